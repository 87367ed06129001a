"""A lazy reader of a wire: on demand, it obtains past edges from the promises of the wire's drivers.

A promise contains a driver's future edges.  A chip that samples an input only occasionally need not
process every edge: a query reads the edges since the last query from the promises, and just before a
driver replaces its promise or its level, the reader reads the edges up to then.  So an edge needs no
kernel event, whatever drives the net, and no edge is lost:

    drive       promise of a train       |  level 0    |  wave
    wire        _|‾|_|‾|_|‾|_|‾|_|‾|_|‾|_|_____________|‾‾‾‾‾‾|__
    read                   ^ query       ^ replaced    ^ replaced   ^ query

Rules of this file: edges after the last committed instant are not read, only forecast (`coming`); a
level that begins and ends at the same instant is not seen.
"""

from __future__ import annotations

from itertools import compress
from operator import ne
from typing import Any

from ....core.time.hook import Hook
from ....core.wires.net import Level
from ....core.wires.pin import Terminal


class PinEdges:
    """The edges of a pin's wire after the last `begin`.

    A level change at the instant of `begin` is not an edge; it only determines the first level.
    `on_change` is called when a driver of the wire changes its level or its promise; the new edges can be
    read in the kernel's next round.
    """

    def __init__(self, pin: Terminal) -> None:
        self.pin = pin  # wiring may still join its net with another
        self.on_change: Hook[[]] = Hook()
        self.begin()
        pin.net.sample(self._before_change)

    def begin(self) -> None:
        """Discard all edges up to and including the present instant."""
        self._read = self.pin.net.kernel.now  # up to and including this instant
        self._changed: int | None = self._read  # a drive that began at this instant has not been read
        self._first = True
        self.first: Level = None
        self._level: Level = None
        self._edges: list[tuple[Any, Any]] = []

    def edges_until(self, ps: int) -> tuple[Any, Any]:
        """Return the edges since the last query, up to an instant (ps) no later than the last committed one.

        Returns:
            Edge times (ps), and the level after each edge: two lists, or two arrays if a promise gave arrays.
        """
        self._catch_up(ps)
        edges, self._edges = self._edges, []
        if len(edges) == 1:
            return edges[0]
        if any(not isinstance(times, list) for times, _ in edges):
            import numpy as np

            return np.concatenate([times for times, _ in edges]), np.concatenate([levels for _, levels in edges])
        return [ps for times, _ in edges for ps in times], [level for _, levels in edges for level in levels]

    def coming(self, ps: int) -> tuple[Any, Any, Level] | None:
        """Return the edges promised after the last query, up to a future instant (ps); None if it is too soon.

        It is too soon while the first level, the last change of a driver, or some past edges have not been read.

        Returns:
            The times of the edges (ps), the level after each, and the level at the end.
        """
        if self._first or self._changed is not None or self._edges:
            return None
        times, levels = self._real(*self.pin.net.edges_ahead(self._read, ps))
        return times, levels, levels[-1] if len(levels) else self._level

    def skip(self, ps: int, level: Level) -> None:
        """Treat the edges up to an instant (ps) as read: they occurred as promised, and the level is now `level`."""
        self._read, self._level = ps, level

    @property
    def quiet(self) -> bool:
        """True if no edge is promised after the last query: none will occur unless a driver changes."""
        return self._changed is None and self.ends_by(self._read)

    def ends_by(self, ps: int) -> bool:
        """Return whether no edge is promised after an instant (ps)."""
        promises = (driver.promise for driver in self.pin.net.active if driver.promise is not None)
        return all(promise.after(ps) is None for promise in promises)

    def _before_change(self) -> None:
        now = self.pin.net.kernel.now
        self._catch_up(now - 1)
        self._changed = now
        if self.on_change.listeners:
            self.on_change()

    def _catch_up(self, ps: int) -> None:
        """Read the promised edges up to an instant (ps), and keep them for the next query."""
        net, since = self.pin.net, self._changed
        if since is not None and since <= ps:
            self._changed = None
            level = net.resolve(since)
            if self._first:
                self._first, self.first, self._level = False, level, level
            self._keep([since], [level])
            self._read = max(self._read, since)
        if ps > self._read:
            if net.promise is not None:
                self._keep(*net.edges_ahead(self._read, ps))
            self._read = ps

    def _real(self, times: Any, levels: Any) -> tuple[Any, Any]:
        """Drop the edges that leave the level the same, if the arguments are lists; return arrays unchanged."""
        if isinstance(times, list):
            real = [*map(ne, levels, [self._level, *levels])]
            if not all(real):
                return [*compress(times, real)], [*compress(levels, real)]
        return times, levels

    def _keep(self, times: Any, levels: Any) -> None:
        times, levels = self._real(times, levels)
        if len(times) > 0:
            self._level = levels[-1]
            self._edges.append((times, levels))
