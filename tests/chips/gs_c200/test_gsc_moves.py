"""Moves of the GS-C modules: to a position, by a number of steps, without end or until an input falls; S, T and R.

An instruction takes a millisecond before it acts; a motion begins 10 us later.
"""

from __future__ import annotations

import pytest
from gsc import C200, C200S, FAST, MS, SETUP, STR, US, base, both, gaps, shown, spacing, velocity, within


# ---------------------------------------------------------------------------------------------------------------- moves
@pytest.mark.fact("GSC-CMD-G-1", "GSC-CON-GOTO-LETTER")
def test_goto_of_the_c200_takes_a_plain_position() -> None:
    rig = base(C200)
    rig.run(*STR, "G500", "G120")
    assert rig.moves() == [500, -380]
    assert rig.ask("V1") == "V120"
    assert rig.prg("G9999999", "G10000000", "G0", "G") == ["Y", "E2", "Y", "E2"]


@pytest.mark.fact("GSC-CMD-G-3", "GSC-CON-GOTO-LETTER", "GSC-UND-F-SIGN")
def test_goto_of_the_c200s_takes_a_signed_position() -> None:
    rig = base(C200S)
    rig.run(*STR, "G+500", "G-120")
    assert rig.moves() == [500, -620]
    assert rig.ask("V1") == "V-120"
    half = rig.bench.now_ps
    rig.run("G0", "G30")
    assert rig.moves(half) == [150]
    assert rig.prg("G+8388607", "G-8388608", "G+8388608", "G-8388609", "G") == ["Y", "Y", "E2", "E2", "E2"]


@both
@pytest.mark.fact("GSC-CMD-G-2")
def test_goto_the_present_position_takes_no_step(part: str) -> None:
    rig = base(part, "mov", "uo1")
    rig.run(*STR, "G50", "G50", "A1")
    last = rig.pulses()[-1]
    assert rig.moves() == [50] and len(rig.rises("mov")) == 1
    assert rig.rises("uo1") == [last + 10 * MS + 2 * MS]


@both
@pytest.mark.fact("GSC-CMD-INC-1")
def test_a_signed_number_moves_from_the_present_position(part: str) -> None:
    rig = base(part)
    rig.run(*STR, "+37", "-12")
    assert rig.moves() == [37, -12]
    assert rig.ask("V1") == shown(part, 25)
    assert rig.prg("+999999", "-999999", "+1000000", "-1000000", "+0", "-0", "+") == ["Y", "Y"] + ["E2"] * 5


@both
@pytest.mark.fact("GSC-CMD-INC-2")
def test_both_kinds_of_moves_may_be_mixed(part: str) -> None:
    rig = base(part)
    rig.run(*STR, "G100", "+50", "-30", "G10")
    assert rig.moves() == [150, -140]
    assert rig.ask("V1") == shown(part, 10)


@both
@pytest.mark.fact("GSC-CMD-INC-3", "GSC-CON-UNSIGNED-MOVE")
def test_a_move_needs_its_sign(part: str) -> None:
    rig = base(part)
    assert rig.prg("3000", "+3000") == ["E4", "Y"]
    assert rig.listed() == ["+3000"]


# -------------------------------------------------------------------------------------------------------- velocity mode
@both
@pytest.mark.fact("GSC-CMD-GV-1", "GSC-CMD-GV-2", "GSC-CON-G-ENDLESS-EXAMPLE", "GSC-CON-GOTO-LETTER")
@pytest.mark.parametrize(("sign", "end"), [("+", "K"), ("-", "Z")])
def test_velocity_mode_accelerates_and_runs_without_end(part: str, sign: str, end: str) -> None:
    rig = base(part, "ramp")
    rig.run(*STR, "+80000")  # the counter of the GS-C200 must not end the way back
    begin = rig.start(*STR, f"{velocity(part)}{sign}") + 4 * MS + SETUP
    rig.bench.run("2 s")
    up = spacing(100, 10, 100, 10)[:10]
    assert gaps(rig.pulses(begin))[:12] == [*up, MS, MS]
    assert rig.rises("ramp", begin - SETUP) == [begin - SETUP]
    assert rig.falls("ramp", begin) == [begin + sum(up)]
    rig.bench.run("60 s")
    assert set(gaps(rig.pulses(begin))[10:]) == {MS}
    assert rig.levels("dir", "mov", "ramp", "rdy") == (sign == "+", 1, 0, 0)
    assert rig.ask(end) == "Y"
    rig.bench.run_until_idle("1 s")


@both
@pytest.mark.fact("GSC-CMD-GV-2", "GSC-CMD-GC-1", "GSC-CMD-GC-2")
def test_velocity_mode_checks_its_form(part: str) -> None:
    rig = base(part)
    letter = velocity(part)
    forms = [letter + rest for rest in ("+", "-", "+1", "-3", "+4", "+0", "")]
    assert rig.prg(*forms) == ["Y"] * 4 + ["E2"] * 3
    assert rig.listed() == forms[:4]
    assert rig.asks(*({C200: ("g+", "g+1"), C200S: ("G+", "g1")}[part])) == ["E4" if part == C200 else "E2"] * 2


@both
@pytest.mark.fact("GSC-CMD-GC-1", "GSC-CMD-GC-2", "GSC-CMD-GC-3", "GSC-CON-G-ENDLESS-EXAMPLE")
def test_a_controlled_run_ramps_down_when_its_input_falls(part: str) -> None:
    rig = base(part, "ramp", "mov", "uo1")
    rig.start(*FAST, f"{velocity(part)}+2", "A1")
    rig.bench.run("3 s")
    rig.drive("ui1", 0)
    rig.drive("ui3", 0)
    rig.bench.run("3 s")
    assert rig.levels("mov", "ramp") == (1, 0)
    fall = rig.bench.now_ps
    rig.drive("ui2", 0)
    rig.bench.run_until_idle()
    pulses = rig.pulses()
    down, rest = rig.edges("ramp", fall)
    assert fall < down[0] <= fall + 2 * MS  # a look, and the step after it
    assert within(pulses, down[0], rest[0]) == 51 and pulses[-1] < rest[0]
    assert gaps(pulses) == gaps(pulses)[::-1]
    assert set(gaps(pulses)[50:-50]) == {MS}
    assert rig.rises("uo1") == [pulses[-1] + 10 * MS + MS]


@both
@pytest.mark.fact("GSC-CMD-GC-3")
def test_a_controlled_run_takes_no_step_when_its_input_is_low(part: str) -> None:
    rig = base(part, "mov", "uo1", ui2=0)
    start = rig.run(*FAST, f"{velocity(part)}+2", "A1")
    assert rig.pulses() == rig.edges("mov") == []
    assert rig.edges("uo1") == [(start + 5 * MS, 1)]


@both
@pytest.mark.fact("GSC-CMD-GS-DIFF", "GSC-CMD-GC-2")
def test_the_same_text_is_a_run_on_the_c200_and_a_position_on_the_c200s(part: str) -> None:
    rig = base(part)
    rig.start(*STR, "G+2")
    rig.bench.run("5 s")
    if part == C200:
        assert rig.level("mov") == 1 and gaps(rig.pulses())[-1] == MS
    else:
        assert rig.level("mov") == 0 and rig.moves() == [2]


# ----------------------------------------------------------------------------------------------------- speeds and ramps
@both
@pytest.mark.fact("GSC-CMD-S-1", "GSC-CMD-T-1", "GSC-CON-VALUE-RANGE")
def test_speeds_count_tens_of_steps_a_second(part: str) -> None:
    rig = base(part)
    rig.run("S30", "T300", "R50", "+500")
    assert gaps(rig.pulses())[0] == round(10**12 / 300)
    assert set(gaps(rig.pulses())[50:448]) == {round(10**12 / 3000)}
    half = rig.bench.now_ps
    rig.run("S1", "T1000", "R1", "+20")
    assert gaps(rig.pulses(half)) == [100 * MS, *[100 * US] * 17, 100 * MS]
    ranges = {"S": ("0", "1001", "", "+5"), "T": ("0", "1001", "", "+5"), "R": ("0", "1000", "", "+5")}
    for letter, wrong in ranges.items():
        limit = {"R": 999}.get(letter, 1000)
        assert rig.prg(f"{letter}1", f"{letter}{limit}") == ["Y", "Y"]
        assert rig.asks(*(letter + text for text in wrong)) == ["E2"] * 4


@both
@pytest.mark.fact("GSC-CMD-R-1")
def test_the_last_r_sets_the_length_of_ramps(part: str) -> None:
    rig = base(part, "ramp")
    rig.run("S10", "T100", "R25", "+3000", "R85", "-800")
    pulses, ramps = rig.pulses(), [time for time, _ in rig.edges("ramp")]
    assert rig.moves() == [3000, -800]
    assert [within(pulses, *ramps[n : n + 2]) for n in (0, 2, 4, 6)] == [25, 26, 85, 86]


@both
@pytest.mark.fact("GSC-CMD-S-2", "GSC-UND-PERSIST")
def test_speeds_act_on_the_moves_that_follow_and_outlive_the_program(part: str) -> None:
    rig = base(part)
    rig.run("S20", "T200", "R20", "+500", "S35", "+500", "T300", "+500")
    moves = [rig.pulses()[n : n + 500] for n in (0, 500, 1000)]
    assert [gaps(move)[0] for move in moves] == [5 * MS, round(10**12 / 350), round(10**12 / 350)]
    assert [min(gaps(move)) for move in moves] == [500 * US, 500 * US, round(10**12 / 3000)]
    half = rig.bench.now_ps
    assert rig.ask("I3") == "Y"
    rig.run("+500")
    assert gaps(rig.pulses(half)) == gaps(moves[2])
