"""Random dialogues with a CY545 that reads and writes a memory, disturbed in its bus cycles."""

from __future__ import annotations

from random import Random
from typing import Any

from .exchanges import MS, NS, US, Dialogue, Disturber, World, edges_of, played

CONTROLS = ("xmem_sel", "ale", "rd", "wr")
MEMORIES = ("ram", "ram", "ram", "eeprom", "eprom")
MORE = ("ram", "eprom", "hp_display", "thumbwheels")
DB = tuple(f"x.db{n}" for n in range(8))


class Remembering(World):
    """A chip with a memory, and a host on its parallel side."""

    wires = (
        *(f"x.{name}" for name in (*CONTROLS, "sw_sel", "busy", "io_request", "usrb0", "usrb7")), "memory.rd",
        "memory.db",
    )  # fmt: skip
    chip: Any
    host: Any
    memory: Any

    def furnish(self) -> None:
        options, bench = self.dialogue.options, self.bench
        self.chip = bench.add(self.dialogue.part, "x", options["crystal"], **options["of the chip"])
        self.memory = bench.part(options["memory"], name="memory", to=self.chip, **options["of the memory"])
        if options["display"]:
            bench.part("hp_display", name="display", to=self.chip)
        self.host = bench.host(self.chip)
        self.host.send(self.dialogue.sent)

    def __init__(self, dialogue: Dialogue, shuffle: int | None) -> None:
        super().__init__(dialogue, shuffle)
        self.pins |= {name: self.bench.pin(name) for name in (*DB, "x.reset")}

    def load(self, image: bytes, at: int) -> None:
        """Put something into the memory."""
        self.memory.load(image, at)

    def send(self, text: str) -> None:
        self.host.send(text)

    def state(self) -> dict[str, Any]:
        return {
            "registers": self.chip.registers,
            "content": self.memory.content,
            "received": bytes(self.host.received),
            "steps": self.chip.steps().times_ps.tolist(),
            "latches": [(part._bus.high, part._bus.low) for part in self.bench.parts.values() if hasattr(part, "_bus")],
            "writing": getattr(self.memory, "writing", None),
        }


class Remembered(Disturber):
    """What happens to it."""

    def more(self, what: str, at: int) -> None:
        rnd = self.rnd
        kind = rnd.choice(("load", "load", "load", "part", "reset", "power", "bus", "function", "send", "usrb0"))
        if kind == "load":
            image = rnd.choice((rnd.randbytes(2), b"0\r" * 30, b"N 3\r"))
            self.act(at, "load", image, rnd.choice((0, 1, 5, rnd.randrange(30), 300)))
        elif kind == "part":
            self.joined += 1
            self.act(at, "add", rnd.choice(MORE), self.joined, within=False)
        elif kind == "reset":
            self.act(at, "pulse", "x.reset", 1, rnd.choice((US, 2 * US, 10 * US, 200 * US)))
        elif kind == "power":
            self.act(at, "power", "x", False, within=False)
            self.act(at + self.width(), "power", "x", True, within=False)
        elif kind == "bus":
            self.hold(at, rnd.choice(DB))
        elif kind == "function":
            self.act(at, "function", rnd.choice(self.lines), rnd.randrange(2), MS, within=False)
        elif kind == "send":
            self.act(at, "send", rnd.choice(("N 5\r", "? P\r", "Y 7\r", "0\r", "Y 0\rX\r")), within=False)
        else:
            self.hold(at, "x.usrb0")


def lines_of(rnd: Random) -> list[str]:
    """A program."""
    lines = []
    for _ in range(rnd.choice((1, 2, 3, 5))):
        lines.append(
            rnd.choice(
                ("N 2", "+", "D 1", "B 16", "B 0", "B 8", "B 24", "? N", '"a"', "A 77", "N #", "G", "[1,1,2", "I")
            )
        )
    ends = (["L 2,0"], ["Z 3,0"], ["T 0,0"], ["T 16,0"], ["J 0"], ["T 8,0"], ["T 24,0"], [], ["W 0"])
    return [*lines, *rnd.choice(ends), "0"]


def base(seed: int) -> Dialogue:
    """A dialogue that nothing disturbs."""
    rnd = Random(f"exchange cy545 {seed}")
    memory, program = rnd.choice(MEMORIES), "".join(f"{line}\r" for line in lines_of(rnd))
    at = rnd.choice((0, 0, 0, 250, 0xFFFE))
    given, image = {}, (b"\xff" * at + program.encode())[:0xFFFF] if at < 300 else program.encode()
    enters = memory != "eprom" and rnd.random() < 0.6
    if not enters:
        given["image"] = image + bytes([rnd.randrange(256)])
    if memory == "eeprom":
        given["write_time"] = rnd.choice((MS, 100 * US, 333 * US + 7, 21 * MS))
    if at < 300 and rnd.random() < 0.3:
        given["size"] = 2048
    page = f"Y {at}\r" if enters or at < 300 else "Y 0\r"
    told = f"{page}E\r{program}Q" if enters else ""
    mode = rnd.choice(("", "", "O 81H\r", "O 85H\r"))
    options = {
        "crystal": rnd.choice(("12 MHz", "12 MHz", "11 MHz", "3.579545 MHz")),
        "of the chip": {} if rnd.random() < 0.7 else {"inferred": {"fetch": rnd.choice((2, 10, 25, 240, 1001))}},
        "memory": memory,
        "of the memory": given,
        "display": rnd.random() < 0.2,
    }
    return Dialogue(seed, rnd.choice(("cy545", "cy545b")), f"{mode}{told}{page}X\r", options, 30 * MS)


def dialogues(seed: int, number: int) -> list[Dialogue]:
    """So many dialogues that say the same, disturbed each in another way."""
    quiet = base(seed)
    rnd = Random(f"exchange cy545 {seed} disturbed")
    world = played(Remembering, quiet, "recorded", seed)
    marks = edges_of(world, (*(f"x.{name}" for name in CONTROLS), "memory.db"))[:1500]
    if len(marks) < 3:
        marks = [MS, 2 * MS, 3 * MS]
    made = []
    for each in range(number):
        options = {**quiet.options, "of the memory": dict(quiet.options["of the memory"])}
        if options["memory"] == "eeprom" and rnd.random() < 0.5:
            options["of the memory"]["write_time"] = write_time(world, rnd)
        first = rnd.randrange(len(marks) - 2)
        near = marks[first : first + rnd.choice((20, 200, 1500))]
        maker = Remembered(
            rnd, near, Remembering.wires, (*(f"x.{name}" for name in (*CONTROLS, "sw_sel")), "memory.rd")
        )
        for _ in range(rnd.choice((1, 1, 2, 3, 6))):
            maker.disturb()
        acts = maker.made()
        until = min(max(near[-1], acts[-1].at) + rnd.choice((US, MS, 3 * MS)), 60 * MS)
        made.append(Dialogue(seed * 100 + each, quiet.part, quiet.sent, options, until, acts))
    return made


def write_time(world: World, rnd: Random) -> int:
    """How long a write takes, if it ends at an edge of RD, or beside it."""
    rises = [time for time, level in world.recorded("x.wr", 0) if level == 1]
    if not rises:
        return MS
    begin = rises[0]
    polls = [time for time in edges_of(world, ("x.rd", "x.xmem_sel", "x.ale")) if time > begin][:60]
    return max(rnd.choice(polls) - begin + rnd.choice((0, 0, 1, -1, 500 * NS)), 1000) if polls else MS
