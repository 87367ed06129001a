"""CY500 data sheet as data.  No manual of it is at hand: "art." is a magazine article with its command set (tables 1
and 2), "CY525" the CY525 manual of 1984: its history, CY500 page and selection guide.  No behaviour in this file.

What no source states is *inferred*, most of it from the CY525, which fits the socket of the CY512, which agrees with
the CY500 in nine tenths of pins and instructions.  It is marked so, and a bench file replaces it: option `inferred`.
"""

from __future__ import annotations

from functools import partial
from types import MappingProxyType

from ...core.channel import BusHandshake
from ...core.option import Option
from ...core.table import Arg, Pin, Register, Row, Sheet, Table, Timing
from ...language.letters import Letters

BUS = "as the CY525"  # T.I there, s.7
_Pin = partial(Pin, trust="inferred")
# fmt: off
PINS = (
    _Pin(1, "io_request", "in", "byte strobe", active=0, tie=1, seen="level", where=BUS, role="request"),
    _Pin(2, "xtal1", "power", "crystal, LC or external clock", where=BUS),
    _Pin(3, "xtal2", "power", "crystal, LC or external clock", where=BUS),
    _Pin(4, "reset", "in", "power-up state", active=0, pull=1, tie=1, seen="level, low for 15 us at 6 MHz", where=BUS, role="reset", told=("the chip is held in reset", "the chip starts anew")),
    Pin(5, "nc5", "none", "not known"),
    _Pin(6, "abort", "in", "ends a motion behind the running step, without ramp", active=0, tie=1, seen="as a step begins", where=BUS, role="abort", told=("stop the motion", "")),
    _Pin(7, "vss7", "power", "ground", where=BUS),
    _Pin(8, "instrobe", "out", "low while a byte is read from the bus", active=0, reset=1, where=BUS, role="in_strobe"),
    Pin(9, "nc9", "none", "not known"),
    Pin(10, "nc10", "none", "not known; no read-out"),
    _Pin(11, "clk15", "out", "crystal frequency divided by 15", where=BUS, role="clock"),
    *(_Pin(12 + bit, f"db{bit}", "both", f"data bus, bit {bit}", active=1, where=BUS, role="data") for bit in range(8)),
    _Pin(20, "vss20", "power", "ground", where=BUS),
    *(_Pin(21 + n, f"phase{n + 1}", "out", f"stepper drive, phase {n + 1}: low energises", active=0, reset=1, where="art. text; as the CY525", role=f"phase{n + 1}") for n in range(4)),
    Pin(25, "nc25", "none", "not known"),
    _Pin(26, "vdd", "power", "+5 V", where=BUS),
    _Pin(27, "ready", "out", "high: ready for a byte, or a program runs; low while a byte or a motion of a command is in work", active=1, reset=1, where=BUS, role="ready"),
    Pin(28, "xss", "in", "external start/stop: low runs the motor in jog mode; T loops while it is low", active=0, pull=1, seen="as a step begins; by T", where="art. T.2 J, T", role="input2", told=("", "")),
    Pin(29, "xdir", "in", "external direction behind L; high: CW", active=1, pull=1, seen="as a step begins", where="art. T.2 L", told=("", "")),
    _Pin(30, "trigger", "in", "high holds the next step", active=1, pull=1, tie=0, seen="as a step begins", where="art. T.2 O; as the CY525", role="enable", sense=0, told=("", "no further step")),
    _Pin(31, "prog", "out", "low during program entry", active=0, reset=1, where="as the CY512", role="program_entry", told=("program entry", "")),
    _Pin(32, "run", "out", "low while a program runs (Int Req 2)", active=0, reset=1, where=BUS, role="running", told=("the program runs", "the program has ended")),
    Pin(33, "nc33", "none", "not known; no direction output"),
    Pin(34, "programmable_output", "out", "set by B, cleared by C", active=1, reset=1, where="art. T.2 B, C", role="output1", told=("", "")),
    _Pin(35, "pulse", "out", "low for the duration of a step", active=0, reset=1, where="art. T.2 L; as the CY525", role="step"),
    _Pin(36, "ascii_binary", "in", "high: ASCII decimal, low: binary", active=1, pull=1, seen="with each command letter", where="CY525 s.1", role="text", told=("binary commands", "ASCII commands")),
    _Pin(37, "motion_complete", "out", "falls after the last step (Int Req 1)", active=0, reset=1, where=BUS, role="motion_complete"),
    _Pin(38, "wait", "in", "tested by U (low)", active=0, pull=1, seen="polled every 8 us at 11 MHz by U", where="art. T.1, T.2 U; as the CY525", role="input1", told=("", "")),
    Pin(39, "nc39", "none", "not known; no read-out"),
    _Pin(40, "vcc", "power", "+5 V", where=BUS),
)

# fmt: on


# Busy times, at 6 MHz: those of the CY525's Table V for equal names, 375 us at 11 MHz for the others (inferred).  Of a
# command without argument the letter takes 187 us, and 26 us pass before READY falls.
def _us(at_11: int) -> int:
    return (at_11 * 11 + 3) // 6


_ALONE = 375 - 187 - 26
T2 = "art. T.1, T.2"
RATE_TOP = 253
# fmt: off
COMMANDS = Table(
    Row("A", "ATHOME",     (),                                     _us(_ALONE), "this place is position zero", T2),
    Row("B", "BITSET",     (),                                     _us(_ALONE), "programmable output high", T2),
    Row("C", "CLEARBIT",   (),                                     _us(_ALONE), "programmable output low", T2),
    Row("D", "DOITNOW",    (),                                     _us(_ALONE + 5), "run the program from its start", T2, flow="0", role="run"),
    Row("E", "ENTER",      (),                                     _us(_ALONE + 25), "enter program code", T2, role="enter"),
    Row("F", "FACTOR",     (Arg("factor", 1, 1, 255),),            _us(375), "divide the rate; not in a slope", T2),
    Row("G", "GOSTEP",     (),                                     _us(_ALONE + 285), "step as N or P says", T2, motion=True),
    Row("H", "HALFSTEP",   (),                                     _us(_ALONE), "half steps, until I or RESET", T2),
    Row("I", "INITIALIZE", (),                                     _us(_ALONE), "command mode, program and modes erased, coils off", T2, flow="", role="erase"),
    Row("J", "JOG",        (),                                     _us(_ALONE), "XSS low runs the motor, until I or RESET", T2),
    Row("L", "LEFTRIGHT",  (),                                     _us(_ALONE), "XDIR gives the direction, until I or RESET", T2),
    Row("N", "NUMBER",     (Arg("steps", 2, 1, 65535),),           _us(180), "number of steps of a relative move; right behind A one less", T2),
    Row("O", "ONESTEP",    (),                                     _us(_ALONE), "take one step at once", T2, motion=True),
    Row("P", "POSITION",   (Arg("position", 2, 0, 65535),),        _us(550), "target of an absolute move", T2),
    Row("Q", "QUIT",       (),                                     _us(175 - 26), "end program entry; never terminated", T2, terminated=False, stored=False, role="leave"),
    Row("R", "RATE",       (Arg("rate", 1, 1, RATE_TOP),),         _us(80), "maximum step rate", T2),
    Row("S", "SLOPE",      (Arg("slope", 1, 1, 255),),             _us(80), "ramps whose rate changes by so much a step", T2),
    Row("T", "TIL",        (),                                     _us(_ALONE + 5), "run the program from its start while XSS is low", T2, flow="n0"),
    Row("U", "UNTIL",      (),                                     _us(_ALONE + 5), "wait until WAIT is low", T2),
    Row("+", "CW",         (),                                     _us(_ALONE + 5), "direction clockwise", T2),
    Row("-", "CCW",        (),                                     _us(_ALONE + 5), "direction counter-clockwise", T2),
    Row("0", "COMMAND",    (),                                     _us(_ALONE + 225), "stop the program, command mode", T2, code=0x00, program_us=_us(36), flow="", role="stop"),
)
# fmt: on

REGISTERS = (
    Register("number", 16, 0, "steps of a relative move", "N", "art. T.2 N", unit="steps"),
    Register(
        "slope", 8, 0, "change of the rate parameter with each step of a ramp", "S", "art. T.2 S", unit="rate index"
    ),
    Register("rate", 8, 1, "maximum rate", "R", "art. T.2 R", unit="rate index"),
    Register("factor", 8, 1, "divisor of the rate", "F", "art. T.2 F", unit="times"),
    Register("position", 16, 0xA55A, "absolute position", "A", "art. T.2 A, P", unit="steps"),
)

_T = Timing
LETTER_US = 187
# fmt: off
TIMES = MappingProxyType({
    "instrobe_delay": _T(15, 11, "request low to INSTROBE low", BUS, "inferred"),
    "strobe_width": _T(1, 11, "INSTROBE low", BUS, "inferred"),
    "busy_delay": _T(10, 11, "strobe high to READY low", BUS, "inferred"),
    "letter": _T(LETTER_US, 11, "request low to READY high, byte without further work", BUS, "inferred"),
    "store": _T(162, 11, "READY low for the last byte of a command that is only stored", BUS, "inferred"),
    "effect_lead": _T(17, 11, "effect of a command to READY high", BUS, "inferred"),
    "digit": _T(40, 11, "conversion of one decimal digit", BUS, "inferred"),
    "first_instruction": _T(60, 11, "RUN low to the end of the first instruction", BUS, "inferred"),
    "wait_poll": _T(8, 11, "U looks at WAIT", BUS, "inferred"),
    "inhibit_poll": _T(3, 11, "a held step looks at TRIGGER", BUS, "inferred"),
    "pulse_high": _T(16, 6, "PULSE high between steps", "CY525 s.8", "inferred"),
    "step_lead": _T(10, 11, "READY low to the first step", BUS, "inferred"),
    "ready_after_motion": _T(30, 6, "MOTION COMPLETE low to READY high", BUS, "inferred"),
    "reset_pulse": _T(15, 6, "shortest RESET while running", BUS, "inferred"),
})
# fmt: on

# The rate equation is not printed.  Inferred: the period falls by the same 78.18 us with each unit of the parameter, as
# a preset timer would have it, from 50 steps/s at R 1 to 3350 at R 253, both exact (art. T.2 R); R 0 goes on below.
REFERENCE_HZ = 6_000_000
SLOWEST, FASTEST = REFERENCE_HZ // 50, (REFERENCE_HZ, 3350)  # clocks: a whole number, and a fraction
_UNITS = (RATE_TOP - 1) * FASTEST[1]  # the period at rate r is this many times a whole number of clocks
PERIODS = tuple(
    (2 * (SLOWEST * _UNITS - (r - 1) * (SLOWEST * FASTEST[1] - FASTEST[0])) + _UNITS) // (2 * _UNITS)
    for r in range(RATE_TOP + 1)
)

# phi1, phi2, phi3, phi4, 0 energises; clockwise goes up.  Full steps take every other row, from the first one on: the
# CY525's patterns; the half steps lie between them (inferred)
PHASES = (0b0101, 0b1101, 0b1001, 0b1011, 0b1010, 0b1110, 0b0110, 0b0111)

# fmt: off
INFERRED = (
    Option("periods", "ints", (), "clocks of a step by rate parameter, from 0 to 253; () is the model's law: 50 to 3350 steps/s, linear in the period", low=1001, high=1 << 24, check=lambda given: "" if len(given) in (0, RATE_TOP + 1) else f"{len(given)} periods; allowed {RATE_TOP + 1}, or none", where="art. T.2 R"),
    Option("ramp_start", "int", 1, "the rate parameter at which ramps start and end", low=1, high=RATE_TOP, where="art. T.2 S"),
    Option("phases", "ints", PHASES, "eight phase patterns, phase 1 in the high bit, 0 energises; full steps take every other one", low=0, high=15, check=lambda given: "" if len(given) == len(PHASES) else f"{len(given)} patterns; allowed {len(PHASES)}", where="art. text"),
    *(Option(name, "int", time.ticks, time.says, low=1, high=1000, unit="clocks", where=time.where) for name, time in TIMES.items()),
)
OPTIONS = (
    Option("stepwise", "bool", False, "play every motion step by step instead of whole; slow, and the same to the last edge"),
    Option("cold", "bool", False, "begin without supply; `power(True)` and RESET low for 10 ms bring the chip up"),
    Option("early_part", "bool", False, "a part of the first batch: N a multiple of 256 makes 256 steps too few (quirk UND-N256)", where="art. T.2 N"),
    Option("p_starts", "bool", False, "P starts the motion by itself, without G (quirk CON-P)", where="CY525 s.1"),
    *(Option(row.name, "int", row.default, f"at power-up: {row.says}; random in the part", low=0, high=(1 << row.bits) - 1, where=row.where) for row in REGISTERS),
    Option("inferred", "table", MappingProxyType({}), "what no source states, and the model infers: replace it where you know better", table=INFERRED),
)
# fmt: on

# How the article prints commands, and what the sister parts call otherwise
SLIPS = MappingProxyType(
    {
        "o": "the article prints o for the digit zero: write 0",
        "V": "the CY500 shows nothing of itself: it has no read-out",
        "W": "the CY500 waits for WAIT low only: U",
        "X": "the CY500 runs its program with D, and has no delay",
        "Z": "slopes of the CY500 have no divisor",
    }
)

POWER_UP = 10_000_000_000, 71_355_817_782  # ps of RESET low, and of its capacitor, as the CY525 (s.9, fig. 9.1)

SHEET = Sheet(
    part="cy500",
    title="CY500 stored program stepper motor controller",
    manual="a magazine article with the command set (no date); CY525 manual, 1984, about its predecessors",
    crystal_hz=REFERENCE_HZ,
    crystal_low_hz=1_000_000,
    crystal_high_hz=REFERENCE_HZ,
    pins=PINS,
    commands=COMMANDS,
    registers=REGISTERS,
    options=OPTIONS,
    rates=tuple(REFERENCE_HZ // period for period in PERIODS),
    times=TIMES,
    buffer_bytes=18,
    buffer_where="CY525 selection guide",
    suffix=".cy500",
    slips=SLIPS,
    dialect=Letters(),
    channels=(BusHandshake(),),
    sections=MappingProxyType({"text": "art. text", "running": "art. text"}),
    key="art. is the article, T. a table of it; s. is a section of the CY525 manual",
    notes=MappingProxyType(
        {"supply": "5 V; 40 pins", "instructions": "22 here; 24 on the data sheet page, 21 in the selection guide"}
    ),
)
