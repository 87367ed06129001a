"""What stands beside the pins in a VCD file: reals and strings, judged by pyvcd's reader; and what a unit hides."""

from __future__ import annotations

import numpy as np
import pytest

from slewline.errors import UsageError
from slewline.record.waveforms.vcd import MISREAD, VcdStream, identifiers, real, string, write_vcd
from slewline.record.waveforms.vcd_sources import CurveSource, TextSource, Variable
from tests.oracles import waveform
from tests.rows import rows

SEVENTH = 5978.260869565217  # needs all its digits


class Staircase:
    """A quantity that is 0 at first, and changes at given instants."""

    def __init__(self, *points: tuple[int, float]) -> None:
        self.times = np.array([0, *(ps for ps, _ in points)])
        self.heights = np.array([0.0, *(value for _, value in points)])

    def at(self, times_ps):
        return self.heights[np.searchsorted(self.times, times_ps, side="right") - 1]

    def staircase(self, start, stop):
        inside = (self.times > start) & (self.times <= stop)
        now = self.at(np.array([start]))
        return np.append(start, self.times[inside]), np.append(now, self.heights[inside])


def differences(*texts: tuple[int, str]) -> TextSource:
    return TextSource("x.said", lambda start, stop: [each for each in texts if start <= each[0] <= stop])


def moving(rig):
    rig.recorder.record(rig.net("x.slew", pull=1))
    rig.on(5_000, x_slew=0)
    rig.on(20_500, x_slew=1)
    rig.kernel.run(30_000)
    return rig


def test_reals_and_strings_to_the_byte(rig, tmp_path):
    moving(rig)
    curve = CurveSource("x.velocity", Staircase((5_000, SEVENTH), (9_000, np.nan), (9_400, -3.0), (12_000, np.nan)))
    texts = differences((2_000, "P 300"), (5_100, "a\\b"), (5_900, "zwölf µs"))
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 1_000, 21_000, values=[curve, texts], comments=["x: CY525"])
    assert (
        (tmp_path / "a.vcd").read_text()
        == """\
$timescale 1 ns $end
$version slewline $end
$comment x: CY525 $end
$scope module x $end
$var wire 1 ! slew $end
$var real 64 " velocity $end
$var string 1 % said $end
$upscope $end
$enddefinitions $end
#1
$dumpvars
1!
r0 "
s %
$end
#2
sP\\x20300 %
#5
0!
r5978.260869565217 "
sa\\\\b;\\x20zw?lf\\x20us %
#9
r-3 "
#12
rnan "
#20
1!
#21
"""
    )


def test_pyvcd_reads_the_same(rig, tmp_path):
    moving(rig)
    curve = CurveSource("x.position", Staircase((5_000, SEVENTH), (9_000, 1.0), (9_400, -3.0), (9_900, 1e-9)))
    write_vcd(
        tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 30_000, values=[curve, differences((7_000, "go"), (7_000, "on"))]
    )
    assert waveform.read(tmp_path / "a.vcd")[1] == {
        "x.slew": [(0, "1"), (5, "0"), (20, "1")],
        "x.position": [(0, 0.0), (5, SEVENTH), (9, 1e-9)],
        "x.said": [(0, ""), (7, "go;\\x20on")],
    }


@pytest.mark.parametrize("timescale", ["1 ps", "1 us"])
@pytest.mark.parametrize("seed", range(2))
def test_parts_and_streams_give_the_same_bytes(lively, tmp_path, monkeypatch, seed, timescale):
    def sources():
        random = np.random.default_rng(seed)
        times = np.unique(random.integers(1, 80_000_000, 150)).tolist()
        curve = Staircase(*zip(times, random.integers(-3, 3, len(times)) / 3, strict=True))
        return [CurveSource("x.v", curve), differences(*((ps, f"at {ps}") for ps in times[::7]))]

    rig, other = lively(seed, events=60), lively(seed, events=60, keep=3_000_000)
    rig.kernel.run(80_000_000)
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 80_000_000, timescale, values=sources())
    whole = (tmp_path / "a.vcd").read_bytes()
    monkeypatch.setattr("slewline.record.recording.recorder.FIRST_CHUNK_PS", 100_000)
    monkeypatch.setattr("slewline.record.recording.recorder.CHUNK_EDGES", 12)
    saved = write_vcd(tmp_path / "b.vcd", rig.nets, rig.recorder, 0, 80_000_000, timescale, values=sources())
    assert (tmp_path / "b.vcd").read_bytes() == whole
    with VcdStream(tmp_path / "c.vcd", other.nets, other.recorder, timescale, values=sources()) as stream:
        for now in range(0, 80_000_001, 1_234_567):
            other.kernel.run(now)
            stream.write_until(now)
        other.kernel.run(80_000_000)
        stream.write_until(80_000_000)
    assert (tmp_path / "c.vcd").read_bytes() == whole
    assert stream.lost == saved.lost


def test_reals_may_be_in_a_chunk_of_an_hour_of_picoseconds(rig, tmp_path, monkeypatch):
    """Time and code of a change share 63 bits: times count from the first change of the chunk."""
    rig.recorder.record(rig.net("x.slew", pull=1))
    hour = 3600 * 10**12
    monkeypatch.setattr("slewline.record.recording.recorder.LONGEST_CHUNK_PS", hour)
    rig.on(hour, x_slew=0)
    rig.kernel.run(hour + 100_000)
    points = [(hour + n, n / 7) for n in range(1, 9_997)]
    write_vcd(
        tmp_path / "a.vcd",
        rig.nets,
        rig.recorder,
        0,
        hour + 100_000,
        "1 ps",
        values=[CurveSource("x.v", Staircase(*points))],
    )
    lines = (tmp_path / "a.vcd").read_text().splitlines()
    assert lines[-3:] == [f"#{hour + 9_996}", 'r1428 "', f"#{hour + 100_000}"]
    assert sum(line.startswith("r") for line in lines) == 9_997


def test_strings_have_names_that_are_not_mistaken_for_a_change():
    """A reader that skips a string goes on at its identifier: "1" would be a level, "#" the next instant."""
    kinds = ["wire", "real", "string"] * 2000
    names = identifiers([Variable(f"v{number}", kind) for number, kind in enumerate(kinds)])  # type: ignore[arg-type]
    assert len(set(names)) == len(names)
    assert not any(name[0] in MISREAD for name, kind in zip(names, kinds, strict=True) if kind == "string")
    assert {name for name, kind in zip(names, kinds, strict=True) if kind == "wire"} & MISREAD, "these may have them"


@rows("value", [0.0, -0.0, 1 / 3, 1e22, -65535.0, 2.0**-1074, np.float64(5978.25)])
def test_a_real_is_read_back_exactly(value):
    assert float(real(_bits(value))[1:]) == value


def _bits(value: float) -> int:
    return int(np.float64(value).view(np.int64))


def test_a_text_is_one_word_of_ascii():
    assert string("P 300\r") == "sP\\x20300\\r"
    assert string("a\tb\nc\\d\x05\N{THIN SPACE}é") == "sa\\tb\\nc\\\\d???"


# ---------------------------------------------------------------------------------------------- what a unit hides
def test_changes_that_others_follow_in_the_same_unit_are_counted(rig, tmp_path):
    rig.recorder.record(rig.net("x.slew", pull=1))
    for ps, level in ((2_300, 0), (2_600, 1), (2_900, 0), (3_100, 1), (7_000, 0), (7_500, 1), (7_999, 0), (8_000, 1)):
        rig.on(ps, x_slew=level)
    rig.kernel.run(9_000)
    lost = [
        write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, start, 9_000).lost for start in (0, 2_400, 2_900, 7_999)
    ]
    assert lost == [4, 4, 2, 0], "two in 2 ns, unless the file begins between or behind them; two in 7 ns"
    assert write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 9_000, "100 ps").lost == 0
    assert write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 9_000, "1 us").lost == 8


def test_wires_of_a_bus_are_counted_each_by_itself(rig, tmp_path):
    rig.recorder.record(rig.bus("x.db"))
    rig.on(5_000, x_db=(255, 1))
    rig.on(5_100, x_db=(255, 3))
    rig.on(5_200, x_db=(255, 2))
    rig.kernel.run(9_000)
    assert write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 9_000).lost == 2, (
        "wire 0: high, then low; wire 1: low, then high"
    )
    assert write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 9_000, buses="whole").lost == 2
    assert write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 9_000, buses="both").lost == 4


def test_two_variables_of_one_name_are_refused(rig, tmp_path):
    moving(rig)
    with pytest.raises(UsageError, match="'slew' is already the name of a variable in the file; rename one of them"):
        write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 9, values=[CurveSource("x.slew", Staircase((1, 1.0)))])
    assert list(tmp_path.iterdir()) == []
