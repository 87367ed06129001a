"""Random dialogues with a CY525: what the fast path and its step-by-step twin are compared on.

A dialogue is data: options, parameters, what the host sends, and what happens on the pins at given instants.  The same
data are played on benches that differ in one thing (the twin, the order of ties, the hash seed) and must leave the same
edges on every output pin.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from random import Random
from typing import Any

import numpy as np

import slewline
from slewline.core.wires.net import Driver

OUTPUTS = (
    "ready", "instrobe", "outstrobe", "slew", "prog", "run", "direction", "programmable_output", "pulse",
    "motion_complete", "phase1", "phase2", "phase3", "phase4", "db",
)  # fmt: skip
CRYSTALS = ("11 MHz", "6 MHz", "3.579545 MHz", "1 MHz")


@dataclass
class Dialogue:
    """One dialogue: `events` are (instant in ps, pin or "db", level or byte or None)."""

    seed: int
    crystal: str
    sent: str
    until_ps: int
    options: dict[str, Any] = field(default_factory=dict)  # of the part
    events: list[tuple[int, str, Any]] = field(default_factory=list)
    kinds: set[str] = field(default_factory=set)
    part: str = "cy525"


def in_order(events: list[tuple[int, str, Any]]) -> list[tuple[int, str, Any]]:
    """Events in the order of time; a wire is told one thing in an instant, for the order of two would not be given."""
    once = {(at, pin): level for at, pin, level in events}
    return sorted(((at, pin, level) for (at, pin), level in once.items()), key=lambda event: event[0])


def made(seed: int) -> Dialogue:
    """The dialogue of a seed."""
    rnd = Random(seed)
    dialogue = Dialogue(seed, rnd.choice(CRYSTALS), *script(rnd), laws(seed))
    quiet = play(dialogue)  # where the steps would be, so that events can hit them exactly
    begins = [int(t) for t in quiet.chip.steps().times_ps] or [dialogue.until_ps // 2]
    edges = sorted({*begins, *(int(t) for t in quiet.bench.edges("x.pulse")[0])})
    for _ in range(rnd.choice((0, 1, 1, 2, 3, 5))):
        happening(dialogue, rnd, edges)
    dialogue.events = in_order(dialogue.events)
    return dialogue


def laws(seed: int) -> dict[str, Any]:
    """Options of the ramps: those of the part by default, in a third of all dialogues others."""
    rnd = Random(f"laws {seed}")
    if rnd.random() < 2 / 3:
        return {}
    return {"ramp_unit": rnd.choice((1, 100, 452, 479, 480, 2000)), "ramp_jumps": rnd.random() < 0.6}


def script(rnd: Random) -> tuple[str, int]:
    """What the host sends, and how long to run."""
    lines = [
        f"A {rnd.choice((0, 5, 65530, rnd.randrange(65536)))}",
        f"F {rnd.choice((0, 3, 10, 30, rnd.randrange(128)))}",
        f"R {rnd.choice((3, 40, 80, 127, rnd.randrange(128)))}",
        f"S {rnd.choice((150, 200, 240, 250, 255))}",
        f"Z {rnd.choice((1, 1, 1, 2, 5))}",
        f"O {rnd.randrange(4)}",
    ]
    motions = []
    for _ in range(rnd.choice((1, 1, 2))):
        motions.append(f"N {rnd.choice((1, 2, 3, 7, 50, 257, 300, 700, 1500, 3000, rnd.randrange(1, 400)))}")
        motions.append(rnd.choice("+-"))
        if rnd.random() < 0.45:
            motions.append("H")
        motions.append(
            rnd.choice(("G", "G", "G", f"P {rnd.randrange(65536) if rnd.random() < 0.2 else rnd.randrange(900)}"))
        )
    if rnd.random() < 0.3:
        return "\r".join([*lines, "E", *motions, "0"]) + "\rQX\r", rnd.choice((60, 200, 500)) * 10**9
    return "\r".join([*lines, *motions]) + "\r", rnd.choice((60, 200, 500)) * 10**9


def happening(dialogue: Dialogue, rnd: Random, edges: list[int]) -> None:
    """Add one thing that happens on the pins, often exactly on an edge of PULSE."""
    at = rnd.choice(edges) if rnd.random() < 0.5 else rnd.randrange(edges[0], max(edges[-1], edges[0] + 1) + 1)
    if at in edges:
        dialogue.kinds.add("tie")
    later = rnd.choice(edges) if rnd.random() < 0.3 else at + rnd.choice((1, 10**6, 10**8, 10**9, 10**10, 3 * 10**10))
    kind = rnd.choice(("abort", "inhibit", "rate", "rate", "read", "reset", "wait"))
    dialogue.kinds.add(kind)
    add = dialogue.events.append
    if kind == "abort":
        add((at, "abort", 0))
        if rnd.random() < 0.6:
            add((max(later, at + 1), "abort", None))
    elif kind == "inhibit":
        add((at, "step_inhibit", 1))
        add((max(later, at + 1), "step_inhibit", 0))
    elif kind == "rate":
        add((at, "db", rnd.choice((0, 3, 60, 80, 127, 200, rnd.randrange(128)))))
        add((at, "io_request", 0))
        add((max(later, at + 1), "io_request", None))
        add((max(later, at + 1), "db", None))
    elif kind == "read":
        add((at, "io_select", 1))
        add((max(later, at + 1), "io_select", None))
    elif kind == "reset":
        add((at, "reset", 0))
        add((at + rnd.choice((10**6, 20 * 10**6, 200 * 10**6)), "reset", None))
    else:
        add((at, "wait", rnd.randrange(2)))


def told(axis: Any) -> dict[str, Any]:
    """What an axis tells of its motions; a phase that is held has no common end."""
    motions = [
        (
            at.time_ps,
            at.text,
            dict(at.rates),
            at.changes,
            dict(at.notes),
            at.position,
            at.end,
            at.ideal and along(at.ideal),
        )
        for at in axis.motions()
    ]
    return {
        "motions": motions,
        "marks": [(mark.time_ps, mark.kind, mark.text) for mark in axis.marks()],
        "phases": [(begin, label) for begin, _, label in axis.phases()],
    }


def along(ideal: Any) -> tuple[Any, ...]:
    """An ideal at a few instants."""
    times = np.linspace(ideal.start, min(ideal.stop, ideal.start + 10**13), 5).astype(np.int64)
    return ideal.start, ideal.stop, ideal.positions(times).tolist(), ideal.velocities(times).tolist()


def heard(chip: Any) -> list[tuple[Any, ...]]:
    """What a chip tells from now on: instructions that begin, what it works on, motions as they begin and end."""
    told: list[tuple[Any, ...]] = []
    now = lambda: chip.kernel.now  # noqa: E731
    chip.on_instruction.add(lambda at: told.append((now(), at, chip.program_counter)))
    chip.on_command.add(lambda text: told.append((now(), text)))
    for number in range(1, chip.sheet.axes + 1):
        axis = chip.axis(number)
        axis.on_motion_begin.add(lambda motion, n=number: told.append((now(), n, motion.text, motion.direction)))
        axis.on_motion_end.add(lambda end, n=number: told.append((now(), n, end)))
    return told


@dataclass
class Played:
    """What a dialogue left behind."""

    bench: slewline.Bench
    chip: Any
    outputs = OUTPUTS
    heard = ()

    def traces(self) -> dict[str, tuple[list[int], list[int]]]:
        """Edges of every output pin."""
        edges = {pin: self.bench.edges(f"{self.chip.name}.{pin}") for pin in self.outputs}
        return {pin: (times.tolist(), levels.tolist()) for pin, (times, levels) in edges.items()}

    @property
    def finds(self) -> bool:
        """Does the twin tell findings?"""
        return str(self.chip.sheet.part) == "cy525"

    def state(self) -> dict[str, Any]:
        """Registers, travel, every step, every change of velocity, what is told of the motions, and findings."""
        steps = self.chip.steps()
        return {
            **self.chip.registers,
            "travel": self.chip.travel,
            "steps": (steps.times_ps.tolist(), steps.directions.tolist(), steps.positions.tolist()),
            "velocities": [part.tolist() for part in self.chip.motor.velocities(0, self.bench.now_ps)],
            "heard": self.heard,
            "findings": [(found.time_ps, found.code) for found in self.chip.findings if self.finds],
            **told(self.chip),
        }

    def digest(self) -> str:
        """Everything above in one hash."""
        return hashlib.sha256(repr((self.traces(), self.state())).encode()).hexdigest()


class Wires:
    """Extra outputs beside the host's: whoever pulls a line low wins."""

    def __init__(self, chip: Any) -> None:
        names = {"abort", "step_inhibit", "io_request", "reset", "wait", "terminate"} & chip.pins.keys()
        nets = {name: chip.pin(name).net for name in sorted(names)}
        self.drivers = {name: Driver(net, "event") for name, net in nets.items()}
        self.drivers["db"] = Driver(chip.bus, "event")
        self.select = chip.pin("io_select")

    def set(self, name: str, level: int | None) -> None:
        if name == "io_select":
            self.select.net.drivers[0].drive(level or 0)  # the host's own line
        elif name == "db":
            self.drivers[name].drive(None if level is None else (0xFF, level))
        else:
            self.drivers[name].drive(level)


def play(dialogue: Dialogue, *, stepwise: bool = False, shuffle: int | None = None, fit: Any = None) -> Played:
    """Play a dialogue on a fresh bench; `fit` puts parts on it."""
    bench = slewline.Bench(shuffle=shuffle)
    chip = bench.add(dialogue.part, "x", dialogue.crystal, stepwise=stepwise, **dialogue.options)
    if fit is not None:
        fit(bench)
    host = bench.host(chip)
    wires = Wires(chip)
    bench.record(*(f"x.{pin}" for pin in OUTPUTS))
    host.send(dialogue.sent)
    for at, name, level in dialogue.events:
        bench.at(at, lambda name=name, level=level: wires.set(name, level))  # type: ignore[misc]
    played = Played(bench, chip)
    played.heard = heard(chip)
    bench.run_to(dialogue.until_ps)
    return played


def differences(one: Played, two: Played) -> list[str]:
    """Where two runs of a dialogue part, pin by pin; empty: nowhere."""
    found = []
    a, b = one.traces(), two.traces()
    for pin in one.outputs:
        if a[pin] != b[pin]:
            pairs = list(zip(zip(*a[pin], strict=True), zip(*b[pin], strict=True), strict=False))
            first = next((pair for pair in pairs if pair[0] != pair[1]), "one is longer")
            found.append(f"{pin}: {len(a[pin][0])} and {len(b[pin][0])} edges, first difference {first}")
    c, d = one.state(), two.state()
    return found + [f"{key} differs" for key in c if c[key] != d[key]]
