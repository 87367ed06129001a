"""The data sheet as Markdown: what `slewline describe` prints, and a generated page of the documentation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ..core.table import Arg, Port, Row, Sheet
from ..errors import UnknownName
from . import lines
from .assemble import units
from .dialects import Command

LEVEL = {0: "low", 1: "high", None: ""}
OWN = "Opcodes are the model's own: the sheet gives none. A carriage return ends a line."
SECTIONS = "; s. is a section, T. a table of it"
STATES = {"i": "idle", "p": "during program entry", "r": "while a program runs"}


def describe(sheet: Sheet, command: str | None = None) -> str:
    """The whole sheet, or a single command by its letter or name, all forms of it.

    Raises:
        UnknownName: the part has no such command; the message lists those that it has.
    """
    if command is not None:
        return describe_command(sheet, command)
    commands = f"## Commands\n\n{line_table(sheet.commands)}\n\n{OWN}" if sheet.in_lines else _commands(sheet)
    port = _port(sheet.port) if sheet.port is not None else ""
    parts = [_head(sheet), commands, port, _pins(sheet), _registers(sheet), _times(sheet)]
    return "\n\n".join(part for part in parts if part) + "\n"


def describe_command(sheet: Sheet, command: str) -> str:
    """One command in full: how it is written, sent and stored, what it takes, how long it lasts."""
    in_full = _line_in_full if sheet.in_lines else _in_full
    return "\n".join(in_full(sheet, row) for row in find(sheet, command))


def _in_full(sheet: Sheet, row: Row) -> str:
    text = [
        f"# {row.name}: {row.says}",
        "",
        f"- ASCII: `{usage(row)}`{', then a carriage return' if row.terminated else ', without a carriage return'}",
        f"- binary: `{binary(row)}`",
        f"- program buffer: {f'{_bytes(row.size)}, `{stored(row)}`' if row.stored else 'not stored'}",
        f"- time at {_mhz(sheet.crystal_hz)} MHz: {_busy(row)}"
        + (f"; {row.program_us} µs in a program" if row.stored else ""),
        f"- manual: {row.where}",
    ]
    text += [f"- `{arg.name}`: {_range(sheet, arg)}, {_bytes(arg.size)}" for arg in row.args]
    return "\n".join(text) + "\n"


def _line_in_full(sheet: Sheet, row: Row) -> str:
    room = f"{row.size} {units(sheet)}, opcode {_opcodes(row)}" if row.stored else "not stored"
    text = [
        f"# {row.name}: {row.says}",
        "",
        f"- line: `{lines.usage(row)}`",
        f"- taken: {_taken(row)}",
        f"- program memory: {room}",
        f"- manual: {row.where}",
    ]
    text += [f"- `{arg.name}`: {_limits(arg)}" for arg in row.args]
    return "\n".join(text) + "\n"


def find(sheet: Sheet, command: str) -> list[Row]:
    """The rows of a command, by letter (all forms of it), by name, or by a line that is one.

    Raises:
        UnknownName: the part has no such command; the message lists those that it has.
    """
    for wanted in (command, command.upper()):
        rows = [row for row in sheet.commands if wanted in (row.form, row.name, row.head)]
        if rows:
            return rows
    line = lines.parse(sheet, command) if sheet.in_lines else None
    if isinstance(line, Command):
        return [line.row]
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


def _limits(arg: Arg) -> str:
    unit = f" ({arg.unit})" if arg.unit else ""
    return f"{lines.range_of(arg)}{unit}{', may be left out' if arg.optional else ''}"


def _opcodes(row: Row) -> str:
    first, last = row.codes[0], row.codes[-1]
    return f"{first:02X}" if first == last else f"{first:02X} to {last:02X}"


def _taken(row: Row) -> str:
    """In which states it acts at once; a stored one is kept for the program during program entry."""
    found = [STATES[state] for state in row.when] + (["into the program"] if row.stored else [])
    return ", ".join(found)


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
    text = [f"# {sheet.title}", "", f"- source: {sheet.manual}{'' if sheet.in_lines else SECTIONS}"]
    if sheet.crystal_high_hz:
        at = f"times below hold at {_mhz(sheet.crystal_hz)} MHz unless another is named"
        text.append(f"- crystal: {low} to {high} MHz; {at}")
    text.append(f"- program buffer: {sheet.buffer_bytes} {units(sheet)}")
    if sheet.labels:
        text.append(f"- labels: {', '.join(f'`{letter}$`' for letter in sheet.labels)}, in ASCII programs")
    text += [f"- {name}: {says}" for name, says in sheet.notes.items()]
    return "\n".join(text)


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


def line_table(commands: Iterable[Row]) -> str:
    """Commands that are lines, as a table."""
    heads = ("line", "name", "what it does", "arguments", "locations", "opcode", "taken", "manual")
    rows = [
        (
            f"`{lines.usage(row)}`",
            row.name,
            row.says,
            "; ".join(f"{arg.name} {_limits(arg)}" for arg in row.args),
            row.size,
            _opcodes(row) if row.stored else "",
            _taken(row),
            row.where,
        )
        for row in commands
    ]
    return table(heads, rows)


def _port(port: Port) -> str:
    """The serial port: format, rates, addresses, answers."""
    format_ = f"{port.bits} data bits, {port.parity} parity, {port.stop} stop bits"
    longest = f"; lines of up to {port.longest} characters" if port.longest else ""
    check = f"; checksums while `{port.checksum_pin}` is high" if port.checksum_pin else ""
    parts = [f"## Serial port\n\n{format_}{longest}{check}. Source: {port.where}."]
    for names, what, entries in ((port.baud_pins, "baud", port.bauds), (port.address_pins, "address", port.addresses)):
        if names:
            rows = [(*levels, value or "none: a line of its own") for levels, value in entries.items()]
            parts.append(table((*(f"`{name}`" for name in names), what), rows))
    if port.answers:
        parts.append(table(("answer", "meaning"), ((f"`{answer}`", says) for answer, says in port.answers.items())))
    return "\n\n".join(parts)


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
    clocks: tuple[str, ...] = ("at MHz", "clocks") if sheet.crystal_high_hz else ()
    heads = ("time", "what it is", "µs", *clocks, "manual", "trust")
    rows = [
        (
            f"`{name}`",
            time.says,
            f"{time.us:.10g}",
            *((f"{time.mhz:g}", time.ticks) if clocks else ()),
            time.where,
            time.trust,
        )
        for name, time in sheet.times.items()
    ]
    note = "Trust: *stated* by the manual, *derived* from what it states, or *chosen* where it is silent."
    return f"## Times\n\n{table(heads, rows)}\n\n{note}" if rows else ""


def table(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(str(cell).replace('|', chr(92) + '|') for cell in line)} |" for line in lines)
