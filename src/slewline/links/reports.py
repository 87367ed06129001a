"""Findings for who looks at a terminal: each kind once a minute, then how many more of it there were."""

from __future__ import annotations

from collections.abc import Callable

from ..core.chip import Finding
from .loop import Loop

PERIOD_S = 60.0


class Reports:
    """Tells findings; the first of a code and a source at once, the others as a number when the minute is over."""

    def __init__(self, loop: Loop, tell: Callable[[str], object]) -> None:
        self.loop, self.tell = loop, tell
        self.more: dict[tuple[str, str], int] = {}  # since the last report of this source and code

    def found(self, finding: Finding) -> None:
        """Report a finding."""
        key = finding.source, finding.code
        if key in self.more:
            self.more[key] += 1
        else:
            self.tell(f"{finding.source}: {finding.code}: {finding.text}")
            self._begin(key)

    def _begin(self, key: tuple[str, str]) -> None:
        self.more[key] = 0
        self.loop.after(PERIOD_S, lambda: self._over(key))

    def _over(self, key: tuple[str, str]) -> None:
        if self._count(key):
            self._begin(key)

    def _count(self, key: tuple[str, str]) -> int:
        count = self.more.pop(key)
        if count:
            self.tell(f"{key[0]}: {key[1]}: {count} more of these")
        return count

    def close(self) -> None:
        """Tell what is left."""
        for key in list(self.more):
            self._count(key)
