"""Random point-to-point moves of the MC1451A's law of motion, checked run by run; also as a program.

    python -m tests.laws.mc_moves 1000000

Every move is followed through its runs, not its cycles, so that moves of a million cycles cost no more than short ones.
What is measured is told at the end: the worst of a million is worth more than a yes.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import sqrt
from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slewline.chips.mc1451a.profiles.profile import UNIT, CycleRun, MoveLimits, Phases, s_curve, trapezoid
from slewline.chips.mc1451a.profiles.s_curves import SCurve
from slewline.chips.mc1451a.twin.twin_profile import TwinSCurve as Twin

ONE = 1 << 16
CYCLES = 10**6  # longer moves are not asked for
JERK = (1 << 31) - 1
SHORT = 3000  # S-curves up to so many cycles are looked at cycle by cycle
EVEN = 1e-9  # floating point is right to so much of a duration


@dataclass
class Worst:
    """The extremes of what was measured, each with the move that gave it."""

    least: dict[str, tuple[float, Any]] = field(default_factory=dict)
    most: dict[str, tuple[float, Any]] = field(default_factory=dict)
    moves: int = 0
    coasting: int = 0  # S-curves that coast for three cycles or more

    def note(self, what: str, value: float, move: Any) -> None:
        if what not in self.most or value > self.most[what][0]:
            self.most[what] = (value, move)
        if what not in self.least or value < self.least[what][0]:
            self.least[what] = (value, move)

    def __str__(self) -> str:
        lines = [f"{self.moves} moves, {self.coasting} of them S-curves that coast for three cycles or more"]
        for what, (value, move) in self.most.items():
            lines.append(f"{what}: {self.least[what][0]:.3f} ... {value:.3f}, the last by {move}")
        return "\n".join(lines)


# ---------------------------------------------------------------------------------------------------------- trapezoids
def runs_of(limits: MoveLimits, distance: int, speed: int = 0) -> Iterator[tuple[CycleRun, int]]:
    """The runs of a move, each with the distance that remains when it begins; ends with the landing."""
    while True:
        run = trapezoid(limits, distance, speed)
        yield run, distance
        distance -= covered(run, run.cycles)
        speed = run.speed + run.change * (run.cycles - 1)
        if run.landing:
            assert distance == 0
            return


def covered(run: CycleRun, cycles: int) -> int:
    """How far some cycles of a run lead."""
    return run.speed * cycles + run.change * cycles * (cycles - 1) // 2


def ideal(distance: int, limits: MoveLimits) -> float:
    """Cycles that the continuous profile takes."""
    v, a, s = limits.velocity, limits.acceleration, limits.start
    ramps = (v * v - s * s) / a
    if distance >= ramps:
        return 2 * (v - s) / a + (distance - ramps) / v
    return 2 * (distance / (s + sqrt(s * s + a * distance)))


def check_trapezoid(distance: int, limits: MoveLimits, worst: Worst) -> None:
    """One move from rest: exact, within its limits, as long as it must be."""
    v, a, s = limits.velocity, limits.acceleration, limits.start
    move = (distance, v, a, s)
    cycles = rising = falling = 0
    before: int | None = None
    for run, remaining in runs_of(limits, distance):
        last = run.speed + run.change * (run.cycles - 1)
        assert 0 < run.speed <= v and 0 < last <= v, move
        assert remaining > 0 and abs(run.change) <= a, move
        if before is None:
            assert run.speed <= max(a, s), move
        elif run.landing:
            assert run.cycles == 1 and run.speed == remaining <= max(a, s) and before - run.speed <= max(a, s), move
        else:
            assert abs(run.speed - before) <= a, move
        if not run.landing:
            step = 0 if before is None else run.speed - before
            rising += (step > 0) + (run.cycles - 1) * (run.change > 0)
            falling += (step < 0) + (run.cycles - 1) * (run.change < 0)
        cycles, before = cycles + run.cycles, last
    beyond = cycles - ideal(distance, limits)
    worst.note("trapezoid: cycles beyond the ideal", beyond, move)
    worst.note("trapezoid: cycles rising less falling", rising - falling, move)
    assert -2 <= beyond <= 4 and abs(rising - falling) <= 1, move


def random_trapezoid(chance: Random) -> tuple[int, MoveLimits] | None:
    """A move of at most CYCLES; velocity and acceleration not zero, extremes among them."""
    velocity = numbers(chance, 25)
    limits = MoveLimits(velocity, numbers(chance, 30), min(chance.choice([0, 0, numbers(chance, 30)]), velocity))
    distance = numbers(chance, 31) * ONE + chance.choice([0, 0, chance.randrange(ONE)])
    return None if ideal(distance, limits) > CYCLES else (distance, limits)


def numbers(chance: Random, bits: int) -> int:
    """A number from 1 up to 2 to so many bits, evenly over its length; now and then an end of the range."""
    if chance.random() < 0.05:
        return chance.choice([1, 2, (1 << bits) - 1, 1 << bits])
    return int(2 ** chance.uniform(0, bits))


# ------------------------------------------------------------------------------------------------------------- S-curves
def continuous(distance: int, velocity: int, acceleration: int, jerk: float) -> float:
    """Cycles of the continuous S-curve; the jerk in 1/65536 step per cycle^3."""
    d, v, a, j = float(distance), float(velocity), float(acceleration), jerk

    def ramp(top: float) -> float:
        return top / a + a / j if top * j >= a * a else 2 * sqrt(top / j)

    if d >= v * ramp(v):
        return ramp(v) + d / v
    peak = (d * d * j / 4) ** (1 / 3)
    if peak * j >= a * a:
        peak = (sqrt(a**4 / j**2 + 4 * a * d) - a * a / j) / 2
    return 2 * ramp(peak)


def check_curve(distance: int, velocity: int, acceleration: int, jerk: int, worst: Worst) -> None:
    """One S-curve from rest to rest."""
    move = (distance, velocity, acceleration, jerk)
    phases = s_curve(*move)
    law, cycles = SCurve(phases.pieces()), phases.cycles
    beyond = cycles - continuous(distance, velocity, acceleration, jerk / ONE)
    worst.note("S-curve: cycles beyond the ideal", beyond, move)
    assert -EVEN * cycles <= beyond < 1 + EVEN * cycles, move
    if cycles <= SHORT:
        asked = np.arange(cycles)
    else:  # where one phase passes over to the next
        asked = np.unique(np.add.outer(law.cycles, range(-4, 4)))
        asked = asked[(asked >= 0) & (asked < cycles)]
    check_cycles(law, asked, move)
    if phases.coasting >= 3 * UNIT:
        check_coast(law, phases, move)
        worst.coasting += 1


def check_cycles(law: SCurve, cycles: NDArray[np.int64], move: tuple[int, int, int, int]) -> None:
    """Velocities and displacements of successive cycles, in whole 1/65536 step: both are rounded down.

    A position is rounded as well, so that what three or four of them tell is less exact by a unit or two.
    """
    distance, velocity, acceleration, jerk = move
    speeds, phases = law.velocities(cycles), law.phases(cycles)
    before, behind = law.travels(cycles), law.travels(cycles + 1)
    displaced = behind - before
    assert (before[0], behind[-1]) == (0, distance) and np.diff(phases).min(initial=0) >= 0, move
    assert min(displaced.min(), speeds.min()) >= 0 and max(displaced.max(), speeds.max()) <= velocity, move
    assert np.abs(displaced - speeds).max() <= 1, move
    at = np.concatenate([[-2, -1], cycles, cycles[-1] + [1, 2]])  # at rest at both ends
    next_, next_but_one = np.diff(at) == 1, at[2:] - at[:-2] == 2
    for found, more in ((speeds, 0), (displaced, 1)):
        found = np.concatenate([[0, 0], found, [0, 0]])
        assert np.abs(np.diff(found)[next_]).max() <= acceleration + more, move
        assert np.abs(np.diff(found, 2)[next_but_one]).max() <= -(-jerk // ONE) + 1 + 2 * more, move
    for phase, change in ((2, acceleration), (4, 0), (6, -acceleration)):
        inside = (phases[:-1] == phase) & (phases[1:] == phase) & next_[2:-2]
        assert (np.diff(speeds)[inside] == change).all(), move


def check_coast(law: SCurve, phases: Phases, move: tuple[int, int, int, int]) -> None:
    """A curve that coasts for three cycles or more does so at the velocity that was set, and at no other."""
    rising = sum(phases.lengths[:3])
    first, last = -(-rising // UNIT), (rising + phases.coasting) // UNIT - 1
    assert last > first and 4 not in (law.phase(first - 1), law.phase(last + 1)), move
    for cycle in (first, first + 1, (first + last) // 2, last - 1, last):
        assert (law.phase(cycle), law.velocity(cycle)) == (4, move[1]), move
    assert law.travel(last) - law.travel(first) == (last - first) * move[1], move


def compare_with_twin(number: int, seed: int, most: int = 200) -> int:
    """Short S-curves, cycle by cycle beside the law of the slow twin; most of them are told to stop smoothly, once or
    more often.

    Returns how many stops changed something.
    """
    chance, stops = Random(seed), 0
    while number:
        move = numbers(chance, 34), numbers(chance, 25), min(numbers(chance, 15), 32767), min(numbers(chance, 31), JERK)
        phases = s_curve(*move)
        if phases.cycles > most or chance.random() * most > phases.cycles + 20:
            continue
        number -= 1
        twin = Twin(*move)
        law, first = SCurve(phases.pieces()), 0
        stop = chance.randrange(1, phases.cycles + 1) if chance.random() < 0.8 else CYCLES
        done = 0
        while done < phases.cycles:
            if done == stop or (done > stop and chance.random() < 0.1):
                twin.smooth_stop()
                stopped = phases.stopped(done)
                if stopped != phases:
                    phases, law, first = stopped, SCurve(stopped.pieces(), done), done
                    stops += 1
            i = done - first
            here = law.travel(i + 1) - law.travel(i), law.velocity(i), law.phase(i)
            assert twin.step() == here, (move, stop, done)
            done += 1
        assert twin.over, move
    return stops


def random_curve(chance: Random) -> tuple[int, int, int, int] | None:
    move = (numbers(chance, 31) * ONE, numbers(chance, 25), min(numbers(chance, 15), 32767), numbers(chance, 31))
    move = (*move[:3], min(move[3], JERK))
    return None if continuous(*move[:3], move[3] / ONE) > CYCLES else move


def check_moves(number: int, seed: int = 1) -> Worst:
    """Random moves, one half trapezoids, the other S-curves."""
    chance, worst = Random(seed), Worst()
    while worst.moves < number:
        if worst.moves % 2:
            trapezoid_ = random_trapezoid(chance)
            if trapezoid_ is None:
                continue
            check_trapezoid(*trapezoid_, worst)
        else:
            curve = random_curve(chance)
            if curve is None:
                continue
            check_curve(*curve, worst)
        worst.moves += 1
    return worst


# ------------------------------------------------------------------------------------------------------------ retargets
def check_retargets(number: int, seed: int = 1) -> int:
    """Moves whose destination and maximum velocity change on the way, again and again: each arrives.

    Returns how many changes there were.
    """
    chance, changes = Random(seed), 0
    while changes < number:
        start = chance.choice([0, numbers(chance, 20)])
        acceleration = numbers(chance, 24)
        position, speed, sign = 0, 0, 1
        for left in range(chance.randrange(1, 6), -1, -1):
            destination = chance.choice([-1, 1]) * numbers(chance, 20) * ONE
            velocity = numbers(chance, 25)
            limits = MoveLimits(velocity, acceleration, min(start, velocity))
            cut = chance.randrange(1, 3000) if left else CYCLES * 10**6
            position, speed, sign = follow(limits, position, speed, sign, destination, cut)
            changes += 1
        assert (position, speed) == (destination, 0), (position, destination)
    return changes


def follow(
    limits: MoveLimits, position: int, speed: int, sign: int, destination: int, cut: int
) -> tuple[int, int, int]:
    """Go on towards a destination, for so many cycles at most; returns position, speed and direction then."""
    passed = 0
    while passed < cut and (speed or position != destination):
        distance = destination - position
        if not speed:
            sign = 1 if distance > 0 else -1
        run = trapezoid(limits, sign * distance, speed)
        cycles = min(run.cycles, cut - passed)
        top = max(limits.velocity, speed - limits.acceleration)
        for at in (0, cycles - 1):
            assert 0 <= run.speed + at * run.change <= top
        drop = speed - run.speed
        assert -max(limits.acceleration, limits.start) <= drop <= max(limits.acceleration, limits.start), (limits, run)
        position += sign * covered(run, cycles)
        speed = run.speed + run.change * (cycles - 1)
        passed += cycles
        if run.landing and cycles == run.cycles:
            assert position == destination
            speed = 0
    return position, speed, sign


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    print(check_moves(count))
    print(f"{compare_with_twin(count // 10, seed=1, most=1000)} smooth stops: the twin does the same")
    print(f"{check_retargets(count // 10)} retargets: all arrive")
