"""The host computer of a chipset that uses packets: a command byte, words in either direction, a checksum.

    host.command("SET_POS", 12345)          10  0000 3039  -> checksum 3049, which is checked
    host.query("GET_STATUS")                31             -> 0300, checksum 0331
    host.ask("GET_STATUS")                  the same, with the command as text

A packet ends when HostRdy is high again after its last word.  The host remembers the current axis, so
that axis(2) sends SET_2 only if another axis is current.  A wrong checksum is always a finding of the
host; a call that waits for the packet also raises an error.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from ...core.datasheet.command_rows import PacketRow
from ...core.messages.calls import answering
from ...core.messages.instead import face, missing
from ...core.messages.whole import whole
from ...core.time.inputs import from_outside
from ...core.time.timebase import Time, picoseconds
from ...core.wires.pin import Condition, GotCondition
from ...errors import Timeout, UsageError
from ...language import packets
from ...language.source import host_lines
from ..base.operation import GAP_PS, LOW_PS, Strobes
from ..base.part import served
from ..base.written_data import Data, as_bytes
from .ends.packet_port import UNKNOWN, USUAL, Packet, PacketPort, operations, packet_of
from .host import TO_ONE, Host

if TYPE_CHECKING:
    from ...core.datasheet.table import Sheet
    from ...core.time.kernel import Kernel
    from ..base.request_queue import Request
    from .connection import Connection

POLL = "1 ms"  # polling interval of a host that waits for a status bit
LONGEST_READ = 1 << 10  # bytes of one operation; a packet has fewer than ten


class Result(NamedTuple):
    """The result of a script command: the axis, the command, and the value that the command returned."""

    axis: int
    command: str
    value: int


class PacketHost(Host):
    """A host computer on the host port of one chipset, or of several chipsets that share a data bus.

    Attributes:
        received: all words read, a list of ints, 0 to 65535.
        results: the results of a script's commands, each with axis, command and value.
    """

    _for_users: ClassVar[tuple[str, ...]] = (
        "command",
        "query",
        "axis",
        "wait",
        "packet",
        "results",
        "write_command",
        "write_word",
        "write_byte",
        "read_word",
        "read_byte",
    )

    def __init__(self, kernel: Kernel, name: str, chips: Sequence[Connection], delay_ps: int = 0) -> None:
        super().__init__(kernel, name, chips)
        self.received: list[int] = []
        self.ports = {chip.name: PacketPort(chip, self.queue, self.received, self.finding, delay_ps) for chip in chips}
        for chip in chips:
            _report_missing(chip.sheet)
        self.results: list[Result] = []
        self.keep_recent(self.received)
        self.keep_recent(self.results)

    @property
    def port(self) -> PacketPort:
        """Host port of the selected chipset."""
        return self.ports[self.chip.name]

    def got(self, data: Data) -> Condition:
        """Return a condition for `bench.run_until`: these words have been read, consecutively.

        Args:
            data: the words as numbers, 0 to 65535, or as bytes, two per word, high byte first.

        Raises:
            UsageError: the data are not words, or the number of bytes is odd.
        """
        words = list(data) if not isinstance(data, (str, bytes, bytearray, int)) else None
        if isinstance(data, (bytes, bytearray)) and len(data) % 2 == 0:
            words = [int.from_bytes(data[at : at + 2], "big") for at in range(0, len(data), 2)]
        if words is None:
            raise UsageError(f"{self.name}: got({data!r}); expected words, such as [0x0300], or bytes, two per word")
        return GotCondition(self.name, self.received, words)

    def axis(self, number: int) -> AxisView:
        """Return a view of this host that sends all its commands to one axis.

        Before each command this axis is made the current one, unless it already is.

        Raises:
            UsageError: the chipset does not have this axis.
        """
        self._check_axis(number)
        return AxisView(self, number)

    def _check_axis(self, number: int) -> None:
        axes = self.port.sheet.axes
        if number not in range(1, axes + 1):
            chip = f"{self.port.chip} ({self.port.sheet.part})"
            raise UsageError(f"{self.name}: axis {number!r}; allowed 1..{axes} for {chip}")

    def _rest(self) -> None:
        """Release the lines to every chipset."""
        for port in self.ports.values():
            port.rest()

    # ------------------------------------------------------------------------------------------------------ packets
    def command(self, name: str, *values: int | str, axis: int = UNKNOWN, timeout: Time = "5 s") -> int | None:
        """Send a command and check the checksum; return the command's value, or None if it returns no value.

        Args:
            name: the mnemonic.
            values: the arguments, in the units of the command; a rate may also be text, such as "12345 steps/s"
                or "0.5 steps/cycle2".
            axis: the axis to select before the command is sent, unless it is current; 0: leave the selection unchanged.
            timeout: the longest wait, in virtual time.

        Raises:
            UsageError: the command or axis does not exist, or the arguments do not match the command.
            ChecksumError: the checksum is wrong, or the chipset does not know the command.
            Timeout: HostRdy stays low.
        """
        port = self.port
        row = packets.row(port.sheet, name)
        numbers = packets.numbers(port.sheet, row, values, port.crystal_hz)
        found = self.queue.result(self._queue(packet_of(row, numbers), axis), timeout)
        return packets.values(row.reads, found)[0] if row.reads and found is not None else None

    def query(self, name: str, axis: int = UNKNOWN, timeout: Time = "5 s") -> int:
        """Send a command and return its value, in the units of the command.

        Raises:
            UsageError: the command does not exist, or returns nothing.
            ChecksumError, Timeout: as for `command`.
        """
        row = packets.row(self.port.sheet, name)
        if not row.reads:
            raise UsageError(f"{self.name}: {name} returns nothing, so it cannot be queried; send it with command()")
        found = self.queue.result(self._queue(packet_of(row, ()), axis), timeout)
        return packets.values(row.reads, found)[0] if found is not None else None

    @answering("host.ask()", TO_ONE)
    def ask(self, command: str, timeout: Time = "5 s", axis: int = UNKNOWN) -> int:
        """Send a command as text, in the form used in scripts, such as "GET_STATUS", and return its value.

        Raises:
            UsageError: the text is not a command, or the command returns nothing.
            ChecksumError, Timeout: as for `command`.
        """
        line = packets.command(self.port.sheet, command, self.port.crystal_hz)
        if not line.row.reads:
            raise UsageError(f"{self.name}: {command} returns nothing; send it with command() or send()")
        found = self.queue.result(self._queue(packet_of(line.row, line.values), axis), timeout)
        return packets.values(line.row.reads, found)[0] if found is not None else None

    def packet(
        self, code: int, *words: int, reads: int = 0, checksum: bool = True, axis: int = UNKNOWN, timeout: Time = "5 s"
    ) -> tuple[int, ...]:
        """Send any packet: write a command byte and words; then read words, and return the words read.

        Args:
            code: the command byte, 0 to 255.
            words: the words that are written, each 0 to 65535.
            reads: the number of words to read, without the checksum.
            checksum: whether to read and check a checksum at the end.
            axis, timeout: as for `command`.

        Raises:
            UsageError: a number is out of range.
            ChecksumError, Timeout: as for `command`.
        """
        return self.queue.result(self._queue(Packet(code, words, reads, checksum), axis), timeout)

    def send(self, data: str | bytes, axis: int = UNKNOWN) -> None:
        """Queue commands given as text, one per line; or one packet given as bytes: command byte, then words.

        Raises:
            UsageError: a line of the text is not a command; in this case nothing is queued.
        """
        if isinstance(data, str):
            for command in [
                packets.command(self.port.sheet, line, self.port.crystal_hz) for _, _, line in host_lines(data)
            ]:
                self._queue(packet_of(command.row, command.values), axis)
            return
        for part, is_command in operations(as_bytes(self.name, data)):
            self.strobe(self.port.chip, part, is_command, *USUAL)

    def wait(self, bit: str, timeout: Time = "60 s", every: Time = POLL, axis: int = UNKNOWN) -> int:
        """Poll the status word until a bit is 1 (or 0, if `bit` begins with "!"); return the status word.

        Args:
            bit: "motion_complete", "!in_motion" ...; after an update, "!in_motion" first waits for the cycle in
                which the update takes effect.
            timeout: the longest wait, in virtual time.
            every: the pause between two polls.
            axis: as for `command`.

        Raises:
            UsageError: the status word does not have this bit.
            ChecksumError: as for `command`.
            Timeout: the bit does not change in time; the message names any commands that wait for an update.
        """
        packets.status_bit(self.port.sheet, bit.removeprefix("!"))
        try:
            return self.queue.result(self.poll(self.port.chip, axis, bit, picoseconds(every)), timeout)
        except Timeout as error:
            if not (pending := ", ".join(self.port.pending)):
                raise
            raise Timeout(f"{error}\n  no-update: {pending} without an update: send UPDATE") from None

    def _queue(self, packet: Packet, axis: int) -> Request[tuple[int, ...]]:
        return self.perform(self.port.chip, axis, *packet)

    # ---------------------------------------------------------------------------------------------- single operations
    def write_command(self, byte: int, timeout: Time = "5 s", **how: Any) -> None:
        """Write a single command byte; return at the end of the write operation, before the chipset's busy time.

        Args:
            how: `low` is the duration of the strobe, and `gap` the pause between two strobes; with `ready=False`
                the byte is written without waiting for HostRdy.

        Raises:
            UsageError: the byte is not 0 to 255, or a strobe or pause is 0.
            Timeout: HostRdy stays low.
        """
        self._write(self._bytes(byte, 1), True, timeout, how)

    def write_byte(self, byte: int, timeout: Time = "5 s", **how: Any) -> None:
        """Write one byte of a data word (high byte first); other arguments and errors as for `write_command`."""
        self._write(self._bytes(byte, 1), False, timeout, how)

    def write_word(self, word: int, timeout: Time = "5 s", **how: Any) -> None:
        """Write a data word, 0 to 65535; other arguments and errors as for `write_command`."""
        self._write(self._bytes(word, 2), False, timeout, how)

    def read_byte(self, timeout: Time = "5 s", **how: Any) -> int:
        """Read and return one byte of a data word (high byte first); `how` and errors as for `write_command`."""
        return self._read(1, timeout, how)

    def read_word(self, timeout: Time = "5 s", **how: Any) -> int:
        """Read and return a data word, 0 to 65535; `how` and errors as for `write_command`."""
        return self._read(2, timeout, how)

    def _write(self, data: bytes, command: bool, timeout: Time, how: dict[str, Any]) -> None:
        self.queue.result(self.strobe(self.port.chip, data, command, *self._how(**how)), timeout)

    def _read(self, number: int, timeout: Time, how: dict[str, Any]) -> int:
        data = self.queue.result(self.sample(self.port.chip, number, *self._how(**how)), timeout)
        return int.from_bytes(data or b"", "big")

    def _how(self, low: Time = LOW_PS, gap: Time = GAP_PS, ready: bool = True) -> Strobes:
        how = Strobes(picoseconds(low), picoseconds(gap), ready)
        if not (how.low_ps and how.gap_ps):
            raise UsageError(f"{self.name}: low={low!r}, gap={gap!r}; allowed more than 0")
        return how

    def _bytes(self, number: int, size: int) -> bytes:
        value = whole(number)
        if value is None or not 0 <= value < 1 << 8 * size:
            raise UsageError(f"{self.name}: {('byte', 'word')[size - 1]} {number!r}; allowed 0..{(1 << 8 * size) - 1}")
        return value.to_bytes(size, "big")

    # ------------------------------------------------------------------------ the queue, which is what a journal keeps
    @from_outside
    def perform(
        self, chip: str, axis: int, code: int, words: Sequence[int], reads: int, checked: bool
    ) -> Request[tuple[int, ...]]:
        """Queue a packet for a chipset; the request's result is the words read, without the checksum."""
        port, packet = served(self.name, self.ports, chip), Packet(code, tuple(words), reads, checked)
        for number, size in ((code, 1), *((word, 2) for word in words)):
            self._bytes(number, size)
        if axis != UNKNOWN:
            self._check_axis(axis)
        self.input("perform", chip, axis, code, list(words), reads, checked)
        return self.queue.submit(f"sending {packet.spelled(port.sheet)} to {chip}", lambda: port.exchange(packet, axis))

    @from_outside
    def strobe(
        self, chip: str, data: Sequence[int], command: bool, low_ps: int, gap_ps: int, ready: bool
    ) -> Request[None]:
        """Queue a write operation on a chipset: a command byte (`command`) or data, with the given strobe times."""
        port, data = served(self.name, self.ports, chip), as_bytes(self.name, data)
        self.input("strobe", chip, data, command, low_ps, gap_ps, ready)

        async def action() -> None:
            await port.begin(Strobes(low_ps, gap_ps, ready))
            await port.write(data, command, Strobes(low_ps, gap_ps, ready))
            if command and ready:
                port.note_axis(data[0])
            elif command:
                port.axis = UNKNOWN

        return self.queue.submit(f"sending {data.hex()} to {chip}", action)

    @from_outside
    def sample(self, chip: str, number: int, low_ps: int, gap_ps: int, ready: bool) -> Request[bytes]:
        """Queue a read of `number` bytes from a chipset, as one operation with the given strobe times."""
        port = served(self.name, self.ports, chip)
        if whole(number) is None or not 0 < number <= LONGEST_READ:
            raise UsageError(f"{self.name}: a read of {number!r} bytes; allowed 1..{LONGEST_READ}")
        self.input("sample", chip, number, low_ps, gap_ps, ready)
        strobes = Strobes(low_ps, gap_ps, ready)
        return self.queue.submit(f"reading a word from {chip}", lambda: port.take(number, strobes))

    @from_outside
    def poll(self, chip: str, axis: int, bit: str, every_ps: int) -> Request[int]:
        """Queue a poll of an axis's status word until `bit` (as for `wait`) is true; the result is the word."""
        port = served(self.name, self.ports, chip)
        self.input("poll", chip, axis, bit, every_ps)
        return self.queue.submit(f"{bit} of {chip}", lambda: port.until_status(bit, every_ps, axis))


@face
class AxisView:
    """A view of a `PacketHost` whose commands are sent to one axis.

    Attributes:
        host: the host.
        number: the number of the axis, counted from 1.
    """

    _for_users: ClassVar[tuple[str, ...]] = ("command", "query", "ask", "packet", "send", "wait", "host", "number")

    def __init__(self, host: PacketHost, number: int) -> None:
        self.host, self.number = host, number
        self.name = f"{host.name}.axis({number})"

    def __repr__(self) -> str:
        return f"<{self.name}>"

    def command(self, name: str, *values: int | str, timeout: Time = "5 s") -> int | None:
        """Send a command to this axis, like `PacketHost.command`."""
        return self.host.command(name, *values, axis=self.number, timeout=timeout)

    def query(self, name: str, timeout: Time = "5 s") -> int:
        """Send a query to this axis, like `PacketHost.query`."""
        return self.host.query(name, axis=self.number, timeout=timeout)

    def ask(self, command: str, timeout: Time = "5 s") -> int:
        """Send a command as text to this axis, like `PacketHost.ask`."""
        return self.host.ask(command, timeout, axis=self.number)

    def packet(
        self, code: int, *words: int, reads: int = 0, checksum: bool = True, timeout: Time = "5 s"
    ) -> tuple[int, ...]:
        """Send any packet to this axis, like `PacketHost.packet`."""
        return self.host.packet(code, *words, reads=reads, checksum=checksum, axis=self.number, timeout=timeout)

    def send(self, data: str) -> None:
        """Queue commands to this axis, one per line, like `PacketHost.send`."""
        self.host.send(data, axis=self.number)

    def wait(self, bit: str, timeout: Time = "60 s", every: Time = POLL) -> int:
        """Poll the status word of this axis, like `PacketHost.wait`."""
        return self.host.wait(bit, timeout, every, axis=self.number)


missing(
    PacketHost,
    **dict.fromkeys(("verify", "read_position"), '{it}.query("GET_POS")'),
    **dict.fromkeys(("live", "change_rate", "run_program"), "a chipset takes commands at any time: {it}.command(...)"),
    change_line="a host port has no rate; {it}.command(...) sends",
)
missing(
    AxisView,
    **{name: f"the chip has it: x.axis(1).{name}" for name in ("position", "reaches", "steps", "registers")},
    velocity='the chip has it: x.axis(1).velocity_at("3 ms")',
    findings="errors of a host are in bench.findings",
)


@cache
def _report_missing(sheet: Sheet) -> None:
    """Register error hints for calls such as host.set_pos(), because data-sheet commands are not methods."""
    for row in sheet.rows(PacketRow):
        verb = "query" if row.reads else "command"
        values = "".join(f", {arg.name}" for arg in row.args)
        for cls in (PacketHost, AxisView):
            missing(cls, **dict.fromkeys((row.name.lower(), row.name), f'{{it}}.{verb}("{row.name}"{values})'))
