"""Encoders: counts follow the steps, whatever drives PULSE, and a shaft may be blocked, slip or be turned by hand."""

from __future__ import annotations

from bisect import bisect_right
from fractions import Fraction
from random import Random

import pytest

import slewline
from slewline.chips.mc1451a.axis.pin_edges import PinEdges
from slewline.chips.mc1451a.profiles.cycle_train import CycleTrain, Linear, SquareView
from slewline.chips.mc1451a.profiles.s_curves import PLACES, JerkPiece, SCurve
from slewline.core.motion.step_views import PulseView, StrobeView
from slewline.core.motion.train import OPEN, Playing, StepTrain
from slewline.core.time.events import ask_at
from slewline.core.time.kernel import Kernel
from slewline.core.time.timebase import Clock
from slewline.core.wires.clocking import clock_edges
from slewline.core.wires.net import Driver, Net, Wave
from slewline.parts.shafts.encoder import Encoder, Quadrature
from slewline.parts.shafts.shaft_counter import CountScale, StepCounter
from slewline.parts.shafts.shaft_motion import ShaftMotion
from slewline.parts.shafts.shown import EncoderChannel, LevelPattern
from tests.ensembles import few

US, MS = 1_000_000, 1_000_000_000
END = 3 * MS  # of a story
CLOCK = Clock(25_000_000)
LEVELS = ((0, 0), (1, 0), (1, 1), (0, 1))  # A and B, by the count


class Rig:
    """An encoder, and a chip's outputs on its inputs."""

    def __init__(self, level=1, lag="1 us", **options):
        self.kernel = Kernel()
        self.encoder = Encoder(self.kernel, "enc", **options | {"lag": f"{lag} ps" if isinstance(lag, int) else lag})
        self.pulse, self.dir = (Driver(self.encoder.pin(name).net, "chip") for name in ("pulse", "dir"))
        self.pulse.drive(level)
        self.dir.drive(1)
        self.kernel.settle()
        self.readings = {name: PinEdges(self.encoder.pin(name)) for name in "ab"}
        self.encoder.rewired()
        self.kernel.settle()

    def steps(self, interval_us, count=OPEN):
        """Steps from now on, the first one now."""
        train = StepTrain(CLOCK, CLOCK.ticks_from(self.kernel.now), [(25 * interval_us, count)])
        self.pulse.play(PulseView(Playing(train), 10))
        self.kernel.settle()

    def step(self, forward=True):
        """A step by levels, now."""
        self.dir.drive(int(forward))
        for level in (1, 0):
            self.pulse.drive(level)
            self.kernel.settle()

    def run(self, ps):
        self.kernel.run(self.kernel.now + ps)

    def edges(self):
        """Edges of A and B up to now, since the last question: (instant, pin, level)."""
        found = []
        for name, reading in self.readings.items():
            times, levels = reading.edges_until(self.kernel.seen)
            found += [(int(time), name, int(level)) for time, level in zip(times, levels, strict=True)]
        return sorted(found)


def shown(timeline):
    """Edges of A and B from counts: (instant, count), ascending; of equal instants the last one counts."""
    edges, before = [], 0
    for time, count in dict(timeline).items():
        for name, was, now in zip("ab", LEVELS[before % 4], LEVELS[count % 4], strict=True):
            if was != now:
                edges.append((time, name, now))
        before = count
    return edges


# ------------------------------------------------------------------------------------------------------------ following
def test_counts_are_the_steps_made_times_the_ratio_rounded_down():
    rig = Rig()
    steps = 0
    for forward, number in ((True, 40), (False, 100), (True, 61)):
        for _ in range(number):
            rig.step(forward)
            steps += 1 if forward else -1
            rig.run(10 * US)
            assert rig.encoder.counts == steps * 4000 // 12800
    assert steps == 1


def test_a_count_follows_its_step_by_the_lag_and_a_is_ahead_of_b():
    rig = Rig(counts=1, steps=1, lag="3 us")
    for n in range(1, 6):
        rig.kernel.run(n * 10 * US)
        rig.step()
    rig.run(1 * MS)
    assert rig.edges() == [
        (13 * US, "a", 1), (23 * US, "b", 1), (33 * US, "a", 0), (43 * US, "b", 0), (53 * US, "a", 1),
    ]  # fmt: skip


@pytest.mark.parametrize("reverse", [False, True])
def test_dir_and_reverse_turn_the_count_round(reverse):
    rig = Rig(counts=1, steps=1, reverse=reverse)
    for forward in (False, False, True, False):
        rig.step(forward)
        rig.run(5 * US)
    assert rig.encoder.counts == (2 if reverse else -2)


def test_the_direction_is_that_of_the_fall():
    rig = Rig(counts=1, steps=1)
    found = []
    for pulse, direction in ((1, 0), (1, 1), (0, 1), (0, 0), (1, 0), (1, 1), (0, 0), (1, 0), (0, 1)):
        rig.pulse.drive(pulse)
        rig.dir.drive(direction)  # takes effect together with PULSE
        rig.kernel.settle()
        rig.run(2 * US)
        found.append(rig.encoder.counts)
    assert found == [0, 0, 1, 1, 1, 1, 0, 0, 1]


def test_pulse_that_is_low_from_the_beginning_has_not_fallen():
    rig = Rig(level=0, counts=1, steps=1)
    rig.run(10 * US)
    assert rig.encoder.counts == 0
    rig.step()
    rig.run(10 * US)
    assert rig.encoder.counts == 1


def test_a_step_at_the_instant_of_several_changes_is_counted_once():
    rig = Rig(counts=1, steps=1)
    rig.steps(10)
    rig.run(10 * US)  # the second step falls now
    for _ in range(3):
        rig.pulse.renew()
        rig.kernel.settle()
    rig.run(9 * US)
    assert rig.encoder.counts == 2
    for way in (0, 1, 0, 1):
        rig.dir.drive(way)
        rig.kernel.settle()
    rig.run(3 * US)
    assert rig.encoder.counts == 3


def test_where_another_output_pulls_pulse_low_there_is_no_step():
    rig = Rig(counts=1, steps=1)
    other = Driver(rig.encoder.pin("pulse").net, "other")
    rig.steps(10)
    rig.run(45 * US)  # five steps, and PULSE is low
    other.drive(0)
    rig.run(50 * US)
    assert rig.encoder.counts == 5
    other.drive(None)  # PULSE is low under the train, too
    rig.run(30 * US)
    assert rig.encoder.counts == 8


def test_while_pulse_follows_a_train_no_step_is_an_event():
    rig = Rig(counts=3, steps=7)
    rig.steps(10)
    rig.run(1000 * MS)
    assert rig.kernel.next_time() is None
    assert rig.encoder.counts == 100_000 * 3 // 7
    changes = [-(-j * 7 // 3) for j in range(1, 100_000 * 3 // 7 + 1)]  # the step that makes each count
    assert rig.edges() == shown([((k - 1) * 10 * US + US, j) for j, k in enumerate(changes, 1)])


def test_a_watched_channel_wakes_at_its_own_edges_only():
    rig = Rig()
    rig.steps(10)
    seen = []
    rig.encoder.pin("a").net.watch(lambda net: seen.append((rig.kernel.now, net.level)))
    rig.run(100 * MS)
    assert seen == [(time, level) for time, name, level in rig.edges() if name == "a"]
    assert len(seen) == 10_000 * 4000 // 12800 // 2 + 1


def test_a_bound_that_moves_moves_what_a_watcher_of_the_encoder_waits_for():
    rig = Rig(counts=1, steps=1)
    rig.steps(10)
    playing = rig.pulse.promise.of
    seen = []
    for name in "ab":
        rig.encoder.pin(name).net.watch(lambda net: seen.append(rig.kernel.now))
    rig.run(5 * US)
    for until in (10 * US, 25 * US, 60 * US):
        playing.until = until
        rig.pulse.renew()
        rig.kernel.run(until)
    assert seen == [1 * US, 11 * US, 21 * US, 31 * US, 41 * US, 51 * US]
    assert rig.encoder.counts == 6


def test_counts_of_a_step_of_several_follow_each_other():
    rig = Rig(counts=1000, steps=200, lag="1 us")
    rig.kernel.run(10 * US)
    rig.step()
    rig.kernel.run(100 * US)
    assert rig.edges() == shown([(11 * US + n * 800_000, n + 1) for n in range(5)])
    rig.step()
    rig.kernel.run(102 * US)  # on its way, the next step takes it further
    rig.step()
    rig.kernel.run(200 * US)
    assert (
        rig.edges()
        == shown(
            [
                (0, 5),
                *((101 * US + n * 800_000, 6 + n) for n in range(3)),
                *((103 * US + n * 800_000, 11 + n) for n in range(5)),
            ]
        )[1:]
    )
    assert rig.encoder.counts == 15


# -------------------------------------------------------------------------------------------- blocked, slipping, pushed
def test_a_blocked_shaft_loses_steps_and_follows_from_where_it_is():
    rig = Rig()
    rig.steps(10)
    rig.run(99 * US)  # 10 steps
    rig.encoder.block()
    rig.run(1000 * US)
    assert rig.encoder.counts == 10 * 4000 // 12800 == 3
    assert rig.kernel.next_time() is None
    assert rig.encoder.pin("a").net.promise.after(rig.kernel.now) is None  # and nothing will come
    rig.encoder.free()
    rig.run(10 * MS)
    assert rig.encoder.counts == 1010 * 4000 // 12800


def test_a_slip_loses_an_exact_number_of_counts_in_either_direction():
    rig = Rig(counts=4000, steps=12800)
    rig.encoder.slip(5)
    rig.steps(10)
    rig.run(3199 * US)  # 320 steps, 100 counts
    assert rig.encoder.counts == 95
    rig.encoder.slip(10)
    rig.encoder.slip(20)
    rig.dir.drive(0)
    rig.kernel.settle()
    rig.run(3200 * US)
    assert rig.encoder.counts == 95 - 70


def test_a_push_turns_the_shaft_one_count_after_the_other():
    rig = Rig()
    rig.kernel.run(10 * US)
    rig.encoder.push(3)
    assert not rig.encoder.idle
    assert rig.encoder.waiting == "enc: turning 2 more counts by hand"
    rig.run(1 * MS)
    assert rig.edges() == [(11 * US, "a", 1), (13 * US, "b", 1), (15 * US, "a", 0)]
    rig.encoder.push(-5)
    rig.run(3 * US)
    rig.encoder.push(2)
    rig.run(1 * MS)
    assert (rig.encoder.counts, rig.encoder.idle) == (0, True)
    assert rig.encoder.waiting == "enc: nothing to do"


def test_pushes_come_one_after_the_other():
    rig = Rig()
    for n in (1, 2):
        rig.encoder.push(n)
    rig.run(1 * US)
    rig.encoder.push(1)
    rig.run(1 * MS)
    assert rig.edges() == [(1 * US, "a", 1), (3 * US, "b", 1), (5 * US, "a", 0), (7 * US, "b", 0)]


def test_a_blocked_shaft_can_be_pushed_while_the_motor_runs():
    rig = Rig(counts=1, steps=1)
    rig.steps(7)
    rig.encoder.block()
    rig.run(100 * US)
    rig.encoder.push(4)
    rig.run(100 * US)
    assert rig.encoder.counts == 5  # the first step was before the block


# ----------------------------------------------------------------------------------------------------------- at random
class Naive:
    """A shaft that makes one step after the other; `timeline` is what its outputs show: (instant, count)."""

    def __init__(self, counts, steps, lag, reverse):
        self.counts, self.steps, self.lag, self.reverse = counts, steps, lag, reverse
        self.place = self.slack = 0
        self.timeline = [(0, 0)]

    def fall(self, ps, forward):
        way = 1 if forward != self.reverse else -1
        lost = min(self.slack, self.counts)
        self.slack -= lost
        old = self.place // self.steps
        self.place += way * (self.counts - lost)
        new = self.place // self.steps
        if new != old:
            self.timeline = [entry for entry in self.timeline if entry[0] < ps + self.lag]
            for n, count in enumerate(range(old + way, new + way, way)):
                self.timeline.append((ps + self.lag + n * 800_000, count))

    def push(self, ps, way):
        self.place += way * self.steps
        due = ps + self.lag
        over = bisect_right(self.timeline, due, key=lambda entry: entry[0])
        later = [(time, count + way) for time, count in self.timeline[over:]]
        self.timeline = [*self.timeline[:over], (due, self.timeline[over - 1][1] + way), *later]


RATIOS = [(4000, 12800), (1, 1), (3, 7), (7, 3), (20, 1), (1, 30), (999, 1000)]


class Story:
    """What happens to a motor and its shaft, the same for every rig: drives of PULSE, DIR, and a user's hands."""

    def __init__(self, seed):
        random = Random(seed)
        counts, steps = random.choice(RATIOS)
        lag = random.choice([1, 1 * US, 1 * US + 7, 30 * US, 400 * US])
        self.options = {"counts": counts, "steps": steps, "lag": lag, "reverse": random.random() < 0.3}
        self.drives, self.hands = [], []
        for _ in range(random.randrange(1, 12)):
            kind = random.choice([self.train, self.train, self.cycles, self.curve, self.level, self.dir, self.bound])
            at, chance = (
                random.choice([40_000 * random.randrange(1, 50_000), random.randrange(1, 2 * MS)]),
                random.random(),
            )
            self.drives.append((at, kind, chance))
        for _ in range(random.randrange(6)):
            verb, number = random.choice([("block",) * 2, ("free",) * 2, ("slip", random.randrange(9)), ("push", 0)])
            self.hands.append((random.randrange(1, 2 * MS), verb, number))

    def tell(self, kernel, pulse, direction):
        """Let it happen on two wires."""
        self.views = {}
        for at, kind, chance in self.drives:
            kernel.call_at(at, lambda kind=kind, chance=chance: kind(kernel.now, pulse, direction, Random(chance)))

    def play(self, pulse, view, now, random):
        view.of.until = random.choice([None, now + random.randrange(1, 800 * US)])
        self.views[pulse] = view
        pulse.play(view)

    def train(self, now, pulse, direction, random):
        runs = [(random.randrange(30, 1500), random.choice([1, 5, 200])) for _ in range(3)] + [
            (25, random.choice([1, OPEN]))
        ]
        playing = Playing(StepTrain(CLOCK, CLOCK.ticks_from(now) + random.randrange(-30, 30), runs))
        self.play(pulse, random.choice([PulseView, StrobeView])(playing, 12), now, random)

    def cycles(self, now, pulse, direction, random):
        law = Linear(random.randrange(1, 300 << 16), random.randrange(1, 1 << 16))
        self.cycle_train(now, pulse, law, random.randrange(1, 6), random)

    def curve(self, now, pulse, direction, random):
        end, speed = random.randrange(1, 8), random.randrange(1, 40 << 16) << PLACES
        curve = [JerkPiece(0, 1, 0, 0, speed // end, speed // end**2), JerkPiece(end, 3, 0, 3 * speed, -speed // 9, 0)]
        curve[1] = curve[1]._replace(position=curve[0].covered(end))
        law = SCurve([*curve, JerkPiece(end + 9, 7, curve[1].covered(end + 9), 0, 0, 0)])
        self.cycle_train(now, pulse, law, end + 9, random)

    def cycle_train(self, now, pulse, law, cycles, random):
        train = CycleTrain(CLOCK, CLOCK.ticks_from(now), law, cycles, random.randrange(-65535, 65536))
        self.play(pulse, SquareView(Playing(train), random.random() < 0.5), now, random)

    def level(self, now, pulse, direction, random):
        pulse.drive(random.choice([0, 1]))

    def dir(self, now, pulse, direction, random):
        times = (now + random.randrange(1, 200 * US), now + 300 * US)
        direction.play(Wave(random.choice([0, 1]), times, random.choice([(0, 1), (1, 0)])))

    def bound(self, now, pulse, direction, random):
        view = self.views.get(pulse)
        if view is not None and pulse.promise is view and (view.of.until is None or view.of.until >= now):
            view.of.until = now + random.randrange(1, 400 * US)
            pulse.renew()

    def edges(self):
        """The edges of the two wires, seen by somebody who watches: (instant, wire, level)."""
        kernel = Kernel()
        pulse, direction = Net(kernel, "pulse"), Net(kernel, "dir")
        seen = []
        drivers = [Driver(net, "chip") for net in (pulse, direction)]
        for driver in drivers:
            driver.drive(1)
        kernel.settle()
        for wire, net in enumerate((direction, pulse)):
            net.watch(lambda net, wire=wire: seen.append((kernel.now, wire, net.level)))
        self.tell(kernel, *drivers)
        kernel.run(END)
        return sorted(seen)

    def pushes(self):
        """The single counts of the pushes, one after the other: instants."""
        found = []
        for at in sorted(at for at, verb, _ in self.hands if verb == "push"):
            first = at if not found else max(at, found[-1] + 2 * US)
            found += [first + n * 2 * US for n in range(7)]
        return found

    def naive(self):
        shaft, forward = Naive(**self.options), True
        events = [(at, 0, verb, number) for at, verb, number in self.hands if verb != "push"]
        events += [(at, 0, "push", 7) for at in self.pushes()]
        events += [(time, 1 + wire, "", level) for time, wire, level in self.edges()]
        for time, kind, verb, number in sorted(events):
            if kind == 1:
                forward = number == 1
            elif kind == 2:
                if number == 0:
                    shaft.fall(time, forward)
            elif verb == "push":
                shaft.push(time, 1)
            else:
                shaft.slack = {"block": 1 << 99, "free": 0}.get(verb, shaft.slack)
                shaft.slack += number * shaft.steps if verb == "slip" else 0
        return [edge for edge in shown(shaft.timeline) if edge[0] <= END]

    def rig(self, by_edges, watched, seed):
        """The edges of the encoder's outputs."""
        rig, random, found, seen = Rig(**self.options), Random(seed), [], []
        for at, verb, number in self.hands:
            arguments = {"slip": (number,), "push": (7,)}.get(verb, ())
            rig.kernel.call_at(at, lambda verb=verb, arguments=arguments: getattr(rig.encoder, verb)(*arguments))
        if by_edges:
            for time, wire, level in self.edges():
                driver = rig.pulse if wire else rig.dir
                rig.kernel.call_at(time, lambda driver=driver, level=level: driver.drive(level))
        else:
            self.tell(rig.kernel, rig.pulse, rig.dir)
        for name in "ab" if watched else "":
            rig.encoder.pin(name).net.watch(lambda net, name=name: seen.append((rig.kernel.now, name, net.level)))
        for at in sorted(random.sample(range(1, END), random.choice([0, 1, 30]))):
            rig.kernel.run(at)
            found += rig.edges()
        rig.kernel.run(END)
        found += rig.edges()
        assert not watched or sorted(seen) == sorted(found)
        return sorted(found)


def compare_with_one_step_after_the_other(seed):
    story = Story(seed)
    expected = story.naive()
    assert story.rig(False, False, seed) == expected
    assert story.rig(True, False, seed) == expected
    if seed % 3 == 0:
        assert story.rig(False, True, seed) == expected


@pytest.mark.parametrize("seed", few(range(40), 5))
def test_promised_steps_and_single_edges_turn_the_shaft_as_one_step_after_the_other_does(seed):
    compare_with_one_step_after_the_other(seed)


@pytest.mark.long
@pytest.mark.timeout(600)
def test_they_do_so_in_two_thousand_more_stories():
    for seed in range(40, 2080):
        compare_with_one_step_after_the_other(seed)


@pytest.mark.parametrize("seed", few(range(60), 10))
def test_level_after_and_edges_of_a_channel_agree(seed):
    random = Random(seed)
    view = PulseView(Playing(StepTrain(CLOCK, 3, [(random.randrange(2, 40), 9), (30, OPEN)])), 1)
    view.of.until = random.choice([None, 40_000 * random.randrange(400)])
    counts, steps = random.choice(RATIOS)
    motion = ShaftMotion(
        clock_edges(view, 0, 0), since=0, sign=random.choice([1, -1]), place=8 * steps + random.randrange(steps),
        step=counts, unit=counts, slack=random.choice([0, steps // 2, 7 * steps]),
    )  # fmt: skip
    coming = ([10_000, 90_000, 1_700_000], [8, 9, 8])
    counter = StepCounter(motion, CountScale(Fraction(counts, steps)), 50_000, before=7, coming=coming)
    for channel in (EncoderChannel(counter, LevelPattern(*levels)) for levels in zip(*LEVELS, strict=True)):
        instants = range(0, 12_000_000, 10_000)  # everything happens then
        levels = [channel.level(ps) for ps in instants]
        edges = [ps for ps, was, now in zip(instants[1:], levels, levels[1:], strict=False) if was != now]
        assert edges
        times, shown_levels = channel.edges(instants[0], instants[-1])
        assert [int(time) for time in times] == edges
        assert [int(level) for level in shown_levels] == [channel.level(ps) for ps in edges]
        for start in random.sample(instants, 20):
            stop = random.choice(instants)
            assert [int(time) for time in channel.edges(start, stop)[0]] == [ps for ps in edges if start < ps <= stop]
            following = next((ps for ps in edges if ps > start), 12_000_000)
            looked_for = min(ask_at(channel.after(start)) or 12_000_000, 12_000_000)
            assert looked_for == following or (counts > steps and start < looked_for < following)


# -------------------------------------------------------------------------------------------------- turned by a machine
def turned(**options):
    kernel = Kernel()
    shaft = Quadrature(kernel, "master", **options)
    kernel.settle()
    return kernel, shaft, {name: PinEdges(shaft.pin(name)) for name in "ab"}


@pytest.mark.parametrize("rate", [3, 1_250_000, -999_983])
def test_a_shaft_that_a_machine_turns_makes_a_count_every_so_often_without_drift(rate):
    kernel, shaft, _ = turned()
    kernel.run(7 * MS + 1)
    shaft.run(rate)
    start, way = kernel.now, 1 if rate > 0 else -1
    for ps in (1, 333_333_333_333, 333_333_333_334, 10 * 10**12):
        kernel.run(start + ps)
        assert shaft.counts == way * (((ps + 1) * abs(rate) - 1) // 10**12)  # count n comes n/rate later, rounded down
    assert kernel.next_time() is None


def test_the_counts_of_a_machine_are_promised_and_come_as_arrays():
    kernel, shaft, readings = turned()
    kernel.run(5 * US)
    shaft.run(-1_250_000)
    kernel.run(5 * US + 10 * MS)
    assert kernel.next_time() is None
    edges = []
    for name, reading in readings.items():
        times, levels = reading.edges_until(kernel.now)
        edges += zip(times.tolist(), name * len(times), levels.tolist(), strict=True)
    assert sorted(edges) == sorted(shown([(5 * US + n * 800_000, -n) for n in range(1, 12_501)]))


def test_a_machine_changes_speed_turns_back_and_stops_and_the_counts_continue_from_there():
    kernel, shaft, readings = turned()
    told = []
    for rate in (1_000_000, 500_000, -2_000_000, 0, 1_000_000):
        shaft.run(rate)
        kernel.run(kernel.now + 4 * US)
        told.append(shaft.counts)
    assert told == [4, 6, -2, -2, 2]
    shaft.push(-3)
    kernel.run(kernel.now + 10 * US)
    assert shaft.counts == 2 + 10 - 3
    edges = sorted(time for reading in readings.values() for time in reading.edges_until(kernel.now)[0])
    assert edges[:6] == [1 * US, 2 * US, 3 * US, 4 * US, 6 * US, 8 * US]
    assert edges[6:14] == [8 * US + n * 500_000 for n in range(1, 9)]
    assert edges[14] == 17 * US


# ----------------------------------------------------------------------------------------------------------- on a bench
def story_on_a_bench(bench, **options):
    x = bench.add("cy525", name="x", **options)
    enc = bench.part("encoder", name="enc", counts=100, steps=200, lag="20 us")
    bench.wire("x.pulse", "enc.pulse")
    bench.wire("x.direction", "enc.dir")
    host = bench.host(x)
    bench.record("enc.a", "enc.b")
    host.send("A 0\rF 10\rR 127\rS 240\rZ 1\rN 2001\rG\r-\rN 301\rG\r")
    return x, enc


@pytest.mark.parametrize(("shuffle", "stepwise"), [(None, False), (1, False), (2, True)])
def test_an_encoder_follows_a_chip_through_ramps_and_back(shuffle, stepwise):
    bench = slewline.Bench(shuffle=shuffle)
    x, enc = story_on_a_bench(bench, stepwise=stepwise)
    bench.run_until(x.reaches(1000))
    bench.run("20 us")
    assert enc.counts == 500
    bench.run_until_idle()
    assert x.position == 1700
    assert enc.counts == 850
    steps = x.steps()
    counts = [
        (int(time) + 20 * US, int(position) // 2)
        for time, position in zip(steps.times_ps, steps.positions, strict=True)
    ]
    found = []
    for name in "ab":
        times, levels = bench.edges(f"enc.{name}")
        found += [(int(time), name, int(level)) for time, level in zip(times, levels, strict=True)]
    assert sorted(found) == shown(counts)


def test_actions_of_a_user_on_a_shaft_are_in_the_journal(tmp_path):
    journal = tmp_path / "journal"
    bench = slewline.Bench(journal=journal)
    x, enc = story_on_a_bench(bench)
    master = bench.part("quadrature", name="master")
    bench.run_until(x.reaches(100))
    enc.block()
    bench.run("1 ms")
    enc.push(20)
    master.run(-12_345)
    bench.run("10 ms")
    enc.free()
    enc.slip(3)
    bench.run_until_idle()
    counts = enc.counts, master.counts
    bench.journal.close()
    again = slewline.replay(journal)
    assert (again["enc"].counts, again["master"].counts) == counts
    assert counts[0] not in (850, 847)
    assert counts[1] < -1000


@pytest.mark.parametrize("axis", [1, 4])
def test_the_standard_wiring_is_that_of_the_axis(axis):
    bench = slewline.Bench()
    x = bench.add("mc1451a-e", name="x")
    enc, master = bench.part("encoder", to=x, axis=axis), bench.part("quadrature", to=x, axis=5 - axis)
    pairs = [(enc, "pulse", f"pulse{axis}"), (enc, "dir", f"dir{axis}")]
    pairs += [(part, pin, f"quad{pin}{n}") for part, n in ((enc, axis), (master, 5 - axis)) for pin in "ab"]
    assert all(part.pin(own).net.root is x.pin(theirs).net.root for part, own, theirs in pairs)


@pytest.mark.parametrize("chip", ["cy525", "gs-c200", "mc1151a"])
def test_an_encoder_attaches_to_a_chip_without_encoder_inputs_and_takes_its_steps(chip):
    bench = slewline.Bench()
    x = bench.add(chip, name="x")
    enc = bench.part("encoder", to=x, counts=200, steps=200)
    assert enc.pin("pulse").net.root is next(pin for pin in x.pins.values() if pin.row.role == "step").net.root
    assert enc.pin("a").net.root.joined == ()


def test_mistakes_are_refused_with_the_allowed_values():
    bench = slewline.Bench()
    with pytest.raises(slewline.UsageError, match=r"encoder: axis 5; allowed 1..4"):
        bench.part("encoder", axis=5)
    with pytest.raises(slewline.UsageError, match=r"encoder: counts 0; allowed"):
        bench.part("encoder", counts=0)
    with pytest.raises(slewline.UsageError, match=r"lag 0; allowed"):
        bench.part("encoder", lag=0)
    enc, master = bench.part("encoder", name="enc"), bench.part("quadrature", name="master")
    with pytest.raises(slewline.UsageError, match=r"enc: 0.5 counts; expected a whole number"):
        enc.push(0.5)
    with pytest.raises(
        slewline.UsageError, match=r"enc: slip by -1 counts; allowed 0 or more \(push turns the shaft\)"
    ):
        enc.slip(-1)
    with pytest.raises(slewline.UsageError, match=r"master: True counts"):
        master.run(True)
