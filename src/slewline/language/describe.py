"""The data sheet as Markdown: what `slewline describe` prints, and a generated page of the documentation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ..core.option import Option, flat
from ..core.table import AXIS_ROLES, Arg, Bits, Packets, Pin, Port, Row, Sheet
from . import lines, packets
from .assemble import units
from .lookup import MARK, find
from .source import LABELS

LEVEL = {0: "low", 1: "high", None: ""}
OWN = "Opcodes are the model's own: the sheet gives none. A carriage return ends a line."
SECTIONS = "; s. is a section, T. a table of it"
BUFFERED, WITH_ENCODER = "waits for an update", "needs an encoder; other parts accept it"
CHECKSUM = "A checksum of 16 bits may be read behind every packet: command byte and words, added up."
STATES = {"i": "idle", "p": "during program entry", "r": "while a program runs"}


def describe(sheet: Sheet, command: str | None = None) -> str:
    """The whole sheet, or a single command by its letter or name, all forms of it.

    Raises:
        UnknownName: the part has no such command; the message lists those that it has.
    """
    if command is not None:
        return describe_command(sheet, command)
    port = _port(sheet.port) if sheet.port is not None else ""
    words = _words(sheet.packets) if sheet.packets is not None else ""
    tables = (_pins, _wires, _registers, _times, _printed, _rates, _options)
    parts = [_head(sheet), _commands(sheet), port, words, *(write(sheet) for write in tables)]
    return "\n\n".join(part for part in parts if part) + "\n"


def describe_command(sheet: Sheet, command: str) -> str:
    """One command in full: how it is written, sent and stored, what it takes, how long it lasts."""
    if command == MARK and sheet.labels:
        return _labels_in_full(sheet)
    in_full = _line_in_full if sheet.in_lines else _packet_in_full if sheet.in_packets else _in_full
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
        f"- manual: {_source(row)}",
    ]
    text += [f"- `{arg.name}`: {_range(sheet, arg)}, {_bytes(arg.size)}" for arg in row.args]
    text += [f"- {sheet.slips[row.form]}"] if row.form in sheet.slips else []
    return "\n".join(text) + "\n"


def _labels_in_full(sheet: Sheet) -> str:
    first, last = sheet.labels[0], sheet.labels[-1]
    used = ", ".join(row.form for row in sheet.commands if any(arg.label for arg in row.args))
    text = [
        "# LABEL: names the instruction that follows",
        "",
        f"- ASCII: `{first}{MARK}` to `{last}{MARK}`, directly in front of the instruction, without a carriage return",
        "- binary: none; binary programs branch to addresses",
        "- program buffer: no room",
        f"- branches to it: {used}, with the letter alone, such as `J {first}`",
        f"- manual: {LABELS}; T.II",
    ]
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


def _packet_in_full(sheet: Sheet, row: Row) -> str:
    text = [
        f"# {row.name}: {row.says}",
        "",
        f"- line: `{packets.usage(row)}`",
        f"- packet: `{packet(row)}`",
        f"- acts on: {_acted_on(row)}",
        f"- time at {_mhz(sheet.crystal_hz)} MHz: {row.time_us} µs after the command and after each word",
        f"- manual: {row.where}",
    ]
    text += [f"- `{arg.name}`: {packets.range_of(arg)}" for arg in (*row.args, *row.reads)]
    text += [f"- {says}" for says in _conditions(row)]
    return "\n".join(text) + "\n"


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


def packet(row: Row) -> str:
    """What goes over the host port: code, words that are written, words that are returned in brackets."""
    returned = " ".join(_halves(row.reads))
    return " ".join([f"{row.code:02X}", *_halves(row.args), *([f"[{returned}]"] if returned else [])])


def _halves(args: Iterable[Arg]) -> list[str]:
    """Words by name, the high one first."""
    return [part for arg in args for part in ([arg.name] if arg.size == 2 else [f"{arg.name}.high", f"{arg.name}.low"])]


def _acted_on(row: Row) -> str:
    """Whom the command is for."""
    axes = {"set": "the axis that it sets", "mask": "the axes in its mask", "global": "all axes"}
    return axes.get(row.acts, f"the {row.acts} axis")


def _conditions(row: Row) -> list[str]:
    return [*([BUFFERED] if row.buffered else []), *([WITH_ENCODER] if row.encoder else [])]


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
    text = [f"# {sheet.title}", "", f"- source: {sheet.manual}{SECTIONS if sheet.in_letters else ''}"]
    if sheet.crystal_high_hz:
        at = f"times below hold at {_mhz(sheet.crystal_hz)} MHz unless another is named"
        text.append(f"- crystal: {low} to {high} MHz; {at}")
    if sheet.buffer_bytes:
        text.append(f"- program buffer: {sheet.buffer_bytes} {units(sheet)}")
    if sheet.labels:
        text.append(f"- labels: {', '.join(f'`{letter}$`' for letter in sheet.labels)}, in ASCII programs")
    text += [f"- {name}: {says}" for name, says in sheet.notes.items()]
    return "\n".join(text)


def _commands(sheet: Sheet) -> str:
    if sheet.in_lines:
        return f"## Commands\n\n{line_table(sheet.commands)}\n\n{OWN}"
    return f"## Commands\n\n{_packet_table(sheet) if sheet.in_packets else _letter_table(sheet)}"


def _letter_table(sheet: Sheet) -> str:
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
            _source(row),
        )
        for row in sheet.commands
    ]
    note = "The time is how long the chip is busy with the last byte of the command, without conversion and motion."
    return f"{table(heads, rows)}\n\n{note}"


def _packet_table(sheet: Sheet) -> str:
    """Commands that are packets, the codes without a command behind them."""
    heads = ("packet", "name", "what it does", "numbers", "acts on", "condition")
    rows = [
        (
            f"`{packet(row)}`",
            row.name,
            row.says,
            "; ".join(f"{arg.name} {packets.range_of(arg)}" for arg in (*row.args, *row.reads)),
            _acted_on(row),
            "; ".join(_conditions(row)),
        )
        for row in sheet.commands
    ]
    return f"{table(heads, rows)}\n\n{CHECKSUM}"


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


def _words(port: Packets) -> str:
    """The words that tell about an axis, and the codes that are no commands."""
    parts = [
        f"## Status word\n\n{_fields(port.status)}",
        f"## Mode word\n\n{_fields(port.mode)}",
        f"## Version word\n\n`{port.version:04X}`",
        f"## Other codes\n\n{table(('codes', 'what they do'), _other_codes(port))}\n\nSource: {port.where}.",
    ]
    return "\n\n".join(parts)


def _fields(bits: Iterable[Bits]) -> str:
    rows = (
        (f"{each.low}" if each.width == 1 else f"{each.low}-{each.low + each.width - 1}", f"`{each.name}`", each.says)
        for each in bits
    )
    return table(("bit", "name", "what it says"), rows)


def _other_codes(port: Packets) -> list[tuple[str, str]]:
    """Codes that are no commands of the part, and what they do."""
    alike = {(1, 0): "a word is taken", (0, 1): "a word is returned, 0", (0, 0): "no data"}
    rows = [
        (_codes(code for code, found in port.siblings.items() if found == words), f"a sister part's; no effect, {says}")
        for words, says in alike.items()
    ]
    return [
        (_codes(port.illegal), "illegal: checksum 0"),
        (_codes(port.reserved), "reserved: no effect"),
        *rows,
        ("the others", "not documented: no effect, no data"),
    ]


def _codes(codes: Iterable[int]) -> str:
    """Codes in hexadecimal, runs of them as ranges."""
    found = sorted(codes)
    runs = [code for code in found if code - 1 not in found], [code for code in found if code + 1 not in found]
    return ", ".join(f"{one:02X}" if one == two else f"{one:02X}-{two:02X}" for one, two in zip(*runs, strict=True))


def _pins(sheet: Sheet) -> str:
    heads = (
        "pin",
        "name",
        "way",
        "what it does",
        "role",
        "active",
        "open",
        "wire to",
        "after reset",
        "when it is seen",
        "manual",
    )
    rows = [
        (
            pin.number or "",
            f"`{pin.name}`",
            pin.way,
            pin.says,
            _role(pin, sheet),
            LEVEL[pin.active],
            LEVEL[pin.pull],
            LEVEL[pin.tie],
            LEVEL[pin.reset],
            pin.seen,
            _source(pin),
        )
        for pin in sheet.pins
    ]
    note = (
        "A part that is wired `to` the chip finds its pins by their roles. A level behind a role is the one at which\n"
        "it holds, where that is not the active one."
    )
    return f"## Pins\n\n{table(heads, rows)}\n\n{note}" if rows else ""


def _source(of: Row | Pin) -> str:
    """Return where a row or a pin stands in the manual; marked, where it is inferred."""
    return of.where if of.trust == "stated" else f"{of.where} ({of.trust})"


def _role(pin: Pin, sheet: Sheet) -> str:
    """What a pin is for: its role, the axis where there are several, and the level where it is not the active one."""
    axis = f" {pin.axis}" if pin.role in AXIS_ROLES and sheet.axes > 1 else ""
    return f"`{pin.role}`{axis}{f' ({LEVEL[pin.sense]})' * (pin.sense != pin.active)}" if pin.role else ""


def _wires(sheet: Sheet) -> str:
    rows = ((", ".join(f"`{name}`" for name in wire),) for wire in sheet.wires)
    return f"## Wires between the packages\n\n{table(('pins',), rows)}" if sheet.wires else ""


def _registers(sheet: Sheet) -> str:
    heads = ("register", "what it holds", "loaded by", "bits", "unit", "power-up value of the model", "manual")
    rows = [
        (f"`{r.name}`", r.says, f"`{r.letter}`" if r.letter else "", r.bits, r.unit, r.default, r.where)
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
    if any(time.trust == "inferred" for time in sheet.times.values()):
        note += " *Inferred*: no manual is at hand."
    return f"## Times\n\n{table(heads, rows)}\n\n{note}" if rows else ""


def _printed(sheet: Sheet) -> str:
    clocks: tuple[str, ...] = ("at MHz",) if sheet.crystal_high_hz else ()
    heads = ("", "time", "from", "to", "min. µs", "typ. µs", "max. µs", *clocks, "kept by", "manual", "trust")
    rows = [
        (
            *(limit.symbol, limit.says, f"`{limit.start}`", f"`{limit.end}`"),
            *("" if ps is None else f"{ps / 10**6:.10g}" for ps in (limit.least, limit.typical, limit.most)),
            *(*(limit.mhz or "any" for _ in clocks), limit.keeper, limit.where, limit.trust),
        )
        for limit in sheet.limits
    ]
    note = "What `bench.check_timing()` checks. From the last such edge; with another crystal, scaled."
    if any(limit.most is not None and limit.most < 0 for limit in sheet.limits):
        note += " Below zero: it has to come first."
    return f"## Limits\n\n{table(heads, rows)}\n\n{note}" if rows else ""


def _rates(sheet: Sheet) -> str:
    rows = ((f"**{first}**", *sheet.rates[first : first + 8]) for first in range(0, len(sheet.rates), 8))
    says = f"Steps per second at {_mhz(sheet.crystal_hz)} MHz for every rate parameter; they scale with the crystal."
    return f"## Rates\n\n{says}\n\n{table(('', *(f'+{n}' for n in range(8))), rows)}" if sheet.rates else ""


def _options(sheet: Sheet) -> str:
    says = (
        "Of `bench.add`, `options` in a bench file, `serve --option name=value`"
        + (", `slewline://` URLs" if sheet.port is not None else "")
        + ("; what is in a table is written `table.name=value` there." if any(r.table for r in sheet.options) else ".")
    )
    return f"## Options\n\n{says}\n\n{option_table(sheet.options)}" if sheet.options else ""


def option_table(options: Iterable[Option]) -> str:
    """Options, those of tables behind them, as a table."""
    heads = ("option", "default", "allowed", "what it is")
    rows = [
        (
            f"`{name}`",
            "required" if row.required else row.shown and f"`{row.shown}`",
            row.allowed,
            f"{row.says}{row.where and f' ({row.where})'}",
        )
        for name, row in flat(options)
    ]
    return table(heads, rows)


def table(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(str(cell).replace('|', chr(92) + '|') for cell in line)} |" for line in lines)
