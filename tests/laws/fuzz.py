"""A host gone mad: bytes weighted by the grammar, pins that change at random, a RESET every thousand bytes.

    python -m tests.laws.fuzz 1000000        run it, print what was reached, the hash, and the hash of its replay

Everything the chip does is a function of the seed: the same run twice, and the replay of its journal, give the same
hash over all findings, registers, steps and output levels.
"""

from __future__ import annotations

import hashlib
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from random import Random
from types import MappingProxyType
from typing import Any

import slewline

LETTERS = "ABCDEFGHIJLNOPQRSTUVWXZ+-0"
ARGUMENTS = {
    "A": 65535,
    "D": 3,
    "F": 130,
    "J": 62,
    "N": 400,
    "O": 255,
    "P": 65535,
    "R": 130,
    "S": 255,
    "T": 62,
    "V": 5,
    "Z": 3,
}
INPUTS = ("abort", "step_inhibit", "wait", "dowhile", "ascii_binary", "io_select", "io_request", "prog")
BLOCK = 1000  # bytes between two resets
VALID = (
    "I\rA 5\rF 3\rR 10\rS 200\rZ 1\rN 3\r+\rG\rB\rC\r-\rP 5\rO 2\rH\rV 3\rD 1\r0\rT 5\rL 1,0\rW\r"
    "E\rB\rC\rL 2,0\r0\rQX\rJ 1\r"
)


def text(rnd: Random) -> bytes:
    """A piece of what the mad host sends: mostly commands, some of them wrong, some noise."""
    kind = rnd.random()
    letter = rnd.choice(LETTERS)
    if kind < 0.10:
        return bytes(rnd.randrange(256) for _ in range(rnd.randrange(1, 4)))
    if kind < 0.25:  # binary form
        if letter == "Q":
            return b"Q"
        count = 2 if letter in "ALNPD" else 1 if letter in "FJORSTVZ" else 0
        return bytes(
            [
                ord(letter),
                count if rnd.random() < 0.95 else rnd.randrange(6),
                *(rnd.randrange(256) for _ in range(count)),
            ]
        )
    if letter == "Q":
        return b"Q"
    if letter == "L":
        return b"L %d,%d\r" % (rnd.randrange(5), rnd.randrange(12))
    label = f"{rnd.choice('ABCDEF')}$" if rnd.random() < 0.05 else ""
    argument = f" {rnd.randrange(ARGUMENTS[letter] + 1)}" if letter in ARGUMENTS else ""
    if letter in "JT" and rnd.random() < 0.3:
        argument = f" {rnd.choice('ABCDE')}"
    return f"{label}{letter}{argument}\r".encode()


class Mad:
    """One run of the fuzz."""

    part = "cy525"
    letters = LETTERS
    inputs: tuple[str, ...] = INPUTS
    text = staticmethod(text)
    valid = VALID  # every command once; it ends at position 5, with N 3 and the programmable output low
    program = b"BCL\2\0\0"  # what it has entered
    rest: Mapping[str, int] = MappingProxyType({})  # inputs that are at a level in it

    def __init__(self, seed: int, journal: str | None = None) -> None:
        self.rnd = Random(seed)
        self.bench = slewline.Bench(journal=journal)
        self.furnish()
        self.hash, self.told = hashlib.sha256(), hashlib.sha256()
        self.effects: Counter[str] = Counter()
        self.findings: Counter[str] = Counter()
        self.accepted = 0
        for code, handler in list(self.chip._interpreter.handlers.items()):
            self.chip._interpreter.handlers[code] = self._counted(code, handler)

    def furnish(self) -> None:
        """Put the chip and its host on the bench."""
        self.chip: Any = self.bench.add(self.part, "x", position=0)
        self.host = self.bench.host(self.chip)

    def _counted(self, code: int | str, handler: Any) -> Any:
        letter = code if isinstance(code, str) else chr(code or 0x30)

        def counted(*values: int, **named: bytes) -> Any:
            self.effects[letter] += 1
            return handler(*values, **named)

        return counted

    def block(self) -> None:
        """A thousand bytes with pin changes among them, then RESET, then every valid command."""
        rnd, bench, host = self.rnd, self.bench, self.host
        data = b""
        while len(data) < BLOCK:
            data += self.text(rnd)
        before = host.sent
        host.send(data)
        while not host.idle:
            for _ in range(rnd.randrange(3)):
                pin = self.chip.pin(rnd.choice(self.inputs))
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
        for name in self.inputs:
            chip.pin(name).release()
        for name, level in self.rest.items():
            chip.pin(name).drive(level)
        chip.reset()
        bench.run("1 ms")
        self.host.send(self.valid)
        bench.run_until_idle("30 s")
        chip.pin("wait").drive(0)
        self.host.send("U\r")
        bench.run_until_idle("1 s")
        chip.pin("wait").release()
        assert chip.position == 5 and chip.program == self.program and chip.registers["number"] == 3, chip.waiting
        assert not chip.pin("programmable_output").level and chip.pin("run").level == 1, chip.waiting
        self.note()

    def note(self) -> None:
        """What has happened so far goes into the hash, and is forgotten."""
        chip = self.chip
        steps = chip.steps()
        levels = [pin.level for pin in chip.pins.values()]
        self.hash.update(repr((self.bench.now_ps, chip.registers, chip.travel, levels)).encode())
        digest(self.told, chip.findings)
        self.hash.update(steps.times_ps[-2000:].tobytes() + steps.positions[-2000:].tobytes())
        self.findings.update(found.code for found in chip.findings)
        chip.findings.clear()
        chip.axes[0].forget(self.bench.now_ps)

    def digest(self) -> str:
        """Everything that happened, in one hash."""
        return self.hash.hexdigest() + self.told.hexdigest()

    def end_state(self) -> str:
        """What the replay of the journal must end with."""
        return state(self.bench, self.told.hexdigest())


def run(bytes_wanted: int, seed: int, journal: str | None = None, mad: type[Mad] = Mad) -> Mad:
    """Run until so many bytes have been accepted."""
    one = mad(seed, journal)
    while one.accepted < bytes_wanted:
        one.block()
    return one


def check(bytes_wanted: int, folder: Path, mad: type[Mad] = Mad, seed: int = 1) -> None:
    """Run so many bytes: every command is reached, RESET brings the chip back, run and journal repeat it."""
    journal = str(folder / "journal")
    one = run(bytes_wanted, seed, journal, mad)
    print(one.accepted, dict(one.effects), dict(one.findings))
    assert one.accepted >= bytes_wanted
    for letter in set(one.letters) - {"Q"}:
        assert one.effects[letter] >= bytes_wanted // 2000, f"{letter} was hardly reached"
    assert run(bytes_wanted, seed, mad=mad).digest() == one.digest()
    assert replayed(journal) == one.end_state()


def state(bench: slewline.Bench, told: str) -> str:
    """What can be asked at the end of a run, and a digest of all findings, in one hash."""
    chip = bench["x"]
    parts = (bench.now_ps, chip.registers, chip.travel, chip.program, [pin.level for pin in chip.pins.values()], told)
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def digest(found: hashlib._Hash, findings: list[Any]) -> None:
    """Add findings to a digest."""
    for finding in findings:
        found.update(f"{finding.time_ps} {finding.code} {finding.text}\n".encode())


def replayed(path: str) -> str:
    """The state at the end of a journal's replay."""
    bench = slewline.replay(path)
    told = hashlib.sha256()
    digest(told, bench["x"].findings)
    return state(bench, told.hexdigest())


def main() -> None:
    wanted = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000
    with tempfile.TemporaryDirectory() as folder:
        journal = str(Path(folder, "journal"))
        start = time.perf_counter()
        one = run(wanted, 1, journal)
        wall = time.perf_counter() - start
        print(f"{one.accepted:,} bytes accepted, {one.bench.now_ps / 1e12:.1f} s virtual in {wall:.0f} s")
        print("effects:", ", ".join(f"{letter} {count}" for letter, count in sorted(one.effects.items())))
        print("findings:", ", ".join(f"{code} {count}" for code, count in one.findings.most_common()))
        two = run(wanted, 1)
        print("hash      ", one.digest(), "\nagain     ", two.digest())
        print("end state ", one.end_state(), "\nreplayed  ", replayed(journal))
        assert one.digest() == two.digest() and one.end_state() == replayed(journal)


if __name__ == "__main__":
    main()
