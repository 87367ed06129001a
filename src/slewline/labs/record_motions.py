"""The motions of a motor record, one after another; a new request replaces one that has not yet begun.

                 begin(motion)                     SPMG Go
       at rest ---------------> requested <------------------- paused
          ^                        |                            ^
          |     over, or STOP      v           SPMG Pause       |
          +------------------- in progress ---------------------+

A separate thread communicates with the module, one command after another.  A new motion may end the one
in progress, if the part can stop; a put that requests a motion completes when all motions are over.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeVar

from ..errors import SlewlineError
from .field_table import PAUSE

if TYPE_CHECKING:
    from .module_motor import ModuleMotor
    from .record_state import RecordState

Result = TypeVar("Result")


class RecordMotion(NamedTuple):
    """A requested motion: to a dial position, or a homing run if `homing` is 1 (towards positive steps) or -1.

    `button` is the field that is 1 during the motion: the homing field or the jog field; "" for neither.
    """

    dial: float = 0.0
    homing: int = 0
    button: str = ""


class Owner(Protocol):
    """The members of a record that its motions use."""

    motor: ModuleMotor
    state: RecordState

    async def publish(self) -> None:
        """Post the fields that have changed."""

    async def failed(self, error: Exception) -> None:
        """Report a failure."""


class RecordMotions:
    """The motions of a record, which owns the motor and the state.

    Attributes:
        wanted: the requested motion that has not yet begun; None if there is none.
        current: the motion in progress; None if there is none.
        task: the task that performs the motions; None while no motion is requested or in progress.
    """

    def __init__(self, owner: Owner, name: str) -> None:
        self.owner = owner
        self.thread = ThreadPoolExecutor(1, thread_name_prefix=name)
        self.wanted: RecordMotion | None = None
        self.current: RecordMotion | None = None
        self.task: asyncio.Task[SlewlineError | None] | None = None
        self.changed = asyncio.Event()  # the request, or its permission to begin
        self.halting = ""  # "stop" or "pause": the motion in progress is to end

    async def within(self, call: Callable[[], Result]) -> Result:
        """Call a function that uses the module, in the thread that communicates with the module; return its result."""
        return await asyncio.get_running_loop().run_in_executor(self.thread, call)

    @property
    def idle(self) -> bool:
        """True if no motion is requested or in progress."""
        return self.task is None

    # -------------------------------------------------------------------------------------------------------- for puts
    async def begin(self, motion: RecordMotion) -> None:
        """Request a motion; return when all motions are over.

        Raises:
            SlewlineError: a motion has failed.
        """
        self.wanted = motion
        self.changed.set()
        if self.task is None:
            self.task = asyncio.create_task(self._work())
        await self.over()

    async def stop(self, pause: bool = False) -> None:
        """Stop the motor; discard the requested motion or, for a pause, keep it; return when the motor is at rest.

        Raises:
            UsageError: the part executes no command while it moves.
            SlewlineError: the motion has failed.
        """
        state = self.owner.state
        if state.moving:
            if self.owner.motor.stopping is None:
                self.owner.motor.stop()  # the message states why it cannot
            self.halting = "pause" if pause else "stop"
        if not pause:
            self.wanted = None
            self.changed.set()
            return await self.over()
        while state.moving:
            self.changed.clear()
            await self.changed.wait()

    async def over(self) -> None:
        """Wait until no motion is requested or in progress.

        Raises:
            SlewlineError: a motion has failed.
        """
        if self.task is not None and (failure := await asyncio.shield(self.task)) is not None:
            raise failure

    # ------------------------------------------------------------------------------------------------------ one by one
    async def _work(self) -> SlewlineError | None:
        """Perform the requested motions, one after another; return the last failure, or None."""
        state, failure, arrived = self.owner.state, None, True
        state.done = False
        await self.owner.publish()
        try:
            while self.wanted is not None:
                if state.paused:
                    arrived = False
                    self.changed.clear()
                    await self.changed.wait()
                    continue
                motion, self.wanted, self.halting = self.wanted, None, ""
                self.current = motion
                try:
                    arrived = await self._motion(motion)
                    if self.halting == "pause" and self.wanted is None and not (arrived or motion.button):
                        self.wanted = motion
                except SlewlineError as error:
                    failure, arrived, self.wanted = error, False, None
                    await self.owner.failed(error)
                state.moving, state.button, self.current = False, "", None
                if state.once and self.wanted is None and not self.halting:
                    state.kept["SPMG"] = state.obeyed = PAUSE
                await self.owner.publish()
                self.changed.set()
        finally:  # after any end: the next put begins another task
            self.task = self.wanted = None
        if not arrived:
            state.settle()
        state.done = True
        await self.owner.publish()
        return failure

    async def _motion(self, motion: RecordMotion) -> bool:
        """Perform a motion; return whether the motor has completed a move to the record's target position.

        Return False after a jog, a homing run or a stop: the target position then has to be set to the present
        position.
        """
        state, motor, begun = self.owner.state, self.owner.motor, self.owner.state.dial_position
        state.missed, state.button = False, motion.button
        if motion.homing:
            home = partial(motor.home, motion.homing, state.ramps["home"])
            state.homed = False
            state.homed = await self._leg(motion, begun, motion.homing > 0, home)
            return False
        legs = [(motion.dial, state.ramps["jog"])] if motion.button else state.legs(motion.dial)
        for target, ramp in ((state.raw(dial), ramp) for dial, ramp in legs):
            move = partial(motor.move, target, ramp)
            if target != state.position and not await self._leg(motion, begun, target > state.position, move):
                return False
        if motion.button:
            state.violated = True  # not stopped before the limit
            return False
        if state.kept["DLY"] > 0:
            state.moving = False
            await self.owner.publish()
            await asyncio.sleep(state.kept["DLY"])
            await self.within(motor.look)
            state.position = motor.position
        state.missed = self.wanted is None and abs(motion.dial - state.dial_position) >= state.kept["RDBD"]
        return True

    async def _leg(self, motion: RecordMotion, begun: float, onward: bool, start: Callable[[], None]) -> bool:
        """Perform a move or a homing run, which `start` begins; return whether it ended without being stopped."""
        state, motor, stopped = self.owner.state, self.owner.motor, False
        state.moving, state.forward = True, onward
        await self.owner.publish()
        await self.within(start)
        while not await self.within(motor.at_rest):
            if not stopped and (self.halting or self._interrupted(motion, begun)):
                stopped = True
                await self.within(motor.stop)
        state.position = motor.position
        return not (stopped or self.halting)

    def _interrupted(self, motion: RecordMotion, begun: float) -> bool:
        """Return whether a new request must end the motion in progress.

        A request for a position further on in the same direction waits for the end of that motion, as in EPICS.
        """
        new = self.wanted
        if new is None or self.owner.motor.stopping is None:
            return False
        if new.button or motion.button:
            return True
        onward = (new.dial - motion.dial) * (motion.dial - begun) >= 0
        return bool(self.owner.state.kept["NTM"]) and not onward
