"""The trace of one pin in a picture, taken from a recorded pin or from a signal in a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from . import outlines
from .recorder import FLOATING, Probe, Recorder, net_of, width_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .recorder import Levels

EVER = 1 << 62


@dataclass(frozen=True, slots=True)
class Trace:
    """The edges of one pin or bus, as returned by Recorder.edges, and the level before the first edge.

    A bus is shown by its bytes.

    Args:
        since, until: the known part, ps; nothing is drawn before or after it.
        tolerance_ps: the tolerance, ps: where a measured trace and the model's trace differ for no longer
            than this, the difference is not marked.
        over: the measured trace of the same pin, which is drawn over this trace, with the
            differences marked; None if there is none.
    """

    name: str
    times_ps: NDArray[np.int64]
    levels: Levels
    level: int
    bus: bool = False
    since: int = -EVER
    until: int = EVER
    tolerance_ps: int = 0
    over: Trace | None = None

    def __repr__(self) -> str:
        over = f", over it {self.over!r}" if self.over else ""
        return f"<Trace {self.name}: {len(self.times_ps)} changes{over}>"

    @classmethod
    def of(cls, name: str, probe: Probe, recorder: Recorder, start: int, stop: int, over: Trace | None = None) -> Trace:
        """Return the trace of a recorded net or pin in a window (ps): as many of its edges as a picture needs.

        If another trace is drawn over it, all edges are included, since any of them may differ.
        """
        since, until = max(start, recorder.since(probe)), min(stop, net_of(probe).kernel.seen)
        edges = recorder.edges(probe, since + 1, stop) if over else outlines.edges(recorder, probe, start, stop)
        level, bus = recorder.level(probe, since), width_of(probe) > 1
        return cls(name, *edges, level, bus, since, until, over=over)

    def shifted(self, by: int) -> Trace:
        """Return the trace delayed by `by` ps."""
        over = self.over.shifted(by) if self.over else None
        return replace(self, times_ps=self.times_ps + by, since=self.since + by, until=self.until + by, over=over)

    def within(self, start: int, stop: int) -> Trace:
        """Return the trace with only its edges in start < t <= stop (ps).

        This is for a trace from a file, which has all edges of the file.
        """
        import numpy as np

        first, last = np.searchsorted(self.times_ps, (start, stop), side="right").tolist()
        level = int(self.levels[first - 1]) if first else self.level
        return replace(self, times_ps=self.times_ps[first:last], levels=self.levels[first:last], level=level)

    def levels_at(self, times_ps: Sequence[int]) -> list[int]:
        """Return the levels at some instants (ps), after any edges there; FLOATING outside the known part."""
        import numpy as np

        at = np.array(times_ps, np.int64)
        levels = np.append(self.level, self.levels)[np.searchsorted(self.times_ps, at, side="right")]
        found: list[int] = np.where((self.since <= at) & (at <= self.until), levels, FLOATING).tolist()
        return found
