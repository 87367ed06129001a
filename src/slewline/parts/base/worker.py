"""Parts that work off a queue in a task of their own: senders, typists, processors."""

from __future__ import annotations

from collections import deque
from collections.abc import Awaitable, Callable, Iterable

from ...core.time.kernel import Kernel, Task
from ...core.time.timebase import readable
from ...core.wires.net import Net
from ...errors import UsageError
from .part import Part

Data = str | bytes | Iterable[int]


def as_bytes(owner: str, data: Data) -> bytes:
    """Text (ASCII), bytes, or a list of numbers 0 to 255, as bytes."""
    try:
        if isinstance(data, int):
            raise TypeError
        return data.encode("ascii") if isinstance(data, str) else bytes(data)
    except UnicodeEncodeError as error:
        raise UsageError(
            f"{owner}: {data[error.start]!r} at character {error.start + 1} is not ASCII; give bytes for raw values"  # type: ignore[index]
        ) from None
    except (TypeError, ValueError):
        raise UsageError(f"{owner}: {data!r}; expected text, bytes, or a list of numbers 0 to 255") from None


class Worker(Part):
    """A part with a queue of work; each piece is a coroutine function, with a text that says what it does."""

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.queue: deque[tuple[str, Callable[[], Awaitable[None]]]] = deque()
        self.task: Task | None = None
        self.since = 0
        self.begun = False  # has the first piece of work begun to show? the part says so itself, where it matters

    def net(self, name: str) -> Net:
        """Return the net on a pin."""
        return self.pins[name].net

    def work(self, text: str, action: Callable[[], Awaitable[None]]) -> None:
        """Put a piece of work at the end of the queue."""
        self.queue.append((text, action))
        if self.task is None or not self.task.alive:
            self.task = self.kernel.spawn(self._run, name=self.name)

    async def _run(self) -> None:
        while self.queue:
            self.since = self.kernel.now
            try:
                await self.queue[0][1]()
            except Exception:
                self.queue.clear()  # what stands behind the piece that failed is not done either
                raise
            self.queue.popleft()
            self.begun = False

    @property
    def idle(self) -> bool:
        """Nothing is queued."""
        return not self.queue

    @property
    def waiting(self) -> str:
        """The piece of work that is under way, in words, and since when."""
        if not self.queue:
            return super().waiting
        return f"{self.name}: {self.queue[0][0]}, {len(self.queue)} in the queue, since {readable(self.since)}"
