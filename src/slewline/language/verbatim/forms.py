"""How a part that keeps programs as they were written has its commands written: what its sheet says of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..dialect import Dialect


@dataclass(frozen=True, eq=False)
class Forms(Dialect):
    """The signs that have a meaning of their own.

    Args:
        queries: the letters that may be asked for, each with the digits of its answer.
        asked: what queries ask for whose letter sets no register.
        answer_bytes: of the value in a binary answer, by the digits that it has in text.
        listing: the letter that asks for lines of the memory.
        query, quote, display: the forms of the commands that ask, that say a string, that write to a display.
        negate: stands in front of the commands `negated`, and inverts the bits `flips` of their first argument.
        switches: stands for a first argument that switches give.
        page: bytes that a branch with an address of one byte reaches.
    """

    queries: Mapping[str, int] = field(default_factory=dict)
    asked: Mapping[str, str] = field(default_factory=dict)
    answer_bytes: Mapping[int, int] = field(default_factory=dict)
    listing: str = "M"
    query: str = "?"
    quote: str = '"'
    display: str = "["
    negate: str = "/"
    negated: tuple[str, ...] = ("B", "T", "W", "H")
    flips: int = 0x10
    switches: str = "#"
    page: int = 256
