"""A host computer for a chipset on a TCP port: it sends packets by name and verifies their checksums.

    from slewline.links.clients.chipset_host import ChipsetHost

    with ChipsetHost("127.0.0.1", 4001) as host:
        host.command("SET_POS", 12345, axis=2)           # sends SET_2 first
        host.command("UPDATE")
        host.wait("motion_complete")
        print(host.query("GET_TRGT_POS"))

The methods are those of the host that `bench.host(x)` returns, except that nothing is queued: each call
returns when it is done.  Times are wall-clock times, written as on a bench: "10 s", "500 ms".
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
        ConnectionError: there is no server, the server has no chipset, or it has another host already.
        TimeoutError: there is no answer in time; every method may raise this error.
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
        """Send a command and verify the checksum; return the chipset's value, or None if it returns none.

        Args:
            name: the mnemonic.
            values: the arguments, in the units of the command; a rate may also be text, "12345 steps/s", which
                assumes the standard crystal.
            axis: the axis to select first; 0 keeps the current axis.

        Raises:
            UsageError: there is no such command, or the arguments do not fit it.
            ChecksumError: the checksum is wrong, or the chipset does not recognise the command.
        """
        row = packets.row(self.sheet, name)
        found = self._exchange(packet_of(row, packets.numbers(self.sheet, row, values)), axis)
        return packets.values(row.reads, found)[0] if row.reads else None

    def query(self, name: str, axis: int = 0) -> int:
        """Send a command without arguments, and return the value in its answer, in the units of the command.

        Raises:
            UsageError: there is no such command, or it returns nothing.
            ChecksumError: as for `command`.
        """
        if not packets.row(self.sheet, name).reads:
            raise UsageError(f"{name} returns nothing, so it cannot be queried; send it with command()")
        return self.command(name, axis=axis)  # type: ignore[return-value]

    def ask(self, command: str, axis: int = 0) -> int:
        """Send a command written as in a script ("GET_STATUS"), and return the value in its answer.

        Raises:
            UsageError: the text is not a command, or the command returns nothing.
            ChecksumError: as for `command`.
        """
        line = packets.command(self.sheet, command)
        if not line.row.reads:
            raise UsageError(f"{command} returns nothing; send it with command() or send()")
        return packets.values(line.row.reads, self._exchange(packet_of(line.row, line.values), axis))[0]

    def send(self, data: str | bytes, axis: int = 0) -> None:
        """Send the commands of a text, one per line, or a packet as bytes: a command byte, and two bytes per word.

        `axis`, if not 0, is selected before each command of a text.  For bytes, no axis is selected and no
        checksum is read.

        Raises:
            UsageError: a line of the text is not a command, or the bytes end within a word; nothing is sent.
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
        """Send any packet, a command byte and words; return the words read in reply, without the checksum.

        Args:
            code: the command byte, 0 to 255.
            words: the words to write, each 0 to 65535.
            reads: the number of words to read, not counting the checksum.
            checksum: True: a checksum is read after these words, and verified.

        Raises:
            ChecksumError: as for `command`.
        """
        return self._exchange(Packet(code, words, reads, checksum))

    def wait(self, bit: str, timeout: Time = "60 s", every: Time = "1 ms") -> int:
        """Poll the status word of the current axis until a bit is 1, or 0 for "!bit"; return the status word.

        Args:
            bit: "motion_complete", "!in_motion" ...; after an update, "!in_motion" first waits for the cycle in
                which the update takes effect.
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
    """Return a time such as "500 ms" as a number of seconds."""
    return picoseconds(time) / PS_PER_S
