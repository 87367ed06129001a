"""Parts that are called: a call queues an errand and lets virtual time pass until it is done.

Only the queueing is an input for the journal; when a journal is played again, time passes as it says itself.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any, Generic, TypeVar

from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...core.time.timebase import Time
from ...errors import SlewlineError, Timeout, UsageError
from .worker import Worker

T = TypeVar("T")


class Errand(Generic[T]):
    """A piece of work that brings something back, `answer` once it is `done`, or fails."""

    __slots__ = ("action", "answer", "caller", "done", "failure", "text")

    def __init__(self, caller: Caller, text: str, action: Callable[[], Awaitable[T]]) -> None:
        self.caller, self.text, self.action, self.done = caller, text, action, False
        self.answer: T = None  # type: ignore[assignment]  # until it is done
        self.failure: SlewlineError | None = None

    async def __call__(self) -> None:
        """Do the work, and keep its answer or its failure."""
        try:
            self.answer = self.caller.answer = await self.action()
        except SlewlineError as error:
            self.failure = error
        self.done = True

    def forget(self, why: str) -> None:
        """Let it fail: it is not done any more."""
        self.done, self.failure = True, UsageError(f"{self.caller.name}: {self.text}: forgotten by {why}")


class Caller(Worker):
    """A worker that is asked for something: `answer_of` waits for what an errand brings back."""

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.answer: Any = None  # what the latest errand has brought

    def errand(self, text: str, action: Callable[[], Awaitable[T]]) -> Errand[T]:
        """Queue a piece of work whose answer somebody may wait for."""
        errand = Errand(self, text, action)
        self.work(text, errand)
        return errand

    def answer_of(self, errand: Errand[T], timeout: Time) -> T:
        """Let virtual time pass until an errand is done; return its answer, or raise what went wrong.

        Where calls only queue (`Outside.queued`, or a part without a bench) return None at once.

        Raises:
            Timeout: it is not done in time; it is taken back then.
        """
        try:
            self.kernel.outside.wait(lambda: errand.done, f"{self.name}: {errand.text}", timeout)
        except Timeout:
            self.give_up()
            raise
        if errand.failure is not None:
            raise errand.failure
        return errand.answer

    @from_outside
    def give_up(self) -> None:
        """Take back the last errand, which took too long; what comes after it can go on."""
        self.input("give_up")
        if self.queue:
            self.queue.pop()
        if not self.queue:
            self.halt()

    def take_back(self, left: int, why: str) -> None:
        """Take what is queued back, last first, until `left` pieces of work are left; their errands fail."""
        while len(self.queue) > left:
            _, action = self.queue.pop()
            if isinstance(action, Errand):
                action.forget(why)

    def halt(self) -> None:
        """End what is under way, and put the outputs to rest."""
        if self.task is not None:
            self.task.kill()
        self.begun = False
        self.rest()
        self.kernel.settle()

    def rest(self) -> None:
        """Put the outputs to rest: what was under way was cut short."""
