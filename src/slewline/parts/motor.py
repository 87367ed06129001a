"""What turns: a pulse-to-step translator with its motor, a motor with limits, and a rotor between two windings."""

from __future__ import annotations

from collections.abc import Iterable
from math import sqrt
from types import MappingProxyType
from typing import ClassVar

from ..core.kernel import Kernel
from ..core.net import Net
from ..core.timebase import PS_PER_S, Time, picoseconds
from ..errors import UsageError
from .part import Part


class Translator(Part):
    """A translator and its motor: a step at each fall of PULSE, the way that DIRECTION says (CY525 fig. 10.4).

    It knows nothing but these two lines: a PULSE that O 128 to 255 makes for a phase latch is a step to it.
    """

    wiring = MappingProxyType({"pulse": "pulse", "direction": "direction"})
    edge: ClassVar[int] = 0  # the level of PULSE with which a step begins

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_pin("pulse", "in", f"step at each {'rise' if self.edge else 'fall'}", pull=1)
        self.add_pin("direction", "in", "high: clockwise", pull=1)
        self.position = 0  # steps clockwise since the beginning

    def rewired(self) -> None:
        self.pin("pulse").net.watch(self._pulsed)

    def _pulsed(self, net: Net) -> None:
        if net.level == self.edge:
            self.stepped(1 if self.high("direction") else -1)

    def stepped(self, sign: int) -> None:
        """The motor takes a step."""
        self.position += sign


class Motor(Translator):
    """A motor that does not make every step, with its driver and the detector of its steps (GS-C figures 14, 17, 18).

    A pulse is lost while the step before is under way, and when it comes too fast: its rate, from the pulse before, may
    be `pull_in`, or what the motor reaches from its present rate in one step, sqrt(rate^2 + 2 acceleration).  A motor
    that loses a step stands still, and starts again when a pulse is no faster than `pull_in`.

        x   0 1 1 0        the detector, clockwise to the right
        y   0 0 1 1

    Args:
        lag: how long a step takes.
        pull_in: greatest rate from rest, steps/s; 0: any rate at any time.
        acceleration: steps/s^2, at most pull_in^2 / 2: from rest, too, a step takes it no further than pull_in.
        loses: numbers of pulses that it misses besides, the first one being 1.
    """

    wiring = MappingProxyType({"pulse": "clock", "direction": "dir"})
    edge = 1

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        *,
        lag: Time = 0,
        pull_in: float = 0,
        acceleration: float = 0,
        loses: Iterable[int] = (),
    ) -> None:
        super().__init__(kernel, name)
        if pull_in < 0 or not 0 <= acceleration <= pull_in**2 / 2:
            raise UsageError(
                f"{name}: pull_in {pull_in}, acceleration {acceleration}; allowed 0 and more, 0 to {pull_in**2 / 2:g}"
            )
        self.lag_ps, self.pull_in, self.acceleration = picoseconds(lag), pull_in, acceleration
        self.loses = frozenset(loses)
        for pin in "xy":
            self.add_pin(pin, "out", "detector signal", initial=0)
        self.pulses = self.lost = 0
        self.arrives_ps = 0  # when the step under way is made
        self.sign, self.rate, self.pulsed_ps = 0, 0.0, -PS_PER_S

    def stepped(self, sign: int) -> None:
        self.pulses += 1
        if sign != self.sign:
            self.sign, self.rate = sign, 0.0
        now = self.kernel.now
        interval, self.pulsed_ps = now - self.pulsed_ps, now
        follows = now >= self.arrives_ps and self.pulses not in self.loses and interval >= self._shortest_ps()
        self.rate = PS_PER_S / interval if follows else 0.0
        self.lost += not follows
        if follows:
            self.arrives_ps = now + self.lag_ps
            self.kernel.call_at(self.arrives_ps, lambda: self._made(sign))

    def _shortest_ps(self) -> int:
        """The shortest interval before the next step."""
        if not self.pull_in:
            return 0
        return int(PS_PER_S / max(self.pull_in, sqrt(self.rate**2 + 2 * self.acceleration)))

    def _made(self, sign: int) -> None:
        super().stepped(sign)
        self.drivers["x"].drive(int(self.position % 4 in (1, 2)))
        self.drivers["y"].drive(int(self.position % 4 in (2, 3)))


class Rotor(Part):
    """A rotor between two windings, phases 1 and 2 on the ends of one, 3 and 4 on the ends of the other (CY525 s.10).

        winding a   -1 +1 +1 -1         the end with the low phase pin is energised
        winding b   -1 -1 +1 +1
        field        0  1  2  3         quarters of an electrical turn, clockwise

    The rotor follows the field by one quarter at a time.  Without current in both windings it stays where it is, and
    when the field jumps to the opposite side it stays too, with a finding: a real one would go either way.
    """

    wiring = MappingProxyType({f"phase{n}": f"phase{n}" for n in (1, 2, 3, 4)})

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        for n in (1, 2, 3, 4):
            self.add_pin(f"phase{n}", "in", f"phase {n}, low energises", pull=1)
        self.position = 0  # steps clockwise since the beginning; at rest in the field of offset 0
        self.followed: int | None = None

    def rewired(self) -> None:
        for n in (1, 2, 3, 4):
            self.pin(f"phase{n}").net.watch(self._follow)

    @property
    def field(self) -> int | None:
        """The direction of the field, 0 to 3; None without current in both windings."""
        one, two, three, four = (self.high(f"phase{n}") for n in (1, 2, 3, 4))
        return {(-1, -1): 0, (1, -1): 1, (1, 1): 2, (-1, 1): 3}.get((one - two, three - four))

    def _follow(self, _net: Net) -> None:
        field = self.field
        if field is None or field == self.followed:  # four pins tell of one change
            return
        self.followed = field
        turn = (field - self.position) % 4
        if turn == 2:
            self.finding("rotor-lost", "the field jumped to the opposite side: a real rotor would go either way")
        else:
            self.position += {0: 0, 1: 1, 3: -1}[turn]
