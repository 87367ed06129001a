"""What a part keeps without power: a store is handed in by the bench, and the part sees nothing else of it."""

from __future__ import annotations

from typing import Protocol


class Store(Protocol):
    """What keeps bytes without power.  Both may raise OSError: the memory fails."""

    def read(self) -> bytes:
        """The bytes that were written last; none at first."""

    def write(self, data: bytes) -> None:
        """Keep these bytes instead, all of them or none."""


class Memory:
    """A store that lives as long as the model."""

    def __init__(self, data: bytes = b"") -> None:
        self.data = data

    def read(self) -> bytes:
        return self.data

    def write(self, data: bytes) -> None:
        self.data = data
