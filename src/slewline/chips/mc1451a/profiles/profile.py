r"""The law of motion of one axis, in the chipset's integers: pure functions, parameters in, runs of cycles out.

In every cycle of 327.68 µs the chipset chooses a displacement.  Distances are in 1/65536 step, speeds in
that unit per cycle, accelerations in that unit per cycle².  A `CycleRun` is a series of cycles whose
displacements follow one law.

    speed                                                    V  maximum velocity       a  acceleration
      V          ___________________                         s  starting velocity      r  remaining distance
                /                   \
             a /|                   |\ a                     B(c): distance of a cycle at speed c and the
              / |                   | \                      braking after it: c + (c-a) + ... down to s
      s  ____|  |                   |  |____
         0  up  |      coast        | down, landing          landing: the last cycle covers the rest

In every cycle the trapezoid takes the highest speed whose B fits into r.  This rule needs no memory:
after a new destination or a new maximum in mid-move, the same rule applies with other numbers.  A run
lasts for as long as its law agrees with the rule.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isqrt
from typing import NamedTuple

from ....core.motion.train import OPEN
from .s_curves import PLACES, JerkPiece

UNIT = 1 << PLACES
SIX = 6 << 16 + 2 * PLACES  # six positions, with 16 + 3 * PLACES binary places each


class CycleRun(NamedTuple):
    """Cycles with displacements speed, speed + change, speed + 2 change ...; if `landing`, they end a move."""

    cycles: int
    speed: int
    change: int = 0
    landing: bool = False


@dataclass(frozen=True, slots=True)
class MoveLimits:
    """The limits of a move: maximum velocity V, acceleration a, starting velocity s."""

    velocity: int
    acceleration: int
    start: int

    def braking(self, speed: int) -> int:
        """Return B: the distance of a cycle at `speed` and of the deceleration after it, ending with a cycle at s."""
        a, s = self.acceleration, self.start
        cycles = -(-(speed - s) // a) if speed > s else 0
        return cycles * speed - a * cycles * (cycles - 1) // 2 + s

    def greatest(self, remaining: int) -> int:
        """Return the highest speed, at least s, whose B fits into the remaining distance; -1 if none does."""
        a, s = self.acceleration, self.start
        if remaining < s:
            return -1
        if not a:
            return s
        p = 2 * s + a
        cycles = (isqrt(p * p + 8 * a * (remaining - s)) - p) // (2 * a)  # number of whole steps of a above s
        return max(s + cycles * a, (remaining - s + a * cycles * (cycles + 1) // 2) // (cycles + 1))

    def step(self, remaining: int, speed: int) -> tuple[int, bool]:
        """Return the displacement of the next cycle, and whether that cycle reaches the destination (the landing).

        Args:
            remaining: the distance to the destination; zero or negative if the axis has reached or passed it.
            speed: the speed of the previous cycle, not negative.
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
        """Return the speed that follows `speed` in a deceleration: it falls to s first, then to zero."""
        return 0 if speed <= self.start else max(speed - self.acceleration, self.start)


def trapezoid(limits: MoveLimits, remaining: int, speed: int) -> CycleRun:
    """Return the next run of a point-to-point move with linear ramps; `speed` is that of the previous cycle."""
    first, landing = limits.step(remaining, speed)
    if landing:
        return CycleRun(1, first, landing=True)
    if not first:
        return CycleRun(1, 0)
    second, landing = limits.step(remaining - first, first)
    change = second - first
    if landing or not second:
        return CycleRun(1, first)

    def same(i: int) -> bool:
        """Return whether the rule changes the speed by `change` again after cycle i of the run, without a landing."""
        before = first + i * change
        left = remaining - first * (i + 1) - change * (i * (i + 1) // 2)
        if before + change <= 0 or left <= 0 < remaining:
            return False
        return limits.step(left, before) == (before + change, False)

    return CycleRun(1 + holds(same, expected(limits, remaining, first, change)), first, change)


def expected(limits: MoveLimits, remaining: int, first: int, change: int) -> int:
    """Return an estimate of the length of a run in cycles, from which the search for the exact length starts."""
    if change > 0:
        return (limits.velocity - first) // change
    if change < 0:
        return (first - limits.start) // -change
    return max(remaining - (limits.braking(first) if limits.acceleration else 0), 0) // first


def holds(same: Callable[[int], bool], guess: int) -> int:
    """Return the smallest i for which same(i) is False, by exponential search from a guess.

    `same` must be monotonic: once False, it remains False.
    """
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


def brake(limits: MoveLimits, speed: int, floor: int = 0) -> CycleRun:
    """Return the next run of a deceleration to the speed `floor`; if the axis is at rest, a run at speed 0.

    If `floor` is 0, the speed falls to s first, and then to zero.
    """
    a, s = limits.acceleration, limits.start
    if floor:
        if speed - a <= floor:
            return CycleRun(OPEN, floor)
        return CycleRun((speed - floor - 1) // a, speed - a, -a)
    first = limits.slower(speed)
    if not first:
        return CycleRun(1, 0)
    if first == s or first >= speed:  # without acceleration a speed above s is unchanged
        return CycleRun(1 if first == s else OPEN, first)
    return CycleRun(1 + (first - s - 1) // a, first, -a)


def contour(limits: MoveLimits, speed: int) -> CycleRun:
    """Return the next run of velocity contouring in the commanded direction: up or down to V, then at V without end."""
    a, top = limits.acceleration, limits.velocity
    if speed > top:
        return brake(limits, speed, top) if a else CycleRun(OPEN, speed)
    if not a:
        return CycleRun(OPEN, speed)
    first = min(top, max(speed + a, limits.start))
    if first == top:
        return CycleRun(OPEN, top)
    return CycleRun(1 + (top - first - 1) // a, first, a)


# ------------------------------------------------------------------------------------------------------------- S-curves
class Phases(NamedTuple):
    """An S-curve, defined by the durations of its phases, which may end within a cycle.

    Times are in 2^-PLACES cycle.  In phases 1 and 2, positions are computed from the start; in phases 3 to
    5, as deviations from the straight line that phase 4 follows; in phases 6 and 7, back from the
    destination.  So the error from rounding the times, less than 2^-30 of 1/65536 step, does not accumulate.
    """

    jerked: int  # phases 1, 3, 5, 7
    steady: int  # phases 2, 6
    coasting: int  # phase 4
    distance: int  # 2^-PLACES of 1/65536 step
    velocity: int  # 1/65536 step per cycle; the maximum, above or equal to the peak
    acceleration: int  # the same per cycle^2, likewise
    jerk: int  # 2^-32 step per cycle^3

    @property
    def lengths(self) -> tuple[int, ...]:
        """The durations of phases 1 to 7, in 2^-PLACES cycle."""
        t1, t2, t4 = self.jerked, self.steady, self.coasting
        return t1, t2, t1, t4, t1, t2, t1

    @property
    def cycles(self) -> int:
        """The number of cycles of the move, rounded up."""
        return ceil(sum(self.lengths), UNIT)

    @property
    def peak(self) -> int:
        """The highest velocity, that of phase 4; its unit is 2^-(16 + 2 * PLACES) of 1/65536 step per cycle."""
        fast = self.jerked + self.steady
        reached = min(self.jerk * self.jerked, self.acceleration << 16 + PLACES)
        return min(self.velocity << 16 + 2 * PLACES, reached * fast)

    def stopped(self, done: int) -> Phases:
        """Return the whole S-curve that results if a smooth stop begins after `done` cycles.

        The deceleration mirrors the acceleration: phases 1, 2 and 4 are shortened to the part done so far.
        """
        t1, t2, t4 = self.jerked, self.steady, self.coasting
        passed = done * UNIT
        jerked = min(t1, passed)
        steady = min(t2, passed - jerked)
        coasting = min(t4, max(passed - 2 * t1 - t2, 0))
        if (jerked, steady, coasting) == (t1, t2, t4):
            return self
        curve = self._replace(jerked=jerked, steady=steady, coasting=coasting)
        return curve._replace(distance=curve.peak * (2 * jerked + steady + coasting) >> 16 + 2 * PLACES)

    def pieces(self) -> list[JerkPiece]:
        """Return the curve in pieces: the cycles within one phase, and each single cycle that spans several phases.

        A cycle that spans several phases counts as part of the first of these phases that has jerk.
        """
        found, ends, begin = [], [], 0
        for phase, length in enumerate(self.lengths, 1):
            end, cycle = begin + length, ceil(begin, UNIT)
            if cycle * UNIT < end:
                found.append(self._piece(phase, cycle))
                ends.append(end)
            begin = end
        pieces, stays = [], JerkPiece(self.cycles, 7, self.distance, 0, 0, 0)  # end of the move
        for piece, following, end in zip(found, [*found[1:], stays], ends, strict=True):
            last = following.cycle - 1
            if not end & UNIT - 1:
                pieces.append(piece)
                continue
            if last > piece.cycle:
                pieces.append(piece)
            position = piece.covered(last)
            pieces.append(JerkPiece(last, piece.phase | 1, position, following.position - position, 0, 0))
        return [*pieces, stays]

    def _piece(self, phase: int, cycle: int) -> JerkPiece:
        """Return the piece formed by the cycles within a phase; `cycle` is the first of these cycles.

        The piece's numbers, including the positions, are rounded up during acceleration and down after it, so
        that no cycle's displacement exceeds that of a cycle at the maximum velocity.
        """
        x6, v2, a, j = self._state(phase, cycle * UNIT)
        speed, change = 3 * ((v2 << PLACES) + (a << 2 * PLACES)) + (j << 3 * PLACES), a + (j << PLACES)
        up = -1 if phase <= 3 else 1
        position, speed, change = up * (up * x6 // SIX), up * (up * speed // SIX), up * (up * change >> 16)
        return JerkPiece(cycle, phase, position, speed, change, j << PLACES - 16)

    def _state(self, phase: int, t: int) -> tuple[int, int, int, int]:
        """Return six times the position, twice the velocity, the acceleration and the jerk at a time in a phase.

        All are integers, and so exact.  Their units are these fractions of 1/65536 step: 2^-(16 + 3 * PLACES) for
        the position; 2^-(16 + 2 * PLACES), per cycle, for the velocity; 2^-(16 + PLACES), per cycle^2, for the
        acceleration; and 2^-16, per cycle^3, for the jerk.
        """
        t1, j = self.jerked, self.jerk
        if phase <= 2:
            return self._risen(phase, t)
        if phase >= 6:  # like phases 2 and 1, from the other end
            x6, v2, a, j = self._risen(8 - phase, sum(self.lengths) - t)
            return self.distance * SIX - x6, v2, -a, j
        risen, peak = 2 * t1 + self.steady, self.peak
        line = 3 * peak * (2 * t - risen)
        if phase == 4:
            return line, 2 * peak, 0, 0
        t = risen - t if phase == 3 else t - risen - self.coasting
        bent = j * t**3
        if phase == 3:
            return line + bent, 2 * peak - j * t * t, j * t, -j
        return line - bent, 2 * peak - j * t * t, -j * t, -j

    def _risen(self, phase: int, t: int) -> tuple[int, int, int, int]:
        """Return the values of `_state` at time `t`, which is in phase 1 or 2."""
        t1, steep, j = self.jerked, self.acceleration << 16 + PLACES, self.jerk
        if phase == 1:
            return j * t**3, j * t * t, j * t, j
        return steep * (3 * t * (t - t1) + t1 * t1), steep * (2 * t - t1), steep, 0


def s_curve(distance: int, velocity: int, acceleration: int, jerk: int) -> Phases:
    """Return the phases of a move: the times of the continuous profile, each rounded up to 2^-PLACES cycle.

    Args:
        distance: 1/65536 step, positive.
        velocity: 1/65536 step per cycle, positive.
        acceleration: 1/65536 step per cycle^2, positive.
        jerk: 2^-32 step per cycle^3, positive.
    """
    d, v, a, j = distance << 16, velocity << 16, acceleration << 16, jerk
    t4 = 0
    if v * j >= a * a and d * a * j >= v * (v * j + a * a):  # both maxima are reached
        t1, fast = ceil(a << PLACES, j), ceil(v << PLACES, a)
        t2, t4 = fast - t1, ceil(d << PLACES, v) - fast - t1
    elif v * j < a * a and d * d * j >= 4 * v**3:  # the maximum velocity is reached
        t1, t2 = square_root(ceil(v << 2 * PLACES, j)), 0
        t4 = ceil(d << PLACES, v) - 2 * t1
    elif d * j * j >= 2 * a**3:  # the maximum acceleration is reached
        t1 = ceil(a << PLACES, j)
        t2 = ceil(square_root(t1 * t1 + ceil(4 * d << 2 * PLACES, a)) - 3 * t1, 2)
    else:
        t1, t2 = cube_root(ceil(d << 3 * PLACES, 2 * j)), 0
    return Phases(t1, max(t2, 0), max(t4, 0), distance * UNIT, velocity, acceleration, jerk)


def ceil(a: int, b: int) -> int:
    """Return a / b, rounded up."""
    return -(-a // b)


def square_root(number: int) -> int:
    """Return the square root of a positive number, rounded up."""
    return isqrt(number - 1) + 1


def cube_root(number: int) -> int:
    """Return the cube root of a positive number, rounded up; by Newton's method from above."""
    root = 1 << ceil(number.bit_length(), 3)
    while (lower := (2 * root + number // (root * root)) // 3) < root:
        root = lower
    return root + (root**3 < number)
