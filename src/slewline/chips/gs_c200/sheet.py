"""The GS-C200 and GS-C200S as data, from their common data sheet (SGS-Thomson, June 1994).

The two modules differ in a few command rows and in the position counter; everything else is common.  The sheet
states rates and times, but no crystal, so the model counts picoseconds.  No surviving copy includes the figures; values
that only the figures showed are marked "chosen".
"""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

from ...core.datasheet.channel import SerialLine
from ...core.datasheet.command_rows import LineRow
from ...core.datasheet.option import Option
from ...core.datasheet.table import Arg, Limit, Pin, Register, Sheet, Table, Timing
from ...core.memory.store import STORE
from ...language.lines import Lines

LOCATIONS = 119
RATE_UNIT = 10  # steps/s; of S and T
LONGEST = 11  # characters before the carriage return: address, f-8388608, checksum
POSITIONS = MappingProxyType({"gs-c200": range(10_000_000), "gs-c200s": range(-(1 << 23), 1 << 23)})

# ------------------------------------------------------------------------------------------------- pin description
_PD = "pin description"
# fmt: off
PINS = (
    Pin(1, "sel0", "in", "protocol and address", pull=1, seen="at power-up", where=_PD),
    Pin(2, "sel1", "in", "protocol and address", pull=1, seen="at power-up", where=_PD),
    Pin(3, "sel2", "in", "protocol and address", pull=1, seen="at power-up", where=_PD),
    Pin(4, "br0", "in", "baud rate", pull=1, seen="at power-up", where=_PD),
    Pin(5, "br1", "in", "baud rate", pull=1, seen="at power-up", where=_PD),
    Pin(6, "br2", "in", "baud rate", pull=1, seen="at power-up", where=_PD),
    Pin(7, "chs", "in", "high: lines carry a checksum", active=1, pull=1, seen="at the carriage return", where=_PD),
    Pin(8, "gnd8", "power", "ground", where=_PD),
    Pin(9, "rec", "in", "low: recall the program and run it at power-up", active=0, pull=1, seen="at power-up", where=_PD),
    Pin(10, "test", "in", "for testing; wire it to pin 8", pull=1, tie=0, where=_PD),
    Pin(11, "rxd", "in", "received data, RS-232: high is space", active=1, pull=0, seen="level", where=_PD, role="serial_in"),
    Pin(12, "txd", "out", "transmitted data, RS-232: high is space", active=1, where=_PD, role="serial_out"),
    Pin(13, "txpd", "in", "pull-down for txd: on one module of a line", pull=0, where=_PD, role="serial_pull_down"),
    Pin(14, "rdy", "out", "open collector; low while a command or a program is in progress", active=0, tie=1, where=_PD, role="ready"),
    Pin(15, "vsl_minus", "power", "-12 V out, unregulated, 10 mA", where=_PD),
    Pin(16, "vsl_plus", "power", "+12 V out, unregulated, 10 mA", where=_PD),
    Pin(17, "vs17", "power", "supply, 12 to 40 V", where=_PD),
    Pin(18, "vs18", "power", "supply, 12 to 40 V", where=_PD),
    Pin(19, "gnd19", "power", "ground", where=_PD),
    Pin(20, "v5_20", "power", "+5 V out, 100 mA", where=_PD),
    Pin(21, "v5_21", "power", "+5 V out, 100 mA", where=_PD),
    Pin(22, "mov", "out", "high while a movement is executed", active=1, reset=0, where=_PD, role="moving"),
    Pin(23, "ramp", "out", "high while a ramp is executed", active=1, reset=0, where=_PD, role="ramping"),
    Pin(24, "enable", "in", "low holds the next step", active=1, pull=1, seen="just before each step", where=_PD, role="enable", reflex="hold", transcript=("no further step", "")),
    Pin(25, "nc25", "none", "not connected", where=_PD),
    Pin(26, "dir", "out", "high: clockwise", active=1, reset=1, where=_PD, role="direction"),
    Pin(27, "reset", "out", "resets the driver: low for 400 µs", active=0, reset=1, where=_PD, role="driver_reset", transcript=("the driver is reset", "")),
    Pin(28, "clock", "out", "a low pulse of 1.7 µs per step", active=0, reset=1, where=_PD, role="step", sense=1),
    Pin(29, "nc29", "none", "not connected", where=_PD),
    Pin(30, "home", "in", "low: at the home position", active=0, pull=1, seen="just before each step of a homing", where=_PD, role="home", reflex="stop back", transcript=("at the home position", "")),
    Pin(31, "uo1", "out", "user output 1", active=1, reset=0, where=_PD, role="output1", transcript=("", "")),
    Pin(32, "eot", "in", "low: at the end of travel", active=0, pull=1, seen="just before each step of a homing", where=_PD, role="end", reflex="stop out", transcript=("at the end of travel", "")),
    Pin(33, "uo2", "out", "user output 2", active=1, reset=0, where=_PD, role="output2", transcript=("", "")),
    Pin(34, "ui1", "in", "user input 1", pull=1, seen="by W, U, jc, G or g, V2", where=_PD, role="input1", transcript=("", "")),
    Pin(35, "uo3", "out", "user output 3", active=1, reset=0, where=_PD, role="output3", transcript=("", "")),
    Pin(36, "ui2", "in", "user input 2", pull=1, seen="by W, U, jc, G or g, V2", where=_PD, role="input2", transcript=("", "")),
    Pin(37, "ui3", "in", "user input 3", pull=1, seen="by W, U, jc, G or g, V2", where=_PD, role="input3", transcript=("", "")),
    Pin(38, "gnd38", "power", "ground", where=_PD),
)

# ------------------------------------------------------------------------------------------------------ serial port
PORT = SerialLine(
    bits=7, parity="odd", stop=2,
    baud_pins=("br0", "br1", "br2"),
    bauds=MappingProxyType({
        (0, 0, 0): 9600, (1, 0, 0): 4800, (0, 1, 0): 2400, (1, 1, 0): 1200,
        (0, 0, 1): 600, (1, 0, 1): 300, (0, 1, 1): 150, (1, 1, 1): 110,
    }),
    address_pins=("sel2", "sel1", "sel0"),  # the order of the printed table, whose first column toggles fastest
    addresses=MappingProxyType({
        (0, 0, 0): 7, (1, 0, 0): 6, (0, 1, 0): 5, (1, 1, 0): 4,
        (0, 0, 1): 3, (1, 0, 1): 2, (0, 1, 1): 1, (1, 1, 1): 0,
    }),
    checksum_pin="chs",
    where="baud rate programming; module address programming; data exchange protocol",
)
DIALECT = Lines(
    longest=LONGEST,
    answers=MappingProxyType({
        "Y": "accepted", "B": "busy", "R": "ready", "V": "the requested data", "END": "end of the listing",
        "E1": "parity, checksum or length", "E2": "argument missing, wrong or out of range", "E3": "program memory full",
        "E4": "unknown, or not allowed now", "E5": "the position counter overflowed", "E6": "the EEPROM failed",
    }),
    refusals=("E1", "E2", "E3", "E4", "E6"),
    where="data exchange protocol",
    opcodes="chosen",
)

# ----------------------------------------------------------------------------------------- commands, in states i, p, r
MS = 1000
OUTPUT, INPUT = Arg("output", 1, 1, 3), Arg("input", 1, 1, 3)
DIRECTION = Arg("direction", 1, -1, 1, sign="alone")
LOCATION = Arg("target", 1, 0, LOCATIONS - 1)
SPEED = Arg("speed", 3, 1, 1000, unit="10 steps/s")
SIGNED = Arg("position", 3, -(1 << 23), (1 << 23) - 1, sign="must")
_CD = "command descriptions"


def _stored(form: str, name: str, args: tuple[Arg, ...], description: str, *, room: int, head: str = "", code: int = -1, motion: bool = False, tail: tuple[str, ...] = (), when: str = "", flow: str = "n", role: str = "") -> LineRow:
    return LineRow(form, name, args, MS, description, _CD, program_us=MS, code=code, motion=motion, head=head, room=room, tail=tail, when=when, flow=flow, role=role)


def _immediate(form: str, name: str, description: str, *args: Arg, when: str, head: str = "", role: str = "", at_once: str = "", starts: bool = False) -> LineRow:  # fmt: skip
    return LineRow(form, name, args, MS, description, _CD, stored=False, head=head, when=when, role=role, at_once=at_once, starts=starts)


ROWS = (
    _stored("A", "ACTIVATE", (OUTPUT,), "user output high", room=2, role="output_high"),
    _stored("C", "CLEAR", (OUTPUT,), "user output low", room=2, role="output_low"),
    _stored("D", "DELAY", (Arg("delay", 1, 1, 255, unit="0.1 s"),), "wait", room=2, role="delay"),
    _immediate("E", "EXECUTE", "run the program from location 0; ends programming", when="ip", role="leave", starts=True),
    _immediate("F", "FEEDBACK", "ready or busy", when="ipr", role="state"),
    _immediate("H", "HOME", "find the home position", replace(DIRECTION, optional=True), when="i", role="home", starts=True),
    _immediate("K", "KILL", "end program and motion immediately", when="ir", at_once="stop"),
    _stored("L0", "LOOP_START", (), "start of a loop", room=2, head="L", code=ord("l"), tail=("0", "o"), role="mark"),
    _stored("L", "LOOP", (Arg("passes", 1, 1, 255),), "repeat from the loop start; the number counts all passes", room=2, flow="nl", role="loop"),
    _immediate("M", "MEMORIZE", "program to EEPROM", when="ip", role="store"),
    _immediate("Q", "QUERY", "list the program", when="ip", role="list"),
    _stored("R", "RAMP", (Arg("ramp", 3, 1, 999, unit="steps"),), "length of both ramps", room=4, role="ramp"),
    _stored("S", "START_STOP", (SPEED,), "start-stop speed", room=4, role="start_rate"),
    _stored("T", "TOP_SPEED", (SPEED,), "slew speed", room=4, role="top_rate"),
    _stored("U", "UNTIL", (INPUT,), "repeat the program until an input is low", room=2, flow="n0", role="branch_high"),
    _immediate("V", "VERIFY", "position (1) or user inputs and outputs (2)", Arg("what", 1, 1, 2), when="ip", role="question"),
    _stored("W", "WAIT", (INPUT,), "wait until an input is high", room=2, role="wait_high"),
    _immediate("X", "EXCHANGE", "EEPROM to program memory", when="ip", role="recall"),
    _immediate("Z", "ZERO_SPEED", "ramp down and end the program", when="ir", at_once="brake"),
    _stored("±", "MOVE", (Arg("steps", 3, -999_999, 999_999, sign="must", zero=False),), "move by a number of steps", room=4, code=ord("+"), motion=True, role="move"),
)
C200_ROWS = (
    _stored("G", "GOTO", (Arg("position", 3, 0, 9_999_999),), "move to a position", room=4, motion=True, role="goto"),
    _stored("G±", "VELOCITY", (DIRECTION,), "run until K or Z", room=4, head="G", code=ord("g"), motion=True, flow="", role="endless"),
    _stored("G±x", "CONTROLLED_VELOCITY", (DIRECTION, INPUT), "run until an input is low", room=4, head="G", code=ord("x"), motion=True, role="until_input"),
    _immediate("I", "INITIALIZE", "clear counter (1), user outputs (2), both (3)", Arg("what", 1, 1, 3), when="i", role="clear"),
    _immediate("P", "PROGRAM", "begin programming; erases the program", when="ip", role="enter"),
)
C200S_ROWS = (
    _stored("f", "FORCE", (SIGNED,), "preset the position counter", room=4, when="i", role="preset"),
    _stored("G", "GOTO", (replace(SIGNED, sign="may"),), "move to a position", room=4, motion=True, role="goto"),
    _stored("g±", "VELOCITY", (DIRECTION,), "run until K or Z", room=4, head="g", code=ord("g"), motion=True, flow="", role="endless"),
    _stored("g±x", "CONTROLLED_VELOCITY", (DIRECTION, INPUT), "run until an input is low", room=4, head="g", code=ord("x"), motion=True, role="until_input"),
    _stored("I", "INITIALIZE", (Arg("what", 1, 1, 3),), "clear counter (1), user outputs (2), both (3)", room=2, when="i", role="clear"),
    _stored("j", "JUMP", (LOCATION,), "continue at a location", room=2, flow="t", role="jump"),
    _stored("jc", "JUMP_ON", (Arg("inputs", 0, 0, 7), LOCATION), "continue at a location if the user inputs match", room=2, code=0x80, flow="nt", role="branch_inputs"),
    _immediate("Po", "PROGRAM", "begin programming; erases the program", when="ip", role="enter"),
    _immediate("Px", "PROGRAM_END", "end programming without a run", when="ip", role="leave"),
)
C200_ONLY, C200S_ONLY = ("P",), ("f", "g", "j", "jc", "Po", "P0", "Px")  # commands of only one of the parts; P0: Po, misread

# ------------------------------------------------------------------------------------------------ registers and times
REGISTERS = (
    Register("start_stop", 10, 0, "start-stop speed; 0: never set", "S", _CD, unit="10 steps/s"),
    Register("top_speed", 10, 0, "slew speed; 0: never set", "T", _CD, unit="10 steps/s"),
    Register("ramp", 10, 0, "ramp length; 0: never set", "R", _CD, unit="steps"),
    Register("position", 24, 0, "position counter", "", "position counter", unit="steps"),
    Register("user_inputs", 3, 7, "levels of UI3, UI2, UI1", "", "command V", unit="bits"),
    Register("user_outputs", 3, 0, "levels of UO3, UO2, UO1", "A", "commands A, V", unit="bits"),
)
PICOSECONDS = 1_000_000  # MHz: the model counts picoseconds
_T = Timing
TIMES = MappingProxyType({
    "clock": _T(1.7, PICOSECONDS, "CLOCK low; at most 5 µs", "pin 28; electrical characteristics"),
    "reset": _T(400, PICOSECONDS, "RESET low; at most 500 µs", "pin 27; electrical characteristics"),
    "dir_setup": _T(10, PICOSECONDS, "DIR and MOV to the first step", "figure 2", "chosen"),
    "delay_unit": _T(100 * MS, PICOSECONDS, "the unit of D", "command D"),
    "instruction": _T(MS, PICOSECONDS, "an instruction of a program, before its effect", "program examples", "chosen"),
    "turnround": _T(MS, PICOSECONDS, "carriage return to answer", "data exchange protocol", "chosen"),
    "release": _T(5, PICOSECONDS, "ENABLE high to the step that it held", "pin 24", "chosen"),
    "eeprom": _T(1_200_000, PICOSECONDS, "M with a full memory: 119 bytes and a check byte, 10 ms each", "command M", "chosen"),
})
US = PICOSECONDS  # ps
_EC = "electrical characteristics"
LIMITS = (
    Limit("clock falls", "clock rises", "CLOCK low", f"pin 28; {_EC}", typical=17 * US // 10, most=5 * US, symbol="tcpw"),
    Limit("reset falls", "reset rises", "RESET low", f"pin 27; {_EC}", typical=400 * US, most=500 * US, symbol="trpw"),
    Limit("clock falls", "clock falls", "a step, at 10000 steps/s", "motion characteristics", least=100 * US, trust="derived"),
)
# fmt: on

SUPPLY_VOLTS = (12, 40)
LOADS_MA = MappingProxyType({("v5_20", "v5_21"): 100, ("vsl_plus",): 10, ("vsl_minus",): 10})
RAMP_LAWS = ("constant acceleration", "linear in steps")


def _version(text: str) -> str:
    version = text.split(".")
    return "" if len(version) == 2 and all(map(str.isdigit, version)) else "a version is two numbers, such as '2.1'"


def _ramp_law(law: object) -> str:
    return "" if callable(law) else f"allowed {', '.join(RAMP_LAWS)}, or a function"


# ---------------------------------------------------------------------------------------------------------- options
# Choices that the data sheet leaves, and differences of modules; the defaults are in quirks.py.  A supply or a load
# beyond the limits of the sheet is a finding.
# fmt: off
OPTIONS = (
    STORE,
    Option("cold", "bool", False, "start without supply; `power(True)` powers up the module"),
    Option("firmware", "text", "2.2", "GS-C200 below 2.2: checksums without the bit that is always set", check=_version, like="'2.1'"),
    Option("address", "int", None, "address in place of the SEL straps; 0: point-to-point", low=0, high=7, none=True),
    Option("pin_order", "bool", False, "SEL in the order of the pin description"),
    Option("law", "object", RAMP_LAWS[0], "law of the ramps: a name, or a function", choices=RAMP_LAWS, check=_ramp_law),
    Option("turnround", "time", TIMES["turnround"].ticks, "carriage return to answer"),
    Option("instruction_time", "time", TIMES["instruction"].ticks, "time of an instruction of a program, before its effect", low=1),
    Option("dir_setup", "time", TIMES["dir_setup"].ticks, "DIR and MOV to the first step"),
    Option("eeprom_time", "time", TIMES["eeprom"].ticks, "time of M with a full memory; shorter for a shorter program"),
    Option("eeprom_fault", "bool", False, "programming the EEPROM fails"),
    Option("lenient", "bool", False, "accepts LF between lines, and P0 for Po"),
    Option("direct", "bool", False, "delayed commands act immediately outside programming"),
    Option("early_y", "bool", False, "M answers before it writes"),
    Option("pad7", "bool", False, "GS-C200: V1 with leading zeros"),
    Option("mov_hold", "bool", False, "MOV and RAMP high until the end of the last interval"),
    Option("plain_u", "bool", False, "U at location 0 is a plain test, too"),
    Option("nested_loops", "bool", False, "an L0 inside a loop begins a loop of its own"),
    Option("supply", "float", 24, "the supply voltage", unit="V"),
    Option("load", "table", {}, "current drawn from supply output pins", table=tuple(Option(pin, "float", 0, f"from pin {pin}", unit="mA") for pins in LOADS_MA for pin in pins)),
    Option("stepwise", "bool", False, "every motion step by step instead of whole; slow, with identical edges"),
)
# fmt: on
NOTES = MappingProxyType(
    {
        "logic levels": "inputs: low up to 0.8 V, high 2 to 5 V; outputs: low at most 0.8 V, high 2 to 5 V",
        "supply": "12 to 40 V (never above 42 V), 80 mA typical; 5 V out up to 100 mA, +/-12 V out up to 10 mA each",
        "limits": "0 to 50 degrees C in operation, -40 to 85 in storage, humidity 0 to 90 % without condensation",
        "isolation": "txd, rxd and ground through two optocouplers; R2 above 1000 ohm, from a source of 220 to 600 ohm",
    }
)


def _sheet(part: str, rows: tuple[LineRow, ...], foreign: tuple[str, ...], sign: str) -> Sheet:
    questions = {"position": ("V1", f"V({sign}[0-9]{{1,7}})"), "inputs and outputs": ("V2", "V([0-7][0-7])")}
    return Sheet(
        part=part,
        title=f"{part.upper()} intelligent stepper motor controller module",
        manual="GS-C200/GS-C200S data sheet, June 1994",
        behaviour=2,
        pins=PINS,
        commands=Table(*ROWS, *rows),
        registers=REGISTERS,
        options=OPTIONS,
        times=TIMES,
        limits=LIMITS,
        buffer_bytes=LOCATIONS,
        buffer_where="program storage area",
        suffix=f".{part}",
        notes=NOTES,
        dialect=replace(DIALECT, questions=MappingProxyType(questions)),
        channels=(PORT,),
        memory_unit="location",
        foreign=foreign,
        slips={"\u2193": "the data sheet prints \u2193 for the return key: leave it out"},
    )


GS_C200 = _sheet("gs-c200", C200_ROWS, C200S_ONLY, sign="")
GS_C200S = _sheet("gs-c200s", C200S_ROWS, C200_ONLY, sign="[+-]")
