"""Encoders: on the shaft of a motor that PULSE and DIR drive, or on a shaft that another machine turns.

    count    ... -1  0  1  2  3  4  5 ...        forward to the right: A is ahead of B
    a             0  0  1  1  0  0  1
    b             1  0  0  1  1  0  0
    index         1  0  1  1  1  1  1            low once a turn: at count 0, `counts` ...

All three are promises on top of what turns the shaft (counter.py), so while PULSE follows a train, no step is an event.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Literal

from ...core.datasheet.option import Option
from ...core.messages.instead import missing
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...core.time.timebase import Time, picoseconds
from ...core.wires.clocking import Even, Still
from ...errors import UsageError
from .counter import Channel, Code, Scale
from .motor import Translator
from .sensors import Sensor
from .shaft import Geared, Shaft

if TYPE_CHECKING:
    from ...core.datasheet.table import Pin

PUSH_PS = 2_000_000  # the counts of a shaft that is turned by hand
AXIS = Option("axis", "int", 1, "of the chip", low=1, high=4)
MOTOR = MappingProxyType({"pulse": "pulse", "dir": "direction"})  # its pins, as the encoder calls them
CHANNELS = MappingProxyType({"a": Code(0, 1, 1, 0), "b": Code(0, 0, 1, 1)})  # by the count


class Counts(Sensor):
    """Something that shows the counts of a shaft; `to` wires A and B to the encoder inputs of an axis."""

    wiring: Mapping[str, str] = MappingProxyType({"a": "encoder_a", "b": "encoder_b"})
    verbs: tuple[str, ...] = ("push",)

    def __init__(self, kernel: Kernel, name: str, axis: int) -> None:
        super().__init__(kernel, name)
        self.axis = axis
        self._codes = dict(CHANNELS)
        self._hand = 0  # counts that the shaft is still to be turned by hand
        self._pushing = False
        for pin in CHANNELS:
            self.add_pin(pin, "out", f"channel {pin.upper()}", initial=0, role=self.wiring[pin])

    @property
    def counts(self) -> int:
        """The count that the outputs show; neither A nor B is high at 0."""
        return self._counter.at(self.kernel.seen)

    @from_outside
    def push(self, counts: int) -> None:
        """Turn the shaft by hand, so many counts forward (less than 0: back), one every 2 us."""
        self._check(counts)
        self.input("push", counts)
        self._hand += counts
        if not self._pushing:
            self._push()
        self.kernel.settle()

    def _push(self) -> None:
        self._pushing = bool(self._hand)
        if self._hand:
            way = 1 if self._hand > 0 else -1
            self._hand -= way
            self.shaft.push(way / self._counter.scale.per_step)
            self.kernel.call_at(self.kernel.now + PUSH_PS, self._push)

    def _check(self, counts: int) -> None:
        if not isinstance(counts, int) or isinstance(counts, bool):
            raise UsageError(f"{self.name}: {counts!r} counts; expected a whole number")

    def promise(self) -> None:
        """Promise what the outputs show from now on."""
        for name, code in self._codes.items():
            self.drivers[name].play(Channel(self._counter, code))

    @property
    def idle(self) -> bool:
        """Nothing left to do by itself."""
        return not self._hand

    @property
    def waiting(self) -> str:
        """What the part waits for."""
        return f"{self.name}: {self._hand} counts by hand" if self._hand else super().waiting


missing(Counts, **dict.fromkeys(("position", "count", "value", "angle"), "{it}.counts"))


class Encoder(Counts):
    """An encoder on the shaft of a step motor that makes every step, at the fall of PULSE; DIR high is forward.

    Args:
        on: the shaft that it sits on; without it the encoder has a motor of its own, which PULSE and DIR drive.
        axis: of the chip.
        counts: per revolution.
        steps: per revolution, of its own motor.
        reverse: the encoder counts the other way.
        lag: from a step to its count, more than 0.
    """

    optional = frozenset({"a", "b", "index"})  # where the neighbour has no inputs for them
    verbs = ("block", "free", "slip", *Counts.verbs)
    sits: ClassVar[Literal["", "may", "must"]] = "may"

    options = (
        AXIS,
        Option("counts", "int", 4000, "per revolution", low=1),
        Option("steps", "int", 12800, "per revolution, of a motor of its own", low=1),
        Option("reverse", "bool", False, "it counts the other way"),
        Option("lag", "time", "1 us", "from a step to its count", low=1),
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
        super().__init__(kernel, name, axis)
        self._motor = self._own_motor(steps) if on is None else None
        shaft = on if self._motor is None else self._motor.shaft
        assert shaft is not None
        if counts > 1:
            self.add_pin("index", "out", "low once a turn", initial=0, role="index")
            self._codes["index"] = Code(0, *(1,) * (counts - 1))
        self.sit(
            Geared(shaft, Fraction(-1)) if reverse else shaft, Scale(Fraction(counts, shaft.per_turn)), picoseconds(lag)
        )

    def _own_motor(self, steps: int) -> Translator:
        """A motor whose pins are those of the encoder."""
        motor = Translator(self.kernel, self.name)
        motor.shaft.per_turn = steps
        for own, theirs in MOTOR.items():
            self.take_pin(own, motor.pins[theirs])
        self.wiring = MappingProxyType({"pulse": "step", "dir": "direction", **self.wiring})
        return motor

    def attached(self, own: str, row: Pin) -> None:
        """Tell the motor inside which pin one of its own has been joined with."""
        if self._motor is not None and own in MOTOR:
            self._motor.attached(MOTOR[own], row)

    def rewired(self) -> None:
        """Start to watch the pins: the part is wired, and time is about to pass."""
        if self._motor is not None:
            if not ((net := self.pins["pulse"].net).drivers or net.joined):
                self.finding("open-pin", "pulse is open, nothing but push() turns the shaft; give to=x, or on=motor")
            self._motor.rewired()
        super().rewired()

    @from_outside
    def block(self) -> None:
        """Block the shaft: it stands still, steps are lost."""
        self.input("block")
        self.shaft.block()
        self.kernel.settle()

    @from_outside
    def free(self) -> None:
        """Free the shaft: it follows again, from where it is."""
        self.input("free")
        self.shaft.free()
        self.kernel.settle()

    @from_outside
    def slip(self, counts: int) -> None:
        """Let the shaft slip: it does not follow the next steps, so many counts long, whatever their direction."""
        self._check(counts)
        if counts < 0:
            raise UsageError(f"{self.name}: slips {counts} counts; allowed 0 and more (push turns the shaft)")
        self.input("slip", counts)
        self.shaft.slip(counts / self._counter.scale.per_step)
        self.kernel.settle()


class Quadrature(Counts):
    """An encoder on a shaft that another machine turns: the master of an electronic gear.

    Args:
        axis: of the chip.
    """

    verbs = ("run", *Counts.verbs)
    options = (AXIS,)

    def __init__(self, kernel: Kernel, name: str, *, axis: int = 1) -> None:
        super().__init__(kernel, name, axis)
        self.sit(Shaft(kernel, per_turn=1), Scale(Fraction(1)), 0)
        super().rewired()  # its shaft is its own: there is nothing to wait for

    def rewired(self) -> None:
        """Start to watch the pins: the part is wired, and time is about to pass."""
        pass

    @from_outside
    def run(self, rate: int) -> None:
        """Turn at so many counts/s from now on, less than 0: backwards; 0: stop."""
        self._check(rate)
        self.input("run", rate)
        now = self.kernel.now
        self.shaft.cut(now)  # what comes at this instant is known: nobody else turns the shaft
        self.shaft.turn(Even(now, abs(rate)) if rate else Still(), 1 if rate > 0 else -1, now)
        self.kernel.settle()
