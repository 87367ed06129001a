"""What every host that speaks through a serial connector does alike."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from ...core.time.inputs import from_outside
from ..lines.rs232 import SerialPort
from .computer import Computer


class LineHost(SerialPort, Computer):
    """A host computer on a serial line."""

    for_users: ClassVar[tuple[str, ...]] = (
        "write",
        "change_line",
        "faulty",
        "baud",
        "word",
    )

    @from_outside
    def give_up(self) -> None:
        """Take back the last command, which was not answered in time."""
        self.input("give_up")
        self.forget_characters()

    def drop(self) -> None:
        """Forget what is queued; characters that are on the line already, and the command asked last, go on."""
        super().drop()
        self.take_back(1, "drop()")

    def lent(self) -> Callable[[], object]:
        """Return what restores rate and format, when somebody else has spoken over this line (`spoken`)."""
        baud, word = self.baud, self.word
        return lambda: self.set_line(baud, word)

    def rest(self) -> None:
        """Forget what is queued, and put the line to mark."""
        if self.sender is not None:
            self.sender.kill()
        self.outgoing.clear()
        self.drivers["txd"].drive(self.mark)
