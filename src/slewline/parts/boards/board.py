r"""Interface boards in a PC: registers at I/O addresses, each access a cycle of the bus.

    clocks     |  0  |  1  |  2  |  3  |  4  |  5  |            of the bus, 8 MHz
    address    ---<================================>
    IOW, IOR   ‾‾‾‾‾‾\_______________________/‾‾‾‾‾‾            a byte that is read is taken at the end of clock 4

A board decodes ten address lines and takes sixteen addresses; those without a function read FF and take nothing.
"""

from __future__ import annotations

from typing import Any, ClassVar

from ...core.datasheet.option import Option
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...core.time.timebase import Time, picoseconds
from ...errors import UsageError
from ..base.part import Part
from ..base.request_queue import Request, RequestQueue

CLOCK_PS = 125_000
CYCLE = 6  # clocks; the strobes of the bus last from clock 1 to the end of clock 4
DATA, STATUS = 0, 4  # offsets from the base
BASES = range(0x300, 0x400, 0x10)
STEPS = f"{BASES[0]:#x} to {BASES[-1]:#x} in steps of 0x10"
DECODED = 0x3FF
FLOATING = 0xFF
READY = "ready"  # what a program may wait for, instead of polls


def base_option(says: str) -> Option:
    """Return the option `base` of a board."""
    return Option(
        "base",
        "int",
        0x340,
        f"the first of its addresses, {STEPS}{says}",
        like=f"{BASES[4]:#x}",
        check=lambda base: "" if base in BASES else f"allowed {STEPS}",
    )


class Board(Part):
    """An interface board; `waits` are what a program may wait for, by name."""

    _for_users: ClassVar[tuple[str, ...]] = ("base", "out", "inp", "ready")
    waits: tuple[str, ...] = (READY,)

    def __init__(self, kernel: Kernel, name: str, *, base: int) -> None:
        super().__init__(kernel, name)
        self.queue: RequestQueue = RequestQueue(kernel, name, give_up=self.give_up)
        self.base = base

    # ------------------------------------------------------------------------------------ what a program on the PC does
    def out(self, port: int, byte: int, timeout: Time = "5 s") -> None:
        """Write a byte to an I/O address: OUT port, byte."""
        self.queue.result(self.cycle(port, byte), timeout)

    def inp(self, port: int, timeout: Time = "5 s") -> int:
        """Read a byte from an I/O address: IN port."""
        byte: int = self.queue.result(self.cycle(port), timeout)
        return byte

    @from_outside
    def cycle(self, port: int, byte: int | None = None) -> Request[Any]:
        """Queue a bus cycle: a write, or without a byte a read."""
        for number, most in ((port, 0xFFFF), (byte or 0, 0xFF)):
            if not isinstance(number, int) or not 0 <= number <= most:
                raise UsageError(f"{self.name}: {number!r}; allowed 0..{most:#x}")
        self.input("cycle", port, byte)
        if byte is None:
            return self.queue.submit(f"in {port:#x}", lambda: self.read(port))
        return self.queue.submit(f"out {port:#x}, {byte:#04x}", lambda: self.write(port, byte))

    @from_outside
    def ready(self, limit: Time = "1 s", what: str = READY) -> Request[None]:
        """Queue a wait, for so long at most: what a loop of polls is to a program."""
        if what not in self.waits:
            raise UsageError(f"{self.name}: {what!r}; allowed {', '.join(self.waits)}")
        ps = picoseconds(limit)
        self.input("ready", f"{ps} ps", *([] if what == READY else [what]))
        return self.queue.submit(what, lambda: self.until_ready(ps, what))

    @from_outside
    def give_up(self) -> None:
        """Cancel the last request, which took too long; what comes after it can go on."""
        self.input("give_up")
        self.queue.cancel_last()

    # ------------------------------------------------------------------------------------------------------ bus cycles
    async def write(self, port: int, byte: int) -> None:
        """Write a byte to a port, now: a write cycle."""
        raise NotImplementedError

    async def read(self, port: int) -> int:
        """Return the byte of a port, now: a read cycle."""
        raise NotImplementedError

    async def until_ready(self, ps: int, what: str = READY) -> None:
        """Wait, without cycles, for something, or until so much time (ps) is over."""
        raise NotImplementedError

    def _offset(self, port: int) -> int:
        """The address within the board; another number, if it is not one of its addresses."""
        return (port & DECODED) - self.base

    def _clock(self, number: int) -> int:
        """The instant at which a clock of this cycle begins (ps)."""
        return self.kernel.now + number * CLOCK_PS
