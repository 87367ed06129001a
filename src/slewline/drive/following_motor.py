"""Following: the motor makes the model's steps, from now on or from a past instant, until it is stopped.

While a bench is followed, its external inputs are observed, and so are the pins that set board outputs.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from .board.wire import BoardState

if TYPE_CHECKING:
    from ..bench import Bench
    from ..core.wires.net import Net
    from .drive_state import DrivePath, DriveState
    from .stopping.troubles import Troubles
    from .talk import Talk

SILENT = ("drive", "run", "power", "conclude")  # inputs that never move a chip
STEADY_TURNS = 20


class Alignment:
    """The alignment of the model's time with the board's time.

    `near`: True if the model led or lagged by at most a quarter of the horizon at the last turn.
    """

    def __init__(self, state: DriveState, path: DrivePath) -> None:
        self.state = state
        self.wall, self.clock, self.ticks, self.cable = path.wall, path.clock, path.ticks, path.cable
        self._steady = 0  # number of turns with the same offset
        self._looked_ps, self._off = -1, 0  # instant of the model at the last turn, and its offset, ticks
        self.near = True
        self.jumps = self.clock.jumps

    def align(self) -> None:
        """Align the current time of the model with that of the board."""
        self.ticks.align(self.state.kernel.now, self.clock.ticks(self.wall()))
        self._steady, self._looked_ps, self._off = 0, -1, 0
        self.near, self.jumps = True, self.clock.jumps

    def catch_up(self) -> None:
        """Align the model if it leads or lags by over a quarter of the horizon, and no motion is pending.

        Such an offset may be caused by other work of the program.
        """
        if self.state.phase == "ok" and not self.cable.in_progress:
            off = self._ahead(self.clock.ticks(self.wall()))
            if abs(off) > self.state.horizon // 4:
                self.align()

    def turn(self, tick: int) -> None:
        """Align the model if it is frozen, or if its offset from the board's time is large and constant.

        It is not aligned while a motion is pending.  The model of a server is frozen while the server is paused.
        The offset is constant after the server has lagged and has skipped the lost time.
        """
        before_ps, before = self._looked_ps, self._off
        self._looked_ps, self._off = self.state.kernel.now, self._ahead(tick)
        self.near = abs(self._off) <= self.state.horizon // 4
        if self.near or self.cable.in_progress:
            self._steady = 0
            return
        self._steady = self._steady + 1 if abs(self._off - before) < self.state.horizon // 50 else 0
        if self._steady >= STEADY_TURNS or before_ps == self._looked_ps:
            self.align()

    def _ahead(self, tick: int) -> int:
        """Return the lead of the model over the board, in ticks."""
        return (self.ticks.at(self.state.kernel.now) >> 16) - tick

    def present_ps(self) -> int:
        """Return the instant of the model that corresponds to the current time of the board (ps)."""
        return self.ticks.ps(self.clock.ticks(self.wall()))


class Following:
    """The piece that makes the motor follow the model.

    Args:
        self_start: whether a program that the chip starts by itself may move the motor.
        wake: called when an external input arrives while the drive is idle.
    """

    def __init__(
        self,
        state: DriveState,
        path: DrivePath,
        talk: Talk,
        watch: Troubles,
        alignment: Alignment,
        self_start: bool,
        wake: Callable[[], object],
    ) -> None:
        self.state, self.talk, self.watch, self.alignment = state, talk, watch, alignment
        self.path, self.link, self.ticks, self.feeder = path, path.link, path.ticks, path.feeder
        self._wake = wake
        bench = state.bench  # a chip may move once it has received an input
        self.spoken = self_start or bench.now_ps > 0 or any(not part.idle for part in bench.parts.values())
        self.to_stop = False  # a stop that the user has ordered, and the board has not made yet

    # ----------------------------------------------------------------------------------------------------- on a bench
    def attach(self) -> None:
        """Observe the bench."""
        for net, _ in self.state.nets():
            net.watch(self._output)
        self.state.kernel.outside.on_input.add(self._input)

    def detach(self) -> None:
        """Stop observing the bench."""
        for net, _ in self.state.nets():
            with suppress(ValueError, KeyError):
                net.unwatch(self._output)
        self.state.kernel.outside.on_input.remove(self._input)

    def move(self, bench: Bench) -> None:
        """Continue with another bench that is at the same instant as this one, with a chip of the same name."""
        self.detach()
        self.state.move(bench)
        self.path.move()
        self.attach()

    def _input(self, do: str, _what: object) -> None:
        if do not in SILENT:
            self.spoken = True
        if self.link.at_rest:
            self.link.at_rest = False
            self._wake()

    def _output(self, net: Net) -> None:
        """Pass to the feeder the changed level of a net that sets a board output."""
        for each, number in self.state.nets():
            if each is net:
                self.feeder.change(1 << number, (net.level or 0) << number)

    # -------------------------------------------------------------------------------------------------- begin and stop
    def begin(self) -> None:
        """Start following the model, whose current time is aligned with the board's current tick."""
        self.alignment.align()
        self.feeder.go_on()
        self._continue()

    def resume(self, position: int, since_ps: int) -> None:
        """Let a stopped board count on from a position, and output the model's steps after the instant `since_ps`.

        Steps of the model at or before this instant (ps) are not output.

        Raises:
            UsageError: the board does not follow, because an emergency stop is active.
        """
        state = self.state
        self.talk.set_up(position)
        present = self.path.clock.ticks(self.path.wall())
        following = state.axis.times(since_ps + 1, state.kernel.now)
        first = int(following[0]) if len(following) else state.kernel.now
        self.ticks.align(first, present - 3 * state.horizon // 4 if len(following) else present)
        self.feeder.resume(max(since_ps + 1, 0))
        self._continue()

    def _continue(self) -> None:
        self.state.begin()
        self.talk.begin()

    def stop(self, at_once: bool = False, *, of_chip: bool = True) -> None:
        """Stop the motor, by ramping down or, with `at_once`, immediately.

        Args:
            at_once: stop without a ramp.
            of_chip: True if the chip is already being stopped by a command; False: stop the chip as well, as
                soon as the board is idle (see `stop_chip`).
        """
        self.link.stop(0 if at_once else 1)
        chip, axis = self.state.chip, self.state.axis
        self.to_stop = not of_chip and (self.feeder.busy or axis.moving or not chip.idle)
        self.stop_chip()
        self.talk.send(self.path.wall())

    def stop_chip(self) -> None:
        """Stop the chip too if the user ordered a stop and the board is idle: between two motions, or in a hold."""
        self.to_stop = self.to_stop and self.state.phase == "ok"
        answer = self.link.answer
        if self.to_stop and answer is not None and answer.state == BoardState.IDLE:
            self.watch.stopped_at_rest()
