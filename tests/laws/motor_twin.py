"""A slow twin of `stepper`: an event for each grid point, inputs watched edge by edge, outputs driven by levels.

It shares one step of the integrator and the reading of the pins with the part; no promises, nothing foreseen, nothing
kept.  What it passes within a step it looks for picosecond by picosecond, halving.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import replace
from math import ulp
from typing import Any

import numpy as np

from slewline.parts.motors.integration import Point
from slewline.parts.shafts.encoder import Encoder
from slewline.parts.shafts.sensors import Switch
from slewline.parts.shafts.shaft import BacklashShaft, DrivenShaft, GearedShaft, Shaft
from slewline.parts.steppers.feed import Reading
from slewline.parts.steppers.stepper import STALLS, Stepper
from slewline.parts.steppers.turning import pushed

KINDS = {"stepper": "SlowStepper", "encoder": "SlowEncoder", "switch": "SlowSwitch"}


def slow(kind: str) -> str:
    """The kind of a part in slow motion."""
    return f"{__name__}:{KINDS[kind]}" if kind in KINDS else kind


class Shown:
    """A count along a chain of gears and plays, shown `lag` later by a function of the counts."""

    def __init__(
        self, shaft: Shaft | None, per_step: float, bounds: tuple[Any, ...], lag: int, show: Callable[..., None]
    ):
        self.per_step, self.bounds, self.lag, self.show = per_step, [float(bound) for bound in bounds], lag, show
        self.chain: list[tuple[float, float, float]] = []  # factor, play, offset
        while isinstance(shaft, DrivenShaft):
            ratio = float(shaft.ratio) if isinstance(shaft, GearedShaft) else 1.0
            play, offset = (float(shaft.play), float(shaft.offset)) if isinstance(shaft, BacklashShaft) else (0.0, 0.0)
            self.chain.insert(0, (ratio, play, offset))
            shaft = shaft.under
        self.is_lagging = shaft is None  # its command, as `stall` is
        self.plays = self.places(None, 0.0)
        self.count = self.counted(self.plays, 0.0)

    def places(self, plays: list[float] | None, place: float) -> list[float]:
        """The places along the chain with the rotor at a place, having gone there straight."""
        found = []
        for n, (factor, play, offset) in enumerate(self.chain):
            place = place * factor + offset
            if play and plays is not None:
                place = min(max(plays[n], place), place + play)
            found.append(place)
        return found or [place]

    def counted(self, places: list[float], asked: float) -> int:
        place = places[-1] - asked * self.is_lagging
        return int((place * self.per_step + 0.5) // 1.0) if self.per_step else bisect_right(self.bounds, place)


class SlowStepper(Stepper):
    """A stepper that does everything as it comes."""

    def __init__(self, kernel: Any, name: str, **options: Any) -> None:
        self.shown: list[Shown] = []
        self.unsure: dict[int, int] = {}  # ps by which an edge is uncertain: the rotor creeps, and places are rounded
        self._fits = False
        super().__init__(kernel, name, **options)

    def rewired(self) -> None:
        if not self._fits:
            self._fits = True
            self.kernel.call_at(self.kernel.now + 1, self._start)
            self.edge: int | None = None  # not taken up yet
            self.coming: list[tuple[int, int, Shown]] = []

    def _start(self) -> None:
        self._begin()
        last = self._run.stretches[-1].first
        self.point, self.now_law, self.still = (
            replace(self._run.stretches[0].first, t=self.kernel.seen),
            self._run.law,
            False,
        )
        self.levels = [self.high(name) for name in self._read]
        half = self.now_law.period / 2
        self.shown.append(Shown(None, 0.0, (-half, half), self._stalls_ps, self._stalled))
        for name in self._read:
            self.pins[name].net.watch(self._edge_seen)
        self._arrive(self.point)
        self._arrive(replace(last, t=self.kernel.seen), self.now_law)
        self._tick()

    def _show_stall(self) -> None: ...

    def _stalled(self, count: int, _before: int) -> None:
        self.drivers["stall"].drive(int(STALLS[count]))

    def _edge_seen(self, _net: Any) -> None:
        if self.edge != self.kernel.now:
            self._go()
            self.edge = self.kernel.now
            self.kernel.call_at(self.kernel.now + 1, self._go)

    def _tick(self) -> None:
        self._go()
        if not self.still:
            self.kernel.call_at(self.point.t + self.now_law.step_ps + 1, self._tick)

    def _go(self) -> None:
        """Take up what has happened before now."""
        while (self.edge is not None and self.edge < self.kernel.now) or not self.still:
            point, law = self.point, self.now_law
            stop = point.t + law.step_ps
            if self.edge is not None and (self.still or self.edge <= stop):
                stop = self.edge
            if stop >= self.kernel.now:
                return
            times, commands, codes = [], [], []
            if stop == self.edge:
                levels, self.edge = [self.high(name) for name in self._read], None
                reading = Reading(np.array([stop]), np.array([self.levels, levels]))
                asked, rows = self._feed.asked(reading, point.command)
                self.levels = levels
                if (int(asked[0]), int(rows[0])) == (point.command, point.code):
                    continue
                times, commands, codes = [stop], asked, rows
            trace = law.integrate(
                times, commands, stop, codes=codes, start=point.t, state=point.state, command=point.command,
                code=point.code, engine="python",
            )  # fmt: skip
            was, self.still = self.still, trace.rests and len(trace.times) == 1
            if not self.still:
                columns = trace.times, trace.states, trace.commands, trace.codes
                t, state, command, code = (column[-1].tolist() for column in columns)
                self._arrive(Point(t, tuple(state), command, code))
                if was:
                    self.kernel.call_at(t + law.step_ps + 1, self._tick)

    def _arrive(self, point: Point, law: Any = None) -> None:
        """Be at a grid point, perhaps with another law, or in another place."""
        self.coming = [change for change in self.coming if change[0] <= point.t]
        before, place, micro = self.point, point.state[0] / self.now_law.motor.step, self.now_law.micro
        for it in self.shown:
            turn = self._turn()
            if law is None and turn and turn <= point.t - before.t:
                it.plays = it.places(it.plays, self._rotor(turn)[0] / self.now_law.motor.step)
            it.plays = it.places(it.plays, place)
            for asked in (before.command, point.command):
                self._change(it, point.t, it.counted(it.plays, asked / micro))
        self.point, self.now_law = point, law or self.now_law
        for it in self.shown:
            self._look_ahead(it)

    def _rotor(self, span: int) -> tuple[float, ...]:
        return self.now_law.after(self.point.t, self.point.state, self.point.code, span)

    def _turn(self) -> int:
        """When it turns round in the step from here; 0: it does not."""
        omega, step = self.point.state[1], self.now_law.step_ps
        if omega == 0 or self._rotor(step)[1] * omega > 0:
            return 0
        return first(1, step, lambda span: self._rotor(span)[1] * omega <= 0)

    def _look_ahead(self, it: Shown) -> None:
        """What will be shown in the step from here, if it has its full length."""
        turn, step = self._turn(), self.now_law.step_ps
        asked, plays, low = self.point.command / self.now_law.micro, it.plays, 0
        for high in (turn, step) if turn else (step,):

            def along(span: int, plays: list[float] = plays) -> list[float]:
                return it.places(plays, self._rotor(span)[0] / self.now_law.motor.step)

            count, after = it.counted(plays, asked), it.counted(along(high), asked)
            way = 1 if after > count else -1
            for n in range(count + way, after + way, way):
                span = first(low + 1, high, lambda span, n=n, way=way: (it.counted(along(span), asked) - n) * way >= 0)
                self._change(it, self.point.t + span, n)
                theta, omega = self._rotor(span)[:2]
                self.unsure[self.point.t + span + it.lag] = int(8e12 * ulp(theta) / max(abs(omega), 1e-30))
            plays, low = along(high), high

    def _change(self, it: Shown, ps: int, count: int) -> None:
        """Let a count be shown that it has from an instant on."""
        its = [change for change in self.coming if change[2] is it]
        if count != (its[-1][1] if its else it.count):
            change = ps, count, it
            self.coming.append(change)
            self.kernel.call_at(ps + it.lag, lambda: self._show(change))

    def _show(self, change: tuple[int, int, Shown]) -> None:
        if change in self.coming:
            self.coming.remove(change)
            _, count, it = change
            before, it.count = it.count, count
            it.show(count, before)

    def _alter(self, *, blocked=None, torque=None, push=0.0, stops=None) -> None:  # type: ignore[no-untyped-def]
        if self._begun_ps is None:
            return super()._alter(blocked=blocked, torque=torque, push=push, stops=stops)
        self._go()
        law, seen = self.now_law, self.kernel.seen
        law = law if blocked is None else replace(law, blocked=blocked)
        law = law if torque is None else replace(law, load=replace(law.load, torque=torque))
        state = self._rotor(seen - self.point.t) if seen > self.point.t and not self.still else self.point.state
        if not self.still:
            self._arrive(replace(self.point, t=seen, state=state), self.now_law)
        given = dict(zip(self.now_law.names, state, strict=True))
        given |= pushed(law, given, push * law.motor.step)
        if law.blocked:
            given["omega"] = 0.0
        self.still = False
        self._arrive(
            Point(seen, tuple(given.get(name, 0.0) for name in law.names), self.point.command, self.point.code), law
        )
        self.kernel.call_at(max(seen + law.step_ps, self.kernel.now) + 1, self._tick)


def first(low: int, high: int, true: Callable[[int], bool]) -> int:
    """The first number from `low` on for which something is true, as it is for `high`."""
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if true(middle) else (middle + 1, high)
    return low


def stepper_of(shaft: Shaft) -> Any:
    while isinstance(shaft, DrivenShaft):
        shaft = shaft.under
    return shaft.source.part  # type: ignore[attr-defined]


class SlowEncoder(Encoder):
    """An encoder that drives levels."""

    def rewired(self) -> None:
        shown = Shown(self.shaft, float(self.rule.counter.scale.per_step), (), self.rule.counter.lag_ps, self._show)
        stepper_of(self.shaft).shown.append(shown)

    def _show(self, count: int, _before: int) -> None:
        for name, code in self._outputs._codes.items():
            self.drivers[name].drive(code[count])


class SlowSwitch(Switch):
    """A switch that drives levels."""

    shown: Shown | None = None

    def rewired(self) -> None:
        scale = self.rule.counter.scale
        self.shown = Shown(self.rule.shaft, 0.0, scale.bounds, self.rule.counter.lag_ps, self._show)
        self._show(self.shown.count, self.shown.count)
        stepper_of(self.rule.shaft).shown.append(self.shown)

    def _promise(self) -> None:
        self.drivers["out"].drive(self._levels[self._closed])

    def _show(self, count: int, _before: int) -> None:
        says = self._zones[count]
        self._closed = self._closed if says is None else says
        self._promise()
