"""The interfaces of a module in a test: in the same process (a URL or a host), or a port of this machine.

A module on a port is served by a thread of the test process, in lockstep: virtual time passes only as
far as the bytes on the line need it, or when the test lets it pass.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from itertools import count
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from threading import Event, Thread
from typing import Any

from ..bench.runner import Wait
from ..chips import sheet_of
from ..core.chip import Chip
from ..core.datasheet.channel import Channel
from ..core.datasheet.table import Sheet
from ..core.messages.near import hint
from ..core.motion.motions import MotionEnd, MotionStart
from ..core.wires.net import Net
from ..errors import SlewlineError, UsageError
from ..links.lines.pace import Lockstep, Pace, Paced
from ..links.server import Server
from ..parts.hosts.host import Host
from .controller import Controller
from .rig import CLOSED, ENDED, NAMED, SCHEME, Result, Rig, serial_line

NUMBERS = count(1)
SERVER_TIMEOUT_S = 60.0  # of the wall clock: a server without an answer for this long is broken


class UrlEndpoint(Rig):
    """A module whose URL is opened by programs in this process."""

    def __init__(self, part: str | type[Chip], **settings: Any) -> None:
        super().__init__(part, **settings)
        self.key = f"{self.chip.name}_{next(NUMBERS)}"
        self.url = f"{SCHEME}://{self.part}?name={self.key}"
        NAMED[self.key] = self

    def close(self) -> None:
        """Shut down the module; a program that has its port open gets the error for a port that has gone."""
        if self.key not in ENDED:
            ENDED.add(self.key)
            NAMED.pop(self.key, None)
            self.do(lambda: self.unplug(CLOSED))
            super().close()


class BusEndpoint(Rig):
    """A module without a serial line, with a host computer on its bus for use by the test."""

    host: Host  # type: ignore[assignment]  # of whatever its channel has

    def channel_of(self, sheet: Sheet) -> Channel:
        """Return the first channel of the part."""
        return next(iter(sheet.channels))

    def reach(self) -> None:
        """Put the host on the bench."""
        self.host = self.bench.host(self.chip, name="host", over=self.channel.name)
        self.host.on_event.add(lambda text: self.log.event(self.host.name, text))
        self.url = ""
        for number in range(1, self.chip.sheet.axes + 1):
            axis = self.chip.axis(number)
            axis.on_motion_begin.add(partial(self._report, axis.name, "moves from"))
            axis.on_motion_end.add(partial(self._report, axis.name, "is at rest at"))

    def _report(self, name: str, verb: str, motion: MotionStart | MotionEnd) -> None:
        self.log.event(name, f"{verb} {motion.position}")

    def quiet(self) -> bool:
        """Return whether the host has nothing more to send."""
        return self.host.idle


class PortEndpoint(Rig):
    """A module on a port of this machine.

    Args:
        on: "tcp", "pty" or "rfc2217".
        framing: for a chip on a bus: True if the program and the chip exchange lines of text with read-back,
            False if the program exchanges characters with a UART next to the chip.
    """

    def __init__(self, part: str | type[Chip], on: str, framing: bool = False, **settings: Any) -> None:
        self.on, self.framing = on, framing
        super().__init__(part, **settings)
        self.thread = Thread(target=self.server.run, name=f"slewline {self.url}", daemon=True)

    ended = False

    def channel_of(self, sheet: Sheet) -> Channel:
        """Return the serial line of the part, or else its first channel."""
        return serial_line(sheet) or next(iter(sheet.channels))

    def reach(self) -> None:
        """Put the connector on the bench, and open the port."""
        self.server = Server(self.bench, self.pace)
        if self.channel is serial_line(self.chip.sheet):
            super().reach()
            self.server.lines[self.line.name] = self.line
        else:
            self.log = self.server.log
            self.line = self.server.line(self.chip, framing=self.framing)  # type: ignore[assignment]
        self.folder = mkdtemp(prefix="slewline-")
        where = str(Path(self.folder, self.chip.name)) if self.on == "pty" else "127.0.0.1:0"
        try:
            self.url = getattr(self.server, self.on)(self.line, where).where
        except BaseException:
            self.server.close()
            rmtree(self.folder)
            raise

    def unplug(self, why: str) -> None:
        """Close the port in the next iteration of the server's loop."""
        self.server.loop.ask(lambda: self.server.adapters.unplug(self.line))

    def plug(self) -> None:
        """Open the port again at the same address, in the next iteration of the server's loop."""
        self.server.loop.ask(lambda: self.server.adapters.plug(self.line))

    def begin(self) -> None:
        """Start the server in its own thread."""
        self.thread.start()

    def pace_of(self, rate: str | float | None) -> Pace:
        """Return the pacing of virtual time: lockstep if `rate` is None, else by the wall clock.

        In lockstep, virtual time passes only while the program or the test waits.
        """
        return Lockstep(self.bench) if rate is None else Paced(self.bench, rate)

    def do(self, action: Callable[[], Result]) -> Result:
        """Call a function in the thread of the server and return its result; after `close`, in the current thread.

        Raises:
            SlewlineError: the server has ended unexpectedly.
        """
        if self.ended:
            return action()
        if not self.thread.is_alive():
            raise SlewlineError(f"{self.url}: the server of the module has ended unexpectedly")
        return self.server.call(action, SERVER_TIMEOUT_S)  # type: ignore[no-any-return]

    def wait(
        self, met: Callable[[], bool], ps: int, when: Callable[[], int | None] | None = None, nets: Iterable[Net] = ()
    ) -> bool:
        """Let time pass until a condition is met, for at most `ps` of virtual time; return whether it was met.

        Raises:
            SlewlineError: the server has ended.
        """
        if self.ended:
            raise SlewlineError(f"{self.url}: {CLOSED}")
        over, found = Event(), []

        def done(was_met: bool) -> None:
            found.append(was_met)
            over.set()

        self.do(lambda: self.pace.wait(Wait(met, self.bench.now_ps + ps, done, when, nets)))
        while not over.wait(SERVER_TIMEOUT_S):
            self.do(lambda: None)  # raises if the server has ended
        return found[0]

    def close(self) -> None:
        """Stop the server and shut down the module; a second call does nothing."""
        if not self.ended:
            self.ended = True
            self.server.stop()
            self.thread.join(SERVER_TIMEOUT_S)
            rmtree(self.folder)
            super().close()


FACES = ("url", "host", "tcp", "pty", "rfc2217")


def running(part: str | type[Chip], on: str | None = None, seed: int = 0, **settings: Any) -> Controller:
    """Return a running module: `slewline.testing.running` describes the arguments."""
    if on is None:
        on = "url" if serial_line(sheet_of(part)) is not None else "host"
    if on not in FACES:
        raise UsageError(f"on={on!r}; allowed {', '.join(FACES)}{hint(on, FACES)}")
    kinds: dict[str, Callable[..., Rig]] = {"url": UrlEndpoint, "host": BusEndpoint}
    rig = kinds.get(on, partial(PortEndpoint, on=on))(part, seed=seed, **settings)
    controller = Controller(rig, f"{rig.part} on {on}", seed)
    rig.begin()
    return controller
