"""A motor on a real module, moved, homed and stopped with the commands in the part's data sheet.

    motor = ModuleMotor(module, calculator, {"S": 10, "T": 100, "R": 50})
    motor.move(1200)             # or, with another ramp, motor.move(1200, motor.fitted(100, 2000, 0.05))
    while not motor.at_rest():   # waits some 50 ms
        ...
    motor.position

If a part moves only in a program, each move is a program, which is entered, run, and kept until the next
move.  If a part reports whether it is busy, its state is queried; otherwise the position is queried only
at the calculated end of the move, because the part may not be able to receive before then.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING

from ..core.time.timebase import PS_PER_S
from ..errors import UsageError
from ..language.dialect import dialect_of
from ..language.ramp_answers import Search, Wanted, nearest, read, value_of
from ..modules.failures import ModuleFailure, NoAnswer, RefusedCommand
from ..modules.module import TRIES

if TYPE_CHECKING:
    from ..core.datasheet.table import Row
    from ..language.ramp_answers import Calculator, Ramp, RampParameter, Value, Values
    from ..modules.module import Module

LOOK_S = 0.05  # between two queries as to whether it is at rest
LOOKS = 40  # queries for a program without motion
SETTLED_S = 0.1  # after a move, until a part receives again
LATE_S = 5.0  # how long after the end predicted by the law the module must answer
LONGER = 2.0  # and factor, because its clock may differ


class ModuleMotor:
    """A motor on a module.

    Args:
        module: the module; its `may_move` must be True.
        calculator: the ramp calculator of the part.
        values: all ramp parameters of the part, such as {"T": 100} or {"T": "1000 steps/s"}.
        crystal_hz: the part's crystal frequency; None for the one in its data sheet.

    Raises:
        UsageError: a parameter is missing, wrong or unknown; or the part cannot move to positions.
    """

    def __init__(
        self, module: Module, calculator: Calculator, values: Mapping[str, Value], crystal_hz: int | None = None
    ) -> None:
        self.module, self.calculator = module, calculator
        self.sheet = module.speech.sheet
        self.crystal_hz = crystal_hz or self.sheet.crystal_hz
        self.values, _ = read(calculator, values, self.crystal_hz, search=False)
        self.goto = next(iter(self.sheet.acting("goto")), None)
        if self.goto is None:
            raise UsageError(f"{self.sheet.part} has no command that moves to a position; use a part that has one")
        self.homing = next((row for row in self.sheet.acting("home") if row.args[0].sign == "alone"), None)
        self.presetting = next(iter(self.sheet.acting("preset")), None)
        stops = {row.at_once: row for row in self.sheet.commands if row.at_once}
        self.stopping = stops.get("brake", stops.get("stop"))
        self.state = next(iter(self.sheet.acting("state")), None)
        self.entered = "i" not in self.goto.when  # a move is a program
        self.left_s = 0.0  # until a move should be over
        self.late_s = 0.0
        self.position = 0
        self.look()

    # ------------------------------------------------------------------------------------------------------ properties
    @property
    def limits(self) -> tuple[int, int]:
        """The lowest and highest positions to which a command can move."""
        assert self.goto is not None  # noqa: S101  # the constructor has refused that
        return self.goto.args[0].low, self.goto.args[0].high

    @property
    def ramp(self) -> Ramp:
        """The ramp of the motor's moves."""
        return self.calculator.ramp(self.values, self.crystal_hz)

    @property
    def rates(self) -> tuple[RampParameter, RampParameter]:
        """The parameters that set the first and the highest rate of a ramp, in this order."""
        rates = [quantity for quantity in self.calculator.quantities if quantity.per_s == 1]
        return rates[0], rates[-1]

    @property
    def fastest(self) -> float:
        """The highest rate that the rate parameter can set (steps/s)."""
        _, top = self.rates
        highest = self.calculator.arg(top.name).high
        return self.calculator.ramp({**self.values, top.name: highest}, self.crystal_hz).top

    def fitted(self, start: float, top: float, time_s: float) -> Ramp:
        """Return the ramp nearest to a start rate and a top rate (steps/s) and a ramp time (s).

        Raises:
            UsageError: the part does not support one of the rates.
        """
        rates = zip(self.rates, (start, top), strict=True)
        values = {**self.values}
        for quantity, rate in rates:
            values[quantity.name] = value_of(self.calculator, quantity, f"{rate:.12g} steps/s", self.crystal_hz)
        free = [quantity.name for quantity in self.calculator.quantities if quantity.free and quantity.name in values]
        wanted = Wanted("time", round(time_s * PS_PER_S))
        return nearest(self.calculator, Search(wanted, values, free, self.crystal_hz, best=1))[0]

    def foreign_program(self) -> int:
        """Return the line count of a stored program that is not a move (the next move overwrites it); 0 if none."""
        (listing, *_) = (*self.sheet.acting("list"), None)
        if not self.entered or listing is None:
            return 0
        lines = self.module.ask(listing.form).lines[:-1]
        rows = [self.module.speech.row(line) for line in lines]
        ours = {*self._settings(self.values), self.goto}
        return 0 if all(row in ours for row in rows) else len(lines)

    # ---------------------------------------------------------------------------------------------------------- motions
    def move(self, position: int, ramp: Ramp | None = None) -> None:
        """Begin a move to a position, by default with the motor's own ramp.

        Raises:
            ModuleFailure: the module does not execute the command.
        """
        assert self.goto is not None  # noqa: S101  # the constructor has refused that
        ramp = self.ramp if ramp is None else ramp
        commands = self._program(ramp, self._spelled(self.goto, position))
        speech, distance = self.module.speech, abs(position - self.position)
        sent_s = sum(len(speech.framed(command)) for command in commands) * speech.character_s
        self.left_s = SETTLED_S + sent_s + (ramp.move(distance).time_ps / PS_PER_S if distance else 0.0)
        self.late_s = LATE_S + self.left_s * LONGER

    def _program(self, ramp: Ramp, *moving: str) -> list[str]:
        """Send a ramp's settings and the commands `moving`, as a program if required; return all commands sent."""
        settings = [self._spelled(row, value) for row, value in self._settings(ramp.values).items()]
        commands = [*settings, *moving]
        if self.entered:
            assert self.sheet.enter is not None  # noqa: S101  # it takes programs
            run = next(row for row in self.sheet.leave if row.starts)
            commands = [self.sheet.enter.form, *commands, run.form]
        try:
            for command in commands:
                self.module.ask(command)
        except ModuleFailure:
            self._leave_entry()
            raise
        return commands

    def _settings(self, values: Values) -> dict[Row, int]:
        """Return the commands that set the parameters of a ramp, each with the value of its parameter."""
        rows = {row.form: row for row in self.sheet.commands}
        return {rows[name]: value for name, value in values.items() if isinstance(value, int) and name in rows}

    def _spelled(self, row: Row, value: int) -> str:
        return dialect_of(self.sheet).spell(row, (value,))

    def _leave_entry(self) -> None:
        """End an open program entry without running the program, if the part supports this."""
        row = self.sheet.leave[-1]
        if self.module.entering and not row.starts:
            with suppress(ModuleFailure):
                self.module.ask(row.form)

    def home(self, direction: int, ramp: Ramp | None = None) -> None:
        """Begin a homing run in direction 1 or -1, at the first rate of a ramp, by default the motor's own ramp.

        Raises:
            UsageError: the part has no homing command with a selectable direction.
            ModuleFailure: the module does not execute the command.
        """
        if self.homing is None:
            raise UsageError(
                f"{self.sheet.part} has no homing command with a selectable direction; send the homing command of the "
                "part, if any, with slewline terminal"
            )
        self._program(self.ramp if ramp is None else ramp)
        for _ in range(LOOKS):  # a program without a motion is soon over; any other makes the module refuse to home
            if self.at_rest():
                break
        self.module.ask(self._spelled(self.homing, direction))
        self.left_s = self.late_s = 0.0

    def preset(self, position: int) -> None:
        """Set the position register, without motion.

        Raises:
            UsageError: the part has no command for this, or its command does not allow this position.
            ModuleFailure: the module does not execute the command.
        """
        if self.presetting is None:
            raise UsageError(
                f"{self.sheet.part} has no command that sets the position; change the offset (OFF) instead"
            )
        allowed = self.presetting.args[0]
        if not allowed.low <= position <= allowed.high:
            raise UsageError(
                f"{self.sheet.part}: position {position} steps; allowed {allowed.low}..{allowed.high} steps"
            )
        self.module.ask(self._spelled(self.presetting, position))
        self.look()

    def stop(self) -> None:
        """Stop the motor, with a ramp if the part has one.

        Raises:
            UsageError: the part executes no command while it moves.
            ModuleFailure: the module does not execute the command.
        """
        if self.stopping is None:
            raise UsageError(
                f"{self.sheet.part}: accepts no command while the motor moves; stop the motor through the pins "
                "of the part"
            )
        self.module.ask(self.stopping.form)

    def at_rest(self) -> bool:
        """Wait some 50 ms; return whether the motor is at rest and, if so, update `position`.

        Raises:
            ModuleFailure: the module does not report the position.
        """
        self.module.port.pause(LOOK_S)
        if self.state is None:
            return self._has_answered()
        try:
            self.module.ask(self.state.form)
        except RefusedCommand as refused:
            if refused.code != getattr(self.sheet.dialect, "busy", None):
                raise
            return False
        self.look()
        return True

    def look(self) -> None:
        """Query the position of a motor at rest.

        Raises:
            ModuleFailure: the module does not report the position.
        """
        self.position = int(self.module.value("position"))

    def _has_answered(self) -> bool:
        """Query the position if the motor should be at rest by now; return whether the module has answered."""
        self.left_s -= LOOK_S
        if self.left_s > 0:
            return False
        try:
            self.look()
        except NoAnswer:
            question, _ = self.module.speech.questions["position"]
            self.left_s -= TRIES * self.module.speech.answer_timeout(question)
            if self.left_s < -self.late_s:
                raise
            return False
        return True
