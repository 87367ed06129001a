"""Nothing that two hosts and the pins do stops a CY545: RESET brings it back, and all of it can be repeated."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest

from .fuzz import BLOCK, Mad, check

LETTERS = 'ABCDEFGHIJLNOPQRSTWXYZ+-?0["'
ARGUMENTS = {
    "A": 500, "B": 256, "D": 4, "F": 256, "H": 64, "J": 40, "N": 30, "P": 500, "R": 256, "S": 256, "W": 64,
    "Y": 70,
}  # fmt: skip
WIDTHS = {"A": 3, "N": 3, "P": 3, "D": 2, "Y": 2, "Z": 3, "L": 2, "T": 2, **dict.fromkeys("BFHJORSW", 1)}
MODES = (0x80, 0x81, 0x81, 0x81, 0x85, 0x82, 0x90, 0xA0, 0x91, 0x00, 0x01, 0xFF)
INPUTS = (
    *(f"usrb{n}" for n in range(8)), "cw_limit", "ccw_limit", "inhibit_abort", "jog", "slew", "ccw",
    "io_request", "rxd",
)  # fmt: skip
STOPS = ("cw_limit", "ccw_limit", "inhibit_abort", *(f"usrb{n}" for n in range(6)))  # what ends a motion or a wait
STOPPED = b"0\r" * 32768
VALID = (
    "I\rO 81H\rA 5\rF 30\rR 40\rS 200\rN 3\r+\rG\rB 16\rC\rI\rO 81H\rF 255\rD 1\r0\rT 1,0\rL 1,0\rZ 1,0\rW 1\r-\r"
    '? R\r"hi"\r[1,1,2\rY 0\rE\rB 16\rP 2\rL 2,0\r0\rQJ 15\rY 0\rX\r'
)


def text(rnd: Random) -> bytes:
    """A piece of what a mad host sends: mostly commands, some of them wrong, some noise."""
    kind, letter = rnd.random(), rnd.choice(LETTERS)
    if kind < 0.08:
        return rnd.randbytes(rnd.randrange(1, 4))
    if letter == "Q":
        return b"Q"
    if letter == "O":
        mode = rnd.choice(MODES)
        return b"O %d\r" % mode if rnd.random() < 0.7 else bytes([0x4F, 1, mode])
    if kind < 0.20:
        count = WIDTHS.get(letter, 0)
        return bytes([ord(letter), count if rnd.random() < 0.95 else rnd.randrange(6)]) + rnd.randbytes(count)
    special = {
        "L": lambda: f"L {rnd.randrange(5)},{rnd.randrange(30)}",
        "T": lambda: f"T {rnd.randrange(64)},{rnd.randrange(30)}",
        "Z": lambda: f"Z {rnd.randrange(5)} {rnd.randrange(30)}",
        "?": lambda: "? " + rnd.choice(["P", "R", "B", "Y", "M,2", "K"]),
        '"': lambda: f'"{rnd.randrange(10**6)}"',
        "[": lambda: f"[{rnd.randrange(64)},2,65,{rnd.randrange(256)}",
    }
    if letter in special:
        return f"{special[letter]()}\r".encode()
    if letter not in ARGUMENTS:
        return f"{letter}\r".encode()
    number = rnd.randrange(ARGUMENTS[letter])
    slash = "/" * (letter in "BHTW" and rnd.random() < 0.2)
    return f"{slash}{letter} {rnd.choice(('#', number, f'0{number:X}H')) if rnd.random() < 0.3 else number}\r".encode()


class Mad545(Mad):
    """One run of the fuzz, with a host on each side, a memory, a display and switches."""

    part = "cy545b"
    letters, inputs, valid = LETTERS, INPUTS, VALID
    text = staticmethod(text)

    def __init__(self, seed: int, journal: str | None = None) -> None:
        super().__init__(seed, journal)
        self.effects["E"] = self.effects["Q"] = 10**6  # performed by the interpreter itself

    def furnish(self) -> None:
        """Put the chip on the bench, with what stands around it, and a host on each side."""
        self.chip = self.bench.add(self.part, "x", fixed_baud=19200)
        for kind in ("ram", "hp_display", "thumbwheels"):
            self.bench.part(kind, name=kind, to=self.chip)
        self.host = self.bench.host(self.chip)
        self.serial = self.bench.host(self.chip, over="serial", baud=19200)

    def block(self) -> None:
        """A thousand bytes for both sides with pin changes among them, then RESET, then every valid command."""
        rnd, bench, host = self.rnd, self.bench, self.host
        one, two = b"", b""
        while len(one) + len(two) < BLOCK:
            if rnd.random() < 0.85:
                one += self.text(rnd)
            else:
                two += self.text(rnd)
        before, self.stuck = host.sent, 0
        host.send(one)
        self.serial.write(two)
        while not (host.idle and self.serial.idle):
            for _ in range(rnd.randrange(3)):
                pin = self.chip.pin(rnd.choice(self.inputs))
                pin.release() if rnd.random() < 0.7 else pin.drive(rnd.randrange(2))
            bench.run(rnd.choice((10**7, 10**8, 10**9, 5 * 10**9)))
            if bench.now_ps - self.chip._waiting[1] > 10**11:
                self.stuck += 1
                if self.stuck > 40:
                    break
                self.chip.pin(rnd.choice(STOPS)).drive(0)
        self.accepted += host.sent - before + len(two)
        self.recover()

    def recover(self) -> None:
        """RESET, and everything works again."""
        chip, bench = self.chip, self.bench
        self.host.clear()
        self.serial.clear()
        for name in self.inputs:
            chip.pin(name).release()
        chip.reset()
        bench.run("5 ms")
        bench["ram"].load(STOPPED)  # else most programs are a minute of FF
        chip.pin("cw_limit").drive(0)
        self.host.send("H 10H\r")  # ends at the limit
        bench.run_until_idle("1 s")
        chip.pin("cw_limit").release()
        for lines in (self.valid, "N 3\rP 5\r"):
            self.host.send(lines)
            bench.run_until_idle("60 s")
        assert chip.position == 5 and chip.registers["number"] == 3, chip.waiting
        assert self.bench["ram"].content[:17] == b"B 16\rP 2\rL 2,0\r0\r", chip.waiting
        self.note()


@pytest.mark.parametrize(
    ("part", "seed"), [("cy545b", 4), pytest.param("cy545", 1, marks=pytest.mark.long)]
)  # quick ones
def test_two_mad_hosts_do_not_stop_a_cy545(part: str, seed: int, tmp_path: Path) -> None:
    check(1_000, tmp_path, type("Mad", (Mad545,), {"part": part}), seed)


@pytest.mark.long
@pytest.mark.timeout(6000)
def test_a_million_bytes_on_both_sides_do_not_stop_a_cy545(tmp_path: Path) -> None:
    check(1_000_000, tmp_path, Mad545)
