"""Circuits of gates, inverters and delay lines: views of promises and event-driven twins give the same edges.

Watched, recorded, read or left alone, ties shuffled or not, whatever happens to the promises meanwhile.
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

import pytest

import slewline
from slewline.core.cycles import CycleTrain, Linear, SquareView
from slewline.core.net import Driver, Net, Wave
from slewline.core.reading import Reading
from slewline.core.timebase import Clock
from slewline.core.train import OPEN, Playing, PulseView, StepTrain, StrobeView

from .edge_driven import placed

CLOCK = Clock(10**12)  # a tick is a picosecond
END = 400
GATES = ("and", "or", "nand", "nor", "inverter", "delay")


def circuit(bench, random: Random, sources: list[str], parts: int, *, twin: bool, longest_ps: int) -> list[str]:
    """A random circuit behind some pins, each part behind any of those before it; the pins that it drives."""
    outputs = list(sources)
    for number in range(parts):
        kind, name = random.choice(GATES), f"g{number}"
        inputs = 1 if kind in ("inverter", "delay") else random.randrange(1, 4)
        placed(bench, kind, name, twin=twin, inputs=inputs, delay_ps=random.randrange(1, longest_ps))
        for n in range(inputs):
            if random.random() < 0.9:  # else it is open
                bench.wire(random.choice(outputs), f"{name}.in" if kind == "delay" else f"{name}.in{n + 1}")
        outputs.append(f"{name}.out")
    return outputs[len(sources) :]


# ------------------------------------------------------------------------------------------- wires driven in all ways
class Script:
    """Random drives of some wires, by one or two outputs each: levels, waves, trains, bounds that move, any round."""

    def __init__(self, bench, seed: int, names: Sequence[str] = ("s0", "s1", "s2"), latest: int = 3) -> None:
        self.kernel, random = bench.kernel, Random(seed)
        self.drivers: list[Driver] = []
        self.views: dict[Driver, object] = {}
        for name in names:
            net = bench.pin(f"{name}.out").net
            self.drivers += [Driver(net, "script") for _ in range(random.choice((1, 1, 2)))]
        taken = set()
        for _ in range(random.randrange(1, 25)):
            ps, driver = random.randrange(1, END), random.randrange(len(self.drivers))
            if (ps, driver) not in taken:  # else the order of a round would matter
                taken.add((ps, driver))
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


def played(
    seed: int, *, twin=False, watched=False, recorded=True, shuffle=None, read=False, counted=None
) -> dict[str, list]:
    """The edges of a random circuit behind random drives; `counted` takes all changes, those of no width included."""
    bench, random = slewline.Bench(shuffle=shuffle), Random(f"circuit {seed}")
    sources = ["s0.out", "s1.out", "s2.out"]
    for name in ("s0", "s1", "s2"):
        bench.place(Source(bench.kernel, name, random.choice((0, 1, None))))
    outputs = circuit(bench, random, sources, random.randrange(1, 8), twin=twin, longest_ps=60)
    edges: dict[str, list] = {}
    if recorded:
        bench.record(*outputs)
    script = Script(bench, seed)
    bench.run(0)  # everything has come to rest
    readings = {name: Reading(bench.pin(name)) for name in outputs if read}
    found: dict[str, dict[int, int]] = {name: {0: bench.pin(name).level} for name in outputs}
    for name in outputs:
        if watched:
            bench.pin(name).net.watch(lambda net, name=name: found[name].__setitem__(bench.now_ps, net.level))
        elif random.random() < 0.3:  # watched for a while
            bench.kernel.call_at(random.randrange(END), lambda name=name: bench.pin(name).net.watch(_ignored))
    bench.kernel.run(END)
    for name in outputs:
        if recorded:
            times, levels = bench.edges(name, 0, None)
            edges[name] = list(zip(times.tolist(), levels.tolist(), strict=True))
        elif read:
            times, levels = readings[name].edges_until(END)
            edges[name] = [(int(ps), int(level)) for ps, level in zip(times, levels, strict=True)]
        else:
            told = list(found[name].items())
            edges[name] = [edge for edge, (_, was) in zip(told[1:], told, strict=False) if edge[1] != was]
        edges[f"{name} now"] = bench.pin(name).level
        if counted is not None:
            counted[name] = bench.pin(name).net.changes
    assert script.drivers
    return edges


def _ignored(_net: Net) -> None:
    """An observer that only makes promised edges instants."""


class Source(slewline.parts.part.Part):
    """A wire of the script."""

    def __init__(self, kernel, name: str, pull: int | None) -> None:
        super().__init__(kernel, name)
        self.add_pin("out", "in", "", pull=pull)


def agree(seed: int) -> int:
    """Play a circuit in all ways; how many edges there were."""
    twin = played(seed, twin=True)
    for how in (
        {}, {"watched": True}, {"watched": True, "recorded": False}, {"recorded": False, "read": True},
        {"shuffle": seed}, {"shuffle": seed, "watched": True},
    ):  # fmt: skip
        assert played(seed, **how) == twin, f"circuit {seed}, {how}"
    views: dict[str, int] = {}
    edges: dict[str, int] = {}
    played(seed, watched=True, counted=views)
    played(seed, watched=True, counted=edges, twin=True)
    for name, changes in views.items():
        assert changes <= edges[name], f"circuit {seed}: glitches at {name}"
    return sum(len(edges) for edges in twin.values() if isinstance(edges, list))


@pytest.mark.parametrize("block", range(10))
def test_circuits_of_views_and_of_edges_agree(block: int) -> None:
    assert sum(agree(seed) for seed in range(block * 25, block * 25 + 25)) > 100


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_four_thousand_circuits_agree() -> None:
    for seed in range(10_000, 14_000):
        agree(seed)
