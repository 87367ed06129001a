"""A host's port on the command port of one chip: handshake, read-outs, live commands, rate changes.

    wait READY high, byte on the bus, I/O REQUEST low, wait READY low, I/O REQUEST high           (s.2, s.11)

The host responds without delay unless `delay_ps` is set.  This is the time that its program takes before
each byte.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ....core.datasheet.channel import BusHandshake
from ....core.datasheet.command_rows import TextRow
from ....core.wires.exchange import Leader
from ....core.wires.handshake import Handshakes, TakingEnd
from ....core.wires.handshaken_bytes import HandshakenBytes
from ....core.wires.net import Driver, Net
from ....core.wires.waits import first_of, level, next_round, until
from ....errors import UsageError

if TYPE_CHECKING:
    from ...base.request_queue import RequestQueue
    from ..connection import Connection

SETTLED_US = 100  # READY high for longer than any instruction takes to begin: the chip is between two of them


class CommandPort:
    """A host's port on one chip: drivers on the chip's command port, and the nets that the host reads.

    Args:
        chip: the connection to the chip.
        queue: the host's request queue, whose requests use the port.
        received: the array to which bytes read out are appended; all ports of the host share it.
        delay_ps: the time that the host's program takes before each byte, ps.
    """

    def __init__(self, chip: Connection, queue: RequestQueue, received: bytearray, delay_ps: int) -> None:
        host, self.kernel, self.queue, self.received, self.delay_ps = (
            queue.name,
            queue.kernel,
            queue,
            received,
            delay_ps,
        )
        self.chip, self.sheet, self.clock = chip.name, chip.sheet, chip.clock
        self.verify_bytes = chip.sheet.through(BusHandshake).verify_bytes
        self.sent = 0  # without the bytes being sent as a value

        def line(role: str) -> Net:
            """Return the net of the pin with the given role; if the part has no such pin, a new net that reads high."""
            row = chip.sheet.role(role)
            return Net(self.kernel, f"{host}.({role})", tie=1) if row is None else chip.pins[row.name].net

        self.request, self.select, self.prog = (
            Driver(line(role), host) for role in ("request", "select", "program_entry")
        )
        self.bus = Driver(chip.bus, host)
        self.request.drive(1)
        self.select.drive(0)
        self.ready, self.slew, self.mode = line("ready"), line("slewing"), line("text")
        self.outstrobe, self.motion_complete, self.running = (
            line("out_strobe"), line("motion_complete"), line("running"),
        )  # fmt: skip

        self.bytes = BusSender(self)

    @property
    def all_sent(self) -> int:
        """The number of bytes sent so far."""
        exchange = self.bytes.exchange
        return self.sent + (0 if exchange is None else exchange.in_flight)

    def awaits(self, _number: int, low: bool) -> tuple[tuple[Net, int], ...]:
        """Return the READY net and the awaited level: low if I/O REQUEST is low (`low`), otherwise high."""
        return ((self.ready, 0 if low else 1),)

    def rest(self) -> None:
        """Release the bus and PROG/LIVE, and set I/O REQUEST high and I/O SELECT low."""
        self.request.drive(1)
        self.select.drive(0)
        self.prog.drive(None)
        self.bus.drive(None)

    def ps(self, us: int) -> int:
        """Convert a time from the data sheet (µs) to picoseconds at the chip's actual crystal frequency."""
        return self.clock.ps(us * self.sheet.crystal_hz // 1_000_000)

    def text(self, command: str) -> bytes:
        """Return the bytes of a command in the chip's current mode: ASCII, or binary (letter, count and data).

        Raises:
            UsageError: the chip is in binary mode, and the text is not a command.
        """
        from ....language.dialect import spoken_as
        from ....language.text import CommandText, TextDialect

        line = command.encode("ascii") + b"\r"
        if self.mode.level == 1:
            row = self.sheet.rows(TextRow).by_form.get(command)
            return line if row is None or row.terminated else line[:-1]
        spoken = spoken_as(self.sheet, TextDialect)
        decoder = spoken.decoder(self.sheet)
        for byte in line:
            found = decoder.feed(byte, True, False)
            if isinstance(found, CommandText):
                return spoken.encoded(found)
        raise UsageError(f"host: {command!r} is not a command, so it cannot be converted to binary")

    def group_size(self, group: int) -> int:
        """Return the size of a verify group in bytes; group 0 (position) has 5 digits, or 2 bytes in binary mode."""
        return 2 if group == 0 and self.mode.level == 0 else self.verify_bytes[group]

    def group_of(self, command: str) -> int | None:
        """Return the verify group that a command selects; None if it selects none, or if the group does not exist."""
        for row in self.sheet.acting("read"):
            match = re.fullmatch(rf"{re.escape(row.form)} *([0-9]+) *", command)
            if match and int(match[1]) in self.verify_bytes:
                return int(match[1])
        return None

    def pointing_at(self, group: int) -> str:
        """Return the command that selects a verify group."""
        (row,) = self.sheet.acting("read")
        return f"{row.form} {group}"

    # ----------------------------------------------------------------------------------------------- in the host's task
    async def send(self, data: bytes) -> None:
        """Send bytes with the two-line handshake; the last byte stays on the bus until the chip has accepted it."""
        kernel, queue, ready, drive_bus, request = (
            self.kernel, self.queue, self.ready, self.bus.put, self.request.put,
        )  # fmt: skip
        at, exchange = 0, None if self.delay_ps else self.bytes.possible()
        while at < len(data):
            if exchange is None or not exchange.opened:
                if exchange is not None and exchange.by_value:
                    await exchange.reopened()
                if ready.level != 1:
                    await level(ready, 1)
                if self.delay_ps:
                    await until(kernel, kernel.now + self.delay_ps)
            queue.begun = True
            if exchange is not None and self.bytes.begin(data, at):
                try:
                    await exchange.end()
                finally:
                    self.sent += exchange.through
                at += exchange.through
                if exchange.by_value or not exchange.low:
                    continue
            else:
                drive_bus((0xFF, data[at]))
                request(0)
                if ready.level == 0:  # another driver has pulled READY low: the request has been received, and ends
                    await next_round(kernel)
                await level(ready, 0)
            request(1)
            self.sent += 1
            at += 1
        if not self.bytes.by_value:
            drive_bus(None)

    async def fetch(self, number: int) -> bytes:
        """Read and return `number` verify bytes (s.6): I/O SELECT is high, with one I/O REQUEST per byte."""
        data = bytearray()
        await level(self.ready, 1)
        self.bus.drive(None)
        self.select.drive(1)
        for _ in range(number):
            await level(self.ready, 1)
            self.request.drive(0)
            await level(self.ready, 0)
            data.append(self.bus.net.byte)  # type: ignore[attr-defined]
            self.request.drive(1)
            await level(self.ready, 1)
        self.select.drive(0)
        self.received += data
        return bytes(data)

    async def start(self) -> None:
        """Send the command that runs the stored program, and wait until this program runs."""
        await self.command_mode("wait until RUN is high, or use live commands")
        (run,) = self.sheet.acting("run")
        await self.send(self.text(run.form))
        await level(self.running, 0)

    async def command_mode(self, remedy: str) -> None:
        """Wait until READY is high, so that a command may be sent.

        Raises:
            UsageError: a program is running, so the chip accepts no command; the message ends with `remedy`.
        """
        await level(self.ready, 1)
        if self.running.level == 0:
            raise UsageError(f"{self.queue.name}: {self.chip} accepts no command while its program runs; {remedy}")

    async def live(self, commands: Sequence[str], number: int | None = None) -> list[tuple[int, bytes]]:
        """Send commands through PROG/LIVE, and return (group, bytes) for each verify group that they select.

        `number`: the number of bytes to read per group; None: the whole group.
        """
        self.prog.drive(0)
        await self._between_instructions()
        last, found = commands[-1], []
        if self.group_of(last) is None:
            commands = commands[:-1]  # else twice: the repeated command has no effect
        for command in commands:
            await self.send(self.text(command))
            group = self.group_of(command)
            if group is not None:
                found.append((group, await self.fetch(self.group_size(group) if number is None else number)))
        data = self.text(last)
        await self.send(data[:-1])
        await level(self.ready, 1)
        self.prog.drive(None)  # before the last terminator, so that the program continues after it
        await self.send(data[-1:])
        await level(self.ready, 1)
        return found

    async def _between_instructions(self) -> None:
        """Wait for a gap between two instructions.

        READY must stay high for `SETTLED_US`, because just after it rises, a motion may be about to begin.
        """
        while True:
            await level(self.ready, 1)
            if await first_of(self.kernel, self.kernel.now + self.ps(SETTLED_US), (self.ready, 0)) is None:
                return

    async def verify(self, group: int, number: int | None = None, live: bool | None = False) -> bytes:
        """Select a verify group, read it, and return its bytes; the arguments are as for `BusHost.verify`."""
        if live is None:
            await level(self.ready, 1)
            live = self.running.level == 0
        if live:
            return (await self.live([self.pointing_at(group)], number))[0][1]
        await self.command_mode(f"verify({group}, live=True) reads through PROG/LIVE")
        await self.send(self.text(self.pointing_at(group)))
        return await self.fetch(self.group_size(group) if number is None else number)

    async def change_rate(self, rate: int) -> None:
        """Request another rate while the motor slews (s.7).

        Wait for SLEW low, put the rate on the bus, and hold I/O REQUEST low until SLEW is high.
        """
        await level(self.slew, 0)
        self.bus.drive((0xFF, rate))
        self.request.drive(0)
        await level(self.slew, 1)
        self.request.drive(1)
        self.bus.drive(None)

    async def read_position(self) -> int:
        """Return the position that the chip outputs while the motor steps (s.6).

        I/O SELECT is high; one byte is read at each of two rising edges of OUTSTROBE, the high byte first.
        """
        self.select.drive(1)
        data = bytearray()
        for _ in range(2):
            await level(self.outstrobe, 0)
            await level(self.outstrobe, 1)
            data.append(self.bus.net.byte)  # type: ignore[attr-defined]
        await level(self.motion_complete, 1)
        self.select.drive(0)
        self.received += data
        return int.from_bytes(data, "big")


class BusSender(Leader[Handshakes]):
    """The sender of a port's bytes to its chip: several bytes as one value, without simulating each edge.

    All edges are computed from the value (`HandshakenBytes`).  Where this is not possible,
    `CommandPort.send` sends the bytes edge by edge.
    """

    def __init__(self, port: CommandPort) -> None:
        super().__init__(port.request.net)
        self.port = port

    @property
    def by_value(self) -> bool:
        """True if the last bytes were sent as one value, and the lines have not been observed since then."""
        return self.exchange is not None and self.exchange.by_value

    def begin(self, data: bytes, at: int) -> bool:
        """Begin to send `data`, from index `at` on, as one value; return False if this is not possible."""
        port, exchange = self.port, self.exchange
        if exchange is None or not (number := exchange.chip.takes(data, at)):
            return False
        before = exchange.state.on_bus if exchange.by_value else port.bus.level
        sent, chip = data[at : at + number], exchange.chip
        last = at + number == len(data)
        coming = HandshakenBytes(sent, port.kernel.now, before, last, chip.byte_times, chip.clock)
        return exchange.send(coming)

    def made(self, ends: tuple[Any, ...]) -> Handshakes | None:
        """Return the exchange between this port and the chip on I/O REQUEST.

        Return None unless exactly one chip is wired to I/O REQUEST, and the port reads the READY of this chip.
        """
        port = self.port
        if len(ends) != 1 or not hasattr(ends[0], "byte_times"):
            return None
        chip: TakingEnd = ends[0]
        return Handshakes(port, chip) if chip.ready.net is port.ready.root else None
