"""Effects of commands: one method per command row of the sheet (do_loop for LOOP), and common helpers.

This file contains the commands that work alike throughout the family; a part adds commands and replaces
some of these.
"""

from __future__ import annotations

from collections.abc import Awaitable, Iterable, Mapping
from typing import Protocol

from ...core.context import ChipContext
from ...core.time.timebase import readable
from .interfaces.command_port import BusPort
from .interfaces.family_lines import line_in, line_out
from .interfaces.readout import ReadOut
from .program_buffer import Moves, Program
from .registers import Registers
from .stepping.phase_outputs import StepOutputs


class DirectionOutput(Protocol):
    """The output that shows the motor's direction."""

    def turn(self, clockwise: bool) -> None:
        """Set the direction, and output it."""


class ParameterHandlers:
    """Handlers of the commands that every part has: parameters, the direction, a pause, motions."""

    def __init__(
        self, chip: ChipContext, ticks: Mapping[str, int], registers: Registers, outputs: DirectionOutput, motion: Moves
    ) -> None:
        self.chip, self.ticks, self.registers, self.outputs, self.motion = chip, ticks, registers, outputs, motion
        self.axis = chip.axes[0]
        self.reported: set[str] = set()  # findings that are reported once

    def finding_once(self, code: str, text: str) -> None:
        """Add a finding, at most once for each code."""
        if code not in self.reported:
            self.reported.add(code)
            self.chip.finding(code, text)

    # ------------------------------------------------------------------------------------------------- parameters
    def do_number(self, steps: int) -> None:
        """N: load the number of steps that G moves."""
        self.registers.load("number", steps)

    def do_rate(self, rate: int) -> None:
        """R: load the rate parameter."""
        self.registers.load("rate", rate)

    def do_slope(self, slope: int) -> None:
        """S: load the slope parameter."""
        self.registers.load("slope", slope)

    def do_cw(self) -> None:
        """+: set the direction to clockwise."""
        self.outputs.turn(True)

    def do_ccw(self) -> None:
        """-: set the direction to counter-clockwise."""
        self.outputs.turn(False)

    def declare(self, position: int, text: str) -> None:
        """Set the position register to a value, and record the command `text` that does this."""
        self.axis.load(position)
        self.axis.log.mark("command", text)
        self.registers.unset.discard("position")

    async def pause(self, letter: str, delay: int) -> None:
        """Wait for `delay` milliseconds, for the command with this letter."""
        clocks = delay * self.ticks["millisecond"]
        self.chip.waits(f"waiting {readable(self.chip.clock.ps(clocks))} ({letter} {delay})")
        await self.chip.ticks(clocks)

    # ----------------------------------------------------------------------------------------------------- motions
    def do_go(self) -> Awaitable[None]:
        """G: return an awaitable that moves N steps in the present direction."""
        self.check_registers("G", "number")
        return self.motion.move(self.registers.values["number"], 1 if self.registers.clockwise else -1, "G")

    async def do_position(self, position: int) -> None:
        """P: move to a position, clockwise if it is at or above the present position."""
        self.check_registers(f"P {position}", "position")
        here = self.axis.position
        clockwise = position >= here
        number = position - here if clockwise else here - position
        await self.motion.move(number, 1 if clockwise else -1, f"P {position}")

    def check_registers(self, text: str, distance: str) -> None:
        """Report, at most once each, motion parameters that have not been set or that the manual does not allow.

        Args:
            text: the command of the motion.
            distance: the register that determines its distance.
        """
        registers = self.registers
        used = (set(registers.values) - {"number"}) | {distance}
        for name in sorted(used & registers.unset):
            registers.unset.discard(name)
            self.chip.finding(
                "uninitialised",
                f"{text} uses the {name} register, which has not been set since power-up; its content is undefined",
            )
        for bad, code, what in self.odd():
            if bad and what not in self.reported:
                self.reported.add(what)
                self.chip.finding(code, what)

    def odd(self) -> Iterable[tuple[bool, str, str]]:
        """Yield a tuple for each possible fault of a motion's parameters.

        Each tuple consists of a bool, True if the fault is present, and the code and the text of its finding.
        """
        return ()


class Instructions(ParameterHandlers):
    """The command handlers common to the family."""

    request_ends_wait = True  # I/O REQUEST, too, ends U and W
    tested = "dowhile"  # the pin that T tests

    def __init__(
        self,
        chip: ChipContext,
        ticks: Mapping[str, int],
        registers: Registers,
        outputs: StepOutputs,
        port: BusPort,
        readout: ReadOut,
        program: Program,
        motion: Moves,
    ) -> None:
        super().__init__(chip, ticks, registers, outputs, motion)
        self.outputs: StepOutputs = outputs
        self.port, self.readout, self.program = port, readout, program
        self.wait, self.dowhile = line_in(chip, "wait"), line_in(chip, self.tested)
        self.programmable_output = line_out(chip, "programmable_output")

    # ------------------------------------------------------------------------------------------------------- lines
    def do_bitset(self) -> None:
        """B: drive the programmable output high."""
        self.programmable_output.drive(1)

    def do_clearbit(self) -> None:
        """C: drive the programmable output low."""
        self.programmable_output.drive(0)

    async def do_until(self) -> None:
        """U: wait until the wait line is low."""
        await self.wait_for("U", 0)

    async def do_wait(self) -> None:
        """W: wait until the wait line is high."""
        await self.wait_for("W", 1)

    async def wait_for(self, letter: str, wanted: int) -> None:
        """Wait until the line WAIT has the level `wanted`, for the command U or W.

        WAIT is sampled every 8 µs.  A new low on I/O REQUEST may also end the wait (s.3 item 8).
        """
        chip, program, port, poll = self.chip, self.program, self.port, self.ticks["wait_poll"]
        request, ends = port.request, self.request_ends_wait
        chip.waits(f"waiting for wait={wanted} ({letter})")
        program.waits = ends
        try:
            if ends and not program.running and request.changes == port.accepted:
                ended = await chip.polled(self.wait, wanted, poll, request.when_inactive)
                if ended is self.wait:
                    return  # otherwise the request of the terminator has ended, and a new one counts
            before = request.changes
            ended = await chip.polled(self.wait, wanted, poll, *((request.when_active,) if ends else ()))
            if ended is request and request.changes > before:
                port.spend(handshake=not program.running)
        finally:
            program.waits = False

    # ----------------------------------------------------------------------------------------------------- read-out
    def do_verify(self, group: int) -> None:
        """V: select a group for read-out; if the group is unknown, report a finding and keep the old selection."""
        if group not in self.readout.sizes:
            last = max(self.readout.sizes)
            self.chip.finding(
                "verify-group", f"V {group} is not a group; allowed 0 to {last}; the pointer is unchanged"
            )
            return
        ascii = self.port.ascii
        if self.program.running:
            self.chip.finding("verify-in-program", "V in a program only sets the pointer")
            ascii = self.port.mode.level == 1
        self.readout.point(group, ascii)

    # ------------------------------------------------------------------------------------------------------ program
    def do_enter(self) -> None:
        """E: begin program entry; within a running program, report a finding instead."""
        if self.program.pc is not None:
            became = "refused" if self.program.live else "skipped"
            self.chip.finding("enter-while-running", f"E in a running program is {became}")
            return
        self.program.enter()

    def do_quit(self) -> None:
        """Q: end program entry; outside program entry, report a finding."""
        if not self.program.entering:
            self.chip.finding("quit-outside-entry", "Q has no effect outside program entry")
        self.program.quit()

    def do_initialize(self) -> None:
        """I: erase the program, reset modes and read-out; coils off, direction clockwise; enter command mode."""
        self.program.clear()
        self.readout.clear()
        self.registers.clear()
        self.outputs.clear()
        self.outputs.turn(True)
        self.outputs.off()
        self.program.rest()

    def do_command(self) -> None:
        """0: stop the program, and enter command mode."""
        self.program.end()

    def do_jump(self, target: int) -> None:
        """J: continue the program at a byte address, or start it there."""
        self.program.begin(self.program.resolved(target))

    def do_loop(self, count: int, target: int) -> None:
        """L: branch to a byte of the program, until the loop has made `count` passes (0 means 256)."""
        program, finding = self.program, self.chip.finding
        target = program.resolved(target)
        if not program.running:
            if count != 1:
                finding("loop-command", "L as a host command starts the program at the target of L")
                program.begin(target)
            return
        if program.loop is None:
            if count == 0 and self.chip.sheet.commands["L"].args[0].low > 0:
                finding("loop-zero", "L 0 makes 256 passes, a full cycle of the 8-bit counter")
            program.loop = (program.at, count or 256)
        elif program.loop[0] != program.at:
            self.finding_once(
                "nested-loop",
                f"L at byte {program.at} while the L at byte {program.loop[0]} is counting: it takes over the count",
            )
        left = program.loop[1] - 1
        program.loop = (program.loop[0], left) if left else None
        if left:
            program.pc = target
