"""Decoding of a dialogue between host and module from a logic analyser's recording of their two wires."""

from __future__ import annotations

from typing import NamedTuple

from ..core.datasheet.table import Sheet
from ..core.time.timebase import Clock, readable
from ..core.wires.receiver import Character
from ..core.wires.serial import OVERSAMPLING, CharacterFormat
from ..errors import UsageError
from ..record.measuring.intervals import SignalEdges
from ..record.measuring.sampled_characters import characters, shown
from ..record.waveforms.waveforms import Waveforms
from .dialogue import DialogueEntry, DialogueHeader, Gathered, RecordedDialogue, Speaker
from .speech import speech_of

PS_PER_US = 10**6
MOST_DAMAGED = 0.2  # fraction of damaged characters: beyond that it is another rate, or another signal


class DamagedCharacter(NamedTuple):
    """A character with a wrong parity or stop bit: its signal, the time of its start bit (ps), and its value.

    `parity` is True if the parity bit is wrong.
    """

    signal: str
    at_ps: int
    byte: int
    parity: bool

    def __str__(self) -> str:
        what = "parity" if self.parity else "stop bit"
        return f"{self.signal} at {readable(self.at_ps)}: wrong {what} ({shown(self.byte)})"


class Decoded(NamedTuple):
    """A decoded dialogue, and the damaged characters in it."""

    dialogue: RecordedDialogue
    damaged: tuple[DamagedCharacter, ...]


def decode_dialogue(
    waves: Waveforms,
    sheet: Sheet,
    host: str,
    module: str,
    *,
    baud: int | None = None,
    checksum: bool | None = None,
    address: int = 0,
) -> Decoded:
    """Read the dialogue between a host and a module from a recording of their two wires.

    The idle level of each wire, which differs between TTL and RS-232, is detected: it is the level in the
    longest interval without an edge.

    Args:
        waves: the recording; the times in the dialogue count from the beginning of the recording.
        sheet: the sheet of the part, which defines the character format.
        host: the signal on which the host sends.
        module: the signal on which the module sends.
        baud: the rate; None: the part's rate at which the fewest characters are damaged.
        checksum, address: values for the header of the dialogue.

    Raises:
        UsageError: there are no characters, or more than the fraction `MOST_DAMAGED` of them are damaged;
            a signal has more than one bit; the part does not have a given setting.
        UnknownName: there is no such signal.
    """
    speech = speech_of(sheet, baud, checksum, address or None)
    wires = {"host": _Wire(waves, host), "module": _Wire(waves, module)}
    rates = speech.rates if baud is None else (baud,)
    rate = min(rates, key=lambda each: _misfit(wires, each, speech.word))
    characters = {who: wire.characters(rate, speech.word) for who, wire in wires.items()}
    damaged = tuple(
        DamagedCharacter(wires[who].name, each.start_ps, each.byte, each.parity_wrong)
        for who, found in characters.items()
        for each in found
        if not each.good
    )
    total = sum(map(len, characters.values()))
    tried = f"{rate} baud" if len(rates) == 1 else f"{rates[-1]} to {rates[0]} baud"
    if not total or len(damaged) > MOST_DAMAGED * total:
        found = f"{len(damaged)} of {total} characters are damaged" if total else "there are no characters"
        raise UsageError(
            f"{waves.path}: {host} and {module} at {tried}, {speech.word}: {found}; required: the serial "
            f"wires of a {sheet.part.upper()}, sampled often enough (in this file: every "
            f"{readable(waves.sampling_ps)}); name the correct signals and rate"
        )
    header = DialogueHeader(sheet.part, baud=rate, checksum=checksum, address=address)
    return Decoded(RecordedDialogue(header, tuple(_entries(characters, waves.start_ps))), damaged)


class _Wire:
    """A wire of a recording: its edges, its idle level, and the length of its shortest pulse (ps)."""

    def __init__(self, waves: Waveforms, name: str) -> None:
        import numpy as np

        if waves.kind(name) != "bits" or waves.width(name) > 1:
            raise UsageError(f"{name}: not a wire; name a one-bit signal")
        trace = waves.trace(name)
        self.name, self.stop = name, waves.stop_ps
        bounds = np.concatenate(([trace.since], trace.times_ps, [trace.until]))
        lasts = np.diff(bounds)
        levels = np.append(trace.level, trace.levels)
        self.mark = max(int(levels[lasts.argmax()]), 0)
        self.signal = SignalEdges(trace.times_ps, trace.levels, self.mark, False)
        inner = lasts[1:-1]
        self.shortest = int(inner.min()) if len(inner) else 0

    def characters(self, baud: int, word: CharacterFormat) -> list[Character]:
        clock = Clock(round(baud * OVERSAMPLING))
        return characters(self.signal, self.stop + clock.ps(word.ticks), clock, word, self.mark)


def _misfit(wires: dict[str, _Wire], baud: int, word: CharacterFormat) -> tuple[float, float]:
    """Return the misfit of a rate, as a pair of numbers that are compared in this order.

    The first is the fraction of damaged characters.  The second is the ratio between the bit time of the rate and the
    shortest pulse on the wires, the longer of the two divided by the shorter one; 1 is a perfect match.
    """
    found = [each for wire in wires.values() for each in wire.characters(baud, word)]
    shortest = min((wire.shortest for wire in wires.values() if wire.shortest), default=0)
    bit = Clock(round(baud * OVERSAMPLING)).ps(OVERSAMPLING)
    apart = max(bit, shortest) / max(min(bit, shortest), 1)
    return sum(not each.good for each in found) / max(len(found), 1), apart


def _entries(characters: dict[str, list[Character]], begin: int) -> list[DialogueEntry]:
    """Return the entries of a dialogue, timed as a proxy would time them.

    A character from the host has the time of its start, a character from the module the time of its end.
    """
    instants: list[tuple[int, Speaker, int]] = [(each.start_ps, "host", each.byte) for each in characters["host"]]
    instants += [(each.end_ps, "module", each.byte) for each in characters["module"]]
    gathered = Gathered()
    entries = [
        entry
        for ps, who, byte in sorted(instants, key=lambda each: each[0])
        for entry in gathered.take(who, (ps - begin) // PS_PER_US, byte)
    ]
    return [DialogueEntry(first, last, who, data) for who, first, last, data in entries + gathered.end()]
