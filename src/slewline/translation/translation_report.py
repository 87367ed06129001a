"""The verdict on each line of a program (the same, nearly, not possible), and the assumptions.

bar.cy525, line 4: R 80 -> T478: nearly: 4780 steps/s for 4783, 0.06 %
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

from .meaning import Assumed


class LineKind(Enum):
    """The kind of a verdict on a line; the kinds are in order from best to worst."""

    SAME = "same"
    NEARLY = "nearly"
    IMPOSSIBLE = "not possible"

    @property
    def worth(self) -> int:
        """The rank of the kind: 0 for the best, higher for worse kinds."""
        return list(LineKind).index(self)


@dataclass(frozen=True, slots=True)
class LineVerdict:
    """The verdict on a line of the source, or on a part of the line's effect.

    Attributes:
        line: the number of the source line; 0: the whole program.
        kind: the same, nearly, or not possible.
        description: the difference, with its figure: "4780 steps/s for 4783"; a note if there is no
            difference.
        limit: if not possible, the limit of the target, and where its manual states it.
        remedy: advice to the user.
        off: the relative size of the difference: 0.004 for 0.4 %.
        off_ps: the difference between times, ps.
    """

    line: int
    kind: LineKind
    description: str = ""
    limit: str = ""
    remedy: str = ""
    off: float = 0.0
    off_ps: int = 0

    @property
    def text(self) -> str:
        """The verdict in one line."""
        parts = [self.kind.value, self.description, f"{self.limit}" if self.limit else "", self.remedy]
        return ": ".join(parts[:2] if parts[1] else parts[:1]) + "".join(f"; {part}" for part in parts[2:] if part)


@dataclass(frozen=True, slots=True)
class OutLine:
    """A line of the result: its text without comment, the comment, and the number of its source line (0: none)."""

    text: str
    comment: str = ""
    source: int = 0


@dataclass(frozen=True, slots=True)
class ReportLine:
    """A source line with code, the lines written for it, and the verdicts on it, worst first."""

    number: int
    code: str
    written: tuple[str, ...]
    verdicts: tuple[LineVerdict, ...]

    @property
    def kind(self) -> LineKind:
        """The worst kind among the line's verdicts; for a line without verdicts, "the same"."""
        return max((each.kind for each in self.verdicts), key=lambda kind: kind.worth, default=LineKind.SAME)


@dataclass(frozen=True, slots=True)
class Report:
    """The report on a translation.

    Attributes:
        where: the name of the source.
        part: the part that the source is for.
        to: the target of the result.
        lines: the lines of the source with code, in order.
        whole: verdicts on the program as a whole, such as on its size.
        assumed: the assumptions about facts missing from the text.
        wiring: triples: the purpose of a wire, its pin in the source, and its pin in the target.
    """

    where: str
    part: str
    to: str
    lines: tuple[ReportLine, ...]
    whole: tuple[LineVerdict, ...] = ()
    assumed: tuple[Assumed, ...] = ()
    wiring: tuple[tuple[str, str, str], ...] = ()

    @property
    def counts(self) -> dict[LineKind, int]:
        """The number of lines of each kind of verdict."""
        counted = Counter(line.kind for line in self.lines)
        return {kind: counted[kind] for kind in LineKind}

    @property
    def same(self) -> bool:
        """True if the verdict on every line, and on the program as a whole, is "the same"."""
        kinds = [line.kind for line in self.lines] + [each.kind for each in self.whole]
        return all(kind is LineKind.SAME for kind in kinds)

    def of(self, number: int) -> ReportLine | None:
        """Return the report on the source line with the given number, or None if the line has no code."""
        return next((line for line in self.lines if line.number == number), None)

    def __iter__(self) -> Iterator[ReportLine]:
        return iter(self.lines)
