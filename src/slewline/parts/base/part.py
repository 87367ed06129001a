"""The base of every part: its name, pins and findings.  A part sees a chip only through nets.

`wiring` describes the standard wiring to a neighbour (`bench.part(..., to=...)`): for each pin of the part, the role
(core/datasheet/roles.py) of the neighbour's pin to which it is wired.  If the part has an option `axis`, this
option selects the axis to which those pins of the neighbour belong.  Pins in `optional` stay open if
no pin of the neighbour has the role.  Pins of parts have roles, too, so that a part can be wired to another part.

A user's input to a part (a text, a key) goes through a method declared by `@from_outside`, which reports it to `input`,
so that a journal can repeat it; `verbs` are the methods that a run script can call, with an integer or no argument.
`options` are the rows of the constructor's options; the constructor receives all of them, checked.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeVar

from ...core.component import Component, Finding
from ...core.datasheet.option import Option
from ...core.datasheet.table import Pin
from ...core.messages.former_names import formerly
from ...core.messages.near import hint
from ...core.motion.kept import Kept
from ...core.time.kernel import Kernel
from ...core.wires.net import Bus, Driver, Net
from ...core.wires.pin import Terminal
from ...errors import UnknownName, UsageError
from .recent import Recent

if TYPE_CHECKING:
    from ...core.datasheet.table import InOut
    from ...core.motion.quantity import Quantity
    from .request_queue import RequestQueue

T = TypeVar("T")
LEVELS = ("low", "high")
AXIS = Option(
    "axis", "int", 1, "axis of the neighbour", low=1, high=4
)  # for a part that is wired to the pins of one axis


def served(host: str, chips: Mapping[str, T], chip: object) -> T:
    """Return the object that a host keeps for one of its chips; the chip is passed by name or as an object.

    Raises:
        UnknownName: the host does not serve the chip.
    """
    name = chip if isinstance(chip, str) else getattr(chip, "name", repr(chip))
    if name not in chips:
        raise UnknownName(f"{host} has no chip {name!r}; it serves {', '.join(chips)}{hint(name, chips)}")
    return chips[name]


class Part(Component):
    """A part on a bench.  Subclasses make their pins in the constructor, and react to nets by observers or tasks.

    Attributes:
        kernel: the virtual time.
        name: the part's name on the bench.
        pins: the pins, by name.
        drivers: the drivers of the outputs, by the name of the pin.
        on_finding: hook, called with each `Finding` of this part.
        options: the options of its constructor.
        wiring: for each pin, by its name, the role of the pin to which `bench.part(to=...)` wires it.
        optional: the pins that stay open if the chip or part given as `to` has no pin with that role.
        verbs: the methods that a run script can call.
        sits: whether the part "may" or "must" be mounted on the shaft of another part (`bench.part(on=...)`); "":
            it cannot be.
        keeps: True if the part has an option `store`, which preserves its memory without power.
        queue: its request queue; None for a part without requests.
    """

    _for_users: ClassVar[tuple[str, ...]] = (
        "name",
        "pin",
        "pins",
        "findings",
        "on_finding",
        "quantities",
        "shows",
        "idle",
        "waiting",
    )
    wiring: Mapping[str, str] = MappingProxyType({})
    optional: frozenset[str] = frozenset()
    verbs: tuple[str, ...] = ()
    keeps: ClassVar[bool] = False
    sits: ClassVar[Literal["", "may", "must"]] = ""
    options: tuple[Option, ...] = ()
    queue: RequestQueue | None = None

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.pins: dict[str, Terminal] = {}
        self._catching_up = False
        self._past_kept = Kept()
        self._recent: list[Recent] = []

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}>"

    def _repr_html_(self) -> str | None:
        """Return the HTML for a notebook (the shaft with its past motion, the part's state), or None to use `repr`."""
        shows = self.shows()
        if not shows:
            return None
        from .part_card import part_card

        now, kept = self.kernel.seen, self._past_kept.ps
        places = next((each for each in self.quantities() if each.unit == "steps"), None)
        levels = {name: pin.level for name, pin in self.pins.items()}
        return part_card(repr(self)[1:-1], shows, levels, places, 0 if kept is None else max(now - kept, 0), now)

    @formerly(in_out="way", description="says")
    def add_pin(
        self,
        name: str,
        in_out: InOut,
        description: str,
        *,
        pull: int | None = None,
        initial: int | None = None,
        role: str = "",
        axis: int = 1,
        active: int | None = None,
    ) -> Terminal:
        """Make a pin, and return it.

        Args:
            name: the name of the pin.
            in_out: the direction: "in", "out" or "both".
            description: the purpose of the pin, in words.
            pull: the level of an open pin; None: it floats.
            initial: the level that an output drives from the start; None: it floats.
            role: the purpose of the pin, a word of ROLES, by which other parts are wired to it.
            axis: the axis that the role belongs to, counted from 1.
            active: the active level; None: the active level of the pin to which it is wired, if any.
        """
        row = Pin(len(self.pins) + 1, name, in_out, description, active=active, pull=pull, role=role, axis=axis)
        terminal = Terminal(self.name, row, Net(self.kernel, f"{self.name}.{name}", pull, active=active))
        self.pins[name] = terminal
        if in_out in ("out", "both"):
            driver = self.drivers[name] = Driver(terminal.net, self.name)
            if initial is not None:
                driver.drive(initial)
        return terminal

    @formerly(description="says")
    def add_bus(self, name: str, description: str, *, role: str = "") -> Terminal:
        """Make an eight-wire bus pin, and return it; its driver takes (mask, value), or None to let the bus float."""
        terminal = Terminal(
            self.name,
            Pin(len(self.pins) + 1, name, "both", description, role=role),
            Bus(self.kernel, f"{self.name}.{name}"),
        )
        self.pins[name] = terminal
        self.drivers[name] = Driver(terminal.net, self.name)
        return terminal

    def take_pin(self, name: str, inner: Terminal) -> Terminal:
        """Add a pin of the given name to this part, on the net of an inner part's pin; return the new pin."""
        terminal = self.pins[name] = Terminal(self.name, replace(inner.row, name=name), inner.net)
        return terminal

    def pin(self, name: str) -> Terminal:
        """Return a pin by its name.

        Raises:
            UnknownName: the part has no such pin; the message lists its pins.
        """
        try:
            return self.pins[name]
        except KeyError:
            message = f"{self.name} has no pin {name!r}; its pins: {', '.join(self.pins)}"
            raise UnknownName(message + hint(name, self.pins)) from None

    def net(self, name: str) -> Net:
        """Return the net of a pin."""
        return self.pins[name].net

    def high(self, name: str) -> bool:
        """Return whether a pin reads high; an open input reads high, as in TTL."""
        return bool(self.pins[name].net.level != 0)

    def byte(self, name: str) -> int:
        """Return the byte on a bus pin, 0 to 255."""
        return self.pins[name].net.byte  # type: ignore[attr-defined,no-any-return]

    # -------------------------------------------------------------------------------------------------- information
    def quantities(self) -> tuple[Quantity, ...]:
        """Return the quantities of the part, such as an angle, a current or a count; () if it has none."""
        return ()

    def shows(self) -> dict[str, Any]:
        """Return the part's state, except its pins, as plain data (shaft angle, display text); {} if none."""
        return {}

    def catch_up(self) -> None:
        """Compute motion and findings up to the last committed instant, in a part that computes them only on demand.

        Each new finding carries the instant of its cause, but its listeners are called now.
        """

    def leave(self) -> None:
        """Write unsaved data to disk, because no more time will pass, at least for now."""

    def forget(self, before: int) -> None:
        """Drop the values that the part's quantities had before an instant (ps)."""

    def keep_recent(self, what: bytearray | list[Any]) -> Recent:
        """Keep only the recent elements of a list or bytearray that grows at its end.

        `Bench(keep=)` determines which elements are recent.

        Returns:
            A `Recent`, which also counts the dropped elements.
        """
        recent = Recent(what)
        self._recent.append(recent)
        return recent

    @property
    def findings(self) -> list[Finding]:
        """All findings about the part so far, in order of time; the part catches up first."""
        self.be_caught_up()
        return self._findings

    def be_caught_up(self) -> None:
        """Call `catch_up` unless it is already running: it calls listeners, and these may query the findings."""
        if not self._catching_up:
            self._catching_up = True
            try:
                self.catch_up()
            finally:
                self._catching_up = False

    def objection(self, own: str, row: Pin) -> str:
        """Return the reason why a pin of this part cannot be wired to a pin with the right role; "" if it can.

        Args:
            own: the name of the pin of this part.
            row: the data sheet row of the pin with the right role.
        """
        wanted, found = self.pins[own].row.sense, row.sense
        if wanted is None or found is None or wanted == found:
            return ""
        return f"is active {LEVELS[found]}, and {own} is active {LEVELS[wanted]}: use bench.wire(..., invert=True)"

    def attached(self, own: str, row: Pin) -> None:
        """Record that `bench.part(to=...)` has wired a pin of this part to another pin; the default does nothing.

        Args:
            own: the name of the pin of this part.
            row: the data sheet row of the other pin, which is active at the level `row.active`.
        """

    def rewired(self) -> None:
        """Start to follow the pins; called once, after wiring and just before time passes; subclasses override it.

        Raises:
            UsageError: the part has a rule that has not been started, because its class does not override this method.
        """
        if not getattr(vars(self).get("rule"), "is_started", True):
            raise UsageError(f"{self.name}: the rule has not been started. Call self.rule.start() in rewired().")

    @property
    def idle(self) -> bool:
        """True while the part will change nothing until an input changes."""
        return self.queue is None or not self.queue.requests  # queried after every instant of a run

    @property
    def waiting(self) -> str:
        """Event or condition that the part waits for, in words."""
        return f"{self.name}: nothing to do" if self.queue is None else self.queue.waiting


def forget_all(part: Part, before: int) -> None:
    """Drop all data that a part keeps from before an instant (ps); the part catches up first."""
    part.be_caught_up()
    part.forget(before)
    for recent in part._recent:
        recent.forget(before, part.kernel.now)


def limit_kept(part: Part, ps: int | None) -> None:
    """Let a part keep only the last `ps` picoseconds of its past, or all of its past if `ps` is None."""
    part._past_kept.limit(part.name, ps)


def check_kept(part: Part, start: int) -> None:
    """Check that the past of a part is kept from the instant `start` (ps) on.

    Raises:
        NotRecorded: the past is not kept that far back.
    """
    kept = part._past_kept
    if kept.ps is not None and start < (since := part.kernel.seen - kept.ps):
        raise kept.refusal(start, since)
