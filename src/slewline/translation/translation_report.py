"""What became of each line of a program: the same, nearly, not possible; and what was assumed.

bar.cy525, line 4: R 80 -> T478: nearly: 4780 steps/s for 4783, 0.06 %
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

from .meaning import Assumed


class LineKind(Enum):
    """What became of a line: kinds in the order from best to worst."""

    SAME = "same"
    NEARLY = "nearly"
    IMPOSSIBLE = "not possible"

    @property
    def worth(self) -> int:
        """0 for the best, more for worse."""
        return list(LineKind).index(self)


@dataclass(frozen=True, slots=True)
class LineVerdict:
    """What became of a line of the source, or of a part of what it does.

    Attributes:
        line: the line of the source; 0: the whole program.
        kind: the same, nearly, or not possible.
        says: what is different, with its figure: "4780 steps/s for 4783"; of what is the same what to know of it.
        limit: for what is not possible, the limit of the target, and where its manual states it.
        remedy: what a person can do.
        off: by how much a figure differs, as a fraction of what it shall be: 0.004 for 0.4 %.
        off_ps: by how much a time differs, ps.
    """

    line: int
    kind: LineKind
    says: str = ""
    limit: str = ""
    remedy: str = ""
    off: float = 0.0
    off_ps: int = 0

    @property
    def text(self) -> str:
        """The verdict in one line."""
        parts = [self.kind.value, self.says, f"{self.limit}" if self.limit else "", self.remedy]
        return ": ".join(parts[:2] if parts[1] else parts[:1]) + "".join(f"; {part}" for part in parts[2:] if part)


@dataclass(frozen=True, slots=True)
class OutLine:
    """A line of the result: its text without comment, the comment, and the line of the source; 0: no line of it."""

    text: str
    comment: str = ""
    source: int = 0


@dataclass(frozen=True, slots=True)
class ReportLine:
    """A line of the source that says something, what was written for it, and the verdicts on it, worst first."""

    number: int
    code: str
    written: tuple[str, ...]
    verdicts: tuple[LineVerdict, ...]

    @property
    def kind(self) -> LineKind:
        """The worst of its verdicts; without any, it is the same."""
        return max((each.kind for each in self.verdicts), key=lambda kind: kind.worth, default=LineKind.SAME)


@dataclass(frozen=True, slots=True)
class Report:
    """What became of a program.

    Attributes:
        where: the name of the source.
        part: what the source is for.
        to: what the result is for.
        lines: the lines of the source that say something, in order.
        whole: verdicts on the program as a whole, such as its size.
        assumed: what the text does not say.
        wiring: pairs of a wire of the source and of the target, each with what it is for.
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
        """The number of lines of each kind."""
        counted = Counter(line.kind for line in self.lines)
        return {kind: counted[kind] for kind in LineKind}

    @property
    def same(self) -> bool:
        """Whether every line, and the program as a whole, is the same."""
        kinds = [line.kind for line in self.lines] + [each.kind for each in self.whole]
        return all(kind is LineKind.SAME for kind in kinds)

    def of(self, number: int) -> ReportLine | None:
        """Return what became of a line of the source; None: it says nothing."""
        return next((line for line in self.lines if line.number == number), None)

    def __iter__(self) -> Iterator[ReportLine]:
        return iter(self.lines)
