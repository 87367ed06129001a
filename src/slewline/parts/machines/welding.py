"""The welding machine of the CY525 manual, section 4: workpieces, and a carriage with a torch."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from ...core.datasheet.option import Option
from ...core.time.kernel import Kernel
from ...core.time.timebase import Time, picoseconds, readable
from ...core.wires.net import Net
from ..base.part import Part
from ..shafts.interlock import InterlockMonitor
from ..shafts.motor import STEP_WIRING, StepDrive, attach_drive
from ..shafts.shaft import forget_shaft, shaft_quantities

SHOWN = 200  # spots


class Workpieces(Part):
    """Workpieces that come to the machine one by one and leave after their last weld.

    `in_place` is high while a workpiece is ready; `last` is low while more workpieces are to come.
    """

    _for_users = ("pieces", "welds", "left", "finished")
    wiring = MappingProxyType({"in_place": "input1", "last": "input2", "torch": "output1"})

    options = (
        Option("pieces", "int", 3, "number of workpieces", low=0),
        Option("welds", "int", 6, "welds (falling edges of `torch`) per workpiece", low=1),
        Option(
            "change",
            "time",
            "1 s",
            "time from the start, or from the departure of a workpiece, to the arrival of the next one",
        ),
    )

    def __init__(self, kernel: Kernel, name: str, *, pieces: int, welds: int, change: Time) -> None:
        super().__init__(kernel, name)
        self.pieces, self.welds, self._change_ps = pieces, welds, picoseconds(change)
        self.add_pin("in_place", "out", "high: a workpiece is ready", initial=0)
        self.add_pin("last", "out", "low: another workpiece follows", initial=int(pieces == 0))
        self.add_pin("torch", "in", "a weld is done when it falls", pull=1)
        self.finished = 0
        self.left = 0  # welds that the workpiece in place still needs

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        self.pin("torch").net.watch(self._welded)
        self._next()

    def _next(self) -> None:
        if self.finished < self.pieces:
            self.kernel.call_at(self.kernel.now + self._change_ps, self._arrive)

    def _arrive(self) -> None:
        self.left = self.welds
        self.drivers["in_place"].drive(1)
        self.drivers["last"].drive(int(self.finished == self.pieces - 1))

    def _welded(self, net: Net) -> None:
        if net.level == 0 and self.left:
            self.left -= 1
            if not self.left:
                self.finished += 1
                self.drivers["in_place"].drive(0)
                self._next()

    def shows(self) -> dict[str, Any]:
        """Return the number of workpieces, how many are finished, and the welds left on the present workpiece."""
        return {"pieces": self.pieces, "finished": self.finished, "left": self.left}

    @property
    def waiting(self) -> str:
        """Description of the progress: the number of finished workpieces, and the number of all workpieces."""
        return f"{self.name}: {self.finished} of {self.pieces} finished"


@dataclass(frozen=True, slots=True)
class Weld:
    """A weld: its position in steps, and its start and duration in ps."""

    position: int
    start_ps: int
    duration_ps: int

    def __str__(self) -> str:
        return f"{self.position:5}  from {readable(self.start_ps)} for {readable(self.duration_ps)}"


class Welder(Part):
    """A carriage moved by PULSE and DIRECTION, with a torch that burns while `torch` is high."""

    _for_users = ("position", "spots", "lit")
    wiring = MappingProxyType({**STEP_WIRING, "torch": "output1"})
    attached = attach_drive
    quantities, forget = shaft_quantities, forget_shaft

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.drive = StepDrive(self)
        self.shaft = self.drive.shaft
        self.add_pin("torch", "in", "high: on", pull=0)
        self.spots: list[Weld] = []
        self.lit: tuple[int, int] | None = None  # position and instant
        self._interlock = InterlockMonitor(self, self.shaft)

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        self.drive.rule.start()
        self.pin("torch").net.watch(self._torch)
        self._torch(self.pin("torch").net)

    @property
    def position(self) -> int:
        """Steps clockwise since the start."""
        return self.drive.position

    def shows(self) -> dict[str, Any]:
        """Return the positions of the torch and its latest 200 welds, in steps, and whether the torch burns."""
        spots = [spot.position for spot in self.spots[-SHOWN:]]
        return {"position": self.position, "spots": spots, "lit": self.lit is not None}

    def _torch(self, net: Net) -> None:
        now = self.kernel.now
        self._interlock.hold(net.level == 1)
        if net.level == 1:
            self.lit = (self.position, now)
        elif self.lit is not None:
            position, start = self.lit
            self.spots.append(Weld(position, start, now - start))
            self.lit = None

    def catch_up(self) -> None:
        """Report steps made with the torch on, up to the last committed instant."""
        for ps, place, _ in self._interlock.steps():
            self.finding("smeared", f"the carriage moves from position {place} with the torch on", ps)
