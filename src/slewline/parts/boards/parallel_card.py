r"""A PC card for a bidirectional bus: the handshake lines are bits of registers.

    base + 0   data       write: the byte that the card drives while bit 1 of the control is 1;
                          read: the byte on the bus
         + 2   control    bit 0: IO_REQUEST low; bit 1: the card drives the bus; reads back as written
         + 4   status     read: bit 7: BUSY is high, bit 6: FPL is high; the other bits read 1
         + 8   reset      write any byte: a pulse on RESET

Bits 6 and 7 below are those of the status.  To send a byte to the chip: wait until bit 7 is 1, write the
byte to data and 3 to control, wait until bit 7 is 0, write 0 to control.  To read a message of the chip,
repeat while bit 6 is 0: write 1 to control, wait until bit 7 is 0, read data, write 0 to control, wait
until bit 7 is 1.
"""

from __future__ import annotations

from types import MappingProxyType

from ...core.time.kernel import Kernel
from ...core.wires.waits import first_of, until
from .board import FLOATING, READY, Board, base_option
from .register_layouts import DATA, RESET, STATUS, Layout

CONTROL = "control"
LAYOUT = Layout(0x340, {0: DATA, 2: CONTROL, 4: STATUS}, {0: DATA, 2: CONTROL, 8: RESET})
REQUEST, DRIVE = 0x01, 0x02  # bits of the control register
IS_READY, IS_FREE = 0x80, 0x40  # bits of the status: BUSY high, FPL high
RESET_PS = 100_000_000  # longer than needed with any crystal
ANSWER, MESSAGE = "answer", "message"


class ParallelCard(Board):
    """A parallel card in a PC."""

    _for_users = ("status", "control")
    wiring = MappingProxyType({"db": "data", "io_request": "request", "busy": "ready", "fpl": "flow", "reset": "reset"})
    options = (base_option(LAYOUT.base, ""),)
    waits = (READY, ANSWER, MESSAGE)

    def __init__(self, kernel: Kernel, name: str, *, base: int) -> None:
        super().__init__(kernel, name, base=base, layout=LAYOUT)
        self.add_bus("db", "data bus of the chip")
        self.add_pin("io_request", "out", "IO_REQUEST of the chip", initial=1)
        self.add_pin("busy", "in", "BUSY of the chip", pull=1)
        self.add_pin("fpl", "in", "FPL of the chip", pull=1)
        self.add_pin("reset", "out", "RESET of the chip; open except for a pulse")
        self._latch, self.control = 0xFF, 0

    @property
    def status(self) -> int:
        """The status register: bit 7 is 1 while BUSY is high, bit 6 while FPL is high; all others are 1."""
        low = IS_READY * (not self.high("busy")) | IS_FREE * (not self.high("fpl"))
        return FLOATING & ~low

    async def _reach(self, register: str, byte: int | None = None) -> int:
        """Perform a bus cycle that writes `byte`, or that reads if it is None; return the byte written or read.

        The register is written or read at the end of clock 4 of the cycle.
        """
        await until(self.kernel, self._clock(5))
        if byte is None:
            return self._read(register)
        if register == DATA:
            self._latch = byte
        elif register == CONTROL:
            self.control = byte & (REQUEST | DRIVE)
        elif register == RESET:
            self.drivers["reset"].wave(None, (self._clock(0) + 1, self._clock(0) + RESET_PS), (1, None))
        self.drivers["db"].drive((0xFF, self._latch) if self.control & DRIVE else None)
        self.drivers["io_request"].drive(0 if self.control & REQUEST else 1)
        return byte

    def _read(self, register: str) -> int:
        if register == DATA:
            return self.byte("db")
        return self.control if register == CONTROL else self.status

    async def until_ready(self, ps: int, what: str = READY) -> None:
        """Wait, without bus cycles, until the condition `what` is met, but at most `ps` picoseconds.

        READY: BUSY is high; ANSWER: BUSY is low; MESSAGE: FPL is low.
        """
        net, wanted = {READY: ("busy", 1), ANSWER: ("busy", 0), MESSAGE: ("fpl", 0)}[what]
        await first_of(self.kernel, self.kernel.now + ps, (self.pins[net].net, wanted))
