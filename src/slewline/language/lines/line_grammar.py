"""Commands that are lines of text, and answers that are lines: text in, commands out.  No time, no pins.

    [address] command [argument] [checksum] CR             2 A 3 6 CR: module 2, set output 3

    A3         letter and number               G+2       a direction, then a number
    +250       a sign and a number             jc1,18    two numbers, separated by a comma

A command letter may have several forms (G10, G+, G+2); the form whose pattern matches the line is
selected. No function here raises: a line that is not a command becomes a `Refusal`, for which the chip
has an answer.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import cast

from ...core.datasheet.command_rows import LineRow
from ...core.datasheet.table import Arg, Sheet
from ..dialect import Command, Refusal

CR = 0x0D
KEPT = 0x10  # the bit that is always set in a checksum, so that it is never a carriage return
SIGN = "±"  # head of a command that begins with its sign
_PATTERNS = {"no": "[0-9]+", "may": "[+-]?[0-9]+", "must": "[+-][0-9]+", "alone": "[+-]"}


@dataclass(frozen=True, slots=True)
class LineCommand(Command):
    """A valid command, parsed from a line."""

    row: LineRow


def checksum(text: bytes, kept: int = KEPT) -> int:
    """Return the checksum character of a line: the sum of its character codes modulo 128, with `kept` set.

    Args:
        text: everything before the checksum, including the address.
        kept: the bits that are always set.
    """
    return sum(text) & 0x7F | kept


@lru_cache(maxsize=1024)  # hosts repeat the same commands
def framed(text: str | bytes, check: bool = True, kept: int = KEPT) -> bytes:
    """Return the bytes of a line: its text, its checksum if `check`, and a carriage return."""
    line = text.encode("ascii") if isinstance(text, str) else text
    return line + (bytes([checksum(line, kept)]) if check else b"") + b"\r"


def spell(row: LineRow, values: Sequence[int]) -> str:
    """Return the text of a command: "S10", "+250", "jc1,18"."""
    text = "" if row.head == SIGN else row.head
    for arg, value, before in zip(row.args, values, (None, *row.args), strict=False):
        text += ("," if before is not None and before.sign != "alone" else "") + arg.spell(value)
    return text + (row.tail[0] if row.tail else "")


@lru_cache(maxsize=1024)  # hosts repeat the same commands
def parse(sheet: Sheet, text: str) -> LineCommand | Refusal:
    """Parse a line, without address and checksum; return its command, or a `Refusal` if it is not valid."""
    patterns = _patterns(sheet)
    head = next((head for head in patterns if text.startswith(head)), SIGN if text[:1] in ("+", "-") else None)
    if head is None or not patterns.get(head):
        every = " ".join(dict.fromkeys(row.head for row in sheet.rows(LineRow)))
        message = f"{text!r} is not a command of the {sheet.part}"
        return Refusal("unknown", message, 0, len(text), f"{text} is not a command of the {sheet.part.upper()}", every)
    rest = text.removeprefix(head)
    closest: Refusal | None = None
    for row, pattern in patterns[head]:
        match = pattern.fullmatch(rest)
        if match is None:
            continue
        values = tuple(_value(arg, group) for arg, group in zip(row.args, match.groups(), strict=True))
        bad = next((pair for pair in zip(row.args, values, strict=True) if not pair[0].allows(pair[1])), None)
        if bad is None:
            stored = row.pack(values) if row.stored else b""
            return LineCommand(row, values, 0, stored, spell(row, values))
        (arg, value), allowed = bad, range_of(bad[0])
        place = places(row, text)[row.args.index(arg)]
        message = f"{text}: {arg.name} {value}, allowed {allowed}"
        remedy = f"the nearest is {arg.spell(nearest(arg, value))}"
        named = f"{row.name} {arg.name} {value}" if len(row.args) > 1 else f"{row.name} {value}"
        closest = Refusal("range", message, *place, named, allowed, remedy)
    if closest is not None:
        return closest
    forms = " or ".join(usage(row) for row, _ in patterns[head])
    message = f"{text!r} does not fit {forms}"
    return Refusal("argument", message, 0, len(text), f"{text} does not fit", forms)


def places(row: LineRow, text: str) -> list[tuple[int, int]]:
    """Return each argument's place in a line: the index of its first character, and the index after its last.

    The place of an omitted argument is the end of the line.
    """
    rest = text.removeprefix(row.head)
    match = cast("re.Match[str]", _pattern(row).fullmatch(rest))  # the line was parsed as this command
    before = len(text) - len(rest)
    spans = [match.span(number) for number in range(1, len(row.args) + 1)]
    return [(before + at, before + end) if at >= 0 else (len(text), len(text)) for at, end in spans]


def usage(row: LineRow) -> str:
    """Return the syntax of a command: "A<output>", "G<+/-><input>"."""
    text = "" if row.head == SIGN else row.head
    for arg, before in zip(row.args, (None, *row.args), strict=False):
        comma = "," if before is not None and before.sign != "alone" else ""
        shown = "<+/->" if arg.sign == "alone" else f"<+/-{arg.name}>" if arg.sign == "must" else f"<{arg.name}>"
        text += comma + (f"[{shown}]" if arg.optional else shown)
    return text + (row.tail[0] if row.tail else "")


def range_of(arg: Arg) -> str:
    """Return the allowed values of an argument, as text: "0..255", or "+, -"."""
    if arg.sign == "alone":
        return "+, -"
    return f"{arg.low}..{arg.high}" + ("" if arg.zero else " without 0")


def nearest(arg: Arg, value: int) -> int:
    """Return the allowed value of an argument that is nearest to the given value."""
    return min(max(value, arg.low), arg.high) or 1 - arg.zero


def _value(arg: Arg, text: str | None) -> int:
    if not text:
        return arg.high
    return int(text + "1") if arg.sign == "alone" else int(text)


@lru_cache(maxsize=64)
def _patterns(sheet: Sheet) -> dict[str, list[tuple[LineRow, re.Pattern[str]]]]:
    """Return a dictionary from each head to its commands and their patterns; longer heads come first.

    A head that only a sister part has is included, with an empty list.
    """
    heads = sorted({row.head for row in sheet.rows(LineRow)} | set(sheet.foreign), key=lambda head: (-len(head), head))
    return {head: [(row, _pattern(row)) for row in sheet.rows(LineRow) if row.head == head] for head in heads}


def _pattern(row: LineRow) -> re.Pattern[str]:
    pattern = ""
    for arg, before in zip(row.args, (None, *row.args), strict=False):
        comma = "," if before is not None and before.sign != "alone" else ""
        pattern += comma + f"({_PATTERNS[arg.sign]}){'?' if arg.optional else ''}"
    return re.compile(pattern + (f"(?:{'|'.join(row.tail)})" if row.tail else ""))
