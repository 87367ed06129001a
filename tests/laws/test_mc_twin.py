"""An MC1451A leaves the same edges, words and findings cycle by cycle as in blocks of them, whatever happens when."""

from __future__ import annotations

from random import Random

import pytest

import slewline
from slewline.core.motion.motions import MotionEnd
from tests.ensembles import few

from . import mc_dialogues
from .mc_dialogues import CYCLE, HIGHEST, ONE, READY, Dialogue, Event, Maker, play
from .twins import agree, compared, hashes_are_free, ties_are_free

BLOCKS = 20  # of the hundred thousand: they go to all processors, and each takes minutes
KINDS = {  # dialogues with each, of the hundred thousand
    "tie": 80_000,
    "limit": 40_000,
    "home": 30_000,
    "encoder": 30_000,
    "quadrature": 5_000,
    "cut": 8_000,
    "RESET": 4_000,
    "SET_ACTL_POS": 20_000,
    "SET_PRFL_GEAR": 20_000,
    "SMOOTH_STOP": 15_000,
    "SYNCH_PRFL": 12_000,
    "MTR_OFF": 8_000,
}


@pytest.mark.parametrize("block", few(range(10), 2))
def test_fast_path_and_twin_agree(block: int) -> None:
    agree(mc_dialogues, range(block * 10, block * 10 + 10))


@pytest.mark.parametrize("block", few(range(4), 1))
def test_shuffled_ties_change_nothing(block: int) -> None:
    ties_are_free(mc_dialogues, range(1000 + block * 5, 1000 + block * 5 + 5))


def long_move(seed: int) -> Dialogue:
    """A move of some thousand cycles, with an update on the way, which may change something."""
    rnd = Random(seed)
    dialogue = Dialogue(seed, "mc1151a", 25_000_000)
    maker = Maker(dialogue, rnd)
    maker.send("SET_OUTPUT_HIGH")
    velocity = rnd.choice((ONE // 3, ONE, 7 * ONE + 5, 16 * ONE, rnd.randrange(1, HIGHEST)))
    ramp = max(velocity // rnd.randrange(50, 1000), 1)
    maker.send("SET_VEL", velocity)
    maker.send("SET_ACC", ramp)
    maker.send("SET_MAX_ACC", min(ramp, 32767))
    maker.send("SET_JERK", (min(ramp, 32767) << 16) // rnd.randrange(1, 300))
    maker.send("SET_START_VEL", rnd.choice((0, velocity // 10)))
    maker.send("SET_POS", rnd.choice((1, -1)) * rnd.randrange(1, 3000 * velocity // ONE + 2))
    if rnd.random() < 0.5:
        maker.send("SET_PRFL_S_CRV")
    maker.send("UPDATE", None, maker.free + rnd.randrange(5 * CYCLE))
    maker.send("SET_POS", rnd.choice((1, -1)) * rnd.randrange(1, 3000 * velocity // ONE + 2))
    maker.send("SET_VEL", rnd.choice((velocity, velocity, velocity // 2, velocity * 3 // 2)))
    maker.send("UPDATE", None, maker.free + rnd.randrange(2000 * CYCLE))
    dialogue.cycles = maker.free // CYCLE + 4000
    return dialogue


def test_long_moves_agree() -> None:
    for seed in range(2):
        compared(mc_dialogues, long_move(seed))


def test_a_stall_ends_a_gear_without_steps_in_the_next_cycle() -> None:
    dialogue = Dialogue(0, "mc1151a-e", 25_000_000, cycles=60)
    for count in range(8):  # with a ratio of 0 in the gear they make no step, but are eight counts of error
        pin, level = "ab"[count % 2], int(count % 4 < 2)
        dialogue.events.append(Event(READY + 40 * count, f"quad{pin}1", level))
    maker = Maker(dialogue, Random(0))
    for name, value in (("SET_STEP_RATIO", 256), ("SET_AUTO_STOP_ON", None), ("SET_PRFL_GEAR", None)):
        maker.send(name, value)
    maker.send("SET_POS_ERR", 3, act=41 * CYCLE)
    compared(mc_dialogues, dialogue)
    ends = [said[-1] for said in play(dialogue).heard if isinstance(said[-1], MotionEnd)]
    assert [(end.why, end.steps) for end in ends] == [("cut", 0)]
    assert ends[0].time_ps // (CYCLE * 40_000) == 43  # the limit is new in 42, the motor off in 43


def test_a_position_declared_as_the_supply_goes_is_declared() -> None:
    dialogue = Dialogue(0, "mc1151a-e", 25_000_000, cycles=60)
    maker = Maker(dialogue, Random(0))
    for name, value in (("SET_VEL", ONE), ("SET_ACC", ONE), ("SET_POS", 5), ("UPDATE", None)):
        maker.send(name, value)
    maker.free += 10 * CYCLE
    maker.send("SYNCH_PRFL")  # to the encoder, which has not moved
    maker.send("UPDATE", act=49 * CYCLE + 1)
    dialogue.events.append(Event(50 * CYCLE, "power", 0))
    for shuffle in range(6):
        compared(mc_dialogues, dialogue, shuffle)
        ends = [said[-1] for said in play(dialogue, shuffle=shuffle).heard if isinstance(said[-1], MotionEnd)]
        assert [(end.why, end.position) for end in ends] == [("done", 5), ("cut", 0)]


@pytest.mark.parametrize(("kind", "value", "end"), [("ACTL_NEG", -1, (1 << 30) - 4), ("ACTL_POS", 1, 4 - (1 << 30))])
def test_an_actual_position_meets_its_breakpoint_by_going_round_the_end_of_the_range(
    kind: str, value: int, end: int
) -> None:
    there = f"SET_ACTL_POS {end}\nSET_BRK_PNT {value}\nSET_{kind}_BRK"
    away = f"SET_PRFL_VEL\nSET_VEL 5000\nSET_ACC {5000 if end > 0 else -5000}\nUPDATE"
    statuses = []
    for stepwise in (False, True):
        bench = slewline.Bench()
        chip = bench.add("mc1151a-e", name="x", stepwise=stepwise)
        bench.part("encoder", to=chip, counts=4, steps=1)
        bench.host(chip).send(f"{there}\n{away}")
        bench.run("15 ms")
        statuses.append((chip.registers["status"], chip.registers["actl_pos"]))
    assert statuses[0] == statuses[1]
    assert statuses[0][0] & 4 and (statuses[0][1] < 0) is (end > 0)


@pytest.mark.long
def test_hash_seeds_change_nothing() -> None:
    hashes_are_free(mc_dialogues, 20_000, 20_010)


def test_the_port_is_ready_when_the_dialogues_reckon_with_it() -> None:
    dialogue = Dialogue(0, "mc1151a", 25_000_000, cycles=20)
    maker = Maker(dialogue, Random(0))
    for name in ("SET_VEL", "UPDATE", "GET_TRGT_POS"):
        maker.send(name, 1)
    played = play(dialogue)
    assert not played.chip.findings
    assert played.traces()["hostrdy"][0][0] == 40_000 * (READY + 25)
    assert played.chip._port.ready and len(played.read) % 2 == 0


@pytest.mark.long
@pytest.mark.timeout(3000)
@pytest.mark.parametrize("block", range(BLOCKS))
def test_a_hundred_thousand_dialogues_agree(block: int) -> None:
    """A twentieth of them, which reaches a twentieth of everything."""
    number = 100_000 // BLOCKS
    counted = agree(mc_dialogues, range(100_000 + block * number, 100_000 + (block + 1) * number))
    assert all(counted[kind] * BLOCKS >= wanted for kind, wanted in KINDS.items()), counted


@pytest.mark.long
@pytest.mark.timeout(3000)
@pytest.mark.parametrize("block", range(10))
def test_three_hundred_long_moves_agree(block: int) -> None:
    for seed in range(100 + block * 30, 130 + block * 30):
        compared(mc_dialogues, long_move(seed))
