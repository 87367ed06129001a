"""Random dialogues with an MC1451A whose encoders turn: what looking ahead is compared on (test_mc_ahead.py).

Stall detection is on, so that an axis sleeps as long as the counts that its encoder promises let it.  In between the
shaft is blocked, slips, is pushed by hand or goes another way, somebody pulls at the wires of A and B, and the host
reads, writes and resets.
"""

from __future__ import annotations

from random import Random
from typing import Any

import slewline
from slewline.chips.mc1451a.axis.enc import QuadratureCounter
from slewline.core.motion.history import Staircase

from . import mc_dialogues
from .mc_dialogues import CRYSTALS, CYCLE, ONE, Dialogue, Event, Maker, Talked

STILL = ("GET_ACTL_POS", "GET_ACTL_POS_ERR", "GET_STATUS", "GET_TRGT_POS", "GET_INTRPT", "GET_TIME")
SAID = (
    *STILL * 3, *("velocities", "recover", "stops", "breakpoint", "move") * 2, "SET_POS_ERR", "SET_POS_ERR",
    "CLR_STATUS", "SET_STEP_RATIO", "SET_ACTL_POS", "SET_AUTO_STOP_ON", "SET_AUTO_STOP_OFF", "SYNCH_PRFL", "MTR_ON",
    "RST_INTRPT", "SET_PRFL_VEL", "SET_PRFL_GEAR", "SET_RATIO", "RESET",
)  # fmt: skip
RATES = (300, 1000, -3000, 5000, 20_000, -40_000)  # counts/s
GAPS = (0, 1, 2, 3, 5, 10, 30, 70)  # cycles between two things that are said or done


class ShaftMaker(Maker):
    """Makes up a dialogue about a shaft that turns."""

    def mount(self) -> None:
        """An encoder or a master on the shaft of axis 1, or nothing but wires."""
        rnd = self.rnd
        kind = rnd.choice(("encoder", "encoder", "encoder", "quadrature", "wires"))
        counts, steps = rnd.choice(((1, 1), (400, 400), (4, 1), (3, 7), (10, 1), (4000, 12800)))
        self.ratio = counts * 256 // steps
        if kind == "encoder":
            options = {"counts": counts, "steps": steps, "lag": rnd.choice(("1 ps", "1 us", "50 us"))}
            self.dialogue.shaft = kind, options | {"reverse": rnd.random() < 0.1}
        elif kind == "quadrature":
            self.dialogue.shaft = kind, {}
        self.dialogue.kinds.add(kind)

    def velocity(self) -> int:
        """Speeds at which the twin takes no minutes, and seldom one that is too fast for the encoder chip."""
        rnd = self.rnd
        if rnd.random() < 0.02:
            return 90 * ONE
        slow = (0x500, 0x4000, ONE, ONE, 3 * ONE // 2, 5 * ONE, rnd.randrange(1, 6 * ONE), 20 * ONE)
        return min(rnd.choice(slow), 20 * ONE * 256 // max(self.ratio, 1))

    def prepare(self) -> None:
        """Stall detection, an aim, and the first update."""
        rnd, send = self.rnd, self.send
        for axis in range(1, self.axes + 1):
            self.axis = axis
            send(f"SET_{axis}")
            send("SET_STEP_RATIO", rnd.choice((self.ratio, self.ratio, 256, rnd.randrange(1, 3000))))
            send("SET_POS_ERR", rnd.choice((0, 1, 2, 3, 10, 10, 30, 100, 1000, 32767)))
            if rnd.random() < 0.6:
                send("SET_AUTO_STOP_ON")
            send("SET_INTRPT_MASK", 0xFF)
            send("SET_OUTPUT_HIGH")
            self.set_velocities(self.velocity())
            send("SET_POS", rnd.choice((1, -1)) * rnd.choice((300, 2000, 100_000)))
            send("SET_RATIO", self.value("SET_RATIO"))
            send(rnd.choice(("SET_PRFL_VEL", "SET_PRFL_VEL", "SET_PRFL_TRAP", "SET_PRFL_S_CRV", "SET_PRFL_GEAR")))
        self.update()
        self.begun = self.free
        if self.dialogue.shaft is not None and self.dialogue.shaft[0] == "quadrature":
            self.dialogue.events.append(Event(self.free + rnd.randrange(CYCLE), "run", rnd.choice(RATES)))

    def value(self, name: str) -> int | None:
        """What a command is given."""
        rnd = self.rnd
        loop = self.dialogue.shaft is not None and self.dialogue.shaft[0] == "encoder"  # a gear that follows itself
        values = {
            "SET_RATIO": (ONE // 20, -ONE // 30) if loop else (ONE, -ONE, ONE // 3, 5 * ONE, 60 * ONE),
            "SET_POS_ERR": (0, 1, 3, 10, 100, 32767),
            "SET_STEP_RATIO": (self.ratio, 256, 1, rnd.randrange(1, 32768)),
        }
        return rnd.choice(values[name]) if name in values else super().value(name)

    def say(self) -> None:
        """One thing that the host does next, some cycles later."""
        rnd = self.rnd
        self.free += rnd.choice(GAPS) * CYCLE + rnd.choice((0, 0, rnd.randrange(CYCLE)))
        name = rnd.choice(SAID)
        if name == "RESET" and rnd.random() < 0.6:
            name = "GET_ACTL_POS"
        match name:
            case "velocities":
                self.set_velocities(rnd.choice((self.speed // 2, 2 * self.speed, self.velocity())))
                self.update()
            case "recover":
                for each in ("CLR_STATUS", "SYNCH_PRFL", "MTR_ON"):
                    self.send(each)
                self.update()
            case "stops":
                self.send(rnd.choice(("STOP", "SMOOTH_STOP")))
                self.update()
            case "move":
                self.send("SET_POS", rnd.choice((1, -1)) * rnd.choice((10, 300, 2000)))
                self.update()
            case "breakpoint":
                self.send("SET_BRK_PNT", rnd.randrange(-500, 500) % (1 << 32))
                self.send(rnd.choice(("SET_ACTL_POS_BRK", "SET_ACTL_NEG_BRK")))
            case _:
                self.send(name, self.value(name), self.instant())

    def disturb(self, last: int) -> None:
        """One thing that happens to a shaft, or to its wires, before a clock."""
        rnd, add = self.rnd, self.dialogue.events.append
        tick, late = self.moment(last)
        axis = rnd.randrange(1, self.axes + 1)
        if axis > 1 or self.dialogue.shaft is None:
            self.turn(axis, tick, late)
        elif rnd.random() < 0.2:  # somebody pulls a wire low, which the encoder drives as well
            pin, lasts = f"quad{rnd.choice('ab')}1", rnd.choice((5, 13, 500, 5 * CYCLE))
            add(Event(tick, pin, 0, late))
            add(Event(tick + lasts, pin, None, late))
        elif self.dialogue.shaft[0] == "quadrature" and rnd.random() < 0.1:  # too fast, for a moment
            add(Event(tick, "run", 1_260_000, late))
            add(Event(tick + rnd.choice((100, CYCLE)), "run", 0, late))
        elif self.dialogue.shaft[0] == "quadrature":
            add(Event(tick, "run", rnd.choice((0, *RATES)), late))
        else:
            what = rnd.choice(("block", "slip", "push", "push"))
            value = {"block": None, "slip": rnd.choice((1, 5, 40)), "push": rnd.choice((1, -1, 9, -40))}[what]
            add(Event(tick, what, value, late))
            if what == "block":
                add(Event(tick + rnd.choice((1, 5, 40)) * CYCLE, "free", None, late))


def made(seed: int) -> Dialogue:
    """The dialogue of a seed."""
    rnd = Random(seed)
    part = rnd.choice(("mc1151a-e", "mc1151a-e", "mc1251a-e"))
    maker = ShaftMaker(Dialogue(seed, part, rnd.choice(CRYSTALS)), rnd)
    maker.mount()
    maker.prepare()
    for _ in range(rnd.choice((2, 5, 9))):
        maker.say()
    last = maker.free + rnd.choice((5, 40, 100)) * CYCLE
    for _ in range(rnd.choice((0, 1, 2, 4, 7))):
        maker.disturb(last)
    dialogue = maker.dialogue
    dialogue.cycles = last // CYCLE + 1
    once = {(event.tick, event.late_ps, event.what): event for event in dialogue.events}
    dialogue.events = sorted(once.values(), key=lambda event: (event.tick, event.late_ps))
    return dialogue


class Turned(Talked):
    """What such a dialogue left behind: findings with their instants, but for those of wires that are fought over."""

    actual: list[list[float]]  # what was asked of the past now and then

    def state(self) -> dict[str, Any]:
        """All that a dialogue leaves behind."""
        state = super().state()
        del state["findings"]
        state.pop("encoder", None)
        found = [(found.time_ps, found.code) for found in self.chip.findings if found.code != "conflict"]
        first = next((at for at, code in found if code == "reset"), self.bench.now_ps)
        return state | {"found": sorted(pair for pair in found if pair[0] <= first)}


def play(
    dialogue: Dialogue, *, stepwise: bool = False, shuffle: int | None = None, least: int = 4, most: int = 256
) -> Turned:
    """Play a dialogue on a fresh bench, with windows of so many cycles; now and then somebody asks for the past."""
    asked: list[list[float]] = []

    def ask(bench: slewline.Bench) -> None:
        chip: Any = bench["x"]
        axis = chip.axis(1)
        for quantity in axis.quantities():
            if quantity.name == "actual_position" and isinstance(quantity, Staircase):
                now = bench.now_ps
                asked.append([*quantity.at(list(range(0, now, max(now // 97, 1))))])

    def fit(bench: slewline.Bench) -> None:
        if not stepwise:
            for k in range(dialogue.seed % 4):
                at = (mc_dialogues.ORIGIN + (20 + 31 * k) * CYCLE + 17 * k) * 10**12 // dialogue.crystal
                bench.at(at, lambda: ask(bench))

    before = QuadratureCounter.least, QuadratureCounter.most
    QuadratureCounter.least, QuadratureCounter.most = least, most
    try:
        talked = mc_dialogues.play(dialogue, stepwise=stepwise, shuffle=shuffle, fit=fit)
    finally:
        QuadratureCounter.least, QuadratureCounter.most = before
    turned = Turned(talked.bench, talked.chip, talked.read)
    turned.heard = talked.heard
    if not stepwise:
        ask(talked.bench)
    turned.actual = asked
    return turned
