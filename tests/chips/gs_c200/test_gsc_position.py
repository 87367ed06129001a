"""The position counter: its range, what lies beyond it, and what moves, presets and clears it."""

from __future__ import annotations

import pytest
from gsc import C200, C200S, MS, STR, Rig, base, both, gaps, spacing

TOP = 9_999_999
LOW, HIGH = -(1 << 23), (1 << 23) - 1
FAST = ("S1000", "T1000", "R1")


def at(position: int, *record: str) -> Rig:
    """A GS-C200 that has gone to a position from 0, in virtual time that costs nothing."""
    rig = base(C200, *record)
    if position:
        rig.run(*FAST, f"G{position}", timeout="2000 s")
    assert rig.pos() == position
    return rig


# -------------------------------------------------------------------------------------------------- counter of a C200
@pytest.mark.fact("GSC-POS-1", "GSC-CON-TEN-MILLION", "GSC-CON-SINGLE-MOVE")
def test_the_counter_of_a_c200_goes_from_0_to_9999999() -> None:
    rig = base(C200)
    rig.run(*FAST, "L0", "+999999", "L10", timeout="2000 s")
    assert rig.ask("V1") == "V9999990"
    rig.run("+9")
    assert rig.asks("F", "V1") == ["R", "V9999999"]
    rig.run("G0", timeout="2000 s")
    assert rig.asks("F", "V1") == ["R", "V0"]


@pytest.mark.fact("GSC-POS-1")
def test_a_goto_to_the_last_position_of_a_c200_is_taken() -> None:
    rig = base(C200)
    rig.start(*STR, f"G{TOP}")
    rig.bench.run("1 s")
    assert rig.ask("K") == "Y"
    assert rig.pos() == len(rig.pulses()) > 900
    rig.prg(*STR)
    assert rig.ask("G10000000") == "E2"


@pytest.mark.fact("GSC-POS-5", "GSC-UND-E5", "GSC-CON-TEN-MILLION", "GSC-CON-E5-REPORT")
def test_a_move_beyond_the_upper_end_is_refused_before_its_first_step() -> None:
    rig = at(TOP - 9, "mov")
    before = rig.bench.now_ps
    told = len(rig.host.received)
    rig.run(*STR, "+10", "A1")
    assert rig.host.received[told:] == b"Y\r" * 7  # to P, five lines and E: more comes only when the host asks
    assert rig.pulses(before) == [] and rig.edges("mov", before) == []
    assert rig.level("uo1") == 0  # the program is over
    assert rig.asks("F", "F", "V1") == ["E5", "R", "V9999990"]
    rig.run("+9")
    assert rig.asks("F", "V1") == ["R", "V9999999"]


@pytest.mark.fact("GSC-POS-6", "GSC-UND-E5")
def test_below_zero_there_is_the_same_overflow() -> None:
    rig = at(3)
    before = rig.bench.now_ps
    rig.run(*STR, "-4", "+5")
    assert rig.pulses(before) == []
    assert rig.asks("F", "V1") == ["E5", "V3"]
    rig.run(*STR, "-3")
    assert len(rig.pulses(before)) == 3
    assert rig.asks("F", "V1") == ["R", "V0"]


@pytest.mark.fact("GSC-UND-E5", "GSC-CON-E5-REPORT")
def test_an_overflow_is_reported_once_or_forgotten_by_the_next_run() -> None:
    rig = at(0)
    rig.run(*STR, "-1")
    assert rig.level("rdy") == 1
    assert rig.asks("V1", "V2", "Q", "P", "S10") == ["V0", "V70", "S10\rT100\rR10\r-1\rEND", "Y", "Y"]
    assert rig.ask("F") == "E5"
    rig.run(*STR, "-1")
    rig.run(*STR, "+1")
    assert rig.ask("F") == "R"


@pytest.mark.fact("GSC-POS-7", "GSC-UND-E5")
@pytest.mark.parametrize("start", [5, 500])
def test_an_endless_run_stops_dead_at_zero(start: int) -> None:
    rig = at(start, "mov", "dir", "uo1")
    before = rig.bench.now_ps
    rig.run(*STR, "G-", "A1")
    steps = rig.pulses(before)
    assert gaps(steps) == spacing(2 * start, 10, 100, 10)[: start - 1]  # no way down
    assert rig.falls("mov")[-1] == steps[-1] + 1_700_000
    assert rig.level("dir") == 0 and rig.level("uo1") == 0
    assert rig.asks("F", "F", "V1") == ["E5", "R", "V0"]
    rig.run(*STR, "G-")
    assert len(rig.pulses(before)) == start
    assert rig.ask("F") == "E5"


@pytest.mark.fact("GSC-POS-7", "GSC-UND-E5", "GSC-CON-TEN-MILLION")
def test_an_endless_run_stops_dead_at_the_upper_end() -> None:
    rig = at(TOP - 200)
    rig.run(*STR, "G+1")
    assert rig.asks("F", "V1") == ["E5", "V9999999"]


@pytest.mark.fact("GSC-POS-7", "GSC-UND-E5", "GSC-RAMP-7")
@pytest.mark.parametrize(("room", "end", "answer"), [(1, 0, "E5"), (50, 0, "E5"), (51, 0, "R"), (52, 1, "R")])
@pytest.mark.parametrize("stop", ["Z", "ui1"])
def test_the_stop_ramp_of_an_endless_run_ends_at_the_end_of_the_counter(
    stop: str, room: int, end: int, answer: str
) -> None:
    rig = at(500)
    rig.start("S10", "T100", "R50", "G-1")
    rig.bench.run_until(rig.x.reaches(room + 20))
    step = rig.pulses()[-1] + 20 * MS  # there are `room` steps behind this one
    if stop == "Z":
        rig.acts("Z", step + MS // 2)
    else:
        rig.drive("ui1", 0, at=step)
    rig.bench.run_until_idle()
    assert rig.x.position == end
    assert rig.ask("F") == answer
    rig.run(*STR, "G-")  # a run from the end of the counter is an overflow, however the one before ended
    assert rig.ask("F") == "E5"


# ------------------------------------------------------------------------------------------------- counter of a C200S
@pytest.mark.fact("GSC-POS-2")
def test_the_counter_of_a_c200s_has_24_bits() -> None:
    rig = base(C200S)
    assert rig.asks("f-8388608", "V1", "f+8388607", "V1") == ["Y", "V-8388608", "Y", "V+8388607"]
    assert rig.asks("f-8388609", "f+8388608", "V1") == ["E2", "E2", "V+8388607"]


@pytest.mark.fact("GSC-POS-3")
def test_past_its_upper_end_the_counter_of_a_c200s_wraps() -> None:
    rig = base(C200S, chs=1)
    assert rig.ask(f"f+{HIGH - 1}") == "Y"
    rig.run(*STR, "+5")
    assert len(rig.pulses()) == 5
    assert rig.x.steps().positions.tolist() == [HIGH, LOW, LOW + 1, LOW + 2, LOW + 3]
    assert rig.ask("F") == "R"
    assert rig.wire(b"V1\x17\r") == b"V-8388605y\r"
    assert rig.ask(f"f+{HIGH - 1}") == "Y"
    seen = []
    rig.prg(*STR, "+1")
    for _ in range(5):
        assert rig.ask("E") == "Y"
        rig.bench.run_until_idle()
        seen.append(rig.pos())
    assert seen == [8388607, -8388608, -8388607, -8388606, -8388605]


@pytest.mark.fact("GSC-POS-4")
def test_the_counter_of_a_c200s_wraps_downward_too() -> None:
    rig = base(C200S)
    assert rig.ask("f-8388607") == "Y"
    rig.run(*STR, "-3")
    assert rig.asks("F", "V1") == ["R", "V+8388606"]


@pytest.mark.fact("GSC-POS-12", "GSC-UND-WRAP-G")
@pytest.mark.parametrize(("start", "goal", "sign"), [(HIGH, LOW, -1), (LOW, HIGH, 1)])
def test_a_goto_across_the_wrap_point_takes_the_long_route(start: int, goal: int, sign: int) -> None:
    rig = base(C200S)
    assert rig.ask(f"f{start:+d}") == "Y"
    rig.start(*STR, f"G{goal:+d}")
    rig.bench.run_until(rig.x.reaches(start + sign * 100))
    assert rig.level("dir") == (sign > 0)
    assert rig.ask("K") == "Y"
    assert rig.pos() == start + sign * len(rig.pulses())


@pytest.mark.fact("GSC-POS-12", "GSC-UND-WRAP-G")
def test_the_long_route_is_travelled_completely() -> None:
    rig = base(C200S)
    assert rig.ask(f"f{HIGH:+d}") == "Y"
    rig.run(*FAST, f"G{LOW}", timeout="2000 s")
    assert rig.x.travel == LOW - HIGH
    assert rig.asks("F", "V1") == ["R", "V-8388608"]


@pytest.mark.fact("GSC-UND-E5")
def test_a_c200s_has_no_overflow() -> None:
    rig = base(C200S)
    assert rig.ask("f-8388600") == "Y"
    rig.start(*STR, "g-")
    rig.bench.run_until(rig.x.reaches(HIGH - 50))
    assert rig.ask("Z") == "Y"
    rig.bench.run_until_idle()
    assert rig.ask("F") == "R" and rig.codes == []


# ----------------------------------------------------------------------------------------------------------- counting
@both
@pytest.mark.fact("GSC-POS-8", "GSC-PIN-DIR-1")
def test_the_counter_counts_the_falling_edges_of_clock(part: str) -> None:
    rig = base(part, "clock", "dir")
    if part == C200:
        rig.run(*STR, "+100")
    start = rig.x.position
    rig.start(*STR, "+5", "-5", "+30", "-7", "+3000")
    rig.bench.run_until(rig.x.reaches(start + 800))
    assert rig.ask("K") == "Y"
    turns = [(0, 1), *rig.edges("dir")]
    ways = [next(level for time, level in reversed(turns) if time <= fall) for fall in rig.falls("clock")]
    assert rig.pos() == ways.count(1) - ways.count(0) == rig.x.position
    assert ways[start : start + 47] == [1] * 5 + [0] * 5 + [1] * 30 + [0] * 7
    # the edge itself is the moment
    fall = rig.falls("clock")[-1]
    assert rig.x.position_at(fall) - rig.x.position_at(fall - 1) == 1


@both
@pytest.mark.fact("GSC-POS-9")
def test_position_0_is_where_the_counter_was_cleared(part: str) -> None:
    zero = "V0" if part == C200 else "V+0"
    rig = base(part)
    for clear in ("I1", "I3"):
        rig.run(*STR, "+12")
        assert rig.asks(clear, "V1") == ["Y", zero]
        rig.run(*STR, "+33", "G0")
        assert rig.x.steps().directions.tolist()[-66:] == [1] * 33 + [-1] * 33
        assert rig.ask("V1") == zero
    rig.run(*STR, "+12")
    assert rig.asks("I2", "V1")[-1][-2:] == "12"


@both
@pytest.mark.fact("GSC-POS-10", "GSC-UND-POWERUP")
def test_the_counter_is_0_after_power_up(part: str) -> None:
    zero = "V0" if part == C200 else "V+0"
    rig = base(part)
    assert rig.ask("V1") == zero
    rig.run(*STR, "+12")
    rig.x.power(False)
    rig.bench.run("1 s")
    rig.x.power(True)
    assert rig.ask("V1") == zero


@pytest.mark.fact("GSC-POS-11", "GSC-CON-SINGLE-MOVE")
def test_a_goto_of_a_c200s_may_be_longer_than_a_signed_move() -> None:
    rig = base(C200S)
    assert rig.ask("f-1000000") == "Y"
    rig.run(*FAST, "G+0", timeout="200 s")
    assert len(rig.x.steps()) == 1_000_000 and rig.pos() == 0
    rig.prg()
    assert rig.asks("+1000000", "-1000000", "+999999", "-999999") == ["E2", "E2", "Y", "Y"]


@pytest.mark.fact("GSC-POS-11", "GSC-CON-SINGLE-MOVE")
def test_a_goto_of_a_c200_may_be_longer_than_a_signed_move() -> None:
    rig = base(C200)
    rig.run(*FAST, "G1000000", timeout="200 s")
    assert len(rig.x.steps()) == 1_000_000 and rig.pos() == 1_000_000
    rig.prg()
    assert rig.asks("+1000000", "-1000000", "+999999", "-999999") == ["E2", "E2", "Y", "Y"]


@both
@pytest.mark.fact("GSC-POS-13")
def test_coming_and_going_leads_back_to_the_same_step(part: str) -> None:
    rig = base(part)
    rig.run(*STR, "L0", "+123", "-123", "L200")
    directions = rig.x.steps().directions
    assert ((directions > 0).sum(), (directions < 0).sum()) == (24_600, 24_600)
    assert rig.x.position == 0 and rig.x.steps().positions.max() == 123


@both
@pytest.mark.fact("GSC-POS-8")
def test_a_goto_to_the_position_of_the_motor_takes_no_step(part: str) -> None:
    rig = base(part, "mov", "uo1")
    rig.run(*STR, "+7", "G7", "A1")
    assert len(rig.pulses()) == 7 and len(rig.rises("mov")) == 1
    assert rig.rises("uo1") == [rig.pulses()[-1] + 12 * MS]
