"""The ways to the world of a branch: connections to its ports, on which bytes of hosts go there and back."""

from __future__ import annotations

import json
import socket
from typing import TYPE_CHECKING

from ..ports.tcp import parse_address
from ..sockets.stream import SocketStream

if TYPE_CHECKING:
    from ..lines.line import HostLine
    from ..sockets.loop import Loop
    from .branches import Branch


class Road:
    """The way of a host's bytes to the line of a world, and back."""

    def __init__(self, loop: Loop, line: HostLine, where: str, branch: Branch) -> None:
        self.line, self.branch = line, branch
        self.socket = connection(where)
        self.greeted = not getattr(line, "greeting", b"")
        self.stream = SocketStream(loop, self.socket, self._take, lambda _why: None)
        line.detour = self._send

    def _send(self, data: bytes) -> None:
        self.branch.touched = True
        self.stream.write(data)

    def _take(self, data: bytes) -> None:
        if not self.greeted:  # the host has had its greeting
            _, end, data = data.partition(b"\n")
            self.greeted = bool(end)
        if data and self.line.host is not None:
            self.line.given += len(data)
            self.line.host(data)

    def close(self) -> None:
        """Hang up."""
        self.line.detour = None
        self.stream.close()
        self.socket.close()


def connection(where: str) -> socket.socket:
    """Return a connection to a port of this machine."""
    found = socket.create_connection(parse_address(where), timeout=5)
    found.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return found


def greeting(token: str | None) -> bytes:
    """Return the first request to a control port."""
    return json.dumps({"do": "read", "pins": []} | ({} if token is None else {"token": token})).encode() + b"\n"
