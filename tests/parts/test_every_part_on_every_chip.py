"""Every kind of part attached to every chip: where it makes sense it works, elsewhere the reason is given.

What a part is wired to follows from the roles of pins.  This table says by itself, part by part, where that must make
sense; a move of STEPS clockwise and one of BACK steps back are made, and the part must have seen them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest

import slewline
from slewline.chips import PARTS
from slewline.errors import WiringError
from slewline.parts import KINDS, part_class
from tests.rows import rows

STEPS, BACK = 12, 3
LETTERS = ("cy525", "cy512")
SHOWS = (*LETTERS, "cy500")  # the CY500 shows no direction
LINES = ("gs-c200", "gs-c200s")
OUTSIDE = ("cy545", "cy545b")  # whose memory is outside
PACKETS = tuple(part for part in PARTS if part.startswith("mc"))
ENCODERS = tuple(part for part in PACKETS if part.endswith("-e"))
SETS = {chip: "A 100\rF 100\rR 200\rS 255\r" for chip in OUTSIDE} | {
    "cy525": "A 100\rF 10\rR 10\rS 255\rZ 1\r",
    "cy512": "A\rF 1\rR 200\rS 0\r",
    "cy500": "A\rF 1\rR 250\r",
}
SLOW = {"cy525": "A 0\rF 3\rR 3\rS 255\rZ 1\r", "cy512": "A\rF 1\rR 1\rS 0\r", "cy500": "A\rF 1\rR 100\r"}
RUN, DELAY = {"cy525": "X", "cy512": "D"}, {"cy525": "D", "cy512": "X"}
MOVES = {chip: f"{sets}N {STEPS}\r+\rG\rN {BACK}\r-\rG\r" for chip, sets in SETS.items()}
DIRECTION = "a pin that shows the direction"


class Bench:
    """A chip named x with a part on it, and a host that has it make a motion."""

    def __init__(self, chip: str, kind: str, **options: Any) -> None:
        self.bench, self.chip, self.kind = slewline.Bench(), chip, kind
        straps = {"br0": 0, "br1": 0, "br2": 0, "chs": 0} if chip in LINES else {}
        self.x = self.bench.add(chip, name="x", straps=straps)
        if kind in ON_A_SHAFT:
            options["on"] = self.bench.part("translator", name="motor", to="x")
        self.part = self.bench.part(kind, name="part", to="x", **options)
        self.axis = self.x.axis(options.get("axis", 1))

    def pins(self, *names: str) -> list[int | None]:
        return [self.part.pin(name).level for name in names]

    def record(self, *names: str) -> None:
        self.bench.record(*(f"part.{name}" for name in names))

    def edges(self, name: str) -> int:
        return len(self.bench.edges(f"part.{name}")[0])

    def host(self) -> Any:
        return self.bench.host(self.x, name="computer")

    def move(self, host: Any = None) -> None:
        """Twelve steps clockwise, three back."""
        host = host or self.host()
        if self.chip in (*SHOWS, *OUTSIDE):
            host.send(MOVES[self.chip])
            self.bench.run_until_idle()
        elif self.chip in LINES:
            self.program(host, f"+{STEPS}", f"-{BACK}")
        else:
            axis = host.axis(getattr(self.axis, "number", 1))
            for position in (STEPS, STEPS - BACK):
                axis.send(f"SET_VEL 0x4000\nSET_ACC 256\nSET_POS {position}\nUPDATE")
                axis.wait("motion_complete")
                axis.send("CLR_STATUS")
            self.bench.run_until_idle()
        assert self.axis.travel == STEPS - BACK

    def program(self, host: Any, *lines: str) -> None:
        opening = "P" if self.chip == "gs-c200" else "Po"
        assert [host.ask(line) for line in (opening, "S10", "T100", "R10", *lines, "E")] == ["Y"] * (5 + len(lines))
        self.bench.run_until_idle()


# --------------------------------------------------------------------------------------------------- what a part sees
def turns(b: Bench) -> None:
    """A motor that follows."""
    b.move()
    assert b.part.position == STEPS - BACK


def follows_by_itself(b: Bench) -> None:
    """A motor that is integrated: it rests where it was sent, but for the steps that it says it has lost."""
    b.move()
    b.bench.run_until(b.part.rests)
    assert b.part.lost % 4 == 0
    assert abs(b.part.place + b.part.lost - (STEPS - BACK)) < 0.1


def counts(b: Bench) -> None:
    b.move()
    b.bench.run("1 ms")
    assert b.part.counts == STEPS - BACK


def energises(b: Bench) -> None:
    """The state of a driver after a full step each: two states of eight."""
    b.record("a")
    b.bench.pin("part.half_full").drive(0)
    b.move()
    assert b.part.state == 1 + 2 * (STEPS - BACK) % 8
    assert b.edges("a") > 4


def splits(b: Bench) -> None:
    b.record("cw", "ccw")
    b.move()
    assert (b.edges("cw"), b.edges("ccw")) == (2 * STEPS, 2 * BACK)


def holds(b: Bench) -> None:
    """Without a motor the first step is never made, and the chip waits for it."""
    host = b.host()
    if b.chip in LINES:
        for line in ("P" if b.chip == "gs-c200" else "Po", "S10", "T100", "R10", "+12", "E"):
            assert host.ask(line) == "Y"
    else:
        host.send(MOVES[b.chip])
    b.bench.run("3 s")
    assert (b.part.behind, abs(b.x.travel)) in {(1, 1), (1, 2)}
    b.part.pin("x").drive(1)  # the motor makes it
    assert b.part.behind == 0
    b.bench.run("1 s")
    assert b.part.behind == 1
    assert b.x.travel > 1


def brakes(b: Bench) -> None:
    b.record("c")
    b.program(b.host(), "+12")
    b.bench.run("10 ms")
    assert b.edges("c") == 4  # two pulses behind a motion


def cuts(b: Bench) -> None:
    on, off = ("A1", "C1") if b.chip in LINES else ("B\r", "C\r")
    host = b.host()
    if b.chip in LINES:
        b.program(host, "+12", on, off)
    else:
        host.send(MOVES[b.chip] + off + on)
        b.bench.run_until_idle()
    travel = STEPS if b.chip in LINES else STEPS - BACK
    assert [piece.length for piece in b.part.pieces] == [travel]


def drills(b: Bench) -> None:
    b.record("bit")
    b.program(b.host(), "A2", "+12", "-12", "C2")
    assert b.part.position == 0
    assert b.edges("bit") == 2
    assert b.bench.findings == []


def welds(b: Bench) -> None:
    if b.chip in LINES:
        b.program(b.host(), "+12", "A1", "D1", "C1")
        travel = STEPS
    else:
        host = b.host()
        host.send(f"C\r{MOVES[b.chip]}B\r{DELAY[b.chip]} 100\rC\r")
        b.bench.run_until_idle()
        travel = STEPS - BACK
    assert [spot.position for spot in b.part.spots][-1] == travel


def comes_and_goes(b: Bench) -> None:
    """A workpiece comes, the program that waits for it welds it, and it goes."""
    if b.chip in LINES:
        b.program(b.host(), "A1", "W1", "C1")
    else:
        host = b.host()
        if b.chip == "cy500":  # whose U waits for low only: the host sees to it that one is there
            host.send("B\r")
            b.bench.run("150 ms")
            host.send("C\r")
        else:
            host.send(f"E\rB\rW\rC\r0\rQ{RUN[b.chip]}\r")
        b.bench.run_until_idle()
    assert b.part.finished == 1
    assert b.bench.now_ps >= 10**11


def follows(b: Bench) -> None:
    """A rotor in the field of the phases."""
    b.move()
    assert b.part.position == STEPS - BACK


def latches(b: Bench) -> None:
    b.record("coil1")
    b.move()
    assert b.edges("coil1") > 4
    assert b.pins("coil1", "coil2", "coil3", "coil4") == [b.x.pin(f"phase{n}").level for n in (1, 2, 3, 4)]


def catches(b: Bench) -> None:
    """The position that the chip puts out while it steps; a CY512 does not, but its read-outs pass the same gates."""
    host = b.host()
    if b.chip == "cy512":
        host.send(SLOW[b.chip] + "P 40\r")
        b.bench.run_until_idle()
        b.x.pin("ascii_binary").drive(0)
        assert host.verify(0) == b"\0\x28"
        assert b.part.high_byte == 0x28
        return
    host.send("A 100\rF 3\rR 3\rS 255\rZ 1\rN 40\r+\rG\r")
    b.bench.run_until(b.x.reaches(120))
    assert host.read_position() == b.part.position == 121


def closes(b: Bench) -> None:
    """The chip feels HOME from the third step on."""
    b.move()
    b.bench.run("1 ms")
    home = b.x.sheet.role("home")
    assert (b.part.closed, b.x.pin(home.name).level) == (True, home.active)


def chooses(b: Bench) -> None:
    b.move()
    assert len({amperes for _, amperes in b.part.past}) >= 2  # at rest, and on the ramp


def runs_master(b: Bench) -> None:
    b.part.run(1000)
    b.bench.run("10 ms")
    b.part.run(0)
    b.bench.run("1 ms")
    assert b.x.axis(b.part.axis).registers["actl_pos"] == b.part.counts > 5


def talks_lines(b: Bench) -> None:
    """A connector of a computer: characters to the module and back."""
    b.bench.run("10 ms")
    b.part.write("F\r")
    b.bench.run_until(b.part.got(b"R\r"))


def talks_uart(b: Bench) -> None:
    computer = b.bench.part("serial_sender", name="pc", to="part")
    first, second = MOVES[b.chip].split("G\r", 1)
    computer.send(first + "G\r")
    computer.pause("1 s")  # nothing travels back: the chip takes no byte while it moves
    computer.send(second)
    b.bench.run_until_idle()
    assert b.x.travel == STEPS - BACK


def talks_gpib(b: Bench) -> None:
    kind, args = ("gpib_talker", ()) if b.kind == "gpib_listener" else ("gpib_controller", (5,))
    computer = b.bench.part(kind, name="pc", to="part")
    computer.send(MOVES[b.chip]) if not args else computer.write(*args, MOVES[b.chip])
    b.bench.run_until_idle()
    assert b.x.travel == STEPS - BACK


def stops_at_a_limit(b: Bench) -> None:
    host = b.host()
    host.send(f"{SLOW[b.chip]}N 40\r+\rG\r")
    b.bench.run_until(b.x.reaches(20))
    b.part.pin("limit").drive(0)
    b.bench.run("1 s")
    assert 20 <= b.x.position <= 21


def commands(b: Bench) -> None:
    """A part that is the host itself: it is told the moves, with the mark that ends them where it wants one."""
    mark = b"\xff"
    if b.kind == "ppi8255":
        b.part.sendparallel(MOVES[b.chip].encode() + mark)
    elif b.kind == "host8080":
        b.part.send(MOVES[b.chip].encode() + mark)
    elif b.kind == "keyboard":
        b.part.type(MOVES[b.chip])
    b.bench.run_until_idle()  # a PROM needs nobody
    assert b.x.travel == STEPS - BACK


def talks_sender(b: Bench) -> None:
    """Two returns, by which the chip finds the rate, and the moves, each with time to be made."""
    b.bench.run("20 ms")
    b.part.send("\r\r")
    for line in MOVES[b.chip].splitlines(keepends=True):
        b.part.send(line)
        b.part.pause("1 s" if line == "G\r" else "10 ms")
    b.bench.run_until_idle()
    assert b.x.travel == STEPS - BACK


def stores(b: Bench) -> None:
    """A program that is entered, and run."""
    b.host().send(f"Y 500\rE\r{MOVES[b.chip]}0\rQY 500\rX\r")
    b.bench.run_until_idle()
    assert b.part.content[500:].startswith(MOVES[b.chip].encode())
    assert b.x.travel == STEPS - BACK


def executes(b: Bench) -> None:
    b.part.load(MOVES[b.chip] + "0\r")
    b.host().send("X\r")
    b.bench.run_until_idle()
    assert b.x.travel == STEPS - BACK


def hands_over(b: Bench) -> None:
    """Bytes through the registers of a card in a PC: each with its handshake."""
    base = 0x340
    for byte in (MOVES[b.chip]).encode():
        while not b.part.inp(base + 4) & 0x80:
            b.bench.run("1 ms")
        b.part.out(base, byte)
        b.part.out(base + 2, 3)
        while b.part.inp(base + 4) & 0x80:
            b.bench.run("5 us")
        b.part.out(base + 2, 0)
    b.bench.run_until_idle()
    assert b.x.travel == STEPS - BACK


def sets(b: Bench) -> None:
    b.host().send(f"{SETS[b.chip]}N #\r+\rG\r")
    b.bench.run_until_idle()
    assert b.x.travel == STEPS


def jogs(b: Bench) -> None:
    b.part.cw()
    b.bench.run("1 s")
    b.part.off()
    assert b.x.travel > 5
    b.bench.run("1 s")
    before = b.x.travel
    b.part.ccw()
    b.bench.run("1 s")
    assert b.x.travel < before - 5


def shows_text(b: Bench) -> None:
    b.host().send('O 85H\r"Hello"\r')
    b.bench.run_until_idle()
    assert b.part.text == "Hello   "


def shows_parameters(b: Bench) -> None:
    host = b.bench.host(b.x, name="computer", over="serial")
    host.send("? R\r")
    b.bench.run_until_idle()
    b.bench.run("20 ms")
    assert b.part.parameters == {"R": "00100"}


def writes(b: Bench) -> None:
    """SET_POS, SET_VEL, SET_ACC and UPDATE over the board of a PC."""
    for code, *words in ((0x10, 0, STEPS), (0x11, 0, 0x4000), (0x12, 0, 256), (0x1A,)):
        b.part.command(code, *words) if hasattr(b.part, "command") else written(b, code, *words)
    b.bench.run("1 s")
    assert b.x.position == STEPS


def written(b: Bench, code: int, *words: int) -> None:
    base = 0x340

    def ready() -> None:
        while not b.part.inp(base + 4) & 0x80:
            b.bench.run("5 us")

    ready()
    b.part.out(base + 2, code)
    for byte in b"".join(word.to_bytes(2, "big") for word in words):
        ready()
        b.part.out(base, byte)
    for _ in range(2):  # the checksum
        ready()
        b.part.inp(base)


# ------------------------------------------------------------------------------------------------------------- table
@dataclass(frozen=True)
class Fit:
    """The chips that a kind of part makes sense with, what the refusal of the others says, how it is seen to work."""

    chips: tuple[str, ...] = ()
    needs: str = ""
    seen: Callable[[Bench], None] | None = None
    options: tuple[tuple[str, Any], ...] = ()


SISTERS = ("cy545b", "gs-c200", "mc1251a", "mc1251a-e")  # with the pins of another part, as far as parts need them
MOVED = tuple(part for part in PARTS if part != "cy500")
ALONE = Fit(needs="has no standard wiring; (connect|it has no pins)")
ON_A_SHAFT = tuple(kind for kind in KINDS if part_class(kind).sits == "must")
ON_THE_BUS = "a pin that (is a wire of the data bus|shows when the low byte of an address is on the bus)|data bus"
HOSTLIKE = "a pin that requests that the part read or output a byte"
FITS = {
    **dict.fromkeys(("inverter", "and", "or", "nand", "nor", "latch8", "delay"), ALONE),
    "uart": Fit(
        SHOWS, "a pin that (is a wire of the data bus|shows that a byte is being read)|" + HOSTLIKE, talks_uart
    ),
    "serial_sender": Fit(
        OUTSIDE, "a pin that receives characters from a computer|is active high, and txd is active low", talks_sender
    ),
    "serial_port": Fit(
        LINES, "a pin that receives characters from a computer|is active low, and txd is active high", talks_lines
    ),
    "rs232_line": Fit((), "a pin that is the output of a computer's serial port"),
    "prom": Fit(SHOWS, HOSTLIKE + "|data bus|is active high, and load is active low", commands, (("image", ""),)),
    "ram": Fit(OUTSIDE, ON_THE_BUS, stores),
    "eeprom": Fit(OUTSIDE, ON_THE_BUS, stores),
    "eprom": Fit(OUTSIDE, ON_THE_BUS, executes),
    "thumbwheels": Fit(OUTSIDE, ON_THE_BUS, sets, (("letter", "N"), ("value", f"{STEPS:08}"))),
    "hp_display": Fit(OUTSIDE, ON_THE_BUS, shows_text),
    "lcd": Fit(
        OUTSIDE, "a pin that sends characters to a computer|is active high, and rxd is active low", shows_parameters
    ),
    "parallel_card": Fit(OUTSIDE, "needs a pin that|data bus", hands_over),
    "jog_switch": Fit(OUTSIDE, "a pin that", jogs),
    "position_latch": Fit(LETTERS, "a pin that shows that a byte is being put on the data bus|data bus", catches),
    "phase_latch": Fit(SHOWS, "a pin that energises phase 1", latches),
    "translator": Fit(MOVED, "", turns),
    "rotor": Fit(SHOWS, "a pin that energises phase 1", follows),
    "motor": Fit(MOVED, "", turns),
    "stepper": Fit(MOVED, "", follows_by_itself, (("load", "friction 5 mNm"),)),
    "encoder": Fit(MOVED, "", counts, (("counts", 1), ("steps", 1))),
    "quadrature": Fit(ENCODERS, "a pin that receives channel A of an encoder", runs_master),
    "gs_d200": Fit(
        tuple(part for part in MOVED if part not in OUTSIDE), "is active low, and direction is active high", energises
    ),
    "phase_current": Fit(LINES, "a pin that shows that the motor is (moving|accelerating)", chooses),
    "two_clocks": Fit((*LETTERS, *LINES), "is active low, and dir is active high|rests at the level of a step", splits),
    "step_check": Fit((*LETTERS, *LINES), "a pin that enables the next step", holds),
    "damping": Fit(LINES, "a pin that shows that the motor is (moving|accelerating)", brakes),
    "bar": Fit((*LETTERS, *LINES), "a pin that is output 1", cuts),
    "drill": Fit(LINES, "a pin that is output 2", drills, (("gap", 5),)),
    "ppi8255": Fit(LETTERS, "needs a pin that", commands),
    "host8080": Fit((*SHOWS, *OUTSIDE), HOSTLIKE + "|data bus", commands),
    "keyboard": Fit((*SHOWS, *OUTSIDE), HOSTLIKE + "|data bus", commands, (("down", "5 ms"), ("apart", "10 ms"))),
    "isa": Fit(PACKETS, "needs a pin that", writes),
    "gpib_listener": Fit(SHOWS, "needs a pin that", talks_gpib),
    "gpib_talker": Fit((), "a pin that is a data line of an IEEE-488 bus"),
    "gpib_device": Fit(LETTERS, "needs a pin that", talks_gpib),
    "gpib_controller": Fit((), "a pin that is a data line of an IEEE-488 bus"),
    "gpib_interrupts": Fit(SHOWS, "a pin that shows that a motion is complete|enables the next step", stops_at_a_limit),
    "workpieces": Fit(
        (*SHOWS, *LINES), "a pin that is input 1", comes_and_goes, (("pieces", 1), ("welds", 1), ("change", "100 ms"))
    ),
    **dict.fromkeys(("gear", "carriage"), ALONE),
    "switch": Fit((*LINES, *PACKETS), "signals that the motor is at its home position", closes, (("low", 3),)),
    "welder": Fit((*LETTERS, *LINES), "a pin that is output 1", welds),
}  # fmt: skip


def test_the_table_knows_every_kind():
    assert set(FITS) == set(KINDS)


@rows("kind", FITS)
@rows("chip", [chip for chip in PARTS if chip not in SISTERS])
def test_every_part_works_on_every_chip_for_which_it_makes_sense_and_is_refused_by_the_others(kind, chip):
    works_or_is_refused(kind, chip)


@pytest.mark.long
@rows("kind", FITS)
@rows("chip", SISTERS)
def test_and_so_it_does_on_the_sisters_of_these_chips(kind, chip):
    works_or_is_refused(kind, chip)


def works_or_is_refused(kind, chip):
    """Put a part on a chip, and see that it works, or why it is refused."""
    fit = FITS[kind]
    options = dict(fit.options)
    if "image" in options:
        options["image"] = MOVES.get(chip, MOVES["cy525"])
    if chip in fit.chips:
        fit.seen(Bench(chip, kind, **options))
        return
    bench = slewline.Bench()
    x = bench.add(chip, name="x")
    parts = {}
    needs = fit.needs if x.sheet.role("direction") else f"{fit.needs}|{DIRECTION}".removeprefix("|")
    with pytest.raises(WiringError, match=needs):
        if kind in ON_A_SHAFT:
            options["on"] = parts["motor"] = bench.part("translator", name="motor", to="x")
        bench.part(kind, to=x, **options)
    assert bench.parts == parts
