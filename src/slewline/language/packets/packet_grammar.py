"""Packets: the conversion of lines of a host script to words, and of words to lines.  No time, no pins.

    SET_POS 12345             10  0000 3039     command byte; words, high word first, high byte first
    set_vel $2C000            11  0002 C000     case is ignored; hexadecimal after $ or 0x
    SET_ACC -127795           12  FFFE 0CCD     two's complement; $FFFE0CCD is the same number
    SET_VEL 12345 steps/s     11  0004 0B93     the nearest number, at the part's crystal; rates.py lists the units
    GET_STATUS                31 [0300]         a word that the chipset returns
    UPDATE                    1A

After the last word the host may read a checksum: the sum of the command byte and all words, modulo 65536.  `words`
accepts only values that the manual allows a host to *send*; to send other words, compose them yourself.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import zip_longest
from math import isfinite
from typing import NamedTuple

from ...core.datasheet.command_rows import PacketRow
from ...core.datasheet.table import Arg, Bits, Sheet
from ...core.messages.near import hint, near
from ...core.messages.whole import whole
from ...errors import UnknownName, UsageError
from .. import rates
from ..dialect import Command, Dialect, Refusal, digits_meant, spoken_as

DIRECTS = ("wait", "expect")  # lines that start with this direct a script's host, like lines with @
WORD = 1 << 16
_NUMBER = re.compile(r"([+-]?)(?:0[xX]|\$)([0-9a-fA-F]+)|[+-]?[0-9]+")
MOST_MEANT = 3  # commands that a message suggests
LONGEST = 40  # characters of a number or a mnemonic that are read; no valid one is longer


@dataclass(frozen=True, slots=True)
class PacketCommand(Command):
    """A valid packet, parsed from a line."""

    row: PacketRow


class Sibling(NamedTuple):
    """A command of a sister part.

    Attributes:
        name: the name of the command.
        writes: the number of words that a host writes for it.
        reads: the number of words that a host reads from the part.
        of: the name of the sister part.
    """

    name: str
    writes: int
    reads: int
    of: str


@dataclass(frozen=True, eq=False)
class Words(Dialect[PacketRow]):
    """The data of the packets dialect, without its methods; the subclass `Packets` documents the attributes."""

    row_type = PacketRow

    illegal: frozenset[int]
    reserved: frozenset[int]
    siblings: Mapping[int, Sibling]
    version: int
    status: tuple[Bits, ...]
    mode: tuple[Bits, ...]
    slips: Mapping[str, str] = field(default_factory=dict)
    where: str = ""


# ------------------------------------------------------------------------------------------------------ words, checksum
def words(row: PacketRow, values: Sequence[int]) -> tuple[int, ...]:
    """Return the words that a host writes after the command byte.

    Raises:
        UsageError: there are too few or too many values, or one is out of range; the message states the allowed values.
    """
    if len(values) != len(row.args):
        raise UsageError(f"{row.name} takes {row.takes}, not {len(values)} values")
    found = []
    for arg, value in zip(row.args, values, strict=True):
        number = whole(value)
        if number is None or not arg.allows(number):
            meant = (
                f"; {_scaled(arg, repr(value))}"
                if isinstance(value, float) and arg.fraction and isfinite(value)
                else ""
            )
            kind = "" if number is not None else "a whole number, "
            allowed = f"{kind}{arg.low}..{arg.high} ({row.where})"
            raise UsageError(f"{row.name} {arg.name} {value!r}: allowed {allowed}{meant}")
        found.append(number)
    data = row.pack(found)[1:]
    return tuple(int.from_bytes(data[at : at + 2], "big") for at in range(0, len(data), 2))


def numbers(
    sheet: Sheet, row: PacketRow, values: Sequence[int | str], crystal_hz: int | None = None
) -> tuple[int, ...]:
    """Return a command's values as numbers; a rate given as text ("12345 steps/s") becomes a register value.

    Raises:
        UsageError: a text is not a rate, or its unit does not belong to this register.
    """
    found = []
    for arg, value in zip_longest(row.args, values):
        if isinstance(value, str):
            rate = (
                rates.spoken(arg, value, rates.cycles_per_s(sheet, crystal_hz))
                if arg is not None and arg.cycles
                else None
            )
            if rate is None:
                takes = f"a number, or a rate in {rates.units(arg)}" if arg and arg.cycles else "a number"
                raise UsageError(f"{row.name} {value!r}: expected {takes}")
            value = rate
        found.append(value)
    return tuple(found[: len(values)])


def values(args: Iterable[Arg], found: Sequence[int]) -> tuple[int, ...]:
    """Return the signed numbers contained in words from the chipset.

    `args` is the layout of the words: the `reads` of a command's row.
    """
    data = b"".join(word.to_bytes(2, "big") for word in found)
    result, at = [], 0
    for arg in args:
        result.append(arg.unpack(data[at : at + arg.size], "big"))
        at += arg.size
    return tuple(result)


def counted(args: Iterable[Arg]) -> int:
    """Return the number of words that hold the values of `args`."""
    return sum(arg.size for arg in args) // 2


def checksum(code: int, sent: Iterable[int]) -> int:
    """Return a packet's checksum, over its command byte and all its words, both written and returned."""
    return (code + sum(sent)) % WORD


# ------------------------------------------------------------------------------------------------- words about an axis
def fields(word: int, bits: Iterable[Bits]) -> dict[str, int]:
    """Return the values of the fields in a status or mode word, keyed by the name of the field."""
    return {each.name: each.of(word) for each in bits}


def shown(word: int, bits: Iterable[Bits]) -> str:
    """Return a status or mode word as text: the names of bits that are 1, and nonzero fields with their values."""
    found = [(each, each.of(word)) for each in bits]
    return " ".join(f"{each.name}={value}" if each.width > 1 else each.name for each, value in found if value)


def status_bit(sheet: Sheet, name: str) -> Bits:
    """Return the status word bit with the given name.

    Raises:
        UnknownName: there is no such bit; the message lists the bits.
    """
    bits = {each.name: each for each in spoken_as(sheet, Words).status if each.width == 1}
    try:
        return bits[name.lower()]
    except KeyError:
        message = f"{sheet.part} has no status bit {name!r}; allowed {', '.join(bits)}"
        raise UnknownName(message + hint(name, bits)) from None


# ------------------------------------------------------------------------------------------------------------- commands
def row(sheet: Sheet, name: str) -> PacketRow:
    """Return the row of the command with the given mnemonic; case is ignored.

    Raises:
        UnknownName: the part has no such command; the message contains a suggestion.
        UsageError: a code was given instead of a mnemonic.
    """
    if not isinstance(name, str):
        raise UsageError(f"command {name!r}: expected a mnemonic such as 'GET_STATUS'; to send a code, use packet()")
    found = sheet.rows(PacketRow).by_form.get(name.upper())
    if found is None:
        refusal = _unknown(sheet, name)
        raise UnknownName(f"{refusal.found}; {refusal.remedy}")
    return found


def command(sheet: Sheet, text: str, crystal_hz: int | None = None) -> PacketCommand:
    """Parse a line as a command of this part: a mnemonic, followed by a number if the command takes one.

    The register value of a rate per second depends on the crystal.

    Raises:
        UsageError: the line is not a command; the message states the allowed values.
    """
    found = parse(sheet, text, crystal_hz)
    if isinstance(found, Refusal):
        allowed = f": allowed {found.allowed}" if found.allowed else ""
        raise UsageError(f"{found.found}{allowed}{f'; {found.remedy}' if found.remedy else ''}")
    return found


def parse(sheet: Sheet, text: str, crystal_hz: int | None = None) -> PacketCommand | Refusal:
    """Parse a line as a command of this part, or return a `Refusal` that has the problem's place."""
    name = "".join(text.split(maxsplit=1)[:1])
    known = sheet.rows(PacketRow).by_form.get(name.upper())
    if known is None:
        return _unknown(sheet, name)
    rest = text.lstrip()[len(name) :]
    at = len(text) - len(rest.lstrip())
    if "/" in rest and known.args and known.args[0].cycles:
        return _rate(known, text, at, rates.cycles_per_s(sheet, crystal_hz))
    return _arguments(known, text, at)


def spell(row: PacketRow, values: Sequence[int]) -> str:
    """Return the text of a command."""
    return " ".join([row.form, *(arg.spell(value) for arg, value in zip(row.args, values, strict=True))])


def usage(row: PacketRow) -> str:
    """Return the syntax of a command: "SET_POS <position>"."""
    return " ".join([row.form, *(f"<{arg.name}>" for arg in row.args)])


def range_of(arg: Arg) -> str:
    """Return the allowed values of an argument, with their unit: "0..1073741823 (2^-16 steps/cycle)"."""
    unit = f"2^-{arg.fraction} {arg.unit}" if arg.fraction else arg.unit
    return f"{arg.low}..{arg.high}{f' ({unit})' if unit else ''}"


def number(text: str, arg: Arg) -> int | None:
    """Return the value of a text that is a decimal or hexadecimal number; None if the text is not a number.

    A hexadecimal number may be the two's complement of a negative number.
    """
    match = _NUMBER.fullmatch(text)
    if match is None:
        return None
    sign, digits = match.groups()
    if len(text) > LONGEST:
        return -arg.modulus if text[0] == "-" else arg.modulus
    value = int(text) if digits is None else int(sign + digits, 16)
    negative = arg.low < 0 and value > arg.high and arg.modulus // 2 <= value < arg.modulus
    return value - arg.modulus if digits and negative else value


def _rate(row: PacketRow, text: str, at: int, per_s: Fraction) -> PacketCommand | Refusal:
    """Return the command in a line whose rate, with a unit, begins at character `at`.

    Return a refusal if the rate is not valid.
    """
    arg, written = row.args[0], text[at:].rstrip()
    message = written if len(written) <= LONGEST else f"{written[:LONGEST]}..."
    try:
        value = rates.spoken(arg, written, per_s)
    except UsageError as error:
        return _refusal("range", at, at + len(written), f"{row.name} {error}")
    if value is None:
        remedy = f"write a decimal number with {rates.units(arg)} after it"
        return _refusal("bad-number", at, at + len(written), f"{row.name} {arg.name} {message}", range_of(arg), remedy)
    return PacketCommand(row, (value,), 0, b"", spell(row, (value,)))


def _arguments(row: PacketRow, text: str, at: int) -> PacketCommand | Refusal:
    """Return the command in a line whose number, if any, begins at character `at`.

    Return a refusal if the number is missing or not allowed, or if more text follows.
    """
    found = text[at:].split()
    if len(found) > len(row.args):
        first = text.index(found[len(row.args)], at + sum(map(len, found[: len(row.args)])))
        message, remedy = (
            f"{text[first:]} after {row.name}, which takes {row.takes}",
            f"leave out {text[first:]}; write one command per line",
        )
        return _refusal("extra-argument", first, len(text), message, "", remedy)
    if len(found) < len(row.args):
        arg = row.args[0]
        return _refusal("missing-argument", len(text), len(text) + 1, f"{row.name} without {arg.name}", range_of(arg))
    if not found:
        return PacketCommand(row, (), 0, b"", row.form)
    arg, written = row.args[0], found[0]
    value, end = number(written, arg), at + len(written)
    message = f"{row.name} {arg.name} {written if len(written) <= LONGEST else f'{written[:LONGEST]}...'}"
    if value is None:
        return _refusal("bad-number", at, end, message, range_of(arg), _number_meant(arg, written))
    if not arg.allows(value):
        nearest = min(max(value, arg.low), arg.high)
        return _refusal("range", at, end, message, range_of(arg), f"the nearest is {nearest}")
    return PacketCommand(row, (value,), 0, b"", spell(row, (value,)))


def _refusal(code: str, at: int, end: int, found: str, allowed: str = "", remedy: str = "") -> Refusal:
    return Refusal(code, found, at, end, found, allowed, remedy)


def _number_meant(arg: Arg, written: str) -> str:
    """Return the remedy for a text that is not a number: the number probably meant, or how to write one."""
    if meant := digits_meant(written):
        return meant
    if re.fullmatch(r"[0-9a-fA-F]{1,8}[hH]?", written):
        return f"hexadecimal is written 0x{written.rstrip('hH').upper()}"
    if arg.fraction and re.fullmatch(r"[+-]?[0-9]{0,9}\.[0-9]{1,9}", written):
        return _scaled(arg, written)
    if re.fullmatch(r"[+-]?[0-9][0-9_,']*", written):
        return "write the digits without separators"
    return "write decimal digits, or hexadecimal ones after 0x or $"


def _scaled(arg: Arg, written: str) -> str:
    """Return a remedy for a decimal fraction written as an argument: the register value of that fraction."""
    scaled = Fraction(written) * (1 << arg.fraction)
    whole = "" if scaled.denominator == 1 else f"{float(scaled):.8g}, not a whole number; the nearest is "
    return f"{written} {arg.unit} is {whole}{round(scaled)}"


def _unknown(sheet: Sheet, name: str) -> Refusal:
    """Return the refusal of a mnemonic that the part does not have; its remedy suggests how to continue."""
    wanted, slips = name.upper(), spoken_as(sheet, Words).slips
    tail = wanted.partition("_")[2] or wanted
    close = near(wanted, sheet.commands.by_form)[:MOST_MEANT]
    alike = [form for form in sheet.commands.by_form if tail and form.partition("_")[2] == tail]
    spelled_out = [form for form in sheet.commands.by_form if wanted.startswith(form)]
    sibling = next((each for each in spoken_as(sheet, Words).siblings.values() if each.name == wanted), None)
    if wanted in sheet.foreign:
        remedy = "a part with more axes has this command"
    elif sibling is not None:
        remedy = f"it is a command of {sibling.of} and has no effect here; leave it out"
    elif meant := [slips[wanted]] if wanted in slips else close or alike or spelled_out:
        remedy = f"write {' or '.join(meant)}"
    else:
        remedy = f"slewline describe {sheet.part} lists the commands"
    shown = name if len(name) <= LONGEST else f"{name[:LONGEST]}..."
    return _refusal(
        "unknown-command", 0, len(name), f"{shown} is not a command of the {sheet.part.upper()}", "", remedy
    )
