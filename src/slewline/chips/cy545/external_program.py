"""The program in external memory: whether it runs, where, and the counts of its loops."""

from __future__ import annotations

from typing import TYPE_CHECKING

from . import sheet

if TYPE_CHECKING:
    from ...core.context import ChipContext
    from .registers import Registers


class Program:
    """A program that runs, or does not.  Its counter is the memory pointer.

    `at` is the address of the command in progress; `immediate`: a command of the host is performed between two of the
    program.
    """

    def __init__(self, chip: ChipContext, registers: Registers) -> None:
        self.chip, self.registers = chip, registers
        self.clear()

    def clear(self) -> None:
        """RESET and I: no program, no loop."""
        self.running = self.immediate = self.entering = False  # entering: the host stores one
        self.at = 0
        self.loops: dict[str, tuple[int, int]] = {}  # by letter: the loop command that counts, and what is left
        self.told: set[str] = set()  # findings of this run

    @property
    def direct(self) -> bool:
        """Is the command in progress one of the host, whether a program runs or not?"""
        return self.immediate or not self.running

    @property
    def counter(self) -> int | None:
        """The address of the command in progress, or of the next while the host's is performed; None: none runs."""
        if not self.running:
            return None
        return self.registers.pointer if self.immediate else self.at

    def begin(self) -> None:
        """Run from the pointer on; no loop counts, since whatever ends a program drops the counts."""
        if not self.running:
            self.told.clear()
        self.running = True
        self.at = self.registers.pointer

    def end(self) -> None:
        """The program has stopped: the pointer is after the command that did it."""
        self.running = False
        self.loops.clear()

    def go_to(self, target: int) -> None:
        """Continue at a byte of this page, which is that of the byte after the branch."""
        self.registers.pointer = self.registers.pointer // sheet.PAGE_BYTES * sheet.PAGE_BYTES + target

    def finding_once(self, code: str, text: str) -> None:
        """Add a finding, once a run."""
        if code not in self.told:
            self.told.add(code)
            self.chip.finding(code, text)

    def passes_left(self, letter: str, count: int, whole: int) -> bool:
        """Count a pass of a loop; return whether another one follows.

        Args:
            letter: of the loop command; there is one count for each.
            count: what the command says; 0 is `whole`, the counter run through.
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
