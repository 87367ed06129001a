"""TCP: a raw socket for each line, socket://HOST:PORT for pySerial.

One host owns a port at a time.  The next one gets a line of text that says so and is hung up on.  A host that has
vanished without a word (a cable pulled, a machine switched off) is found out by keepalive probes after some 25 s.  One
that says no more (`printf 'V1\\r' | nc -N`) gets the answers to what it has said, and keeps nobody else out meanwhile.
"""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Callable
from contextlib import suppress

from ..errors import UsageError
from .line import Line
from .loop import Loop
from .stream import Stream

KEEPALIVE = (("TCP_KEEPIDLE", 10), ("TCP_KEEPINTVL", 5), ("TCP_KEEPCNT", 3), ("TCP_USER_TIMEOUT", 25_000))
RETRY_S = 0.5  # when the system cannot accept a connection
FAREWELL_S = 1.0  # how long a host that was refused may take to read why


def parse_address(text: str, allow_remote: bool = False) -> tuple[str, int]:
    """ "HOST:PORT" as a pair; port 0 stands for any free one.

    Raises:
        UsageError: not of this form, or reachable from other machines without `allow_remote`.
    """
    host, colon, port = text.rpartition(":")
    host = host.strip("[]")
    if not colon or not host or not port.isdecimal() or int(port) > 65535:
        raise UsageError(f"address {text!r}; expected HOST:PORT, such as 127.0.0.1:4001 (port 0: any free one)")
    if not allow_remote and not is_loopback(host):
        resolved(host, text)
        raise UsageError(f"address {text!r}: other machines could reach it; add --allow-remote if they may")
    return host, int(port)


def is_loopback(host: str) -> bool:
    """Is it this machine, seen from inside?"""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def resolved(host: str, address: str) -> int:
    """The family of addresses to which a name belongs."""
    try:
        return socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)[0][0]
    except (OSError, UnicodeError):
        raise UsageError(f"address {address!r}: the name {host!r} cannot be resolved; give this machine's") from None


class Listener:
    """A socket that listens; `accept` is called with each connection and the name of the other side."""

    def __init__(
        self, loop: Loop, address: str, accept: Callable[[socket.socket, str], object], allow_remote: bool = False
    ) -> None:
        self.loop, self.accept = loop, accept
        host, port = parse_address(address, allow_remote)
        family = resolved(host, address)
        try:
            self.socket = socket.create_server((host, port), family=family)
        except OSError as error:
            raise UsageError(f"address {address!r}: {error.strerror or error}; choose another one") from None
        self.socket.setblocking(False)
        self._listen()

    def _listen(self) -> None:
        if self.socket.fileno() >= 0:
            self.loop.watch(self.socket.fileno(), self._accept)

    @property
    def where(self) -> str:
        """HOST:PORT as it is."""
        host, port = self.socket.getsockname()[:2]
        return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"

    def _accept(self) -> None:
        try:
            connection, peer = self.socket.accept()
        except (BlockingIOError, ConnectionError):  # it has gone already
            return
        except OSError:  # no descriptors left, for example: others may close theirs
            self.loop.watch(self.socket.fileno())
            self.loop.after(RETRY_S, self._listen)
            return
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in KEEPALIVE:
            if hasattr(socket, name):
                connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
        self.accept(connection, f"{peer[0]}:{peer[1]}")

    def close(self) -> None:
        """Listen no more."""
        self.loop.watch(self.socket.fileno())
        self.socket.close()


def dismiss(loop: Loop, connection: socket.socket, why: str) -> None:
    """Say a line, and hang up when it has been read, or after a second."""

    def end(_reason: str = "") -> None:
        stream.close()
        connection.close()

    stream = Stream(loop, connection.fileno(), lambda _data: None, end)
    with suppress(OSError):
        connection.send(f"slewline: {why}\r\n".encode("ascii", "replace"))
        connection.shutdown(socket.SHUT_WR)
    loop.after(FAREWELL_S, end)


class Session:
    """A host on a socket: bytes as they are."""

    def __init__(self, port: TcpPort, connection: socket.socket, name: str) -> None:
        self.port, self.line, self.connection = port, port.line, connection
        self.stream = Stream(port.loop, connection.fileno(), self.take, self.gone, self.room, ended=self.ended)
        self.line.attach(name, self.give, self.stream.resume)

    def take(self, data: bytes) -> None:
        """From the host."""
        self.line.take(data)

    def room(self) -> int:
        """How many bytes may come from the host now."""
        return self.line.room()

    def give(self, data: bytes) -> int:
        """To the host; returns how many bytes were dropped."""
        return self.stream.write(data)

    def ended(self) -> None:
        """The host says no more."""
        self.line.when_answered(self.stream.finish)

    def gone(self, why: str) -> None:
        """The host has gone; the next one may come."""
        self.stream.close()
        self.connection.close()
        self.port.session = None
        self.line.detach(why)


class TcpPort:
    """A line on a TCP port."""

    scheme = "socket"
    make = Session

    def __init__(self, loop: Loop, line: Line, address: str, allow_remote: bool = False) -> None:
        self.loop, self.line = loop, line
        self.session: Session | None = None
        self.listener = Listener(loop, address, self._accept, allow_remote)

    @property
    def where(self) -> str:
        """The URL of the port, as pySerial writes it."""
        return f"{self.scheme}://{self.listener.where}"

    def _accept(self, connection: socket.socket, name: str) -> None:
        if self.session is not None and self.session.stream.at_end:
            self.session.gone("hung up")
        if self.session is None:
            self.session = self.make(self, connection, name)
        else:
            self.line.log.event(self.line.name, f"{name} was refused: {self.line.host_name} is connected")
            dismiss(self.loop, connection, f"{self.line.host_name} has this port; one host at a time")

    def close(self) -> None:
        """Hang up, and listen no more."""
        self.listener.close()
        if self.session is not None:
            self.session.gone("the server has ended")
