"""The CY500 data sheet as data; this file contains no behaviour.

The CY500's manual is not available.  "art." is a magazine article with the chip's command set (tables 1
and 2); "CY525" is the CY525 manual of 1984, with its history, CY500 page and selection guide.

Facts that no source states are *inferred*, most of them from the CY525.  The CY525 fits the socket of the CY512, which
shares nine tenths of its pins and instructions with the CY500.  Inferred facts are marked, and a bench file can
replace them: option `inferred`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import Any

from ...core.datasheet.command_rows import TextRow
from ...core.datasheet.option import Option
from ...core.datasheet.table import Arg, Pin, Table
from ..cy5xx import sheet
from ..cy5xx.family_options import at_power_up, clocks, slopes
from ..cy5xx.letters import exchanged

PART = "cy500"
REFERENCE_HZ = 6_000_000
RATE_TOP = 253
BUS = "as the CY525"  # T.I there, s.7
T2 = "art. T.1, T.2"
_Pin = partial(Pin, trust="inferred")

# fmt: off
_OWN = (
    *(Pin(number, f"nc{number}", "none", description) for number, description in ((5, "not known"), (9, "not known"), (10, "not known; no read-out"), (25, "not known"), (33, "not known; no direction output"), (39, "not known; no read-out"))),
    Pin(28, "xss", "in", "external start/stop: low runs the motor in jog mode; T loops while it is low", active=0, pull=1, seen="as a step begins; by T", where="art. T.2 J, T", role="input2", transcript=("", "")),
    Pin(29, "xdir", "in", "external direction after L; high: CW", active=1, pull=1, seen="as a step begins", where="art. T.2 L", transcript=("", "")),
    _Pin(30, "trigger", "in", "high holds the next step", active=1, pull=1, tie=0, seen="as a step begins", where="art. T.2 O; as the CY525", role="enable", sense=0, reflex="hold", transcript=("", "no further step")),
    _Pin(31, "prog", "out", "low during program entry", active=0, reset=1, where="as the CY512", role="program_entry", transcript=("program entry", "")),
)
_ITS: Mapping[str, dict[str, Any]] = {  # different from the CY525
    "io_request": {"description": "byte strobe", "seen": "level"},
    "abort": {"description": "ends a motion after the current step, without a ramp", "reflex": "stop", "seen": "as a step begins"},
    "ready": {"description": "high: ready for a byte, or a program runs; low while a byte, or the motion of a host command, is in progress"},
    "programmable_output": {"where": "art. T.2 B, C", "trust": "stated"},
    "pulse": {"where": "art. T.2 L; as the CY525"},
    "wait": {"description": "tested by U (low)", "active": 0, "sense": 0, "seen": "polled every 8 µs at 11 MHz by U", "where": "art. T.1, T.2 U; as the CY525"},
    "ascii_binary": {"where": "CY525 s.1"},
    **{f"phase{n}": {"where": "art. text; as the CY525"} for n in (1, 2, 3, 4)},
}
_NUMBERS = {pin.number for pin in _OWN}
_BOTH = [replace(pin, **{"where": BUS, "trust": "inferred"} | _ITS.get(pin.name, {})) for pin in sheet.PINS if pin.number not in _NUMBERS]
PINS = tuple(sorted((*_OWN, *_BOTH), key=lambda pin: pin.number))


# Busy times, in clocks those of the CY525's Table V for equal names and arguments (inferred).
def _us(at_11: int) -> int:
    return (at_11 * 11 + 3) // 6


def _row(letter: str, name: str, description: str, *args: Arg, like: str = "", **its: Any) -> TextRow:
    """Return a command; columns not given are those of the CY525 command `like`, by default `letter`."""
    row: TextRow = sheet.COMMANDS[like or letter]
    both: dict[str, Any] = {"time_us": _us(row.time_us), "where": T2, "code": -1} | its
    return replace(row, form=letter, name=name, description=description, args=args, **both)


COMMANDS = Table(
    _row("A", "ATHOME", "set the current position to zero", like="B", role="preset"),
    _row("B", "BITSET", "programmable output high"),
    _row("C", "CLEARBIT", "programmable output low"),
    _row("D", "DOITNOW", "run the program from its start", like="X"),
    _row("E", "ENTER", "enter program code"),
    _row("F", "FACTOR", "divide the rate; not in a slope", Arg("factor", 1, 1, 255), like="A", role="rate_divisor"),
    _row("G", "GOSTEP", "take the steps that N or P specifies"),
    _row("H", "HALFSTEP", "half steps, until I or RESET", role="half_steps"),
    _row("I", "INITIALIZE", "command mode, program and modes erased, coils off"),
    _row("J", "JOG", "XSS low runs the motor, until I or RESET", like="B", role=""),
    _row("L", "LEFTRIGHT", "XDIR sets the direction, until I or RESET", like="B", role=""),
    _row("N", "NUMBER", "number of steps of a relative move; right after A, one less", Arg("steps", 2, 1, 65535)),
    _row("O", "ONESTEP", "take one step immediately", like="B", motion=True, role="single"),
    _row("P", "POSITION", "target of an absolute move", Arg("position", 2, 0, 65535), motion=False, role="target"),
    _row("Q", "QUIT", "end program entry; has no terminator"),
    _row("R", "RATE", "maximum step rate", Arg("rate", 1, 1, RATE_TOP)),
    _row("S", "SLOPE", "ramps; the rate changes by this much at each step", Arg("slope", 1, 1, 255)),
    _row("T", "TIL", "run the program from its start while XSS is low", flow="n0", role="branch_low"),
    _row("U", "UNTIL", "wait until WAIT is low"),
    _row("+", "CW", "direction clockwise"),
    _row("-", "CCW", "direction counter-clockwise"),
    _row("0", "COMMAND", "stop the program, command mode", code=0x00, program_us=_us(36)),
)

REGISTERS = tuple(replace(row, where=f"art. T.2 {row.letter}") for row in sheet.SLOPED_REGISTERS)
_DESCRIPTIONS = {"strobe_width": "INSTROBE low", "effect_lead": "effect of a command to READY high", "wait_poll": "sampling interval of WAIT in U", "inhibit_poll": "sampling interval of TRIGGER while a step is held", "step_lead": "READY low to the first step"}
TIMES = MappingProxyType({name: replace(time, description=_DESCRIPTIONS.get(name, time.description), where=BUS, trust="inferred") for name, time in sheet.SLOPED_TIMES.items() if name != "millisecond"})

# The rate equation is not printed.  Inferred: the period falls by the same 78.18 µs with each unit of the parameter, as
# with a preset timer, from 50 steps/s at R 1 to 3350 at R 253, both exact (art. T.2 R); R 0 continues below.
SLOWEST, FASTEST = REFERENCE_HZ // 50, (REFERENCE_HZ, 3350)  # clocks: a whole number, and a fraction
_UNITS = (RATE_TOP - 1) * FASTEST[1]  # the period at rate r is this many times a whole number of clocks
PERIODS = tuple(
    (2 * (SLOWEST * _UNITS - (r - 1) * (SLOWEST * FASTEST[1] - FASTEST[0])) + _UNITS) // (2 * _UNITS)
    for r in range(RATE_TOP + 1)
)

OPTIONS = (
    *sheet.OPTIONS,
    Option("early_part", "bool", False, "a chip of the first batch: if N is a multiple of 256, it takes 256 steps too few (quirk UND-N256)", where="art. T.2 N"),
    Option("p_starts", "bool", False, "P starts the motion by itself, without G (quirk CON-P)", where="CY525 s.1"),
    *at_power_up(REGISTERS),
    Option("inferred", "table", MappingProxyType({}), "facts that no source states and the model infers: replace them where you have better data", table=(*slopes(PERIODS, 1001, sheet.HALF_STEPS, "art. T.2 R"), *clocks(TIMES))),
)
# fmt: on

SLIPS = MappingProxyType(
    {"o": "the article prints o for the digit zero: write 0", **exchanged(PART)["cy512"], **exchanged(PART)["cy525"]}
)

SHEET = sheet.socket(
    part=PART,
    title="CY500 stored program stepper motor controller",
    manual="a magazine article with the command set (no date); CY525 manual, 1984, about its predecessors",
    crystal_hz=REFERENCE_HZ,
    crystal_high_hz=REFERENCE_HZ,
    pins=PINS,
    commands=COMMANDS,
    registers=REGISTERS,
    options=OPTIONS,
    rates=tuple(REFERENCE_HZ // period for period in PERIODS),
    times=TIMES,
    limits=(),
    buffer_bytes=18,
    buffer_where="CY525 selection guide",
    suffix=".cy500",
    slips=SLIPS,
    sections=MappingProxyType({"text": "art. text", "running": "art. text"}),
    key="art. is the article, T. one of its tables; s. is a section of the CY525 manual",
    notes=MappingProxyType(
        {"supply": "5 V; 40 pins", "instructions": "22 here; 24 on the data sheet page, 21 in the selection guide"}
    ),
)
