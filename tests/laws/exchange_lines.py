"""Random lines to GS-C modules, alone or several on a line, and to the serial side of a CY545, disturbed as they go."""

from __future__ import annotations

from random import Random
from typing import Any

from slewline.core.wires.receiver import Receiver
from slewline.parts.hosts.ends.adaptive_uart import AdaptiveUart

from .exchanges import MS, NS, US, Dialogue, Disturber, World, edges_of

BAUDS = {300: (1, 1, 0), 9600: (0, 0, 0)}  # by the straps br0 to br2: some of the table, others are tested elsewhere
SAID = ("F", "V1", "V2", "S10", "T100", "R20", "+30", "-5", "Po", "Px", "E", "Q", "H+", "A1", "C1", "Z", "K", "X9", "")
ASKED = ("? P", "? R", "? N", "N 20", "R 50", "+", "G", "B 1", "? Q", "O 81H", "O 0A0H", "O 0A0H")
ENDS = ("\r",) * 12 + ("\r\n", "\n", "")
CUT = "ask", "change_line", "drop", "heed", "parallel", "power", "space"  # what may cut off a line


class Told(World):
    """Modules, or a CY545, and their host on a serial line."""

    host: Any

    def __init__(self, dialogue: Dialogue, shuffle: int | None) -> None:
        self.wires = ("x.rxd", "x.txd", "x.usrb3") if dialogue.part.startswith("cy545") else ("x.rxd", "x.txd", "x.rdy")
        super().__init__(dialogue, shuffle)

    def furnish(self) -> None:
        options, bench = self.dialogue.options, self.bench
        if self.dialogue.part.startswith("cy545"):
            self.chips = [bench.add(self.dialogue.part, "x", fixed_baud=options["fixed"])]
            self.host = bench.host(*self.chips, over="serial", baud=options["baud"])
        else:
            straps = dict(zip(("br0", "br1", "br2"), BAUDS[options["strapped"]], strict=True))
            straps["chs"] = int(options["checked"])
            names = "xyz"[: len(options["addresses"])]
            self.chips = [
                bench.add(self.dialogue.part, name, straps=straps, lenient=options["lenient"], address=address)
                for name, address in zip(names, options["addresses"], strict=True)
            ]
            self.host = bench.host(*self.chips, baud=options["baud"])
        self.heard: list[Any] = []
        self.send(self.dialogue.sent)

    def hear_of(self, what: str) -> None:
        """Note what a listener is told, and what it sees on the line: RDY may fall in that very instant, or rise."""
        self.noted.append((self.bench.now_ps, what))
        if what != "conflict":
            self.glances.append((self.bench.now_ps, what, self.levels()[:2]))

    def left(self) -> dict[str, Any]:
        """What is left; that two disagree is heard when somebody looks, as a listener does at every instant.

        So does a host of a CY545 that cuts off a line.
        """
        found = super().left()
        if any(
            act.what == "listen" or (act.what in CUT and "fixed" in self.dialogue.options) for act in self.dialogue.acts
        ):
            for key in ("noted", "findings"):
                found[key] = [note for note in found[key] if note[1] != "conflict"]
        return found

    # ------------------------------------------------------------------------------------------------------------ acts
    def look(self) -> None:
        """At what has come so far; whether somebody is at work, a task of the same round may change."""
        self.note("look", bytes(self.host.received), self.host.faulty, [chip.unfinished for chip in self.chips])

    def send(self, text: str) -> None:
        self.host.send(text)

    def write(self, text: str, fault: str) -> None:
        self.host.write(text, fault)

    def ask(self, command: str, timeout: int) -> None:
        self.note("asked", self.host.ask(command, timeout))

    def got(self, data: str, timeout: int) -> None:
        self.bench.run_until(self.host.got(data), timeout)
        self.note("got")

    def space(self, on: bool) -> None:
        self.host.space(on)

    def drop(self) -> None:
        self.host.drop()

    def heed(self, on: bool | None) -> None:
        """Obey CTS or not; only the host of a CY545 can."""
        if hasattr(self.host, "heed"):
            self.host.heed(on)

    def parallel(self, byte: int) -> None:
        """Another host begins a command over the bus of a CY545, while that of the line speaks."""
        if self.dialogue.part.startswith("cy545"):
            for bit in range(8):
                self.bench.pin(f"x.db{bit}").drive(byte >> bit & 1)
            self.bench.pin("x.io_request").pulse(0, 500 * US)

    def hook(self) -> None:
        """Somebody hears every character from now on."""
        self.host.on_character.add(lambda character: self.heard.append((self.bench.now_ps, character)))

    def change_line(self, baud: int, bits: int, parity: str, stop: int) -> None:
        self.host.change_line(baud, bits, parity, stop)

    def received(self, number: int, timeout: int) -> None:
        """A function that looks at what the kernel knows nothing of."""
        self.bench.run_until(lambda: len(self.host.received) >= number, timeout)
        self.note("received")

    def state(self) -> dict[str, Any]:
        return {
            "received": bytes(self.host.received),
            "answers": list(getattr(self.host, "answers", ())),
            "faulty": self.host.faulty,
            "heard": self.heard,
            "unfinished": [chip.unfinished for chip in self.chips],
            "positions": [chip.position for chip in self.chips],
            "idle": [self.host.idle, *(chip.idle for chip in self.chips)],
        }


class Disturbed(Disturber):
    """What happens to them."""

    def more(self, what: str, at: int) -> None:
        rnd = self.rnd
        kinds = "ask", "got", "space", "drop", "hook", "line", "received", "power", "send", "write", "wire"
        kind = rnd.choice((*kinds, "heed", "parallel"))
        soon = rnd.choice((US, MS, 3 * MS, 20 * MS, 200 * MS, 1000 * MS))
        if kind == "ask":
            self.act(at, "ask", rnd.choice(("F", "V1", "? P")), soon, within=False)
        elif kind == "got":
            self.act(at, "got", rnd.choice(("Y", "\r", "V", "E2\r", "=")), soon, within=False)
        elif kind == "space":
            self.act(at, "space", True, within=False)
            self.act(at + self.width(), "space", False, within=False)
        elif kind in ("drop", "hook"):
            self.act(at, kind, within=False)
        elif kind == "heed":
            self.act(at, "heed", rnd.choice((True, False, None)), within=False)
        elif kind == "parallel":
            self.act(at, "parallel", rnd.choice((0x4E, 0x2B, 0xFF)), within=False)
        elif kind == "line":
            self.act(at, "change_line", *rnd.choice(((9600, 7, "odd", 2), (300, 7, "odd", 2), (9600, 8, "none", 1))))
        elif kind == "received":
            self.act(at, "received", rnd.randrange(30), soon, within=False)
        elif kind == "power":
            self.act(at, "power", "x", False, within=False)
            self.act(at + self.width(), "power", "x", True, within=False)
        elif kind == "send":
            self.act(at, "send", text(rnd, SAID), within=False)
        elif kind == "write":
            self.act(at, "write", text(rnd, SAID)[:9], rnd.choice(("", "parity", "framing", "late")), within=False)
        else:
            self.hold(at, rnd.choice(self.lines))


def text(rnd: Random, said: tuple[str, ...]) -> str:
    """Return some lines, most of them as they should be."""
    return "".join(rnd.choice(said) + rnd.choice(ENDS) for _ in range(rnd.choice((1, 2, 3, 5))))


def base(seed: int) -> Dialogue:
    """Return a dialogue that nothing disturbs."""
    rnd = Random(f"exchange lines {seed}")
    if rnd.random() < 0.3:
        options: dict[str, Any] = {"fixed": rnd.choice((9600, 9600, None)), "baud": 9600}
        return Dialogue(seed, "cy545b", text(rnd, ASKED), options, 300 * MS)
    strapped = rnd.choice((9600, 9600, 9600, 300))
    part = rnd.choice(("gs-c200", "gs-c200s", "gs-c200s"))
    options = {
        "strapped": strapped,
        "baud": rnd.choice((None,) * 9 + (9600,)),
        "checked": rnd.random() < 0.2,
        "addresses": rnd.choice(((None,), (None,), (2, 3), (1, 2, 3))) if part == "gs-c200s" else (None,),
        "lenient": rnd.random() < 0.3,
    }
    lines = text(rnd, SAID)
    if options["addresses"][0]:
        lines = "".join(f"{rnd.choice((1, 2, 3))}{line}\r" for line in lines.split("\r"))
    return Dialogue(seed, part, lines, options, 300 * MS if strapped == 9600 else 3000 * MS)


def played(dialogue: Dialogue, twin: bool, seed: int, recorded: bool) -> Told:
    """Play a dialogue; as the twin, in which no line is taken as a whole."""
    whole, Receiver.whole_lines = Receiver.whole_lines, not twin
    longest, AdaptiveUart.longest = AdaptiveUart.longest, 1 if twin else AdaptiveUart.longest
    try:
        world = Told(dialogue, seed if twin else None)
        for name in world.wires if recorded else ():
            world.record(name)
        world.play()
    finally:
        Receiver.whole_lines, AdaptiveUart.longest = whole, longest
    return world


def dialogues(seed: int, number: int) -> list[Dialogue]:
    """Return so many dialogues that say the same, disturbed each in another way."""
    quiet = base(seed)
    rnd = Random(f"exchange lines {seed} disturbed")
    world = played(quiet, True, seed, True)
    marks = edges_of(world, world.wires, 1000) or [MS, 2 * MS, 3 * MS]
    made = []
    for each in range(number):
        first = rnd.randrange(max(len(marks) - 2, 1))
        near = [*marks[first : first + rnd.choice((20, 60, 400))], marks[-1] + MS]
        maker = Disturbed(rnd, near, world.wires, world.wires[:2])
        for _ in range(rnd.choice((0, 1, 1, 2, 3, 6))):
            maker.disturb()
        acts = maker.made()
        until = max([near[-1], *(act.at for act in acts)]) + rnd.choice((US, 500 * US, 100 * MS))
        made.append(Dialogue(seed * 100 + each, quiet.part, quiet.sent, quiet.options, until - until % NS, acts))
    return made
