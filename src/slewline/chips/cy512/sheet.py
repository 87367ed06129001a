"""The CY512 data sheet as data; this file contains no behaviour.

Its manual is not available: the only source is the CY525 manual of 1984, with its history (s.1), its comparison (s.3)
and its CY512 page and selection guide ("guide").

The comparison lists the features that are new or different in the CY525, which fits the CY512's socket; so everything
else is taken from the CY525's sheet.  Facts that no source states are *inferred*.  They are marked, and a bench file
can replace the numbers and choices in them: options `inferred.*`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from ...core.datasheet.command_rows import TextRow
from ...core.datasheet.option import Option
from ...core.datasheet.table import Arg, Limit, Pin, Table, Timing, Trust
from ..cy5xx import sheet
from ..cy5xx.family_options import at_power_up, clocks, slopes
from ..cy5xx.letters import exchanged

PART = "cy512"
BUFFER_BYTES = 48  # guide; s.4 and s.6 of the CY525 manual still name it
COMPARED = "s.3, comparison"
PAGE = "CY512 page"
TARGET = Arg("target", 1, 0, BUFFER_BYTES - 1)
RATE = Arg("rate", 1, 1, 255, alias=((256, 255),))  # "up to 256", in one byte
SLOPE, FACTOR, OFFSET = Arg("slope", 1, 0, 255), Arg("factor", 1, 1, 255), Arg("offset", 1, 0, 7)
DELAY = Arg("delay", 2, 1, 65535, unit="ms at 11 MHz")


def _alike(letter: str, *args: Arg) -> TextRow:
    """Return a CY525 command that the comparison does not list; `args`, if given, replace its arguments."""
    row: TextRow = sheet.COMMANDS[letter]
    return replace(row, args=args or row.args)


def _own(
    like: str,
    letter: str,
    name: str,
    args: tuple[Arg, ...],
    description: str,
    flow: str = "n",
    trust: Trust = "inferred",
    role: str = "",
) -> TextRow:
    """Return a command that the comparison lists, with the times of the CY525's command `like`."""
    time_us, where = sheet.COMMANDS[like].time_us, f"{COMPARED}; {PAGE}"
    return TextRow(letter, name, args, time_us, description, where, flow=flow, role=role, trust=trust)


# fmt: off
COMMANDS = Table(
    _own("B", "A", "ATHOME", (), "set the current position to zero", role="preset"),
    _alike("B"),
    _alike("C"),
    _own("X", "D", "DOITNOW", (), "run the program from its start", flow="0", trust="stated", role="run"),
    _alike("E"),
    _own("F", "F", "FACTOR", (FACTOR,), "divide the rate", role="rate_divisor"),
    _alike("G"),
    _own("H", "H", "HALFSTEP", (), "half steps, until I or RESET", trust="stated", role="half_steps"),
    _alike("I"),
    _alike("J", TARGET),
    _alike("L", Arg("count", 1, 0, 256), TARGET),  # guide: 256, which is 0 in a byte
    _alike("N"),
    _own("O", "O", "OFFSET", (OFFSET,), "phase pattern: 0-3 full steps, 4-7 the half step after each", role="phases"),
    _alike("P"),
    _alike("Q"),
    _own("R", "R", "RATE", (RATE,), "step rate", trust="stated", role="top_rate"),
    _own("S", "S", "SLOPE", (SLOPE,), "rise of the rate parameter with each step of a ramp; 0: no ramps; above 0 the factor becomes 1", role="ramp"),
    _own("T", "T", "TIL", (), "run the program from its start while DOWHILE is low", flow="n0", role="branch_low"),
    _alike("U"),
    _alike("V"),
    _alike("W"),
    _own("D", "X", "EXPEND", (DELAY,), "wait", trust="stated", role="delay"),
    _alike("+"),
    _alike("-"),
    _alike("0"),
)

# ---------------------------------------------------------------------------------------------------- pins: CY525, T.I
_ITS: Mapping[str, dict[str, Any]] = {
    "io_request": {"description": "byte strobe; low at the end of a step it ends the motion"},
    "abort": {"description": "ramp down to the lowest rate and stop", "trust": "inferred"},
    "step_inhibit": {"description": "high holds the next step, with PULSE high"},
    "ready": {"description": "high: ready for a byte, or a program runs; low while a byte, or the motion of a host command, is in progress"},
    "prog": {"in_out": "out", "pull": None, "description": "low during program entry", "seen": "", "transcript": ("program entry", "")},
    "io_select": {"description": "low: host writes, high: chip writes", "seen": "level; not in motion"},
}
PINS = (
    *(replace(pin, **_ITS.get(pin.name, {})) for pin in sheet.PINS),
    Pin(0, "terminate", "in", "low ends the current step; pin number not known", active=0, pull=1, tie=1, seen="during a step, except its first 125 µs", where=PAGE, trust="inferred"),
)

# ------------------------------------------------------------------------------------------------- rates, at 11 MHz
# This meets both stated rates: 5000 steps/s at R 255, and almost 8000 if TERMINATE ends every step.
FASTEST_TICKS, RATE_TICKS = 2200, 240  # clocks of a step at R 255, and added by each unit of R below: 16 cycles of 15 clocks
MIN_TICKS = 92 * 15  # of a step ended by TERMINATE
PERIODS = tuple(FASTEST_TICKS + (RATE.high - rate) * RATE_TICKS for rate in range(RATE.high + 1))  # R 0 ... 255

TIMES = MappingProxyType({
    **sheet.SLOPED_TIMES,
    "millisecond": Timing(1000, 11, "unit of X", COMPARED, "inferred"),
    "terminated": Timing(MIN_TICKS / 11, 11, "minimum duration of a step that TERMINATE cuts short", f"s.1; {PAGE}", "inferred"),
})

_EDGES = ("reset falls", "io_request falls", "ready falls", "run falls", "programmable_output rises", "programmable_output falls", "clk15 falls", "clk15 rises")
LIMITS = (
    *(limit for limit in sheet.LIMITS if limit.start in _EDGES),
    Limit("pulse falls", "pulse falls", "a step, at almost 8000 steps/s", f"s.1; {PAGE}", least=125_000_000, mhz=11, trust="derived"),
)

# ----------------------------------------------------------------------------------------------------------- options
ACTIONS = ("ramp", "stop")

INFERRED = (
    *slopes(PERIODS, MIN_TICKS, sheet.HALF_STEPS, f"{COMPARED} R"),
    *clocks({name: time for name, time in TIMES.items() if time.trust == "inferred"}),
    Option("held_pulse", "int", 1, "inferred: PULSE while STEP INHIBIT holds a step", low=0, high=1, where=f"{COMPARED} item 6"),
    Option("abort", "choice", "ramp", "inferred: effect of ABORT low", choices=ACTIONS, where="guide"),
    Option("request", "choice", "stop", "inferred: effect of I/O REQUEST low at the end of a step", choices=ACTIONS, where=f"guide; {COMPARED} item 9"),
)
OPTIONS = (
    *sheet.OPTIONS,
    Option("inferred", "table", {}, "facts that no source states: replace them where more is known", table=INFERRED),
    *at_power_up(sheet.SLOPED_REGISTERS),
)

VERIFY_BYTES = {0: 5, 1: BUFFER_BYTES, 2: 6, 3: 5}
SLIPS = MappingProxyType({
    **sheet.SLIPS,
    **exchanged(PART)["cy525"],
})

SHEET = sheet.socket(
    part=PART,
    title="CY512 intelligent positioning stepper motor controller",
    manual="CY525 manual, 1984: history, comparison, CY512 page, selection guide",
    pins=PINS,
    commands=COMMANDS,
    registers=sheet.SLOPED_REGISTERS,
    options=OPTIONS,
    rates=tuple(round(sheet.REFERENCE_HZ / ticks) for ticks in PERIODS),
    times=TIMES,
    limits=LIMITS,
    buffer_bytes=BUFFER_BYTES,
    buffer_where="guide",
    channels=(sheet.bus(VERIFY_BYTES),),
    suffix=".cy512",
    slips=SLIPS,
    sections=MappingProxyType({"text": "s.3", "reading": "s.6", "running": "s.7"}),
)
# fmt: on
