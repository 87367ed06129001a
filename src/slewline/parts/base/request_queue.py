"""A queue of requests to a part, which a task performs one after another.

    queue.post("pausing", wait)                         no call waits for it; an error in it ends the run
    request = queue.submit("in 0x340", read)            its result, or its failure, is kept
    queue.result(request, "5 s")                        let virtual time pass until it is done

The journal records a request as an input when it is queued, but not the waiting for its result: on replay, time
passes as the journal determines.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Awaitable, Callable
from functools import partial
from operator import attrgetter
from typing import Any, Generic, TypeVar

from ...core.messages.whole import counted
from ...core.time.kernel import Kernel, Task
from ...core.time.timebase import Time, readable
from ...errors import SlewlineError, Timeout, UsageError

T = TypeVar("T")
DONE = attrgetter("done")


class Request(Generic[T]):
    """A coroutine function (`action`) to be run; once the request is `done`, it has a `result` or a `failure`.

    `kept`: whether an error in the function becomes the `failure`; otherwise, the error ends the run.
    """

    __slots__ = ("action", "done", "failure", "kept", "result", "text")

    def __init__(self, text: str, action: Callable[[], Awaitable[T]], kept: bool) -> None:
        self.text, self.action, self.kept, self.done = text, action, kept, False
        self.result: T = None  # type: ignore[assignment]  # until it is done
        self.failure: SlewlineError | None = None

    async def run(self) -> None:
        """Run the coroutine function; store its result or, if the request is `kept`, its error as `failure`."""
        try:
            self.result = await self.action()
        except SlewlineError as error:
            if not self.kept:
                raise
            self.failure = error
        self.done = True


class RequestQueue:
    """The queue of requests to a part, which a task performs one after another.

    `begun`: whether the first request has already affected the lines, and so must not be interrupted; set by
    parts for which this matters.

    Args:
        give_up: the function that cancels the last request after a timeout; by default `cancel_last`; a part
            can provide a function that also records the cancelling as an input of the part.
        rest: a function that releases the outputs of the part after a request has been cut short.
    """

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        give_up: Callable[[], object] | None = None,
        rest: Callable[[], object] = lambda: None,
    ) -> None:
        self.kernel, self.name, self.give_up, self.rest = kernel, name, give_up or self.cancel_last, rest
        self.requests: deque[Request[Any]] = deque()
        self.task: Task | None = None
        self.since = 0
        self.begun = False

    def __len__(self) -> int:
        return len(self.requests)

    def post(self, text: str, action: Callable[[], Awaitable[Any]]) -> None:
        """Queue a request that no call waits for; `text` describes it."""
        self._add(Request(text, action, kept=False))

    def submit(self, text: str, action: Callable[[], Awaitable[T]]) -> Request[T]:
        """Queue a request whose result a call may wait for; `text` describes it."""
        return self._add(Request(text, action, kept=True))

    def _add(self, request: Request[T]) -> Request[T]:
        self.requests.append(request)
        if self.task is None or not self.task.alive:
            self.task = self.kernel.spawn(self._run, name=self.name)
        return request

    async def _run(self) -> None:
        while self.requests:
            self.since = self.kernel.now
            try:
                await self.requests[0].run()
            except Exception:
                self.requests.clear()  # requests after the failed one are not performed either
                raise
            self.requests.popleft()
            self.begun = False

    @property
    def idle(self) -> bool:
        """True while the queue is empty."""
        return not self.requests

    @property
    def waiting(self) -> str:
        """The request under way, in words, with its start time and the number of requests, this one included."""
        if not self.requests:
            return f"{self.name}: nothing to do"
        queued = counted(len(self.requests), "command")
        return f"{self.name}: {self.requests[0].text} since {readable(self.since)}, {queued} queued"

    # -------------------------------------------------------------------------------------------------------- waiting
    def result(self, request: Request[T], timeout: Time) -> T:
        """Let virtual time pass until a request is done; return its result, or raise its failure.

        In a block of `Outside.queued`, and for a part without a bench, do not wait: return None immediately.

        Raises:
            Timeout: the request is not done in time; the last request in the queue is then cancelled.
        """
        self.let_pass(partial(DONE, request), request.text, timeout)
        if request.failure is not None:
            raise request.failure
        return request.result

    def let_pass(self, met: Callable[[], bool], what: str, timeout: Time) -> None:
        """Let virtual time pass until a condition is met; `what` describes it.

        Raises:
            Timeout: the condition is not met in time; the last request in the queue is then cancelled.
        """
        try:
            self.kernel.outside.wait(met, f"{self.name}: {what}", timeout)
        except Timeout:
            self.give_up()
            raise

    # ----------------------------------------------------------------------------------------------------- cancelling
    def cancel_last(self) -> None:
        """Cancel the last request in the queue; requests queued after this call are performed as usual."""
        if self.requests:
            self.requests.pop()
        if not self.requests:
            self.halt()

    def cancel_after(self, number: int, why: str) -> None:
        """Cancel all requests in the queue after the first `number`; they fail with `why` in the message."""
        while len(self.requests) > number:
            request = self.requests.pop()
            request.done = True
            request.failure = UsageError(f"{self.name}: {request.text}: dropped by {why}")

    def halt(self) -> None:
        """End the request under way, and release the outputs."""
        if self.task is not None:
            self.task.kill()
        self.begun = False
        self.rest()
        self.kernel.settle()
