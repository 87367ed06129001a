"""The page of the documentation that compares the chips, generated from their sheets and from moves that are run."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import conformance
from slewline.bench import Bench
from slewline.chips import PARTS, listed, quirks_of, ramps_of, sheet_of
from slewline.chips.cy545.sheet import TABLES
from slewline.chips.gs_c200.sheet import RATE_UNIT
from slewline.chips.mc1451a.sheet import HIGH_RANGE, STANDARD_RANGE
from slewline.core.datasheet.channel import AdaptiveLine, BusHandshake, Channel, FlowBus, HostPort, SerialLine
from slewline.core.datasheet.table import Sheet
from slewline.language.markdown import mhz, table

HEAD = """# The chips side by side

All of these chips are *indexers*: controllers that take commands from a host, and generate the steps of a motor, with
ramps, on their own. For an existing machine, take the part whose name is on the package, to the last letter. If you are
free to choose, this page shows the differences, and how much of each part is known.

## Which one to choose
"""
CHOICES = (  # requirement, part, reason
    (
        "to see how an indexer works, or to teach it", "[CY525](cy525.md)",
        "its whole manual is available, a command is a letter and a number, and its programs fit on half a page",
    ),
    ("phase outputs, half steps", "[CY512](cy512.md)", "it drives the windings itself; a part of it is inferred"),
    (
        "a serial line, lines of text", "[GS-C200S](gs-c200.md)",
        "any terminal can be the host, modules share a line, and a program survives power-off",
    ),
    (
        "long programs, texts on a display, thumbwheels", "[CY545B](cy545.md)",
        "64K of external memory, and two hosts; its rates are inferred until you enter the manual's table",
    ),
    (
        "several axes, S-curves, encoders, the highest step rate", "[MC1451A-E](mc1451a.md)",
        "every motion is computed, and can change on the fly",
    ),
    (
        "the same, with one axis or two", "[MC1151A, MC1251A](mc1451a.md#parts)",
        "the commands are the same; only the -E parts have encoders",
    ),
)  # fmt: skip
HAVE = """
## Features

For parts that share a column, the most complete one. The models have run these moves.
"""
KNOWN = """
## How much is known

The rows of each data sheet, by their basis: *stated* by the manual, *derived* from its statements, *chosen* where it is
silent, or *inferred* from sister parts, if the model was made without the manual (the CY545's is public, and its table
of rates [can be entered](cy545.md#what-we-do-not-know)). Then the facts of the manual that are proven by a test, and
the quirks, for which the manual is silent or contradicts itself. No silicon was measured for any of them.
"""
LETTERS = """
## Letter by letter

The four parts of Cybernetic look alike, but a program for one does not work on another: these letters differ. `slewline
lint` reports letters that were meant for a sister part.
"""


@dataclass(frozen=True)
class Family:
    """Parts that share a page, and a move of 100 steps forward by one of them, as sent by a host.

    `law` describes how a ramp accelerates.
    """

    title: str
    page: str
    parts: tuple[str, ...]
    move: tuple[str, ...]
    law: str

    @property
    def sheet(self) -> Sheet:
        """The sheet of the most complete part."""
        return sheet_of(self.parts[-1])


FAMILIES = (
    Family("CY500", "cy500", ("cy500",), ("R 200", "N 100", "G"), "the rate index grows with each step"),
    Family("CY512", "cy512", ("cy512",), ("R 200", "F 1", "S 0", "N 100", "G"), "the rate index grows with each step"),
    Family("CY525", "cy525", ("cy525",), ("F 10", "R 80", "S 200", "Z 1", "N 100", "G"), "a table of rates, in time"),
    Family(
        "CY545, CY545B", "cy545", ("cy545", "cy545b"), ("F 10", "R 80", "S 200", "+", "N 100", "G"),
        "a table of rates, in time",
    ),
    Family(
        "GS-C200, GS-C200S", "gs-c200", ("gs-c200", "gs-c200s"), ("Po", "S10", "T100", "R50", "+100", "E"),
        "constant acceleration over R steps",
    ),
    Family(
        "MC1151A, MC1251A, MC1451A, -E", "mc1451a", tuple(part for part in PARTS if part.startswith("mc")),
        ("SET_VEL 65536", "SET_ACC 655", "SET_POS 100", "UPDATE"),
        "trapezoid, S-curve, velocity contouring, electronic gear",
    ),
)  # fmt: skip


# ------------------------------------------------------------------------------------------------------ what they have
def maker(family: Family) -> str:
    """Return the manufacturer of the parts, and the year of the documents."""
    return re.findall(r"\(([^)]*)\)$", listed(family.parts[0]).description)[0]


def axes(family: Family) -> str:
    """Return the number of axes."""
    return either(sheet_of(part).axes for part in family.parts)


def either(numbers: Iterable[int]) -> str:
    """Return numbers as text: 1, 2 or 4."""
    *others, last = map(str, sorted({*numbers}))
    return f"{', '.join(others)} or {last}" if others else last


def bus(_channel: Channel) -> str:
    """Return the description of a bus of the CY5xx family."""
    return "8-bit bus, a handshake for each byte"


def both_ways(_channel: Channel) -> str:
    """Return the description of a bidirectional bus."""
    return "bidirectional 8-bit bus"


def line(channel: SerialLine) -> str:
    """Return the description of a serial line with fixed rates: rates, characters, modules."""
    rates, addresses = sorted(channel.bauds.values()), {*channel.addresses.values()} - {0}
    return f"serial line, {rates[0]} to {rates[-1]} baud, {form(channel)}, up to {len(addresses)} modules"


def adaptive(channel: AdaptiveLine) -> str:
    """Return the description of a serial line whose rate the part measures."""
    rates = sorted(channel.bauds)
    return f"serial line, {rates[0]} to {rates[-1]} baud, {form(channel)}, the rate is measured"


def form(channel: SerialLine | AdaptiveLine) -> str:
    """Return the format of characters: 8N1."""
    return f"{channel.bits}{channel.parity[0].upper()}{channel.stop}"


def port(_channel: Channel) -> str:
    """Return the description of a host port."""
    return "registers on a bus: packets of 16-bit words"


WAYS: dict[type[Channel], Callable[..., str]] = {
    BusHandshake: bus, FlowBus: both_ways, SerialLine: line, AdaptiveLine: adaptive, HostPort: port,
}  # fmt: skip


def reached(family: Family) -> str:
    """Return the interfaces between a host and the parts."""
    return "; ".join(WAYS[type(channel)](channel) for channel in family.sheet.channels)


def tried(family: Family) -> str:
    """Return the move of a family, after running it."""
    bench = Bench()
    x = bench.add(family.parts[-1], **({"straps": family.sheet.plain} if family.sheet.plain else {}))
    host = bench.host(x)
    for words in family.move:
        host.send(f"{words}\r")
    bench.run_until_idle()
    made = len(x.axes[0].steps(0, bench.now_ps))
    if made != 100 or x.findings:
        raise SystemExit(f"side_by_side: {family.title}: 100 steps expected, {made} taken; {x.findings}")
    return " ".join(f"`{words}`" for words in family.move)


def commands(family: Family) -> str:
    """Return the number of commands."""
    return either(len(sheet_of(part).commands) for part in family.parts)


def memory(family: Family) -> str:
    """Return the description of the program memory."""
    sheet = family.sheet
    if not sheet.buffer_bytes:
        return "none: each move is sent by the host"
    return f"{sheet.buffer_bytes:,} {sheet.memory_unit}s" + (", survives power-off" if sheet.keeps else "")


def positions(family: Family) -> str:
    """Return the range of the position counter of the most complete part."""
    name = {"gs-c200": "G", "mc1451a": "SET_POS"}.get(family.page, "P")
    row = family.sheet.commands.named(name) if name == "SET_POS" else family.sheet.commands[name]
    return f"{row.args[0].low:,} to {row.args[0].high:,}"


def fastest(family: Family) -> str:
    """Return the highest rate, in steps/s."""
    sheet = family.sheet
    if family.page == "cy545":
        return f"{max(TABLES['20k']):,}, or {max(TABLES['27k']):,} with another table"
    if family.page == "gs-c200":
        return f"{RATE_UNIT * sheet.commands['T'].args[0].high:,}"
    if family.page == "mc1451a":
        cycle = sheet.times["cycle"].us / 10**6
        return f"{STANDARD_RANGE / cycle:,.0f}, or {HIGH_RANGE / cycle:,.0f} in high-speed mode"
    return f"{max(sheet.rates):,}"


def parameters(family: Family) -> str:
    """Return the parameters of a ramp."""
    names = (each.name for each in ramps_of(family.parts[-1]).quantities if each.name.isupper())
    return ", ".join(f"`{name}`" for name in names)


def law(family: Family) -> str:
    """Return the law of a ramp."""
    return family.law


def outputs(family: Family) -> str:
    """Return the outputs for the motor."""
    roles = {pin.role for pin in family.sheet.pins}
    drives = (("phase1", "four phases"), ("step", "step"), ("direction", "direction"))
    return ", ".join(says for role, says in drives if role in roles)


def stops(family: Family) -> str:
    """Return the inputs that stop, hold or jog a motor."""
    roles = {pin.role for pin in family.sheet.pins}
    says = {
        "abort": "abort", "enable": "enable or hold", "home": "home", "end": "end of travel", "end_plus": "two limits",
        "jog": "jog",
    }  # fmt: skip
    return ", ".join(word for role, word in says.items() if role in roles)


def encoder(family: Family) -> str:
    """Return the parts that read an encoder."""
    having = [part for part in family.parts if sheet_of(part).encoder]
    return "the -E parts" if having else "no"


def clock(family: Family) -> str:
    """Return the crystal frequency."""
    sheet = family.sheet
    if not sheet.crystal_high_hz:
        return "internal"
    return f"{mhz(sheet.crystal_low_hz)} to {mhz(sheet.crystal_high_hz)} MHz"


ROWS: tuple[tuple[str, Callable[[Family], str]], ...] = (
    ("manufacturer, year", maker),
    ("axes", axes),
    ("host interface", reached),
    ("100 steps forward", tried),
    ("commands", commands),
    ("program", memory),
    ("positions", positions),
    ("steps/s, at most", fastest),
    ("ramp parameters", parameters),
    ("ramp law", law),
    ("motor outputs", outputs),
    ("inputs that act on the motor", stops),
    ("encoder", encoder),
    ("crystal", clock),
)


# ------------------------------------------------------------------------------------------------------- what is known
def trusts(sheet: Sheet) -> Counter[str]:
    """Return the numbers of rows of a sheet that are stated, derived, chosen and inferred."""
    rows = (*sheet.pins, *sheet.commands, *sheet.times.values(), *sheet.limits)
    return Counter(row.trust for row in rows)


def known(families: Iterable[Family]) -> str:
    """Return the sources of the sheets."""
    heads = ("", "source", "stated", "derived", "chosen", "inferred", "facts with tests", "silent", "contradictory")
    facts, rows = conformance.tables(), []
    for family in families:
        count = trusts(family.sheet)
        silent = Counter("UND-" in quirk.id for quirk in quirks_of(family.parts[-1]))
        folder = listed(family.parts[0]).folder
        proven = sum("open" not in row and "later" not in row for row in facts[folder].facts.values())
        trust = (count[word] or "" for word in ("stated", "derived", "chosen", "inferred"))
        page = f"[{proven}](conformance_{folder}.md)"
        rows.append(
            (f"[{family.title}]({family.page}.md)", family.sheet.manual, *trust, page, silent[True], silent[False])
        )
    return table(heads, rows)


# ---------------------------------------------------------------------------------------------------------- the letters
def letters(parts: tuple[str, ...]) -> str:
    """Return the letters whose meanings differ between some parts."""
    sheets = [sheet_of(part) for part in parts]
    rows = []
    for letter in sorted({row.form for sheet in sheets for row in sheet.commands if row.form.isalpha()}):
        found = [sheet.commands.by_form.get(letter) for sheet in sheets]
        if len({row and row.description for row in found}) > 1:
            rows.append((f"`{letter}`", *(row.description if row else "–" for row in found)))
    return table(("", *(f"[{part.upper()}]({part}.md)" for part in parts)), rows)


def page() -> str:
    """Return the whole page."""
    heads = ("", *(f"[{family.title}]({family.page}.md)" for family in FAMILIES))
    having = table(heads, [(what, *(of(family) for family in FAMILIES)) for what, of in ROWS])
    tables = (
        (HEAD, table(("requirement", "part", "reason"), CHOICES)),
        (HAVE, having),
        (KNOWN, known(FAMILIES)),
        (LETTERS, letters(("cy500", "cy512", "cy525", "cy545"))),
    )
    return "\n".join(f"{says}\n{rows}" for says, rows in tables) + "\n"
