"""Boundaries: dialogues that lead to one place of the core, for what chance reaches too seldom."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator

from . import library, witness
from .dialogues import MS, PARTS, US, Dialogue, S
from .witness import BAUDS

Script = Callable[["Case"], None]
CASES: list[tuple[str, Script]] = []


class Case(Dialogue):
    """A dialogue without chance."""

    def __init__(self, part: str, script: Script) -> None:
        self.script, self.part = script, part
        self.set_up = dict(getattr(script, "set_up", {}))
        super().__init__(0, part)

    def _module(self, name: str, part: str, address: int) -> witness.Module:
        given = self.set_up
        self.rng = random.Random(0)
        self.rate, self.checks = given.get("rate", 0), given.get("checks", False)
        straps = {"br0": self.rate & 1, "br1": self.rate >> 1 & 1, "br2": self.rate >> 2 & 1, "chs": int(self.checks)}
        straps |= {pin: 0 for pin in given.get("low", ())}
        address = given.get("address", 0)
        fixed = {f"sel{n}": (7 - address) >> (2 - n) & 1 for n in range(3)} if address else {}
        self.address = address
        return witness.Module(self.bench, name, part, straps, fixed, given.get("kept", b""), given.get("looks", 0))

    def _play(self) -> None:
        self.addresses = dict.fromkeys(self.modules, self.address)
        self.wait(MS)
        self.start()
        self.script(self)

    def start(self) -> None:
        for name, module in self.modules.items():
            module.put(self.set_up.get("rxd", 0))
            module.power(True)
            self.baud_at[name][self.kernel.now] = BAUDS[self.rate]
            self.wait(500 * US)
            module.put(0)

    @property
    def module(self) -> witness.Module:
        """The module."""
        return self.modules["m0"]

    def line(self, text: str) -> bytes:
        text = f"{self.address or ''}{text}"
        return witness.framed(text.encode("ascii"), self.checks)

    def send(self, data: bytes, damage: dict[int, int] | None = None) -> None:
        baud = BAUDS[self.rate]
        self.module.put(witness.characters_of(data, baud, self.kernel.now, damage))
        self.wait(witness.length_of(len(data), baud))

    def ask(self, text: str, wait: bool = True) -> None:
        self.send(self.line(text))
        if wait:
            self.kernel.run_while(lambda: not self.module.x.line.answering, self.kernel.now + 200 * S)

    def says(self, *lines: str) -> None:
        """Send lines, each after the answer to the one before."""
        for text in lines:
            self.ask(text)

    def runs(self, *lines: str, during: int = 2 * S) -> None:
        """Enter a program and let it run for a time (ps)."""
        self.says("Po" if self.is_200s else "P", *lines, "E")
        self.wait(during)

    def gone(self, letter: str) -> str:
        """Return the letter of an endless run."""
        return letter.lower() if self.is_200s else letter.upper()


def case(**set_up: object) -> Callable[[Script], Script]:
    """Make a function a case, of both parts."""

    def marked(script: Script) -> Script:
        script.set_up = set_up  # type: ignore[attr-defined]
        CASES.append((script.__name__, script))
        return script

    return marked


def all_cases() -> Iterator[tuple[str, Case]]:
    """Yield all cases on both parts."""
    for name, script in CASES:
        for part in PARTS:
            yield f"{name}, {part}", Case(part, script)


# ------------------------------------------------------------------------------------------------------------ language
@case()
def every_command_and_its_ranges(d: Case) -> None:
    d.says("F", "V1", "V2", "Q", "K", "Z", "H", "X", "E", "Px", "I1", "I2", "I3", "I0", "I4", "f+1", "f-1", "f0", "V0", "V3")
    d.says("Po", "P", "P0")
    for text in ("A", "C", "U", "W"):
        d.says(*(f"{text}{n}" for n in ("", 0, 1, 3, 4)), "Po", "P")
    for text, top in (("D", 255), ("L", 255), ("S", 1000), ("T", 1000), ("R", 999), ("j", 118)):
        d.says(*(f"{text}{n}" for n in (0, 1, top, top + 1, "01", "+1")), "Po", "P")
    d.says("G0", "G+0", "G-1", "G9999999", "G10000000", "G8388607", "G8388608", "G-8388608", "G-8388609", "Q", "Po", "P")
    for letter in ("g", "G"):
        d.says(*(f"{letter}{rest}" for rest in ("+", "-", "+0", "+1", "-3", "+4", "", "1", "+1,")), "Q", "Po", "P")
    d.says("jc0,0", "jc7,118", "jc8,0", "jc0,119", "jc,1", "jc1", "jc1,", "jc11", "j,1", "Q", "Po", "P")
    d.says("+0", "-0", "+1", "-1", "+999999", "+1000000", "-999999", "-1000000", "1", "+", "-", "Q", "Po", "P")
    d.says("f+8388607", "f+8388608", "f-8388608", "f-8388609", "f5", "L0", "Lo", "L", "L00", "Q", "Po", "P")
    d.says("F", "V1", "V2", "M", "X", "H", "K", "Z", "I1", "I2", "A1", "Px", "A1", "E")


# -------------------------------------------------------------------------------------------------------------- memory
@case()
def a_full_memory(d: Case) -> None:
    d.says("Po" if d.is_200s else "P", *["+1"] * 29, "A1", "C1", "A2", "+5", "Q", "E")


@case()
def four_more_than_fit(d: Case) -> None:
    d.says("Po" if d.is_200s else "P", *["-12345"] * 28, "A1", "+5", "+5", "A2", "Q")


@case(looks=2)
def an_eeprom_that_takes_longer(d: Case) -> None:
    d.says("Po" if d.is_200s else "P", "A1", "M", "F", "X", "Q")


@case(kept=b"A\1\0\0")
def no_whole_program(d: Case) -> None:
    d.says("X", "Q")


@case(kept=b"A\1C")
def an_instruction_that_is_cut_off(d: Case) -> None:
    d.says("X", "Q")


__all__ = ["CASES", "Case", "all_cases", "library"]
