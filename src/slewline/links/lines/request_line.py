"""A line of requests: a part on the bench works them one by one, and each answer goes to the host that asked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from .line_transcript import TranscriptFile
from .outlet import Told
from .pace import Pace
from .served_line import HostLine, Say

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...parts.base.part import Part
    from ...parts.base.request_queue import Request, RequestQueue

BACKLOG = 256  # pieces of work for the part that may wait; the next answer lets in more


class RequestLine(HostLine):
    """Requests to a part that has a queue, and its answers."""

    def __init__(self, name: str, chips: Sequence[Chip], pace: Pace, log: TranscriptFile, part: Part) -> None:
        super().__init__(name, chips, pace, log)
        self._part = part
        self.full = False
        self.silent = False  # another bench says again what is in the transcript

    @property
    def part(self) -> Part:
        """The part that works the requests."""
        return self._part

    @property
    def queue(self) -> RequestQueue:
        """What it has to do."""
        queue = self._part.queue
        assert queue is not None  # noqa: S101  # it is asked
        return queue

    def move(self, bench: Bench, coming: Sequence[Told]) -> None:
        """End in the part of another bench."""
        super().move(bench, coming)
        self._part = bench.parts[self._part.name]

    def answer(self, answers: Callable[[Any, Any], bytes], work: Request[Any] | None = None) -> None:
        """Queue the answer to a piece of work, for the host of this moment: the next one has not asked.

        Args:
            answers: returns the answer, of the part and the work.
        """
        host = self.host

        def do(part: Any, work: Request[Any] | None, say: Say) -> None:
            async def tell() -> None:
                self.silent = part is not self._part
                found, self.silent = answers(part, work), False
                if host is not None and found:
                    say(found, host)
                self.let_in()

            part.queue.post("an answer", tell)

        if self.acts is not None:
            self.acts.add(self.kernel.now, do)
        do(self._part, work, self.give)

    def let_in(self) -> None:
        """Let more come, if it had to wait and there is room."""
        if self.full and self.space() > 0 and self.resume is not None:
            self.resume()

    def space(self) -> int:
        """Return how many bytes may come now."""
        room = BACKLOG - len(self.queue)
        self.full = room <= 0
        return room

    def sent(self) -> bool:
        """Return whether everything that has come has been carried out."""
        return self._part.idle

    def quiet(self) -> bool:
        """Return whether everything that was asked for is answered."""
        return not self.queue.requests
