"""The outside of a run: its inputs, and the passage of time for a user.

    outside.record("drive", pin="x.abort", level=0)   an input to a pin, a chip or a part
    outside.wait(met, "an answer", "5 s")             a call to a host lets time pass until the call is complete
    with outside.nested(): ...                        consequences of a reported input, such as a script's lines
    with outside.queued(): ...                        calls to hosts only queue actions; the caller lets time pass

Every kernel has an `Outside`, so that pins and parts have access to it with or without a bench.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from .hook import Hook
from .timebase import Time

LetPass = Callable[[Callable[[], bool], str, Time], None]


class Outside:
    """The outside of a run: a user, a server or a replay.

    `on_input` is called with every external input: the verb and its arguments, as plain data that can be
    recorded and repeated.  `write` is called after all listeners of `on_input`, just before the input takes
    effect; so inputs that a listener makes, or time that it lets pass, are recorded before the input itself.
    `let_pass` lets time pass until a condition is met, or raises Timeout; if it is None, time cannot pass.
    """

    __slots__ = ("_inside", "_queueing", "let_pass", "on_input", "write")

    def __init__(self) -> None:
        self.on_input: Hook[[str, dict[str, Any]]] = Hook()
        self.write: Callable[[str, dict[str, Any]], None] | None = None  # a journal
        self.let_pass: LetPass | None = None
        self._inside = self._queueing = 0  # nesting depths of `nested` and `queued`

    @property
    def has_listeners(self) -> bool:
        """True if an input made now is reported to a listener or a journal."""
        return not self._inside and (self.write is not None or bool(self.on_input.listeners))

    def record(self, do: str, **what: Any) -> None:
        """Report an input, as a verb and plain data, unless the input follows from another one (`nested`)."""
        if self._inside:
            return
        if self.on_input.listeners:
            self.on_input(do, what)
        if self.write is not None:
            self.write(do, what)

    def wait(self, met: Callable[[], bool], what: str, timeout: Time) -> bool:
        """Let time pass until `met` returns true, and return True; return False immediately if time cannot pass.

        Time cannot pass inside `queued`, or if `let_pass` is None.

        Raises:
            Timeout: `met` does not return true within `timeout`.
        """
        if self.let_pass is None or self._queueing:
            return False
        self.let_pass(met, what, timeout)
        return True

    @contextmanager
    def nested(self) -> Iterator[None]:
        """Do not report inputs made in this block, because they follow from an input already reported.

        Inside the block, calls to hosts only queue actions.
        """
        self._inside += 1
        try:
            with self.queued():
                yield
        finally:
            self._inside -= 1

    @contextmanager
    def queued(self) -> Iterator[None]:
        """Let calls to hosts only queue actions: no time passes in this block."""
        self._queueing += 1
        try:
            yield
        finally:
            self._queueing -= 1

    def later(self, function: Callable[[], object]) -> Callable[[], object]:
        """Return a function that calls `function`, for use at a later instant, such as the end of a pulse.

        If `later` is called inside `nested`, `function` is also called inside `nested`.
        """
        if not self._inside:
            return function

        def nested() -> None:
            with self.nested():
                function()

        return nested
