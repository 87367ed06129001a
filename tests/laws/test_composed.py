"""Circuits of gates, inverters and delay lines: views of promises and event-driven twins give the same edges.

Watched, recorded, read or left alone, ties shuffled or not, whatever happens to the promises meanwhile.
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

import pytest

import slewline
from slewline.chips.mc1451a.axis.pin_edges import PinEdges
from slewline.chips.mc1451a.profiles.cycle_train import CycleTrain, Linear, SquareView
from slewline.core.motion.step_views import PulseView, StrobeView
from slewline.core.motion.train import OPEN, Playing, StepTrain
from slewline.core.time.timebase import Clock
from slewline.core.wires.net import Driver, Net, Wave
from slewline.parts import KINDS
from tests.ensembles import few

from .edge_driven import LAWS, placed

CLOCK = Clock(10**12)  # a tick is a picosecond
END = 400
GATES = (*LAWS, "delay")


def circuit(bench, random: Random, sources: list[str], parts: int, *, twin: bool, longest_ps: int) -> list[str]:
    """A random circuit behind some pins, each part behind any of those before it; the pins that it drives."""
    outputs, open_lines = list(sources), []
    for number in range(parts):
        kind, name = random.choice(GATES), f"g{number}"
        inputs = 1 if kind in ("inverter", "delay") else random.randrange(1, 4)
        placed(bench, kind, name, twin=twin, inputs=inputs, delay_ps=random.randrange(1, longest_ps))
        for n in range(inputs):
            if random.random() < (0.6 if kind == "delay" else 0.9):
                bench.wire(random.choice(outputs), f"{name}.in" if kind == "delay" else f"{name}.in{n + 1}")
            elif kind == "delay":
                open_lines.append(name)
        outputs.append(f"{name}.out")
    for name in open_lines:  # a line may lead back to where it comes from
        if random.random() < 0.7:
            bench.wire(random.choice(outputs[outputs.index(f"{name}.out") :]), f"{name}.in")
    return outputs[len(sources) :]


# ------------------------------------------------------------------------------------------- wires driven in all ways
class Script:
    """Random drives of some wires, by one or two outputs each: levels, waves, trains, bounds that move, any round."""

    def __init__(self, bench, seed: int, names: Sequence[str] = ("s0", "s1", "s2"), latest: int = 3) -> None:
        self.kernel, random = bench.kernel, Random(seed)
        self.drivers: list[Driver] = []
        self.views: dict[Driver, object] = {}
        self.acts: set[int] = set()  # the instants at which something is driven
        for name in names:
            net = bench.pin(f"{name}.out").net
            self.drivers += [Driver(net, "script") for _ in range(random.choice((1, 1, 2)))]
        taken = set()
        for _ in range(random.randrange(1, 25)):
            ps, driver = random.randrange(1, END), random.randrange(len(self.drivers))
            if (ps, driver) not in taken:  # else the order of a round would matter
                taken.add((ps, driver))
                self.acts.add(ps)
                kind = random.choice(("level", "wave", "soon", "train", "strobe", "cycles", "bound", "bound"))
                self.kernel.call_at(
                    ps, self.acting(kind, self.drivers[driver], random.randrange(latest), random.random())
                )

    def acting(self, kind: str, driver: Driver, rounds: int, seed: float):
        def act() -> None:
            nonlocal rounds
            if rounds and kind != "bound":  # in a later round of the instant; a chip decides on bounds in the first
                rounds -= 1
                self.kernel.call_at(self.kernel.now, act)
            else:
                getattr(self, kind)(driver, Random(seed))

        return act

    def level(self, driver, random):
        driver.drive(random.choice((0, 1, None)))

    def wave(self, driver, random):
        now = self.kernel.now
        times = sorted(random.sample(range(now - 5, now + 80), random.randrange(1, 6)))
        driver.play(Wave(random.choice((0, 1, None)), tuple(times), tuple(random.choice((0, 1, None)) for _ in times)))

    def soon(self, driver, random):
        now = self.kernel.now
        times = sorted(random.sample(range(now + 1, now + 80), random.randrange(1, 6)))
        driver.wave(driver.at(self.kernel.seen), tuple(times), tuple(random.choice((0, 1, None)) for _ in times))

    def train(self, driver, random):
        train = StepTrain(CLOCK, self.kernel.now + random.randrange(-9, 9), [(random.randrange(4, 30), OPEN)])
        self.play(driver, PulseView(Playing(train), 3), random)

    def strobe(self, driver, random):
        train = StepTrain(CLOCK, self.kernel.now + random.randrange(-9, 9), [(random.randrange(4, 30), 4)])
        self.play(driver, StrobeView(Playing(train), 2), random)

    def cycles(self, driver, random):
        train = CycleTrain(CLOCK, self.kernel.now, Linear(random.randrange(1, 1 << 18), 7), 40, cycle=16)
        self.play(driver, SquareView(Playing(train), random.random() < 0.5), random)

    def play(self, driver, view, random):
        view.of.until = random.choice((None, self.kernel.now + random.randrange(1, 60)))
        self.views[driver] = view
        driver.play(view)

    def bound(self, driver, random):
        view, now = self.views.get(driver), self.kernel.now
        if view is not None and driver.promise is view and not driver.pending:
            until = view.of.until
            if until is None or until >= now:
                view.of.until = now + random.randrange(1, 60)
                driver.renew()


def furnished(bench, random: Random, twin: bool) -> list[str]:
    """Put wires and a random circuit behind them on a bench; what the circuit drives."""
    for name in ("s0", "s1", "s2"):
        bench.place(Source(bench.kernel, name, random.choice((0, 1, None))))
    return circuit(bench, random, ["s0.out", "s1.out", "s2.out"], random.randrange(1, 8), twin=twin, longest_ps=60)


def played(
    seed: int, *, twin=None, watched=False, recorded=True, shuffle=None, read=False, ahead=False, pulses=None
) -> dict[str, list]:
    """The edges of a random circuit behind random drives.

    Args:
        twin: by edges; the parts that lie on circles.
        pulses: takes the pulses of no width, (instant, pin), that come though nobody has driven a wire.
    """
    bench, random = slewline.Bench(shuffle=shuffle), Random(f"circuit {seed}")
    outputs = furnished(bench, random, twin is not None)
    edges: dict[str, list] = {}
    if recorded:
        bench.record(*outputs)
    script = Script(bench, seed)
    for name in twin or ():
        bench.parts[name].looped = True
    bench.run(0)  # everything has come to rest
    readings = {name: PinEdges(bench.pin(name)) for name in outputs if read or ahead}
    readers = {name: AheadReader(reading, random) for name, reading in readings.items() if ahead}
    found: dict[str, dict[int, int]] = {name: {0: bench.pin(name).level} for name in outputs}

    def told(net: Net, name: str) -> None:
        if bench.now_ps in found[name] and bench.now_ps not in script.acts and pulses is not None:
            pulses.append((bench.now_ps, name))
        found[name][bench.now_ps] = net.level

    for name in outputs:
        if watched:
            bench.pin(name).net.watch(lambda net, name=name: told(net, name))
        elif random.random() < 0.3:  # watched for a while
            bench.kernel.call_at(random.randrange(END), lambda name=name: bench.pin(name).net.watch(_ignored))
    bench.kernel.run(END)
    for name in outputs:
        if recorded:
            times, levels = bench.edges(name, 0, None)
            edges[name] = list(zip(times.tolist(), levels.tolist(), strict=True))
        elif read or ahead:
            times, levels = readers[name].read(END) if ahead else readings[name].edges_until(END)
            edges[name] = [(int(ps), int(level)) for ps, level in zip(times, levels, strict=True)]
        else:
            told = list(found[name].items())
            edges[name] = [edge for edge, (_, was) in zip(told[1:], told, strict=False) if edge[1] != was]
        edges[f"{name} now"] = bench.pin(name).level
    return edges


class AheadReader:
    """Takes what is promised for what happens, unless a driver is told something, as an encoder chip does."""

    def __init__(self, reading: PinEdges, random: Random) -> None:
        self.reading, self.random = reading, random
        self.kernel = reading.pin.net.kernel
        self.found: list = []
        self.window = None
        reading.on_change.add(self.drop)
        self.kernel.call_at(self.kernel.now + 1, self.look)

    def drop(self) -> None:
        self.window = None

    def look(self) -> None:
        """Read up to here, or take it as read; and look ahead."""
        now, steps = self.kernel.now, self.random.choice((1, 2, 5, 30, 200))
        if self.window is not None:
            times, levels, last = self.window
            self.reading.skip(now - 1, last)
            self.found += zip(times, levels, strict=True)
        else:
            self.read(now - 1)
        self.window = self.reading.coming(now + steps - 1)
        self.kernel.call_at(now + steps, self.look)

    def read(self, ps: int) -> tuple[tuple, tuple]:
        """Read what has happened by an instant; all edges so far."""
        self.found += zip(*self.reading.edges_until(ps), strict=True)
        return tuple(zip(*self.found, strict=True)) or ((), ())


def looped(seed: int) -> list[str]:
    """The parts of a circuit that lie on circles."""
    bench, random = slewline.Bench(), Random(f"circuit {seed}")
    furnished(bench, random, False)
    bench.run(0)
    return [name for name, part in bench.parts.items() if on_circle(part)]


def _ignored(_net: Net) -> None:
    """An observer that only makes promised edges instants."""


class Source(slewline.parts.base.part.Part):
    """A wire of the script."""

    def __init__(self, kernel, name: str, pull: int | None) -> None:
        super().__init__(kernel, name)
        self.add_pin("out", "in", "", pull=pull)


WAYS = (
    {}, {"watched": True, "recorded": False}, {"recorded": False, "read": True}, {"shuffle": 1},
    {"shuffle": 2, "watched": True}, {"recorded": False, "ahead": True},
)  # fmt: skip


def agree(seed: int, ways=WAYS) -> tuple[int, bool]:
    """Play a circuit in some ways; how many edges there were, and whether it has a circle.

    Promised edges pass all gates together, so they make no pulses of no width by themselves; only what is driven does,
    which passes a gate a round, and what a circle does.
    """
    circles = looped(seed)
    pulses: list[tuple[int, str]] = []
    twin = played(seed, twin=circles, watched=True)
    for how in ({"watched": True, "pulses": pulses}, *ways):
        assert played(seed, **how) == twin, f"circuit {seed}, {how}"
    assert circles or not pulses, f"circuit {seed}"
    return sum(len(edges) for edges in twin.values() if isinstance(edges, list)), bool(circles)


@pytest.mark.parametrize("block", few(range(10), 1))
def test_circuits_of_views_and_of_edges_agree(block: int) -> None:
    found = [agree(seed, (WAYS[seed % len(WAYS)],)) for seed in range(block * 25, block * 25 + 25)]
    assert sum(edges for edges, _ in found) > 100
    assert any(circles for _, circles in found)


# ------------------------------------------------------------------------------------------------- between two chips
def chips(seed: int, *, twin=None, stepwise=False, watched=False, shuffle=None) -> tuple[list, list[str]]:
    """Two chips with a random circuit between them, which also leads back to the first one; the edges of all pins."""
    bench, random = slewline.Bench(shuffle=shuffle), Random(f"chips {seed}")
    x, y = (bench.add("cy525", name, random.choice(("11 MHz", "5 MHz")), stepwise=stepwise) for name in "xy")
    sources = ["x.pulse", "x.slew", "x.direction", "x.phase1", "y.motion_complete"]
    outputs = circuit(bench, random, sources, random.randrange(1, 6), twin=twin is not None, longest_ps=3 * 10**9)
    for pin in ("y.step_inhibit", "y.abort", "x.step_inhibit"):
        if random.random() < 0.6:
            bench.wire(random.choice(outputs), pin, invert=random.random() < 0.3)
    for name in twin or ():
        bench.parts[name].looped = True
    pins = [*outputs, "x.pulse", "y.pulse", "x.slew", "y.slew", "x.ready", "y.motion_complete", "y.step_inhibit"]
    bench.record(*pins)
    for chip in (x, y):
        rate, slope = random.choice((40, 100, 127)), random.choice((250, 255))
        motion = f"N {random.randrange(1, 80)}\r{random.choice('+-')}\rG\r"
        bench.host(chip).send(f"A 0\rF 10\rR {rate}\rS {slope}\rZ 1\r{motion}{motion}")
    for _ in range(random.choice((0, 1, 2))):
        pin, level = random.choice((("x.abort", 0), ("x.step_inhibit", 1), ("y.reset", 0)))
        at, width = random.randrange(20 * 10**9, 120 * 10**9), random.choice((10**6, 10**9, 10**10))
        bench.at(f"{at} ps", lambda pin=pin, level=level, width=width: bench.pin(pin).pulse(level, f"{width} ps"))
    if watched:
        for name in outputs:
            bench.pin(name).net.watch(_ignored)
    bench.run("150 ms")
    edges = [[part.tolist() for part in bench.edges(pin, "1 us", None)] for pin in pins]
    return [edges, x.position, y.position], [name for name, part in bench.parts.items() if on_circle(part)]


def on_circle(part) -> bool:
    """Does a part go by edges?"""
    return getattr(getattr(part, "rule", None), "edge_driven", False)


def chips_agree(seed: int) -> int:
    """Play two chips in all ways; how many edges the circuit between them made."""
    views, circles = chips(seed)
    assert chips(seed, twin=circles)[0] == views, f"chips {seed}"
    how = ({"watched": True}, {"stepwise": True}, {"shuffle": seed})[seed % 3]
    assert chips(seed, **how)[0] == views, f"chips {seed}, {how}"
    return sum(len(times) for times, _ in views[0])


@pytest.mark.parametrize("block", few(range(4), 1))
def test_circuits_between_chips_agree(block: int) -> None:
    assert sum(chips_agree(seed) for seed in range(block * 9, block * 9 + 9)) > 100


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_a_thousand_circuits_between_chips_agree() -> None:
    for seed in range(1000, 2000):
        chips_agree(seed)


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_four_thousand_circuits_agree() -> None:
    for seed in range(10_000, 14_000):
        agree(seed)


def test_every_gate_has_its_law() -> None:
    assert {kind for kind, listed in KINDS.items() if listed.at == "logic.gates:Gate"} == set(LAWS)
