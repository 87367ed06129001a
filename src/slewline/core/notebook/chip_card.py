"""The notebook view of a chip: package and pin levels, registers, current part of the program, and latest findings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from ..datasheet.packages import packages
from .markup import Markup, card, element, table
from .package import LEVELS, package_drawing

if TYPE_CHECKING:
    from ..datasheet.table import Sheet

BEFORE, AFTER = 6, 14  # instructions shown around the current one
LAST = 3  # findings shown


class Stored(Protocol):
    """An instruction of a stored program."""

    @property
    def address(self) -> int:
        """The address of the first byte of the instruction."""

    @property
    def data(self) -> bytes:
        """The bytes of the instruction."""

    @property
    def text(self) -> str:
        """The instruction as text."""


@dataclass(frozen=True, slots=True)
class ChipCard:
    """The state of a chip at an instant, as a notebook shows it.

    Args:
        description: the name, part number and state of the chip, in one line.
        levels: the levels of the chip's signal pins, by pin name; None for a floating pin.
        registers: for each axis, the values of the registers, by register name.
        rows: the instructions of the stored program.
        counter: the address of the current instruction; None if no program runs.
        findings: the findings as text, in chronological order.
    """

    description: str
    sheet: Sheet
    levels: Mapping[str, int | None]
    registers: Sequence[Mapping[str, int]]
    rows: Sequence[Stored]
    counter: int | None
    findings: Sequence[str]

    def markup(self) -> Markup:
        """Return the card as HTML."""
        return card(
            self.description, *self._packages(), element("div", self._registers(), self._program()), self._findings()
        )

    def _packages(self) -> list[Markup]:
        pins = {pin.name: pin for pin in self.sheet.pins}
        drawn = []
        for package in packages(self.sheet.pins):
            loose = [f"{name} {LEVELS.get(self.levels.get(name), '')}" for name in package.loose]
            note = element("div", f"without a number: {', '.join(loose)}", class_="quiet") if loose else Markup()
            drawing = package_drawing(package, self.sheet.part.upper(), pins, self.levels)
            drawn.append(element("div", drawing, note))
        return drawn

    def _registers(self) -> Markup:
        known = [row for row in self.sheet.registers if row.name in self.registers[0]]
        if not known:
            return Markup()
        axes = len(self.registers)
        names = [f"axis {n}" for n in range(1, axes + 1)] if axes > 1 else ["value"]
        lines = [
            [
                row.letter or "",
                row.name,
                *(str(own.get(row.name, "")) for own in self.registers),
                row.unit,
                row.description,
            ]
            for row in known
        ]
        return _scrolls(table(["", "register", *names, "unit", ""], lines, range(2, 2 + axes)))

    def _program(self) -> Markup:
        if not self.rows:
            return Markup()
        now = next((n for n, row in enumerate(self.rows) if row.address == self.counter), None)
        first = max(min((now or 0) - BEFORE, len(self.rows) - BEFORE - AFTER), 0)
        shown = self.rows[first : first + BEFORE + AFTER]
        lines = [
            ["\u25b6" if first + n == now else "", f"{row.address:04X}", row.data.hex(" ").upper(), row.text]
            for n, row in enumerate(shown)
        ]
        drawn = table(["", "at", "bytes", "program"], lines, now=None if now is None else now - first)
        left = len(self.rows) - len(shown)
        return _scrolls(drawn, element("div", f"{left} more instructions", class_="quiet") if left else Markup())

    def _findings(self) -> Markup:
        if not self.findings:
            return Markup()
        count = f"{len(self.findings)} finding{'s' * (len(self.findings) > 1)}"
        return _scrolls(table([count], [[each] for each in self.findings[-LAST:]]))


def _scrolls(*inside: Markup) -> Markup:
    return element("div", inside, class_="scrolls")
