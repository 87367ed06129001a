"""The reference of commands in letters: how each is written, sent and stored, in text and in binary."""

from __future__ import annotations

from ...core.datasheet.table import Arg, Row, Sheet
from ..dialect import dialect_of
from ..markdown import mhz, source, table


def in_full(sheet: Sheet, row: Row) -> str:
    """Return all that is known of a command, in Markdown: forms, arguments, times, sources."""
    text = [
        f"# {row.name}: {row.says}",
        "",
        f"- ASCII: `{usage(row)}`{', then a carriage return' if row.terminated else ', without a carriage return'}",
        f"- binary: `{binary(row)}`",
        f"- program buffer: {f'{_bytes(row.size)}, `{stored(row)}`' if row.stored else 'not stored'}",
        f"- time at {mhz(sheet.crystal_hz)} MHz: {_busy(row)}"
        + (f"; {row.program_us} µs in a program" if row.stored else ""),
        f"- manual: {source(row)}",
    ]
    text += [f"- `{arg.name}`: {_range(sheet, arg)}, {_bytes(arg.size)}" for arg in row.args]
    text += [f"- {sheet.slips[row.form]}"] if row.form in sheet.slips else []
    return "\n".join(text) + "\n"


def labels_in_full(sheet: Sheet) -> str:
    """Return how labels are written and used, in Markdown."""
    dialect, first, last = dialect_of(sheet), sheet.labels[0], sheet.labels[-1]
    branch = next((row.form for row in sheet.commands if row.flow == "t" and row.args), "")
    used = ", ".join(row.form for row in sheet.commands if any(arg.label for arg in row.args))
    text = [
        "# LABEL: names the instruction that follows",
        "",
        f"- ASCII: `{dialect.label(first)}` to `{dialect.label(last)}`, "
        "directly in front of the instruction, without a carriage return",
        "- binary: none; binary programs branch to addresses",
        "- program buffer: no room",
        f"- branches to it: {used}, with the letter alone, such as `{branch} {first}`",
        f"- manual: {sheet.sections.get('labels in full', '')}",
    ]
    return "\n".join(text) + "\n"


def usage(row: Row) -> str:
    """How it is written in ASCII: `L count,target`."""
    return f"{row.form} {','.join(arg.name for arg in row.args)}".rstrip()


def binary(row: Row) -> str:
    """How it is sent in binary: letter, count, data, low bytes first."""
    letter = f"{ord(row.form[0]):02X}"
    return f"{letter} {row.data_bytes:02X} {_data(row)}".rstrip() if row.terminated else letter


def stored(row: Row) -> str:
    """How it lies in the program buffer."""
    return f"{row.code:02X} {_data(row)}".rstrip() if row.stored else ""


def _data(row: Row) -> str:
    return " ".join(
        part for arg in row.args for part in ([arg.name] if arg.size == 1 else [f"{arg.name}.low", f"{arg.name}.high"])
    )


def _range(sheet: Sheet, arg: Arg) -> str:
    label = f" or a label {sheet.labels[0]}..{sheet.labels[-1]}" if arg.label and sheet.labels else ""
    return f"{arg.low}..{arg.high}{label}{f' ({arg.unit})' if arg.unit else ''}"


def _busy(row: Row) -> str:
    if row.motion:
        return f"{row.time_us} µs and the motion"
    return f"{row.time_us} µs{' and the conversion of the digits' if row.args else ''}"


def _bytes(count: int) -> str:
    return f"{count} byte{'s' if count != 1 else ''}"


def letter_table(sheet: Sheet) -> str:
    """Return the table of commands of a part, in Markdown."""
    heads = ("ASCII", "name", "what it does", "arguments", "buffer", "binary", "µs", "manual")
    rows = [
        (
            f"`{usage(row)}`",
            row.name,
            row.says,
            "; ".join(f"{arg.name} {_range(sheet, arg)}" for arg in row.args),
            f"{row.size}: `{stored(row)}`" if row.stored else "0",
            f"`{binary(row)}`",
            row.time_us,
            source(row),
        )
        for row in sheet.commands
    ]
    note = "The time is how long the chip is busy with the last byte of the command, without conversion and motion."
    return f"{table(heads, rows)}\n\n{note}"
