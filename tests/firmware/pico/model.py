"""A board beside the model: the same characters and levels at the same instants, and what the two show."""

from __future__ import annotations

import warnings
from typing import NamedTuple

import slewline
from slewline.core.wires.net import Driver
from slewline.core.wires.serial import RS232, CharacterFormat, bit_clock
from slewline.core.wires.wave import Wave
from slewline.record.recording.recorder import Recorder

from .emulated import HZ, Emulator, Pico, cycles_of, ps_of

US, MS, S = 10**6, 10**9, 10**12
WORD = CharacterFormat(7, "odd", 2)
SLOW = ("rdy", "mov", "ramp", "dir", "reset", "uo1", "uo2", "uo3")
TOLERANCE_PS = 50 * US  # of an answer, and of the first step of a motion
STEP_PS = 8000  # of every later step, from the first
PIN_PS = 150 * US  # of another output


class Steps(NamedTuple):
    """How the steps of a board lie to those of the model: of the first step of each motion, of the others to it; ps."""

    count: int
    first: int
    later: float


class Pair:
    """A module of the model, and a board.  Instants are picoseconds from power-up."""

    def __init__(self, emulator: Emulator, number: int = 0, part: str = "gs-c200s", **straps: int) -> None:
        self.board = Pico(emulator, number, **straps)
        self.bench = slewline.Bench()
        fixed = {"test": 0} | straps
        self.x = self.bench.add(
            part, name="m", straps={name: level for name, level in fixed.items() if name != "rxd"}, cold=True
        )
        self.bench.record(*(f"m.{pin}" for pin in (*SLOW, "txd", "clock")))
        self.rxd = Driver(self.x.pins["rxd"].net, "host")
        self.rxd.drive(straps.get("rxd", 0))
        self.bench.kernel.settle()
        self.released: list[int] = []  # instants at which ENABLE has risen
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self.x.power(True)
        self.board.power_up()
        self.wait(8 * MS)

    @property
    def now(self) -> int:
        """The present, ps from power-up."""
        return self.bench.kernel.now

    def cycle(self, ps: int) -> int:
        """Return the cycle of the board at an instant."""
        return self.board.up + cycles_of(ps)

    def wait(self, ps: int) -> None:
        """Let time pass."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self.bench.kernel.run(self.now + ps)
        self.board.run(self.cycle(self.now))

    def drive(self, pin: str, level: int, at: int | None = None) -> None:
        """Give an input a level, now or later."""
        at = self.now if at is None else at
        if pin == "enable" and level:
            self.released.append(at)
        self.x.pin(pin).drive(level, at=f"{at} ps") if at > self.now else self.x.pin(pin).drive(level)
        self.board.drive(pin, level, self.cycle(at))

    def send(self, data: bytes) -> None:
        """Put characters on RXD, and let them pass."""
        baud = HZ // self.board.bit
        clock, times, levels, start = bit_clock(baud, "host"), [], [], self.now
        for byte in data:
            times += [start + clock.ps(16 * n) for n in range(10)]
            levels += [RS232 if bit else 1 - RS232 for bit in (*WORD.levels(byte), 1)]
            start += clock.ps(WORD.ticks)
        self.rxd.drive(Wave(RS232, tuple(times), tuple(levels)))
        self.bench.kernel.settle()
        self.board.send(data, self.cycle(self.now))
        self.wait(start - self.now)

    def ask(self, text: str, ms: float | None = None) -> None:
        """Send a line, and let its answer pass, or some milliseconds."""
        self.send(text.encode("ascii") + b"\r")
        self.wait(2 * MS + 66 * self.board.bit * S // HZ if ms is None else int(ms * MS))

    # ------------------------------------------------------------------------------------------------------- compare
    def wanted(self, pin: str) -> list[tuple[int, int]]:
        """Return the edges of a pin of the model: instant and level."""
        times, levels = Recorder().edges(self.x.pins[pin], 0, self.now)
        return list(zip(times.tolist(), [max(level, 0) for level in levels.tolist()], strict=True))

    def ps(self, cycle: int) -> float:
        """Return the instant of a cycle."""
        return float(ps_of(cycle - self.board.up))

    def steps(self) -> Steps:
        """Compare the steps, each with its motion's first one; after a hold the step that was held is a first one."""
        wanted = [at for at, level in self.wanted("clock") if level == 0 and at]
        found = [self.ps(cycle) for cycle in self.board.steps()]
        assert len(wanted) == len(found), f"model {len(wanted)} steps, board {len(found)}"
        begins = [at for at, level in self.wanted("mov") if level]
        first, later, reference = 0.0, 0.0, 0.0
        for number, (model, board) in enumerate(zip(wanted, found, strict=True)):
            before = wanted[number - 1] if number else -1
            anew = any(before < at <= model for at in (*begins, *self.released))
            if anew:
                reference = board - model
                first = max(first, abs(reference), key=abs)
            later = max(later, abs(board - model - reference))
        return Steps(len(wanted), round(first), later)

    def pins(self) -> int:
        """Compare the other pins: the same edges; return how far apart they are at most, ps."""
        worst = 0.0
        for pin in SLOW:
            wanted = [edge for edge in self.wanted(pin) if edge[0] > 0]
            found = [(self.ps(cycle), level) for cycle, level in self.board.edges(pin) if self.ps(cycle) > US]
            found = [edge for edge in found if edge[0] <= self.now - MS]
            wanted = [edge for edge in wanted if edge[0] <= self.now - MS]
            assert [level for _, level in wanted] == [level for _, level in found], (pin, wanted, found)
            worst = max([worst, *(abs(a - b) for (a, _), (b, _) in zip(wanted, found, strict=True))])
        return round(worst)

    def answers(self) -> tuple[str, int]:
        """Compare the answers; return them, and how far a start bit is from the model's, at most, ps."""
        times = Pico.frames(self.board, [(self.cycle(at), level) for at, level in self.wanted("txd")])
        wanted = [(self.ps(at), chr(sum(bit << n for n, bit in enumerate(bits[1:8])))) for at, bits in times]
        found = [(self.ps(at), character) for at, character in self.board.characters()]
        said = "".join(character for _, character in found)
        assert "".join(character for _, character in wanted) == said, (wanted, found)
        return said, round(max((abs(a - b) for (a, _), (b, _) in zip(wanted, found, strict=True)), default=0))
