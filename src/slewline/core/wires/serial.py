r"""Asynchronous characters on a wire: a start bit, data bits (lowest first), parity, stop bits.

    mark   ‾‾‾‾\_____/  d0 |  d1 | ... |  dn | parity | stop ‾‾‾‾‾
    space      start  ^     ^           ^      ^         ^
                      a receiver looks in the middle of each bit, on a clock of sixteen times the baud rate

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
PARITIES = {"N": "none", "O": "odd", "E": "even"}  # by the letters of 7O2
TTL, RS232 = 1, 0  # the level of mark


@dataclass(frozen=True, slots=True)
class CharacterFormat:
    """A character format: 5 to 8 data bits, parity, and 1, 1.5 or 2 stop bits."""

    bits: int
    parity: str
    stop: int | str

    def checked(self, owner: str) -> CharacterFormat:
        """Return the format itself, checked.

        Raises:
            UsageError: bits, parity or stop bits that there are not.
        """
        if (
            self.bits not in range(5, 9)
            or self.parity not in PARITIES.values()
            or str(self.stop) not in ("1", "1.5", "2")
        ):
            raise UsageError(
                f"{owner}: {self.bits} bits, parity {self.parity!r}, {self.stop} stop bits; "
                f"allowed 5 to 8, {' or '.join(PARITIES.values())}, and 1, '1.5' or 2"
            )
        return self

    @property
    def stop_ticks(self) -> int:
        """Length of the stop bits in ticks of the clock."""
        return int(OVERSAMPLING * Fraction(str(self.stop)))

    @property
    def ticks(self) -> int:
        """Length of a character in ticks of the clock."""
        return OVERSAMPLING * (1 + self.bits + (self.parity != "none")) + self.stop_ticks

    def parity_bit(self, byte: int) -> int:
        """Return the bit, 0 or 1, that makes the number of ones odd or even."""
        return (byte.bit_count() + (self.parity == "odd")) % 2

    def levels(self, byte: int) -> list[int]:
        """Return start bit, data bits and parity bit of a byte; 1 is mark."""
        data = [byte >> n & 1 for n in range(self.bits)]
        return [0, *data] + ([] if self.parity == "none" else [self.parity_bit(byte & (1 << self.bits) - 1)])

    def __str__(self) -> str:
        return f"{self.bits}{self.parity[0].upper()}{self.stop}"


class LineSetting(NamedTuple):
    """Rate and format of one end of a line."""

    baud: int | str
    word: CharacterFormat

    def __str__(self) -> str:
        return f"{self.baud} {self.word}"

    @property
    def character_s(self) -> float:
        """Seconds that a character takes."""
        return self.word.ticks / OVERSAMPLING / float(self.baud)

    @property
    def in_full(self) -> str:
        """As the settings of a serial port name it."""
        word = self.word
        parity = "no" if word.parity == "none" else word.parity
        return f"{self.baud} baud, {word.bits} data bits, {parity} parity, {word.stop} stop bit{'s' * (word.stop != 1)}"


class ReceivingEnd(Protocol):
    """What listens at the end of a line; its settings can be read by a part that is wired to it."""

    @property
    def setting(self) -> LineSetting:
        """Rate and format at which it listens."""

    @property
    def set_by(self) -> str:
        """What has set them, in words; empty: nothing that could be changed."""

    def instead(self, baud: int | str) -> str:
        """Return what would let it listen at another rate, in words; empty: nothing."""


def disagreement(who: str, mine: LineSetting, whom: str, ear: ReceivingEnd) -> str:
    """Return in which way two ends of a line are set differently, and what to do; empty: they agree."""
    theirs = ear.setting
    if str(mine) == str(theirs):  # a stop bit may be 1 or "1"
        return ""
    by = f" ({ear.set_by})" if ear.set_by else ""
    remedy = f"set the host to {theirs.in_full}"
    if str(mine.baud) != str(theirs.baud) and (other := ear.instead(mine.baud)):
        remedy += f", or the part to {mine.baud} baud with {other}"
    return f"{who} is set to {mine}, and {whom} to {theirs}{by}: {remedy}"


def rate_disagreement(who: str, baud: int | str, whom: str, ear: ReceivingEnd) -> str:
    """Return as `disagreement` does, of an end whose rate alone is known."""
    theirs = ear.setting
    if str(baud) == str(theirs.baud):
        return ""
    by = f" ({ear.set_by})" if ear.set_by else ""
    other = ear.instead(baud)
    remedy = f"set the host to {theirs.in_full}" + (f", or the part to {baud} baud with {other}" if other else "")
    return f"{who} is set to {baud} baud, and {whom} to {theirs}{by}: {remedy}"


BAUD = Option("baud", "number", 9600, "rate of the line; sixteen times the rate must be whole hertz")


def word_options(bits: int, parity: str, stop: int | str) -> tuple[Option, ...]:
    """Return the options of a part that say how characters look, with these defaults."""
    return (
        Option("bits", "int", bits, "data bits of a character", low=5, high=8),
        Option("parity", "choice", parity, "parity of a character", choices=tuple(PARITIES.values())),
        Option("stop", "choice", stop, "stop bits of a character", choices=(1, "1.5", 2)),
    )


def bit_clock(baud: int | str | Fraction, owner: str) -> Clock:
    """Return the clock of sixteen times a baud rate.

    Raises:
        UsageError: a rate of which sixteen times is not whole hertz.
    """
    try:
        rate = OVERSAMPLING * Fraction(str(baud))
    except ValueError:
        rate = Fraction(0)
    if rate < 1 or rate.denominator != 1:
        raise UsageError(f"{owner}: baud {baud!r}; expected 9600, '37.5' ...: sixteen times the rate in whole hertz")
    return Clock(rate.numerator)


class Straps:
    """What the strap pins of a part on a serial line say at this moment; the part that has wired them may look.

    `setting` is what it has made of them: it looks at them when it is switched on.

    Args:
        port: the serial line among the channels of the part.
        pins: the pins of the part, by name.
        kept: the bits that a checksum always has.
        address: whatever the pins say; None: what they say.
        backwards: the pins of the address count the other way round.
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
        self.taken: int | None = None  # the rate at which the part listens; None: it has not looked
        self.word = CharacterFormat(port.bits, port.parity, port.stop)

    @property
    def baud(self) -> int:
        """The rate that they ask for."""
        return self.port.bauds[strapped(self.pins, self.port.baud_pins)]

    def take(self) -> int:
        """Return the rate that they ask for, at which the part listens from now on."""
        self.taken = self.baud
        return self.taken

    @property
    def rate(self) -> int:
        """Rate at which the part receives, in baud."""
        return self.baud if self.taken is None else self.taken

    @property
    def setting(self) -> LineSetting:
        """Rate and format at which the part receives."""
        return LineSetting(self.rate, self.word)

    @property
    def set_by(self) -> str:
        """The straps of this rate, in words; empty: it has no such pins."""
        return self.instead(self.setting.baud)

    def instead(self, baud: int | str) -> str:
        """Return the straps of a rate, such as "br0=0, br1=0, br2=0"; empty: no strap gives it."""
        return self.port.strapping(baud)

    @property
    def checked(self) -> bool:
        """Do they ask for checksums?"""
        return self._checksum is not None and self._checksum.level != 0

    @property
    def address(self) -> int:
        """The address that stands in front of the lines of the part; 0: none does."""
        if self.fixed is not None:
            return self.fixed
        address = self._address
        return self.port.addresses[tuple([0 if net.level == 0 else 1 for net in address])] if address else 0
