"""The program in external memory: whether it runs, its address, and its loop counts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from . import sheet

if TYPE_CHECKING:
    from ...core.context import ChipContext
    from .registers import Registers


class Program:
    """State of the program in external memory.  The memory pointer is its program counter.

    `at` is the address of the command in progress; `immediate` is True while a host command is executed between
    two commands of the program.
    """

    def __init__(self, chip: ChipContext, registers: Registers) -> None:
        self.chip, self.registers = chip, registers
        self.clear()

    def clear(self) -> None:
        """Clear the program state and its loops, for RESET and the I command."""
        self.running = self.immediate = self.entering = False  # entering: the host stores a program
        self.at = 0
        self.loops: dict[str, tuple[int, int]] = {}  # by letter: the loop command's address, passes left
        self.reported: set[str] = set()  # findings of this run

    @property
    def direct(self) -> bool:
        """True while the command in progress comes from the host, whether or not a program runs."""
        return self.immediate or not self.running

    @property
    def counter(self) -> int | None:
        """Address of the present program command or, during a host command, of the next; None if no program runs."""
        if not self.running:
            return None
        return self.registers.pointer if self.immediate else self.at

    def begin(self) -> None:
        """Run the program from the pointer; there are no loop counts then, as the end of a program clears them."""
        if not self.running:
            self.reported.clear()
        self.running = True
        self.at = self.registers.pointer

    def end(self) -> None:
        """End the program and clear its loop counts; the pointer stays at the byte after the command that ended it."""
        self.running = False
        self.loops.clear()

    def go_to(self, target: int) -> None:
        """Continue at byte `target` of the present page, the page that contains the byte after the branch command."""
        self.registers.pointer = self.registers.pointer // sheet.PAGE_BYTES * sheet.PAGE_BYTES + target

    def finding_once(self, code: str, text: str) -> None:
        """Add a finding, unless one with this code has already been added in the present run of the program."""
        if code not in self.reported:
            self.reported.add(code)
            self.chip.finding(code, text)

    def passes_left(self, letter: str, count: int, whole: int) -> bool:
        """Count a pass of a loop; return whether another pass follows.

        Args:
            letter: the letter of the loop command; each letter has one count.
            count: the argument of the command; 0 counts as `whole`, the full range of the counter.
        """
        if letter not in self.loops:
            self.loops[letter] = (self.at, count or whole)
        address, left = self.loops.pop(letter)
        if address != self.at:
            self.finding_once(
                "nested-loop",
                f"{letter} at address {self.at} while the {letter} at {address} is counting: it takes over the count",
            )
        if left > 1:
            self.loops[letter] = (address, left - 1)
        return left > 1
