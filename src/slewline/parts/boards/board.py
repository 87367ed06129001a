r"""Interface boards in a PC: registers at I/O addresses; each access is a bus cycle.

    clocks     |  0  |  1  |  2  |  3  |  4  |  5  |            of the bus, 8 MHz
    address    ---<================================>
    IOW, IOR   ‾‾‾‾‾‾\_______________________/‾‾‾‾‾‾            a byte is read at the end of clock 4

A board decodes ten address lines and occupies sixteen addresses.  An address without a register reads FF and ignores
writes, as does an address without a board; each such address is reported as a finding, once for IN and once for OUT.
"""

from __future__ import annotations

from collections.abc import Awaitable
from typing import Any, ClassVar

from ...core.datasheet.option import Option
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...core.time.timebase import Time, picoseconds
from ...core.wires.waits import until
from ...errors import UsageError
from ..base.part import Part
from ..base.request_queue import Request, RequestQueue
from .register_layouts import BASES, OFFSETS, STATUS, STEPS, Layout
from .series import IN, MS, OUT, POLL, POLL_PS, WAITS, Done, is_step, met, spelled

CLOCK_PS = 125_000
CYCLE = 6  # clocks; the strobes of the bus last from clock 1 to the end of clock 4
DECODED = 0x3FF
FLOATING = 0xFF
CYCLE_PS = CYCLE * CLOCK_PS
READY = "ready"  # conditions that a program may wait for instead of polling


def base_option(default: int | None, description: str) -> Option:
    """Return the option `base`, a board's first address; `description` is added to the option's own text."""
    return Option(
        "base",
        "int",
        default,
        f"first I/O address of the card, {STEPS}{description}",
        none=default is None,
        like="0x340",
        check=lambda base: "" if base is None or base in BASES else f"allowed {STEPS}",
    )


class Board(Part):
    """An interface board; `waits` are the names of the conditions that a program may wait for."""

    _for_users: ClassVar[tuple[str, ...]] = ("base", "out", "inp", "ready")
    waits: tuple[str, ...] = (READY,)
    _remedy = ""  # remedy for an access without a register

    def __init__(self, kernel: Kernel, name: str, *, base: int, layout: Layout) -> None:
        super().__init__(kernel, name)
        self.queue: RequestQueue = RequestQueue(kernel, name, give_up=self.give_up)
        self.base, self.layout = base, layout
        self._status = layout.offset(STATUS)
        self._reported: set[tuple[int, bool]] = set()  # addresses without a register, and whether they were read
        self._began = 0  # the instant at which the present cycle begins, or the next one (ps)
        self._broken = False  # the last series has ended with a failed wait

    # ------------------------------------------------------------------------------------- calls of a program on the PC
    def out(self, port: int, byte: int, timeout: Time = "5 s") -> None:
        """Write a byte to an I/O address, like the instruction `OUT port, byte`."""
        self.queue.result(self.cycle(port, byte), timeout)

    def inp(self, port: int, timeout: Time = "5 s") -> int:
        """Return the byte read from an I/O address, like the instruction `IN port`."""
        byte: int = self.queue.result(self.cycle(port), timeout)
        return byte

    @from_outside
    def cycle(self, port: int, byte: int | None = None) -> Request[Any]:
        """Queue a bus cycle that writes `byte`, or that reads a byte if `byte` is None."""
        for what, number, most in (("port", port, 0xFFFF), ("byte", byte or 0, 0xFF)):
            if not isinstance(number, int) or not 0 <= number <= most:
                raise UsageError(f"{self.name}: {what} {number!r}; allowed 0..{most:#x}")
        self.input("cycle", port, byte)
        if byte is None:
            return self.queue.submit(f"in {port:#x}", lambda: self.read(port))
        return self.queue.submit(f"out {port:#x}, {byte:#04x}", lambda: self.write(port, byte))

    @from_outside
    def ready(self, limit: Time = "1 s", what: str = READY) -> Request[None]:
        """Queue a wait, of at most `limit`, for the condition named `what`; it stands for a program's polling loop."""
        if what not in self.waits:
            raise UsageError(f"{self.name}: no condition {what!r}; allowed {', '.join(self.waits)}")
        ps = picoseconds(limit)
        self.input("ready", f"{ps} ps", *([] if what == READY else [what]))
        return self.queue.submit(what, lambda: self.until_ready(ps, what))

    @from_outside
    def series(self, steps: str, poll: Time = 0, on: bool = False) -> Request[Done]:
        """Queue a program's accesses without pauses; the result has one byte per step, FF after a failed wait.

        Args:
            steps: the steps in hexadecimal, two bytes per step (parts/boards/series.py).
            poll: the longest wait for bit 7 of the status to become 1, after a step has read it as 0.
            on: True if the steps continue the preceding series; no step is then performed if that series ended
                with a failed wait.

        Raises:
            UsageError: `steps` are not valid steps for this board.
        """
        try:
            data = bytes.fromhex(steps)
        except ValueError:
            data = b""
        if not data or len(data) % 2 or not all(is_step(request, self.waits) for request in data[::2]):
            raise UsageError(
                f"{self.name}: steps {steps!r}; expected steps of two bytes in hexadecimal: 0r -- (read register r), "
                "1r bb (write bb to register r), 24 nn (wait until ready), 54 nn (poll) ..."
            )
        ps = picoseconds(poll)
        self.input("series", steps, f"{ps} ps", on)
        return self.queue.submit(f"series {spelled(data[:8])}", lambda: self._work(data, ps, on))

    @from_outside
    def give_up(self) -> None:
        """Cancel the last request, which took too long; requests queued after this call are performed as usual."""
        self.input("give_up")
        self.queue.cancel_last()

    # ------------------------------------------------------------------------------------------------------ bus cycles
    async def write(self, port: int, byte: int) -> None:
        """Write a byte to a port in a write cycle that begins now."""
        self._began = self.kernel.now
        await self._access(self._offset(port), byte, port)
        await until(self.kernel, self._clock(CYCLE))

    async def read(self, port: int) -> int:
        """Read a byte from a port in a read cycle that begins now, and return the byte."""
        self._began = self.kernel.now
        byte = await self._access(self._offset(port), None, port)
        await until(self.kernel, self._clock(CYCLE))
        return byte

    async def _reach(self, register: str, byte: int | None = None) -> int:
        """Perform the next bus cycle, which begins within one clock from now, and return the byte written or read.

        Without `byte`, the cycle is a read cycle; its byte is read at the end of clock 4.  Edges of the
        cycle may be promised; the call then returns before the cycle ends.

        Args:
            register: the name of a register that the layout provides for this access.
            byte: the byte to be written.
        """
        raise NotImplementedError

    def _access(self, offset: int, byte: int | None, port: int | None = None) -> Awaitable[int]:
        """Perform a bus cycle at an offset from the base; return the byte written or read.

        The offset need not be that of a register.  `byte` is the byte to be written, or None to read; `port`
        is the full address, if known.
        """
        register = (self.layout.reads if byte is None else self.layout.writes).get(offset)
        return self._nowhere(offset, byte, port) if register is None else self._reach(register, byte)

    async def _nowhere(self, offset: int, byte: int | None, port: int | None) -> int:
        """Perform a cycle at an address without a register; report its first IN and first OUT as findings."""
        address, reading = self.base + offset if port is None else port, byte is None
        await until(self.kernel, self._clock(1))  # at an instant of the cycle, regardless of the instant of the request
        if (address, reading) not in self._reported:
            self._reported.add((address, reading))
            self.finding("no-register", self._without(address, offset, reading))
        if byte is not None:
            return byte
        await until(self.kernel, self._clock(5))
        return FLOATING

    def _without(self, address: int, offset: int, reading: bool) -> str:
        """Return the text of the finding for an address without a register."""
        done = f"IN {address:#x} reads FF" if reading else f"OUT {address:#x} has no effect"
        if offset not in OFFSETS:
            return f"{done}: no board has this address; {self.name} has the addresses from {self.base:#x} on"
        cycle = "IN" if reading else "OUT"
        listed = self.layout.listed(reading)
        return f"{done}: for {cycle}, {self.name} at {self.base:#x} has {listed}{self._remedy}"

    async def until_ready(self, ps: int, what: str = READY) -> None:
        """Wait, without bus cycles, until the condition named `what` is met, but at most `ps` picoseconds."""
        raise NotImplementedError

    def _offset(self, port: int) -> int:
        """Return the offset of an address from the base; it is outside 0 to 15 if the address is not this board's."""
        return (port & DECODED) - self.base

    def _clock(self, number: int) -> int:
        """Return the instant (ps) at which clock `number` of the present cycle begins."""
        return self._began + number * CLOCK_PS

    # ---------------------------------------------------------------------------------------------------------- series
    async def _work(self, steps: bytes, poll_ps: int, on: bool) -> Done:
        """Perform the steps of a series; each cycle begins when the preceding cycle ends.

        A write cycle may be promised as a whole, so time passes here only until a byte has been read, a
        condition is met, or the bus is free for the next cycle.  `poll_ps` and `on` are as for `series`.
        """
        if on and self._broken:
            return Done(bytes([FLOATING]) * (len(steps) // 2), ())
        self._broken = True
        kernel, answers, ends = self.kernel, bytearray(), []
        self._began = free = kernel.now  # `free`: nothing is promised on the bus after this instant
        for request, value in zip(steps[::2], steps[1::2], strict=True):
            if request == POLL:
                byte = await self._poll(value * MS)
            elif request in WAITS or request - IN == self._status:
                if request in WAITS:
                    await until(kernel, self._began)
                    await self.until_ready(value * MS, WAITS[request])
                    self._began = kernel.now
                byte = await self._look()
                if request not in WAITS and poll_ps:
                    await self._ready_within(poll_ps)
            else:
                await until(kernel, free)
                byte = await self._access(request & 0x0F, value if request & 0xF0 == OUT else None)
                self._began = free = self._clock(CYCLE)
            answers.append(byte)
            ends.append(self._began)
            if not met(request, byte):
                break
        else:
            self._broken = False
        await until(kernel, self._began)
        return Done(bytes(answers).ljust(len(steps) // 2, bytes([FLOATING])), ends)

    async def _look(self) -> int:
        """Read the status in a bus cycle, and return it; the next cycle begins immediately after this one."""
        byte = await self._reach(STATUS)
        self._began += CYCLE_PS
        return byte

    async def _poll(self, ps: int) -> int:
        """Poll the status until bit 7 is 1, for at most `ps` picoseconds; return the last status."""
        end = self._began + ps
        while not met(POLL, byte := await self._look()) and self._began < end:
            await self._ready_within(POLL_PS)
        return byte

    async def _ready_within(self, ps: int) -> None:
        """Wait until bit 7 of the status is 1, but at most `ps` picoseconds from the end of the preceding cycle."""
        await self.until_ready(self._began + ps - self.kernel.now)
        self._began = max(self._began, self.kernel.now)
