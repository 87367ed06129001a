r"""A host's port on the host port of a chipset, and the strobes for its bytes.

HostRdy   ‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\___ 82 µs ___/‾‾   checked before each operation
HostSlct  ‾‾‾‾\________________________________________/‾‾‾‾‾‾‾
bus       ----<     high byte     X     low byte       >-------   a command is one byte, with HostCmd high
HostWrite ‾‾‾‾‾‾‾‾‾‾‾‾‾\_____/‾‾‾‾‾‾‾\_____/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾   HostRead likewise; the chipset drives the bus
           settle set-up low   gap    low     hold
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

from ....core.datasheet.command_rows import PacketRow
from ....core.wires.net import Driver, Net
from ....core.wires.waits import level, until
from ....errors import ChecksumError, Timeout
from ....language import packets
from ....language.dialect import spoken_as
from ...base.operation import HostLines, Operation, Strobed, Strobes

if TYPE_CHECKING:
    from ....core.datasheet.table import Sheet
    from ...base.request_queue import RequestQueue
    from ..connection import Connection

UNKNOWN = 0  # the current axis, after a packet that may have changed it


USUAL = Strobes()


class Packet(NamedTuple):
    """A packet: `code` and `words` are written, `reads` words are read, then, if `checked`, the checksum."""

    code: int
    words: tuple[int, ...] = ()
    reads: int = 0
    checked: bool = True

    def spelled(self, sheet: Sheet) -> str:
        """Return the packet as text: name, then code and words in hexadecimal, such as SET_POS (10 0000 3039)."""
        row = sheet.commands.by_code.get(self.code)
        sent = " ".join([f"{self.code:02x}", *(f"{word:04x}" for word in self.words)])
        return f"packet {sent}" if row is None else f"{row.name} ({sent})"

    def mismatch(self, sheet: Sheet, chip: str, found: Sequence[int], checksum: int) -> str:
        """Return an error message if the checksum that a chip sent after the words `found` is wrong, else ""."""
        expected = packets.checksum(self.code, (*self.words, *found))
        if checksum == expected:
            return ""
        why = "0 is the answer to an illegal command" if checksum == 0 else "a byte was garbled; send the packet again"
        returned = f" returned {' '.join(f'{word:04x}' for word in found)}," if found else ""
        return f"{self.spelled(sheet)} to {chip}:{returned} checksum {checksum:04x}, expected {expected:04x}; {why}"


class PacketPort:
    """A host's port on one chipset, which drives the pins of the chipset's host port.

    It also keeps the number of the axis that is current as far as the host knows.

    Args:
        chip: the connection to the chipset.
        queue: the host's request queue; the port is used within its requests.
        received: receives the words read; all ports of the host share it.
        finding: a function that reports a finding, given its code and its text.
        delay_ps: the time that the host's program takes before each operation, ps.

    Attributes:
        sparse: whether `until_status` omits the queries before the next event, because their answers would
            all be the same.
    """

    def __init__(
        self,
        chip: Connection,
        queue: RequestQueue,
        received: list[int],
        finding: Callable[[str, str], object],
        delay_ps: int,
    ) -> None:
        host, self.kernel, self.chip, self.delay_ps = queue.name, queue.kernel, chip.name, delay_ps
        self.queue, self.received, self.finding = queue, received, finding
        self.sheet, self.rows = chip.sheet, chip.sheet.rows(PacketRow).by_code
        self.crystal_hz = chip.crystal_hz  # clock of the board, the base for rates per second and for cycles
        self.pins = pins = chip.pins
        self.select, self.reading, self.writing, self.command = (
            Driver(pins[name].net, host) for name in ("hostslct", "hostread", "hostwrite", "hostcmd")
        )
        self.bus, self.host_ready = Driver(chip.bus, host), pins["hostrdy"].net
        self.operation = Operation(HostLines(self.select, self.command, self.writing, self.reading, self.bus))
        self.cycle_ps = chip.clock.ps(chip.sheet.times["cycle"].ticks)
        self.worked_ps = 0  # by then the cycle of the last update has begun
        self.sparse = False
        self.axis = 1
        self.pending: dict[str, None] = {}  # commands that wait for an update
        pins["reset"].net.watch(self._restarts)
        pins["hostintrpt"].net.watch(lambda net: self._restarts(net) if net.level is None else None)
        self.rest()

    def _restarts(self, _net: Net | None = None) -> None:
        """Record a restart of the chipset: axis 1 is current, and no command waits for an update.

        The chipset restarts when RESET changes, on a reset command, and when its supply is switched off, which
        the host recognises because an output of the chipset then floats.
        """
        self.axis = 1
        self.pending.clear()

    def rest(self) -> None:
        """Deselect the chipset, and release the bus."""
        for driver in (self.select, self.reading, self.writing):
            driver.drive(1)
        self.command.drive(0)
        self.bus.drive(None)

    async def ready(self) -> None:
        """Wait until HostRdy is high."""
        await level(self.host_ready, 1)

    async def write(self, data: bytes, command: bool, how: Strobes) -> None:
        """Write a command byte (if `command`) or the bytes of a word, as one operation with the strobe times `how`."""
        if how.ready and self.host_ready.level != 1:
            await level(self.host_ready, 1)
        if self.delay_ps:
            await until(self.kernel, self.kernel.now + self.delay_ps)
        strobed = Strobed(self.kernel.now, len(data), how)
        if how == USUAL and self.operation.begin(strobed, data, command):
            await self.operation.take_place()
            return
        self.operation.promise(strobed, data, command)
        await until(self.kernel, strobed.end)

    async def read(self, number: int, how: Strobes) -> bytes:
        """Read and return `number` bytes as one operation, each byte at the end of its strobe."""
        if how.ready and self.host_ready.level != 1:
            await level(self.host_ready, 1)
        if self.delay_ps:
            await until(self.kernel, self.kernel.now + self.delay_ps)
        strobed = Strobed(self.kernel.now, number, how)
        if how == USUAL and self.operation.begin(strobed, None):
            return await self.operation.take_place()
        self.operation.promise(strobed, None)
        data = bytearray()
        for rise in strobed.rises:
            await until(self.kernel, rise)
            data.append(self.bus.net.byte)  # type: ignore[attr-defined]
        await until(self.kernel, strobed.end)
        return bytes(data)

    def note_update(self, code: int) -> None:
        """Record the instant at which an accepted update takes effect, or that a buffered command awaits an update."""
        if updates(self.sheet, code):
            self.worked_ps = self.kernel.now + self.cycle_ps
            self.pending.clear()
        elif (row := self.rows.get(code)) is not None and row.buffered:
            self.pending[row.name] = None

    def note_axis(self, code: int, found: Sequence[int] = ()) -> None:
        """Record which axis is current after a packet, given the packet's code and the words read."""
        row = self.rows.get(code)
        if row is None:
            return
        if row.name == RESET:
            self._restarts()
        elif row.acts == "set":
            self.axis = row.code  # SET_2 has the code 2
        elif row.name == "SET_I":
            status = spoken_as(self.sheet, packets.Packets).status
            self.axis = packets.fields(found[0], status)["axis"] if found else UNKNOWN

    # ----------------------------------------------------------------------------------------------- in the host's task
    async def begin(self, how: Strobes) -> None:
        """Wait for HostRdy high if `how.ready`; mark the request as begun, so that `drop` does not interrupt it."""
        if how.ready:
            await self.ready()
        self.queue.begun = True

    async def exchange(self, packet: Packet, axis: int = UNKNOWN) -> tuple[int, ...]:
        """Make `axis` current unless it is UNKNOWN, send a packet, and return the words read, without the checksum.

        The caller is a task of the host: nothing is queued.

        Raises:
            ChecksumError: the checksum is wrong.
        """
        if axis not in (UNKNOWN, self.axis):
            await self.exchange(packet_of(packets.row(self.sheet, f"SET_{axis}")))
        ready = self.host_ready
        if ready.level != 1:
            await level(ready, 1)
        self.queue.begun = True
        await self.write(bytes([packet.code]), True, USUAL)
        for word in packet.words:
            await self.write(word.to_bytes(2, "big"), False, USUAL)
        words, checksum = [], None
        for _ in range(packet.reads):
            words.append(int.from_bytes(await self.read(2, USUAL), "big"))
            self.received.append(words[-1])
        found = tuple(words)
        self.note_axis(packet.code, found)
        if packet.checked:
            checksum = int.from_bytes(await self.read(2, USUAL), "big")
            self.received.append(checksum)
        if ready.level != 1:
            await level(ready, 1)
        self.note_update(packet.code)
        if checksum is not None:
            self._check(packet, found, checksum)
        return found

    def _check(self, packet: Packet, found: tuple[int, ...], checksum: int) -> None:
        wrong = packet.mismatch(self.sheet, self.chip, found, checksum)
        if wrong:
            self.axis = UNKNOWN
            self.finding("checksum", wrong)
            raise ChecksumError(f"{self.queue.name}: {wrong}")

    async def take(self, number: int, how: Strobes) -> bytes:
        """Read and return bytes, in the host's task; if there are two, also add them to `received`, as one word."""
        data = await self.read(number, how)
        if number == 2:
            self.received.append(int.from_bytes(data, "big"))
        return data

    async def until_status(
        self,
        bit: str,
        every_ps: int,
        axis: int = UNKNOWN,
        never: Callable[[], bool] = lambda: False,
    ) -> int:
        """Poll the status word until a bit is 1, or, if `bit` begins with "!", 0; return the status word.

        An axis is in motion only after the cycle in which its update takes effect, so !in_motion is polled only
        after that cycle.  `every_ps` is the pause between two polls.

        Raises:
            Timeout: `never`, which is called after each poll, returned True twice in a row, so the level can no
                longer occur.
        """
        field, wanted = packets.status_bit(self.sheet, bit.removeprefix("!")), not bit.startswith("!")
        question = packet_of(packets.row(self.sheet, "GET_STATUS"))
        if field.name == "in_motion" and not wanted:
            await until(self.kernel, self.worked_ps)
        hopeless = False
        while True:
            began_ps, due_ps = self.kernel.now, self.kernel.next_time()
            (word,) = await self.exchange(question, axis)
            if field.of(word) == wanted:
                return word
            before, hopeless = hopeless, never()
            if before and hopeless:
                raise Timeout(f"{self.queue.name}: {bit} of {self.chip} can no longer become true")
            omitted_ps = self._omitted(due_ps, self.kernel.now - began_ps + every_ps) if self.sparse else 0
            await until(self.kernel, self.kernel.now + omitted_ps + every_ps)

    def _omitted(self, due_ps: int | None, period_ps: int) -> int:
        """Return the time (ps) for which polling may pause: the whole periods that end before the next event.

        Args:
            due_ps: the instant of the next event, as known when the last query began; None: no event was due.
                The event may have occurred during that query.
            period_ps: the time from the start of one query to the start of the next.
        """
        horizon_ps = self.kernel.horizon
        end_ps = horizon_ps if due_ps is None else min(due_ps, horizon_ps)
        return max((end_ps - self.kernel.now - 1) // period_ps, 0) * period_ps


# ------------------------------------------------------------------------------------------------- commands as packets
RESET = "RESET"  # the packet without a checksum to read
UPDATES = ("UPDATE", "MULTI_UPDATE")


def packet_of(row: PacketRow, values: Sequence[int] = ()) -> Packet:
    """Return the packet for a command, given by its row in the data sheet and the values of its arguments."""
    return Packet(row.code, packets.words(row, values), packets.counted(row.reads), row.name != RESET)


def updates(sheet: Sheet, code: int) -> bool:
    """Return whether `code` is the code of an update command; such a command takes effect in the next cycle."""
    row = sheet.commands.by_code.get(code)
    return row is not None and row.name in UPDATES


def operations(data: bytes) -> Iterator[tuple[bytes, bool]]:
    """Yield the write operations for a packet, each as a pair: its bytes, and whether they are a command.

    The first byte is the command; words of two bytes follow.
    """
    yield data[:1], True
    for at in range(1, len(data), 2):
        yield data[at : at + 2], False
