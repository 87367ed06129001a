"""Parts that a clock steps: they count its edges, and promise what follows from the count.

    clock       train --------------------------------->| another one ------>
    direction   high ------------------|  low --------------------------------
                                       cut: so many steps by now; lay: from here on each edge counts the other way

A step that a train promises is no event.  The part is brought up to an instant when an input is driven otherwise or
when somebody asks; what it promises from there on follows from what the inputs show.

An input that says what a step does (`steers`) may have edges ahead itself.  The clock is then followed up to the first
of them, and anew from there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from ...core.wires.clocking import ClockEdges, Limited, Still, clock_edges
from ...core.wires.wave import Level
from .follower import Follower

if TYPE_CHECKING:
    from ...core.time.kernel import Call, Kernel
    from ...core.wires.wave import Promise


class Clocked(Follower):
    """A part that makes a step at each fall, or each rise, of a clock."""

    clock: ClassVar[str]  # the pin
    steers: ClassVar[tuple[str, ...]] = ()  # the pins that say what a step does
    acts: ClassVar[tuple[str, ...]] = ()  # those of them that act without a step, too
    edge = 0  # the level of the clock with which a step begins

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self._level: Level = None  # of the clock, up to where the part has come
        self._begun = False
        self._ahead = Limited(Still())  # the clock that is followed
        self._again: Call | None = None  # looks at what steers, when that has an edge

    # ------------------------------------------------------------------------------------- what a kind of part says
    def advance_to(self, ps: int) -> None:
        """Take up what the clock has done up to an instant; after that it does nothing any more until `follow`."""
        raise NotImplementedError

    def stepped(self) -> None:
        """Take the edge of the clock at this instant, which nobody promised."""
        raise NotImplementedError

    def follow(self, clock: ClockEdges) -> None:
        """Take up a clock from this instant on, and promise what follows."""
        raise NotImplementedError

    # ------------------------------------------------------------------------------------------------------- changes
    def cut(self, ps: int) -> None:
        """Take notice of what the inputs have shown up to an instant (ps): they cannot be asked again."""
        if self._begun:
            self._level = self.outlooks[self.clock].level(ps)
            self._ahead.cut(ps)
            self.advance_to(ps)

    def lay(self) -> None:
        """Promise what the outputs show from now on."""
        self._advance()
        self.follow(self._look_ahead())

    def go_by_edges(self) -> None:
        """Follow the inputs edge by edge from now on."""
        if not self._laying:
            self.cut(self.kernel.seen)
        super().go_by_edges()

    def react(self) -> None:
        """Drive the outputs to the levels that follow from those of the inputs."""
        self.advance_to(self.kernel.seen)
        self._advance()
        self.follow(Still())

    def _advance(self) -> None:
        """Look at the clock: is there an edge between what was up to now, and what is now?"""
        level = self.pins[self.clock].net.level
        if self._begun and level == self.edge != self._level:
            self.stepped()
        self._level, self._begun = level, True

    def _look_ahead(self) -> ClockEdges:
        """The clock from this instant on, up to the first edge of what steers."""
        now = self.kernel.now
        if self._again is not None:
            self._again.token += 1  # it is not called any more
            self._again = None
        clock = clock_edges(self.outlooks[self.clock].shown(), self.edge, now)
        names = self.acts if isinstance(clock, Still) else self.steers
        times = [time for name in names if (time := self.outlooks[name].after(now)) is not None]
        if times:
            self._again = self.kernel.call_at(min(times), self.look)
        if isinstance(clock, Still):
            return clock
        self._ahead = Limited(clock, min(times, default=None))
        return self._ahead

    def look(self) -> None:
        """Look at the inputs again: something changes at this instant of which no driver tells."""
        if self.edge_driven:
            self.react()
        else:
            self.changed()

    @property
    def due(self) -> bool:
        """Has the clock an edge of which the part hears in the next round only?"""
        return self._laying and self.pins[self.clock].net.level == self.edge != self._level

    def shown(self, name: str) -> Promise | Level:
        """Return what an input shows from now on: a promise, or a level."""
        return self.pins[name].net.level if self.edge_driven else self.outlooks[name].shown()
