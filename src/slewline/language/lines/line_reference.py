"""The reference pages for commands that are lines."""

from __future__ import annotations

from collections.abc import Iterable

from ...core.datasheet.command_rows import LineRow
from ...core.datasheet.table import Arg, Sheet
from ..assemble import units
from ..markdown import table
from . import line_grammar

STATES = {"i": "while idle", "p": "during program entry", "r": "while a program runs"}


def line_in_full(sheet: Sheet, row: LineRow) -> str:
    """Return the full description of a command, in Markdown: syntax, states, opcode, manual section, arguments."""
    room = f"{row.size} {units(sheet)}, opcode {_opcodes(row)}" if row.stored else "not stored"
    text = [
        f"# {row.name}: {row.description}",
        "",
        f"- line: `{line_grammar.usage(row)}`",
        f"- accepted: {_taken(row)}",
        f"- program memory: {room}",
        f"- manual: {row.where}",
    ]
    text += [f"- `{arg.name}`: {_limits(arg)}" for arg in row.args]
    return "\n".join(text) + "\n"


def line_table(commands: Iterable[LineRow]) -> str:
    """Return a table of commands that are lines, in Markdown."""
    heads = ("line", "name", "function", "arguments", "locations", "opcode", "taken", "manual")
    rows = [
        (
            f"`{line_grammar.usage(row)}`",
            row.name,
            row.description,
            "; ".join(f"{arg.name} {_limits(arg)}" for arg in row.args),
            row.size,
            _opcodes(row) if row.stored else "",
            _taken(row),
            row.where,
        )
        for row in commands
    ]
    return table(heads, rows)


def _limits(arg: Arg) -> str:
    unit = f" ({arg.unit})" if arg.unit else ""
    return f"{line_grammar.range_of(arg)}{unit}{', optional' if arg.optional else ''}"


def _opcodes(row: LineRow) -> str:
    first, last = row.codes[0], row.codes[-1]
    return f"{first:02X}" if first == last else f"{first:02X} to {last:02X}"


def _taken(row: LineRow) -> str:
    """Return the states in which a command is accepted, as text, with "(stored)" if it can be stored."""
    found = [STATES[state] for state in row.when] + (["during program entry (stored)"] if row.stored else [])
    return ", ".join(found)
