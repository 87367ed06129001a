"""Random packets to an MC1451A or a sister of it, disturbed in the operations on its host port."""

from __future__ import annotations

from random import Random
from typing import Any

from .exchanges import NS, US, Dialogue, Disturber, World, edges_of, played

PARTS = ("mc1151a", "mc1151a-e", "mc1251a", "mc1451a", "mc1451a-e")
CONTROLS = ("hostslct", "hostcmd", "hostwrite", "hostread")
DATA = tuple(f"x.hostdata{n}" for n in range(8))
SAID = (
    "SET_POS 1000", "SET_POS -9", "SET_VEL 65536", "SET_ACC 1024", "UPDATE", "GET_VRSN", "GET_STATUS", "GET_ACTL_POS",
    "GET_POS", "SET_PRFL_VEL", "SET_1", "GET_TIME", "STOP", "GET_HOME", "GET_MODE",
)  # fmt: skip
RAW = (b"\x80\x00\x05", b"\x6c", b"\x10\x00\x01\x00", b"\x10\x00", b"\x13\x01\x02\x03\x04\x05\x06", b"\x1a\x7f")
READY = 3_280 * US  # when HostRdy rises for the first time, at 25 MHz


class Spoken(World):
    """A chipset, or two that share a data bus, and their host."""

    wires = (*(f"x.{name}" for name in (*CONTROLS, "hostrdy", "hostintrpt")), *DATA)
    chip: Any
    host: Any

    def furnish(self) -> None:
        options, bench = self.dialogue.options, self.bench
        self.chip = bench.add(self.dialogue.part, "x", options["crystal"])
        self.chips = [self.chip]
        if options["other"]:
            self.chips.append(bench.add(options["other"], "y"))
        if options["first"] == "sent":
            self.host = bench.host(*self.chips, delay=options["delay"])
        else:
            self.host = bench.host(*reversed(self.chips), delay=options["delay"])
        self.host.to("x").send(self.dialogue.sent)
        if options["other"]:
            self.host.to("y").send("GET_VRSN\nSET_POS 7")
            self.host.to("x").send("GET_VRSN")

    def __init__(self, dialogue: Dialogue, shuffle: int | None) -> None:
        super().__init__(dialogue, shuffle)
        self.pins["x.reset"] = self.bench.pin("x.reset")

    # ------------------------------------------------------------------------------------------------------------ acts
    def send(self, data: str | bytes) -> None:
        self.host.to("x").send(data)

    def ask(self, command: str, timeout: int) -> None:
        """Ask, and give up early, perhaps."""
        self.note("asked", self.host.to("x").query(command, timeout=timeout))

    def packet(self, reads: int, code: int, *words: int) -> None:
        """A packet, whether or not it is as it should be."""
        self.note("packet", self.host.to("x").packet(code, *words, reads=reads, checksum=False))

    def word(self, timeout: int) -> None:
        """Read a word, whatever the chipset has."""
        self.note("word", self.host.to("x").read_word(timeout=timeout))

    def byte(self, timeout: int) -> None:
        """Read half of a word."""
        self.note("byte", self.host.to("x").read_byte(timeout=timeout))

    def write(self, number: int, timeout: int) -> None:
        """Write half of a word, or all of it."""
        if number < 256:
            self.host.to("x").write_byte(number, timeout=timeout)
        else:
            self.host.to("x").write_word(number, timeout=timeout)

    def odd(self, low: int, gap: int) -> None:
        """A strobe that is not as it should be."""
        self.note("odd", self.host.to("x").read_word(low=low, gap=gap, ready=False))

    def halt(self) -> None:
        """The host is broken off."""
        self.host.queue.requests.clear()
        self.host.queue.halt()

    def state(self) -> dict[str, Any]:
        return {
            "received": list(self.host.received),
            "registers": [chip.registers_of(n) for chip in self.chips for n in range(1, chip.sheet.axes + 1)],
            "travel": [axis.travel for chip in self.chips for axis in chip.axes],
            "steps": [axis.times(0, self.bench.now_ps).tolist() for axis in self.chip.axes],
            "port": [repr(vars_of(chip._port)) for chip in self.chips],
            "idle": (self.host.idle, len(self.host.queue)),
        }


def vars_of(port: Any) -> dict[str, Any]:
    """What a port knows of the packet in progress."""
    names = ("ready", "bytes", "wanted", "words", "code", "silent", "answer", "half", "strobed_at", "legal")
    return {name: getattr(port, name) for name in names}


class Disturbed(Disturber):
    """What happens to it."""

    def more(self, what: str, at: int) -> None:
        rnd = self.rnd
        kind = rnd.choice(("ask", "ask", "word", "byte", "write", "odd", "halt", "reset", "power", "data", "function",
                           "send", "raw"))  # fmt: skip
        soon = rnd.choice((100 * NS, 1000, rnd.randrange(1000, 500 * NS), 90 * US, 200 * US, 300 * US, 10_000 * US))
        if kind == "ask":
            self.act(at, "ask", rnd.choice(("GET_VRSN", "GET_POS", "GET_STATUS")), soon, within=False)
        elif kind in ("word", "byte"):
            self.act(at, kind, soon, within=False)
        elif kind == "write":
            self.act(at, "write", rnd.randrange(512), soon, within=False)
        elif kind == "odd":
            self.act(at, "odd", rnd.choice((40, 50, 80, 200)) * NS, rnd.choice((40, 60, 80)) * NS, within=False)
        elif kind == "halt":
            self.act(at, "halt", within=False)
        elif kind == "reset":
            beside = at - at % 1000 + rnd.choice((1, 999))  # which of two edges at a strobe is heard first is not given
            self.act(beside, "pulse", "x.reset", 0, rnd.choice((1000, US, 2 * US)))
        elif kind == "power":
            self.act(at, "power", rnd.choice("xxy"), False, within=False)
            self.act(at + self.width(), "power", "x", True, within=False)
        elif kind == "data":
            self.hold(at, rnd.choice(DATA))
        elif kind == "function":
            self.act(at, "function", rnd.choice(self.lines), rnd.randrange(2), 200 * US, within=False)
        elif kind == "send":
            self.act(at, "send", rnd.choice(SAID), within=False)
        else:
            self.act(at, "send", rnd.choice(RAW), within=False)


def base(seed: int) -> Dialogue:
    """A dialogue that nothing disturbs."""
    rnd = Random(f"exchange mc {seed}")
    sent = "\n".join(rnd.choice(SAID) for _ in range(rnd.choice((1, 2, 3, 4))))
    options = {
        "crystal": rnd.choice((25_000_000,) * 4 + (20_000_000, 6_700_001)),
        "other": rnd.choice(("", "", "", "mc1151a")),
        "delay": rnd.choice((0, 0, 0, 7 * US, 1000, 81_920 * NS)),
        "first": rnd.choice(("sent", "sent", "last")),
    }
    return Dialogue(seed, rnd.choice(PARTS), sent, options, READY + 2_000 * US)


def dialogues(seed: int, number: int) -> list[Dialogue]:
    """So many dialogues that say the same, disturbed each in another way."""
    quiet = base(seed)
    rnd = Random(f"exchange mc {seed} disturbed")
    quiet.until_ps = int((READY + 2_500 * US) * (25_000_000 / quiet.options["crystal"]))
    world = played(Spoken, quiet, "recorded", seed)
    names = tuple(f"x.{name}" for name in (*CONTROLS, "hostrdy"))
    marks = edges_of(world, (*names, *DATA), 1_000_000)
    made = []
    for each in range(number):
        first = rnd.randrange(len(marks) - 2)
        near = marks[first : first + rnd.choice((20, 60, 400))]
        maker = Disturbed(rnd, near, Spoken.wires, names)
        for _ in range(rnd.choice((1, 1, 2, 3, 6))):
            maker.disturb()
        acts = maker.made()
        until = max(near[-1], acts[-1].at) + rnd.choice((US, 100 * US, 1000 * US))
        made.append(Dialogue(seed * 100 + each, quiet.part, quiet.sent, quiet.options, until, acts))
    return made
