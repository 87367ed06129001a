"""The law of motion of one axis, in the integers of the chipset: pure functions, parameters in, runs of cycles out.

Every cycle of 327.68 us the chipset chooses a displacement.  Distances are in 1/65536 step, speeds in the same per
cycle, accelerations per cycle and cycle.  A `Run` is a number of cycles whose displacements follow one law.

    speed                                                    V  maximum velocity       a  acceleration
      V          ___________________                         s  starting velocity      r  remaining distance
                /                   \\
             a /|                   |\\ a                     B(c): what is left behind when a cycle at speed c is
              / |                   | \\                      followed by braking: c + (c-a) + ... down to s
      s  ____|  |                   |  |____
         0  up  |      coast        | down, landing          landing: the last cycle covers what remains

In every cycle the trapezoid takes the greatest speed whose B fits into r.  That rule needs no memory: a new
destination or a new maximum in mid-move is the same rule with other numbers, and every run is the rule applied for as
long as it says the same.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isqrt
from typing import NamedTuple

from ...core.train import OPEN


class Run(NamedTuple):
    """Cycles whose displacements are speed, speed + change, speed + 2 change ...; `landing` ends a move."""

    cycles: int
    speed: int
    change: int = 0
    landing: bool = False


@dataclass(frozen=True, slots=True)
class Limits:
    """What a move may do: maximum velocity V, acceleration a, starting velocity s."""

    velocity: int
    acceleration: int
    start: int

    def braking(self, speed: int) -> int:
        """B: the distance of a cycle at this speed and of the braking behind it, one cycle at s included."""
        a, s = self.acceleration, self.start
        cycles = -(-(speed - s) // a) if speed > s else 0
        return cycles * speed - a * cycles * (cycles - 1) // 2 + s

    def greatest(self, remaining: int) -> int:
        """The greatest speed of at least s whose B fits into a distance; -1 if none does."""
        a, s = self.acceleration, self.start
        if remaining < s:
            return -1
        if not a:
            return s
        p = 2 * s + a
        cycles = (isqrt(p * p + 8 * a * (remaining - s)) - p) // (2 * a)  # so many whole steps of a above s
        return max(s + cycles * a, (remaining - s + a * cycles * (cycles + 1) // 2) // (cycles + 1))

    def step(self, remaining: int, speed: int) -> tuple[int, bool]:
        """The displacement of the next cycle, and whether it is the landing.

        Args:
            remaining: distance to the destination; not positive if that lies behind.
            speed: that of the cycle before, not negative.
        """
        jump = max(self.acceleration, self.start)
        slower = speed - self.acceleration
        if 0 <= remaining <= min(max(self.velocity, slower), jump) and speed <= remaining + jump:
            return remaining, True
        if remaining > 0:
            best = self.greatest(remaining)
            if best >= max(slower, self.start):
                return min(best, max(min(self.velocity, max(speed + self.acceleration, self.start)), slower)), False
        return self.slower(speed), False

    def slower(self, speed: int) -> int:
        """The next speed when braking: down to s, then zero."""
        return 0 if speed <= self.start else max(speed - self.acceleration, self.start)


def trapezoid(limits: Limits, remaining: int, speed: int) -> Run:
    """The next run of a point-to-point move with linear ramps."""
    first, landing = limits.step(remaining, speed)
    if landing:
        return Run(1, first, landing=True)
    if not first:
        return Run(1, 0)
    second, landing = limits.step(remaining - first, first)
    change = second - first
    if landing or not second:
        return Run(1, first)

    def same(i: int) -> bool:
        """Does the rule go on like this behind cycle i?"""
        before = first + i * change
        left = remaining - first * (i + 1) - change * (i * (i + 1) // 2)
        if before + change <= 0 or left <= 0 < remaining:
            return False
        return limits.step(left, before) == (before + change, False)

    return Run(1 + holds(same, expected(limits, remaining, first, change)), first, change)


def expected(limits: Limits, remaining: int, first: int, change: int) -> int:
    """How long a run may be expected to go on; a guess, which only saves time."""
    if change > 0:
        return (limits.velocity - first) // change
    if change < 0:
        return (first - limits.start) // -change
    return max(remaining - (limits.braking(first) if limits.acceleration else 0), 0) // first


def holds(same: Callable[[int], bool], guess: int) -> int:
    """The first i for which something that holds up to there holds no longer; looked for around a guess."""
    if guess > 0 and not same(guess - 1):
        low, high = 0, guess - 1
    else:
        low, width = max(guess, 0), 1
        while same(low + width - 1):
            low, width = low + width, width * 2
        high = low + width - 1
    while low < high:
        middle = (low + high) // 2
        if same(middle):
            low = middle + 1
        else:
            high = middle
    return low


def brake(limits: Limits, speed: int, floor: int = 0) -> Run:
    """The next run on the way down to `floor` (0: by way of s); a run of speed 0 ends it."""
    a, s = limits.acceleration, limits.start
    if floor:
        if speed - a <= floor:
            return Run(OPEN, floor)
        return Run((speed - floor - 1) // a, speed - a, -a)
    first = limits.slower(speed)
    if not first:
        return Run(1, 0)
    if first == s or first >= speed:  # without acceleration a speed above s stays as it is
        return Run(1 if first == s else OPEN, first)
    return Run(1 + (first - s - 1) // a, first, -a)


def contour(limits: Limits, speed: int) -> Run:
    """The next run of velocity contouring in the commanded direction: up to V, or down to it, and on for ever."""
    a, top = limits.acceleration, limits.velocity
    if speed > top:
        return brake(limits, speed, top) if a else Run(OPEN, speed)
    if not a:
        return Run(OPEN, speed)
    first = min(top, max(speed + a, limits.start))
    if first == top:
        return Run(OPEN, top)
    return Run(1 + (top - first - 1) // a, first, a)


# ------------------------------------------------------------------------------------------------------------- S-curves
class Phases(NamedTuple):
    """An S-curve: phases of n1, n2, n1, n4, n1, n2, n1 cycles, whose jerk is such that they cover `distance` / `whole`
    of the distance that a jerk of one unit would cover in them."""

    jerked: int  # n1
    steady: int  # n2
    coasting: int  # n4
    distance: int  # 1/65536 step
    whole: int

    @property
    def lengths(self) -> tuple[int, ...]:
        """Cycles of the phases 1 to 7."""
        n1, n2, n4 = self.jerked, self.steady, self.coasting
        return n1, n2, n1, n4, n1, n2, n1

    @property
    def cycles(self) -> int:
        """Cycles of the move."""
        return sum(self.lengths)

    def phase(self, cycle: int) -> int:
        """The phase, 1 to 7, of a cycle of the move."""
        for number, length in enumerate(self.lengths, 1):
            if cycle < length:
                return number
            cycle -= length
        return 7

    def stopped(self, done: int) -> Phases:
        """What becomes of the move when it is told to stop smoothly after so many cycles.

        It decelerates as it has accelerated: phases that have been entered are cut to what has been done of them.
        """
        n1, n2, n4 = self.jerked, self.steady, self.coasting
        if done < n1:
            return self._replace(jerked=done, steady=0, coasting=0)
        if done < n1 + n2:
            return self._replace(steady=done - n1, coasting=0)
        return self._replace(coasting=min(n4, max(done - 2 * n1 - n2, 0)))


def s_curve(distance: int, velocity: int, acceleration: int, jerk: int) -> Phases:
    """The phases of a move: the times of the continuous profile, each rounded up to whole cycles.

    Longer phases only make velocity, acceleration and jerk smaller, so no limit is exceeded.

    Args:
        distance: 1/65536 step, positive, as are velocity and acceleration.
        jerk: 2^-32 step per cycle^3, positive.
    """
    d, v, a, j = distance << 16, velocity << 16, acceleration << 16, jerk
    reached = v * j >= a * a  # the maximum acceleration, on the way to the maximum velocity
    if reached and d * a * j >= v * (v * j + a * a):
        n1, n2 = ceil(a, j), ceil(v * j - a * a, a * j)
        n4 = ceil(d * a * j - v * (v * j + a * a), v * a * j)
    elif not reached and d * d * j >= 4 * v**3:
        n1, n2 = least(lambda n: n * n * j >= v, isqrt(v // j)), 0
        n4 = ceil(d - isqrt(4 * v**3 // j), v)
    elif d * j * j >= 2 * a**3:
        n1, n4 = ceil(a, j), 0
        root = isqrt(a * a + 4 * d * j * j // a)
        n2 = least(lambda n: a * (a + n * j) * (2 * a + n * j) >= d * j * j, max(root - 3 * a, 0) // (2 * j))
    else:
        n1, n2, n4 = least(lambda n: 2 * n**3 * j >= d, cube_root(d // (2 * j))), 0, 0
    return Phases(n1, n2, n4, distance, n1 * (n1 + n2) * (2 * n1 + n2 + n4))


def ceil(a: int, b: int) -> int:
    """a / b rounded up."""
    return -(-a // b)


def cube_root(number: int) -> int:
    """The whole part of the cube root, by Newton's method from above."""
    root = 1 << -(-number.bit_length() // 3)
    while root**3 > number:
        root = (2 * root + number // (root * root)) // 3
    return root


def least(enough: Callable[[int], bool], guess: int) -> int:
    """The least number that is enough, near a guess that is hardly too large."""
    while guess > 0 and enough(guess - 1):
        guess -= 1
    while not enough(guess):
        guess += 1
    return guess
