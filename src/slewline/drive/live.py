"""The piece that lets the model keep up with its board, whose crystal is the clock."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ..bench.runner import FunctionCondition, Wait
from ..core.time.timebase import PS_PER_S, Time, picoseconds, readable
from ..core.wires.pin import Condition
from ..errors import Timeout, UsageError
from .board.wire import BoardState
from .stopping.findings import signed
from .talk import RAMP_DOWN_S

if TYPE_CHECKING:
    from .drive_state import DrivePath, DriveState
    from .following_motor import Alignment, Following
    from .power import Power
    from .stopping.rewind import Rewind
    from .stopping.stop_ramps import StopRamps
    from .stopping.troubles import Troubles
    from .talk import Talk

LEAST_WAIT_S = 0.0005


class Live:
    """The work that a drive does at each of its turns (every 5 ms), to keep board and model together.

    `rewind` takes the model back to the instant at which an input of the board stopped the motor; if
    `rewind` is None, the chip is stopped at the current instant.
    """

    def __init__(
        self,
        state: DriveState,
        path: DrivePath,
        power: Power,
        stop_ramps: StopRamps,
        watch: Troubles,
        talk: Talk,
        alignment: Alignment,
        motor: Following,
    ) -> None:
        self.state, self.power, self.stop_ramps, self.watch, self.talk = state, power, stop_ramps, watch, talk
        self.alignment, self.motor = alignment, motor
        self.rewind: Rewind | None = None
        self.wall, self.clock, self.link = path.wall, path.clock, path.link
        self.feeder, self.cable = path.feeder, path.cable

    # ----------------------------------------------------------------------------------------------------------- turns
    def turn(self) -> None:
        """Receive from the board, feed it the model's steps, pass on delayed outputs that are due, and send.

        This is called every 5 ms, and when bytes have arrived, always between two runs of the bench.
        """
        state, rewind, watch, now = self.state, self.rewind, self.watch, self.wall()
        if rewind is not None:
            rewind.before_turn()
        self.talk.receive(now)
        if self.clock.jumps != self.alignment.jumps:
            watch.clock_jumped()
            self.alignment.align()
        self.motor.stop_chip()
        if self.power.turn():
            watch.switched_off()
        if not self.motor.spoken and state.phase == "ok" and (state.axis.moving or state.axis.travel):
            watch.moved_by_itself()
        if state.phase == "ok":
            tick = self._feed(now)
        else:
            if state.phase != "closed":
                self.feeder.turn(0)
                watch.stopping.turn()
            tick = self.clock.ticks(now)
        until = rewind.going_back_to if rewind is not None and state.undecided else None
        self.cable.turn(tick if until is None else min(tick, until))
        self.link.at_rest = rests = self._rests()
        self.link.bears_silence = rests and self.power.bears_silence
        self.talk.send(now)

    def _feed(self, now: int) -> int:
        """Feed the steps of the model to the board; return the board's tick at the wall-clock time `now` (ns)."""
        feeder, tick = self.feeder, self.clock.ticks(now)
        self.alignment.turn(tick)
        self.stop_ramps.turn(feeder)
        try:
            feeder.turn(tick)
        except UsageError as error:  # too fast for the board
            self.watch.too_fast(error)
        started = feeder.started
        if started is not None and self.link.starting and tick > started + self.state.horizon:
            self.watch.not_started()
        return tick

    def _rests(self) -> bool:
        """Return whether the drive has nothing to do until an external input arrives."""
        state = self.state
        if state.phase != "ok" or state.axis.moving or self.cable.in_progress or not self.alignment.near:
            return False
        answer = self.link.answer
        if answer is None or answer.state != BoardState.IDLE or not self.link.idle:
            return False
        chips, parts = state.bench.chips.values(), state.bench.parts.values()
        return all(chip.idle for chip in chips) and all(part.idle for part in parts)

    def due(self) -> float:
        """Return the number of seconds within which the next turn is due; `on_wake` may make it due earlier."""
        kernel = self.state.kernel
        due, following = self.talk.due(), kernel.next_time() if self.link.at_rest else None
        return due if following is None else min(due, max(following - kernel.now, 0) / PS_PER_S)

    # -------------------------------------------------------------------------------------------------------- at length
    def keep_up(self, until: int, wait: Wait | None) -> bool:
        """Run in step with the board until an instant (ps) or until `wait` is met; return whether `wait` was met."""
        state = self.state  # a turn may exchange its kernel
        self.alignment.catch_up()
        self.turn()
        while True:
            goal = min(max(self.alignment.present_ps(), state.kernel.now), until)
            met = self._pass(goal, wait)
            self.turn()
            met = met or (wait is not None and wait.met())  # the condition was met by an answer from the board
            if met or state.kernel.now >= until:
                return met
            self.talk.wait(min(self.due(), max((until - state.kernel.now) / PS_PER_S, LEAST_WAIT_S)))

    def until(self, condition: Condition | Callable[[], bool], timeout: Time) -> None:
        """Let the model keep up with the board until a condition is met.

        Raises:
            Timeout: the condition is not met in time.
        """
        state = self.state
        if not isinstance(condition, Condition):
            condition = FunctionCondition(condition, getattr(condition, "__name__", "the condition"))
        condition.begin()
        limit = state.kernel.now + picoseconds(timeout)
        wait = Wait(condition.met, limit, when=condition.foreseen, nets=condition.nets)
        wait.begin()
        try:
            met = self.keep_up(limit, wait)
        finally:
            wait.end()
            state.bench.run(0)
        if not met:
            raise Timeout(f"waited {readable(picoseconds(timeout))} for {condition}; the drive is {state.phase}")

    def _pass(self, goal: int, wait: Wait | None) -> bool:
        """Run the bench up to an instant (ps), or until `wait` is met; return whether it was met."""
        kernel = self.state.kernel
        if wait is None:
            kernel.run(goal)
            return False
        kernel.settle()
        while not wait.met():
            stop, following = goal, kernel.next_time()
            early = wait.when() if wait.when is not None else None
            if early is not None and (following is None or early <= following):
                stop = max(min(goal, early), kernel.now)
            if kernel.run_while(wait.met, stop):
                kernel.run(stop)
            if kernel.now >= goal:
                return wait.met()
        return True

    # ---------------------------------------------------------------------------------------------- begin, stop, end
    def open(self, *, homed: bool) -> None:
        """Set the board up, and let it follow the model; `homed`: the user confirms that the position is known."""
        found = self.talk.set_up(known=homed, power=True)
        self.power.began(known=homed)
        self.watch.goes_on(found)
        self.motor.attach()
        self.motor.begin()

    def clear(self, homed: bool, homing: bool) -> None:
        """Continue after a halt: release the chip, and let the board count from the chip's position.

        Raises:
            UsageError: the drive is not halted, the chip is in motion, or the board remains halted.
        """
        state, feeder, stopping = self.state, self.feeder, self.watch.stopping
        if state.phase == "ok":
            raise UsageError("the drive is not halted, so clearing it has no effect")
        if state.axis.moving:
            raise UsageError(f"{state.chip.name} is in motion; wait until it is at rest, then clear the drive")
        stopping.turn()
        if feeder.lost and state.phase == "halted":
            self.watch.findings.take_over(signed(state.axis.travel - feeder.lost))
        self.talk.reopen()
        self.talk.set_up(known=homed, power=homed or homing)
        self.power.began(known=homed)
        self.motor.begin()
        stopping.clear()

    def stop(self, at_once: bool = False) -> None:
        """Stop the motor, by ramping down or, with `at_once`, immediately."""
        # A command of the chip's host stops the chip itself; at rest there is nothing to stop.
        self.motor.stop(at_once, of_chip=self.rewind is not None and self.rewind.command is not None)

    def close(self) -> None:
        """Let the motor come to rest, and the board take all pending commands; then stop following the model."""
        state = self.state
        if state.phase == "closed":
            return
        try:
            self._come_to_rest()
            self.cable.flush()
            self.talk.finish()
        finally:
            self.motor.detach()
            state.bench.run(0)  # record the present instant in the journal
            state.close()

    def _come_to_rest(self) -> None:
        """Ramp down a moving motor, switch the driver off, and set the chip's register to the position of the motor."""
        state, wall = self.state, self.wall
        if state.phase == "ok" and self.feeder.busy and not (state.chip.idle and not state.axis.moving):
            self.stop()
        limit = wall() + 2 * state.horizon_ps // 1000 + int(RAMP_DOWN_S * 10**9)
        self._pass_while(self._motor_moves, limit)
        if not self._motor_moves():
            self.power.switch_off()
        self._pass_while(lambda: state.phase == "halted" and not self.watch.stopping.settled, limit)

    def _motor_moves(self) -> bool:
        """Return whether the board may still output steps."""
        state = self.state
        return self.cable.in_progress if state.phase == "ok" else state.phase == "halted" and not state.final

    def _pass_while(self, goes_on: Callable[[], bool], limit: int) -> None:
        """Let time run while `goes_on` returns True, up to a wall-clock time limit (ns)."""
        while goes_on() and self.wall() < limit:
            self.keep_up(self.state.kernel.now + picoseconds("5 ms"), None)
