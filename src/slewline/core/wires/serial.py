r"""Asynchronous characters on a wire: a start bit, data bits (lowest first), parity, stop bits.

    mark   ‾‾‾‾\_____/  d0 |  d1 | ... |  dn | parity | stop ‾‾‾‾‾
    space      start  ^     ^           ^      ^         ^
                      a receiver samples the middle of each bit, on a clock of sixteen times the baud rate

A wire rests at *mark*: 1 on a TTL line, 0 on an RS-232 line, whose mark is the negative voltage.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple, Protocol

from ...errors import UsageError
from ..datasheet.option import Option
from ..time.timebase import Clock
from .pin import strapped

if TYPE_CHECKING:
    from ..datasheet.channel import SerialLine
    from .pin import Terminal

OVERSAMPLING = 16
PARITIES = {"N": "none", "O": "odd", "E": "even"}  # keyed by the letters used in 7O2
TTL, RS232 = 1, 0  # the level of mark


@dataclass(frozen=True, slots=True)
class CharacterFormat:
    """A character format: 5 to 8 data bits, parity, and 1, 1.5 or 2 stop bits."""

    bits: int
    parity: str
    stop: int | str

    def checked(self, owner: str) -> CharacterFormat:
        """Check the format, and return it.

        Raises:
            UsageError: the number of data bits, the parity, or the number of stop bits is not allowed.
        """
        if (
            self.bits not in range(5, 9)
            or self.parity not in PARITIES.values()
            or str(self.stop) not in ("1", "1.5", "2")
        ):
            raise UsageError(
                f"{owner}: {self.bits} bits, parity {self.parity!r}, {self.stop} stop bits; "
                f"allowed 5 to 8 bits, parity {' or '.join(PARITIES.values())}, and 1, '1.5' or 2 stop bits"
            )
        return self

    @property
    def stop_ticks(self) -> int:
        """The length of the stop bits in clock ticks, sixteen to the bit."""
        return int(OVERSAMPLING * float(self.stop))

    @property
    def ticks(self) -> int:
        """The length of a character in clock ticks, sixteen to the bit."""
        return OVERSAMPLING * (1 + self.bits + (self.parity != "none")) + self.stop_ticks

    def parity_bit(self, byte: int) -> int:
        """Return the parity bit for a byte: the 0 or 1 that makes the total number of ones odd or even."""
        return (byte.bit_count() + (self.parity == "odd")) % 2

    def levels(self, byte: int) -> list[int]:
        """Return the levels of the start bit, data bits and any parity bit for a byte; 1 is mark."""
        data = [byte >> n & 1 for n in range(self.bits)]
        return [0, *data] + ([] if self.parity == "none" else [self.parity_bit(byte & (1 << self.bits) - 1)])

    def __str__(self) -> str:
        return f"{self.bits}{self.parity[0].upper()}{self.stop}"


class LineSetting(NamedTuple):
    """The rate and format of one end of a serial line."""

    baud: int | str
    word: CharacterFormat

    def __str__(self) -> str:
        return f"{self.baud} {self.word}"

    @property
    def character_s(self) -> float:
        """The length of a character, in seconds."""
        return self.word.ticks / OVERSAMPLING / float(self.baud)

    @property
    def in_full(self) -> str:
        """The rate and format in words, such as "9600 baud, 8 data bits, no parity, 1 stop bit"."""
        word = self.word
        parity = "no" if word.parity == "none" else word.parity
        return f"{self.baud} baud, {word.bits} data bits, {parity} parity, {word.stop} stop bit{'s' * (word.stop != 1)}"


class ReceivingEnd(Protocol):
    """A receiver at the end of a serial line; a part wired to that line can read the receiver's settings."""

    @property
    def setting(self) -> LineSetting:
        """The rate and format at which this end receives."""

    @property
    def set_by(self) -> str:
        """Text that names the straps, options or other means that set the rate and format; "" if they are fixed."""

    def instead(self, baud: int | str) -> str:
        """Return text that explains how to set this end to the given rate; "" if that rate cannot be set."""


def disagreement(who: str, mine: LineSetting, whom: str, receiver: ReceivingEnd) -> str:
    """Return text on how two ends of a line differ in their settings, with a remedy; "" if they do not."""
    theirs = receiver.setting
    if str(mine) == str(theirs):  # a stop bit may be 1 or "1"
        return ""
    by = f" ({receiver.set_by})" if receiver.set_by else ""
    remedy = f"set the host to {theirs.in_full}"
    if str(mine.baud) != str(theirs.baud) and (other := receiver.instead(mine.baud)):
        remedy += f", or the part to {mine.baud} baud with {other}"
    return f"{who} is set to {mine}, and {whom} to {theirs}{by}: {remedy}"


def rate_disagreement(who: str, baud: int | str, whom: str, receiver: ReceivingEnd) -> str:
    """Return text as `disagreement` does, but compare only the rates; used if the format of `who` is not known."""
    theirs = receiver.setting
    if str(baud) == str(theirs.baud):
        return ""
    by = f" ({receiver.set_by})" if receiver.set_by else ""
    other = receiver.instead(baud)
    remedy = f"set the host to {theirs.in_full}" + (f", or the part to {baud} baud with {other}" if other else "")
    return f"{who} is set to {baud} baud, and {whom} to {theirs}{by}: {remedy}"


BAUD = Option("baud", "number", 9600, "rate of the line; sixteen times the rate must be a whole number of hertz")


def word_options(bits: int, parity: str, stop: int | str) -> tuple[Option, ...]:
    """Return the options of a part for its character format, with these values as defaults."""
    return (
        Option("bits", "int", bits, "data bits of a character", low=5, high=8),
        Option("parity", "choice", parity, "parity of a character", choices=tuple(PARITIES.values())),
        Option("stop", "choice", stop, "stop bits of a character", choices=(1, "1.5", 2)),
    )


def bit_clock(baud: int | str | Fraction, owner: str) -> Clock:
    """Return a clock that runs at sixteen times a baud rate.

    Raises:
        UsageError: sixteen times the rate is not a whole number of hertz.
    """
    try:
        rate = OVERSAMPLING * Fraction(str(baud))
    except ValueError:
        rate = Fraction(0)
    if rate < 1 or rate.denominator != 1:
        raise UsageError(
            f"{owner}: baud {baud!r}; expected a rate such as 9600 or '37.5': sixteen times the rate must be a whole "
            "number of hertz"
        )
    return Clock(rate.numerator)


class Straps:
    """The settings that strap pins select for a part's serial line; another part on that line can read them.

    `setting` is the setting in use: the part reads its straps when it is switched on.

    Args:
        port: the part's channel, which describes the line and its straps.
        pins: the part's pins, keyed by name.
        kept: the bits that are set in every checksum.
        address: a fixed address, regardless of the pins; None for the address that the pins select.
        backwards: True if the address is read from the address pins in reverse order.
    """

    __slots__ = ("_address", "_checksum", "fixed", "kept", "order", "pins", "port", "taken", "word")

    def __init__(
        self,
        port: SerialLine,
        pins: Mapping[str, Terminal],
        *,
        kept: int,
        address: int | None = None,
        backwards: bool = False,
    ) -> None:
        self.port, self.pins, self.kept, self.fixed = port, pins, kept, address
        self.order = port.address_pins[:: -1 if backwards else 1]
        self._address = [pins[name].net for name in self.order]
        self._checksum = pins[port.checksum_pin].net if port.checksum_pin else None
        self.taken: int | None = None  # the rate at which the part receives; None until it reads the straps
        self.word = CharacterFormat(port.bits, port.parity, port.stop)

    @property
    def baud(self) -> int:
        """The rate that the pins select, in baud."""
        return self.port.bauds[strapped(self.pins, self.port.baud_pins)]

    def take(self) -> int:
        """Return the rate (baud) that the pins select now; the part receives at this rate from now on."""
        self.taken = self.baud
        return self.taken

    @property
    def rate(self) -> int:
        """The rate at which the part receives, in baud."""
        return self.baud if self.taken is None else self.taken

    @property
    def setting(self) -> LineSetting:
        """The rate and format at which the part receives."""
        return LineSetting(self.rate, self.word)

    @property
    def set_by(self) -> str:
        """Text that lists the straps for the rate in use; "" if the part has no pins that select the rate."""
        return self.instead(self.setting.baud)

    def instead(self, baud: int | str) -> str:
        """Return text with the straps for a rate, such as "br0=0, br1=0, br2=0"; "" if no straps select that rate."""
        return self.port.strapping(baud)

    @property
    def checked(self) -> bool:
        """True if the pins select checksums."""
        return self._checksum is not None and self._checksum.level != 0

    @property
    def address(self) -> int:
        """The address that precedes each line of text sent to the part; 0 if the part has no address."""
        if self.fixed is not None:
            return self.fixed
        address = self._address
        return self.port.addresses[tuple([0 if net.level == 0 else 1 for net in address])] if address else 0
