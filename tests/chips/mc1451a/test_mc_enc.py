"""The encoder chip: filters on its inputs, and the counter of quadrature states."""

from __future__ import annotations

from itertools import accumulate, pairwise
from random import Random

import pytest

from slewline.chips.mc1451a.axis.enc import FilteredInput, QuadratureCounter
from slewline.core.datasheet.table import Pin
from slewline.core.motion.step_views import PulseView
from slewline.core.motion.train import OPEN, Playing, StepTrain
from slewline.core.time.kernel import Kernel
from slewline.core.time.timebase import Clock
from slewline.core.wires.net import Driver, Net, Wave
from slewline.core.wires.pin import Terminal
from tests.ensembles import few

NS, US, MS = 1_000, 1_000_000, 1_000_000_000
CYCLE = 8192
FORWARD = ["00", "10", "11", "01"]  # A and B
CRYSTALS = (25_000_000, 24_999_999, 6_700_000)


class Inputs:
    """The channels of an axis, driven by tick or by instant."""

    def __init__(self, hz=25_000_000):
        self.clock, self.kernel, self.findings = Clock(hz), Kernel(), []
        self.pins = {name: self.pin(name) for name in ("quada1", "quadb1", "home1")}
        self.drivers = {name: Driver(pin.net, name) for name, pin in self.pins.items()}
        self.counter = QuadratureCounter(
            self.pins["quada1"], self.pins["quadb1"], self.clock, lambda *found: self.findings.append(found)
        )
        self.home = FilteredInput(self.pins["home1"], self.clock)
        self.put("quada1", 0)
        self.put("quadb1", 0)
        self.put("home1", 1)

    def pin(self, name):
        return Terminal("x", Pin(1, name, "in", name), Net(self.kernel, name, 0))

    def put(self, name, level):
        self.drivers[name].drive(level)
        self.kernel.settle()

    def state(self, levels):
        self.put("quada1", int(levels[0]))
        self.put("quadb1", int(levels[1]))

    def run(self, tick):
        self.kernel.run(self.clock.ps(tick))

    def wave(self, name, ticks, levels, early=lambda period: 0):
        """Promise levels that are there at ticks, having come at most a clock period before."""
        clock = self.clock
        times = tuple(clock.ps(tick) - early(clock.n // clock.d) for tick in ticks)
        self.drivers[name].play(Wave(0, times, tuple(levels)))
        self.kernel.settle()

    def quadrature(self, state_ps, periods, start=None):
        """Promise periods of a forward turn, each state as long as said."""
        start = self.kernel.now + state_ps if start is None else start
        for name, quarter in (("quada1", 0), ("quadb1", 1)):
            times = tuple(start + (4 * n + quarter + 2 * half) * state_ps for n in range(periods) for half in (0, 1))
            self.drivers[name].play(Wave(0, times, (1, 0) * periods))
        self.kernel.settle()

    def counts(self, tick):
        """What a look at a tick finds."""
        self.kernel.run(self.clock.ps(tick) - 1)
        return self.counter.counts_before(tick)

    @property
    def codes(self):
        return [code for code, _ in self.findings]


# ------------------------------------------------------------------------------------------------------------ decoding
@pytest.mark.fact("PMD-ENC-1")
def test_a_period_gives_four_counts():
    i = Inputs()
    i.quadrature(10 * US, 250)
    assert i.counts(10 * CYCLE) == 4 * 80 + 7  # 3,276.8 us
    assert i.counts(50 * CYCLE) == 1000
    assert i.findings == []


@pytest.mark.fact("PMD-ENC-2")
def test_a_leading_b_counts_up_and_a_lagging_b_counts_down():
    i = Inputs()
    tick, found = 100, []
    i.counts(tick)
    for levels in (FORWARD * 3)[1:] + (FORWARD * 4)[:1] + FORWARD[::-1] * 4:
        i.state(levels)
        tick += 100
        found.append(i.counts(tick))
    assert found == [*range(1, 13), *range(11, -4, -1), -4]
    assert i.findings == []


@pytest.mark.fact("PMD-ENC-2")
@pytest.mark.parametrize("turned", range(4))
def test_the_first_state_is_the_one_that_the_chip_wakes_up_to(turned):
    i = Inputs()
    first, then = (FORWARD * 2)[turned : turned + 2]
    assert i.counter.counts_before(0) == 0  # its own instant has not come to its end
    i.state(first)
    assert i.counts(CYCLE) == 0
    i.state(then)
    assert i.counts(2 * CYCLE) == 1
    i.counter.begin()
    i.state(FORWARD[turned])
    assert (i.counts(3 * CYCLE), i.findings) == (0, [])


@pytest.mark.fact("PMD-ENC-6", "PMD-UND-ENC-ILLEGAL")
@pytest.mark.parametrize("apart_ps", [0, 1, 39 * NS])
def test_a_change_of_both_channels_at_one_tick_is_not_counted_but_taken_over(apart_ps):
    i = Inputs()
    i.run(199)
    i.kernel.run(i.kernel.now + 1)
    i.put("quada1", 1)
    i.kernel.run(i.kernel.now + apart_ps)
    i.put("quadb1", 1)
    assert i.counts(CYCLE) == 0
    assert i.codes == ["encoder-illegal"]
    i.state("01")
    assert i.counts(2 * CYCLE) == 1  # 11 to 01: forward
    assert len(i.findings) == 1


@pytest.mark.fact("PMD-UND-ENC-ILLEGAL")
def test_changes_one_tick_apart_are_two_counts():
    i = Inputs()
    i.run(200)
    i.put("quada1", 1)
    i.run(201)
    i.put("quadb1", 1)
    assert i.counts(CYCLE) == 2
    assert i.codes == ["encoder-fast"]


# -------------------------------------------------------------------------------------------------------------- filter
@pytest.mark.fact("PMD-ENC-3")
@pytest.mark.parametrize(("width", "counted"), [(320 * NS, 0), (440 * NS, 0), (480 * NS, 1), (640 * NS, 1)])
@pytest.mark.parametrize("plus", [0, 17_001])
def test_a_level_counts_only_when_it_has_lasted_480_ns(width, counted, plus):
    i = Inputs()
    start = 100 * 40 * NS + plus
    i.drivers["quada1"].play(Wave(0, (start, start + width), (1, 0)))
    i.kernel.settle()
    seen = [i.counts(tick) for tick in range(100, 200)]
    assert max(seen) == counted
    assert seen[-1] == 0


@pytest.mark.fact("PMD-ENC-3")
@pytest.mark.parametrize("hz", CRYSTALS)
def test_a_change_at_a_tick_is_seen_twelve_ticks_later_and_not_before(hz):
    i = Inputs(hz)
    i.run(1_000_001)
    i.put("quada1", 1)
    assert [i.counts(1_000_001 + n) for n in (11, 12, 13)] == [0, 0, 1]


@pytest.mark.fact("PMD-HOME-3", "PMD-UND-HOME-SAMPLE")
def test_home_goes_through_the_same_filter():
    i = Inputs()
    ticks = [500, 508, 9000, 9000 + 2 * CYCLE]  # 320 ns, two cycles
    i.drivers["home1"].play(Wave(1, tuple(i.clock.ps(tick) for tick in ticks), (0, 1, 0, 1)))
    i.kernel.settle()
    seen = []
    for tick in [400, 510, 515, 525, 1000, 9012, 9013, *range(2 * CYCLE, 6 * CYCLE, CYCLE)]:
        i.kernel.run(i.clock.ps(tick))
        seen.append(i.home.level_before(tick))
    assert seen == [1, 1, 1, 1, 1, 1, 0, 0, 0, 1, 1]


@pytest.mark.fact("PMD-UND-HOME-OPEN")
def test_an_open_input_reads_low_after_the_filter_and_a_tied_one_its_level():
    kernel = Kernel()
    for tie, pull, level in ((1, None, 1), (None, None, 0), (None, 0, 0)):
        pin = Terminal("x", Pin(1, "home1", "in", "home"), Net(kernel, "home1", pull, tie))
        assert FilteredInput(pin, Clock(25_000_000)).level_before(CYCLE) == level


def glitchy(random, ticks, crowded):
    """Ticks at which a channel changes, some of them close to each other."""
    found, tick = [], 4 * random.randrange(1, 15)
    while tick < ticks:
        found.append(tick)
        tick += random.choice(crowded)
    return found


def filtered(changes, ticks):
    """Tick by tick: the level at a tick is the one of the last twelve before, if they were alike."""
    level, lasts, seen, out, at = 0, 0, 0, [], set(changes)
    for tick in range(ticks):
        if lasts >= 12:
            level = seen
        out.append(level)
        lasts = 0 if tick in at else lasts
        seen ^= tick in at
        lasts += 1
    return out


def decoded(a, b):
    """Counts by tick, and how often both channels changed."""
    counts, illegal = [0], 0
    for (a0, b0), (a1, b1) in pairwise(zip(a, b, strict=True)):
        turn = (FORWARD.index(f"{a1}{b1}") - FORWARD.index(f"{a0}{b0}") + 1) % 4 - 1
        illegal += turn == 2
        counts.append(counts[-1] + (turn if turn != 2 else 0))
    return counts, illegal


@pytest.mark.fact("PMD-ENC-3", "PMD-ENC-6")
@pytest.mark.parametrize("hz", CRYSTALS)
@pytest.mark.parametrize("seed", few(range(12), 2))
@pytest.mark.parametrize("crowded", [(5, 11, 12, 13, 25, 40), (12, 20, 24), (40,)])
def test_filter_and_counter_agree_with_a_sample_at_every_tick(hz, seed, crowded):
    random, ticks = Random(seed), 6000
    i = Inputs(hz)
    channels = [glitchy(random, ticks - 20, crowded) for _ in "ab"]
    for name, changes in zip(("quada1", "quadb1"), channels, strict=True):
        i.wave(name, changes, [1 - n % 2 for n in range(len(changes))], random.randrange)
    expected, illegal = decoded(*(filtered(changes, ticks) for changes in channels))
    looks = [*sorted(random.sample(range(1, ticks), random.choice([1, 5, 300]))), ticks]
    assert [i.counts(tick) for tick in looks] == [expected[tick - 1] for tick in looks]
    assert i.codes.count("encoder-illegal") == illegal
    if crowded == (12, 20, 24):
        assert illegal


# ---------------------------------------------------------------------------------------------------------------- rates
@pytest.mark.fact("PMD-ENC-4")
@pytest.mark.parametrize("often", [True, False])
def test_at_1_25_million_counts_a_second_none_is_lost(often):
    i = Inputs()
    i.quadrature(800 * NS, 31_250, start=800 * NS)
    if often:
        found = [i.counts(n * CYCLE) for n in range(1, 101)]
        assert {two - one for one, two in pairwise(found)} == {409, 410}
        assert found == [(n * CYCLE - 13) // 20 for n in range(1, 101)]
    assert i.counts(2_500_000 + 13) == 125_000
    assert i.findings == []


@pytest.mark.fact("PMD-UND-ENC-FAST")
@pytest.mark.parametrize("periods", [5, 50, 5000])
def test_faster_counts_count_and_every_burst_is_reported_once(periods):
    i = Inputs()
    for state_ns, bursts in ((500, 1), (760, 2), (800, 2), (500, 3), (1600, 3), (760, 4)):
        before = i.counter.counts
        i.quadrature(state_ns * NS, periods)
        i.kernel.run(i.kernel.now + (4 * periods + 2) * state_ns * NS)
        assert i.counter.counts_before(i.clock.ticks_until(i.kernel.now)) == before + 4 * periods
        assert i.codes == ["encoder-fast"] * bursts


@pytest.mark.fact("PMD-UND-ENC-FAST")
@pytest.mark.parametrize("every", [500, 3000, 50 * CYCLE])
@pytest.mark.parametrize(
    ("lasts", "bursts"),
    [([700, 900, 700, 1500, 700, 1600, 900, 700, 2000] * 400, 800), (([700] * 300 + [1700] * 300) * 4, 4)],
)
def test_a_shaft_that_is_now_and_then_too_fast_is_one_burst_until_it_is_slow(lasts, bursts, every):
    i = Inputs()
    times = list(accumulate((ns * NS for ns in lasts), initial=10 * US))
    for name, own in (("quada1", times[::2]), ("quadb1", times[1::2])):
        i.drivers[name].play(Wave(0, tuple(own), tuple(1 - n % 2 for n in range(len(own)))))
    i.kernel.settle()
    assert [i.counts(tick) for tick in range(every, 50 * CYCLE + 1, every)][-1] == len(times)
    assert len(i.findings) == bursts


@pytest.mark.fact("PMD-UND-ENC-FAST")
def test_states_below_the_filter_are_lost():
    i = Inputs()
    for name, origin in (("quada1", 0), ("quadb1", 5)):
        train = StepTrain(i.clock, origin, [(20, OPEN)])
        i.drivers[name].play(PulseView(Playing(train), 10))
    i.kernel.settle()
    assert i.counts(50 * CYCLE) == 0
    assert i.findings == []


# ----------------------------------------------------------------------------------------------------- asked and asleep
@pytest.mark.fact("PMD-ENC-5")
def test_quiet_reports_that_no_count_can_come_and_a_change_is_reported():
    i = Inputs()
    told = []
    i.counter.watch(lambda: told.append(i.kernel.now))
    assert i.counts(CYCLE) == 0
    assert i.counter.quiet
    i.run(2 * CYCLE - 6)
    i.put("quadb1", 1)
    assert told == [i.kernel.now]
    assert i.counts(2 * CYCLE) == 0
    assert not i.counter.quiet  # the filter holds a change back
    assert i.counts(3 * CYCLE) == -1
    assert i.counter.quiet
    i.put("quadb1", 0)
    i.quadrature(10 * US, 1)
    assert len(told) == 4
    assert not i.counter.quiet
    assert i.counts(4 * CYCLE) == 4
    assert i.counter.quiet


def test_a_train_costs_no_event_until_it_is_queried():
    i = Inputs()
    for name, origin in (("quada1", 20), ("quadb1", 40)):
        i.drivers[name].play(PulseView(Playing(StepTrain(i.clock, origin, [(80, OPEN)])), 40))
    i.kernel.settle()
    i.run(25_000_000)
    assert i.kernel.next_time() is None
    assert i.counter.counts_before(25_000_000) == (25_000_000 - 13) // 20


# ---------------------------------------------------------------------------------------------------------- look ahead
def windows(i, cycles):
    """The lengths of the windows, in cycles, out of which the counter answers, asked in each of some cycles."""
    found = []
    for n in cycles:
        i.counts(n * CYCLE)
        window = i.counter.window
        if window is not None and (not found or window.stop != found[-1][1]):
            found.append((n, window.stop))
    return [stop // CYCLE - n for n, stop in found]


def test_a_window_is_twice_as_long_as_the_one_before_and_short_again_when_a_driver_is_notified(monkeypatch):
    monkeypatch.setattr(QuadratureCounter, "most", 16)
    i = Inputs()
    i.quadrature(100 * US, 2000)
    assert windows(i, range(1, 60)) == [4, 8, 16, 16, 16]
    i.quadrature(100 * US, 2000)
    assert windows(i, range(60, 70)) == [4, 8]
    assert i.findings == []


def test_a_query_of_the_past_counts_up_to_the_last_query_and_counting_continues():
    i = Inputs()
    i.quadrature(100 * US, 2000)
    assert [i.counts(n * CYCLE) for n in range(1, 9)] == [3 * n + (n * 27_680) // 100_000 for n in range(1, 9)]
    assert i.counter.window.stop > 9 * CYCLE
    history = [*i.counter.history]
    assert [count for _, count in history] == [*range(27)] and history[-1][0] < 8 * CYCLE
    assert i.counts(9 * CYCLE) == 29 and i.counter.history.last == 29


def test_a_window_with_a_finding_is_refused_and_findings_come_when_they_happen():
    i = Inputs()
    both = 3 * CYCLE + 100
    i.wave("quada1", [500, both, 4 * CYCLE], [1, 0, 1])
    i.wave("quadb1", [both, 4 * CYCLE + 40], [1, 0])
    told = []
    for n in range(1, 12):
        i.counts(n * CYCLE)
        told.append((len(i.findings), i.counter.window is not None))
    assert told == [(0, False)] * 3 + [(1, False)] + [(1, True)] * 7


@pytest.mark.parametrize("asked", [5, 7])  # there it is asked last: where a window begins, and in it
def test_a_reset_in_a_window_starts_it_again(asked):
    i = Inputs()
    i.quadrature(100 * US, 2000)
    for n in range(1, asked + 1):
        before = i.counts(n * CYCLE)
    assert i.counter.window.stop == 13 * CYCLE
    i.run(asked * CYCLE + 300)
    i.counter.begin()
    i.kernel.settle()
    assert i.counter.window is None
    assert i.counts((asked + 1) * CYCLE) == 3
    assert [count for _, count in i.counter.history] == [*range(before + 1), 0, 1, 2, 3]


def test_a_count_at_the_very_tick_of_the_query_comes_later():
    i = Inputs()
    i.wave("quada1", [2 * CYCLE - 12], [1])
    assert (i.counts(CYCLE), i.counter.quiet) == (0, False)
    assert (i.counts(2 * CYCLE), i.counter.quiet) == (0, False)
    assert (i.counts(3 * CYCLE), i.counter.quiet) == (1, True)
