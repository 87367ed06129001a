"""The exchanges of a dialogue: a host's data up to an answer, and the answer, with the times of both.

Times are those on the line: a character written by a host is sent after the previous character, and
takes one character time at the rate of the line.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from ...language.lines import KEPT, checksum
from ..dialogue import DialogueEntry
from ..spoken import CR, Speech

LF = b"\n"


class TimedAnswer:
    """A base class with the delay and the duration of an answer; it must be listed before any other bases."""

    over_us: float
    first_us: float | None
    last_us: float | None

    @property
    def delay_us(self) -> float | None:
        """Time (µs) between the end of the host's last character and the answer's first; None without an answer."""
        return None if self.first_us is None else self.first_us - self.over_us

    @property
    def duration_us(self) -> float:
        """Time from the first to the last character of the answer (µs); 0 without an answer."""
        return 0 if self.first_us is None or self.last_us is None else self.last_us - self.first_us


@dataclass
class RecordedExchange(TimedAnswer):
    """Data sent by a host, and the answer received before the host sent its next line.

    `at_us` is the time when the first character was written, `over_us` the time when the last character had
    been sent on the line; `first_us` and `last_us` are the times of the first and the last character of the
    answer, if there was one.
    """

    number: int
    at_us: int
    over_us: float
    characters: list[tuple[int, int]] = field(default_factory=list)  # time of each character (µs), and its code
    answer: bytes = b""
    first_us: int | None = None
    last_us: int | None = None

    @property
    def sent(self) -> bytes:
        """Characters sent by the host."""
        return bytes(code for _, code in self.characters)


def commands(speech: Speech, data: bytes) -> list[str]:
    """Return the commands in a host's data, without line ends, checksums, addresses and wake-up characters."""
    found = []
    for line in re.split(b"[%b]" % speech.ends, data.removeprefix(speech.wake)):
        line = line.strip(LF)
        text = (line[:-1] if speech.checked else line).decode("latin-1")
        found.append(text.removeprefix(str(speech.address)) if speech.address else text)
    return [text for text in found if text]


def is_for(speech: Speech, data: bytes) -> bool:
    """Return whether a line is addressed to the module of this dialogue."""
    return not speech.address or data.startswith(str(speech.address).encode())


def exchanges_of(entries: Iterable[DialogueEntry], speech: Speech) -> list[RecordedExchange]:
    """Return the exchanges of a dialogue with one module; data for other modules on the same line is left out.

    A line of text that a host sends before its previous line has been transmitted belongs to the exchange of
    that previous line.
    """
    found: list[RecordedExchange] = []
    character_us = speech.character_s * 1e6
    over_us = 0.0
    begun = False  # a line
    passed = False  # the last line is for another module, and so is its answer
    for entry in entries:
        if entry.speaker == "module" and found and not passed:
            _answered(found[-1], entry)
        if entry.speaker != "host":
            continue
        for at_us, code in spread(entry):
            begins = not begun and not (found and code == LF[0])  # a line feed belongs to the previous line
            if begins:
                passed = not is_for(speech, bytes([code]))
                if not passed and not (found and waits_for_none(found[-1], at_us)):
                    found.append(RecordedExchange(len(found) + 1, at_us, 0.0))
            over_us = max(over_us, at_us) + character_us
            if not passed:
                found[-1].characters.append((at_us, code))
                found[-1].over_us = over_us
            begun = code not in speech.ends and (begun or begins)
    return found


def waits_for_none(before: RecordedExchange, at_us: int) -> bool:
    """Return whether the host begins a line at `at_us` before the data of `before` has been sent.

    Return False if `before` has been answered, or contains only carriage returns.
    """
    return not before.answer and at_us < before.over_us and before.sent.strip(CR) != b""


def are_checked(entries: Iterable[DialogueEntry]) -> bool:
    """Return whether every line that the host sent ends in its checksum; False if the host sent no line."""
    sent = b"".join(entry.data for entry in entries if entry.speaker == "host")
    lines = [line for each in sent.split(CR)[:-1] if (line := each.lstrip(LF))]
    return bool(lines) and all(line[-1] == checksum(line[:-1], KEPT) for line in lines)


def spread(entry: DialogueEntry) -> list[tuple[int, int]]:
    """Return the time (µs) and code of each character of an entry, with equally spaced times."""
    span, last = entry.last_us - entry.at_us, max(len(entry.data) - 1, 1)
    return [(entry.at_us + span * number // last, code) for number, code in enumerate(entry.data)]


def _answered(exchange: RecordedExchange, entry: DialogueEntry) -> None:
    exchange.answer += entry.data
    if exchange.first_us is None:
        exchange.first_us = entry.at_us
    exchange.last_us = entry.last_us
