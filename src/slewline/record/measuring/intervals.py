r"""Times between edges, compared with the limits in the data sheet.

    start  ‾‾\___/‾‾\___/‾‾‾‾‾‾‾‾‾‾‾‾‾‾    an interval runs from a start edge to an end edge, with no other start
    end    ‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\___/‾‾\___/‾    or end edge in between: here, from the second fall of
                    |<-->|                 the start signal to the first fall of the end signal

All times are exact, in whole picoseconds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from ...core.datasheet.table import Limit
from ...core.notebook.markup import card, table
from ...errors import UsageError
from ..recording.recorder import FLOATING, Recorder, real_edges, width_of
from ..style import aligned, duration

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ..recording.recorder import Levels, Probe
    from ..recording.traces import Trace

    Spans: TypeAlias = tuple[NDArray[np.int64], NDArray[np.int64]]  # starts and ends

CHANGES = ("falls", "rises", "changes", "appears", "vanishes")


class SignalEdges(NamedTuple):
    """The edges of one pin or bus, as returned by Recorder.edges, the level before them, and whether it is a bus."""

    times_ps: NDArray[np.int64]
    levels: Levels
    level: int
    bus: bool

    @classmethod
    def of(cls, probe: Probe, recorder: Recorder, start: int, stop: int) -> SignalEdges:
        """Return the edges of a recorded net or pin in start <= t <= stop (ps).

        Raises:
            NotRecorded, TimeError: as for `Recorder.edges`.
        """
        times, levels = recorder.edges(probe, start, stop)
        before = max(start - 1, recorder.since(probe))
        return cls(times, levels, recorder.level(probe, before), width_of(probe) > 1)

    @classmethod
    def of_trace(cls, trace: Trace, start: int, stop: int) -> SignalEdges:
        """Return the edges of a measured signal in a window (ps); where it was not measured, it counts as floating."""
        import numpy as np

        since, until = max(start, trace.since), min(stop, trace.until)
        if until <= since:
            return cls(np.empty(0, np.int64), np.empty(0, np.int16), FLOATING, trace.bus)
        cut = trace.within(since, until)
        times, levels, level = cut.times_ps, cut.levels.astype(np.int16), cut.level
        if since > start:
            times, levels, level = np.append(since, times), np.append(level, levels), FLOATING
        if until < stop:
            times, levels = np.append(times, until + 1), np.append(levels, FLOATING)
        return cls(*real_edges(times, levels, level), level, trace.bus)

    def edges(self, change: str) -> NDArray[np.int64]:
        """Return the instants of all changes of one kind, such as "falls": (n,) int64 ps, ascending."""
        import numpy as np

        before = np.append(self.level, self.levels)[:-1]
        chosen = {
            "changes": before == before,
            "appears": before == FLOATING,
            "vanishes": self.levels == FLOATING,
            "falls": self.levels == 0,
            "rises": self.levels == 1,
        }
        found: NDArray[np.int64] = self.times_ps[chosen[change]]
        return found

    def levels_at(self, times: Any) -> NDArray[np.int64]:
        """Return the levels at instants in the window, after any edges at these instants: (n,) int64."""
        import numpy as np

        found: NDArray[np.int64] = np.append(self.level, self.levels)[np.searchsorted(self.times_ps, times, "right")]
        return found


class Edge(NamedTuple):
    """A specified edge: "hostwrite rises", "pulse falls 3" (the third fall), or just a pin for any change."""

    pin: str
    change: str
    number: int

    @classmethod
    def read(cls, text: str) -> Edge:
        """Return the edge that a text specifies.

        Raises:
            UsageError: the text does not specify an edge.
        """
        pin, *rest = (text.split() if isinstance(text, str) else []) or [""]
        change = rest.pop(0) if rest and rest[0] in CHANGES else "changes"
        number = rest.pop(0) if rest else "1"
        if not pin or rest or not number.isdecimal() or not int(number):
            allowed = ", ".join(CHANGES)
            raise UsageError(
                f"edge {text!r}: expected a pin, a change ({allowed}) and a number, as in 'x.pulse falls 3'"
            )
        return cls(pin, change, int(number))

    def find(self, signal: SignalEdges, after: int, include: bool) -> int | None:
        """Return the instant (ps) of this edge; None if there is none.

        Edges are counted from `after`; an edge at `after` itself counts only if `include` is True.
        """
        import numpy as np

        if signal.bus and self.change in ("falls", "rises"):
            raise UsageError(f"{self.pin} {self.change}: {self.pin} is a bus; allowed 'changes', 'appears', 'vanishes'")
        times = signal.edges(self.change)
        at = int(np.searchsorted(times, after, "left" if include else "right")) + self.number - 1
        return int(times[at]) if at < len(times) else None


def pairs(starts: NDArray[np.int64], ends: NDArray[np.int64], strict: bool) -> Spans:
    """Return the starts and ends of all intervals: (m,) int64 ps each.

    If `strict` is True, no interval has length 0.
    """
    import numpy as np

    last = np.searchsorted(starts, ends, "left" if strict else "right") - 1
    begun = np.append(-1, starts)[last + 1]
    before = np.append(-2, ends)[:-1]
    real = (last >= 0) & ((begun >= before) if strict else (begun > before))
    return begun[real], ends[real]


def intervals(limit: Limit, signals: Callable[[str], SignalEdges]) -> Spans:
    """Return the starts and ends of all intervals to which a limit applies: (m,) int64 ps each.

    Args:
        signals: a function that returns the edges of a pin, given its name in the data sheet.
    """
    (first, begins), (second, ends) = limit.start.split(), limit.end.split()
    answer = limit.least is None and limit.most is None  # a host may send another request at the instant of the answer
    never = limit.most is not None and limit.most < 0  # the end must come first; at the same instant the interval is 0
    starts = signals(first).edges(begins)
    for pin, level in limit.before:
        starts = starts[signals(pin).levels_at(starts - 1) == level]
    found = pairs(starts, signals(second).edges(ends), answer or never or limit.start == limit.end)
    for pin, level in limit.given:
        matching = signals(pin).levels_at(found[1]) == level
        found = found[0][matching], found[1][matching]
    return found


def rounded(ps: int, digits: int) -> int:
    """Return a time rounded to `digits` significant digits."""
    power = int(10 ** max(len(str(ps)) - digits, 0))
    return (ps + power // 2) // power * power


@dataclass(frozen=True, slots=True)
class Bound:
    """A time limit of a chip at the frequency of its crystal: minimum, typical and maximum times in ps."""

    limit: Limit
    least: int | None
    typical: int | None
    most: int | None

    @classmethod
    def of(cls, limit: Limit, crystal_hz: int) -> Bound:
        """Return a limit with its times (ps) at a crystal frequency (Hz)."""
        return cls(limit, *limit.at(crystal_hz))

    def kept(self, shortest: int, longest: int) -> bool | None:
        """Return whether times from `shortest` to `longest` (ps) meet the limit; None if it is only typical."""
        if self.least is None and self.most is None:
            return None
        return (self.least is None or shortest >= self.least) and (self.most is None or longest <= self.most)

    def __str__(self) -> str:
        named = ("min.", self.least), ("typ.", self.typical), ("max.", self.most)
        return ", ".join(f"{name} {duration(rounded(ps, 6))}" for name, ps in named if ps is not None)


@dataclass(frozen=True, slots=True)
class Interval:
    """A measured time between two edges.

    Attributes:
        start: the first edge, such as "x.io_request falls".
        end: the second edge.
        start_ps: the instant of the first edge, ps.
        end_ps: the instant of the second edge, ps.
        bounds: the limits for this interval in the part's data sheet.
    """

    start: str
    end: str
    start_ps: int
    end_ps: int
    bounds: tuple[Bound, ...] = ()

    @property
    def ps(self) -> int:
        """The length of the interval, ps."""
        return self.end_ps - self.start_ps

    @property
    def kept(self) -> bool | None:
        """True if the interval keeps its data sheet limits, False if not; None without a minimum or maximum."""
        found = [bound.kept(self.ps, self.ps) for bound in self.bounds]
        return None if all(kept is None for kept in found) else False not in found

    @property
    def symbol(self) -> str:
        """The data sheet symbol of the interval, such as "t14"; "t" if the interval has none."""
        return next((bound.limit.symbol for bound in self.bounds if bound.limit.symbol), "t")

    def __str__(self) -> str:
        limits = "; ".join(str(bound) for bound in self.bounds)
        verdict = "" if self.kept is None else ": met" if self.kept else ": VIOLATED"
        return f"{self.symbol} = {duration(self.ps)}" + (f" ({limits}{verdict})" if limits else "")


@dataclass(frozen=True, slots=True)
class Checked:
    """A time limit of a chip, and the measured times to which it applies.

    Attributes:
        chip: the name of the chip.
        bound: the limit, as in the data sheet.
        count: the number of measured times.
        shortest_ps: the shortest measured time, ps; None if there is none.
        longest_ps: the longest measured time, ps; None if there is none.
        violations: the instants at which the intervals that violate the limit begin, ps.
        missing: the pin that was not recorded; "" if none is missing.
        doubt_ps: the uncertainty of the times, ps: for a measured recording, its sampling period.  A time
            counts as a violation only if it violates the limit by more than this.
    """

    chip: str
    bound: Bound
    count: int = 0
    shortest_ps: int | None = None
    longest_ps: int | None = None
    violations: tuple[int, ...] = ()
    missing: str = ""
    doubt_ps: int = 0

    @classmethod
    def of(
        cls, chip: str, bound: Bound, begins: NDArray[np.int64], ends: NDArray[np.int64], doubt_ps: int = 0
    ) -> Checked:
        """Return the check of a limit on intervals with starts `begins` and ends `ends`: (m,) int64 ps each."""
        if not len(begins):
            return cls(chip, bound)
        lasts = ends - begins
        wrong = lasts + doubt_ps <= bound.least if bound.least is not None and doubt_ps else lasts < (bound.least or 0)
        if bound.most is not None:
            wrong |= lasts - doubt_ps > bound.most
        violations = tuple(begins[wrong].tolist())
        return cls(chip, bound, len(lasts), int(lasts.min()), int(lasts.max()), violations, doubt_ps=doubt_ps)

    @property
    def name(self) -> str:
        """The name of the chip, followed by the data sheet symbol of the limit, if it has one."""
        return f"{self.chip} {self.bound.limit.symbol}".rstrip()

    @property
    def kept(self) -> bool | None:
        """True if the limit was met, False if not; None if nothing was measured or the limit is only typical."""
        if self.shortest_ps is None or self.longest_ps is None:
            return None
        sure = self.bound.kept(self.shortest_ps, self.longest_ps)
        return sure if sure is None or not self.doubt_ps else not self.violations

    @property
    def doubtful(self) -> bool:
        """True if the limit counts as met, but may have been violated within the uncertainty of the times."""
        return bool(
            self.kept
            and self.doubt_ps
            and not self.bound.kept((self.shortest_ps or 0) - self.doubt_ps, (self.longest_ps or 0) + self.doubt_ps)
        )

    @property
    def verdict(self) -> str:
        """The result as text: met, violated, only typical, not seen, or not recorded."""
        if self.missing:
            return f"{self.missing} not recorded"
        if not self.count:
            return "not seen"
        if self.kept is None:
            return "typical"
        if self.kept:
            return f"met, within {duration(self.doubt_ps)}" if self.doubtful else "met"
        times = f"{len(self.violations)} times, first" if len(self.violations) > 1 else "once,"
        return f"VIOLATED {times} at {duration(self.violations[0])}, by the {self.bound.limit.keeper}"


HEADS = ("", "time", "data sheet", "count", "shortest", "longest", "")  # of a table


class TimingTable(Sequence[Checked]):
    """The time limits in the data sheets of some chips, each with its measured times; `print` shows a table."""

    def __init__(self, rows: Iterable[Checked]) -> None:
        self.rows = tuple(rows)

    @property
    def violated(self) -> tuple[Checked, ...]:
        """The rows of the limits that were violated."""
        return tuple(row for row in self.rows if row.kept is False)

    def __getitem__(self, key):  # type: ignore[no-untyped-def]
        return self.rows[key]

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        return f"<TimingTable: {len(self)} limits, {len(self.violated)} violated>"

    def _repr_html_(self) -> str:
        """Return the notebook view of the table: the limits for which times were measured."""
        return card(repr(self)[1:-1], table(HEADS, [_cells(row) for row in self.rows if row.count], right=(3, 4, 5)))

    def __str__(self) -> str:
        lines = [HEADS, *(_cells(row) for row in self.rows if row.count)]
        shown = aligned(lines, left=(0, 1, 2, 6))
        others: dict[str, list[str]] = {}
        for row in self.rows:
            if not row.count:
                others.setdefault(row.verdict, []).append(f"{row.name} {row.bound.limit.description}")
        shown += [fill(f"{why}: {'; '.join(names)}", 100, subsequent_indent="  ") for why, names in others.items()]
        return "\n".join(shown)


def _cells(row: Checked) -> tuple[str, ...]:
    limit = row.bound.limit
    measured = ("" if ps is None else duration(ps) for ps in (row.shortest_ps, row.longest_ps))
    return (
        row.name,
        limit.description,
        str(row.bound),
        str(row.count),
        *measured,
        row.verdict,
    )
