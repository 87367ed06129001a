r"""TCP: a raw socket for each line, which pySerial opens as socket://HOST:PORT.

A port behaves like a line: hosts take turns, and one owns the port at a time.

    a host closes              all its bytes still go to the line, whether it has read its answers or not
    the next host connects     at any later time: its bytes follow; it receives all answers from then on
    a host connects too early  it receives a line of text naming the present host, and is disconnected

A host that closes its sending side (`printf 'V1\r' | nc -N`) receives the answers to its bytes, unless
another host connects.  A host that disappears (a cable unplugged, a machine switched off) is detected by
keepalive probes.

The next host does not wait long: of the bytes still to be sent to the chip when it connects, at most
`REMAINS` are kept, up to the end of a line; the rest is dropped, and reported.  Until the server
has read the last byte of a host, it cannot detect that the host has closed; so when another host
connects, the bytes of the first one are read ahead.  If more than `AHEAD` are waiting, the first host is
disconnected, whether it has closed or not.
"""

from __future__ import annotations

import socket
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Self

from ...closing import Closing
from ...errors import UsageError
from ..lines.port_line import PortLine
from ..sockets import system
from ..sockets.address import parse_address, resolved
from ..sockets.loop import Loop
from ..sockets.preamble import HOLD_S, Preamble
from ..sockets.stream import CHUNK, QUEUE, SocketStream

KEEPALIVE = (("TCP_KEEPIDLE", 10), ("TCP_KEEPINTVL", 5), ("TCP_KEEPCNT", 3), ("TCP_USER_TIMEOUT", 25_000))
LOCAL = "a socket of this user"  # address of a Unix socket, and name for its client
RETRY_S = 0.5  # when the system cannot accept a connection
# Acknowledge immediately: a host that writes in small pieces, as most do, otherwise waits 40 ms before the next one.
QUICK: int | None = getattr(socket, "TCP_QUICKACK", None)
REFUSAL_S = 1.0  # time for a refused host to read the reason
REMAINS = 8192  # bytes of former hosts that the next one has to wait for: ten seconds at 9600 baud
AHEAD = 1 << 20  # bytes read ahead to detect the closing of a host; at 9600 baud they would take 18 minutes
LEFT = 64  # bytes counted for a former host, in addition to its remaining bytes


class Listener:
    """A listening socket; `accept` is called with each connection and the address of its client."""

    def __init__(
        self,
        loop: Loop,
        address: str | Path,
        accept: Callable[[socket.socket, str], object],
        allow_remote: bool = False,
    ) -> None:
        self.loop, self.accept = loop, accept
        try:
            if isinstance(address, Path):
                self.socket = socket.socket(system.UNIX)
                self.socket.bind(str(address))
                self.socket.listen()
            else:
                host, port = parse_address(address, allow_remote)
                self.socket = socket.create_server((host, port), family=resolved(host, address))
        except OSError as error:
            raise UsageError(f"address {address!r}: {error.strerror or error}; choose another address") from None
        self.socket.setblocking(False)
        self.listen()

    def listen(self) -> None:
        """Accept connections."""
        if self.socket.fileno() >= 0:
            self.loop.watch(self.socket.fileno(), self._accept)

    def pause(self) -> None:
        """Leave new connections waiting in the system's queue."""
        self.loop.watch(self.socket.fileno())

    @property
    def where(self) -> str:
        """Actual address of the socket, HOST:PORT; for a Unix socket, a description instead."""
        if not isinstance(self.socket.getsockname(), tuple):
            return LOCAL
        host, port = self.socket.getsockname()[:2]
        return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"

    def _accept(self) -> None:
        try:
            connection, peer = self.socket.accept()
        except (BlockingIOError, ConnectionError):  # the client has left already
            return
        except OSError:  # for example, no descriptors are left: others may close theirs
            self.pause()
            self.loop.after(RETRY_S, self.listen)
            return
        if not isinstance(peer, tuple):
            self.accept(connection, LOCAL)
            return
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in KEEPALIVE:
            if hasattr(socket, name):
                connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
        self.accept(connection, f"{peer[0]}:{peer[1]}")

    def close(self) -> None:
        """Stop listening."""
        self.pause()
        self.socket.close()


def dismiss(loop: Loop, connection: socket.socket, why: str) -> None:
    """Send a client the reason for its dismissal, as a line, and close the connection.

    The connection is closed when the client closes it, or after `REFUSAL_S` seconds.
    """

    def end(_reason: str = "") -> None:
        stream.close()
        connection.close()

    stream = SocketStream(loop, connection, lambda _data: None, end)
    with suppress(OSError):
        connection.send(f"slewline: {why}\r\n".encode("ascii", "replace"))
        connection.shutdown(socket.SHUT_WR)
    loop.after(REFUSAL_S, end)


class Session:
    """A host on a socket; its bytes are passed on unmodified."""

    def __init__(self, port: TcpPort, connection: socket.socket, name: str) -> None:
        self.port, self.line, self.connection, self.name = port, port.line, connection, name
        self.beginning = Preamble(self.line.greetings)
        self.characters = bytearray()  # received bytes that wait for their turn on the line
        self.attached = self.begun = self.answering = False
        self.stream = SocketStream(port.loop, connection, self.take, self.gone, self.room, ended=self.ended)
        self.arrive()

    def arrive(self) -> None:
        """Connect the host, which then receives the output of the module."""
        self.attach()

    def attach(self) -> None:
        """Start receiving the output of the line."""
        self.attached = True
        self.line.attach(self.name, self.give, self.port.resume)

    def begin(self) -> None:
        """Begin the turn of this host: from now on, its bytes go to the line."""
        self.begun = True

    def end(self) -> None:
        """End the turn: the host has left, and all of its bytes are on the line."""

    # --------------------------------------------------------------------------------------------------- to the line
    def room(self) -> int:
        """Return the number of bytes that may arrive from the host now."""
        return min(self.line.share, CHUNK - len(self.characters) - len(self.beginning.pending))

    def take(self, data: bytes) -> None:
        """Receive bytes from the host."""
        self.port.loop.dirty.append(self._acknowledge)
        passed = self.beginning.take(data)
        if self.beginning.protocol:
            self.characters.clear()
            why = f"speaks {self.beginning.protocol}, which hosts do not use; connection closed"
            self.port.report_foreign_client(self.beginning.protocol, f"{self.name} {why}")
            self.gone(why)
            return
        if self.beginning.pending:
            self.port.loop.after(HOLD_S, partial(self._pass_on, len(self.beginning.seen)))
        self.receive(passed)

    def _acknowledge(self) -> None:
        if QUICK is not None and self.stream.open and not self.stream.dirty:
            with suppress(OSError):
                self.connection.setsockopt(socket.IPPROTO_TCP, QUICK, 1)

    def _pass_on(self, seen: int) -> None:
        if self.stream.open and len(self.beginning.seen) == seen:  # no byte has come since then
            self.receive(self.beginning.release())

    def receive(self, data: bytes) -> None:
        """Receive bytes of the host that have passed the check for foreign protocols."""
        self.characters += data
        self.port.pump()

    def fed(self) -> None:
        """Accept more bytes, because some have gone to the line; after the host's last byte, wait for the answers."""
        self.stream.resume()
        if self.stream.at_end and not self.characters and not self.answering:
            self.answering = True
            self.line.when_answered(self.stream.finish)

    # --------------------------------------------------------------------------------------------------- to the host
    def give(self, data: bytes) -> int:
        """Send bytes to the host; return the number dropped."""
        return self.stream.write(data)

    # ----------------------------------------------------------------------------------------------------------- end
    def leave(self) -> bool:
        """Make room for the next host, if this one has closed, or has too many bytes waiting.

        Returns:
            True if this host has left, False if it stays connected.
        """
        ahead = self.stream.ahead
        if not self.stream.at_end and not self.stream.read_ahead(AHEAD):
            return False
        self.port.dropped += max(len(ahead) - REMAINS, 0)
        if ahead:
            self.take(bytes(ahead[:REMAINS]))
            ahead.clear()
        self.receive(self.beginning.release())
        self.gone("closed the connection")
        return True

    def shorten(self, excess: int) -> int:
        """Drop the last `excess` characters that are not transmitted yet, and return the number dropped.

        More are dropped if the rest would end in the middle of a line of text: it then ends with the last complete line
        of text, if it contains one.
        """
        kept = self.characters[: max(len(self.characters) - excess, 0)]
        end = max(kept.rfind(b"\r"), kept.rfind(b"\n")) + 1
        dropped = len(self.characters) - (end or len(kept))
        del self.characters[end or len(kept) :]
        return dropped

    def ended(self) -> None:
        """Record that the host sends no more."""
        self.receive(self.beginning.release())
        if self.stream.is_shut:
            self.gone(self.stream.why)

    def detach(self, why: str) -> None:
        """Disconnect from the line; later answers go to another host, or are lost."""
        if self.port.session is self:
            self.port.session = None
        if self.attached:
            self.attached = False
            self.line.leave(why)

    def gone(self, why: str) -> None:
        """Record that the host has left; the next one may connect."""
        self.stream.close()
        self.connection.close()
        self.detach(why)
        self.port.pump()


class TurnSession(Session):
    """A host that receives nothing before its turn, because every answer belongs to a request."""

    def arrive(self) -> None:
        """Do nothing: the host is attached to the line only when its turn begins."""

    def begin(self) -> None:
        super().begin()
        self.attach()


class TcpPort(Closing):
    """A line on a TCP port.

    Args:
        report: called with a message when bytes of a host are dropped, or a client uses a foreign protocol.
    """

    scheme = "socket"
    make = Session

    def __init__(
        self,
        loop: Loop,
        line: PortLine,
        address: str | Path,
        allow_remote: bool = False,
        report: Callable[[str], object] = lambda _text: None,
    ) -> None:
        self.loop, self.line, self.allow_remote, self.report = loop, line, allow_remote, report
        self.session: Session | None = None  # the connected host
        self.turns: deque[Session] = deque()  # the connected host, after former ones whose bytes are still to be played
        self.full = self.sending = self.crowded = False
        self.dropped = 0  # dropped bytes of former hosts, not reported yet
        self.strangers: set[str] = set()  # protocols already reported
        self.listener = Listener(loop, address, self._accept, allow_remote)
        self.address = address if isinstance(address, Path) else self.listener.where

    def again(self) -> Self:
        """Return a new port at the address of this one, which has been closed."""
        return type(self)(self.loop, self.line, self.address, self.allow_remote, self.report)

    @property
    def where(self) -> str:
        """URL of the port, for pySerial."""
        return f"{self.scheme}://{self.listener.where}"

    def _accept(self, connection: socket.socket, name: str) -> None:
        if self.session is not None and not self.session.leave():
            self.line.event(f"{name} was refused: {self.session.name} is connected")
            dismiss(self.loop, connection, f"{self.session.name} has this port; one host at a time")
            return
        self._shorten()
        self.session = self.make(self, connection, name)
        self.turns.append(self.session)
        self.crowded = sum(LEFT + len(host.characters) for host in self.turns) > QUEUE
        if self.crowded:
            self.listener.pause()
        self.pump()

    def report_foreign_client(self, protocol: str, message: str) -> None:
        """Report a client with another protocol, but only once per protocol, because a browser reconnects by itself."""
        if protocol not in self.strangers:
            self.strangers.add(protocol)
            self.report(f"{message}; a browser opens the page of slewline panel" if protocol == "HTTP" else message)

    def _shorten(self) -> None:
        """Drop bytes left by former hosts, so that the next host waits for at most `REMAINS` of them.

        Report the number of bytes dropped.
        """
        excess = sum(len(host.characters) for host in self.turns) - REMAINS
        while excess > 0:
            dropped = max(self.turns, key=lambda host: len(host.characters)).shorten(excess)
            self.dropped += dropped
            excess -= dropped
        if self.dropped:
            dropped, self.dropped = self.dropped, 0
            self.report(
                f"{self.where}: the previous host left more bytes than the line can transmit before the next host's "
                f"turn; {dropped} of them were dropped"
            )

    # --------------------------------------------------------------------------------------------------------- turns
    def resume(self) -> None:
        """Resume passing bytes, because the line has room again.

        The loop passes the bytes a little later, so this method may also be called while the bench processes an
        instant.
        """
        self.full = False
        self.loop.ask(self.pump)

    def pump(self) -> None:
        """Pass bytes from hosts to the line, one host after another."""
        while self.turns and not self.full:
            host = self.turns[0]
            if not host.begun:
                host.begin()
            if host.characters:
                self._feed(host)
            elif host.stream.open:
                host.fed()
                return
            elif self.line.sent():
                self._end(host)
            else:
                self._wait()
                return

    def _feed(self, host: Session) -> None:
        room = self.line.room()
        self.full = room <= 0
        if not self.full:
            data = bytes(host.characters[:room])
            del host.characters[:room]
            self.line.take(data)
            host.fed()

    def _end(self, host: Session) -> None:
        """End the turn of a host."""
        self.turns.popleft()
        host.end()
        if self.crowded:
            self.crowded = False
            self.listener.listen()

    def _wait(self) -> None:
        """Begin the next turn when all bytes of the current turn have been sent."""
        if not self.sending:
            self.sending = True
            self.line.when_sent(self._sent)

    def _sent(self) -> None:
        self.sending = False
        self.loop.ask(self.pump)

    def _shut(self) -> None:
        """Disconnect all hosts, and stop listening."""
        self.listener.close()
        hosts = list(self.turns)
        self.turns.clear()
        for host in hosts:
            host.gone("the port is closed")
