"""Waveform files of benches: what the axes do beside the pins, wires of buses, layouts, streams."""

from __future__ import annotations

import numpy as np
import pytest

import slewline
from slewline.errors import NotRecorded, UnknownName
from tests.oracles import waveform

US = 1_000_000


@pytest.fixture
def cy525():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x", crystal="11 MHz")
    bench.record()
    bench.host(x).send("A 0\rF 10\rR 80\rS 240\rZ 1\rN 300\r+\rG\r-\rN 200\rG\rQQ\r")
    bench.run_until_idle()
    bench.run("5 ms")
    return bench


def read(path) -> dict[str, tuple[list[int], list[object]]]:
    """Units and values of every variable, as pyvcd reads them."""
    _, changes = waveform.read(path)
    return {name: ([at for at, _ in found], [value for _, value in found]) for name, found in changes.items()}


def at(times, values, instants):
    """The values at some instants, where every value holds until the next."""
    return np.array(values)[np.searchsorted(times, instants, side="right") - 1]


def test_position_and_velocity_are_those_of_the_axis_at_a_thousand_instants(cy525, tmp_path):
    x = cy525["x"]
    cy525.save_vcd(tmp_path / "a.vcd", ["x.slew"], timescale="1 ps", values=True)
    found = read(tmp_path / "a.vcd")
    assert list(found) == ["x.slew", "x.finding", "x.command", "x.motion", "x.velocity", "x.position"]
    instants = np.random.default_rng(1).integers(0, cy525.now_ps, 1000)
    assert (at(*found["x.position"], instants) == x.position_at(instants)).all()
    velocity = x.quantities()[0]
    assert velocity.name == "velocity"
    assert (at(*found["x.velocity"], instants) == velocity.at(instants)).all()
    assert set(found["x.position"][0]) >= set(x.steps().times_ps.tolist()), "every step"


def test_motions_and_findings_are_texts_at_their_instants(cy525, tmp_path):
    cy525.save_vcd(tmp_path / "a.vcd", ["x.slew"], timescale="1 us", values=True)
    found = read(tmp_path / "a.vcd")
    motions = cy525["x"].motions()
    assert len(motions) == 2
    states = [(at // US, text) for m in motions for at, text in ((m.time_ps, m.text), (m.end.time_ps, ""))]
    assert list(zip(*found["x.motion"], strict=True)) == [(0, ""), *states]
    findings = [(f.time_ps // US, f"{f.code}: {f.text}".replace(" ", "\\x20")) for f in cy525.findings]
    assert len(findings) == 3
    assert list(zip(*found["x.finding"], strict=True)) == [(0, ""), *findings]


def test_the_current_command_is_a_text_from_start_to_end(cy525, tmp_path):
    cy525.save_vcd(tmp_path / "a.vcd", ["x.ready"], timescale="1 ps", values=True)
    found = read(tmp_path / "a.vcd")
    texts = [text.replace("\\x20", " ") for text in found["x.command"][1] if text]
    assert texts == ["A 0", "F 10", "R 80", "S 240", "Z 1", "N 300", "+", "G", "-", "N 200", "G", "Q", "Q"]
    went = found["x.command"][0][found["x.command"][1].index("G")]
    assert went <= cy525["x"].motions()[0].time_ps
    high = np.array(found["x.ready"][0])[np.array(found["x.ready"][1]) == "1"]
    ended = [at for at, text in zip(*found["x.command"], strict=True) if not text][1:]
    assert set(ended) <= set(high.tolist()), "READY returns"


@pytest.mark.parametrize("timescale", ["1 ns", "1 us", "1 ms"])
def test_of_the_commands_of_one_unit_the_last_state_counts(cy525, timescale, tmp_path):
    cy525.save_vcd(tmp_path / "all.vcd", ["x.slew"], timescale="1 ps", values=True)
    cy525.save_vcd(tmp_path / "some.vcd", ["x.slew"], timescale=timescale, values=True)
    unit = {"1 ns": 10**3, "1 us": 10**6, "1 ms": 10**9}[timescale]
    (times, texts), some = read(tmp_path / "all.vcd")["x.command"], read(tmp_path / "some.vcd")["x.command"]
    last = dict(zip((at // unit for at in times), texts, strict=True))
    changes = [entry for n, entry in enumerate(last.items()) if not n or list(last.values())[n - 1] != entry[1]]
    assert list(zip(*some, strict=True)) == changes


def test_a_stream_has_the_same_commands_as_a_file(tmp_path):
    bench = slewline.Bench()
    x = bench.add("gs-c200s", name="x", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0})
    host = bench.host(x)
    host.uart.follow_straps()
    bench.record("x.mov")
    with bench.stream_vcd(tmp_path / "a.vcd", timescale="1 ps", values=True):
        for line in ("Po", "S10", "T100", "R5", "+300", "L3", "E"):
            host.ask(line)
        bench.run("500 ms")
        host.ask("V1")
        bench.run_until_idle()
    bench.save_vcd(tmp_path / "b.vcd", timescale="1 ps", values=True)
    assert (tmp_path / "a.vcd").read_bytes() == (tmp_path / "b.vcd").read_bytes()
    _, texts = read(tmp_path / "a.vcd")["x.command"]
    asked = texts.index("V1")
    assert texts[asked - 1] == texts[asked + 1] == "+300", "a question in a motion, and then the motion again"
    assert texts.count("L3") == 1 + 3 and texts[-2:] == ["L3", ""], "entered once, executed three times"


def test_of_one_instant_the_last_command_counts(tmp_path):
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.record("x.run")
    bench.host(x).send("E\rB\rC\r0\rQX\r")
    bench.run_until_idle()
    bench.save_vcd(tmp_path / "a.vcd", timescale="1 ps", values=True)
    _, texts = read(tmp_path / "a.vcd")["x.command"]
    assert texts[-5:] == ["X", "B", "C", "0", ""], "the program begins where X ends"


def test_commands_are_kept_as_long_as_the_pins(tmp_path):
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.record("x.run", keep="50 ms")
    bench.host(x).send("E\rB\rD 1\rJ 0\rQX\r")
    bench.run("5 s")
    assert len(bench._signals.commands["x"].log) < 3000
    bench.save_vcd(tmp_path / "a.vcd", timescale="1 us", values=True)
    _, texts = read(tmp_path / "a.vcd")["x.command"]
    assert 20 < len(texts) < 200 and set(texts) == {"B", "D\\x201", "J\\x200"}


def test_a_file_names_its_parts_and_units(cy525, tmp_path):
    cy525.save_vcd(tmp_path / "a.vcd", ["x.slew"])
    assert "$comment x: CY525, 11000000 Hz $end\n$scope" in (tmp_path / "a.vcd").read_text()
    cy525.save_vcd(tmp_path / "a.vcd", ["x.slew"], values=True)
    assert "$comment x.velocity in steps/s $end\n" in (tmp_path / "a.vcd").read_text()


def test_a_name_in_a_file_has_no_blanks(tmp_path):
    bench = slewline.Bench()
    bench.part("stepper", "m", load="friction 5 mNm", step="100 us")
    bench.record("m.pulse")
    bench.run("1 ms")
    bench.save_vcd(tmp_path / "a.vcd", values=True)
    lines = (tmp_path / "a.vcd").read_text().splitlines()
    declared = [line.split() for line in lines if line.startswith("$var")]
    assert {len(words) for words in declared} == {6}
    assert [words[4] for words in declared if words[1] == "real"][-2:] == ["current_1", "current_2"]
    assert "$comment m.current_1 in A $end" in lines
    assert "m.current_1" in slewline.read_vcd(tmp_path / "a.vcd")


def test_axes_of_a_chip_have_scopes_of_their_own(tmp_path):
    bench = slewline.Bench()
    bench.add("mc1251a", name="m")
    bench.record("m.pulse1")
    bench.run("1 ms")
    bench.save_vcd(tmp_path / "a.vcd", values=True, layout=True)
    names = list(read(tmp_path / "a.vcd"))
    assert [name for name in names if name.endswith("position")] == ["m.axis1.position", "m.axis2.position"]
    assert names[:4] == ["m.pulse1", "m.finding", "m.command", "m.axis1.motion"]
    layout = (tmp_path / "a.gtkw").read_text()
    assert all(name in layout for name in names)


def test_only_chips_whose_pins_are_in_the_file_have_values(tmp_path):
    bench = slewline.Bench()
    for name in "xy":
        bench.add("cy525", name=name)
    bench.record()
    bench.run("1 ms")
    bench.save_vcd(tmp_path / "a.vcd", pins=["y.slew"], values=True)
    assert list(read(tmp_path / "a.vcd")) == [
        "y.slew",
        "y.finding",
        "y.command",
        "y.motion",
        "y.velocity",
        "y.position",
    ]


# --------------------------------------------------------------------------------------------------------- buses
def test_a_bus_is_its_wires_and_they_are_named_as_the_pins(cy525, tmp_path):
    cy525.save_vcd(tmp_path / "a.vcd", ["x.db"], timescale="1 ps")
    found = read(tmp_path / "a.vcd")
    assert list(found) == [f"x.db{bit}" for bit in range(8)]
    times, levels = cy525.edges("x.db")
    assert len(times) > 40
    for bit in range(8):
        assert cy525["x"].pin(f"db{bit}").bit == bit
        assert at(*found[f"x.db{bit}"], times).tolist() == [
            "z" if v < 0 else str(v >> bit & 1) for v in levels.tolist()
        ]
    cy525.save_vcd(tmp_path / "b.vcd", ["x.db"], timescale="1 ps", buses="whole")
    assert list(read(tmp_path / "b.vcd")) == ["x.db"]


def test_a_wire_of_a_recorded_bus_can_be_selected(cy525, tmp_path):
    cy525.save_vcd(tmp_path / "a.vcd", ["x.db3", "x.pulse"])
    assert list(read(tmp_path / "a.vcd")) == ["x.db3", "x.pulse"]
    times, levels = cy525.edges("x.db3")
    assert set(levels.tolist()) == {-1, 0, 1}
    whole = dict(zip(*(column.tolist() for column in cy525.edges("x.db")), strict=True))
    assert [(whole[ps] >> 3 & 1) if whole[ps] >= 0 else -1 for ps in times.tolist()] == levels.tolist()


def test_a_wire_can_be_recorded_alone(tmp_path):
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.record("x.db0")
    with pytest.raises(NotRecorded, match=r"x\.db is not recorded"):
        bench.edges("x.db")
    bench.host(x).send("A 1\r")
    bench.run_until_idle()
    assert set(bench.edges("x.db0")[1].tolist()) == {-1, 0, 1}
    with pytest.raises(UnknownName, match="no pin 'db9'"):
        bench.save_vcd(tmp_path / "a.vcd", ["x.db9"])


# --------------------------------------------------------------------------------------------- layouts and streams
def test_a_layout_shows_the_motion_and_marks_what_happened(cy525, tmp_path):
    cy525.save_vcd(tmp_path / "a.vcd", ["x.pulse", "x.db"], timescale="1 us", values=True, layout=True)
    lines = (tmp_path / "a.gtkw").read_text().splitlines()
    steps = cy525["x"].steps().times_ps // US
    (start,) = (int(line.split()[1]) for line in lines if line.startswith("[timestart]"))
    assert steps[0] - 5_000 < start < steps[0]
    first, second = cy525["x"].motions()
    marks = [line.removeprefix("[markername] ") for line in lines if line.startswith("[markername]")]
    assert marks == [f"A{first.text}", f"B{second.text}", "Cquit-outside-entry"], "the others are too near"
    (zoom,) = (line.split() for line in lines if line.startswith("*"))
    assert zoom[2:6] == [
        str(first.time_ps // US),
        str(second.time_ps // US),
        str(cy525.findings[0].time_ps // US),
        "-1",
    ]
    shown = [line.split()[1] for line in (tmp_path / "a.sucl").read_text().splitlines() if "variable_add" in line]
    assert sorted(shown) == sorted(read(tmp_path / "a.vcd"))


def test_a_layout_of_any_timescale_begins_with_the_motion(cy525, tmp_path):
    def start(timescale: str) -> int:
        cy525.save_vcd(tmp_path / "a.vcd", ["x.pulse"], timescale=timescale, layout=True)
        (line,) = (line for line in (tmp_path / "a.gtkw").read_text().splitlines() if "[timestart]" in line)
        return int(line.split()[1])

    first = int(cy525["x"].steps().times_ps[0])
    for timescale, ps in (("1 ns", 10**3), ("10 ns", 10**3), ("100 ns", 10**3), ("10 us", 10**6), ("100 ps", 1)):
        assert first - 5_000 * US < start(timescale) * ps < first, timescale


def test_the_same_run_gives_the_same_bytes(cy525, tmp_path):
    folders = [tmp_path / "a", tmp_path / "b"]
    for folder in folders:
        folder.mkdir()
        cy525.save_vcd(folder / "w.vcd", values=True, layout=True)
    one, two = ([path.read_bytes() for path in sorted(folder.iterdir())] for folder in folders)
    assert len(one) == 3
    assert one == two


def test_a_stream_is_the_file_that_is_saved(tmp_path):
    files = []
    for streamed in (True, False):
        bench = slewline.Bench()
        x = bench.add("cy525", name="x")
        bench.record(keep="150 ms" if streamed else None)
        options = {"timescale": "10 us", "buses": "both", "values": True, "layout": True}
        bench.host(x).send("A 0\rF 10\rR 80\rS 240\rN 300\rG\rQQ\r")
        path = tmp_path / f"{streamed}" / "w.vcd"
        path.parent.mkdir()
        if streamed:
            with bench.stream_vcd(path, **options) as stream:
                bench.run("0.4 s")
            lost = stream.lost
        else:
            bench.run("0.4 s")
            assert bench.save_vcd(path, **options) == lost > 500
        files.append([each.read_text() for each in sorted(path.parent.iterdir())])
    assert files[0] == files[1]
    assert len(files[0]) == 3


def test_edges_hidden_by_the_unit_are_reported(cy525, tmp_path):
    assert cy525.save_vcd(tmp_path / "a.vcd", ["x.pulse"], timescale="1 us") == 0
    times, levels = cy525.edges("x.pulse")
    units = times // (10 * US)
    within = int((units[1:] == units[:-1]).sum())
    assert (len(times), levels.tolist()) == (1000, [0, 1] * 500)
    assert 500 > within > 300, "PULSE is high for 2.5 us"
    assert cy525.save_vcd(tmp_path / "a.vcd", ["x.pulse"], timescale="10 us") == 2 * within


def test_the_header_has_the_crystals_of_parts_and_units_in_ascii(tmp_path):
    bench = slewline.Bench()
    bench.add("gs-c200s", name="g")
    bench.add("mc1151a", name="m")
    bench.record()
    bench.run("1 us")
    bench.save_vcd(tmp_path / "a.vcd", values=True)
    said = [line for line in (tmp_path / "a.vcd").read_text().splitlines() if line.startswith("$comment")]
    assert said[0] == "$comment g: GS-C200S $end"
    assert "$comment m: MC1151A, 25000000 Hz $end" in said
    assert "$comment m.acceleration in steps/s^2 $end" in said


@pytest.fixture
def s_curve():
    """An S-curve in progress, and how to send another one."""
    bench = slewline.Bench()
    x = bench.add("mc1151a", name="x")
    host = bench.host(x)
    bench.record("x.pulse1")
    host.send("SET_PRFL_S_CRV\nSET_VEL 0x8000\nSET_MAX_ACC 0x400\nSET_JERK 0x20000\nSET_POS 5\nUPDATE")
    bench.run("30 ms")
    return bench, x, host


def test_the_acceleration_of_an_s_curve_is_in_the_file_cycle_by_cycle(s_curve, tmp_path):
    bench, x, _ = s_curve
    bench.save_vcd(tmp_path / "a.vcd", timescale="1 ps", values=True)
    read = slewline.read_vcd(tmp_path / "a.vcd")
    (acceleration,) = (quantity for quantity in x.axis(1).quantities() if quantity.name == "acceleration")
    times = x.axis(1).cycles().times_ps
    assert len(times) > 80
    assert [read.level_at("acceleration", int(time)) for time in times] == acceleration.at(times).tolist()
    assert len(read.edges("acceleration")[0]) == len(times[times > 4_916_200_000]) + 1, "one phase begins in mid-cycle"


def test_a_stream_of_sloping_values_is_the_saved_file(s_curve, tmp_path):
    """However its pieces are cut: a window that ends in mid-phase ends with the value there."""
    bench, _, host = s_curve
    start = bench.now_ps
    with bench.stream_vcd(tmp_path / "a.vcd", timescale="1 ps", values=True):
        host.send("SET_POS 9\nUPDATE")
        for duration in (1, 10**6, 123_456_789, 10**9, 3 * 10**9, 10**10, 10**10, 2 * 10**10):
            bench.run(f"{duration} ps")
    bench.save_vcd(tmp_path / "b.vcd", timescale="1 ps", values=True, start=start)
    assert (tmp_path / "a.vcd").read_bytes() == (tmp_path / "b.vcd").read_bytes()


def test_a_window_that_ends_in_a_phase_ends_with_its_value(s_curve):
    bench, x, _ = s_curve
    (quantity,) = (quantity for quantity in x.axis(1).quantities() if quantity.name == "acceleration")
    for stop in range(6 * 10**9, bench.now_ps, 10**9):
        times, values = quantity.changes(5 * 10**9, stop)
        assert values[-1] == pytest.approx(quantity.at(np.array([stop]))[0]), stop
        assert times[-1] <= stop


def test_a_stream_that_cannot_write_its_last_changes_leaves_no_file(tmp_path, monkeypatch):
    bench = slewline.Bench()
    bench.add("cy525", name="x")
    bench.record()
    with pytest.raises(OSError, match="no space"), bench.stream_vcd(tmp_path / "run.vcd") as stream:
        bench.run("1 ms")
        monkeypatch.setattr(stream, "write_until", lambda _ps: (_ for _ in ()).throw(OSError("no space")))
    assert [*tmp_path.iterdir()] == []
    bench.run("1 ms")  # and nobody writes to it any more
