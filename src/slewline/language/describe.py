"""The data sheet as Markdown: the output of `slewline describe`, and a generated documentation page."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..core.datasheet.channel import AdaptiveLine, FlowBus, SerialLine
from ..core.datasheet.option import Option, flat
from ..core.datasheet.roles import AT_ONCE, AXIS_ROLES, REFLEXES
from ..core.datasheet.table import Pin, Row, Sheet
from .assemble import units
from .dialect import Dialect, dialect_of
from .lookup import find
from .markdown import mhz, source, table

LEVEL = {0: "low", 1: "high", None: ""}


def describe(sheet: Sheet, command: str | None = None) -> str:
    """Return, as Markdown, the whole sheet or all forms of the command with a given letter or name.

    Raises:
        UnknownName: the part has no such command; the message lists its commands.
    """
    if command is not None:
        return describe_command(sheet, command)
    dialect, serial = dialect_of(sheet), sheet.channel(SerialLine)
    commands = f"## Commands\n\n{dialect.table(sheet)}"
    port = _port(serial, dialect) if serial is not None else ""
    tables = (_at_once, _pins, _wires, _registers, _times, _printed, _rates, _options)
    parts = [_head(sheet), commands, port, _sides(sheet), *dialect.chapters(sheet), *(write(sheet) for write in tables)]
    return "\n\n".join(part for part in parts if part) + "\n"


def describe_command(sheet: Sheet, command: str) -> str:
    """Return one command in full: how it is written, sent and stored, its arguments and its duration."""
    dialect = dialect_of(sheet)
    if command == dialect.mark and sheet.labels:
        return dialect.labels_in_full(sheet)
    return "\n".join(dialect.in_full(sheet, row) for row in find(sheet, command))


# ------------------------------------------------------------------------------------------------------------- chapters


def syntax(row: Row) -> str:
    """Return the syntax of a command: its head, and the names of its arguments."""
    return " ".join([row.head, *(f"<{arg.name}>" for arg in row.args)])


def _head(sheet: Sheet) -> str:
    low, high = mhz(sheet.crystal_low_hz), mhz(sheet.crystal_high_hz)
    text = [f"# {sheet.title}", "", f"- source: {sheet.manual}{f'; {sheet.key}' if sheet.key else ''}"]
    if sheet.crystal_high_hz:
        at = f"times below hold at {mhz(sheet.crystal_hz)} MHz unless another frequency is given"
        text.append(f"- crystal: {low} to {high} MHz; {at}")
    if sheet.buffer_bytes:
        text.append(f"- program buffer: {sheet.buffer_bytes} {units(sheet)}")
    if sheet.labels:
        labels = ", ".join(f"`{dialect_of(sheet).label(letter)}`" for letter in sheet.labels)
        text.append(f"- labels: {labels}, in ASCII programs")
    text += [f"- {name}: {description}" for name, description in sheet.notes.items()]
    return "\n".join(text)


def _port(port: SerialLine, dialect: Dialect[Any]) -> str:
    """Return the description of the serial port: format, baud rates, addresses, answers."""
    format_ = f"{port.bits} data bits, {port.parity} parity, {port.stop} stop bits"
    longest = f"; lines of up to {dialect.longest} characters" if dialect.longest else ""
    check = f"; checksums while `{port.checksum_pin}` is high" if port.checksum_pin else ""
    parts = [f"## Serial port\n\n{format_}{longest}{check}. Source: {port.where}."]
    for names, what, entries in ((port.baud_pins, "baud", port.bauds), (port.address_pins, "address", port.addresses)):
        if names:
            rows = [(*levels, value or "none: a dedicated line") for levels, value in entries.items()]
            parts.append(table((*(f"`{name}`" for name in names), what), rows))
    if dialect.answers:
        parts.append(
            table(
                ("answer", "meaning"), ((f"`{answer}`", description) for answer, description in dialect.answers.items())
            )
        )
    return "\n\n".join(parts)


def _sides(sheet: Sheet) -> str:
    """Return the description of both interfaces, if a part has a bidirectional bus and a serial line; else ""."""
    bus, line = sheet.channel(FlowBus), sheet.channel(AdaptiveLine)
    if bus is None or line is None:
        return ""
    ends = "after the request for its last byte" if bus.ends == "after" else "with its last byte on the bus"
    live = "takes commands, after a first request without a byte" if bus.live else "takes no commands"
    rates = ", ".join(map(str, line.bauds))
    return (
        "## Two host interfaces\n\n"
        "Both work at the same time: a side that has begun a command owns the chip until its end.\n\n"
        f"- `{bus.name}`: a request and an answer for every byte; `{_named(sheet, 'flow')}` is low while the part\n"
        f"  has a message, and high again {ends}. While a program runs the part {live}.\n"
        f"- `{line.name}`: {line.bits} data bits, {line.parity} parity, {line.stop} stop bit. The rate is that of two\n"
        f"  carriage returns, near {rates}, or fixed by the option `fixed_baud`. Source: {line.where}."
    )


def _named(sheet: Sheet, role: str) -> str:
    pin = sheet.role(role)
    return "" if pin is None else pin.name


def _pins(sheet: Sheet) -> str:
    heads = (
        "pin",
        "name",
        "in/out",
        "function",
        "role",
        "active",
        "open",
        "wire to",
        "after reset",
        "when it is sampled",
        "reflex",
        "manual",
    )
    rows = [
        (
            pin.number or "",
            f"`{pin.name}`",
            pin.in_out,
            pin.description,
            _role(pin, sheet),
            LEVEL[pin.active],
            LEVEL[pin.pull],
            LEVEL[pin.tie],
            LEVEL[pin.reset],
            pin.seen,
            pin.reflex,
            source(pin),
        )
        for pin in sheet.pins
    ]
    note = (
        "A part that is wired `to` the chip finds its pins by their roles. A level after a role is the level\n"
        "of the role, if that is not the active one."
    )
    reflexes = [f"- {word}: {REFLEXES[word]}" for word in REFLEXES if any(pin.reflex == word for pin in sheet.pins)]
    if reflexes:
        note += "\n\nA reflex is the effect of an input on a running motor at its active level:\n\n" + "\n".join(
            reflexes
        )
    return f"## Pins\n\n{table(heads, rows)}\n\n{note}" if rows else ""


def _at_once(sheet: Sheet) -> str:
    rows = [(f"`{row.form}`", row.name, AT_ONCE[row.at_once]) for row in sheet.commands if row.at_once]
    note = "They do not wait for the end of a motion; a command that waits for an update acts with it.\n\n"
    return f"## Commands that act immediately\n\n{note}{table(('command', 'name', 'effect'), rows)}" if rows else ""


def _role(pin: Pin, sheet: Sheet) -> str:
    """Return a pin's role, its axis if the part has several, and the level `sense` if it differs from `active`."""
    axis = f" {pin.axis}" if pin.role in AXIS_ROLES and sheet.axes > 1 else ""
    return f"`{pin.role}`{axis}{f' ({LEVEL[pin.sense]})' * (pin.sense != pin.active)}" if pin.role else ""


def _wires(sheet: Sheet) -> str:
    rows = ((", ".join(f"`{name}`" for name in wire),) for wire in sheet.wires)
    return f"## Wires between the packages\n\n{table(('pins',), rows)}" if sheet.wires else ""


def _registers(sheet: Sheet) -> str:
    heads = ("register", "content", "loaded by", "bits", "unit", "power-up value of the model", "manual")
    rows = [
        (f"`{r.name}`", r.description, f"`{r.letter}`" if r.letter else "", r.bits, r.unit, r.default, r.where)
        for r in sheet.registers
    ]
    return f"## Registers\n\n{table(heads, rows)}" if rows else ""


def _times(sheet: Sheet) -> str:
    clocks: tuple[str, ...] = ("at MHz", "clocks") if sheet.crystal_high_hz else ()
    heads = ("time", "meaning", "µs", *clocks, "manual", "trust")
    rows = [
        (
            f"`{name}`",
            time.description,
            f"{time.us:.10g}",
            *((f"{time.mhz:g}", time.ticks) if clocks else ()),
            time.where,
            time.trust,
        )
        for name, time in sheet.times.items()
    ]
    note = "Trust: *stated* by the manual, *derived* from its statements, or *chosen* where it is silent."
    if any(time.trust == "inferred" for time in sheet.times.values()):
        note += " *Inferred*: none of the sources states it."
    return f"## Times\n\n{table(heads, rows)}\n\n{note}" if rows else ""


def _printed(sheet: Sheet) -> str:
    clocks: tuple[str, ...] = ("at MHz",) if sheet.crystal_high_hz else ()
    heads = ("", "time", "from", "to", "min. µs", "typ. µs", "max. µs", *clocks, "kept by", "manual", "trust")
    rows = [
        (
            *(limit.symbol, limit.description, f"`{limit.start}`", f"`{limit.end}`"),
            *("" if ps is None else f"{ps / 10**6:.10g}" for ps in (limit.least, limit.typical, limit.most)),
            *(*(limit.mhz or "any" for _ in clocks), limit.keeper, limit.where, limit.trust),
        )
        for limit in sheet.limits
    ]
    note = "The limits of `bench.check_timing()`, from the last such edge. They scale with the crystal."
    if any(limit.most is not None and limit.most < 0 for limit in sheet.limits):
        note += " Below zero: the second edge must come first."
    return f"## Limits\n\n{table(heads, rows)}\n\n{note}" if rows else ""


def _rates(sheet: Sheet) -> str:
    rows = ((f"**{first}**", *sheet.rates[first : first + 8]) for first in range(0, len(sheet.rates), 8))
    description = (
        f"Steps per second at {mhz(sheet.crystal_hz)} MHz for every rate parameter; they scale with the crystal."
    )
    return f"## Rates\n\n{description}\n\n{table(('', *(f'+{n}' for n in range(8))), rows)}" if sheet.rates else ""


def _options(sheet: Sheet) -> str:
    description = (
        "Of `bench.add`, `options` in a bench file, `serve --option name=value`"
        + (", `slewline://` URLs" if sheet.channel(SerialLine) is not None else "")
        + (
            "; an option in a table is written `table.name=value` there."
            if any(r.table for r in sheet.options)
            else "."
        )
    )
    return f"## Options\n\n{description}\n\n{option_table(sheet.options)}" if sheet.options else ""


def option_table(options: Iterable[Option]) -> str:
    """Return options as a Markdown table; an option that has options of its own is followed by these."""
    heads = ("option", "default", "allowed", "meaning")
    rows = [
        (
            f"`{name}`",
            "required" if row.required else row.shown and f"`{row.shown}`",
            row.allowed,
            f"{row.description}{row.where and f' ({row.where})'}",
        )
        for name, row in flat(options)
    ]
    return table(heads, rows)
