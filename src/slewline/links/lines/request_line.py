"""A request line: a part on the bench executes requests one by one, and each answer goes to the requesting host."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from .line_transcript import TranscriptFile
from .outlet import SentBytes
from .pace import Pace
from .served_line import HostLine, Send

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...parts.base.part import Part
    from ...parts.base.request_queue import Request, RequestQueue

BACKLOG = 256  # requests that may wait for the part; the next answer makes room


class RequestLine(HostLine):
    """A line on which hosts send requests to the queue of a part, and receive the part's answers."""

    def __init__(self, name: str, chips: Sequence[Chip], pace: Pace, log: TranscriptFile, part: Part) -> None:
        super().__init__(name, chips, pace, log)
        self._part = part
        self.full = False
        self.silent = False  # another bench repeats answers that are in the transcript

    @property
    def part(self) -> Part:
        """Part that executes the requests."""
        return self._part

    @property
    def queue(self) -> RequestQueue:
        """Queue of the part."""
        queue = self._part.queue
        assert queue is not None  # noqa: S101  # it is asked
        return queue

    def move(self, bench: Bench, coming: Sequence[SentBytes]) -> None:
        """Connect the line to the part of the same name on another bench."""
        super().move(bench, coming)
        self._part = bench.parts[self._part.name]

    def answer(self, answers: Callable[[Any, Any], bytes], work: Request[Any] | None = None) -> None:
        """Queue the answer to a request of the present host; drop that answer if the host leaves first.

        Args:
            answers: returns the answer, given the part and the executed request `work`.
        """
        host = self.host

        def do(part: Any, work: Request[Any] | None, send: Send) -> None:
            async def deliver() -> None:
                self.silent = part is not self._part
                found, self.silent = answers(part, work), False
                if host is not None and found:
                    send(found, host)
                self.let_in()

            part.queue.post("an answer", deliver)

        if self.acts is not None:
            self.acts.add(self.kernel.now, do)
        do(self._part, work, self.give)

    def let_in(self) -> None:
        """Accept more bytes from the host, if it had to wait and there is room now."""
        if self.full and self.space() > 0 and self.resume is not None:
            self.resume()

    def space(self) -> int:
        """Return the number of bytes that may arrive now."""
        room = BACKLOG - len(self.queue)
        self.full = room <= 0
        return room

    def sent(self) -> bool:
        """Return whether every request has been executed."""
        return self._part.idle

    def quiet(self) -> bool:
        """Return whether all requests have been answered."""
        return not self.queue.requests
