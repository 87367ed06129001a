"""The data sheet as Markdown: what `slewline describe` prints, and a generated page of the documentation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ..core.table import Arg, Row, Sheet
from ..errors import UnknownName

LEVEL = {0: "low", 1: "high", None: ""}


def describe(sheet: Sheet, command: str | None = None) -> str:
    """The whole sheet, or a single command by its letter or name.

    Raises:
        UnknownName: the part has no such command; the message lists those that it has.
    """
    if command is not None:
        return describe_command(sheet, command)
    parts = [_head(sheet), _commands(sheet), _pins(sheet), _registers(sheet), _times(sheet)]
    return "\n\n".join(part for part in parts if part) + "\n"


def describe_command(sheet: Sheet, command: str) -> str:
    """One command in full: how it is written, sent and stored, what it takes, how long it lasts."""
    row = _find(sheet, command)
    lines = [
        f"# {row.name}: {row.says}",
        "",
        f"- ASCII: `{usage(row)}`{', then a carriage return' if row.terminated else ', without a carriage return'}",
        f"- binary: `{binary(row)}`",
        f"- program buffer: {f'{_bytes(row.size)}, `{stored(row)}`' if row.stored else 'not stored'}",
        f"- time at {_mhz(sheet.crystal_hz)} MHz: {_busy(row)}"
        + (f"; {row.program_us} µs in a program" if row.stored else ""),
        f"- manual: {row.where}",
    ]
    lines += [f"- `{arg.name}`: {_range(sheet, arg)}, {_bytes(arg.size)}" for arg in row.args]
    return "\n".join(lines) + "\n"


def _find(sheet: Sheet, command: str) -> Row:
    for row in sheet.commands:
        if command in (row.form, row.name) or command.upper() in (row.form, row.name):
            return row
    letters = ", ".join(f"{row.form} ({row.name})" for row in sheet.commands)
    raise UnknownName(f"{sheet.part} has no command {command!r}; it has {letters}")


# ------------------------------------------------------------------------------------------------------ one command


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


def _mhz(hz: float) -> str:
    return f"{hz / 1e6:g}"


# ------------------------------------------------------------------------------------------------------------- chapters


def _head(sheet: Sheet) -> str:
    low, high = _mhz(sheet.crystal_low_hz), _mhz(sheet.crystal_high_hz)
    lines = [
        f"# {sheet.title}",
        "",
        f"- source: {sheet.manual}; s. is a section, T. a table of it",
        f"- crystal: {low} to {high} MHz; times below hold at {_mhz(sheet.crystal_hz)} MHz unless another is named",
        f"- program buffer: {_bytes(sheet.buffer_bytes)}",
    ]
    if sheet.labels:
        lines.append(f"- labels: {', '.join(f'`{letter}$`' for letter in sheet.labels)}, in ASCII programs")
    lines += [f"- {name}: {text}" for name, text in sheet.notes.items()]
    return "\n".join(lines)


def _commands(sheet: Sheet) -> str:
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
            row.where,
        )
        for row in sheet.commands
    ]
    note = "The time is how long the chip is busy with the last byte of the command, without conversion and motion."
    return f"## Commands\n\n{table(heads, rows)}\n\n{note}"


def _pins(sheet: Sheet) -> str:
    heads = (
        "pin",
        "name",
        "way",
        "what it does",
        "active",
        "open",
        "wire to",
        "after reset",
        "when it is seen",
        "manual",
    )
    rows = [
        (
            pin.number,
            f"`{pin.name}`",
            pin.way,
            pin.says,
            LEVEL[pin.active],
            LEVEL[pin.pull],
            LEVEL[pin.tie],
            LEVEL[pin.reset],
            pin.seen,
            pin.where,
        )
        for pin in sorted(sheet.pins, key=lambda pin: pin.number)
    ]
    return f"## Pins\n\n{table(heads, rows)}" if rows else ""


def _registers(sheet: Sheet) -> str:
    heads = ("register", "what it holds", "loaded by", "bits", "power-up value of the model", "manual")
    rows = [
        (f"`{r.name}`", r.says, f"`{r.letter}`" if r.letter else "", r.bits, r.default, r.where)
        for r in sheet.registers
    ]
    return f"## Registers\n\n{table(heads, rows)}" if rows else ""


def _times(sheet: Sheet) -> str:
    heads = ("time", "what it is", "µs", "at MHz", "clocks", "manual", "trust")
    rows = [
        (f"`{name}`", time.says, f"{time.us:g}", f"{time.mhz:g}", time.ticks, time.where, time.trust)
        for name, time in sheet.times.items()
    ]
    note = "Trust: *stated* by the manual, *derived* from what it states, or *chosen* where it is silent."
    return f"## Times\n\n{table(heads, rows)}\n\n{note}" if rows else ""


def table(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(str(cell).replace('|', chr(92) + '|') for cell in line)} |" for line in lines)
