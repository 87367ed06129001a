"""Random dialogues about motion with a CY545: what the fast path and its step-by-step twin are compared on."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random
from typing import Any

import slewline
from slewline.core.wires.net import Driver

from .dialogues import Dialogue, Played, heard, in_order

MS = 10**9
MOST = 500  # steps
PINS = ("pulse", "ccw", "stopped", "slew", "busy", "txd", "usrb0", "usrb1")
EVENTS = ("inhibit_abort", "cw_limit", "ccw_limit", "slew", "ccw", "jog", "usrb0", "usrb1", "reset")
KINDS = ("inhibit", "limit", "slew", "ccw", "jog", "home", "user", "reset", "tie")
CRYSTALS = ("12 MHz", "11 MHz", "16 MHz", "3.579545 MHz", "1 MHz")


@dataclass
class Motions(Dialogue):
    """A dialogue; `sensor` is a switch on the carriage, closed from one place to below another."""

    sensor: tuple[int, int, int] | None = None  # from, to, backlash; steps


def made(seed: int) -> Motions:
    """The dialogue of a seed."""
    rnd = Random(f"cy545 {seed}")
    sent = script(rnd)
    part = rnd.choice(("cy545", "cy545b"))
    dialogue = Motions(seed, rnd.choice(CRYSTALS), sent, 1000 * MS, options(rnd), part=part)
    if "\rH " in sent:
        dialogue.kinds.add("home")
        place = rnd.randrange(-60, 60)
        dialogue.sensor = place, place + rnd.choice((1, 5, 40, 1000)), rnd.choice((0, 0, 7))
    quiet = play(dialogue)  # where the steps would be, so that events can hit them exactly
    most = MOST if dialogue.sensor is None else MOST // 3  # a step that a carriage follows costs more
    every = quiet.chip.steps().times_ps
    begins = [int(t) for t in every[:most]] or [dialogue.until_ps // 100]
    dialogue.until_ps = begins[-1] + rnd.choice((1, 8, 40) if len(every) < most else (1, 2)) * MS
    edges = {int(t) for pin in ("pulse", "stopped") for t in quiet.bench.edges(f"x.{pin}")[0][: 2 * most]}
    ordered = sorted({*begins, *(t for t in edges if t < dialogue.until_ps)})
    for _ in range(rnd.choice((0, 1, 1, 2, 3, 5, 8))):
        happening(dialogue, rnd, ordered)
    if "\rC\r" in sent and rnd.random() < 0.7:
        at = rnd.choice(begins)
        dialogue.events += [(at, "inhibit_abort", 0), (at + rnd.choice((1, 10**8, MS, 30 * MS)), "inhibit_abort", None)]
    dialogue.events = in_order(dialogue.events)
    return dialogue


def options(rnd: Random) -> dict[str, Any]:
    """The law and the times: as the part has them, in a third of all dialogues otherwise."""
    baud = rnd.choice((None, 19200))  # at which the position is shown
    if rnd.random() < 2 / 3:
        return {"fixed_baud": baud}
    first = rnd.choice((1, 20, 500))
    rising = [first]
    while len(rising) < 256:
        rising.append(min(rising[-1] + rnd.choice((0, 1, 25, 100, 400)), 40_000))
    inferred: dict[str, Any] = {
        "rates": rnd.choice(((), rising)),
        "ramp_unit": rnd.choice((1, 500, 3072, 20_000)),
        "first_step": rnd.choice((1, 240, 1200)),
        "ccw_lead": rnd.choice((1, 240, 1000)),
        "inhibit_release": rnd.choice((1, 300, 5000)),
        "pulse_low": rnd.choice((1, 60, 200)),
    }
    return {
        "fixed_baud": baud,
        "inferred": inferred,
        "ramp_jumps": rnd.random() < 0.5,
        "rate_table": rnd.choice(("20k", "27k")),
    }


def script(rnd: Random) -> str:
    """What the host sends."""
    start = rnd.choice((0, 5, 16777215, rnd.randrange(1 << 24)))
    first = rnd.choice((14, 100, 200, 255, rnd.randrange(256), rnd.randrange(150, 256)))
    lines = [
        f"A {start}",
        f"F {first}",
        f"R {rnd.choice((100, 255, first, min(first + rnd.randrange(80), 255), rnd.randrange(256)))}",
        f"S {rnd.choice((175, 220, 250, 254, 255, rnd.randrange(1, 256)))}",
        *rnd.choice((("O 128",), ("O 144",), ("O 144",))),
    ]
    for _ in range(rnd.choice((1, 1, 2, 3))):
        lines += [f"N {rnd.choice((0, 1, 2, 3, 7, 50, 103, 200, rnd.randrange(1, 300)))}", rnd.choice("+-")]
        if rnd.random() < 0.2:
            lines.append("C")
        target = (start + rnd.randrange(-200, 200)) % (1 << 24)
        if rnd.random() < 0.25:
            lines += [f"F {rnd.randrange(200, 256)}", f"H {rnd.choice((0, 16, 0, 16, 193, 65))}"]
        else:
            lines.append(rnd.choice(("G", "G", "G", f"P {target}" if 200 < start < 1 << 23 else "G")))
        if rnd.random() < 0.3:
            lines.append(rnd.choice(("D 3", "B 16", "F 200", "B 0")))
    return "\r".join(lines) + "\r"


def happening(dialogue: Motions, rnd: Random, edges: list[int]) -> None:
    """Add one thing that happens on the pins, often exactly on an edge of PULSE or STOPPED."""
    at = rnd.choice(edges) if rnd.random() < 0.5 else rnd.randrange(edges[0], dialogue.until_ps)
    kinds = ("inhibit", "inhibit", "limit", "limit", "slew", "ccw", "jog", "jog", "user", "reset")
    kind = rnd.choice(kinds)
    if rnd.random() < (0.6 if kind == "slew" else 0.15):
        at = rnd.randrange(edges[0] + 1)  # before the first step
    if at in edges:
        dialogue.kinds.add("tie")
    later = rnd.choice(edges) if rnd.random() < 0.3 else at + rnd.choice((1, 10**6, 10**8, MS, 10 * MS, 30 * MS))
    pin, level = {
        "inhibit": ("inhibit_abort", 0),
        "limit": (rnd.choice(("cw_limit", "ccw_limit")), 0),
        "slew": ("slew", 0),
        "ccw": ("ccw", 0),
        "jog": ("jog", rnd.randrange(2)),
        "user": (rnd.choice(("usrb0", "usrb1")), 0),
        "reset": ("reset", 1),
    }[kind]
    dialogue.kinds.add(kind)
    dialogue.events.append((at, pin, level))
    if kind == "reset" or rnd.random() < 0.8:
        end = at + rnd.choice((10**6, 30 * 10**6, 200 * 10**6)) if kind == "reset" else max(later, at + 1)
        dialogue.events.append((end, pin, None))


class Moved(Played):
    """What a dialogue left behind."""

    outputs = PINS


def play(dialogue: Motions, *, stepwise: bool = False, shuffle: int | None = None) -> Moved:
    """Play a dialogue on a fresh bench."""
    bench = slewline.Bench(shuffle=shuffle)
    chip = bench.add(dialogue.part, "x", dialogue.crystal, stepwise=stepwise, **dialogue.options)
    if dialogue.sensor is not None:
        low, high, backlash = dialogue.sensor
        motor = bench.part("motor", "motor", to=chip)
        carriage = bench.part("carriage", "carriage", on=motor, backlash=backlash)
        bench.part("switch", "home", on=carriage, low=low, high=high)
        bench.wire("home.out", "x.usrb0")
    host = bench.host(chip, over="parallel")
    drivers = {name: Driver(chip.pin(name).net, "event") for name in EVENTS}
    bench.record(*(f"x.{pin}" for pin in PINS))
    host.send(dialogue.sent)
    for at, name, level in dialogue.events:
        bench.at(at, lambda name=name, level=level: drivers[name].drive(level))  # type: ignore[misc]
    played = Moved(bench, chip)
    played.heard = heard(chip)
    bench.run_to(dialogue.until_ps)
    return played
