"""The drilling machine of the data sheet, example 2, and the rules for choosing S, T and R."""

from __future__ import annotations

from pathlib import Path

import pytest
from modules import C200, MS, US, Modules, S, both

import slewline
from slewline.parts.machines.drilling import CutPiece
from tests.parts.gsc_selection import start_stop, top_speed, turns_a_minute

# fmt: off
BAR = ["S10", "T100", "R40", "W1", "+250", "L0", "A2", "D1", "C2", "W2", "+120", "L4", "A2", "C2", "W2",
       "+250", "A1", "D5", "C1"]
DRILL = ["S15", "T200", "R25", "W1", "W2", "A2", "+150", "D1", "G0", "C2", "A1", "D1", "C1"]
# fmt: on
LOOP = [*DRILL[:3], "L0", *DRILL[3:], "L5"]  # the drill unit made to serve a whole bar
EXAMPLES = Path(__file__).parents[2] / "examples/drill"
HOLES = (250, 370, 490, 610, 730)
BARS = (CutPiece(HOLES, 980),)


class Answerer:
    """Stands for the drill unit: 0.3 s behind the request it tells for 0.1 s that the hole is done."""

    def __init__(self, m: Modules) -> None:
        self.m, self.requests = m, []
        m.bench.pin("x.ui2").drive(0)
        m.bench.pin("x.uo2").net.watch(self.asked)

    def asked(self, net) -> None:
        if net.level == 1:
            now = self.m.bench.now_ps
            self.requests.append(self.m.x.position)
            self.m.bench.pin("x.ui2").drive(1, at=now + 300 * MS)
            self.m.bench.pin("x.ui2").drive(0, at=now + 400 * MS)


def bar_unit(part: str, **options: object) -> Modules:
    """The bar unit, named x, with a tester."""
    m = Modules(part, **options)
    m.bench.record("x.uo1", "x.uo2", "x.dir", "x.rdy")
    m.connect()
    m.tester = Answerer(m)
    return m


def machine(part: str, shuffle: int | None = None) -> Modules:
    """Bar unit x, drill unit y, bar and drill."""
    m = Modules(part, "x", "y", shuffle=shuffle)
    m.bar = m.bench.part("bar", name="bar", to="x")
    m.drill = m.bench.part("drill", name="drill", to="y")
    m.wire("drill.bit bar.bit", "x.uo2 y.ui2", "y.uo1 x.ui2")
    m.bench.record("x.uo1", "x.uo2", "y.uo1", "y.uo2")
    m.connect()
    return m


# ----------------------------------------------------------------------------------------------------------- bar unit
@both
@pytest.mark.fact("GSC-SYS-DRILL-2", "GSC-SYS-DRILL-3", "GSC-CON-PULSE-WIDTH")
def test_the_bar_unit_requests_five_holes_and_cuts(part):
    m = bar_unit(part)
    m.run(*BAR)
    assert tuple(m.tester.requests) == HOLES
    steps = m.x.steps()
    assert (len(steps), set(steps.directions.tolist()), m.x.position) == (980, {1}, 980)
    assert m.highs("x.uo2") == [102 * MS] * 4 + [MS]  # D1 and C2; C2 alone
    assert m.highs("x.uo1") == [502 * MS]
    (cut,) = m.rises("x.uo1")
    assert cut == m.pulses()[-1] + 10 * MS + MS  # the last interval, and the time of A1


@pytest.mark.fact("GSC-CON-PULSE-WIDTH")
def test_the_fifth_request_is_as_long_as_an_instruction_takes():
    m = bar_unit(C200, instruction_time="7 ms")
    m.run(*BAR)
    assert m.highs("x.uo2") == [114 * MS] * 4 + [7 * MS]
    with pytest.raises(slewline.UsageError, match="instruction_time 0; allowed more than 0"):
        Modules(C200, instruction_time=0)


@both
@pytest.mark.fact("GSC-SYS-DRILL-6")
def test_until_repeats_bar_after_bar(part):
    m = bar_unit(part)
    m.start("U3", *BAR)
    m.bench.run_until(m.x.reaches(2 * 980 + 100), "120 s")
    m.bench.pin("x.ui3").drive(0)
    m.bench.run_until_idle()
    assert m.x.position == 3 * 980
    assert m.tester.requests == [bar * 980 + hole for bar in range(3) for hole in HOLES]
    assert m.ask("F") == "R"
    assert m.bench.pin("x.rdy").level == 1
    assert len(m.rises("x.uo1")) == 3


# --------------------------------------------------------------------------------------------------------- drill unit
@both
@pytest.mark.fact("GSC-SYS-DRILL-4", "GSC-CON-DRILL-ONCE")
def test_one_run_of_the_drill_unit_drills_one_hole(part):
    m = Modules(part)
    m.bench.record("x.uo1", "x.uo2")
    m.connect()
    m.run(*DRILL)
    steps = m.x.steps()
    assert steps.directions.tolist() == [1] * 150 + [-1] * 150
    assert steps.positions[149] == 150
    down, up = steps.times_ps[:150].tolist(), steps.times_ps[150:].tolist()
    last = (S + 75) // 150  # the last interval: S15
    assert up[0] - down[-1] == last + 102 * MS + 10 * US  # D1 and its time, that of G0, DIR
    assert m.edges("x.uo2", 1) == [(down[0] - 10 * US - MS, 1), (up[-1] + last + MS, 0)]
    assert m.highs("x.uo1") == [102 * MS]
    assert m.rises("x.uo1", 1) == [up[-1] + last + 2 * MS]
    assert (m.x.position, m.bench.pin("x.rdy").level) == (0, 1)


# ------------------------------------------------------------------------------------------------------ whole machine
@both
@pytest.mark.fact("GSC-SYS-DRILL-1", "GSC-SYS-DRILL-5", "GSC-CON-DRILL-ONCE")
def test_as_printed_the_drill_unit_serves_one_hole(part):
    m = machine(part)
    m.start(*DRILL, name="y")
    m.start(*BAR, name="x")
    with pytest.raises(slewline.Timeout, match=r"waiting for ui2=1 \(W2\)"):
        m.bench.run_until_idle("60 s")
    assert (m.x.position, m.bench.pin("x.rdy").level, m.bench.pin("y.rdy").level) == (370, 0, 1)
    assert m.bar.holes == [250]
    assert m.ask("E", "y") == "Y"  # too late: the request was over long ago
    with pytest.raises(slewline.Timeout, match=r"waiting for ui2=1 \(W2\)"):
        m.bench.run_until_idle("60 s")
    assert m.bar.holes == [250]


@both
@pytest.mark.fact("GSC-SYS-DRILL-1", "GSC-SYS-DRILL-5", "GSC-CON-DRILL-ONCE")
def test_a_host_that_starts_the_drill_unit_five_times_in_time_gets_the_bar(part):
    m = machine(part)
    m.start(*DRILL, name="y")
    m.start(*BAR, name="x")
    for _ in range(4):
        while m.ask("F", "y") == "B":
            pass
        assert m.ask("E", "y") == "Y"
    m.bench.run_until_idle()
    assert tuple(m.bar.pieces) == BARS
    assert len(m.pulses("y")) == 5 * 300


@both
@pytest.mark.fact("GSC-SYS-DRILL-1", "GSC-SYS-DRILL-5")
@pytest.mark.parametrize("shuffle", [None, 1])
def test_with_a_loop_around_it_one_run_drills_the_bar(part, shuffle):
    m = machine(part, shuffle=shuffle)
    m.enter(*LOOP, name="y")
    assert len(m["y"].program) == 40
    assert m.ask("E", "y") == "Y"
    m.run(*BAR, name="x")
    assert tuple(m.bar.pieces) == BARS
    assert m["y"].steps().directions.tolist() == ([1] * 150 + [-1] * 150) * 5
    assert (m["x"].position, m["y"].position, m.drill.position, m.bar.position) == (980, 0, 0, 0)
    assert m.bench.findings == []
    assert [m.highs(pin) for pin in ("x.uo2", "y.uo1")] == [[102 * MS] * 4 + [MS], [102 * MS] * 5]


@both
@pytest.mark.fact("GSC-SYS-DRILL-6")
def test_bar_after_bar_is_drilled_and_cut(part):
    m = machine(part)
    m.start(*LOOP[:-1], "L10", name="y")
    m.start("U3", *BAR, name="x")
    m.bench.run_until(m["x"].reaches(1000), "60 s")
    m.bench.pin("x.ui3").drive(0)
    m.bench.run_until_idle()
    assert tuple(m.bar.pieces) == 2 * BARS


@pytest.mark.fact("GSC-SYS-DRILL-1", "GSC-SYS-DRILL-5")
@pytest.mark.parametrize("file", ["as_printed", "looped"])
def test_the_bench_files_of_the_machine_drill_and_cut_the_bar(file):
    bench = slewline.load(EXAMPLES / f"{file}.toml")
    bench.run_until_idle()
    assert tuple(bench["bar"].pieces) == BARS
    assert bench.findings == []
    programs = [bench[name].listing().split()[1::2] for name in ("bar_unit", "drill_unit")]
    assert programs == [BAR, DRILL if file == "as_printed" else LOOP]
    assert [len(bench[name].program) for name in ("bar_unit", "drill_unit")] == [50, 36 if file == "as_printed" else 40]


def test_the_bar_must_not_move_with_the_drill_in_it_and_the_drill_must_turn():
    m = machine(C200)
    m.run(*DRILL[:3], "+101", name="y")
    m.run(*BAR[:3], "+2", name="x")
    assert m.codes("drill") == ["drill-stands"]
    assert m.codes("bar") == ["bit-broken", "bit-broken"]
    assert m.bar.holes == [0]
    assert str(CutPiece((250, 370), 980)) == "holes at 250, 370, cut at 980"
    assert str(CutPiece((), 5)) == "holes at none, cut at 5"
    with pytest.raises(slewline.UsageError, match="d: gap 0; allowed 1 or more steps"):
        slewline.Bench().part("drill", "d", gap=0)


# ----------------------------------------------------------------------------------------------------- choosing S and T
@pytest.mark.fact("GSC-SYS-SS-1")
def test_the_start_stop_speed_is_half_of_the_pull_in_rate():
    assert start_stop(600) == 30
    assert start_stop(619) == 30  # never faster than half
    assert start_stop(620) == 31
    with pytest.raises(
        slewline.UsageError, match=r"pull-in rate 19 steps/s: makes 0 units of 10 steps/s; allowed 1\.\.1000"
    ):
        start_stop(19)


@pytest.mark.fact("GSC-SYS-SLEW-1", "GSC-CON-SLEW-FORMULA")
def test_the_slew_speed_follows_from_load_and_torque():
    assert turns_a_minute(force=20, length=10, seconds=0.5, torque=100) == pytest.approx(666.67, rel=1e-5)
    assert top_speed(20, 10, 0.5, 100) == 222
    assert top_speed(20, 10, 0.5, 100, steps_a_turn=400) == 444
    assert 200 / (6000 * 0.5) * 10 / 100 < 0.007  # what the printed 10 would make of it
    horsepower = 550 * 12  # pound-inches a second
    turning = 33_000 * 12 * 16 / 6.283185  # ounce-inches times turns a minute
    assert (horsepower, turning) == (6600, pytest.approx(1_008_406, rel=1e-6))
    assert 20 * 10 / 0.5 / horsepower == pytest.approx(100 * 666.67 / turning, rel=0.1)  # 6000 for 6600
    with pytest.raises(slewline.UsageError, match="makes 22222 units"):
        top_speed(20, 10, 0.005, 100)
