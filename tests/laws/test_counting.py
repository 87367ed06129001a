"""Parts that count clock edges when they are asked, and their twins that step at every edge, do the same.

Behind wires that are driven in all ways, and behind chips: watched, recorded, read or left alone, step by step or as a
whole, ties shuffled or not; and what they are asked meanwhile is answered alike.
"""

from __future__ import annotations

from random import Random

import pytest

import slewline
from slewline.parts.part import Part

from .edge_parts import fitted
from .test_composed import END, Script, Source, _ignored, circuit

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

    What a gate without delay does takes a round of its twin, and none of a view.  So a race of two inputs within an
    instant, one of them behind a gate, is left out.
    """
    kind = random.choice(("translator", "motor", "motor", "gs_d200", "gs_d200", "rotor", "phase_latch"))
    options = random.choice(MOTORS) if kind == "motor" else {}
    part = fitted(bench, kind, name, twin=twin, **options)
    for pin, terminal in part.pins.items():
        if terminal.row.way == "in" and random.random() < 0.8:  # else it is open
            behind = clocks if pin in ("pulse", "clock") or kind == "rotor" else sources
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
    gates = circuit(bench, random, sources, random.randrange(1, 4), twin=twin, longest_ps=60) if deep else sources
    parts = [fit(bench, random, gates, sources, "p0", twin=twin)]
    outs = [f"p0.{pin}" for pin, terminal in parts[0].pins.items() if terminal.row.way == "out"]
    if outs and deep:
        parts.append(fit(bench, random, outs, sources, "p1", twin=twin))
    outs = [f"{part.name}.{pin}" for part in parts for pin, term in part.pins.items() if term.row.way == "out"]
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
    """Play it in all ways; how many edges and steps there were."""
    twin = played(seed, twin=True)
    for how in (
        {}, {"watched": True}, {"recorded": False}, {"recorded": False, "watched": True}, {"asked": False},
        {"shuffle": seed}, {"shuffle": seed, "watched": True},
    ):  # fmt: skip
        own = played(seed, **how)
        for key, value in own.items():
            if key != "answers" or value:
                assert value == twin[key], f"parts {seed}, {how}: {key}"
    return sum(len(value) for key, value in twin.items() if "." in key) + sum(len(map_) for map_ in twin["end"])


@pytest.mark.parametrize("block", range(10))
def test_parts_that_count_and_parts_that_step_agree(block: int) -> None:
    assert sum(agree(seed) for seed in range(block * 10, block * 10 + 10)) > 50
