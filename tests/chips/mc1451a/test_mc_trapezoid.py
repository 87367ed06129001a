"""Trapezoids of the MC1451A family: their law, cycle by cycle, and what may be changed on the way.

Most moves here are made of 1/64 steps: a step per cycle at most, and 1/64 of that faster or slower each cycle.
"""

from __future__ import annotations

from math import ceil, sqrt
from random import Random

import pytest
from mc import ONE, T1, T1_CYCLES, T4, TRAPEZOID, each
from mc_motion import Mover, differences, mover, trapezoid

from tests.ensembles import few

UNIT = ONE // 64
UP = list(range(UNIT, ONE + 1, UNIT))  # 64 cycles, 32.5 steps
DOWN = UP[-2::-1]  # 63 cycles, 31.5 steps
T3 = (*T1, "SET_START_VEL 0x4000")


def ideal(distance: int, top: int, acceleration: int, start: int = 0) -> float:
    """How many cycles the continuous move lasts."""
    start = min(start, top)
    ramp = (top * top - start * start) / (2 * acceleration)
    if distance >= 2 * ramp:
        return 2 * (top - start) / acceleration + (distance - 2 * ramp) / top
    return 2 * (sqrt(start * start + acceleration * distance) - start) / acceleration


def command(distance: int, top: int, acceleration: int, start: int = 0) -> tuple[str, ...]:
    """The registers of a move."""
    return (
        f"SET_POS {distance}",
        f"SET_VEL {top}",
        f"SET_ACC {acceleration}",
        f"SET_START_VEL {start}",
    )


def coasting(*setup: str, part: str = "mc1151a", record: tuple[str, ...] = ()) -> tuple[Mover, int]:
    """The move T1, or another one, some cycles before it has gone on for 500; returns its first cycle."""
    rig = mover(part, *record)
    begun = rig.begin(*(setup or T1))
    rig.to(begun + 480)
    return rig, begun


# ------------------------------------------------------------------------------------------------------------ the moves
MOVES = {  # distance, V, a, s; the cycles that it takes
    "T1": (1000, ONE, 1024, 0, T1_CYCLES),
    "T2": (16, ONE, 1024, 0, 63),
    "T3": (1000, ONE, 1024, 16384, 1037),
    "T4": (-1000, ONE, 1024, 0, T1_CYCLES),
    "T5": (50_000, 265_107, 478, 0, 12_914),  # 12345 steps/s, 67890 steps/s^2
    "T6": (1, ONE, 1024, 0, 15),
    "T7": (100, ONE, ONE, 0, 100),
    "T8": (100_000, 16 * ONE, 3277, 0, 6569),
    "T9": (1_000_000, 512 * ONE, 131_072, 0, 2209),
    "T10": (10_000, 180_224, 11_469, 0, 3652),
    "T11": (2000, 131_072, 16_384, 256, 1008),
}


@pytest.mark.fact("PMD-TRAP-1", "PMD-TRAP-2", "PMD-TRAP-4")
@pytest.mark.parametrize("name", MOVES)
def test_a_move_ends_at_its_destination_in_due_time_and_is_never_faster_than_its_velocity(name: str) -> None:
    distance, top, acceleration, start, cycles = MOVES[name]
    rig = mover("mc1151a")
    if top > 16 * ONE:
        rig.do("SET_OUTPUT_HIGH")
    begun = rig.begin(*command(distance, top, acceleration, start))
    rig.rest()
    assert rig.lows("atrest1") == [(begun, cycles)]
    assert -2 <= cycles - ideal(abs(distance) * ONE, top, acceleration, start) <= 4
    assert rig.moves() == [distance] and rig.do("GET_TRGT_POS") == distance
    assert rig.do("GET_TRGT_VEL") == 0 and rig.status() == 0x301
    assert max(rig.counts(begun)) == -(-top // ONE) and not rig.codes


@pytest.mark.fact("PMD-TRAP-1", "PMD-TRAP-2", "PMD-TRAP-3", "PMD-TRAP-4", "PMD-UND-TRAP-ALGO")
@pytest.mark.parametrize("seed", few(range(4), 2))
def test_random_moves_follow_the_law_cycle_by_cycle(seed: int) -> None:
    rnd = Random(seed)
    rig = mover("mc1151a")
    place = 0
    for _ in range(50):
        top = rnd.choice((ONE, ONE // 3, rnd.randrange(ONE // 8, 4 * ONE), 16 * ONE))
        acceleration = rnd.randrange(top // 16, 2 * top)
        start = rnd.choice((0, 0, top // 4, 2 * top, acceleration // 60 + 1))
        distance = rnd.choice((1, -1)) * rnd.randrange(1, 20 * top // ONE + 3)
        place += distance
        begun = rig.begin(*command(place, top, acceleration, start))
        speeds, way = rig.speeds(), 1 if distance > 0 else -1
        assert speeds == [way * speed for speed in trapezoid(abs(distance) * ONE, top, acceleration, start)]
        assert sum(speeds) == distance * ONE and rig.moves(begun) == [distance]
        assert max(map(abs, speeds)) <= top
        jump = max(acceleration, min(start, top))
        assert abs(speeds[0]) <= jump and abs(speeds[-1]) <= jump
        assert all(abs(change) <= acceleration for change in differences(speeds[:-1]))
        crawl = ceil(min(acceleration, top - start) / start) if 0 < start < min(acceleration, top) else 0
        assert -2 <= len(speeds) - ideal(abs(distance) * ONE, top, acceleration, start) <= 4 + crawl
        assert rig.do("GET_TRGT_POS") == place and rig.do("GET_TRGT_VEL") == 0
    assert rig.x.position == place


@each
@pytest.mark.fact("PMD-TRAP-5")
def test_a_short_move_accelerates_and_decelerates_immediately_on_every_axis_of_every_part(part: str) -> None:
    rig = mover(part)
    for axis in range(1, len(rig.x.axes) + 1):
        rig.do(f"SET_{axis}")
        begun = rig.begin(*TRAPEZOID, "SET_POS 16")
        assert rig.speeds(axis) == [*UP[:32], *UP[30::-1]]  # 0.5 steps/cycle at most, and none of them twice
        assert rig.moves(begun, axis) == [16]


@pytest.mark.fact("PMD-TRAP-6")
@pytest.mark.parametrize("name", ["T1", "T5", "T10"])
def test_slowing_down_is_like_speeding_up(name: str) -> None:
    distance, top, acceleration, start, cycles = MOVES[name]
    rig = mover("mc1151a")
    rig.begin(*command(distance, top, acceleration, start))
    ramp = -(-top // acceleration) + 2
    first = [look.vel for look in rig.trace(ramp)]
    rig.to(rig.cycle + cycles - 2 * ramp)
    last = [look.vel for look in rig.trace(ramp)]
    rising = sum(change > 0 for change in differences([0, *first]))
    falling = sum(change < 0 for change in differences([*last, 0]))
    assert abs(rising - falling) <= 1
    assert abs(sum(first) - sum(last)) <= top + ONE


@pytest.mark.fact("PMD-TRAP-7", "PMD-UND-START-END")
def test_ramps_begin_and_end_at_the_start_velocity() -> None:
    rig = mover("mc1151a")
    rig.begin(*T3)
    speeds = rig.speeds()
    assert speeds[:49] == UP[15:] and speeds[49] == ONE
    assert speeds == trapezoid(1000 * ONE, ONE, UNIT, 0x4000) and len(speeds) == 1037
    assert speeds[0] == min(speeds) == speeds[-1] == 0x4000


@pytest.mark.fact("PMD-TRAP-8", "PMD-CMD-SET_VEL-3")
def test_a_move_back_is_the_mirror_image_of_a_move_forth() -> None:
    ticks, shown = [], []
    for move in (T1, T4):
        rig = mover("mc1151a", "dir1")
        begun = rig.begin(*move)
        rig.to(begun + 500)
        assert rig.packet(0x1E, reads=2) == ((0x0001, 0x0000, 0x001F) if move is T1 else (0xFFFF, 0x0000, 0x001D))
        rig.rest()
        ticks.append(rig.ticks(begun))
        shown.append((rig.lows("atrest1"), rig.level("dir1"), rig.moves()))
    assert ticks[0] == ticks[1]
    assert shown[0] == ([(begun, T1_CYCLES)], 1, [1000]) and shown[1] == ([(begun, T1_CYCLES)], 0, [-1000])


@pytest.mark.fact("PMD-TRAP-14")
def test_another_update_continues_from_the_end_of_the_last_move() -> None:
    rig = mover("mc1151a")
    rig.begin(*T1)
    rig.rest()
    back = rig.begin("SET_POS 0")
    rig.rest()
    assert rig.moves() == [1000, -1000] and rig.do("GET_TRGT_POS") == 0
    assert rig.lows("atrest1")[1] == (back, T1_CYCLES)


@pytest.mark.fact("PMD-TRAP-15")
def test_an_acceleration_of_the_velocity_gives_full_speed_immediately() -> None:
    rig = mover("mc1151a")
    begun = rig.begin(*command(100, ONE, ONE))
    assert rig.speeds() == [ONE] * 100
    assert rig.ticks(begun) == [8192 * n for n in range(1, 101)]


@pytest.mark.fact("PMD-TRAP-16")
def test_a_move_of_one_step_makes_one_pulse() -> None:
    rig = mover("mc1151a", "pulse1")
    begun = rig.begin(*TRAPEZOID, "SET_POS 1")
    assert rig.speeds() == [*UP[:8], *UP[6::-1]]
    ((rise, high), (fall, low)) = rig.edges("pulse1", rig.at(begun))
    assert (high, low) == (1, 0) and rig.at(begun) < rise < fall <= rig.at(begun + 15)
    assert rig.do("GET_TRGT_POS") == 1


@pytest.mark.fact("PMD-TRAP-17", "PMD-UND-START-GE-MAX")
def test_with_a_start_velocity_above_the_velocity_there_are_no_ramps() -> None:
    rig = mover("mc1151a")
    begun = rig.begin(*command(100, 0x4000, 1024, 0x8000))
    assert rig.speeds() == [0x4000] * 400
    assert rig.ticks(begun) == [4 * 8192 * n for n in range(1, 101)]
    assert rig.codes == ["start-velocity"]


@pytest.mark.fact("PMD-TRAP-18", "PMD-UND-TRAP-ALGO")
def test_a_low_start_velocity_makes_no_crawl_at_the_end() -> None:
    distance, top, acceleration, start, cycles = MOVES["T11"]
    rig = mover("mc1151a")
    rig.begin(*command(distance, top, acceleration, start))
    speeds = rig.speeds()
    assert speeds == trapezoid(distance * ONE, top, acceleration, start) and len(speeds) == cycles
    assert speeds.count(start) <= 2  # the first cycle, and one before the landing


@pytest.mark.fact("PMD-TRAP-19", "PMD-UND-WRAP-MOVE")
def test_the_longest_move_takes_the_long_route() -> None:
    rig = mover("mc1451a", "dir1")
    far = 1 << 30
    begun = rig.begin("SET_OUTPUT_HIGH", f"SET_ACTL_POS {-far}", *command(far - 1, 512 * ONE, 32 * ONE))
    rig.to(begun + 1000)
    assert rig.look().pos == -far + 512 * 1000 - sum(range(0, 512, 32)) and rig.level("dir1") == 1
    rig.rest("2000 s")
    assert rig.shows("trgt_pos") == far - 1 and rig.shows("status") == 0x301  # no wrap-around
    assert rig.x.travel == 2 * far - 1
    assert rig.lows("atrest1") == [(begun, 4_194_304 + 15)]
    rig.begin(f"SET_POS {-far}")
    rig.next(1000)
    assert rig.look().pos > 0 and rig.level("dir1") == 0
    rig.heeds(rig.cycle + 2, "STOP", "UPDATE")
    assert rig.shows("status") == 0x301


# ----------------------------------------------------------------------------------------------------------- on the way
@pytest.mark.fact("PMD-TRAP-9")
def test_a_destination_that_is_moved_on_is_reached_without_a_stop() -> None:
    rig, begun = coasting()
    rig.heeds(begun + 500, "SET_POS 2000", "UPDATE")
    assert rig.speeds() == [ONE] * (2000 - 64 - 436) + DOWN
    assert rig.lows("atrest1") == [(begun, 2063)] and rig.moves() == [2000]


@pytest.mark.fact("PMD-TRAP-10", "PMD-UND-TRAP-BEHIND")
def test_a_destination_already_passed_is_reached_by_braking_and_turning_round() -> None:
    rig, begun = coasting(record=("dir1",))
    rig.heeds(begun + 500, "SET_POS 300", "UPDATE")  # at 468.5
    back = [*UP, *[ONE] * 136, *DOWN]
    turn = rig.trace(64)
    assert [look.vel for look in turn] == [*DOWN, 0]
    assert turn[-1].pos == 500 and turn[-1].status == 0x700  # at rest for a cycle, but not complete
    assert rig.speeds() == [-speed for speed in back]
    assert rig.moves() == [500, -200] and rig.lows("atrest1") == [(begun, 827)]
    assert rig.edges("dir1") == [(rig.at(begun + 564), 0)]


@pytest.mark.fact("PMD-TRAP-11", "PMD-UND-TRAP-BEHIND")
def test_a_destination_too_near_is_overrun_and_reached_from_the_other_side() -> None:
    rig, begun = coasting()
    rig.heeds(begun + 500, "SET_POS 480", "UPDATE")
    speeds = rig.speeds()
    assert speeds == [*DOWN, 0, *(-speed for speed in trapezoid(20 * ONE, ONE, UNIT))]
    assert all(abs(change) <= UNIT for change in differences([ONE, *speeds, 0]))
    assert rig.moves() == [500, -20] and rig.lows("atrest1") == [(begun, 635)]


@pytest.mark.fact("PMD-TRAP-11", "PMD-UND-TRAP-ALGO")
def test_a_destination_within_one_acceleration_does_not_cause_an_immediate_stop() -> None:
    rig = mover("mc1151a")
    begun = rig.begin(*command(1000, 4 * ONE, ONE))
    rig.heeds(begun + 10, "SET_POS 35", "UPDATE")  # at 34
    assert [2 * speed // ONE for speed in rig.speeds()] == [6, 4, 2, 0, -2, -4, -3, -1]
    assert rig.moves() == [40, -5]


@pytest.mark.fact("PMD-UND-TRAP-BEHIND")
def test_on_the_return_to_a_passed_destination_the_start_velocity_is_the_slowest() -> None:
    rig, begun = coasting(*T3)
    rig.heeds(begun + 500, "SET_POS 100", "UPDATE")
    speeds = rig.speeds()
    assert speeds[:50] == [*DOWN[:48], 0, -0x4000] and rig.moves()[1] < 0
    assert rig.status() == 0x301 and rig.do("GET_TRGT_POS") == 100


@pytest.mark.fact("PMD-TRAP-12", "PMD-ERRC-18")
def test_a_lower_velocity_is_reached_by_braking() -> None:
    rig, begun = coasting()
    rig.heeds(begun + 500, "SET_VEL 0x8000", "UPDATE")
    assert rig.look().status == 0x700
    assert rig.speeds() == [*DOWN[:32], *[ONE // 2] * 999, *DOWN[31:]]
    assert rig.lows("atrest1") == [(begun, 1563)] and rig.moves() == [1000]


@pytest.mark.fact("PMD-TRAP-13", "PMD-ERRC-18")
def test_a_higher_velocity_is_reached_by_accelerating() -> None:
    rig, begun = coasting()
    rig.heeds(begun + 500, "SET_VEL 0x20000", "UPDATE")
    up, down = range(ONE + UNIT, 2 * ONE + 1, UNIT), range(2 * ONE - UNIT, 0, -UNIT)
    assert rig.speeds() == [*up, *[2 * ONE] * 154, *down]
    assert rig.lows("atrest1") == [(begun, 845)] and rig.moves() == [1000]


# ------------------------------------------------------------------------------------------------------- command errors
@pytest.mark.fact("PMD-ERRC-12", "PMD-ERRC-22")
def test_another_acceleration_in_motion_is_a_command_error_and_waits_for_an_update_at_rest() -> None:
    rig, begun = coasting()
    rig.heeds(begun + 500, "SET_ACC 0x800", "UPDATE")
    assert rig.look().status == 0x780 and rig.status() == 0x780
    rig.rest()
    assert rig.lows("atrest1") == [(begun, T1_CYCLES)] and rig.do("GET_ACC") == 0x800
    rig.begin("SET_POS 2000")
    assert [look.vel for look in rig.trace(4)] == [0x800, 0x1000, 0x1800, 0x2000]


@pytest.mark.fact("PMD-ERRC-13")
def test_the_same_acceleration_once_more_is_not_a_command_error() -> None:
    rig, begun = coasting()
    rig.heeds(begun + 500, "SET_ACC 0x400", "UPDATE")
    assert rig.look().status == 0x700
    rig.rest()
    assert rig.lows("atrest1") == [(begun, T1_CYCLES)]


@pytest.mark.fact("PMD-ERRC-14", "PMD-ERRC-24", "PMD-CON-CMDERR-TRAP")
def test_of_an_update_with_another_acceleration_the_destination_alone_is_taken() -> None:
    rig, begun = coasting()
    rig.heeds(begun + 500, "SET_ACC 0x800", "SET_VEL 0x8000", "SET_POS 2000", "UPDATE")
    assert rig.look().status == 0x780
    assert rig.speeds() == [*[ONE] * 1500, *DOWN]  # neither the velocity nor the acceleration
    assert rig.lows("atrest1") == [(begun, 2063)] and rig.moves() == [2000]


@pytest.mark.fact("PMD-ERRC-14")
def test_an_update_with_another_acceleration_moves_the_destination() -> None:
    rig, begun = coasting()
    rig.heeds(begun + 500, "SET_ACC 0x800", "SET_POS 2000", "UPDATE")
    assert rig.look().status == 0x780
    rig.rest()
    assert rig.moves() == [2000] and rig.status() == 0x381


@pytest.mark.fact("PMD-ERRC-12", "PMD-ERRC-22", "PMD-UND-CMDERR-ONCE")
def test_a_refused_acceleration_is_an_error_once_and_counts_with_the_next_start() -> None:
    rig, begun = coasting()
    rig.heeds(begun + 500, "SET_ACC 0x800", "UPDATE")
    assert rig.status() == 0x780
    rig.do("CLR_STATUS", "SET_VEL 0x8000", "SET_POS 2000", "UPDATE")
    rig.next(200)
    assert rig.status() == 0x700 and rig.look().vel == 0x8000  # braked with the acceleration in force
    rig.do("SET_ACC 0x800", "UPDATE")  # loaded once more: refused once more
    rig.next()
    assert rig.status() == 0x780
    rig.rest()
    assert rig.moves() == [2000]
    rig.begin("SET_POS 0")
    assert [look.vel for look in rig.trace(2)] == [-0x800, -0x1000]


@pytest.mark.fact("PMD-ERRC-23", "PMD-UND-START-CHANGE", "PMD-CON-STARTVEL-MOTION")
def test_a_start_velocity_counts_from_the_next_start() -> None:
    rig, begun = coasting(*T3)
    rig.heeds(begun + 500, "SET_START_VEL 0", "UPDATE")
    assert rig.look().status == 0x700 and rig.do("GET_START_VEL") == 0
    rig.next()
    assert min(rig.speeds()) == 0x4000 and rig.lows("atrest1") == [(begun, 1037)]
    rig.begin("SET_POS 2000")
    assert [look.vel for look in rig.trace(3)] == UP[:3]


@pytest.mark.fact("PMD-CMD-SET_JERK-2", "PMD-CMD-SET_MAX_ACC-2")
@pytest.mark.parametrize("mode", ["SET_PRFL_TRAP", "SET_PRFL_VEL"])
def test_jerk_and_greatest_acceleration_belong_to_s_curves(mode: str) -> None:
    found = set()
    for extra in ("SET_JERK 0", "SET_JERK 0x7fffffff", "SET_MAX_ACC 0", "SET_MAX_ACC 0x7fff"):
        rig = mover("mc1151a")
        begun = rig.begin(mode, *TRAPEZOID, "SET_POS 100", extra)
        rig.next(200)
        found.add((rig.look(), *rig.ticks(begun)))
    assert len(found) == 1


# ---------------------------------------------------------------------------------------------------------------- zeros
@pytest.mark.fact("PMD-STAT-23", "PMD-UND-TRAP-ZERO")
@pytest.mark.parametrize("setup", [(*TRAPEZOID, "SET_POS 0"), ("SET_VEL 0", "SET_ACC 0x400", "SET_POS 1000")])
def test_a_move_to_nowhere_or_at_velocity_0_is_complete_in_the_cycle_after_its_update(setup: tuple[str, ...]) -> None:
    rig = mover("mc1151a", "pulse1")
    before = rig.update(*setup) - 1
    assert rig.cycle == before and rig.shows("status") == 0x300
    rig.to(before + 1)
    assert rig.shows("status") == 0x301
    rig.next(100)
    assert not rig.ticks() and rig.lows("atrest1") == [] and not rig.codes


@pytest.mark.fact("PMD-UND-TRAP-ZERO")
def test_without_acceleration_and_start_velocity_nothing_starts() -> None:
    rig = mover("mc1151a")
    rig.begin("SET_VEL 0x10000", "SET_POS 1000")
    rig.next(100)
    assert rig.shows("status") == 0x300 and not rig.ticks() and rig.codes == ["no-start"]


@pytest.mark.fact("PMD-UND-TRAP-ZERO")
@pytest.mark.parametrize(("start", "speed"), [(0x4000, 0x4000), (0x20000, ONE)])
def test_without_acceleration_a_start_velocity_is_the_speed_of_the_whole_move(start: int, speed: int) -> None:
    rig = mover("mc1151a")
    rig.begin("SET_VEL 0x10000", f"SET_START_VEL {start}", "SET_POS 25")
    assert rig.speeds() == [speed] * (25 * ONE // speed)
    assert rig.moves() == [25]
