"""A command as a decoder returns it, and as a host writes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from ...core.datasheet.command_rows import TextRow
from ...core.datasheet.table import Row
from ..dialect import Command

CR, LF, OPEN_BUS = 0x0D, 0x0A, 0xFF
NO_NAMES: Mapping[int, str] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Label:
    """A label mark, which names the instruction after it."""

    letter: str


@dataclass(frozen=True, slots=True)
class CommandText(Command):
    """A command; `data` contains anything other than numbers: a string's characters, or a query's letter.

    `switched`: the first value comes from switches.  `flips`: the bits of the first value that a prefix
    inverts.
    """

    row: TextRow
    data: bytes = b""
    switched: bool = False
    flips: int = 0


def spell(row: Row, shown: Sequence[int | str]) -> str:
    """Return a command as a host writes it: "R 100", "L 3,B"."""
    return f"{row.form} {','.join(map(str, shown))}" if shown else row.form


def letters_for(row: Row, values: Sequence[int], labels: str, names: Mapping[int, str] = NO_NAMES) -> list[int | str]:
    """Return a command's values, with letters in place of label codes and of addresses that have names.

    `labels` are the letters that can be labels; `names` are the letters of named addresses, keyed by
    address.
    """
    return [
        names.get(value) or (chr(value) if chr(value) in labels else value) if arg.label else value
        for arg, value in zip(row.args, values, strict=True)
    ]
