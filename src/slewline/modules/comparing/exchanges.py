"""The exchanges of a dialogue: what a host has sent up to an answer, and the answer, each with its times.

Times are those on the line: a character that a host has handed over goes out behind the one before it, and takes as
long as the rate has it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from ...language.lines import KEPT, checksum
from ..dialogue import Said
from ..spoken import CR, Speech

LF = b"\n"


class TimedAnswer:
    """What follows from the times of an answer: first among the bases."""

    over_us: float
    first_us: float | None
    last_us: float | None

    @property
    def delay_us(self) -> float | None:
        """From the end of the last character that was sent to the first one that came."""
        return None if self.first_us is None else self.first_us - self.over_us

    @property
    def duration_us(self) -> float:
        """From the first character of the answer to the last one."""
        return 0 if self.first_us is None or self.last_us is None else self.last_us - self.first_us


@dataclass
class RecordedExchange(TimedAnswer):
    """What was sent, and what came until the next line was sent.

    `at_us` is when the first character was handed over, `over_us` when the last one was on the line; `first_us` and
    `last_us` are when the first and the last character of the answer came, if there was one.
    """

    number: int
    at_us: int
    over_us: float
    characters: list[tuple[int, int]] = field(default_factory=list)  # when each was handed over (µs), and its code
    answer: bytes = b""
    first_us: int | None = None
    last_us: int | None = None

    @property
    def sent(self) -> bytes:
        """The characters that were sent."""
        return bytes(code for _, code in self.characters)


def commands(speech: Speech, data: bytes) -> list[str]:
    """Return what was sent as commands: without carriage returns, checksums and addresses, and without the wake."""
    found = []
    for line in re.split(b"[%b]" % speech.ends, data.removeprefix(speech.wake)):
        line = line.strip(LF)
        text = (line[:-1] if speech.checked else line).decode("latin-1")
        found.append(text.removeprefix(str(speech.address)) if speech.address else text)
    return [text for text in found if text]


def is_for(speech: Speech, data: bytes) -> bool:
    """Return whether a line is for the module that is spoken to."""
    return not speech.address or data.startswith(str(speech.address).encode())


def exchanges_of(said: Iterable[Said], speech: Speech) -> list[RecordedExchange]:
    """Return the exchanges of a dialogue with one module; what is for others on its line is left out.

    A line that a host sends without waiting until the one before it is over shares its exchange.
    """
    found: list[RecordedExchange] = []
    character_us = speech.character_s * 1e6
    over_us = 0.0
    begun = False  # a line
    passed = False  # the last line is for another module, and so is what comes
    for entry in said:
        if entry.speaker == "module" and found and not passed:
            _answered(found[-1], entry)
        if entry.speaker != "host":
            continue
        for at_us, code in spread(entry):
            begins = not begun and not (found and code == LF[0])  # a line feed belongs to the line before
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
    """Return whether a line is sent before the one before it is over on the line, let alone answered."""
    return not before.answer and at_us < before.over_us and before.sent.strip(CR) != b""


def are_checked(said: Iterable[Said]) -> bool:
    """Return whether every line that was sent ends in its checksum."""
    sent = b"".join(entry.data for entry in said if entry.speaker == "host")
    lines = [line for each in sent.split(CR)[:-1] if (line := each.lstrip(LF))]
    return bool(lines) and all(line[-1] == checksum(line[:-1], KEPT) for line in lines)


def spread(entry: Said) -> list[tuple[int, int]]:
    """Return the characters of an entry with their times; those between the first and the last are at equal ones."""
    span, last = entry.last_us - entry.at_us, max(len(entry.data) - 1, 1)
    return [(entry.at_us + span * number // last, code) for number, code in enumerate(entry.data)]


def _answered(exchange: RecordedExchange, entry: Said) -> None:
    exchange.answer += entry.data
    if exchange.first_us is None:
        exchange.first_us = entry.at_us
    exchange.last_us = entry.last_us
