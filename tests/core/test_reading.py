"""Readings: every edge of a wire is told once, however it is driven and whenever somebody asks."""

from __future__ import annotations

from itertools import pairwise
from random import Random

import pytest

from slewline.chips.mc1451a.axis.pin_edges import PinEdges
from slewline.chips.mc1451a.profiles.cycle_train import CycleTrain, Linear, SquareView
from slewline.core.datasheet.table import Pin
from slewline.core.motion.step_views import PulseView
from slewline.core.motion.train import OPEN, Playing, StepTrain
from slewline.core.time.kernel import Kernel
from slewline.core.time.timebase import Clock
from slewline.core.wires.net import Driver, Net, Wave
from slewline.core.wires.pin import Terminal
from tests.ensembles import few

CLOCK = Clock(10**12)  # a tick is a picosecond


def wire(drivers=1, pull=0):
    kernel = Kernel()
    net = Net(kernel, "wire", pull)
    return kernel, Terminal("x", Pin(1, "wire", "in", "an input"), net), [Driver(net, f"d{n}") for n in range(drivers)]


def played(*runs, origin=0, high=3):
    return PulseView(Playing(StepTrain(CLOCK, origin, runs)), high)


def told(reading, ps):
    times, levels = reading.edges_until(ps)
    return [(int(time), level if level is None else int(level)) for time, level in zip(times, levels, strict=True)]


# ------------------------------------------------------------------------------------------------------- one drive
def test_the_edges_of_a_train_cost_no_event_and_come_as_arrays():
    kernel, pin, (driver,) = wire()
    reading = PinEdges(pin)
    driver.play(played((10, OPEN), origin=5))
    kernel.settle()
    kernel.run(10_000_002)
    assert kernel.next_time() is None
    assert told(reading, 27) == [(5, 0), (12, 1), (15, 0), (22, 1), (25, 0)]
    times, levels = reading.edges_until(10_000_002)
    assert len(times) == len(levels) == 2_000_000 - 5
    assert (times[0], times[-1], levels[-1]) == (32, 10_000_002, 1)
    assert told(reading, 10_000_002) == []


def test_levels_waves_and_floating_outputs_are_read_alike():
    kernel, pin, (driver,) = wire(pull=1)
    driver.drive(0)
    kernel.settle()
    reading = PinEdges(pin)
    kernel.run(10)
    driver.drive(1)
    kernel.run(20)
    driver.play(Wave(1, (25, 30, 35, 40), (0, 0, None, 0)))  # two of its edges are none
    kernel.run(50)
    driver.drive(None)
    kernel.run(60)
    assert told(reading, 60) == [(10, 1), (25, 0), (35, 1), (40, 0), (50, 1)]
    assert reading.first == 0


def test_a_change_at_the_instant_of_creation_is_the_first_level():
    kernel, pin, (driver,) = wire()
    reading = PinEdges(pin)
    for level in (1, 0, 1):
        driver.drive(level)
        kernel.settle()
    kernel.run(5)
    driver.drive(0)
    kernel.run(7)
    assert told(reading, 7) == [(5, 0)]
    assert reading.first == 1
    driver.drive(1)
    kernel.settle()
    reading.begin()
    driver.drive(0)
    kernel.run(9)
    assert (told(reading, 9), reading.first) == ([], 0)


def test_a_change_at_the_instant_of_the_query_is_reported_by_the_next_one():
    kernel, pin, (driver,) = wire()
    reading = PinEdges(pin)
    kernel.run(10)
    assert told(reading, 10) == []
    driver.drive(1)
    kernel.settle()
    assert told(reading, 9) == []
    assert told(reading, 10) == [(10, 1)]
    driver.drive(0)
    kernel.run(11)
    assert told(reading, 11) == [(10, 0)]


def test_wires_that_become_one_are_read_as_one():
    kernel, pin, (driver,) = wire()
    other = Net(kernel, "other", 1)
    reading = PinEdges(pin)
    other.join(pin.net)
    kernel.settle()
    kernel.run(5)
    driver.drive(0)
    kernel.run(9)
    assert (told(reading, 9), reading.first) == ([(5, 0)], 1)


# -------------------------------------------------------------------------------------------------- drives that change
def test_a_promise_that_is_cut_off_has_shown_its_edges_up_to_there():
    kernel, pin, (driver,) = wire()
    reading = PinEdges(pin)
    view = played((10, OPEN), origin=5)
    driver.play(view)
    kernel.settle()
    kernel.run(33)
    view.of.until = 42
    driver.renew()
    kernel.run(42)
    driver.play(played((4, OPEN), origin=50, high=1))
    kernel.run(54)
    assert told(reading, 54)[-6:] == [(32, 1), (35, 0), (42, 1), (50, 0), (53, 1), (54, 0)]


def test_a_sleeping_reader_is_notified_of_a_bound_that_moves():
    kernel, pin, (driver,) = wire()
    reading = PinEdges(pin)
    changes = []
    reading.on_change.add(lambda: changes.append(kernel.now))
    view = played((10, OPEN), origin=5)
    view.of.until = 20
    driver.play(view)
    kernel.run(20)
    assert told(reading, 20) == [(5, 0), (12, 1), (15, 0)]
    assert reading.quiet
    view.of.until = 30
    driver.renew()
    kernel.settle()
    assert changes == [0, 20]
    assert told(reading, 20) == []
    assert not reading.quiet
    kernel.run(40)
    assert told(reading, 40) == [(22, 1), (25, 0)]
    assert reading.quiet


def test_quiet_means_that_no_change_follows_the_last_query():
    kernel, pin, (driver,) = wire()
    reading = PinEdges(pin)
    assert not reading.quiet  # its first level is not known
    reading.edges_until(0)
    assert reading.quiet
    driver.play(Wave(0, (10, 20), (1, 0)))
    kernel.run(15)
    assert not reading.quiet
    reading.edges_until(15)
    assert not reading.quiet
    kernel.run(30)
    assert not reading.quiet  # the edge at 20 has not been told
    assert told(reading, 30) == [(20, 0)]
    assert reading.quiet
    driver.drive(1)
    kernel.settle()
    assert not reading.quiet


def test_on_change_comes_before_the_change_and_the_next_round_sees_it():
    kernel, pin, (driver,) = wire()
    reading = PinEdges(pin)
    seen = []

    def look():
        seen.append((kernel.now, pin.net.level, told(reading, kernel.now)))

    reading.on_change.add(lambda: kernel.call_at(kernel.now, look))
    kernel.call_at(10, lambda: driver.drive(1))
    kernel.call_at(20, lambda: driver.play(Wave(1, (25,), (0,))))
    kernel.run(40)
    assert seen == [(10, 1, [(10, 1)]), (20, 1, [])]


# ---------------------------------------------------------------------------------------------------------- at random
class Script:
    """A random drive of one wire by one or two outputs, the same for everybody who listens to it."""

    def __init__(self, seed):
        self.random = random = Random(seed)
        self.kernel, self.pin, self.drivers = wire(random.choice([1, 1, 2]), random.choice([0, 1, None]))
        self.views = {}
        for _ in range(random.randrange(1, 25)):
            self.kernel.call_at(random.randrange(1, 400), self.acting(random.choice(self.drivers), random.randrange(3)))

    def acting(self, driver, rounds):
        kind, seed = self.random.choice(["level", "wave", "soon", "train", "cycles", "bound"]), self.random.random()

        def act():
            nonlocal rounds
            if rounds:  # in a later round of the same instant
                rounds -= 1
                self.kernel.call_at(self.kernel.now, act)
            else:
                getattr(self, kind)(driver, Random(seed))

        return act

    def level(self, driver, random):
        driver.drive(random.choice([0, 1, None]))

    def wave(self, driver, random):
        now = self.kernel.now
        times = sorted(random.sample(range(now - 5, now + 80), random.randrange(1, 6)))
        driver.play(Wave(random.choice([0, 1, None]), tuple(times), tuple(random.choice([0, 1, None]) for _ in times)))

    def soon(self, driver, random):
        now = self.kernel.now
        times = sorted(random.sample(range(now + 1, now + 80), random.randrange(1, 6)))
        driver.wave(driver.at(self.kernel.seen), tuple(times), tuple(random.choice([0, 1, None]) for _ in times))

    def train(self, driver, random):
        view = played(
            (random.randrange(4, 30), random.choice([3, OPEN])), origin=self.kernel.now + random.randrange(-9, 9)
        )
        self.play(driver, view, random)

    def cycles(self, driver, random):
        train = CycleTrain(CLOCK, self.kernel.now, Linear(random.randrange(1, 1 << 18), 7), 40, cycle=16)
        self.play(driver, SquareView(Playing(train), random.random() < 0.5), random)

    def play(self, driver, view, random):
        view.of.until = random.choice([None, self.kernel.now + random.randrange(1, 60)])
        self.views[driver] = view
        driver.play(view)

    def bound(self, driver, random):
        view = self.views.get(driver)
        now = self.kernel.now
        if driver.promise is view and view is not None and not driver.pending:
            until = view.of.until
            if until is None or until >= now:
                view.of.until = now + random.randrange(1, 60)
                driver.renew()


def real(edges, first):
    """One edge per instant, each a real change."""
    last = dict(edges)  # of equal times the last one
    before = [first, *last.values()]
    return [(time, level) for (time, level), was in zip(last.items(), before, strict=False) if level != was]


@pytest.mark.parametrize("seed", few(range(400), 60))
def test_a_reading_reports_the_view_of_an_observer(seed):
    watched = Script(seed)
    seen = []
    watched.pin.net.watch(lambda net: seen.append((watched.kernel.now, net.level)))
    watched.kernel.run(500)
    lazy, random = Script(seed), Random(seed)
    reading = PinEdges(lazy.pin)
    changes, found = [], []
    reading.on_change.add(lambda: changes.append(lazy.kernel.now))
    quiet_since = None

    def ask(ps):
        nonlocal quiet_since
        edges = told(reading, ps)
        if quiet_since is not None and edges:
            assert any(quiet_since[0] <= change <= edges[0][0] for change in changes[quiet_since[1] :])
        quiet_since = (ps, len(changes)) if reading.quiet else None
        found.extend(edges)

    for _ in range(random.randrange(30)):
        ps = random.randrange(1, 480)
        lazy.kernel.call_at(ps, lambda: ask(lazy.kernel.seen))
        lazy.kernel.call_at(ps, lambda: lazy.kernel.call_at(lazy.kernel.now, lambda: ask(lazy.kernel.seen)))
    lazy.kernel.run(500)
    ask(500)
    assert all(one[0] <= two[0] and one[1] != two[1] for one, two in pairwise(found))
    assert reading.first == watched.pin.net.pull
    assert real(found, reading.first) == real(seen, reading.first)
