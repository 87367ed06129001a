"""Encoders: on the shaft of a motor that PULSE and DIR drive, or on a shaft that another machine turns.

    count    ... -1  0  1  2  3  4  5 ...        forward to the right: A is ahead of B
    a             0  0  1  1  0  0  1
    b             1  0  0  1  1  0  0
    index         1  0  1  1  1  1  1            low once a turn, where A and B are low: at count 0, `counts` ...

All three are promises on top of what turns the shaft (core/counter.py), so while PULSE follows a train, no step is an
event.  When PULSE is driven otherwise, DIR changes or a user lays hands on the shaft, it is cut at that instant and
takes up a new course in the next round.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from types import MappingProxyType
from typing import ClassVar, Literal

from ..core.clocking import Even, Still, clock_edges
from ..core.counter import Channel, Code, Scale
from ..core.kernel import Kernel
from ..core.shaft import Geared, Shaft
from ..core.timebase import Time, picoseconds
from ..errors import UsageError
from .follower import Follower
from .sensors import Sensor

PUSH_PS = 2_000_000  # the counts of a shaft that is turned by hand
CHANNELS = MappingProxyType({"a": Code(0, 1, 1, 0), "b": Code(0, 0, 1, 1)})  # by the count


class Counts(Sensor):
    """Something that shows the counts of a shaft; `to` wires A and B to the encoder inputs of an axis."""

    wiring = MappingProxyType({"a": "quada1", "b": "quadb1"})
    verbs: tuple[str, ...] = ("push",)

    def __init__(self, kernel: Kernel, name: str, axis: int) -> None:
        super().__init__(kernel, name)
        if axis not in (1, 2, 3, 4):
            raise UsageError(f"{name}: axis {axis!r}; allowed 1 to 4")
        self.wiring = MappingProxyType({own: f"{theirs[:-1]}{axis}" for own, theirs in type(self).wiring.items()})
        self._codes = dict(CHANNELS)
        self._hand = 0  # counts that the shaft is still to be turned by hand
        self._pushing = False
        for pin in CHANNELS:
            self.add_pin(pin, "out", f"channel {pin.upper()}", initial=0)

    @property
    def counts(self) -> int:
        """The count that the outputs show; neither A nor B is high at 0."""
        return self._counter.at(self.kernel.seen)

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
        for name, code in self._codes.items():
            self.drivers[name].play(Channel(self._counter, code))

    @property
    def idle(self) -> bool:
        return not self._hand

    @property
    def waiting(self) -> str:
        return f"{self.name}: {self._hand} counts by hand" if self._hand else super().waiting


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

    wiring = MappingProxyType({"pulse": "pulse1", "dir": "dir1", **Counts.wiring})
    verbs = ("block", "free", "slip", *Counts.verbs)
    sits: ClassVar[Literal["", "may", "must"]] = "may"

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
        lag_ps = picoseconds(lag)
        if counts < 1 or steps < 1 or lag_ps < 1:
            raise UsageError(f"{name}: counts {counts!r}, steps {steps!r}, lag {lag!r}; allowed 1, 1, 1 ps and more")
        super().__init__(kernel, name, axis)
        self._own = Shaft(kernel, steps) if on is None else None
        shaft = on
        if self._own is not None:
            shaft = self._own
            shaft.source = self
            self.follows = ("pulse",)
            self.add_pin("pulse", "in", "step at each fall", pull=1)
            self.add_pin("dir", "in", "high: forward", pull=1)
        else:
            self.wiring = MappingProxyType({own: self.wiring[own] for own in CHANNELS})
        if counts > 1:
            self.add_pin("index", "out", "low once a turn", initial=0)
            self._codes["index"] = Code(0, *(1,) * (counts - 1))
        self._high = True  # PULSE, at the last instant that was looked at
        assert shaft is not None
        self.sit(Geared(shaft, Fraction(-1)) if reverse else shaft, Scale(Fraction(counts, shaft.per_turn)), lag_ps)

    def block(self) -> None:
        """The shaft stands still: steps are lost."""
        self.input("block")
        self.shaft.block()
        self.kernel.settle()

    def free(self) -> None:
        """The shaft follows again, from where it is."""
        self.input("free")
        self.shaft.free()
        self.kernel.settle()

    def slip(self, counts: int) -> None:
        """The shaft does not follow the next steps, so many counts long, whatever their direction."""
        self._check(counts)
        if counts < 0:
            raise UsageError(f"{self.name}: slips {counts} counts; allowed 0 and more (push turns the shaft)")
        self.input("slip", counts)
        self.shaft.slip(counts / self._counter.scale.per_step)
        self.kernel.settle()

    # ----------------------------------------------------------------------------------------------- a motor of its own
    def sources(self) -> Iterable[Follower]:
        return super().sources() if self._own is None else Follower.sources(self)

    def rewired(self) -> None:
        if self._own is not None:
            self._high = self.high("pulse")
            self.pin("dir").net.watch(lambda _: self.changed())
        super().rewired()

    def cut(self, ps: int) -> None:
        if self._own is not None and ps > self._own.course.since:
            self._high = self.pin("pulse").net.resolve(ps) != 0
            self._own.cut(ps)

    def lay(self) -> None:
        if self._own is None:
            super().lay()
            return
        self.react()
        now = self.kernel.now
        self._own.turn(clock_edges(self.outlooks["pulse"].shown(), 0, now), 1 if self.high("dir") else -1, now)

    def react(self) -> None:
        if self._own is not None:
            was, self._high = self._high, self.high("pulse")
            if was and not self._high:
                self._own.step(self.kernel.now, 1 if self.high("dir") else -1)


class Quadrature(Counts):
    """An encoder on a shaft that another machine turns: the master of an electronic gear.

    Args:
        axis: of the chip.
    """

    verbs = ("run", *Counts.verbs)

    def __init__(self, kernel: Kernel, name: str, *, axis: int = 1) -> None:
        super().__init__(kernel, name, axis)
        self.sit(Shaft(kernel, per_turn=1), Scale(Fraction(1)), 0)

    def run(self, rate: int) -> None:
        """Turn at so many counts/s from now on, less than 0: backwards; 0: stop."""
        self._check(rate)
        self.input("run", rate)
        now = self.kernel.now
        self.shaft.cut(now)  # what comes at this instant is known: nobody else turns the shaft
        self.shaft.turn(Even(now, abs(rate)) if rate else Still(), 1 if rate > 0 else -1, now)
        self.kernel.settle()
