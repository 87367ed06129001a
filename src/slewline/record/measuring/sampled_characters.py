"""The characters on a serial line, decoded from its recorded edges as a receiver would decode them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...core.time.timebase import Clock
from ...core.wires.receiver import Character
from ...core.wires.serial import OVERSAMPLING, CharacterFormat

if TYPE_CHECKING:
    from .intervals import SignalEdges


def characters(signal: SignalEdges, stop: int, clock: Clock, word: CharacterFormat, mark: int) -> list[Character]:
    """Return the characters in the signal of a serial line, which must be idle at the start of the signal.

    Args:
        stop: the end of the signal (ps); a character is left out if the middle of its first stop bit is
            later than this.
        clock: the clock, at sixteen times the baud rate.
        mark: the level of the idle line.
    """
    import numpy as np

    times, found, free = signal.times_ps, [], 0
    bit, length = clock.ps(OVERSAMPLING), clock.ps(word.ticks)
    bits = 2 + word.bits + (word.parity != "none")  # with start bit and first stop bit
    middles = np.array([clock.ps(OVERSAMPLING // 2 + n * OVERSAMPLING) for n in range(bits)], np.int64)
    for start in times[signal.levels == 1 - mark].tolist():
        if start < free or start + int(middles[-1]) > stop:
            continue
        seen = (signal.levels_at(start + middles) == mark).astype(int).tolist()
        if seen[0]:
            continue  # a spike
        byte = sum(one << n for n, one in enumerate(seen[1 : 1 + word.bits]))
        wrong = word.parity != "none" and seen[-2] != word.parity_bit(byte)
        found.append(Character(byte, wrong, not seen[-1], start, start + length))
        free = start + int(middles[-1]) + (0 if seen[-1] else bit)
    return found


def shown(byte: int) -> str:
    """Return a byte as text for a picture: a character, a control character's abbreviation, or two hex digits."""
    names = {13: "CR", 10: "LF", 27: "ESC", 3: "ETX", 32: "SP"}
    return names.get(byte) or (chr(byte) if 32 < byte < 127 else f"{byte:02X}")
