"""Homing: out to the end of travel, back to the home position, at the start-stop speed."""

from __future__ import annotations

import pytest
from gsc import C200, C200S, MS, SETUP, STR, US, WIDTH, Rig, base, both, gaps

ZERO = {C200: "V0", C200S: "V+0"}


def ready(part: str, *record: str, **straps: int) -> Rig:
    """A module with the speeds 100 and 1000 steps/s, at position 7."""
    rig = base(part, *record, **straps)
    rig.run(*STR, "+7")
    return rig


def begun(rig: Rig, command: str = "H") -> int:
    """Begin to home; returns the instant of the first step."""
    return rig.obeyed(command) + SETUP


def homed(rig: Rig, command: str, out: int, back: int, period: int = 10 * MS) -> int:
    """Home with EOT low just behind step `out` and HOME low just behind step `back` on the way back."""
    begin = begun(rig, command)
    rig.drive("eot", 0, at=begin + (out - 1) * period + 1)
    rig.drive("home", 0, at=begin + out * period + SETUP + (back - 1) * period + 1)
    rig.bench.run_until_idle()
    return begin


@both
@pytest.mark.fact("GSC-HOME-1", "GSC-HOME-2", "GSC-HOME-3", "GSC-HOME-8", "GSC-UND-H-REVERSE", "GSC-POS-9")
@pytest.mark.parametrize(("command", "sign"), [("H", 1), ("H+", 1), ("H-", -1)])
def test_homing_goes_to_the_end_of_travel_and_back_to_home(part: str, command: str, sign: int) -> None:
    rig = ready(part, "dir", "mov", "ramp", "rdy", "clock")
    begin = homed(rig, command, 30, 12)
    assert rig.x.steps(begin).directions.tolist() == [sign] * 30 + [-sign] * 12
    steps = rig.pulses(begin)
    # no ramp, no pause at the reversal but the period and the set-up of DIR
    assert gaps(steps) == [10 * MS] * 29 + [10 * MS + SETUP] + [10 * MS] * 11
    assert rig.edges("dir", begin - SETUP)[-1] == (steps[30] - SETUP, int(sign < 0))
    # HOME is looked at just before the next step, and there the motion ends
    assert rig.edges("mov", begin - SETUP) == [(begin - SETUP, 1), (steps[-1] + 10 * MS, 0)]
    assert rig.edges("ramp", begin - SETUP) == []
    assert rig.rises("rdy")[-1] == steps[-1] + 10 * MS
    assert rig.asks("F", "V1") == ["R", ZERO[part]]
    assert rig.x.position == 0


@both
@pytest.mark.fact("GSC-HOME-1", "GSC-HOME-8")
def test_homing_begins_with_its_answer(part: str) -> None:
    rig = ready(part, "dir", "mov")
    acted = rig.obeyed("H-")
    assert rig.edges("dir", acted) == [(acted, 0)] and rig.edges("mov", acted) == [(acted, 1)]
    assert rig.pulses(acted) == [acted + SETUP]


@both
@pytest.mark.fact("GSC-HOME-8", "GSC-UND-H-REVERSE")
@pytest.mark.parametrize(("late", "extra"), [(-1, 0), (0, 1)])
def test_switches_are_sampled_just_before_each_step(part: str, late: int, extra: int) -> None:
    rig = ready(part)
    begin = begun(rig)
    look = begin + 5 * 10 * MS  # of step 5, counted from 0
    rig.drive("eot", 0, at=look + late)
    back = look + extra * 10 * MS + SETUP
    rig.drive("home", 0, at=back + 3 * 10 * MS + late)
    rig.bench.run_until_idle()
    assert rig.moves(begin) == [5 + extra, -3 - extra]


@both
@pytest.mark.fact("GSC-HOME-8", "GSC-UND-H-REVERSE")
def test_a_switch_that_is_low_between_two_samples_is_missed(part: str) -> None:
    rig = ready(part)
    begin = begun(rig)
    rig.x.pin("eot").pulse(0, 10 * MS - 1, at=begin + 50 * MS)  # from look to look, neither included
    rig.x.pin("eot").pulse(0, "1 ps", at=begin + 100 * MS - 1)  # just there
    rig.drive("home", 0, at=begin + 200 * MS)
    rig.bench.run_until_idle()
    assert rig.moves(begin) == [10, -10]


@both
@pytest.mark.fact("GSC-UND-H-REVERSE")
def test_home_is_ignored_on_the_outward_move(part: str) -> None:
    rig = ready(part, home=0)
    begin = begun(rig)
    rig.drive("home", 1, at=begin + 195 * MS)
    rig.drive("eot", 0, at=begin + 245 * MS)
    rig.drive("home", 0, at=begin + 275 * MS)
    rig.bench.run_until_idle()
    assert rig.moves(begin) == [25, -3]


@both
@pytest.mark.fact("GSC-HOME-6")
def test_with_both_inputs_tied_the_reference_is_the_end_of_travel(part: str) -> None:
    rig = base(part, "mov", "dir")
    rig.bench.wire("x.home", "x.eot")
    rig.run(*STR, "+7")
    begin = begun(rig)
    rig.drive("eot", 0, at=begin + 295 * MS)
    rig.bench.run_until_idle()
    assert rig.moves(begin) == [30]
    assert rig.falls("mov")[-1] == begin + 300 * MS
    assert rig.edges("dir") == []  # no reversal
    assert rig.ask("V1") == ZERO[part]


@both
@pytest.mark.fact("GSC-HOME-7")
def test_at_the_end_of_travel_from_the_beginning_no_step_goes_further(part: str) -> None:
    rig = ready(part, "dir", eot=0)
    begin = begun(rig, "H+")
    rig.drive("home", 0, at=begin + 35 * MS)
    rig.bench.run_until_idle()
    assert rig.moves(begin - SETUP) == [-4]
    assert rig.edges("dir") == [(begin - SETUP, 0)]
    assert rig.pulses(begin - SETUP)[0] == begin
    assert rig.ask("V1") == ZERO[part]


@both
@pytest.mark.fact("GSC-HOME-7")
def test_at_home_and_at_the_end_of_travel_no_step_is_made_at_all(part: str) -> None:
    rig = ready(part, "mov", "dir", eot=0, home=0)
    acted = rig.obeyed("H-")
    rig.bench.run_until_idle()
    assert rig.pulses(acted) == [] and rig.edges("mov", acted) == [] and rig.edges("dir") == []
    assert rig.asks("F", "V1") == ["R", ZERO[part]]


@both
@pytest.mark.fact("GSC-HOME-8", "GSC-PIN-RDY-1", "GSC-PIN-MOV-1")
def test_the_pins_while_homing(part: str) -> None:
    rig = ready(part)
    begin = begun(rig)
    rig.drive("eot", 0, at=begin + 45 * MS)
    seen = set()
    for later in (0, 25, 49, 51, 75):
        rig.bench.run_to(begin + later * MS if later else rig.bench.now_ps)
        seen.add(rig.levels("mov", "ramp", "rdy"))
    assert seen == {(1, 0, 0)}
    rig.drive("home", 0)
    rig.bench.run_until_idle()
    assert rig.levels("mov", "ramp", "rdy") == (0, 0, 1)


@pytest.mark.fact("GSC-HOME-4")
def test_homing_erases_the_program_of_a_c200() -> None:
    rig = ready(C200)
    homed(rig, "H+", 3, 2)
    assert rig.asks("Q", "E", "F") == ["END", "E4", "R"]


@pytest.mark.fact("GSC-HOME-5")
def test_homing_keeps_the_program_of_a_c200s() -> None:
    rig = ready(C200S)
    homed(rig, "H+", 3, 2)
    assert rig.listed() == [*STR, "+7"]
    assert rig.ask("E") == "Y"
    rig.bench.run_until_idle()
    assert rig.pos() == 7


@pytest.mark.fact("GSC-HOME-12", "GSC-HOME-4")
def test_after_kill_and_home_a_c200_needs_its_program_again() -> None:
    rig = base(C200)
    rig.prg(*STR, "G+")
    assert rig.asks("M", "E") == ["Y", "Y"]
    rig.bench.run("1 s")
    assert rig.ask("K") == "Y"
    homed(rig, "H+", 3, 2)
    assert rig.asks("E", "X", "E") == ["E4", "Y", "Y"]


@both
@pytest.mark.fact("GSC-HOME-9")
@pytest.mark.parametrize(("speed", "period"), [(20, 5 * MS), (1000, 100 * US), (1, 100 * MS)])
def test_the_homing_speed_is_that_of_the_s_at_the_head_of_the_program(part: str, speed: int, period: int) -> None:
    rig = base(part)
    rig.prg(f"S{speed}", "T100", "R10", "S77")
    assert rig.ask("E") == "Y"
    rig.bench.run_until_idle()  # 77 is in force now
    begin = homed(rig, "H", 60, 5, period)
    assert gaps(rig.pulses(begin)) == [period] * 59 + [period + SETUP] + [period] * 4


@both
@pytest.mark.fact("GSC-HOME-10", "GSC-HOME-9")
def test_an_s_at_the_head_counts_before_it_has_been_executed(part: str) -> None:
    rig = base(part)
    rig.prg("S20")
    assert rig.ask("H") == "E4"  # not while programming
    if part == C200S:
        assert rig.asks("Px", "H") == ["Y", "Y"]
        rig.bench.run("1 s")
        assert set(gaps(rig.pulses())) == {5 * MS}


@both
@pytest.mark.fact("GSC-HOME-10", "GSC-UND-H-NO-S")
def test_without_an_s_at_the_head_the_last_one_executed_counts_and_without_any_homing_is_refused(part: str) -> None:
    rig = base(part)
    assert rig.asks("H+", "H-", "F") == ["E4", "E4", "R"]
    assert rig.pulses() == []
    rig.run("S30", "T100", "R10")
    rig.run("A1")
    begin = homed(rig, "H+", 6, 2, 3_333_333_333)
    assert set(gaps(rig.pulses(begin)[:6])) == {3_333_333_333}


@both
@pytest.mark.fact("GSC-HOME-11", "GSC-UND-H-ABORT", "GSC-UND-H-ENDLESS", "GSC-UND-H-COUNTER")
@pytest.mark.parametrize("stop", ["K", "Z"])
def test_homing_runs_until_it_is_stopped_and_leaves_counter_and_program(part: str, stop: str) -> None:
    rig = ready(part, "mov")
    assert rig.ask("H-") == "Y"
    rig.bench.run("3600 s")
    assert rig.asks("F", "V1", "Q") == ["B", "B", "B"]
    acted = rig.obeyed(stop)
    assert rig.falls("mov")[-1] == acted
    rig.bench.run("1 s")
    assert rig.pulses(acted) == []
    assert len(rig.x.steps()) > 360_000
    assert rig.ask("F") == "R"  # not E5, though the counter of a GS-C200 does not go below 0
    assert rig.pos() == rig.x.position == 7
    assert rig.listed() == [*STR, "+7"]


@both
@pytest.mark.fact("GSC-UND-H-ABORT", "GSC-UND-K-DETAIL")
@pytest.mark.parametrize("stop", ["K", "Z"])
def test_a_homing_that_is_stopped_completes_its_pulse(part: str, stop: str) -> None:
    rig = ready(part, "mov", "clock")
    begin = begun(rig, "H-")
    rig.acts(stop, begin + 100 * MS + US)
    rig.bench.run("1 s")
    assert rig.edges("clock")[-2:] == [(begin + 100 * MS, 0), (begin + 100 * MS + WIDTH, 1)]
    assert rig.falls("mov")[-1] == begin + 100 * MS + WIDTH
    assert len(rig.pulses(begin)) == 11
    assert rig.pos() == 7


@both
@pytest.mark.fact("GSC-HOME-3", "GSC-UND-H-COUNTER", "GSC-POS-9")
def test_after_homing_the_counter_begins_at_zero_and_can_be_moved_from(part: str) -> None:
    rig = ready(part)
    begin = homed(rig, "H-", 30, 12)
    rig.run(*STR, "+20", "G0")
    assert rig.moves(begin) == [-30, 32, -20]
    assert rig.asks("F", "V1") == ["R", ZERO[part]]


@both
@pytest.mark.fact("GSC-PIN-EOT-1")
def test_eot_and_home_are_ignored_outside_homing(part: str) -> None:
    rig = base(part, eot=0, home=0)
    rig.run(*STR, "+100")
    assert len(rig.pulses()) == 100
    assert rig.asks("F", "V1") == ["R", "V100" if part == C200 else "V+100"]
    assert rig.codes == []
