"""The loop: one thread that waits for file descriptors and for the next thing to do, whichever comes first.

Whoever paces virtual time needs to sleep for a part of a millisecond, and epoll rounds its sleep up to whole ones.  So
the loop waits in `select` for the one descriptor that epoll itself has, which is good to some 0.1 ms, whatever number
of descriptors lies behind it.
"""

from __future__ import annotations

import os
import select
import selectors
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from heapq import heappop, heappush
from itertools import count
from time import perf_counter

Call = Callable[[], object]
Calls = tuple[Call | None, Call | None]  # when readable, when writable
Ready = tuple[selectors.SelectorKey, int]


class FineSelector(selectors.DefaultSelector):
    """The selector of the system, with sleeps of any length."""

    def select(self, timeout: float | None = None) -> list[Ready]:
        """Return what is ready, after at most so many seconds."""
        if timeout:
            select.select([self.fileno()], [], [], timeout)
            timeout = 0
        return super().select(timeout)


class Loop:
    """File descriptors, timers of the wall clock, and calls from signal handlers and other threads."""

    def __init__(self) -> None:
        self.selector = FineSelector()
        self.calls: dict[int, Calls] = {}  # by descriptor
        self.timers: list[tuple[float, int, Call]] = []
        self.order = count()
        self.asked: deque[Call] = deque()
        self.dirty: list[Call] = []  # what flushes bytes that were written in this turn
        self.closed = False
        self.bell, self.button = os.pipe()
        for end in (self.bell, self.button):
            os.set_blocking(end, False)
        self.watch(self.bell, self._answer)

    # --------------------------------------------------------------------------------------------- file descriptors
    def watch(self, fd: int, readable: Call | None = None, writable: Call | None = None) -> None:
        """Call these when a descriptor can be read or written; neither: forget it."""
        calls = readable, writable
        if self.calls.get(fd) == calls:
            return  # a selector keeps the old pair then, and `serve` knows a pair by its identity
        events = (selectors.EVENT_READ if readable else 0) | (selectors.EVENT_WRITE if writable else 0)
        known = self.calls.pop(fd, None) is not None
        if events:
            self.calls[fd] = calls
            (self.selector.modify if known else self.selector.register)(fd, events, calls)
        elif known:
            self.selector.unregister(fd)

    # -------------------------------------------------------------------------------------------- calls and timers
    def after(self, seconds: float, call: Call) -> None:
        """Call a function when so much time of the wall clock has passed."""
        heappush(self.timers, (perf_counter() + seconds, next(self.order), call))

    def ask(self, call: Call) -> None:
        """Call a function in the thread of the loop; may be used in any thread, and in a signal handler."""
        self.asked.append(call)
        with suppress(BlockingIOError):  # it has been rung often enough
            if not self.closed:
                os.write(self.button, b"\0")

    def _answer(self) -> None:
        os.read(self.bell, 4096)
        while self.asked:
            self.asked.popleft()()

    # ------------------------------------------------------------------------------------------------------ running
    def sleep(self, pause: float | None) -> list[Ready]:
        """Send what was written, then wait for at most so many seconds (None: for ever); returns what has come up."""
        dirty, self.dirty = self.dirty, []
        for flush in dirty:
            flush()
        if self.timers:
            left = max(self.timers[0][0] - perf_counter(), 0)
            pause = left if pause is None else min(pause, left)
        return self.selector.select(pause)

    def serve(self, ready: list[Ready]) -> None:
        """Do what has come up, timers included."""
        calls = self.calls
        for key, mask in ready:
            readable, writable = key.data
            if writable is not None and mask & selectors.EVENT_WRITE and calls.get(key.fd) is key.data:
                writable()
            if readable is not None and mask & selectors.EVENT_READ and calls.get(key.fd) is key.data:
                readable()  # else it was forgotten in this very turn
        while self.timers and self.timers[0][0] <= perf_counter():
            heappop(self.timers)[2]()

    def close(self) -> None:
        """Let go of everything; what is asked from now on is not done."""
        self.closed = True
        self.selector.close()
        os.close(self.bell)
        os.close(self.button)
