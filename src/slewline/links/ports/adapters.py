"""Ports that disappear and return, as when an adapter is unplugged, to test hosts that must survive this."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..face import ServerFace
    from ..lines.served_line import HostLine


class Adapters:
    """The unplugged ports of a server, which can be plugged in again."""

    def __init__(self, server: ServerFace) -> None:
        self.server = server
        self.pulled: list[Any] = []  # closed ports, to be opened again

    def unplug(self, line: HostLine) -> None:
        """Close the ports of a line; a connected host is disconnected."""
        ports: list[Any] = [port for port in self.server.ports if getattr(port, "line", None) is line]
        for port in ports:
            port.close()
            self.server.ports.remove(port)
        self.pulled += ports

    def plug(self, line: HostLine) -> None:
        """Open the ports of a line again, at the same addresses; a host must reconnect.

        Raises:
            UsageError: another program now uses the address of a port.
        """
        for port in [port for port in self.pulled if port.line is line]:
            self.pulled.remove(port)
            self.server.ports.append(port.again())
