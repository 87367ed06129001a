"""The event kernel: integer time, delta rounds, tasks.

Theory.  An instant T runs in rounds.  Round 1 runs every task that a timer woke; everything still reads as it was
before T.  Then the edges that were promised for T and the changes made in round 1 commit together, everybody is
told, and reactions run in rounds 2 and on, until the instant is quiet.  So a look (a timer wake at which firmware
samples) sees the level from before the instant, and the order of tasks inside a round cannot matter.

Rules of this file: no wall clock; nothing global; a heap entry is (time, order, who, token) and is stale, hence
dropped, when `who.token` has moved on.  Nothing is ever searched for in the heap.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from heapq import heappop, heappush
from itertools import count
from random import Random
from typing import Any, Protocol

from ..errors import Endless, SlewlineError
from .timebase import readable

ROUNDS_LIMIT = 1_000_000


class Due(Protocol):
    """What may stand in the heap: a task, a net with a promised edge, a call."""

    token: int
    is_net: bool


class Task:
    """A coroutine on the kernel.  `value` is what its next resumption returns: the net that woke it, or None for time."""

    __slots__ = ("alive", "coroutine", "kernel", "name", "token", "value")
    is_net = False

    def __init__(self, kernel: Kernel, coroutine: Coroutine[Any, Any, None], name: str) -> None:
        self.kernel, self.coroutine, self.name = kernel, coroutine, name
        self.token, self.alive, self.value = 0, True, None

    def resume(self) -> None:
        if not self.alive:
            return
        self.kernel.task = self
        value, self.value = self.value, None
        try:
            self.coroutine.send(value)
        except StopIteration:
            self.alive = False

    def kill(self) -> None:
        """End the task where it waits; its `finally` blocks run."""
        self.token += 1
        self.alive = False
        self.coroutine.close()

    def __repr__(self) -> str:
        return f"<Task {self.name}>"


class Call:
    """A plain function to be called at an instant, in round 1."""

    __slots__ = ("function", "token")
    is_net = False

    def __init__(self, function: Callable[[], object]) -> None:
        self.function, self.token = function, 0

    def resume(self) -> None:
        self.function()

    def __repr__(self) -> str:
        return f"<Call {self.function!r}>"


class Kernel:
    """Virtual time.  `now` is the instant being run, `seen` the last instant whose changes are visible."""

    def __init__(self, shuffle: Random | None = None) -> None:
        self.now = 0
        self.seen = 0
        self.heap: list[tuple[int, int, Any, int]] = []
        self.order = count()
        self.pending: list[Any] = []  # drivers that change at the end of the round
        self.woken: list[Any] = []  # tasks for the next round
        self.task: Task | None = None
        self.shuffle = shuffle
        self.running = False

    # ------------------------------------------------------------------------------------------------- scheduling
    def spawn(self, coroutine: Coroutine[Any, Any, None], name: str) -> Task:
        """Start a task; its first lines run in the next round."""
        task = Task(self, coroutine, name)
        self.woken.append(task)
        return task

    def call_at(self, ps: int, function: Callable[[], object]) -> Call:
        """Call a function in round 1 of an instant; an instant that is past or present is served in the next round."""
        call = Call(function)
        if ps <= self.now:
            self.woken.append(call)
        else:
            heappush(self.heap, (ps, next(self.order), call, 0))
        return call

    def next_time(self) -> int | None:
        """When the next thing happens if nobody interferes; None: never."""
        heap = self.heap
        while heap and heap[0][2].token != heap[0][3]:
            heappop(heap)
        return heap[0][0] if heap else None

    # ---------------------------------------------------------------------------------------------------- running
    def settle(self) -> None:
        """Run rounds of the present instant until it is quiet: what was driven from outside takes effect."""
        if not self.running and (self.woken or self.pending):
            self._rounds(self.now, self._take_woken(), [])

    def run(self, until: int) -> None:
        """Run everything up to and including an instant, and stand there."""
        self.settle()
        heap = self.heap
        while heap and heap[0][0] <= until:
            self.instant()
        if until > self.now:
            self.now = self.seen = until

    def instant(self) -> None:
        """Run the next instant in the heap, whole."""
        heap = self.heap
        time = heap[0][0]
        first: list[Any] = []
        edges: list[Any] = []
        while heap and heap[0][0] == time:
            _, _, who, token = heappop(heap)
            if who.token == token:
                who.token += 1
                (edges if who.is_net else first).append(who)
        if not first and not edges:
            return
        self.now = time
        self.seen = time - 1
        self._rounds(time, first, edges)

    def _take_woken(self) -> list[Any]:
        woken = self.woken
        self.woken = []
        return woken

    def _rounds(self, time: int, ready: list[Any], edges: list[Any]) -> None:
        self.running = True
        try:
            for number in range(ROUNDS_LIMIT):
                if self.shuffle is not None:
                    self.shuffle.shuffle(ready)
                for task in ready:
                    task.resume()
                self.seen = time
                if self.pending or edges:
                    self._commit(time, edges)
                    edges = []
                if not self.woken and not self.pending:
                    return
                ready = self._take_woken()
            names = ", ".join(sorted({repr(task) for task in ready}))
            raise Endless(f"{number + 1} rounds at {readable(time)}: these answer each other without letting time pass: {names}")
        finally:
            self.running = False
            self.seen = time
            self.task = None

    def _commit(self, time: int, edges: list[Any]) -> None:
        """All changes of the round take effect together; then everybody is told."""
        pending = self.pending
        self.pending = []
        nets = edges
        for driver in pending:
            driver.pending = False
            driver.take()
            net = driver.net
            if not net.dirty:
                net.dirty = True
                nets.append(net)
        changed = []
        for net in nets:
            net.dirty = False
            if net.update(time):
                changed.append(net)
        for net in changed:
            net.tell()

    def current(self) -> Task:
        """The task that is running; waiting is only possible inside one."""
        if self.task is None:
            raise SlewlineError("only a task of the kernel can wait")
        return self.task
