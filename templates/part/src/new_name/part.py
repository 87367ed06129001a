"""What the NEW-NAME does: its pins, its options, and a task that waits for edges and times."""

from __future__ import annotations

from slewline.build import Kernel, Option, Part, Time, first_of, picoseconds


class NewName(Part):
    """A relay: some time after the coil, its contact follows."""

    options = (Option("delay", "time", "5 ms", "from the coil to the contact", low=1),)
    wiring = {"coil": "output1"}  # where `to` joins it: to the pin of the chip with this role

    def __init__(self, kernel: Kernel, name: str, *, delay: Time = "5 ms") -> None:
        super().__init__(kernel, name)
        self.delay_ps = picoseconds(delay)
        self.due_ps: int | None = None  # when the contact will move
        self.add_pin("coil", "in", "high: it has current", pull=0)
        self.add_pin("contact", "out", "high: it is closed", initial=0)
        kernel.spawn(self._run, name=name)

    async def _run(self) -> None:
        coil, contact, closed = self.pin("coil"), self.drivers["contact"], 0
        while True:
            late = coil.level != closed
            self.due_ps = self.kernel.now + self.delay_ps if late else None
            if await first_of(self.kernel, self.due_ps, (coil.net, None)) is None:
                closed = int(coil.level == 1)
                contact.drive(closed)
            elif late:
                self.finding("short", "the coil changed back before the contact had moved, which does not move now")

    @property
    def idle(self) -> bool:
        """Is there nothing to do?  A run until idle waits for the contact."""
        return self.due_ps is None
