"""Parts that are called: a call queues an errand and lets virtual time pass until it is done.

Only the queueing is an input for the journal; when a journal is played again, time passes as it says itself.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from ..core.timebase import Time
from ..errors import SlewlineError, Timeout
from .worker import Worker


class Errand:
    """A piece of work that brings something back (`answer`), or fails."""

    __slots__ = ("answer", "done", "failure", "text")

    def __init__(self, text: str) -> None:
        self.text, self.done = text, False
        self.answer: Any = None
        self.failure: SlewlineError | None = None


class Caller(Worker):
    """A worker that is asked for something: `fetch` waits for what an errand brings back."""

    def errand(self, text: str, action: Callable[[], Awaitable[Any]]) -> Errand:
        """Queue a piece of work whose answer somebody may fetch."""
        errand = Errand(text)

        async def go() -> None:
            try:
                errand.answer = await action()
            except SlewlineError as error:
                errand.failure = error
            errand.done = True

        self.work(text, go)
        return errand

    def fetch(self, errand: Errand, timeout: Time) -> Any:
        """Let virtual time pass until an errand is done; returns its answer, or raises what went wrong.

        Where calls only queue (`Outside.queued`, or a part without a bench) it returns None at once.
        """
        try:
            if not self.kernel.outside.wait(lambda: errand.done, f"{self.name}: {errand.text}", timeout):
                return None
        except Timeout:
            self.give_up()
            raise
        if errand.failure is not None:
            raise errand.failure
        return errand.answer

    def give_up(self) -> None:
        """Take back the last errand, which took too long; what comes after it can go on."""
        self.input("give_up")
        self.queue.pop()
        if not self.queue and self.task is not None:
            self.task.kill()
            self.rest()
            self.kernel.settle()

    def rest(self) -> None:
        """Put the outputs to rest: the errand was cut short."""
