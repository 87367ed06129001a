"""Gates, inverters and delay lines run ahead: no events, no second promise, and circles that go by edges."""

from __future__ import annotations

import pytest

import slewline
from slewline.build import Clocked, Follower, Part, gated
from slewline.core.motion.step_views import PulseView
from slewline.core.motion.train import OPEN, Playing, StepTrain
from slewline.core.time.timebase import Clock
from slewline.core.wires.net import Driver, Wave
from slewline.core.wires.views import Inverted, Repeated
from slewline.errors import Endless, UnknownName, UsageError

US = 1_000_000
CLOCK = Clock(1_000_000)


def train(steps=OPEN, until=None):
    """A step every 10 us from 10 us on; PULSE is high in the last 3 us of it."""
    return PulseView(Playing(StepTrain(CLOCK, 10, [(10, steps)]), until), 3)


@pytest.fixture
def bench():
    return slewline.Bench()


def driver(bench, pin, level=None):
    """An output on a pin."""
    driver = Driver(bench.pin(pin).net, "test")
    if level is not None:
        driver.drive(level)
    return driver


def edges(bench, pin):
    times, levels = bench.edges(pin)
    return list(zip(times.tolist(), levels.tolist(), strict=True))


# ---------------------------------------------------------------------------------------------------- what it costs
def test_a_train_through_gates_makes_no_events(bench):
    for kind, name in (("inverter", "i"), ("nand", "n"), ("delay", "d")):
        bench.part(kind, name)
    bench.wire("i.out", "n.in1")
    bench.wire("n.out", "d.in")
    bench.record("d.out")
    pulse, enable = driver(bench, "i.in1"), driver(bench, "n.in2", 1)
    bench.run(0)
    pulse.play(train())
    bench.run("1 s")
    assert bench.kernel.next_time() is None
    assert len(bench.edges("d.out")[0]) == 199_998
    assert len(bench.pin("d.out").net.log) == 1
    enable.drive(0)
    bench.run("1 s")
    assert edges(bench, "d.out")[-2:] == [(10**12 - 10 * US + 100_000, 0), (10**12 - 3 * US + 100_000, 1)]


def test_an_input_can_be_read_before_the_first_run(bench):
    inverter = bench.part("inverter", "i")
    pulse = driver(bench, "i.in1", 1)
    bench.kernel.settle()
    assert not inverter.rule.is_started and inverter.rule.shown("in1") == 1
    promise = train()
    pulse.play(promise)
    bench.run(0)
    assert inverter.rule.is_started and inverter.rule.shown("in1") is promise


def test_a_bound_that_moves_leaves_the_promise_and_notifies_every_watcher(bench):
    bench.part("inverter", "i")
    pulse, out = driver(bench, "i.in1"), bench.pin("i.out").net
    bench.record("i.out")
    bench.run(0)
    view = train(until=25 * US)
    pulse.play(view)
    bench.run("1 us")
    promise, told = out.promise, []
    out.watch(lambda net: told.append((bench.now_ps, net.level)))
    bench.run_to("25 us")
    for until in (40, 60):
        view.of.until = until * US
        pulse.renew()
    bench.run_to("45 us")
    assert out.promise is promise
    assert len(out.log) == 1
    assert told == [(ps * US, level) for ps, level in ((10, 1), (17, 0), (20, 1), (27, 0), (30, 1), (37, 0), (40, 1))]


def test_a_closed_gate_passes_no_notice_of_its_inputs(bench):
    bench.part("and", "a")
    bench.part("inverter", "i")
    bench.wire("a.out", "i.in1")
    pulse = driver(bench, "a.in1")
    driver(bench, "a.in2", 0)
    bench.run(0)
    told = []
    bench.pin("a.out").net.sample(lambda: told.append(bench.now_ps))
    for n in range(5):
        pulse.play(train())
        bench.run(f"{10 + n} us")
        pulse.drive(n % 2)
        bench.run("10 us")
    assert told == []


def test_a_shown_level_stays_until_the_next_round(bench):
    """A wire is driven otherwise in a later round of the instant at which it has risen."""
    bench.part("inverter", "i")
    pulse, out, seen = driver(bench, "i.in1"), bench.pin("i.out"), []
    bench.run(0)
    pulse.play(train())

    def third():
        seen.append(out.level)  # PULSE is driven to 0, which it shows already
        bench.kernel.call_at(bench.now_ps, lambda: seen.append(out.level))

    def second():
        seen.append(out.level)
        pulse.drive(0)
        bench.kernel.call_at(bench.now_ps, third)

    bench.at("20 us", lambda: (seen.append(out.level), bench.kernel.call_at(bench.now_ps, second)))
    bench.run("30 us")
    assert seen == [0, 1, 1, 1]


def test_an_input_handed_from_one_driver_to_another_in_one_instant_leaves_the_train_at_the_output(bench):
    bench.part("nand", "n")
    bench.record("n.out")
    pulse, enable, other = driver(bench, "n.in1"), driver(bench, "n.in2", 1), driver(bench, "n.in2")
    bench.run(0)
    pulse.play(train())
    bench.run("12 us")
    enable.drive(None)
    other.drive(1)
    bench.run("20 us")
    assert edges(bench, "n.out") == [(10 * US, 1), (17 * US, 0), (20 * US, 1), (27 * US, 0), (30 * US, 1)]


# --------------------------------------------------------------------------------------------------------- the wire
def test_an_inverting_wire_passes_on_floating_and_follows_a_train(bench):
    bench.part("delay", "a", delay="1 us")
    bench.part("delay", "b", delay="1 us")
    bench.wire("a.in", "b.in", invert=True)
    one, two = driver(bench, "a.in"), bench.pin("b.in")
    levels = [two.level]
    for level in (0, None, 1):
        one.drive(level)
        bench.run("1 us")
        levels.append(two.level)
    assert levels == [None, 1, None, 0]
    one.play(Wave(1, (5 * US, 6 * US), (0, None)))
    bench.run_to("5 us")
    assert two.level == 1
    bench.run_to("6 us")
    assert two.level is None
    one.play(train())
    bench.run_to("20 us")
    assert type(two.net.promise) is Inverted
    assert bench.kernel.next_time() is None
    assert two.level == 1


# --------------------------------------------------------------------------------------------------------- the delay
def test_a_delay_line_swallows_nothing_and_starts_at_rest(bench):
    bench.part("inverter", "i")
    bench.part("delay", "d", delay="2 us")
    bench.wire("i.out", "d.in")
    bench.record("d.out")
    one = driver(bench, "i.in1", 1)
    bench.run("10 us")
    assert bench.pin("d.out").level == 0
    for level, width in ((0, "1 ns"), (1, "1 us"), (0, "5 us")):
        one.drive(level)
        bench.run(width)
    one.play(Wave(1, (bench.now_ps + 1,), (0,)))  # a pulse of a picosecond
    bench.run("9 us")
    found = edges(bench, "d.out")[-4:]
    assert [ps - 2 * US for ps, _ in found] == [10 * US + 1000, 11 * US + 1000, 16 * US + 1000, 16 * US + 1001]
    assert [level for _, level in found] == [0, 1, 0, 1]
    with pytest.raises(UsageError, match="delay"):
        bench.part("delay", "e", delay=0)


# --------------------------------------------------------------------------------------------------------- circles
def ring(bench, kinds):
    for n, kind in enumerate(kinds):
        bench.part(kind, f"g{n}")
    for n in range(len(kinds)):
        follower = (n + 1) % len(kinds)
        bench.wire(f"g{n}.out", f"g{follower}.in" if kinds[follower] == "delay" else f"g{follower}.in1")


def edge_driven(bench):
    return [name for name, part in bench.parts.items() if getattr(getattr(part, "rule", None), "edge_driven", False)]


@pytest.mark.parametrize("count", [1, 3])
def test_inverters_on_a_ring_never_come_to_rest_and_the_message_names_them(bench, count, monkeypatch):
    monkeypatch.setattr("slewline.core.time.kernel.ROUNDS_LIMIT", 1000)
    ring(bench, ["inverter"] * count)
    with pytest.raises(Endless, match=r"these change each other in a loop without delay: <Net g\d\.out"):
        bench.run("1 us")


def test_a_ring_with_a_delay_line_oscillates(bench):
    ring(bench, ["inverter", "delay", "delay"])
    bench.record("g2.out")
    bench.run("10 us")
    times, levels = bench.edges("g2.out", "1 us", "2 us")
    assert set(times[1:] - times[:-1]) == {200_000}  # two lines of 100 ns
    assert set(levels.tolist()) == {0, 1}
    assert edge_driven(bench) == ["g0", "g1", "g2"]


@pytest.mark.parametrize("late", [False, True])
def test_only_parts_on_a_circle_go_by_edges_however_it_is_wired(bench, late):
    for name in ("q", "nq", "before", "behind"):
        bench.part("nor", name)
    bench.wire("before.out", "q.in2")
    bench.wire("q.out", "behind.in1")
    bench.wire("q.out", "nq.in1")
    if late:
        bench.run("1 us")
        assert edge_driven(bench) == []
    bench.wire("nq.out", "q.in1")
    bench.run("1 us")
    assert edge_driven(bench) == ["q", "nq"]
    found = []
    for name, level in (
        ("before.in1", 0),
        ("before.in2", 0),
        ("nq.in2", 0),
        ("before.in1", 1),
        ("nq.in2", 1),
        ("nq.in2", 0),
    ):
        bench.pin(name).drive(level)
        bench.run("1 us")
        found.append((bench.pin("q.out").level, bench.pin("nq.out").level))
    assert found == [(1, 0), (0, 0), (0, 1), (0, 1), (1, 0), (1, 0)]


def test_a_circle_through_wires_that_invert_is_one(bench):
    bench.part("inverter", "i")
    bench.part("delay", "d")
    bench.wire("i.out", "d.in", invert=True)
    bench.wire("d.out", "i.in1", invert=True)
    bench.run("1 us")
    assert edge_driven(bench) == ["i", "d"]


def test_a_loop_through_a_chip_is_none(bench):
    x = bench.add("cy525", "x")
    bench.part("inverter", "i")
    bench.wire("x.slew", "i.in1")
    bench.wire("i.out", "x.step_inhibit")
    bench.record("x.step_inhibit")
    bench.host(x).send("A 0\rF 10\rR 40\rS 250\rZ 1\rN 2000\rG\r")
    bench.run("2 s")
    assert edge_driven(bench) == []
    assert len(edges(bench, "x.step_inhibit")) == 1  # as soon as it slews, it holds itself for good
    assert 0 < x.position < 2000


def test_a_buffer_has_a_bound_of_its_own(bench):
    bench.part("and", "a", inputs=1)
    pulse = driver(bench, "a.in1")
    bench.run(0)
    view = train()
    pulse.play(view)
    bench.run("12 us")
    promise = bench.pin("a.out").net.promise
    assert (type(promise), promise.of) == (Repeated, view)
    pulse.drive(0)
    bench.run("1 us")
    assert (promise.until, view.until) == (12 * US + 1, None)


# ----------------------------------------------------------------------------------------- mistakes of a part's author
class Dip(Part):
    """Promises a dip of its output, one nanosecond after its input has fallen."""

    def __init__(self, kernel, name):
        super().__init__(kernel, name)
        self.add_pin("in", "in", "input", pull=1)
        self.add_pin("out", "out", "output", initial=1)
        self.rule = Follower(self, ("in",), schedule=self.promise, react=self.promise)

    def rewired(self):
        self.rule.start()

    def promise(self):
        dip = gated([Wave(1, (self.kernel.now + 1000, self.kernel.now + 2000), (0, 1))], (0, 1))
        self.rule.put(self.drivers["out"], 1 if self.high("in") else dip)


def test_releasing_an_input_withdraws_a_promise_before_its_edge_in_that_instant(bench):
    part, levels = bench.part(Dip, "dip"), []
    part.pin("out").net.watch(lambda net: levels.append(net.level))
    part.pin("in").pulse(0, "1 ns", at="5 ns")  # it ends by a release, not by another level
    bench.run("20 ns")
    assert levels == []


class Unstarted(Part):
    """A part with a rule that nothing starts."""

    def __init__(self, kernel, name, *, pin="in"):
        super().__init__(kernel, name)
        self.add_pin("in", "in", "input")
        self.add_pin("out", "out", "output")
        self.rule = Follower(self, (pin,), schedule=print, react=print)


def test_a_rule_names_the_part_and_its_pins_if_an_input_is_unknown(bench):
    with pytest.raises(UnknownName, match=r"^p has no pin 'inn'; its pins: in, out; did you mean in\?$"):
        Unstarted(bench.kernel, "p", pin="inn")
    with pytest.raises(UnknownName, match=r"^p: clock 'out' is not an input of the rule; allowed: in$"):
        Clocked(Unstarted(bench.kernel, "p"), ("in",), clock="out", advance=print, step=print, follow=print)


def test_a_part_whose_rule_is_never_started_is_reported_when_time_is_about_to_pass(bench):
    bench.part(Unstarted, "p")
    with pytest.raises(UsageError, match=r"^p: the rule has not been started\. Call self\.rule\.start\(\) in rewired"):
        bench.run("1 us")
