"""What chips and parts of one's own are built with, in one place that stays where it is.

from slewline.build import Arg, LineChip, Lines, Pin, Row, Sheet, Table     a chip: its sheet, and what it does
from slewline.build import Option, Part, edge, until                        a part beside it
from slewline.build import assemble, lint, listing, sheet_of                programs

Other modules move these names about among themselves; here they keep their place.  Each is loaded when it is asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .lazy import lazily

if TYPE_CHECKING:
    from .chips import checks_of, chip_class, sheet_of
    from .chips.line import Line, LineChip
    from .core.axis import Axis
    from .core.channel import AdaptiveLine, BusHandshake, FlowBus, HostPort, SerialLine
    from .core.chip import Chip, Finding
    from .core.hook import Hook
    from .core.inputs import from_outside
    from .core.net import Bus, Driver, Net
    from .core.one_axis import OneAxis
    from .core.option import Option
    from .core.pin import Condition, Terminal
    from .core.plan import Leg, Plan, plan
    from .core.program import ProgramRow
    from .core.quirk import Quirk
    from .core.step_views import PatternView, PulseView, StrobeView
    from .core.table import Arg, Limit, Pin, Register, Row, Sheet, Table, Timing
    from .core.timebase import Clock, Time, moment, picoseconds, readable
    from .core.train import Playing, StepTrain
    from .core.views import gated, inverted
    from .core.waits import edge, first_of, level, next_round, polled, until
    from .language.assemble import assemble
    from .language.disassemble import listing
    from .language.letters import Letters
    from .language.lines import Lines
    from .language.lint import lint
    from .language.packets import Packets
    from .language.verbatim import Verbatim
    from .parts.clocked import Clocked
    from .parts.follower import Follower, Stateless
    from .parts.part import Part
    from .parts.sensors import Sensor

_FROM = {
    "chips": ("checks_of", "chip_class", "sheet_of"),
    "chips.line": ("Line", "LineChip"),
    "core.axis": ("Axis",),
    "core.channel": ("AdaptiveLine", "BusHandshake", "FlowBus", "HostPort", "SerialLine"),
    "core.chip": ("Chip", "Finding"),
    "core.one_axis": ("OneAxis",),
    "core.hook": ("Hook",),
    "core.net": ("Bus", "Driver", "Net"),
    "core.option": ("Option",),
    "core.inputs": ("from_outside",),
    "core.pin": ("Condition", "Terminal"),
    "core.plan": ("Leg", "Plan", "plan"),
    "core.program": ("ProgramRow",),
    "core.quirk": ("Quirk",),
    "core.step_views": ("PatternView", "PulseView", "StrobeView"),
    "core.table": ("Arg", "Limit", "Pin", "Register", "Row", "Sheet", "Table", "Timing"),
    "core.timebase": ("Clock", "Time", "moment", "picoseconds", "readable"),
    "core.train": ("Playing", "StepTrain"),
    "core.views": ("gated", "inverted"),
    "core.waits": ("edge", "first_of", "level", "next_round", "polled", "until"),
    "language.assemble": ("assemble",),
    "language.disassemble": ("listing",),
    "language.letters": ("Letters",),
    "language.lines": ("Lines",),
    "language.lint": ("lint",),
    "language.packets": ("Packets",),
    "language.verbatim": ("Verbatim",),
    "parts.clocked": ("Clocked",),
    "parts.follower": ("Follower", "Stateless"),
    "parts.part": ("Part",),
    "parts.sensors": ("Sensor",),
}
__all__ = [
    "AdaptiveLine",
    "Arg",
    "Axis",
    "Bus",
    "BusHandshake",
    "Chip",
    "Clock",
    "Clocked",
    "Condition",
    "Driver",
    "Finding",
    "FlowBus",
    "Follower",
    "Hook",
    "HostPort",
    "Leg",
    "Letters",
    "Limit",
    "Line",
    "LineChip",
    "Lines",
    "Net",
    "OneAxis",
    "Option",
    "Packets",
    "Part",
    "PatternView",
    "Pin",
    "Plan",
    "Playing",
    "ProgramRow",
    "PulseView",
    "Quirk",
    "Register",
    "Row",
    "Sensor",
    "SerialLine",
    "Sheet",
    "Stateless",
    "StepTrain",
    "StrobeView",
    "Table",
    "Terminal",
    "Time",
    "Timing",
    "Verbatim",
    "assemble",
    "checks_of",
    "chip_class",
    "edge",
    "first_of",
    "from_outside",
    "gated",
    "inverted",
    "level",
    "lint",
    "listing",
    "moment",
    "next_round",
    "picoseconds",
    "plan",
    "polled",
    "readable",
    "sheet_of",
    "until",
]

__getattr__, __dir__ = lazily(globals(), _FROM)
