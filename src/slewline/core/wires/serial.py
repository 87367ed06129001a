r"""Asynchronous characters on a wire: a start bit, data bits (lowest first), parity, stop bits.

    mark   ‾‾‾‾\_____/  d0 |  d1 | ... |  dn | parity | stop ‾‾‾‾‾
    space      start  ^     ^           ^      ^         ^
                      a receiver looks in the middle of each bit, on a clock of sixteen times the baud rate

A wire rests at *mark*: 1 on a TTL line, 0 on an RS-232 line, whose mark is the negative voltage.

Both directions cost the kernel an instant or two a character, however many bits it has: a sender promises all its edges
at once, and a receiver asks the promise afterwards what the line was in the middle of each bit.  It is exact all the
same: before anything replaces a promise, the looks in the past are taken from the old one.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple, Protocol

from ...errors import UsageError
from ..datasheet.option import Option
from ..time.kernel import Task
from ..time.timebase import Clock
from .net import Driver, Level, Net, Wave
from .pin import strapped
from .waits import level, until

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


class Character(NamedTuple):
    """A character as a receiver took it: its data bits, what was wrong, and the instants of its first and last edge."""

    byte: int
    parity_wrong: bool
    framing_wrong: bool
    start_ps: int
    end_ps: int

    @property
    def good(self) -> bool:
        """Neither parity nor framing fault."""
        return not (self.parity_wrong or self.framing_wrong)


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

    __slots__ = ("fixed", "kept", "order", "pins", "port", "taken")

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
        self.taken: int | None = None  # the rate at which the part listens; None: it has not looked

    @property
    def baud(self) -> int:
        """The rate that they ask for."""
        return self.port.bauds[strapped(self.pins, self.port.baud_pins)]

    def take(self) -> int:
        """Return the rate that they ask for, at which the part listens from now on."""
        self.taken = self.baud
        return self.taken

    @property
    def setting(self) -> LineSetting:
        """Rate and format at which the part listens."""
        port = self.port
        return LineSetting(
            self.baud if self.taken is None else self.taken, CharacterFormat(port.bits, port.parity, port.stop)
        )

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
        return bool(self.port.checksum_pin) and strapped(self.pins, [self.port.checksum_pin]) == (1,)

    @property
    def address(self) -> int:
        """The address that stands in front of the lines of the part; 0: none does."""
        if self.fixed is not None:
            return self.fixed
        return self.port.addresses[strapped(self.pins, self.order)] if self.order else 0


class FrameTable:
    """The characters of a word format at a rate, worked out once: instants of the bits, levels, what levels say."""

    __slots__ = ("_levels", "_read", "length", "mark", "times", "word")

    def __init__(self, clock: Clock, word: CharacterFormat, mark: int) -> None:
        self.word, self.mark = word, mark
        bits = word.ticks - word.stop_ticks + OVERSAMPLING  # as far as the start of the stop bit
        self.times = tuple(clock.ps(n) for n in range(0, bits, OVERSAMPLING))
        self.length = clock.ps(word.ticks)
        self._levels: dict[int, tuple[int, ...]] = {}
        self._read: dict[tuple[Level, ...], tuple[int, bool, bool]] = {}

    def levels(self, byte: int) -> tuple[int, ...]:
        """Return the levels of the wire from the start bit to the stop bit."""
        if byte not in self._levels:
            mark = self.mark
            self._levels[byte] = tuple(mark if bit else 1 - mark for bit in (*self.word.levels(byte), 1))
        return self._levels[byte]

    def read(self, seen: tuple[Level, ...]) -> tuple[int, bool, bool]:
        """Return what the levels in the middle of the bits say: byte; is the parity wrong, is there no stop bit?"""
        if seen not in self._read:
            word, bits = self.word, [int(level == self.mark) for level in seen]
            byte = sum(bit << n for n, bit in enumerate(bits[1 : 1 + word.bits]))
            wrong = word.parity != "none" and bits[-2] != word.parity_bit(byte)
            self._read[seen] = byte, wrong, not bits[-1]
        return self._read[seen]


@lru_cache(maxsize=64)
def _frames(hz: int, word: CharacterFormat, mark: int) -> FrameTable:
    return FrameTable(Clock(hz), word, mark)


async def transmit(
    driver: Driver, clock: Clock, word: CharacterFormat, data: bytes, mark: int, fault: str = ""
) -> None:
    """Send characters, one after the other, from this instant on; returns at the end of the last one's stop bits.

    Args:
        fault: "parity": the other parity bit; "framing": space where the first stop bit belongs; in every character.
    """
    kernel, frames = driver.kernel, _frames(clock.hz, word, mark)
    start = kernel.now
    times: list[int] = []
    levels: list[int] = []
    for byte in data:
        times += [start + time for time in frames.times]
        levels += frames.levels(byte)
        if fault == "parity" and word.parity != "none":
            levels[-2] = 1 - levels[-2]
        elif fault == "framing":
            levels[-1] = 1 - mark
            times.append(times[-1] + frames.times[1])
            levels.append(mark)
        start += frames.length
    driver.play(Wave(mark, tuple(times), tuple(levels)))
    await until(kernel, start)


class Receiver:
    """The receiving half of a UART; `receiving` is true within a character.

    Rate and format may change between two characters; so may the net, when wiring makes it one with another.
    """

    def __init__(self, net: Net, clock: Clock, word: CharacterFormat, mark: int) -> None:
        self.net, self.clock, self.word, self.mark = net, clock, word, mark
        self.receiving = False
        self.broken = False  # the last character had no stop bit: the line must come to rest first
        self.looks: list[int] = []  # instants of the looks of this character
        self.seen: list[int] = []  # what those in the past saw
        self.taken = 0  # how many
        self.task: Task | None = None
        net.sample(self.before_change)

    def close(self) -> None:
        """Stop receiving."""
        self.net.unwatch_before(self.before_change)

    def before_change(self) -> None:
        """Sample the middle of a start bit that the coming change of the wire would cut short."""
        self.catch_up()
        kernel, task = self.net.kernel, self.task
        if self.receiving and not self.taken and task is not None:
            kernel.wake_at(self.looks[0], task)

    def catch_up(self) -> None:
        """Take the samples due up to now, each with the level just before its instant."""
        looks, now = self.looks, self.net.kernel.now
        if self.taken < len(looks) and looks[self.taken] <= now:
            over = bisect_right(looks, now, self.taken)
            self.seen += self.net.levels_before(looks[self.taken : over])
            self.taken = over

    async def character(self) -> Character:
        """Wait for a character and return it, in the middle of its first stop bit."""
        mark, kernel = self.mark, self.net.kernel
        if self.broken:
            await level(self.net, mark)
        while True:
            self.receiving = False
            await level(self.net, 1 - mark)
            self.receiving = True
            start, clock = kernel.now, self.clock
            frames = _frames(clock.hz, self.word, mark)
            middle = clock.ticks_until(start) + 1 + OVERSAMPLING // 2  # the edge is seen at the next clock
            self.seen, self.taken = [], 0
            last = middle + OVERSAMPLING * len(frames.times)
            self.looks = [tick * clock.n // clock.d for tick in range(middle, last, OVERSAMPLING)]
            self.task = kernel.current()
            promised = self.net.resolve(self.looks[0] - 1) == 1 - mark
            await until(kernel, self.looks[-1 if promised else 0])
            self.catch_up()
            if self.seen[0] == 1 - mark:
                break  # else it was a spike, no start bit
        if kernel.now < self.looks[-1]:
            await until(kernel, self.looks[-1])
            self.catch_up()
        byte, wrong, self.broken = frames.read(tuple(self.seen))
        self.receiving = False
        return Character(byte, wrong, self.broken, start, start + frames.length)
