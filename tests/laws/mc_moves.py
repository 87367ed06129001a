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

from slewline.chips.mc1451a.profile import Limits, Phases, Run, s_curve, trapezoid
from slewline.core.cycles import SCurve

ONE = 1 << 16
CYCLES = 10**6  # longer moves are not asked for
SHORT = 3000  # S-curves up to so many cycles are looked at cycle by cycle


@dataclass
class Worst:
    """The extremes of what was measured, each with the move that gave it."""

    least: dict[str, tuple[float, Any]] = field(default_factory=dict)
    most: dict[str, tuple[float, Any]] = field(default_factory=dict)
    moves: int = 0

    def note(self, what: str, value: float, move: Any) -> None:
        if what not in self.most or value > self.most[what][0]:
            self.most[what] = (value, move)
        if what not in self.least or value < self.least[what][0]:
            self.least[what] = (value, move)

    def __str__(self) -> str:
        lines = [f"{self.moves} moves"]
        for what, (value, move) in self.most.items():
            lines.append(f"{what}: {self.least[what][0]:.3f} ... {value:.3f}, the last by {move}")
        return "\n".join(lines)


# ---------------------------------------------------------------------------------------------------------- trapezoids
def runs_of(limits: Limits, distance: int, speed: int = 0) -> Iterator[tuple[Run, int]]:
    """The runs of a move, each with the distance that remains when it begins; ends with the landing."""
    while True:
        run = trapezoid(limits, distance, speed)
        yield run, distance
        distance -= covered(run, run.cycles)
        speed = run.speed + run.change * (run.cycles - 1)
        if run.landing:
            assert distance == 0
            return


def covered(run: Run, cycles: int) -> int:
    """How far some cycles of a run lead."""
    return run.speed * cycles + run.change * cycles * (cycles - 1) // 2


def ideal(distance: int, limits: Limits) -> float:
    """Cycles that the continuous profile takes."""
    v, a, s = limits.velocity, limits.acceleration, limits.start
    ramps = (v * v - s * s) / a
    if distance >= ramps:
        return 2 * (v - s) / a + (distance - ramps) / v
    return 2 * (distance / (s + sqrt(s * s + a * distance)))


def check_trapezoid(distance: int, limits: Limits, worst: Worst) -> None:
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


def random_trapezoid(chance: Random) -> tuple[int, Limits] | None:
    """A move of at most CYCLES; velocity and acceleration not zero, extremes among them."""
    velocity = numbers(chance, 25)
    limits = Limits(velocity, numbers(chance, 30), min(chance.choice([0, 0, numbers(chance, 30)]), velocity))
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
    n1, n2, n4 = phases.jerked, phases.steady, phases.coasting
    assert phases.whole == n1 * (n1 + n2) * (2 * n1 + n2 + n4) and min(n1 - 1, n2, n4) >= 0, move
    assert distance * ONE <= jerk * phases.whole, move  # the law's own jerk, acceleration and velocity, exactly
    assert distance * n1 <= acceleration * phases.whole, move
    assert distance * n1 * (n1 + n2) <= velocity * phases.whole, move
    beyond = phases.cycles - continuous(distance, velocity, acceleration, jerk / ONE)
    worst.note("S-curve: cycles beyond the ideal", beyond, move)
    assert -2 <= beyond <= 9, move
    law = SCurve(distance, phases.whole, phases.lengths)
    assert law.travel(phases.cycles) == distance and law.travel(phases.cycles - 1) <= distance, move
    if phases.cycles <= SHORT:
        check_cycles(law, phases, move)


def check_cycles(law: SCurve, phases: Phases, move: tuple[int, int, int, int]) -> None:
    """Velocities and displacements, in whole 1/65536 step: both are rounded down."""
    distance, velocity, acceleration, jerk = move
    travelled = law.travels(np.arange(phases.cycles + 1))
    speeds, displaced = law.velocities(np.arange(phases.cycles)), np.diff(travelled)
    assert travelled[0] == 0 and travelled[-1] == distance and displaced.min() >= 0 and speeds.min() >= 0, move
    assert np.abs(displaced - speeds).max() <= 1 and max(speeds.max(), displaced.max()) <= velocity, move
    assert np.abs(np.diff(speeds, prepend=0)).max() <= acceleration + 1, move
    assert np.abs(np.diff(speeds, 2, prepend=[0, 0])).max() <= -(-jerk // ONE) + 2, move


def random_curve(chance: Random) -> tuple[int, int, int, int] | None:
    move = (numbers(chance, 31) * ONE, numbers(chance, 25), min(numbers(chance, 15), 32767), numbers(chance, 31))
    move = (*move[:3], min(move[3], (1 << 31) - 1))
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
            limits = Limits(velocity, acceleration, min(start, velocity))
            cut = chance.randrange(1, 3000) if left else CYCLES * 10**6
            position, speed, sign = follow(limits, position, speed, sign, destination, cut)
            changes += 1
        assert (position, speed) == (destination, 0), (position, destination)
    return changes


def follow(limits: Limits, position: int, speed: int, sign: int, destination: int, cut: int) -> tuple[int, int, int]:
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
    print(f"{check_retargets(count // 10)} retargets: all arrive")
