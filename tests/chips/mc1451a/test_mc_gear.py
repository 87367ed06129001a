"""Electronic gear of the MC1451A family: an axis follows its own encoder.

Counts that have come by the start of a cycle move the axis in the cycle behind it.
"""

from __future__ import annotations

from itertools import accumulate

import pytest
from mc import ENCODERS, ONE, SEVERAL, T1, with_encoder
from mc_motion import Mover, mover, without_encoder

GEAR = "SET_PRFL_GEAR"


def geared(ratio: int, *more: str, part: str = "mc1151a-e", record: tuple[str, ...] = ()) -> tuple[Mover, int]:
    """An axis in gear; returns a cycle that begins now."""
    rig = mover(part, *record)
    return rig, rig.begin(GEAR, f"SET_RATIO {ratio}", *more)


def following(ratio: int = ONE, record: tuple[str, ...] = ()) -> tuple[Mover, int]:
    """An axis that follows a count per cycle, for a hundred cycles; ten of them are over."""
    rig, _ = geared(ratio, record=record)
    rig.turn(100, apart=8192)
    return rig, rig.next(10)


def moved(rig: Mover, cycles: int) -> list[int]:
    """Displacements of some cycles."""
    return [look.vel for look in rig.trace(cycles)]


# ------------------------------------------------------------------------------------------------------------ following
@with_encoder
@pytest.mark.fact("PMD-GEAR-1", "PMD-UND-MC-GEAR")
def test_the_last_of_the_axes_follows_its_encoder_step_for_count(part: str) -> None:
    rig = mover(part)
    axis = len(rig.x.axes)
    rig.do(f"SET_{axis}")
    begun = rig.begin(GEAR, f"SET_RATIO {ONE}")
    rig.turn(1000, apart=1024, axis=axis)  # 8 in a cycle
    rig.to(begun + 125 + 2)
    assert rig.counts(begun, axis) == [0] * 2 + [8] * 125 + [0]  # all made 2 cycles behind the one of the last count
    assert rig.moves(axis=axis) == [1000] and rig.shows("trgt_pos", axis) == 1000 == rig.shows("actl_pos", axis)
    assert rig.shows("status", axis) & 0xFFF == 0x300


@pytest.mark.fact("PMD-GEAR-1")
def test_the_steps_of_a_cycle_are_evenly_spaced() -> None:
    rig, now = geared(ONE)
    rig.turn(4, apart=100)
    assert moved(rig, 4) == [0, 0, 4 * ONE, 0]
    assert rig.ticks(now + 2) == [2048, 4096, 6144, 8192]


@pytest.mark.fact("PMD-GEAR-2", "PMD-GEAR-3", "PMD-GEAR-4", "PMD-CON-GEAR-TWICE")
@pytest.mark.parametrize(
    ("ratio", "counts", "target", "steps"),
    [
        (0x8000, 1000, 500, 500),
        (0x8000, -1000, -500, -500),
        (-0x20000, 100, -200, -200),
        (98_304, 200, 300, 300),
        (-746_455, 100, -1139, -1138),  # 1138.99
    ],
)
def test_steps_are_counts_times_the_ratio(ratio: int, counts: int, target: int, steps: int) -> None:
    rig, _ = geared(ratio, record=("dir1",))
    per_cycle = 8 if abs(ratio) <= 2 * ONE else 1
    rig.turn(counts, apart=8192 // per_cycle)
    rig.next(abs(counts) // per_cycle + 3)
    assert rig.shows("actl_pos") == counts and rig.shows("trgt_pos") == target
    assert rig.moves() == [steps] and rig.level("dir1") == (steps > 0)
    rig.turn(-counts, apart=8192 // per_cycle)
    rig.next(abs(counts) // per_cycle + 3)
    assert rig.moves() == [steps, -steps] and rig.shows("trgt_pos") == 0


@pytest.mark.fact("PMD-GEAR-5")
def test_fractions_of_a_step_are_kept() -> None:
    rig = mover("mc1151a-e", quadrature={})
    rig.begin(GEAR, "SET_RATIO 0x5555", "SET_OUTPUT_HIGH")
    shaft = rig.shafts["quadrature"]
    for rate, counts in ((1_000_000, 300_000), (-1_000_000, 0)):
        shaft.run(rate)
        rig.bench.run("300 ms")
        shaft.run(0)
        rig.next(4)
        assert rig.shows("actl_pos") == counts and rig.shows("trgt_pos") == counts * 0x5555 // ONE
    assert rig.moves() == [99_998, -99_998] and not rig.codes


@pytest.mark.fact("PMD-GEAR-6")
@pytest.mark.parametrize("part", [part for part in ENCODERS if part in SEVERAL])
def test_an_axis_follows_no_encoder_but_its_own(part: str) -> None:
    rig = mover(part)
    for axis in range(1, len(rig.x.axes) + 1):
        rig.begin(f"SET_{axis}", *(() if axis == 1 else (GEAR, f"SET_RATIO {ONE}")))
    rig.turn(40)
    rig.next(10)
    assert rig.shows("actl_pos", 1) == 40
    for axis in range(1, len(rig.x.axes) + 1):
        assert not rig.moves(axis=axis) and rig.shows("trgt_pos", axis) == 0
    rig.turn(40, axis=2)
    rig.next(10)
    assert rig.moves(axis=2) == [40] and not rig.moves(axis=1)


@pytest.mark.fact("PMD-GEAR-7", "PMD-ERRC-20")
def test_the_ratio_changes_with_an_update_and_no_step_is_lost() -> None:
    rig, now = following()
    rig.heeds(now + 5, "SET_RATIO 0x20000", "UPDATE")
    rig.to(now + 200)
    assert rig.counts(now - 10)[:104] == [0, 0, *[1] * 13, *[2] * 87, 0, 0]
    assert rig.shows("status") & 0x80 == 0 and rig.shows("actl_pos") == 100


@pytest.mark.fact("PMD-GEAR-8", "PMD-UND-MODE-SWITCH")
def test_a_trapezoid_put_in_gear_stops_with_its_encoder() -> None:
    rig = mover("mc1151a-e")
    begun = rig.begin(*T1)
    rig.heeds(begun + 500, GEAR)
    assert rig.look() == (468, 0, 0x300, 0) and not rig.codes
    rig.next(100)
    assert rig.moves() == [468] and rig.lows("atrest1") == [(begun, 500)]


@pytest.mark.fact("PMD-GEAR-9", "PMD-UND-GEAR-ENTRY")
def test_counts_from_before_the_gear_move_nothing() -> None:
    rig = mover("mc1151a-e", quadrature={})
    rig.shafts["quadrature"].run(500_000)
    rig.bench.run("10 ms")
    rig.shafts["quadrature"].run(0)
    rig.begin(f"SET_RATIO {ONE}")
    rig.do(GEAR)
    rig.next(100)
    assert rig.shows("actl_pos") == 5000 and rig.shows("trgt_pos") == 0 and not rig.ticks()
    rig.shafts["quadrature"].push(3)
    rig.next(4)
    assert rig.moves() == [3] and rig.shows("trgt_pos") == 3


@pytest.mark.fact("PMD-GEAR-10", "PMD-UND-SMOOTH-GEAR")
def test_a_smooth_stop_does_not_affect_the_gear_and_is_forgotten() -> None:
    rig, now = following()
    rig.heeds(now + 5, "SMOOTH_STOP", "UPDATE")
    assert moved(rig, 5) == [ONE] * 5
    begun = rig.begin("SET_PRFL_TRAP", "SET_VEL 0x10000", "SET_ACC 0x10000", "SET_POS 0")
    rig.rest()
    assert rig.shows("trgt_pos") == 0 and rig.moves(begun)[0] < 0


@pytest.mark.fact(
    "PMD-GEAR-10", "PMD-STOP-2", "PMD-UND-STOP-GEAR", "PMD-UND-MC-GEAR", "PMD-CON-MC-GEAR", "PMD-UND-STOP-RESUME"
)
def test_a_stop_suspends_the_gear_until_the_next_update() -> None:
    rig, now = following()
    rig.heeds(now + 5, "STOP", "UPDATE")
    place = rig.look().pos
    assert set(moved(rig, 20)) == {0} and rig.look() == (place, 0, 0x300, 0)  # motion is not complete
    rig.heeds(now + 40, "UPDATE")
    assert moved(rig, 10) == [0] + [ONE] * 9  # those from before are lost
    assert rig.look().pos == place + 9 and rig.shows("actl_pos") > place + 30


@pytest.mark.fact("PMD-GEAR-12")
def test_the_start_velocity_has_no_part_in_it() -> None:
    rig, _ = geared(ONE, "SET_START_VEL 0x8000")
    rig.turn(10, apart=81_920)
    assert moved(rig, 105)[2:] == ([ONE] + [0] * 9) * 10 + [0] * 3
    assert rig.moves() == [10]


@pytest.mark.fact("PMD-CMD-SET_POS-3")
def test_a_destination_does_not_affect_it() -> None:
    rig, now = following()
    rig.heeds(now + 5, "SET_POS 1000", "SET_VEL 0x10000", "SET_ACC 0x400", "UPDATE")
    assert moved(rig, 50) == [ONE] * 50


# ----------------------------------------------------------------------------------------------------- beyond the range
@pytest.mark.fact("PMD-UND-GEAR-BACKLOG")
@pytest.mark.parametrize("way", [1, -1])
def test_steps_beyond_the_pulse_range_follow_later(way: int) -> None:
    rig, _ = geared(ONE)
    rig.turn(100 * way, apart=50)  # 2 us
    assert moved(rig, 10) == [0, 0, *[16 * way * ONE] * 6, 4 * way * ONE, 0]
    assert rig.moves() == [100 * way] and rig.codes == ["gear-backlog"]


@pytest.mark.fact("PMD-UND-GEAR-BACKLOG", "PMD-UND-GEAR-ENTRY")
def test_steps_that_wait_are_lost_with_another_mode() -> None:
    rig, now = geared(ONE)
    rig.turn(100, apart=50)
    rig.heeds(now + 4, "SET_PRFL_VEL")
    rig.do(GEAR)
    rig.next(20)
    assert rig.moves() == [32]


@pytest.mark.fact("PMD-UND-GEAR-BACKLOG")
def test_the_high_range_carries_what_the_standard_one_does_not() -> None:
    rig, _ = geared(ONE, "SET_OUTPUT_HIGH")
    rig.turn(100, apart=50)
    assert moved(rig, 4) == [0, 0, 100 * ONE, 0] and not rig.codes


# --------------------------------------------------------------------------------------------------- what it looks like
@pytest.mark.fact("PMD-UND-ATREST-GEAR", "PMD-UND-MC-GEAR")
def test_at_rest_is_low_in_cycles_with_a_step() -> None:
    rig, now = geared(0x6000)  # steps in 8 of 21 cycles
    rig.turn(21, apart=8192)
    looks = rig.trace(30)
    target = [look.pos for look in looks]
    with_step = [now + n for n in range(29) if target[n + 1] > target[n]]
    assert [cycle for cycle, length in rig.lows("atrest1") for cycle in range(cycle, cycle + length)] == with_step
    assert target[-1] == 21 * 3 // 8 and {look.status for look in looks} == {0x300}


@pytest.mark.fact("PMD-UND-GEAR-ERROR")
def test_a_stall_is_detected_in_gear() -> None:
    rig, _ = geared(2 * ONE, "SET_STEP_RATIO 256", "SET_POS_ERR 10")
    rig.turn(20, apart=8192)
    looks = rig.trace(30)
    targets = list(accumulate([0] * 2 + [2] * 20, initial=0))
    errors = [min(n, 20) - target for n, target in enumerate(targets)]  # a count in every cycle
    assert [bool(look.status & 16) for look in looks[:20]] == [
        any(abs(error) > 10 for error in errors[: n + 1]) for n in range(20)
    ]


@without_encoder
@pytest.mark.fact("PMD-GEAR-11", "PMD-CON-GEAR-PARTS")
def test_without_an_encoder_the_mode_is_accepted_and_the_axis_does_not_move(part: str) -> None:
    rig = mover(part)
    begun = rig.begin(*T1, f"SET_RATIO {ONE}")
    rig.to(begun + 500)
    rig.says("0c > 000c", "48 > 1800 1848")
    rig.next(100)
    assert rig.x.position == 469 and rig.shows("status") == 0x300
    rig.begin()
    rig.next(100)
    assert rig.x.position == 469 and rig.shows("status") == 0x300
