"""Nothing that a host or the pins do stops a CY500: RESET brings it back, and all of it can be repeated."""

from __future__ import annotations

import hashlib
from collections import Counter
from pathlib import Path
from random import Random
from typing import Any

import pytest

import slewline

from .fuzz import BLOCK, Mad, replayed

LETTERS = "ABCDEFGHIJLNOPQRSTU+-0"
ARGUMENTS = {"F": 256, "N": 400, "P": 65_536, "R": 256, "S": 256}
INPUTS = ("abort", "trigger", "wait", "xss", "xdir", "ascii_binary", "io_request")
VALID = (
    "I\rR 253\rF 2\rS 20\rN 3\r+\rG\rA\rB\rC\r-\rP 2\rG\rO\rH\rL\r0\rT\rJ\rI\rF 1\rA\rB\rN 5\rG\rE\rB\rC\rN 3\r0\rQD\r"
)


def text(rnd: Random) -> bytes:
    """A piece of what the mad host sends: mostly commands, some of them wrong, some noise."""
    kind, letter = rnd.random(), rnd.choice(LETTERS)
    if kind < 0.10:
        return rnd.randbytes(rnd.randrange(1, 4))
    if letter == "Q":
        return b"Q"
    count = 2 if letter in "NP" else letter in "FRS"
    if kind < 0.25:
        return bytes([ord(letter), count if rnd.random() < 0.95 else rnd.randrange(6)]) + rnd.randbytes(count)
    return f"{letter} {rnd.randrange(ARGUMENTS[letter])}\r".encode() if letter in ARGUMENTS else f"{letter}\r".encode()


class Mad500(Mad):
    """One run of the fuzz."""

    def __init__(self, seed: int, journal: str | None = None) -> None:
        self.rnd = Random(seed)
        self.bench = slewline.Bench(journal=journal)
        self.chip: Any = self.bench.add("cy500", "x", position=0)
        self.host = self.bench.host(self.chip)
        self.hash, self.told = hashlib.sha256(), hashlib.sha256()
        self.effects: Counter[str] = Counter()
        self.findings: Counter[str] = Counter()
        self.accepted = 0
        for code, handler in list(self.chip.interpreter.handlers.items()):
            self.chip.interpreter.handlers[code] = self._counted(code, handler)

    def block(self) -> None:
        """A thousand bytes with pin changes among them, then RESET, then every valid command."""
        rnd, bench, host = self.rnd, self.bench, self.host
        data = b""
        while len(data) < BLOCK:
            data += text(rnd)
        before = host.sent
        host.send(data)
        while not host.idle:
            for _ in range(rnd.randrange(3)):
                pin = self.chip.pin(rnd.choice(INPUTS))
                pin.release() if rnd.random() < 0.6 else pin.drive(rnd.randrange(2))
            bench.run(rnd.choice((10**7, 10**8, 10**9, 5 * 10**9)))
            if rnd.random() < 0.02 or bench.now_ps - self.chip._waiting[1] > 10**11:
                break  # stuck at a wait, or simply enough of it
        self.accepted += host.sent - before
        self.recover()

    def recover(self) -> None:
        """RESET, and everything works again."""
        chip, bench = self.chip, self.bench
        self.host.clear()
        for name in INPUTS:
            chip.pin(name).release()
        chip.pin("trigger").drive(0)
        chip.reset()
        bench.run("1 ms")
        self.host.send(VALID)
        bench.run_until_idle("30 s")
        assert chip.position == 5 and chip.program == b"BCN\3\0\0" and chip.registers["number"] == 3, chip.waiting
        assert not chip.pin("programmable_output").level and chip.pin("run").level == 1, chip.waiting
        self.note()


def run(bytes_wanted: int, seed: int, journal: str | None = None) -> Mad500:
    """Run until so many bytes have been accepted."""
    mad = Mad500(seed, journal)
    while mad.accepted < bytes_wanted:
        mad.block()
    return mad


def check(bytes_wanted: int, tmp_path: Path) -> None:
    journal = str(tmp_path / "journal")
    one = run(bytes_wanted, 1, journal)
    print(one.accepted, dict(one.effects), dict(one.findings))
    for letter in set(LETTERS) - {"Q"}:
        assert one.effects[letter] >= bytes_wanted // 2000, f"{letter} was hardly reached"
    assert run(bytes_wanted, 1).digest() == one.digest()
    assert replayed(journal) == one.end_state()


def test_a_mad_host_does_not_stop_a_cy500(tmp_path: Path) -> None:
    check(2_000, tmp_path)


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_half_a_million_bytes_do_not_stop_a_cy500(tmp_path: Path) -> None:
    check(500_000, tmp_path)
