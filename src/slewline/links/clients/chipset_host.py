"""A host computer for a chipset on a TCP port: packets by name, their checksums checked.

    from slewline.links.clients.chipset_host import ChipsetHost

    with ChipsetHost("127.0.0.1", 4001) as host:
        host.command("SET_POS", 12345, axis=2)           # SET_2 goes first
        host.command("UPDATE")
        host.wait("motion_complete")
        print(host.query("GET_TRGT_POS"))

The calls are those of `bench.host(x)`, except that nothing is queued: each returns when it is done.  Times are those of
the wall clock, written as everywhere: "10 s", "500 ms".
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
    """A host on the registers of a chipset.  `received` are all words that it has read.

    Args:
        host, port: where `slewline serve` has it.
        timeout: for an answer, of the wall clock; TimeoutError if there is none.
    """

    def __init__(self, host: str, port: int, timeout: Time = "10 s") -> None:
        self.port = ChipsetPort(host, port, seconds(timeout))
        try:
            self.sheet = sheet_of(self.port.part, allow_code=False)  # a name that comes from outside
        except BaseException:
            self.port.close()
            raise
        self.received: list[int] = []
        self.updated = False  # the cycle that works the last update may not have begun

    def command(self, name: str, *values: int | str, axis: int = 0) -> int | None:
        """Send a command and check the checksum; return what the command returns, if it returns anything.

        Args:
            name: the mnemonic.
            values: what the command takes, in its own units; rates also as text, "12345 steps/s", at the usual crystal.
            axis: becomes the current axis first; 0: whichever is current.

        Raises:
            ChecksumError: the checksum does not fit, or the chipset does not know the command.
        """
        row = packets.row(self.sheet, name)
        found = self._exchange(packet_of(row, packets.numbers(self.sheet, row, values)), axis)
        return packets.values(row.reads, found)[0] if row.reads else None

    def query(self, name: str, axis: int = 0) -> int:
        """Send a command and return the number that it reads, in the units of the command.

        Raises:
            UsageError: the command returns nothing, or there is no such command.
            ChecksumError: as `command`.
        """
        if not packets.row(self.sheet, name).reads:
            raise UsageError(f"{name} returns nothing, so there is no query; send it with command()")
        return self.command(name, axis=axis)  # type: ignore[return-value]

    def ask(self, command: str, axis: int = 0) -> int:
        """Send a command as a line of a script has it, such as "GET_STATUS", and return the number that it reads.

        Raises:
            UsageError: no command, or one that returns nothing.
            ChecksumError: as `command`.
        """
        line = packets.command(self.sheet, command)
        if not line.row.reads:
            raise UsageError(f"{command} returns nothing; send it with command() or send()")
        return packets.values(line.row.reads, self._exchange(packet_of(line.row, line.values), axis))[0]

    def send(self, data: str | bytes, axis: int = 0) -> None:
        """Send packets: text is commands, one a line; bytes are a code and the bytes of its words, as they are.

        Raises:
            UsageError: text that is no command, found before anything is sent; or half a word.
            ChecksumError: as `command`; what follows it is not sent.
        """
        if isinstance(data, str):
            for command in [packets.command(self.sheet, line) for _, _, line in host_lines(data)]:
                self._exchange(packet_of(command.row, command.values), axis)
        elif len(data) % 2:
            self.port.packet(data[0], [int.from_bytes(data[at : at + 2], "big") for at in range(1, len(data), 2)], 0)
        elif data:
            raise UsageError(f"{data!r}: expected a code and whole words, two bytes each")

    def packet(self, code: int, *words: int, reads: int = 0, checksum: bool = True) -> tuple[int, ...]:
        """Send any packet: a code, and words after it; return the words that are read after those."""
        return self._exchange(Packet(code, words, reads, checksum))

    def wait(self, bit: str, timeout: Time = "60 s", every: Time = "1 ms") -> int:
        """Ask for the status word until a bit of it is 1, or, with "!" before its name, 0; return the word.

        Args:
            bit: "motion_complete", "!in_motion" ...; after an update !in_motion waits for the cycle that works it.
            every: pause between two questions.

        Raises:
            Timeout: the bit is not so in time.
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
        """Close the connection; the chipset goes on."""
        self.port.close()

    def __enter__(self) -> ChipsetHost:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def seconds(time: Time) -> float:
    """Return a time as the wall clock has it."""
    return picoseconds(time) / PS_PER_S
