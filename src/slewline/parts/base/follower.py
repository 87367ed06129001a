"""Parts that run ahead: what they promise on their outputs follows from what is promised on their inputs.

    input     train ---------------------------->| (a driver is told something else)
    output    view of the train ---------------->|........|  view of what comes now
                                       changed:  cut      lay: in the next round

As long as the inputs promise, such a part costs nothing, and its outputs cost what they cost anywhere: nothing while
nobody looks.  When a driver of an input is told something else, the part hears of it at once, before that driver
forgets: it takes notice of what the inputs have shown up to the instant before (`cut`), and its outputs are bounded, so
that no edge shows of what was withdrawn.  In the next round it looks at the inputs anew and promises again (`lay`).

Parts that follow each other in a circle without a chip between them (two crossed gates, a ring oscillator) cannot
promise anything to each other.  They are found when they are wired; from then on they watch their inputs and drive
levels, edge by edge (`react`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from ...core.wires.net import Driver, Net
from ...core.wires.views import View
from ...core.wires.wave import Level, Promise, alike, promised
from .outlook import Outlook
from .part import Part

if TYPE_CHECKING:
    from ...core.datasheet.table import Way
    from ...core.time.kernel import Kernel
    from ...core.wires.pin import Terminal


class Follower(Part):
    """A part that runs ahead.  Subclasses name their inputs, and say what they promise in `lay`."""

    follows: tuple[str, ...] = ()
    edge_driven = False  # part of a circle: inputs are watched, outputs driven by levels

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.outlooks: dict[str, Outlook] = {}
        self.withdrawn = True  # an input shows something else since the last `lay`; else only bounds have moved
        self._laying = False  # `lay` is due in the next round
        self._drivers_seen = -1  # of the inputs, when circles were looked for

    def add_pin(self, name: str, way: Way, says: str, **how: Any) -> Terminal:
        """Make a pin, as `Part.add_pin`; an output promises what follows from the inputs."""
        terminal = super().add_pin(name, way, says, **how)
        if name in self.drivers:
            self.drivers[name].source = self
        return terminal

    def rewired(self) -> None:
        """Look ahead along the inputs from now on."""
        if self.edge_driven:
            return
        self.outlooks = {name: Outlook(self.pins[name], self.changed) for name in self.follows}
        self._lay()

    # ------------------------------------------------------------------------------------- what a kind of part says
    def cut(self, ps: int) -> None:
        """Take notice of what the inputs have shown up to an instant: they will not be there to be asked again."""

    def lay(self) -> None:
        """Promise the outputs anew, from this instant on, under the present inputs."""
        raise NotImplementedError

    def react(self) -> None:
        """Drive the outputs to levels: an input of a part in a circle has changed."""
        raise NotImplementedError

    def sources(self) -> Iterable[Follower]:
        """Yield the parts that run ahead and drive the inputs of this one."""
        for name in self.follows:
            for driver in self.pins[name].net.drivers:
                if isinstance(driver.source, Follower):
                    yield driver.source

    # ------------------------------------------------------------------------------------------------------- changes
    def changed(self) -> None:
        """Take notice that an input is about to be driven otherwise, or that the bound of what it promises moves."""
        if not (self.withdrawn or any(outlook.renewed for outlook in self.outlooks.values())):
            self.withdrawn = True
            self.bound_outputs(self.kernel.seen + 1)
        if not self._laying:
            self._laying = True
            self.cut(self.kernel.seen)
            self.kernel.call_at(self.kernel.now, self._lay)

    def bound_outputs(self, ps: int) -> None:
        """Bound the promises of the outputs: nothing shows of what they say from an instant on."""
        for driver in self.drivers.values():
            if isinstance(driver.promise, View):
                driver.promise.until = ps

    def _lay(self) -> None:
        self._laying = False
        drivers = sum(len(outlook.pin.net.drivers) for outlook in self.outlooks.values())
        if drivers != self._drivers_seen:
            self._drivers_seen = drivers
            for part in circle(self):
                part.go_by_edges()
        if not self.edge_driven:
            self.lay()
            self.withdrawn = False

    def put(self, driver: Driver, shown: Promise | Level) -> None:
        """Let an output show something from now on; what it shows already costs nothing."""
        if promised(shown) or driver.promise is not None or driver.pending or driver.level != shown:
            driver.drive(shown)

    def go_by_edges(self) -> None:
        """Follow the inputs edge by edge from now on."""
        self.edge_driven = True
        for outlook in self.outlooks.values():
            outlook.close()
        for name in self.follows:
            self.pins[name].net.watch(self._reacted)
        self.react()

    def _reacted(self, _net: Net) -> None:
        self.react()


class Stateless(Follower):
    """A part without delay and memory: what its outputs show follows from what its inputs show."""

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self._inputs: list[Promise | Level] = []  # of which the outputs promise something

    def view(self, pin: str, inputs: Sequence[Promise | Level]) -> Promise | Level:
        """Return what an output shows while the inputs, in the order of `follows`, show promises or levels."""
        raise NotImplementedError

    def lay(self) -> None:
        """Promise what the outputs show from now on."""
        inputs = [outlook.shown() for outlook in self.outlooks.values()]
        same = len(inputs) == len(self._inputs) and all(map(alike, inputs, self._inputs))
        self._inputs = inputs
        for pin, driver in self.drivers.items():
            if self.withdrawn or not same:
                self.put(driver, self.view(pin, inputs))
            elif driver.promise is not None:
                driver.renew()

    def react(self) -> None:
        """Drive the outputs to the levels that follow from those of the inputs."""
        levels = [self.pins[name].level for name in self.follows]
        for pin, driver in self.drivers.items():
            driver.drive(self.view(pin, levels))


def circle(part: Follower) -> list[Follower]:
    """Return the parts on circles through a part, itself among them; none where there is no circle.

    Whoever is driven by edges already promises nothing, so a circle ends there.
    """
    driven: dict[Follower, list[Follower]] = {}  # the parts behind a part, of all that are in front of this one
    ahead = [part]
    while ahead:
        behind = ahead.pop()
        for source in behind.sources():
            if not source.edge_driven:
                if source not in driven:
                    driven[source] = []
                    ahead.append(source)
                driven[source].append(behind)
    found: list[Follower] = []
    ahead = [part] if part in driven else []
    while ahead:
        here = ahead.pop()
        if here not in found:
            found.append(here)
            ahead += [behind for behind in driven.get(here, ()) if behind in driven]
    return found
