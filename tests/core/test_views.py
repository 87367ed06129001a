"""Views of promises against plain functions of the instant, and what the wire on a pin says ahead of time."""

from __future__ import annotations

from itertools import pairwise
from random import Random

import numpy as np
import pytest
from promises import Asked

from slewline.chips.mc1451a.axis.pin_edges import PinEdges
from slewline.core.datasheet.table import Pin
from slewline.core.motion.step_views import PulseView, StrobeView
from slewline.core.motion.train import OPEN, Playing, StepTrain
from slewline.core.time.events import NotYet, ask_at
from slewline.core.time.kernel import Kernel
from slewline.core.time.timebase import Clock
from slewline.core.wires.clocking import clock_edges
from slewline.core.wires.net import Bus, Driver, Net, Wave
from slewline.core.wires.pin import EdgeCondition, LevelCondition, Terminal
from slewline.core.wires.views import Delayed, Gated, Inverted, Repeated, Rested, View, Wired, gated, inverted
from slewline.core.wires.wave import promised
from slewline.parts.base.counted import Counted
from slewline.parts.base.lookahead import Lookahead
from slewline.record.recording.recorder import Recorder
from tests.ensembles import few

CLOCK = Clock(10**12)  # a tick is a picosecond
END = 160
NAND, NOR = (1, 1, 1, 0), (1, 0, 0, 0)


def pulses(interval, count=OPEN, origin=0, until=None):
    return PulseView(Playing(StepTrain(CLOCK, origin, [(interval, count)]), until), 3)


class Early:
    """A promise that answers `after` early: a few picoseconds on, and at an edge only when it is due."""

    def __init__(self, of, ahead):
        self.of, self.ahead = of, ahead

    until = property(lambda self: self.of.until)
    floats = property(lambda self: getattr(self.of, "floats", False))

    def level(self, ps):
        return self.of.level(ps)

    def after(self, ps):
        edge, ahead = self.of.after(ps), ps + self.ahead
        at = ask_at(edge)
        return edge if at is not None and at <= ahead else NotYet(ahead)

    def edges(self, start, stop):
        return self.of.edges(start, stop)


def settled(level, rest):
    return rest if level is None else level


def made(random, depth=3):
    """A random promise or level, and a plain function of the instant that says the same."""
    kind = random.choice(["level", "wave", "train", "strobe"] + ["invert", "gate", "wire", "rest", "delay"] * 2 * depth)
    if kind == "level":
        level = random.choice([0, 1, None])
        return level, lambda ps: level
    if kind == "wave":
        times = tuple(sorted(random.choices(range(-20, END), k=random.randrange(1, 8))))
        wave = Wave(random.choice([0, 1, None]), times, tuple(random.choice([0, 1, 0, 1, None]) for _ in times))
        wave.until = random.choice([None, None, random.randrange(END)])
        if random.random() < 0.2:
            return Early(wave, random.randrange(1, 9)), wave.level
        return wave, wave.level
    if kind in ("train", "strobe"):
        train = StepTrain(CLOCK, random.randrange(-50, 60), [(random.randrange(6, 30), random.choice([1, 5, OPEN]))])
        playing = Playing(train, random.choice([None, None, random.randrange(END)]))
        view = PulseView(playing, 3) if kind == "train" else StrobeView(playing, 2)
        return view, view.level
    number = {"gate": random.randrange(1, 4), "wire": random.randrange(1, 4), "delay": random.randrange(1, 4)}
    of = [made(random, depth - 1) for _ in range(number.get(kind, 1))]
    inputs, plain = [what for what, _ in of], [level for _, level in of]
    view, level = MAKERS[kind](random, inputs, plain)
    until = random.choice([None, None, random.randrange(END)])
    if until is None or not promised(view) or view in inputs:
        return view, level
    view.until = until
    return view, lambda ps: level(min(ps, until - 1))


def gate(random, inputs, plain):
    table = tuple(random.randrange(2) for _ in range(1 << len(inputs)))
    view = gated(inputs, table) if random.random() < 0.5 or not any(map(promised, inputs)) else Gated(inputs, table)
    return view, lambda ps: table[sum((level(ps) != 0) << n for n, level in enumerate(plain))]


def wire(random, inputs, plain):
    rest = random.choice([0, 1, None])

    def level(ps):
        shown = [now for of in plain if (now := of(ps)) is not None]
        return min(shown) if shown else rest

    return (Wired(inputs, Net.wired, rest) if any(map(promised, inputs)) else level(0)), level


def rested(random, inputs, plain):
    rest, (what,) = random.choice([0, 1]), inputs
    view = Rested(what, rest) if promised(what) else settled(what, rest)
    return view, lambda ps: settled(plain[0](ps), rest)


def delay(random, inputs, plain):
    lag = random.randrange(1, 40)
    since = sorted(random.sample(range(-40, END), len(inputs)))

    def level(ps):
        return plain[max(sum(at <= ps - lag for at in since) - 1, 0)](ps - lag)

    return Delayed(list(zip(since, inputs, strict=True)), lag), level


def invert(random, inputs, plain):
    return inverted(inputs[0]), lambda ps: None if (level := plain[0](ps)) is None else 1 - level


MAKERS = {"gate": gate, "wire": wire, "rest": rested, "delay": delay, "invert": invert}


@pytest.mark.parametrize("seed", few(range(250), 40))
def test_a_view_agrees_with_a_plain_function_of_its_inputs(seed):
    random = Random(seed)
    view, plain = made(random)
    while not isinstance(view, View):
        view, plain = made(random)
    levels = {ps: plain(ps) for ps in range(-1, END + 1)}
    edges = [(ps, levels[ps]) for ps in range(END + 1) if levels[ps] != levels[ps - 1]]
    assert [view.level(ps) for ps in levels] == list(levels.values())
    for start in range(0, END, 13):
        for stop in (start - 1, start, start + 1, (start + END) // 2, END):
            times, found = view.edges(start, stop)
            assert list(zip(map(int, times), found, strict=True)) == [edge for edge in edges if start < edge[0] <= stop]
            if not isinstance(times, list):
                assert (times.dtype, found.dtype) == (np.int64, np.int8)
        asked = start
        following = next((ps for ps, _ in edges if ps > start), None)
        for _ in range(END):
            answer = view.after(asked)
            asked = ask_at(answer)
            if asked is None or asked > END or asked == following:
                break
            assert isinstance(answer, NotYet)  # an instant is that of an edge
            assert following is None or start < asked < following
        assert asked == following or (following is None and (asked is None or asked > END))


def test_edges_of_trains_come_as_arrays_through_gates_delays_and_inverters():
    train, slow = pulses(10), pulses(70)
    for view in (
        inverted(train),
        Gated([train, slow], NAND),
        Delayed([(0, train)], 7),
        Wired([train, slow], Net.wired, 1),
    ):
        times, levels = view.edges(0, 1_000_000)
        assert (times.dtype, levels.dtype) == (np.int64, np.int8)
        assert len(times) > 20_000
        assert not (levels[1:] == levels[:-1]).any()


def test_a_gate_is_reduced_to_its_relevant_inputs():
    train = pulses(10)
    assert gated([train, 0], NAND) == 1
    assert type(gated([train, None], NAND)) is Inverted  # an open input reads high
    assert type(gated([train, train], NAND)) is Inverted
    assert type(gated([train, train], (0, 1, 1, 1))) is Repeated
    assert gated([train, train], (0, 1, 1, 0)) == 0  # exclusive or
    assert gated([train, 1], NOR) == 0
    assert type(gated([Wave(0, (5,), (None,))], (0, 1))) is Gated  # what floats reads high
    assert gated([None], (0, 1)) == 1


def test_a_closed_gate_does_not_ask_for_the_steps_of_its_other_input():
    view = Gated([pulses(10), Wave(0, (10**12,), (1,))], (0, 0, 0, 1))
    assert view.after(5) == 10**12 + 7
    assert Gated([pulses(10), Wave(0, (1,), (0,))], (0, 0, 0, 1)).after(5) is None
    assert Wired([pulses(10), Wave(0, (10**12,), (1,))], Net.wired, 1).after(5) == 10**12 + 7


def test_the_source_of_a_view_that_has_looked_ahead_enough_does_not_look_ahead_itself():
    train = Asked(pulses(16))
    view = still = Gated((train, Inverted(train)), (1, 1, 1, 1))  # no edge ever, and no input decides
    for _ in range(3):
        view = Gated((view, Inverted(view)), (1, 1, 1, 1))
    assert view.after(0).at > 100 and train.asked < 1000
    train.asked = 0
    assert clock_edges(Counted(clock_edges(still, 1, 0), still, (0, 1)), 1, 0).time(3).at > 100
    assert train.asked < 1000


def test_a_bound_is_before_those_of_the_inputs():
    train = pulses(10, until=50)
    view = inverted(Delayed([(0, train)], 7))
    assert view.until == 57
    view.until = 30
    assert (view.until, view.of.until) == (30, 57)
    assert [view.level(ps) for ps in (29, 30, 31)] == [view.level(29)] * 3
    view.until = None
    train.of.until = None
    assert view.until is None


# --------------------------------------------------------------------------------------------- the wire on a pin
def wired(drivers=1, pull=0, kind=Net):
    kernel = Kernel()
    net = kind(kernel, "wire", pull) if kind is Net else kind(kernel, "wire")
    return kernel, Terminal("x", Pin(1, "wire", "in", "an input"), net), [Driver(net, f"d{n}") for n in range(drivers)]


def test_a_wire_shows_a_level_or_a_promise_and_the_same_object_until_it_changes():
    kernel, pin, (one, two) = wired(2)
    lookahead = Lookahead(pin, lambda: None)
    assert lookahead.shown() == 0
    train = pulses(10)
    one.play(train)
    kernel.settle()
    assert lookahead.shown() is train
    two.drive(1)
    kernel.settle()
    shown = lookahead.shown()
    assert type(shown) is Wired
    assert lookahead.shown() is shown
    two.drive(1)
    kernel.settle()
    assert lookahead.shown() is shown
    one.drive(0)
    kernel.settle()
    assert lookahead.shown() == 0
    one.play(Wave(None, (50,), (1,)))
    two.drive(None)
    kernel.settle()
    assert (type(lookahead.shown()), lookahead.level(49), lookahead.after(3), lookahead.edges(3, 90)) == (
        Rested,
        0,
        50,
        ([50], [1]),
    )


def test_shown_levels_remain_in_the_past_when_a_driver_changes():
    kernel, pin, (driver,) = wired()
    lookahead = Lookahead(pin, lambda: None)
    driver.wave(0, (10, 20), (1, 0))
    kernel.run(5)
    shown = lookahead.shown()
    driver.wave(0, (30, 40, 50), (1, 0, 1))  # would write into the old one if nobody held it
    kernel.run(60)
    assert shown.edges(0, 60) == ([10, 20], [1, 0])
    assert lookahead.edges(0, 60) == ([30, 40, 50], [1, 0, 1])


def test_changed_is_called_before_the_driver_forgets_and_reports_whether_only_a_bound_has_moved():
    kernel, pin, (driver,) = wired()
    told = []
    lookahead = Lookahead(pin, lambda: told.append((kernel.now, lookahead.renewed, pin.net.shown())))
    train = pulses(10, until=50)
    driver.play(train)
    kernel.run(3)
    train.of.until = 40
    driver.renew()
    kernel.run(7)
    driver.drive(1)
    kernel.run(8)
    driver.drive(1)  # it is so already
    kernel.run(9)
    assert told == [(0, False, 0), (3, True, train), (7, False, train)]
    lookahead.close()
    driver.drive(0)
    kernel.run(10)
    assert len(told) == 3


def test_the_wires_of_a_bus_are_put_together_ahead_of_time():
    _, pin, (one, two) = wired(2, kind=Bus)
    one.play(Wave((0x0F, 0), (10, 30), ((0x0F, 5), None)))
    two.drive((0xF0, 0x20))
    pin.net.kernel.settle()
    assert pin.net.edges_ahead(0, 50) == ([10, 30], [(0xFF, 0x25), (0xF0, 0x20)])


# --------------------------------------------------------------------------------------------- answers that come early
@pytest.mark.parametrize("seed", few(range(60), 30))
def test_a_query_for_the_next_edge_may_have_to_be_repeated(seed):
    """Observers, waits, readings, recorders and conditions: a promise that answers early changes nothing."""
    random = Random(seed)
    drives = [(made(random, 1)[0], random.randrange(60)) for _ in range(3)]

    def seen(early):
        kernel, pin, (driver, other) = wired(2)
        net, recorder = pin.net, Recorder()
        reading, found = PinEdges(pin), []
        net.watch(lambda net: found.append((kernel.now, net.level, net.changes)))
        recorder.record(net)
        edge, level = EdgeCondition(pin, 3), LevelCondition(pin, 1)
        edge.begin()
        met = [None, None]
        for what, at in drives:
            what = Early(what, 3) if early and promised(what) else what
            kernel.call_at(at, lambda what=what: driver.drive(what))
        kernel.call_at(70, lambda: other.drive(0))
        for n, condition in enumerate((edge, level)):
            if kernel.run_while(lambda condition=condition: condition.met(), 50 * n + 50) is False:
                met[n] = kernel.now
            kernel.run(50 * n + 50)
        kernel.run(END)
        told, ahead = ([list(part) for part in edges] for edges in (reading.edges_until(END), net.edges_ahead(0, END)))
        kept = [list(part) for part in recorder.edges(net, 0, END)]
        return found, met, told, kept, list(recorder.each_edge(net, 0, END)), ahead

    assert seen(early=True) == seen(early=False)


def test_a_reading_is_not_quiet_while_it_must_query_again():
    kernel, pin, (driver,) = wired()
    reading = PinEdges(pin)
    driver.play(Early(Wave(0, (50,), (1,)), 5))
    kernel.run(10)
    reading.edges_until(10)
    assert not reading.quiet
    kernel.run(60)
    assert reading.edges_until(60) == ([50], [1])


def test_neighbouring_edges_differ():
    random = Random(1)
    for _ in range(50):
        view, _ = made(random)
        if isinstance(view, View):
            levels = [view.level(0), *view.edges(0, END)[1]]
            assert all(one != two for one, two in pairwise(levels))
