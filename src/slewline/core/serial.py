"""Asynchronous characters on a wire: a start bit, data bits (lowest first), parity, stop bits.

    mark   ‾‾‾‾\\_____/  d0 |  d1 | ... |  dn | parity | stop ‾‾‾‾‾
    space      start  ^     ^           ^      ^         ^
                      a receiver looks in the middle of each bit, on a clock of sixteen times the baud rate

A wire rests at *mark*: 1 on a TTL line, 0 on an RS-232 line, whose mark is the negative voltage.

Both directions cost the kernel an instant or two a character, however many bits it has: a sender promises all its edges
at once, and a receiver asks the promise afterwards what the line was in the middle of each bit.  `sampled` is exact all
the same: before anything replaces a promise, the looks that lie behind us are taken from the old one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from ..errors import UsageError
from .net import Driver, Net, Wave
from .timebase import Clock
from .waits import level, until

OVERSAMPLING = 16
PARITIES = ("none", "odd", "even")
TTL, RS232 = 1, 0  # the level of mark


@dataclass(frozen=True, slots=True)
class Word:
    """A word format: 5 to 8 data bits, parity, and 1, 1.5 or 2 stop bits."""

    bits: int
    parity: str
    stop: int | str

    def checked(self, owner: str) -> Word:
        """The format itself, if it is one."""
        if self.bits not in range(5, 9) or self.parity not in PARITIES or str(self.stop) not in ("1", "1.5", "2"):
            raise UsageError(
                f"{owner}: {self.bits} bits, parity {self.parity!r}, {self.stop} stop bits; "
                f"allowed 5 to 8, {' or '.join(PARITIES)}, and 1, '1.5' or 2"
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
        """The bit that makes the number of ones odd or even."""
        return (byte.bit_count() + (self.parity == "odd")) % 2

    def levels(self, byte: int) -> list[int]:
        """Start bit, data bits, parity: 1 is mark."""
        data = [byte >> n & 1 for n in range(self.bits)]
        return [0, *data] + ([] if self.parity == "none" else [self.parity_bit(byte & (1 << self.bits) - 1)])

    def __str__(self) -> str:
        return f"{self.bits}{self.parity[0].upper()}{self.stop}"


def bit_clock(baud: int | str | Fraction, owner: str) -> Clock:
    """The clock of sixteen times a baud rate.

    Raises:
        UsageError: for a rate of which sixteen times is not whole hertz.
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


async def transmit(
    driver: Driver, clock: Clock, word: Word, byte: int, mark: int, *, wrong_parity: bool = False, no_stop: bool = False
) -> None:
    """Send one character from this instant on; returns at the end of its stop bits.

    Args:
        wrong_parity: send the other parity bit.
        no_stop: send space where the first stop bit belongs.
    """
    kernel = driver.kernel
    start, bits = kernel.now, word.levels(byte)
    if wrong_parity and word.parity != "none":
        bits[-1] ^= 1
    bits.append(0 if no_stop else 1)
    if no_stop:
        bits.append(1)
    times = tuple(start + clock.ps(OVERSAMPLING * n) for n in range(len(bits)))
    driver.play(Wave(mark, times, tuple(mark if bit else 1 - mark for bit in bits)))
    await until(kernel, start + clock.ps(word.ticks))


async def sampled(net: Net, times: Sequence[int]) -> list[int]:
    """The levels that looks at some instants see, each the one from before its instant; returns at the last of them.

    Args:
        times: ascending instants to come, ps.
    """
    kernel = net.kernel
    found: list[int] = []

    def catch_up() -> None:
        while len(found) < len(times) and times[len(found)] <= kernel.now:
            found.append(net.resolve(times[len(found)] - 1))

    net.sample(catch_up)
    try:
        await until(kernel, times[-1])
        catch_up()
    finally:
        net.unsample(catch_up)
    return found


class Receiver:
    """The receiving half of a UART; `receiving` is true within a character.  Rate and format may change between two."""

    def __init__(self, net: Net, clock: Clock, word: Word, mark: int) -> None:
        self.net, self.clock, self.word, self.mark = net, clock, word, mark
        self.receiving = False
        self.broken = False  # the last character had no stop bit: the line must come to rest first

    async def character(self) -> Character:
        """Wait for a character; returns in the middle of its first stop bit."""
        net, mark = self.net, self.mark
        if self.broken:
            await level(net, mark)
        while True:
            self.receiving = False
            await level(net, 1 - mark)
            self.receiving = True
            start, clock, word = net.kernel.now, self.clock, self.word
            middle = clock.ticks_until(start) + 1 + OVERSAMPLING // 2  # the edge is seen at the next clock
            if (await sampled(net, [clock.ps(middle)]))[0] == 1 - mark:
                break  # else it was a spike, no start bit
        looks = word.bits + (word.parity != "none") + 1
        levels = await sampled(net, [clock.ps(middle + OVERSAMPLING * n) for n in range(1, looks + 1)])
        *bits, stop = [int(seen == mark) for seen in levels]
        byte = sum(bit << n for n, bit in enumerate(bits[: word.bits]))
        wrong = word.parity != "none" and bits[-1] != word.parity_bit(byte)
        self.receiving, self.broken = False, not stop
        return Character(byte, wrong, not stop, start, start + clock.ps(word.ticks))
