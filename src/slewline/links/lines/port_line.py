"""What ports need of a line: bytes in, bytes out, one host at a time.

The line ends in modules of a bench (`HostLine`), or in a module at the end of a cable (`modules/recording_proxy.py`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from ...core.wires.serial import LineSetting
from ..sockets.preamble import Greetings


class AnyLine(Protocol):
    """A line behind any port."""

    @property
    def baud(self) -> int | str | None:
        """Its rate, where it has one."""

    def attach(self, name: str, host: Callable[[bytes], int], resume: Callable[[], object]) -> None:
        """Connect a host: `host` takes bytes, returns how many it dropped; `resume` is called when more may come."""

    def leave(self, why: str) -> None:
        """Disconnect a host that has gone."""

    def take(self, data: bytes) -> None:
        """Bytes have come from the host."""

    def room(self) -> int:
        """Return how many bytes may come now; when none may, `resume` is called once there is room again."""


class CableLine(AnyLine, Protocol):
    """A line behind a serial port of this machine."""

    @property
    def setting(self) -> LineSetting:
        """Rate and format."""


class PortLine(AnyLine, Protocol):
    """A line behind a port that host programs open."""

    @property
    def name(self) -> str:
        """What messages call it."""

    @property
    def greetings(self) -> Greetings:
        """How strangers begin, whose connection is closed."""

    @property
    def share(self) -> int:
        """Bytes that are taken from a host in a turn of the loop."""

    def obey(self, on: bool) -> None:
        """Let characters wait for CTS, where there is one, or not."""

    def opened_at(self, baud: int) -> None:
        """Take notice of the rate that a host has set."""

    def event(self, text: str) -> None:
        """Note an event on the line."""

    def sent(self) -> bool:
        """Return whether everything that has come has gone out, so that another host may begin."""

    def when_sent(self, call: Callable[[], object]) -> None:
        """Call a function when everything that has come has gone out."""

    def when_answered(self, call: Callable[[], object]) -> None:
        """Call a function when what has come is answered, or is not for a long time."""
