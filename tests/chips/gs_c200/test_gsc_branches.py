"""Loops, jumps, waits and Until: how a program of the GS-C modules finds its way.

An instruction takes a millisecond before it acts.
"""

from __future__ import annotations

from itertools import pairwise

import pytest
from gsc import C200S, MS, STR, US, Rig, base, both

SEG = (*STR, "jc1,18", "jc2,24", "j12", "+10", "j12", "-10", "j12")  # UI = 1: +10, UI = 2: -10


def put(rig: Rig, pattern: int) -> None:
    """Drive the user inputs to a number, UI1 being its lowest bit."""
    for n in range(3):
        rig.drive(f"ui{n + 1}", pattern >> n & 1)


# ---------------------------------------------------------------------------------------------------------------- loops
@both
@pytest.mark.fact("GSC-CMD-L-1")
@pytest.mark.parametrize(("steps", "passes"), [(10, 10), (10, 1), (10, 2), (1, 255)])
def test_a_loop_has_the_programmed_number_of_passes(part: str, steps: int, passes: int) -> None:
    rig = base(part, "mov")
    rig.run(*STR, "+3", "L0", f"+{steps}", f"L{passes}", "-1")
    assert rig.moves() == [3 + steps * passes, -1]
    assert len(rig.rises("mov")) == 1 + passes + 1
    assert rig.codes == []


@both
@pytest.mark.fact("GSC-CMD-L-1", "GSC-CON-VALUE-RANGE")
def test_a_loop_counts_from_1_to_255(part: str) -> None:
    assert base(part).prg("L255", "L256", "L", "L-1", "L1") == ["Y", "E2", "E2", "E2", "Y"]


@both
@pytest.mark.fact("GSC-CMD-L-2")
def test_a_loop_without_a_start_repeats_from_the_beginning(part: str) -> None:
    rig = base(part)
    rig.run(*STR, "+10", "L3", "A1")
    assert rig.moves() == [30]
    assert rig.level("uo1") == 1 and rig.codes == []


@both
@pytest.mark.fact("GSC-CMD-L-3", "GSC-CON-LOOP-LETTER")
def test_the_loop_start_may_be_written_with_a_letter(part: str) -> None:
    rig = base(part)
    rig.run(*STR, "Lo", "+10", "L4")
    assert rig.listed() == [*STR, "L0", "+10", "L4"]
    assert rig.moves() == [40]


@both
@pytest.mark.fact("GSC-CMD-L-4")
def test_loops_may_follow_one_another(part: str) -> None:
    rig = base(part, "mov")
    rig.run(*STR, "L0", "+10", "L3", "L0", "+1", "L5")
    assert rig.moves() == [35] and len(rig.rises("mov")) == 8
    assert rig.codes == []


@both
@pytest.mark.fact("GSC-UND-LOOP-NEST")
def test_there_is_one_loop_at_a_time_and_a_loop_end_without_a_start_is_reported_once(part: str) -> None:
    rig = base(part, "mov")
    rig.start("A1", *STR, "L0", "+1", "L0", "+2", "L2", "C1", "L3")  # the L3 goes back to location 0, for ever
    rig.bench.run("30 s")
    assert rig.ask("K") == "Y"
    assert rig.codes == ["loop-without-start"]
    assert len(rig.rises("mov")) > 20
    positions = rig.x.steps().positions.tolist()
    assert positions == list(range(1, len(positions) + 1))


@both
@pytest.mark.fact("GSC-UND-LOOP-NEST")
def test_the_inner_start_of_nested_loops_replaces_the_outer_one(part: str) -> None:
    rig = base(part, "mov", "uo1")
    program = ("A1", *STR, "L0", "+1", "L0", "+2", "L2", "C1", "L3")
    rig.start(*program)
    rig.bench.run_until(rig.x.pin("uo1").is_(0), "10 s")
    assert rig.moves() == [5]
    rig.bench.run_until(rig.x.pin("uo1").is_(1), "2 ms")  # from location 0, not from the outer start
    nested = base(part, "uo1", options={"nested_loops": True})
    nested.run(*program)
    assert nested.moves() == [15]
    assert nested.codes == []


@both
@pytest.mark.fact("GSC-UND-LOOP-NEST")
def test_a_second_loop_without_a_start_is_reported(part: str) -> None:
    rig = base(part)
    rig.start(*STR, "+1", "L2", "+1", "L2")
    rig.bench.run("5 s")
    assert rig.ask("K") == "Y"
    assert rig.codes == ["loop-without-start"]
    again = base(part, ui1=0)
    again.run(*STR, "+1", "L3", "L0", "+1", "L5", "U1")  # nothing is wrong with the second time round
    assert again.moves() == [8] and again.codes == []


@pytest.mark.fact("GSC-UND-LOOP-JC")
def test_a_loop_that_is_left_keeps_start_and_count_until_the_next_run() -> None:
    rig = base(C200S, ui1=0, ui2=0, ui3=0)
    rig.start(*STR, "L0", "+1", "jc1,22", "L3", "+10", "L3", "A1")  # the last three begin at location 22
    rig.bench.run_until(rig.x.reaches(2), "1 s")
    rig.drive("ui1", 1)  # out of the second pass
    rig.bench.run_until_idle()
    assert rig.moves() == [1 + 11 + 11] and rig.level("uo1") == 1
    second = rig.bench.now_ps
    assert rig.ask("E") == "Y"
    rig.bench.run_until_idle()
    assert rig.moves(second) == [3 * 11]
    assert rig.codes == []


@pytest.mark.fact("GSC-UND-LOOP-JC")
def test_a_loop_start_counts_from_zero() -> None:
    rig = base(C200S, ui1=0, ui2=0, ui3=0)
    rig.start(*STR, "L0", "+1", "jc1,12", "L3")
    rig.bench.run_until(rig.x.reaches(2), "1 s")
    rig.drive("ui1", 1)  # back to the L0 from the second pass
    rig.bench.run_until(rig.x.reaches(3), "1 s")
    rig.drive("ui1", 0)
    rig.bench.run_until_idle()
    assert rig.moves() == [1 + 1 + 3]


# ---------------------------------------------------------------------------------------------------------------- jumps
@pytest.mark.fact("GSC-CMD-J-1")
def test_jump_continues_at_its_location() -> None:
    rig = base(C200S)
    rig.start(*STR, "+10", "j12")
    rig.bench.run("5 s")
    assert rig.ask("K") == "Y"
    pulses = rig.pulses()
    groups = [pulses[n : n + 10] for n in range(0, len(pulses) - 10, 10)]
    assert len(groups) > 20
    for group, following in pairwise(groups):
        assert following[0] - group[-1] == 10 * MS + 2 * MS + 10 * US
    assert rig.prg("j118", "j119", "j", "j+1", "j0") == ["Y", "E2", "E2", "E2", "Y"]


@pytest.mark.fact("GSC-CMD-J-2")
def test_jump_to_0_repeats_the_program() -> None:
    rig = base(C200S, "uo1")
    start = rig.start(*STR, "A1", "D1", "C1", "D1", "j0")
    rig.bench.run("2 s")
    period, high = (100 + 100 + 8) * MS, (100 + 2) * MS
    begins = [start + 4 * MS + n * period for n in range(10)]
    assert rig.rises("uo1")[:9] == begins[:9]
    assert rig.falls("uo1")[:9] == [begin + high for begin in begins[:9]]
    assert rig.ask("K") == "Y"


@pytest.mark.fact("GSC-CMD-JC-1", "GSC-PROG-9", "GSC-USERIO-4")
@pytest.mark.parametrize(("inputs", "steps"), [(1, 10), (2, -10), (0, 0), (3, 0), (7, 0)])
def test_inputs_choose_a_segment_of_a_program(inputs: int, steps: int) -> None:
    rig = base(C200S, "mov")
    put(rig, inputs)
    rig.start(*SEG)
    addresses = [int(line.split()[0]) for line in rig.x.listing().splitlines()]
    assert addresses == [0, 4, 8, 12, 14, 16, 18, 22, 24, 28] and len(rig.x.program) == 30
    rig.bench.run("3 s")
    put(rig, 0)
    rig.bench.run("1 s")
    groups = len(rig.rises("mov"))
    assert len(rig.pulses()) == groups * abs(steps)
    assert set(rig.x.steps().directions.tolist()) == ({steps // 10} if steps else set())
    assert (groups > 10) == bool(steps) and rig.codes == []


@pytest.mark.fact("GSC-CMD-JC-2")
def test_a_condition_weighs_the_inputs_1_2_4_and_requires_all_three() -> None:
    rig = base(C200S)
    for wanted in range(8):
        assert rig.prg("C1", f"jc{wanted},8", "D1", "j10", "A1", "D1") == ["Y"] * 6
        found = []
        for pattern in range(8):
            put(rig, pattern)
            assert rig.ask("E") == "Y"
            rig.bench.run_until_idle()
            found.append(rig.level("uo1"))
        assert found == [int(pattern == wanted) for pattern in range(8)]


@pytest.mark.fact("GSC-CMD-JC-3", "GSC-CON-JC-ORDER", "GSC-CON-JUMP-SPELLING")
def test_a_conditional_jump_is_written_condition_comma_location() -> None:
    rig = base(C200S)
    good, bad = ("jc0,40", "jc1,52", "jc2,74", "jc7,118"), ("jc40,0", "jc8,0", "jc0,119", "jc0", "jc,40", "jc0, 40")
    assert rig.prg(*good) == ["Y"] * 4
    assert rig.asks(*bad) == ["E2"] * 6
    assert rig.asks("J12", "Jc0,40", "JC0,40") == ["E4"] * 3
    assert rig.asks("ju", "ju12") == ["E2"] * 2
    assert rig.listed() == list(good)


@pytest.mark.fact("GSC-UND-JUMP-PAST")
@pytest.mark.parametrize("target", [16, 18, 118])
def test_a_jump_beyond_the_program_ends_it(target: int) -> None:
    rig = base(C200S, "rdy")
    start = rig.run(*STR, "A1", f"j{target}")
    assert rig.rises("rdy")[-1] == start + 5 * MS
    assert rig.ask("F") == "R" and rig.codes == []


@pytest.mark.fact("GSC-UND-JUMP-INSIDE", "GSC-PROG-9")
def test_a_jump_into_an_instruction_stops_the_program() -> None:
    rig = base(C200S, ui2=0, ui3=0)
    rig.run(*(line.replace("jc1,18", "jc1,19") for line in SEG))
    assert rig.codes == ["jump-inside"]
    assert "19" in rig.x.findings[0].text
    assert rig.levels("rdy", "mov") == (1, 0) and rig.pulses() == []
    assert rig.ask("F") == "R"


# ---------------------------------------------------------------------------------------------------------------- until
@both
@pytest.mark.fact("GSC-CMD-U-1")
def test_until_repeats_the_program_while_its_input_is_high(part: str) -> None:
    rig = base(part, "mov")
    rig.start(*STR, "+5", "D2", "U2", "+7", "C1")
    rig.drive("ui1", 0)
    rig.drive("ui3", 0)
    rig.bench.run("3 s")
    groups = len(rig.rises("mov"))
    assert groups > 8
    rig.bench.run_until(rig.x.pin("mov").is_(1))
    rig.drive("ui2", 0)
    rig.bench.run_until_idle()
    assert len(rig.rises("mov")) == groups + 2
    assert rig.moves() == [5 * (groups + 1) + 7]
    assert rig.prg("U0", "U4", "U", "U3") == ["E2", "E2", "E2", "Y"]


@both
@pytest.mark.fact("GSC-CMD-U-2")
def test_until_lets_the_program_pass_when_its_input_is_low(part: str) -> None:
    rig = base(part, ui2=0)
    rig.run(*STR, "+5", "U2", "+7")
    assert rig.moves() == [12]


@both
@pytest.mark.fact("GSC-CMD-U-3", "GSC-UND-U-FIRST")
def test_until_at_the_head_of_a_program_is_tested_at_its_end(part: str) -> None:
    rig = base(part, "mov", "rdy")
    rig.start("U3", *STR, "+5", "D2")
    rig.bench.run("3 s")
    rig.bench.run_until(rig.x.pin("mov").is_(1))
    groups = len(rig.rises("mov"))
    assert groups > 8
    rig.drive("ui3", 0)
    rig.bench.run_until_idle()
    assert len(rig.rises("mov")) == groups
    assert rig.moves() == [5 * groups]
    assert rig.rises("rdy")[-1] == rig.pulses()[-1] + 10 * MS + MS + 200 * MS


@both
@pytest.mark.fact("GSC-CMD-U-3", "GSC-UND-U-FIRST")
def test_until_at_the_head_does_not_arm_while_its_input_is_low(part: str) -> None:
    rig = base(part, ui3=0)
    rig.start("U3", *STR, "+5", "D2")
    rig.bench.run("0.1 s")
    rig.drive("ui3", 1)
    rig.bench.run_until_idle("1 s")
    assert rig.moves() == [5]


@both
@pytest.mark.fact("GSC-UND-U-FIRST")
def test_until_at_the_head_may_be_a_plain_test(part: str) -> None:
    rig = base(part, options={"plain_u": True})
    rig.start("U3", *STR, "+5")
    rig.bench.run("3 s")
    assert rig.pulses() == [] and rig.level("rdy") == 0  # it only waits
    rig.drive("ui3", 0)
    rig.bench.run_until_idle()
    assert rig.moves() == [5]


# ----------------------------------------------------------------------------------------------------------------- wait
@both
@pytest.mark.fact("GSC-CMD-W-1")
def test_wait_holds_the_program_until_its_input_is_high(part: str) -> None:
    rig = base(part, "uo1", ui2=0)
    start = rig.start("W2", "A1")
    rig.drive("ui1", 0)
    rig.drive("ui3", 0)
    rig.bench.run("5 s")
    assert rig.edges("uo1") == []
    rig.drive("ui2", 1)
    rise = rig.bench.now_ps
    rig.bench.run_until_idle()
    look = start + MS + -(-(rise - start - MS) // MS) * MS  # every millisecond
    assert rig.edges("uo1") == [(look + MS, 1)]
    assert rig.prg("W0", "W4", "W", "W3") == ["E2", "E2", "E2", "Y"]


@both
@pytest.mark.fact("GSC-CMD-W-1")
def test_wait_does_not_wait_for_an_input_that_is_high(part: str) -> None:
    rig = base(part, "uo1")
    start = rig.run("W2", "A1")
    assert rig.edges("uo1") == [(start + 2 * MS, 1)]


@both
@pytest.mark.fact("GSC-CMD-W-2")
@pytest.mark.parametrize("end", ["Z", "K"])
def test_a_wait_is_busy_without_motion_and_can_be_ended(part: str, end: str) -> None:
    rig = base(part, "mov", ui2=0)
    rig.start("W2", "A1")
    assert rig.ask("F") == "B"
    assert rig.levels("rdy", "mov") == (0, 0)
    assert rig.ask(end) == "Y"
    rig.drive("ui2", 1)
    rig.bench.run("1 s")
    assert rig.levels("rdy", "uo1") == (1, 0) and rig.edges("mov") == []
    assert rig.ask("F") == "R"
