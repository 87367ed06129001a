"""The stored program of a chip, as whoever looks at it sees it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ProgramRow:
    """An instruction of a stored program: where it begins, its bytes, and how it is written.

    A byte that is no instruction stands alone, with ??? and its value as text.
    """

    address: int
    data: bytes
    text: str
