"""The control port: pins, time, faults and status, for tests and panels in any language.

A client connects by TCP, sends one JSON object per line, and receives one JSON object per line in reply,
in order.  A reply has `time_ps`, the virtual time; a reply with `error` reports the fault, and the
request had no effect.  `requests.py` defines the requests, as rows; docs/reference/control.md shows
them.  A client that subscribes receives events as well: lines with `event`, between the replies.

In lockstep, `until` lets time pass as `advance` does; when paced, time passes by itself.  A client may
send its next request at any time; the server reads it after sending the reply to the previous request.
A client that has closed its side still receives every reply; the last line that it sends may lack the
line feed.  Empty lines are ignored.

Clients on this machine are allowed; those on other machines only if the server has a token, which every
client must then send with its first request.  If the first line of a connection is not a JSON object, or
lacks a required token, the connection is closed and the rest is not read: a browser that was made to
POST here begins with an HTTP request line.  A connection whose protocol `links/sockets/preamble.py`
recognises is closed even before its first line ends.
"""

from __future__ import annotations

import hmac
import json
import socket
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from time import perf_counter
from traceback import format_exception
from typing import TYPE_CHECKING, Any

from ...bench.runner import Wait
from ...closing import Closing
from ...core.wires.pin import Condition
from ...errors import SlewlineError, UsageError
from ..ports.tcp import Listener
from ..sockets.address import is_loopback, parse_address
from ..sockets.preamble import CONTROL, Preamble
from ..sockets.stream import SocketStream
from ..views.panel_views import at, difference, put
from .beyond import Beyond
from .pin_verbs import PinVerbs
from .requests import read
from .time_verbs import TimeVerbs
from .validator import as_object
from .value_kinds import Data
from .view_verbs import ViewVerbs

if TYPE_CHECKING:
    from ..face import ServerFace

LONGEST = 1 << 16  # longest request, bytes
QUEUE = 1 << 24  # bytes of replies
SHARE_S = 0.001  # time for requests of a client per turn of the loop
SHORTEST_TOKEN = 8  # characters
OFTENEST_S = 0.005  # events of a client
OF_ALL_BRANCHES = ("back", "branches", "branch", "quit", "schema", "unplug", "plug")  # requests that are answered here
GATHER_S = 0.0003  # time for comparing a view per turn of the loop
CLOCK_S = 0.1  # between two events that only report the time


class Requests(PinVerbs, TimeVerbs, ViewVerbs):
    """Handlers of all requests; if a handler returns None, the reply comes later."""

    def perform(self, request: Data) -> Data | None:
        """Execute a request, and return its reply; None if the reply comes later."""
        found: Data | None = getattr(self, f"do_{request['do']}")(request)
        return found


class Control(Closing):
    """A control port, for any number of simultaneous clients.

    Args:
        token: the token, at least 8 characters, that clients send in their first request; None: no token.

    Raises:
        UsageError: the address is in use; the token is short, or missing where other machines have access.
    """

    def __init__(self, server: ServerFace, address: str | Path, token: str | None = None) -> None:
        self.server, self.token = server, token
        self.clients: list[Client] = []
        if token is not None and len(token) < SHORTEST_TOKEN:
            raise UsageError(
                f"the token of the control port has {len(token)} characters; give {SHORTEST_TOKEN} or more"
            )
        host = "localhost" if isinstance(address, Path) else parse_address(address, server.allow_remote)[0]
        if token is None and not is_loopback(host):
            raise UsageError(f"address {address!r}: other machines could drive the pins without a token; add --token")
        self.listener = Listener(server.loop, address, self._accept, server.allow_remote)

    @property
    def where(self) -> str:
        """Address of the port, HOST:PORT."""
        return self.listener.where

    def _accept(self, connection: socket.socket, _name: str) -> None:
        self.clients.append(Client(self, connection))

    def _shut(self) -> None:
        """Close all connections and the port."""
        self.listener.close()
        for client in list(self.clients):
            client.gone("")


class Client:
    """A client of the control port, whose requests are read and answered one after another."""

    def __init__(self, control: Control, connection: socket.socket) -> None:
        self.control, self.server, self.connection = control, control.server, connection
        self.incoming = bytearray()
        self.waiting = self.too_long = False
        self.known = self.refused = False  # set by the first line
        self.beginning = Preamble(CONTROL)
        self.postponed = False  # requests wait for the next turn of the loop
        self.every_s = 0.0  # between two events, for a subscribed client
        self.seen: Data = {}  # the view that the client has
        self.sent = (0, 0, 0.0)  # entries sent so far, and the time of the last event
        self.watching = 0  # the number of its subscription
        self.gathering: Iterator[tuple[tuple[str, ...], Any]] | None = None  # rest of a view, still to be compared
        self.changed: Data = {}  # changes found in it
        self.beyond: Beyond | None = None  # destination of its requests
        self.stream = SocketStream(self.server.loop, connection, self.take, self.gone, self.room, QUEUE, self.ended)

    @property
    def token(self) -> str | None:
        """Token that a client must send with its first request; None if no token is required."""
        return self.control.token

    def room(self) -> int:
        """Return the number of bytes that may be read now.

        It is 0 while a reply or a received request is pending, while the client does not read its replies, and
        after the client has been refused.
        """
        return 0 if self.waiting or self.postponed or self.stream.outgoing or self.refused else LONGEST

    def take(self, data: bytes) -> None:
        """Receive bytes: complete requests, or parts of them."""
        self.incoming += self.beginning.take(data)
        if self.beginning.protocol:
            self.refuse(f"this port does not support {self.beginning.protocol}")
        self.work()

    def ended(self) -> None:
        """Record that no more requests will come."""
        self.incoming += self.beginning.release() + b"\n"
        self.work()

    def work(self) -> None:
        """Answer received requests for a share of a loop turn; postpone the rest until other clients are served."""
        end_s = perf_counter() + SHARE_S
        while not self.waiting and self.stream.open and not self.refused:
            line, end, rest = self.incoming.partition(b"\n")
            self.too_long |= len(line) > LONGEST
            if not end:
                if self.too_long:
                    self.incoming.clear()
                if self.stream.at_end:
                    self.stream.finish()
                return
            self.incoming = rest
            if not self.known and line.strip() and not self.greet(bytes(line)):
                return
            if self.too_long:
                self.reply({}, {"error": f"the request has more than {LONGEST} bytes"})
                self.too_long = False
            elif line.strip():
                self.answer(bytes(line))
            if perf_counter() >= end_s:
                self.postponed = True
                self.server.loop.ask(self.go_on)
                return

    def greet(self, line: bytes) -> bool:
        """Return whether the first line is an object with the required token, if any; if not, close the connection."""
        try:
            token = as_object(line).get("token")
            if self.control.token is not None and not same(token, self.control.token):
                raise UsageError('the first request must include the token of this server: {"token": ..., "do": ...}')
            self.known = True
            self.lead(self.server.branches.elsewhere)
        except UsageError as error:
            self.refuse(str(error))
        return self.known

    def refuse(self, why: str) -> None:
        """Reply with the reason, and close the connection."""
        self.refused = True
        self.reply({}, {"error": f"{why}; connection closed"})
        self.stream.finish()

    def answer(self, line: bytes) -> None:
        """Answer one request, given as a line."""
        request: Data = {}
        self.server.catch_up()
        try:
            request = read(line)
            if self.beyond is not None and request["do"] not in OF_ALL_BRANCHES:
                self.beyond.forward(request)
                return
            found = self.perform(request)
            if found is not None:
                self.reply(request, found)
        except Exception as error:
            self.waiting = False
            request = request or numbered(line)
            self.reply(request, self.failed(request, error))

    def failed(self, request: Data, error: Exception) -> Data:
        """Return the reply for an error.

        It contains the message of slewline's own errors; for any other error, it refers to the terminal.
        """
        if isinstance(error, SlewlineError):
            return {"error": str(error)}
        do = request.get("do", "request")
        self.server.say("server", f"control port: {do}: {''.join(format_exception(error))}")
        return {"error": f"{do}: an internal error of slewline; the terminal of the server shows it"}

    def perform(self, request: Data) -> Data | None:
        """Execute a request and return its reply; None if the reply comes later."""
        return Requests(self.server, self).perform(request)

    def wait(
        self, request: Data, reply: Callable[[bool], Data], condition: Condition, limit_ps: int, pushes: bool = False
    ) -> None:
        """Send `reply(met)` when a condition is met, or at `limit_ps`; `pushes`: let paused time run until then."""
        answer = self.answer_later(request)
        wait = Wait(condition.met, limit_ps, lambda met: answer(reply(met)), condition.foreseen, condition.nets, pushes)

        def renew() -> None:
            fresh = Requests(self.server, self).renewed(request, condition)
            wait.met, wait.when, wait.nets = fresh.met, fresh.foreseen, fresh.nets

        wait.renew = renew
        self.server.pace.wait(wait)

    def answer_later(self, request: Data) -> Callable[[Data], object]:
        """Return a function that later sends the reply to a request.

        Until the reply is sent, further requests are read only if the client has subscribed.
        """
        self.waiting = not self.every_s

        def answer(found: Data) -> None:
            self.waiting = False
            self.reply(request, found)
            self.server.loop.ask(self.go_on)

        return answer

    # -------------------------------------------------------------------------------------------------------- events
    def subscribe(self, every_s: float) -> Data:
        """Start sending events, at a minimum interval of `every_s` seconds; 0 stops them.  Return the current view."""
        dialogue = self.server.dialogue
        self.seen, self.sent = self.server.views.view(), (dialogue.touched, dialogue.number, perf_counter())
        self.gathering = None
        self.watch(every_s)
        return self.seen

    def watch(self, every_s: float) -> None:
        """Check for changes every `every_s` seconds from now on, but at most once in 5 ms; 0 stops the checks."""
        self.every_s = every_s and max(every_s, OFTENEST_S)
        self.watching += 1
        if self.every_s:
            self.server.loop.after(self.every_s, partial(self.notify, self.watching))

    def notify(self, watching: int) -> None:
        """Send changes, unless earlier ones are still unread.

        Each call schedules the next; a call does nothing if `watching` is not the current subscription's number.
        """
        if watching != self.watching or not self.stream.open:
            return
        self.server.loop.after(self.every_s, partial(self.notify, watching))
        if self.stream.outgoing or self.beyond is not None:
            return
        self.send_dialogue()
        if self.gathering is None:
            self.gathering, self.changed = self.server.views.pieces(), {}
            self.gather()

    def send_dialogue(self) -> None:
        """Send the entries of the dialogue that are new or have changed."""
        dialogue = self.server.dialogue
        touched, number, sent_s = self.sent
        if dialogue.touched != touched:
            self.sent = dialogue.touched, dialogue.number, sent_s
            self.event({"event": "said", "entries": [*dialogue.changed(touched, number)][::-1]})

    def gather(self) -> None:
        """Search the view for changes, in several loop turns so as not to delay a module's answer; then send them."""
        if self.gathering is None:  # ended by a stop
            return
        end_s = perf_counter() + GATHER_S
        for path, value in self.gathering:
            old = at(self.seen, path)
            if value != old:
                both = isinstance(value, dict) and isinstance(old, dict)
                put(self.changed, path, difference(old, value) if both else value)
                put(self.seen, path, value)
            if perf_counter() > end_s:
                self.server.loop.ask(self.gather)
                return
        self.gathering = None
        sent_s, now_s = self.sent[2], perf_counter()
        if self.changed or (now_s - sent_s > CLOCK_S and not self.server.pace.paused):
            self.event({"event": "view", "view": self.changed})
            self.sent = *self.sent[:2], now_s

    def divert(self, where: str, event: Data) -> None:
        """Send `event`, then route later requests to a branch's control port at the address `where`.

        If `where` is "", later requests are answered here again.
        """
        if self.beyond is not None:
            self.beyond.close()
        self.event(event)
        self.gathering = None
        self.lead(where)
        self.seen, self.sent = {}, (self.server.dialogue.touched, self.server.dialogue.number, 0.0)

    def lead(self, where: str) -> None:
        """Route later requests to a branch's control port at `where`; if `where` is "", answer them here."""
        self.beyond = None
        if where:
            with suppress(OSError):  # the branch has ended: the server detects that, too, and shows the first run
                self.beyond = Beyond(self, where)

    def event(self, found: Data) -> None:
        """Send an event, if the client has subscribed; before a stop or a branch, send the older changes.

        The search for changes begins again after a stop, so that the next view includes the pause.
        """
        if self.every_s and self.stream.open:
            if found["event"] in ("stopped", "branch"):
                self.send_dialogue()
            if found["event"] == "stopped" and self.gathering is not None:
                self.gathering = None
                if self.changed:
                    self.event({"event": "view", "view": self.changed})
            event = {"event": "", "time_ps": self.server.branches.now_ps} | found
            self.stream.write(json.dumps(event).encode() + b"\n")

    def go_on(self) -> None:
        """Answer received requests that had to wait, then resume reading."""
        self.postponed = False
        self.work()
        if not self.postponed:
            self.stream.resume()

    def reply(self, request: Data, found: Data) -> None:
        """Send the reply to a request, as one line."""
        about = {"id": request["id"]} if "id" in request else {}
        self.stream.write(json.dumps(about | {"time_ps": self.server.branches.now_ps} | found).encode() + b"\n")

    def gone(self, _why: str) -> None:
        """Close the connection and remove the client; pending waits stay active, but their replies are discarded."""
        self.watching += 1
        if self.beyond is not None:
            self.beyond.close()
        self.stream.close()
        self.connection.close()
        if self in self.control.clients:
            self.control.clients.remove(self)


def numbered(line: bytes) -> Data:
    """Return the id of an invalid request as {"id": ...}; {} if the request has no id.

    With the id, the client can match the error to its request.
    """
    try:
        request = as_object(line)
    except (SlewlineError, ValueError):
        return {}
    return {"id": request["id"]} if "id" in request else {}


def same(token: object, expected: str) -> bool:
    """Return whether a token is the expected one; the time taken does not reveal how many characters are right."""
    return isinstance(token, str) and hmac.compare_digest(token.encode("utf-8", "replace"), expected.encode("utf-8"))
