"""The past and foreseen motion of a motor: grid points, computed on demand.

    past           now                    foreseen
    grid points -->|- - - - - - - - - ->|           integrated so far: `reached`
                   |- - -x                          an input changes unexpectedly: the future is integrated again

Nothing is integrated before it is queried.  The past never changes.  The foreseen points after the first
unforeseen edge are dropped.  Old points are dropped, too, except one per stretch; the dropped points can
be computed again, bit for bit.
"""

from __future__ import annotations

from bisect import bisect_right
from typing import TYPE_CHECKING, Any, NamedTuple

from ..motors.integration import Integration, Point
from ..motors.law import MotorLaw
from .feed import Edges, Feed, changes

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Mapping

STRETCH = 4096  # grid points
WHOLE = 64  # stretches whose points are kept
NEVER_PS = 1 << 62
AT_ONCE_PS = 20_000_000_000  # how far a single query for rest looks ahead


class Stretch:
    """Consecutive grid points computed with one law, starting at `first`.

    Attributes:
        changed: None if `first` continues the preceding stretch; otherwise the values of the states that
            were changed externally, by name (empty if only the law was changed).
        columns: times, states, commands and codes of the points, as in a `MotorTrace`; None: the points have
            been dropped.
    """

    def __init__(self, law: MotorLaw, first: Point, changed: Mapping[str, float] | None = None) -> None:
        self.law, self.first, self.changed = law, first, changed
        self.columns: tuple[Any, ...] | None = columns_of(first)
        self.last = first
        self._edges: Edges | None = None  # set once the stretch is complete

    @property
    def count(self) -> int:
        """Number of points."""
        return len(self.whole[0])

    @property
    def whole(self) -> tuple[Any, ...]:
        """Columns of the points: times, states, commands, codes."""
        if self.columns is None and self._edges is not None:
            trace = Integration(self.law).trace(*self._edges[:], self.last.t, self.first)
            self.columns = trace.times, trace.states, trace.commands, trace.codes
        return self.columns or ()

    def point(self, n: int) -> Point:
        """Return point n."""
        times, states, commands, codes = self.whole
        return Point(int(times[n]), tuple(states[n].tolist()), int(commands[n]), int(codes[n]))

    def extend(self, more: tuple[Any, ...]) -> None:
        """Append points, given as columns."""
        import numpy as np

        self.columns = tuple(np.concatenate(pair) for pair in zip(self.whole, more, strict=True))
        self.last = self.point(-1)

    def edges(self, after: int) -> Edges:
        """Return the input edges after an instant (ps), each of which is at a grid point."""
        times, _, commands, codes = self.whole
        changed = changes(commands, commands[0]) | changes(codes, codes[0])
        changed &= times > after
        return Edges(times[changed], commands[changed], codes[changed])

    def cut(self, before: int) -> None:
        """Drop the points at or after an instant (ps), except the first point."""
        count = max(int(self.whole[0].searchsorted(before)), 1)
        self.columns = tuple(column[:count] for column in self.whole)
        self.last = self.point(-1)
        self._edges = None

    def drop(self) -> None:
        """Drop the points, which can be computed again."""
        if self.columns is not None:
            self._edges = self.edges(self.first.t)
            self.columns = None


def columns_of(point: Point) -> tuple[Any, ...]:
    """Return a grid point as columns of length 1."""
    import numpy as np

    ints = [np.array([value], np.int64) for value in (point.t, point.command, point.code)]
    return ints[0], np.array([point.state], np.float64), ints[1], ints[2]


class RunPart(NamedTuple):
    """Consecutive grid points computed with one law: columns times, states, commands, codes.

    `changed`: True if the first point does not continue the preceding points, because the law or the state
    was changed externally.
    """

    law: MotorLaw
    columns: tuple[Any, ...]
    changed: bool


class Run:
    """The motion of a rotor.

    The functions in `cuts` are called with an instant (ps) when the foreseen future from that instant on is
    dropped.  `along` holds results derived from the run, such as `Passings`, keyed by the arguments from
    which they were made.

    Args:
        law: the law of motor, driver and load; `alter` can replace it.
        feed: the inputs.
        first: the starting point.
        engine: "python", "numba", or None, as in `Integration`.
    """

    def __init__(self, law: MotorLaw, feed: Feed, first: Point, engine: str | None = None) -> None:
        self.feed = feed
        self.cuts: list[Callable[[int], object]] = []
        self.along: dict[Hashable, Any] = {}
        self._engine = engine
        self.begin(law, first)

    def begin(self, law: MotorLaw, first: Point) -> None:
        """Restart with another law and another first point, before the motion has been used by any part.

        `first` has the same rotor position as the old start.
        """
        self.stretches = [Stretch(law, first)]
        self.reached = first.t  # the instant up to which it is integrated
        self._integration = Integration(law, self._engine)
        self._rests = False  # at the last point nothing changes until the next edge
        for cut in self.cuts:
            cut(first.t)

    @property
    def compiled(self) -> bool:
        """True if the engine is "numba": all functions are then compiled before simulated time passes."""
        return self._engine == "numba"

    @property
    def law(self) -> MotorLaw:
        """The present law."""
        return self.stretches[-1].law

    # ------------------------------------------------------------------------------------------------------- the points
    def reach(self, ps: int) -> None:
        """Integrate up to an instant (ps)."""
        while self.reached < ps:
            self._go_on(min(ps, self._stays() if self._rests else self.reached + STRETCH * self.law.step_ps))

    def _stays(self) -> int:
        """Return the instant (ps) up to which to integrate next while the rotor rests.

        This is the next instant at which an input may change.  If the motion has only been integrated up to an
        instant before the present inputs begin, it is a fixed time after that instant instead.
        """
        now = self.feed.now
        if self.reached < now.since:
            return self.reached + AT_ONCE_PS
        following = now.look_after(self.reached)
        return NEVER_PS if following is None else following

    def _go_on(self, ps: int) -> None:
        """Integrate up to an instant (ps) in one call of the integrator."""
        stretch = self.stretches[-1]
        last = stretch.last
        edges = self.feed.edges(max(last.t, self.reached), ps, last.command, last.code)
        if not (self._rests and not len(edges.times)):
            if stretch.count >= STRETCH:
                stretch = Stretch(stretch.law, last)
                self.stretches.append(stretch)
                self._drop_old()
            trace = self._integration.trace(edges.times, edges.commands, edges.codes, ps, last)
            self._rests = trace.rests
            if len(trace.times) > 1:
                stretch.extend((trace.times[1:], trace.states[1:], trace.commands[1:], trace.codes[1:]))
        self.reached = ps

    def _drop_old(self) -> None:
        if len(self.stretches) > WHOLE:
            self.stretches[-1 - WHOLE].drop()

    def follow(self, seen: int) -> None:
        """Use the present inputs; drop the future from the first edge after `seen` (ps) that is not as foreseen."""
        if self.reached <= seen:
            return
        n = len(self.stretches) - 1
        while n and self.stretches[n].first.t > seen:
            n -= 1
        before = self.at_or_before(seen)
        now = self.feed.edges(seen, self.reached, before.command, before.code)
        foreseen = [stretch.edges(seen) for stretch in self.stretches[n:]]
        differs = first_difference(now, Edges(*map(joined, zip(*foreseen, strict=True))))
        if differs is not None:
            altered = [it for it in self.stretches[n:] if it.changed is not None and it.first.t == differs]
            self._cut(differs, differs)
            for stretch in altered:  # at this instant, too: the change is applied after the inputs
                self.alter(differs, stretch.law, **(stretch.changed or {}))

    def _cut(self, ps: int, since: int) -> None:
        """Drop the points at or after an instant (ps), and call the functions in `cuts` with `since` (ps).

        `since` is the first instant at which the new motion differs from the dropped one.
        """
        while len(self.stretches) > 1 and self.stretches[-1].first.t >= ps:
            self.stretches.pop()
        self.stretches[-1].cut(ps)
        self.reached, self._rests = ps - 1, False
        for cut in self.cuts:
            cut(since)

    def alter(self, ps: int, law: MotorLaw, **states: float) -> None:
        """Continue after an instant (ps) with another law, or with other values of some states."""
        self.reach(ps)
        point, state = self.at_or_before(ps), self.state(ps)
        self._cut(ps + 1, ps)
        given = dict(zip(self.stretches[-1].law.names, state, strict=True)) | states
        first = Point(ps, tuple(given.get(name, 0.0) for name in law.names), point.command, point.code)
        if law is not self.law:
            self._integration = Integration(law, self._engine)
        self.stretches.append(Stretch(law, first, states))
        self.reached = ps

    # ---------------------------------------------------------------------------------------------------------- queries
    def stretch_at(self, ps: int) -> Stretch:
        """Return the stretch that contains an instant (ps), which has been reached."""
        n = bisect_right(self.stretches, ps, key=lambda stretch: stretch.first.t) - 1
        return self.stretches[max(n, 0)]

    def at_or_before(self, ps: int) -> Point:
        """Return the last grid point at or before an instant (ps); if none is kept, the first kept point."""
        self.reach(ps)
        stretch = self.stretch_at(ps)
        return stretch.point(max(int(stretch.whole[0].searchsorted(ps, "right")) - 1, 0))

    def state(self, ps: int) -> tuple[float, ...]:
        """Return the state at an instant (ps)."""
        point, law = self.at_or_before(ps), self.stretch_at(ps).law
        return law.after(point.t, point.state, point.code, ps - point.t) if ps > point.t else point.state

    def between(self, start: int, stop: int) -> list[RunPart]:
        """Return the grid points at start < t <= stop (ps)."""
        self.reach(stop)
        found = []
        n = max(bisect_right(self.stretches, start, key=lambda stretch: stretch.first.t) - 1, 0)
        for stretch in self.stretches[n:]:
            if stretch.first.t > stop:
                break
            times = stretch.whole[0]
            part = slice(int(times.searchsorted(start, "right")), int(times.searchsorted(stop, "right")))
            changed = part.start == 0 and stretch.changed is not None
            if part.start == 0 and not changed:
                part = slice(1, part.stop)  # its first point is the last point of the preceding stretch
            if part.stop > part.start:
                found.append(RunPart(stretch.law, tuple(column[part] for column in stretch.whole), changed))
        return found

    def rests(self, ps: int) -> bool:
        """Return whether nothing changes from an instant (ps) until the next input edge."""
        self.reach(ps)
        return self._rests and ps >= self.stretches[-1].last.t

    def comes_to_rest(self, ps: int) -> int:
        """Return the instant (ps), later than a given one, at which the motor will rest if no input changes.

        If this is not known, return an instant at which to query again.
        """
        following = self.feed.now.look_after(ps)
        until = ps + AT_ONCE_PS if following is None else max(min(ps + AT_ONCE_PS, following), ps + 1)
        return max(self.known_to_rest, ps + 1) if self.rests(until) else until

    @property
    def known_to_rest(self) -> int:
        """The first instant (ps) that is more than a grid step after the last point.

        If no further point follows by then, the rotor is at rest, and its lost steps can be counted.
        """
        return self.stretches[-1].last.t + self.law.step_ps + 1

    def forget(self, before: int) -> None:
        """Drop the past before an instant (ps), except inputs that have not been integrated yet."""
        before = min(before, self.reached)
        for known in self.along.values():
            known.forget(before)
        n = bisect_right(self.stretches, before, key=lambda stretch: stretch.first.t) - 1
        del self.stretches[: max(n, 0)]
        self.feed.forget(min(before, self.stretches[0].first.t))


def joined(columns: Any) -> Any:
    """Return arrays joined into one."""
    import numpy as np

    return np.concatenate(columns)


def first_difference(one: Edges, two: Edges) -> int | None:
    """Return the first instant (ps) at which two sequences of edges differ; None if they are equal."""
    count = min(len(one.times), len(two.times))
    differ = (
        (one.times[:count] != two.times[:count])
        | (one.commands[:count] != two.commands[:count])
        | (one.codes[:count] != two.codes[:count])
    )
    if differ.any():
        n = int(differ.argmax())
        return int(min(one.times[n], two.times[n]))
    longer = max(one, two, key=lambda edges: len(edges.times))
    return int(longer.times[count]) if len(longer.times) > count else None
