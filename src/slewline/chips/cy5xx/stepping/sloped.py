"""Common behaviour of the parts with slopes (slope.py): half steps, a rate divisor, and commands D and T."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from ....core.motion.ideal_motion import Ideal
from ....core.motion.motions import MotionParameters
from ....core.motion.plan import Plan
from ....core.wires.net import Net
from .. import instructions, registers
from ..program_buffer import Program
from . import motion
from .phase_outputs import Patterns, StepOutputs
from .slope import Law, RegistersAtStart


def half_steps(inferred: Mapping[str, Any]) -> Patterns:
    """Return the half-step patterns, each a row of levels of phases 1 to 4; full steps use every second row."""
    return tuple(tuple(pattern >> bit & 1 for bit in (3, 2, 1, 0)) for pattern in inferred["phases"])


def full_steps(inferred: Mapping[str, Any]) -> Patterns:
    """Return the full-step phase patterns, each row with the levels of phases 1 to 4."""
    return half_steps(inferred)[::2]


def law(inferred: Mapping[str, Any], periods: tuple[int, ...]) -> Law:
    """Return the law: the step periods in clocks by rate parameter, and the parameter at which ramps start.

    Periods given in the options replace those of the part.
    """
    return Law(inferred["periods"] or periods, inferred["ramp_start"])


@dataclass
class Registers(registers.Registers):
    """The family's registers, and the half-step mode set by H."""

    half: bool = False

    @property
    def slope(self) -> int:
        """The slope in effect; 0 for none."""
        return self.values["slope"]

    @property
    def factor(self) -> int:
        """The factor in effect (command F), by which the rate is divided; 0 counts as 256."""
        return self.values["factor"] or 256

    def at_start(self, crystal_hz: int, number: int, law: Law) -> RegistersAtStart:
        """Return the parameters of a motion of `number` steps that begins now."""
        return RegistersAtStart(crystal_hz, self.values["rate"], self.slope, self.factor, number, law)


class Instructions(instructions.ParameterHandlers):
    """The handlers of A, D and T, which have no argument in these parts, and of F and H.

    The class of a part also inherits the handlers common to the family.
    """

    registers: Registers
    outputs: StepOutputs
    program: Program
    dowhile: Net
    request_ends_wait = False
    in_slope = ""  # effect of a factor with slopes

    def do_athome(self) -> None:
        """A: set the position to 0."""
        self.declare(0, "A")

    def do_doitnow(self) -> None:
        """D: run the program from its start."""
        self.program.begin(0)

    def do_til(self) -> None:
        """T: branch to the start of the program if DOWHILE is low."""
        if self.dowhile.is_active:
            self.do_doitnow()

    def do_factor(self, factor: int) -> None:
        """F: load the rate divisor, 1 to 255; if a slope is in effect, report a finding."""
        if self.registers.slope:
            self.chip.finding("factor-in-slope", f"F {factor} after S: {self.in_slope}")
        self.registers.load("factor", factor)

    def do_halfstep(self) -> None:
        """H: output half steps until the I command or RESET."""
        if not self.registers.half:
            self.registers.half = True
            self.registers.phase *= 2
            self.outputs.walk(half_steps(self.chip.options.inferred))


class Motion(motion.Motion):
    """The motions of the parts with slopes; their ideal course is the plan itself."""

    registers: Registers
    law: Law

    def parameters(self, number: int) -> Callable[[], MotionParameters]:
        """Load the parameters of a motion that begins now, and return a function that returns them for a picture."""
        self.at_start = self.registers.at_start(self.chip.crystal_hz, number, self.law)
        return self.at_start.parameters

    def expected(self, plan: Plan) -> Callable[[], Ideal]:
        return partial(self.at_start.ideal, plan.runs, self.kernel.now, self.axis.position, self.sign)
