"""What turns: a pulse-to-step translator with its motor, and a rotor between two windings (s.10)."""

from __future__ import annotations

from types import MappingProxyType

from ..core.kernel import Kernel
from ..core.net import Net
from .part import Part


class Translator(Part):
    """A translator and its motor: a step at each fall of PULSE, the way that DIRECTION says (fig. 10.4).

    It knows nothing but these two lines: a PULSE that O 128 to 255 makes for a phase latch is a step to it.
    """

    wiring = MappingProxyType({"pulse": "pulse", "direction": "direction"})

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_pin("pulse", "in", "step at each fall", pull=1)
        self.add_pin("direction", "in", "high: clockwise", pull=1)
        self.position = 0  # steps clockwise since the beginning

    def rewired(self) -> None:
        self.pin("pulse").net.watch(self._pulsed)

    def _pulsed(self, net: Net) -> None:
        if net.level == 0:
            self.stepped(1 if self.high("direction") else -1)

    def stepped(self, sign: int) -> None:
        """The motor takes a step."""
        self.position += sign


class Rotor(Part):
    """A rotor between two windings, phases 1 and 2 on the ends of one, 3 and 4 on the ends of the other (s.10).

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
