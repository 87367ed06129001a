"""Encoders: on the shaft of a motor driven by PULSE and DIR, or on a shaft turned by another machine.

    count    ... -1  0  1  2  3  4  5 ...        forward to the right: A leads B
    a             0  0  1  1  0  0  1
    b             1  0  0  1  1  0  0
    index         1  0  1  1  1  1  1            low once per revolution: at count 0, `counts` ...

All three outputs are promises (levels known in advance), derived from the motion of the shaft
(shaft_counter.py): while PULSE follows a pulse train known in advance, the steps cause no events.
"""

from __future__ import annotations

from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from ...core.datasheet.option import Option
from ...core.messages.instead import missing
from ...core.time.events import Even, NoEvents
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...core.time.timebase import Time, picoseconds
from ...errors import UsageError
from ..base.part import Part
from .motor import Translator
from .sensors import Sensor
from .shaft import Blockable, GearedShaft, Shaft
from .shaft_counter import CountScale
from .shown import EncoderChannel, LevelPattern

if TYPE_CHECKING:
    from ...core.datasheet.table import Pin

PUSH_PS = 2_000_000  # count interval of a shaft that is turned by hand
FASTEST = 100_000_000  # counts/s of a shaft that another machine turns: chips count a few million
AXIS = Option("axis", "int", 1, "axis of the chip", low=1, high=4)
MOTOR = MappingProxyType({"pulse": "pulse", "dir": "direction"})  # its pins, by the encoder's names
COUNT_WIRING = MappingProxyType({"a": "encoder_a", "b": "encoder_b"})
CHANNELS = MappingProxyType({"a": LevelPattern(0, 1, 1, 0), "b": LevelPattern(0, 0, 1, 1)})  # levels by the count


class CountOutputs:
    """The outputs A and B, and an optional index, which show the counts of a shaft that can be turned by hand.

    Args:
        part: a part with the pins A and B; the index pin is added.
        shaft, scale, lag_ps: as in `Sensor`.
        index: number of counts from one index pulse to the next; 1: no index.
    """

    def __init__(self, part: Part, shaft: Shaft, scale: CountScale, lag_ps: int, index: int = 1) -> None:
        self.part, self.shaft = part, shaft
        self._codes = dict(CHANNELS)
        self.hand = 0  # counts that the shaft is still to be turned by hand
        self._pushing = False
        if index > 1:
            part.add_pin("index", "out", "low once per revolution", initial=0, role="index")
            self._codes["index"] = LevelPattern(0, *(1,) * (index - 1))
        self.rule = Sensor(part, shaft, scale, lag_ps, show=self._promise)

    def _promise(self) -> None:
        """Promise the levels of the outputs from now on, for the present motion of the shaft."""
        for name, code in self._codes.items():
            self.part.drivers[name].play(EncoderChannel(self.rule.counter, code))

    @property
    def count(self) -> int:
        """The count that the outputs show; at 0, both A and B are low."""
        return self.rule.counter.level(self.rule.kernel.seen)

    def steps(self, counts: int) -> Fraction:
        """Return the number of shaft steps that corresponds to a number of counts."""
        return counts / self.rule.counter.scale.per_step

    def push(self, counts: int) -> None:
        """Turn the shaft by hand, by `counts` (negative: backwards), one count every 2 µs.

        The call is recorded as an input of the part.
        """
        check_counts(self.part, counts)
        self.part.input("push", counts)
        self.hand += counts
        if not self._pushing:
            self._push()
        self.rule.kernel.settle()

    def _push(self) -> None:
        self._pushing = bool(self.hand)
        if self.hand:
            direction = 1 if self.hand > 0 else -1
            self.hand -= direction
            self.shaft.push(self.steps(direction))
            self.rule.kernel.call_at(self.rule.kernel.now + PUSH_PS, self._push)


def add_channels(part: Part) -> None:
    """Add the output pins A and B to a part."""
    for pin in CHANNELS:
        part.add_pin(pin, "out", f"channel {pin.upper()}", initial=0, role=COUNT_WIRING[pin])


def check_counts(part: Part, counts: object) -> None:
    """Check that a number of counts set by a user is an integer.

    Raises:
        UsageError: the value is not an integer.
    """
    if not isinstance(counts, int) or isinstance(counts, bool):
        raise UsageError(f"{part.name}: {counts!r} counts; expected a whole number")


class ShowsCounts:
    """Mixin that adds the count and `push` to a part with `CountOutputs`; list it before `Part` in the bases."""

    name: str
    _outputs: CountOutputs

    @property
    def counts(self) -> int:
        """The count that the outputs show; at 0, both A and B are low."""
        return self._outputs.count

    def shows(self) -> dict[str, Any]:
        """Return the count."""
        return {"counts": self.counts}

    @from_outside
    def push(self, counts: int) -> None:
        """Turn the shaft by hand, by `counts` (negative: backwards), one count every 2 µs."""
        self._outputs.push(counts)

    @property
    def idle(self) -> bool:
        """True if the part will change nothing unless an input changes."""
        return not self._outputs.hand

    @property
    def waiting(self) -> str:
        """Event or condition that the part waits for."""
        if hand := self._outputs.hand:
            return f"{self.name}: turning {hand} more counts by hand"
        return super().waiting  # type: ignore[misc,no-any-return]


class Encoder(ShowsCounts, Blockable, Part):
    """An encoder on a shaft, or on its own motor; falling edges of PULSE step this motor (DIR high: forward).

    Args:
        on: the shaft that carries the encoder; None: the encoder has its own motor, driven by PULSE and DIR.
        axis: the axis of the chip.
        counts: number of counts per revolution.
        steps: number of steps per revolution of the encoder's own motor.
        reverse: whether the encoder counts down while the shaft turns forward.
        lag: the time from a step to its count, more than 0.
    """

    _for_users = ("counts", "block", "free", "slip", "push")
    wiring = COUNT_WIRING
    optional = frozenset({"a", "b", "index"})  # if the neighbour has no inputs for them
    verbs = ("block", "free", "slip", "push")
    sits: ClassVar[Literal["", "may", "must"]] = "may"

    options = (
        AXIS,
        Option("counts", "int", 4000, "counts per revolution", low=1, high=1 << 20),
        Option("steps", "int", 12800, "steps per revolution of the motor, unless `on` names a shaft", low=1),
        Option("reverse", "bool", False, "count in the opposite direction"),
        Option("lag", "time", "1 us", "delay from a step to its count", low=1),
    )

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        *,
        on: Shaft | None = None,
        axis: int = 1,
        counts: int = 4000,
        steps: int = 12800,
        reverse: bool = False,
        lag: Time = "1 us",
    ) -> None:
        super().__init__(kernel, name)
        self.axis = axis
        add_channels(self)
        self._motor: Translator | None = None
        if on is None:
            on = self._own_motor(steps)
        self.shaft = GearedShaft(on, Fraction(-1)) if reverse else on
        scale = CountScale(Fraction(counts, on.per_turn))
        self._outputs = CountOutputs(self, self.shaft, scale, picoseconds(lag), counts)
        self.rule = self._outputs.rule

    def _own_motor(self, steps: int) -> Shaft:
        """Make the encoder's own motor, take over the motor's pins, and return its shaft."""
        motor = self._motor = Translator(self.kernel, self.name)
        motor.shaft.per_turn = steps
        for own, theirs in MOTOR.items():
            self.take_pin(own, motor.pins[theirs])
        self.wiring = MappingProxyType({"pulse": "step", "dir": "direction", **self.wiring})
        return motor.shaft

    def attached(self, own: str, row: Pin) -> None:
        """Adapt the encoder's own motor to a neighbour's pin, if this pin is wired to a pin of the motor."""
        if self._motor is not None and own in MOTOR:
            self._motor.attached(MOTOR[own], row)

    def rewired(self) -> None:
        """Start to follow the pins, once the part is wired and before time passes."""
        if self._motor is not None:
            if not ((net := self.pins["pulse"].net).drivers or net.joined):
                text = "pulse is open, so only push() turns the shaft; set to= to a chip, or on= to a motor"
                self.finding("open-pin", text)
            self._motor.rewired()
        self.rule.start()

    @from_outside
    def slip(self, counts: int) -> None:
        """Let the shaft slip: it does not follow its drive for the next `counts` counts, in either direction."""
        check_counts(self, counts)
        if counts < 0:
            raise UsageError(f"{self.name}: slip by {counts} counts; allowed 0 or more (push turns the shaft)")
        self.input("slip", counts)
        self.shaft.slip(self._outputs.steps(counts))
        self.kernel.settle()


class Quadrature(ShowsCounts, Part):
    """An encoder on a shaft turned by another machine: the master of an electronic gear.

    Args:
        axis: the axis of the chip.
    """

    _for_users = ("counts", "run", "push")
    wiring = COUNT_WIRING
    verbs = ("run", "push")
    options = (AXIS,)

    def __init__(self, kernel: Kernel, name: str, *, axis: int = 1) -> None:
        super().__init__(kernel, name)
        self.axis = axis
        add_channels(self)
        self.shaft = Shaft(kernel, per_turn=1)
        self._outputs = CountOutputs(self, self.shaft, CountScale(Fraction(1)), 0)
        self.rule = self._outputs.rule
        self.rule.start()  # the encoder has a shaft of its own: nothing to wait for

    @from_outside
    def run(self, rate: int) -> None:
        """Turn at `rate` counts/s from now on, backwards if negative; 0 stops the shaft."""
        check_counts(self, rate)
        if abs(rate) > FASTEST:
            raise UsageError(f"{self.name}: {rate} counts/s; allowed {-FASTEST} to {FASTEST}")
        self.input("run", rate)
        now = self.kernel.now
        self.shaft.cut(now)  # the edge at this instant is known: nothing else turns the shaft
        self.shaft.turn(Even(now, abs(rate)) if rate else NoEvents(), 1 if rate > 0 else -1, now)
        self.kernel.settle()


for _kind in (Encoder, Quadrature):
    missing(_kind, **dict.fromkeys(("position", "count", "value", "angle"), "{it}.counts"))
