"""asyncio in virtual time: a loop that uses its benches' clock, which stops while any task has work to do.

    async def main():
        bench = slewline.Bench()
        x = bench.add("cy525")
        ...
        await bench.until(x.reaches(40))
        await asyncio.sleep(0.5)                                # in virtual time, like all timeouts

    slewline.testing.aio.run(main())
    asyncio.Runner(loop_factory=VirtualLoop)                    the same, by hand
    anyio.run(main, backend_options={"loop_factory": VirtualLoop})

When all tasks wait, time passes on every bench of the loop, up to the next event that concerns one of
the tasks: a timer, a character, a condition.  So the run depends on the program alone.  A bench joins
the loop when one of its methods is first awaited, and the bench of a port's module when the port is
opened; from then on, the bench's time passes with that of the loop.

While work is done in threads (`asyncio.to_thread`), time stops.  Real sockets and pipes are served in
every iteration of the loop, which waits for them only when nothing is due in virtual time.
"""

from __future__ import annotations

import asyncio
import selectors
from collections.abc import Callable, Coroutine
from concurrent.futures import Executor
from contextvars import Context
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, TypeVarTuple

from ..bench.runner import Wait
from ..core.time.timebase import PS_PER_S, readable
from ..errors import Timeout, UsageError
from ..links.lines.pace import Pace
from ..links.lines.served_line import ANSWER_TIMEOUT_PS

if TYPE_CHECKING:
    from ..bench import Bench
    from ..bench.runner import Runner
    from ..core.time.kernel import Kernel
    from ..core.wires.pin import Condition
    from .rig import Rig

Result = TypeVar("Result")
Given = TypeVarTuple("Given")
GRACE_S = 1.0  # of the wall clock: a loop in which nothing is due, and that no thread calls, is stuck


def run(main: Coroutine[Any, Any, Result]) -> Result:
    """Run a coroutine in its own loop in virtual time, as `asyncio.run` does in real time.

    Raises:
        UsageError: the argument is a function rather than the coroutine that a call of the function returns.
        Timeout: deadlock: every task waits, and no event is pending.
    """
    if callable(main):
        name = getattr(main, "__name__", "main")
        raise UsageError(f"aio.run({name}): this is a function; call it: aio.run({name}())")
    with asyncio.Runner(loop_factory=VirtualLoop) as runner:
        return runner.run(main)


class TimeDriver(Protocol):
    """An object that lets time pass for a port in an asyncio loop."""

    def join(self, user: object) -> None:
        """Add a user of the port; time passes as long as there is at least one user."""

    def leave(self, user: object) -> None:
        """Remove a user of the port; when there are no more users, time stops."""

    def wait(self, wait: Wait) -> None:
        """Add a wait, which ends when its condition is met or its time is up."""

    def answer(self, quiet: Callable[[], bool]) -> None:
        """Let time pass until the written bytes have been answered, that is, until `quiet` returns True."""


def time_of(loop: asyncio.AbstractEventLoop, rig: Rig) -> TimeDriver:
    """Return the object that lets time pass for a rig in an asyncio loop."""
    return loop.joined(rig.bench) if isinstance(loop, VirtualLoop) else PacedRig(loop, rig)


# ----------------------------------------------------------------------------------------------- a loop in virtual time
class JoinedBench(Pace):
    """A bench that has joined a loop; `ahead_ps` is the time of the loop minus the time of the bench."""

    def __init__(self, bench: Bench | Runner, loop: VirtualLoop) -> None:
        super().__init__(bench)
        self.loop = loop
        self.users: list[object] = []
        self.meet()

    def meet(self) -> None:
        """Set `ahead_ps` so that the current instants of the bench and of the loop are the same."""
        self.ahead_ps = self.loop.now_ps - self.kernel.now

    def join(self, user: object) -> None:
        """Add a user: while there is at least one, the bench's time passes with that of the loop."""
        if not self.users:
            self.meet()
        self.users.append(user)

    def leave(self, user: object) -> None:
        """Remove a user; when there are no more users, the bench's time stops."""
        self.users.remove(user)
        if not self.users:
            del self.loop.paces[self.kernel]

    def answer(self, quiet: Callable[[], bool]) -> None:
        """Do nothing: time passes anyway as soon as all tasks wait."""

    @property
    def now_ps(self) -> int:
        """The current instant of the bench on the loop's clock (ps)."""
        return self.kernel.now + self.ahead_ps

    def due(self) -> int | None:
        """Notify tasks whose wait is over; return the next possible event's instant (ps of the loop), or None."""
        self.kernel.settle()
        self._answer()
        times = [self.kernel.next_time()]
        for wait in self.waits:
            times += [wait.limit_ps, wait.when() if wait.when is not None else None]
        ahead = [max(time, self.kernel.now) for time in times if time is not None]
        return min(ahead) + self.ahead_ps if ahead else None

    def goal(self) -> int:
        return self.kernel.now if self._stopped() else max(self.loop.target_ps - self.ahead_ps, self.kernel.now)

    def _stopped(self) -> bool:
        return self.loop.stirred and self.loop.alone  # several benches each run whole instants, the same for all

    def _enough(self) -> bool:
        return self._stopped() or super()._enough()


class IdleSelector(selectors.DefaultSelector):
    """A selector that lets virtual time pass where an ordinary one would sleep, while every task waits."""

    loop: VirtualLoop

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        """Return the ready files; if none is ready, let virtual time pass, for at most `timeout` virtual seconds."""
        ready = super().select(0)
        if ready or (timeout is not None and timeout <= 0):
            return ready
        if self.loop.elsewhere:
            return super().select(None)
        if self.loop.pass_time(timeout):
            return []
        if len(self.get_map()) > 1:  # besides the loop's own, there are sockets or pipes
            return super().select(None)
        ready = super().select(GRACE_S)
        if not ready:
            raise Timeout(self.loop.stuck())
        return ready


class VirtualLoop(asyncio.SelectorEventLoop):
    """An asyncio loop in virtual time."""

    def __init__(self) -> None:
        self.now_ps = self.target_ps = 0
        self.stirred = self.alone = False  # an event is due at this instant; there is one bench
        self.elsewhere = 0  # jobs in threads
        self.paces: dict[Kernel, JoinedBench] = {}
        selector = IdleSelector()
        selector.loop = self
        super().__init__(selector)

    def time(self) -> float:
        """Return the virtual time since the loop was created, in seconds."""
        return self.now_ps / PS_PER_S

    def joined(self, bench: Bench | Runner) -> JoinedBench:
        """Return the JoinedBench of a bench; at the first call, the bench joins this loop."""
        if bench.kernel not in self.paces:
            bench.run(0)
            self.paces[bench.kernel] = JoinedBench(bench, self)
        return self.paces[bench.kernel]

    async def passed(self, bench: Runner, condition: Condition, ps: int) -> bool:
        """Wait until a condition is met, for at most `ps` of the bench's time; return whether it was met."""
        pace = self.joined(bench)
        if not any(user is bench for user in pace.users):
            pace.join(bench)
        over: asyncio.Future[bool] = self.create_future()

        def done(found: bool) -> None:
            if not over.done():
                over.set_result(found)

        wait = Wait(condition.met, bench.kernel.now + ps, done, condition.foreseen, condition.nets)
        pace.wait(wait)
        try:
            return await over
        finally:
            pace.forget(wait)
            bench.outside.record("run", to=bench.kernel.now)

    # ---------------------------------------------------------------------------------------------------------- time
    def pass_time(self, timeout: float | None) -> bool:
        """Let time pass until a task has work to do, for at most `timeout` seconds; return False if nothing is due."""
        paces = [pace for pace in self.paces.values() if pace.users]
        self.alone, self.stirred = len(paces) == 1, False
        goal = None if timeout is None else self.now_ps + max(round(timeout * PS_PER_S), 1)
        floor = max([self.now_ps, *(pace.now_ps for pace in paces)])  # a call that was not awaited has let time pass
        while True:
            due = [time for pace in paces if (time := pace.due()) is not None]
            if self.stirred:  # by changes at this instant
                return True
            if goal is None and not due:
                return False
            known = due if goal is None else [goal] if self.alone else [goal, *due]
            self.target_ps = max(min(known), floor)
            done = all([pace.pass_time() for pace in paces])
            self.now_ps = paces[0].now_ps if self.alone else self.target_ps if done else self.now_ps
            if self.stirred or not done or (goal is not None and self.now_ps >= goal):
                return True

    def stuck(self) -> str:
        """Return the message about a deadlock, with the reason for which each chip, part and host is waiting."""
        waiting = [
            f"\n  {owner.waiting}" for pace in self.paces.values() if pace.users for owner in pace.bench.chips.values()
        ]
        return f"deadlock at {readable(self.now_ps)}: every task waits, and no event is pending{''.join(waiting)}"

    # --------------------------------------------------------------------------------------- events that wake a task
    def call_soon(
        self, callback: Callable[[*Given], object], *args: *Given, context: Context | None = None
    ) -> asyncio.Handle:
        """Call a function in the next iteration of the loop; time stops until then."""
        self.stirred = True
        return super().call_soon(callback, *args, context=context)

    def call_at(
        self, when: float, callback: Callable[[*Given], object], *args: *Given, context: Context | None = None
    ) -> asyncio.TimerHandle:
        """Call a function at an instant of virtual time (s)."""
        self.stirred = True
        return super().call_at(when, callback, *args, context=context)

    def run_in_executor(
        self, executor: Executor | None, func: Callable[[*Given], Result], *args: *Given
    ) -> asyncio.Future[Result]:
        """Call a function in a thread; time stops until it has returned."""
        future = super().run_in_executor(executor, func, *args)
        self.elsewhere += 1
        future.add_done_callback(self._back)
        return future

    def _back(self, _future: asyncio.Future[Any]) -> None:
        self.elsewhere -= 1

    async def shutdown_default_executor(self, *arguments: Any) -> None:
        """Wait for the threads of the loop to end; time stops until then."""
        self.elsewhere += 1
        try:
            await super().shutdown_default_executor(*arguments)
        finally:
            self.elsewhere -= 1


# ------------------------------------------------------------------------------------------------ a loop in real time
class PacedRig:
    """A rig in an asyncio loop in real time: virtual time passes in the iterations of the loop.

    Without a rate, virtual time passes until the written bytes are answered; with a rate, it keeps up with
    the wall clock.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, rig: Rig) -> None:
        self.loop, self.rig = loop, rig
        self.handle: asyncio.Handle | None = None
        self.used = 0

    def join(self, user: object) -> None:
        """Add a user of the port; time passes as long as there is at least one user."""
        self.used += 1
        self._soon()

    def leave(self, user: object) -> None:
        """Remove a user of the port; when there are no more users, time stops."""
        self.used -= 1
        if not self.used and self.handle is not None:
            self.handle.cancel()
            self.handle = None

    def wait(self, wait: Wait) -> None:
        """Add a wait, which ends when its condition is met or its time is up."""
        self.rig.pace.wait(wait)
        self._soon()

    def answer(self, quiet: Callable[[], bool]) -> None:
        """Let time pass until `quiet` returns True, for at most ANSWER_TIMEOUT_PS."""
        self.wait(Wait(quiet, self.rig.bench.now_ps + ANSWER_TIMEOUT_PS, lambda _quiet: None))

    def _soon(self) -> None:
        if self.handle is not None:
            self.handle.cancel()
        self.handle = self.loop.call_soon(self._turn)

    def _turn(self) -> None:
        self.handle = None
        if not self.used:
            return
        pace = self.rig.pace
        with self.rig.lock:
            done = pace.pass_time()
            pause = pace.pause() if done else 0.0
        if pause is not None and self.handle is None:
            self.handle = self.loop.call_later(pause, self._turn)
