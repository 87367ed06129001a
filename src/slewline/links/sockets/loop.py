"""The loop: one thread that waits for sockets, descriptors and timers, whichever comes first.

Paced virtual time needs sleeps of a fraction of a millisecond (see `system.py`), which asyncio loops cannot provide:
they wait in epoll, whose sleeps are whole milliseconds.
"""

from __future__ import annotations

import selectors
import signal
import weakref
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from heapq import heappop, heappush
from itertools import count
from socket import socket
from time import perf_counter

from .system import FineSelector, Ready, wakeup_pair

Call = Callable[[], object]
Calls = tuple[Call | None, Call | None]  # called when readable, when writable


class Loop:
    """A loop that serves file descriptors, wall-clock timers, and calls from signal handlers and other threads."""

    def __init__(self) -> None:
        self.selector = FineSelector()
        self.calls: dict[int, Calls] = {}  # by descriptor
        self.timers: list[tuple[float, int, Call]] = []
        self.order = count()
        self.asked: deque[Call] = deque()
        self.dirty: list[Call] = []  # functions that flush bytes written in this turn
        self.closed = self.watches_signals = False
        self.wakeup, self.button = wakeup_pair()
        self._forgotten = weakref.finalize(self, _close, self.wakeup, self.button)  # closed all the same
        self.watch(self.wakeup.fileno(), self._answer)

    # --------------------------------------------------------------------------------------------- file descriptors
    def watch(self, fd: int, readable: Call | None = None, writable: Call | None = None) -> None:
        """Call `readable` when a descriptor can be read, `writable` when it can be written; None: do not watch."""
        calls = readable, writable
        if self.calls.get(fd) == calls:
            return  # a selector keeps the old pair then, and `serve` compares pairs by identity
        events = (selectors.EVENT_READ if readable else 0) | (selectors.EVENT_WRITE if writable else 0)
        known = self.calls.pop(fd, None) is not None
        if events:
            self.calls[fd] = calls
            (self.selector.modify if known else self.selector.register)(fd, events, calls)
        elif known:
            self.selector.unregister(fd)

    # -------------------------------------------------------------------------------------------- calls and timers
    def after(self, seconds: float, call: Call) -> None:
        """Call a function after a delay by the wall clock."""
        heappush(self.timers, (perf_counter() + seconds, next(self.order), call))

    def ask(self, call: Call) -> None:
        """Call a function in the loop's thread; this method may be used in any thread and in signal handlers."""
        self.asked.append(call)
        with suppress(OSError):  # it is full, or already closed
            if not self.closed:
                self.button.send(b"\0")

    def watch_signals(self) -> None:
        """Let a signal end a `sleep`, even on Windows.  Call this method, and later `close`, in the main thread."""
        signal.set_wakeup_fd(self.button.fileno(), warn_on_full_buffer=False)
        self.watches_signals = True

    def _answer(self) -> None:
        self.wakeup.recv(4096)
        for _ in range(len(self.asked)):  # calls requested by these have their turn after ready descriptors
            self.asked.popleft()()

    # ------------------------------------------------------------------------------------------------------ running
    def sleep(self, pause: float | None) -> list[Ready]:
        """Send queued bytes; wait up to `pause` s (None: no limit) or for a timer; return ready descriptors."""
        dirty, self.dirty = self.dirty, []
        for flush in dirty:
            flush()
        if self.timers:
            left = max(self.timers[0][0] - perf_counter(), 0)
            pause = left if pause is None else min(pause, left)
        return self.selector.select(pause)

    def serve(self, ready: list[Ready]) -> None:
        """Call the functions for ready descriptors and due timers."""
        calls = self.calls
        for key, mask in ready:
            readable, writable = key.data
            if writable is not None and mask & selectors.EVENT_WRITE and calls.get(key.fd) is key.data:
                writable()
            if readable is not None and mask & selectors.EVENT_READ and calls.get(key.fd) is key.data:
                readable()  # otherwise it was removed in this turn
        now_s = perf_counter()  # a timer set again meanwhile has its turn after the descriptors
        while self.timers and self.timers[0][0] <= now_s:
            heappop(self.timers)[2]()

    def close(self) -> None:
        """Release the selector and the wake-up sockets; later calls to `ask` have no effect."""
        self.closed = True
        if self.watches_signals:
            signal.set_wakeup_fd(-1)
            self.watches_signals = False
        self.selector.close()
        self._forgotten()


def _close(*ends: socket) -> None:
    for end in ends:
        end.close()
