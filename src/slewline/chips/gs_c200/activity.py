"""What a module is working on, and what shows it: RDY is low meanwhile."""

from __future__ import annotations

from ...core.context import ChipContext

LINE, PROGRAM, EEPROM, START = "line", "program", "EEPROM", "start"


class Activity:
    """What is in progress: a line of the host, a program or a homing, a write to the EEPROM, the start of the module.

    `text` is what is in progress besides a line and an instruction of the program: a homing, a write ...
    """

    def __init__(self, chip: ChipContext) -> None:
        self.chip, self.busy = chip, chip.drivers["rdy"]  # an open collector, active while there is work
        self.clear()

    def clear(self) -> None:
        """Forget all work: there is no supply."""
        self.kinds: set[str] = set()
        self.text = ""

    def begin(self, kind: str) -> None:
        """Begin a kind of work."""
        self.kinds.add(kind)
        self.busy.put(self.busy.active_level)

    def end(self, kind: str) -> None:
        """End a kind of work, if it is under way."""
        self.kinds.discard(kind)
        if not self.kinds:
            self.busy.put(None)

    def works_on(self, text: str) -> None:
        """Report what has begun that is no instruction of the program; empty: it is over."""
        self.text = text
        self.chip.on_command(text)
