"""Write the pages of the documentation that are generated from the code.

python tools/describe_docs.py            write them
python tools/describe_docs.py --check    fail if a committed page differs from the code

docs/reference/chips.md         the chips side by side
docs/reference/cy500.md         the data sheet, and open questions
docs/reference/cy525.md         the data sheet, the rates and the quirks
docs/reference/cy545.md         the data sheet, the differences of the CY545B, and open questions
docs/reference/gs-c200.md       the data sheet of both modules, and the quirks
docs/reference/mc1451a.md       the data sheet of the six chipsets, and the quirks
docs/reference/cli.md           commands and options
docs/reference/control.md       the requests of the control port
docs/reference/parts.md         the parts around a chip
docs/reference/motors.md        motors, drivers and loads, and the accepted texts
docs/reference/boards.md        boards that drive real motors: pins, times, drivers, messages
docs/reference/motor_record.md  the fields of the motor record
docs/reference/conformance_*.md facts and their tests

It also writes a file of the package: src/slewline/links/control/control.schema.json, with the same requests.
"""

from __future__ import annotations

import argparse
import inspect
import json
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import command_line
import side_by_side

import conformance
from slewline.bench import Bench
from slewline.bench.wiring import joints
from slewline.chips import PARTS, listed, quirks_of, ramps_of, sheet_of
from slewline.chips.cy545 import sheet as cy545
from slewline.core.chip import Chip
from slewline.core.datasheet import units
from slewline.core.datasheet.roles import ROLES
from slewline.drive.board import boards, wire
from slewline.drive.step_drivers import STEP_DRIVERS
from slewline.errors import WiringError
from slewline.labs.field_table import FIELDS, FieldRow
from slewline.language.describe import describe, option_table, table
from slewline.language.lines import usage
from slewline.language.lines.line_reference import line_table
from slewline.language.packets import Packets
from slewline.links.control.requests import COMMON, NAMES, REQUESTS, schema
from slewline.links.control.rows_of_views import EVENTS
from slewline.links.control.validator import in_words, span
from slewline.links.control.value_kinds import A_TIME, Key, RequestSpec
from slewline.parts import KINDS, options_of, part_class
from slewline.parts.base.part import Part
from slewline.parts.motors import drivers, loads, motors
from slewline.parts.motors.motor_data import DriverData

EXAMPLES: dict[str, dict[str, Any]] = {"prom": {"image": ""}, "switch": {"low": 0}}  # parts that need an option
DOCS = Path(__file__).resolve().parent.parent / "docs"
NOTE = "<!-- Written by tools/describe_docs.py; change the code, not this page. -->\n\n"
COMPLETION = """\
A shell completes commands, options and files, chips, pins and their levels, options of a chip, its commands and the
parameters of its ramps, and examples. The completion scripts and the man page are in `share` of the environment in
which slewline is installed. `man slewline` works wherever the shell finds `slewline`; after `pip install --user` shells
find their scripts as well. In another environment source the script:

    . .venv/share/bash-completion/completions/slewline             bash 4.4 or newer, in ~/.bashrc
    fpath+=(.venv/share/zsh/site-functions)                        zsh, before compinit in ~/.zshrc
    source .venv/share/fish/vendor_completions.d/slewline.fish     fish, in ~/.config/fish/config.fish

Without these files, for any installation of slewline:

    eval "$(_SLEWLINE_COMPLETE=bash_source slewline)"
    eval "$(_SLEWLINE_COMPLETE=zsh_source slewline)"
    _SLEWLINE_COMPLETE=fish_source slewline | source

Chips of installed packages are completed as well; a chip written as module:Class is not imported for completion. There
is no completion for PowerShell.

If the environment variable `NO_COLOR` is set and not empty, output is not coloured."""
RAMP_UNIT, OTHER_UNIT = 452, 479  # clocks; see quirk UND-RAMP-LAW
RAMP_TIMES = (  # S, computed and measured milliseconds (CY525 manual, s.8)
    (1, 1299, 1350), (2, 1294, 1350), (10, 1254, 1250), (25, 1177, 1200), (50, 1050, 1050),
    (100, 795, 800), (150, 540, 550), (200, 285, 270), (225, 158, 150), (250, 30, 38),
)  # fmt: skip


# ----------------------------------------------------------------------------------------------------------- data sheet
def older_page(part: str) -> str:
    """Return the page of a part without an available manual: its data sheet, and gaps in the sources."""
    quirks = quirk_lines(part)
    quirks[:2] = [
        "\n## What we do not know\n",
        f"No manual of the {part.upper()} is available. Behaviour not stated by a source is inferred (UND), mostly\n"
        "from its sisters; if two sources disagree (CON), one is chosen. Replace inferred numbers in a bench file:\n\n"
        f'```toml\n[[chip]]\npart = "{part}"\n[chip.options.inferred]\npulse_high = 60\n```\n',
    ]
    return "\n".join([NOTE + describe(sheet_of(part)), *quirks])


def cy545_page() -> str:
    """Return the page of the CY545: data sheet, differences of the CY545B, mode register, and open questions."""
    heads = ("bit", "mask", "function", "trust")
    bits = [(f"MB{mask.bit_length() - 1}", f"{mask:02X}", *of) for mask, of in cy545.MODE_BITS.items()]
    quirks = quirk_lines("cy545")
    quirks[:2] = [
        "\n## What we do not know\n",
        "The model follows one chapter of the manual, and single facts of the others. A complete manual, the edition\n"
        "of 2002, is public, a PDF of the manufacturer (Cybernetic Micro Systems); the model was made without it.\n"
        "Gaps in the available pages are inferred (UND); if two disagree (CON), one is chosen.\n\n"
        "The most important gap is the rates: chapter 17 of the manual is the table of all 256. If you have it, enter\n"
        "it as `inferred.rates`, steps/s at 12 MHz from index 0 to 255, for all tools (`--options`). Replace times\n"
        "in the same way:\n\n"
        '```toml\n[[chip]]\npart = "cy545b"\n[chip.options.inferred]\npulse_low = 72\nfirst_step = 2400\n```\n',
    ]
    return "\n".join(
        [
            NOTE + describe(sheet_of("cy545")),
            "## CY545B\n\nAll of this applies to the CY545B as well, with the following differences.\n",
            table(("", "CY545", "CY545B"), [(what, *both) for what, both in cy545.DIFFERENCES.items()]),
            "\n## Mode register\n\nWritten by `O`, 80 after reset.\n",
            table(heads, bits),
            *quirks,
        ]
    )


def cy525_page() -> str:
    """Return the page of the CY525: data sheet, ramps, and quirks."""
    return "\n".join(
        [
            NOTE + describe(sheet_of("cy525")),
            *ramp_lines(),
            *quirk_lines("cy525", " Times apply at\n11 MHz."),
        ]
    )


def ramp_lines() -> Iterator[str]:
    """Yield the lines of the ramp times of the CY525, from the manual and from the model."""
    yield "## Ramps\n"
    yield "From F 3 to R 127 with Z 1 at 11 MHz, in milliseconds: the manual's table (s.8), and the model from the"
    yield "first step to SLEW low, from the end of the first step, and with other options (quirk UND-RAMP-LAW).\n"
    calculator, hz = ramps_of("cy525"), sheet_of("cy525").crystal_hz
    laws = [(unit, jumps) for jumps in ("False", "True") for unit in (RAMP_UNIT, OTHER_UNIT)]
    rows = []
    for slope, *manual in RAMP_TIMES:
        values = {"F": 3, "R": 127, "S": slope, "Z": 1}
        ramps = [calculator.ramp(values | {"ramp_unit": unit, "ramp_jumps": jumps}, hz) for unit, jumps in laws]
        times = [ramp.time_ps / 10**9 for ramp in ramps]
        times.insert(1, times[0] - 1000 / ramps[0].start)
        rows.append((slope, *manual, *(f"{time:.1f}" for time in times)))
    unit, jumps = f"ramp_unit={OTHER_UNIT}", "ramp_jumps=True"
    head = ("computed", "measured", "model", "from the end of step 1", f"`{unit}`", f"`{jumps}`", f"`{unit}, {jumps}`")
    yield table(("S", *head), rows)


def gs_c200_page() -> str:
    """Return the page of both modules: the whole GS-C200S, the differences of the GS-C200, and the quirks."""
    older, newer = sheet_of("gs-c200"), sheet_of("gs-c200s")
    lacks = [f"`{usage(row)}`" for row in newer.commands if row not in older.commands.rows]
    positions = Bench().add("gs-c200").motor.positions
    whole = describe(newer).replace(f"# {newer.title}", "# GS-C200 and GS-C200S stepper motor controller modules", 1)
    note = "The tables are those of the GS-C200S.\n\n- source"
    return "\n".join(
        [
            NOTE + whole.replace("- source", note, 1),
            "## GS-C200\n",
            f"It does not have {', '.join(lacks)}, but it has:\n",
            line_table(row for row in older.commands if row not in newer.commands.rows),
            f"\nIts position counter ranges from {positions[0]} to {positions[-1]} and does not wrap: a program that "
            "exceeds it ends (E5).",
            *quirk_lines("gs-c200"),
        ]
    )


def mc1451a_page() -> str:
    """Return the page of the chipsets: the whole MC1451A-E, the differences of the others, and the quirks."""
    sheets = [sheet_of(part) for part, row in PARTS.items() if row.folder == "mc1451a"]
    most = sheet_of("mc1451a-e")
    title = "# MC1151A, MC1251A, MC1451A and their -E parts: step motor control chipsets"
    whole = describe(most).replace(f"# {most.title}", title, 1)
    rows = (
        (
            f"`{sheet.part}`",
            sheet.axes,
            "yes" if sheet.encoder else "no",
            ", ".join(f"`{name}`" for name in sheet.foreign),
            f"{sheet.dialect.version:04X}" if isinstance(sheet.dialect, Packets) else "",
        )
        for sheet in sheets
    )
    return "\n".join(
        [
            NOTE + whole.replace("- source", "The tables are those of the MC1451A-E.\n\n- source", 1),
            "## Parts\n",
            "Missing axes have no pins; the codes that would select them are illegal. Parts without an encoder chip\n"
            "lack its pins, but accept its commands.\n",
            table(("part", "axes", "encoder", "illegal", "version word"), rows),
            *quirk_lines("mc1451a"),
        ]
    )


def quirk_lines(part: str, note: str = "") -> list[str]:
    """Return the chapter about the gaps of a manual."""
    rows = ((quirk.id, quirk.where, quirk.description, quirk.why) for quirk in quirks_of(part))
    return [
        "\n## Quirks\n",
        f"Decisions of the model where the manual is silent (UND) or contradicts itself (CON), with reasons.{note}",
        f"The [conformance page](conformance_{listed(part).folder}.md) names the tests.\n",
        table(("id", "manual", "behaviour", "reason"), rows) + "\n",
    ]


# --------------------------------------------------------------------------------------------------------- command line
def cli_page() -> str:
    """Return the page with every command, its arguments and options."""
    return NOTE + "# Command line\n\n" + "\n".join(cli_lines()) + "\n"


def cli_lines() -> Iterator[str]:
    """Yield the lines of the page of the command line."""
    what, statuses = command_line.about()
    yield from (coded(what), "", coded(statuses), "")
    for command in command_line.commands():
        yield from (f"## {command.name}", "", f"`{command.usage}`", "", coded(command.text), "")
        yield table(("option", ""), ((f"`{written}`", coded(says)) for written, says in command.options))
        yield ""
    yield from ("## Completion", "", COMPLETION, "")
    yield from ("## Run scripts", "", "```text", *command_line.script_guide(), "```")


def coded(says: str) -> str:
    """Return a help text with its options set as code."""
    return command_line.OPTION.sub(r"`\g<0>`", says)


# --------------------------------------------------------------------------------------------------------- control port
CONTROL = """# Control port

`slewline serve ... --control 127.0.0.1:4002` opens a port on which a program in any language controls pins, time and
faults, and reads the state. [Virtual serial port](../howto/serve.md#pins-time-and-faults-from-any-language) has an
example.

- A client connects by TCP and sends one JSON object per line, in UTF-8. It gets one reply per line, in order.
- A reply has `time_ps`, virtual time in picoseconds. A reply with `error` states the mistake; the request had no
  effect.
- Every request is checked against the schema before it takes effect: `true` is not a number, and a value outside its
  range is refused. An `error` has the place, the value found, and the values allowed.
- Times are text with a unit (`"250 ms"`) or whole picoseconds. Levels are electrical. Pins have their full names.
- A client that waits (`advance`, `until`) may send more requests, which are read after its reply. Any number of
  clients may be connected.
- A client that has sent `subscribe` also gets events, lines with `event` between the replies; its requests do not
  wait for one another, and `id` relates a reply to its request.
- A client that closes its side of the connection still gets every reply. Its last line may lack the line feed.

The first line of a connection must be such an object, or the server closes it, so a web page cannot make a browser
control the pins. Other machines can connect only if the server was started with `--allow-remote` and with `--token
TEXT`, or with the token in the environment variable `SLEWLINE_TOKEN`, which a process list does not show. Then every
client, on this machine too, sends `"token"` with its first request; with a wrong one the connection is closed. The
token is sent unencrypted: it excludes clients without it, but does not protect against eavesdropping.

`{"do": "schema"}` returns the requests as a JSON schema for generating clients; it is also the file
`control.schema.json` in `slewline/links`. Its `definitions` have each request and its reply (`drive`, `drive_reply`),
each event
(`view_event`), and `error`.
"""


def control_page() -> str:
    """Return the page with every request, its keys and its reply."""
    common = table(("key of every request", "", "if left out"), map(key_row, COMMON))
    chapters = "".join(chapter(name) for name in NAMES)
    return f"{NOTE}{CONTROL}\n{common}\n{chapters}\n{events()}"


def events() -> str:
    """Return the events with their keys."""
    rows = [(f"`{row.event}`", row.description, f"`{key.name}`", key.description) for row in EVENTS for key in row.keys]
    return f"## Events\n\nEach has `event` and `time_ps`, and:\n\n{table(('event', '', 'key', ''), rows)}\n"


def chapter(name: str) -> str:
    """Return the chapter of a request, with all its forms."""
    rows = [row for row in REQUESTS if row.do == name]
    return f"\n## {name}\n" + "".join(form(row) for row in rows)


def form(row: RequestSpec) -> str:
    """Return one form of a request."""
    parts = [f"\n{row.description}\n\n    {json.dumps({'do': row.do} | row.example)}\n"]
    if row.keys:
        parts.append("\n" + table(("key", "", "value", "if left out"), map(request_row, row.keys)) + "\n")
    if row.reply:
        parts.append("\n" + table(("reply", ""), (key_row(key)[:2] for key in row.reply)) + "\n")
    return "".join(parts)


def key_row(key: Key) -> tuple[str, str, str]:
    """Return the table row of a key of a request or of a reply."""
    return f"`{key.name}`", key.description, key.default


def request_row(key: Key) -> tuple[str, str, str, str]:
    """Return the table row of a key of a request, with the values that the validator allows."""
    what = "a time" if key.kind.get("pattern") == A_TIME else in_words(key.kind)
    return f"`{key.name}`", key.description, ", ".join(filter(None, (what, span(key.kind)))), key.default


def control_schema() -> str:
    """Return the requests as a JSON schema, for programs."""
    return json.dumps(schema(), indent=1) + "\n"


# ---------------------------------------------------------------------------------------------------------------- parts
def parts_page() -> str:
    """Return the page with every kind of part, its pins and its options."""
    kinds, chapters, faces = [], [], []
    for kind, row in KINDS.items():
        cls = part_class(kind)
        bench = Bench()
        on = bench.part("motor", "shaft") if cls.sits == "must" else None
        part = bench.part(kind, on=on, **EXAMPLES.get(kind, {}))
        pins = (f"{pin} → {part.wiring[pin]}" if pin in part.wiring else pin for pin in part.pins)
        named = f"[`{kind}`](#{kind})" if options_of(cls, row.fixed) else f"`{kind}`"
        kinds.append((named, row.description, ", ".join(pins), ", ".join(fitting(kind, part))))
        if rows := options_of(cls, row.fixed):
            chapters.append(f"\n### {kind}\n\n{option_table(rows)}\n")
        if own := [*own_names(cls)]:
            faces.append((f"`{kind}`", ", ".join(own)))
    text = (
        "Parts around a chip are added with `bench.part(kind, to=x, ...)` in Python, or `[[part]]` in a bench file.\n"
        "With `to`, pins with an arrow are wired to the neighbour's pin in [that role](#roles). This may be a\n"
        "chip or another part; on a chip with several axes the option `axis` selects one. A part that needs a pin\n"
        "which the neighbour lacks is refused with the reason. Figure numbers refer to the CY525 manual; those\n"
        "with GS-C refer to the data sheet of the GS-C modules.\n"
    )
    table_of_kinds = table(("kind", "description", "pins", "fits chips"), kinds)
    roles = table(("role", "a pin that"), ((f"`{role}`", says) for role, says in ROLES.items()))
    return (
        f"{NOTE}# Parts: motors, drivers, switches, encoders, hosts\n\n{text}\n{table_of_kinds}\n\n"
        f"## Options\n{''.join(chapters)}\n"
        "## From Python\n\nMethods and attributes of each part, besides `name`, `pin(name)`, `pins`, `findings`,\n"
        "`on_finding`, `quantities()`, `shows()`, `idle` and `waiting`. `help` has the details.\n\n"
        f"{table(('kind', ''), faces)}\n\n"
        "## Roles\n\nA role is the purpose of a pin; the pin tables on the chip pages list the roles.\n\n"
        f"{roles}\n"
    )


def own_names(cls: type[Part]) -> Iterator[str]:
    """Yield the methods and attributes of a class of parts for users, in source order, without those of all parts."""
    for base in reversed(cls.__mro__[: cls.__mro__.index(Part)]):
        for name in vars(base).get("_for_users", ()):
            member = getattr(cls, name, None)
            yield (
                f"`{name}({', '.join([*inspect.signature(member).parameters][1:])})`"
                if callable(member)
                else f"`{name}`"
            )


def fitting(kind: str, part: Part) -> list[str]:
    """Return the chips to which a part can be attached, or the names of their families."""
    found = []
    for folder in dict.fromkeys(row.folder for row in PARTS.values()):
        chips = [Bench().add(chip) for chip, row in PARTS.items() if row.folder == folder]
        fits = [chip.sheet.part for chip in chips if attaches(kind, part, chip)]
        found += [f"all of {folder}"] if len(fits) == len(chips) > 2 else fits
    return found


def attaches(kind: str, part: Part, chip: Chip) -> bool:
    """Return whether a part can be wired to a chip in the standard way."""
    try:
        return bool(joints(kind, part, chip))
    except WiringError:
        return False


# --------------------------------------------------------------------------------------------------------------- motors
MOTORS_PAGE = """\
# Motors, drivers and loads

The arguments `motor`, `driver` and `load` of [`stepper`](../howto/motors.md), and of `slewline calibrate` and `slewline
tune`, are a name, text, or a table of figures. A figure is a number in the unit of the table, or text with a unit, such
as `"68 g cm2"`. [The motor model](../explanation/motors.md) explains the figures.

## Motors

Hybrid motors with 200 full steps per revolution; windings, holding torque with two phases on, and rotor inertia are
those of the source. None of the sheets states the drag by iron loss; the model uses 2.66 ms times the holding torque.
"""
SOURCES_NOTE = "Some rows are partly estimates, see their sources. Check a row against the sheet of your motor."
OWN_MOTOR = """\
A text has names and figures between commas, with the names of the table or those of data sheets:

    {example}

A table has the same, in a bench file and in a file MOTOR.toml for `--motor`, one per line: `current = "2 A"`. `like`
and the name of a motor takes all figures of that row; other figures replace single ones, as in `like 17HS4401, inertia
80 g cm2`. `step angle 0.9 deg` (in a table `step_angle`) may be written instead of `teeth`.

{needed} are required. For omitted figures the commands print their assumptions:

{assumed}
"""
UNITS_NOTE = """\
These units are accepted wherever a figure may be text: in these texts and tables, on the command line, in bench files
and from Python. A number alone is in the first unit of its row. Spaces, dots, stars and dashes within a unit are
ignored: `62 oz-in`, `68 g·cm²`, `4.5 kgf-cm`. A rate in revolutions needs the steps per revolution of a motor:
`calibrate`, `pull_out` and the grid of `tune` have a motor, and accept an acceleration in rev/s2 and a jerk in rev/s3.
Scripts and `slewline ramp` have no motor and refuse such rates.
"""
DRIVER_TEXTS = """\
`{supply:V}` stands for a number and its unit, `24 V`; `L/{times:R}` for `L/4R`. A text without a kind is `averaged`,
or `chopper` if it has a frequency, an off-time (`off 12 us`) or a decay. The current is that of a phase with two phases
on; the default is the rated current of the motor.
"""
BOUGHT_NOTE = """\
A chopper without a name and a frequency has 20 kHz. With a winding of low inductance its current ripple is then so
large that torque is lost at high rates, which the commands report. `auto` decay is slow, and mixed after a step that
reduces the current. A TMC2208 or TMC2209 regulates the mean of the current after a reset, so it is `averaged`;
`TMC2209, 24 V, 1 A, chopper` switches at the frequency of its PWM. The fast decay of a DRV8825 ends at 75 % of the
period; in the model it lasts for 75 % of a period from the peak on.
"""
LOAD_TEXTS = """\
A text has names and figures between commas, `inertia 68 g cm2, friction 10 mNm`; a table has the same. `mass` with
`lead` is a linear axis: its inertia, its friction by `force`, its weight if it is `vertical`.
"""


BOARDS_PAGE = """\
# Boards

A board outputs the steps of a [real motor](../howto/real_motors.md). An Arduino Uno and a Nano have the same processor,
the same pins and the same firmware, which `make boards` builds: only the application, with the same bytes wherever it
is built.
"""
TIMES_NOTE = """\
Times of boards up to 45,000 steps/s, measured in an emulator of the Uno's processor; an Uno accepts up to 70,000
steps/s, where STEP is low for 0.7 µs. The times of drivers are those of their data sheets.
"""
WIRE_NOTE = """\
500,000 baud, 8N1. A frame is `number u8, kind u8, payload, CRC-16/X-25 u16`, encoded with COBS and terminated by
00; all fields are little-endian. Each frame of the host has one ANSWER. Numbered frames are accepted only in order;
ANSWER has the next expected number. A record is `flags u8, count u16, interval u32 ticks, fraction u16, add i32`,
fraction and add in 1/65536 tick. The firmware contains parts of avr-libc, whose notice is below.
"""
AVR_LIBC = """\
## Notice of avr-libc

The firmware is linked with start-up code and functions of avr-libc, which is under a three-clause BSD licence
(copyright by its many authors, without warranty of any kind, as stated in full in its licence), and of libgcc, under
the GPL with the runtime library exception. If you distribute the .hex, include that notice: Debian has it in
`avr-libc/copyright`.
"""


def board_pins(board: boards.BoardModel) -> str:
    """Return the pins of a board."""
    pins = [
        (board.step, "STEP; high for one step"),
        (board.dir, "DIR"),
        (board.enable, "ENABLE of the driver; high impedance until a host has configured the board"),
        *((pin, f"phase {'ABCD'[n]}, for a driver without STEP") for n, pin in enumerate(board.phases)),
        *((pin, f"output {n}") for n, pin in enumerate(board.outputs)),
        *((pin, f"input {n}, with a pull-up") for n, pin in enumerate(board.inputs)),
        (board.loop, "counts the pulses of STEP in the self-test, if wired to it"),
        (board.led, "LED: on while the board is not at rest"),
    ]
    rows = ((pin.printed, pin.port, says) for pin, says in pins)
    return f"### {board.title}\n\n{table(('pin', 'port of the processor', 'function'), rows)}"


def boards_page() -> str:
    """Return the page with pins and times of the boards, step drivers, and the messages of the wire."""
    known = list(boards.BOARDS.values())
    times = (
        (what, *(f"{getattr(board, name) * 1e6 / board.hz:.1f}" for board in known))
        for what, name in (
            ("STEP is high", "high"), ("STEP is low", "low"),
            ("DIR is stable before STEP", "setup"), ("DIR is stable after STEP", "hold"),
        )
    )  # fmt: skip
    rows = (
        (
            f"`{row.name}`", *(f"{ps / 1e6:g}" for ps in (row.high_ps, row.low_ps, row.setup_ps, row.hold_ps)),
            "high" if row.enabled else "low", row.source,
        )
        for row in STEP_DRIVERS.values()
    )  # fmt: skip
    kinds = (
        (f"{kind:#04x}" if kind >= 128 else str(int(kind)), kind.name, "yes" if kind in wire.NUMBERED else "")
        for kind in wire.FrameKind
    )
    named = (
        (title, ", ".join(f"{int(each)} {each.name}" for each in kind))
        for title, kind in (
            ("state", wire.BoardState), ("event", wire.Happening),
            ("result", wire.FrameResult), ("reflex", wire.Reflex),
        )
    )  # fmt: skip
    columns = ("driver", "high, µs", "low", "DIR before", "DIR after", "ENABLE is active", "source")
    return "\n\n".join(
        (
            f"{NOTE}{BOARDS_PAGE}\n## Pins", *map(board_pins, known), "## Drivers", TIMES_NOTE.strip(),
            table(("at least, µs", *(board.title for board in known)), times), table(columns, rows),
            "## Messages", WIRE_NOTE.strip(), table(("kind", "frame", "numbered"), kinds),
            table(("numbers of a", ""), named), AVR_LIBC,
        )
    )  # fmt: skip


def switching(driver: DriverData) -> str:
    """Return the switching rate of a driver, and the decay of its current, as text."""
    often = f"an off-time of {driver.off_time * 1e6:g} us" if driver.off_time else f"{driver.frequency / 1e3:g} kHz"
    return f"{often}, averaged" if driver.kind == "averaged" else f"{often}, {driver.decay} decay"


def motors_page() -> str:
    """Return the page with motors and drivers and their sources, and the content of texts and tables."""
    sources = list(dict.fromkeys(row.source for row in motors.MOTORS.values()))
    columns = ("motor", "A", "ohm", "mH", "N m", "detent mN m", "g cm²", "source")
    rows = (
        (
            f"`{row.name}`", f"{row.current:g}", f"{row.resistance:g}", f"{row.inductance * 1e3:g}", f"{row.torque:g}",
            f"{row.detent * 1e3:g}" if row.detent else "", f"{row.inertia * 1e7:g}", str(sources.index(row.source) + 1),
        )
        for row in motors.MOTORS.values()
    )  # fmt: skip
    listed = "\n".join(f"{n}. {source}" for n, source in enumerate(sources, 1))
    sayings = (
        (f"`{form}`", "; ".join(f"{name} = {value}" for name, value in sets.items()))
        for form, sets in drivers.SAYINGS.items()
    )
    kinds = ((f"`{kind}`", ", ".join(f"`{name}`" for name in names)) for kind, names in drivers.TAKES.items())
    bought = (
        (
            f"`{name}`", switching(row.data),
            f"{row.supply[0]:g} to {row.supply[1]:g}", f"{row.most:g}", row.data.source,
        )
        for name, row in drivers.DRIVERS.items()
    )  # fmt: skip
    always = ", ".join(f"`{name}`" for name in drivers.ALWAYS)
    turns = {"steps/s": units.TURNS}
    measures = (
        (units.KINDS[first], ", ".join(f"`{each}`" for each in (*sizes, *turns.get(first, ()))))
        for first, sizes in units.UNITS.items()
    )
    return "\n\n".join(
        (
            f"{NOTE}{MOTORS_PAGE}\n{table(columns, rows)}", listed, SOURCES_NOTE,
            "### A motor of your own",
            OWN_MOTOR.format(
                example=motors.EXAMPLE, needed=", ".join(f"`{name}`" for name in motors.NEEDED),
                assumed="\n".join(f"- `{name}`: {says}" for name, says in motors.ASSUMED.items()),
            ).strip(),
            option_table(motors.FIGURES),
            "## Drivers", "A text has parts between commas, in any order:",
            "\n".join(f"    {text}" for text in drivers.EXAMPLES),
            table(("text", "sets"), sayings), DRIVER_TEXTS.strip(),
            "Commercial drivers are named in a text, or with `like` in a table:",
            table(("driver", "switches at", "supply, V", "most, A", "source"), bought), BOUGHT_NOTE.strip(),
            "### A driver as a table", option_table(drivers.FIGURES),
            f"In addition to {always} a driver has the figures of its kind:", table(("kind", "figures"), kinds),
            "## Loads", LOAD_TEXTS.strip(), option_table(loads.FIGURES),
            "## Units", UNITS_NOTE.strip(), f"{table(('quantity', 'units'), measures)}\n",
        )
    )  # fmt: skip


# --------------------------------------------------------------------------------------------------------- laboratories
RECORD_PAGE = """# The motor record

The fields of the record that [`slewline epics`](../howto/epics.md) serves, with the names, types and words of the motor
record of EPICS. A put of a position, a jog or a homing completes when the motor is at rest; DMOV is 0 until then. A
refused put fails with `ECA_PUTFAIL`, and the server prints the reason. pyepics and ophyd-async ignore that status: with
these, read the field back.

Differences from a motor record with a controller that reports its position in motion:

- RBV, DRBV and RRBV are the positions at rest. So a new position that the motor may already have passed stops it
  immediately. A jog is a move to its final position; when it is stopped, the motor remains where it stopped.
- A pause by SPMG leaves DMOV at 0, because the motion resumes later. A position put during a pause becomes a motion
  after Go or Move; until then its put does not complete.
- HLM, LLM, DHLM or DLLM put while the motor moves stop a motion that would exceed them.
- A rate beyond the range of the part is refused; the motor record would take the nearest.
- With SET, a GS-C200S or a CY545 takes its new position; a GS-C200 has no command for that, so only OFF can change.
- A CY545 accepts no command while it moves, and homes to an input: STOP, SPMG, jogs and homings are refused.
"""
TYPES = {"double": "DOUBLE", "float": "FLOAT", "short": "SHORT", "long": "LONG", "string": "STRING", "enum": "ENUM"}


def record_page() -> str:
    """Return the page with the fields of the motor record, by the access of clients."""

    def fields(access: str) -> str:
        rows = (row for row in FIELDS if row.access == access)
        return table(("field", "type", "meaning"), ((f"{row.name}", TYPES[row.kind], meaning(row)) for row in rows))

    def meaning(row: FieldRow) -> str:
        return f"{coded(row.description)} ({', '.join(row.words)})" if row.words else coded(row.description)

    return "\n\n".join(
        (
            f"{NOTE}{RECORD_PAGE}\n## Written by clients", fields("put"),
            "## Read by clients", fields("read"),
            "## Constants", "A put of the present value of the field succeeds, so a saved list of fields can be "
            "restored; any other value is refused.", f"{fields('fixed')}\n",
        )
    )  # fmt: skip


# ---------------------------------------------------------------------------------------------------------- conformance
def conformance_page(folder: str) -> str:
    """Return the page with facts and choices of a data sheet, and their tests."""
    return NOTE + conformance.page(conformance.tables()[folder], conformance.markers())


# ---------------------------------------------------------------------------------------------------------------- pages
FILES = {
    "reference/chips.md": lambda: NOTE + side_by_side.page(),
    "reference/cy500.md": partial(older_page, "cy500"),
    "reference/cy525.md": cy525_page,
    "reference/cy545.md": cy545_page,
    "reference/cy512.md": partial(older_page, "cy512"),
    "reference/gs-c200.md": gs_c200_page,
    "reference/mc1451a.md": mc1451a_page,
    "reference/cli.md": cli_page,
    "reference/control.md": control_page,
    "../src/slewline/links/control/control.schema.json": control_schema,
    "reference/parts.md": parts_page,
    "reference/motors.md": motors_page,
    "reference/boards.md": boards_page,
    "reference/motor_record.md": record_page,
    **{f"reference/conformance_{folder}.md": partial(conformance_page, folder) for folder in conformance.tables()},
}


def outdated() -> list[str]:
    """Return the files that differ from the code."""
    found = []
    for name, made in FILES.items():
        path = DOCS / name
        committed = path.read_text("utf-8") if path.exists() else ""
        if committed != made():
            found.append(name)
    return found


def main() -> int:
    """Write the pages, or check them; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    if parser.parse_args().check:
        found = outdated()
        for name in found:
            print(f"docs/{name} differs from the code; run: python tools/describe_docs.py")
        return int(bool(found))
    for name, made in FILES.items():
        (DOCS / name).write_text(made(), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
