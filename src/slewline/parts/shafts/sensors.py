"""Sensors on a shaft: the rule that encoders and switches share, and a switch.

position     ----[##########]----        closed from `low` to below `high`
             --[--##########--]--        once closed, opens only `hysteresis` further out
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from ...core.datasheet.option import Option
from ...core.time.timebase import Time, picoseconds
from ...errors import UsageError
from ..base.follower import Follower, ignored, start_rule
from ..base.part import Part
from .shaft_counter import Counter, CountScale
from .shown import SwitchZone

if TYPE_CHECKING:
    from ...core.datasheet.table import Pin
    from ...core.time.kernel import Kernel
    from .shaft import Shaft

ROLES = (
    "home",
    "end",
    "end_plus",
    "end_minus",
    "abort",
    "input1",
    "input2",
    "input3",
)  # roles of the inputs that a switch is wired to


class Sensor(Follower):
    """The rule by which the outputs of a part that is mounted on a shaft follow the counts of the shaft.

    Args:
        part: the part, with its pins.
        shaft: the shaft, which is followed from `start` on; `start` is called before time passes.
        scale: counts per step, or the positions at which the count changes.
        lag_ps: the delay from the shaft to the outputs, ps.
        show: a function that is called at each new motion; it computes the future levels of the outputs from
            `counter`.
        cut: a function that is called with the instant (ps) at which a motion ends; it processes the counts
            up to this instant, before `counter` is replaced.

    Attributes:
        counter: the counts of the present motion of the shaft.
    """

    def __init__(
        self,
        part: Part,
        shaft: Shaft,
        scale: CountScale,
        lag_ps: int,
        *,
        show: Callable[[], None],
        cut: Callable[[int], None] = ignored,
    ) -> None:
        super().__init__(part, (), schedule=show, react=_later, cut=cut)
        self.shaft = shaft
        self.counter: Counter = shaft.counter(scale, lag_ps)

    def start(self) -> None:
        """Follow the shaft from now on."""
        self.counter = self.shaft.counter(self.counter.scale, self.counter.lag_ps)
        self.shaft.on_cut.add(self._consume)
        self.shaft.on_turn.add(self._turned)
        self.schedule()

    def sources(self) -> Iterable[Follower]:
        """Return the `Follower` of the part that turns the shaft, in a list; empty if that part has none."""
        source = self.shaft.source
        return [source] if isinstance(source, Follower) else []

    def _consume(self, ps: int) -> None:
        counter = self.counter.onward(ps)
        if counter is not self.counter:  # otherwise the past levels remain known
            self.cut(ps)
            self.counter = counter

    def _turned(self) -> None:
        counter = self.counter.on(self.shaft.motion, self.kernel.now)
        lasts = counter is self.counter  # the promises of the outputs remain valid if nothing depends on the change
        self.counter = counter
        if not lasts or any(driver.watched or driver.promise is None for driver in self.part.drivers.values()):
            self.schedule()


def _later() -> None:
    """Do nothing at an edge that turns the shaft, because the outputs change later than that edge."""


class Switch(Part):
    """A switch on a shaft or a carriage, closed between two positions.

    It is a contact or an open collector: when closed, it pulls `out` to its active level; when open, it
    releases `out`, so several switches may share a wire.

    Args:
        on: the part on whose shaft the switch is mounted.
        role: the role of the neighbour's input that the option `to` connects with `out`: "home", "end"
            (either end of travel), "end_plus", "end_minus" ...
        axis: the neighbour's axis.
        low: the lowest position at which the switch is closed, in steps; None: no limit in this direction.
        high: the lowest position above `low` at which the switch is open again, in steps; None: no limit in
            this direction.
        hysteresis: the number of steps beyond these positions at which the closed switch opens.
        lag: the time from the step that operates the switch to the edge of `out`, more than 0.
        active: the level of `out` while the switch is closed; None: the active level of the neighbour's
            input, or 0 if that input has none.
    """

    _for_users = ("closed",)
    wiring = MappingProxyType({"out": "home"})
    sits: ClassVar[Literal["", "may", "must"]] = "must"
    options = (
        Option("role", "choice", "home", "role of the input to which `to` wires the switch", choices=ROLES),
        Option("axis", "int", 1, "axis of the neighbour", low=1, high=4),
        Option(
            "low",
            "float",
            None,
            "lowest position at which the switch is closed; None: no limit",
            unit="steps",
            none=True,
        ),
        Option(
            "high",
            "float",
            None,
            "lowest position above `low` at which the switch is open again; None: no limit",
            unit="steps",
            none=True,
        ),
        Option(
            "hysteresis", "float", 0, "distance beyond these positions at which the switch opens", low=0, unit="steps"
        ),
        Option("lag", "time", "1 us", "delay from a step to the edge", low=1),
        Option(
            "active",
            "choice",
            None,
            "level while closed; None: the active level of the input",
            choices=(0, 1),
            none=True,
        ),
    )
    rewired = start_rule

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        *,
        on: Shaft,
        role: str = "home",
        axis: int = 1,
        low: float | None = None,
        high: float | None = None,
        hysteresis: float = 0,
        lag: Time = "1 us",
        active: int | None = None,
    ) -> None:
        super().__init__(kernel, name)
        if (low is None and high is None) or (low is not None and high is not None and low >= high):
            raise UsageError(
                f"{name}: closed from low={low} to high={high}; low must be below high, and only one of them "
                "may be None"
            )
        self.axis, self.wiring = axis, MappingProxyType({"out": role})
        self._low, self._high = low, high
        self._active = active
        self._levels: tuple[int | None, int | None] = (None, active or 0)
        scale, self._zones = zone(fraction_or_none(low), fraction_or_none(high), fraction(hysteresis))
        self.add_pin("out", "out", "at its active level while closed", pull=1 - (active or 0), role=role, active=active)
        self._since = on.motion.since  # of the counter
        self._closed = False  # while the position alone does not determine the state
        self.rule = Sensor(self, on, scale, picoseconds(lag), show=self._promise, cut=self._cut)
        self._promise()

    def attached(self, own: str, row: Pin) -> None:
        """Use the active level of the neighbour's input, unless the user has set `active`."""
        if self._active is None and row.active == 1:
            self._active, self._levels = 1, (None, 1)
            net = self.pins[own].net
            for one in net.root.joined or (net,):
                one.pull = 0
            self._promise()

    @property
    def closed(self) -> bool:
        """True while the switch is closed."""
        return self._zone.closed_at(self.kernel.seen)

    def shows(self) -> dict[str, Any]:
        """Return whether the switch is closed, its bounds in steps, and the name of the part that turns its shaft."""
        source = getattr(self.rule.shaft.source, "name", None)
        return {"closed": self.closed, "low": self._low, "high": self._high, "on": source}

    def _cut(self, ps: int) -> None:
        """Record the state of the switch at an instant (ps)."""
        self._closed = self._zone.closed_at(ps)
        self._since = ps

    def _promise(self) -> None:
        """Promise the level of `out` from now on, for the present motion of the shaft."""
        self._zone = SwitchZone(self.rule.counter, self._since, self._closed, self._zones, self._levels)
        self.drivers["out"].play(self._zone)


def zone(
    low: Fraction | None, high: Fraction | None, hysteresis: Fraction
) -> tuple[CountScale, tuple[bool | None, ...]]:
    """Return a switch's bounds, and its states below, between and above the bounds.

    State n applies where n of the bounds are at or below the position.  A state is closed (True),
    open (False), or unchanged (None).
    """
    bounds: list[tuple[Fraction, bool | None]] = []
    if low is not None:
        bounds += [(low - hysteresis, None)] * bool(hysteresis) + [(low, True)]
    if high is not None:
        bounds += [(high, None)] * bool(hysteresis) + [(high + hysteresis, False)]
    return CountScale(bounds=tuple(bound for bound, _ in bounds)), (low is None, *(closed for _, closed in bounds))


def fraction(value: float) -> Fraction:
    """Return the exact fraction of a number as written: 0.1 becomes 1/10."""
    return Fraction(str(value))


def fraction_or_none(value: float | None) -> Fraction | None:
    """Return the exact fraction of a number as written, or None if the number is None."""
    return None if value is None else fraction(value)
