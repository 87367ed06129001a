"""The emulated board behind a pseudo-terminal, in real time: a process of its own, and the test's handle on it.

    with ServedBoard(firmware) as board:
        serial.Serial(board.port, 500_000) ...
        board.set_input(0, 0)
        board.steps()

As on an Uno, DTR resets it when the port is opened, unless it was closed with HUPCL cleared, for then DTR has stayed.
"""

from __future__ import annotations

import gc
import json
import os
import pty
import random
import select
import socket
import subprocess
import sys
import tempfile
import termios
import time
import tty
from pathlib import Path
from typing import Any

from .emulated import EmulatedBoard, Emulator, Firmware

HZ = 16_000_000
SLICE = 0.001  # seconds between two looks at the line
MOST = 0.005  # seconds of the board at once, if it is behind


class Server:
    """The process: what the board is connected to, and the side channel."""

    def __init__(self, firmware: Firmware, link: Path, channel: socket.socket, boot: float) -> None:
        self.link, self.channel, self.boot = link, channel, boot
        self.emulator = Emulator(firmware)
        EmulatedBoard(self.emulator).run(HZ // 4)  # node compiles what it runs often
        self.board = EmulatedBoard(self.emulator)
        self.lives: list[EmulatedBoard] = []
        self.levels = 0x3F
        self.on, self.open, self.stays = True, False, False
        self.rate, self.chance = 0.0, random.Random(0)
        self.hurries, self.lost = True, 0.0  # does it make up for time that it has lost?
        self.resets = self.dropped = 0
        self.master = -1
        self.plug()
        self._start_again()

    def plug(self) -> None:
        """Be there: a new port, and its name."""
        self.master, slave = pty.openpty()
        tty.setraw(slave)
        settings = termios.tcgetattr(slave)
        settings[2] |= termios.HUPCL  # as a serial port has it; a pseudo-terminal begins without
        termios.tcsetattr(slave, termios.TCSANOW, settings)
        os.set_blocking(self.master, False)
        name = os.ttyname(slave)
        os.close(slave)
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(name)
        self.open = self.stays = False

    def unplug(self) -> None:
        """Be gone, with the supply, which comes through the cable."""
        os.close(self.master)
        self.master = -1
        self.link.unlink(missing_ok=True)
        self.on = False

    def reset(self) -> None:
        """Power up, or let DTR reset it."""
        self.lives.append(self.board)
        self.board = EmulatedBoard(self.emulator)
        for number in range(6):
            if not self.levels >> number & 1:
                self.board.set_input(number, 0, 0)
        self.resets += 1
        self._start_again()

    def _start_again(self) -> None:
        self.began = time.monotonic() + self.boot - self.board.now / HZ

    # -------------------------------------------------------------------------------------------------------- the line
    def serve(self) -> None:
        """Go on until the side channel is closed."""
        poll = select.poll()
        poll.register(self.channel, select.POLLIN)
        pending = b""
        while True:
            if poll.poll(SLICE * 1000):
                data = self.channel.recv(65536)
                if not data:
                    break
                *lines, pending = (pending + data).split(b"\n")
                for line in lines:
                    self.channel.sendall(json.dumps(self.do(**json.loads(line))).encode() + b"\n")
            self.turn()
        self.emulator.close()

    def turn(self) -> None:
        """Let the board live up to the present."""
        data = self._from_host()
        if not self.on:
            return
        late = time.monotonic() - self.began - self.board.now / HZ - MOST
        if late > 0 and not self.hurries:
            self.began += late
            self.lost += late
        goal = int((time.monotonic() - self.began) * HZ)
        if data:
            self.board.receive(self._damaged(data), self.board.now)
        if goal > self.board.now:
            self.board.run(min(goal, self.board.now + int(MOST * HZ)))
            told = self._damaged(bytes(self._sent()))
            if told and self.open and self.master >= 0:
                try:
                    self.dropped += len(told) - os.write(self.master, told)
                except OSError:
                    self.dropped += len(told)

    def _sent(self) -> bytearray:
        out = bytearray()
        for _, byte in self.board.told["sent"]:
            out.append(byte)
        return out

    def _from_host(self) -> bytes:
        if self.master < 0:
            return b""
        try:
            data = os.read(self.master, 4096)
        except BlockingIOError:
            data = b""
        except OSError:  # nobody has it open
            if self.open:
                self.open = False
            return b""
        if not self.open:
            self.open = True
            if self.on and not self.stays:
                self.reset()
        # Whether DTR will fall when the port is closed; then the next who opens it raises it.
        self.stays = not termios.tcgetattr(self.master)[2] & termios.HUPCL
        return data if self.on else b""

    def _damaged(self, data: bytes) -> bytes:
        if not self.rate:
            return data
        return bytes(
            each ^ (1 << self.chance.randrange(8)) if self.chance.random() < self.rate else each for each in data
        )

    # ------------------------------------------------------------------------------------------------ the side channel
    def do(self, what: str, **more: Any) -> dict[str, Any]:
        """Do what a test asks for."""
        if what == "input":
            number, level = more["number"], more["level"]
            self.levels = self.levels | 1 << number if level else self.levels & ~(1 << number)
            self.board.set_input(number, level, self.board.now)
        elif what == "supply":
            if more["on"] and not self.on:
                self.reset()
            self.on = more["on"]
        elif what == "unplug":
            self.unplug()
        elif what == "plug":
            self.plug()
            self.on = True
            self.reset()
        elif what == "damage":
            self.rate, self.chance = more["rate"], random.Random(more["seed"])
        elif what == "promptly":
            self.emulator.prompt()
            self.hurries = False
            gc.disable()
        elif what == "loop":
            self.emulator.ask(loop=more["on"])
        elif what == "steps":
            lives = [*self.lives, self.board]
            return {"lives": [[life.rises, life.directions] for life in lives], "now": self.board.now}
        elif what == "shown":
            board = self.board
            board.polarity = more["polarity"]
            shown = {"phases": board.phases, "outputs": board.outputs, "enable": board.enable}
            return shown | {"rises": board.rises, "now": board.now}
        return {
            "now": self.board.now,
            "resets": self.resets,
            "lost": self.lost,
            "overruns": self.board.overruns,
            "dropped": self.dropped,
            "open": self.open,
        }


def main(words: list[str]) -> None:
    """Serve: FIRMWARE as JSON, LINK, descriptor of the side channel, seconds that the boot loader takes."""
    firmware, link, descriptor, boot = words
    path, *numbers = json.loads(firmware)
    channel = socket.socket(fileno=int(descriptor))
    Server(Firmware(Path(path), *numbers), Path(link), channel, float(boot)).serve()


class ServedBoard:
    """The test's end: a board in real time at `port`.

    `boot`: seconds between a reset and the firmware, which the boot loader of a real one takes (some 1.6).
    """

    def __init__(self, firmware: Firmware, boot: float = 0.0) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="board-")
        self.port = str(Path(self._folder.name) / "ttyUNO")
        self._channel, theirs = socket.socketpair()
        words = [json.dumps([str(firmware.path), *firmware[1:]]), self.port, str(theirs.fileno()), str(boot)]
        root = Path(__file__).resolve().parents[2]
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.firmware.served", *words], cwd=root, pass_fds=[theirs.fileno()]
        )
        theirs.close()
        self._channel.settimeout(30)
        self._lines = self._channel.makefile("rb")
        self.status()  # wait until it is there

    def _ask(self, what: str, **more: Any) -> dict[str, Any]:
        self._channel.sendall(json.dumps({"what": what, **more}).encode() + b"\n")
        line = self._lines.readline()
        assert line, "the served board has ended; why is above"
        answer: dict[str, Any] = json.loads(line)
        return answer

    def __enter__(self) -> ServedBoard:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the process."""
        self._channel.close()
        self._lines.close()
        self._process.wait(30)
        self._folder.cleanup()

    def status(self) -> dict[str, Any]:
        """Return `now` (tick), `resets`, `lost`, `overruns`, `dropped`, `open`.

        `lost`: seconds for which its time has stood (`promptly`); `dropped`: bytes that nobody could read.
        """
        return self._ask("status")

    def set_input(self, number: int, level: int) -> None:
        """Change the level of an input, now."""
        self._ask("input", number=number, level=level)

    def supply(self, on: bool) -> None:
        """Take the supply away, or give it back: a power-up."""
        self._ask("supply", on=on)

    def unplug(self) -> None:
        """Pull the cable: the port is gone, and so is the supply."""
        self._ask("unplug")

    def plug(self) -> None:
        """Put the cable back: the port is there again, under the same name."""
        self._ask("plug")

    def damage(self, rate: float, seed: int = 0) -> None:
        """From now on let this part of all bytes, both ways, lose a bit."""
        self._ask("damage", rate=rate, seed=seed)

    def promptly(self) -> None:
        """Let the emulator go before all others, where that is allowed, and let its time stand where it is held up.

        Else it hurries then, and no host could feed such a board.
        """
        self._ask("promptly")

    def loop(self, on: bool) -> None:
        """Wire STEP to the input that counts it, or not."""
        self._ask("loop", on=on)

    def lives(self) -> list[list[tuple[int, int]]]:
        """Return the steps of each life, from power-up to power-up: tick and level of DIR."""
        out = []
        for rises, directions in self._ask("steps")["lives"]:
            steps, at, level = [], 0, 0
            for tick in rises:
                while at < len(directions) and directions[at][0] <= tick:
                    level = directions[at][1]
                    at += 1
                steps.append((tick, level))
            out.append(steps)
        return out

    def steps(self) -> list[tuple[int, int]]:
        """Return the steps since the last power-up: tick and level of DIR."""
        return self.lives()[-1]

    def shown(self, polarity: int = 0) -> dict[str, Any]:
        """Return `phases`, `outputs` and `enable` (D11): tick and value of each change; `rises`: ticks of STEP."""
        return self._ask("shown", polarity=polarity)


if __name__ == "__main__":
    main(sys.argv[1:])
