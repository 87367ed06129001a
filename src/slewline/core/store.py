"""What a part keeps without power: a store is handed in by the bench, and the part sees nothing else of it."""

from __future__ import annotations

from typing import Protocol

from .option import Option


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


def _missing(store: object) -> str:
    has = all(callable(getattr(store, name, None)) for name in ("read", "write"))
    return "" if has else "expected an object with read() and write(data)"


STORE = Option(
    "store",
    "object",
    None,
    "what keeps the memory without power: an object with read() and write(data); gone with the bench by default",
    none=True,
    check=_missing,
)
