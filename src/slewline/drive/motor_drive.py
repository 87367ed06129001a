"""A drive: a board outputs the steps of one axis of a chip; the model runs in real time.

    host -> chip on a bench -> Feeder -> Link -> port -> board -> driver -> motor
         <-     Cable       <-  events of the board, its count, its clock

The board's crystal paces the model.  At each turn, every 5 ms, the bench has run up to the current time;
steps that are final go to the board, and cable calls that are due are made.  When the board stops by
itself, the drive is `halted`: the chip is stopped as well (`halting.py`), and the motor does not move
until `clear`.  If a board was reset, it has lost its count, and the drive is `unknown`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from os import PathLike
from time import perf_counter_ns, sleep
from typing import TYPE_CHECKING, Self

from ..bench.past import Past
from ..bench.runner import FunctionCondition
from ..core.messages.calls import answering
from ..core.time.hook import Hook
from ..core.time.timebase import Time, picoseconds
from ..core.wires.pin import Condition
from ..errors import UsageError
from . import terminals
from .blackbox import recorded
from .board.board_port import BoardPort, opened
from .board.rehearsal import TwinPort
from .board.wire import BoardConfig, BoardEvent, EnableOff
from .drive_state import DrivePath, DriveState, Phase
from .following_motor import Alignment, Following
from .live import Live
from .power import Power
from .status_line import as_line, introduction
from .stopping.findings import DriveFindings
from .stopping.halting import StopChip, stop_mode
from .stopping.reflexes import configured, inputs_of
from .stopping.rewind import Rewind
from .stopping.stop_ramps import StopRamps
from .stopping.troubles import Troubles
from .talk import Talk, identified

if TYPE_CHECKING:
    from types import TracebackType

    from ..bench import Bench
    from ..core.chip import Chip
    from .check import Checkup


class Drive:
    """A real motor on a board, which outputs the steps of one axis of a chip.

    Args:
        bench: the bench with the chip.
        chip: the chip, or its name.
        port: the name of a serial port, such as "/dev/ttyUSB0", or an open port.
        horizon: the delay between a step of the chip and that of the motor, 10 ms to 2 s; a pause of this
            computer does no harm if it is shorter than the horizon.
        axis: the number of the axis, counted from 1.
        enable: switch on the driver, which must then be named; without it the drive is a dry run: the board
            counts the steps, and STEP has no edges.
        pulses: output edges on STEP in a dry run too; a driver whose ENABLE is not wired then moves the motor.
        enable_off: when the board switches the driver off by itself, after `enable_hold`: "rest", whenever
            the motor is at rest; "halt", after a halt, and at rest if the host is silent; "never".  An
            emergency stop always switches it off, immediately; the end of a session does so when the motor
            is at rest, unless this is "never".
        enable_hold: how long the driver stays on in these cases, up to 268 s; with "rest" at least the horizon.
        stop: how the chip is stopped when the board has stopped by itself: "abort", "kill" (K of a GS-C),
            "reset" or "power"; by default the first of these that the chip has.
        start_stop: the highest rate from which the motor can stop without a ramp, such as "500 steps/s"; by
            default the first rate of each motion.
        driver: the name of the driver, such as "DM542", which determines the active level of ENABLE and the
            minimum pulse times; without it ENABLE is not driven.
        invert_dir: invert DIR relative to the direction pin of the chip.
        inputs: the wiring of the board inputs, keyed by their printed names: a pin of the chip, or "estop";
            "!" before it inverts the level.
        filter: the number of equal samples of an input, 4 us apart, before a change counts, 0 to 15; an
            emergency stop is not filtered.
        outputs: the signals of the board outputs, keyed by their printed names: pins of the chip, "fault"
            (the board has halted) or "energised"; by default the pins that programs set.
        self_start: allow a program that the chip starts by itself to move the motor.
        keep_count: set the position register to the count of a board that has kept running since an earlier
            session; refused if the position of the motor is uncertain.
        homed: the user confirms that the count of the board is the position of the motor.
        config: the configuration of the board, instead of the one that follows from chip and driver.
        black_box: the folder for the record of the session; True: a new folder in the state directory of
            this system; False: no record.
        clock: a function that returns the wall-clock time, in nanoseconds.
        wait: a function that waits for a number of seconds, or until bytes have arrived.

    Attributes:
        board: the model of the board, according to its IDENT.
        port: the open port of the board, which may have another file number after `clear`.
        power: the state of the driver: `power.on` is True while the driver is switched on, and `power.known`
            while the position is known.
        troubles: texts of all troubles since the start.
        on_event: hook, called with each event that the board reports.
        on_wake: hook, called when an external input arrives while the drive is idle: a turn is due now.

    Raises:
        UsageError: an argument is out of range or does not fit chip or board; `enable` without `driver`; the
            port does not exist or is busy; no board answers, or this version does not know the board.
        UnknownName: there is no such chip, axis or driver.
        TimeError: `horizon` is not a time.
    """

    @answering("Drive()")
    def __init__(
        self,
        bench: Bench,
        chip: Chip | str,
        port: BoardPort | str,
        *,
        horizon: Time = "100 ms",
        axis: int = 1,
        enable: bool = False,
        pulses: bool = False,
        enable_off: str = terminals.USUAL_OFF,
        enable_hold: Time = terminals.USUAL_HOLD,
        stop: str | None = None,
        start_stop: str | int | None = None,
        driver: str | None = None,
        invert_dir: bool = False,
        inputs: Mapping[str, str] | None = None,
        filter: int = 0,  # the term of data sheets
        outputs: Mapping[str, str] | None = None,
        self_start: bool = False,
        keep_count: bool = False,
        homed: bool = False,
        config: BoardConfig | None = None,
        black_box: str | PathLike[str] | bool = True,
        clock: Callable[[], int] = perf_counter_ns,
        wait: Callable[[float], object] | None = None,
    ) -> None:
        model: Chip = bench[chip] if isinstance(chip, str) else chip  # type: ignore[assignment]
        if (number := getattr(model, "number", None)) is not None:
            raise UsageError(f"chip {chip!r}: expected a chip, found an axis of one; give the chip, and axis={number}")
        if not hasattr(model, "axis"):
            raise UsageError(f"chip {chip!r}: expected a chip of the bench, or its name; axis=2 selects another axis")
        model.axis(axis)  # check that it exists
        for name, given in (("inputs", inputs), ("outputs", outputs)):
            if given is not None and not isinstance(given, Mapping):
                raise UsageError(f"{name} {given!r}: expected board pins and their chip pins, such as {{'A1': 'home'}}")
        horizon_ps = terminals.checked_horizon(horizon)
        rate = None if start_stop is None else terminals.steps_a_second(start_stop)
        terminals.checked_driver(driver, enable)
        off, how = terminals.off_policy(enable_off), stop_mode(model, stop)
        self._homed = homed
        self.on_event: Hook[[BoardEvent]] = Hook()
        self.on_wake: Hook[[]] = Hook()
        with ExitStack() as undo:
            found = port
            if isinstance(found, str):
                found = opened(found)
                undo.callback(found.close)
            board = self.board = identified(found, clock, wait or sleep)
            self._inputs = inputs_of(board, model, inputs or {})
            shown = terminals.outputs_of(board, model, outputs)
            of = (board, model, axis, shown, horizon_ps, rate, driver, not (enable or pulses), off, enable_hold)
            usual = config or terminals.usual_config(*of, invert_dir=invert_dir, filter=filter)
            usual.check()
            if found is not port and isinstance(found, TwinPort):
                found.close_contacts(each.number for each in self._inputs if not each.pin)
            usual = configured(usual, self._inputs) if inputs else usual
            session = (bench, model, axis, board, usual, horizon_ps, rate, enable, keep_count, terminals.pins_of(shown))
            self._state = DriveState(*session)
            self._path = DrivePath(self._state, clock)
            self.port = recorded(found, black_box, clock, self._path.clock.ticks)
            self._compose(off, how, self_start, wait)
            undo.pop_all()

    def _compose(self, off: EnableOff, how: str, self_start: bool, wait: Callable[[float], object] | None) -> None:
        state, path = self._state, self._path
        self.power = Power(state, path.link, path.cable, off)
        stop_ramps = StopRamps(state, path.link, path.send_tail)
        path.feeder.ramps, path.feeder.wake = stop_ramps.pieces, self.power.before_start
        self._findings = DriveFindings(state, path.feeder)
        self.troubles = self._findings.reported
        self._watch = Troubles(state, path, self._findings, StopChip(state, self._findings, how), self.on_event)
        self._talk = Talk(state, path, self.port, self.power, self._watch, wait)
        alignment = self._alignment = Alignment(state, path)
        self._motor = Following(state, path, self._talk, self._watch, alignment, self_start, self.on_wake)
        self._live = Live(state, path, self.power, stop_ramps, self._watch, self._talk, alignment, self._motor)

    def __repr__(self) -> str:
        state, dry = self._state, "" if self._state.enable else ", a dry run"
        return f"<Drive of {state.chip.name} axis {state.number}, {self.board.name}: {state.phase}{dry}>"

    # ------------------------------------------------------------------------------------------------------- queries
    @property
    def bench(self) -> Bench:
        """Present bench; another one replaces it after an input of the board has stopped the motor."""
        return self._state.bench

    @property
    def chip(self) -> Chip:
        """Chip on the present bench."""
        return self._state.chip

    @property
    def state(self) -> Phase:
        """State of the drive: "ok", "halted", "unknown" (the board has lost its count) or "closed"."""
        return self._state.phase

    @property
    def count(self) -> int | None:
        """Steps counted by the board, up minus down, as last reported; None while unknown."""
        return self._path.link.counted

    @property
    def _has_estop(self) -> bool:
        return any(not each.pin for each in self._inputs)

    def introduction(self) -> str:
        """Return one line with the chip, the board, and whether the driver is enabled."""
        return introduction(self._state, self._has_estop)

    def status(self) -> str:
        """Return one line with phase, count, driver, queued time (lead), free queue slots, link and last trouble."""
        return as_line(self._state, self._path, self.power.on, self.troubles)

    def check(self, seconds: float, priority: str = "", tell: Callable[[str], object] = lambda _text: None) -> Checkup:
        """Measure link, computer and board of an open drive; output test pulses or, if enabled, ten steps each way.

        Args:
            seconds: the duration by the wall clock.
            priority: the priority of this process, for the report.
            tell: called with progress messages, and with instructions for the user.

        Raises:
            UsageError: the drive is closed.
        """
        from .check import Check

        self._check_open()
        of = (self._state, self._path, self._talk, self.on_event, self.turn, self._has_estop)
        return Check(*of).look(seconds, priority, tell)

    # ------------------------------------------------------------------------------------------------ open and closed
    def __enter__(self) -> Self:
        try:
            self.open()
        except BaseException:
            self.port.close()
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, error: object, trace: TracebackType | None) -> None:
        self.close()

    def open(self) -> None:
        """Open the session with the board: check its version, configure it, read its count, synchronise the clocks.

        Raises:
            UsageError: no board answers, or the board's firmware is not the version that this slewline needs.
        """
        state = self._state
        state.bench.run(0)
        if self._live.rewind is None and state.bench.journal is not None:
            self.go_back_by(Past(state.bench))
        self._live.open(homed=self._homed)

    def go_back_by(self, past: Past) -> None:
        """Set up the drive to take the model back in time whenever the board stops the motor by itself.

        The model then returns to the instant at which the board stopped the motor, and its chip stops there as
        well.  Without this call, the chip is stopped at the present instant, and its position register is set to
        the board's count.

        Args:
            past: the past of the bench.  If the bench belongs to a server, pass the server's past, so that the
                hosts of the server also change to the new bench.

        Raises:
            UsageError: the bench writes no journal; going back in time needs one.
        """
        stopping = self._watch.stopping
        of = self._state, self._path, self._findings, stopping, self._motor
        self._watch.stopping = self._live.rewind = Rewind(*of, self._inputs, past, self.on_event)

    def close(self) -> None:
        """Stop the motor, adopt the board's count, switch the driver off (see `enable_off`), and close the port.

        A motion in progress is stopped by ramping down.  The current of a moving motor is not cut: if the motor
        does not come to rest, or `close` is interrupted, the board stops the motor, and switches the driver off
        by itself.
        """
        try:
            self._live.close()
        finally:
            self.port.close()

    # ----------------------------------------------------------------------------------------------------------- time
    def nanoseconds(self) -> int:
        """Return the time of the board, in nanoseconds: the clock that paces the model."""
        return self._path.clock.nanoseconds(self._path.wall())

    def align(self) -> None:
        """Align the current time of the model with that of the board."""
        self._alignment.align()

    def turn(self) -> None:
        """Receive from the board, feed it the steps of the model, make the cable calls that are due, and send.

        This is called every 5 ms, and when bytes have arrived, always between two runs of the bench.
        """
        self._live.turn()

    def due(self) -> float:
        """Return the number of seconds within which the next turn is due; `on_wake` may make it due earlier."""
        return self._live.due()

    def gate(self, call: Callable[[], object], ps: int) -> None:
        """Make a call one horizon after an instant of the model (ps), or now if no steps or calls are pending."""
        self._path.gate(call, ps)

    def run(self, duration: Time) -> None:
        """Let time run in step with the board.

        Args:
            duration: "2 s", or picoseconds.

        Raises:
            TimeError: `duration` is not a time.
            UsageError: the drive is closed.
        """
        self._check_open()
        self._live.keep_up(self._state.kernel.now + picoseconds(duration), None)
        self._state.bench.run(0)

    def run_until(self, condition: Condition | Callable[[], bool], timeout: Time = "60 s") -> None:
        """Let time run until the chip meets a condition; the motor follows one horizon later.

        Args:
            condition: a condition such as x.reaches(40), or a function that returns true when it is met.
            timeout: the longest wait.

        Raises:
            Timeout: the condition is not met in time.
            TimeError: `timeout` is not a time.
            UsageError: `condition` is neither a condition nor a function, or the drive is closed.
        """
        self._check_open()
        self._live.until(condition, timeout)

    def run_until_rest(self, timeout: Time = "60 s") -> None:
        """Let time run until the motor is at rest, and no data is in transit to the board.

        Raises:
            Timeout: the motor does not come to rest in time.
            TimeError: `timeout` is not a time.
            UsageError: the drive is closed.
        """
        state, cable = self._state, self._path.cable
        self.run_until(
            FunctionCondition(
                lambda: not state.axis.moving and state.chip.idle and not cable.in_progress, "the motor at rest"
            ),
            timeout,
        )

    def _check_open(self) -> None:
        if self._state.phase == "closed":
            raise UsageError(
                "the drive is closed; write: with slewline.Drive(bench, x, port) as drive: drive.run('2 s')"
            )

    def stop(self, at_once: bool = False) -> None:
        """Stop the motor; the drive is then halted.

        Args:
            at_once: False: ramp down; True: make no further step.

        Raises:
            UsageError: the drive is closed.
        """
        self._check_open()
        self._live.stop(at_once)

    def clear(self, *, homed: bool = False, homing: bool = False) -> None:
        """Continue after a halt: the board counts from the position of the chip, and the chip is released.

        A driver that the board has switched off remains off, unless `homed` or `homing` is given.

        Args:
            homed: the user confirms that the position register holds the position of the motor.
            homing: the motor is being homed; until homing has ended, the position is unknown (`power.known`).

        Raises:
            UsageError: the drive is closed or not halted, the chip is in motion, the port is still missing, an
                emergency stop is active, or `homed` and `homing` are both given.
        """
        self._check_open()
        if homed and homing:
            raise UsageError("clear: 'homed' and 'homing' are both given; give only one of them")
        self._live.clear(homed, homing)
