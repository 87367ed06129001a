"""A branch, and the connections to its ports, which relay the bytes of hosts in both directions."""

from __future__ import annotations

import json
import socket
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from ..sockets import system
from ..sockets.stream import CHUNK, SocketStream

if TYPE_CHECKING:
    from ..lines.served_line import HostLine
    from ..sockets.loop import Loop

ANSWER_S = 1.5  # time for a branch to answer
AGAIN_S = 0.01  # delay after which a waiting host may send again


@dataclass
class Branch:
    """A run that begins at an instant of another run, or the first run itself."""

    number: int
    parent: int | None
    from_ps: int
    now_ps: int  # when it was last left
    journal: Path
    shared: int  # bytes at the start of its journal that it shares with the first run
    shared_ps: int  # the instant up to which it equals the first run
    control: str = ""
    lines: dict[str, str] = field(default_factory=dict)
    process: int = 0
    lifeline: socket.socket | None = None  # the world ends when it is closed
    rest: bytes = b""  # rest of the bytes received on the leash
    waiting: list[Callable[[], object]] = field(default_factory=list)  # queries of its time, in order
    silent: int = 0  # consecutive polls without an answer
    watched: bool = False
    touched: bool = False


class Road:
    """A relay of the bytes between a host and a line of a branch, in both directions; it starts with `open`.

    Raises:
        OSError: the branch does not answer.
    """

    def __init__(self, loop: Loop, line: HostLine, where: str, branch: Branch) -> None:
        self.loop, self.line, self.branch = loop, line, branch
        self.socket = connection(where)
        self.greeted = not getattr(line, "greeting", b"")
        self.stream = SocketStream(loop, self.socket, self._take, lambda _why: None)

    def open(self) -> None:
        """Start to relay the bytes of the host."""
        self.line.detour = self

    def room(self) -> int:
        """Return the number of bytes that the host may send now.

        If it is 0, this method also schedules a call that lets the line continue to read a little later.
        """
        room = self.stream.queue - len(self.stream.outgoing)
        if room <= 0:
            self.loop.after(AGAIN_S, lambda: self.line.resume() if self.line.resume is not None else None)
        return room

    def send(self, data: bytes) -> None:
        """Send bytes from the host to the branch."""
        self.branch.touched = True
        self.stream.write(data)

    def _take(self, data: bytes) -> None:
        if not self.greeted:  # the host has already received its greeting
            _, end, data = data.partition(b"\n")
            self.greeted = bool(end)
        if data and self.line.host is not None:
            self.line.given += len(data)
            self.line.host(data)

    def close(self) -> None:
        """Close the connection; the host still receives the output of the branch so far."""
        if self.line.detour is self:
            self.line.detour = None
            with suppress(OSError):
                while data := self.socket.recv(CHUNK):
                    self._take(data)
        self.stream.close()
        self.socket.close()


def rebuilt(loop: Loop, lines: Sequence[HostLine], branch: Branch, before: Sequence[Road]) -> list[Road]:
    """Relay the hosts' bytes to `branch` instead of the former branch; return the new relays.

    For the first run, the list is empty.

    Raises:
        OSError: the branch cannot be reached; the former relays still work.
    """
    roads: list[Road] = []
    try:
        for line in lines:
            if branch.number:
                roads.append(Road(loop, line, branch.lines[line.name], branch))
    except OSError:
        for road in roads:
            road.close()
        raise
    for road in before:
        road.close()
    for road in roads:
        road.open()
    for line in lines:
        if line.resume is not None:
            line.resume()  # the room has changed
    return roads


def connection(path: str) -> socket.socket:
    """Return a connection to a branch's port, the socket at `path` in a private folder of this user."""
    found = socket.socket(system.UNIX)
    try:
        found.settimeout(ANSWER_S)
        found.connect(path)
    except OSError:
        found.close()
        raise
    return found


def greeting(token: str | None) -> bytes:
    """Return the first request to a control port, which contains the token if there is one."""
    return json.dumps({"do": "read", "pins": []} | ({} if token is None else {"token": token})).encode() + b"\n"
