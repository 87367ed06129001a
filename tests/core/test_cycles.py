"""Trains of cycles against plain loops: tick by tick where they are short, cycle by cycle where they are long."""

from __future__ import annotations

from bisect import bisect_right
from itertools import pairwise
from random import Random

import numpy as np
import pytest
from promises import bounds, check_promise

from slewline.chips.mc1451a.profiles.cycle_train import BLOCK, CYCLE, ONE, STRETCH, CycleTrain, Linear, SquareView
from slewline.chips.mc1451a.profiles.s_curves import PLACES, JerkPiece, SCurve
from slewline.core.motion.axis import Axis
from slewline.core.motion.train import OPEN, Playing, StepTrain
from slewline.core.time.kernel import Kernel
from slewline.core.time.timebase import Clock
from tests.ensembles import few
from tests.rows import rows

CRYSTALS = [25_000_000, 24_999_999, 6_700_000, 20_480_000]
TOP = 512 * ONE
MHZ25 = Clock(25_000_000)


# ------------------------------------------------------------------------------------------------------------ the loops
def linear(speed: int, change: int, cycles: int) -> list[int]:
    """Displacements that change evenly."""
    return [speed + i * change for i in range(cycles)]


def pieces(random: Random, most: int, top: int) -> list[JerkPiece]:
    """Pieces of a random curve of up to so many cycles each, ended by rest; its displacements are at most `top` steps.

    The numbers have all their binary places.  Velocities are not continuous where a piece ends: nobody asks for that.
    """
    found, cycle, position = [], 0, random.randrange(ONE << PLACES)
    for phase in sorted(random.sample(range(1, 8), random.randrange(1, 8))):
        cycles = random.randrange(1, most + 1)
        a, b, c = (random.randrange((top * ONE << PLACES) // 4) for _ in range(3))
        change, jerk = random.choice([(b // cycles, 0), (0, 0), (b // cycles, 2 * c // cycles**2)])
        speed = a
        if random.randrange(2):  # the same backwards
            speed, change = a + cycles * change + cycles**2 // 2 * jerk, -change - cycles * jerk
        found.append(JerkPiece(cycle, phase, position, speed, change, jerk))
        cycle, position = cycle + cycles, found[-1].covered(cycle + cycles)
    return [*found, JerkPiece(cycle, 7, position, 0, 0, 0)]


def walked(curve: list[JerkPiece]) -> tuple[list[int], list[int], list[int]]:
    """Positions, displacements and phases of a curve by adding up cycle by cycle, with all their places."""
    positions, displacements, phases = [], [], []
    for piece, following in pairwise(curve):
        position, speed, change = piece.position, piece.speed, piece.change
        for _ in range(piece.cycle, following.cycle):
            positions.append(position)
            displacements.append(speed)
            phases.append(piece.phase)
            position, speed, change = position + speed, speed + change, change + piece.jerk
    return [*positions, curve[-1].position], displacements, phases


def curved(curve: list[JerkPiece], first: int, cycles: int) -> list[int]:
    """Displacements of a curve, between positions that are rounded down."""
    at = [position >> PLACES for position in walked(curve)[0]][first : first + cycles + 1]
    return np.diff(np.array(at, object)).tolist()


def tick_by_tick(displacements: list[int], lead: int, cycle: int, unit: int) -> list[int]:
    """Ticks, since the begin of cycle 0, on which the position is first at or beyond 1, 2, 3 ... units."""
    out = [0] * (lead >= unit)
    begin = lead
    for i, displaced in enumerate(displacements):
        for tick in range(cycle + 1):
            while begin * cycle + displaced * tick >= (len(out) + 1) * unit * cycle:
                out.append(i * cycle + tick)
        begin += displaced
    return out


def cycle_by_cycle(displacements: list[int], lead: int, cycle: int, unit: int) -> list[int]:
    """The same, by one division a step."""
    out = [0] * (lead >= unit)
    begin = lead
    for i, displaced in enumerate(displacements):
        while (missing := (len(out) + 1) * unit - begin) <= displaced:
            out.append(i * cycle - -missing * cycle // displaced)
        begin += displaced
    return out


def short_trains(cycle: int, clock: Clock = MHZ25, number: int = 30):
    """Short trains of every law, with their displacements."""
    random = Random(cycle)
    for n in range(number):
        lead = random.choice([0, 1, -1, ONE // 2, 40_000, ONE - 1, 1 - ONE, random.randrange(1 - ONE, ONE)])
        cycles = random.randrange(0, 9)
        if n % 3 == 2:
            curve = pieces(random, 2, random.randrange(1, 3))
            first = random.randrange(curve[-1].cycle)
            cycles = random.randrange(min(curve[-1].cycle - first, 8) + 1)
            law, displaced = SCurve(curve, first), curved(curve, first, cycles)
        else:
            speed = random.choice([0, 1, ONE, 3 * ONE - 1, random.randrange(5 * ONE)])
            change = 0 if n % 3 else random.choice([ONE // 3, 1, -1, -(speed // 8), -ONE])
            if change == -ONE:
                speed, lead = max(cycles - 1, 0) * ONE, 0  # the last cycle stands still, and on a step
            else:
                change = max(change, -(speed // max(cycles, 1)))
            law, displaced = Linear(speed, change), linear(speed, change, cycles)
        origin = random.choice([0, 1, 10**6, 10**12 + 3])
        yield random, CycleTrain(clock, origin, law, cycles, lead, cycle), displaced


# ------------------------------------------------------------------------------------------------------------ questions
@pytest.mark.parametrize("cycle", [16, 61])
@pytest.mark.parametrize("number", few((10, 30), 1))
def test_every_question_is_answered_as_by_counting_tick_by_tick(cycle, number):
    for random, whole_steps, displaced in short_trains(cycle, number=number):
        for train in (whole_steps, whole_steps.halves):
            ticks = tick_by_tick(displaced, train.lead, cycle, train.unit)
            begins, end = [train.origin + tick for tick in ticks], train.origin + len(displaced) * cycle
            assert (train.steps, train.origin + train.length) == (len(ticks), end)
            assert [train.end(k) for k in range(train.steps)] == begins
            assert [train.end(train.steps + n) for n in (0, 1, 9)] == [end] * 3
            for first in range(min(train.steps, 3) + 1):
                assert train.few([*range(first + 1, train.steps + 1, 3)]) == [
                    train.clock.ps(tick) for tick in begins[first::3]
                ]
            asked = list(range(train.origin - 3, end + 40))
            random.shuffle(asked)
            expected = [bisect_right(begins, tick) for tick in asked]
            for tick, begun in zip(asked, expected, strict=True):
                assert train.step_at(tick) == begun
                assert train.end(begun) == (begins[begun] if begun < len(begins) else end)  # the next one
                assert begun == 0 or train.end(begun - 1) == begins[begun - 1]
            assert train.steps_at(np.array(asked) - train.origin).tolist() == expected
            for first in range(train.steps + 2):
                for last in [None, *range(train.steps + 3)]:
                    assert train.ends(first, last).tolist() == ticks[first:last]


@rows("hz", CRYSTALS)
def test_instants_are_those_of_the_ticks_under_any_crystal(hz):
    clock = Clock(hz)
    for _, train, _ in short_trains(CYCLE, clock):
        instants = [clock.ps(train.end(k)) for k in range(train.steps)]
        for first in range(train.steps + 1):
            assert train.times(first + 1, train.steps).tolist() == instants[first:]
        asked = [ps + d for ps in instants for d in (-1, 0, 1)] + [clock.ps(train.origin + train.length)]
        expected = [bisect_right(instants, ps) for ps in asked]
        assert [train.count(ps) for ps in asked] == expected
        assert train.count_many(np.array(asked, np.int64)).tolist() == expected
        assert train.times(1, train.steps).tolist() == instants


def long_trains():
    """Speeds at both ends of what there is, leads at both ends, and ramps between them over many parts of an array."""
    random = Random(5)
    for speed in (1, 2, ONE - 1, ONE, ONE + 1, 20_467_547, TOP - 1, TOP):
        cycles = min(2 * BLOCK * ONE // speed, 3 * STRETCH)
        for lead in (0, ONE - 1, 1 - ONE, random.randrange(ONE)):
            yield Linear(speed), linear(speed, 0, cycles), lead
    for speed, change, cycles in (
        (0, TOP // 200, 200),
        (TOP, -TOP // 171, 171),
        (0, 1, 3000),
        (3000, -1, 3000),
        (1 << 22, -4096, 1024),
        (4095, 4097, 1500),
        (1, 333, 2 * STRETCH),
    ):
        yield Linear(speed, change), linear(speed, change, cycles), random.randrange(1 - ONE, ONE)
    for most, top in ((50, 400), (200, 9), (2000, 1)):
        curve = pieces(random, most, top)
        cycles = curve[-1].cycle - 1
        yield SCurve(curve, 1), curved(curve, 1, cycles), random.randrange(1 - ONE, ONE)


def test_long_trains_are_expanded_exactly():
    random = Random(6)
    for law, displaced, lead in long_trains():
        for train in (one := CycleTrain(MHZ25, 12_345, law, len(displaced), lead), one.halves):
            ticks = cycle_by_cycle(displaced, lead, CYCLE, train.unit)
            assert train.ends().tolist() == ticks
            for k in (random.randrange(train.steps) for _ in range(10 if ticks else 0)):
                assert train.end(k) == 12_345 + ticks[k]
                assert (train.step_at(12_344 + ticks[k]), train.step_at(12_345 + ticks[k])) == (
                    bisect_right(ticks, ticks[k] - 1),
                    bisect_right(ticks, ticks[k]),
                )
                last = random.randrange(k, train.steps + 1)
                assert train.ends(k, last).tolist() == ticks[k:last]
                assert train.times(k + 1, k + 9).tolist() == [MHZ25.ps(12_345 + tick) for tick in ticks[k : k + 9]]


def test_positions_are_those_at_the_start_of_cycles():
    for law, displaced, lead in long_trains():
        train = CycleTrain(MHZ25, 0, law, len(displaced), lead)
        expected = [lead, *(lead + np.cumsum(displaced)).tolist()]
        assert train.positions(0, len(displaced) + 1).tolist() == expected
        assert train.positions(5, 5).tolist() == []
        middle = len(displaced) // 2
        assert train.positions(middle, middle + 5).tolist() == expected[middle : middle + 5]


@rows("hz", CRYSTALS)
@rows("speed", [1, 20_467_547, TOP - 1, TOP])
def test_a_speed_without_end_is_exact_after_a_hundred_days(hz, speed):
    train = CycleTrain(Clock(hz), 77, Linear(speed), OPEN, 65_000)
    first = train.step_at(9 * 10**6 * hz)  # 104 days
    assert first > 100
    ticks = [-(-((k + 1) * ONE - 65_000) * CYCLE // speed) for k in range(first, first + 1000)]
    assert [train.end(k) for k in range(first, first + 1000)] == [77 + tick for tick in ticks]
    assert train.ends(first, first + 1000).tolist() == ticks
    near = [ps for k in range(first - 100, first + 1) if (ps := train.clock.ps(train.end(k))) < 9 * 10**18]
    assert train.times(first - 99, first - 100 + len(near)).tolist() == near
    assert train.count_many(np.array(near)).tolist() == list(range(first - 99, first - 99 + len(near)))
    assert train.steps > train.count(1 << 80) > first + 10**6


@rows("speed", [1, 3, 7, 1021, ONE + 1, 1_000_003, TOP - 3])
def test_rounding_up_is_exact_at_every_speed(speed):
    steps = BLOCK + 1000
    ticks = [-(-((k + 1) * ONE + 12_345) * CYCLE // speed) for k in range(steps)]
    train = CycleTrain(MHZ25, 0, Linear(speed), OPEN, -12_345)
    assert train.ends(0, steps).tolist() == ticks
    assert train.ends(500, steps).tolist() == ticks[500:]


def test_a_stationary_train_has_no_steps():
    for law in (Linear(0), SCurve([JerkPiece(0, 1, ONE << PLACES, 0, 0, 0), JerkPiece(9, 7, ONE << PLACES, 0, 0, 0)])):
        train = CycleTrain(MHZ25, 5, law, 9, ONE - 1)
        assert (train.steps, train.end(0), train.count(10**15)) == (0, 5 + 9 * CYCLE, 0)
        assert train.times(1, train.steps).tolist() == []
        assert train.positions(0, 10).tolist() == [ONE - 1] * 10


def test_begins_go_into_a_buffer():
    for train in (CycleTrain(MHZ25, 9, Linear(0, 9999), 500, 777), StepTrain(MHZ25, 9, ((8192, 900), (77, 2000)))):
        buffer = np.full(3000, -1)
        found = train.times(301, 1900, buffer)
        assert found.base is buffer and np.array_equal(found, train.times(301, 1900))
        assert np.array_equal(buffer[:1600], found) and (buffer[1600:] == -1).all()


# ------------------------------------------------------------------------------------------------------------- S-curves
def test_an_s_curve_is_the_sum_of_its_pieces():
    random = Random(8)
    for _ in range(100):
        curve = pieces(random, random.choice([1, 3, 30]), random.choice([1, 511]))
        cycles = curve[-1].cycle
        first = random.randrange(cycles + 1)
        law = SCurve(curve, first)
        positions, displacements, phases = (numbers[first:] for numbers in walked(curve))
        travels = [(position >> PLACES) - (positions[0] >> PLACES) for position in positions]
        velocities = [displacement >> PLACES for displacement in displacements]
        assert [law.travel(i) for i in range(cycles - first + 1)] == travels
        assert [law.velocity(i) for i in range(cycles - first)] == velocities
        assert [law.phase(i) for i in range(cycles - first)] == phases
        asked = random.sample(range(cycles - first), cycles - first)
        assert law.travels(np.array([*asked, cycles - first])).tolist() == [travels[i] for i in asked] + [travels[-1]]
        assert law.velocities(np.array(asked, int)).tolist() == [velocities[i] for i in asked]
        assert law.phases(np.array(asked, int)).tolist() == [phases[i] for i in asked]


@pytest.mark.parametrize("most", [1 << 10, 1 << 16, (1 << 21) - 1])
def test_long_s_curves_are_exact_where_products_overflow(most):
    """The longest ones: phases of 2^21 cycles, positions of 2^47, displacements of 2^25 in 1/65536 step."""
    random = Random(most)
    for _ in range(10):
        curve = pieces(random, most, min(511, (1 << 28) // most))
        curve.insert(-1, JerkPiece(curve[-1].cycle, 4, curve[-1].position, 3 << PLACES, 0, 0))
        end = curve[-2].cycle + (1 << 44)  # it coasts for long
        curve[-1] = JerkPiece(end, 7, curve[-2].covered(end), 0, 0, 0)
        law = SCurve(curve)
        asked = [0, 1, end - 1, *(piece.cycle + d for piece in curve[1:-1] for d in (-1, 0, 1))]
        asked += [random.randrange(curve[-2].cycle) for _ in range(500)] + [random.randrange(end) for _ in range(9)]
        assert law.travels(np.array([*asked, end])).tolist() == [law.travel(i) for i in [*asked, end]]
        assert law.velocities(np.array(asked)).tolist() == [law.velocity(i) for i in asked]
        i = random.randrange(1, end)
        assert CycleTrain(MHZ25, 0, law, end).step_at(i * CYCLE) == law.travel(i) // ONE


# ---------------------------------------------------------------------------------------------------------------- PULSE
@pytest.mark.parametrize("high", [False, True])
@pytest.mark.parametrize("hz", few([7 * 10**10, 10**12], 1))
@pytest.mark.parametrize("number", few((5, 10), 1))
def test_pulse_is_high_in_the_second_half_of_each_step(hz, high, number):
    clock = Clock(hz)
    for random, train, displaced in short_trains(16, clock, number):
        train = CycleTrain(clock, 5, train.law, train.cycles, train.lead, 16)
        halves = [clock.ps(5 + tick) for tick in tick_by_tick(displaced, train.lead, 16, ONE // 2)]
        end = train.origin + train.length

        def plain(ps, halves=halves):
            over = bisect_right(halves, ps)
            return int(high) if over == 0 else over % 2

        for until in bounds(random, [5, end], clock):
            check_promise(SquareView(Playing(train, until), high), 0, clock.ps(end) + 5, plain, until)


def test_pulse_at_top_speed_changes_every_8_ticks():
    view = SquareView(Playing(CycleTrain(MHZ25, 100, Linear(TOP), OPEN)), False)
    times, levels = view.edges(0, MHZ25.ps(100 + 10 * CYCLE))
    assert times.tolist() == [MHZ25.ps(100 + 8 * n) for n in range(1, 10 * CYCLE // 8 + 1)]
    assert levels.tolist() == [1, 0] * (10 * CYCLE // 16)


# ------------------------------------------------------------------------------------------------------------- the axis
def test_an_axis_follows_trains_of_cycles_to_and_fro():
    random = Random(9)
    for _ in range(8):
        kernel = Kernel()
        axis = Axis(kernel, range(-100, 100), 90)
        past: list[tuple[int, int, int]] = []  # instant, direction, register
        position = 90
        for n in range(12):
            sign, origin = random.choice([1, -1]), n * 4 * CYCLE
            speed = random.randrange(9 * ONE)
            train = random.choice(
                (
                    CycleTrain(MHZ25, origin, Linear(speed, -(speed // 5)), random.randrange(1, 5), speed % ONE),
                    CycleTrain(MHZ25, origin, Linear(3 * ONE), 4),  # the last step is where the next train begins
                    StepTrain(MHZ25, origin, ((1000, 5),)),  # the first one is where the train begins
                )
            )
            until = random.choice([None, MHZ25.ps(origin + random.randrange(1, 4 * CYCLE))])
            axis.follow(Playing(train, until), sign)
            for k in range(train.steps):
                if until is None or MHZ25.ps(train.end(k)) < until:
                    position = (position + sign + 100) % 200 - 100
                    past.append((MHZ25.ps(train.end(k)), sign, position))
            kernel.now = kernel.seen = MHZ25.ps((n + 1) * 4 * CYCLE)
            if random.randrange(3) == 0:
                position = random.randrange(-100, 100)
                axis.load(position)
                if past and past[-1][0] == kernel.now:
                    past[-1] = (*past[-1][:2], position)
        check_past(axis, past, random)


def check_past(axis: Axis, past: list[tuple[int, int, int]], random: Random) -> None:
    """What an axis tells about windows of its past."""
    buffer = np.empty(len(past), np.int64)
    instants = [0, axis.kernel.now, *(ps + d for ps, _, _ in past for d in (-1, 0, 1))]
    for _ in range(80):
        start, stop = sorted(random.sample(instants, 2))
        inside = [entry for entry in past if start <= entry[0] <= stop]
        steps = axis.steps(start, stop)
        found = zip(steps.times_ps.tolist(), steps.directions.tolist(), steps.positions.tolist(), strict=True)
        assert list(found) == inside
        assert (steps.times_ps.dtype, steps.directions.dtype, steps.positions.dtype) == (np.int64, np.int8, np.int64)
        assert axis.count(start, stop) == len(inside)
        assert axis.times(start, stop).tolist() == [ps for ps, _, _ in inside]
        assert axis.times(start, stop, buffer).tolist() == buffer[: len(inside)].tolist() == [ps for ps, _, _ in inside]
    registers = {ps: register for ps, _, register in past}  # behind the last step of each instant
    assert [axis.position_at(ps) for ps in registers] == list(registers.values())
    assert axis.positions_at(np.array([*registers])).tolist() == list(registers.values())
