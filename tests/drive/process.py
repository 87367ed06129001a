"""`slewline drive` and `slewline serve` as processes: what they say, what is typed, signals, and a host."""

from __future__ import annotations

import os
import pty
import re
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import serial

from ..links.conftest import PATIENCE

ROOT = Path(__file__).resolve().parents[2]
NUMBER = r"(-?\d+)"


class Slewline:
    """The command line as a process.

    Args:
        words: of the command line.
        folder: in which it runs, and where it keeps what programs remember.
        typed: its standard input is a terminal.
        program: what is called instead of the module, with the words.
    """

    def __init__(
        self, *words: str, folder: Path, typed: bool = False, program: tuple[str, ...] = ("slewline",)
    ) -> None:
        environment = {
            **os.environ,
            "PYTHONPATH": f"{ROOT / 'src'}{os.pathsep}{ROOT}",
            "XDG_STATE_HOME": str(folder / "state"),
        }
        environment |= {"PYTHONUNBUFFERED": "1", "NO_COLOR": "1"}
        self.terminal, theirs = pty.openpty() if typed else (-1, subprocess.DEVNULL)
        self.process = subprocess.Popen(
            [sys.executable, "-m", *program, *words],
            cwd=folder,
            env=environment,
            stdin=theirs,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        if typed:
            os.close(theirs)
        self.said: list[str] = []
        self._more = threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            with self._more:
                self.said.append(line.decode().rstrip("\r\n"))
                self._more.notify_all()
        with self._more:
            self._more.notify_all()

    def __enter__(self) -> Slewline:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()

    @property
    def text(self) -> str:
        """All that it has said."""
        return "\n".join(self.said)

    def hears(self, pattern: str, seconds: float = PATIENCE, since: int = 0) -> re.Match[str]:
        """Return the first match in what it has said since a line; wait for it."""
        limit = time.monotonic() + seconds
        with self._more:
            while True:
                for line in self.said[since:]:
                    if found := re.search(pattern, line):
                        return found
                left = limit - time.monotonic()
                assert left > 0, f"no {pattern!r} in:\n{self.text}"
                if not self._reader.is_alive():
                    raise AssertionError(f"it has ended without {pattern!r}:\n{self.text}")
                self._more.wait(min(left, 0.2))

    def ready(self) -> str:
        """Wait until it serves and drives; return the address of its port."""
        where = self.hears(r": (socket://\S+)")[1]
        if "drive" in self.process.args:  # type: ignore[operator]
            self.hears(", horizon ")
        return where

    def status(self) -> str:
        """Ask for a status line, and return it."""
        since = len(self.said)
        self.process.send_signal(signal.SIGUSR1)
        return self.hears(r"^.* s \| .*\| board .*$", since=since)[0]

    def count(self) -> int:
        """The count of the board, as the status line has it."""
        found = re.search(rf"\| board \w+ at {NUMBER}", self.status())
        assert found, self.text
        return int(found[1])

    def stands(self, seconds: float = PATIENCE) -> int:
        """Wait until the board counts no more steps; return its count."""
        limit = time.monotonic() + seconds
        before = self.count()
        while True:
            time.sleep(0.3)
            if (count := self.count()) == before:
                return count
            assert time.monotonic() < limit, self.text
            before = count

    def clear(self, seconds: float = PATIENCE) -> None:
        """Let a drive that is halted go on; the chip must be at rest for that."""
        limit = time.monotonic() + seconds
        while True:
            since = len(self.said)
            self.process.send_signal(signal.SIGUSR2)
            if "continues" in self.hears("the drive continues|in motion|is not halted", since=since)[0]:
                return
            assert time.monotonic() < limit, self.text
            time.sleep(0.1)

    def type(self, line: str) -> None:
        """Type a line on its terminal."""
        os.write(self.terminal, line.encode() + b"\n")

    def signal(self, number: int) -> None:
        """Send it a signal."""
        self.process.send_signal(number)

    def end(self, seconds: float = PATIENCE) -> int:
        """Let it end in good order; return its exit status."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        return self.ended(seconds)

    def ended(self, seconds: float = PATIENCE) -> int:
        """Wait until it has ended by itself; return its exit status."""
        status = self.process.wait(seconds)
        self._reader.join(PATIENCE)
        self._close()
        return status

    def kill(self) -> None:
        """Kill it, as it stands."""
        self.process.kill()
        self.process.wait(PATIENCE)
        self._reader.join(PATIENCE)
        self._close()

    def _close(self) -> None:
        if self.process.stdout is not None and not self._reader.is_alive():
            self.process.stdout.close()
        if self.terminal >= 0:
            with suppress(OSError):
                os.close(self.terminal)
            self.terminal = -1


class ModuleHost:
    """What a host program of a GS-C200S does: lines that end with a carriage return, and an answer to each."""

    def __init__(self, where: str, timeout: float = PATIENCE) -> None:
        self.line = serial.serial_for_url(where, timeout=timeout)
        self.transcript: list[tuple[str, str]] = []

    def __enter__(self) -> ModuleHost:
        return self

    def __exit__(self, *_: object) -> None:
        self.line.close()

    def ask(self, text: str) -> str:
        """Send a line, and return the answer."""
        self.line.write(text.encode() + b"\r")
        answer = self.line.read_until(b"\r").decode("ascii", "replace").strip()
        self.transcript.append((text, answer))
        return answer

    def tell(self, *lines: str) -> None:
        """Send lines that are accepted."""
        for text in lines:
            assert (answer := self.ask(text)) == "Y", f"{text}: {answer!r}, of {self.transcript}"

    def until_ready(self, seconds: float = PATIENCE) -> None:
        """Ask until the module is ready; only the last answer is kept in the transcript."""
        limit = time.monotonic() + seconds
        while (answer := self.ask("F")) != "R":
            assert answer == "B", self.transcript
            del self.transcript[-1]
            assert time.monotonic() < limit
            time.sleep(0.05)

    def position(self) -> int:
        """Return the position of the module."""
        return int(self.ask("V1").lstrip("V"))

    def program(self, *lines: str) -> None:
        """Enter a program, and run it."""
        self.tell("Po", *lines, "E")
