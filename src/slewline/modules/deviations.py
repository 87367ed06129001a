"""Deviations of a module's answer from the data sheet: the smallest set that explains the answer, as text.

A mend undoes one kind of deviation; `deviations` searches for the fewest mends that turn the answer
into a valid one.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from itertools import combinations
from typing import NamedTuple

from ..language.dialect import Command, dialect_of
from ..language.lines import parse
from .failures import DamagedAnswer
from .speech import LineSpeech, QuerySpeech
from .spoken import CR, Speech

MOST = 2  # maximum number of deviations searched for together
LONGEST = 4096  # maximum length of an answer that is searched, in characters
BLANKS = b" \t"


class ModuleQuery(NamedTuple):
    """A query to a module: the protocol of the part, and the command."""

    speech: Speech
    command: str

    @property
    def lists(self) -> bool:
        """True if the query requests the listing of the whole program, not of a number of memory lines."""
        row = self.speech.row(self.command)
        return row is not None and row.role == "list"


class Mend(NamedTuple):
    """A kind of deviation: its description, and a function that undoes the deviation in an answer."""

    description: str
    undo: Callable[[ModuleQuery, bytes], bytes]


def deviations(speech: Speech, command: str, received: bytes) -> str:
    """Return the deviations that explain an invalid answer, as text; empty if it is valid, or not explained."""
    question = ModuleQuery(speech, command)
    if not received or len(received) > LONGEST or not isinstance(speech, (LineSpeech, QuerySpeech)):
        return ""
    if fits(question, received):
        return ""
    for number in range(1, MOST + 1):
        for mends in combinations(MENDS, number):
            if fits(question, _undone(question, received, mends)):
                return " and ".join(mend.description for mend in mends)
    return ""


def _undone(question: ModuleQuery, received: bytes, mends: Sequence[Mend]) -> bytes:
    """Apply these mends to an answer, one after another; return the result, empty if a mend changes nothing."""
    for mend in mends:
        before, received = received, mend.undo(question, received)
        if received == before:
            return b""
    return received


def fits(question: ModuleQuery, received: bytes) -> bool:
    """Return whether the received characters are a valid answer of the part to a query."""
    if not received.endswith(CR):
        return False
    try:
        lines = question.speech.lines(received)
    except DamagedAnswer:
        return False
    if len(lines) == 1 and question.speech.refusal(lines[0]):
        return True
    shape = next((shape for each, shape in question.speech.questions.values() if each == question.command), None)
    if shape is not None:
        return re.fullmatch(shape, "\r".join(lines)) is not None
    if question.lists:
        return lines[-1] == _end_of(question) and all(is_instruction(question, line) for line in lines[:-1])
    if isinstance(question.speech, QuerySpeech):
        (pointer,) = question.speech.sheet.acting("pointer")
        wanted = 1 + question.speech.listed_lines(question.command)
        return len(lines) == wanted and re.fullmatch(rf"{pointer.form}=[0-9]{{5}}", lines[0]) is not None
    return len(lines) == 1 and lines[0] in dialect_of(question.speech.sheet).answers


def is_instruction(question: ModuleQuery, line: str) -> bool:
    """Return whether a line of a listing is an instruction of the part."""
    command = parse(question.speech.sheet, line)
    return isinstance(command, Command) and bool(command.row.stored)


def _end_of(question: ModuleQuery) -> str:
    """Return the line that ends a listing; empty if listings of the part have no such line."""
    answers = dialect_of(question.speech.sheet).answers.items()
    return next((answer for answer, meaning in answers if "listing" in meaning), "")


# ---------------------------------------------------------------------------------------------------------- the mends
def _each(undo: Callable[[ModuleQuery, bytes], bytes]) -> Callable[[ModuleQuery, bytes], bytes]:
    """Return a function that applies `undo` to each line of an answer."""
    return lambda question, data: b"".join(undo(question, line) for line in data.splitlines(keepends=True))


def _echo(question: ModuleQuery, data: bytes) -> bytes:
    sent = question.speech.framed(question.command)
    for each in (sent + b"\n", sent, sent.rstrip(CR)):
        if data.startswith(each) and len(data) > len(each):
            return data[len(each) :].lstrip(b"\n")
    return data


def _no_prompt(_question: ModuleQuery, data: bytes) -> bytes:
    return re.sub(rb"(?m)^[>*#:?]+ ?|[>*#:?]+ ?\Z", b"", data)


def _capitals(question: ModuleQuery, line: bytes) -> bytes:
    text = line.rstrip(b"\r\n").decode("latin-1")
    return line if question.lists and is_instruction(question, text) else line.upper()


def _joined(question: ModuleQuery, data: bytes) -> bytes:
    """Return a listing in which each line that begins with neither letter nor sign is joined to the one before."""
    if not question.lists:
        return data
    *lines, end = data.removesuffix(CR).split(CR)
    found: list[bytes] = []
    for line in lines:
        goes_on = found and not re.match(rb"[A-Za-z+-]", line)
        found[-1:] = [found[-1] + line] if goes_on else [*found[-1:], line]
    return CR.join([*found, end]) + CR


def _with_end(question: ModuleQuery, data: bytes) -> bytes:
    end = _end_of(question).encode("ascii")
    return data + end + CR if question.lists and end and not data.endswith(end + CR) else data


def _last_line(question: ModuleQuery, data: bytes) -> bytes:
    return data if question.lists else data.removesuffix(CR).rpartition(CR)[2] + CR


def _padded(question: ModuleQuery, line: bytes) -> bytes:
    """Return a line with leading zeros added or removed, so that its number has as many digits as in the sheet."""
    found = re.fullmatch(rb"([A-Z])=([0-9]+)\r", line)
    if found and isinstance(question.speech, QuerySpeech):
        digits = question.speech.dialect.queries.get(found[1].decode("ascii"), 0)
        return found[1] + b"=" + found[2].lstrip(b"0").rjust(digits, b"0") + CR
    return re.sub(rb"\A(V[+-]?)0+(?=[0-9]{2})", rb"\1", line)


def _unchecked(question: ModuleQuery, line: bytes) -> bytes:
    if not isinstance(question.speech, LineSpeech) or question.speech.checked:
        return line
    checked = LineSpeech(question.speech.sheet, question.speech.baud, True, question.speech.address)
    with suppress(DamagedAnswer):
        return checked.stripped(line.rstrip(CR)).encode("latin-1") + CR
    return line


MENDS = (
    Mend("bit 7 of its 7-bit characters is 1", lambda _, data: bytes(each & 0x7F for each in data)),
    Mend("it echoes sent characters, as a modem or a console does", _echo),
    Mend("its lines end in CR LF instead of CR", lambda _, data: data.replace(b"\r\n", CR)),
    Mend("its lines end in LF instead of CR", lambda _, data: data if CR in data else data.replace(b"\n", CR)),
    Mend("its lines end in LF CR instead of CR", lambda _, data: data.replace(b"\n\r", CR)),
    Mend("it does not end in CR", lambda _, data: data if data.endswith(CR) else data + CR),
    Mend("it has empty lines", lambda _, data: re.sub(rb"\r+", CR, data.lstrip(CR))),
    Mend("its lines end in checksums (--checksum)", _each(_unchecked)),
    Mend("it is surrounded by a prompt", _no_prompt),
    Mend("it has spaces before or after it", _each(lambda _, line: line.rstrip(CR).strip(BLANKS) + CR)),
    Mend("it has spaces inside", _each(lambda _, line: re.sub(rb"[ \t]", b"", line))),
    Mend("it has lower-case letters instead of capitals", _each(_capitals)),
    Mend("it begins with the address", _each(lambda _, line: re.sub(rb"\A[1-7](?=[A-Z])", b"", line))),
    Mend("it is preceded by other lines", _last_line),
    Mend("its number has a different number of digits", _each(_padded)),
    Mend("it lacks the V at its start", lambda _, data: data if data.startswith(b"V") else b"V" + data),
    Mend("lines of the listing are wrapped", _joined),
    Mend("the listing has no END", _with_end),
)


# --------------------------------------------------------------------------------------------------------- in words
def in_words(shape: str) -> str:
    """Return the pattern of an answer as readable text, such as: V, a sign, 1 to 7 digits."""
    words = re.sub(r"[()]", "", shape)
    for pattern, replacement in (
        (r"\[\+-\]", ", a sign"),
        (r"\[0-9\]\{([0-9]+),([0-9]+)\}", r", \1 to \2 digits"),
        (r"\[0-9\]\{([0-9]+)\}", r", \1 digits"),
        (r"\[0-7\]\[0-7\]", ", 2 digits of 0 to 7"),
    ):
        words = re.sub(pattern, replacement, words)
    return words
