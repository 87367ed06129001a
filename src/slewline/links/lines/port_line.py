"""The interface between ports and a line: bytes in, bytes out, one host at a time.

The line ends in modules on a bench (`HostLine`), or in a module on a real cable
(`modules/recording_proxy.py`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from ...core.wires.serial import LineSetting
from ..sockets.preamble import Greetings


class AnyLine(Protocol):
    """A line that any kind of port can use."""

    @property
    def baud(self) -> int | str | None:
        """Rate of the line, baud; None if the line has no rate."""

    def attach(self, name: str, host: Callable[[bytes], int], resume: Callable[[], object]) -> None:
        """Connect a host.

        Args:
            name: the name of the host.
            host: a function that sends bytes to the host, and returns the number of bytes dropped.
            resume: a function that makes the port continue to read bytes from the host.
        """

    def leave(self, why: str) -> None:
        """Disconnect a host that has left; `why` is the reason."""

    def take(self, data: bytes) -> None:
        """Receive bytes from the host."""

    def room(self) -> int:
        """Return the number of bytes that may arrive now; at 0, `resume` is called once there is room again."""


class CableLine(AnyLine, Protocol):
    """A line that a serial port of this machine can use."""

    @property
    def setting(self) -> LineSetting:
        """Rate and format of the line."""


class PortLine(AnyLine, Protocol):
    """A line for a port that host programs open, such as a TCP port or a pseudo-terminal."""

    @property
    def name(self) -> str:
        """Name of the line in messages."""

    @property
    def greetings(self) -> Greetings:
        """First bytes of foreign protocols; a connection that begins with them is closed."""

    @property
    def share(self) -> int:
        """Maximum number of bytes read from a host per turn of the loop."""

    def obey(self, on: bool) -> None:
        """Select whether characters to the chip wait for its CTS; this has no effect if the chip has no CTS."""

    def opened_at(self, baud: int) -> None:
        """Record the rate (baud) that a host has set on its port."""

    def event(self, text: str) -> None:
        """Record an event on the line."""

    def sent(self) -> bool:
        """Return whether all bytes received from the host have been sent on, so that another host may begin."""

    def when_sent(self, call: Callable[[], object]) -> None:
        """Call a function when all bytes received from the host have been sent on."""

    def when_answered(self, call: Callable[[], object]) -> None:
        """Call a function when all bytes received from the host have been answered, or after a timeout."""
