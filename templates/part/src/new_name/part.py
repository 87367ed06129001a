"""The model of the NEW-NAME: its pins, its options, and a task that waits for edges and times."""

from __future__ import annotations

from slewline.build import Kernel, Option, Part, Time, first_of, picoseconds


class NewName(Part):
    """A relay whose contact follows the coil after a delay."""

    options = (Option("delay", "time", "5 ms", "from the coil to the contact", low=1),)
    wiring = {"coil": "output1"}  # `to` connects the coil to the pin of the chip with this role

    def __init__(self, kernel: Kernel, name: str, *, delay: Time = "5 ms") -> None:
        super().__init__(kernel, name)
        self.delay_ps = picoseconds(delay)
        self.due_ps: int | None = None  # instant at which the contact moves
        self.add_pin("coil", "in", "high: energised", pull=0)
        self.add_pin("contact", "out", "high: closed", initial=0)
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
                self.finding("short", "the coil changed back before the contact had moved; the contact does not move")

    @property
    def idle(self) -> bool:
        """Whether the contact is at rest; a run until idle waits for this."""
        return self.due_ps is None
