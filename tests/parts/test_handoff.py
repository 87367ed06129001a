"""Two arms hand a part over (s.10): both run the same program, and meet again at every hand-off."""

from __future__ import annotations

from itertools import pairwise

import pytest

import slewline

PROGRAM = (
    "A 0\rR 120\rS 25\rF 5\rZ 1\rP 14\rE\rU\rP 0\r+\rC\rD 90\rP 14\rD 90\rP 108\r-\rP 122\rB\rD 90\rP 108\rD 90\r"
    "R 20\rP 0\rP 14\rR 120\rT 0\r0\rQX\r"
)
CYCLE = [0, 14, 108, 122, 108, 0, 14]
US, MS = 10**6, 10**9
INSTRUCTION, LEAD = 40 * US, 10 * US  # DIRECTION is set so long before the first step


class Arms:
    """A giving arm and a taking arm; the arrival signal is DIRECTION or programmable output of the giver (both low)."""

    def __init__(self, program=PROGRAM, cycles=1, **options):
        self.bench = slewline.Bench(shuffle=options.pop("shuffle", None))
        self.giver = self.bench.add("cy525", name="giver", **options)
        self.taker = self.bench.add("cy525", name="taker", **options)
        self.bench.part("or", "arrived")
        self.bench.wire("giver.direction", "arrived.in1")
        self.bench.wire("giver.programmable_output", "arrived.in2")
        self.bench.wire("arrived.out", "taker.wait")
        pins = ("pulse", "motion_complete", "direction", "programmable_output", "run")
        self.bench.record("arrived.out", *(f"{arm}.{pin}" for arm in ("giver", "taker") for pin in pins))
        self.giver.pin("wait").drive(1)
        self.rates = {}  # rate register at the end of each motion
        for arm in (self.giver, self.taker):
            arm.pin("dowhile").drive(0 if cycles > 1 else 1)
            self.bench.host(arm).send(program)
            rates = self.rates.setdefault(arm.name, [])
            arm.pin("motion_complete").net.watch(
                lambda net, arm=arm, rates=rates: rates.append(arm.registers["rate"]) if net.level == 0 else None
            )
        self.bench.run("200 ms")
        for cycle in range(cycles):
            self.giver.pin("wait").pulse(0, "1 ms")
            self.bench.run("400 ms")
            if cycle == cycles - 1:
                for arm in (self.giver, self.taker):
                    arm.pin("dowhile").drive(1)
            self.bench.run("1600 ms")

    def edges(self, pin, level):
        times, levels = self.bench.edges(pin)
        return times[levels == level].tolist()

    def targets(self, arm):
        return [arm.position_at(t) for t in self.edges(f"{arm.name}.motion_complete", 0)]

    def moves(self, arm):
        """(first PULSE fall, end, target) of every motion."""
        falls, ends = self.edges(f"{arm.name}.pulse", 0), self.edges(f"{arm.name}.motion_complete", 0)
        found = []
        for begin, end in pairwise([0, *ends]):
            found.append((next(t for t in falls if t > begin), end, arm.position_at(end)))
        return found


@pytest.fixture(scope="module")
def arms():
    return Arms()


@pytest.mark.fact("EXAMPLE-HANDOFF-1")
def test_each_arm_goes_through_its_targets_once_a_part(arms):
    assert arms.targets(arms.giver) == [14, *CYCLE]
    assert arms.targets(arms.taker) == [14, *CYCLE]
    assert len(arms.giver.program) == 45
    assert [found.code for found in arms.bench.findings] == []


@pytest.mark.fact("EXAMPLE-HANDOFF-1")
def test_the_arms_pause_for_90_ms_at_the_four_delays(arms):
    moves = arms.moves(arms.giver)
    pauses = [after[0] - before[1] for before, after in pairwise(moves)][1:]
    assert [pause // (90 * MS) for pause in pauses] == [1, 1, 0, 1, 1, 0]  # behind 0, 14, 108, 122, 108, 0
    for pause in pauses:
        assert pause % (90 * MS) < MS  # a few instructions


@pytest.mark.fact("EXAMPLE-HANDOFF-1")
def test_only_the_empty_return_has_the_slow_rate(arms):
    assert arms.rates["giver"] == arms.rates["taker"] == [120, 120, 120, 120, 120, 120, 20, 20]
    assert arms.giver.registers["rate"] == 120


@pytest.mark.fact("EXAMPLE-HANDOFF-1")
def test_the_part_is_gripped_from_the_taking_to_the_giving(arms):
    moves = arms.moves(arms.giver)
    (taken,), given = arms.edges("giver.programmable_output", 0), arms.edges("giver.programmable_output", 1)
    assert moves[1][1] < taken < moves[2][0]  # after P 0, before P 14
    assert moves[4][1] < given[0] < moves[5][0]  # after P 122, before P 108


@pytest.mark.fact("EXAMPLE-HANDOFF-2", "DER-HANDOFF-WINDOW")
def test_the_arrival_is_reported_once_a_cycle_for_one_instruction(arms):
    (told,), (over,) = arms.edges("arrived.out", 0), arms.edges("arrived.out", 1)
    before, after = arms.moves(arms.giver)[3:5]
    assert (before[2], after[2]) == (108, 122)
    assert before[1] < told
    assert (over, after[0]) == (told + INSTRUCTION - LEAD, told + INSTRUCTION)
    assert arms.giver.position_at(told) == 108


@pytest.mark.fact("EXAMPLE-HANDOFF-3", "DER-HANDOFF-WINDOW")
def test_both_arms_begin_their_move_together(arms):
    giving, taking = arms.moves(arms.giver)[4], arms.moves(arms.taker)[1]
    assert (giving[2], taking[2]) == (122, 0)
    assert abs(giving[0] - taking[0]) < 200 * US
    assert giving[0] == arms.edges("arrived.out", 1)[0] + LEAD  # P 122 turns the direction round just before
    assert 0 <= taking[0] - giving[0] <= 8 * US  # a poll later
    assert abs(giving[1] - taking[1]) < 200 * US


@pytest.mark.fact("EXAMPLE-HANDOFF-2", "EXAMPLE-HANDOFF-1")
def test_the_arms_meet_again_for_the_second_part():
    arms = Arms(cycles=2)
    assert arms.targets(arms.giver) == [14, *CYCLE, *CYCLE]
    assert arms.targets(arms.taker) == [14, *CYCLE, *CYCLE]
    assert len(arms.edges("arrived.out", 0)) == 2
    giving = [move for move in arms.moves(arms.giver) if move[2] == 122]
    taking = [move for n, move in enumerate(arms.moves(arms.taker)) if n % 7 == 1]
    assert all(abs(one[0] - two[0]) < 200 * US for one, two in zip(giving, taking, strict=True))
    assert arms.giver.pin("run").level == arms.taker.pin("run").level == 1


def test_with_c_before_plus_a_false_arrival_would_be_reported():
    arms = Arms(PROGRAM.replace("+\rC\r", "C\r+\r"))
    assert len(arms.edges("arrived.out", 0)) == 2
    assert arms.giver.position_at(arms.edges("arrived.out", 0)[0]) == 0


@pytest.mark.parametrize("options", [{"stepwise": True}, {"shuffle": 5}])
def test_the_hand_off_is_the_same_in_slow_motion_and_with_ties_shuffled(arms, options):
    other = Arms(**options)
    assert other.moves(other.taker) == arms.moves(arms.taker)
    assert other.edges("arrived.out", 0) == arms.edges("arrived.out", 0)
