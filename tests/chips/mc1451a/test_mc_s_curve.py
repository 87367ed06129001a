"""S-curves of the MC1451A family: phases, limits and durations, cycle by cycle, and what they take on the way.

S1       jerk 32, 0, -32, 0, -32, 0, 32 (in 2^-16 steps per cycle^3) for 32, 32, 32, 904, 32, 32, 32 cycles
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from itertools import groupby
from math import ceil, floor
from random import Random

import pytest
from mc import ONE, S1, S1_CYCLES, each
from mc_motion import Mover, differences, mover

from tests.ensembles import few

UNIT = 32  # jerk
NOISE = Decimal(2) ** -20  # what is computed with 60 digits may be so far on the wrong side of a whole number


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


class Curve:
    """The continuous profile of a move, and what its cycles cover."""

    def __init__(self, distance: int, velocity: int, acceleration: int, jerk: int) -> None:
        t1, t2, t4 = phases(abs(distance), velocity, acceleration, jerk)
        self.way = 1 if distance > 0 else -1
        self.pieces: list[tuple[Decimal, Decimal, Decimal, Decimal, Decimal]] = []  # begin, then x, v and a there, jerk
        begin = x = v = a = Decimal(0)
        with localcontext(prec=60):
            for length, sign in zip((t1, t2, t1, t4, t1, t2, t1), (1, 0, -1, 0, -1, 0, 1), strict=True):
                j = sign * Decimal(jerk) / ONE / ONE
                self.pieces.append((begin, x, v, a, j))
                x += v * length + a * length**2 / 2 + j * length**3 / 6
                v += a * length + j * length**2 / 2
                a += j * length
                begin += length
            self.ends = [round(piece[0], 20) for piece in self.pieces[1:]] + [round(begin, 20)]
        self.cycles, self.distance = ceil(self.ends[-1]), abs(distance)

    def place(self, t: int) -> Decimal:
        """The position after so many cycles, from the start, in 1/65536 step."""
        with localcontext(prec=60):
            if t >= self.ends[-1]:
                return Decimal(self.distance * ONE)
            begin, x, v, a, j = [piece for piece in self.pieces if piece[0] <= t][-1]
            since = t - begin
            return (x + v * since + a * since**2 / 2 + j * since**3 / 6) * ONE

    def covered(self, cycle: int) -> Decimal:
        """What a cycle covers, in 1/65536 step."""
        with localcontext(prec=60):
            return self.place(cycle + 1) - self.place(cycle)

    def phase(self, cycle: int) -> int:
        """The phase that a cycle lies in; the first one with jerk if it lies in several."""
        first = sum(end <= cycle for end in self.ends)
        return first + 1 if cycle + 1 <= self.ends[first] else (first + 1) | 1

    @property
    def speeds(self) -> list[int]:
        """What the cycles cover, rounded down."""
        return [floor(self.covered(cycle) + NOISE) for cycle in range(self.cycles)]

    @property
    def shown(self) -> list[tuple[int, int]]:
        """The phases, and how many cycles count as each."""
        return [(phase, len(list(run))) for phase, run in groupby(map(self.phase, range(self.cycles)))]

    def follows(self, targets: list[int], speeds: list[int]) -> bool:
        """Are these its positions and the distances between them, rounded down each?"""
        cycles = range(self.cycles)
        exact = [*map(self.place, cycles), *map(self.covered, cycles)]
        return len(targets) == len(speeds) == self.cycles and all(
            floor(number - NOISE) <= self.way * found <= floor(number + NOISE)
            for number, found in zip(exact, [*targets, *speeds], strict=True)
        )


S1_SPEEDS = Curve(1000, ONE, 1024, 0x200000).speeds
UP, DOWN = S1_SPEEDS[:96], S1_SPEEDS[-96:]  # phases 1 to 3, 5 to 7


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
MOVES = {  # distance, V, A, J; cycles of the phases 1 to 7
    "S1": (1000, ONE, 1024, 0x200000, (32, 32, 32, 904, 32, 32, 32)),
    "S2": (1000, ONE // 2, 32767, 0x200000, (32, 0, 32, 1936, 32, 0, 32)),
    "S3": (96, 16 * ONE, 1024, 0x200000, (32, 32, 32, 0, 32, 32, 32)),
    "S4": (32, 16 * ONE, 32767, 0x200000, (32, 0, 32, 0, 32, 0, 32)),
    "S5": (-1000, ONE, 1024, 0x200000, (32, 32, 32, 904, 32, 32, 32)),
    # phases end at 19.15, 38.30; 3636.36, 3655.51, 3674.66
    "S6": (10_000, 180_224, 11_469, 32_212_255, (20, 0, 19, 3597, 20, 0, 19)),
    # at 102.41, 319.98, 422.39; 6250, 6352.41, 6569.98, 6672.39
    "S7": (100_000, 16 * ONE, 3277, 0x200000, (103, 216, 104, 5827, 103, 216, 104)),
}


@pytest.mark.fact("PMD-SCRV-1", "PMD-SCRV-7", "PMD-UND-SCRV-ALGO")
@pytest.mark.parametrize("name", MOVES)
def test_a_curve_ends_at_its_destination_in_due_time(name: str) -> None:
    distance, *limits, lengths = MOVES[name]
    rig = mover("mc1151a")
    begun = rig.begin(*command(distance, *limits))
    rig.rest()
    assert rig.lows("atrest1") == [(begun, sum(lengths))]
    assert 0 <= sum(lengths) - Curve(distance, *limits).ends[-1] < 1
    assert rig.moves() == [distance] and rig.do("GET_TRGT_POS") == distance
    assert rig.do("GET_TRGT_VEL") == 0 and rig.status() == 0x301
    assert not rig.codes


@pytest.mark.fact("PMD-SCRV-1", "PMD-SCRV-2", "PMD-SCRV-7", "PMD-UND-SCRV-ALGO")
@pytest.mark.parametrize("seed", few(range(4), 2))
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
        rig.rest()
        curve = Curve(distance, velocity, acceleration, jerk)
        assert rig.lows("atrest1", rig.at(begun)) == [(begun, curve.cycles)]
        passed = rig.x.axis(1).cycles(rig.at(begun), rig.at(begun + curve.cycles) - 1)
        speeds, targets = passed.velocities.tolist(), (passed.targets - (place - distance) * ONE).tolist()
        assert curve.follows(targets, speeds)
        assert [(phase, len(list(run))) for phase, run in groupby(passed.phases.tolist())] == curve.shown
        assert rig.moves(begun) == [distance]
        displaced = differences([*targets, distance * ONE])
        assert max(map(abs, (*speeds, *displaced))) <= velocity
        for found, more in ((speeds, 0), (displaced, 1)):  # positions are rounded, and so differ by one more
            accelerations = differences([0, *found, 0])
            assert max(map(abs, accelerations)) <= acceleration + more
            assert max(map(abs, differences([0, *accelerations, 0]))) <= -(-jerk // ONE) + 1 + 2 * more
        assert rig.do("GET_TRGT_POS") == place and rig.do("GET_TRGT_VEL") == 0
    assert rig.x.position == place


@pytest.mark.fact("PMD-SCRV-3", "PMD-SCRV-4", "PMD-SCRV-5", "PMD-SCRV-6", "PMD-SCRV-8")
@pytest.mark.parametrize("name", MOVES)
def test_the_mode_word_shows_the_phases_and_empty_ones_fall_out(name: str) -> None:
    *registers, lengths = MOVES[name]
    rig = mover("mc1151a")
    rig.begin(*command(*registers))
    expected = [(phase, length) for phase, length in enumerate(lengths, 1) if length]
    assert shown(rig, sum(lengths) + 5) == [*expected, (0, 5)] and Curve(*registers).shown == expected


@pytest.mark.fact("PMD-SCRV-2", "PMD-SCRV-3", "PMD-SCRV-5", "PMD-SCRV-6", "PMD-SCRV-8")
@pytest.mark.parametrize(("name", "peak"), [("S1", ONE), ("S2", ONE // 2), ("S3", ONE), ("S4", ONE // 2)])
def test_each_phase_has_its_jerk_and_the_second_half_mirrors_the_first(name: str, peak: int) -> None:
    *registers, lengths = MOVES[name]
    rig = mover("mc1151a")
    rig.begin(*command(*registers))
    speeds = rig.speeds()
    signs = zip((1, 0, -1, 0, -1, 0, 1), lengths, strict=True)
    jerks = [sign * UNIT for sign, length in signs for _ in range(length)]
    seen = differences([0, *differences([0, *speeds])])
    for found, *of in zip(seen, [0, 0, *jerks[:-2]], [0, *jerks[:-1]], jerks, strict=True):
        assert abs(6 * found - (of[0] + 4 * of[1] + of[2])) < 12  # three mean velocities, each rounded down
    assert peak - UNIT // 3 <= max(speeds) <= peak and speeds == speeds[::-1]


@pytest.mark.fact("PMD-UND-SCRV-ALGO")
def test_numbers_of_an_s_curve_are_rounded_up_while_it_gains_speed_and_down_while_it_loses_it() -> None:
    """J/6 has no end in binary; 32 k^3 / 6 is a whole number in every third cycle."""
    rig = mover("mc1151a")
    begun = rig.begin(*S1)
    rig.rest()
    targets = rig.x.axis(1).cycles(rig.at(begun), rig.at(begun + S1_CYCLES)).targets.tolist()
    assert targets[:33] == [16 * k**3 // 3 for k in range(33)]
    assert targets[-2:-34:-1] == [1000 * ONE - 16 * k**3 // 3 - 1 for k in range(1, 33)]


def check_maxima(number: int, seed: int) -> None:
    """Ask the registers of random moves in the cycles that lie in phase 4, and in those of phases 2 and 6.

    Every move coasts for three cycles or more; the shortest have two whole cycles in them.
    """
    rnd = Random(seed)
    rig = mover("mc1151a")
    place = made = 0
    while made < number:
        velocity, acceleration = int(2 ** rnd.uniform(4, 20)), min(int(2 ** rnd.uniform(2, 15.1)), 32767)
        jerk = min(int(2 ** rnd.uniform(10, 31.1)), (1 << 31) - 1)
        rising = sum(phases(1 << 60, velocity, acceleration, jerk)[i] * (2 - i) for i in (0, 1))
        way = (rising + 3) * velocity / ONE * Decimal(2 ** rnd.uniform(0, 3))
        if rising > 2000 or way < 1:
            continue
        distance = rnd.choice((-1, 1)) * ceil(way)
        curve, place = Curve(distance, velocity, acceleration, jerk), place + distance
        begun = rig.begin(*command(place, velocity, acceleration, jerk))
        for phase, top in ((2, 0), (4, velocity), (6, 0)):
            first, last = ceil(curve.ends[phase - 2]), floor(curve.ends[phase - 1]) - 1  # the whole cycles in it
            speeds = []
            for cycle in sorted({first, min(first + 1, last), last}) if first <= last else ():
                rig.to(begun + cycle)
                look = rig.look()
                assert look.phase == phase
                speeds.append(abs(look.vel))
                assert not top or abs(look.vel) == top
            assert not top or len(speeds) > 1
            if phase != 4 and first < last:
                assert abs(speeds[1] - speeds[0]) == acceleration
                assert abs(speeds[-1] - speeds[0]) == (last - first) * acceleration
        rig.rest()
        assert rig.do("GET_TRGT_POS") == place and rig.lows("atrest1", rig.at(begun)) == [(begun, curve.cycles)]
        made += 1


@pytest.mark.fact("PMD-SCRV-2", "PMD-SCRV-3", "PMD-UND-SCRV-ALGO")
def test_coasting_shows_the_set_velocity_and_constant_acceleration_the_set_acceleration() -> None:
    check_maxima(60, seed=1)


@pytest.mark.long
@pytest.mark.timeout(1800)
def test_ten_thousand_curves_that_coast_show_the_velocity_that_was_set() -> None:
    check_maxima(10_000, seed=2)


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
def test_another_destination_in_motion_is_allowed_and_waits_for_an_update_at_rest() -> None:
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
def test_a_smooth_stop_in_phase_4_continues_with_phase_5() -> None:
    rig, begun = moving(500)
    rig.heeds(begun + 500, "SMOOTH_STOP", "UPDATE")
    place, looks = rig.look().pos, rig.trace(100)
    assert [look.vel for look in looks] == [*DOWN, 0, 0, 0, 0]
    assert [look.phase for look in looks] == [5] * 32 + [6] * 32 + [7] * 32 + [0] * 4
    assert (place, looks[-1].pos) == (452, 500) and looks[-1].status == 0x301
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
    assert max(look.vel for look in looks) == peak - 6  # what the first cycle behind it covers, rounded down
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
def test_a_curve_to_nowhere_or_at_velocity_0_is_complete_in_the_cycle_after_its_update(zero: str) -> None:
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
def test_the_phase_is_0_after_any_end(end: str) -> None:
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


@pytest.mark.parametrize("distance", [1000, 90, -20])
def test_phases_that_end_with_a_cycle_are_the_same_cycle_by_cycle(distance: int) -> None:
    found = []
    for stepwise in (False, True):
        rig = mover("mc1151a", options={"stepwise": stepwise})
        begun = rig.begin(*S1[:-1], f"SET_POS {distance}")
        rig.next(1200 if distance == 1000 else 400)
        found.append((rig.look(), rig.ticks(begun)))
    assert found[0] == found[1] and len(found[0][1]) == abs(distance)
