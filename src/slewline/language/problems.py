"""Problems in a text, with their places, and pictures that show each place in its line.

weld.txt, line 3, column 3: RATE 200: allowed 0..127 (manual, T.V)
    R 200
      ^^^
    the nearest is 127
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol

from ..core.messages.former_names import formerly

Severity = Literal["error", "warning", "note"]


class HasPlace(Protocol):
    """Anything with a place in a text; lines and columns count from 1."""

    @property
    def line(self) -> int:
        """The line number."""

    @property
    def column(self) -> int:
        """The column of the first character."""

    @property
    def length(self) -> int:
        """The number of characters."""


class Place(NamedTuple):
    """A range of characters in a line of a text."""

    line: int
    column: int
    length: int


@formerly(message="says")
@dataclass(frozen=True, slots=True, order=True)
class Problem:
    """A problem in a text: its place, the text found, the allowed values, the manual's section and the remedy."""

    line: int
    column: int
    length: int
    code: str
    severity: Severity
    found: str
    allowed: str = ""
    where: str = ""
    remedy: str = ""

    @property
    def message(self) -> str:
        """The text found, the allowed values, and the section of the manual, in one line."""
        allowed = f": allowed {self.allowed}" if self.allowed else ""
        where = f" ({self.where})" if self.where else ""
        return f"{self.found}{allowed}{where}"


def picture(problem: Problem, text: str, name: str, severity: bool = True) -> str:
    """Return one problem as text: its message, the line, carets under the characters concerned, and the remedy.

    `name` is the name of the text, and `severity` selects whether the message begins with the severity.
    """
    lines = text.splitlines()
    line = lines[problem.line - 1] if 0 < problem.line <= len(lines) else ""
    blank = re.sub(r"[^\t]", " ", line[: problem.column - 1].ljust(problem.column - 1))  # keeps tabs
    prefix = f"{problem.severity}: " if severity else ""
    shown = [
        f"{name}, line {problem.line}, column {problem.column}: {prefix}{problem.message}",
        f"    {line}",
        f"    {blank}{'^' * max(problem.length, 1)}",
    ]
    return "\n".join([*shown, *(f"    {line}" for line in problem.remedy.splitlines())])


def render(problems: Iterable[Problem], text: str, name: str) -> str:
    """Return the pictures of all problems, separated by blank lines; `name` is the name of the text."""
    return "\n\n".join(picture(problem, text, name) for problem in problems)
