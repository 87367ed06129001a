"""The future levels of the wire on a pin: the promises of its drivers.

    Lookahead(pin, changed)

        shown()   train ------------------>|  another train ---------------->
                                           ^ changed(): immediately, before the driver drops its promise

`shown()` returns the present and future state of the wire as one promise or level.  If a part's own
promises follow from this state, the part bounds them when `changed` is called, and calls `shown()`
again in the next round.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...core.time.events import When
from ...core.wires.pin import Terminal
from ...core.wires.wave import Level, Promise, alike, promised


class Lookahead:
    """The promised future of the wire on a pin.

    Args:
        pin: the pin; wiring may still merge its net with another net.
        changed: called in every round in which a driver of the wire replaces its promise, before the driver does so;
            during the call, inputs can be read up to the instant before now, and `renewed` is valid.
    """

    __slots__ = ("_levels", "_shown", "changed", "pin")

    def __init__(self, pin: Terminal, changed: Callable[[], object]) -> None:
        self.pin, self.changed = pin, changed
        self._levels: list[Any] | None = None
        self._shown: Promise | Level = None
        pin.net.sample(changed)

    def close(self) -> None:
        """Stop calling `changed`."""
        self.pin.net.unwatch_before(self.changed)

    @property
    def renewed(self) -> bool:
        """True if earlier promises remain true and only their bounds have moved; valid while `changed` is called."""
        return self.pin.net.root.renewed

    def shown(self) -> Promise | Level:
        """Return the promise or level of the wire from now on: the object last returned, if nothing has changed."""
        net = self.pin.net
        levels = [net.tie, net.pull, *(d.level if d.promise is None else d.promise for d in net.active)]
        if self._levels is None or len(levels) != len(self._levels) or not all(map(alike, levels, self._levels)):
            self._levels, self._shown = levels, net.shown()
        return self._shown

    def level(self, ps: int) -> Level:
        """Return the level at a committed, present or future instant (ps)."""
        return shown.level(ps) if promised(shown := self.shown()) else shown

    def after(self, ps: int) -> When:
        """Return the time (ps) of the next edge later than `ps`, NotYet, or None, as `Promise.after` does."""
        return shown.after(ps) if promised(shown := self.shown()) else None

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges in start < t <= stop (ps): two lists, or two arrays (int64 ps, int8 levels)."""
        return shown.edges(start, stop) if promised(shown := self.shown()) else ([], [])
