"""Every exception that slewline raises on purpose: what *our user* did wrong.

What a *host* does wrong is chip behaviour and never an exception; it is answered as the chip answers and kept as
a finding.  Each class also inherits the built-in that it resembles, so callers may catch either.

Whatever comes from outside, a name, a line, a file, may be quoted in a message, so its length is limited.
"""

import re

LONGEST_FINDING, LONGEST_LINE = 400, 2000  # characters of the text of a finding, and of a line of an error

CUT = re.compile(r" \.\.\. \((\d+) characters in all\) \.\.\. ")


def shortened(text: str, most: int) -> str:
    """Return a text; of one with more than so many characters start and end, and how many there are."""
    if len(text) <= most:
        return text
    half = most // 2
    out = text[half:-half]
    count = len(CUT.sub("", text)) + sum(int(number) - 2 * half for number in CUT.findall(out))  # of one cut before
    return f"{text[:half]} ... ({count} characters in all) ... {text[-half:]}"


class SlewlineError(Exception):
    """What slewline raises on purpose: every exception of this list is one, and a built-in one that it resembles."""

    def __init__(self, *args: object) -> None:
        super().__init__(*(_lines(each) if isinstance(each, str) else each for each in args))


def _lines(text: str) -> str:
    """Return a message, whose lines are as long as they may be."""
    if len(text) <= LONGEST_LINE:
        return text
    return "\n".join(shortened(line, LONGEST_LINE) for line in text.split("\n"))


class UsageError(SlewlineError, ValueError):
    """An argument that is out of range, of the wrong kind, or does not fit the part."""


class TimeError(UsageError):
    """A time that cannot be read, or cannot be represented in whole picoseconds."""


class UnknownName(SlewlineError, KeyError):
    """A chip, pin, register or part that does not exist; the message lists those that do."""

    def __str__(self) -> str:  # KeyError would print the repr of the message
        return str(self.args[0]) if self.args else ""


class NoSuchAttribute(SlewlineError, AttributeError):
    """A name that an object has not, or that cannot be set; the message names what there is instead."""


class WiringError(SlewlineError, ValueError):
    """Pins that cannot be connected as asked."""


class SheetError(SlewlineError, ValueError):
    """A data sheet that contradicts itself: a mistake in a chip folder."""


class PlanError(SlewlineError, AssertionError):
    """A planned motion that does not hold together: a mistake in a law of motion, never of the user or the host."""


class ProgramError(SlewlineError, ValueError):
    """A program text that the assembler refuses.  The message carries line, column and manual section."""


class BenchFileError(SlewlineError, ValueError):
    """A bench file or journal that cannot be used."""


class JournalWarning(UserWarning):
    """A journal is replayed, but not as the run was, or not to its end."""


class OtherLaws(JournalWarning):
    """The parts of a journal behaved differently from those of this version."""


class TornJournal(JournalWarning):
    """The last line of a journal was cut off; the replay ends before it."""


class WaveformError(SlewlineError, ValueError):
    """A waveform file that cannot be read.  The message carries file, line and what was expected."""


class NotRecorded(SlewlineError, LookupError):
    """A question about the past of a net that was not recorded."""


class NoSuchStep(SlewlineError, IndexError):
    """A step beyond those that there are."""


class Timeout(SlewlineError, TimeoutError):
    """Virtual time ran out before the bench was idle; the message lists who waits for what, since when."""


class Endless(SlewlineError, RuntimeError):
    """A hundred thousand rounds in one instant: tasks that answer each other without letting time pass."""


class ChecksumError(SlewlineError, ValueError):
    """A reply whose checksum does not fit."""


class StoreError(SlewlineError, OSError):
    """A memory in a file that cannot be read, or did not take its new content."""
