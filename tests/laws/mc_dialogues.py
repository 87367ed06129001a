"""Random dialogues with an MC1451A or a sister of it: what the fast path and its cycle-by-cycle twin are compared on.

A dialogue is data: packets and what happens on the input pins, each at a clock of the crystal, counted from cycle 0.
Many of them fall exactly on the start of a cycle, or a clock beside it: a command takes effect when HostRdy rises, 2048
clocks behind its last strobe, so it is strobed that much earlier.

The host port is driven wire by wire, with the times of a fast host; nobody looks at HostRdy, whose times are known.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from random import Random
from typing import Any, NamedTuple

import slewline
from slewline.chips import sheet_of
from slewline.core.time.timebase import Clock
from slewline.core.wires.net import Driver

from .dialogues import Played, heard, told

PARTS = ("mc1151a", "mc1151a-e", "mc1151a-e", "mc1251a", "mc1251a-e", "mc1251a-e", "mc1451a", "mc1451a-e")
CRYSTALS = (25_000_000,) * 6 + (20_000_000, 6_700_001)
CYCLE, SLICE, READY = 8192, 2048, 10 * 8192  # clocks; the port is ready behind cycle 9
ORIGIN = 25  # the clock at which cycle 0 begins: the end of the power-up reset
LOW = 2  # clocks of a strobe, and between two
WORD = SLICE + 4 * LOW  # from HostRdy high to HostRdy high again
ONE = 1 << 16
HIGHEST = 512 * ONE  # steps in a cycle
QUADRATURE = ((0, 0), (1, 0), (1, 1), (0, 1))

CODE = {row.name: row.code for row in sheet_of("mc1451a").commands}
READS = {row.code: sum(arg.size for arg in row.reads) // 2 for row in sheet_of("mc1451a").commands}
WRITES = {row.code: sum(arg.size for arg in row.args) // 2 for row in sheet_of("mc1451a").commands}


class Event(NamedTuple):
    """At a clock since cycle 0 and some picoseconds: a level on a pin, or the first strobe of a packet ends."""

    tick: int
    what: str  # a pin, "packet", "power", or what is done to the shaft: "block", "free", "slip", "push", "run"
    value: Any  # a level, or the code, the words to be written and how many are read
    late_ps: int = 0


@dataclass
class Dialogue:
    """One dialogue."""

    seed: int
    part: str
    crystal: int
    cycles: int = 0
    shaft: tuple[str, dict[str, Any]] | None = None  # at the encoder input of axis 1: the kind of part, and its options
    events: list[Event] = field(default_factory=list)
    kinds: set[str] = field(default_factory=set)


def made(seed: int) -> Dialogue:
    """The dialogue of a seed."""
    rnd = Random(seed)
    maker = Maker(Dialogue(seed, rnd.choice(PARTS), rnd.choice(CRYSTALS)), rnd)
    maker.mount()
    maker.prepare()
    for _ in range(rnd.choice((1, 2, 4, 6, 9))):
        maker.talk()
    last = maker.free + rnd.choice((1, 3, 10, 40)) * CYCLE
    for _ in range(rnd.choice((0, 1, 2, 3, 5))):
        maker.happen(last)
    dialogue = maker.dialogue
    dialogue.cycles = last // CYCLE + 1
    # a wire is told one thing in an instant: two would be a matter of order, which is nobody's to choose
    once = {(event.tick, event.late_ps, event.what): event for event in dialogue.events}
    dialogue.events = sorted(once.values(), key=lambda event: (event.tick, event.late_ps))
    return dialogue


class Maker:
    """Makes up a dialogue."""

    def __init__(self, dialogue: Dialogue, rnd: Random) -> None:
        self.dialogue, self.rnd = dialogue, rnd
        sheet = sheet_of(dialogue.part)
        self.axes, self.encoder = sheet.axes, sheet.encoder
        self.axis = 1
        self.free = self.begun = READY  # the clocks at which the port is ready, and at which the first update was sent
        self.speed, self.base, self.far = ONE, 0, 10  # of what has been set up: steps are counted from `base`
        self.quad = dict.fromkeys(range(1, 5), 0)  # where the encoders are

    # ------------------------------------------------------------------------------------------------------- packets
    def send(self, name: str, value: int | None = None, act: int | None = None) -> None:
        """A packet, as early as may be, or so that it acts at a clock; most of what can be read is read."""
        code = CODE[name]
        count = WRITES[code]
        words = tuple((value or 0) >> 16 * (count - 1 - n) & 0xFFFF for n in range(count))
        takes = SLICE + count * WORD
        begin = self.free + LOW + 1
        while act is not None and act - takes < begin:
            act += CYCLE
        rise = begin if act is None else act - takes
        reads = self.rnd.choice((READS[code] + 1, READS[code], READS[code], 0)) if name != "RESET" else 0
        self.dialogue.events.append(Event(rise, "packet", (code, words, reads)))
        self.dialogue.kinds.add(name)
        if act is not None and act % CYCLE == 0:
            self.dialogue.kinds.add("tie")
        self.free = rise + takes + reads * WORD + (READY if name == "RESET" else 0)

    def set_velocities(self, most: int) -> None:
        """Speed and ramps, so that a move takes some ten cycles."""
        rnd, send = self.rnd, self.send
        self.speed = most
        self.far = most * rnd.choice((1, 10, 20, 40, rnd.randrange(1, 60))) // ONE + rnd.choice((0, 1, 1, 3))
        parts = (1, 2, 3, 7, rnd.randrange(1, 30))
        ramp = rnd.choice((*(most // part for part in parts for _ in range(3)), 2 * most, 1, 0x400, 0))
        send("SET_VEL", most)
        send("SET_ACC", ramp * rnd.choice((1, 1, 1, -1)))
        if rnd.random() < 0.4:
            send("SET_START_VEL", rnd.choice((most // 2, most // 3, most, 2 * most, 0x100, rnd.randrange(most + 1))))
        if rnd.random() < 0.4:
            self.set_s_curve(most)

    def set_s_curve(self, most: int) -> None:
        greatest = min(most // self.rnd.choice((1, 2, 5, 9)) + 1, 32767)
        self.send("SET_MAX_ACC", greatest)
        self.send("SET_JERK", min((greatest << 16) // self.rnd.choice((1, 2, 3, 8, 20)) + 1, (1 << 31) - 1))
        self.send("SET_PRFL_S_CRV")

    def destination(self) -> int:
        """Somewhere near."""
        far = self.far
        return self.base + self.rnd.choice(
            (far, far, -far, far // 2, 2 * far, 0, 1, -1, self.rnd.randrange(-far, far + 1))
        )

    def velocity(self) -> int:
        rnd = self.rnd
        slow = (0x100, 0x1000, 0x4000, 0x5555, 0x8000, ONE - 1, rnd.randrange(1, ONE))
        fast = (ONE, ONE, 3 * ONE // 2, 2 * ONE, 3 * ONE, 8 * ONE, rnd.randrange(1, 16 * ONE))
        return rnd.choice((*slow, *fast, *fast, 16 * ONE, 17 * ONE, rnd.choice((40, 511, 512, 600, 0)) * ONE))

    def prepare(self) -> None:
        """What is set up while nothing moves, and the first update."""
        rnd, send = self.rnd, self.send
        for axis in range(1, self.axes + 1):
            if axis > 1:
                if rnd.random() < 0.5:
                    continue
                send(f"SET_{axis}")
                self.axis = axis
            if rnd.random() < 0.15:
                self.base = rnd.choice(((1 << 30) - 3, -(1 << 30) + 2, 1000, rnd.randrange(-(1 << 30), 1 << 30)))
                send("SET_ACTL_POS", self.base)
            if rnd.random() < 0.2:
                send("SET_OUTPUT_HIGH")
            self.set_velocities(self.velocity())
            send("SET_POS", self.destination())
            if rnd.random() < 0.3:
                send("SET_INTRPT_MASK", rnd.choice((0xFF, 1, 4, 0x71, rnd.randrange(256))))
            if self.encoder and rnd.random() < 0.5:
                self.watch_encoder()
            for name in rnd.sample(("SET_PRFL_VEL", "SET_PRFL_TRAP", "SET_PRFL_GEAR", "SET_PRFL_S_CRV"), 1):
                if rnd.random() < 0.5:
                    send(name)
        self.update()
        self.begun = self.free

    def watch_encoder(self) -> None:
        rnd, send = self.rnd, self.send
        send("SET_STEP_RATIO", rnd.choice((256, 80, 512, 1, 0, 32767, rnd.randrange(32768))))
        if rnd.random() < 0.6:
            send("SET_POS_ERR", rnd.choice((0, 1, 3, 10, 100, 32767)))
        if rnd.random() < 0.5:
            send("SET_AUTO_STOP_ON")
        if rnd.random() < 0.5:
            send("SET_RATIO", rnd.choice((ONE, ONE // 2, 0x5555, -2 * ONE, 40 * ONE, rnd.randrange(-4 * ONE, 4 * ONE))))

    def update(self) -> None:
        act = self.instant()
        if self.axes > 1 and self.rnd.random() < 0.5:
            self.send("MULTI_UPDATE", self.rnd.choice((15, self.rnd.randrange(16))), act)
        else:
            self.send("UPDATE", None, act)

    def instant(self) -> int | None:
        """When a command is to act: at once, at the start of a cycle or a clock beside it, or anywhere."""
        rnd = self.rnd
        start = self.free // CYCLE * CYCLE + rnd.choice((1, 1, 1, 2, 3, 5, 10, 20)) * CYCLE
        return rnd.choice(
            (None, start, start, start + 1, start - 1, start + rnd.randrange(CYCLE), start + GRID * rnd.randrange(32))
        )

    def talk(self) -> None:
        """One thing that the host does next."""
        rnd, send = self.rnd, self.send
        name = rnd.choice(SAID)
        if name == "UPDATE":
            return self.update()
        if self.axes > 1 and rnd.random() < 0.3:
            self.axis = rnd.randrange(1, self.axes + 1)
            send(f"SET_{self.axis}", None, self.instant())
        if name == "stops":
            for each in rnd.sample(
                ("STOP", "SMOOTH_STOP", "SMOOTH_STOP", "SYNCH_PRFL", "UPDATE"), rnd.choice((1, 1, 2))
            ):
                send(each)
            return self.update() if rnd.random() < 0.8 else None
        if name == "move":
            send("SET_POS", self.destination())
            return self.update()
        if name == "velocities":
            self.set_velocities(rnd.choice((self.speed, self.speed // 2, 2 * self.speed, self.velocity())))
            return self.update() if rnd.random() < 0.7 else None
        if name == "breakpoint":
            return self.breakpoint()
        if name == "recover":
            for each in rnd.sample(("CLR_STATUS", "SYNCH_PRFL", "MTR_ON", "SET_AUTO_STOP_OFF"), rnd.choice((1, 2, 3))):
                send(each, None, self.instant() if rnd.random() < 0.3 else None)
            return self.update()
        return send(name, self.value(name), self.instant())

    def value(self, name: str) -> int | None:
        """What a command is given."""
        rnd = self.rnd
        values: dict[str, tuple[int, ...]] = {
            "SET_POS": (self.destination(),),
            "SET_ACC": (self.speed // 3, -self.speed // 3, self.speed, 0, rnd.randrange(1, 2 * ONE)),
            "SET_VEL": (self.velocity(), self.speed // 2, 0),
            "SET_START_VEL": (0, self.speed // 2, self.speed),
            "SET_ACTL_POS": (0, self.destination(), (1 << 30) - 1, -(1 << 30)),
            "SET_INTRPT_MASK": (0, 0xFF, rnd.randrange(256)),
            "RST_INTRPT": (0, 0, 0xFFFF, rnd.randrange(256)),
            "RST_STATUS": (0, rnd.randrange(256)),
            "SET_LMT_SENSE": (0, 0, rnd.randrange(256)),
            "SET_RATIO": (ONE, -ONE, 3 * ONE, 0, rnd.randrange(-4 * ONE, 4 * ONE)),
            "SET_STEP_RATIO": (0, 256, rnd.randrange(32768)),
            "SET_POS_ERR": (0, 2, 20, 32767),
            "SET_BRK_PNT": (self.comparison(),),
        }
        return rnd.choice(values[name]) if name in values else None

    def comparison(self) -> int:
        time = self.free // CYCLE + self.rnd.randrange(-1, 8)
        return self.rnd.choice((time, time, self.destination(), self.destination(), 0, -1)) % (1 << 32)

    def breakpoint(self) -> None:
        rnd, send = self.rnd, self.send
        send("SET_BRK_PNT", self.comparison())
        if rnd.random() < 0.7:
            send(
                rnd.choice(("STOP", "SMOOTH_STOP", "SET_POS", "SET_VEL")),
                self.destination() if rnd.random() < 0.5 else 0,
            )
        if rnd.random() < 0.2:
            send("SET_AUTO_UPDATE_OFF")
        send(rnd.choice(BREAKPOINTS), None, self.instant())

    # -------------------------------------------------------------------------------------------------------- inputs
    def mount(self) -> None:
        """Perhaps an encoder on the shaft of axis 1, or one that another machine turns."""
        rnd = self.rnd
        if self.encoder and rnd.random() < 0.4:
            counts, steps = rnd.choice(((1, 1), (4, 1), (10, 1), (3, 7), (4000, 12800)))
            ratio = {"counts": counts, "steps": steps, "lag": rnd.choice(("1 ps", "1 us"))}
            kind = rnd.choice(("encoder", "encoder", "quadrature"))
            self.dialogue.shaft = kind, ratio if kind == "encoder" else {}
            self.dialogue.kinds.add(kind)

    def handle(self, tick: int, late: int) -> None:
        """Something is done to the shaft."""
        rnd, add = self.rnd, self.dialogue.events.append
        if self.dialogue.shaft is not None and self.dialogue.shaft[0] == "quadrature":
            add(Event(tick, "run", rnd.choice((0, 1000, -3000, 100_000, 1_250_000, -1_300_000)), late))
        else:
            name = rnd.choice(("block", "slip", "push"))
            add(Event(tick, name, {"block": None, "slip": 5, "push": rnd.randrange(-9, 10)}[name], late))
            add(Event(tick + rnd.choice((1, 5, 40)) * CYCLE, "free", None))

    def happen(self, last: int) -> None:
        """One thing that happens on the pins, before a clock."""
        rnd = self.rnd
        axis = rnd.randrange(1, self.axes + 1)
        tick, late = self.moment(last)
        kind = rnd.choice(("limit",) * 8 + ("home",) * 4 + ("encoder" if self.encoder else "home",) * 6 + ("cut",))
        self.dialogue.kinds.add(kind)
        if kind == "limit":
            self.touch(f"{rnd.choice(('pos', 'neg'))}limit{axis}", tick, late, last)
        elif kind == "home":
            lasts = rnd.choice((1, 11, 12, 13, CYCLE, 3 * CYCLE + 5))
            self.dialogue.events += Event(tick, f"home{axis}", 0, late), Event(tick + lasts, f"home{axis}", 1, late)
        elif kind == "cut":
            lasts, what = rnd.choice((25, CYCLE, 3 * CYCLE + 5)), rnd.choice(("reset", "power"))
            self.dialogue.events += Event(tick, what, 0, late), Event(tick + lasts, what, 1)
        elif axis == 1 and self.dialogue.shaft is not None:
            self.handle(tick, late)
        else:
            self.turn(axis, tick, late)

    def touch(self, pin: str, tick: int, late: int, last: int) -> None:
        """A limit switch."""
        self.dialogue.events.append(Event(tick, pin, 1, late))
        if self.rnd.random() < 0.7:
            self.dialogue.events.append(Event(max(self.moment(last)[0], tick + 1), pin, 0))

    def moment(self, last: int) -> tuple[int, int]:
        """A clock, and picoseconds behind it: often at the start of a cycle, or just too late for a filter."""
        rnd = self.rnd
        tick = rnd.randrange(self.begun if rnd.random() < 0.9 else 1, last)
        start = tick // CYCLE * CYCLE
        beside = rnd.choice((0, 0, 0, 1, -1, -11, -12, -13, GRID * rnd.randrange(32)))
        if rnd.random() < 0.6:
            self.dialogue.kinds.add("tie")
            return max(start + beside, 1), 0
        return tick, rnd.choice((0, 0, 7000))

    def turn(self, axis: int, tick: int, late: int) -> None:
        """Turn an encoder: so many counts, so many clocks apart, with a glitch here and there."""
        rnd, add = self.rnd, self.dialogue.events.append
        way, apart = rnd.choice((1, -1)), rnd.choice((8192, 4096, 1000, 20, 19, 12, 11, rnd.randrange(5, 3000)))
        for _ in range(rnd.choice((1, 4, 10, 40))):
            before = self.quad[axis]
            self.quad[axis] = (before + way * rnd.choice((1,) * 30 + (2, -1))) % 4
            for pin, old, new in zip("ab", QUADRATURE[before], QUADRATURE[self.quad[axis]], strict=True):
                if old != new:
                    add(Event(tick, f"quad{pin}{axis}", new, late))
            tick += apart


GRID = 256  # clocks between edges of PULSE at 16 steps per cycle
BREAKPOINTS = (
    "SET_TIME_BRK", "SET_TIME_BRK", "SET_POS_BRK", "SET_POS_BRK", "SET_NEG_BRK", "SET_ACTL_POS_BRK", "SET_ACTL_NEG_BRK",
    "SET_MTN_CMPLT_BRK", "SET_EXT_BRK", "SET_EXT_BRK", "SET_BRK_OFF",
)  # fmt: skip
SAID = (
    *("UPDATE",) * 6, *("stops",) * 6, *("move",) * 8, *("velocities",) * 5, *("breakpoint",) * 5, *("recover",) * 3,
    "SET_PRFL_TRAP", "SET_PRFL_VEL", "SET_PRFL_VEL", "SET_PRFL_S_CRV", "SET_PRFL_GEAR", "SET_PRFL_GEAR", "SET_POS",
    "SET_ACC", "SET_ACC", "SET_VEL", "SET_START_VEL", "SET_RATIO", "SET_ACTL_POS", "SET_ACTL_POS", "SET_OUTPUT_HIGH",
    "SET_OUTPUT_STNDRD", "MTR_ON", "MTR_ON", "MTR_OFF", "MTR_OFF", "SET_AUTO_STOP_ON", "SET_STEP_RATIO", "SET_POS_ERR",
    "SET_INTRPT_MASK", "RST_INTRPT", "RST_INTRPT", "SET_I", "GET_INTRPT", "CLR_STATUS", "CLR_STATUS", "RST_STATUS",
    "SET_LMT_SENSE", "LMTS_ON", "LMTS_OFF", "GET_STATUS", "GET_MODE", "GET_TIME", "GET_TRGT_POS", "GET_TRGT_VEL",
    "GET_ACTL_POS", "GET_ACTL_POS_ERR", "GET_LMT_SWTCH", "GET_HOME", "SET_AUTO_UPDATE_ON", "SET_BRK_PNT", "RESET",
)  # fmt: skip


# ------------------------------------------------------------------------------------------------------------ playing
@dataclass
class Talked(Played):
    """What a dialogue left behind, and the words that the host read, with their instants."""

    read: list[tuple[int, int]]

    @property
    def outputs(self) -> tuple[str, ...]:  # type: ignore[override]
        return outputs(self.chip)

    def state(self) -> dict[str, Any]:
        """Every axis: registers, steps and velocities; every word read; findings, in whatever words.

        What the encoder inputs find is told when somebody asks for their counts: later, or not at all before a reset.
        """
        state: dict[str, Any] = {"read": self.read, "heard": self.heard}
        for number in range(1, self.chip.sheet.axes + 1):
            axis = self.chip.axes[number - 1]
            steps = axis.steps(0, self.bench.now_ps)
            state[f"registers {number}"] = self.chip.registers_of(number)
            state[f"position {number}"] = axis.position, axis.travel
            state |= {
                f"{key} {number}": found for key, found in told(self.chip.axis(number)).items() if key != "phases"
            }
            state[f"steps {number}"] = steps.times_ps.tolist(), steps.directions.tolist(), steps.positions.tolist()
            state[f"velocities {number}"] = [part.tolist() for part in axis.velocities(0, self.bench.now_ps)]
        found = [(found.time_ps, found.code) for found in self.chip.findings]
        state["findings"] = [pair for pair in found if not pair[1].startswith("encoder")]
        if self.chip._supply.starts == 1:
            state["encoder"] = sorted(code for _, code in found if code.startswith("encoder"))
        return state


def outputs(chip: Any) -> tuple[str, ...]:
    """The pins that are compared."""
    axes = range(1, chip.sheet.axes + 1)
    return (*(f"{pin}{n}" for n in axes for pin in ("pulse", "dir", "atrest")), "hostintrpt", "hostrdy")


class Wires:
    """A host on the wires of the port, which promises all strobes of a packet at once, and what drives other inputs."""

    def __init__(self, bench: slewline.Bench, chip: Any, clock: Clock) -> None:
        self.kernel, self.chip, self.clock = bench.kernel, chip, clock
        self.select, self.writing, self.reading, self.command = (
            Driver(chip.pin(name).net, "host") for name in ("hostslct", "hostwrite", "hostread", "hostcmd")
        )
        self.bus = Driver(chip.bus, "host")
        for driver, level in ((self.select, 1), (self.writing, 1), (self.reading, 1), (self.command, 0)):
            driver.drive(level)
        self.inputs: dict[str, Driver] = {}
        self.shaft: Any = None
        self.read: list[tuple[int, int]] = []

    def put(self, event: Event) -> None:
        """Let an event happen, now."""
        if event.what == "packet":
            self.packet(ORIGIN + event.tick, *event.value)
        elif event.what == "power":
            self.chip.power(bool(event.value))
        elif event.what in ("block", "free", "slip", "push", "run"):
            getattr(self.shaft, event.what)(*(() if event.value is None else (event.value,)))
        else:
            if event.what not in self.inputs:
                self.inputs[event.what] = Driver(self.chip.pin(event.what).net, "event")
            self.inputs[event.what].drive(event.value)

    def packet(self, rise: int, code: int, words: tuple[int, ...], reads: int) -> None:
        """Promise every strobe of a packet, the first of which ends at a clock."""
        ps = self.clock.ps
        written = [(rise, code), *self.bytes_written(rise + SLICE, words)]
        ready = rise + SLICE + len(words) * WORD
        read = [ready + n * WORD + k * LOW for n in range(reads) for k in (2, 4)]
        self.promise(self.writing, [(at - LOW, at) for at, _ in written], 1, (0, 1))
        self.promise(self.reading, [(at - LOW, at) for at in read], 1, (0, 1))
        self.promise(self.select, [(at - LOW, at + 1) for at in sorted([at for at, _ in written] + read)], 1, (0, 1))
        self.promise(self.command, [(rise - LOW, rise + 1)], 0, (1, 0))
        times = tuple(ps(at + side) for at, _ in written for side in (-LOW, 1))
        self.bus.wave(None, times, tuple(level for _, byte in written for level in ((0xFF, byte), None)))
        for at in read:
            self.kernel.call_at(ps(at), lambda: self.read.append((self.kernel.now, self.chip.bus.byte)))

    def bytes_written(self, ready: int, words: tuple[int, ...]) -> Iterator[tuple[int, int]]:
        for n, word in enumerate(words):
            yield ready + n * WORD + 2 * LOW, word >> 8
            yield ready + n * WORD + 4 * LOW, word & 0xFF

    def promise(self, driver: Driver, spans: list[tuple[int, int]], rest: int, levels: tuple[int, int]) -> None:
        """Spans of a level, from clock to clock."""
        if spans:
            driver.wave(rest, tuple(self.clock.ps(at) for span in spans for at in span), levels * len(spans))


def play(dialogue: Dialogue, *, stepwise: bool = False, shuffle: int | None = None, fit: Any = None) -> Talked:
    """Play a dialogue on a fresh bench; `fit` puts parts on it."""
    bench = slewline.Bench(shuffle=shuffle)
    chip: Any = bench.add(dialogue.part, "x", dialogue.crystal, stepwise=stepwise)
    clock = Clock(dialogue.crystal)
    wires = Wires(bench, chip, clock)
    if dialogue.shaft is not None:
        kind, options = dialogue.shaft
        wires.shaft = bench.part(kind, "shaft", chip, **options)
    bench.record(*(f"x.{pin}" for pin in outputs(chip)))
    if fit is not None:
        fit(bench)
    for event in dialogue.events:
        early = LOW + 1 if event.what == "packet" else 0
        bench.at(clock.ps(ORIGIN + event.tick - early) + event.late_ps, lambda event=event: wires.put(event))  # type: ignore[misc]
    talked = Talked(bench, chip, wires.read)
    talked.heard = heard(chip)
    bench.run_to(clock.ps(ORIGIN + dialogue.cycles * CYCLE))
    return talked
