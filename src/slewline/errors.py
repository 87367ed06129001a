"""Every exception that slewline raises on purpose: mistakes of *our user*.

A mistake of a *host* is never an exception: the chip answers as the real one does, and a finding records it.  Each
class also inherits the similar built-in one, so callers may catch either.

Messages may quote names, lines and files from outside, so their length is limited.
"""

import re

LONGEST_FINDING, LONGEST_LINE = 400, 2000  # characters of the text of a finding, and of a line of an error

CUT = re.compile(r" \.\.\. \((\d+) characters in all\) \.\.\. ")


def shortened(text: str, most: int) -> str:
    """Return a text; if it has more than `most` characters, only its start and end, with the number of all."""
    if len(text) <= most:
        return text
    half = most // 2
    out = text[half:-half]
    count = len(CUT.sub("", text)) + sum(int(number) - 2 * half for number in CUT.findall(out))  # shortened before
    return f"{text[:half]} ... ({count} characters in all) ... {text[-half:]}"


class SlewlineError(Exception):
    """The base class of the exceptions of slewline; each also inherits the similar built-in one."""

    def __init__(self, *args: object) -> None:
        super().__init__(*(_lines(each) if isinstance(each, str) else each for each in args))


def _lines(text: str) -> str:
    """Return a message with its lines shortened to the longest allowed."""
    if len(text) <= LONGEST_LINE:
        return text
    return "\n".join(shortened(line, LONGEST_LINE) for line in text.split("\n"))


class UsageError(SlewlineError, ValueError):
    """An argument that is out of range, of the wrong kind, or does not fit the part."""


class TimeError(UsageError):
    """A time that cannot be understood, or is not a whole number of picoseconds."""


class UnknownName(SlewlineError, KeyError):
    """A name of a chip, pin, register or part that does not exist; the message lists the existing ones."""

    def __str__(self) -> str:  # KeyError would print the repr of the message
        return str(self.args[0]) if self.args else ""


class NoSuchAttribute(SlewlineError, AttributeError):
    """An attribute that an object does not have, or that cannot be set; the message names the one to use instead."""


class WiringError(SlewlineError, ValueError):
    """Pins that cannot be connected as requested."""


class SheetError(SlewlineError, ValueError):
    """A data sheet that contradicts itself: an error in the source of a chip."""


class PlanError(SlewlineError, AssertionError):
    """A planned motion that is inconsistent: an error in the motion law of a chip, never of the user or the host."""


class ProgramError(SlewlineError, ValueError):
    """A program text that the assembler refuses; the message has line, column and section of the manual."""


class BenchFileError(SlewlineError, ValueError):
    """A bench file or journal that cannot be used."""


class JournalWarning(UserWarning):
    """A journal whose replay may differ from the recorded run, or end before it."""


class OtherLaws(JournalWarning):
    """A journal of parts that behaved differently when it was recorded: the replay may differ."""


class TornJournal(JournalWarning):
    """A journal whose last line is cut off: the replay ends before it."""


class LongPast(UserWarning):
    """The past of a bench uses much memory; `Bench(keep=)` limits it."""


class WaveformError(SlewlineError, ValueError):
    """A waveform file that cannot be read; the message has the file, the line and the expected content."""


class NotRecorded(SlewlineError, LookupError):
    """A query about the past of a pin or an axis that was not recorded, or is no longer kept."""


class NoSuchStep(SlewlineError, IndexError):
    """An index of a step that does not exist."""


class Timeout(SlewlineError, TimeoutError):
    """A wait that has exceeded its timeout; the message lists what each chip, part and host waits for."""


class Endless(SlewlineError, RuntimeError):
    """A hundred thousand rounds in one instant: tasks react to each other without letting time pass."""


class ChecksumError(SlewlineError, ValueError):
    """An answer with a wrong checksum, or one with a parity or framing error."""


class StoreError(SlewlineError, OSError):
    """A memory kept in a file that cannot be read or written."""
