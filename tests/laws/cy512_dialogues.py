"""Random dialogues with a CY512: what the fast path and its step-by-step twin are compared on."""

from __future__ import annotations

from random import Random
from typing import Any

from .dialogues import CRYSTALS, Dialogue, in_order, play

__all__ = ["made", "play"]
MS = 10**9


def made(seed: int) -> Dialogue:
    """The dialogue of a seed."""
    rnd = Random(f"cy512 {seed}")
    dialogue = Dialogue(seed, rnd.choice(CRYSTALS), *script(rnd), options(rnd), part="cy512")
    if rnd.random() < 0.1:
        dialogue.events.append((0, "terminate", 0))
        dialogue.kinds.add("terminate")
    quiet = play(dialogue)  # where the steps would be, so that events can hit them exactly
    begins = [int(t) for t in quiet.chip.steps().times_ps] or [dialogue.until_ps // 2]
    edges = sorted({*begins, *(int(t) for t in quiet.bench.edges("x.pulse")[0])})
    for _ in range(rnd.choice((0, 1, 1, 2, 3, 5, 8))):
        happening(dialogue, rnd, edges)
    dialogue.events = in_order(dialogue.events)
    return dialogue


def options(rnd: Random) -> dict[str, Any]:
    """What is inferred: as the part has it, in a third of all dialogues otherwise."""
    if rnd.random() < 2 / 3:
        return {}
    inferred: dict[str, Any] = {
        "terminated": rnd.choice((97, 500, 1380, 5000)),
        "held_pulse": rnd.randrange(2),
        "abort": rnd.choice(("ramp", "stop")),
        "request": rnd.choice(("ramp", "stop")),
        "ramp_start": rnd.choice((0, 1, 200)),
        "pulse_high": rnd.choice((28, 96, 400)),
    }
    return {"inferred": inferred}


def script(rnd: Random) -> tuple[str, int]:
    """What the host sends, and how long to run."""
    lines = [
        "A",
        f"R {rnd.choice((0, 1, 200, 240, 255, rnd.randrange(256)))}",
        f"S {rnd.choice((0, 0, 5, 20, 50, 100, 255, rnd.randrange(256)))}",
        f"O {rnd.randrange(8)}",
    ]
    if rnd.random() < 0.3:
        lines.append(f"F {rnd.choice((1, 2, 3, 0))}")
    if rnd.random() < 0.4:
        lines.append("H")
    motions = []
    for _ in range(rnd.choice((1, 1, 2, 3))):
        motions.append(f"N {rnd.choice((1, 2, 3, 7, 12, 50, 103, 300, 700, rnd.randrange(1, 200)))}")
        motions.append(rnd.choice("+-"))
        motions.append(rnd.choice(("G", "G", "G", f"P {rnd.randrange(300)}")))
    if rnd.random() < 0.3:
        return "\r".join([*lines, "E", *motions, "0"]) + "\rQD\r", rnd.choice((60, 200, 500)) * MS
    return "\r".join([*lines, *motions]) + "\r", rnd.choice((60, 200, 500)) * MS


def happening(dialogue: Dialogue, rnd: Random, edges: list[int]) -> None:
    """Add one thing that happens on the pins, often exactly on an edge of PULSE."""
    at = rnd.choice(edges) if rnd.random() < 0.5 else rnd.randrange(edges[0], max(edges[-1], edges[0] + 1) + 1)
    if at in edges:
        dialogue.kinds.add("tie")
    later = rnd.choice(edges) if rnd.random() < 0.3 else at + rnd.choice((1, 10**6, 10**8, MS, 10 * MS, 30 * MS))
    kind = rnd.choice(("abort", "inhibit", "request", "terminate", "terminate", "terminate", "select", "reset", "prog"))
    dialogue.kinds.add(kind)
    pin, level = {
        "abort": ("abort", 0),
        "inhibit": ("step_inhibit", 1),
        "request": ("io_request", 0),
        "terminate": ("terminate", 0),
        "select": ("io_select", 1),
        "reset": ("reset", 0),
        "prog": ("wait", 0),
    }[kind]
    dialogue.events.append((at, pin, level))
    if rnd.random() < 0.8:
        end = max(later, at + 1)
        if kind == "reset":
            end = at + rnd.choice((10**6, 20 * 10**6, 200 * 10**6))
        dialogue.events.append((end, pin, 0 if kind == "inhibit" else None))
