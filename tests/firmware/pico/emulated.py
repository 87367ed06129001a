"""Boards in the emulator, driven cycle by cycle: a Pico that runs the firmware from its second stage on."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path
from typing import Any

from tools.pico import PicoFirmware

from .needs import RP2040JS

HERE = Path(__file__).resolve().parent
HZ = 132_000_000
US = HZ // 1_000_000
PINS = {
    **{name: n for n, name in enumerate(("sel0", "sel1", "sel2", "br0", "br1", "br2", "chs", "rec", "rxd"))},
    **{"enable": 9, "home": 10, "eot": 11, "ui1": 12, "ui2": 13, "ui3": 14, "test": 15},
    **{
        "clock": 16,
        "dir": 17,
        "mov": 18,
        "ramp": 19,
        "reset": 20,
        "rdy": 21,
        "uo1": 22,
        "uo2": 26,
        "uo3": 27,
        "txd": 28,
    },
    "led": 25,
}
INVERTED = ("rdy", "txd")  # by the transistor or optocoupler behind the pin, as RXD is by the one before it
PULLED = {"clock": 1, "dir": 1, "reset": 1, "rdy": 1, "txd": 1}  # what resistors do with a pin that is let go
BAUDS = {0: 9600, 1: 4800, 2: 2400, 3: 1200, 4: 600, 5: 300, 6: 150, 7: 110}  # by BR2, BR1, BR0 as a number
STACK = (0x20041000, 0x20042000)


def ps_of(cycles: int) -> Fraction:
    """Return how long so many cycles last, ps."""
    return Fraction(cycles * 250_000, 33)


def cycles_of(ps: int) -> int:
    """Return the number of cycles nearest to a time (ps)."""
    return round(Fraction(ps * 33, 250_000))


class Emulator:
    """A process of node with any number of boards, by their numbers."""

    def __init__(self, firmware: PicoFirmware) -> None:
        words = ["node", str(HERE / "emulator.js"), str(RP2040JS), str(firmware.image)]
        self._node = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.firmware = firmware

    def ask(self, **request: Any) -> dict[str, Any]:
        """Return the answer to a request."""
        assert self._node.stdin and self._node.stdout
        self._node.stdin.write(json.dumps(request) + "\n")
        self._node.stdin.flush()
        line = self._node.stdout.readline()
        assert line, "the emulator has ended; why is above"
        answer: dict[str, Any] = json.loads(line)
        return answer

    def close(self) -> None:
        """End the process."""
        assert self._node.stdin and self._node.stdout
        self._node.stdin.close()
        self._node.wait(60)
        self._node.stdout.close()


class Pico:
    """A board.  `changes`: cycle, pin and level (2: it is let go) of all it has driven."""

    def __init__(self, emulator: Emulator, number: int = 0, **straps: int) -> None:
        self.emulator, self.number = emulator, number
        self.changes: list[tuple[int, int, int]] = []
        self.resets: list[tuple[int, str]] = []
        self.bit = HZ // BAUDS[straps.get("br0", 1) | straps.get("br1", 1) << 1 | straps.get("br2", 1) << 2]
        given = {"test": 0} | straps
        self._ask(
            make=True, straps=[[PINS[name], 1 - level if name == "rxd" else level] for name, level in given.items()]
        )

    def _ask(self, **request: Any) -> dict[str, Any]:
        told = self.emulator.ask(board=self.number, **request)
        self.told = told
        self.now: int = told["now"]
        self.changes += map(tuple, told["changes"])
        self.resets += map(tuple, told["resets"])
        assert not told["notes"], told["notes"]
        return told

    def power_up(self) -> None:
        """Switch the supply on, and run until RESET falls: the part begins."""
        seen, on = len(self.changes), self.now
        self._ask(power=True, run=on)
        while not self._fallen(seen):
            assert self.now < on + 50_000 * US, "no RESET pulse"
            self.run(self.now + 100 * US)
        self.up, self.boot = self._fallen(seen)[0], self._fallen(seen)[0] - on

    def _fallen(self, seen: int) -> list[int]:
        return [cycle for cycle, pin, level in self.changes[seen:] if pin == PINS["reset"] and level == 0]

    def fail(self, seed: int) -> None:
        """Let the supply fail now."""
        self._ask(fail=seed)

    def run(self, cycle: int, **more: Any) -> dict[str, Any]:
        """Run up to a cycle, or as far beyond it as the last instruction lasts."""
        return self._ask(run=cycle, **more)

    def send(self, data: bytes, cycle: int | None = None, **more: Any) -> int:
        """Put characters on RXD; return the cycle at which the last stop bit ends."""
        at = self.now + 1000 if cycle is None else cycle
        return int(self._ask(send=[{"hex": data.hex(), "bit": self.bit, "cycle": at, **more}])["until"][0])

    def drive(self, pin: str, level: int, cycle: int) -> None:
        """Let an input have a level of the part from a cycle on."""
        self._ask(inputs=[[PINS[pin], 1 - level if pin == "rxd" else level, cycle]])

    def ask(self, text: str, ms: float = 6) -> str:
        """Send a line, run until an answer has been sent; return it."""
        end = self.send(text.encode("ascii") + b"\r")
        self.run(end + round(ms * 1000 * US) + 60 * 11 * self.bit // 10)
        return "".join(character for at, character in self.characters() if at >= end)

    def forget(self) -> None:
        """Forget what it has driven so far."""
        self.changes.clear()

    # ---------------------------------------------------------------------------------------------- what it showed
    def edges(self, pin: str) -> list[tuple[int, int]]:
        """Return the edges of an output as the part shows it: cycle and level."""
        number, out = PINS[pin], []
        before = -1
        for cycle, which, level in self.changes:
            if which != number:
                continue
            shown = PULLED.get(pin, 0) if level == 2 else level
            shown = 1 - shown if pin in INVERTED else shown
            if shown != before:
                out.append((cycle, shown))
            before = shown
        return out

    def steps(self) -> list[int]:
        """Return the cycles at which CLOCK fell."""
        return [cycle for cycle, level in self.edges("clock") if level == 0]

    def frames(self, edges: Iterable[tuple[int, int]] | None = None) -> list[tuple[int, list[int]]]:
        """Return each character on TXD: the cycle of its start bit, and the levels in the middle of its ten bits."""
        out: list[tuple[int, list[int]]] = []
        at, level, changes = 0, 0, list(self.edges("txd") if edges is None else edges)
        index = 0
        while index < len(changes):
            at, level = changes[index]
            if level != 1:  # the mark is 0 on an RS-232 line
                index += 1
                continue
            if at + 10 * self.bit > self.now:
                break  # it is still being sent
            bits = []
            for n in range(10):
                middle = at + n * self.bit + self.bit // 2
                while index + 1 < len(changes) and changes[index + 1][0] <= middle:
                    index += 1
                bits.append(1 - changes[index][1])
            out.append((at, bits))
            index += 1
        return out

    def characters(self) -> list[tuple[int, str]]:
        """Return the characters on TXD, each with the cycle of its start bit; parity and first stop bit are right."""
        out = []
        for at, bits in self.frames():
            assert bits[0] == 0 and sum(bits[1:9]) % 2 == 1 and bits[9] == 1, (at, bits)
            out.append((at, chr(sum(bit << n for n, bit in enumerate(bits[1:8])))))
        return out

    def off_the_grid(self) -> int:
        """Return by how many cycles an edge of TXD lies off the bits of its answer, at most."""
        worst, begin, last = 0, None, 0
        for at, _ in self.frames():
            if begin is None or at - last > 11 * self.bit + self.bit // 2:
                begin = at
            last = at
            ends = [edge for edge, _ in self.edges("txd") if at <= edge < at + 10 * self.bit]
            for edge in ends:
                off = (edge - begin) % self.bit
                worst = max(worst, min(off, self.bit - off))
        return worst
