"""The slow twin's laws of motion, one cycle at a time, in plain integers and fractions.

Distances are in 2^-16 step, and speeds in that unit per cycle.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import accumulate, pairwise
from math import ceil, floor


def sign(number: int) -> int:
    """Return -1 for a negative number, otherwise 1."""
    return -1 if number < 0 else 1


def least(holds: Callable[[int], bool]) -> int:
    """Return the smallest number n >= 0 for which `holds` is true; it must also be true for all above n."""
    high = 1
    while not holds(high):
        high *= 2
    low = 0
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle + 1, high)
    return low


def braking(speed: int, acceleration: int, start: int, room: int) -> bool:
    """Return whether the distance `room` is enough for a cycle at `speed` and a deceleration down to `start`."""
    if speed <= start:
        return start <= room
    if acceleration == 0:
        return False
    cycles = -(-(speed - start) // acceleration)  # above `start`
    return cycles * speed - acceleration * (cycles * (cycles - 1) // 2) + start <= room


def braked(speed: int, acceleration: int, start: int) -> int:
    """Return the next cycle's speed in a deceleration, after a cycle at `speed`; 0 if `speed` <= `start`."""
    return 0 if speed <= start else max(speed - acceleration, start)


def trapezoid(speed: int, room: int, most: int, acceleration: int, start: int) -> tuple[int, bool]:
    """Return the speed of the next cycle of a move, and whether the axis reaches the destination in that cycle.

    The speed is the highest from which the axis can stop in time; an axis that is already faster decelerates.
    """
    step = max(acceleration, start)
    if 0 <= room <= min(max(most, speed - acceleration), step) and speed <= room + step:
        return room, True
    low = max(start, speed - acceleration)
    high = max(min(most, max(speed + acceleration, start)), speed - acceleration)
    if not braking(low, acceleration, start, room):
        return braked(speed, acceleration, start), False
    return high - least(lambda less: braking(high - less, acceleration, start, room)), False


def contour(speed: int, most: int, acceleration: int, start: int) -> int:
    """Return the next cycle's speed on the way to the maximum velocity; without acceleration it is unchanged."""
    if acceleration == 0:
        return speed
    if speed > most:
        return max(speed - acceleration, most)
    return min(max(speed + acceleration, start), most)


FINE = 1 << 58  # resolution: parts of a cycle, and parts of 1/65536 step


def fine(number: Fraction) -> Fraction:
    """Return a number rounded up to a multiple of 1/FINE."""
    return Fraction(-(-number * FINE // 1), FINE)


def finest(holds: Callable[[Fraction], bool]) -> Fraction:
    """Return the smallest multiple n >= 0 of 1/FINE for which `holds` is true; it must be true for all above n."""
    return Fraction(least(lambda parts: holds(Fraction(parts, FINE))), FINE)


def phase_times(d: int, v: int, a: int, j: Fraction) -> tuple[Fraction, Fraction, Fraction]:
    """Return the durations of an S-curve's phases 1, 2 and 4, in cycles, rounded up to a multiple of 1/FINE.

    The curve covers the distance `d` without exceeding the velocity `v`, the acceleration `a` or the jerk
    `j`.  In the continuous curve, phase 1 lasts a/j, and phases 1 and 2 together last v/a; if `a` is not
    reached, phase 1 lasts sqrt(v/j), and phase 2 is omitted.  Phase 4 covers the rest of `d` at `v`; if `v`
    is not reached, phase 4 is omitted, and `d` limits the velocity.
    """
    if v * j >= a * a:
        t1, gaining = fine(a / j), fine(Fraction(v, a))
        if d >= v * (Fraction(v, a) + a / j):
            return t1, gaining - t1, max(fine(Fraction(d, v)) - gaining - t1, Fraction(0))
    elif d * d * j >= 4 * v**3:
        t1 = finest(lambda t: j * t * t >= v)
        return t1, Fraction(0), max(fine(Fraction(d, v)) - 2 * t1, Fraction(0))
    if d * j * j >= 2 * a**3:
        t1 = fine(a / j)
        return t1, finest(lambda t: a * (t1 + t) * (2 * t1 + t) >= d), Fraction(0)
    return finest(lambda t: 2 * j * t**3 >= d), Fraction(0), Fraction(0)


class TwinSCurve:
    """An S-curve in progress; the jerk in its seven phases is +J, 0, -J, 0, -J, 0, +J.

    A cycle moves the axis from its position to the curve's position at the end of the cycle.  Four registers
    with 58 binary places contain the position and its first, second and third differences; in every cycle,
    each difference is added to the register before it.  All four are loaded again at the first cycle that
    begins in a new phase.
    """

    def __init__(self, distance: int, velocity: int, acceleration: int, jerk: int) -> None:
        self.distance, self.velocity, self.acceleration = distance, velocity, acceleration
        self.jerk = Fraction(jerk, 1 << 16)
        self.t1, self.t2, self.t4 = phase_times(abs(distance), velocity, acceleration, self.jerk)
        self.end = Fraction(abs(distance))
        self.cycle = self.loaded = 0
        self.registers = [0, 0, 0, 0]

    @property
    def ends(self) -> list[Fraction]:
        """The end times of phases 1 to 7, in cycles."""
        t1, t2, t4 = self.t1, self.t2, self.t4
        return list(accumulate((t1, t2, t1, t4, t1, t2, t1)))

    @property
    def over(self) -> bool:
        """True when all cycles of the curve are done."""
        return self.cycle >= self.ends[-1]

    @property
    def peak(self) -> Fraction:
        """The speed between phases 3 and 5."""
        steepest = min(self.jerk * self.t1, Fraction(self.acceleration))
        return min(Fraction(self.velocity), steepest * (self.t1 + self.t2))

    def place(self, phase: int, t: Fraction) -> Fraction:
        """Return the position at time `t` (cycles) by the formula of a phase."""
        ends = self.ends
        coasting = self.peak * (t - ends[2] / 2)
        if phase == 1:
            return self.jerk * t**3 / 6
        if phase == 2:
            return self.acceleration * (t**2 / 2 - self.t1 * t / 2 + self.t1**2 / 6)
        if phase == 3:
            return coasting + self.jerk * (ends[2] - t) ** 3 / 6
        if phase == 4:
            return coasting
        if phase == 5:
            return coasting - self.jerk * (t - ends[3]) ** 3 / 6
        return self.end - self.place(8 - phase, ends[6] - t)

    def phase(self, cycle: int) -> int:
        """Return the phase in which a cycle begins; 8 after the end."""
        return 1 + sum(end <= cycle for end in self.ends)

    def load(self, phase: int, cycle: int) -> list[int]:
        """Return the four registers at the start of a cycle: rounded up in phases 1 to 3, otherwise rounded down."""
        if phase == 8:
            return [int(self.end * FINE // 1), 0, 0, 0]
        numbers = [self.place(phase, Fraction(cycle + i)) * FINE for i in range(4)]
        found = []
        while numbers:
            found.append(ceil(numbers[0]) if phase <= 3 else floor(numbers[0]))
            numbers = [after - before for before, after in pairwise(numbers)]
        return found

    def step(self) -> tuple[int, int, int]:
        """Process a cycle; return its displacement, its velocity rounded down, and its phase."""
        phase, ends = self.phase(self.cycle), self.ends
        if phase != self.loaded:
            self.loaded, self.registers = phase, self.load(phase, self.cycle)
        place, speed, change, jerk = self.registers
        self.registers = [place + speed, speed + change, change + jerk, jerk]
        whole = self.cycle + 1 <= ends[phase - 1]
        self.cycle += 1
        following = self.phase(self.cycle)
        after = place + speed if following == phase else self.load(following, self.cycle)[0]
        if not whole:  # further phases begin in this cycle: it counts as the first of them that has jerk
            phase, speed = phase | 1, after - place
        direction = sign(self.distance)
        return direction * (after // FINE - place // FINE), direction * (speed // FINE), phase

    def smooth_stop(self) -> None:
        """End acceleration and constant speed now; the deceleration mirrors the acceleration so far."""
        done, before = self.cycle, (self.t1, self.t2, self.t4)
        rising = 2 * self.t1 + self.t2
        self.t1 = min(self.t1, Fraction(done))
        self.t2 = min(self.t2, done - self.t1)
        self.t4 = min(self.t4, max(done - rising, Fraction(0)))
        if (self.t1, self.t2, self.t4) != before:
            self.end = self.peak * (2 * self.t1 + self.t2 + self.t4)
