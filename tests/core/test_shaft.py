"""A shaft with a gear, a carriage between stops and switches on it, against the same made one step after the other."""

from __future__ import annotations

from fractions import Fraction
from random import Random

import numpy as np
import pytest

from slewline.chips.mc1451a.axis.pin_edges import PinEdges
from slewline.core.motion.step_views import PulseView
from slewline.core.motion.train import OPEN, Playing, StepTrain
from slewline.core.time.events import Even, Listed, NoEvents
from slewline.core.time.kernel import Kernel
from slewline.core.time.timebase import Clock, picoseconds
from slewline.core.wires.clocking import clock_edges
from slewline.parts.shafts.carriage import Carriage, Gear
from slewline.parts.shafts.sensors import Switch
from slewline.parts.shafts.shaft import Shaft
from tests.ensembles import few

US, MS = 1_000_000, 1_000_000_000
END = 4 * MS
CLOCK = Clock(25_000_000)


class Story:
    """What turns a shaft: instants, each with a direction and edges from there on; and what sits on it."""

    def __init__(self, seed):
        random = Random(seed)
        self.gear = random.choice([None, {"pinion": 20, "wheel": 60}, {"pinion": 7, "wheel": 3, "reverse": True}])
        self.backlash = random.choice([0, 7, 2.5])
        low, high = random.choice([(None, None), (-30, 40), (None, 25), (-12.5, 0)])
        self.carriage = {"backlash": self.backlash, "low": low, "high": high, "start": random.choice([0, 0, -5, -12.5])}
        self.switches = [
            {"low": -10, "high": -4, "hysteresis": random.choice([0, 2, 0.5])},
            {"low": 20, "hysteresis": random.choice([0, 3])},
            {"high": -8.25, "hysteresis": random.choice([0, 1]), "lag": random.choice(["1 ps", "1 us", "300 us"])},
        ]
        self.turns = []
        at = 0
        for _ in range(random.randrange(3, 12)):
            at += random.choice([1, 40_000, random.randrange(1, 900 * US)])
            if at >= END:
                break
            kind = random.choice(["train", "train", "even", "still", "step"])
            self.turns.append((at, kind, random.choice([1, -1]), random.random()))

    def edges(self, at, kind, chance):
        random = Random(chance)
        if kind == "even":
            return Even(at, random.choice([1_000, 20_000, 150_000]))
        if kind == "train":
            runs = [(random.randrange(30, 1500), random.choice([1, 5, 200])), (random.randrange(100, 900), OPEN)]
            return clock_edges(PulseView(Playing(StepTrain(CLOCK, CLOCK.ticks_from(at), runs)), 12), 0, at)
        return NoEvents()

    def made(self):
        """All edges: (instant, direction)."""
        found = []
        for (at, kind, sign, chance), following in zip(self.turns, [*self.turns[1:], (END + 1,)], strict=True):
            if kind == "step":
                found.append((at, sign))
                continue
            edges = self.edges(at, kind, chance)
            for k in range(1, edges.count(following[0] - 1) + 1):  # what is cut off at an instant does not come there
                found.append((int(edges.time(k)), sign))
        return found

    def naive(self):
        """Places and edges of the switches, one step after the other."""
        ratio = Fraction(1)
        if self.gear is not None:
            ratio = Fraction(self.gear["pinion"], self.gear["wheel"]) * (-1 if self.gear.get("reverse") else 1)
        start, play = Fraction(self.carriage["start"]), Fraction(self.backlash)
        low, high = self.carriage["low"], self.carriage["high"]
        steps, place, lost = 0, start, 0
        switches = [Naive(start, **switch) for switch in self.switches]
        places = []
        for time, sign in self.made():
            pushed = (steps + sign) * ratio + start
            moved = min(max(place, pushed), pushed + play)
            if moved != place and ((high is not None and moved > high) or (low is not None and moved < low)):
                lost += 1
                continue
            steps, place = steps + sign, moved
            places.append((time, steps, place))
            for switch in switches:
                switch.move(time, place)
        return places, lost, [[edge for edge in switch.edges if edge[0] <= END] for switch in switches]

    def rig(self, random, shuffle, watched, asked):
        kernel = Kernel(shuffle)
        shaft = Shaft(kernel)
        on = shaft if self.gear is None else Gear(kernel, "gear", on=shaft, **self.gear).shaft
        carriage = Carriage(kernel, "carriage", on=on, **self.carriage)
        switches = [Switch(kernel, f"s{n}", on=carriage.shaft, **what) for n, what in enumerate(self.switches)]
        for switch in switches:
            switch.rewired()
        kernel.settle()
        readings = [PinEdges(switch.pin("out")) for switch in switches]
        found = [[] for _ in switches]
        if watched:
            for switch in switches:
                switch.pin("out").net.watch(lambda net: None)
        for at, kind, sign, chance in self.turns:
            kernel.call_at(at, lambda turn=(at, kind, sign, chance): self.turn(kernel, shaft, *turn))

        def ask():
            for reading, edges in zip(readings, found, strict=True):
                times, levels = reading.edges_until(kernel.seen)
                edges += [(int(time), int(level)) for time, level in zip(times, levels, strict=True)]

        for at in sorted(random.sample(range(1, END), asked)):
            kernel.run(at)
            ask()
            assert carriage.lost >= 0
        kernel.run(END)
        ask()
        return shaft, carriage, found

    def turn(self, kernel, shaft, at, kind, sign, chance):
        shaft.cut(at - 1)

        def schedule():
            if kind == "step":
                shaft.step(at, sign)
            shaft.turn(self.edges(at, kind, chance), sign, at)

        kernel.call_at(at, schedule)


class Naive:
    """A switch, told of every step."""

    def __init__(self, place, low=None, high=None, hysteresis=0, lag="1 us"):
        self.low = -(10**9) if low is None else Fraction(low)
        self.high = 10**9 if high is None else Fraction(high)
        self.out, self.lag = Fraction(hysteresis), picoseconds(lag)
        self.closed = self.low <= place < self.high
        self.edges = []

    def move(self, time, place):
        was = self.closed
        if self.low <= place < self.high:
            self.closed = True
        elif not self.low - self.out <= place < self.high + self.out:
            self.closed = False
        if was != self.closed:
            self.edges.append((time + self.lag, 0 if self.closed else 1))


def compare(seed):
    story, random = Story(seed), Random(seed)
    places, lost, edges = story.naive()
    for shuffle, watched, asked in ((None, False, 0), (Random(seed), True, 0), (Random(seed), seed % 2, 20)):
        shaft, carriage, found = story.rig(random, shuffle, watched, asked)
        assert found == edges
        assert carriage.lost == lost
        assert len([f for f in carriage.findings if f.code == "hard-stop"]) <= lost
        assert bool(carriage.findings) == bool(lost)
        times = np.array([time for time, _, _ in places], np.int64)
        assert shaft.place_at(times).tolist() == [steps for _, steps, _ in places]
        assert carriage.shaft.place_at(times) == pytest.approx([float(place) for _, _, place in places], abs=1e-9)
        if places:
            assert carriage.shaft.place == places[-1][2]
        changes = shaft.changes(-1, END)
        assert changes[0].tolist() == times.tolist()
        assert changes[1].tolist() == [steps for _, steps, _ in places]


@pytest.mark.parametrize("seed", few(range(60), 20))
def test_parts_on_a_shaft_move_step_by_step(seed):
    compare(seed)


@pytest.mark.long
def test_it_does_so_in_many_more_stories():
    for seed in range(60, 660):
        compare(seed)


def test_slip_in_front_of_a_stop_is_not_lost_there():
    kernel = Kernel()
    shaft = Shaft(kernel)
    carriage = Carriage(kernel, "carriage", on=Gear(kernel, "gear", on=shaft, wheel=2).shaft, high=5)
    shaft.slip(Fraction(3))
    shaft.turn(Even(0, 1_000_000), 1, 0)
    kernel.run(20 * US)
    assert (shaft.place, carriage.place, carriage.lost) == (10, 5, 20 - 3 - 10)
    carriage.shaft.push(Fraction(-2))
    assert (shaft.place, carriage.place) == (6, 3)
    kernel.run(21 * US)
    assert (shaft.place, carriage.lost) == (7, 7)
    carriage.shaft.block()
    kernel.run(30 * US)
    carriage.shaft.free()
    kernel.run(32 * US)
    assert (shaft.place, carriage.lost) == (9, 7)


def test_a_hand_turns_a_shaft_no_further_than_to_a_stop():
    kernel = Kernel()
    shaft = Shaft(kernel)
    carriage = Carriage(kernel, "carriage", on=shaft, low=-5, high=4.5, backlash=2)
    shaft.push(Fraction(20))
    assert (shaft.place, carriage.place) == (Fraction(9, 2), 4.5)
    shaft.push(Fraction(-1))
    assert (shaft.place, carriage.place) == (Fraction(7, 2), 4.5)
    carriage.shaft.push(Fraction(-20))
    assert (shaft.place, carriage.place) == (-7, -5)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_part_put_on_a_turning_shaft_begins_at_its_given_position(sign):
    kernel = Kernel()
    shaft = Shaft(kernel)
    shaft.turn(Even(0, 1_000_000), sign, 0)
    kernel.run(50 * US)
    carriage = Carriage(kernel, "carriage", on=shaft, backlash=7, start=3, low=-60, high=40)
    assert (carriage.place, shaft.place) == (3, 50 * sign)
    kernel.run(60 * US)
    assert carriage.place == (13 if sign > 0 else 0)
    kernel.run(200 * US)
    assert carriage.place == (40 if sign > 0 else -60)
    assert carriage.lost == (150 - 37 if sign > 0 else 150 - 7 - 63)


def test_only_the_load_that_is_at_its_stop_reports_lost_steps():
    kernel = Kernel()
    shaft = Shaft(kernel)
    near = Carriage(kernel, "near", on=Gear(kernel, "gear", on=shaft, wheel=3).shaft, low=-20, high=5, backlash=2.5)
    far = Carriage(kernel, "far", on=shaft, low=-30, high=500)
    free = Carriage(kernel, "free", on=near.shaft, start=7)
    for since, sign in ((0, 1), (20 * US, -1)):
        shaft.cut(since)
        shaft.turn(Even(since, 1_000_000), sign, since)
        kernel.run((20 if sign > 0 else 80) * US)
        assert (near.lost, far.lost, free.lost) == ((5, 0, 0) if sign > 0 else (5, 15, 0))
    assert [(carriage.name, len(carriage.findings)) for carriage in (near, far, free)] == [
        ("near", 1), ("far", 1), ("free", 0)
    ]  # fmt: skip


def test_forgetting_the_past_of_a_shaft_leaves_the_rest_unchanged():
    kernel = Kernel()
    shaft = Shaft(kernel)
    for n in range(1, 101):
        kernel.run(n * 10 * US)
        shaft.step(n * 10 * US, 1 if n % 10 else -1)
    kernel.run(1005 * US)
    times = np.arange(600, 1005) * US
    before = shaft.place_at(times).tolist()
    kept = len(shaft.past)
    shaft.forget(600 * US)
    assert len(shaft.past) < kept / 2 + 2
    assert shaft.place_at(times).tolist() == before
    assert before[-1] == 80


@pytest.mark.parametrize("there_and_back", [False, True])
def test_an_endless_shaft_keeps_its_latest_courses(there_and_back, monkeypatch):
    monkeypatch.setattr("slewline.parts.shafts.shaft.KEPT", 10)
    monkeypatch.setattr("slewline.parts.shafts.shaft.SINGLE", 4)
    kernel = Kernel()
    shaft, places = Shaft(kernel), [0]
    for n in range(1, 1000):
        kernel.run(n * 10 * US)
        shaft.step(n * 10 * US, -1 if there_and_back and n % 5 == 0 else 1)
        places.append(int(shaft.place))
        assert len(shaft.past) <= 21
        assert all(len(motion.drive.instants) <= 4 for motion in shaft.past if isinstance(motion.drive, Listed))
    kernel.run(9999 * US)
    times = np.arange(985, 1000) * 10 * US
    assert shaft.place_at(times).tolist() == places[985:]
