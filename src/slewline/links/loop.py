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
from heapq import heappop, heappush
from itertools import count
from time import perf_counter
from typing import Any

Call = Callable[[], object]
Eager = Callable[[], float | None]


class FineSelector(selectors.DefaultSelector):
    """The selector of the system, with sleeps of any length."""

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        """What is ready, after at most so many seconds."""
        if timeout is None or timeout > 0:
            select.select([self.fileno()], [], [], timeout)
        return super().select(0)


class Loop:
    """File descriptors, timers of the wall clock, and calls from signal handlers and other threads."""

    def __init__(self) -> None:
        self.selector = FineSelector()
        self.timers: list[tuple[float, int, Call]] = []
        self.order = count()
        self.asked: deque[Call] = deque()
        self.dirty: list[Call] = []  # what flushes bytes that were written in this turn
        self.bell, self.button = os.pipe()
        for end in (self.bell, self.button):
            os.set_blocking(end, False)
        self.watch(self.bell, self._answer)

    # --------------------------------------------------------------------------------------------- file descriptors
    def watch(self, fd: int, readable: Call | None = None, writable: Call | None = None) -> None:
        """Call these when a descriptor can be read or written; neither: forget it."""
        events = (selectors.EVENT_READ if readable else 0) | (selectors.EVENT_WRITE if writable else 0)
        if fd in self.selector.get_map():
            if not events:
                self.selector.unregister(fd)
            else:
                self.selector.modify(fd, events, (readable, writable))
        elif events:
            self.selector.register(fd, events, (readable, writable))

    # -------------------------------------------------------------------------------------------- calls and timers
    def after(self, seconds: float, call: Call) -> None:
        """Call a function when so much time of the wall clock has passed."""
        heappush(self.timers, (perf_counter() + seconds, next(self.order), call))

    def ask(self, call: Call) -> None:
        """Call a function in the thread of the loop; may be used in any thread, and in a signal handler."""
        self.asked.append(call)
        try:
            os.write(self.button, b"\0")
        except BlockingIOError:
            pass  # it has been rung often enough

    def _answer(self) -> None:
        os.read(self.bell, 4096)
        while self.asked:
            self.asked.popleft()()

    # ------------------------------------------------------------------------------------------------------ running
    def turn(self, pause: float | None) -> None:
        """Send what was written, then wait for at most so many seconds (None: for ever) and do what has come up."""
        dirty, self.dirty = self.dirty, []
        for flush in dirty:
            flush()
        if self.timers:
            left = max(self.timers[0][0] - perf_counter(), 0)
            pause = left if pause is None else min(pause, left)
        for key, mask in self.selector.select(pause):
            readable, writable = key.data
            if mask & selectors.EVENT_WRITE and writable is not None:
                writable()
            if mask & selectors.EVENT_READ and readable is not None and self._watched(key):
                readable()
        while self.timers and self.timers[0][0] <= perf_counter():
            heappop(self.timers)[2]()

    def _watched(self, key: Any) -> bool:
        """Has nobody forgotten it in this very turn?"""
        return self.selector.get_map().get(key.fd) is key

    def close(self) -> None:
        """Let go of everything."""
        self.selector.close()
        os.close(self.bell)
        os.close(self.button)
