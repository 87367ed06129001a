"""The laws of motion of the slow twin, for one cycle at a time: plain integers, taken from the rules as they stand.

Distances are in 2^-16 step, and speeds in that per cycle.
"""

from __future__ import annotations

from collections.abc import Callable


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


def phase_times(distance: int, velocity: int, acceleration: int, jerk: int) -> tuple[int, int, int]:
    """Cycles of an S-curve's phases 1, 2 and 4: those of the continuous curve, each rounded up.

    With D, V, A, J in steps and cycles, phase 1 lasts A/J and phase 2 V/A - A/J, or sqrt(V/J) and 0 if A is not
    reached; phase 4 lasts what is left of D at V.  If V is not reached, phase 4 falls out and V is what D allows.
    """
    d, v, a, j = distance, velocity, acceleration, jerk
    knee = a * a << 16  # V * J at which A is just reached
    if v * j >= knee:
        if d * a * j >= v * (v * j + knee):
            n4 = least(lambda n: (n * v - d) * a * j + v * (v * j + knee) >= 0)
            return -(-(a << 16) // j), -((knee - v * j) // (a * j)), n4
    elif d * d * j >= 4 * v**3 << 16:
        n1 = least(lambda n: n * n * j >= v << 16)
        return n1, 0, least(lambda n: d <= n * v or 4 * v**3 << 16 >= j * (d - n * v) ** 2)
    if d * a * j * j >= 2 * knee * knee:
        n2 = least(lambda n: (2 * a * j * n + 3 * knee) ** 2 >= knee * knee + 4 * a * d * j * j)
        return -(-(a << 16) // j), n2, 0
    return least(lambda n: 2 * j * n**3 >= d << 16), 0, 0


class SCurve:
    """An S-curve under way: +J, 0, -J, 0, -J, 0, +J for n1, n2, n1, n4, n1, n2, n1 cycles, counted in whole J."""

    JERKS = (1, 0, -1, 0, -1, 0, 1)

    def __init__(self, distance: int, velocity: int, acceleration: int, jerk: int) -> None:
        self.distance = distance
        self.n1, self.n2, self.n4 = phase_times(abs(distance), velocity, acceleration, jerk)
        self.whole = self.n1 * (self.n1 + self.n2) * (2 * self.n1 + self.n2 + self.n4)  # way in units of J
        self.cycle = self.acceleration = self.velocity = self.way = 0

    @property
    def lengths(self) -> tuple[int, ...]:
        """Cycles of the phases 1 to 7."""
        return self.n1, self.n2, self.n1, self.n4, self.n1, self.n2, self.n1

    @property
    def over(self) -> bool:
        """Are all cycles done?"""
        return self.cycle == sum(self.lengths)

    @property
    def gone(self) -> int:
        """How far the axis has come."""
        return sign(self.distance) * (abs(self.distance) * self.way // self.whole)

    def step(self) -> tuple[int, int, int]:
        """Work a cycle: the displacement in it, its velocity rounded down, and its phase."""
        phase, end = 0, 0
        while self.cycle >= end:
            end += self.lengths[phase]
            phase += 1
        before = self.gone
        self.acceleration += self.JERKS[phase - 1]
        self.velocity += self.acceleration
        self.way += self.velocity
        self.cycle += 1
        speed = abs(self.distance) * self.velocity // self.whole
        return self.gone - before, sign(self.distance) * speed, phase

    def smooth_stop(self) -> None:
        """Phases that gain speed or keep it last no longer than they have lasted; braking mirrors what was gained."""
        done = self.cycle
        self.n1 = min(self.n1, done)
        self.n2 = min(self.n2, done - self.n1)
        self.n4 = min(self.n4, max(done - 2 * self.n1 - self.n2, 0))
