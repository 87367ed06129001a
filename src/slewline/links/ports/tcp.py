r"""TCP: a raw socket for each line, socket://HOST:PORT for pySerial.

A port behaves like a line: hosts take turns, and one owns the port at a time.

    a host closes            what it has sent is played to the last byte, whether it has read its answers or not
    the next one comes       at any time: its bytes queue after those, and it gets the answers that come from now on
    a second one meanwhile   gets a line of text that names the first one, and is disconnected

A host that sends no more (`printf 'V1\r' | nc -N`) gets the answers to what it has sent, unless the next one comes.
One that has vanished without a word (a cable pulled, a machine switched off) is found out by keepalive probes.

The next one does not wait for long: of what is still to be played when it comes, `REMAINS` bytes stay, up to the end of
a line; the rest is dropped, and reported.  That a host has closed shows after its last byte only, so when the next one
knocks, what it has sent is read ahead; one that has more than `AHEAD` waiting then gives way, whether it has closed or
not.
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
LOCAL = "a socket of this user"  # where a Unix socket is, and who has come on one
RETRY_S = 0.5  # when the system cannot accept a connection
# Acknowledge at once: a host that writes in small pieces, as most do, else waits 40 ms before the next one goes out.
QUICK: int | None = getattr(socket, "TCP_QUICKACK", None)
FAREWELL_S = 1.0  # how long a host that was refused may take to read why
REMAINS = 8192  # bytes of hosts that have gone which the next one has to wait for: ten seconds at 9600 baud
AHEAD = 1 << 20  # bytes that are read to find the end of a host; at 9600 baud they would take 18 minutes
LEFT = 64  # bytes that a host which has gone counts for, besides those that it has left


class Listener:
    """A socket that listens; `accept` is called with each connection and the name of the other side."""

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
            raise UsageError(f"address {address!r}: {error.strerror or error}; choose another one") from None
        self.socket.setblocking(False)
        self.listen()

    def listen(self) -> None:
        """Take connections."""
        if self.socket.fileno() >= 0:
            self.loop.watch(self.socket.fileno(), self._accept)

    def pause(self) -> None:
        """Let connections wait in the system's queue."""
        self.loop.watch(self.socket.fileno())

    @property
    def where(self) -> str:
        """HOST:PORT as it is; of a Unix socket, that it is one."""
        if not isinstance(self.socket.getsockname(), tuple):
            return LOCAL
        host, port = self.socket.getsockname()[:2]
        return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"

    def _accept(self) -> None:
        try:
            connection, peer = self.socket.accept()
        except (BlockingIOError, ConnectionError):  # it has gone already
            return
        except OSError:  # no descriptors left, for example: others may close theirs
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
    """Send a line, and hang up when it has been read, or after a second."""

    def end(_reason: str = "") -> None:
        stream.close()
        connection.close()

    stream = SocketStream(loop, connection, lambda _data: None, end)
    with suppress(OSError):
        connection.send(f"slewline: {why}\r\n".encode("ascii", "replace"))
        connection.shutdown(socket.SHUT_WR)
    loop.after(FAREWELL_S, end)


class Session:
    """A host on a socket: bytes as they are."""

    def __init__(self, port: TcpPort, connection: socket.socket, name: str) -> None:
        self.port, self.line, self.connection, self.name = port, port.line, connection, name
        self.beginning = Preamble(self.line.greetings)
        self.characters = bytearray()  # what has come, and waits for its turn on the line
        self.attached = self.begun = self.answering = False
        self.stream = SocketStream(port.loop, connection, self.take, self.gone, self.room, ended=self.ended)
        self.arrive()

    def arrive(self) -> None:
        """Connect the host: from now on it gets what the module sends."""
        self.attach()

    def attach(self) -> None:
        """Get what comes from the line."""
        self.attached = True
        self.line.attach(self.name, self.give, self.port.resume)

    def begin(self) -> None:
        """Begin the turn of this host."""
        self.begun = True

    def end(self) -> None:
        """End the turn: the host has gone, and all that it has sent is under way."""

    # --------------------------------------------------------------------------------------------------- to the line
    def room(self) -> int:
        """Return how many bytes may come from the host now."""
        return min(self.line.share, CHUNK - len(self.characters) - len(self.beginning.held))

    def take(self, data: bytes) -> None:
        """Take bytes from the host."""
        self.port.loop.dirty.append(self._acknowledge)
        passed = self.beginning.take(data)
        if self.beginning.stranger:
            self.characters.clear()
            why = f"speaks {self.beginning.stranger}, which no host does; connection closed"
            self.port.report_stranger(self.beginning.stranger, f"{self.name} {why}")
            self.gone(why)
            return
        if self.beginning.held:
            self.port.loop.after(HOLD_S, partial(self._pass_on, len(self.beginning.seen)))
        self.receive(passed)

    def _acknowledge(self) -> None:
        """Acknowledge what has come, at the end of a turn; an answer that is about to go out does so by itself."""
        if QUICK is not None and self.stream.open and not self.stream.dirty:
            with suppress(OSError):
                self.connection.setsockopt(socket.IPPROTO_TCP, QUICK, 1)

    def _pass_on(self, seen: int) -> None:
        if self.stream.open and len(self.beginning.seen) == seen:  # nothing has come since then
            self.receive(self.beginning.release())

    def receive(self, data: bytes) -> None:
        """Take bytes of the host, none of them held back."""
        self.characters += data
        self.port.pump()

    def fed(self) -> None:
        """Take notice that characters have gone to the line: there is room for more."""
        self.stream.resume()
        if self.stream.at_end and not self.characters and not self.answering:
            self.answering = True
            self.line.when_answered(self.stream.finish)

    # --------------------------------------------------------------------------------------------------- to the host
    def give(self, data: bytes) -> int:
        """Send bytes to the host; return how many were dropped."""
        return self.stream.write(data)

    # ----------------------------------------------------------------------------------------------------------- end
    def leave(self) -> bool:
        """Make room for the next host, if this one has closed, or has more waiting than the line plays for long.

        Returns:
            False: it stays.
        """
        ahead = self.stream.ahead
        if not self.stream.at_end and not self.stream.read_ahead(AHEAD):
            return False
        self.port.dropped += max(len(ahead) - REMAINS, 0)
        if ahead:
            self.take(bytes(ahead[:REMAINS]))
            ahead.clear()
        self.receive(self.beginning.release())
        self.gone("hung up")
        return True

    def shorten(self, excess: int) -> int:
        """Drop so many characters that wait for the line, or more, so that a line ends there; return how many."""
        kept = self.characters[: max(len(self.characters) - excess, 0)]
        end = max(kept.rfind(b"\r"), kept.rfind(b"\n")) + 1
        dropped = len(self.characters) - (end or len(kept))
        del self.characters[end or len(kept) :]
        return dropped

    def ended(self) -> None:
        """Take notice that the host sends no more."""
        self.receive(self.beginning.release())
        if self.stream.deaf:
            self.gone(self.stream.why)

    def detach(self, why: str) -> None:
        """Disconnect from the line: its answers go to another host, or are lost."""
        if self.port.session is self:
            self.port.session = None
        if self.attached:
            self.attached = False
            self.line.leave(why)

    def gone(self, why: str) -> None:
        """Take notice that the host has gone; the next one may come."""
        self.stream.close()
        self.connection.close()
        self.detach(why)
        self.port.pump()


class TurnSession(Session):
    """A host to which nothing goes out before its turn, for every answer belongs to a request."""

    def arrive(self) -> None:
        """Wait for its turn."""

    def begin(self) -> None:
        super().begin()
        self.attach()


class TcpPort(Closing):
    """A line on a TCP port.

    Args:
        tell: called when bytes of a host are dropped.
    """

    scheme = "socket"
    make = Session

    def __init__(
        self,
        loop: Loop,
        line: PortLine,
        address: str | Path,
        allow_remote: bool = False,
        tell: Callable[[str], object] = lambda _text: None,
    ) -> None:
        self.loop, self.line, self.allow_remote, self.tell = loop, line, allow_remote, tell
        self.session: Session | None = None  # the host that is there
        self.turns: deque[Session] = deque()  # it, after those that have left something to be played
        self.full = self.sending = self.crowded = False
        self.dropped = 0  # bytes of hosts that have gone, not reported yet
        self.strangers: set[str] = set()  # the protocols that have been reported
        self.listener = Listener(loop, address, self._accept, allow_remote)
        self.address = address if isinstance(address, Path) else self.listener.where

    def again(self) -> Self:
        """Return a port where this one was, before it was closed."""
        return type(self)(self.loop, self.line, self.address, self.allow_remote, self.tell)

    @property
    def where(self) -> str:
        """The URL of the port, as pySerial writes it."""
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

    def report_stranger(self, protocol: str, says: str) -> None:
        """Report once that a program has come that speaks another protocol: a browser comes again by itself."""
        if protocol not in self.strangers:
            self.strangers.add(protocol)
            self.tell(f"{says}; a browser opens the page of slewline panel" if protocol == "HTTP" else says)

    def _shorten(self) -> None:
        """Keep of what hosts have left as much as the next one may have to wait for."""
        excess = sum(len(host.characters) for host in self.turns) - REMAINS
        while excess > 0:
            dropped = max(self.turns, key=lambda host: len(host.characters)).shorten(excess)
            self.dropped += dropped
            excess -= dropped
        if self.dropped:
            dropped, self.dropped = self.dropped, 0
            self.tell(
                f"{self.where}: the host before left more than the line plays in time; "
                f"{dropped} bytes of it were dropped, because the next host is connected"
            )

    # --------------------------------------------------------------------------------------------------------- turns
    def resume(self) -> None:
        """Read on: the line has room again; may be called in mid-instant."""
        self.full = False
        self.loop.ask(self.pump)

    def pump(self) -> None:
        """Bring to the line what hosts have sent, those of one host after those of the one before."""
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
        """The turn of a host is over."""
        self.turns.popleft()
        host.end()
        if self.crowded:
            self.crowded = False
            self.listener.listen()

    def _wait(self) -> None:
        """The next turn begins when everything of this one is sent."""
        if not self.sending:
            self.sending = True
            self.line.when_sent(self._sent)

    def _sent(self) -> None:
        self.sending = False
        self.loop.ask(self.pump)

    def _shut(self) -> None:
        """Close the connection, and stop listening."""
        self.listener.close()
        hosts = list(self.turns)
        self.turns.clear()
        for host in hosts:
            host.gone("the port is closed")
