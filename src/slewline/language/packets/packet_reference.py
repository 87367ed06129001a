"""The reference pages for commands that are packets, and for an axis's status and mode words."""

from __future__ import annotations

from collections.abc import Iterable

from ...core.datasheet.command_rows import PacketRow
from ...core.datasheet.table import Arg, Bits, Sheet
from ..markdown import mhz, table
from . import packet_grammar

BUFFERED, WITH_ENCODER = "takes effect at the next update", "needs an encoder; other parts accept it"
CHECKSUM = "A checksum of 16 bits may be read after every packet: the sum of command byte and words."


def packet_in_full(sheet: Sheet, row: PacketRow) -> str:
    """Return the full description of a command, in Markdown: its words, times and sources."""
    text = [
        f"# {row.name}: {row.description}",
        "",
        f"- line: `{packet_grammar.usage(row)}`",
        f"- packet: `{packet(row)}`",
        f"- acts on: {_acted_on(row)}",
        f"- busy at {mhz(sheet.crystal_hz)} MHz: for {row.time_us} µs after the command and after each word",
        f"- manual: {row.where}",
    ]
    text += [f"- `{arg.name}`: {packet_grammar.range_of(arg)}" for arg in (*row.args, *row.reads)]
    text += [f"- {condition}" for condition in _conditions(row)]
    return "\n".join(text) + "\n"


def packet(row: PacketRow) -> str:
    """Return a packet as text: the code, the words that the host writes and, in brackets, the words returned."""
    returned = " ".join(_halves(row.reads))
    return " ".join([f"{row.code:02X}", *_halves(row.args), *([f"[{returned}]"] if returned else [])])


def _halves(args: Iterable[Arg]) -> list[str]:
    """Return the names of the words that hold arguments; for an argument of two words, the high word is first."""
    return [part for arg in args for part in ([arg.name] if arg.size == 2 else [f"{arg.name}.high", f"{arg.name}.low"])]


def _acted_on(row: PacketRow) -> str:
    """Return a text that states on which axes a command acts."""
    axes = {"set": "the axis that it sets", "mask": "the axes in its mask", "global": "all axes"}
    return axes.get(row.acts, f"the {row.acts} axis")


def _conditions(row: PacketRow) -> list[str]:
    return [*([BUFFERED] if row.buffered else []), *([WITH_ENCODER] if row.encoder else [])]


def packet_table(sheet: Sheet) -> str:
    """Return a table of commands that are packets, in Markdown, followed by a remark about the checksum."""
    heads = ("packet", "name", "function", "numbers", "acts on", "condition")
    rows = [
        (
            f"`{packet(row)}`",
            row.name,
            row.description,
            "; ".join(f"{arg.name} {packet_grammar.range_of(arg)}" for arg in (*row.args, *row.reads)),
            _acted_on(row),
            "; ".join(_conditions(row)),
        )
        for row in sheet.rows(PacketRow)
    ]
    return f"{table(heads, rows)}\n\n{CHECKSUM}"


def words_of(dialect: packet_grammar.Words) -> list[str]:
    """Return chapters in Markdown: status word, mode word, version word, and codes that are not commands."""
    return [
        f"## Status word\n\n{_fields(dialect.status)}",
        f"## Mode word\n\n{_fields(dialect.mode)}",
        f"## Version word\n\n`{dialect.version:04X}`",
        f"## Other codes\n\n{table(('codes', 'effect'), _other_codes(dialect))}\n\nSource: {dialect.where}.",
    ]


def _fields(bits: Iterable[Bits]) -> str:
    rows = (
        (
            f"{each.low}" if each.width == 1 else f"{each.low}-{each.low + each.width - 1}",
            f"`{each.name}`",
            each.description,
        )
        for each in bits
    )
    return table(("bit", "name", "meaning"), rows)


def _other_codes(dialect: packet_grammar.Words) -> list[tuple[str, str]]:
    """Return codes that are not commands of the part, and their effects."""
    alike = {(1, 0): "a word is read", (0, 1): "a word is returned, 0", (0, 0): "no data"}
    rows = [
        (
            _codes(code for code, found in dialect.siblings.items() if (found.writes, found.reads) == words),
            f"a sister part's; no effect, {condition}",
        )
        for words, condition in alike.items()
    ]
    return [
        (_codes(dialect.illegal), "illegal: checksum 0"),
        (_codes(dialect.reserved), "reserved: no effect"),
        *rows,
        ("the others", "not documented: no effect, no data"),
    ]


def _codes(codes: Iterable[int]) -> str:
    """Return codes in hexadecimal, with consecutive codes combined into ranges such as "10-1F"."""
    found = sorted(codes)
    runs = [code for code in found if code - 1 not in found], [code for code in found if code + 1 not in found]
    return ", ".join(f"{one:02X}" if one == two else f"{one:02X}-{two:02X}" for one, two in zip(*runs, strict=True))
