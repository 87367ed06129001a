"""A host computer for a chipset on a TCP port: packets by name, their checksums checked.

    from slewline.links.chipset_host import ChipsetHost

    with ChipsetHost("127.0.0.1", 4001) as host:
        host.command("SET_POS", 12345, axis=2)           # SET_2 goes first
        host.command("UPDATE")
        host.wait("motion_complete")
        print(host.query("GET_TRGT_POS"))

The calls are those of `bench.host(x)`; the times of this host are seconds of the wall clock.
"""

from __future__ import annotations

from time import monotonic, sleep

from ..chips import sheet_of
from ..errors import ChecksumError, Timeout, UsageError
from ..language import packets
from ..parts.packet_port import Packet, packet_of, updates
from .chipset_port import ChipsetPort


class ChipsetHost:
    """A host on the registers of a chipset.

    Args:
        host, port: where `slewline serve` has it.
        timeout: seconds for an answer.
    """

    def __init__(self, host: str, port: int, timeout: float = 10.0) -> None:
        self.port = ChipsetPort(host, port, timeout)
        self.sheet = sheet_of(self.port.part)
        self.updated = False  # nobody knows yet that the cycle has begun which works the last update

    def command(self, name: str, *values: int | str, axis: int = 0) -> int | None:
        """Send a command and check the checksum; returns what the command returns, if it returns anything.

        Args:
            name: the mnemonic.
            values: what the command takes, in its own units; rates also as text, "12345 steps/s", at the usual crystal.
            axis: becomes the current axis first; 0: whichever is current.

        Raises:
            ChecksumError: the checksum does not fit, or the chipset does not know the command.
        """
        row = packets.row(self.sheet, name)
        if axis:
            self.command(f"SET_{axis}")
        found = self._exchange(packet_of(row, packets.numbers(self.sheet, row, values)))
        return packets.values(row.reads, found)[0] if row.reads else None

    def query(self, name: str, axis: int = 0) -> int:
        """Send a command that reads something and return the number, in the command's own units.

        Raises:
            UsageError: an unknown command, or one that reads nothing.
        """
        if not packets.row(self.sheet, name).reads:
            raise UsageError(f"{name} returns nothing, so there is no query; send it with command()")
        return self.command(name, axis=axis)  # type: ignore[return-value]

    def packet(self, code: int, *words: int, reads: int = 0, checksum: bool = True) -> tuple[int, ...]:
        """Send any packet: a code, and words behind it; returns the words that are read behind those."""
        return self._exchange(Packet(code, words, reads, checksum))

    def wait(self, bit: str, timeout: float = 60.0, every: float = 0.001) -> int:
        """Ask for the status word until a bit of it is 1, or, with "!" before its name, 0; returns the word.

        Args:
            bit: "motion_complete", "!in_motion" ...; behind an update !in_motion waits for the cycle that works it.
            every: pause between two questions.
        """
        field, wanted = packets.status_bit(self.sheet, bit.removeprefix("!")), not bit.startswith("!")
        end = monotonic() + timeout
        if field.name == "in_motion" and not wanted and self.updated:
            begun = self.query("GET_TIME")
            while self.query("GET_TIME") == begun and monotonic() < end:
                pass
            self.updated = False
        while field.of(word := self.query("GET_STATUS")) != wanted:
            if monotonic() >= end:
                raise Timeout(f"{self.port.where}: waited {timeout:g} s for {bit}; the status is {word:04x}")
            sleep(every)
        return word

    def _exchange(self, packet: Packet) -> tuple[int, ...]:
        words = self.port.packet(packet.code, packet.words, packet.reads + packet.checked)
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
