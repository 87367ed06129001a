"""The CY545 and CY545B: classes that start and stop the firmware, show its state, and own these objects.

registers, user_bits      the memory of the chip, and the lines that programs switch and test
local_bus                 memory, thumbwheel switches and HP display on the data bus
port, serial_side, sides  the two host interfaces, and the arbiter that orders their bytes
display                   the destination of replies and strings
steps, motion, jog, home  the motion of the motor
program, instructions, interpreter: the execution of commands
"""

from __future__ import annotations

from collections.abc import Coroutine, Mapping
from typing import TYPE_CHECKING, Any

from ...core.chip import Chip
from ...core.motion.axis import Axis
from ...core.time.kernel import Kernel
from ..cy5xx.crystal import check_crystal, clocks
from ..cy5xx.supply import PowerUp, Supplied, Supply
from . import sheet
from .external_program import Program
from .instructions import Instructions
from .interfaces.arbiter import InputArbiter
from .interfaces.display import Display
from .interfaces.local_bus import LocalBus
from .interfaces.parallel_side import ParallelPort
from .interfaces.serial_side import SerialSide
from .interfaces.user_bits import UserBits
from .interpreter import Interpreter
from .profile import law_of
from .registers import Registers
from .stepping.home import Home
from .stepping.jog import Jog
from .stepping.motion import Motion
from .stepping.pulse_outputs import StepOutputs

if TYPE_CHECKING:
    from ..cy5xx.program_buffer import Moves
    from .twin import Homewise, Stepwise


class Cy545(Chip):
    """A CY545 on a bench."""

    _for_users = ("powered", "baud")
    sheet = sheet.CY545
    _jog: Jog

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        self.sheet = sheet.fitted(type(self).sheet, vars(self.options))
        ticks = clocks(self)
        defaults = {row.name: row.default for row in self.sheet.registers}
        self.state = Registers(defaults)
        self.axes = (Axis(kernel, range(sheet.POSITIONS), defaults["position"]),)
        self._bits = UserBits(self, self.state)
        self._local_bus = LocalBus(self, ticks, self._bits)
        self._port = ParallelPort(self, ticks, self._bits)
        self._serial = SerialSide(self, ticks, self._bits)
        self._sides = InputArbiter(self, self._port, self._serial)
        self._display = Display(self, self.state, self._local_bus, self._port, self._serial)
        self._moved_by(ticks)
        self._stored = Program(self, self.state)
        self._instructions = Instructions(
            self, ticks, self.state, self._outputs, self._motion, self._home, self._bits, self._display,
            self._local_bus, self._stored, self._restart,
        )  # fmt: skip
        self._interpreter = Interpreter(
            self, ticks, self.state, self._sides, self._local_bus, self._stored, self._instructions, self._jog
        )
        supplied = Supplied(self._powered_up, self._cleared, self._driven)
        power_up = PowerUp(ticks["reset_pulse"], sheet.POWER_UP_PS)
        self._supply = Supply(self, supplied, self.sheet.times, power_up)
        check_crystal(self, "the sheet")
        if self._supply.powered:
            self._powered_up()
            self.start()
        else:
            self._driven(False)

    def _moved_by(self, ticks: Mapping[str, int]) -> None:
        """Create the objects that move the motor: the fast ones or, with the option `stepwise`, their slow twins."""
        options, state, shown = self.options, self.state, self._display.position
        law = law_of(self.sheet)
        self._outputs = StepOutputs(self, state, ticks)
        moves: type[Motion | Stepwise]
        seeks: type[Home | Homewise]
        moves, seeks = self._twins() if options.stepwise else (Motion, Home)
        self._motion: Moves = moves(self, ticks, state, self._outputs, law)
        self._jog = Jog(self, ticks, state, self._outputs, law, shown)
        self._home = seeks(self, ticks, state, self._outputs, law, shown, self._bits)

    def _twins(self) -> tuple[type[Stepwise], type[Homewise]]:
        from .twin import Homewise, Stepwise

        return Stepwise, Homewise

    def run(self) -> Coroutine[Any, Any, None]:
        """Run the firmware, beginning at reset."""
        return self._interpreter.run()

    # ------------------------------------------------------------------------------------------------ power and reset
    def power(self, on: bool) -> None:
        """Switch the supply on or off; at power-up the chip resets itself, unless RESET is driven.

        Raises:
            UsageError: `on` is neither True nor False.
        """
        self._check_switch(on)
        self._supply.switch(on)

    def reset(self) -> None:
        """Pulse RESET high for 30 clocks, beginning now."""
        self.pin("reset").pulse(1, self.clock.ps(30) + 1)

    def _powered_up(self) -> None:
        """Set all state to its power-up values; drive every output."""
        self._restart()
        self._driven(True)
        self._sides.reset()

    def _restart(self) -> None:
        """Set registers, position, mode and outputs as after power-up, and end any program.

        RESET and the I command do this (ch.10).  A transfer in progress continues, but the serial side measures
        its baud rate again.
        """
        self.state.clear()
        self.state.clockwise = self.options.direction == "+"
        self.axes[0].load(self.state.defaults["position"])
        self._stored.clear()
        self._interpreter.decoder.reset()
        self._bits.clear()
        self._outputs.clear()
        self._sides.restart()

    def _cleared(self) -> None:
        """Clear the state of program, motion, commands and bus, after the firmware has been stopped."""
        self._motion.killed()
        self._home.killed()
        self.on_command("")
        self._restart()

    def _driven(self, on: bool) -> None:
        """Drive every output to its reset level if the supply is on; otherwise, release all outputs."""
        for row in self.sheet.pins:
            if row.name in self.drivers:
                self.drivers[row.name].drive(row.reset if on and row.in_out == "out" else None)
        self._sides.killed(on)

    def start(self) -> None:
        """Start the firmware at this instant."""
        super().start()
        self._sides.reset()

    # ------------------------------------------------------------------------------------------------ public properties
    def left_over(self) -> list[tuple[str, str]]:
        """Return findings (code, text) about unfinished input of the host: a line, or a program entry without Q."""
        return [*super().left_over(), *([self._open_entry()] if self._stored.entering else [])]

    @property
    def powered(self) -> bool:
        """True while the supply is on."""
        return self._supply.powered

    @property
    def answering(self) -> bool:
        """True while a command line of the serial host is in progress, or its answer is being sent."""
        return self._sides.answering

    @property
    def baud(self) -> float:
        """The baud rate of the serial side; 0 if it is not known."""
        return self._serial.rate or 0

    @property
    def awaits_host(self) -> bool:
        """True while the chip waits for the rest of a command or of a handshake."""
        return self._port.host_is_next or self._sides.unfinished

    @property
    def registers(self) -> dict[str, int]:
        """The registers by name, including the position."""
        return self._known({**self.state.values, "position": self.axes[0].position})

    @property
    def program_counter(self) -> int | None:
        """Address of the present program command or, during a host command, of the next; None if no program runs."""
        return self._stored.counter

    def _does(self) -> tuple[str, int]:
        self._port.catch_up()
        self._serial.catch_up()
        return super()._does()

    @property
    def unfinished(self) -> str:
        """The part of a command line that has been received so far."""
        self._serial.catch_up()
        coming = self._port.catch_up() if self.state.ascii else ""
        return self._interpreter.decoder.unfinished + coming

    @property
    def _lacking(self) -> str:
        """The name of the character that would end the line received so far or, within a string, end the string."""
        return "quotation mark" if self._interpreter.decoder.in_string else super()._lacking


class Cy545B(Cy545):
    """A CY545B on a bench: it accepts host commands while it runs a program."""

    sheet = sheet.CY545B
