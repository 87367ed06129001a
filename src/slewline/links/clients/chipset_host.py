"""A host computer for a chipset on a TCP port: it sends packets by name and verifies their checksums.

    from slewline.links.clients.chipset_host import ChipsetHost

    with ChipsetHost("127.0.0.1", 4001) as host:
        host.command("SET_POS", 12345, axis=2)           # SET_2 goes first
        host.command("UPDATE")
        host.wait("motion_complete")
        print(host.query("GET_TRGT_POS"))

The calls are those of `bench.host(x)`, except that nothing is queued: each call returns when it is done.  Times are
wall-clock times, written as everywhere else: "10 s", "500 ms".
"""

from __future__ import annotations

from time import monotonic, sleep

from ...chips import sheet_of
from ...core.time.timebase import PS_PER_S, Time, picoseconds
from ...errors import ChecksumError, Timeout, UsageError
from ...language import packets
from ...language.source import host_lines
from ...parts.hosts.ends.packet_port import Packet, packet_of, updates
from .chipset_port import ChipsetPort


class ChipsetHost:
    """A host that commands a chipset through the registers that `slewline serve` offers over TCP.

    Args:
        host, port: the address on which `slewline serve` listens.
        timeout: the longest wait for an answer, by the wall clock.

    Attributes:
        received: all words read, a list of ints, 0 to 65535.

    Raises:
        ConnectionError: there is no server, it serves no chipset, or another host is connected.
        TimeoutError: no answer; every call may raise it.
    """

    def __init__(self, host: str, port: int, timeout: Time = "10 s") -> None:
        self.port = ChipsetPort(host, port, seconds(timeout))
        try:
            self.sheet = sheet_of(self.port.part, allow_code=False)  # an untrusted name
        except BaseException:
            self.port.close()
            raise
        self.received: list[int] = []
        self.updated = False  # the cycle of the last update may not have begun

    def command(self, name: str, *values: int | str, axis: int = 0) -> int | None:
        """Send a command and verify the checksum; return the command's value, or None if it returns no value.

        Args:
            name: the mnemonic.
            values: the arguments, in the units of the command; a rate may also be text, "12345 steps/s", which
                assumes the standard crystal.
            axis: the axis to select first; 0 keeps the current axis.

        Raises:
            UsageError: no such command, or arguments that do not fit it.
            ChecksumError: the checksum is wrong, or the chipset does not know the command.
        """
        row = packets.row(self.sheet, name)
        found = self._exchange(packet_of(row, packets.numbers(self.sheet, row, values)), axis)
        return packets.values(row.reads, found)[0] if row.reads else None

    def query(self, name: str, axis: int = 0) -> int:
        """Send a command and return the value that it returns, in the units of the command.

        Raises:
            UsageError: no such command, or one that returns nothing.
            ChecksumError: as for `command`.
        """
        if not packets.row(self.sheet, name).reads:
            raise UsageError(f"{name} returns nothing, so it cannot be queried; send it with command()")
        return self.command(name, axis=axis)  # type: ignore[return-value]

    def ask(self, command: str, axis: int = 0) -> int:
        """Send a command as text, as written in a script ("GET_STATUS"), and return the value that it returns.

        Raises:
            UsageError: not a command, or one that returns nothing.
            ChecksumError: as for `command`.
        """
        line = packets.command(self.sheet, command)
        if not line.row.reads:
            raise UsageError(f"{command} returns nothing; send it with command() or send()")
        return packets.values(line.row.reads, self._exchange(packet_of(line.row, line.values), axis))[0]

    def send(self, data: str | bytes, axis: int = 0) -> None:
        """Send packets: text contains commands, one per line; bytes are a command byte and the bytes of its words.

        Raises:
            UsageError: the text has a line that is not a command, or the bytes end within a word; nothing is sent.
            ChecksumError: as for `command`; the remaining commands are not sent.
        """
        if isinstance(data, str):
            for command in [packets.command(self.sheet, line) for _, _, line in host_lines(data)]:
                self._exchange(packet_of(command.row, command.values), axis)
        elif len(data) % 2:
            self.port.packet(data[0], [int.from_bytes(data[at : at + 2], "big") for at in range(1, len(data), 2)], 0)
        elif data:
            raise UsageError(f"{data!r}: expected a code of one byte and words of two bytes each")

    def packet(self, code: int, *words: int, reads: int = 0, checksum: bool = True) -> tuple[int, ...]:
        """Send any packet, a command byte and words; return the words that are read afterwards.

        Args:
            code: the command byte, 0 to 255.
            words: the words to write, each 0 to 65535.
            reads: the number of words to read, not counting the checksum.
            checksum: read a checksum at the end, and verify it.

        Raises:
            ChecksumError: as for `command`.
        """
        return self._exchange(Packet(code, words, reads, checksum))

    def wait(self, bit: str, timeout: Time = "60 s", every: Time = "1 ms") -> int:
        """Poll the status word of the current axis until a bit is 1 (0 if its name begins with "!"); return the word.

        Args:
            bit: "motion_complete", "!in_motion" ...; after an update, "!in_motion" first waits for the cycle in which
                the update takes effect.
            timeout: the longest wait, by the wall clock.
            every: the pause between two polls, by the wall clock.

        Raises:
            UsageError: the status word has no such bit.
            Timeout: the bit does not change in time.
        """
        field, wanted = packets.status_bit(self.sheet, bit.removeprefix("!")), not bit.startswith("!")
        end, pause = monotonic() + seconds(timeout), seconds(every)
        if field.name == "in_motion" and not wanted and self.updated:
            begun = self.query("GET_TIME")
            while self.query("GET_TIME") == begun and monotonic() < end:
                pass
            self.updated = False
        while field.of(word := self.query("GET_STATUS")) != wanted:
            if monotonic() >= end:
                waited = f"{seconds(timeout):g} s"
                raise Timeout(f"{self.port.where}: waited {waited} for {bit}; the status word is {word:04x}")
            sleep(pause)
        return word

    def _exchange(self, packet: Packet, axis: int = 0) -> tuple[int, ...]:
        if axis:
            self._exchange(packet_of(packets.row(self.sheet, f"SET_{axis}")))
        words = self.port.packet(packet.code, packet.words, packet.reads + packet.checked)
        self.received += words
        found = words[: packet.reads]
        wrong = packet.checked and packet.mismatch(self.sheet, self.port.where, found, words[-1])
        if wrong:
            raise ChecksumError(wrong)
        self.updated |= updates(self.sheet, packet.code)
        return found

    def close(self) -> None:
        """Close the connection; the chipset keeps running."""
        self.port.close()

    def __enter__(self) -> ChipsetHost:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def seconds(time: Time) -> float:
    """Return a time in wall-clock seconds."""
    return picoseconds(time) / PS_PER_S
