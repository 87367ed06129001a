"""The sampling period of a recording: as the file states, else the grid of its instants, else the unit of its times."""

from __future__ import annotations

import zipfile
from fractions import Fraction

import numpy as np
import pytest

import slewline
from slewline.errors import UsageError, WaveformError
from slewline.record.waveforms.read_waveforms import volts_of
from slewline.record.waveforms.sampling import rate_in, sampling_of
from tests.captures import MS, US, Sampled, Wave, model, saleae_csv, scope_csv, sigrok_vcd, wave

MHZ = 1_000_000


def grid(times, unit):
    return sampling_of(lambda: np.array(times, np.int64), Fraction(unit), None, False)


@pytest.mark.parametrize("mhz", [8, 12, 16, 24, 48])
@pytest.mark.parametrize("comment", [True, False])
def test_the_period_is_found(tmp_path, mhz, comment):
    path = tmp_path / "a.vcd"
    path.write_bytes(sigrok_vcd(Sampled(wave(), mhz * MHZ), comment=comment))
    found = slewline.read_vcd(path)
    assert found.sampling.found == ("comment" if comment else "grid")
    assert abs(found.sampling.period - Fraction(10**6, mhz)) < 1
    assert 10**6 / mhz <= found.sampling_ps <= 10**6 / mhz + found.timescale_ps + 1 and found.timescale_ps < 10**6 / mhz
    assert f"sampling at {mhz} MHz" in repr(found)
    assert found.trace("STEP").tolerance_ps == found.sampling_ps
    assert found.trace("STEP", tolerance="3 us").tolerance_ps == 3 * US


def test_facts_stated_by_a_file():
    stated = {
        "Acquisition with 2/8 channels at 12 MHz": 12 * MHZ,
        "Sample rate: 24 MHz": 24 * MHZ,
        "; Samplerate: 500 kHz": 500_000,
        "META samplerate: 24000000": 24 * MHZ,
        "at 2.5 GHz": 2500 * MHZ,
    }
    assert {text: rate_in(text) for text in stated} == stated
    for text in ("D: CY525, 11000000 Hz", "x.velocity in steps/s", "at 0 Hz", "at noon", ""):
        assert rate_in(text) is None


def test_a_conversion_states_its_unit_and_the_grid_counts(tmp_path):
    """Sigrok-cli reads a VCD file at one sample a unit, and states 10 GHz."""
    path = tmp_path / "a.vcd"
    path.write_bytes(sigrok_vcd(Sampled(wave(), 12 * MHZ)).replace(b"at 12 MHz", b"at 10 GHz"))
    assert str(slewline.read_vcd(path).sampling) == "the sampling at 12 MHz"


def test_chance_is_not_a_grid():
    some = np.random.default_rng(2).integers(1, 10**6, 200).cumsum() * 1000
    assert grid(some, 1000).found == "unit"
    steady = np.arange(500) * 100 * US  # a wave of constant rate: on the grid of its own period
    assert grid(np.sort(np.concatenate([steady, steady + 5 * US])), 100).found == "unit"
    assert grid([], 1000).found == grid([5], 1000).found == "unit"


def test_our_own_files_are_exact(tmp_path):
    """Edges of a chip are on the grid of its clock: that is no sampling."""
    of = wave()
    on_grid = Wave({name: [at // US * US for at in edges] for name, edges in of.edges.items()}, of.first, of.end)
    path = model(on_grid, tmp_path / "a.vcd")
    assert slewline.read_vcd(path).sampling_ps == 1000
    path.write_text(path.read_text().replace("$version slewline $end", "$version another $end"))
    assert slewline.read_vcd(path).sampling_ps == US


# ------------------------------------------------------------------------------------------------------------- tables
def table(tmp_path, text: str | bytes, **options):
    path = tmp_path / "a.csv"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return slewline.read_waveforms(path, **options)


def test_a_table_of_changes(tmp_path):
    found = table(tmp_path, "Time [s],Channel 0,DIR\n-0.000002,0,1\n0.000000,1,1\n0.0000005,0,0\n0.000001,0,0")
    assert found.names == ("Channel 0", "DIR") and (found.start_ps, found.stop_ps) == (0, 3 * US)
    assert found.edges("Channel 0")[0].tolist() == [2 * US, 2_500_000] and found.level_at("DIR", 0) == 1


def test_line_ends_marks_and_padding(tmp_path, subtests):
    plain = "Time [s],A\n0.0,0\n0.000001,1\n0.000002,0\n"
    for name, data in {
        "lf": plain.encode(),
        "crlf": plain.replace("\n", "\r\n").encode(),
        "cr": plain.replace("\n", "\r").encode(),
        "bom": b"\xef\xbb\xbf" + plain.encode(),
        "no end": plain.encode().rstrip(),
        "ctrl-z": plain.encode() + b"\x1a",
        "blank lines": plain.encode() + b"\r\n\n",
        "quotes": plain.replace("Time [s],A", '"Time [s]","A"').encode(),
        "tabs": plain.replace(",", "\t").encode(),
        "semicolons": plain.replace(",", ";").replace(".", ",").encode(),
    }.items():
        with subtests.test(name):
            found = table(tmp_path, data)
            assert found.names == ("A",) and found.edges("A")[0].tolist() == [US, 2 * US]


def test_a_table_over_many_blocks(tmp_path, monkeypatch):
    data = saleae_csv(Sampled(wave(), 24 * MHZ), 3 * MS)
    whole = table(tmp_path, data)
    for size in (997, 4096):
        monkeypatch.setattr("slewline.record.waveforms.read_csv.BLOCK", size)
        parts = table(tmp_path, data)
        for name in whole.names:
            assert [column.tolist() for column in parts.edges(name)] == [c.tolist() for c in whole.edges(name)]


def test_tables_that_cannot_be_read(tmp_path, subtests):
    good = "Time [s],A\n0.0,0\n0.000001,1\n"
    for text, says in {
        good + "0.000002,x\n": "line 4: '0.000002,x': expected a number in each column",
        good + "0.0000": "line 4: '0.0000': expected a number in each column",
        good + "0.0000005,0\n": "line 4: '5e-07, 0': a time before the one above",
        good + "nan,0\n": "line 4: 'nan, 0': a time before the one above, or not a finite number",
        good + "0.000002,1e308\n": "line 4: '2e-06, 1e\\+308': a time before the one above, or not a finite number",
        good + "0.000002,-1e30\n": "line 4: '2e-06, -1e\\+30': a time before the one above, or not a finite number",
        good + "1e9,0\n": "a time is too large; allowed less than 2\\^62 ps",
        "Time,A\n2026-11-28T10:00:00,0\n": "no row of numbers in its first 2 lines; export times as seconds, not",
        "Time,A\n": "no row of numbers in its first 1 lines; expected columns of numbers",
        "A,B\n0,1\n1,1\n": "has no column of times, and states no sample rate; export the times too",
        good + "0," + "1" * (1 << 21): "a line of more than",
        "Time [s]" + ",A" * 2000 + "\n" + "0" + ",1" * 2000: "2001 columns; allowed up to 1024",
        "X,A,Start,Increment\n0,V,0,1e-999999999\n0,1,,\n1,0,,\n": "has no column of times",
        f"; Channels (2/2): A, {'a' * 100_000}\nA,B\n0,1\n": "has no column of times",
        "a,b\nsample rate" + " " * 500_000 + "x\nA,B\n0,1\n": "has no column of times",
        "a,b\nA[" + " " * 500_000 + ",x\n0,1\n": "has no column of times, and",
        "Time(s),A,B\n0,0,1\n1,2e-08,1,1\n": "line 3: '1,2e-08,1,1': 4 cells, and the first row has 3; if numbers",
        "Time(s),A\n0,5,1\n1,0,0\n": "line 2: 1 numbers without a column name; if numbers have decimal commas",
        "0.5,1\n0.4,0\n0.6,1\n0.7,1\n": "has no column of times",  # nothing rises, or whole numbers do, too few
        "0,1.5\n1,0.2\n2,3.3\n3,3.3\n": "has no column of times",
        "0.5,1\n0.6,0\n": "has no column of times",
    }.items():
        with subtests.test(says), pytest.raises((WaveformError, UsageError), match=says):
            table(tmp_path, text)
    assert table(tmp_path, good + "0.0000", torn=True).stop_ps == US
    assert table(tmp_path, "A,B\n0,1\n1,1\n", timescale="3 us").edges("A")[0].tolist() == [3 * US]
    with pytest.raises(UsageError, match="threshold 'high': expected a voltage"):
        table(tmp_path, good, threshold="high")
    with pytest.raises(UsageError, match="threshold '700 mA': mA is a unit of current; expected a voltage"):
        table(tmp_path, good, threshold="700 mA")
    assert [volts_of(given) for given in ("700 mV", "1.4 v", 1.4, " 2V ")] == [0.7, 1.4, 1.4, 2.0]


def test_names_of_columns(tmp_path, subtests):
    rows = "-0.5,0,1\n0.5,1,1\n1.5,0,1\n2.5,0,0\n"
    for head, (names, second) in {
        "Time [s],A,B": (("A", "B"), 1e12), "t / s,CH1 / V,CH2 / V": (("CH1", "CH2"), 1e12),
        "in s,C1 in V,C2 in V": (("C1", "C2"), 1e12), "in ms,C1 in mV,C2 in mV": (("C1", "C2"), 1e9),
        "Timestamp(us),A (V),B [V]": (("A", "B"), 1e6), '"t / ms","IN/OUT","B"': (("IN/OUT", "B"), 1e9),
        "Tempo,A,B": (("A", "B"), 1e12), "Time (hh:mm) (ms),A(B),C": (("A", "C"), 1e9),
    }.items():  # fmt: skip
        with subtests.test(head):
            found = table(tmp_path, f"{head}\n{rows}")
            assert found.names == names and found.edges(names[0])[0].tolist() == [second, 2 * second]
    for head in ("X,A,B", "Sample,A,B"):  # a number of each sample, not a time
        with pytest.raises(UsageError, match="has no column of times"):
            table(tmp_path, f"{head}\n{rows}")


def test_a_table_of_numbers_alone_has_times_that_rise(tmp_path):
    """Some oscilloscopes write no head; where the rate is stated, or `timescale` given, every column is a signal."""
    seen = Sampled(wave(), MHZ)
    found = table(tmp_path, scope_csv(seen, "bare"))
    assert found.names == ("D0", "D1") and str(found.sampling) == "the sampling at 1 MHz"
    assert found.edges("D0")[0].tolist() == [n * US for n in seen.edges["STEP"]]
    rising = "0.5,1\n0.6,0\n0.7,1\n0.8,0\n"
    assert table(tmp_path, rising).names == ("D0",)
    for whole in (table(tmp_path, rising, timescale="1 us"), table(tmp_path, f"; Samplerate: 1 MHz\n{rising}")):
        assert whole.names == ("D0", "D1") and whole.edges("D1")[0].tolist() == [US, 2 * US, 3 * US]


def test_a_header_next_to_the_first_rows_loses_none_of_them(tmp_path):
    seen = Sampled(wave(), MHZ)
    data = scope_csv(seen, "tektronix").decode()
    found = table(tmp_path, data)
    assert found.names == ("STEP", "DIR") and found.stop_ps == (seen.count - 1) * US
    assert table(tmp_path, data.replace("Source", "Origin")).names == ("D0", "D1")
    assert table(tmp_path, data.replace("Sample Interval", "Interval")).sampling.found == found.sampling.found


def test_voltages_have_a_threshold_and_hysteresis(tmp_path):
    volts = [0, 0.1, 1.5, 1.6, 1.5, 1.6, 3.3, 3.2, 1.7, 1.6, 1.7, 0.1, 0, 0, 0, 0, 0, 0, 0, 0]
    text = "Time (us),A,B,C\n" + "".join(f"{n},{v},0.02,{3.3 - n % 2 / 50}\n" for n, v in enumerate(volts))
    found = table(tmp_path, text)
    assert found.edges("A")[0].tolist() == [6 * US, 11 * US]
    assert len(found.edges("B")[0]) == len(found.edges("C")[0]) == 0
    assert (found.level_at("B", 0), found.level_at("C", 0)) == (0, 1)
    assert table(tmp_path, text, threshold="900 mV").edges("A")[0].tolist() == [2 * US, 11 * US]


@pytest.mark.parametrize("volts", [3.3, 5.0, -12.0])
@pytest.mark.parametrize("high", [2, 20, 500, 980])  # samples of 1000
@pytest.mark.parametrize("spike", [0.0, 1.0, 2.4])  # of the swing, beyond the level; a screen has no more
def test_spikes_move_no_threshold(tmp_path, volts, high, spike):
    """A motor whose current is switched is on every oscilloscope: some samples go far beyond their level."""
    chance = np.random.default_rng(high)
    count = 20
    level = np.tile(np.arange(1000) < high, count)
    shown = volts * level + chance.normal(0, 0.03, len(level))
    for n in (3, 11):  # after a step has begun, and in a pause
        shown[1000 * n + 1] += spike * volts
        shown[1000 * n + 990] -= spike * volts
    rows = "".join(f"{n},{v:.4f}\n" for n, v in enumerate(shown))
    found = table(tmp_path, f"Time (us),A\n{rows}")
    times, levels = found.edges("A")
    rises = 1 if volts > 0 else 0
    assert len(times) == 2 * count - 1  # the recording begins within a pulse
    assert times[levels == rises].tolist() == [1000 * n * US for n in range(1, count)]
    assert times[levels != rises].tolist() == [(1000 * n + high) * US for n in range(count)]


def test_an_invalid_table_is_read_as_vcd(tmp_path):
    for data, says in ((b"", "is empty"), (b"\x1f\x8b,,", "gunzip"), (b"hello", "a VCD file does not begin like this")):
        with pytest.raises(WaveformError, match=says):
            table(tmp_path, data)
    for data in (b"AG10\0\0", b"WAVEDESC" + bytes(40), bytes([0, 1, 1, 0, 3])):
        with pytest.raises(WaveformError, match="a binary file, not a readable recording; export VCD or"):
            table(tmp_path, data)
    with pytest.raises(WaveformError, match="a binary export of Logic 2; export CSV there"):
        table(tmp_path, b"<SALEAE>" + bytes(40))
    with zipfile.ZipFile(tmp_path / "a.xlsx", "w") as archive:
        archive.writestr("xl/workbook.xml", "<workbook/>")
    says = "a ZIP archive, but not a session of sigrok; if it is a spreadsheet, save it as CSV"
    with pytest.raises(WaveformError, match=says):
        slewline.read_waveforms(tmp_path / "a.xlsx")
    for ending, says in ((".dsl", "export VCD or CSV in DSView"), (".sal", "export CSV in Logic 2")):
        (tmp_path / f"a{ending}").write_bytes(b"PK\x03\x04")
        with pytest.raises(WaveformError, match=says):
            slewline.read_waveforms(tmp_path / f"a{ending}")
    with pytest.raises(UsageError, match="is a directory"):
        slewline.read_waveforms(tmp_path)


def test_a_real_number_is_not_a_step(tmp_path):
    path = tmp_path / "a.vcd"
    path.write_text("$timescale 1 us $end $var real 64 ! A0 $end $enddefinitions $end\n#0 r1.5 !\n#1 r2 !\n")
    with pytest.raises(UsageError, match="A0 is a real variable, which has no levels; name a wire"):
        slewline.read_vcd(path).steps("A0")
    path.write_text(path.read_text().replace("r1.5", "s1.5").replace("64 !", "1 !"))  # as MyHDL writes it
    assert slewline.read_vcd(path).edges("A0")[1].tolist() == [2.0]


def test_a_trace_of_an_inverted_signal(tmp_path):
    path = tmp_path / "a.vcd"
    path.write_bytes(sigrok_vcd(Sampled(wave().inverted("STEP"), MHZ)))
    found = slewline.read_vcd(path)
    trace = found.trace("STEP", invert=True)
    assert trace.level == 0 and (trace.levels == 1 - found.edges("STEP")[1]).all()
