"""The host computer: master of the two-line handshake, of verify read-outs, live commands and requests on the fly.

    wait READY high, byte on the bus, I/O REQUEST low, wait READY low, I/O REQUEST high           (s.2, s.11)

A host never hesitates unless it is told to: `delay_ps` is what its program takes before each byte.
"""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable, Sequence
from typing import TYPE_CHECKING, ClassVar, TypeVar

from ...core.messages.calls import answering
from ...core.messages.whole import whole
from ...core.time.inputs import from_outside
from ...core.wires.net import Driver, Net
from ...core.wires.pin import Condition, GotCondition
from ...core.wires.waits import first_of, level, until
from ...errors import Timeout, UsageError
from ..base.part import served
from ..base.worker import Data, as_bytes
from .computer import Computer

if TYPE_CHECKING:
    from ...core.time.kernel import Kernel
    from ...core.time.timebase import Time
    from ..base.caller import Errand
    from .connection import Connection

Action = Callable[["Port"], Awaitable[None]]
NO_READ_OUT = "the part cannot be read, only sent to"
SETTLED_US = 100  # READY high for longer than any instruction takes to begin: the chip is between two of them
T = TypeVar("T")


class Port:
    """What a host has on one chip: drivers on its command port, and the nets that it looks at."""

    def __init__(self, chip: Connection, host: str) -> None:
        self.chip, self.sheet, self.clock = chip.name, chip.sheet, chip.clock

        def line(role: str) -> Net:
            """Return the net of the pin that has a role; where the part lacks one, a net that leads nowhere."""
            row = chip.sheet.role(role)
            return Net(chip.bus.kernel, f"{host}.({role})", tie=1) if row is None else chip.pins[row.name].net

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

    def rest(self) -> None:
        """Let go of the bus and of PROG/LIVE, and ask for nothing."""
        self.request.drive(1)
        self.select.drive(0)
        self.prog.drive(None)
        self.bus.drive(None)

    def ps(self, us: int) -> int:
        """Return the picoseconds, at the crystal of the chip, of a time that is stated at that of the sheet."""
        return self.clock.ps(us * self.sheet.crystal_hz // 1_000_000)

    def text(self, command: str) -> bytes:
        """Return a command as this port takes it now: ASCII, or letter, count and data in binary mode."""
        from ...language.dialect import Command
        from ...language.letters import Decoder, encode_binary

        line = command.encode("ascii") + b"\r"
        if self.mode.level == 1:
            row = self.sheet.commands.by_form.get(command)
            return line if row is None or row.terminated else line[:-1]
        decoder = Decoder(self.sheet)
        for byte in line:
            found = decoder.feed(byte, True, False)
            if isinstance(found, Command):
                return encode_binary(found.row, found.values)
        raise UsageError(f"host: {command!r} is no command; it cannot be put into binary form")

    def group_size(self, group: int) -> int:
        """Bytes of a verify group in the present mode: the position has five digits, or two bytes in binary mode."""
        return 2 if group == 0 and self.mode.level == 0 else self.sheet.verify_bytes[group]

    def group_of(self, command: str) -> int | None:
        """Return the verify group that a command points at; None: it points at none, or there is no such group."""
        for row in self.sheet.acting("read"):
            match = re.fullmatch(rf"{re.escape(row.form)} *([0-9]+) *", command)
            if match and int(match[1]) in self.sheet.verify_bytes:
                return int(match[1])
        return None

    def pointing_at(self, group: int) -> str:
        """Return the command that points at a verify group."""
        (row,) = self.sheet.acting("read")
        return f"{row.form} {group}"


class Host(Computer):
    """A host computer on the command port of one or several chips that share its bus."""

    for_users: ClassVar[tuple[str, ...]] = (
        "run_program",
        "verify",
        "live",
        "change_rate",
        "read_position",
        "sent",
        "write",
        "delay_ps",
    )

    def __init__(self, kernel: Kernel, name: str, chips: Sequence[Connection], delay_ps: int = 0) -> None:
        super().__init__(kernel, name, chips)
        self.delay_ps = delay_ps
        self.ports = {chip.name: Port(chip, name) for chip in chips}
        self.received: bytearray = bytearray()  # what read-outs brought
        self.sent = 0

    @property
    def port(self) -> Port:
        """What it has on the chip that it speaks to."""
        return self.ports[self.chip.name]

    def send(self, data: str | bytes) -> None:
        """Queue bytes; they go out as fast as the handshake allows.  No time passes.

        Raises:
            UsageError: text that is not ASCII, or neither text nor bytes.
        """
        self.write(self.chip.name, as_bytes(self.name, data))

    def got(self, data: Data) -> Condition:
        """Return a condition for `bench.run_until`: read-outs have brought these bytes, one behind the other."""
        return GotCondition(self.name, self.received, as_bytes(self.name, data))

    def do(self, action: Action) -> None:
        """Queue something else than a byte: a coroutine function that gets the port."""
        port = self.port
        self.work(f"something of its own with {port.chip}", lambda: action(port))

    def rest(self) -> None:
        """Put the lines of every chip to rest."""
        for port in self.ports.values():
            port.rest()

    # ------------------------------------------------------------------------------------------------- the host's task
    async def send_now(self, port: Port, data: bytes) -> None:
        """Send bytes by the two-line handshake; the last one leaves the bus when it has been taken."""
        kernel, ready, drive_bus, request = self.kernel, port.ready, port.bus.drive, port.request.drive
        for byte in data:
            if ready.level != 1:
                await level(ready, 1)
            if self.delay_ps:
                await until(kernel, kernel.now + self.delay_ps)
            self.begun = True
            drive_bus((0xFF, byte))
            request(0)
            await level(ready, 0)
            request(1)
            self.sent += 1
        drive_bus(None)

    async def fetch(self, port: Port, number: int) -> bytes:
        """Read verify bytes (s.6): I/O SELECT high, one I/O REQUEST a byte."""
        data = bytearray()
        await level(port.ready, 1)
        port.bus.drive(None)
        port.select.drive(1)
        for _ in range(number):
            await level(port.ready, 1)
            port.request.drive(0)
            await level(port.ready, 0)
            data.append(port.bus.net.byte)  # type: ignore[attr-defined]
            port.request.drive(1)
            await level(port.ready, 1)
        port.select.drive(0)
        self.received += data
        return bytes(data)

    async def start_now(self, port: Port) -> None:
        """Send the command that runs the program, and wait until it runs."""
        await self.command_mode(port, "wait until RUN is high, or give live commands")
        (run,) = port.sheet.acting("run")
        await self.send_now(port, port.text(run.form))
        await level(port.running, 0)

    async def command_mode(self, port: Port, remedy: str) -> None:
        """Wait until a byte may be sent.

        Raises:
            UsageError: a program runs, which takes none.
        """
        await level(port.ready, 1)
        if port.running.level == 0:
            raise UsageError(f"{self.name}: the program of {port.chip} runs and takes no command; {remedy}")

    async def live_now(self, port: Port, commands: Sequence[str], number: int | None = None) -> list[tuple[int, bytes]]:
        """Give commands through PROG/LIVE, read out what they point at; return (group, bytes) of each read-out."""
        port.prog.drive(0)
        await self._between_instructions(port)
        last, found = commands[-1], []
        if port.group_of(last) is None:
            commands = commands[:-1]  # else twice: the chip is left by one more command, and this one changes nothing
        for command in commands:
            await self.send_now(port, port.text(command))
            group = port.group_of(command)
            if group is not None:
                found.append((group, await self.fetch(port, port.group_size(group) if number is None else number)))
        data = port.text(last)
        await self.send_now(port, data[:-1])
        await level(port.ready, 1)
        port.prog.drive(None)  # before the last terminator, so that the program goes on behind it
        await self.send_now(port, data[-1:])
        await level(port.ready, 1)
        return found

    async def _between_instructions(self, port: Port) -> None:
        """READY high alone does not say it: an instruction may be about to begin a motion."""
        while True:
            await level(port.ready, 1)
            if await first_of(self.kernel, self.kernel.now + port.ps(SETTLED_US), (port.ready, 0)) is None:
                return

    async def verify_now(self, port: Port, group: int, number: int | None = None, live: bool | None = False) -> bytes:
        """Point at a group and read it; `live` as with `verify`."""
        if live is None:
            await level(port.ready, 1)
            live = port.running.level == 0
        if live:
            return (await self.live_now(port, [port.pointing_at(group)], number))[0][1]
        await self.command_mode(port, f"verify({group}, live=True) reads through PROG/LIVE")
        await self.send_now(port, port.text(port.pointing_at(group)))
        return await self.fetch(port, port.group_size(group) if number is None else number)

    async def rate_now(self, port: Port, rate: int) -> None:
        """Request a rate while the motor slews: SLEW low, rate on the bus, I/O REQUEST low until SLEW is high (s.7)."""
        await level(port.slew, 0)
        port.bus.drive((0xFF, rate))
        port.request.drive(0)
        await level(port.slew, 1)
        port.request.drive(1)
        port.bus.drive(None)

    async def position_now(self, port: Port) -> int:
        """Read the position while the motor steps: I/O SELECT high, one byte at each rise of OUTSTROBE (s.6)."""
        port.select.drive(1)
        data = bytearray()
        for _ in range(2):
            await level(port.outstrobe, 0)
            await level(port.outstrobe, 1)
            data.append(port.bus.net.byte)  # type: ignore[attr-defined]
        await level(port.motion_complete, 1)
        port.select.drive(0)
        self.received += data
        return int.from_bytes(data, "big")

    # ------------------------------------------------------------------------ the queue, which is what a journal keeps
    @answering("host.write()", "; host.send(...) sends to the chip that is spoken to")
    @from_outside
    def write(self, chip: str, data: Sequence[int]) -> None:
        """Queue bytes for a chip."""
        port, data = served(self.name, self.ports, chip), bytes(data)
        self.input("write", chip, data)
        if data:
            self.work(f"sends to {chip}", lambda: self.send_now(port, data))

    @from_outside
    def start(self, chip: str) -> Errand[None]:
        """Queue the start of the program of a chip."""
        port = served(self.name, self.ports, chip)
        self.input("start", chip)
        return self.errand(f"starts the program of {chip}", lambda: self.start_now(port))

    @from_outside
    def interject(self, chip: str, commands: Sequence[str]) -> Errand[list[tuple[int, bytes]]]:
        """Queue commands to the running program of a chip."""
        port = served(self.name, self.ports, chip)
        self.input("interject", chip, list(commands))
        text = f"live commands {', '.join(commands)} to {chip}"
        return self.errand(text, lambda: self.live_now(port, commands))

    @from_outside
    def read_group(self, chip: str, group: int, number: int | None, live: bool | None) -> Errand[bytes]:
        """Queue the read-out of a verify group of a chip."""
        port = served(self.name, self.ports, chip)
        self.input("read_group", chip, group, number, live)
        text = f"reads verify group {group} of {chip}"
        return self.errand(text, lambda: self.verify_now(port, group, number, live))

    @from_outside
    def request_rate(self, chip: str, rate: int) -> Errand[None]:
        """Queue the request of a chip for another rate."""
        port = served(self.name, self.ports, chip)
        self.input("request_rate", chip, rate)
        return self.errand(f"requests rate {rate} of {chip}", lambda: self.rate_now(port, rate))

    @from_outside
    def request_position(self, chip: str) -> Errand[int]:
        """Queue a look at the position of a chip that moves."""
        port = served(self.name, self.ports, chip)
        self.input("request_position", chip)
        return self.errand(f"reads the position of {chip} on the fly", lambda: self.position_now(port))

    # -------------------------------------------------------------------------------------- calls that let time pass
    def ask(self, command: str, timeout: Time = "5 s") -> bytes:
        """Send V and the number of a group, and return the bytes of the group, as `verify` does.

        Raises:
            UsageError: another command, which is not answered; or a program runs.
            Timeout: the chip does not answer in time.
        """
        group = self.port.group_of(command) if isinstance(command, str) else None
        if group is None:
            groups = ", ".join(repr(self.port.pointing_at(number)) for number in self.port.sheet.verify_bytes)
            answered = f"ask {groups}, and send() the rest" if groups else NO_READ_OUT
            raise UsageError(f"{self.name}: {command!r} is not answered; {answered}")
        return self.verify(group, timeout=timeout)

    def run_program(self, timeout: Time = "5 s") -> None:
        """Send X, and let time pass until RUN is low; from then on only live commands count, until RUN is high again.

        Raises:
            UsageError: a program runs already.
            Timeout: RUN is not low in time.
        """
        self.answer_of(self.start(self.chip.name), timeout)

    def live(self, *commands: str, timeout: Time = "5 s") -> bytes:
        """Give commands to a chip whose program is running, through PROG/LIVE (s.7).

        Returns:
            The groups that V commands among them read, one behind the other.

        Raises:
            UsageError: no command, or one that is no ASCII text; or the part takes none while its program runs.
            Timeout: the chip does not take them in time.
        """
        for command in commands or ("",):
            if not isinstance(command, str) or not command or not command.isascii():
                raise UsageError(f"{self.name}: live command {command!r}; expected text such as 'R 20'")
        if not self.port.sheet.takes_live:
            raise UsageError(f"{self._part} takes no commands while its program runs; wait for its end")
        if self.idle and self.port.running.level != 0 and self.port.ready.level == 1:
            raise UsageError(
                f"{self.name}: no program of {self.port.chip} runs, which live commands go to; send() sends a command, "
                "run_program() starts the program"
            )
        found = self.answer_of(self.interject(self.chip.name, commands), timeout)
        return b"".join(data for _, data in found or ())

    @answering("host.verify()", "; groups are 0 to 3")
    def verify(self, group: int, number: int | None = None, timeout: Time = "5 s", live: bool | None = False) -> bytes:
        """Read a verify group: bytes as the chip delivers them (group 0: five digits, or two bytes in binary mode).

        Args:
            group: 0 position, 1 program, 2 status, 3 parameters (Table VI).  Of a program that is 48 bytes, as the
                table has it, of up to 60; `x.program` has all of them.
            number: how many bytes; all of the group by default.
            live: read between two instructions of a running program, through PROG/LIVE (s.3 V); None: if one runs.

        Raises:
            UsageError: no such group, or a program runs and `live` was not asked for.
            Timeout: the chip does not answer in time.
        """
        count = None if number is None else whole(number)
        which = whole(group)
        if (
            which is None
            or which not in self.port.sheet.verify_bytes
            or (number is not None and (count is None or count < 0))
        ):
            groups = list(self.port.sheet.verify_bytes)
            allowed = f"allowed groups {groups[0]} to {groups[-1]}, and 0 or more bytes" if groups else NO_READ_OUT
            raise UsageError(f"{self.name}: verify({group!r}, {number!r}); {allowed}")
        return self.answer_of(self.read_group(self.chip.name, which, count, live), timeout)

    def change_rate(self, rate: int, timeout: Time = "5 s") -> None:
        """Request a new rate on the fly (s.7), when the motor slews.

        Raises:
            UsageError: `rate` is not 0 to 255, or the part takes none.
            Timeout: the chip does not take it in time.
        """
        value = whole(rate)
        if value is None or not 0 <= value <= 255:
            raise UsageError(f"{self.name}: rate {rate!r}; allowed 0 to 127 (a byte goes out as it is)")
        self._needs("slewing", "takes no rate on the fly")
        taken = "a rate is taken while the motor slews, in a motion behind H and G"
        self._on_the_fly(self.request_rate(self.chip.name, value), timeout, taken)

    def read_position(self, timeout: Time = "5 s") -> int:
        """Return the position, read on the fly (s.6): two bytes, 0 to 65535, while the motor steps.

        Raises:
            UsageError: the part does not tell it.
            Timeout: the motor does not step.
        """
        self._needs("out_strobe", "tells no position on the fly")
        return self._on_the_fly(
            self.request_position(self.chip.name),
            timeout,
            "it is told while the motor steps; at rest verify(0) reads it",
        )

    def _on_the_fly(self, errand: Errand[T], timeout: Time, taken: str) -> T:
        """Wait for what goes on while the motor moves."""
        try:
            return self.answer_of(errand, timeout)
        except Timeout as error:
            raise Timeout(f"{error}\n  {taken}") from None

    @property
    def _part(self) -> str:
        """The chip and its part number, as a message begins."""
        return f"{self.name}: {self.chip.name} ({self.chip.sheet.part})"

    def _needs(self, role: str, otherwise: str) -> None:
        """Refuse a call for which the part lacks a pin."""
        if self.chip.sheet.role(role) is None:
            raise UsageError(f"{self._part} {otherwise}: it has no pin for it")
