"""The work of a module; RDY is low while there is any."""

from __future__ import annotations

from ...core.context import ChipContext

LINE, PROGRAM, EEPROM, START = "line", "program", "EEPROM", "start"


class Activity:
    """Work in progress: a line of the host, a program or a homing, a write to the EEPROM, the start of the module.

    `text` names the work in progress other than a line and an instruction of the program: a homing, a write ...
    """

    def __init__(self, chip: ChipContext) -> None:
        self.chip, self.busy = chip, chip.drivers["rdy"]  # an open collector, active during work
        self.clear()

    def clear(self) -> None:
        """Clear all work, without supply."""
        self.kinds: set[str] = set()
        self.text = ""

    def begin(self, kind: str) -> None:
        """Begin a kind of work."""
        self.kinds.add(kind)
        self.busy.put(self.busy.active_level)

    def end(self, kind: str) -> None:
        """End a kind of work, if it is in progress."""
        self.kinds.discard(kind)
        if not self.kinds:
            self.busy.put(None)

    def works_on(self, text: str) -> None:
        """Set the text of work that is not an instruction of the program; empty when it is over."""
        self.text = text
        self.chip.on_command(text)
