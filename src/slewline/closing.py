"""Base classes for objects that need closing: `close` may be called twice, and a `with` block calls it."""

from __future__ import annotations

from types import TracebackType
from typing import Self


class WholeOrNothing:
    """A result that a `with` block completes at its end, or discards if an exception leaves the block."""

    def close(self) -> None:
        """Complete the result."""
        raise NotImplementedError

    def discard(self) -> None:
        """Discard the result, unless it is complete."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self.close()
        finally:
            self.discard()


class Closing:
    """An object that can be closed; subclasses implement `_shut`."""

    closed = False

    def close(self) -> None:
        """Close the object; a second call does nothing."""
        if not self.closed:
            self.closed = True
            self._shut()

    def _shut(self) -> None:
        """Release the object's resources; called once."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
