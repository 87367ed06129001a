"""What has come in, of which only the latest is kept: bytes, words, answers.

They bear no times, so two marks do: what came before the last mark is dropped when that mark itself is old enough.

          before        now
    ........|............|          what has come in
      |  dropped  | kept |          at least since `before`, at most twice as far back
               mark     new mark
"""

from __future__ import annotations

from typing import Any


class Recent:
    """The latest of a list or bytearray that grows at its end; `what` stays the same object.

    `dropped` is how many are gone: a place in it that is to be found again is counted from the very first one on.
    """

    __slots__ = ("_mark", "_old", "dropped", "what")

    def __init__(self, what: bytearray | list[Any]) -> None:
        self.what = what
        self.dropped = 0
        self._mark = self._old = 0  # the instant of the last mark (ps), and how many of `what` had come by then

    @property
    def total(self) -> int:
        """How many there have been, the dropped ones included."""
        return self.dropped + len(self.what)

    def place(self, number: int) -> int:
        """Return where in `what` one is that so many came before; the first one, if it is gone."""
        return max(number - self.dropped, 0)

    def forget(self, before: int, now: int) -> None:
        """Drop what is known to have come before an instant (ps); remember what has come up to now."""
        if self._mark > before:
            return
        gone = min(self._old, len(self.what))
        del self.what[:gone]
        self.dropped += gone
        self._mark, self._old = now, len(self.what)

    def clear(self) -> None:
        """Drop all."""
        self.dropped += len(self.what)
        self.what.clear()
        self._old = 0
