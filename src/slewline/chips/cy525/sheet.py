"""The CY525 data sheet as data, from the CY525 manual (Cybernetic Micro Systems, 1984).  No behaviour in this file.

Each time applies at the crystal frequency that the manual states with it; the chip counts crystal
clocks, so every time scales with the crystal.  "T.V" is the manual's Table V, "s.7" its section 7.
"""

from __future__ import annotations

from types import MappingProxyType

from ...core.datasheet.option import Option
from ...core.datasheet.table import Arg, Register
from ..cy5xx import sheet
from ..cy5xx.family_options import at_power_up
from ..cy5xx.sheet import BUFFER_BYTES, LABELS, REFERENCE_HZ

# --------------------------------------------------------------------------------------------------------- registers
REGISTERS = (
    Register("number", 16, 0, "steps of a relative move", "N", "s.1; s.6", unit="steps"),
    Register("slope", 8, 255, "acceleration", "S", "s.6", unit="slope index"),
    Register("rate", 8, 3, "maximum rate", "R", "s.6", unit="rate index"),
    Register("firstrate", 8, 3, "initial rate", "F", "s.6", unit="rate index"),
    Register("divisor", 8, 1, "slope divisor", "Z", "s.6", unit="times"),
    Register("position", 16, 0xA55A, "absolute position", "A", "s.1; s.6", unit="steps"),
)

# ------------------------------------------------------------------------------------------- rates and ramps, Table VII
# Steps per second at 11 MHz for R = 0 ... 127.  R = 0, 1, 2: "slightly less than 300, subject to change" (275: s.3 R).
# fmt: off
STEPS_PER_SECOND = (
    275, 283, 292,
    *range(300, 4001, 100),
    4062, 4107, 4154, 4201, 4250, 4299, 4350, 4402, 4456, 4511, 4567, 4624, 4683, 4743, 4805, 4869, 4934, 5002, 5070, 5141,
    5178, 5214, 5252, 5289, 5328, 5367, 5406, 5446, 5487, 5528, 5570, 5612, 5656, 5699, 5744, 5789, 5835, 5882, 5929, 5978,
    6027, 6076, 6127, 6178, 6231, 6284, 6338, 6393, 6449, 6507, 6565, 6624, 6684, 6745, 6808, 6871, 6936, 7002, 7070, 7138,
    7208, 7280, 7352, 7427, 7503, 7580, 7659, 7739, 7822, 7906, 7992, 8080, 8169, 8261, 8355, 8451, 8549, 8650, 8753, 8858,
    8967, 9077, 9191, 9307, 9426, 9549, 9675,
)
# fmt: on
RATE_TOP = 127
STEP_TICKS = tuple((2 * REFERENCE_HZ + rate) // (2 * rate) for rate in STEPS_PER_SECOND)  # round(11 MHz / rate)

# One rate unit takes Z*(256-S) times this (s.8): the manual takes 9375/(22988*80/(256-S)) s for the 124 units from R 3 to
# R 127, 452.22 clocks a unit at 11 MHz.  Where D is 100, at R 3 to 40, its formula results in 478.51: UND-RAMP-LAW.
RAMP_UNIT_TICKS = 452
RAMP_UNIT = Arg("ramp_unit", 2, 1, 65535, unit="clocks")  # other readings; an option of the chip, too
SHORT_SLEW_STEPS = 256  # below this number of steps there is no slewing (s.8, special case)

# ----------------------------------------------------------------------------------------------------------- options
# fmt: off
OPTIONS = (
    *sheet.OPTIONS,
    Option(RAMP_UNIT.name, "int", RAMP_UNIT_TICKS, "duration of one rate unit at S 255 and Z 1 (quirk UND-RAMP-LAW); 479 follows the formula of s.8 with the D of the low rates", low=RAMP_UNIT.low, high=RAMP_UNIT.high, unit=RAMP_UNIT.unit, where="s.8"),
    Option("ramp_jumps", "bool", False, "take all rate units that are due when a step begins, not just one"),
    *at_power_up(REGISTERS),
)
# fmt: on

# Verify groups (T.VI): bytes that have a meaning
VERIFY_BYTES = {0: 5, 1: 48, 2: 6, 3: 6}

# The manual's notation of commands, and CY512 commands with another meaning here (s.3, comparison; CY500: T.2)
SLIPS = MappingProxyType(
    {
        **sheet.SLIPS,
        "$": "$ follows the letter of a label, as in A$; binary programs have no labels",
        "A": "in the CY512 A took no number: write A 0",
        "D": "in the CY512 D ran the program: here X does, and D is the delay",
        "H": "in the CY512 H was half step: the CY525 has none",
        "X": "in the CY512 X was the delay: here D is, and X runs the program",
    }
)

SHEET = sheet.socket(
    part="cy525",
    title="CY525 intelligent ramping stepper motor controller",
    manual="CY525 manual, 1984",
    behaviour=2,
    registers=REGISTERS,
    options=OPTIONS,
    rates=STEPS_PER_SECOND,
    buffer_bytes=BUFFER_BYTES,
    buffer_where="s.5",
    channels=(sheet.bus(VERIFY_BYTES),),
    labels=LABELS,
    suffix=".cy525",
    slips=SLIPS,
    sections=MappingProxyType(
        {"labels": "s.3", "labels in full": "s.3; T.II", "text": "s.3", "reading": "s.6", "running": "s.7"}
    ),
)
