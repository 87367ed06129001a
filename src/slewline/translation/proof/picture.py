"""A picture of a proof: velocity and position of source and result, overlaid."""

from __future__ import annotations

from ...core.motion.quantity import Position, Velocity
from ...record.pictures.figures import Contents, description_of, figure
from ...record.pictures.picture_files import save
from ...record.pictures.tracks import Track
from .play import Played
from .prove import Proof

MARGIN_PS = 10**9


def draw(proof: Proof, path: str, names: tuple[str, str]) -> None:
    """Draw both runs overlaid, with time 0 at the first motion of each.

    Args:
        path: the file, SVG, PNG or PDF.
        names: the names of source and result.
    """
    runs = [(name, run) for name, run in zip(names, (proof.source, proof.result), strict=True) if run is not None]
    tracks = [track(name, run) for name, run in runs]
    stop = max(ends(run) - begins(run) for _, run in runs) + MARGIN_PS
    contents = Contents(" and ".join(names), tracks, [], 0, stop, marks=False, zero_is="the first motion of each")
    picture = figure(contents)
    save(picture, path, contents.title, description_of(picture))


def track(name: str, run: Played) -> Track:
    """Return the motion of axis 1 in a run as a track of the picture; `name` is the name of the track."""
    axis = run.chip.axis(1)
    motor, motions = axis.motor, axis.motions()
    return Track(name, [Velocity(motor), Position(motor)], motions, zero=begins(run), until=run.bench.now_ps)


def begins(run: Played) -> int:
    """Return the time at which the first motion of a run begins, ps; 0 if there is no motion."""
    return min((motion.time_ps for motion in run.chip.motions()), default=0)


def ends(run: Played) -> int:
    """Return the time at which the last motion of a run ends, ps; the end of the run if no motion ends."""
    ends = [motion.end.time_ps for motion in run.chip.motions() if motion.end is not None]
    return max(ends, default=run.bench.now_ps)
