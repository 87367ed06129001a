"""Pins as seen externally, and the conditions for which a run can wait."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, ClassVar, NoReturn

from ...errors import NoSuchAttribute, UsageError, WiringError
from ..datasheet.table import Pin
from ..messages.calls import answering
from ..messages.instead import face, missing
from ..messages.whole import whole
from ..time.timebase import Time, picoseconds, readable
from .net import Bus, Driver, Net

if TYPE_CHECKING:
    from ..time.kernel import Kernel


class Condition:
    """A condition for which `Bench.run_until` can wait; `a | b` is met when a or b is met.

    Attributes:
        text: a description of the condition, for messages.
        nets: the nets that are watched during the wait, so that each of their promised edges becomes
            an instant of the run.
    """

    text = ""
    nets: tuple[Net, ...] = ()

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self}>"

    def begin(self) -> None:
        """Prepare for a wait that begins now."""

    def met(self) -> bool:
        """Return whether the condition holds now."""
        raise NotImplementedError

    def when(self) -> int | None:
        """Return the instant (ps) at which the present promises will meet the condition; None if none is foreseen."""
        return None

    @property
    def foreseen(self) -> Callable[[], int | None] | None:
        """The method `when`, if the condition follows from promises; None if it must be checked at every instant."""
        return self.when if type(self).when is not Condition.when else None

    def belongs(self, kernel: Kernel) -> bool:
        """Return whether all nets of the condition belong to a kernel, so that the kernel's runs can wait for it."""
        return all(net.kernel is kernel for net in self.nets)

    def __bool__(self) -> NoReturn:
        raise self._no_truth()

    def __and__(self, other: object) -> NoReturn:
        raise self._no_truth()

    def __await__(self) -> NoReturn:
        raise UsageError(f"{self}: a condition cannot be awaited directly; write await bench.until(...)")

    def _no_truth(self) -> UsageError:
        return UsageError(
            f"{self}: a condition has no truth value; bench.run_until waits for it; write 'a | b' to wait for either "
            "of two, or a condition of your own, such as 'lambda: x.position > 40'"
        )

    def __or__(self, other: Condition) -> Condition:
        if not isinstance(other, Condition):
            raise UsageError(f"{self.text} | {other!r}: expected another condition, such as x.reaches(40)")
        return EitherCondition(self, other)


class EitherCondition(Condition):
    """The condition that at least one of two conditions is met."""

    def __init__(self, *of: Condition) -> None:
        self.of, self.text = of, " or ".join(condition.text for condition in of)
        self.nets = tuple(net for condition in of for net in condition.nets)

    def __str__(self) -> str:
        return " or ".join(map(str, self.of))

    def belongs(self, kernel: Kernel) -> bool:
        """Return whether both conditions belong to a kernel, so that the kernel's runs can wait for them."""
        return all(condition.belongs(kernel) for condition in self.of)

    def begin(self) -> None:
        """Prepare both conditions for a wait that begins now."""
        for condition in self.of:
            condition.begin()

    def met(self) -> bool:
        return any(condition.met() for condition in self.of)

    def when(self) -> int | None:
        """Return the first instant (ps) at which the promises meet either condition; None if none is foreseen."""
        return min((time for condition in self.of if (time := condition.when()) is not None), default=None)


class LevelCondition(Condition):
    """The condition that a pin has a level, 0 or 1."""

    def __init__(self, pin: Terminal, level: int) -> None:
        if level not in (0, 1):
            raise UsageError(f"{pin.name}: level {level!r}; allowed 0, 1")
        self.pin, self.wanted, self.text, self.nets = pin, level, f"{pin.name}={level}", (pin.net,)

    def met(self) -> bool:
        return self.pin.level == self.wanted


class EdgeCondition(Condition):
    """The condition that a pin has changed a given number of times since the wait began."""

    def __init__(self, pin: Terminal, number: int) -> None:
        count = whole(number)
        if count is None or count < 1:
            raise UsageError(f"{pin.name}: {number!r} edges; allowed 1 or more")
        self.net, self.number, self.text, self.nets = pin.net, count, f"{count} edges of {pin.name}", (pin.net,)

    def begin(self) -> None:
        """Start counting changes of the pin."""
        self.last = self.net.changes + self.number

    def met(self) -> bool:
        return self.net.changes >= self.last


class GotCondition(Condition):
    """The condition that a sequence of bytes or words has been received."""

    def __init__(
        self, name: str, received: bytearray | list[int], data: bytes | list[int], nets: tuple[Net, ...] = ()
    ) -> None:
        self.received, self.data, self.text, self.nets = received, data, f"{name} got {data!r}", nets

    def met(self) -> bool:
        received, data = self.received, self.data
        if isinstance(received, bytearray) and isinstance(data, bytes):
            return data in received
        return any(received[at : at + len(data)] == data for at in range(len(received) - len(data) + 1))


def strapped(pins: Mapping[str, Terminal], names: Iterable[str]) -> tuple[int, ...]:
    """Return the levels of strap pins, 0 or 1; an open pin reads 1."""
    return tuple(0 if pins[name].level == 0 else 1 for name in names)


@face
class Terminal:
    """A pin as accessed from outside: it can be read, and driven as if by another output on its wire.

    Attributes:
        name: the full name, which includes the owner's name, such as "x.slew".
        row: the row of the pin in the pin table of the data sheet: number, direction, purpose.
        net: the wire to which the pin is connected.
    """

    _for_users: ClassVar[tuple[str, ...]] = ("name", "level", "drive", "release", "pulse", "is_", "edges", "row", "net")

    def __init__(self, owner: str, row: Pin, net: Net) -> None:
        self.owner, self.row, self.net = owner, row, net
        self.name = f"{owner}.{row.name}"
        self.bit: int | None = None  # of a bus
        self._driver: Driver | None = None
        self._level: int | None = None  # the level driven externally
        self._pulses: tuple[tuple[object, int], ...] = ()  # in progress: each with its level, the last begun last
        self._between: int | None = None  # the level driven when the first of them began

    @property
    def level(self) -> int | None:
        """The level of the pin now: 0, 1, or None while it floats."""
        net = self.net
        if isinstance(net, Bus) and self.bit is not None:
            return net.bit(self.bit)
        return net.level  # type: ignore[no-any-return]

    @level.setter
    def level(self, level: int | None) -> None:
        what = "release()" if level is None else f"drive({level!r})"
        raise NoSuchAttribute(f"{self.name}: level cannot be set: it is the state of the wire; write pin.{what}")

    @property
    def held(self) -> int | None:
        """The level to which the pin is driven externally; None if it is not driven externally."""
        return self._level

    def drive(self, level: int, at: Time | None = None) -> None:
        """Drive the pin externally to 0 or 1, now or at an instant.

        This overrides the standard wiring of a part that is not `bare`.

        Raises:
            UsageError: a level other than 0 and 1, or an instant in the past.
            TimeError: `at` is not a time.
            WiringError: the pin carries no signal (a supply pin, for example), or is a whole bus.
        """
        if level not in (0, 1):
            raise UsageError(f"{self.name}: level {level!r}; allowed 0, 1 (release() releases the pin)")
        self._put(level, self._instant(at))

    def release(self, at: Time | None = None) -> None:
        """Stop driving the pin externally, now or at an instant; its wiring then determines the level.

        Raises:
            UsageError: the instant is in the past.
            TimeError: `at` is not a time.
            WiringError: the pin carries no signal (a supply pin, for example), or is a whole bus.
        """
        self._put(None, self._instant(at))

    @answering("pulse()", '; such as pin.pulse(0, "10 us")')
    def pulse(self, level: int, width: Time, at: Time | None = None) -> None:
        """Drive the pin to a level for a time; then restore its previous external level, if any, or release it.

        If pulses overlap, the pulse that began last determines the level; after the last pulse ends, the pin is
        driven as before the first pulse.

        Args:
            level: 0 or 1.
            width: the length of the pulse, such as "25 us", or picoseconds.
            at: the instant at which the pulse begins, by default now.

        Raises:
            UsageError: a level other than 0 and 1, or an instant in the past.
            TimeError: `width` or `at` is not a time.
            WiringError: the pin carries no signal (a supply pin, for example), or is a whole bus.
        """
        kernel = self.net.kernel
        if level not in (0, 1):
            raise UsageError(f"{self.name}: level {level!r}; allowed 0, 1")
        start, ps = self._instant(at), picoseconds(width)

        def begin() -> None:
            if not self._pulses:
                self._between = self._level
            self._put(level, kernel.now)
            self._pulses = (*self._pulses, (begin, level))
            if ps:
                kernel.call_at(kernel.now + ps, kernel.outside.later(end))
            else:
                end()

        def end() -> None:
            self._pulses = tuple(pulse for pulse in self._pulses if pulse[0] is not begin)
            self._put(self._pulses[-1][1] if self._pulses else self._between, kernel.now)

        if start > kernel.now:
            kernel.call_at(start, kernel.outside.later(begin))
        else:
            begin()

    def _instant(self, at: Time | None) -> int:
        now = self.net.kernel.now
        ps = now if at is None else picoseconds(at)
        if ps < now:
            raise UsageError(f"{self.name}: {readable(ps)} is in the past; the time is {readable(now)}")
        return ps

    def _put(self, level: int | None, ps: int) -> None:
        kernel = self.net.kernel
        if self.row.in_out in ("power", "none"):
            raise WiringError(f"{self.name} (pin {self.row.number}: {self.row.description}) carries no signal")
        if isinstance(self.net, Bus) and self.bit is None:
            raise WiringError(f"{self.name} is a bus of eight wires; drive the pins of a chip that is wired to it")
        if ps > kernel.now:
            kernel.call_at(ps, kernel.outside.later(lambda: self._put(level, ps)))
            return
        self._level = level = None if level is None else int(level)
        kernel.outside.record("drive", pin=self.name, level=level)
        if self._driver is None:
            self._driver = Driver(self.net, "outside")
        if isinstance(self.net, Bus) and self.bit is not None:
            self._driver.drive(None if level is None else (1 << self.bit, level << self.bit))
        else:
            self._driver.drive(level)
        kernel.settle()

    # conditions, for Bench.run_until
    def is_(self, level: int) -> LevelCondition:
        """Return a condition that is met while the pin has the given level.

        Raises:
            UsageError: a level other than 0 and 1.
        """
        return LevelCondition(self, level)

    def edges(self, number: int) -> EdgeCondition:
        """Return a condition that is met when the pin has changed `number` times since the wait began.

        Raises:
            UsageError: `number` is not a whole number, 1 or more.
        """
        return EdgeCondition(self, number)

    def __repr__(self) -> str:
        return f"<pin {self.name}={self.level}>"


missing(
    Terminal,
    "write pin.drive(0) or pin.drive(1)",
    **dict.fromkeys(("set", "set_level", "write"), "pin.drive(0) or pin.drive(1)"),
    **dict.fromkeys(("high", "on"), "pin.drive(1) drives it, pin.level reads it"),
    **dict.fromkeys(("low", "off", "clear"), "pin.drive(0) drives it, pin.level reads it"),
    **dict.fromkeys(("get", "read", "value", "state"), "pin.level"),
    **dict.fromkeys(("float", "free"), "pin.release()"),
    is_active="pin.level == pin.row.active",
    activate="pin.drive(pin.row.active)",
    deactivate="pin.drive(1 - pin.row.active)",
    **dict.fromkeys(("toggle", "strobe"), 'pin.pulse(1, "10 us")'),
    **dict.fromkeys(("rises", "falls", "changes"), "pin.edges(1) is a condition for run_until"),
    **dict.fromkeys(
        ("wait", "wait_for", "wait_for_edge", "wait_for_press", "wait_for_active", "when_pressed"),
        "bench.run_until(pin.edges(1)), or pin.is_(0)",
    ),
    times='bench.record("{it}"), then bench.edges("{it}")',
)
