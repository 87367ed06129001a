"""The host computer: master of the two-line handshake, of verify read-outs, live commands and requests on the fly.

    wait READY high, byte on the bus, I/O REQUEST low, wait READY low, I/O REQUEST high           (s.2, s.11)

A host never hesitates unless it is told to: `delay_ps` is what its program takes before each byte.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Awaitable, Callable, Sequence
from typing import TYPE_CHECKING, Any

from ..core.channel import Channel
from ..core.hook import Hook
from ..core.kernel import Kernel, Task
from ..core.net import Driver
from ..core.pin import Condition, GotCondition
from ..core.table import Sheet
from ..core.timebase import Clock, Time, readable
from ..core.waits import first_of, level, until
from ..errors import Timeout, UsageError
from .part import Part, served

if TYPE_CHECKING:
    from ..core.chip import Chip

Action = Callable[["Port"], Awaitable[None]]
SETTLED_US = 100  # READY high for longer than any instruction takes to begin: the chip is between two of them


class Port:
    """What a host has on one chip: drivers on its command port, and the nets that it looks at."""

    def __init__(self, chip: Chip, host: str) -> None:
        self.chip = chip.name
        self.sheet: Sheet = chip.sheet
        self.clock: Clock = chip.clock
        self.request, self.select = (Driver(chip.pin(name).net, host) for name in ("io_request", "io_select"))
        self.prog, self.bus = Driver(chip.pin("prog").net, host), Driver(chip.bus, host)
        self.request.drive(1)
        self.select.drive(0)
        pins = chip.pins
        self.ready, self.slew, self.mode = pins["ready"].net, pins["slew"].net, pins["ascii_binary"].net
        self.outstrobe, self.motion_complete = pins["outstrobe"].net, pins["motion_complete"].net
        self.running = pins["run"].net

    def ps(self, us: int) -> int:
        """A time that is stated at 11 MHz, at the crystal of the chip."""
        return self.clock.ps(us * self.sheet.crystal_hz // 1_000_000)

    def text(self, command: str) -> bytes:
        """A command as this port takes it now: ASCII, or letter, count and data in binary mode."""
        from ..language.dialect import Command
        from ..language.letters import Decoder, encode_binary

        line = command.encode("ascii") + b"\r"
        if self.mode.level == 1:
            return command.encode("ascii") if command == "Q" else line
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
        """The verify group that a command points at; None: it is no V, or there is no such group."""
        match = re.fullmatch(r"V *([0-9]+) *", command)
        group = int(match[1]) if match else -1
        return group if group in self.sheet.verify_bytes else None


class Host(Part):
    """A host computer on the command port of one or several chips that share its bus."""

    def __init__(self, kernel: Kernel, name: str, chips: Sequence[Chip], delay_ps: int = 0) -> None:
        super().__init__(kernel, name)
        self.delay_ps = delay_ps
        self.chips = {chip.name: chip for chip in chips}
        self.ports = {chip.name: Port(chip, name) for chip in chips}
        self.port = next(iter(self.ports.values()))
        self.channel: Channel = self.port.sheet.channels[0]
        self.queue: deque[tuple[Port, bytes | Action]] = deque()
        self.received = bytearray()  # what read-outs brought
        self.sent = 0
        self.begun = False  # has a byte of what comes first in the queue gone out?
        self.task: Task | None = None
        self.doing = ""
        self.since = 0
        self.answer: Any = None
        self.refused: UsageError | None = None  # what the latest call found when its turn came
        self.on_event: Hook[[str]] = Hook()  # what it does, in words: a line of a script, an answer

    @property
    def chip(self) -> Chip:
        """The chip that it speaks to."""
        return self.chips[self.port.chip]

    # ------------------------------------------------------------------------------------------------------ queueing
    def to(self, chip: str | Chip) -> Host:
        """From now on, speak to this chip."""
        self.port = served(self.name, self.ports, chip)
        return self

    def send(self, data: str | bytes) -> None:
        """Queue bytes; they go out as fast as the handshake allows.  Text must be ASCII."""
        if isinstance(data, str):
            if not data.isascii():
                at = next(i for i, c in enumerate(data) if ord(c) > 127)
                where = f"{data[at]!r} at character {at + 1}"
                raise UsageError(f"{self.name}: {where} is not ASCII; send bytes for raw values")
            data = data.encode("ascii")
        elif not isinstance(data, (bytes, bytearray)):
            raise UsageError(f"{self.name}: send({data!r}); expected text or bytes")
        self._journal("send", [self.port.chip, bytes(data).hex()])
        if data:
            self.queue.append((self.port, bytes(data)))
        self._wake()

    def do(self, action: Action) -> None:
        """Queue something else than a byte: a coroutine function that gets the port."""
        self.queue.append((self.port, action))
        self._wake()

    def clear(self) -> None:
        """Forget what is queued, and let go of the bus and of PROG/LIVE: the host's program has been started anew."""
        self._journal("clear", [])
        self.queue.clear()
        self.begun = False
        if self.task is not None:
            self.task.kill()
        for port in self.ports.values():
            port.request.drive(1)
            port.select.drive(0)
            port.prog.drive(None)
            port.bus.drive(None)
        self.kernel.settle()

    def drop(self) -> None:
        """Forget what is queued; a command that has begun to go out is not cut in two: the chip gets the rest of it."""
        if not self.begun:
            self.clear()
            return
        self._journal("drop", [])
        while len(self.queue) > 1:
            self.queue.pop()

    def _wake(self) -> None:
        if self.queue and (self.task is None or not self.task.alive):
            self.task = self.kernel.spawn(self._run(), self.name)
            self.since = self.kernel.now

    def _journal(self, verb: str, args: list[Any]) -> None:
        self.kernel.outside.tell(verb, host=self.name, args=args)

    @property
    def idle(self) -> bool:
        return not self.queue and (self.task is None or not self.task.alive)

    @property
    def waiting(self) -> str:
        if self.idle:
            return f"{self.name}: nothing to send"
        return f"{self.name}: {self.doing}, {len(self.queue)} in the queue, since {readable(self.since)}"

    def got(self, data: bytes) -> Condition:
        """Condition: these bytes have been received."""
        return GotCondition(self.name, self.received, bytes(data))

    # ------------------------------------------------------------------------------------------------- the host's task
    async def _run(self) -> None:
        queue = self.queue
        while queue:
            port, item = queue[0]
            self.since = self.kernel.now
            if isinstance(item, bytes):
                self.doing = f"sends to {port.chip}"
                await self.send_now(port, item)
            else:
                try:
                    await item(port)
                except Exception:
                    queue.clear()  # what stands behind the action that failed is not done either
                    raise
            queue.popleft()
            self.begun = False

    async def send_now(self, port: Port, data: bytes) -> None:
        """The two-line handshake, byte after byte; the last byte leaves the bus when it has been taken."""
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

    # -------------------------------------------------------------------------------------- calls that let time pass
    def _call(self, verb: str, args: list[Any], action: Action, timeout: Time) -> Any:
        self._journal("call", [verb, self.port.chip, *args])
        self.answer = self.refused = None

        async def guarded(port: Port) -> None:
            try:
                await action(port)
            except UsageError as error:
                self.refused = error

        self.do(guarded)
        try:
            if not self.kernel.outside.wait(lambda: self.idle, f"{self.name}.{verb}", timeout):
                return None
        except Timeout:
            self.give_up()
            raise
        if self.refused is not None:
            raise self.refused
        return self.answer

    def give_up(self) -> None:
        """Take back the last call, which took too long: its lines rest, and what comes after it can go on."""
        if len(self.queue) == 1:
            self.clear()
        elif self.queue:
            self._journal("give_up", [])
            self.queue.pop()

    def run_program(self, timeout: Time = "5 s") -> None:
        """Send X, and let time pass until RUN is low; from then on only live commands count, until RUN is high again.

        Raises:
            UsageError: a program runs already.
        """

        async def action(port: Port) -> None:
            self.doing = f"starts the program of {port.chip}"
            await self.command_mode(port, "wait until RUN is high, or give live commands")
            await self.send_now(port, port.text("X"))
            await level(port.running, 0)

        self._call("run_program", [], action, timeout)

    async def command_mode(self, port: Port, remedy: str) -> None:
        """Wait until a byte may be sent.

        Raises:
            UsageError: a program runs, which takes none.
        """
        await level(port.ready, 1)
        if port.running.level == 0:
            raise UsageError(f"{self.name}: the program of {port.chip} runs and takes no command; {remedy}")

    def live(self, *commands: str, timeout: Time = "5 s") -> bytes:
        """Give commands to a chip whose program is running, through PROG/LIVE (s.7).

        Returns:
            The groups that V commands among them read, one behind the other.

        Raises:
            UsageError: no command, or one that is no ASCII text.
            Timeout: the chip does not take them in time.
        """
        for command in commands or ("",):
            if not isinstance(command, str) or not command or not command.isascii():
                raise UsageError(f"{self.name}: live command {command!r}; expected text such as 'R 20'")

        async def action(port: Port) -> None:
            self.doing = f"live commands {', '.join(commands)} to {port.chip}"
            self.answer = await self.live_now(port, commands)

        return b"".join(data for _, data in self._call("live", list(commands), action, timeout) or ())

    async def live_now(self, port: Port, commands: Sequence[str], number: int | None = None) -> list[tuple[int, bytes]]:
        """Give commands through PROG/LIVE, each V followed by its read-out; return (group, bytes) of each."""
        port.prog.drive(0)
        await self._between_instructions(port)
        last, found = commands[-1], []
        if port.group_of(last) is None:
            commands = commands[:-1]  # else V twice: the chip is left by one more command, and V changes nothing
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

    def verify(self, group: int, number: int | None = None, timeout: Time = "5 s", live: bool | None = False) -> bytes:
        """Read a verify group: bytes as the chip delivers them (group 0: five digits, or two bytes in binary mode).

        Args:
            group: 0 position, 1 program, 2 status, 3 parameters (Table VI).
            number: how many bytes; all of the group by default.
            live: read between two instructions of a running program, through PROG/LIVE (s.3 V); None: if one runs.

        Raises:
            UsageError: no such group, or a program runs and `live` was not asked for.
        """
        if group not in self.port.sheet.verify_bytes or (
            number is not None and (not isinstance(number, int) or number < 0)
        ):
            raise UsageError(f"{self.name}: verify({group!r}, {number!r}); allowed groups 0 to 3, and 0 or more bytes")

        async def action(port: Port) -> None:
            self.doing = f"reads verify group {group} of {port.chip}"
            self.answer = await self.verify_now(port, group, number, live)

        return self._call("verify", [group, number, timeout, live], action, timeout)  # type: ignore[no-any-return]

    async def verify_now(self, port: Port, group: int, number: int | None = None, live: bool | None = False) -> bytes:
        """Send V and read the group; `live` as with `verify`."""
        if live is None:
            await level(port.ready, 1)
            live = port.running.level == 0
        if live:
            return (await self.live_now(port, [f"V {group}"], number))[0][1]
        await self.command_mode(port, f"verify({group}, live=True) reads through PROG/LIVE")
        await self.send_now(port, port.text(f"V {group}"))
        return await self.fetch(port, port.group_size(group) if number is None else number)

    def change_rate(self, rate: int, timeout: Time = "5 s") -> None:
        """Request a new rate on the fly (s.7): SLEW low, rate on the bus, I/O REQUEST low until SLEW is high.

        Raises:
            UsageError: `rate` is not 0 to 255.
            Timeout: the chip does not take it in time.
        """
        if not isinstance(rate, int) or not 0 <= rate <= 255:
            raise UsageError(f"{self.name}: rate {rate!r}; allowed 0 to 127 (a byte goes out as it is)")

        async def action(port: Port) -> None:
            self.doing = f"requests rate {rate} of {port.chip}"
            await level(port.slew, 0)
            port.bus.drive((0xFF, rate))
            port.request.drive(0)
            await level(port.slew, 1)
            port.request.drive(1)
            port.bus.drive(None)

        self._call("change_rate", [rate], action, timeout)

    def read_position(self, timeout: Time = "5 s") -> int:
        """Read the position on the fly (s.6): I/O SELECT high, one byte at each rise of OUTSTROBE."""

        async def action(port: Port) -> None:
            self.doing = f"reads the position of {port.chip} on the fly"
            port.select.drive(1)
            data = bytearray()
            for _ in range(2):
                await level(port.outstrobe, 0)
                await level(port.outstrobe, 1)
                data.append(port.bus.net.byte)  # type: ignore[attr-defined]
            await level(port.motion_complete, 1)
            port.select.drive(0)
            self.received += data
            self.answer = int.from_bytes(data, "big")

        return self._call("read_position", [], action, timeout)  # type: ignore[no-any-return]
