"""When an axis moves, as the window of a picture wants to know it."""

from __future__ import annotations

from ...core.motion.one_axis import OneAxis


def moving_from_to(axis: OneAxis, start: int, stop: int) -> tuple[int, int] | None:
    """Return the first and the last instant of a window at which an axis moves; None: it makes no step there."""
    played = [(train, a, b) for _, train, a, b in axis.motor.played(start, stop)]
    if not played:
        return None
    train, a, _ = played[0]
    begin = max(train.clock.ps(train.begin(a) if a else train.origin), start)
    train, _, b = played[-1]
    last = train.clock.ps(train.begin(b - 1))
    times, values = axis.quantities()[0].outline(last, stop, 100)
    rests = times[values == 0]
    return begin, int(rests[0]) if len(rests) else stop


def first_step(axis: OneAxis, stop: int) -> int | None:
    """Return the instant (ps) of the first step of an axis; None: it makes no step."""
    return next((train.clock.ps(train.begin(a)) for _, train, a, _ in axis.motor.played(0, stop)), None)
