"""Received data (bytes, words, answers), of which only the latest are kept.

The data have no time stamps.  Instead, a mark records an instant and the number of items received by then.
Once the mark is older than `before`, the data before it are dropped, and a new mark is set at the end.

          before        now
    ........|............|          received data
      |  dropped  | kept |          kept: at least the time since `before`, at most twice that time
               mark     new mark
"""

from __future__ import annotations

from typing import Any


class Recent:
    """The latest elements of a list or bytearray (`what`) that grows at its end and stays the same object.

    `dropped` is the number of dropped elements; an index that must stay valid when elements are
    dropped counts from the very first element.
    """

    __slots__ = ("_mark", "_old", "dropped", "what")

    def __init__(self, what: bytearray | list[Any]) -> None:
        self.what = what
        self.dropped = 0
        self._mark = self._old = 0  # the instant of the last mark (ps), and the length of `what` then

    @property
    def total(self) -> int:
        """Number of elements so far, including the dropped ones."""
        return self.dropped + len(self.what)

    def place(self, number: int) -> int:
        """Return the index in `what` of an element; its `number` counts from 0 and includes the dropped elements.

        If that element has been dropped, return the index of the first kept one: 0.
        """
        return max(number - self.dropped, 0)

    def forget(self, before: int, now: int) -> None:
        """Drop the elements before the last mark, and set a new mark, unless the last is later than `before`.

        `now` is the present instant, and becomes the instant of the new mark; `before` and `now` are in ps.
        """
        if self._mark > before:
            return
        gone = min(self._old, len(self.what))
        del self.what[:gone]
        self.dropped += gone
        self._mark, self._old = now, len(self.what)

    def clear(self) -> None:
        """Drop all elements."""
        self.dropped += len(self.what)
        self.what.clear()
        self._old = 0
