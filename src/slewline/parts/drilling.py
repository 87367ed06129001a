"""The drilling machine of the GS-C data sheet, example 2: a bar that is fed, drilled and cut, and a drill.

    bar unit     UO2 -> UI2 of the drill unit   drill now        UO1 -> blade
    drill unit   UO1 -> UI2 of the bar unit     hole is done     UO2 -> motor of the drill

Bar and drill meet in one net, `bit`, which is high while the drill is in the bar.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

from ..core.kernel import Kernel
from ..core.net import Net
from ..core.option import Option
from .stepped import Stepped


@dataclass(frozen=True, slots=True)
class Piece:
    """What was cut off a bar: where its holes are, and how long it is, steps from its end."""

    holes: tuple[int, ...]
    length: int

    def __str__(self) -> str:
        return f"holes at {', '.join(map(str, self.holes)) or 'none'}, cut at {self.length}"


class Bar(Stepped):
    """A bar that CLOCK and DIR feed under drill and blade; each rise of `bit` makes a hole, of `blade` a cut."""

    wiring = MappingProxyType({"pulse": "step", "direction": "direction", "blade": "output1"})

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_pin("blade", "in", "cuts when it rises", pull=0)
        self.add_pin("bit", "in", "high: the drill is in the bar", pull=0)
        self.holes: list[int] = []
        self.pieces: list[Piece] = []

    def rewired(self) -> None:
        super().rewired()
        self.pin("bit").net.watch(self._drilled)
        self.pin("blade").net.watch(self._cut)

    def _drilled(self, net: Net) -> None:
        if net.level == 1:
            self.holes.append(self.position)

    def _cut(self, net: Net) -> None:
        if net.level == 1:
            self.pieces.append(Piece(tuple(self.holes), self.position))
            self.holes.clear()
            self.position = 0

    def stepped(self, sign: int) -> None:
        if self.high("bit"):
            self.finding("bit-broken", f"the bar leaves {self.position} with the drill in it")
        super().stepped(sign)


class Drill(Stepped):
    """A drill that CLOCK and DIR lower (clockwise) and lift; its spindle turns while `motor` is high."""

    wiring = MappingProxyType({"pulse": "step", "direction": "direction", "motor": "output2"})

    options = (Option("gap", "int", 100, "from the upper end to the bar", low=1, unit="steps"),)

    def __init__(self, kernel: Kernel, name: str, *, gap: int) -> None:
        super().__init__(kernel, name)
        self.gap = gap
        self.add_pin("motor", "in", "high: the spindle turns", pull=0)
        self.add_pin("bit", "out", "high: in the bar", initial=0)

    def stepped(self, sign: int) -> None:
        super().stepped(sign)
        inside = self.position > self.gap
        if inside and not self.high("motor"):
            self.finding("drill-stands", f"the drill is {self.position - self.gap} steps in the bar and does not turn")
        self.drivers["bit"].drive(int(inside))
