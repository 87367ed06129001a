"""A chip of the family: it owns the objects, starts and stops the firmware, and provides the public properties."""

from __future__ import annotations

from collections.abc import Coroutine, Mapping
from typing import TYPE_CHECKING, Any

from ...core.chip import Chip
from ...core.datasheet.channel import BusHandshake
from ...core.motion.axis import Axis
from ...core.motion.step_views import PulseView
from ...core.motion.train import OPEN, Playing, StepTrain
from ...core.time.kernel import Kernel
from .crystal import check_crystal, clocks
from .instructions import Instructions
from .interfaces.command_port import BusPort
from .interfaces.readout import ReadOut
from .interpreter import Interpreter
from .program_buffer import Moves, Program
from .registers import Registers
from .stepping.motion import Motion
from .stepping.phase_outputs import Patterns, StepOutputs
from .supply import PowerUp, Supplied, Supply

if TYPE_CHECKING:
    from ...core.program import ProgramRow
    from .stepping.twin import Stepwise


class Cy5xx(Chip):
    """A stepper motor controller of the family, on a bench.

    The class of each part (chip type) sets the classes and tables that the part uses.
    """

    _for_users = ("powered",)
    _power_up: PowerUp
    _crystal_where = "the manual"  # states the allowed crystals
    _registers_class: type[Registers] = Registers
    _outputs_class: type[StepOutputs] = StepOutputs
    _port_class: type[BusPort] = BusPort
    _instructions_class: type[Instructions] = Instructions
    _interpreter_class: type[Interpreter] = Interpreter
    _motion_class: type[Motion]

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        ticks = clocks(self)
        defaults = {row.name: getattr(self.options, row.name) for row in self.sheet.registers}
        self.state = self._registers_class(defaults)
        self.axes = (Axis(kernel, range(1 << 16), defaults["position"]),)
        self._outputs = self._outputs_class(self, self.state, self.phase_patterns(), ticks["pulse_high"])
        self._bus = self.sheet.channel(BusHandshake) or BusHandshake()  # a sister may have a different channel
        self._readout = ReadOut(self, self._bus.verify_bytes, self._group_bytes)
        self._port = self._port_class(self, ticks, self._readout)
        self._motion = self._moves(ticks)
        self._stored = Program(self, self._port, self._motion)
        self._instructions = self._instructions_class(
            self, ticks, self.state, self._outputs, self._port, self._readout, self._stored, self._motion
        )
        self._interpreter = self._interpreter_class(self, ticks, self._port, self._stored, self._instructions)
        supplied = Supplied(self._powered_up, self._cleared, self._driven)
        self._supply = Supply(self, supplied, self.sheet.times, self._power_up)
        if self._supply.powered:
            self._driven(True)
            self._clock_runs()
        check_crystal(self, self._crystal_where)
        if self._supply.powered:
            self.start()

    def phase_patterns(self) -> Patterns:
        """Return the phase levels, one row per step, in clockwise order."""
        raise NotImplementedError

    def _law(self) -> Any:
        """Return the law by which motions are planned."""
        raise NotImplementedError

    def _twin_class(self) -> type[Stepwise]:
        """Return the class of the slow twin, which plays motions step by step and is loaded on demand."""
        raise NotImplementedError

    def _moves(self, ticks: Mapping[str, int]) -> Moves:
        """Create the object that moves the motor: the fast one or, with the option `stepwise`, its slow twin."""
        moves = self._twin_class() if self.options.stepwise else self._motion_class
        return moves(self, ticks, self.state, self._outputs, self._port, self._law())

    def run(self) -> Coroutine[Any, Any, None]:
        """Return a coroutine that runs the firmware, beginning at reset."""
        return self._interpreter.run()

    # ------------------------------------------------------------------------------------------------ power and reset
    def power(self, on: bool) -> None:
        """Switch the supply on or off.

        After power-up the registers have their power-up values, and RESET must be low for 10 ms; if nothing
        drives RESET, the capacitor of fig. 9.1 keeps it low.

        Raises:
            UsageError: `on` is neither True nor False.
        """
        self._check_switch(on)
        self._supply.switch(on)

    def reset(self) -> None:
        """Pulse RESET low for 120 clocks, beginning now (20 µs with a 6 MHz crystal)."""
        self.pin("reset").pulse(0, self.clock.ps(120) + 1)

    def _powered_up(self) -> None:
        """Set the registers to their power-up values, drive every output, and start the clock output CLK/15."""
        self.state.power_up()
        self.axes[0].load(self.state.defaults["position"])
        self._driven(True)
        self._clock_runs()

    def _cleared(self) -> None:
        """Clear the program, motion, partial command, flags and pointers; the firmware must have stopped."""
        self._stored.clear()
        self._motion.killed()
        self.on_command("")
        self._port.begin()
        self._interpreter.decoder.reset()
        self._readout.clear()
        self.state.clear()
        self._outputs.clear()

    def _driven(self, on: bool) -> None:
        """Drive outputs to 1 (s.13), but release PROG/LIVE, which is pulled up; if not `on`, release all outputs."""
        for name, driver in self.drivers.items():
            row = self.sheet.pin(name)
            if row.role != "ready" and (row.reset == 1 or not on):
                driver.drive(row.reset if on and row.in_out == "out" else None)
        self._port.rest(on)

    def _clock_runs(self) -> None:
        """Start the output CLK/15, which runs from power-up, regardless of anything else (s.13)."""
        clock = Playing(StepTrain(self.clock, self.clock.ticks_from(self.kernel.now), ((15, OPEN),)))
        self.drivers["clk15"].play(PulseView(clock, 10))  # 5 of 15 clocks low: 0.45 µs at 11 MHz

    # ------------------------------------------------------------------------------------------------ public properties
    def left_over(self) -> list[tuple[str, str]]:
        """Return a finding's code and text for any unfinished line of the host, and for any open program entry."""
        return [*super().left_over(), *([self._open_entry()] if self._stored.entering else [])]

    @property
    def powered(self) -> bool:
        """True while the supply is on."""
        return self._supply.powered

    @property
    def registers(self) -> dict[str, int]:
        """The manual's registers by name, including the position."""
        return self._known({**self.state.values, "position": self.axes[0].position})

    @property
    def program(self) -> bytes:
        """The bytes stored in the program buffer."""
        return bytes(self._stored.buffer)

    @property
    def program_counter(self) -> int | None:
        """Buffer address of the running instruction or, during live commands, of the next; None if no program runs."""
        return self._stored.counter

    def program_rows(self) -> list[ProgramRow]:
        """Return the program buffer, one instruction per row: address, bytes and text."""
        from ...language.disassemble import program_rows

        return program_rows(self.program, self.sheet)

    def listing(self) -> str:
        """Return the stored program as text, with addresses."""
        from ...language.disassemble import listing

        return listing(self.program, self.sheet)

    def _does(self) -> tuple[str, int]:
        self._port.catch_up()
        return super()._does()

    @property
    def unfinished(self) -> str:
        """The part of an unfinished command line that has been received so far."""
        self._port.catch_up()
        return self._interpreter.decoder.unfinished

    def _group_bytes(self, group: int, ascii: bool) -> bytes:
        """Return the present bytes of a verify group: position, program, status or parameters.

        The position is in ASCII if `ascii` (V was sent in ASCII), otherwise binary; other groups are always
        binary (s.6).
        """
        position = self.axes[0].position
        if group == 0:
            return b"%05d" % position if ascii else position.to_bytes(2, "big")
        if group == 1:
            return bytes(self._stored.buffer).ljust(self.sheet.buffer_bytes, b"\0")
        if group == 2:
            return bytes([0, 0, 0, 0, 0, 0x00 if self.state.clockwise else self._bus.ccw_bit])
        values = self.state.values
        rows = (row for row in self.sheet.registers if row.name in values)
        return b"".join(values[row.name].to_bytes(row.bits // 8, "big") for row in rows)
