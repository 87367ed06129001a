"""How a part that keeps programs as they were written has its commands written: what its sheet says of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..dialect import Dialect


@dataclass(frozen=True, eq=False)
class Forms(Dialect):
    """The signs that have a meaning of their own; `Verbatim` says which."""

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
