"""The names for building chips and parts, in one module that does not change.

from slewline.build import Arg, LineChip, Lines, Pin, Row, Sheet, Table     a chip: its sheet and its behaviour
from slewline.build import Option, Part, edge, until                        a part next to it
from slewline.build import assemble, lint, listing, sheet_of                programs

The modules that define these names may change, so import the names from here.  Each name is loaded on first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .lazy import lazily

if TYPE_CHECKING:
    from .chips import checks_of, chip_class, sheet_of
    from .chips.line import Line, LineChip
    from .core.chip import Chip
    from .core.component import Finding
    from .core.context import ChipContext
    from .core.datasheet.channel import AdaptiveLine, BusHandshake, FlowBus, HostPort, SerialLine
    from .core.datasheet.command_rows import LineRow, PacketRow, TextRow
    from .core.datasheet.option import Option
    from .core.datasheet.quirk import Quirk
    from .core.datasheet.table import Arg, Limit, Pin, Register, Row, Sheet, Table, Timing
    from .core.motion.axis import Axis
    from .core.motion.one_axis import OneAxis
    from .core.motion.plan import Leg, Plan, plan
    from .core.motion.step_views import PatternView, PulseView, StrobeView
    from .core.motion.train import Playing, StepTrain
    from .core.program import ProgramRow
    from .core.time.events import Events, NoEvents, NotYet, ask_at
    from .core.time.hook import Hook
    from .core.time.inputs import from_outside
    from .core.time.kernel import Kernel
    from .core.time.timebase import Clock, Time, moment, picoseconds, readable
    from .core.wires.clocking import clock_edges
    from .core.wires.net import Bus, Driver, Net
    from .core.wires.pin import Condition, Terminal
    from .core.wires.views import View, gated, inverted
    from .core.wires.waits import edge, first_of, level, next_round, polled, until
    from .core.wires.wave import Wave
    from .language.assemble import assemble
    from .language.disassemble import listing
    from .language.lines import Lines
    from .language.lint import lint
    from .language.packets import Packets
    from .language.text import Letters, Verbatim
    from .parts.base.clocked import Clocked
    from .parts.base.counted import Counted, Sampled
    from .parts.base.follower import Follower, Stateless
    from .parts.base.part import Part
    from .parts.shafts.sensors import Sensor

_FROM = {
    "chips": ("checks_of", "chip_class", "sheet_of"),
    "chips.line": ("Line", "LineChip"),
    "core.motion.axis": ("Axis",),
    "core.datasheet.channel": ("AdaptiveLine", "BusHandshake", "FlowBus", "HostPort", "SerialLine"),
    "core.chip": ("Chip",),
    "core.component": ("Finding",),
    "core.context": ("ChipContext",),
    "core.motion.one_axis": ("OneAxis",),
    "core.time.hook": ("Hook",),
    "core.wires.net": ("Bus", "Driver", "Net"),
    "core.datasheet.option": ("Option",),
    "core.time.inputs": ("from_outside",),
    "core.time.kernel": ("Kernel",),
    "core.wires.pin": ("Condition", "Terminal"),
    "core.motion.plan": ("Leg", "Plan", "plan"),
    "core.program": ("ProgramRow",),
    "core.datasheet.quirk": ("Quirk",),
    "core.motion.step_views": ("PatternView", "PulseView", "StrobeView"),
    "core.datasheet.command_rows": ("LineRow", "PacketRow", "TextRow"),
    "core.datasheet.table": ("Arg", "Limit", "Pin", "Register", "Row", "Sheet", "Table", "Timing"),
    "core.time.timebase": ("Clock", "Time", "moment", "picoseconds", "readable"),
    "core.motion.train": ("Playing", "StepTrain"),
    "core.time.events": ("Events", "NoEvents", "NotYet", "ask_at"),
    "core.wires.clocking": ("clock_edges",),
    "core.wires.views": ("View", "gated", "inverted"),
    "core.wires.wave": ("Wave",),
    "core.wires.waits": ("edge", "first_of", "level", "next_round", "polled", "until"),
    "language.assemble": ("assemble",),
    "language.disassemble": ("listing",),
    "language.lines": ("Lines",),
    "language.lint": ("lint",),
    "language.packets": ("Packets",),
    "language.text": ("Letters", "Verbatim"),
    "parts.base.clocked": ("Clocked",),
    "parts.base.counted": ("Counted", "Sampled"),
    "parts.base.follower": ("Follower", "Stateless"),
    "parts.base.part": ("Part",),
    "parts.shafts.sensors": ("Sensor",),
}
__all__ = [
    "AdaptiveLine",
    "Arg",
    "Axis",
    "Bus",
    "BusHandshake",
    "Chip",
    "ChipContext",
    "Clock",
    "Clocked",
    "Condition",
    "Counted",
    "Driver",
    "Events",
    "Finding",
    "FlowBus",
    "Follower",
    "Hook",
    "HostPort",
    "Kernel",
    "Leg",
    "Letters",
    "Limit",
    "Line",
    "LineChip",
    "LineRow",
    "Lines",
    "Net",
    "NoEvents",
    "NotYet",
    "OneAxis",
    "Option",
    "PacketRow",
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
    "Sampled",
    "Sensor",
    "SerialLine",
    "Sheet",
    "Stateless",
    "StepTrain",
    "StrobeView",
    "Table",
    "Terminal",
    "TextRow",
    "Time",
    "Timing",
    "Verbatim",
    "View",
    "Wave",
    "ask_at",
    "assemble",
    "checks_of",
    "chip_class",
    "clock_edges",
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
