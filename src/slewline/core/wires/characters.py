r"""Characters on a wire: a whole line of text is one promised waveform, whose edges are computed on request.

    mark   ‾‾‾‾\_____/  d0 |  d1 | ... |  dn | parity | stop ‾‾‾‾‾\_____/  d0 | ...
    space      start                                              the next character

A sender promises whole lines; receivers accept each line as a whole (receiver.py).
"""

from __future__ import annotations

from functools import lru_cache

from ..time.events import When
from ..time.timebase import Clock
from .net import Driver, Level, Wave
from .serial import OVERSAMPLING, CharacterFormat
from .waits import until

MAX_BITS = 8


class FrameTable:
    """The waveforms of all bytes in one character format at one rate, and the byte for each set of samples.

    Both are computed when first used, and cached.
    """

    __slots__ = ("_levels", "_read", "byte_mask", "last_sample", "length", "mark", "settled", "times", "word")

    def __init__(self, clock: Clock, word: CharacterFormat, mark: int) -> None:
        self.word, self.mark, self.byte_mask = word, mark, (1 << word.bits) - 1
        bits = word.ticks - word.stop_ticks + OVERSAMPLING  # up to the start of the stop bit
        self.times = tuple(clock.ps(n) for n in range(0, bits, OVERSAMPLING))
        self.length = clock.ps(word.ticks)
        self.settled = self.times[-1] - self.length  # from the end of a character to its last edge, ps
        self.last_sample = 1 + OVERSAMPLING // 2 + bits - OVERSAMPLING  # ticks after the tick before the start bit
        self._levels: dict[int, tuple[int, ...]] = {}
        self._read: dict[tuple[Level, ...], tuple[int, bool, bool]] = {}

    def levels(self, byte: int) -> tuple[int, ...]:
        """Return the levels of the wire for a byte, one per bit, from the start bit to the stop bit."""
        if byte not in self._levels:
            mark = self.mark
            self._levels[byte] = tuple(mark if bit else 1 - mark for bit in (*self.word.levels(byte), 1))
        return self._levels[byte]

    def read(self, seen: tuple[Level, ...]) -> tuple[int, bool, bool]:
        """Return the byte represented by levels sampled at mid-bit: (byte, parity is wrong, framing is wrong)."""
        if seen not in self._read:
            word, bits = self.word, [int(level == self.mark) for level in seen]
            byte = sum(bit << n for n, bit in enumerate(bits[1 : 1 + word.bits]))
            wrong = word.parity != "none" and bits[-2] != word.parity_bit(byte)
            self._read[seen] = byte, wrong, not bits[-1]
        return self._read[seen]


@lru_cache(maxsize=64)
def frames_of(hz: int, word: CharacterFormat, mark: int) -> FrameTable:
    """Return the frame table of a character format; `hz` is 16 times the baud rate, `mark` the level at rest."""
    return FrameTable(Clock(hz), word, mark)


class Characters:
    """A promise of consecutive characters from `start` to `end` (ps); before and after, the wire is at mark."""

    __slots__ = ("_wave", "data", "end", "frames", "last", "start")
    until: int | None = None
    floats = False

    def __init__(self, frames: FrameTable, data: bytes, start: int) -> None:
        if frames.word.bits < MAX_BITS and not (data.isascii() and frames.word.bits == MAX_BITS - 1):
            data = bytes(byte & frames.byte_mask for byte in data)
        self.frames, self.data, self.start = frames, data, start
        self.end = start + len(data) * frames.length
        self.last = self.end + frames.settled  # there may be an edge: the stop bit of the last one
        self._wave: Wave | None = None

    @property
    def wave(self) -> Wave:
        """The wave with all edges of the characters."""
        if self._wave is None:
            frames, start = self.frames, self.start
            times: list[int] = []
            levels: list[int] = []
            for byte in self.data:
                times += [start + time for time in frames.times]
                levels += frames.levels(byte)
                start += frames.length
            self._wave = Wave(frames.mark, tuple(times), tuple(levels))
        return self._wave

    def level(self, ps: int) -> Level:
        """Return the level at an instant (ps), after any edge at that instant."""
        return self.wave.level(ps) if self.start < ps < self.last else self.frames.mark ^ (ps == self.start)

    def after(self, ps: int) -> When:
        """Return the instant (ps) of the first edge strictly after the instant `ps`; None if no edge is foreseen."""
        return self.start if ps < self.start else None if ps >= self.last else self.wave.after(ps)

    def edges(self, start: int, stop: int) -> tuple[list[int], list[Level]]:
        """Return the edges in start < t <= stop: a list of instants (ps) and a list of levels."""
        return self.wave.edges(start, stop)


def begin_line(driver: Driver, frames: FrameTable, data: bytes, fault: str = "") -> int:
    """Promise consecutive characters, the first starting at this instant; return the end (ps) of the last stop bit.

    Args:
        fault: "parity" for a wrong parity bit, or "framing" for space instead of mark in the first stop
            bit, in every character; "" for no fault.
    """
    line = Characters(frames, data, driver.kernel.now)
    if fault or not handed_over(driver, line):
        driver.drive(faulty(line, fault) if fault else line)
    return line.end


async def transmit(driver: Driver, frames: FrameTable, data: bytes, fault: str = "") -> None:
    """Send characters as `begin_line` does; return at the end of the last stop bit."""
    await until(driver.kernel, begin_line(driver, frames, data, fault))


def handed_over(driver: Driver, line: Characters) -> bool:
    """Pass a line that begins now directly to the receivers on the wire; return whether this was possible.

    If it was not possible, the caller must drive the wire.  It is possible only if no other task runs in
    this round, no driver other than `driver` drives the wire, and all observers of the wire are receivers at
    rest with the character format of the line.
    """
    root, kernel = driver.net, driver.kernel
    active = root.active
    if not kernel.sole or root.pending_drivers or root.exchange is not None or (active and active != (driver,)):
        return False
    nets, frames = root.joined or (root,), line.frames
    for net in nets:
        readers = net.readers
        if net.observers or net.latched or len(net.before_change) != len(readers):
            return False
        if net.waiters and len(net.waiters) > len(readers):
            net.drop_ended()
            if len(net.waiters) > len(readers):
                return False
        for reader in readers:
            if not reader.rests or reader.frames is not frames:
                return False
    driver.promise = line
    now, space = kernel.now, 1 - frames.mark
    for net in nets:
        if not active:
            net.active = (driver,)
        net.promise, net.plain = line, None
        net.token += 1
        if net._log is not None:
            net.log_from(now, line)
        if net.readers:
            net.value, net.changed_at, net.waiters = space, now, None
            net.changes += 1
            for reader in net.readers:
                reader.take_over(line)
    return True


def faulty(line: Characters, fault: str) -> Wave:
    """Return the wave of a line with `fault` in each character: "parity" or "framing"; other values: no fault."""
    frames = line.frames
    times: list[int] = []
    levels: list[int] = []
    for number, byte in enumerate(line.data):
        start = line.start + number * frames.length
        times += [start + time for time in frames.times]
        levels += frames.levels(byte)
        if fault == "parity" and frames.word.parity != "none":
            levels[-2] = 1 - levels[-2]
        elif fault == "framing":
            levels[-1] = 1 - frames.mark
            times.append(times[-1] + frames.times[1])
            levels.append(frames.mark)
    return Wave(frames.mark, tuple(times), tuple(levels))
