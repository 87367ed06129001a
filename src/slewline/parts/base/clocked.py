"""The rule of clocked parts: they count clock edges, and promise outputs that follow from the count.

    clock       train --------------------------------->| another train ---->
    direction   high ------------------|  low --------------------------------
                                       cut: count the steps so far; schedule: later edges count in the other direction

A promised step is not an event.  The state of the part is brought up to an instant only when an input is driven at
that instant, or on request; the promises of the part after that instant follow from the inputs.

An input that decides the effect of a step (`steers`) may have promised edges, too.  The clock is then followed up to
the first of these edges, and from there up to the next one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from ...core.time.events import Events, NoEvents, Until, earliest
from ...core.wires.clocking import clock_edges
from ...core.wires.wave import Level
from ...errors import UnknownName
from .follower import Follower

if TYPE_CHECKING:
    from ...core.time.kernel import Call
    from .part import Part


class Clocked(Follower):
    """A rule that acts at each falling, or each rising, edge of a clock.

    Args:
        part: the part, with its pins.
        inputs: the names of the input pins, the clock included.
        clock: the name of the clock pin.
        edge: the active edge: 0 falling, 1 rising.
        steers: the names of the pins that decide the effect of a clock edge.
        acts: the names of those steering pins that also act while the clock has no edges.
        advance: a function that processes the edges of the clock up to an instant (ps); after that, the part
            treats the clock as stopped until `follow` is called.
        step: a function that handles a clock edge that occurs now and was not promised.
        follow: a function that receives the promised clock edges from now on, and promises the outputs.

    Raises:
        UnknownName: the clock is not one of the inputs, or the part has no pin with the name of an input.
    """

    def __init__(
        self,
        part: Part,
        inputs: Iterable[str],
        *,
        clock: str,
        edge: int = 0,
        steers: tuple[str, ...] = (),
        acts: tuple[str, ...] = (),
        advance: Callable[[int], None],
        step: Callable[[], None],
        follow: Callable[[Events], None],
    ) -> None:
        super().__init__(part, inputs, schedule=self._promise, react=self._take_edge, cut=self._cut)
        if clock not in self.inputs:
            raise UnknownName(
                f"{part.name}: clock {clock!r} is not an input of the rule; allowed: {', '.join(self.inputs)}"
            )
        self.clock, self.edge, self.steers, self.acts = clock, edge, steers, acts
        self.advance, self.step, self.follow = advance, step, follow
        self._level: Level = None  # of the clock, up to the instant that the part has processed
        self._begun = False
        self._ahead = Until(NoEvents())  # the clock that is followed
        self._again: Call | None = None  # samples the steering pins at their next edge

    def _cut(self, ps: int) -> None:
        """Process the clock edges up to an instant (ps)."""
        if self._begun:
            self._level = self.lookaheads[self.clock].level(ps)
            self._ahead.cut(ps)
            self.advance(ps)

    def _promise(self) -> None:
        """Promise the outputs from now on."""
        self._sample_clock()
        self.follow(self._look_ahead())

    def go_by_edges(self) -> None:
        if not self.scheduling:
            self._cut(self.kernel.seen)
        super().go_by_edges()

    def _take_edge(self) -> None:
        """Process an input edge, and drive the outputs to the resulting levels."""
        self.advance(self.kernel.seen)
        self._sample_clock()
        self.follow(NoEvents())

    def _sample_clock(self) -> None:
        """Process a clock edge, if the clock has gone to its active level since it was last sampled."""
        level = self.part.pins[self.clock].net.level
        if self._begun and level == self.edge != self._level:
            self.step()
        self._level, self._begun = level, True

    def _look_ahead(self) -> Events:
        """Return the clock edges from now on, up to the first promised edge of a steering pin.

        The method `look` is called at the instant of that edge.
        """
        now = self.kernel.now
        if self._again is not None:
            self._again.token += 1  # it is not called any more
            self._again = None
        clock = clock_edges(self.lookaheads[self.clock].shown(), self.edge, now)
        names = self.acts if isinstance(clock, NoEvents) else self.steers
        first = earliest([self.lookaheads[name].after(now) for name in names])
        if first is not None:
            self._again = self.kernel.call_at(first, self.look)
        if isinstance(clock, NoEvents):
            return clock
        self._ahead = Until(clock, first)
        return self._ahead

    def look(self) -> None:
        """Read the inputs again; called at an instant that no driver reports, such as that of a promised edge."""
        if self.edge_driven:
            self.react()
        else:
            self.changed()

    @property
    def due(self) -> bool:
        """True if the clock has had an active edge that the part will process only in the next round."""
        return self.scheduling and self.part.pins[self.clock].net.level == self.edge != self._level
