"""The motions of an axis for a picture: a track, and the curves of its quantities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ...core.motion.deviation import Deviation
from ...core.motion.ideal_motion import Ideal
from ...core.motion.motions import Mark, MotionStart
from ...core.motion.quantity import Outline, Quantity
from ..style import TimeAxis


@dataclass(frozen=True, slots=True)
class Track:
    """The motions of one axis, or the activity of a part, in one run.

    Args:
        quantities: the quantities to draw, one panel each.
        motions: the motions in the window, with the rates that were in force.
        marks: events, including findings.
        phases: stretches, each with its start and end (ps) and its label.
        ideals: the unquantized motions, drawn over the real ones, each with the deviation of the real motion
            from it.
        zero: the instant of the run that is 0 in the picture, ps.
        since, until: the first and the last known instant of the run, ps.
        over: True if the track was measured, and is drawn over the other tracks.
        words: the meanings of parameters, keyed by parameter name; a parameter whose name already states its
            meaning is left out.
        part: True if the track belongs to a part rather than an axis; the heading of its panel then names
            the part, unless the panel is shared.
    """

    name: str
    quantities: Sequence[Quantity]
    motions: Sequence[MotionStart] = ()
    marks: Sequence[Mark] = ()
    phases: Sequence[tuple[int, int, str]] = ()
    ideals: Sequence[tuple[Ideal, Deviation]] = ()
    zero: int = 0
    since: int = 0
    until: int = 1 << 62
    over: bool = False
    part: bool = False
    words: Mapping[str, str] = field(default_factory=dict)

    def called(self, rate: str) -> str:
        """Return a rate's name, followed by its parameter's meaning if `words` includes it: "R = 80 (rate)"."""
        parameter, _, value = rate.partition(" = ")
        return f"{rate} ({self.words[parameter]})" if value and parameter in self.words else rate

    def rates(self) -> list[tuple[int, Mapping[str, float]]]:
        """Return all sets of rates that were in force, each with the instant (ps) from which it was in force."""
        return [each for motion in self.motions for each in ((motion.time_ps, motion.rates), *motion.changes)]

    def window(self, axis: TimeAxis) -> tuple[int, int]:
        """Return the start and end (ps) of the known part of a picture's window, in the time of this run."""
        start = max(axis.start + self.zero, self.since)
        return start, max(min(axis.stop + self.zero, self.until), start)


@dataclass(frozen=True, slots=True)
class TrackCurve:
    """A quantity of a track in a picture; the `number` of the track determines colour and line style."""

    number: int
    track: Track
    quantity: Quantity
    outline: Outline

    @property
    def ends(self) -> tuple[float, float]:
        """The lowest and the highest value; (0, 0) if there is no value.

        The first `rest_before()` points are left out.
        """
        import numpy as np

        values = self.outline.values[self.rest_before() :]
        values = values[~np.isnan(values)]
        return (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)

    @property
    def reach(self) -> tuple[float, float]:
        """The lowest and the highest value, extended to zero if pictures of the quantity include zero."""
        low, high = self.ends
        return (min(low, 0.0), max(high, 0.0)) if self.from_zero else (low, high)

    def rest_before(self) -> int:
        """Return the number of points before the register is first loaded; 0 if the axis moves before that.

        Before the first load, a register may have any value.  That value must not set the scale of the
        picture, which could flatten the curve of the motion.
        """
        import numpy as np

        breaks = np.flatnonzero(np.isnan(self.outline.values))
        return int(breaks[0]) + 1 if len(breaks) and breaks[0] == 1 and len(self.outline.values) > 3 else 0

    @property
    def from_zero(self) -> bool:
        """True if pictures of the quantity include zero."""
        return self.quantity.from_zero
