"""A host computer on a bus: two-line handshake, verify read-outs, live commands, on-the-fly requests."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from typing import TYPE_CHECKING, ClassVar, TypeVar

from ...core.messages.calls import answering
from ...core.messages.whole import whole
from ...core.time.inputs import from_outside
from ...core.wires.pin import Condition, GotCondition
from ...errors import Timeout, UsageError
from ..base.part import served
from ..base.written_data import Data, as_bytes
from .ends.handshake_port import CommandPort
from .host import TO_ONE, Host

if TYPE_CHECKING:
    from ...core.time.kernel import Kernel
    from ...core.time.timebase import Time
    from ..base.request_queue import Request
    from .connection import Connection

T = TypeVar("T")
NO_READ_OUT = "the part accepts commands but cannot be read"


class BusHost(Host):
    """A host computer on the command port of one chip, or of several chips that share a bus."""

    _for_users: ClassVar[tuple[str, ...]] = (
        "run_program",
        "verify",
        "live",
        "change_rate",
        "read_position",
        "sent",
        "do",
    )

    def __init__(self, kernel: Kernel, name: str, chips: Sequence[Connection], delay_ps: int = 0) -> None:
        super().__init__(kernel, name, chips)
        self.received: bytearray = bytearray()  # bytes of read-outs
        self.keep_recent(self.received)
        self.ports = {chip.name: CommandPort(chip, self.queue, self.received, delay_ps) for chip in chips}

    @property
    def port(self) -> CommandPort:
        """Command port of the selected chip."""
        return self.ports[self.chip.name]

    @property
    def sent(self) -> int:
        """The number of bytes sent so far, to all chips together."""
        return sum(port.all_sent for port in self.ports.values())

    def send(self, data: str | bytes) -> None:
        """Queue bytes, which are sent as fast as the handshake allows; no time passes in the call.

        Raises:
            UsageError: the text is not ASCII, or the data are neither text nor bytes.
        """
        self.write(self.chip.name, as_bytes(self.name, data))

    def got(self, data: Data) -> Condition:
        """Return a condition for `bench.run_until`: these bytes have been read out, with no others between them."""
        return GotCondition(self.name, self.received, as_bytes(self.name, data))

    def do(self, action: Callable[[CommandPort], Awaitable[object]]) -> None:
        """Queue a custom action: a coroutine function that is called with the command port of the selected chip."""
        port = self.port
        self.queue.post(f"custom action with {port.chip}", lambda: action(port))

    def _rest(self) -> None:
        """Release the lines of every chip."""
        for port in self.ports.values():
            port.rest()

    # ------------------------------------------------------------------------ the queue, which is what a journal keeps
    @answering("host.write()", "; host.send(...) sends to the selected chip")
    @from_outside
    def write(self, chip: str, data: Sequence[int]) -> None:
        """Queue bytes for the chip with the name `chip`."""
        port, data = served(self.name, self.ports, chip), as_bytes(self.name, data)
        self.input("write", chip, data)
        if data:
            self.queue.post(f"sending to {chip}", lambda: port.send(data))

    @from_outside
    def start(self, chip: str) -> Request[None]:
        """Queue the start of the program of a chip."""
        port = served(self.name, self.ports, chip)
        self.input("start", chip)
        return self.queue.submit(f"starting the program of {chip}", port.start)

    @from_outside
    def interject(self, chip: str, commands: Sequence[str]) -> Request[list[tuple[int, bytes]]]:
        """Queue commands for a chip whose program runs; the result has (group, bytes) for each verify group read."""
        port = served(self.name, self.ports, chip)
        self.input("interject", chip, list(commands))
        text = f"sending live commands {', '.join(commands)} to {chip}"
        return self.queue.submit(text, lambda: port.live(commands))

    @from_outside
    def read_group(self, chip: str, group: int, number: int | None, live: bool | None) -> Request[bytes]:
        """Queue the read-out of a verify group of a chip; `number` and `live` are as for `verify`."""
        port = served(self.name, self.ports, chip)
        self.input("read_group", chip, group, number, live)
        text = f"reading verify group {group} of {chip}"
        return self.queue.submit(text, lambda: port.verify(group, number, live))

    @from_outside
    def request_rate(self, chip: str, rate: int) -> Request[None]:
        """Queue a request to a chip to change its rate on the fly."""
        port = served(self.name, self.ports, chip)
        self.input("request_rate", chip, rate)
        return self.queue.submit(f"requesting rate {rate} of {chip}", lambda: port.change_rate(rate))

    @from_outside
    def request_position(self, chip: str) -> Request[int]:
        """Queue a read-out of a chip's position on the fly, that is, while its motor moves."""
        port = served(self.name, self.ports, chip)
        self.input("request_position", chip)
        return self.queue.submit(f"reading the position of {chip} on the fly", port.read_position)

    # -------------------------------------------------------------------------------------- calls that let time pass
    @answering("host.ask()", TO_ONE)
    def ask(self, command: str, timeout: Time = "5 s") -> bytes:
        """Send a verify command, such as "V 2", and return the bytes of its verify group, as `verify` does.

        Raises:
            UsageError: the command has no answer, or a program is running.
            Timeout: the chip does not answer in time.
        """
        group = self.port.group_of(command) if isinstance(command, str) else None
        if group is None:
            groups = ", ".join(repr(self.port.pointing_at(number)) for number in self.port.verify_bytes)
            answered = f"ask() is for {groups}; use send() for other commands" if groups else NO_READ_OUT
            raise UsageError(f"{self.name}: {command!r} has no answer; {answered}")
        return self.verify(group, timeout=timeout)

    def run_program(self, timeout: Time = "5 s") -> None:
        """Send X to start the program, and wait until RUN is low; from then on the chip accepts only live commands.

        Raises:
            UsageError: a program is running already.
            Timeout: RUN does not become low in time.
        """
        self.queue.result(self.start(self.chip.name), timeout)

    def live(self, *commands: str, timeout: Time = "5 s") -> bytes:
        """Send commands to a chip whose program is running, through PROG/LIVE (manual, s.7).

        Returns:
            The bytes of the groups read by V commands, one group after another.

        Raises:
            UsageError: the list of commands is empty, a command is not ASCII text, no program is running, or the part
                accepts no commands while its program runs.
            Timeout: the chip does not accept the commands in time.
        """
        for command in commands or ("",):
            if not isinstance(command, str) or not command or not command.isascii():
                raise UsageError(f"{self.name}: live command {command!r}; expected text such as 'R 20'")
        if not self.port.sheet.takes_live:
            raise UsageError(f"{self._part} accepts no commands while its program runs; wait until the program ends")
        if self.idle and self.port.running.level != 0 and self.port.ready.level == 1:
            raise UsageError(
                f"{self.name}: live commands need a running program, and {self.port.chip} runs none; start the "
                "program with run_program(), or use send()"
            )
        found = self.queue.result(self.interject(self.chip.name, commands), timeout)
        return b"".join(data for _, data in found or ())

    @answering("host.verify()", "; groups are 0 to 3")
    def verify(self, group: int, number: int | None = None, timeout: Time = "5 s", live: bool | None = False) -> bytes:
        """Return a verify group's bytes as sent by the chip; group 0: five digits, or two bytes in binary mode.

        Args:
            group: 0 position, 1 program, 2 status, 3 parameters (manual, Table VI).  Group 1 has 48 bytes, as in
                that table, though a program may have up to 60; `x.program` (x: the chip) has the whole program.
            number: the number of bytes to read; None: the whole group.
            live: True: read between two instructions of a running program, through PROG/LIVE (manual, s.3 V);
                None: do so only if a program is running; False: never.

        Raises:
            UsageError: the group does not exist, the number is negative, or a program is running and `live` is
                False.
            Timeout: the chip does not answer in time.
        """
        count = None if number is None else whole(number)
        which = whole(group)
        if (
            which is None
            or which not in self.port.verify_bytes
            or (number is not None and (count is None or count < 0))
        ):
            groups = list(self.port.verify_bytes)
            allowed = f"allowed groups {groups[0]} to {groups[-1]}, and 0 or more bytes" if groups else NO_READ_OUT
            raise UsageError(f"{self.name}: verify({group!r}, {number!r}); {allowed}")
        return self.queue.result(self.read_group(self.chip.name, which, count, live), timeout)

    def change_rate(self, rate: int, timeout: Time = "5 s") -> None:
        """Request a new rate on the fly (manual, s.7), while the motor slews.

        Args:
            rate: the rate parameter, a byte that is sent unchanged; valid rates of the part are 0 to 127.

        Raises:
            UsageError: `rate` is not 0 to 255, or the part does not accept a rate on the fly.
            Timeout: the chip does not accept the rate in time.
        """
        value = whole(rate)
        if value is None or not 0 <= value <= 255:
            raise UsageError(f"{self.name}: rate {rate!r}; allowed 0 to 127, and 128 to 255 to test invalid rates")
        self._needs("slewing", "accepts no rate on the fly")
        taken = "the part accepts a rate while the motor slews in an endless motion, started by H and then G"
        self._on_the_fly(self.request_rate(self.chip.name, value), timeout, taken)

    def read_position(self, timeout: Time = "5 s") -> int:
        """Return the position, 0 to 65535, read on the fly (manual, s.6) while the motor steps.

        Raises:
            UsageError: the part does not output its position on the fly.
            Timeout: the motor does not step in time.
        """
        self._needs("out_strobe", "outputs no position on the fly")
        taken = "the position is available while the motor steps; at rest, verify(0) reads it"
        return self._on_the_fly(self.request_position(self.chip.name), timeout, taken)

    def _on_the_fly(self, request: Request[T], timeout: Time, taken: str) -> T:
        """Wait for the result of an on-the-fly request, and return it.

        Raises:
            Timeout: the request is not done in time; the message ends with `taken`, an explanation.
        """
        try:
            return self.queue.result(request, timeout)
        except Timeout as error:
            raise Timeout(f"{error}\n  {taken}") from None

    @property
    def _part(self) -> str:
        """The names of the host and its selected chip, and the chip's part number, as the beginning of a message."""
        return f"{self.name}: {self.chip.name} ({self.chip.sheet.part})"

    def _needs(self, role: str, otherwise: str) -> None:
        """Refuse a call that needs a pin with the role `role` if the part has none; the error contains `otherwise`."""
        if self.chip.sheet.role(role) is None:
            raise UsageError(f"{self._part} {otherwise}: the part has no pin for this")
