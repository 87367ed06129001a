"""Where a program finds a module of a test: in its own process by a URL, or behind a port of the machine.

A module behind a port is served by a thread of the test process, in lockstep: virtual time passes as far as the bytes
of the line need it, and when the test says so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import count
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from threading import Event, Thread
from typing import Any

from ..core.net import Net
from ..errors import SlewlineError, UsageError
from ..links.pace import Lockstep, Pace, Paced, Wait
from ..links.server import Server
from .controller import Controller
from .rig import NAMED, SCHEME, Result, Rig

NUMBERS = count(1)
PATIENCE_S = 60.0  # of the wall clock: a server that does not answer for so long is broken


class Named(Rig):
    """A module that programs of this process find by its URL."""

    def __init__(self, part: str, **settings: Any) -> None:
        super().__init__(part, **settings)
        self.key = f"{self.chip.name}_{next(NUMBERS)}"
        self.url = f"{SCHEME}://{part}?name={self.key}"
        NAMED[self.key] = self

    def close(self) -> None:
        """End the module; its name is free again."""
        del NAMED[self.key]
        super().close()


class Served(Rig):
    """A module behind a port.

    Args:
        on: "tcp", "pty" or "rfc2217".
    """

    def __init__(self, part: str, on: str, **settings: Any) -> None:
        super().__init__(part, **settings)
        self.server = Server(self.bench, self.pace)
        self.server.lines[self.line.name] = self.line
        self.folder = mkdtemp(prefix="slewline-")
        where = str(Path(self.folder, self.chip.name)) if on == "pty" else "127.0.0.1:0"
        self.url = getattr(self.server, on)(self.line, where).where
        self.thread = Thread(target=self.server.run, name=f"slewline {self.url}", daemon=True)

    def begin(self) -> None:
        """Start the server, in a thread of its own."""
        self.thread.start()

    def pace_of(self, rate: str | float | None) -> Pace:
        """Return how virtual time passes: only while somebody waits (None), or by the wall clock at a rate."""
        return Lockstep(self.bench) if rate is None else Paced(self.bench, rate)

    def do(self, action: Callable[[], Result]) -> Result:
        """Call a function in the thread of the server and return what it returns.

        Raises:
            SlewlineError: the server has ended.
        """
        if not self.thread.is_alive():
            raise SlewlineError(f"{self.url}: the server has ended")
        return self.server.call(action, PATIENCE_S)  # type: ignore[no-any-return]

    def wait(
        self, met: Callable[[], bool], ps: int, when: Callable[[], int | None] | None = None, nets: Iterable[Net] = ()
    ) -> bool:
        """Let time pass until a condition is met, or for so many ps; return whether it was met."""
        over, found = Event(), []

        def done(was_met: bool) -> None:
            found.append(was_met)
            over.set()

        self.do(lambda: self.pace.wait(Wait(met, self.bench.now_ps + ps, done, when, nets)))
        while not over.wait(PATIENCE_S):
            self.do(lambda: None)  # raises if nobody is there
        return found[0]

    def close(self) -> None:
        """End the server."""
        self.server.stop()
        self.thread.join(PATIENCE_S)
        rmtree(self.folder)
        super().close()


FACES = ("url", "tcp", "pty", "rfc2217")


def running(part: str, on: str = "url", seed: int = 0, **settings: Any) -> Controller:
    """Return a running module.

    Args:
        part: its number, such as "gs-c200s".
        on: where a program finds it: "url", "tcp", "pty", "rfc2217".
        seed: of everything that is random, such as a garbled character.
        settings: straps, rate, store, and options of the part.

    Raises:
        UsageError: none of these faces, or a setting that is not allowed.
        UnknownName: no such part.
    """
    if on not in FACES:
        raise UsageError(f"on {on!r}; allowed {', '.join(FACES)}")
    rig = Named(part, seed=seed, **settings) if on == "url" else Served(part, on, seed=seed, **settings)
    controller = Controller(rig, f"{part} on {on}", seed)
    rig.begin()
    return controller
