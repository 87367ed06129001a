"""Random dialogues with a CY500: slopes, half steps, jogs, turns, and lines that change when steps begin."""

from __future__ import annotations

from random import Random
from typing import Any

import slewline
from slewline.core.wires.net import Driver

from .dialogues import Dialogue, Played, heard, in_order

OUTPUTS = (
    "ready", "instrobe", "prog", "run", "programmable_output", "pulse", "motion_complete", "phase1", "phase2",
    "phase3", "phase4",
)  # fmt: skip
LINES = ("abort", "trigger", "xss", "xdir", "reset", "wait")
CRYSTALS = ("6 MHz", "3.579545 MHz", "1 MHz")
KINDS = (*LINES, "tie", "jog", "slope", "half", "external", "program")


class Played500(Played):
    """What a dialogue with a CY500 left behind."""

    outputs = OUTPUTS


def made(seed: int) -> Dialogue:
    """The dialogue of a seed."""
    rnd = Random(seed)
    kinds: set[str] = set()
    dialogue = Dialogue(seed, rnd.choice(CRYSTALS), *script(rnd, kinds), laws(rnd), kinds=kinds)
    if "jog" in kinds:
        at = rnd.randrange(10**9, dialogue.until_ps // 2)
        dialogue.events += [(at, "xss", 0), (at + rnd.choice((1, 10**7, 10**9, 5 * 10**9)), "xss", None)]
    quiet = play(dialogue)  # where the steps would be, so that events can hit them exactly
    begins = [int(t) for t in quiet.chip.steps().times_ps] or [dialogue.until_ps // 2]
    edges = sorted({*begins, *(int(t) for t in quiet.bench.edges("x.pulse")[0])})
    for _ in range(rnd.choice((0, 1, 1, 2, 3, 5))):
        happening(dialogue, rnd, edges)
    dialogue.events = in_order(dialogue.events)
    return dialogue


def laws(rnd: Random) -> dict[str, Any]:
    """Options: those of the part, in a third of all dialogues others."""
    if rnd.random() < 2 / 3:
        return {}
    first, fall = rnd.choice(((20_000, 70), (3_000, 7)))
    inferred = {"periods": [first - fall * rate for rate in range(254)], "ramp_start": rnd.choice((1, 5, 100))}
    return {"inferred": inferred, "p_starts": rnd.random() < 0.5, "early_part": rnd.random() < 0.5}


def script(rnd: Random, kinds: set[str]) -> tuple[str, int]:
    """What the host sends, and how long to run."""
    lines = [
        f"R {rnd.choice((200, 240, 253, 253, rnd.randrange(256)))}",
        f"F {rnd.choice((1, 1, 2, rnd.randrange(9)))}",
        "A",
    ]
    for kind, line, share in (
        ("slope", f"S {rnd.choice((5, 20, 60, 200))}", 0.5),
        ("half", "H", 0.3),
        ("external", "L", 0.4),
    ):
        if rnd.random() < share:
            kinds.add(kind)
            lines.append(line)
    motions = []
    for _ in range(rnd.choice((1, 1, 2))):
        motions.append(rnd.choice("+-"))
        motions.append(f"N {rnd.choice((1, 2, 3, 7, 20, 50, 256, rnd.randrange(1, 300)))}")
        if rnd.random() < 0.2:
            motions.append(f"P {rnd.choice((rnd.randrange(65536), rnd.randrange(200)))}")
        motions.append(rnd.choice("GGGO"))
    if rnd.random() < 0.3:
        kinds.add("program")
        return "\r".join([*lines, "E", *motions, rnd.choice("0TU"), "0"]) + "\rQD\r", rnd.choice((60, 200, 500)) * 10**9
    if rnd.random() < 0.4:
        kinds.add("jog")
        motions.append("J")
    return "\r".join([*lines, *motions]) + "\r", rnd.choice((60, 200, 500)) * 10**9


def happening(dialogue: Dialogue, rnd: Random, edges: list[int]) -> None:
    """Add one thing that happens on the pins, often exactly on an edge of PULSE."""
    at = rnd.choice(edges) if rnd.random() < 0.5 else rnd.randrange(edges[0], max(edges[-1], edges[0] + 1) + 1)
    if at in edges:
        dialogue.kinds.add("tie")
    later = rnd.choice(edges) if rnd.random() < 0.3 else at + rnd.choice((1, 10**6, 10**8, 10**9, 10**10))
    pin = rnd.choice(("abort", "trigger", "trigger", "xss", "xdir", "xdir", "reset", "wait"))
    dialogue.kinds.add(pin)
    dialogue.events.append((at, pin, {"abort": 0, "trigger": 1, "xss": 0, "reset": 0}.get(pin, rnd.randrange(2))))
    if pin == "reset":
        later = at + rnd.choice((10**6, 20 * 10**6, 200 * 10**6))
    if pin != "wait" and rnd.random() < 0.8:
        dialogue.events.append((max(later, at + 1), pin, None))


def play(dialogue: Dialogue, *, stepwise: bool = False, shuffle: int | None = None) -> Played:
    """Play a dialogue on a fresh bench."""
    bench = slewline.Bench(shuffle=shuffle)
    chip = bench.add("cy500", "x", dialogue.crystal, stepwise=stepwise, **dialogue.options)
    host = bench.host(chip)
    drivers = {name: Driver(chip.pin(name).net, "event") for name in LINES}
    rest = {"trigger": 0, "abort": 1, "reset": 1, "xss": 1, "xdir": 1, "wait": 1}
    for name, driver in drivers.items():
        driver.drive(rest[name])
    bench.record(*(f"x.{pin}" for pin in OUTPUTS))
    host.send(dialogue.sent)
    for at, name, level in dialogue.events:
        to = rest[name] if level is None else level
        bench.at(at, lambda name=name, to=to: drivers[name].drive(to))  # type: ignore[misc]
    played = Played500(bench, chip)
    played.heard = heard(chip)
    bench.run_to(dialogue.until_ps)
    return played
