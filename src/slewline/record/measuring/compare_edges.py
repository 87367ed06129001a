"""Two recordings of one signal, the model's and a measured one: which edges match, and how far apart.

    model      ‾‾‾|_____|‾‾‾‾‾|_____|‾‾‾‾‾|_____|‾‾‾‾‾|_____
    measured   ‾‾‾|_____|‾‾‾‾‾‾|_____|‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾|_____
    edge          0     1     2      3     4     5     6        2 is late, 4 and 5 are missing

Pairs are formed in order.  Two edges to the same level are a pair, unless one of them fits better with a
later edge of the other signal, two places further on.  It fits better if the delay would then be closer
to that of the previous pair.  So a clock that is slightly fast or slow, as every real clock is, does not
cause wrong pairs.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from ...core.messages.calls import answering
from ...core.time.timebase import Time, moment, readable
from ...errors import TimeError, UsageError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Edges: TypeAlias = tuple[NDArray[np.int64], NDArray[Any]]

NEVER = 1 << 62
FEW, MANY = 64, 1 << 16  # pairs that are tried at a time
PATTERN, ALIKE = 24, 3  # edges whose distances are compared, and number of matching places that are tried
CANDIDATES, PROBED = 12, 400  # edges that may be the first pair, and edges that judge it
MAX_DRIFT = 1e-3  # between two clocks: crystals have a tenth of it, resonators half
ENOUGH = 10  # pairs that show that a drift is not chance
SHOWN = 10  # rows of a text
BECOMES = {-2: "becomes unknown", -1: "floats", 0: "falls", 1: "rises"}


class Difference(NamedTuple):
    """An edge at which model and measurement differ.

    Attributes:
        kind: how the measured signal differs: "missing", "extra", "late" or "early".
        edge: the index of the edge, from 0, in the model; for an extra edge, in the measured signal.
        time_ps: the instant of the edge on the time axis of the model, ps.
        level: the level after the edge.
        late_ps: the delay of the measured edge, ps, negative if earlier; 0 for a missing or extra edge.
    """

    kind: str
    edge: int
    time_ps: int
    level: int
    late_ps: int

    def __str__(self) -> str:
        begin = f"edge {self.edge} ({BECOMES.get(self.level, f'becomes {self.level:02X}')}) at {readable(self.time_ps)}"
        return f"{begin} is {readable(abs(self.late_ps)) + ' ' if self.late_ps else ''}{self.kind}"


@dataclass(frozen=True, eq=False)
class Comparison:
    """The comparison of a measured signal with the model's; `print` shows it.

    Attributes:
        name: the name of the signal.
        model: the edges in the model: times, (n,) int64 ps, and levels, (n,).
        measured: the measured edges in the same form, with times as measured.
        shift_ps: the time that was added to the measured times for the comparison, ps.
        tolerance_ps: the greatest distance at which the two edges of a pair still agree, ps.
        pairs: the indices of the edges of each pair, (n, 2) int64: column 0 in the model, column 1 in the
            measured signal.
        within: text that states the origin of the tolerance, such as "the sampling at 12 MHz"; "" if the
            caller set it.
        notes: possible causes of differences, one per line.
    """

    name: str
    model: Edges
    measured: Edges
    shift_ps: int
    tolerance_ps: int
    pairs: NDArray[np.int64]
    within: str = ""
    notes: tuple[str, ...] = ()

    @cached_property
    def late_ps(self) -> NDArray[np.int64]:
        """The delay of the measured edge of each pair, negative if earlier: (n,) int64 ps."""
        return self.measured[0][self.pairs[:, 1]] + self.shift_ps - self.model[0][self.pairs[:, 0]]

    @cached_property
    def missing(self) -> NDArray[np.int64]:
        """The indices of the model's edges that were not measured: (m,) int64."""
        return _others(len(self.model[0]), self.pairs[:, 0])

    @cached_property
    def extra(self) -> NDArray[np.int64]:
        """The indices of the measured edges that the model does not have: (k,) int64."""
        return _others(len(self.measured[0]), self.pairs[:, 1])

    @property
    def greatest_ps(self) -> int:
        """The greatest distance between the two edges of a pair, ps; 0 without pairs."""
        return int(abs(self.late_ps).max()) if len(self.pairs) else 0

    @property
    def mean_ps(self) -> float:
        """The distance between the two edges of a pair, averaged over all pairs, ps; 0 without pairs."""
        return float(abs(self.late_ps).mean()) if len(self.pairs) else 0.0

    @property
    def drift_ppm(self) -> float:
        """The drift of the measured clock: the slope of `late_ps`, in ppm; positive if slower than the model's."""
        return 1e6 * _slope(self.model[0][self.pairs[:, 0]], self.late_ps)

    @property
    def agrees(self) -> bool:
        """True if no edge is missing, none is extra, and no pair is further apart than the tolerance."""
        return not (len(self.missing) or len(self.extra) or self.greatest_ps > self.tolerance_ps)

    @cached_property
    def rows(self) -> list[Difference]:
        """A `Difference` for every missing or extra edge and every pair outside the tolerance, ordered by time."""
        import numpy as np

        times, levels = self.model[0], self.model[1]
        found = [Difference("missing", int(n), int(times[n]), int(levels[n]), 0) for n in self.missing]
        times, levels = self.measured[0] + self.shift_ps, self.measured[1]
        found += [Difference("extra", int(n), int(times[n]), int(levels[n]), 0) for n in self.extra]
        times, levels, late = self.model[0], self.model[1], self.late_ps
        for pair in np.flatnonzero(abs(late) > self.tolerance_ps):
            n, by = int(self.pairs[pair, 0]), int(late[pair])
            found.append(Difference("late" if by > 0 else "early", n, int(times[n]), int(levels[n]), by))
        return sorted(found, key=lambda row: (row.time_ps, row.edge))

    def __repr__(self) -> str:
        return f"<Comparison {str(self).splitlines()[0]}>"

    def __str__(self) -> str:
        begin = f"{self.name}: " if self.name else ""
        counts = f"{len(self.model[0])} edges in the model, {len(self.measured[0])} measured"
        given = readable(self.tolerance_ps) if self.tolerance_ps and not self.within else ""
        within = self.within or given
        verdict = (
            f"agree{within and f' within {within}'}" if self.agrees else f"differ{given and f' (tolerance {given})'}"
        )
        lines = [f"{begin}{counts}, shifted by {readable(self.shift_ps)}: {verdict}"]
        lines += [f"  {row}" for row in self.rows[:SHOWN]]
        if len(self.rows) > SHOWN:
            kinds = [f"{sum(row.kind == kind for row in self.rows)} {kind}" for kind in ("missing", "extra")]
            lines.append(f"  and {len(self.rows) - SHOWN} more; in all {', '.join(kinds)}")
        if len(self.pairs):
            apart = f"at most {readable(self.greatest_ps)} apart, {readable(round(self.mean_ps))} on average"
            drift = f", drift {self.drift_ppm:+.1f} ppm" if len(self.pairs) >= ENOUGH else ""
            lines.append(f"  {len(self.pairs)} {'pair' if len(self.pairs) == 1 else 'pairs'}: {apart}{drift}")
        return "\n".join([*lines, *(f"  {note}" for note in self.notes)])


@answering("compare_edges()")
def compare_edges(
    model: Edges,
    measured: Edges,
    *,
    shift: Time = "first",
    tolerance: Time = 0,
    name: str = "",
    invert: bool = False,
) -> Comparison:
    """Compare the edges of a signal in the model with measured ones.

    Args:
        model, measured: times, (n,) int64 ps, ascending, and levels, (n,), as from `bench.edges` and
            `Waveforms.edges`.
        shift: the time that is added to the measured times: a time, which may be negative; "first", to make
            the first edges to the same level coincide; or "best", to make as many edges as possible
            coincide.
        tolerance: the greatest distance at which the two edges of a pair still agree.
        name: the name of the signal, for the text.
        invert: invert the measured levels first, for a signal measured after an inverting optocoupler.

    Raises:
        UsageError: `invert` for a bus, arrays of different lengths, or times that do not ascend.
        TimeError: `shift` or `tolerance` is not a time.
    """
    import numpy as np

    for what, edges in (("model", model), ("measured", measured)):
        if isinstance(edges, str) or len(edges) != 2:
            raise UsageError(f"{what} {edges!r}: expected times and levels, as returned by bench.edges(...)")
        times, levels = edges
        if len(times) != len(levels) or (np.diff(times) <= 0).any():
            raise UsageError(
                f"{what}: {len(times)} times and {len(levels)} levels; expected ascending times, and a level for each"
            )
    if invert:
        measured = measured[0], inverted(measured[1], name)
    if shift == "first":
        by = _first(model, measured)
    elif shift == "best":
        by = _best(model, measured)
    else:
        try:
            by = moment(shift, negative=True)
        except TimeError as error:
            raise TimeError(f'shift: {error}; also allowed: "first", "best"') from None
    pairs = _pairs(model, (measured[0] + by, measured[1]))
    return Comparison(name, model, measured, by, moment(tolerance), pairs)


def inverted(levels: NDArray[Any], name: str = "") -> NDArray[Any]:
    """Return levels with 0 and 1 exchanged; floating and unknown levels are unchanged.

    Raises:
        UsageError: the levels are bus levels.
    """
    import numpy as np

    if len(levels) and levels.max() > 1:
        raise UsageError(f"invert: {name or 'the signal'} is a bus; only wires can be inverted")
    return np.where(levels < 0, levels, 1 - levels).astype(levels.dtype)


def _others(count: int, paired: NDArray[np.int64]) -> NDArray[np.int64]:
    import numpy as np

    alone = np.ones(count, np.bool_)
    alone[paired] = False
    return np.flatnonzero(alone)


def _slope(at: NDArray[np.int64], what: NDArray[np.int64]) -> float:
    """Return the slope of the straight line fitted to values `what` at times `at`; 0 for fewer than two points."""
    if len(at) < 2:
        return 0.0
    x = at - at.mean()
    return float((x * (what - what.mean())).sum() / (x * x).sum())


# ------------------------------------------------------------------------------------------------------------ shifts
def _first(model: Edges, measured: Edges) -> int:
    for level, time in zip(model[1][:CANDIDATES], model[0], strict=False):
        same = (measured[1][:CANDIDATES] == level).nonzero()[0]
        if len(same):
            return int(time - measured[0][same[0]])
    return 0


def _best(model: Edges, measured: Edges) -> int:
    """Return the shift (ps), out of some candidates, that brings the most measured edges close to model edges."""
    import numpy as np

    shifts = {
        int(time - other): None
        for time, level in zip(model[0][:CANDIDATES], model[1], strict=False)
        for other, same in zip(measured[0][:CANDIDATES], measured[1], strict=False)
        if level == same
    }
    shifts |= dict.fromkeys(_alike(model, measured)) | dict.fromkeys(-shift for shift in _alike(measured, model))
    period = float(np.median(model[0][2:] - model[0][:-2])) if len(model[0]) > 2 else 1.0

    def merit(shift: int) -> float:
        begin = np.searchsorted(model[0], measured[0][0] + shift - int(period))
        since = np.searchsorted(measured[0], model[0][0] - shift - int(period))
        some = model[0][begin : begin + PROBED], model[1][begin : begin + PROBED]
        others = measured[0][since : since + PROBED], measured[1][since : since + PROBED]
        return _near(some, others, shift, period / 4)

    merits = {shift: merit(shift) for shift in shifts}
    nearly = 0.95 * max(merits.values(), default=0.0)
    nearest = [shift for shift, found in merits.items() if found >= nearly]  # a plateau is the same everywhere
    return max(nearest, key=lambda shift: _near(model, measured, shift, period / 4), default=0)


def _near(model: Edges, measured: Edges, shift: int, reach: float) -> float:
    """Return the number of measured edges close to a model edge, each weighted by its closeness.

    The weight falls linearly from 1 for edges that coincide, after the shift (ps), to 0 for edges `reach`
    (ps) apart.
    """
    import numpy as np

    count = 0.0
    for level in np.unique(model[1][:PROBED]):
        times = np.concatenate([[-NEVER], model[0][model[1] == level], [NEVER]])
        others = measured[0][measured[1] == level] + shift
        after = np.searchsorted(times, others)
        distance = np.minimum(times[after] - others, others - times[after - 1])
        count += float(np.maximum(1 - distance / reach, 0).sum())
    return count


def _alike(long: Edges, short: Edges) -> list[int]:
    """Return shifts (ps) that make the first edges of `short` match consecutive edges somewhere in `long`."""
    import numpy as np

    shifts: list[int] = []
    for begin in range(0, min(CANDIDATES, len(short[0]) - 1), 3):  # the very first edges may be glitches
        rest = len(short[0]) - begin
        for length in {min(rest, PATTERN), rest}:  # a few edges close together, or some of all
            count = len(long[0]) - length + 1
            if count < 1:
                continue
            places = np.unique(np.linspace(0, length - 1, PATTERN).astype(np.int64))
            by = long[0][:count] - short[0][begin]
            apart = np.zeros(count)
            for place in places[1:]:
                apart += abs(long[0][place : place + count] - short[0][begin + place] - by)
            apart[long[1][:count] != short[1][begin]] = np.inf
            nearest = np.argsort(apart, kind="stable")[:ALIKE]
            shifts += [int(by[n]) for n in nearest if apart[n] < np.inf]
    return shifts


# ------------------------------------------------------------------------------------------------------------- pairs
def _pairs(model: Edges, measured: Edges) -> NDArray[np.int64]:
    """Return the indices of the edges of each pair, (n, 2) int64: in the model, and in the measured signal."""
    import numpy as np

    count = min(len(model[0]), len(measured[0]))
    runs = _runs(model, measured)
    paired = sum(length for _, _, length in runs)
    if paired < count and np.array_equal(model[1], measured[1]) and _drift_alone(model[0], measured[0]):
        runs = [(0, 0, count)]
    first = [np.arange(a, a + length) for a, _, length in runs]
    second = [np.arange(b, b + length) for _, b, length in runs]
    empty = np.empty(0, np.int64)
    return np.stack([np.concatenate([empty, *first]), np.concatenate([empty, *second])], axis=1)


def _drift_alone(model: NDArray[np.int64], measured: NDArray[np.int64]) -> bool:
    """Return whether two edge sequences of equal length differ only by the drift of a clock.

    Over a long pause, such a drift can add up to more than the time between two edges.
    """
    import numpy as np

    if len(model) < 3:
        return True
    late, slope = measured - model, _slope(model, measured - model)
    left = late - late.mean() - slope * (model - model.mean())
    most = max(abs(left).max(), abs(late[0]))
    return bool(abs(slope) < MAX_DRIFT and 2 * most < np.min(model[2:] - model[:-2]))


def _runs(model: Edges, measured: Edges) -> list[tuple[int, int, int]]:
    """Return runs of consecutive pairs: for each, the indices of its first pair, and its number of pairs."""
    import numpy as np

    ends = np.array([NEVER, NEVER])
    columns = [np.append(times, ends) for times, _ in (model, measured)]
    columns += [np.append(levels.astype(np.int64), ends) for _, levels in (model, measured)]
    runs: list[tuple[int, int, int]] = []
    a = b = late = 0
    size = FEW
    while (length := min(size, len(model[0]) - a, len(measured[0]) - b)) > 0:
        fits = _fits(columns, a, b, length, late)
        paired = length if fits.all() else int(np.argmin(fits))
        if paired:
            runs.append((a, b, paired))
            a, b = a + paired, b + paired
            late = int(columns[1][b - 1] - columns[0][a - 1])
        if paired == length:
            size = min(4 * size, MANY)
        elif columns[0][a] + late <= columns[1][b]:
            a, size = a + 1, FEW
        else:
            b, size = b + 1, FEW
    return runs


def _fits(columns: list[NDArray[np.int64]], a: int, b: int, length: int, late: int) -> NDArray[np.bool_]:
    """Return which edges pair up, from index `a` in the model and `b` in the measured signal: (length,) bool.

    Each element is valid only if all elements before it are True.  `late` is the delay (ps) of the pair of
    edges that precedes these edges.
    """
    import numpy as np

    def cut(which: int, begin: int) -> NDArray[np.int64]:
        return columns[which][begin : begin + length]

    times, others, levels, same = cut(0, a), cut(1, b), cut(2, a), cut(3, b)
    apart = others - times
    expected = np.append(late, apart[:-1])
    distance = abs(apart - expected)
    nearer = (cut(3, b + 2) == levels) & (abs(cut(1, b + 2) - times - expected) < distance)
    nearer |= (cut(2, a + 2) == same) & (abs(others - cut(0, a + 2) - expected) < distance)
    fits: NDArray[np.bool_] = (levels == same) & ~nearer
    return fits
