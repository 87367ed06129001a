"""The board in the emulator, driven tick by tick: what drive/board/twin_board.py is, but real firmware."""

from __future__ import annotations

import json
import os
import subprocess
from contextlib import suppress
from pathlib import Path
from typing import Any

from tools.firmware import Firmware

from .needs import AVR8JS

HERE = Path(__file__).resolve().parent
DIR, ENABLE, LED, OUT2, OUT3 = 0x04, 0x08, 0x20, 0x01, 0x10  # of port B
OUT0, OUT1 = 0x04, 0x08  # of port D
BYTE = 320  # ticks
PHASES_WITHIN = (
    176  # ticks from a rise of STEP to its phases, at 45,000 steps/s and whatever else falls together: 11 us
)
PRIORITY = -5  # of an emulator that is to keep up with the clock


class Emulator:
    """A process of node with one ATmega328P, which any number of boards use one after the other."""

    def __init__(self, firmware: Firmware) -> None:
        self.firmware = firmware
        words = ["node", str(HERE / "emulator.js"), str(AVR8JS), str(firmware.path)]
        self._node = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.ask(watch=firmware.levels, rounds=firmware.looked_at)

    def ask(self, **request: Any) -> dict[str, Any]:
        """Return the answer to a request."""
        assert self._node.stdin and self._node.stdout
        self._node.stdin.write(json.dumps(request) + "\n")
        self._node.stdin.flush()
        line = self._node.stdout.readline()
        assert line, "the emulator has ended; why is above"
        answer: dict[str, Any] = json.loads(line)
        return answer

    def prompt(self) -> None:
        """Let this process and that of node go before usual ones, where that is allowed.

        A real-time priority would be too much: the kernel's own worker, which carries bytes from one end of a
        pseudo-terminal to the other, is a usual process, and whoever reads waits for it.
        """
        with suppress(OSError):
            for task in (*os.listdir(f"/proc/{self._node.pid}/task"), "0"):
                os.setpriority(os.PRIO_PROCESS, int(task), PRIORITY)

    def close(self) -> None:
        """End the process."""
        self._node.stdin.close()
        self._node.wait(30)
        self._node.stdout.close()


class EmulatedBoard:
    """A board from its power-up on.  Ticks are whole numbers that do not wrap.

    `rises`, `falls`: ticks of the edges of STEP.  `steps`: tick and direction, by the level of DIR.  `ports`: tick and
    the registers PORTB, DDRB, PORTD, DDRD behind each change.  `frames`: tick at which the last byte of each frame was
    out, and the frame with its zero.  `looks`: tick of each look at the inputs that found a change, and the levels (one
    row for each input that had changed).  `rounds`: ticks of the rounds of the main loop, if they are `told`.  `lost`:
    ticks of bytes that came while it had no place for them.  `polarity` is what CONFIG said.
    """

    def __init__(self, emulator: Emulator, polarity: int = 0, *, rounds: bool = False) -> None:
        self.emulator = emulator
        self.polarity = polarity
        self.inputs = 0x3F
        self._first(emulator.ask(power=True, telling=rounds, inputs=[[n, 1, 0] for n in range(6)]))

    def _first(self, told: dict[str, Any]) -> None:
        self.rises: list[int] = []
        self.falls: list[int] = []
        self.ports: list[tuple[int, ...]] = []
        self.frames: list[tuple[int, bytes]] = []
        self.looks: list[tuple[int, int]] = []
        self.rounds: list[int] = []
        self.lost: list[int] = []
        self._taken = 0
        self._frame = bytearray()
        self._bytes: list[list[Any]] = []
        self._edges: list[list[int]] = []
        self._take(told)

    def _take(self, told: dict[str, Any]) -> dict[str, Any]:
        self.told = told  # what the last run told
        self.now: int = told["now"]
        self.overruns: int = told["overruns"]
        self.lost += told["lost"]
        self.rises += told["rises"]
        self.falls += told["falls"]
        self.ports += map(tuple, told["ports"])
        self.looks += map(tuple, told["looks"])
        self.rounds += told["rounds"]
        for tick, byte in told["sent"]:
            self._frame.append(byte)
            if not byte:
                self.frames.append((tick, bytes(self._frame)))
                self._frame.clear()
        return told

    # ------------------------------------------------------------------------------------------- what is done to it
    def run(self, tick: int, **more: Any) -> dict[str, Any]:
        """Run up to a tick, or as far beyond it as the last instruction lasts."""
        request = {"run": tick, "bytes": self._bytes, "inputs": self._edges, **more}
        told = self._take(self.emulator.ask(**request))
        self._bytes, self._edges = [], []
        return told

    def skip(self, count: int) -> None:
        """Let so many times 65,536 ticks pass at once, while nothing happens and the processor stands."""
        self._take(self.emulator.ask(skip=[count, self.emulator.firmware.overflows]))

    def receive(self, data: bytes, tick: int) -> None:
        """Put bytes on the line, from a tick on, or behind those that are on it; a byte takes 320 ticks."""
        if data:
            self._bytes.append([data.hex(), tick])

    def set_input(self, number: int, level: int, tick: int) -> None:
        """Change the level of an input at a tick that has not been run yet."""
        self._edges.append([number, int(bool(level)), tick])

    def power_up(self) -> None:
        """Reset it, as a pulled cable or an opened port does; ticks begin again, what it told is forgotten."""
        self._first(self.emulator.ask(power=True))

    def take(self) -> bytes:
        """Return the frames that it sent since the last call."""
        new = self.frames[self._taken :]
        self._taken = len(self.frames)
        return b"".join(frame for _, frame in new)

    # ----------------------------------------------------------------------------------------------- what it showed
    def _changes(self, value: Any) -> list[tuple[int, Any]]:
        out: list[tuple[int, Any]] = []
        before = value(0, 0, 0, 0)
        for tick, *registers in self.ports:
            after = value(*registers)
            if after != before:
                out.append((tick, after))
                before = after
        return out

    @property
    def phases(self) -> list[tuple[int, int]]:
        """Changes of the phases: tick and levels."""
        return self._changes(lambda portb, ddrb, portd, ddrd: (portd & ddrd) >> 4)

    @property
    def directions(self) -> list[tuple[int, int]]:
        """Changes of the level of DIR."""
        return self._changes(lambda portb, ddrb, portd, ddrd: int(bool(portb & DIR)))

    @property
    def outputs(self) -> list[tuple[int, int]]:
        """Changes of outputs, one pin at a time: tick and value, bit 4 is ENABLE."""

        def value(portb: int, ddrb: int, portd: int, ddrd: int) -> int:
            users = bool(portd & OUT0) | bool(portd & OUT1) << 1 | bool(portb & OUT2) << 2 | bool(portb & OUT3) << 3
            driven = ddrb & ENABLE
            return users | (16 if driven and bool(portb & ENABLE) != bool(self.polarity & 2) else 0)

        return self._changes(value)

    @property
    def enable(self) -> list[tuple[int, int | None]]:
        """Changes of D11: tick and level; None without one."""
        return self._changes(lambda portb, ddrb, portd, ddrd: int(bool(portb & ENABLE)) if ddrb & ENABLE else None)

    @property
    def steps(self) -> list[tuple[int, int]]:
        """Tick and direction of each rising edge."""
        ways = [(-1, 0), *self.directions]
        out, at = [], 0
        for tick in self.rises:
            while at + 1 < len(ways) and ways[at + 1][0] <= tick:
                at += 1
            up = ways[at][1] == (self.polarity & 1)
            out.append((tick, 1 if up else -1))
        return out
