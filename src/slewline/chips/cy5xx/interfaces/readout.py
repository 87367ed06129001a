"""The verify groups: what the chip reports about itself, byte by byte (s.6)."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ....core.context import ChipContext


class ReadOut:
    """Which byte a read-out gives next.

    Args:
        sizes: how many bytes the manual promises of each group.
        content: returns all bytes of a group as they stand now; its second argument says whether V came as text.
    """

    def __init__(self, chip: ChipContext, sizes: Mapping[int, int], content: Callable[[int, bool], bytes]) -> None:
        self.chip, self.sizes, self.content = chip, sizes, content
        self.clear()

    def clear(self) -> None:
        """No V has been given."""
        self.group: tuple[int, bool] | None = None  # and whether V was given in ASCII
        self.output: bytes | None = None  # the group as captured at its first fetch
        self.fetched = 0

    def point(self, group: int, ascii: bool) -> None:
        """V: point at a group; its bytes are those at the first fetch."""
        self.group = (group, ascii)
        self.output, self.fetched = None, 0

    def next(self) -> int:
        """Return the next byte of the group that V points at; FF where there is none."""
        finding = self.chip.finding
        if self.group is None:
            finding("verify-without-v", "a read-out without any V before: FF")
            return 0xFF
        if self.output is None:
            self.output = self.content(*self.group)
        if self.fetched >= len(self.output):
            finding("verify-overrun", f"group {self.group[0]} has {len(self.output)} bytes: FF")
            return 0xFF
        if self.group[0] == 1 and self.fetched == self.sizes[1]:
            finding("verify-48", f"the manual guarantees the first {self.sizes[1]} bytes of the program")
        self.fetched += 1
        return self.output[self.fetched - 1]
