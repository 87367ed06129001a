"""Encoders: on the shaft of a motor that PULSE and DIR drive, or on a shaft that another machine turns.

    count    ... -1  0  1  2  3  4  5 ...        forward to the right: A is ahead of B
    a             0  0  1  1  0  0  1
    b             1  0  0  1  1  0  0

A and B are promises on top of what PULSE promises (course.py), so while PULSE follows a train, no step is an event.
When PULSE is driven otherwise, DIR changes or a user lays hands on the shaft, it is brought up to that instant and
takes up a new course in the next round.
"""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

from ..core.cycles import SquareView
from ..core.kernel import Kernel
from ..core.net import Net
from ..core.timebase import Time, picoseconds
from ..core.train import PulseView, StrobeView
from ..errors import UsageError
from .course import Channel, Course, Drive, Fall, Falls, Rotation, Still
from .part import Part

PUSH_PS = 2_000_000  # the counts of a shaft that is turned by hand
BLOCKED = 1 << 200  # a slack that no motion takes up
LEVELS = MappingProxyType({"a": (0, 1, 1, 0), "b": (0, 0, 1, 1)})  # by the count, modulo 4


class Shaft(Part):
    """A shaft with an encoder; `to` wires A and B to the encoder inputs of an axis."""

    wiring = MappingProxyType({"a": "quada1", "b": "quadb1"})
    verbs: tuple[str, ...] = ("push",)

    def __init__(self, kernel: Kernel, name: str, axis: int, course: Course) -> None:
        super().__init__(kernel, name)
        if axis not in (1, 2, 3, 4):
            raise UsageError(f"{name}: axis {axis!r}; allowed 1 to 4")
        self.wiring = MappingProxyType({own: f"{theirs[:-1]}{axis}" for own, theirs in type(self).wiring.items()})
        self._course = course
        self._turning = False  # a new course comes in the next round
        self._hand = 0  # counts that the shaft is still to be turned by hand
        self._pushing = False
        for pin in LEVELS:
            self.add_pin(pin, "out", f"channel {pin.upper()}", initial=0)

    @property
    def counts(self) -> int:
        """The count that the outputs show; neither A nor B is high at 0."""
        return self._course.at(self.kernel.seen)

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
            self._turn(self.kernel.seen)
            self._course = self._course.pushed(way, self.kernel.now)
            self.kernel.call_at(self.kernel.now + PUSH_PS, self._push)

    def _check(self, counts: int) -> None:
        if not isinstance(counts, int) or isinstance(counts, bool):
            raise UsageError(f"{self.name}: {counts!r} counts; expected a whole number")

    def _turn(self, ps: int) -> None:
        """The shaft is as its course says up to an instant; in the next round it takes up another."""
        if not self._turning:
            self._turning = True
            if ps > self._course.since:
                self._bring(ps)
            self.kernel.call_at(self.kernel.now, self._lay)

    def _bring(self, ps: int) -> None:
        """Follow the course up to an instant."""
        self._course = self._course.onward(ps)

    def _lay(self) -> None:
        self._turning = False
        self._course = self.steered(self._course)
        for name, levels in LEVELS.items():
            self.drivers[name].play(Channel(self._course, levels))

    def steered(self, course: Course) -> Course:
        """The course from this instant on."""
        return replace(course, since=self.kernel.now)

    @property
    def idle(self) -> bool:
        return not self._hand

    @property
    def waiting(self) -> str:
        return f"{self.name}: {self._hand} counts by hand" if self._hand else super().waiting


class Encoder(Shaft):
    """An encoder on the shaft of a step motor that makes every step, at the fall of PULSE; DIR high is forward.

    Args:
        axis: of the chip.
        counts: per revolution.
        steps: per revolution.
        reverse: the encoder counts the other way.
        lag: from a step to its count, more than 0.
    """

    wiring = MappingProxyType({"pulse": "pulse1", "dir": "dir1", **Shaft.wiring})
    verbs = ("block", "free", "slip", *Shaft.verbs)

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        *,
        axis: int = 1,
        counts: int = 4000,
        steps: int = 12800,
        reverse: bool = False,
        lag: Time = "1 us",
    ) -> None:
        lag_ps = picoseconds(lag)
        if counts < 1 or steps < 1 or lag_ps < 1:
            raise UsageError(f"{name}: counts {counts!r}, steps {steps!r}, lag {lag!r}; allowed 1, 1, 1 ps and more")
        super().__init__(kernel, name, axis, Course(counts, steps, lag_ps, Still()))
        self.add_pin("pulse", "in", "step at each fall", pull=1)
        self.add_pin("dir", "in", "high: forward", pull=1)
        self._reverse = reverse
        self._high = True  # PULSE, at the last instant that was looked at
        self._watches = False  # every change of PULSE, where it does not follow a train

    def rewired(self) -> None:
        pulse = self.pin("pulse").net
        self._high = pulse.level != 0
        pulse.sample(self._changed)
        self.pin("dir").net.watch(self._changed)
        self._turn(self.kernel.seen)

    def block(self) -> None:
        """The shaft stands still: steps are lost."""
        self.input("block")
        self._turn(self.kernel.seen)
        self._slacken(BLOCKED)

    def free(self) -> None:
        """The shaft follows again, from where it is."""
        self.input("free")
        self._turn(self.kernel.seen)
        self._slacken(0)

    def slip(self, counts: int) -> None:
        """The shaft does not follow the next steps, so many counts long, whatever their direction."""
        self._check(counts)
        if counts < 0:
            raise UsageError(f"{self.name}: slips {counts} counts; allowed 0 and more (push turns the shaft)")
        self.input("slip", counts)
        self._turn(self.kernel.seen)
        self._slacken(self._course.slack + counts * self._course.steps)

    def _slacken(self, slack: int) -> None:
        self._course = replace(self._course, slack=slack)
        self.kernel.settle()

    def _changed(self, _net: Net | None = None) -> None:
        """PULSE is driven otherwise, or DIR has changed: up to the instant before, all is as it was."""
        self._turn(self.kernel.now - 1)

    def _bring(self, ps: int) -> None:
        drive = self._course.drive
        if isinstance(drive, Falls):
            self._high = drive.view.level(ps) != 0
        super()._bring(ps)

    def steered(self, course: Course) -> Course:
        now, pulse = self.kernel.now, self.pin("pulse").net
        course = replace(course, sign=1 if self.high("dir") is not self._reverse else -1)
        high = pulse.level != 0
        if self._high and not high:
            course = replace(course, drive=Fall(now), since=now - 1).onward(now)
        self._high = high
        return replace(course, drive=self._followed(pulse), since=now)

    def _followed(self, pulse: Net) -> Drive:
        """What PULSE promises; where that is no train, every change of it is told."""
        view = pulse.promise
        if len(pulse.active) == 1 and isinstance(view, SquareView | PulseView | StrobeView):
            if self._watches:
                pulse.unwatch(self._changed)
            self._watches = False
            return Falls(view)
        if not self._watches:
            pulse.watch(self._changed)
        self._watches = True
        return Still()


class Quadrature(Shaft):
    """An encoder on a shaft that another machine turns: the master of an electronic gear.

    Args:
        axis: of the chip.
    """

    verbs = ("run", *Shaft.verbs)

    def __init__(self, kernel: Kernel, name: str, *, axis: int = 1) -> None:
        super().__init__(kernel, name, axis, Course(1, 1, 0, Still()))

    def run(self, rate: int) -> None:
        """Turn at so many counts/s from now on, less than 0: backwards; 0: stop."""
        self._check(rate)
        self.input("run", rate)
        self._turn(self.kernel.seen)
        drive = Rotation(self.kernel.now, abs(rate)) if rate else Still()
        self._course = replace(self._course, drive=drive, sign=1 if rate > 0 else -1)
        self.kernel.settle()

    def _turn(self, ps: int) -> None:
        super()._turn(self.kernel.now)  # what comes at this instant is known: nobody else turns the shaft
