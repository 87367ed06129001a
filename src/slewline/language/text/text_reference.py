"""The reference pages for commands: how each is written, sent and stored, in text and in binary."""

from __future__ import annotations

from ...core.datasheet.command_rows import TextRow
from ...core.datasheet.table import Arg, Sheet
from ..dialect import spoken_as
from ..markdown import mhz, source, table
from .forms import TextDialect


def usage(row: TextRow, spoken: TextDialect) -> str:
    """Return the syntax of a command in ASCII, such as `L count,target`."""
    others = {spoken.query: " letter", spoken.quote: f"characters{row.form}", spoken.display: "address,count,data..."}
    return f"{row.form}{others.get(row.form) or ' ' + ','.join(arg.name for arg in row.args)}".rstrip()


def binary(row: TextRow, spoken: TextDialect) -> str:
    """Return, as text, how a command is sent in binary: letter, count, data (the low byte of a number first)."""
    letter = f"{spoken.byte(row):02X}"
    if not row.terminated:
        return letter
    others = {spoken.query: "letter", spoken.quote: "characters", spoken.display: "address count data..."}
    if row.form in others:
        return f"{letter} bytes {others[row.form]}"
    return f"{letter} {row.data_bytes:02X} {_data(row)}".rstrip()


def stored(row: TextRow) -> str:
    """Return the bytes of a command in the program buffer, as text; empty if the command is not stored."""
    return f"{row.code:02X} {_data(row)}".rstrip() if row.stored else ""


def _data(row: TextRow) -> str:
    parts = {1: ("",), 2: (".low", ".high"), 3: (".low", ".middle", ".high")}
    return " ".join(arg.name + part for arg in row.args for part in parts[arg.size])


def _range(sheet: Sheet, arg: Arg) -> str:
    label = f" or a label {sheet.labels[0]}..{sheet.labels[-1]}" if arg.label and sheet.labels else ""
    return f"{arg.low}..{arg.high}{label}{f' ({arg.unit})' if arg.unit else ''}"


def _bytes(count: int) -> str:
    return f"{count} byte{'s' if count != 1 else ''}"


def _busy(row: TextRow) -> str:
    if row.motion:
        return f"{row.time_us} µs and the motion"
    return f"{row.time_us} µs{' and the conversion of the digits' if row.args else ''}"


def in_full(sheet: Sheet, row: TextRow) -> str:
    """Return the full description of a command, in Markdown: forms, arguments, times, sources."""
    spoken = spoken_as(sheet, TextDialect)
    if spoken.tokens:
        place, kept = "buffer", f"{_bytes(row.size)}, `{stored(row)}`"
        time = _busy(row) + (f"; {row.program_us} µs in a program" if row.stored else "")
    else:
        place, kept = "memory", "as it was sent"
        time = f"{row.time_us} µs after the last byte" if not row.motion else "as long as the motion"
    text = [
        f"# {row.name}: {row.description}",
        "",
        f"- ASCII: `{usage(row, spoken)}`, {'then a' if row.terminated else 'without a'} carriage return",
        f"- binary: `{binary(row, spoken)}`",
        f"- program {place}: {kept if row.stored else 'not stored'}",
        f"- time at {mhz(sheet.crystal_hz)} MHz: {time}",
        f"- manual: {source(row)}",
    ]
    text += [f"- `{arg.name}`: {_range(sheet, arg)}, {_bytes(arg.size)}" for arg in row.args]
    if spoken.tokens and row.form in sheet.slips:
        text.append(f"- {sheet.slips[row.form]}")
    if row.form in spoken.negated:
        text.append(f"- `{spoken.negate}` in front inverts bit {spoken.flips.bit_length() - 1} of the first argument")
    if row.form == spoken.query:
        digits = ", ".join(f"{letter} ({count} digits)" for letter, count in spoken.queries.items())
        text.append(f"- letters: {digits}; `{spoken.listing},n`: n lines of the memory")
    return "\n".join(text) + "\n"


def labels_in_full(sheet: Sheet) -> str:
    """Return the full description of labels, in Markdown: how they are written and used."""
    spoken, first, last = spoken_as(sheet, TextDialect), sheet.labels[0], sheet.labels[-1]
    branch = next((row.form for row in sheet.commands if row.flow == "t" and row.args), "")
    used = ", ".join(row.form for row in sheet.commands if any(arg.label for arg in row.args))
    text = [
        "# LABEL: names the next instruction",
        "",
        f"- ASCII: `{spoken.label(first)}` to `{spoken.label(last)}`, "
        "directly in front of the instruction, without a carriage return",
        "- binary: none; binary programs branch to addresses",
        "- program buffer: no bytes",
        f"- branches to it: {used}, with the letter alone, such as `{branch} {first}`",
        f"- manual: {sheet.sections.get('labels in full', '')}",
    ]
    return "\n".join(text) + "\n"


def command_table(sheet: Sheet) -> str:
    """Return the table of commands of a part, in Markdown."""
    spoken = spoken_as(sheet, TextDialect)
    stored_as, time = (["buffer"], ["µs"]) if spoken.tokens else ([], [])
    heads = ("ASCII", "name", "function", "arguments", *stored_as, "binary", *time, "manual")
    rows = [
        (
            f"`{usage(row, spoken)}`",
            row.name,
            row.description,
            "; ".join(f"{arg.name} {_range(sheet, arg)}" for arg in row.args),
            *(f"{row.size}: `{stored(row)}`" if row.stored else "0" for _ in stored_as),
            f"`{binary(row, spoken)}`",
            *(row.time_us for _ in time),
            source(row),
        )
        for row in sheet.rows(TextRow)
    ]
    note = "The time is that of the last byte of the command, without conversion and motion."
    return f"{table(heads, rows)}\n\n{note}" if time else table(heads, rows)


def chapters(sheet: Sheet) -> list[str]:
    """Return a list with the chapter on how numbers are written, in Markdown."""
    spoken = spoken_as(sheet, TextDialect)
    return [
        "## Numbers\n\nDecimal (`135`) or hexadecimal, with a leading digit and a trailing `H` (`87H`, `0ABH`); "
        f"separated by a comma or a space. `{spoken.switches}` for the first one reads thumbwheel switches. "
        f"`{spoken.negate}` in front of {', '.join(spoken.negated)} inverts bit {spoken.flips.bit_length() - 1} of the "
        "first argument. Both are for text only."
    ]
