"""The work in progress in a module; RDY is low while there is any."""

from __future__ import annotations

from ...core.context import ChipContext

LINE, PROGRAM, EEPROM, START = "line", "program", "EEPROM", "start"


class Activity:
    """Work in progress: a line from the host, a program or homing run, an EEPROM write, or the module's start.

    `text` names work in progress other than a line or a program instruction: a homing run, an EEPROM write ...
    """

    def __init__(self, chip: ChipContext) -> None:
        self.chip, self.busy = chip, chip.drivers["rdy"]  # an open collector, active during work
        self.clear()

    def clear(self) -> None:
        """Discard all work, as a loss of supply does."""
        self.kinds: set[str] = set()
        self.text = ""

    def begin(self, kind: str) -> None:
        """Begin a kind of work, and drive RDY low."""
        self.kinds.add(kind)
        self.busy.put(self.busy.active_level)

    def end(self, kind: str) -> None:
        """End a kind of work, if it is in progress; release RDY if no work remains."""
        self.kinds.discard(kind)
        if not self.kinds:
            self.busy.put(None)

    def works_on(self, text: str) -> None:
        """Set the text that describes work other than a program instruction; "" when this work is over."""
        self.text = text
        self.chip.on_command(text)
