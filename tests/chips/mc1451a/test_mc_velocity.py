"""Velocity contouring of the MC1451A family: up to a velocity at the commanded rate, and on until told otherwise.

V1 comes to a step per cycle in 64 cycles, each 1/64 faster than the last.
"""

from __future__ import annotations

import pytest
from mc import ONE, T1, V1, each
from mc_motion import Mover, mover

UNIT = ONE // 64
UP = list(range(UNIT, ONE + 1, UNIT))  # 64 cycles, 32.5 steps
DOWN = UP[-2::-1]  # 63 cycles, 31.5 steps
S = "SET_START_VEL 0x4000"


def running(*more: str, setup: tuple[str, ...] = V1, record: tuple[str, ...] = ()) -> tuple[Mover, int]:
    """An axis that moves at a step per cycle, 80 cycles behind its start; returns the cycle of the start."""
    rig = mover("mc1151a", *record)
    begun = rig.begin(*setup, *more)
    rig.to(begun + 80)
    return rig, begun


def velocities(rig: Mover, cycles: int) -> list[int]:
    return [look.vel for look in rig.trace(cycles)]


@each
@pytest.mark.fact("PMD-VEL-1", "PMD-VEL-2")
@pytest.mark.parametrize(("acceleration", "way"), [("0x400", 1), ("-0x400", -1)])
def test_it_speeds_up_to_its_velocity_in_the_direction_of_the_acceleration(
    part: str, acceleration: str, way: int
) -> None:
    rig = mover(part)
    axis = len(rig.x.axes)
    rig.do(f"SET_{axis}")
    rig.begin(*V1, f"SET_ACC {acceleration}")
    looks = rig.trace(100, axis)
    assert [look.vel for look in looks] == [way * speed for speed in (*UP, *[ONE] * 36)]
    assert [look.pos for look in looks[64:]] == [(way * (65 + 2 * n)) // 2 for n in range(36)]  # 32.5 steps on, and on
    assert {look.status & 0xFFF for look in looks} == {0x700}
    assert rig.level(f"dir{axis}") == (way > 0) and set(rig.x.axis(axis).steps().directions.tolist()) == {way}


@pytest.mark.fact("PMD-VEL-3")
def test_it_continues_for_ever() -> None:
    rig = mover("mc1151a")
    begun = rig.begin(*V1)
    rig.to(begun + 100_000)
    assert rig.look() == (100_000 - 64 + 32, ONE, 0x700, 0)
    assert rig.x.position == 100_000 - 64 + 32


@pytest.mark.fact("PMD-VEL-4", "PMD-ERRC-19")
def test_velocity_and_acceleration_change_on_the_fly() -> None:
    rig, begun = running()
    rig.heeds(begun + 100, "SET_VEL 0x20000", "SET_ACC 0x800", "UPDATE")
    assert velocities(rig, 40) == [*range(ONE + 0x800, 2 * ONE + 1, 0x800), *[2 * ONE] * 8]
    assert rig.status() == 0x700


@pytest.mark.fact("PMD-VEL-5", "PMD-UND-VEL-LOWER")
@pytest.mark.parametrize("acceleration", ["0x400", "0x1500"])
def test_a_lower_velocity_is_reached_by_braking_with_the_acceleration(acceleration: str) -> None:
    rig, begun = running()
    rig.heeds(begun + 100, "SET_VEL 0x8000", f"SET_ACC {acceleration}", "UPDATE")
    step = int(acceleration, 16)
    down = [max(ONE - n * step, ONE // 2) for n in range(1, 40)]
    assert velocities(rig, 39) == down
    assert rig.status() == 0x700


both_ways = pytest.mark.parametrize("way", [1, -1], ids=["forward", "backward"])


@both_ways
@pytest.mark.fact("PMD-VEL-6", "PMD-UND-VEL-REVERSE")
def test_the_other_sign_takes_it_through_zero(way: int) -> None:
    rig, begun = running(f"SET_ACC {UNIT * way}", record=("dir1",))
    rig.heeds(begun + 100, f"SET_ACC {-UNIT * way}", "UPDATE")
    looks = rig.trace(140)
    assert [way * look.vel for look in looks] == [*DOWN, 0, *(-speed for speed in UP), *[-ONE] * 12]
    assert {look.status for look in looks} == {0x700}
    assert rig.edges("dir1", rig.at(begun + 1)) == [(rig.at(begun + 100 + 64), int(way < 0))]
    assert rig.falls("atrest1", rig.at(begun)) == [rig.at(begun)] and not rig.rises("atrest1", rig.at(begun))


@both_ways
@pytest.mark.fact("PMD-UND-VEL-REVERSE")
def test_it_turns_round_at_its_start_velocity(way: int) -> None:
    rig, begun = running(S, f"SET_ACC {UNIT * way}")
    rig.heeds(begun + 100, f"SET_ACC {-UNIT * way}", "UPDATE")
    assert [way * speed for speed in velocities(rig, 52)] == [*DOWN[:48], 0, -0x4000, -0x4400, -0x4800]
    assert rig.status() == 0x700


@pytest.mark.fact("PMD-VEL-7", "PMD-UND-VEL-ZERO-ACC")
def test_without_acceleration_the_speed_stays() -> None:
    rig = mover("mc1151a")
    begun = rig.begin(*V1)
    rig.heeds(begun + 32, "SET_ACC 0", "UPDATE")
    assert velocities(rig, 100) == [ONE // 2] * 100
    rig.heeds(begun + 150, "SET_VEL 0x4000", "UPDATE")  # not even for a lower velocity
    assert velocities(rig, 10) == [ONE // 2] * 10


@pytest.mark.fact("PMD-UND-VEL-ZERO-ACC")
def test_without_acceleration_nothing_starts() -> None:
    rig = mover("mc1151a")
    rig.begin(*V1, "SET_ACC 0", S)
    rig.next(50)
    assert rig.look() == (0, 0, 0x300, 0) and not rig.ticks() and rig.codes == ["no-start"]


@pytest.mark.fact("PMD-VEL-8")
def test_it_starts_at_its_start_velocity() -> None:
    rig = mover("mc1151a")
    rig.begin(*V1, S)
    assert velocities(rig, 60) == [*UP[15:], *[ONE] * 11]


@pytest.mark.fact("PMD-VEL-9", "PMD-UND-VEL-ENTER")
def test_a_trapezoid_changes_to_velocity_contouring_without_a_stop() -> None:
    rig, begun = running(setup=T1)
    rig.heeds(begun + 100, "SET_VEL 0x20000", "SET_PRFL_VEL")  # a velocity that waits for its update
    assert {look.vel for look in rig.trace(1100)} == {ONE}
    assert rig.look() == (1200 - 64 + 32, ONE, 0x700, 0)
    rig.heeds(begun + 1205, "UPDATE")
    assert velocities(rig, 3) == [ONE + UNIT, ONE + 2 * UNIT, ONE + 3 * UNIT]


@pytest.mark.fact("PMD-UND-VEL-ENTER")
@pytest.mark.parametrize(("acceleration", "then"), [("0x400", UNIT), ("-0x400", -UNIT)])
def test_entered_during_deceleration_it_continues_from_the_present_speed(acceleration: str, then: int) -> None:
    rig = mover("mc1151a")
    begun = rig.begin(*V1[1:], f"SET_ACC {acceleration}", "SET_POS 64")
    rig.heeds(begun + 100, "SET_PRFL_VEL")  # 64 cycles up, 63 down
    assert velocities(rig, 3) == [DOWN[35] + n * then for n in (1, 2, 3)]


@pytest.mark.fact("PMD-VEL-10", "PMD-STAT-19")
def test_velocity_0_stops_with_the_acceleration_and_completes_the_motion() -> None:
    rig, begun = running()
    rig.heeds(begun + 100, "SET_VEL 0", "UPDATE")
    looks = rig.trace(70)
    assert [look.vel for look in looks] == [*DOWN, *[0] * 7]
    assert [look.status for look in looks] == [0x700] * 63 + [0x301] * 7
    assert looks[-1].pos == 32 + 36 + 32  # 32.5 + 36 + 31.5
    assert rig.lows("atrest1") == [(begun, 163)] and rig.status() == 0x301


@pytest.mark.fact("PMD-VEL-11", "PMD-UND-START-CHANGE", "PMD-CON-STARTVEL-MOTION")
def test_a_start_velocity_changed_in_motion_counts_from_the_next_start() -> None:
    rig, begun = running(S)
    rig.do("SET_START_VEL 0x8000")
    assert velocities(rig, 5) == [ONE] * 5
    rig.heeds(begun + 100, "SMOOTH_STOP", "UPDATE")
    assert velocities(rig, 50) == [*DOWN[:48], 0, 0]
    rig.begin()
    assert velocities(rig, 2) == [0x8000, 0x8400]


@pytest.mark.fact("PMD-CMD-SET_POS-3")
def test_a_destination_does_not_affect_it() -> None:
    rig, begun = running()
    rig.heeds(begun + 100, "SET_POS 0", "UPDATE")
    looks = rig.trace(100)
    assert [look[:2] for look in looks] == [(68 + n, ONE) for n in range(100)] and looks[-1].status == 0x700


# ------------------------------------------------------------------------------------------- the target, in whole steps
@pytest.mark.fact("PMD-CMD-GET_TRGT_POS-2", "PMD-UND-TRGT-ROUND")
@pytest.mark.parametrize("sign", ["", "-"])
def test_the_target_is_rounded_down(sign: str) -> None:
    rig = mover("mc1151a")
    rig.begin("SET_PRFL_VEL", "SET_VEL 0x4000", f"SET_ACC {sign}0x4000")
    rounded = [n // 4 for n in range(12)] if not sign else [-n // 4 for n in range(12)]
    assert [look.pos for look in rig.trace(12)] == rounded


@pytest.mark.fact("PMD-UND-TRGT-ROUND", "PMD-UND-PULSE-PHASE")
@pytest.mark.parametrize(("sign", "cycles", "target", "made"), [("", 10, 2, 2), ("-", 10, -3, -2), ("-", 12, -3, -3)])
def test_at_rest_at_a_fraction_after_a_stop_ramp_the_target_is_one_below_the_steps(sign, cycles, target, made) -> None:
    rig = mover("mc1151a")
    n = rig.begin("SET_PRFL_VEL", "SET_VEL 0x4000", f"SET_ACC {sign}0x4000")
    rig.heeds(n + cycles, "STOP", "UPDATE")
    rig.next(9)
    assert (rig.shows("trgt_pos"), rig.x.position) == (target, made)


@pytest.mark.fact("PMD-CMD-GET_TRGT_POS-2")
def test_target_reads_in_motion_belong_to_the_cycle_and_are_at_most_a_step_off_the_pulses() -> None:
    rig, begun = running()
    for cycle in range(begun + 90, begun + 130, 3):
        rig.to(cycle, 100 * (cycle % 50))
        assert rig.x.position - rig.shows("trgt_pos") in (0, 1)
        assert rig.do("GET_TRGT_POS") == 32 + cycle - begun - 64  # 32.5, cut off
