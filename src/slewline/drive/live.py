"""A drive by itself: the model keeps up with its board, whose crystal is the clock."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ..bench.runner import FunctionCondition, Wait
from ..core.time.timebase import PS_PER_S, Time, picoseconds, readable
from ..core.wires.pin import Condition
from ..errors import Timeout

if TYPE_CHECKING:
    from .driven import Driven
    from .talk import Talk

LEAST_WAIT_S = 0.0005


class Live:
    """Lets the bench of a drive keep up with the board."""

    def __init__(self, drive: Driven, talk: Talk) -> None:
        self.drive, self.talk = drive, talk

    def keep_up(self, until: int, wait: Wait | None) -> bool:
        """Let the model keep up with the board up to an instant (ps); return whether a wait was met before."""
        drive = self.drive  # its bench may be exchanged in a turn
        drive.catch_up()
        drive.turn()
        while True:
            goal = min(max(drive.ticks.ps(drive.clock.ticks(drive.wall())), drive.kernel.now), until)
            met = self._pass(goal, wait)
            drive.turn()
            met = met or (wait is not None and wait.met())  # by an answer of the board
            if met or drive.kernel.now >= until:
                return met
            self.talk.wait(min(drive.due(), max((until - drive.kernel.now) / PS_PER_S, LEAST_WAIT_S)))

    def until(self, condition: Condition | Callable[[], bool], timeout: Time) -> None:
        """Let the model keep up with the board until a condition is met.

        Raises:
            Timeout: it is not met in time.
        """
        drive = self.drive
        if not isinstance(condition, Condition):
            condition = FunctionCondition(condition, getattr(condition, "__name__", "the condition"))
        condition.begin()
        limit = drive.kernel.now + picoseconds(timeout)
        wait = Wait(condition.met, limit, when=condition.foreseen, nets=condition.nets)
        wait.begin()
        try:
            met = self.keep_up(limit, wait)
        finally:
            wait.end()
            drive.bench.run(0)
        if not met:
            raise Timeout(f"waited {readable(picoseconds(timeout))} for {condition}; the drive is {drive.state}")

    def _pass(self, goal: int, wait: Wait | None) -> bool:
        """Run the bench up to an instant (ps), or until a wait is met; return whether it is."""
        kernel = self.drive.kernel
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
