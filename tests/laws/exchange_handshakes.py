"""Random commands to a CY500, CY512 or CY525 over its two-line handshake, disturbed as they go."""

from __future__ import annotations

from random import Random
from typing import Any

from .exchanges import MS, US, Dialogue, Disturber, World, edges_of, played

PARTS = ("cy500", "cy512", "cy525", "cy525", "cy525")
LINES = ("io_request", "instrobe", "ready")
DB = tuple(f"x.db{n}" for n in range(8))
MORE = ("ascii_binary", "io_select", "motion_complete", "programmable_output")
SAID = {
    "cy500": ("R 100", "N 5", "S 9", "F 200", "+", "-", "G", "B", "C", "H", "P 12", "J", "E", "Q", "A"),
    "cy512": ("R 100", "N 5", "S 9", "F 200", "+", "-", "G", "B", "C", "H", "P 12", "V 1", "E", "Q", "A 7", "X", "0"),
    "cy525": (
        "R 100", "N 5", "S 9", "F 20", "+", "-", "G", "B", "C", "H", "P 12", "V 1", "E", "Q", "A 7", "X", "A$", "0",
    ),
}  # fmt: skip
ODD = (
    "R\n", "\n", "r 5\r", "N 12345678901234567890\r", "N  5\r", "N 5 6\r", "?\r", "N$\r", "\r", "N 7\n\r", "R 999\r",
    "N 1",
)  # fmt: skip
BINARY = (
    b"R\x01\x20", b"N\x02\x05\x00", b"G\x00", b"Q", b"S\x01\x09", b"N\x00", b"N\x05\x01\x02\x03\x04\x05",
    b"?\x02\x01\x02",
)  # fmt: skip


class Handshaken(World):
    """A chip and its host, which speak by handshakes."""

    host: Any

    def left(self) -> dict[str, Any]:
        """What is left; that two outputs disagree is heard when somebody looks, which is more often in the twin."""
        found = super().left()
        for key in ("noted", "findings"):
            found[key] = [note for note in found[key] if note[1] != "conflict"]
        return found

    def drop(self) -> None:
        self.host.drop()

    def halt(self) -> None:
        """The program of the host is started again."""
        self.host.clear()


class Strobed(Handshaken):
    """A chip, or two that share a bus, and their host."""

    wires = (*(f"x.{name}" for name in LINES), *DB)
    chip: Any

    def furnish(self) -> None:
        options, bench = self.dialogue.options, self.bench
        self.chip = bench.add(self.dialogue.part, "x", options["crystal"], straps={"ascii_binary": options["text"]})
        self.chips = [self.chip]
        if options["other"]:
            self.chips.append(bench.add(options["other"], "y"))
        self.host = bench.host(*self.chips, delay=options["delay"])
        self.send(self.dialogue.sent)
        if options["other"]:
            self.host.to("y").send("R 77\r")
            self.send("N 9\r")
            self.host.to("y").send("N 8\rR 6\r")

    def __init__(self, dialogue: Dialogue, shuffle: int | None) -> None:
        super().__init__(dialogue, shuffle)
        names = [name for name in MORE if name in self.chip.pins]
        self.pins |= {f"x.{name}": self.bench.pin(f"x.{name}") for name in (*names, "reset")}

    # ------------------------------------------------------------------------------------------------------------ acts
    def look(self) -> None:
        """Look at what has come, unless it is in the very instant of an edge."""
        if self.bench.kernel.running:
            self.note("look")
        else:
            states = [(chip.unfinished, chip.waiting, chip.idle, chip.program) for chip in self.chips]
            self.note("look", self.host.sent, self.host.idle, states)

    def send(self, data: str) -> None:
        """Send text, or what it stands for in binary."""
        self.host.to("x").send(data.encode("latin-1"))

    def ask(self, timeout: int) -> None:
        """Read the registers, and give up early, perhaps."""
        self.note("asked", self.host.to("x").ask("V 3", timeout=timeout))

    def state(self) -> dict[str, Any]:
        return {
            "registers": [chip.registers for chip in self.chips],
            "programs": [chip.program for chip in self.chips],
            "steps": self.chip.steps().times_ps.tolist(),
            "unfinished": [chip.unfinished for chip in self.chips],
            "waiting": [chip.waiting for chip in self.chips],
            "sent": (self.host.sent, bytes(self.host.received), self.host.idle, len(self.host.queue)),
        }


class Disturbed(Disturber):
    """What happens to it."""

    selects: tuple[str, ...] = ("x.io_select",)

    def more(self, what: str, at: int) -> None:
        rnd = self.rnd
        kind = rnd.choice(
            ("ask", "drop", "halt", "reset", "power", "bus", "function", "send", "send", "mode", "select")
        )
        if kind == "ask":
            self.act(at, "ask", rnd.choice((1000, 90 * US, 900 * US, 20 * MS)), within=False)
        elif kind in ("drop", "halt"):
            self.act(at, kind, within=False)
        elif kind == "reset":
            self.act(at, "pulse", "x.reset", 0, rnd.choice((US, 20 * US, 200 * US)), within=False)
        elif kind == "power":
            self.act(at, "power", "x", False, within=False)
            self.act(at + self.width(), "power", "x", True, within=False)
        elif kind == "bus":
            self.hold(at, rnd.choice(DB))
        elif kind == "function":
            self.act(at, "function", rnd.choice(("x.io_request", "x.ready")), rnd.randrange(2), MS, within=False)
        elif kind == "send":
            self.act(at, "send", rnd.choice(("N 5\r", "R 7\rN 8\r", "+\r")), within=False)
        elif kind == "mode":
            self.hold(at, "x.ascii_binary")
        else:
            self.hold(at, rnd.choice(("x.motion_complete", *self.selects)))


def text(rnd: Random, part: str) -> str:
    """Return some commands, most of them as they should be."""
    said = [
        f"{rnd.choice(SAID[part])}\r" if rnd.random() < 0.9 else rnd.choice(ODD)
        for _ in range(rnd.choice((1, 2, 4, 7)))
    ]
    return "".join(each.removesuffix("\r") if each in ("Q\r", "A$\r") else each for each in said)


def base(seed: int) -> Dialogue:
    """A dialogue that nothing disturbs."""
    rnd = Random(f"exchange handshakes {seed}")
    part, ascii = rnd.choice(PARTS), rnd.random() < 0.85
    said = text(rnd, part) if ascii else b"".join(rnd.choice(BINARY) for _ in range(5)).decode("latin-1")
    options = {
        "crystal": rnd.choice(
            ("11 MHz", "11 MHz", "6 MHz", "3.579545 MHz") if part == "cy525" else ("6 MHz", "3.579545 MHz")
        ),
        "text": int(ascii),
        "other": rnd.choice((None, None, None, "cy525")),
        "delay": rnd.choice((0, 0, 0, 0, 100 * US, 1000)),
    }
    return Dialogue(seed, part, said, options, 20 * MS)


def dialogues(seed: int, number: int) -> list[Dialogue]:
    """So many dialogues that say the same, disturbed each in another way."""
    return disturbed(base(seed), number, Random(f"exchange handshakes {seed} disturbed"))


def disturbed(quiet: Dialogue, number: int, rnd: Random, disturber: type[Disturbed] = Disturbed) -> list[Dialogue]:
    """Make so many of one that nothing disturbs."""
    world = played(Strobed, quiet, "recorded", quiet.seed)
    marks = edges_of(world, tuple(f"x.{name}" for name in LINES))[:400]
    if len(marks) < 3:
        marks = [MS, 2 * MS, 3 * MS]
    made = []
    for each in range(number):
        first = rnd.randrange(len(marks) - 2)
        near = marks[first : first + rnd.choice((20, 60, 400))]
        maker = disturber(rnd, near, Strobed.wires, tuple(f"x.{name}" for name in LINES))
        maker.selects = () if quiet.part == "cy500" else maker.selects
        for _ in range(rnd.choice((0, 1, 1, 2, 3, 6))):
            maker.disturb()
        acts = maker.made()
        until = max([near[-1], *(act.at for act in acts)]) + rnd.choice((US, MS, 20 * MS))
        made.append(Dialogue(quiet.seed * 100 + each, quiet.part, quiet.sent, quiet.options, until, acts))
    return made
