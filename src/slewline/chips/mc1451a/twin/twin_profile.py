"""The laws of motion of the slow twin, for one cycle at a time: plain integers, taken from the rules as they stand.

Distances are in 2^-16 step, and speeds in that per cycle.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import accumulate, pairwise
from math import ceil, floor


def sign(number: int) -> int:
    """1, or -1 for a negative number."""
    return -1 if number < 0 else 1


def least(holds: Callable[[int], bool]) -> int:
    """The least number, 0 and up, for which something holds that then holds for all greater ones."""
    high = 1
    while not holds(high):
        high *= 2
    low = 0
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle + 1, high)
    return low


def braking(speed: int, acceleration: int, start: int, room: int) -> bool:
    """Does it fit into the room to go at a speed for a cycle, then slower by the acceleration ..., last at `start`?"""
    if speed <= start:
        return start <= room
    if acceleration == 0:
        return False
    cycles = -(-(speed - start) // acceleration)  # above `start`
    return cycles * speed - acceleration * (cycles * (cycles - 1) // 2) + start <= room


def braked(speed: int, acceleration: int, start: int) -> int:
    """The speed of the next cycle when an axis slows down; 0 when it has been as slow as its start velocity."""
    return 0 if speed <= start else max(speed - acceleration, start)


def trapezoid(speed: int, room: int, most: int, acceleration: int, start: int) -> tuple[int, bool]:
    """The next speed on the way to a destination, and whether the axis lands there with it.

    The fastest that allows to brake in time; an axis that is too fast for that slows down.
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
    """The next speed on the way to the maximum velocity; without acceleration it stays."""
    if acceleration == 0:
        return speed
    if speed > most:
        return max(speed - acceleration, most)
    return min(max(speed + acceleration, start), most)


FINE = 1 << 58  # so many parts of a cycle are told apart, and so many parts of 1/65536 step


def fine(number: Fraction) -> Fraction:
    """A number rounded up to the next part."""
    return Fraction(-(-number * FINE // 1), FINE)


def finest(holds: Callable[[Fraction], bool]) -> Fraction:
    """The least number of parts for which something holds that then holds for all greater ones."""
    return Fraction(least(lambda parts: holds(Fraction(parts, FINE))), FINE)


def phase_times(d: int, v: int, a: int, j: Fraction) -> tuple[Fraction, Fraction, Fraction]:
    """Cycles of an S-curve's phases 1, 2 and 4: those of the continuous curve, rounded up to parts of a cycle.

    Phase 1 lasts A/J and phases 1 and 2 together V/A, or sqrt(V/J) and no longer if A is not reached; phase 4 lasts
    what is left of D at V.  If V is not reached, phase 4 falls out and V is what D allows.
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
    """An S-curve under way: +J, 0, -J, 0, -J, 0, +J.

    A cycle takes the axis from where it is to where the curve has come to at its end.  Registers with 58 binary
    places hold position, speed, and how that changes; with every cycle each is added to the one before it.  They
    are loaded at the first cycle that begins in another phase.
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
        """When the phases 1 to 7 end, in cycles."""
        t1, t2, t4 = self.t1, self.t2, self.t4
        return list(accumulate((t1, t2, t1, t4, t1, t2, t1)))

    @property
    def over(self) -> bool:
        """Are all cycles done?"""
        return self.cycle >= self.ends[-1]

    @property
    def peak(self) -> Fraction:
        """The speed between phases 3 and 5."""
        steepest = min(self.jerk * self.t1, Fraction(self.acceleration))
        return min(Fraction(self.velocity), steepest * (self.t1 + self.t2))

    def place(self, phase: int, t: Fraction) -> Fraction:
        """Where the law of a phase has the axis at a time."""
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
        """The phase in which a cycle begins; 8 after the end."""
        return 1 + sum(end <= cycle for end in self.ends)

    def load(self, phase: int, cycle: int) -> list[int]:
        """The registers at the start of a cycle: rounded up as long as the axis gains speed, then down."""
        if phase == 8:
            return [int(self.end * FINE // 1), 0, 0, 0]
        numbers = [self.place(phase, Fraction(cycle + i)) * FINE for i in range(4)]
        found = []
        while numbers:
            found.append(ceil(numbers[0]) if phase <= 3 else floor(numbers[0]))
            numbers = [after - before for before, after in pairwise(numbers)]
        return found

    def step(self) -> tuple[int, int, int]:
        """Work a cycle: the displacement in it, its velocity rounded down, and its phase."""
        phase, ends = self.phase(self.cycle), self.ends
        if phase != self.loaded:
            self.loaded, self.registers = phase, self.load(phase, self.cycle)
        place, speed, change, jerk = self.registers
        self.registers = [place + speed, speed + change, change + jerk, jerk]
        whole = self.cycle + 1 <= ends[phase - 1]
        self.cycle += 1
        following = self.phase(self.cycle)
        after = place + speed if following == phase else self.load(following, self.cycle)[0]
        if not whole:  # other phases begin in this cycle: it counts as the first of them that has jerk
            phase, speed = phase | 1, after - place
        way = sign(self.distance)
        return way * (after // FINE - place // FINE), way * (speed // FINE), phase

    def smooth_stop(self) -> None:
        """Phases that gain speed or keep it last no longer than they have lasted; braking mirrors what was gained."""
        done, before = self.cycle, (self.t1, self.t2, self.t4)
        rising = 2 * self.t1 + self.t2
        self.t1 = min(self.t1, Fraction(done))
        self.t2 = min(self.t2, done - self.t1)
        self.t4 = min(self.t4, max(done - rising, Fraction(0)))
        if (self.t1, self.t2, self.t4) != before:
            self.end = self.peak * (2 * self.t1 + self.t2 + self.t4)
