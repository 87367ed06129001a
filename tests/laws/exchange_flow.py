"""Random commands to a CY545 over its parallel bus, with empty handshakes and answers, disturbed as they go."""

from __future__ import annotations

from random import Random
from typing import Any

from .exchange_handshakes import DB, Handshaken
from .exchanges import MS, US, Dialogue, Disturber, edges_of, played

LINES = ("io_request", "busy")
MORE = ("usrb0", "usrb6", "jog", "cw_limit", "ccw")
SAID = (
    "N 100", "R 50", "S 9", "F 200", "+", "-", "G", "B 8", "B 0", "D 1", "? P", "? R", "? B", "N #", "/B 2",
    "O 80H", "O 81H", "O 82H", "Y 0", "E", "X", "0", "I", "P 4",
)  # fmt: skip
ODD = ('"a"\r', "\n", "r 5\r", "N 99999999999999999999\r", "N  5\r", "?\r", "N 7\n\r", "\xff", "Q", "\r", "N 1")
BINARY = (b"N\x03\x05\x00\x00", b"R\x01\x20", b"?\x01P", b"+\x00", b"S\x01\x09", b"O\x01\x80", b"N\x00", b"G\x00")


class Offered(Handshaken):
    """A chip, perhaps with a memory, and its host."""

    wires = (*(f"x.{name}" for name in LINES), "x.usrb6", *DB)
    chip: Any

    def furnish(self) -> None:
        options, bench = self.dialogue.options, self.bench
        self.chip = bench.add(self.dialogue.part, "x", options["crystal"])
        if options["memory"]:
            bench.part("ram", name="memory", to=self.chip)
        self.host = bench.host(self.chip, delay=options["delay"])
        self.host.prefix(options["prefix"])
        self.send(self.dialogue.sent)
        self.send("N 9\rR 77\r")

    def __init__(self, dialogue: Dialogue, shuffle: int | None) -> None:
        super().__init__(dialogue, shuffle)
        self.pins |= {f"x.{name}": self.bench.pin(f"x.{name}") for name in (*MORE, "reset", "rxd")}

    # ------------------------------------------------------------------------------------------------------------ acts
    def look(self) -> None:
        """Look at what has come, unless it is in the very instant of an edge."""
        if self.bench.kernel.running:
            self.note("look")
        else:
            chip = self.chip
            state = chip.unfinished, chip.waiting, chip.idle, chip.awaits_host
            self.note("look", self.host.sent, self.host.idle, bytes(self.host.received), state)

    def send(self, data: str) -> None:
        self.host.send(data.encode("latin-1"))

    def ask(self, timeout: int) -> None:
        """Read a register, and give up early, perhaps."""
        self.note("asked", self.host.ask("? R", timeout=timeout))

    def heed(self, on: bool | None) -> None:
        self.host.heed(on)

    def state(self) -> dict[str, Any]:
        chip, host = self.chip, self.host
        return {
            "registers": chip.registers,
            "steps": chip.steps().times_ps.tolist(),
            "doing": (chip.unfinished, chip.waiting, chip.idle, chip.awaits_host),
            "host": (host.sent, bytes(host.received), host.idle, len(host.queue)),
        }


class Disturbed(Disturber):
    """What happens to it."""

    def more(self, what: str, at: int) -> None:
        rnd = self.rnd
        kind = rnd.choice(
            ("ask", "drop", "halt", "reset", "power", "bus", "function", "send", "send", "pin", "pin", "heed", "serial")
        )
        if kind == "ask":
            self.act(at, "ask", rnd.choice((1000, 90 * US, 900 * US, 20 * MS)), within=False)
        elif kind in ("drop", "halt"):
            self.act(at, kind, within=False)
        elif kind == "reset":
            self.act(at, "pulse", "x.reset", 1, rnd.choice((US, 20 * US, 200 * US)), within=False)
        elif kind == "power":
            self.act(at, "power", "x", False, within=False)
            self.act(at + self.width(), "power", "x", True, within=False)
        elif kind == "bus":
            self.hold(at, rnd.choice(DB))
        elif kind == "function":
            self.act(at, "function", rnd.choice(self.lines), rnd.randrange(2), MS, within=False)
        elif kind == "send":
            self.act(at, "send", rnd.choice(("N 5\r", "R 7\rN 8\r", "+\r", "? P\r")), within=False)
        elif kind == "heed":
            self.act(at, "heed", rnd.choice((True, False, None)), within=False)
        elif kind == "serial":
            self.hold(at, "x.rxd")
        else:
            self.hold(at, rnd.choice(("x.usrb6", "x.jog", "x.cw_limit", "x.ccw", "x.usrb0")))


def text(rnd: Random) -> str:
    """Return some commands, most of them as they should be."""
    number = rnd.choice((1, 2, 4, 7))
    return "".join(f"{rnd.choice(SAID)}\r" if rnd.random() < 0.9 else rnd.choice(ODD) for _ in range(number))


def base(seed: int) -> Dialogue:
    """A dialogue that nothing disturbs."""
    rnd = Random(f"exchange flow {seed}")
    ascii = rnd.random() < 0.85
    said = "O 81H\r" * (rnd.random() < 0.5) + text(rnd)
    if not ascii:
        said = "O 1\r" + b"".join(rnd.choice(BINARY) for _ in range(5)).decode("latin-1")
    options = {
        "crystal": rnd.choice(("12 MHz", "12 MHz", "11 MHz", "3.579545 MHz")),
        "memory": rnd.random() < 0.3,
        "prefix": rnd.random() < 0.8,
        "delay": rnd.choice((0, 0, 0, 0, 100 * US)),
    }
    return Dialogue(seed, rnd.choice(("cy545", "cy545b")), said, options, 20 * MS)


def dialogues(seed: int, number: int) -> list[Dialogue]:
    """So many dialogues that say the same, disturbed each in another way."""
    quiet = base(seed)
    rnd = Random(f"exchange flow {seed} disturbed")
    world = played(Offered, quiet, "recorded", seed)
    marks = edges_of(world, tuple(f"x.{name}" for name in LINES))[:400]
    if len(marks) < 3:
        marks = [MS, 2 * MS, 3 * MS]
    made = []
    for each in range(number):
        first = rnd.randrange(len(marks) - 2)
        near = marks[first : first + rnd.choice((20, 60, 400))]
        maker = Disturbed(rnd, near, Offered.wires, tuple(f"x.{name}" for name in LINES))
        for _ in range(rnd.choice((0, 1, 1, 2, 3, 6))):
            maker.disturb()
        acts = maker.made()
        until = max([near[-1], *(act.at for act in acts)]) + rnd.choice((US, MS, 20 * MS))
        made.append(Dialogue(seed * 100 + each, quiet.part, quiet.sent, quiet.options, until, acts))
    return made
