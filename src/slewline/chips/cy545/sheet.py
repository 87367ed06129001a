"""The CY545 and CY545B data sheets as data.  This file contains no behaviour, except `fitted`.

Only chapter 16 of the manual (edition of 22 March 1999) is available ("ch.16"); from the other chapters and the edition
of 2002, only individual facts are public ("ch.5", "2002 p.77").  "guide" is the selection guide in the
CY525 manual of 1984.

Facts that no legible page states are *inferred*.  They are marked, and a bench file can replace them: option
`inferred`.  Times are for a 12 MHz crystal, at which a machine cycle takes 1 µs; the chip counts clocks of its
crystal.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Literal

from ...core.datasheet.channel import AdaptiveLine, FlowBus
from ...core.datasheet.command_rows import TextRow
from ...core.datasheet.option import Option, defaulted
from ...core.datasheet.table import Arg, Limit, Pin, Register, Sheet, Table, Timing, Trust
from ...language.text import Verbatim
from ..cy5xx.family_options import clocks

PART, PART_B = "cy545", "cy545b"
REFERENCE_HZ = 12_000_000
MEMORY_BYTES = 1 << 16  # ch.16, External Memory
PAGE_BYTES = 256  # range of J, L, T and Z (ch.4)
POSITIONS = 1 << 24

# ------------------------------------------------------------------------------------------------------------- pins
# The numbers of the pins are in a chapter that is not at hand: 0.
PORT, MEMORY = "ch.16, The Parallel Handshake", "ch.16, External Memory"
HP, SWITCHES, SERIAL = "ch.16, HP LED Display", "ch.16, Thumbwheel Switch", "ch.16, The Serial Interface"
# fmt: off
PINS = (
    Pin(0, "io_request", "in", "low: a byte from the host is on the bus, or the host is ready for one", active=0, pull=1, tie=1, seen="between commands, and for each byte of a command", where=PORT, role="request"),
    Pin(0, "busy", "out", "low: a byte has been read, or is on the bus; a command is in progress", active=0, reset=1, sense=1, where=PORT, role="ready"),
    *(Pin(0, f"db{bit}", "both", f"data bus, bit {bit}: host, memory, display, switches; or user bit {bit + 8}", active=1, pull=1, where="ch.16; ch.6", role="data") for bit in range(8)),
    *(Pin(0, f"usrb{bit}", "both", f"user bit {bit}; high: an input, too", active=1, pull=1, reset=1, where="ch.6", reflex="stop sought", transcript=("", "")) for bit in range(6)),
    Pin(0, "usrb6", "both", "user bit 6; FPL, low: output for the host; or CTS, low: the host may send", active=1, pull=1, reset=1, sense=0, where="ch.16; ch.6", role="flow"),
    Pin(0, "usrb7", "both", "user bit 7; HP_SEL, low: the display is selected", active=1, pull=1, reset=1, sense=0, where="ch.16; ch.6", role="display_select"),
    Pin(0, "rxd", "in", "characters of the host", active=0, pull=1, tie=1, where=SERIAL, role="serial_in"),
    Pin(0, "txd", "out", "characters to the host", active=0, reset=1, where=SERIAL, role="serial_out"),
    Pin(0, "xmem_sel", "out", "low: the memory is selected; its fall latches the high address byte", active=0, reset=1, where=MEMORY, role="memory_select"),
    Pin(0, "sw_sel", "out", "low: the thumbwheel switches are selected", active=0, reset=1, where=SWITCHES, role="switch_select"),
    Pin(0, "ale", "out", "its fall latches the low address byte", active=1, reset=0, where=MEMORY, role="address_latch"),
    Pin(0, "rd", "out", "low: the selected device drives the bus", active=0, reset=1, where=MEMORY, role="read_strobe"),
    Pin(0, "wr", "out", "low: the selected device reads the byte on the bus", active=0, reset=1, where=MEMORY, role="write_strobe"),
    Pin(0, "pulse", "out", "low at the start of every step", active=0, reset=1, where="ch.16, PULSE and CCW", role="step"),
    Pin(0, "ccw", "both", "high: counter-clockwise; may be pulled low from outside", active=1, pull=1, reset=1, sense=0, seen="as a step begins", where="ch.16, PULSE and CCW", role="direction"),
    Pin(0, "stopped", "out", "low while the motor steps, and 5 ms longer", active=1, reset=1, sense=0, where="ch.16, STOPPED", role="moving"),
    Pin(0, "slew", "both", "low at the rate of R; pulled low before a motion: it is continuous", active=0, pull=1, reset=1, seen="before the first step of a motion", where="ch.16, SLEW", role="slewing", transcript=("at a steady rate", "")),
    Pin(0, "inhibit_abort", "in", "delays the start of a motion; decelerates a running one, and stops it at the first rate", active=0, pull=1, tie=1, seen="before the first step; at the end of every step", where="ch.16, INHIBIT_ABORT", role="abort", reflex="brake back", transcript=("hold or stop the motion", "")),
    Pin(0, "cw_limit", "in", "low: no step clockwise", active=0, pull=1, tie=1, seen="before every step", where="ch.16, CW_LIMIT and CCW_LIMIT", role="end_plus", reflex="stop up", transcript=("no step clockwise", "")),
    Pin(0, "ccw_limit", "in", "low: no step counter-clockwise", active=0, pull=1, tie=1, seen="before every step", where="ch.16, CW_LIMIT and CCW_LIMIT", role="end_minus", reflex="stop down", transcript=("no step counter-clockwise", "")),
    Pin(0, "jog", "both", "open: off; low: steps clockwise, driven high: counter-clockwise", seen="while no command is in progress", where="ch.16, JOG Mode", role="jog"),
    Pin(0, "reset", "in", "high: state at power-up", active=1, pull=0, tie=0, seen="level, high for 24 clocks", where="no readable page", role="reset", transcript=("the chip starts again", "the chip is held in reset"), trust="inferred"),
    Pin(0, "xtal1", "power", "crystal", where="ch.16, JOG Mode", trust="inferred"),
    Pin(0, "xtal2", "power", "crystal", where="ch.16, JOG Mode", trust="inferred"),
    Pin(0, "vcc", "power", "+5 V", where="ch.16, JOG Mode"),
    Pin(0, "vss", "power", "ground", where="ch.16, JOG Mode"),
)
EIGHT = ("pulse", "ccw", "stopped", "slew", "inhibit_abort", "cw_limit", "ccw_limit", "jog")  # "eight signals dedicated"

# --------------------------------------------------------------------------------------------------------- commands
COMMAND_US, PROGRAM_US, DIGIT_US = 100, 50, 20  # inferred, see TIMES
POSITION = Arg("position", 3, 0, POSITIONS - 1, unit="steps")
BIT = Arg("bit", 1, 0, 255)
TARGET = Arg("target", 1, 0, PAGE_BYTES - 1)


def _row(form: str, name: str, args: tuple[Arg, ...], description: str, where: str, *, motion: bool = False, flow: str = "n", role: str = "", trust: Trust = "stated", code: int = -1, terminated: bool = True, stored: bool = True, starts: bool = False) -> TextRow:
    return TextRow(form, name, args, COMMAND_US, description, where, program_us=PROGRAM_US, motion=motion, flow=flow, role=role, trust=trust, code=code, terminated=terminated, stored=stored, starts=starts)


COMMANDS = Table(
    _row("A", "ATPOSITION", (POSITION,), "set the current position, without motion", "ch.4", role="preset"),
    _row("B", "BIT", (BIT,), "set, clear, write, AND, OR user bits or bits of the data bus", "ch.6", role="bits"),
    _row("C", "CONTINUOUS", (), "the next motion runs until INHIBIT_ABORT ends it", "ch.4; ch.16, SLEW", role="endless_next"),
    _row("D", "DELAY", (Arg("delay", 2, 1, 65535, unit="ms at 12 MHz"),), "wait", "ch.10", role="delay"),
    _row("E", "ENTER", (), "store the following commands in memory, from the pointer on", "ch.7", role="enter"),
    _row("F", "FIRSTRATE", (Arg("rate", 1, 0, 255, unit="rate index"),), "rate at which every motion starts and ends; a twentieth of it for jog and home", "ch.5", role="start_rate"),
    _row("G", "GO", (), "take the number of steps set by N", "ch.4", motion=True, role="move"),
    _row("H", "HOME", (BIT,), "seek the edge of the home sensor", "ch.4; ch.16, Home Signal", motion=True, role="home"),
    _row("I", "INITIALIZE", (), "return to the state at power-up; ends a program", "ch.10", flow=""),
    _row("J", "JUMP", (TARGET,), "continue at a byte of this page", "ch.4", flow="t", starts=True, role="jump"),
    _row("L", "LOOP", (Arg("count", 1, 0, 255), TARGET), "branch until the count has run out", "ch.4; ch.10", flow="nt", role="loop", starts=True),
    _row("N", "NUMBER", (Arg("steps", 3, 0, POSITIONS - 1, unit="steps"),), "number of steps of a relative motion", "ch.4", role="distance"),
    _row("O", "MODE", (Arg("mode", 1, 0, 255),), "write the mode register", "ch.9"),
    _row("P", "POSITION", (POSITION,), "step to a position", "ch.4", motion=True, role="goto"),
    _row("Q", "QUIT", (), "end program entry; has no terminator", "ch.7; 2002, Binary format", terminated=False, stored=False, role="leave"),
    _row("R", "RATE", (Arg("rate", 1, 0, 255, unit="rate index"),), "highest step rate", "ch.5", role="top_rate"),
    _row("S", "SLOPE", (Arg("slope", 1, 1, 255),), "acceleration, 255 is steepest", "ch.5", role="ramp"),
    _row("T", "TIL", (BIT, TARGET), "branch until the bits match", "ch.4", flow="nt", starts=True, role="branch_bits"),
    _row("W", "WAIT", (BIT,), "wait until the bits match", "ch.4", role="wait_bits"),
    _row("X", "EXECUTE", (), "run the program at the pointer", "ch.4", role="run"),
    _row("Y", "POINTER", (Arg("target", 2, 0, MEMORY_BYTES - 1),), "set the memory pointer; in a program continue there", "ch.7", flow="t", role="pointer"),
    _row("Z", "LONGLOOP", (Arg("count", 2, 0, 65535), TARGET), "branch until the count, of 16 bits, has run out", "ch.4", flow="nt", role="loop", starts=True),
    _row("+", "CW", (), "direction clockwise", "ch.4", role="plus"),
    _row("-", "CCW", (), "direction counter-clockwise", "ch.4", role="minus"),
    _row("?", "QUERY", (), "query a parameter", "ch.14; 2002 p.37", role="question"),
    _row("0", "STOP", (), "stop the program", "ch.4", code=0x00, flow="", role="stop"),
    _row("[", "DISPLAY", (), "write values to addresses of the HP display", "ch.4; ch.16, HP LED Display"),
    _row('"', "STRING", (), "send characters to the display device", "ch.4; ch.14"),
)
MISSING = MappingProxyType({"U": "U is reserved", "V": "V is reserved", "M": "M is not a command", "K": "K is not in any list"})  # ch.4; command summary

# Digits of the answers to ? (ch.14; the letters other than P, N, R are inferred).
QUERIES = MappingProxyType({"P": 8, "N": 8, "R": 5, "F": 5, "S": 5, "O": 5, "Y": 5, "B": 5})
ASKED = MappingProxyType({"P": "position", "B": "user bits"})
ANSWER_BYTES = MappingProxyType({8: 3, 5: 2})  # the same in binary, high byte first (2002 p.37)
LISTING = "M"  # ? M,n: the pointer, then n lines of memory

# -------------------------------------------------------------------------------------------- arguments of B, T, W, H
# Bits 7 and 6 are the action, the others the operand (ch.6).  T, W and H: the table is a missing figure, inferred.
SET, CLEAR_BIT, DATA_BUS = 0x00, 0x10, 0x08  # below 40: one bit, by its number in the low three bits
OPCODES = MappingProxyType({0x40: "write", 0x80: "and", 0xC0: "or"})  # of bits 0 to 5
MATCHES = MappingProxyType({0x40: "equal", 0x80: "all", 0xC0: "any"})
NEGATED = 0x10  # bits that a slash inverts

# ------------------------------------------------------------------------------------------------------ mode register
MB_ASCII, MB_6, MB_CTS, MB_SHOW, MB_3, MB_HP, MB_LCD, MB_PARALLEL = 0x80, 0x40, 0x20, 0x10, 0x08, 0x04, 0x02, 0x01
MODE_BITS: Mapping[int, tuple[str, Trust]] = MappingProxyType({
    MB_ASCII: ("1: commands in ASCII, 0: in binary", "stated"),
    MB_6: ("not known: kept, without effect", "inferred"),
    MB_CTS: ("1: CTS on USRB6", "stated"),
    MB_SHOW: ("1: the position is shown after each step of jog and home", "stated"),
    MB_3: ("not known: kept, without effect", "inferred"),
    MB_HP: ("with MB0: 1: HP display, 0: parallel port", "inferred"),
    MB_LCD: ("without MB0: 1: LCD, 0: plain serial output", "inferred"),
    MB_PARALLEL: ("output is 1: parallel, 0: serial", "stated"),
})

CTS_IN_USE = (MB_CTS | MB_PARALLEL | MB_HP, *(MB_CTS | other for other in (0, MB_HP, MB_PARALLEL | MB_HP)))  # mask; FPL wins

# --------------------------------------------------------------------------------------------------------- registers
_RESET = "ch.10"
REGISTERS = (
    Register("number", 24, 200, "steps of a relative motion", "N", _RESET, unit="steps"),
    Register("rate", 8, 100, "highest rate", "R", _RESET, unit="rate index"),
    Register("firstrate", 8, 14, "first rate", "F", _RESET, unit="rate index"),
    Register("slope", 8, 220, "acceleration", "S", _RESET, unit="slope index"),
    Register("mode", 8, MB_ASCII, "mode register", "O", "ch.9", unit="bits"),
    Register("pointer", 16, 0, "memory pointer", "Y", "inferred from ch.10", unit="bytes"),
    Register("position", 24, 0, "absolute position", "A", _RESET, unit="steps"),
)

# ------------------------------------------------------------------------------------------------ rates, at 12 MHz
# No readable page has the table.  Known: 256 rates, 25 steps/s apart, then 50, then about 35 and increasing, since
# the period is then counted in machine cycles (2002 p.77); a twentieth is about 1 to about 1000 steps/s (ch.16, JOG);
# 27K at most (guide, which names no crystal).  From 1000 / 20 and a cycle of 1 µs follows the first of these tables,
# whose maximum is 27K at 16 MHz; from 27K at 12 MHz the second one.
CYCLE_TICKS = 12  # clocks of a machine cycle
RATES = 256


def rate_law(by_25: int, by_50: int, top: int) -> tuple[int, ...]:
    """Return the rates by rate index, 0 to 255, in whole steps/s at 12 MHz.

    The first rates are 25 or 50 steps/s apart.  For the remaining rates, a step takes a whole number of
    machine cycles.  These rates are rounded to whole steps/s, but the number of cycles can still be
    calculated from them exactly.

    Args:
        by_25: the number of rates after the first (20 steps/s) that are 25 steps/s above their predecessor.
        by_50: the number of rates after these that are 50 steps/s above their predecessor.
        top: the number of machine cycles that a step takes at index 255; among the remaining rates, a step
            takes one cycle more at each lower index.
    """
    slow = [20 + 25 * min(k, by_25) + 50 * max(k - by_25, 0) for k in range(by_25 + by_50 + 1)]
    fast = [round(REFERENCE_HZ / ((top + RATES - 1 - k) * CYCLE_TICKS)) for k in range(len(slow), RATES)]
    return (*slow, *fast)


TABLES: Mapping[str, tuple[int, ...]] = MappingProxyType({"20k": rate_law(36, 100, 50), "27k": rate_law(10, 113, 37)})
MAX_STEPS_PER_S = 40_000  # of a user's table, at 12 MHz: a step is longer than a pulse and its lead time
JOG_DIVISOR = 20  # of the first rate (ch.16, JOG Mode)
RAMP_UNIT_TICKS = 256 * CYCLE_TICKS  # a rate index takes 256 - S times this: 3906 * D / (256 - S) (2002 p.77)

# ------------------------------------------------------------------------------------------------------------- times
_T, _NONE = Timing, "no readable page"
TIMES = MappingProxyType({
    "busy_delay": _T(25, 12, "IO_REQUEST low to BUSY low", PORT),
    "busy_end": _T(25, 12, "IO_REQUEST high to BUSY high", _NONE, "inferred"),
    "output_delay": _T(25, 12, "IO_REQUEST low to BUSY low with a byte for the host", _NONE, "inferred"),
    "flow_lead": _T(5, 12, "FPL high to BUSY high (CY545B), or to BUSY low (CY545)", _NONE, "inferred"),
    "command": _T(COMMAND_US, 12, "a command of the host, from its last byte on", _NONE, "inferred"),
    "digit": _T(DIGIT_US, 12, "conversion of one digit", _NONE, "inferred"),
    "fetch": _T(20, 12, "a byte from memory, display or switches", _NONE, "inferred"),
    "program_command": _T(PROGRAM_US, 12, "a command of a program, after its last byte", _NONE, "inferred"),
    "store": _T(100, 12, "a byte into RAM, read back", _NONE, "inferred"),
    "verify_poll": _T(100, 12, "between two reads of a written byte", _NONE, "inferred"),
    "verify_timeout": _T(20_000, 12, "time within which a byte must read back correctly", _NONE, "inferred"),
    "millisecond": _T(1000, 12, "unit of D", "ch.10"),
    "wait_poll": _T(20, 12, "sampling interval of the bits in W", _NONE, "inferred"),
    "first_step": _T(100, 12, "G or P to the first PULSE", _NONE, "inferred"),
    "inhibit_release": _T(25, 12, "INHIBIT_ABORT high to the first PULSE that it has delayed", _NONE, "inferred"),
    "pulse_low": _T(5, 12, "PULSE low", _NONE, "inferred"),
    "ccw_lead": _T(20, 12, "CCW to the next PULSE", _NONE, "inferred"),
    "hold": _T(5000, 12, "end of the last step to STOPPED high", "ch.16, STOPPED"),
    "jog_test": _T(100, 12, "end of a command, or of a jog step, to the next sample of JOG", _NONE, "inferred"),
    "shortest_bit": _T(1e6 / 19200, 11, "a bit of the highest rate on RXD; 19200 baud at 11 MHz", SERIAL, "derived"),
    "longest_bit": _T(1e6 / 300, 11, "a bit of the lowest rate on RXD; 300 baud at 11 MHz", SERIAL, "derived"),
    "initialize": _T(1000, 12, "I", _NONE, "inferred"),
    "reset_pulse": _T(2, 12, "shortest RESET", _NONE, "inferred"),
})
US = 1_000_000  # ps
LIMITS = (
    Limit("io_request falls", "busy falls", "a byte from or to the host", PORT, typical=25 * US, mhz=12, given=(("stopped", 1),)),
    Limit("pulse falls", "pulse falls", "a step at the highest rate, 27K steps/s", "guide", least=37 * US, mhz=12, trust="inferred"),
    Limit("pulse falls", "pulse rises", "PULSE low", _NONE, typical=5 * US, mhz=12, trust="inferred"),
)

# ----------------------------------------------------------------------------------------------------------- options
BAUDS = tuple(300 << k for k in range(7))  # 300 to 19200 (ch.16, The Serial Interface)
BAUD_TOLERANCE = 0.03  # tolerance of a carriage return to a standard rate, and of two to each other (inferred)
POWER_UP_PS = 10_000_000_000  # RESET at power-up, when nothing drives it (inferred: no readable page)


def _rising(given: Sequence[int]) -> str:
    if len(given) not in (0, RATES):
        return f"{len(given)} numbers; allowed {RATES} or none"
    falls = [k for k in range(1, len(given)) if given[k] < given[k - 1]]
    return f"{given[falls[0]]} at {falls[0]} is below {given[falls[0] - 1]}; allowed ascending numbers" if falls else ""


LONGEST_TICKS = {"pulse_low": 200, "ccw_lead": 1000}  # shorter than a step at MAX_STEPS_PER_S, and than one of jog
INFERRED = (
    Option("rates", "ints", (), f"inferred: steps/s at 12 MHz by rate index, 0 to {RATES - 1}; none: those of `rate_table`", low=1, high=MAX_STEPS_PER_S, check=_rising, unit="steps/s", where="2002 p.77"),
    Option("ramp_unit", "int", RAMP_UNIT_TICKS, "inferred: duration of one rate index at S 255", low=1, high=1 << 20, unit="clocks", where="2002 p.77"),
    *(replace(row, high=LONGEST_TICKS.get(row.name, row.high)) for row in clocks({name: time for name, time in TIMES.items() if time.trust == "inferred"})),
)
OPTIONS = (
    Option("stepwise", "bool", False, "play every motion step by step instead of as a whole; slow, with identical edges"),
    Option("cold", "bool", False, "start without supply; `power(True)` powers up the chip"),
    Option("rate_table", "choice", "20k", "inferred: the rate table, by its top at 12 MHz (quirk CY545-CON-RATE-TOP)", choices=tuple(TABLES), where="ch.16, JOG; guide"),
    Option("ramp_jumps", "bool", True, "take all rate indices that are due when a step begins; otherwise at most one per step, as the CY525", where="2002 p.77"),
    Option("direction", "choice", "-", "inferred: the direction after reset", choices=("-", "+"), where="ch.10"),
    Option("fixed_baud", "choice", None, "inferred: a fixed baud rate instead of the adaptive one", choices=BAUDS, none=True, where=SERIAL),
    Option("autostart", "bool", False, "inferred: run the program at address 0 after reset", where="guide"),
    Option("inferred", "table", MappingProxyType({}), "facts that no readable page states: replace them where more is known", table=INFERRED),
)

# -------------------------------------------------------------------------------------------------------------- sheets
NOTES = MappingProxyType({
    "program": "64K bytes outside, none inside; loops of up to 64K passes; 16 lines for inputs and outputs (guide; the guide's 1.6M steps are 16,777,215, ch.4)",
    "limits": "the limit inputs are not a safety device: cut the power of the drivers independently (ch.16)",
    "errors": "the part has no error register (overview of the CY550)",
    "numbers": "pin numbers and electrical data are in chapters that are not readable",
})
SLIPS = MappingProxyType({
    **{letter: f"{description}: there is no such command" for letter, description in MISSING.items()},
    "\u00d8": "write the digit 0",
    "\u201c": 'write a straight quotation mark: "',
    "\u201d": 'write a straight quotation mark: "',
})
# fmt: on


def _sheet(part: str, title: str, flow: Literal["before", "after"], live: bool) -> Sheet:
    return Sheet(
        part=part,
        title=title,
        manual="CY545 manual, 22 March 1999, chapter 16, and public pages of the others; CY525 manual, 1984, selection guide",
        behaviour=2,
        crystal_hz=REFERENCE_HZ,
        crystal_low_hz=1_000_000,
        crystal_high_hz=16_000_000,
        pins=PINS,
        commands=COMMANDS,
        registers=REGISTERS,
        options=OPTIONS,
        rates=TABLES["20k"],
        times=TIMES,
        limits=LIMITS,
        buffer_bytes=MEMORY_BYTES,
        buffer_where="ch.16, External Memory",
        suffix=f".{part}",
        slips=SLIPS,
        notes=NOTES,
        dialect=Verbatim(queries=QUERIES, asked=ASKED, answer_bytes=ANSWER_BYTES, listing=LISTING, flips=NEGATED),
        channels=(
            FlowBus(ends=flow, live=live, in_use=(MB_PARALLEL | MB_HP, MB_PARALLEL)),
            AdaptiveLine(bauds=BAUDS, flow_pin="usrb6", in_use=CTS_IN_USE, answers=(MB_PARALLEL, 0), where=SERIAL),
        ),
        sections=MappingProxyType({"text": "ch.4", "reading": "ch.14", "running": "ch.7"}),
        key="ch. is a chapter of the manual of 1999, p. a page of that of 2002",
    )


CY545 = _sheet(PART, "CY545 stepper system controller", "before", live=False)
CY545B = _sheet(PART_B, "CY545B stepper system controller", "after", live=True)
DIFFERENCES = MappingProxyType(
    {  # differences of the CY545B (ch.16)
        "FPL": (
            "rises with the last byte put on the bus, before BUSY falls",
            "rises after IO_REQUEST of the last byte, before BUSY rises",
        ),
        "BUSY": ("low until a program has stopped", "high while a program runs"),
        "immediate commands": ("none while a program runs", "between two commands of a program, from either side"),
    }
)


def fitted(sheet: Sheet, options: Mapping[str, Any]) -> Sheet:
    """Return a copy of a sheet with the given options as its defaults, and with the rates that they select.

    Args:
        options: all options, already checked; the rates that they select are `inferred.rates` or the table
            named by `rate_table`.
    """
    rates = tuple(options["inferred"]["rates"]) or TABLES[options["rate_table"]]
    return replace(sheet, rates=rates, options=defaulted(sheet.options, options))
