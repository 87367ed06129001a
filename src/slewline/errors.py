"""All exceptions that slewline raises deliberately, which report mistakes by *our user*.

A *host's* mistake never raises an exception: the chip answers as the real chip does, and a finding records it.  Each
class also inherits from the similar built-in exception, so callers may catch either.

Messages may quote external names, lines and files, so their length is limited.
"""

import re

LONGEST_FINDING, LONGEST_LINE = 400, 2000  # characters of the text of a finding, and of a line of an error

CUT = re.compile(r" \.\.\. \((\d+) characters in all\) \.\.\. ")


def shortened(text: str, most: int) -> str:
    """Return a text or, if it exceeds `most` characters, its start and end with its total length between them."""
    if len(text) <= most:
        return text
    half = most // 2
    out = text[half:-half]
    count = len(CUT.sub("", text)) + sum(int(number) - 2 * half for number in CUT.findall(out))  # shortened before
    return f"{text[:half]} ... ({count} characters in all) ... {text[-half:]}"


class SlewlineError(Exception):
    """The base class of slewline's exceptions; each subclass also inherits from a similar built-in exception."""

    def __init__(self, *args: object) -> None:
        super().__init__(*(_lines(each) if isinstance(each, str) else each for each in args))


def _lines(text: str) -> str:
    """Return a message, with each line that exceeds the maximum length shortened."""
    if len(text) <= LONGEST_LINE:
        return text
    return "\n".join(shortened(line, LONGEST_LINE) for line in text.split("\n"))


class UsageError(SlewlineError, ValueError):
    """An argument that is out of range, is of the wrong kind, or does not apply to the part."""


class TimeError(UsageError):
    """A time that cannot be understood, or is not a whole number of picoseconds."""


class UnknownName(SlewlineError, KeyError):
    """A name for which no chip, pin, register or part exists; the message lists the existing names."""

    def __str__(self) -> str:  # KeyError would print the repr of the message
        return str(self.args[0]) if self.args else ""


class NoSuchAttribute(SlewlineError, AttributeError):
    """An attribute that an object does not have, or that cannot be set; the message names the alternative."""


class WiringError(SlewlineError, ValueError):
    """Pins that cannot be connected as requested."""


class SheetError(SlewlineError, ValueError):
    """A data sheet that contradicts itself: an error in the chip's source code."""


class PlanError(SlewlineError, AssertionError):
    """A planned motion that is inconsistent: a fault of a chip's planner, never of the user or the host."""


class ProgramError(SlewlineError, ValueError):
    """A program text that the assembler refuses; the message states line, column and section of the manual."""


class BenchFileError(SlewlineError, ValueError):
    """A bench file or journal that cannot be used.

    Attributes:
        place: the place of the error, such as ("part", 0, "to"); empty: the whole file.
        reason: the message without the file and the place.
    """

    place: tuple[str | int, ...] = ()
    reason: str = ""


class JournalWarning(UserWarning):
    """A journal whose replay may differ from the recorded run, or end before the run does."""


class OtherLaws(JournalWarning):
    """A journal whose parts behaved differently at the time of recording than now, so the replay may differ."""


class TornJournal(JournalWarning):
    """A journal whose last line is truncated: the replay ends before this line."""


class LongPast(UserWarning):
    """A bench whose recorded past uses a lot of memory; `Bench(keep=)` limits it."""


class WaveformError(SlewlineError, ValueError):
    """A waveform file that cannot be read; the message states the file, the line and the expected content."""


class NotRecorded(SlewlineError, LookupError):
    """A query about the past of a pin or an axis that was not recorded, or is no longer kept."""


class NoSuchStep(SlewlineError, IndexError):
    """An index at which an axis has no step."""


class Timeout(SlewlineError, TimeoutError):
    """A wait that has exceeded its timeout; the message lists the event awaited by each chip, part and host."""


class Endless(SlewlineError, RuntimeError):
    """Tasks that have reacted to each other a hundred thousand times in one instant, without letting time pass."""


class ChecksumError(SlewlineError, ValueError):
    """An answer with a wrong checksum, or with a parity or framing error."""


class StoreError(SlewlineError, OSError):
    """A memory file that cannot be read or written."""
