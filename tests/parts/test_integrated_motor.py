"""A motor whose rotor is integrated instead of counted turns a shaft with all that sits on it.

It knows its future only as far as it has been integrated: asked for more, it answers an instant at which to ask again.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import replace
from random import Random

import numpy as np
import pytest

from slewline import Bench
from slewline.chips.mc1451a.axis.pin_edges import PinEdges
from slewline.core.time.events import Events, NotYet
from slewline.core.time.kernel import Kernel
from slewline.parts.shafts.carriage import Carriage
from slewline.parts.shafts.encoder import Encoder
from slewline.parts.shafts.sensors import Switch
from slewline.parts.shafts.shaft import Shaft

US, MS = 1_000_000, 1_000_000_000
END = 150 * MS
GRID_PS = 20 * US
AHEAD = 50  # grid points that one question integrates at most
PARTS = 256  # the rotor is told of so many parts of a step


class Swing(Events):
    """A rotor with inertia, friction and a spring to the step that is commanded, from an instant on."""

    def __init__(self, since, place, speed, target):
        self.grid, self.states, self.target = [since], [(place, speed)], target  # steps, steps/s
        self.passed, self.back = [], None  # instants of its parts as long as it goes one way; when it turns round
        self.sign = 1 if speed > 0 or (speed == 0 and target > place) else -1

    @property
    def rests(self):
        place, speed = self.states[-1]
        return self.back is None and abs(speed) < 1 and abs(self.target - place) < 0.02

    def grow(self, ps):
        """Integrate as far as an instant."""
        while self.grid[-1] < ps and self.back is None and not self.rests:
            (place, speed), dt = self.states[-1], GRID_PS / 1e12
            speed += (2e5 * (self.target - place) - 150 * speed) * dt
            if speed * self.sign < 0:
                self.back = self.grid[-1] + GRID_PS
                speed = 0.0
            after, begin = place + speed * dt, self.grid[-1]
            low, high = sorted((int(place * PARTS // 1), int(after * PARTS // 1)))
            found = [begin + max(1, int((n / PARTS - place) / speed * 1e12)) for n in range(low + 1, high + 1)]
            self.passed += found if self.sign > 0 else found[::-1]
            self.grid.append(begin + GRID_PS)
            self.states.append((after, speed))

    # ----------------------------------------------------------------------------- edges of a clock, one for each part
    def count(self, ps):
        self.grow(ps)
        return bisect_right(self.passed, ps)

    def time(self, k):
        horizon = self.grid[-1] + AHEAD * GRID_PS
        while len(self.passed) < k and self.grid[-1] < horizon and self.back is None and not self.rests:
            self.grow(self.grid[-1] + GRID_PS)
        if len(self.passed) >= k:
            return self.passed[k - 1]
        return None if self.rests or self.back is not None else NotYet(self.grid[-1])

    def times(self, first, last):
        return np.array(self.passed[first - 1 : last], np.int64)


class Integrated:
    """Steps are commanded, the rotor swings there; it tells its shaft each time that it turns round."""

    def __init__(self, kernel):
        self.kernel, self.shaft = kernel, Shaft(kernel)
        self.shaft.motion = replace(self.shaft.motion, unit=PARTS)  # an edge is a part
        self.swing, self.swings = Swing(0, 0.0, 0.0, 0), []

    def command(self, steps):
        self._anew(self.swing.target + steps)

    def _anew(self, target):
        now, old = self.kernel.now, self.swing
        old.grow(now)
        self.shaft.cut(now - 1)
        place, speed = old.states[max(bisect_right(old.grid, now) - 1, 0)]
        swing = self.swing = Swing(now, place, speed, target)
        self.swings.append(swing)
        self.shaft.cut(now)
        self.shaft.turn(swing, swing.sign, now)
        self._look(swing)

    def _look(self, swing):
        """Look, again and again, whether it turns round."""
        if swing is self.swing:
            swing.time(len(swing.passed) + 1)
            if swing.back is not None and swing.back <= self.kernel.now:
                self._anew(swing.target)
            elif not swing.rests:
                self.kernel.call_at(swing.back or swing.grid[-1], lambda: self._look(swing))


def run(shuffle=None, watched=False, asked=()):
    kernel = Kernel(shuffle)
    motor = Integrated(kernel)
    carriage = Carriage(kernel, "carriage", on=motor.shaft, backlash=0.5, high=7)
    encoder = Encoder(kernel, "encoder", on=motor.shaft, counts=4000)
    switch = Switch(kernel, "switch", on=carriage.shaft, low=1.9, hysteresis=0.25)
    pins = [*(encoder.pin(name) for name in ("a", "b", "index")), switch.pin("out")]
    for part in (encoder, switch):
        part.rewired()
    kernel.settle()
    if watched:
        for pin in pins:
            pin.net.watch(lambda net: None)
    readings, found = [PinEdges(pin) for pin in pins], [[] for _ in pins]
    for n, steps in enumerate((1, 1, 1, -2, 1, 8, -3)):  # it swings over; the last but one ends at the stop
        kernel.call_at((10 + 15 * n) * MS, lambda steps=steps: motor.command(steps))
    for at in (*sorted(asked), END):
        kernel.run(at)
        for reading, edges in zip(readings, found, strict=True):
            edges += [(int(time), level) for time, level in zip(*reading.edges_until(kernel.seen), strict=True)]
        assert carriage.lost >= 0
    return motor, carriage, encoder, found


def test_parts_on_an_integrated_motor_follow_its_rotor():
    motor, carriage, encoder, found = run()
    place, (a, b, index, out) = 0, found
    closed, edges, shown = False, [], [[(0, 0)], [(0, 0)]]
    moved = 0.0  # the carriage
    assert len(motor.swings) > 20  # it swings
    for swing, following in zip(motor.swings, [*motor.swings[1:], None], strict=True):
        for time in swing.passed:
            if time <= (END if following is None else following.grid[0]) and place + swing.sign <= 7 * PARTS:
                place += swing.sign
                moved = min(max(moved, place / PARTS), place / PARTS + 0.5)
                now = moved >= 1.9 or (closed and moved >= 1.65)
                if now != closed:
                    edges.append((time + US, 1 - now))
                closed = now
                for levels, known in zip(((0, 1, 1, 0), (0, 0, 1, 1)), shown, strict=True):
                    level = levels[place * 20 // PARTS % 4]
                    if level != known[-1][1]:
                        known.append((time + US, level))
    assert motor.shaft.place == place / PARTS
    assert out == edges and len(edges) == 4
    assert [a, b] == [known[1:] for known in shown] and len(a) > 300 and index
    assert encoder.counts == place * 20 // PARTS
    assert carriage.lost and [found.code for found in carriage.findings][:1] == ["hard-stop"]


@pytest.mark.parametrize("seed", range(6))
def test_its_output_does_not_depend_on_observers_or_the_order_within_an_instant(seed):
    random = Random(seed)
    asked = random.sample(range(1, END), 30)
    assert run(Random(seed), watched=seed % 2 == 0, asked=asked)[3] == run()[3]


def test_steps_are_lost_once_it_is_at_rest():
    bench = Bench()
    x = bench.add("cy525", name="x")
    motor = bench.part(
        "stepper", "motor", to=x, driver="L/4R 20 V", load="inertia 68 g cm2, friction 5 mNm, torque 30 mNm"
    )
    bench.host(x).send("A 0\rF 6\rR 20\rS 200\rZ 1\rN 400\rG\r")
    bench.run_until_idle()
    bench.run_until(motor.rests)
    assert motor.lost == round(motor.command - motor.place) and motor.lost % 4 == 0 and motor.lost > 300
