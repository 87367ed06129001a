"""A host gone mad on a serial line: characters half near the grammar, half noise, with parity and framing faults, and
pins that change at random.

    python -m tests.laws.fuzz_gsc 1000000        run it, print what was answered, the hash, and the hash of its replay

After every block of characters a carriage return clears the line, K ends what runs, and the module must work as ever.
"""

from __future__ import annotations

import hashlib
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from random import Random
from typing import Any

import slewline
from slewline.language.lines import framed

from .fuzz import digest, replayed, state

INPUTS = ("enable", "eot", "home", "ui1", "ui2", "ui3", "chs")
BLOCK = 1000  # characters between two recoveries
ARGUMENTS = {
    "A": 4, "C": 4, "D": 260, "I": 4, "L": 260, "R": 1010, "S": 1010, "T": 1010, "U": 4, "V": 3, "W": 4, "j": 125,
    "+": 2_000, "-": 2_000, "G": 12_000_000, "G+": 9_000_000, "G-": 4, "g+": 4, "f+": 9_000_000, "f-": 9_000_000,
    "jc7,": 125, "H": 0,
}  # fmt: skip
BARE = (
    "E", "E", "F", "F", "H", "H-", "K", "K", "K", "K", "L0", "Lo", "M", "P", "Po", "Px", "Q", "X", "Z", "G-", "G+",
    "g+", "g-",
)  # fmt: skip
SPEEDS = ("S10", "T100", "R10")
ANSWERS = ("Y", "B", "E1", "E2", "E3", "E4", "E5", "E6", "V")


class Mad:
    """One run of the fuzz."""

    def __init__(self, part: str, seed: int, journal: str | None = None) -> None:
        self.rnd = Random(seed)
        self.bench = slewline.Bench(journal=journal)
        self.chip: Any = self.bench.add(part, "x", straps={"br0": 0, "br1": 0, "br2": 0})
        self.host = self.bench.host(self.chip)
        self.opener = "P" if part == "gs-c200" else "Po"
        self.hash, self.told = hashlib.sha256(), hashlib.sha256()
        self.answers: Counter[str] = Counter()
        self.findings: Counter[str] = Counter()
        self.sent = 0
        self.coming: list[bytes] = []  # lines that belong together
        self.host.uart.follow_straps()

    # --------------------------------------------------------------------------------------------------- what is sent
    def text(self) -> bytes:
        """A piece of what the mad host sends: a line that is nearly right, or noise."""
        rnd = self.rnd
        if not self.coming and rnd.random() < 0.002:  # more than fits into the memory
            self.coming = [framed(line, self.checked, self.chip.straps.kept) for line in (self.opener, *["+1"] * 32)]
        if self.coming:
            return self.coming.pop(0)
        if rnd.random() < 0.2:
            return bytes(rnd.randrange(128) for _ in range(rnd.randrange(1, 40)))
        line = rnd.choice((*BARE, *SPEEDS, "V1", "V2", self.opener, *(self.command() for _ in range(10))))
        if rnd.random() < 0.1:
            at = rnd.randrange(len(line) + 1)
            line = line[:at] + chr(rnd.randrange(128)) + line[at + rnd.randrange(2) :]
        return framed(line, self.checked is (rnd.random() < 0.95), self.chip.straps.kept)

    @property
    def checked(self) -> bool:
        return bool(self.chip.pin("chs").level == 1)

    def command(self) -> str:
        letter = self.rnd.choice(tuple(ARGUMENTS))
        most = ARGUMENTS[letter]
        return f"{letter}{self.rnd.randrange(min(most, 40) if self.rnd.random() < 0.5 else most)}" if most else letter

    def fault(self) -> str:
        chance = self.rnd.random()
        return "parity" if chance < 0.001 else "framing" if chance < 0.002 else ""

    # ------------------------------------------------------------------------------------------------------- one block
    def block(self) -> None:
        """A thousand characters with pin changes among them, then the recovery."""
        rnd, bench, host, size = self.rnd, self.bench, self.host, 0
        while size < BLOCK:
            data = self.text()
            size += len(data)
            for byte in data:
                host.write(bytes([byte]), self.fault())
            if rnd.random() < 0.9:  # mostly it lets the module answer
                bench.run_until(lambda: host.idle and not self.chip.answering, "600 s")
            if rnd.random() < 0.1:
                pin = self.chip.pin(rnd.choice(INPUTS))
                pin.release() if rnd.random() < 0.6 else pin.drive(rnd.randrange(2))
            if rnd.random() < 0.1:
                bench.run(rnd.choice((10**7, 10**9, 10**11, 2 * 10**12)))
        self.coming.clear()
        self.sent += size
        self.recover()

    def recover(self) -> None:
        """A carriage return, K, and everything works as ever."""
        bench, chip, host = self.bench, self.chip, self.host
        bench.run_until(lambda: host.idle and not chip.answering, "600 s")
        for name in INPUTS:
            chip.pin(name).release()
        chip.pin("chs").drive(0)
        host.write("\r")
        bench.run("10 s")  # the EEPROM, too
        self.note()
        assert host.ask("F") in ("R", "B", "E5", "E6"), host.answers
        host.ask(self.opener)  # B, if a program runs; else K would be refused in a session
        host.ask("E")
        host.ask("K")
        assert [host.ask("F") for _ in range(3)][-1] == "R", host.answers
        for line in ("I1", self.opener, *SPEEDS, "A1", "+3", "C1"):
            assert host.ask(line) == "Y", (line, host.answers)
        assert host.ask("E") == "Y" and host.ask("F") == "B"
        bench.run_until_idle("1 s")
        assert host.ask("F") == "R" and chip.position == 3
        chip.pin("chs").release()

    def note(self) -> None:
        """What has happened so far goes into the hash, and is forgotten."""
        chip, host = self.chip, self.host
        for line in bytes(host.received).split(b"\r"):
            text = line.decode("ascii")
            kind = "R" if text in ("R", "RR") else next((kind for kind in ANSWERS if text.startswith(kind)), "listing")
            self.answers[kind if text else "nothing"] += 1
        steps = chip.steps()
        levels = [pin.level for pin in chip.pins.values()]
        self.hash.update(repr((self.bench.now_ps, chip.registers, chip.travel, chip.program, levels)).encode())
        self.hash.update(bytes(host.received))
        self.hash.update(steps.times_ps[-2000:].tobytes() + steps.positions[-2000:].tobytes())
        digest(self.told, chip.findings)
        self.findings.update(found.code for found in chip.findings)
        chip.findings.clear()
        host.received.clear()
        chip.axes[0].forget(self.bench.now_ps)

    def digest(self) -> str:
        """Everything that happened, in one hash."""
        return self.hash.hexdigest()[:32] + self.told.hexdigest()[:32]

    def end_state(self) -> str:
        """What the replay of the journal must end with."""
        told = self.told.copy()
        digest(told, self.chip.findings)
        return state(self.bench, told.hexdigest())


def run(part: str, characters: int, seed: int, journal: str | None = None) -> Mad:
    """Run until so many characters have been sent."""
    mad = Mad(part, seed, journal)
    while mad.sent < characters:
        mad.block()
    return mad


def main() -> None:
    wanted = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000
    with tempfile.TemporaryDirectory() as folder:
        for part in ("gs-c200", "gs-c200s"):
            journal = str(Path(folder, part))
            start = time.perf_counter()
            one = run(part, wanted // 2, 1, journal)
            wall = time.perf_counter() - start
            print(f"{part}: {one.sent:,} characters, {one.bench.now_ps / 1e12:.1f} s virtual in {wall:.0f} s")
            print("answers:", ", ".join(f"{kind} {count}" for kind, count in one.answers.most_common()))
            print("findings:", ", ".join(f"{code} {count}" for code, count in one.findings.most_common()))
            two = run(part, wanted // 2, 1)
            print("hash      ", one.digest(), "\nagain     ", two.digest())
            print("end state ", one.end_state(), "\nreplayed  ", replayed(journal))
            assert one.digest() == two.digest() and one.end_state() == replayed(journal)


if __name__ == "__main__":
    main()
