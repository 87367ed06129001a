"""Parts that count clock edges when they are asked, and their twins that step at every edge, do the same.

Behind wires that are driven in all ways, and behind chips: watched, recorded, read or left alone, step by step or as a
whole, ties shuffled or not; and what they are asked meanwhile is answered alike.
"""

from __future__ import annotations

from random import Random

import pytest

import slewline
from slewline.core.wires.net import Driver
from slewline.parts.base.part import Part
from tests.ensembles import few

from . import dialogues, gsc_dialogues, mc_dialogues
from .edge_driven import placed
from .edge_parts import fitted
from .test_composed import END, Script, Source, _ignored

ASKED = ("position", "state", "pulses", "lost", "held", "field")
MOTORS = (
    {},
    {"lag": "7 ps"},
    {"lag": "31 ps", "loses": (2, 5)},
    {"pull_in": 6e10, "acceleration": 2e20},
    {"loses": (1,)},
)


# ------------------------------------------------------------------------------------------- wires driven in all ways
def fit(bench, random: Random, clocks: list[str], sources: list[str], name: str, *, twin: bool) -> Part:
    """A random part: its clock, or the phases of a rotor, behind some pins, the other inputs behind sources.

    What a part without delay does takes a round of its twin, and none of a view.  So two inputs that race each other
    within an instant, and the pulses of no width that come of that, are left out: in a row of parts none has
    inputs besides its clock.
    """
    kind = random.choice(("translator", "motor", "motor", "gs_d200", "gs_d200", "rotor", "phase_latch"))
    options = random.choice(MOTORS) if kind == "motor" else {}
    part = fitted(bench, kind, name, twin=twin, **options)
    for pin, terminal in part.pins.items():
        if terminal.row.in_out == "in" and random.random() < 0.8:  # else it is open
            behind = clocks if pin in ("pulse", "clock") or kind == "rotor" else sources
            if behind:
                bench.wire(random.choice(behind), f"{name}.{pin}")
    return part


def told(part: Part) -> dict:
    """What a part answers."""
    return {name: getattr(part, name) for name in ASKED if hasattr(part, name)}


def played(seed: int, *, twin=False, watched=False, recorded=True, shuffle=None, asked=True) -> dict:
    """The edges of parts behind random drives, and their answers at random instants."""
    bench, random = slewline.Bench(shuffle=shuffle), Random(f"counting {seed}")
    names = [f"s{n}" for n in range(6)]
    sources = [f"{name}.out" for name in names]
    for name in names:
        bench.place(Source(bench.kernel, name, random.choice((0, 1, None))))
    deep = random.random() < 0.5  # parts behind gates and parts
    clocks = sources[:3]
    for number in range(random.randrange(1, 4) if deep else 0):
        kind, behind = random.choice(("inverter", "delay")), random.choice(clocks)
        placed(bench, kind, f"g{number}", twin=twin, inputs=1, delay_ps=random.randrange(1, 60))
        bench.wire(behind, f"g{number}.in{'' if kind == 'delay' else 1}")
        clocks.append(f"g{number}.out")
    row = deep and random.random() < 0.5
    parts = [fit(bench, random, clocks[-1:] if deep else sources, [] if row else sources, "p0", twin=twin)]
    outs = [f"p0.{pin}" for pin, terminal in parts[0].pins.items() if terminal.row.in_out == "out"]
    if outs and row:
        parts.append(fit(bench, random, outs, [], "p1", twin=twin))
    outs = [f"{part.name}.{pin}" for part in parts for pin, term in part.pins.items() if term.row.in_out == "out"]
    if recorded:
        bench.record(*outs)
    script = Script(bench, seed, names, latest=1 if deep else 3)
    bench.run(0)
    for name in outs:
        some, ps = random.random() < 0.2, random.randrange(END)
        if watched or some:
            bench.kernel.call_at(ps, lambda name=name: bench.pin(name).net.watch(_ignored))
    answers: dict[int, list] = {}
    for ps in sorted(random.sample(range(1, END), 20)):
        if asked:
            bench.kernel.run(ps)
            answers[ps] = [told(part) for part in parts]
    bench.kernel.run(END)
    found: dict = {"answers": answers, "end": [told(part) for part in parts]}
    found["findings"] = [(found.time_ps, found.code) for part in parts for found in part.findings]
    found["levels"] = {name: bench.pin(name).level for name in outs}
    for name in outs if recorded else ():
        times, levels = bench.edges(name, 0, None)
        found[name] = list(zip(times.tolist(), levels.tolist(), strict=True))
    assert script.drivers
    return found


def agree(seed: int) -> int:
    """Play it in all ways; how many edges and other answers there were."""
    twin = played(seed, twin=True)
    for how in (
        {}, {"watched": True}, {"recorded": False}, {"recorded": False, "watched": True}, {"asked": False},
        {"shuffle": seed}, {"shuffle": seed, "watched": True},
    ):  # fmt: skip
        own = played(seed, **how)
        for key, value in own.items():
            if key != "answers" or value:
                assert value == twin[key], f"parts {seed}, {how}: {key}"
    edges = sum(len(value) for key, value in twin.items() if "." in key)
    return edges + len({repr(answer) for answer in twin["answers"].values()}) - 1


@pytest.mark.parametrize("block", few(range(10), 1))
def test_parts_that_count_and_parts_that_step_agree(block: int) -> None:
    assert sum(agree(seed) for seed in range(block * 10, block * 10 + 10)) > 0


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_parts_that_count_and_parts_that_step_agree_a_thousand_times() -> None:
    for seed in range(10_000, 11_000):
        agree(seed)


# --------------------------------------------------------------------------------------------------------- behind chips
BEHIND = {  # which pins of a chip make the steps, where they go, and what else is wired
    "cy525": ("pulse", "direction", {f"phase{n}": f"phase{n}" for n in (1, 2, 3, 4)}),
    "gs-c200": ("clock", "dir", {"reset": "reset", "enable": "uo1", "half_full": "uo2", "off": "uo1"}),
    "mc1451a": ("pulse1", "dir1", {}),
}
LIMITS = (
    {}, {"lag": "300 us"}, {"lag": "1 ms", "loses": (1, 7)}, {"pull_in": 300, "acceleration": 20_000},
    {"pull_in": 1000, "acceleration": 100_000, "lag": "5 us"},
)  # fmt: skip
KINDS = ("translator", "motor", "motor", "gs_d200", "rotor", "phase_latch")


class Fitting:
    """Parts behind a chip, asked, watched, recorded and driven at random: all from one seed."""

    def __init__(self, seed: int, family: str, until_ps: int, *, twin: bool, watched: bool, recorded: bool) -> None:
        self.seed, self.family, self.until_ps, self.twin = seed, family, until_ps, twin
        self.watched, self.recorded = watched, recorded
        self.answers: list = []

    def __call__(self, bench) -> None:
        random = Random(f"behind {self.family} {self.seed}")
        step, direction, others = BEHIND[self.family]
        wires = {"pulse": step, "clock": step, "direction": direction, **others}
        self.bench, self.parts = bench, []
        for number in range(random.choice((1, 2, 3))):
            kind = random.choice(KINDS)
            options = random.choice(LIMITS) if kind == "motor" else {}
            part = fitted(bench, kind, f"p{number}", twin=self.twin, **options)
            self.parts.append(part)
            for pin, terminal in part.pins.items():
                if terminal.row.in_out == "in" and pin in wires:
                    bench.wire(f"x.{wires[pin]}", f"{part.name}.{pin}")
                if terminal.row.in_out == "in" and (pin not in wires or random.random() < 0.1):
                    driver = Driver(terminal.net, "hand")
                    for _ in range(random.choice((0, 0, 1, 3)) if pin not in ("pulse", "clock") else 0):
                        at, level = random.randrange(1, self.until_ps), random.choice((0, 1))
                        bench.kernel.call_at(at, lambda driver=driver, level=level: driver.drive(level))
                some, at = random.random() < 0.3, random.randrange(self.until_ps)
                if terminal.row.in_out == "out" and (self.watched or some):
                    bench.kernel.call_at(at, lambda net=terminal.net: net.watch(_ignored))
        self.outs = [f"{p.name}.{pin}" for p in self.parts for pin, t in p.pins.items() if t.row.in_out == "out"]
        if self.recorded:
            bench.record(*self.outs)
        for _ in range(6):
            bench.kernel.call_at(random.randrange(1, self.until_ps), self.ask)

    def ask(self) -> None:
        self.answers.append((self.bench.now_ps, [told(part) for part in self.parts]))

    def left(self) -> dict:
        self.ask()
        found = {"answers": sorted(self.answers, key=lambda answer: answer[0])}
        found["findings"] = [(f.time_ps, f.code) for part in self.parts for f in part.findings]
        for name in self.outs if self.recorded else ():
            times, levels = self.bench.edges(name)
            found[name] = list(zip(times.tolist(), levels.tolist(), strict=True))
        return found


def behind(seed: int, family: str) -> int:
    """Play a dialogue with parts behind the chip and their twins; how many steps the first one counted."""
    made, play = {
        "cy525": (dialogues.made, dialogues.play), "gs-c200": (gsc_dialogues.made, gsc_dialogues.play),
        "mc1451a": (mc_dialogues.made, mc_dialogues.play),
    }[family]  # fmt: skip
    dialogue = made(seed)
    until = getattr(dialogue, "until_ps", 0) or (dialogue.cycles + 20) * 8192 * 10**12 // dialogue.crystal
    random, found = Random(seed), []
    for twin in (True, False):
        how = {} if twin else {"stepwise": random.random() < 0.4, "shuffle": seed}
        fitting = Fitting(
            seed, family, until, twin=twin, watched=not twin and random.random() < 0.4,
            recorded=twin or random.random() < 0.7,
        )  # fmt: skip
        play(dialogue, fit=fitting, **how)
        found.append(fitting.left())
    for key, value in found[1].items():
        assert value == found[0][key], f"{family} {seed}: {key}"
    return len(found[0]["answers"]) + sum(len(value) for key, value in found[0].items() if "." in key)


@pytest.mark.parametrize("family", BEHIND)
def test_parts_connected_to_a_chip_agree_with_their_twins(family: str) -> None:
    assert sum(behind(seed, family) for seed in range(4)) > 20


@pytest.mark.long
@pytest.mark.timeout(3000)
@pytest.mark.parametrize("family", BEHIND)
def test_parts_connected_to_a_chip_agree_with_their_twins_in_many_dialogues(family: str) -> None:
    for seed in (*range(4, 10), *range(1000, 1334)):
        behind(seed, family)
