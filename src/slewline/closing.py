"""What is opened and closed: closed twice it is closed, and a `with` block closes it."""

from __future__ import annotations

from types import TracebackType
from typing import Self


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
