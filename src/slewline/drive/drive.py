"""A drive: a board makes the steps of one axis of a chip, while the model lives in the present.

    host -> chip on a bench -> Feeder -> Link -> port -> board -> driver -> motor
         <-     Cable       <-  events of the board, its count, its clock

The crystal of the board paces the model.  Each turn, every 5 ms, the bench is at the present; steps that are final go
to the board, and what is due leaves the cable.  When the board stops by itself, the drive is `halted`: the chip is
stopped as well (`halting.py`), and nothing moves until `clear`.  A board that was reset has lost its count: the drive
is `unknown`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from dataclasses import replace
from os import PathLike
from pathlib import Path
from time import perf_counter_ns, sleep
from typing import TYPE_CHECKING, Literal, Self

from ..bench.rewinding import ReachablePast
from ..bench.runner import FunctionCondition
from ..core.time.hook import Hook
from ..core.time.timebase import PS_PER_S, Time, picoseconds, readable
from ..core.wires.pin import Condition
from ..errors import UsageError
from .blackbox import BlackBox, new_folder
from .board.clock import BoardClock
from .board.link import Link
from .board.port import BoardPort, opened
from .board.rehearsal import TwinPort
from .board.wire import BoardConfig, BoardEvent, BoardState
from .cable import Cable
from .driven import DriveState, Exchanger, Stopping, Telling
from .drivers import STEP_DRIVERS
from .feeder import Feeder, LaidOutput
from .live import Live
from .power import USUAL_HOLD, USUAL_OFF, Power, hold_of, least_hold, off_policy
from .stopping.alone import Alone
from .stopping.halting import StopChip
from .stopping.reflexes import configured, inputs_of
from .stopping.rewind import Rewind
from .stopping.troubles import Troubles, signed
from .stopping.ways import WaysDown
from .talk import WAY_DOWN_S, Talk, identified
from .terminals import LAMPS, outputs_of, steps_a_second, usual_config
from .ticks import TickMap

if TYPE_CHECKING:
    from types import TracebackType

    from ..bench import Bench
    from ..core.chip import Chip
    from ..core.motion.axis import Axis
    from ..core.wires.net import Net

STEADY_TURNS = 20
SHADOWS = 3  # of the past, each for one more try
SILENT = ("drive", "run", "power", "conclude")  # inputs that tell a chip nothing
LEAST_HORIZON_PS, MOST_HORIZON_PS = 10 * 10**9, 2 * PS_PER_S


def checked_horizon(horizon: Time) -> int:
    """Return a horizon in picoseconds.

    Raises:
        TimeError: it is not a time.
        UsageError: it is out of range.
    """
    ps = picoseconds(horizon)
    if not LEAST_HORIZON_PS <= ps <= MOST_HORIZON_PS:
        allowed = f"{readable(LEAST_HORIZON_PS)} to {readable(MOST_HORIZON_PS)}"
        raise UsageError(f"horizon {horizon!r}; allowed {allowed}")
    return ps


class Drive:
    """A real motor on a board, which makes the steps of one axis of a chip.

    Args:
        bench: the bench with the chip.
        chip: the chip, or its name.
        port: the name of a serial port, such as "/dev/ttyUSB0", or an open port.
        horizon: the delay from a step of the chip to that of the motor, 10 ms to 2 s; a pause of this computer does no
            harm as long as it is shorter.
        axis: the number of the axis, counted from 1.
        enable: switch the driver on, which is to be named; without it the drive is a dry run: the board counts the
            steps, and STEP has no edges.
        pulses: let STEP have edges in a dry run too; a driver whose ENABLE is not wired moves the motor then.
        enable_off: when the board switches the driver off by itself, after `enable_hold`: "rest", whenever the motor is
            at rest; "halt", after a halt, and at rest when its host is silent; "never".  An emergency stop always
            does, immediately.  So does the end of a session, unless "never", when the motor is at rest.
        enable_hold: the time for which the driver stays on then, up to 268 s; with "rest" at least the horizon.
        stop: how the chip is stopped when the board has stopped by itself: "abort", "kill" (K of a GS-C), "reset" or
            "power"; by default the first of these that the chip has.
        start_stop: the rate from which the motor can stop at once, such as "500 steps/s"; by default the first rate of
            the motion.
        driver: the name of the driver, such as "DM542", which gives the level of ENABLE and minimum pulse times;
            without it ENABLE has no level.
        invert_dir: let DIR have the other level than the direction pin of the chip.
        inputs: the wiring of inputs of the board, by their printed names: a pin of the chip, or "estop"; "!" before it
            inverts the level.
        filter: how often an input is looked at, 4 us apart, before a change counts, 0 to 15; an emergency stop is not
            filtered.
        outputs: what outputs of the board show, by their printed names: pins of the chip, "fault" (the board has
            halted) or "energised"; by default the pins that programs set.
        self_start: allow a program that the chip starts by itself to move the motor.
        keep_count: take over the count of a board that has kept running since an earlier session, as the position
            register; refused where the motor may be elsewhere.
        homed: the user says that the motor is where the board has counted it to be.
        config: the configuration of the board, instead of the one that follows from chip and driver.
        black_box: the folder for the record of the session; True: a new folder in the state directory of this system;
            False: no record.
        clock: a function that returns the time of the wall clock, in nanoseconds.
        wait: a function that waits for a number of seconds, or until bytes have come.

    Attributes:
        board: the model of the board, which is looked up by what the board reports.
        state: "ok", "halted", "unknown" (the board has lost its count) or "closed".
        power: the current of the driver: `power.on`, and `power.known`, whether the position is.
        troubles: what has gone wrong since the start, in words.
        on_event: hook, called with each event that the board reports.
        on_wake: hook, called when something comes from outside while nothing is to be done: a turn is due now.

    Raises:
        UsageError: an argument is out of range or does not fit chip or board; `enable` without `driver`; the port does
            not exist or is busy; no board answers, or one that this version does not know.
        UnknownName: there is no such chip, axis or driver.
        TimeError: `horizon` is not a time.
    """

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
        enable_off: str = USUAL_OFF,
        enable_hold: Time = USUAL_HOLD,
        stop: str | None = None,
        start_stop: str | int | None = None,
        driver: str | None = None,
        invert_dir: bool = False,
        inputs: Mapping[str, str] | None = None,
        filter: int = 0,  # the word of data sheets
        outputs: Mapping[str, str] | None = None,
        self_start: bool = False,
        keep_count: bool = False,
        homed: bool = False,
        config: BoardConfig | None = None,
        black_box: str | PathLike[str] | bool = True,
        clock: Callable[[], int] = perf_counter_ns,
        wait: Callable[[float], object] | None = None,
    ) -> None:
        self.bench, self.axis_number = bench, axis
        self.chip: Chip = bench[chip] if isinstance(chip, str) else chip  # type: ignore[assignment]
        self.axis: Axis = self.chip.axis(axis).motor
        self.kernel = bench.kernel
        self.horizon_ps = checked_horizon(horizon)
        self.start_stop = None if start_stop is None else steps_a_second(start_stop)
        if enable and driver is None:
            raise UsageError(
                "enable needs the name of the driver, which says the level of its ENABLE: driver='DM542' (--driver); "
                "known: " + ", ".join(STEP_DRIVERS)
            )
        self.enable, self.homed = enable, homed
        self.counted_from = self.count_origin = 0
        self.keep_count = keep_count
        # Has anything been said to the chip, so that it may move?
        self.spoken = self_start or bench.now_ps > 0 or any(not part.idle for part in bench.parts.values())
        self.state: DriveState = "closed"
        self.on_event: Hook[[BoardEvent]] = Hook()
        self.on_wake: Hook[[]] = Hook()
        self._to_stop = False  # ordered by the user, and not yet stopped by the board
        self.wall = clock
        self.power = Power(self, off_policy(enable_off))
        self.stopping: Stopping = StopChip(self, stop)
        self.rewind: Rewind | None = None
        self.ways = WaysDown(self)
        with ExitStack() as undo:
            by_name = isinstance(port, str)
            if isinstance(port, str):
                port = opened(port)
                undo.callback(port.close)
            board = self.board = identified(port, clock, wait or sleep)
            self.horizon = self.horizon_ps * board.hz // PS_PER_S
            self.board_inputs = inputs_of(board, self.chip, inputs or {})
            shown = outputs_of(board, self.chip, outputs)
            self.outputs = {number: name for number, name in shown.items() if name not in LAMPS}
            usual = config or replace(
                usual_config(
                    board,
                    self.chip,
                    axis,
                    shown,
                    self.horizon_ps,
                    self.start_stop,
                    driver,
                    dry=not (enable or pulses),
                    invert_dir=invert_dir,
                ),
                enable_off=self.power.off,
                enable_hold=max(hold_of(board, enable_hold), least_hold(self.power.off, self.horizon)),
                filter=filter,
            )
            usual.check()
            self.config = configured(usual, self.board_inputs) if inputs else usual
            if by_name and isinstance(port, TwinPort):
                port.close_contacts(each.number for each in self.board_inputs if not each.pin)
            self.clock = BoardClock(board.hz)
            self.link = Link(self.clock)
            self.ticks = TickMap(board.hz)
            self.feeder = Feeder(
                self.axis,
                self.kernel,
                self.link,
                self.ticks,
                self.horizon,
                board.shortest,
                self._put,
                self._half,
                self.ways.pieces,
                self.power.before_start,
            )
            self.cable = Cable(self.horizon, lambda: self.ticks.at(self.kernel.now) >> 16, self._under_way)
            self.watch: Telling = (troubles := Troubles(self))
            self.troubles = troubles.told
            self.talk = Talk(self, troubles, wait)
            self._live = Live(self, self.talk)
            self.box = None if black_box is False else self._recorded(port, black_box)
            self.port: BoardPort = port if self.box is None else self.box
            undo.pop_all()

    def _recorded(self, port: BoardPort, black_box: str | PathLike[str] | Literal[True]) -> BlackBox:
        """Return a port that also records what goes over another one, in a folder; True: a new folder."""
        folder = new_folder() if black_box is True else Path(black_box)
        folder.mkdir(parents=True, exist_ok=True)
        return BlackBox(port, folder, self.wall, self.clock.ticks)

    def __repr__(self) -> str:
        dry = "" if self.enable else ", a dry run"
        return f"<Drive of {self.chip.name} axis {self.axis_number}, {self.board.name}: {self.state}{dry}>"

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
            UsageError: no board answers, or one with another version of the firmware.
        """
        self.bench.run(0)
        if self.rewind is None and self.bench.journal is not None:
            self.go_back_by(Alone(self))
        found = self.talk.set_up(known=self.homed, power=True)
        self.power.began(known=self.homed)
        self.watch.goes_on(found, self.keep_count)
        for net, _ in self.nets():
            net.watch(self._output)
        self.kernel.outside.on_input.add(self._heard)
        self._begin()

    def go_back_by(self, exchanges: Exchanger) -> None:
        """When the board stops the motor by itself, go back to that instant and let the chip stop there, as it would.

        Without this the chip is stopped at the present instant, and its position register takes the count of the board.

        Args:
            exchanges: replaces the present bench by another one, replayed to that instant.

        Raises:
            UsageError: the bench writes no journal, which going back needs.
        """
        journal = self.bench.journal
        if journal is None:
            raise UsageError('going back needs a journal: Bench(journal="FILE")')
        past = ReachablePast(journal.path, exchanges.listen, SHADOWS)
        copy = Path(f"{journal.path}.other")
        self.rewind = Rewind(self, past, exchanges.exchange, self.board_inputs, copy, forget=exchanges.forget)

    def _heard(self, do: str, _what: object) -> None:
        """Something comes from outside; levels and time do not let a chip move."""
        if do not in SILENT:
            self.spoken = True
        if self.link.at_rest:
            self.link.at_rest = False
            self.on_wake()

    def nets(self) -> list[tuple[Net, int]]:
        """Return the nets that set outputs of the board, and the number of each output."""
        return [(self.chip.pin(name).net, number) for number, name in self.outputs.items()]

    def _begin(self) -> None:
        """The model is at the present of the board from now on."""
        self.align()
        self.feeder.go_on()
        self.state = "ok"
        self.talk.begin()

    def close(self) -> None:
        """Let the motor come to rest, take its count over, switch the driver off as `enable_off` says, close the port.

        A motion that is under way is stopped by ramping down.  The current is not taken from a motor that moves: if it
        does not come to rest, or this is interrupted, the board stops it, and switches off by itself.
        """
        try:
            if self.state != "closed":
                self._come_to_rest()
                self.cable.flush()
                self.talk.finish()
        finally:
            if self.state != "closed":
                for net, _ in self.nets():
                    net.unwatch(self._output)
                self.kernel.outside.on_input.remove(self._heard)
                self.bench.run(0)  # a journal learns how far time has gone
            self.state = "closed"
            self.port.close()

    def _come_to_rest(self) -> None:
        """Ramp down what moves, switch the driver off, and let the register of the chip be where the motor is."""
        if self.state == "ok" and self.feeder.busy and not (self.chip.idle and not self.axis.moving):
            self.stop()
        limit = self.wall() + 2 * self.horizon_ps // 1000 + int(WAY_DOWN_S * 10**9)
        self._pass_while(self._motor_moves, limit)
        if not self._motor_moves():
            self.power.switch_off()
        self._pass_while(lambda: self.state == "halted" and not self.stopping.settled, limit)

    def _motor_moves(self) -> bool:
        """May the board still make steps?"""
        return self.cable.under_way if self.state == "ok" else self.state == "halted" and not self.watch.final

    def _pass_while(self, goes_on: Callable[[], bool], limit: int) -> None:
        """Let time pass while something is so, up to a limit on the wall clock (ns)."""
        while goes_on() and self.wall() < limit:
            self._live.keep_up(self.kernel.now + picoseconds("5 ms"), None)

    # ----------------------------------------------------------------------------------------------------------- time
    def nanoseconds(self) -> int:
        """Return the time of the board, in nanoseconds: the clock that paces the model."""
        return self.clock.nanoseconds(self.wall())

    def align(self) -> None:
        """Let the present of the model be that of the board."""
        self.ticks.align(self.kernel.now, self.clock.ticks(self.wall()))
        self._steady = 0  # turns since which the model is as far off as now
        self._looked = (-1, 0)  # where the model was at the last turn, ps, and how far off, ticks
        self._jumps = self.clock.jumps

    def turn(self) -> None:
        """Hear the board, lay what the model has done, let what is due leave, and speak.

        It is called each 5 ms, and when bytes have come; the bench is between two runs.
        """
        now = self.wall()
        if self.rewind is not None:
            self.rewind.before_turn()
        self.talk.hear(now)
        if self.clock.jumps != self._jumps:
            self.watch.clock_jumped()
            self.align()
        self._stop_chip()
        self.power.turn()
        if not self.spoken and self.state == "ok" and (self.axis.moving or self.axis.travel):
            self.watch.moved_by_itself()
        if self.state == "ok":
            tick = self.clock.ticks(now)
            self._look_for_drift(tick)
            self.ways.turn()
            try:
                self.feeder.turn(tick)
            except UsageError as error:  # faster than the board can
                self.watch.too_fast(error)
            started = self.feeder.started
            if started is not None and self.link.starting and tick > started + self.horizon:
                self.watch.not_started()
        elif self.state != "closed":
            self.feeder.turn(0)
            self.stopping.turn()
        present, until = self.clock.ticks(now), None if self.rewind is None else self.rewind.going_back_to
        self.cable.turn(present if until is None else min(present, until))
        self.link.at_rest = self._rests()
        self.talk.say(now)

    def _rests(self) -> bool:
        """Is nothing to be done until something comes from outside?"""
        if self.state != "ok" or self.axis.moving or self.cable.under_way or abs(self._looked[1]) > self.horizon // 4:
            return False
        answer = self.link.answer
        if answer is None or answer.state != BoardState.IDLE or not (self.link.idle and self.power.bears_silence):
            return False
        chips, parts = self.bench.chips.values(), self.bench.parts.values()
        return all(chip.idle for chip in chips) and all(part.idle for part in parts)

    def _under_way(self) -> bool:
        """Are steps under way, or is it open where the motor comes to rest, and what its host is told then?"""
        return self.feeder.busy or (self.rewind is not None and self.rewind.going_back_to is not None)

    def gate(self, call: Callable[[], object], ps: int) -> None:
        """Make a call that the model makes at an instant (ps): a horizon later while something is under way."""
        self.cable.send_at((self.ticks.at(ps) >> 16) + self.horizon, call)

    def catch_up(self) -> None:
        """Align the model if, at rest, the program has done something else meanwhile."""
        if (
            self.state == "ok"
            and not self.cable.under_way
            and abs(self._off(self.clock.ticks(self.wall()))) > self.horizon // 4
        ):
            self.align()

    def _off(self, tick: int) -> int:
        """How many ticks the model is ahead of the board."""
        return (self.ticks.at(self.kernel.now) >> 16) - tick

    def _look_for_drift(self, tick: int) -> None:
        """Align the model if, at rest, it stands, or is steadily elsewhere: a server was paused, or gave up a lag."""
        off, before = self._off(tick), self._looked
        self._looked = (self.kernel.now, off)
        if abs(off) <= self.horizon // 4 or self.cable.under_way:
            self._steady = 0
            return
        self._steady = self._steady + 1 if abs(off - before[1]) < self.horizon // 50 else 0
        if self._steady >= STEADY_TURNS or before[0] == self.kernel.now:
            self.align()

    def due(self) -> float:
        """Return in how many seconds the next turn is due at the latest, unless it is to wake before (`on_wake`)."""
        due, following = self.talk.due(), self.kernel.next_time() if self.link.at_rest else None
        return due if following is None else min(due, max(following - self.kernel.now, 0) / PS_PER_S)

    def run(self, duration: Time) -> None:
        """Let time pass, in step with the board.

        Args:
            duration: "2 s", or picoseconds.

        Raises:
            TimeError: `duration` is not a time.
            UsageError: the drive is closed.
        """
        self._check_open()
        self._live.keep_up(self.kernel.now + picoseconds(duration), None)
        self.bench.run(0)

    def run_until(self, condition: Condition | Callable[[], bool], timeout: Time = "60 s") -> None:
        """Let time pass until the chip meets a condition; the motor follows a horizon later.

        Args:
            condition: a condition such as x.reaches(40), or a function that returns true when it is met.
            timeout: the longest wait, from now on.

        Raises:
            Timeout: the condition is not met in time.
            TimeError: `timeout` is not a time.
            UsageError: neither a condition nor a function, or the drive is closed.
        """
        self._check_open()
        self._live.until(condition, timeout)

    def run_until_rest(self, timeout: Time = "60 s") -> None:
        """Let time pass until the motor is at rest, and nothing is on its way to the board.

        Raises:
            Timeout: the motor does not come to rest in time.
            TimeError: `timeout` is not a time.
            UsageError: the drive is closed.
        """
        self.run_until(
            FunctionCondition(
                lambda: not self.axis.moving and self.chip.idle and not self.cable.under_way, "the motor at rest"
            ),
            timeout,
        )

    def _check_open(self) -> None:
        if self.state == "closed":
            raise UsageError(
                "the drive is closed; write: with slewline.Drive(bench, x, port) as drive: drive.run('2 s')"
            )

    def move(self, bench: Bench) -> None:
        """Go on with another bench, which is at the same instant and has a chip of the same name."""
        for net, _ in self.nets():
            with suppress(ValueError, KeyError):
                net.unwatch(self._output)
        self.kernel.outside.on_input.remove(self._heard)
        self.bench, self.kernel = bench, bench.kernel
        self.kernel.outside.on_input.add(self._heard)
        self.chip = bench.chips[self.chip.name]
        self.axis = self.chip.axis(self.axis_number).motor
        self.feeder.axis, self.feeder.kernel = self.axis, bench.kernel
        for net, _ in self.nets():
            net.watch(self._output)

    def resume(self, position: int, since_ps: int) -> None:
        """Let a board that has stopped go on: it counts from a position, and makes the steps after an instant (ps).

        Raises:
            UsageError: the board does not follow: an emergency stop is active.
        """
        self.talk.set_up(position)
        present = self.clock.ticks(self.wall())
        following = self.axis.times(since_ps + 1, self.kernel.now)
        first = int(following[0]) if len(following) else self.kernel.now
        self.ticks.align(first, present - 3 * self.horizon // 4 if len(following) else present)
        self.feeder.resume(max(since_ps + 1, 0))
        self.state = "ok"
        self.talk.begin()

    # -------------------------------------------------------------------------------------------------- what is asked
    @property
    def count(self) -> int | None:
        """The steps counted by the board, up minus down, as it last reported; None while it is unknown."""
        return self.link.counted

    def stop(self, at_once: bool = False) -> None:
        """Stop the motor, after which the drive is halted.

        Args:
            at_once: False: ramp down; True: make no further step.

        Raises:
            UsageError: the drive is closed.
        """
        self._check_open()
        self.link.stop(0 if at_once else 1)
        # A command of the chip's host stops the chip itself; at rest there is nothing to stop.
        of_chip = self.rewind is not None and self.rewind.command is not None
        self._to_stop = not of_chip and (self.feeder.busy or self.axis.moving or not self.chip.idle)
        self._stop_chip()
        self.talk.say(self.wall())

    def _stop_chip(self) -> None:
        """Stop the chip too where the board has nothing to stop: before a motion, between two, or while it is held."""
        self._to_stop = self._to_stop and self.state == "ok"
        answer = self.link.answer
        if self._to_stop and answer is not None and answer.state == BoardState.IDLE:
            self.watch.stopped_at_rest()

    def clear(self, *, homed: bool = False, homing: bool = False) -> None:
        """Continue after a halt: the board counts on from the position of the chip, and the chip is released.

        A driver that the board has switched off remains off, unless the user says one of these:

        Args:
            homed: the motor is where the position register says.
            homing: the motor is homed now; until that has ended the position is unknown (`power.known`).

        Raises:
            UsageError: the drive is closed or not halted, the chip is in motion, the port is still missing, or an
                emergency stop is active; homed and homing.
        """
        self._check_open()
        if homed and homing:
            raise UsageError("clear: homed and homing; give one of them")
        if self.state == "ok":
            raise UsageError("the drive is not halted: there is nothing to clear")
        if self.axis.moving:
            raise UsageError(f"{self.chip.name} is in motion; wait until it is at rest, then clear the drive")
        self.stopping.turn()
        if self.feeder.lost and self.state == "halted":
            self.take_over(signed(self.axis.travel - self.feeder.lost))
        self.talk.reopen()
        self.talk.set_up(known=homed, power=homed or homing)
        self.power.began(known=homed)
        self._begin()
        self.stopping.clear()

    def take_over(self, position: int, known: bool = True) -> None:
        """Set the position register of the chip to where the board has counted the motor to be.

        Args:
            position: the count of the board.
            known: False: the registers of the chip are lost anyway.
        """
        missing = signed(self.axis.travel - position)
        self.feeder.counted()
        self.watch.taken_over(missing, known)

    # ---------------------------------------------------------------------------------------------------- the outputs
    def _output(self, net: Net) -> None:
        """A pin of the chip that programs set has changed."""
        for each, number in self.nets():
            if each is net:
                self.feeder.change(1 << number, (net.level or 0) << number)

    def _put(self, output: LaidOutput) -> None:
        """Change outputs by a frame: at once while the motor stands and nothing is under way."""
        self.cable.send_at(output.tick16 >> 16, lambda: self.link.outputs(output.mask, output.value))

    def _half(self) -> bool:
        """Does the chip make half steps?"""
        return bool(getattr(getattr(self.chip, "state", None), "half", False))
