"""The first example of the data sheet, and what it says of the room that the second one takes."""

from __future__ import annotations

import pytest
from gsc import C200, C200S, MS, PARTS, base, both, gaps, spacing

BAR = (
    "S10", "T100", "R40", "W1", "+250", "L0", "A2", "D1", "C2", "W2", "+120", "L4", "A2", "C2", "W2", "+250", "A1",
    "D5", "C1",
)  # fmt: skip
DRILL = ("S15", "T200", "R25", "W1", "W2", "A2", "+150", "D1", "G0", "C2", "A1", "D1", "C1")
SPEEDS = ("S10", "T100", "R50")


@pytest.mark.fact("GSC-EXAMPLE-1", "GSC-UND-RAMP-LAW")
def test_the_first_example_is_a_move_to_500000() -> None:
    rig = base(C200, "dir", chs=1)
    dialogue = [
        (b"FV\r", b"RR\r"),
        *((line, b"YY\r") for line in (b"I3|\r", b"PP\r", b"S104\r", b"T100u\r", b"R507\r", b"G500000|\r", b"EU\r")),
    ]
    for line, answer in dialogue:
        assert rig.wire(line) == answer
    rig.bench.run_until_idle("600 s")
    steps = rig.x.steps()
    assert len(steps) == 500_000 and set(steps.directions.tolist()) == {1}
    intervals = spacing(500_000, 10, 100, 50)
    assert steps.times_ps[-1] - steps.times_ps[0] == sum(intervals[:-1])
    assert round(sum(intervals) / 10**12, 3) == 500.101
    assert rig.wire(b"V1\x17\r") == b"V500000{\r"


@both
@pytest.mark.fact("GSC-EXAMPLE-2")
def test_a_signed_move_from_0_is_the_same_as_the_goto(part: str) -> None:
    times = []
    for move in ("+500000", "G500000" if part == C200 else "G+500000"):
        rig = base(part)
        rig.run(*SPEEDS, move)
        steps = rig.x.steps().times_ps
        times.append((steps - steps[0]).tolist())
        assert rig.pos() == 500_000
    assert times[0] == times[1]


@both
@pytest.mark.fact("GSC-EXAMPLE-3")
def test_m_before_e_saves_the_example(part: str) -> None:
    rig = base(part)
    rig.prg(*SPEEDS, "+500000")
    assert rig.asks("M", "E") == ["Y", "Y"]
    rig.bench.run("1 s")
    assert rig.ask("K") == "Y"
    rig.cycle()
    assert rig.ask("Q") == "END"
    assert rig.ask("X") == "Y"
    assert rig.ask("Q") == "S10\rT100\rR50\r+500000\rEND"


@pytest.mark.fact("GSC-EXAMPLE-4", "GSC-EXAMPLE-5")
@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize(("lines", "locations"), [(BAR, 50), (DRILL, 36), (BAR + DRILL, 86), (("U3", *BAR), 52)])
def test_the_programs_of_the_second_example_take_the_room_in_the_sheet(
    part: str, lines: tuple[str, ...], locations: int
) -> None:
    rig = base(part)
    assert rig.prg(*lines) == ["Y"] * len(lines)
    assert len(rig.x.program) == locations
    rest = (118 - locations) // 2
    assert rig.asks(*["A1"] * (rest + 1)) == ["Y"] * rest + ["E3"]
    assert len(rig.listed()) == len(lines) + rest


@both
@pytest.mark.fact("GSC-SPEED-5", "GSC-CON-T200")
def test_t200_of_the_drill_is_2000_steps_a_second(part: str) -> None:
    rig = base(part)
    rig.run(*DRILL)
    down = rig.pulses()[:150]
    assert len(rig.pulses()) == 300 and rig.x.position == 0
    assert min(gaps(down)) == MS // 2
    assert gaps(down) == spacing(150, 15, 200, 25)[:-1]


@pytest.mark.fact("GSC-EXAMPLE-1")
def test_any_monotonic_law_completes_the_example_in_time() -> None:
    for law in ("linear in steps", lambda start, top, ramp, k: start, lambda start, top, ramp, k: top):
        rig = base(C200S, options={"law": law})
        rig.run(*SPEEDS, "G+500000")
        steps = rig.x.steps().times_ps
        assert 500 * 10**12 <= steps[-1] - steps[0] <= 500.9 * 10**12
