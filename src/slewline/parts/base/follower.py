"""Rules for parts that compute ahead of time: they derive the promises of outputs from those of inputs.

    input     train ---------------------------->| (a driver gets a new value)
    output    view of the train ---------------->|........|  view of the new value
                                       changed:  cut      schedule: in the next round

While its inputs are promised, such a part takes no computing time; its outputs take none either, unless
they are observed.  When a driver of an input is about to get a new promise or level, the part is notified
while the old promise is still in place.  The part then processes its inputs up to the last visible
instant (`cut`), and bounds the promises of its outputs, so that no later edge of the old promise becomes
visible.  In the next round the part reads the inputs, and promises its outputs again (`schedule`).

Parts that follow each other in a circle without a chip between them (two crossed gates, a ring
oscillator) cannot promise anything to each other.  Such circles are found after wiring; their parts
follow the inputs edge by edge, and drive levels (`react`).

A part that has a rule makes its pins, passes the functions of its logic to the rule, and starts the rule
once the part is wired.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

from ...core.wires.views import View
from ...core.wires.wave import Level, Promise, alike, promised
from .lookahead import Lookahead

if TYPE_CHECKING:
    from ...core.wires.net import Driver, Net
    from .part import Part


def ignored(_ps: int) -> None:
    """Do nothing: parts whose past inputs have no effect use this as their `cut`."""


class Follower:
    """A rule that computes the promised waveforms of all outputs of a part from the waveforms of some of its inputs.

    Args:
        part: the part, with its pins.
        inputs: the names of the input pins.
        schedule: a function that promises the outputs from this instant on, given the current inputs.
        react: a function that drives the outputs to levels when an input has changed, if the part is in a loop.
        cut: a function that processes the inputs up to an instant (ps), before their promises are replaced.
        delay_ps: the delay from the inputs to the outputs, ps.

    Attributes:
        lookaheads: the `Lookahead` of each input, by the name of the input.

    Raises:
        UnknownName: the part has no pin with the name of an input; the message lists the part's pins.
    """

    def __init__(
        self,
        part: Part,
        inputs: Iterable[str],
        *,
        schedule: Callable[[], None],
        react: Callable[[], None],
        cut: Callable[[int], None] = ignored,
        delay_ps: int = 0,
    ) -> None:
        self.part, self.kernel, self.inputs = part, part.kernel, tuple(inputs)
        self.schedule, self.react, self.cut, self.delay_ps = schedule, react, cut, delay_ps
        self.lookaheads: dict[str, Lookahead] = {}
        self.edge_driven = False  # part of a circle: inputs are observed, outputs driven by levels
        self.withdrawn = True  # an input has changed since the last `schedule`; if False, only bounds have moved
        self.scheduling = False  # `schedule` is due in the next round
        self._drivers_seen = -1  # wiring state of the inputs when circles were last searched
        for name in self.inputs:
            part.pin(name)
        for driver in part.drivers.values():
            driver.source = self

    def start(self) -> None:
        """Start to follow the inputs, now that the part is wired."""
        if self.edge_driven:
            return
        self.lookaheads = {name: Lookahead(self.part.pins[name], self.changed) for name in self.inputs}
        self._schedule_next()

    @property
    def is_started(self) -> bool:
        """True while the rule follows its inputs, or if it has no inputs."""
        return bool(self.lookaheads) or not self.inputs

    def sources(self) -> Iterable[Follower]:
        """Yield the rule of each part that drives an input of this rule."""
        for name in self.inputs:
            for driver in self.part.pins[name].net.drivers:
                if isinstance(driver.source, Follower):
                    yield driver.source

    def shown(self, name: str) -> Promise | Level:
        """Return the present and future state of an input: a promised waveform, or a constant level."""
        net = self.part.pins[name].net
        if self.edge_driven:
            return net.level
        return self.lookaheads[name].shown() if name in self.lookaheads else net.shown()

    # ------------------------------------------------------------------------------------------------------- changes
    def changed(self) -> None:
        """Prepare for a change of an input, just before its level, its promise or the promise's end changes."""
        if not (self.withdrawn or any(lookahead.renewed for lookahead in self.lookaheads.values())):
            self.withdrawn = True
            self.bound_outputs(self.kernel.seen + 1)
        if not self.scheduling:
            self.scheduling = True
            self.cut(self.kernel.seen)
            self.kernel.call_at(self.kernel.now, self._schedule_next)

    def bound_outputs(self, ps: int) -> None:
        """Limit the output promises, because the promises of the inputs may no longer hold from `ps` on.

        The output promises end `delay_ps` after `ps`.
        """
        for driver in self.part.drivers.values():
            if isinstance(driver.promise, View):
                driver.promise.until = ps + self.delay_ps

    def _schedule_next(self) -> None:
        self.scheduling = False
        drivers = sum(len(lookahead.pin.net.drivers) for lookahead in self.lookaheads.values())
        if drivers != self._drivers_seen:
            self._drivers_seen = drivers
            for rule in circle(self):
                rule.go_by_edges()
        if not self.edge_driven:
            self.schedule()
            self.withdrawn = False

    def put(self, driver: Driver, shown: Promise | Level) -> None:
        """Set the promise or level of an output from now on; setting the same level again has no effect."""
        if promised(shown) or driver.promise is not None or driver.pending or driver.level != shown:
            driver.drive(shown)

    def go_by_edges(self) -> None:
        """Follow the inputs edge by edge from now on, and drive levels instead of promises."""
        self.edge_driven = True
        for lookahead in self.lookaheads.values():
            lookahead.close()
        for name in self.inputs:
            self.part.pins[name].net.watch(self._reacted)
        self.react()

    def _reacted(self, _net: Net) -> None:
        self.react()


class HasRule(Protocol):
    """A part with a rule."""

    @property
    def rule(self) -> Follower:
        """The part's rule, which computes its outputs ahead of time."""


def start_rule(self: HasRule) -> None:
    """Start the rule, now that the part is wired; a part with no other preparation uses this as its `rewired`."""
    self.rule.start()


class Stateless(Follower):
    """A rule without delay or memory, such as that of a gate.

    Args:
        part: the part, with its pins.
        inputs: the names of the input pins.
        views: for each output, by its name, a function that returns the output's promised waveform or level; it is
            called with the list of the waveforms or levels of the inputs, in the order of `inputs`.
    """

    def __init__(
        self,
        part: Part,
        inputs: Iterable[str],
        views: Mapping[str, Callable[[Sequence[Promise | Level]], Promise | Level]],
    ) -> None:
        super().__init__(part, inputs, schedule=self._promise, react=self._drive)
        self._views = [(part.drivers[output], view) for output, view in views.items()]
        self._shown: list[Promise | Level] = []  # bounded by the inputs that the outputs depend on

    def _promise(self) -> None:
        """Promise the outputs from now on."""
        inputs = [lookahead.shown() for lookahead in self.lookaheads.values()]
        same = len(inputs) == len(self._shown) and all(map(alike, inputs, self._shown))
        self._shown = inputs
        for driver, view in self._views:
            if self.withdrawn or not same:
                self.put(driver, view(inputs))
            elif driver.promise is not None:
                driver.renew()

    def _drive(self) -> None:
        """Drive the outputs to the levels that follow from the input levels."""
        levels = [self.part.pins[name].level for name in self.inputs]
        for driver, view in self._views:
            driver.drive(view(levels))


def circle(rule: Follower) -> list[Follower]:
    """Return the rules of all parts that form circles with the part of `rule`; empty if there is no circle.

    The result includes `rule`.  A part that already follows its inputs edge by edge promises nothing, so it
    does not count as part of a circle.
    """
    driven: dict[Follower, list[Follower]] = {}  # rules downstream of each rule, among all rules upstream of this one
    ahead = [rule]
    while ahead:
        follower = ahead.pop()
        for source in follower.sources():
            if not source.edge_driven:
                if source not in driven:
                    driven[source] = []
                    ahead.append(source)
                driven[source].append(follower)
    found: list[Follower] = []
    ahead = [rule] if rule in driven else []
    while ahead:
        here = ahead.pop()
        if here not in found:
            found.append(here)
            ahead += [follower for follower in driven.get(here, ()) if follower in driven]
    return found
