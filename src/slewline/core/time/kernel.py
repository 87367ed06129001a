"""The event kernel: integer time, delta rounds, tasks.

Theory.  An instant T runs in rounds.  Round 1 runs every task that a timer woke; all levels are still the levels before
T.  Then the edges that were promised for T and the changes made in round 1 commit together, listeners are notified, and
reactions run in round 2 and later rounds, until the instant is quiet.  So a sampling point (a timer wake-up at which
firmware reads a level) sees the level from before the instant, and the order of tasks within a round cannot matter.

Rules of this file: no wall clock; no global state; a heap entry is (time, order, who, token) and is stale, hence
dropped, when `who.token` has been incremented.  The heap is never searched.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from functools import partial
from heapq import heappop, heappush
from itertools import count
from typing import Any, Protocol, TypeVarTuple

from ...errors import Endless, SlewlineError, UsageError
from .hook import Hook
from .outside import Outside
from .timebase import readable

ROUNDS_LIMIT = 100_000  # about a second, a hundred times what a chain of a thousand gates takes
Args = TypeVarTuple("Args")


class Shuffler(Protocol):
    """An external source of randomness, for example random.Random(1)."""

    def shuffle(self, ready: list[Any], /) -> None:
        """Shuffle a list in place."""


class Task:
    """A coroutine that the kernel runs.

    `value` is the result of its last wait: the net that woke the task, or None after a timed wait.  The coroutine is
    only created when it starts to run, because Python warns about coroutines that are never run.
    """

    __slots__ = ("alive", "begin", "coroutine", "is_net", "name", "send", "token", "value")

    def __init__(self, begin: Callable[[], Coroutine[Any, Any, None]], name: str) -> None:
        self.begin, self.name = begin, name
        self.coroutine: Coroutine[Any, Any, None] | None = None
        self.send: Callable[[Any], Any] = self._run
        self.token, self.alive, self.is_net = 0, True, False
        self.value: Any = None

    def _run(self, _value: None) -> None:
        """Run the coroutine up to its first wait."""
        self.coroutine = self.begin()
        self.send = self.coroutine.send
        self.send(None)

    def kill(self) -> None:
        """End the task at the point where it waits; its `finally` blocks run."""
        self.token += 1
        self.alive = False
        if self.coroutine is not None:
            self.coroutine.close()

    def __repr__(self) -> str:
        return f"<Task {self.name}>"


class Call:
    """A plain function to be called at an instant, in round 1."""

    __slots__ = ("alive", "function", "is_net", "token", "value")

    def __init__(self, function: Callable[[], object]) -> None:
        self.function, self.token, self.value, self.alive, self.is_net = function, 0, None, True, False

    def send(self, _value: None) -> None:
        """Call the function; the kernel uses this method in the same way as the `send` of a task."""
        self.function()

    def __repr__(self) -> str:
        return f"<Call {self.function!r}>"


class CommitHook(Hook[[int]]):
    """The hook that is called with each committed instant (`Kernel.on_commit`).

    A run checks for listeners only once, when it starts, so that instants without listeners cost nothing
    extra.  If the first listener is added during a run, an entry in the heap makes the run notice it.
    """

    __slots__ = ("kernel", "mark")

    def __init__(self, kernel: Kernel) -> None:
        super().__init__()
        self.kernel, self.mark = kernel, Call(lambda: None)
        self.mark.token = 1  # an entry with another token is stale: it is dropped without a call

    def add(self, listener: Callable[[int], object]) -> Callable[[int], object]:
        """Register a function to be called with each instant (ps) committed from now on; return it, for `remove`."""
        kernel = self.kernel
        if kernel.running and not self.listeners:
            heappush(kernel.heap, (kernel.now, next(kernel.order), self.mark, 0))
        return super().add(listener)


class Kernel:
    """The kernel of the simulation: virtual time, tasks and events.

    Attributes:
        now: the instant being run, ps.
        seen: the last instant whose changes are visible, ps.
        on_commit: hook, called with an instant (ps) when its rounds have been run, or when a run ends at it.  Earlier
            instants are final; at this instant, an external input may follow, and the hook is then called again.
    """

    def __init__(self, shuffle: Shuffler | None = None) -> None:
        self.now = 0
        self.seen = 0
        self.heap: list[tuple[int, int, Any, int]] = []
        self.order = count()
        self.pending: list[Any] = []  # drivers that change at the end of the round
        self.woken: list[Any] = []  # tasks for the next round
        self.late: list[Any] = []  # nets found during a commit to have an edge in its instant
        self.task: Task | Call | None = None  # the task that is running
        self.shuffle = shuffle
        self.running = False
        self.sole = False  # the running task is alone in its round, with nothing to commit
        self.over: Callable[[], bool] | None = None  # the end of the run in progress
        self.ended = False  # this end has been reached
        self.horizon = -1  # the latest instant to which a task may advance time (ps)
        self.outside = Outside()
        self.on_commit: Hook[[int]] = CommitHook(self)

    # ------------------------------------------------------------------------------------------------- scheduling
    def spawn(self, function: Callable[[*Args], Coroutine[Any, Any, None]], *args: *Args, name: str) -> Task:
        """Start a task that calls a coroutine function with `args` in the next round; `name` is for messages."""
        task = Task(partial(function, *args) if args else function, name)
        self.woken.append(task)
        return task

    def call_at(self, ps: int, function: Callable[[], object]) -> Call:
        """Call a function in round 1 of an instant (ps), or in the next round if the instant is not in the future."""
        call = Call(function)
        if ps <= self.now:
            self.woken.append(call)
        else:
            heappush(self.heap, (ps, next(self.order), call, 0))
        return call

    def wake_at(self, ps: int, task: Task) -> None:
        """Wake a waiting task at an instant (ps), unless something else has woken it by then."""
        heappush(self.heap, (ps, next(self.order), task, task.token))

    def wake(self, task: Task) -> None:
        """Wake a waiting task in the next round."""
        task.token += 1
        task.value = None
        self.woken.append(task)

    def next_time(self) -> int | None:
        """Return the instant (ps) of the next scheduled event; None if no event is scheduled."""
        heap = self.heap
        while heap and heap[0][2].token != heap[0][3]:
            heappop(heap)
        return heap[0][0] if heap else None

    def pass_to(self, ps: int) -> bool:
        """Advance to a later instant (ps) and return True; return False if a wait is needed, as other work is due."""
        heap = self.heap
        if not self.sole or self.pending or self.woken or ps > self.horizon or (heap and heap[0][0] <= ps):
            return False
        if self.over is not None:
            self.seen = self.now
            if self.over():
                self.ended = True
                return False
        self.now, self.seen = ps, ps - 1
        return True

    def pass_round(self) -> bool:
        """Advance to the next round if only the running task has work now; return whether this was the case."""
        if not self.sole or self.pending or self.woken:
            return False
        self.seen = self.now
        return True

    # ---------------------------------------------------------------------------------------------------- running
    def settle(self) -> None:
        """Run rounds of the current instant until it is quiet, so that externally driven levels take effect."""
        if not self.running and (self.woken or self.pending):
            self.running = True
            try:
                self._react(self.now, [])
                if self.on_commit.listeners:
                    self._committed()
            finally:
                self._rest()

    def run(self, until: int) -> None:
        """Run everything up to and including an instant (ps), which is the current instant afterwards."""
        self.run_while(None, until)
        if until > self.now:
            self.now = self.seen = until
            if self.on_commit.listeners:
                self.running = True
                try:
                    self._committed()
                finally:
                    self._rest()

    def run_while(self, over: Callable[[], bool] | None, until: int) -> bool:
        """Run complete instants up to `until` (ps) and return True; stop and return False once `over` returns true.

        Raises:
            UsageError: the call is made from within a run.
        """
        if self.running:
            raise UsageError(
                f"the time is {readable(self.now)}, and a run is in progress: a function that is called during a run "
                "must not run the bench or wait (run_until(), ask() ...); queue data with send(), or wait after the run"
            )
        if self.woken or self.pending:
            self.settle()
        heap = self.heap
        has_listeners = self.on_commit.listeners != ()
        self.running, self.ended, self.over = True, False, over
        self.horizon = -1 if has_listeners or self.shuffle is not None else until
        try:
            while not self.ended and (over is None or not over()):
                if not heap or (time := heap[0][0]) > until:
                    return True
                _, _, who, token = heappop(heap)
                if who.token != token:
                    if not has_listeners and self.on_commit.listeners:  # a listener has been added
                        has_listeners, self.horizon = True, -1
                        self._committed()
                    continue
                who.token = token + 1
                self.now = time
                self.seen = time - 1
                if self.shuffle is not None or who.is_net or (heap and heap[0][0] == time):
                    self._instant(time, who)
                    if has_listeners:
                        self._committed()
                    continue
                self.task, self.sole = who, True  # one timer, alone in its instant: the usual case
                try:
                    who.send(None)
                except StopIteration:
                    who.alive = False
                except Exception:
                    who.alive = False
                    raise
                if self.pending or self.woken:
                    self._react(self.now, [])
                else:
                    self.seen = self.now
                if has_listeners:
                    self._committed()
            return False
        finally:
            self._rest()

    def _instant(self, time: int, who: Any) -> None:
        """Run an instant with several timers or edges; round 1 runs tasks with expired timers, at the old levels."""
        heap = self.heap
        ready: list[Any] = []
        edges: list[Any] = []
        while True:
            if who.is_net:
                edges.append(who)
            else:
                who.value = None
                ready.append(who)
            while True:
                if not heap or heap[0][0] != time:
                    self.sole = False
                    try:
                        self._resume(ready)
                    finally:
                        self._react(time, edges)
                    return
                _, _, who, token = heappop(heap)
                if who.token == token:
                    who.token = token + 1
                    break

    def _committed(self) -> None:
        """Report the end of this instant; if a listener changes an input, run the effects, and report again."""
        for _ in range(ROUNDS_LIMIT):
            self.on_commit(self.now)
            if not (self.pending or self.woken):
                return
            self._react(self.now, [])
        raise Endless(
            f"a listener of on_commit changes an input at {readable(self.now)} each time it is called, so time cannot "
            "pass; let it do so once, or at a later time"
        )

    def _rest(self) -> None:
        self.running = self.sole = False
        self.horizon, self.over = -1, None
        self.seen = self.now
        self.task = None

    def _react(self, time: int, edges: list[Any]) -> None:
        """Commit changes, notify listeners and run woken tasks until the instant is quiet; a task may advance time."""
        rounds = 0
        while rounds < ROUNDS_LIMIT:
            rounds += 1
            if self.pending or edges:
                self._commit(time, edges)
                edges = []
            self.seen = time
            ready = self.woken
            if ready:
                self.woken = []
                self.sole = len(ready) == 1
                self._resume(ready)
                if self.now != time:  # a task has advanced time
                    time, rounds = self.now, 0
            elif not self.pending:
                return
        names = ", ".join(sorted({repr(task) for task in ready} | {repr(driver.net) for driver in self.pending}))
        raise Endless(
            f"{ROUNDS_LIMIT} rounds at {readable(time)}: these change each other in a loop without delay: {names}; "
            "add a delay to one of them"
        )

    def _resume(self, ready: list[Any]) -> None:
        """Resume tasks; an exception ends its task; the first exception is raised after all tasks have run."""
        if self.shuffle is not None:
            self.shuffle.shuffle(ready)
        failure: Exception | None = None
        for task in ready:
            if task.alive:
                self.task = task
                try:
                    task.send(task.value)
                except StopIteration:
                    task.alive = False
                except Exception as error:
                    task.alive = False
                    failure = failure or error
        if failure is not None:
            raise failure

    def _commit(self, time: int, nets: list[Any]) -> None:
        """Let all changes of the round take effect together; then notify observers and waiters of the changed nets."""
        pending, self.pending = self.pending, []
        self.sole = False  # calls in here belong to the next round
        changed = []
        for driver in pending:
            driver.pending = False
            net = driver.net
            level = driver.next
            if net.pending_drivers == 1 and net.plain is driver and ((kind := type(level)) is int or kind is tuple):
                net.pending_drivers = 0
                driver.level = level  # usual case: the only driver changes from level to level, without a recorder
                if level != net.value:
                    net.value = level
                    net.changes += 1
                    net.changed_at = time
                    if net.waiters or net.observers:
                        changed.append(net)
            else:
                driver.take()
                if net.pending_drivers:
                    net.pending_drivers = 0
                    nets += net.joined or (net,)
        self.seen = time
        if self.late:
            nets[:0], self.late = self.late, []
        for net in nets:
            if net.update(time) and (net.waiters or net.observers):
                changed.append(net)
        for net in changed:
            waiters = net.waiters
            if not net.observers and len(waiters) == 1:  # usual case: one task waits for this level
                task, token, wanted = waiters[0]
                if wanted is None or wanted == net.value or task.token != token:
                    waiters.clear()
                    if task.token == token:
                        task.token = token + 1
                        task.value = net
                        self.woken.append(task)
            else:
                net.notify()
        for net in nets:  # the next edge is only scheduled if the net is still watched
            if net.promise is not None:
                net.schedule(time)

    def current(self) -> Task:
        """Return the running task; raise SlewlineError if no task is running, because only a task can wait."""
        if not isinstance(self.task, Task):
            raise SlewlineError("only a task of the kernel can wait")
        return self.task
