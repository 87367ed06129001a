"""ENABLE: a step that it holds waits, and nothing of the move is lost."""

from __future__ import annotations

from itertools import accumulate

import pytest
from gsc import C200, C200S, MS, SETUP, STR, US, WIDTH, Rig, base, both, gaps, spacing

PLAN = spacing(1000, 10, 100, 50)
DUE = [0, *accumulate(PLAN)]  # when each step of such a move comes after the first one; they count from 0
RELEASE = 5 * US  # from ENABLE high to the step that it held


def moving(part: str, *record: str, move: str = "+1000", ramp: str = "R50") -> tuple[Rig, int]:
    """A module in motion from 100 to 1000 steps/s, and the instant of its first step."""
    rig = base(part, *record)
    first = rig.start("S10", "T100", ramp, move) + 4 * MS + SETUP
    return rig, first


# ----------------------------------------------------------------------------------------------------- one long hold
@both
@pytest.mark.fact("GSC-ENABLE-1", "GSC-ENABLE-2", "GSC-ENABLE-3", "GSC-ENABLE-6", "GSC-TIME-7")
def test_a_hold_stops_the_steps_and_loses_none(part: str) -> None:
    rig, first = moving(part, "clock")
    hold = first + DUE[199] + MS // 2
    rig.drive("enable", 0, at=hold)
    rig.drive("enable", 1, at=hold + 500 * MS)
    rig.bench.run_to(hold + 20 * MS)
    assert rig.levels("mov", "rdy", "clock") == (1, 0, 1)
    assert rig.asks("F", "V1") == ["B", "B"]
    assert "held by enable=0" in rig.x.waiting
    rig.bench.run_until_idle()
    falls = rig.falls("clock")
    assert [fall for fall in falls if hold <= fall <= hold + 500 * MS] == []
    assert falls[:200] == [first + DUE[index] for index in range(200)]
    assert falls[200] == hold + 500 * MS + RELEASE
    assert gaps(falls[200:]) == PLAN[200:-1]
    assert len(falls) == 1000 == rig.pos()


@both
@pytest.mark.fact("GSC-ENABLE-4", "GSC-ENABLE-2")
@pytest.mark.parametrize("index", [0, 1, 25, 49, 50, 948, 949, 950, 999])
def test_the_profile_goes_by_steps_and_a_hold_freezes_it(part: str, index: int) -> None:
    rig, first = moving(part, "mov", "ramp")
    free = [first + due for due in DUE[:1000]]
    rig.drive("enable", 0, at=free[index] - 1)
    release = free[index] + 500 * MS
    rig.drive("enable", 1, at=release)
    rig.bench.run_until_idle()
    late = release + RELEASE - free[index]
    assert rig.pulses() == [time + late * (k >= index) for k, time in enumerate(free)]
    # RAMP goes with the steps, so it keeps its level in the hold; MOV is high from before the first step on
    steps = rig.pulses()
    assert rig.edges("ramp") == [(first - SETUP, 1), (steps[50], 0), (steps[949], 1), (steps[999] + WIDTH, 0)]
    assert rig.edges("mov") == [(first - SETUP, 1), (steps[999] + WIDTH, 0)]


@both
@pytest.mark.fact("GSC-ENABLE-4", "GSC-UND-ENABLE-LATENCY")
def test_a_step_is_never_made_before_it_is_due(part: str) -> None:
    rig, first = moving(part)
    rig.drive("enable", 0, at=first + DUE[100] + 100)
    rig.drive("enable", 1, at=first + DUE[101] - 1)  # high again just before the look
    rig.x.pin("enable").pulse(0, 30 * US, at=first + DUE[150] + 3 * US)
    rig.bench.run_until_idle()
    assert gaps(rig.pulses()) == PLAN[:-1]


# ---------------------------------------------------------------------------------------------------------- the look
@both
@pytest.mark.fact("GSC-UND-ENABLE-LATENCY")
@pytest.mark.parametrize(("fall", "held"), [(-1, True), (0, False), (US, False)])
def test_enable_is_sampled_just_before_a_step_and_a_pulse_that_has_begun_is_completed(
    part: str, fall: int, held: bool
) -> None:
    rig, first = moving(part, "clock")
    due = first + DUE[100]
    rig.drive("enable", 0, at=due + fall)
    rig.bench.run("2 s")
    edges = rig.edges("clock")
    assert len(edges) == 2 * (100 if held else 101)
    assert edges[-1][0] - edges[-2][0] == WIDTH
    assert rig.x.position == len(edges) // 2
    rig.drive("enable", 1, at=(release := rig.bench.now_ps + 1))
    rig.bench.run_until_idle()
    assert rig.pulses()[len(edges) // 2] == release + RELEASE
    assert rig.pos() == 1000


@both
@pytest.mark.fact("GSC-UND-ENABLE-LATENCY", "GSC-ENABLE-4")
@pytest.mark.parametrize("rise", [0, 1, 100 * US])
def test_a_release_in_the_instant_of_the_sample_comes_too_late_for_it(part: str, rise: int) -> None:
    rig, first = moving(part)
    due = first + DUE[100]
    rig.drive("enable", 0, at=due - 10 * US)
    rig.drive("enable", 1, at=due + rise)
    rig.bench.run_until_idle()
    assert rig.pulses()[100] == due + rise + RELEASE
    assert gaps(rig.pulses()[100:]) == PLAN[100:-1]


@both
@pytest.mark.fact("GSC-UND-ENABLE-LATENCY")
def test_a_release_shorter_than_its_latency_causes_no_step(part: str) -> None:
    rig, first = moving(part)
    due = first + DUE[100]
    rig.drive("enable", 0, at=due - 10 * US)
    rig.bench.run_to(due + 50 * MS)
    for bounce in range(5):
        rig.x.pin("enable").pulse(1, RELEASE - 1, at=due + (60 + bounce) * MS)
        rig.drive("enable", 0, at=due + (60 + bounce) * MS + RELEASE - 1)
    rig.bench.run_to(due + 100 * MS)
    assert len(rig.pulses()) == 100
    rig.drive("enable", 1)
    rig.bench.run_until_idle()
    assert rig.pulses()[100] == due + 100 * MS + RELEASE


@both
@pytest.mark.fact("GSC-ENABLE-2", "GSC-ENABLE-3")
def test_a_move_that_begins_inhibited_waits_with_its_pins_set(part: str) -> None:
    rig = base(part, "mov", "ramp", "dir", enable=0)
    acted = rig.start(*STR, "+20")
    rig.bench.run("10 s")
    assert rig.pulses() == []
    assert rig.edges("mov", acted) == rig.edges("ramp", acted) == [(acted + 4 * MS, 1)]
    rig.drive("enable", 1, at=(release := rig.bench.now_ps + 1))
    rig.bench.run_until_idle()
    assert rig.pulses()[0] == release + RELEASE
    assert gaps(rig.pulses()) == spacing(20, 10, 100, 10)[:-1]


@both
@pytest.mark.fact("GSC-ENABLE-2")
def test_enable_low_after_the_last_step_has_no_effect(part: str) -> None:
    rig, first = moving(part, "mov", "uo1", move="+20", ramp="R10")
    last = first + sum(spacing(20, 10, 100, 10)[:19])
    rig.drive("enable", 0, at=last)
    rig.bench.run_until_idle()
    assert rig.falls("mov") == [last + WIDTH]
    assert rig.bench.now_ps == last + 10 * MS


# ------------------------------------------------------------------------------------------------- loops around steps
@both
@pytest.mark.fact("GSC-ENABLE-5")
@pytest.mark.parametrize("late", [300 * US, 5 * MS])
def test_in_a_closed_loop_each_step_waits_for_the_report_of_the_one_before(part: str, late: int) -> None:
    rig, _ = moving(part, move="+50", ramp="R10")
    clock, enable = rig.x.pin("clock").net, rig.x.pin("enable")

    def detector(net: object) -> None:
        if clock.level == 0:
            now = rig.bench.now_ps
            enable.drive(0)
            if rig.x.position != 20:
                enable.drive(1, at=now + late)

    clock.watch(detector)
    rig.bench.run("3 s")
    assert len(rig.pulses()) == 20  # the report of this one is withheld
    assert rig.ask("F") == "B"
    plan = spacing(50, 10, 100, 10)
    assert gaps(rig.pulses()) == [gap if gap > late else late + RELEASE for gap in plan[:19]]
    enable.drive(1, at=(report := rig.bench.now_ps + 1))
    rig.bench.run_until_idle()
    assert rig.pulses()[20] == report + RELEASE
    assert gaps(rig.pulses()[20:]) == [gap if gap > late else late + RELEASE for gap in plan[20:-1]]
    assert rig.pos() == 50


@both
@pytest.mark.fact("GSC-ENABLE-6")
def test_a_gate_at_enable_times_the_steps(part: str) -> None:
    rig, first = moving(part, move="+100", ramp="R10")
    gate = first // (10 * MS) * 10 * MS + 20 * MS
    rig.drive("enable", 0)
    for period in range(150):
        rig.drive("enable", 1, at=gate + period * 10 * MS)
        rig.drive("enable", 0, at=gate + period * 10 * MS + MS // 2)
    rig.bench.run_until_idle()
    steps = rig.pulses()
    assert len(steps) == 100
    assert gaps(steps[2:]) == [10 * MS] * 97
    assert {(time - gate) % (10 * MS) for time in steps[2:]} == {RELEASE}


# --------------------------------------------------------------------------------------------------------- K, Z, H
@both
@pytest.mark.fact("GSC-ENABLE-7")
def test_k_ends_an_inhibited_move(part: str) -> None:
    rig, first = moving(part, "mov")
    rig.drive("enable", 0, at=first + DUE[199] + 1)
    rig.bench.run_to(first + DUE[250])
    acted = rig.obeyed("K")
    assert rig.falls("mov") == [acted]
    rig.drive("enable", 1)
    rig.bench.run("1 s")
    assert len(rig.pulses()) == 200 == rig.pos()
    assert rig.level("rdy") == 1 and rig.ask("F") == "R"


@both
@pytest.mark.fact("GSC-ENABLE-7")
def test_z_in_a_hold_decelerates_on_release(part: str) -> None:
    rig, first = moving(part, move="+5000")
    rig.drive("enable", 0, at=first + DUE[199] + 1)
    rig.bench.run_to(first + DUE[250])
    assert rig.ask("Z") == "Y"
    rig.bench.run("5 s")
    assert len(rig.pulses()) == 200
    assert rig.ask("F") == "B"
    rig.drive("enable", 1, at=(release := rig.bench.now_ps + 1))
    rig.bench.run_until_idle()
    assert rig.pulses()[200] == release + RELEASE
    assert gaps(rig.pulses()[200:]) == spacing(5000, 10, 100, 50)[49::-1]
    assert rig.pos() == 251


@both
@pytest.mark.fact("GSC-ENABLE-7")
def test_z_ends_a_hold_at_the_start_stop_rate_immediately(part: str) -> None:
    rig = base(part, "mov", enable=0)
    rig.start(*STR, "+50", "+50")
    rig.bench.run("1 s")
    acted = rig.obeyed("Z")
    assert rig.falls("mov") == [acted]
    rig.bench.run_until_idle()
    rig.drive("enable", 1)
    rig.bench.run("1 s")
    assert rig.pulses() == [] and rig.ask("F") == "R"


@both
@pytest.mark.fact("GSC-ENABLE-7", "GSC-UND-T-LE-S")
def test_z_ends_a_hold_immediately_without_a_ramp(part: str) -> None:
    rig = base(part, "mov")
    rig.start("S50", "T50", "R9", "+500", "+500")
    rig.bench.run_until(rig.x.reaches(100))
    rig.drive("enable", 0)
    rig.bench.run("1 s")
    acted = rig.obeyed("Z")
    assert rig.falls("mov") == [acted]
    rig.drive("enable", 1)
    rig.bench.run("1 s")
    assert len(rig.pulses()) == 100 == rig.pos()


@both
@pytest.mark.fact("GSC-ENABLE-8")
def test_enable_gates_homing_too(part: str) -> None:
    rig = base(part, "mov")
    rig.run(*STR)
    rig.drive("enable", 0)
    assert rig.ask("H+") == "Y"
    rig.bench.run("2 s")
    assert rig.pulses() == [] and rig.levels("mov", "rdy") == (1, 0)
    rig.drive("enable", 1, at=(release := rig.bench.now_ps + 1))
    begin = release + RELEASE
    rig.drive("enable", 0, at=begin + 45 * MS)
    rig.drive("enable", 1, at=begin + 105 * MS)
    rig.drive("eot", 0, at=begin + 130 * MS)
    rig.drive("home", 0, at=begin + 200 * MS)
    rig.bench.run_until_idle()
    late = 55 * MS + RELEASE
    out = [begin + k * 10 * MS + late * (k > 4) for k in range(8)]
    assert rig.pulses() == [*out, *(out[-1] + 10 * MS + SETUP + k * 10 * MS for k in range(7))]
    assert rig.moves() == [8, -7]


@both
@pytest.mark.fact("GSC-ENABLE-8")
def test_enable_does_not_affect_delays_waits_and_outputs(part: str) -> None:
    seen = []
    for enable in (0, 1):
        rig = base(part, "uo1", enable=enable, ui2=0)
        rig.drive("ui2", 1, at=2000 * MS)
        rig.run("A1", "D5", "C1", "W2", "A1", "D1", "C1")
        seen.append(rig.edges("uo1"))
    assert seen[0] == seen[1]
    assert seen[0][1][0] - seen[0][0][0] == 502 * MS


@pytest.mark.fact("GSC-ENABLE-6")
@pytest.mark.parametrize("part", [C200, C200S])
def test_a_move_pauses_for_as_long_as_enable_is_low(part: str) -> None:
    rig, first = moving(part)
    rig.drive("enable", 0, at=first + DUE[10] + 1)
    rig.bench.run("86400 s")
    assert len(rig.pulses()) == 11 and rig.ask("F") == "B"
    rig.drive("enable", 1)
    rig.bench.run_until_idle()
    assert rig.pos() == 1000
