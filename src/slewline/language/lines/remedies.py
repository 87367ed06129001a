"""Remedies for lines that are not commands.

The linter shows them before a run; during a run they are part of a module's findings.
"""

from __future__ import annotations

from ...core.datasheet.channel import SerialLine
from ...core.datasheet.command_rows import LineRow
from ...core.datasheet.table import Sheet
from ..dialect import IN_DIGITS, LIKE_DIGITS, Command, Refusal, slip_remedy
from .line_grammar import KEPT, SIGN, checksum, parse, range_of, usage

LF = "\n"


def alike(sheet: Sheet, text: str) -> list[LineRow]:
    """Return the commands that a line may be meant to be: those with the same first character.

    If the line begins with + or -, the commands that begin with a sign are returned.
    """
    letter = SIGN if text[:1] in ("+", "-") else text[:1]
    return [row for row in sheet.rows(LineRow) if row.head[:1] == letter]


def remedy(sheet: Sheet, text: str, found: Refusal) -> str:
    """Return the remedy for a line that was refused; empty if none is known."""
    unknown = found.code == "unknown"
    if LF in text:
        return "lines end with a carriage return alone: leave out the line feed"
    if word := slip_remedy(sheet, text):
        return word
    if meant := respelled(sheet, text):
        return f"write {meant}: no spaces, and case matters"
    if is_command(sheet, digits := text[:1] + text[1:].translate(LIKE_DIGITS)):
        return f"write {digits}, {IN_DIGITS}"
    if is_command(sheet, text[:-1]) and any(ord(text[-1]) == checksum(text[:-1].encode(), kept) for kept in (0, KEPT)):
        pin = _pin(sheet)
        return f"{text[-1]!r} is the checksum of {text[:-1]}: leave it out" + (f", or strap {pin}=1" if pin else "")
    if text[:1].isdigit() and is_command(sheet, text[1:]):
        return f"write {text[1:]}: leave out the address"
    if unknown and (rows := alike(sheet, text)):
        return f"with this letter it has {', '.join(map(usage, rows))}"
    if unknown and text.startswith(sheet.foreign):
        return "a sister part has this command"
    return found.remedy or ("" if unknown else arguments(sheet, text))


def arguments(sheet: Sheet, text: str) -> str:
    """Return the remedy for a line whose arguments do not fit: the arguments of its command, with their ranges."""
    heads = [row.head for row in sheet.rows(LineRow) if text.startswith(row.head)]
    head = max(heads, key=len, default=SIGN)
    args = {arg.name: range_of(arg) for row in sheet.rows(LineRow) if row.head == head for arg in row.args}
    given = ", ".join(f"{name} {allowed}" for name, allowed in args.items())
    return f"give {given}" if given else f"{head} takes no argument"


def refusal(sheet: Sheet, text: str, found: Refusal) -> str:
    """Return a sentence about a refused line: the text found, the allowed values and the remedy, if known."""
    word = remedy(sheet, text, found)
    if not word and found.code == "unknown":
        word = f"its commands begin with {found.allowed}"
    return f"{found.text}; {word}" if word else found.text


def respelled(sheet: Sheet, text: str) -> str:
    """Return a line in a different case or without its spaces, if that makes it a command; "" otherwise."""
    tight = text.replace(" ", "")
    return next(
        (spelling for spelling in (tight, tight.lower(), tight.capitalize()) if is_command(sheet, spelling)), ""
    )


def is_command(sheet: Sheet, text: str) -> bool:
    """Return whether a line is a command of the part."""
    return isinstance(parse(sheet, text), Command)


def _pin(sheet: Sheet) -> str:
    port = sheet.channel(SerialLine)
    return port.checksum_pin if port is not None else ""
