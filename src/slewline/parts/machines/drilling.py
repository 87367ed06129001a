"""The drilling machine of the GS-C data sheet, example 2: a drill, and a bar that is fed, drilled and cut.

    bar unit     UO2 -> UI2 of the drill unit   "drill now"        UO1 -> blade
    drill unit   UO1 -> UI2 of the bar unit     "hole is done"     UO2 -> motor of the drill

The net `bit` joins bar and drill; it is high while the drill is in the bar.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from ...core.datasheet.option import Option
from ...core.time.kernel import Kernel
from ...core.wires.net import Net
from ..base.part import Part
from ..shafts.interlock import InterlockMonitor
from ..shafts.motor import STEP_WIRING, StepDrive, attach_drive
from ..shafts.sensors import Switch
from ..shafts.shaft import forget_shaft, shaft_quantities

SHOWN = 200  # holes


@dataclass(frozen=True, slots=True)
class CutPiece:
    """A piece cut off a bar: its length, and the distances of its holes from the preceding cut, in steps."""

    holes: tuple[int, ...]
    length: int

    def __str__(self) -> str:
        return f"holes at {', '.join(map(str, self.holes)) or 'none'}, cut at {self.length}"


class Bar(Part):
    """A bar fed under drill and blade by CLOCK and DIR; drilled when `bit` rises, cut when `blade` rises."""

    _for_users = ("position", "holes", "pieces")
    wiring = MappingProxyType({**STEP_WIRING, "blade": "output1"})
    attached = attach_drive
    quantities, forget = shaft_quantities, forget_shaft

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.drive = StepDrive(self)
        self.shaft = self.drive.shaft
        self.add_pin("blade", "in", "cuts when it rises", pull=0)
        self.add_pin("bit", "in", "high: the drill is in the bar", pull=0)
        self.holes: list[int] = []
        self.pieces: list[CutPiece] = []
        self._cut_at = 0  # position of the motor at the last cut
        self._interlock = InterlockMonitor(self, self.shaft)

    @property
    def position(self) -> int:
        """Steps that the bar has moved forward since the last cut."""
        return self.drive.position - self._cut_at

    def shows(self) -> dict[str, Any]:
        """Return the positions of the bar and of its latest holes (up to 200), in steps, and the number of pieces."""
        return {"position": self.position, "spots": self.holes[-SHOWN:], "pieces": len(self.pieces)}

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        self.drive.rule.start()
        self.pin("bit").net.watch(self._drilled)
        self.pin("blade").net.watch(self._cut)

    def _drilled(self, net: Net) -> None:
        if net.level == 1:
            self.holes.append(self.position)
        self._interlock.hold(net.level == 1)

    def _cut(self, net: Net) -> None:
        if net.level == 1:
            self.catch_up()
            self.pieces.append(CutPiece(tuple(self.holes), self.position))
            self.holes.clear()
            self._cut_at += self.position

    def catch_up(self) -> None:
        """Report steps made with the drill in the bar, up to the last committed instant."""
        for ps, place, _ in self._interlock.steps():
            self.finding("bit-broken", f"the bar moves from position {place - self._cut_at} with the drill in it", ps)


class Drill(Part):
    """A drill lowered (clockwise) and lifted by CLOCK and DIR; its spindle turns while `motor` is high."""

    _for_users = ("position", "gap")
    wiring = MappingProxyType({**STEP_WIRING, "motor": "output2"})
    options = (Option("gap", "int", 100, "distance from the upper end to the bar", low=1, unit="steps"),)
    attached = attach_drive
    quantities, forget = shaft_quantities, forget_shaft

    def __init__(self, kernel: Kernel, name: str, *, gap: int) -> None:
        super().__init__(kernel, name)
        self.gap = gap
        self.drive = StepDrive(self)
        self.shaft = self.drive.shaft
        self.add_pin("motor", "in", "high: the spindle turns", pull=0)
        self._bit = Switch(kernel, name, on=self.shaft, low=gap + 1, lag="1 ps", active=1)  # high: it is in the bar
        self.take_pin("bit", self._bit.pins["out"])
        self._interlock = InterlockMonitor(self, self.shaft)

    @property
    def position(self) -> int:
        """Steps clockwise since the start."""
        return self.drive.position

    def shows(self) -> dict[str, Any]:
        """Return the position of the drill, in steps."""
        return {"position": self.position}

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        self.drive.rule.start()
        self._bit.rewired()
        motor = self.pin("motor").net
        motor.watch(lambda net: self._interlock.hold(net.level == 0))
        self._interlock.hold(motor.level == 0)

    def catch_up(self) -> None:
        """Report steps made in the bar while the spindle is not turning, up to the last committed instant."""
        for ps, _, place in self._interlock.steps():
            if place > self.gap:
                self.finding("drill-stands", f"the drill is {place - self.gap} steps into the bar, but not turning", ps)
