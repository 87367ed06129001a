"""Random dialogues with a GS-C module: what the fast path and its step-by-step twin are compared on.

A dialogue is data: a program, how it is started, and what happens on pins and line at given instants, half of them on
an edge or a look of the undisturbed run.  A line is sent early enough to be obeyed at its instant.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cache
from random import Random
from typing import Any

import slewline

from .dialogues import Played, heard, in_order

OUTPUTS = ("clock", "dir", "mov", "ramp", "rdy", "uo1", "uo2", "uo3", "reset", "txd")
LINES = ("K", "Z", "Z", "F", "V1", "E", "V2", "Q")
US, MS = 10**6, 10**9
STEPS = (400,) * 12 + (4000,)  # of the undisturbed run; then the dialogue ends
SPEEDS = (1, 10, 20, 50, 100, 300, 999, 1000)
EXTREMES = {"gs-c200": (0, 0, 3, 40, 9_999_990), "gs-c200s": (0, 0, -3, 8_388_600, -8_388_600)}


@dataclass
class Dialogue:
    """One dialogue: `events` are (instant in ps, pin, level), (instant, "line", text) or (instant, "power", on)."""

    seed: int
    part: str
    options: dict[str, Any]
    position: int
    program: list[str]
    start: str  # "E", "H+" ..., or "power": recalled and run at power-up
    until_ps: int = 0
    events: list[tuple[int, str, Any]] = field(default_factory=list)
    kinds: set[str] = field(default_factory=set)


def made(seed: int) -> Dialogue:
    """The dialogue of a seed."""
    rnd = Random(seed)
    dialogue = scripted(seed, rnd)
    dialogue.until_ps = begin(dialogue).bench.now_ps + 3000 * MS
    if dialogue.start != "E":
        switches(dialogue, rnd)
    instants = marks(dialogue, rnd.choice(STEPS))
    for _ in range(rnd.choice((0, 1, 1, 2, 3, 5))):
        happening(dialogue, rnd, instants)
    dialogue.events = in_order(dialogue.events)
    return dialogue


def marks(dialogue: Dialogue, most: int) -> list[int]:
    """Edges and looks of the undisturbed run, which also says how long to play."""
    quiet = play(dialogue)
    begins = quiet.chip.steps().times_ps.tolist()
    if len(begins) > most:
        dialogue.until_ps = begins[most]
    found = {time for pin in OUTPUTS[:5] for time in quiet.bench.edges(f"x.{pin}")[0].tolist()}
    rises = [t for t, level in zip(*(p.tolist() for p in quiet.bench.edges("x.mov")), strict=True) if level]
    found |= {rise + n * MS for rise in rises for n in range(-1, 4)}  # looks of W and of a controlled velocity
    found |= {rise + 5 * US for rise in rises}  # between DIR and the first step
    earliest = begin(dialogue).bench.now_ps + 10 * MS
    inside = sorted(t for t in found if earliest < t <= dialogue.until_ps) or [(earliest + dialogue.until_ps) // 2]
    rises = [rise for rise in rises if earliest < rise <= dialogue.until_ps]
    return inside + rises * (len(inside) // (8 * len(rises) or 1))  # every eighth one a begin of a motion


# ------------------------------------------------------------------------------------------------------- the program
def scripted(seed: int, rnd: Random) -> Dialogue:
    """A part, its options, a program, and the way it is started."""
    part = rnd.choice(("gs-c200", "gs-c200s"))
    options: dict[str, Any] = {}
    if rnd.random() < 0.2:
        options["mov_hold"] = True
    if rnd.random() < 0.2:
        options["law"] = "linear in steps"
    if rnd.random() < 0.2:
        options["instruction_time"] = rnd.choice(("100 us", "3 ms"))
    ramp = rnd.choice((1, 1, 2, 3, 5, 10, 50, 999, rnd.randrange(1, 60)))
    lines = [f"S{speed(rnd)}", f"T{speed(rnd)}", f"R{ramp}"]
    for _ in range(rnd.choice((1, 2, 3))):
        lines += motion(rnd, part, ramp)
        lines += rnd.choice(([], ["A1"], ["C1"], ["A2", "C2"], ["W1"], ["D1"], ["A3"]))
    if rnd.random() < 0.2:
        lines += rnd.choice((["L3"], ["U2"], ["R2", "+7"], ["T1000", "-9"]))
    if part == "gs-c200s" and rnd.random() < 0.2:
        lines += rnd.choice((["I3"], ["j0"], ["jc7,12"], ["f+5", "I1", "+3"]))
    start = rnd.choice(("E",) * 7 + ("H", "H-", "power"))
    return Dialogue(seed, part, options, rnd.choice(EXTREMES[part]), lines, start)


def speed(rnd: Random) -> int:
    return rnd.choice((*SPEEDS, rnd.randrange(1, 1001), rnd.randrange(5, 200)))


def motion(rnd: Random, part: str, ramp: int) -> list[str]:
    """A motion instruction, often at the edge of what makes a ramp."""
    sign = rnd.choice("+-")
    number = rnd.choice((1, 2, 3, 4, ramp, 2 * ramp - 1, 2 * ramp, 2 * ramp + 1, 2 * ramp + 2, rnd.randrange(1, 120)))
    endless = "G" if part == "gs-c200" else "g"
    kind = rnd.random()
    if kind < 0.6:
        return [f"{sign}{number}"]
    if kind < 0.7:
        return [f"G{sign if part == 'gs-c200s' else ''}{rnd.randrange(100)}"]
    return [f"{endless}{sign}"] if kind < 0.8 else [f"{endless}{sign}{rnd.choice('123')}"]


# -------------------------------------------------------------------------------------------------- what happens when
def switches(dialogue: Dialogue, rnd: Random) -> None:
    """A homing that finds its switches, often just as a step begins."""
    period = 10**11 // int(dialogue.program[0][1:])
    at = begin(dialogue).bench.now_ps + arrives("H") + 10**7
    for pin in ("eot", "home"):
        at += rnd.randrange(12) * period + rnd.choice((0, 0, 0, 1, -1, 10**7, rnd.randrange(1, period)))
        dialogue.events.append((at, pin, 0))
        if rnd.random() < 0.3:
            dialogue.events.append((at + rnd.randrange(1, 3 * period), pin, None))


def happening(dialogue: Dialogue, rnd: Random, instants: list[int]) -> None:
    """Add one thing that happens, often exactly on an edge or a look, or together with another one."""
    at = rnd.choice(instants) if rnd.random() < 0.6 else rnd.randrange(instants[0], dialogue.until_ps + 1)
    if at in instants:
        dialogue.kinds.add("tie")
    later = rnd.choice(instants) if rnd.random() < 0.3 else at + rnd.choice((1, US, 5 * US, MS, 10 * MS))
    later = max(later, at + 1)
    recent = (at, later, later + 5 * US)  # ENABLE holds a step for 5 us more
    kind = rnd.choice(("enable",) * 3 + ("held",) * 2 + ("input",) * 4 + ("line",) * 5 + ("switch",) * 2 + ("power",))
    dialogue.kinds.add(kind)
    add = dialogue.events.append
    if kind == "enable":
        add((at, "enable", 0))
        add((later, "enable", None))
    elif kind == "input":
        named = [line[-1] for line in dialogue.program if re.fullmatch("[Gg][+-][123]|[WU][123]", line)]
        pin = f"ui{rnd.choice([*named * 3, *'123'])}"
        add((at, pin, 0))
        if rnd.random() < 0.6:
            add((later, pin, None))
    elif kind == "held":  # and told something meanwhile
        add((at, "enable", 0))
        add((at + 4000 * MS, "enable", None))
        text = rnd.choice(LINES[:5])
        dialogue.kinds.add(text)
        add((max(later, at + 300 * MS) - arrives(text), "line", text))
    elif kind == "line":
        text = rnd.choice(LINES)
        dialogue.kinds.add(text)
        add((at - arrives(text), "line", text))
    elif kind == "switch":
        pin = rnd.choice(("eot", "home"))
        add((at, pin, 0))
        add((later, pin, None))
    else:
        add((at, "power", False))
        add((later, "power", True))
    instants += recent * 3


@cache
def arrives(text: str) -> int:
    """Picoseconds from the first bit of a line to the instant at which it is obeyed: its answer begins."""
    bench = slewline.Bench()
    chip = bench.add("gs-c200", "x", straps=STRAPS)
    host = bench.host(chip)
    host.uart.follow_straps()
    bench.run("5 ms")
    bench.record("x.txd")
    start = bench.now_ps
    host.write(text + "\r")
    bench.run("40 ms")
    return int(bench.edges("x.txd")[0][0]) - start


# ------------------------------------------------------------------------------------------------------------ playing
STRAPS = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}


@dataclass
class Talked(Played):
    """What a dialogue left behind; the edges of TXD are the answers with their instants."""

    host: Any
    outputs = OUTPUTS

    def state(self) -> dict[str, Any]:
        """Every finding, too."""
        findings = [str(found) for found in self.chip.findings]
        return {**super().state(), "idle": self.chip.idle, "findings": findings}


def begin(dialogue: Dialogue, *, stepwise: bool = False, shuffle: int | None = None, fit: Any = None) -> Talked:
    """A bench on which the program of the dialogue is stored and ready to be started."""
    bench = slewline.Bench(shuffle=shuffle)
    straps = {**STRAPS, "rec": 0} if dialogue.start == "power" else STRAPS
    chip: Any = bench.add(dialogue.part, "x", straps=straps, stepwise=stepwise, **dialogue.options)
    if fit is not None:
        fit(bench)
    host = bench.host(chip)
    host.ask("P" if dialogue.part == "gs-c200" else "Po")
    for line in dialogue.program:
        assert host.ask(line) == "Y", line
    if dialogue.start == "power":
        assert host.ask("M") == "Y"
        chip.power(False)
        bench.run("1 ms")
    elif dialogue.start == "E":
        chip.axes[0].load(dialogue.position)
    else:
        assert host.ask("E")
        host.ask("K")
        bench.run_until(lambda: not chip._running)
        chip.axes[0].load(dialogue.position)
    bench.record(*(f"x.{pin}" for pin in OUTPUTS))
    talked = Talked(bench, chip, host)
    talked.heard = heard(chip)
    return talked


def play(dialogue: Dialogue, *, stepwise: bool = False, shuffle: int | None = None, fit: Any = None) -> Talked:
    """Play a dialogue on a fresh bench; `fit` puts parts on it."""
    played = begin(dialogue, stepwise=stepwise, shuffle=shuffle, fit=fit)
    bench, chip, host = played.bench, played.chip, played.host

    def happen(name: str, what: Any) -> None:
        if name == "line":
            host.write(what + "\r")
        elif name == "power":
            chip.power(what)
        else:
            chip.pin(name).release() if what is None else chip.pin(name).drive(what)

    happen(*(("power", True) if dialogue.start == "power" else ("line", dialogue.start)))
    for at, name, what in dialogue.events:
        if at > bench.now_ps:
            bench.at(at, lambda name=name, what=what: happen(name, what))  # type: ignore[misc]
    bench.run_to(dialogue.until_ps)
    return played
