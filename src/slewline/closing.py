"""What is opened and closed: closed twice it is closed, and a `with` block closes it."""

from __future__ import annotations

from types import TracebackType
from typing import Self


class WholeOrNothing:
    """What a `with` block completes at its end, and discards when an error leaves the block."""

    def close(self) -> None:
        """Complete it."""
        raise NotImplementedError

    def discard(self) -> None:
        """Drop it, unless it is complete."""
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
    """What has an end; a class says in `_shut` what that is."""

    closed = False

    def close(self) -> None:
        """End it; to close it again does nothing."""
        if not self.closed:
            self.closed = True
            self._shut()

    def _shut(self) -> None:
        """End it; called once."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
