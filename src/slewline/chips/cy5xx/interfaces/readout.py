"""The verify groups: the chip's report about itself, byte by byte (s.6)."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ....core.context import ChipContext


class ReadOut:
    """The source of read-out bytes.

    Args:
        sizes: the number of bytes that the manual specifies for each group.
        content: returns the present bytes of a group; its second argument is True if V was sent in ASCII.
    """

    def __init__(self, chip: ChipContext, sizes: Mapping[int, int], content: Callable[[int, bool], bytes]) -> None:
        self.chip, self.sizes, self.content = chip, sizes, content
        self.clear()

    def clear(self) -> None:
        """Discard the selection made by the last V."""
        self.group: tuple[int, bool] | None = None  # and True if V was sent in ASCII
        self.output: bytes | None = None  # the group as captured at its first fetch
        self.fetched = 0

    def point(self, group: int, ascii: bool) -> None:
        """V: select a group; its bytes are captured when the first of them is fetched."""
        self.group = (group, ascii)
        self.output, self.fetched = None, 0

    def next(self) -> int:
        """Return the next byte of the group that V selected; FF if no group is selected, or no byte is left."""
        finding = self.chip.finding
        if self.group is None:
            finding("verify-without-v", "a read-out that is not preceded by a V returns FF")
            return 0xFF
        if self.output is None:
            self.output = self.content(*self.group)
        if self.fetched >= len(self.output):
            finding("verify-overrun", f"group {self.group[0]} has {len(self.output)} bytes; further bytes are FF")
            return 0xFF
        if self.group[0] == 1 and self.fetched == self.sizes[1]:
            finding("verify-48", f"the manual guarantees only the first {self.sizes[1]} bytes of the program")
        self.fetched += 1
        return self.output[self.fetched - 1]
