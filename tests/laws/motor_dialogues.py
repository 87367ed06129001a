"""Random dialogues with a chip that has a stepper with physics behind it: what all ways to play them are compared on.

A dialogue is one of a chip (CY525, GS-C200S, MC1151A-E), with all that happens on its pins, and a motor: its driver,
its load, what sits on its shaft and is fed back to the chip, and what hands do to it, often exactly at an edge of
PULSE, at a grid point, or a picosecond beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from random import Random
from types import ModuleType
from typing import Any

import slewline
from slewline.core.wires.net import Driver
from slewline.parts.motors import integration
from slewline.parts.steppers import motor_run, passing

from . import dialogues, gsc_dialogues, mc_dialogues

FAMILIES: dict[str, ModuleType] = {"cy525": dialogues, "gs-c200s": gsc_dialogues, "mc1151a-e": mc_dialogues}
US, MS = 10**6, 10**9
PULSE = {"cy525": "pulse", "gs-c200s": "clock", "mc1151a-e": "pulse1"}
LENGTHS = (30 * MS, 60 * MS, 120 * MS)
SHORTER = (15 * MS, 30 * MS)  # behind a chopper
HANDS = ("block", "block", "push", "push", "load", "load", "enable", "enable")
UNIPOLAR = {"like": "QSH4218-51-10-049", "windings": "unipolar"}
LEVELS = {"kind": "averaged", "supply": 24, "current": 1, "rest": 0.3, "ramp": 1.2}
DRIVERS: tuple[tuple[Any, str], ...] = (  # and the step of the grid
    ("24 V, 1 A", "100 us"),
    ("24 V, 1 A", "20 us"),
    ({"kind": "averaged", "supply": 12, "current": 0.6}, "50 us"),
    ("L/4R 20 V", "100 us"),
    ("L/2R 12 V", "37 us"),
    ("current 1 A", "100 us"),
    ("current 1 A, boost", "50 us"),
    ({"kind": "current", "current": 1, "lag": 0.0005}, "100 us"),
    ("bilevel 24 V 2 ms, 5 V", "50 us"),
    ("24 V, 1 A chopper, 20 kHz, mixed decay", "10 us"),
    ("24 V, 1 A chopper, 17 kHz, slow decay", "10 us"),
)
LOADS: tuple[Any, ...] = (
    {},
    "inertia 68 g cm2",
    "inertia 20 g cm2, friction 10 mNm",
    {"inertia": "30 g cm2", "friction": "5 mNm", "stiction": "9 mNm"},
    {"inertia": "50 g cm2", "torque": "30 mNm"},
    {"inertia": "60 g cm2", "stiffness": 3.0, "coupling_drag": 0.001, "friction": "4 mNm"},
    {"damper_inertia": "40 g cm2", "damper_drag": 0.0008},
    {"inertia": "20 g cm2", "low": -3.3, "high": 40.2},
)


@dataclass
class Dialogue:
    """One dialogue: `parts` are (kind, name, neighbour, options), `wires` (pin, pin), `hands` (ps, what, value)."""

    seed: int
    chip: str
    talk: Any  # of the family
    stepper: dict[str, Any]
    parts: list[tuple[str, str, str | None, dict[str, Any]]] = field(default_factory=list)
    wires: list[tuple[str, str]] = field(default_factory=list)
    hands: list[tuple[int, str, Any]] = field(default_factory=list)
    kinds: set[str] = field(default_factory=set)


def made(seed: int) -> Dialogue:
    """The dialogue of a seed."""
    rnd = Random(f"motor {seed}")
    chip = rnd.choice(("cy525", "cy525", "gs-c200s", "mc1151a-e"))
    driver, step = rnd.choice(DRIVERS)
    options = {"driver": driver, "step": step, "load": rnd.choice(LOADS), "lag": rnd.choice(("1 us", "1 ps", "20 us"))}
    dialogue = Dialogue(seed, chip, {}, options, kinds={chip})
    dialogue.talk = talk(chip, rnd)
    feed(dialogue, rnd)
    sit(dialogue, rnd)
    if isinstance(driver, str):
        dialogue.kinds.add(driver.partition(" ")[0])
    length = rnd.choice(SHORTER if "chopper" in str(dialogue.stepper["driver"]) else LENGTHS)
    edges = shortened(dialogue, length)
    for _ in range(rnd.choice((0, 1, 1, 2, 3, 5))):
        happening(dialogue, rnd, edges)
    once = {at: (what, value) for at, what, value in dialogue.hands}
    dialogue.hands = [(at, *once[at]) for at in sorted(once)]
    return dialogue


def talk(chip: str, rnd: Random) -> Any:
    """A dialogue with a chip of a kind."""
    while True:
        found = FAMILIES[chip].made(rnd.randrange(1_000_000))
        if getattr(found, "part", chip) == chip:
            break
    if chip == "mc1151a-e":
        hands = ("block", "free", "slip", "push", "run", "quada1", "quadb1")
        events = [event for event in found.events if event.what not in hands]
        return replace(found, shaft=None, events=events)
    return found


def feed(dialogue: Dialogue, rnd: Random) -> None:
    """What drives the motor: steps, phases, or a driver module."""
    options, chance = dialogue.stepper, rnd.random()
    if dialogue.chip == "cy525" and chance < 0.4:
        options["inputs"] = "phases"
        if chance < 0.2:
            options |= {"motor": UNIPOLAR, "driver": rnd.choice(("L/4R 20 V", "L/2R 12 V")), "step": "100 us"}
            dialogue.kinds.add("unipolar")
    elif dialogue.chip == "gs-c200s" and chance < 0.35:
        options["inputs"] = "phases"
        dialogue.kinds.add("gs_d200")
    elif dialogue.chip == "gs-c200s" and chance < 0.7:
        options |= {"driver": LEVELS, "step": "100 us"}
        dialogue.kinds.add("levels")
    else:
        options["steps"] = rnd.choice(("full", "full", "half", "wave", "micro 8"))
    if "inputs" in options:
        dialogue.kinds.add("phases")


def sit(dialogue: Dialogue, rnd: Random) -> None:
    """What sits on the shaft, and what is fed back."""
    parts, wires, lag = dialogue.parts, dialogue.wires, rnd.choice(("1 us", "1 ps", "50 us"))
    under = "m"
    if rnd.random() < 0.4:
        ratio = rnd.choice(((1, 3), (7, 2), (20, 9)))
        parts.append(
            ("gear", "gear", None, {"on": "m", "pinion": ratio[0], "wheel": ratio[1], "reverse": rnd.random() < 0.5})
        )
        under = rnd.choice(("m", "gear"))
        dialogue.kinds.add("gear")
    carries = "m"
    if rnd.random() < 0.5:
        ends = rnd.choice(({}, {"low": -2.4}, {"low": -30, "high": 25.5}))
        parts.append(
            ("carriage", "car", None, {"on": rnd.choice(("m", under)), "backlash": rnd.choice((0, 0.3, 2.5)), **ends})
        )
        carries = "car"
        dialogue.kinds |= {"carriage"} | ({"stop"} if ends else set())
    to = "x" if dialogue.chip == "mc1151a-e" else None
    counts = rnd.choice((200, 400, 2000, 4000))
    parts.append(("encoder", "enc", to, {"on": under, "counts": counts, "lag": lag, "reverse": rnd.random() < 0.2}))
    role = {"cy525": "abort", "gs-c200s": rnd.choice(("home", "end")), "mc1151a-e": rnd.choice(("home", "end_plus"))}
    low = rnd.choice((-5.0, 3.0, 10.5, 30.0))
    zone = {"low": low, "high": rnd.choice((None, low + 4.25, low + 40)), "hysteresis": rnd.choice((0, 0, 0.25))}
    fed = rnd.random() < 0.5
    parts.append(
        ("switch", "sw", "x" if fed else None, {"on": carries, "role": role[dialogue.chip], "lag": lag, **zone})
    )
    if fed:
        dialogue.kinds.add("fed back")
    elif rnd.random() < 0.3:  # a circle, in which the motor follows edge by edge
        parts.append(("inverter", "inv", None, {}))
        wires += [("sw.out", "inv.in1"), ("inv.out", "m.enable")]
        dialogue.kinds.add("circle")
    if dialogue.chip == "cy525" and rnd.random() < 0.2:
        wires.append(("m.stall", "x.step_inhibit"))
        dialogue.kinds.add("stall")


def shortened(dialogue: Dialogue, length: int) -> list[int]:
    """End it so long after its first step, and return what happens in it: edges of PULSE and of the encoder."""
    at_first = 0.0 if dialogue.chip == "mc1151a-e" else 1.0
    quiet = FAMILIES[dialogue.chip].play(dialogue.talk)
    pulses = [int(ps) for ps in quiet.bench.edges(f"x.{PULSE[dialogue.chip]}")[0]]
    end = min((pulses[0] if pulses else int(at_first)) + length, quiet.bench.now_ps)
    if dialogue.chip == "mc1151a-e":
        clock = mc_dialogues.Clock(dialogue.talk.crystal)
        cycles = min(dialogue.talk.cycles, clock.ticks_until(end) // mc_dialogues.CYCLE + 1)
        dialogue.talk = replace(dialogue.talk, cycles=cycles)
    else:
        dialogue.talk = replace(dialogue.talk, until_ps=end)
    played = play(dialogue)
    edges = {int(ps) for pin in played.pins for ps in played.bench.edges(pin)[0]}
    end = played.bench.now_ps
    first = pulses[0] if pulses else end // 2
    return sorted(ps for ps in edges if first <= ps < end) or [(first + end) // 2]


def happening(dialogue: Dialogue, rnd: Random, edges: list[int]) -> None:
    """A hand on the shaft, or on ENABLE."""
    grid = {"20 us": 20, "100 us": 100, "50 us": 50, "37 us": 37, "10 us": 10}[dialogue.stepper["step"]] * US
    at = rnd.choice(edges) if rnd.random() < 0.6 else rnd.randrange(edges[0], edges[-1] + 1)
    at += rnd.choice((0, 0, 1, -1, grid, 2 * grid, grid + 1))
    later = rnd.choice(edges) if rnd.random() < 0.3 else at + rnd.choice((1, US, grid, 3 * grid, 10 * MS))
    what = rnd.choice(HANDS)
    dialogue.kinds.add(what)
    if what == "block":
        dialogue.hands += (at, "block", None), (max(later, at + 1), "free", None)
    elif what == "enable":
        dialogue.hands += (at, "enable", 0), (max(later, at + 1), "enable", None)
    else:
        dialogue.hands.append(
            (at, what, rnd.choice((1, -1, 3, -2)) if what == "push" else rnd.choice((0.0, 0.02, -0.05, 0.3)))
        )


# ------------------------------------------------------------------------------------------------------------ playing
@dataclass
class Played:
    """What a dialogue left behind."""

    bench: slewline.Bench
    pins: tuple[str, ...]

    def edges(self) -> dict[str, Any]:
        """Edges of all pins."""
        found = {pin: self.bench.edges(pin) for pin in self.pins}
        return {pin: (times.tolist(), levels.tolist()) for pin, (times, levels) in found.items()}

    def told(self) -> dict[str, Any]:
        """Edges of all pins, the end of the motor, and what it has found."""
        motor: Any = self.bench["m"]
        told: dict[str, Any] = self.edges()
        told |= {"place": motor.place, "lag": motor.lag, "lost": motor.lost, "command": motor.command}
        told |= {"speed": motor.speed, "currents": motor.currents, "counts": self.bench["enc"].counts}
        told["findings"] = sorted((found.time_ps, found.source, found.code, found.text) for found in motor.findings)
        now = self.bench.now_ps
        asked = [now * k // 13 for k in range(14)]
        told["past"] = [quantity.at(asked).tolist() for quantity in motor.quantities()]
        told["carriage"] = self.bench["car"].place if "car" in self.bench else None
        return told


def fitted(dialogue: Dialogue, bench: slewline.Bench, kind: Callable[[str], str] = str) -> None:
    """Put the motor on a bench, with all that belongs to it, each part of a kind."""
    options, chip = dict(dialogue.stepper), "x"
    if "gs_d200" in dialogue.kinds:
        bench.part("gs_d200", "d", "x")
        bench.part(kind("stepper"), "m", **options)
        for n, phase in enumerate("abcd", 1):
            bench.wire(f"d.{phase}", f"m.phase{n}")
    else:
        bench.part(kind("stepper"), "m", chip, **options)
    for what, name, to, given in dialogue.parts:
        bench.part(kind(what), name, *([] if to is None else [to]), **given)
    for one, two in dialogue.wires:
        bench.wire(one, two)


def play(
    dialogue: Dialogue,
    *,
    stepwise: bool = False,
    shuffle: int | None = None,
    watched: bool = False,
    pieces: int | None = None,
    kind: Callable[[str], str] = str,
) -> Played:
    """Play a dialogue on a fresh bench, perhaps watched, perhaps in random pieces with questions in between."""
    pins = [f"x.{PULSE[dialogue.chip]}", "enc.a", "enc.b", "enc.index", "sw.out", "m.stall"]
    enable: list[Driver] = []

    def hand(bench: slewline.Bench, what: str, value: Any) -> Callable[[], object]:
        motor: Any = bench["m"]
        if what == "enable":
            return lambda: enable[0].drive(value)
        return getattr(motor, what) if value is None else (lambda: getattr(motor, what)(value))

    def fit(bench: slewline.Bench) -> None:
        fitted(dialogue, bench, kind)
        enable.append(Driver(bench["m"].pin("enable").net, "hand"))
        bench.record(*pins)
        if watched:
            for pin in pins:
                part, _, own = pin.partition(".")
                bench[part].pin(own).net.watch(lambda _net: None)
        for at, what, value in dialogue.hands:
            bench.at(at, hand(bench, what, value))

    family = FAMILIES[dialogue.chip]
    with in_pieces(None if pieces is None else Random(f"{pieces} {dialogue.seed}")):
        played = family.play(dialogue.talk, stepwise=stepwise, shuffle=shuffle, fit=fit)
    return Played(played.bench, tuple(pins))


@contextmanager
def in_pieces(rnd: Random | None) -> Iterator[None]:
    """Let `bench.run_to` run in random pieces, and ask for this and that in between."""
    whole: Any = slewline.Bench.run_to

    def run_to(bench: slewline.Bench, until: int) -> None:
        assert rnd is not None
        now = bench.now_ps
        cuts = sorted({rnd.randrange(now, until + 1) for _ in range(rnd.choice((3, 10, 25)))} if until > now else ())
        for cut in cuts:
            whole(bench, cut)
            asked(bench, rnd)
        whole(bench, until)

    if rnd is not None:
        slewline.Bench.run_to = run_to  # type: ignore[method-assign,assignment]
    try:
        yield
    finally:
        slewline.Bench.run_to = whole  # type: ignore[method-assign]


def asked(bench: slewline.Bench, rnd: Random) -> None:
    """Ask for something."""
    motor: Any = bench["m"]
    now = bench.now_ps
    match rnd.choice(("place", "counts", "edges", "findings", "past", "curve", "carriage", "stall")):
        case "place":
            assert motor.lag == motor.command - motor.place
        case "counts":
            assert bench["enc"].counts is not None  # type: ignore[attr-defined]
        case "edges":
            bench.edges(rnd.choice(("enc.a", "enc.index", "sw.out", "m.stall")))
        case "findings":
            assert bench.findings is not None
        case "past":
            for quantity in motor.quantities():
                quantity.at([rnd.randrange(now + 1) for _ in range(3)])
        case "curve":
            rnd.choice(motor.quantities()).changes(now // 2, now)
        case "carriage":
            if "car" in bench:
                assert bench["car"].place is not None  # type: ignore[attr-defined]
        case _:
            assert motor.pin("stall").level in (0, 1)


@contextmanager
def blocks(rnd: Random, *, soon: bool = False) -> Iterator[None]:
    """Let everything be done in other, small blocks; `soon`: Numba takes over somewhere."""
    small: dict[tuple[ModuleType, str], int] = {
        (integration, "CHUNK"): rnd.choice((1, 7, 64, 300)),
        (motor_run, "STRETCH"): rnd.choice((8, 50, 300)),
        (motor_run, "WHOLE"): rnd.choice((1, 2, 5)),
        (passing, "FIRST_PS"): rnd.choice((3 * US, 77 * US, 5 * MS)),
        (passing, "MOST_PS"): rnd.choice((900 * US, 30 * MS)),
        (passing, "AHEAD_PS"): rnd.choice((2 * MS, 100 * MS)),
        (passing, "MARKS"): rnd.choice((2, 10)),
    }
    if soon:
        small[integration, "SOON"] = rnd.choice((0, 17, 500, 2000))
    before = {key: getattr(*key) for key in small}
    for key, value in small.items():
        setattr(*key, value)
    try:
        yield
    finally:
        for key, value in before.items():
            setattr(*key, value)


def differences(one: dict[str, Any], two: dict[str, Any]) -> list[str]:
    """Where two tales part; empty: nowhere."""
    found = []
    for key, value in one.items():
        if value != two[key]:
            says = f"{value!r} and {two[key]!r}"
            if isinstance(value, tuple) and value and isinstance(value[0], list):
                pairs = list(zip(zip(*value, strict=True), zip(*two[key], strict=True), strict=False))
                first = next((pair for pair in pairs if pair[0] != pair[1]), "one is longer")
                says = f"{len(value[0])} and {len(two[key][0])} edges, first difference {first}"
            found.append(f"{key}: {says}"[:300])
    return found


def nearly(one: dict[str, Any], two: dict[str, Any], unsure: dict[int, int]) -> dict[str, Any]:
    """The edges of `one`, those that differ from `two` by less than is certain of them moved there."""
    found = {}
    for pin, (times, levels) in one.items():
        others = two[pin][0]
        moved = [
            other if abs(other - time) <= unsure.get(time, 0) else time
            for time, other in zip(times, others, strict=False)
        ]
        found[pin] = moved + times[len(moved) :], levels
    return found
