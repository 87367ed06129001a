"""Cycles of an axis as a plot shows them: in steps and seconds, phases of S-curves as spans."""

from __future__ import annotations

from itertools import pairwise

from ..core.chip import AxisInCycles
from ..core.cycles import ONE
from ..record.profiles import Profile


def profile_of(axis: AxisInCycles, start: int, stop: int) -> Profile:
    """What an axis did in the cycles of a window (ps)."""
    import numpy as np

    cycles = axis.cycles(start, stop)
    speeds = cycles.velocities / ONE * cycles.per_second
    accelerations = np.diff(speeds, prepend=speeds[:1]) * cycles.per_second
    jerks = np.diff(accelerations, prepend=accelerations[:1]) * cycles.per_second
    changes = [0, *(np.flatnonzero(np.diff(cycles.phases)) + 1).tolist(), len(cycles)]
    spans = [
        (int(cycles.times_ps[a]), int(cycles.times_ps[b]) if b < len(cycles) else stop, str(cycles.phases[a]))
        for a, b in pairwise(changes)
        if b > a and cycles.phases[a]
    ]
    return Profile(axis.name, cycles.times_ps, speeds, cycles.targets / ONE, accelerations, jerks, spans)
