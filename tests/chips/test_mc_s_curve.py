"""S-curves of the MC1451A family: phases, limits and durations, cycle by cycle, and what they take on the way.

S1       jerk 32, 0, -32, 0, -32, 0, 32 (in 2^-16 steps per cycle^3) for 32, 32, 32, 904, 32, 32, 32 cycles
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from fractions import Fraction
from itertools import accumulate, groupby
from math import ceil
from random import Random

import pytest
from mc import ONE, S1, S1_CYCLES, each
from mc_motion import Mover, differences, mover

UNIT = 32  # jerk
UP = list(accumulate(accumulate([UNIT] * 32 + [0] * 32 + [-UNIT] * 32)))  # phases 1 to 3
DOWN = [ONE - speed for speed in UP]  # phases 5 to 7


def command(distance: int, velocity: int, acceleration: int, jerk: int) -> tuple[str, ...]:
    """The registers of a move."""
    return (
        "SET_PRFL_S_CRV",
        f"SET_POS {distance}",
        f"SET_VEL {velocity}",
        f"SET_MAX_ACC {acceleration}",
        f"SET_JERK {jerk}",
    )


def phases(distance: int, velocity: int, acceleration: int, jerk: int) -> tuple[Decimal, Decimal, Decimal]:
    """Phases 1, 2 and 4 of the continuous profile, in cycles; the distance is in steps."""
    with localcontext(prec=60):
        d, v, a, j = Decimal(distance), *(Decimal(value) / ONE for value in (velocity, acceleration)), Decimal(jerk)
        j /= ONE * ONE
        reached = v * j >= a * a
        t1, t2 = (a / j, v / a - a / j) if reached else ((v / j).sqrt(), Decimal(0))
        if d >= v * (2 * t1 + t2):
            return t1, t2, d / v - 2 * t1 - t2
        if d >= 2 * a**3 / j**2:
            peak = ((a**4 / j**2 + 4 * a * d).sqrt() - a * a / j) / 2
            return a / j, peak / a - a / j, Decimal(0)
        return (d / (2 * j)) ** (Decimal(1) / 3), Decimal(0), Decimal(0)


def whole(cycles: Decimal) -> int:
    """The next whole number of cycles; the last digits are noise."""
    return ceil(round(cycles, 20))


def s_curve(distance: int, velocity: int, acceleration: int, jerk: int) -> tuple[list[int], list[int]]:
    """Targets and velocities of the cycles of a move: those of a jerk of 1, scaled to the distance, cut off."""
    n1, n2, n4 = (whole(cycles) for cycles in phases(abs(distance), velocity, acceleration, jerk))
    n1 = max(n1, 1)
    lengths = zip((n1, n2, n1, n4, n1, n2, n1), (1, 0, -1, 0, -1, 0, 1), strict=True)
    speeds = list(accumulate(accumulate(sign for length, sign in lengths for _ in range(length))))
    places = list(accumulate(speeds, initial=0))
    way, scale = (1 if distance > 0 else -1), Fraction(abs(distance) * ONE, places[-1])
    return [way * int(scale * place) for place in places[:-1]], [way * int(scale * speed) for speed in speeds]


def shown(rig: Mover, cycles: int) -> list[tuple[int, int]]:
    """Phases and how long they last, from this cycle on."""
    return [(phase, len(list(run))) for phase, run in groupby(look.phase for look in rig.trace(cycles))]


def moving(cycle: int) -> tuple[Mover, int]:
    """The move S1, so long before one of its cycles that some commands find room; returns its first cycle."""
    rig = mover("mc1151a")
    begun = rig.begin(*S1)
    rig.to(begun + max(cycle - 20, 0))
    return rig, begun


# ------------------------------------------------------------------------------------------------------------ the moves
MOVES = {  # distance, V, A, J; lengths of phases 1, 2 and 4
    "S1": (1000, ONE, 1024, 0x200000, (32, 32, 904)),
    "S2": (1000, ONE // 2, 32767, 0x200000, (32, 0, 1936)),
    "S3": (96, 16 * ONE, 1024, 0x200000, (32, 32, 0)),
    "S4": (32, 16 * ONE, 32767, 0x200000, (32, 0, 0)),
    "S5": (-1000, ONE, 1024, 0x200000, (32, 32, 904)),
    "S6": (10_000, 180_224, 11_469, 32_212_255, (20, 0, 3599)),
    "S7": (100_000, 16 * ONE, 3277, 0x200000, (103, 218, 5828)),
}


@pytest.mark.fact("PMD-SCRV-1", "PMD-SCRV-7", "PMD-UND-SCRV-ALGO")
@pytest.mark.parametrize("name", MOVES)
def test_a_curve_ends_at_its_destination_in_due_time(name: str) -> None:
    distance, velocity, acceleration, jerk, (n1, n2, n4) = MOVES[name]
    rig = mover("mc1151a")
    begun = rig.begin(*command(distance, velocity, acceleration, jerk))
    rig.rest()
    cycles = 4 * n1 + 2 * n2 + n4
    assert rig.lows("atrest1") == [(begun, cycles)]
    t1, t2, t4 = phases(abs(distance), velocity, acceleration, jerk)
    assert 0 <= cycles - (4 * t1 + 2 * t2 + t4) <= 7
    assert rig.moves() == [distance] and rig.do("GET_TRGT_POS") == distance
    assert rig.do("GET_TRGT_VEL") == 0 and rig.status() == 0x301
    assert not rig.codes


@pytest.mark.fact("PMD-SCRV-1", "PMD-SCRV-2", "PMD-SCRV-7", "PMD-UND-SCRV-ALGO")
@pytest.mark.parametrize("seed", range(4))
def test_random_curves_follow_the_law_cycle_by_cycle(seed: int) -> None:
    rnd = Random(seed)
    rig = mover("mc1151a")
    place = 0
    for _ in range(50):
        velocity = rnd.choice((ONE, ONE // 3, rnd.randrange(ONE // 8, 4 * ONE), 16 * ONE))
        acceleration = min(rnd.randrange(velocity // 16, 2 * velocity), 32767)
        jerk = (acceleration << 16) // rnd.choice((1, 2, 5, 10, 20)) + rnd.randrange(1000)
        distance = rnd.choice((1, -1)) * rnd.randrange(1, 10 * velocity // ONE + 3)
        place += distance
        begun = rig.begin(*command(place, velocity, acceleration, jerk))
        way = 1 if distance > 0 else -1
        rig.rest()
        ((_, cycles),) = rig.lows("atrest1", rig.at(begun))
        targets, speeds = s_curve(distance, velocity, acceleration, jerk)
        passed = rig.x.axis(1).cycles(rig.at(begun), rig.at(begun + cycles) - 1)
        assert passed.velocities.tolist() == speeds and speeds[-1] == 0
        assert (passed.targets - (place - distance) * ONE).tolist() == targets
        assert rig.moves(begun) == [distance]
        assert max(way * speed for speed in speeds) <= velocity
        accelerations = differences([0, *speeds, 0])
        assert max(map(abs, accelerations)) <= acceleration + 1
        assert max(map(abs, differences([0, *accelerations]))) <= -(-jerk // ONE) + 2
        t1, t2, t4 = phases(abs(distance), velocity, acceleration, jerk)
        assert -2 <= cycles - (4 * t1 + 2 * t2 + t4) <= 9
        assert rig.do("GET_TRGT_POS") == place and rig.do("GET_TRGT_VEL") == 0
    assert rig.x.position == place


@pytest.mark.fact("PMD-SCRV-3", "PMD-SCRV-4", "PMD-SCRV-5", "PMD-SCRV-6", "PMD-SCRV-8")
@pytest.mark.parametrize("name", MOVES)
def test_the_mode_word_shows_the_phases_and_empty_ones_fall_out(name: str) -> None:
    *registers, (n1, n2, n4) = MOVES[name]
    rig = mover("mc1151a")
    rig.begin(*command(*registers))
    lengths = enumerate((n1, n2, n1, n4, n1, n2, n1), 1)
    expected = [(phase, length) for phase, length in lengths if length]
    assert shown(rig, 4 * n1 + 2 * n2 + n4 + 5) == [*expected, (0, 5)]


@pytest.mark.fact("PMD-SCRV-2", "PMD-SCRV-3", "PMD-SCRV-5", "PMD-SCRV-6", "PMD-SCRV-8")
@pytest.mark.parametrize(("name", "peak"), [("S1", ONE), ("S2", ONE // 2), ("S3", ONE), ("S4", ONE // 2)])
def test_each_phase_has_its_jerk_and_the_second_half_mirrors_the_first(name: str, peak: int) -> None:
    *registers, (n1, n2, n4) = MOVES[name]
    rig = mover("mc1151a")
    rig.begin(*command(*registers))
    speeds = rig.speeds()
    jerks = differences([0, *differences([0, *speeds])])
    ramp = [UNIT] * n1 + [0] * n2 + [-UNIT] * n1
    assert jerks == [*ramp, *[0] * n4, *(-jerk for jerk in ramp)]
    assert max(speeds) == peak and speeds[:-2] == speeds[-3::-1]


@each
@pytest.mark.fact("PMD-SCRV-6")
def test_a_short_move_has_four_phases_on_every_axis_of_every_part(part: str) -> None:
    rig = mover(part)
    for axis in range(1, len(rig.x.axes) + 1):
        rig.do(f"SET_{axis}")
        rig.begin(*command(*MOVES["S4"][:4]))
        looks = rig.trace(130, axis)
        assert [look.phase for look in looks] == [1] * 32 + [3] * 32 + [5] * 32 + [7] * 32 + [0, 0]
        assert rig.moves(axis=axis) == [32] and looks[-1].pos == 32


# --------------------------------------------------------------------------------------------- registers of other modes
@pytest.mark.fact("PMD-CMD-SET_ACC-3", "PMD-SCRV-11")
@pytest.mark.parametrize("extra", ["SET_ACC 0", "SET_ACC 0x3fffffff", "SET_START_VEL 0x4000"])
def test_acceleration_and_start_velocity_have_no_part_in_it(extra: str) -> None:
    rig = mover("mc1151a")
    begun = rig.begin(*S1, extra)
    assert rig.speeds() == [*UP, *[ONE] * 904, *DOWN]
    assert rig.lows("atrest1") == [(begun, S1_CYCLES)]


# ----------------------------------------------------------------------------------------------------------- on the way
@pytest.mark.fact("PMD-SCRV-9", "PMD-ERRC-16", "PMD-UND-SCRV-NEWPOS", "PMD-CON-CMDERR-SCOPE")
def test_another_destination_in_motion_is_no_error_and_waits_for_an_update_at_rest() -> None:
    rig, begun = moving(500)
    rig.heeds(begun + 500, "SET_POS 2000", "UPDATE")
    assert rig.look().status == 0x700
    rig.rest()
    rig.next(100)
    assert rig.lows("atrest1") == [(begun, S1_CYCLES)] and rig.do("GET_TRGT_POS") == 1000
    second = rig.begin()
    rig.rest()
    assert rig.lows("atrest1")[1] == (second, S1_CYCLES) and rig.moves() == [2000]


@pytest.mark.fact("PMD-ERRC-15", "PMD-SCRV-10", "PMD-CON-CMDERR-SCOPE", "PMD-UND-CMDERR-ONCE")
@pytest.mark.parametrize(
    ("change", "then"), [("SET_VEL 0x8000", 2064), ("SET_MAX_ACC 0x200", 1144), ("SET_JERK 0x100000", 1128)]
)
def test_other_limits_in_motion_are_a_command_error_and_count_from_the_next_start(change: str, then: int) -> None:
    rig, begun = moving(500)
    rig.heeds(begun + 500, change, "SET_POS 2000", "UPDATE")
    assert rig.look().status == 0x780
    rig.do("CLR_STATUS", "UPDATE")  # nothing is loaded now, so nothing is wrong
    rig.next()
    assert rig.look().status == 0x700
    rig.rest()
    assert rig.lows("atrest1") == [(begun, S1_CYCLES)] and rig.do("GET_TRGT_POS") == 1000
    second = rig.begin()
    rig.rest()
    assert rig.lows("atrest1")[1] == (second, then) and rig.moves() == [2000]


@pytest.mark.fact("PMD-SCRV-12", "PMD-UND-PHASE-END")
def test_a_smooth_stop_in_phase_4_goes_on_with_phase_5() -> None:
    rig, begun = moving(500)
    rig.heeds(begun + 500, "SMOOTH_STOP", "UPDATE")
    place, looks = rig.look().pos, rig.trace(100)
    assert [look.vel for look in looks] == [*DOWN, 0, 0, 0, 0]
    assert [look.phase for look in looks] == [5] * 32 + [6] * 32 + [7] * 32 + [0] * 4
    assert (place, looks[-1].pos) == (453, 500) and looks[-1].status == 0x301
    assert rig.lows("atrest1") == [(begun, 596)]


@pytest.mark.fact("PMD-SCRV-13", "PMD-UND-SCRV-SMOOTH", "PMD-UND-PHASE-END")
@pytest.mark.parametrize(
    ("done", "peak", "expected"),
    [
        (16, ONE // 8, [(3, 16), (5, 16), (7, 16)]),
        (48, ONE * 3 // 4, [(3, 32), (5, 32), (6, 16), (7, 32)]),
        (80, ONE, [(3, 16), (5, 32), (6, 32), (7, 32)]),
    ],
)
def test_a_smooth_stop_while_it_speeds_up_mirrors_what_was_done(
    done: int, peak: int, expected: list[tuple[int, int]]
) -> None:
    rig, begun = moving(0)
    rig.heeds(begun + done, "SMOOTH_STOP", "UPDATE")
    looks = rig.trace(150)
    lengths = [(phase, len(list(run))) for phase, run in groupby(look.phase for look in looks)]
    rest = sum(length for _, length in expected)
    assert lengths == [*expected, (0, 150 - rest)]
    assert max(look.vel for look in looks) == peak
    assert [look.status for look in looks[rest - 1 : rest + 1]] == [0x700, 0x301]
    assert rig.lows("atrest1") == [(begun, done + rest)]


@pytest.mark.fact("PMD-SCRV-14", "PMD-UND-SCRV-SMOOTH")
@pytest.mark.parametrize("done", [1001, 1040, 1090])
def test_a_smooth_stop_in_phases_5_to_7_changes_nothing_and_is_forgotten(done: int) -> None:
    rig, begun = moving(done)
    rig.heeds(begun + done, "SMOOTH_STOP", "UPDATE")
    rig.rest()
    assert rig.lows("atrest1") == [(begun, S1_CYCLES)] and rig.moves() == [1000] and rig.status() == 0x301
    back = rig.begin("SET_POS 0")
    rig.rest()
    assert rig.lows("atrest1")[1] == (back, S1_CYCLES)


# ---------------------------------------------------------------------------------------------------------------- zeros
@pytest.mark.fact("PMD-SCRV-15", "PMD-UND-SCRV-ZERO")
@pytest.mark.parametrize("zero", ["SET_JERK 0", "SET_MAX_ACC 0"])
def test_without_jerk_or_acceleration_nothing_starts(zero: str) -> None:
    rig = mover("mc1151a")
    rig.begin(*S1, zero)
    rig.next(100)
    assert rig.shows("status") == 0x300 and not rig.ticks() and rig.codes == ["no-start"]
    begun = rig.begin(*S1)
    rig.rest()
    assert rig.lows("atrest1") == [(begun, S1_CYCLES)]


@pytest.mark.fact("PMD-SCRV-15", "PMD-STAT-23", "PMD-UND-SCRV-ZERO")
@pytest.mark.parametrize("zero", ["SET_POS 0", "SET_VEL 0"])
def test_a_curve_to_nowhere_or_at_velocity_0_is_complete_in_the_cycle_behind_its_update(zero: str) -> None:
    rig = mover("mc1151a", "pulse1")
    begun = rig.update(*S1, zero)
    assert rig.shows("status") == 0x300
    rig.to(begun)
    assert rig.shows("status") == 0x301
    rig.next(100)
    assert not rig.ticks() and rig.lows("atrest1") == [] and not rig.codes


# ------------------------------------------------------------------------------------------------------------ the phase
@pytest.mark.fact("PMD-UND-PHASE-END")
@pytest.mark.parametrize("end", ["STOP", "MTR_OFF", "poslimit1", "SET_PRFL_TRAP", "SET_PRFL_VEL"])
def test_the_phase_is_0_behind_any_end(end: str) -> None:
    rig, begun = moving(500)
    rig.to(begun + 498)
    assert rig.shows("mode") == 0x9000
    if end == "STOP":
        rig.heeds(begun + 500, "STOP", "UPDATE")
    elif end == "poslimit1":
        rig.drive(end, 1)
        rig.to(begun + 500)
    else:
        rig.heeds(begun + 500, end)
    assert rig.look().phase == 0


@pytest.mark.fact("PMD-UND-PHASE-END")
def test_before_the_first_move_and_in_other_modes_the_phase_is_0() -> None:
    rig = mover("mc1151a")
    rig.do("SET_PRFL_S_CRV")
    assert rig.do("GET_MODE") == 0x1000
    rig.begin(*S1, "SET_PRFL_TRAP", "SET_ACC 0x400")
    assert {look.phase for look in rig.trace(200)} == {0}
