"""Data common to parts that fit one 40-pin socket: pins, commands, and times printed in a 1984 manual.

The sheets of the parts begin with this data and state their differences; the two parts whose rate grows
by S with each step (sloped.py) also share registers and half steps.  Data only.

Each time applies to the crystal that the manual names with it; the chip counts crystal clocks, so
every time scales with the crystal.  "T.V" is the manual's Table V, "s.7" its section 7.
"""

from __future__ import annotations

from functools import partial
from types import MappingProxyType

from ...core.datasheet.channel import BusHandshake
from ...core.datasheet.command_rows import TextRow
from ...core.datasheet.option import Option
from ...core.datasheet.table import Arg, Limit, Pin, Register, Sheet, Table, Timing
from ...language.text import Letters

REFERENCE_HZ = 11_000_000
BUFFER_BYTES = 60  # s.5; the 48 of s.6 belongs to the CY512
LABELS = "ABCDE"  # s.3

# ---------------------------------------------------------------------------------------------------- pins, Table I
HANDSHAKE = "T.I; s.7"
# fmt: off
PINS = (
    Pin(1, "io_request", "in", "byte strobe; rate request while slewing; ends W and U", active=0, tie=1, seen="level; once per step in motion", where=HANDSHAKE, role="request"),
    Pin(2, "xtal1", "power", "crystal, LC or external clock", where="T.I; s.9"),
    Pin(3, "xtal2", "power", "crystal, LC or external clock", where="T.I; s.9"),
    Pin(4, "reset", "in", "power-up state", active=0, pull=1, tie=1, seen="level, low for 15 µs at 6 MHz", where="T.I; s.9", role="reset", transcript=("the chip is held in reset", "the chip starts again")),
    Pin(5, "nc5", "none", "leave open", where="T.I"),
    Pin(6, "abort", "in", "ramp down to the first rate, then stop if still low", active=0, tie=1, seen="once per step, at its start", where="T.I; s.7", role="abort", reflex="brake", transcript=("stop the motion", "")),
    Pin(7, "vss7", "power", "ground", where="T.I"),
    Pin(8, "instrobe", "out", "low while a byte is read from the bus", active=0, reset=1, where=HANDSHAKE, role="in_strobe"),
    Pin(9, "nc9", "none", "leave open", where="T.I"),
    Pin(10, "outstrobe", "out", "rises when a byte on the bus is valid", active=0, reset=1, where=HANDSHAKE, role="out_strobe"),
    Pin(11, "clk15", "out", "crystal frequency divided by 15", where="T.I; s.13", role="clock"),
    *(Pin(12 + bit, f"db{bit}", "both", f"data bus, bit {bit}", active=1, where="T.I", role="data") for bit in range(8)),
    Pin(20, "vss20", "power", "ground", where="T.I"),
    *(Pin(21 + n, f"phase{n + 1}", "out", f"stepper drive, phase {n + 1}: low energises", active=0, reset=1, where="T.I; s.7", role=f"phase{n + 1}") for n in range(4)),
    Pin(25, "nc25", "none", "leave open", where="T.I"),
    Pin(26, "vdd", "power", "+5 V", where="T.I"),
    Pin(27, "ready", "out", "high: ready for a byte; low while a byte or a motion is in progress", active=1, reset=1, where="T.I; s.2", role="ready"),
    Pin(28, "dowhile", "in", "tested by T: low branches", active=0, pull=1, seen="by T", where="T.I", role="input2", transcript=("", "")),
    Pin(29, "slew", "out", "low at a steady rate", active=0, reset=1, where="T.I; s.7", role="slewing", transcript=("at a steady rate", "")),
    Pin(30, "step_inhibit", "in", "high holds the next step", active=1, pull=1, tie=0, seen="in the time-out of every step", where="T.I; s.7", role="enable", sense=0, reflex="hold", transcript=("", "no further step")),
    Pin(31, "prog", "both", "low during program entry; pulled low it admits live commands", active=0, pull=1, reset=1, seen="between instructions", where="T.I; s.7", role="program_entry", transcript=("program entry, or live commands", "")),
    Pin(32, "run", "out", "low while a program runs (Int Req 2)", active=0, reset=1, where="T.I", role="running", transcript=("the program runs", "the program has ended")),
    Pin(33, "direction", "out", "high: CW, low: CCW", active=1, reset=1, where="T.I; s.7", role="direction"),
    Pin(34, "programmable_output", "out", "set by B, cleared by C", active=1, reset=1, where="T.I", role="output1", transcript=("", "")),
    Pin(35, "pulse", "out", "low for the duration of a step", active=0, reset=1, where="T.I; s.8", role="step"),
    Pin(36, "ascii_binary", "in", "high: ASCII decimal, low: binary", active=1, pull=1, seen="with each command letter", where="T.I; s.5", role="text", transcript=("binary commands", "ASCII commands")),
    Pin(37, "motion_complete", "out", "falls after the last step (Int Req 1)", active=0, reset=1, where="T.I; s.2", role="motion_complete"),
    Pin(38, "wait", "in", "tested by W (high) and U (low)", active=1, pull=1, seen="polled every 8 µs by W and U", where="T.I", role="input1", transcript=("", "")),
    Pin(39, "io_select", "in", "low: host writes, high: chip writes; position read-out while stepping", active=1, tie=0, seen="level; once per step in motion", where="T.I; s.7", role="select"),
    Pin(40, "vcc", "power", "+5 V", where="T.I"),
)
# fmt: on

# ------------------------------------------------------------------------------------------------- commands, Table V
# Commands without argument: Table V states letter plus terminator, of which the letter takes LETTER_US; with argument
# it states the busy time of the last byte.  `time_us` is the busy time of the last byte in both cases.
LETTER_US = 187
_BUSY_US = 26  # from the request to READY low
TARGET = Arg("target", 1, 0, BUFFER_BYTES - 1, label=True)


def _alone(total_us: int) -> int:
    return total_us - LETTER_US - _BUSY_US


# fmt: off
COMMANDS = Table(
    TextRow("A", "ABSOLUTE",   (Arg("position", 2, 0, 65535),),           375, "set the current position", "s.3; T.V", role="preset"),
    TextRow("B", "BITSET",     (),                                _alone(375), "programmable output high", "s.3; T.V", role="output_high"),
    TextRow("C", "CLEARBIT",   (),                                _alone(375), "programmable output low", "s.3; T.V", role="output_low"),
    TextRow("D", "DELAY",      (Arg("delay", 2, 1, 65535, unit="ms at 11 MHz"),), 100, "wait", "s.3; T.V", role="delay"),
    TextRow("E", "ENTER",      (),                                _alone(400), "enter program code", "s.3; T.V", role="enter"),
    TextRow("F", "FIRSTRATE",  (Arg("rate", 1, 0, 127),),                 240, "rate at which every move starts and ends", "s.3; T.V", role="start_rate"),
    TextRow("G", "GO",         (),                                _alone(660), "take the number of steps set by N", "s.3; T.V", motion=True, role="move"),
    TextRow("H", "HALTMODE",   (),                                _alone(375), "the next motion runs until aborted", "s.3; T.V", role="endless_next"),
    TextRow("I", "INITIALIZE", (),                                _alone(375), "erase the program, coils off, CW, command mode", "s.3; T.V", flow="", role="erase"),
    TextRow("J", "JUMP",       (TARGET,),                                 100, "continue at a byte of the program", "s.3; T.V", flow="t", starts=True, role="jump"),
    TextRow("L", "LOOP",       (Arg("count", 1, 1, 255), TARGET),         150, "branch until the count has run out", "s.3; T.V", flow="nt", role="loop", starts=True),
    TextRow("N", "NUMBER",     (Arg("steps", 2, 1, 65535),),              180, "number of steps of a relative move", "s.3; T.V", role="distance"),
    TextRow("O", "OFFSET",     (Arg("offset", 1, 0, 255),),                80, "0-3: phase pattern; above 3: phases off, above 127 with a pulse", "s.3; T.V", role="phases"),
    TextRow("P", "POSITION",   (Arg("position", 2, 0, 65535),),           550, "step to an absolute position", "s.3; T.V", motion=True, role="absolute"),
    TextRow("Q", "QUIT",       (),                           175 - _BUSY_US,   "end program entry; has no terminator", "s.3; T.V", terminated=False, stored=False, role="leave"),
    TextRow("R", "RATE",       (Arg("rate", 1, 0, 127),),                  80, "maximum step rate", "s.3; T.V", role="top_rate"),
    TextRow("S", "SLOPE",      (Arg("slope", 1, 1, 255),),                 80, "acceleration, 255 is steepest", "s.3; T.V", role="ramp"),
    TextRow("T", "TIL",        (TARGET,),                         _alone(380), "branch while DOWHILE is low", "s.3; T.V", flow="nt", starts=True, role="branch_low"),
    TextRow("U", "UNTIL",      (),                                _alone(380), "wait until WAIT is low", "s.3; T.V", role="wait_low"),
    TextRow("V", "VERIFY",     (Arg("group", 1, 0, 3),),                  125, "select a group for read-out", "s.6; T.V", role="read"),
    TextRow("W", "WAIT",       (),                                _alone(380), "wait until WAIT is high", "s.3; T.V", role="wait_high"),
    TextRow("X", "EXECUTE",    (),                                _alone(380), "run the program from its start", "s.3; T.V", flow="0", role="run"),
    TextRow("Z", "DIVISOR",    (Arg("divisor", 1, 1, 255),),              180, "divide the slope", "s.3; T.V", role="ramp_divisor"),
    TextRow("+", "CW",         (),                                _alone(380), "direction clockwise", "s.3; T.V", role="plus"),
    TextRow("-", "CCW",        (),                                _alone(380), "direction counter-clockwise", "s.3; T.V", role="minus"),
    TextRow("0", "COMMAND",    (),                                _alone(600), "stop the program, command mode", "s.3; s.5; T.V", code=0x00, program_us=36, flow="", role="stop"),
)
# fmt: on

# ------------------------------------------------------------------------------------------------------------- times
_T = Timing
# fmt: off
TIMES = MappingProxyType({
    "instrobe_delay": _T(15, 11, "request low to INSTROBE low", "s.7, fig. 7.3", "chosen"),
    "strobe_width": _T(1, 11, "INSTROBE and OUTSTROBE low", "s.7, fig. 7.3", "chosen"),
    "busy_delay": _T(10, 11, "strobe high to READY low", "s.7, fig. 7.3", "chosen"),
    "letter": _T(LETTER_US, 11, "request low to READY high, for a byte that needs no further processing", "s.7 (at most 200 µs)", "derived"),
    "store": _T(188 - _BUSY_US, 11, "READY low for the last byte of a command that is only stored", "s.7, fig. 7.2", "derived"),
    "effect_lead": _T(17, 11, "effect of a command to READY high; puts RUN low 150 µs after X is accepted", "s.7, fig. 7.5", "derived"),
    "digit": _T(40, 11, "conversion of one decimal digit", "T.V note c", "chosen"),
    "millisecond": _T(1000, 11, "unit of D", "s.3 D"),
    "first_instruction": _T(60, 11, "RUN low to the end of the first instruction", "s.7, fig. 7.6"),
    "wait_poll": _T(8, 11, "sampling interval of WAIT in W and U", "s.10 (in step to 10 µs)", "chosen"),
    "inhibit_poll": _T(3, 11, "sampling interval of STEP INHIBIT while a step is held", "s.7", "chosen"),
    "pulse_high": _T(2.5, 11, "PULSE high between steps", "s.3 item 6"),
    "step_lead": _T(10, 11, "READY low and DIRECTION set to the first step", "s.2, s.7: just before stepping", "chosen"),
    "ready_after_motion": _T(30, 6, "MOTION COMPLETE low to READY high", "s.11, fig. 11.4"),
    "readout_delay": _T(4, 11, "step start to the first OUTSTROBE low", "s.6, fig. 6.5", "chosen"),
    "readout_spacing": _T(10, 11, "between the two OUTSTROBE of a read-out; MOTION COMPLETE low", "s.6, fig. 6.5", "chosen"),
    "readout_stretch": _T(20, 11, "a read-out while ramping lengthens the step", "s.6 note"),
    "reset_pulse": _T(15, 6, "shortest RESET while running", "s.9"),
    "phase_pulse": _T(20, 11, "PULSE low of O above 127", "s.3 O", "chosen"),
    "slew_blink": _T(10, 11, "SLEW high when the zero rate is taken", "s.7", "chosen"),
})
# fmt: on
NS, US = 1000, 1_000_000  # ps
# fmt: off
# The manual's limits between edges.  The step period is that of the highest rate of Table VII; O above 127 pulses as
# well, with SLEW high.
LIMITS = (
    Limit("reset falls", "reset rises", "RESET low while running", "s.9", least=15 * US, mhz=6, keeper="host"),
    Limit("io_request falls", "ready rises", "a byte that needs no further processing", "s.7, fig. 7.3", typical=200 * US, mhz=11),
    Limit("ready falls", "run falls", "X fully accepted to RUN low", "s.7, fig. 7.5", typical=150 * US, mhz=11),
    Limit("run falls", "programmable_output rises", "a program that begins with B", "s.7, fig. 7.6", typical=60 * US, mhz=11),
    Limit("programmable_output rises", "programmable_output falls", "B, C in a program", "s.7, fig. 7.6", typical=40 * US, mhz=11, given=(("run", 0),)),
    Limit("programmable_output falls", "run rises", "C, 0 in a program", "s.7, fig. 7.6", typical=40 * US, mhz=11),
    Limit("pulse rises", "pulse falls", "PULSE high between two steps", "s.3 item 6", least=2500 * NS, mhz=11),
    Limit("pulse falls", "pulse falls", "a step while SLEW is low, at 9675 steps/s", "T.VII", least=103_359 * NS, mhz=11, given=(("slew", 0),), trust="derived"),
    Limit("motion_complete falls", "ready rises", "end of motion to READY", "s.11, fig. 11.4", typical=30 * US, mhz=6),
    Limit("motion_complete rises", "io_select falls", "I/O SELECT low again after a read-out in motion", "s.6", most=50 * US, mhz=11, keeper="host", given=(("ready", 0),), before=(("io_select", 1),)),
    Limit("clk15 falls", "clk15 rises", "CLK/15 low", "T.I", least=300 * NS),
    Limit("clk15 rises", "clk15 falls", "CLK/15 high", "T.I", least=300 * NS),
)
# fmt: on
POWER_UP_RESET_PS = 10_000_000_000  # 10 ms whatever the crystal (s.9)
POWER_UP_RC_PS = 71_355_817_782  # 50 kOhm and 1 uF from 0 to 3.8 V of 5 V: RC * ln(5 / 1.2) (s.9, fig. 9.1)

# phi1, phi2, phi3, phi4 by offset (s.7); clockwise goes up
PHASES = ((0, 1, 0, 1), (1, 0, 0, 1), (1, 0, 1, 0), (0, 1, 1, 0))

# Electrical limits (T.VIII; s.9).  Nothing computes with them: the model knows 0, 1 and floating.
NOTES = MappingProxyType(
    {
        "input levels": "high from 2.0 V (XTAL and RESET 3.8 V), low up to 0.8 V (XTAL and RESET 0.6 V)",
        "output levels": "high at least 2.4 V at 40 µA, low at most 0.45 V at 1.6 mA; open bus lines leak up to 10 µA",
        "supply": "5 V +/- 10 %, up to 100 mA; at most 1.5 W",
        "limits": "-0.5 to 7 V at any pin, 0 to 70 degrees C in operation, -65 to 150 in storage",
    }
)

OPTIONS = (
    Option(
        "stepwise",
        "bool",
        False,
        "play every motion step by step instead of as a whole; slow, with identical edges",
    ),
    Option("cold", "bool", False, "start without supply; `power(True)` and RESET low for 10 ms power up the chip"),
)

# The manual's notation of commands
SLIPS = MappingProxyType(
    {
        "\u00d8": "the manual prints \u00d8 for the digit zero: write 0",
        "}": "the manual prints } for the return key: leave it out",
    }
)

bus = partial(BusHandshake, ccw_bit=0x10)
socket = partial(
    Sheet,
    crystal_hz=REFERENCE_HZ,
    crystal_low_hz=1_000_000,
    crystal_high_hz=REFERENCE_HZ,
    pins=PINS,
    commands=COMMANDS,
    times=TIMES,
    limits=LIMITS,
    notes=NOTES,
    dialect=Letters(),
    channels=(bus(),),
    key="s. is a section, T. a table of it",
)

# ------------------------------------------------------------------------ parts whose rate grows by S with each step
_POWER_UP = "s.4; s.6"
SLOPED_REGISTERS = (
    Register("number", 16, 0, "steps of a relative move", "N", _POWER_UP, unit="steps"),
    Register("slope", 8, 0, "rise of the rate parameter per step", "S", _POWER_UP, unit="rate index"),
    Register("rate", 8, 1, "step rate", "R", _POWER_UP, unit="rate index"),
    Register("factor", 8, 1, "divisor of the rate", "F", _POWER_UP, unit="times"),
    Register("position", 16, 0xA55A, "absolute position", "A", _POWER_UP, unit="steps"),
)
# phi1 to phi4 in half steps, phi1 in the high bit (s.7; the half steps between them inferred); clockwise goes up
_FULL = tuple(sum(level << 3 - n for n, level in enumerate(row)) for row in PHASES)
HALF_STEPS = tuple(
    row for full, after in zip(_FULL, (*_FULL[1:], _FULL[0]), strict=True) for row in (full, full | after)
)
_LEFT_OUT = ("readout_delay", "readout_spacing", "readout_stretch", "phase_pulse", "slew_blink")
SLOPED_TIMES = MappingProxyType(
    {
        **{name: time for name, time in TIMES.items() if name not in _LEFT_OUT},
        "pulse_high": Timing(16, 6, "PULSE high between steps", "s.3 item 6; s.8", "inferred"),
    }
)
