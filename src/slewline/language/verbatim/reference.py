"""The reference of commands that are kept as they are written: how each is written, in text and in binary."""

from __future__ import annotations

from ...core.datasheet.table import Arg, Row, Sheet
from ..dialect import spoken_as
from ..markdown import mhz, source, table
from .forms import Forms


def spoken_by(sheet: Sheet) -> Forms:
    """Return the dialect of a sheet."""
    return spoken_as(sheet, Forms)


def usage(row: Row, spoken: Forms) -> str:
    """Return how a command is written: `L count,target`."""
    if row.form == spoken.query:
        return f"{row.form} letter"
    if row.form == spoken.quote:
        return f"{row.form}characters{row.form}"
    if row.form == spoken.display:
        return f"{row.form}address,count,data..."
    return f"{row.form} {','.join(arg.name for arg in row.args)}".rstrip()


def binary(row: Row, spoken: Forms) -> str:
    """Return how it is sent in binary: letter, count, data, low bytes first."""
    letter = f"{row.code:02X}"
    if not row.terminated:
        return letter
    others = {spoken.query: "letter", spoken.quote: "characters", spoken.display: "address count data..."}
    if row.form in others:
        return f"{letter} bytes {others[row.form]}"
    return f"{letter} {row.data_bytes:02X} {' '.join(map(_bytes_of, row.args))}".rstrip()


def _bytes_of(arg: Arg) -> str:
    names = {1: ("",), 2: (".low", ".high"), 3: (".low", ".middle", ".high")}[arg.size]
    return " ".join(arg.name + name for name in names)


def _range(arg: Arg) -> str:
    return f"{arg.low}..{arg.high}{f' ({arg.unit})' if arg.unit else ''}"


def command_table(sheet: Sheet) -> str:
    """Return all commands as a table."""
    spoken = spoken_by(sheet)
    heads = ("ASCII", "name", "what it does", "arguments", "binary", "manual")
    rows = [
        (
            f"`{usage(row, spoken)}`",
            row.name,
            row.says,
            "; ".join(f"{arg.name} {_range(arg)}" for arg in row.args),
            f"`{binary(row, spoken)}`",
            source(row),
        )
        for row in sheet.commands
    ]
    return table(heads, rows)


def in_full(sheet: Sheet, row: Row) -> str:
    """Return all about a command."""
    spoken = spoken_by(sheet)
    ends = ", then a carriage return" if row.terminated else ", without a carriage return"
    time = f"{row.time_us} µs after the last byte" if not row.motion else "as long as the motion"
    text = [
        f"# {row.name}: {row.says}",
        "",
        f"- ASCII: `{usage(row, spoken)}`{ends}",
        f"- binary: `{binary(row, spoken)}`",
        f"- program memory: {'as it was sent' if row.stored else 'not stored'}",
        f"- time at {mhz(sheet.crystal_hz)} MHz: {time}",
        f"- manual: {source(row)}",
    ]
    text += [f"- `{arg.name}`: {_range(arg)}, {arg.size} byte{'s' * (arg.size > 1)}" for arg in row.args]
    if row.form in spoken.negated:
        text.append(f"- `{spoken.negate}` in front inverts bit {spoken.flips.bit_length() - 1} of the first argument")
    if row.form == spoken.query:
        digits = ", ".join(f"{letter} ({count} digits)" for letter, count in spoken.queries.items())
        text.append(f"- letters: {digits}; `{spoken.listing},n`: n lines of the memory")
    return "\n".join(text) + "\n"


def chapters(sheet: Sheet) -> list[str]:
    """Return how numbers are written."""
    spoken = spoken_by(sheet)
    return [
        "## Numbers\n\nDecimal (`135`) or hexadecimal, with a leading digit and a trailing `H` (`87H`, `0ABH`); "
        f"between two of them a comma or a space. `{spoken.switches}` for the first one reads thumbwheel switches. "
        f"`{spoken.negate}` in front of {', '.join(spoken.negated)} inverts bit {spoken.flips.bit_length() - 1} of the "
        "first argument. Both are for text only."
    ]
