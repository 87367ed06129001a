"""What the commands of the CY500 do, where it is not what they do in its successors."""

from __future__ import annotations

from collections.abc import Awaitable
from dataclasses import dataclass, field
from typing import Protocol

from ...core.motion.plan import steps
from ..cy5xx import instructions
from ..cy5xx.program_buffer import Moves
from ..cy5xx.stepping import sloped
from ..cy5xx.stepping.slope import Law

TURNS = ("CW", "CCW")


@dataclass
class Registers(sloped.Registers):
    """The modes and flags of the CY500; those with a factory outlive RESET and I, as the parameters do."""

    target: int | None = field(default_factory=lambda: None)  # of P; None: N was given since, or nothing
    waits: bool = False  # a P waits for its G
    sloped: bool = False  # S
    jog: bool = False  # J
    external: bool = False  # L
    home: bool = False  # A has been given
    last: str = ""  # the command that was performed last

    def power_up(self) -> None:
        """Set the registers of power-up: position and target are unset."""
        super().power_up()
        self.target, self.unset = None, {"position"}  # the other parameters have values that a motion may use

    @property
    def slope(self) -> int:
        return self.values["slope"] if self.sloped else 0

    @property
    def factor(self) -> int:
        """The factor that counts: a slope forces it to 1."""
        return 1 if self.sloped else super().factor


class SlopedMoves(Moves, Protocol):
    """What moves the motor, and knows the law of its slopes."""

    law: Law


class Instructions(sloped.Instructions, instructions.Instructions):
    """The handlers."""

    registers: Registers
    motion: SlopedMoves
    tested = "xss"
    in_slope = "slopes force the factor to 1, it counts after them"

    def do_athome(self) -> None:
        """A: set the position to 0; a second A, or one directly after a change of direction, is a finding."""
        registers = self.registers
        if registers.last in TURNS:
            self.chip.finding("a-after-direction", "A right after a change of direction")
        if registers.home:
            self.chip.finding("a-twice", "A again without RESET or I")
        registers.home = True
        super().do_athome()

    def do_number(self, steps: int) -> None:
        """N: load the number of steps of the next G; directly after A it is one step less."""
        if self.registers.last == "ATHOME" and steps:
            steps -= 1
            self.chip.finding("n-after-a", f"N right after A: one step less, {steps}")
        self.registers.target, self.registers.waits = None, False
        super().do_number(steps)

    def do_position(self, position: int) -> Awaitable[None] | None:  # type: ignore[override]
        """P: load the target of the next G; return the motion, if P itself starts it."""
        self.registers.target, self.registers.waits = position, True
        return self.do_gostep() if self.chip.options.p_starts else None

    def do_slope(self, slope: int) -> None:
        """S: load the slope; any but 0 makes the motions to come sloped."""
        self.registers.sloped = slope > 0
        super().do_slope(slope)

    def do_jog(self) -> None:
        """J: enter jog mode, in which XSS starts and stops the motor."""
        self.registers.jog = True

    def do_leftright(self) -> None:
        """L: take the direction from the pin from now on."""
        self.registers.external = True

    def do_cw(self) -> None:
        """+: turn clockwise; without effect where the pin sets the direction."""
        if not self.registers.external:
            super().do_cw()

    def do_ccw(self) -> None:
        """-: turn counter-clockwise; without effect where the pin sets the direction."""
        if not self.registers.external:
            super().do_ccw()

    # ----------------------------------------------------------------------------------------------------- motions
    def do_gostep(self) -> Awaitable[None] | None:
        """G: return the motion by N steps or to P; None, with a finding: there is none."""
        self.registers.waits = False
        if self.registers.jog:
            self.chip.finding("go-in-jog", "G in jog mode, where XSS starts and stops: ignored")
            return None
        return self.relative() if self.registers.target is None else self.absolute(self.registers.target)

    def relative(self) -> Awaitable[None]:
        """G after N: so many steps."""
        number = self.registers.values["number"]
        if self.chip.options.early_part and number % 256 == 0 and number:
            number -= 256
            self.chip.finding("early-part", f"a multiple of 256 in a part of the first batch: {number} steps")
        return self.takes(number, "G")

    def absolute(self, target: int) -> Awaitable[None]:
        """G after P: to a position, in the direction that is set, right round if need be."""
        self.check_registers("G", "position")
        way = (target - self.axis.position) * self.sign
        if way < 0:
            self.chip.finding("wrong-way", f"P {target} lies the other way: round through 65535")
        return self.takes(way % (1 << 16), f"P {target}")

    def takes(self, number: int, text: str) -> Awaitable[None]:
        """Take steps; the user is to see to it that there are enough for both ways of a slope."""
        registers = self.registers
        ramp = steps(self.motion.law.up(registers.values["rate"], registers.slope))
        if 0 < number < 2 * ramp:
            found = f"{text}, {number} steps, is too short for slopes of {ramp} steps: it ends abruptly"
            self.chip.finding("short-slope", found)
        return self.motion.move(number, self.sign, text)

    def do_onestep(self) -> Awaitable[None]:
        """O: return a motion of one step in the present direction."""
        return self.motion.move(1, self.sign, "O")

    @property
    def sign(self) -> int:
        """The direction of a motion that begins now: 1 clockwise, -1 counter-clockwise."""
        registers = self.registers
        return 1 if (self.chip.pins["xdir"].net.level if registers.external else registers.clockwise) else -1

    # ----------------------------------------------------------------------------------------------------- program
    def do_doitnow(self) -> None:
        """D: run the program from its start; without a program that is a finding."""
        if self.program.buffer:
            super().do_doitnow()
        else:
            self.chip.finding("empty-program", "D without a program: command mode")

    def do_til(self) -> None:
        """T: run the program from its start while XSS is low; in jog mode, which uses it too, a finding."""
        if self.registers.jog:
            self.chip.finding("til-and-jog", "T in jog mode: both use XSS")
        super().do_til()

    def do_quit(self) -> None:
        """Q: end program entry."""
        self.program.quit()  # outside program entry it does nothing, and is no mistake: programs end so
