"""Commands of the CY500 that work differently in its successors."""

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
    """The modes and flags of the CY500.

    Fields with a default factory survive RESET and the I command, as the parameters do.
    """

    target: int | None = field(default_factory=lambda: None)  # of P; None if N was sent since, or neither
    waits: bool = False  # True while a P waits for its G
    sloped: bool = False  # S
    jog: bool = False  # J
    external: bool = False  # L
    home: bool = False  # A has been sent
    last: str = ""  # the command executed last

    def power_up(self) -> None:
        """Set the registers to their state after power-up: position and target are unset."""
        super().power_up()
        self.target, self.unset = None, {"position"}  # the other parameters are valid for a motion

    @property
    def slope(self) -> int:
        return self.values["slope"] if self.sloped else 0

    @property
    def factor(self) -> int:
        """The factor in effect: 1 if a slope is set, else F, where 0 counts as 256."""
        return 1 if self.sloped else super().factor


class SlopedMoves(Moves, Protocol):
    """The object that moves the motor of a part whose motions may have slopes."""

    law: Law


class Instructions(sloped.Instructions, instructions.Instructions):
    """Handlers of the CY500's own commands."""

    registers: Registers
    motion: SlopedMoves
    tested = "xss"
    in_slope = "slopes force the factor to 1; F takes effect after the slopes"

    def do_athome(self) -> None:
        """A: set the position to 0; report a finding for a second A, or an A directly after a change of direction."""
        registers = self.registers
        if registers.last in TURNS:
            self.chip.finding("a-after-direction", "command A directly follows a change of direction")
        if registers.home:
            self.chip.finding("a-twice", "command A is repeated with no RESET or I in between")
        registers.home = True
        super().do_athome()

    def do_number(self, steps: int) -> None:
        """N: load the number of steps of the next G; directly after A, load one step fewer, and report a finding."""
        if self.registers.last == "ATHOME" and steps:
            steps -= 1
            self.chip.finding("n-after-a", f"command N directly after A moves one step less: {steps}")
        self.registers.target, self.registers.waits = None, False
        super().do_number(steps)

    def do_position(self, position: int) -> Awaitable[None] | None:  # type: ignore[override]
        """P: load the target of the next G; if P itself starts the motion, return the motion, else None."""
        self.registers.target, self.registers.waits = position, True
        return self.do_gostep() if self.chip.options.p_starts else None

    def do_slope(self, slope: int) -> None:
        """S: load the slope; any value except 0 makes the following motions sloped."""
        self.registers.sloped = slope > 0
        super().do_slope(slope)

    def do_jog(self) -> None:
        """J: enter jog mode, in which XSS starts and stops the motor."""
        self.registers.jog = True

    def do_leftright(self) -> None:
        """L: from now on, take the direction from the pin XDIR."""
        self.registers.external = True

    def do_cw(self) -> None:
        """+: set the direction to clockwise; this has no effect if the pin XDIR sets the direction."""
        if not self.registers.external:
            super().do_cw()

    def do_ccw(self) -> None:
        """-: set the direction to counter-clockwise; this has no effect if the pin XDIR sets the direction."""
        if not self.registers.external:
            super().do_ccw()

    # ----------------------------------------------------------------------------------------------------- motions
    def do_gostep(self) -> Awaitable[None] | None:
        """G: return the motion by N or to P, whichever came last; in jog mode, report a finding and return None."""
        self.registers.waits = False
        if self.registers.jog:
            self.chip.finding("go-in-jog", "command G is ignored in jog mode, in which XSS starts and stops the motor")
            return None
        return self.relative() if self.registers.target is None else self.absolute(self.registers.target)

    def relative(self) -> Awaitable[None]:
        """Return the motion of a G after N: by N steps."""
        number = self.registers.values["number"]
        if self.chip.options.early_part and number % 256 == 0 and number:
            number -= 256
            text = f"a chip of the first batch takes only {number} steps for this multiple of 256"
            self.chip.finding("early-part", text)
        return self.takes(number, "G")

    def absolute(self, target: int) -> Awaitable[None]:
        """Return the motion of a G after P: to `target` in the set direction, wrapping around if necessary."""
        self.check_registers("G", "position")
        distance = (target - self.axis.position) * self.sign
        if distance < 0:
            self.chip.finding(
                "wrong-way", f"P {target} is opposite to the set direction: the motion wraps around at 65535"
            )
        return self.takes(distance % (1 << 16), f"P {target}")

    def takes(self, number: int, text: str) -> Awaitable[None]:
        """Return a motion of a number of steps; report a finding if the two ramps of a slope do not fit into it."""
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
        """The direction of a motion that begins now: 1 is clockwise, -1 is counter-clockwise."""
        registers = self.registers
        return 1 if (self.chip.pins["xdir"].net.level if registers.external else registers.clockwise) else -1

    # ----------------------------------------------------------------------------------------------------- program
    def do_doitnow(self) -> None:
        """D: run the program from its start; if there is no program, report a finding."""
        if self.program.buffer:
            super().do_doitnow()
        else:
            self.chip.finding("empty-program", "command D has no program to run; the chip stays in command mode")

    def do_til(self) -> None:
        """T: run the program from its start while XSS is low; in jog mode, which uses XSS too, report a finding."""
        if self.registers.jog:
            self.chip.finding("til-and-jog", "command T is sent in jog mode; both T and jog mode use XSS")
        super().do_til()

    def do_quit(self) -> None:
        """Q: end program entry."""
        self.program.quit()  # allowed without effect outside program entry: programs end with it
