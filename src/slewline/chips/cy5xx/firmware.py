"""A chip of the family: it owns the objects, starts and kills the firmware, and is what a user sees."""

from __future__ import annotations

from collections.abc import Coroutine, Mapping
from typing import TYPE_CHECKING, Any

from ...core.chip import Chip
from ...core.motion.axis import Axis
from ...core.motion.step_views import PulseView
from ...core.motion.train import OPEN, Playing, StepTrain
from ...core.time.kernel import Kernel
from .crystal import check_crystal, clocks
from .instructions import Instructions
from .interpreter import Interpreter
from .motion import Motion
from .port import BusPort
from .program import Moves, Program
from .readout import ReadOut
from .registers import Registers
from .steps import Patterns, StepOutputs
from .supply import PowerUp, Supply

if TYPE_CHECKING:
    from ...core.program import ProgramRow
    from .twin import Stepwise


class Cy5xx(Chip):
    """A stepper motor controller of the family, on a bench.  A part says which classes and tables it is made of."""

    power_up: PowerUp
    crystal_where = "the manual"  # says which crystals fit
    registers_class: type[Registers] = Registers
    outputs_class: type[StepOutputs] = StepOutputs
    port_class: type[BusPort] = BusPort
    instructions_class: type[Instructions] = Instructions
    interpreter_class: type[Interpreter] = Interpreter
    motion_class: type[Motion]

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        ticks = clocks(self)
        defaults = {row.name: getattr(self.options, row.name) for row in self.sheet.registers}
        self.state = self.registers_class(defaults)
        self.axes = (Axis(kernel, range(1 << 16), defaults["position"]),)
        self.outputs = self.outputs_class(self, self.state, self.patterns(), ticks["pulse_high"])
        self.readout = ReadOut(self, self.sheet.verify_bytes, self.group_bytes)
        self.port = self.port_class(self, ticks, self.readout)
        self.motion = self.moves(ticks)
        self.stored = Program(self, self.port, self.motion)
        self.instructions = self.instructions_class(
            self, ticks, self.state, self.outputs, self.port, self.readout, self.stored, self.motion
        )
        self.interpreter = self.interpreter_class(self, ticks, self.port, self.stored, self.instructions)
        self.supply = Supply(self, self, self.sheet.times, self.power_up)
        if self.supply.powered:
            self.driven(True)
            self.clock_runs()
        check_crystal(self, self.crystal_where)
        if self.supply.powered:
            self.start()

    def patterns(self) -> Patterns:
        """Return the levels of the phases, a row a step; clockwise goes down the rows."""
        raise NotImplementedError

    def law(self) -> Any:
        """Return what motions are planned by."""
        raise NotImplementedError

    def twin_class(self) -> type[Stepwise]:
        """Return the class of the slow twin, which is loaded by who asks for it."""
        raise NotImplementedError

    def moves(self, ticks: Mapping[str, int]) -> Moves:
        """Make what moves the motor: the fast way, or its slow twin."""
        moves = self.twin_class() if self.options.stepwise else self.motion_class
        return moves(self, ticks, self.state, self.outputs, self.port, self.law())

    def run(self) -> Coroutine[Any, Any, None]:
        """The firmware from reset on."""
        return self.interpreter.run()

    # ------------------------------------------------------------------------------------------------ power and reset
    def power(self, on: bool) -> None:
        """Switch the supply.  After power-up the registers hold their power-up values, and RESET must be low for 10 ms;
        when nobody drives RESET, the capacitor of fig. 9.1 does it.

        Raises:
            UsageError: `on` is neither True nor False.
        """
        self.check_switch(on)
        self.supply.switch(on)

    def reset(self) -> None:
        """Pulse RESET low for 20 us at 6 MHz from now on."""
        self.pin("reset").pulse(0, self.clock.ps(120) + 1)

    def powered_up(self) -> None:
        """Give the registers their values after power-up; every output is driven, the clock runs."""
        self.state.power_up()
        self.axes[0].load(self.state.defaults["position"])
        self.driven(True)
        self.clock_runs()

    def cleared(self) -> None:
        """The firmware has been killed: no program, no motion, no command; flags and pointers as after reset."""
        self.stored.clear()
        self.motion.killed()
        self.on_command("")
        self.port.begin()
        self.interpreter.decoder.reset()
        self.readout.clear()
        self.state.clear()
        self.outputs.clear()

    def driven(self, on: bool) -> None:
        """Drive every output to 1 (s.13), and PROG/LIVE as its pull does; or let go of all of them, without supply."""
        for name, driver in self.drivers.items():
            row = self.sheet.pin(name)
            if row.role != "ready" and (row.reset == 1 or not on):
                driver.drive(1 if on and row.way == "out" else None)
        self.port.rest(1 if on else None)

    def clock_runs(self) -> None:
        """CLK/15 runs from power-up on, whatever else happens (s.13)."""
        clock = Playing(StepTrain(self.clock, self.clock.ticks_from(self.kernel.now), ((15, OPEN),)))
        self.drivers["clk15"].play(PulseView(clock, 10))  # 5 of 15 clocks low: 0.45 us at 11 MHz

    # ------------------------------------------------------------------------------------------------- as others see it
    @property
    def powered(self) -> bool:
        """Is the supply on?"""
        return self.supply.powered

    @property
    def registers(self) -> dict[str, int]:
        """The manual's registers by name, the position among them."""
        return self.known({**self.state.values, "position": self.axes[0].position})

    @property
    def program(self) -> bytes:
        """The program buffer in use, as stored."""
        return bytes(self.stored.buffer)

    @property
    def program_counter(self) -> int | None:
        """The byte of the buffer at which the instruction in work begins, or the next one while live commands come."""
        return self.stored.counter

    def program_rows(self) -> list[ProgramRow]:
        """Return the program buffer, an instruction a row: address, bytes and text."""
        return self.stored.rows()

    def listing(self) -> str:
        """Return the stored program as text, with addresses."""
        return self.stored.listing()

    @property
    def unfinished(self) -> str:
        """The line that has come so far."""
        return self.interpreter.decoder.unfinished

    def group_bytes(self, group: int, ascii: bool) -> bytes:
        """Return all bytes of a verify group as they stand now: position, program, status, parameters.

        The position has the form of the mode in which V was given; the other groups are binary in both modes (s.6).
        """
        position = self.axes[0].position
        if group == 0:
            return b"%05d" % position if ascii else position.to_bytes(2, "big")
        if group == 1:
            return bytes(self.stored.buffer).ljust(self.sheet.buffer_bytes, b"\0")
        if group == 2:
            return bytes([0, 0, 0, 0, 0, 0x00 if self.state.clockwise else 0x10])
        values = self.state.values
        rows = (row for row in self.sheet.registers if row.name in values)
        return b"".join(values[row.name].to_bytes(row.bits // 8, "big") for row in rows)
