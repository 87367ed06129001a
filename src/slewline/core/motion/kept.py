"""The limit, if any, on how much of its past an axis or a part keeps.

The limit is a period or a number of stretches (axis.py).  Data older than the period cannot be queried.
Old data is dropped when the list of stretches has doubled in length since it was last trimmed.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from typing import Any

from ...errors import LongPast, NotRecorded
from ..messages.calls import level_of_caller
from ..time.timebase import readable

FEWEST = 1024  # stretches; less than that is not worth dropping
MANY = 100_000  # stretches, two per move: 50 to 200 MB with all their data


class Kept:
    """The limit on how much of its past an axis or a part keeps; until `limit` is called, all of it.

    The past is trimmed when it has more than `full` stretches.
    """

    __slots__ = ("full", "name", "ps", "stretches")

    def __init__(self) -> None:
        self.name = ""  # of the axis or part, as in an error
        self.ps: int | None = None
        self.stretches: int | None = None
        self.full = MANY

    @property
    def everything(self) -> bool:
        """True if no limit is set."""
        return self.ps is None and self.stretches is None

    def warn(self) -> None:
        """Warn once that everything is kept, and explain how to keep less."""
        self.full = sys.maxsize
        warnings.warn(
            f"about {MANY // 2:,} motions of an axis are kept, 1 to 4 KB each, and all later ones will be kept, too; "
            "slewline.Bench(keep='10 s') keeps only the last ten seconds",
            LongPast,
            stacklevel=level_of_caller(),
        )

    def limit(self, name: str, ps: int | None = None, stretches: int | None = None) -> None:
        """Keep only the last `ps` picoseconds and at most the last `stretches` stretches.

        If one of the two is None, the present limit of that kind is unchanged.  `name` is the name of the axis
        or the part, for error messages.
        """
        self.name = name
        self.ps = self.ps if ps is None else ps
        self.stretches = self.stretches if stretches is None else stretches
        self.full = max(2 * (self.stretches or 0), FEWEST)

    def bound(self, past: Sequence[Any], now: int) -> int:
        """Return the instant (ps) before which the past, a list of stretches, is to be dropped; `now` is in ps."""
        oldest: int = 0 if self.stretches is None else past[-self.stretches].start
        return oldest if self.ps is None else max(oldest, now - self.ps)

    def dropped(self, left: int) -> None:
        """Set the number of stretches beyond which the past is next trimmed; `left` stretches are left now."""
        self.full = max(2 * left, 2 * (self.stretches or 0), FEWEST)

    @property
    def remedy(self) -> str:
        """The advice to the user in an error message: how to keep more of the past."""
        if self.ps is not None:
            return keep_more(self.ps)
        return f"a server keeps the last {self.stretches} stretches of motion: query earlier, or replay its journal"

    def refusal(self, start: int, since: int) -> NotRecorded:
        """Return the error for a query about `start` (ps), when the past is kept only from `since` (ps)."""
        return NotRecorded(
            f"{self.name} at {readable(start)}: the past is kept only from {readable(since)} on; {self.remedy}"
        )


def keep_more(ps: int) -> str:
    """Return the advice for a query that goes back further than the `ps` picoseconds that a bench keeps."""
    return f"make the bench with a longer keep than {readable(ps)!r}"
