"""Ports that vanish and come back, as that of an adapter which is unplugged: for hosts that have to survive it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..face import ServerFace
    from ..lines.served_line import HostLine


class Adapters:
    """The ports of a server that are unplugged at present."""

    def __init__(self, server: ServerFace) -> None:
        self.server = server
        self.pulled: list[Any] = []  # closed, and to be opened again

    def unplug(self, line: HostLine) -> None:
        """Close the ports of a line; a host that is connected finds that out."""
        ports: list[Any] = [port for port in self.server.ports if getattr(port, "line", None) is line]
        for port in ports:
            port.close()
            self.server.ports.remove(port)
        self.pulled += ports

    def plug(self, line: HostLine) -> None:
        """Open them again, where they were; a host must connect again.

        Raises:
            UsageError: another program has taken the place of one meanwhile.
        """
        for port in [port for port in self.pulled if port.line is line]:
            self.pulled.remove(port)
            self.server.ports.append(port.again())
