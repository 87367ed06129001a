"""The control port: pins, time, faults and status, for tests and panels in any language.

A client connects by TCP, sends one JSON object a line, and gets one JSON object a line for each, in order.  A reply
has `time_ps`, virtual time; one that has `error` reports what was wrong, and nothing was done.  `requests.py` has the
requests, as rows; docs/reference/control.md shows them.

In lockstep, `until` lets time pass as `advance` does; paced, time passes by itself.  A client that waits sends its next
request when it likes; it is read when the reply to the one before has gone out.  A client that sends no more still gets
every reply; its last line may lack the line feed.  Empty lines are ignored.

Allowed are clients on this machine; on others only where the server has a token, which then every client sends
with the first request.  A connection whose first line is no such request is closed, and nothing after it
is read: a browser that was made to POST here begins with a request line of HTTP.  What `links/sockets/preamble.py`
knows is hung up on before that line ends.
"""

from __future__ import annotations

import hmac
import json
import socket
from collections.abc import Callable
from time import perf_counter
from typing import TYPE_CHECKING

from ...bench.runner import NEVER, Wait
from ...core.messages.near import hint
from ...core.time.timebase import moment, picoseconds
from ...core.wires.pin import Condition
from ...errors import SlewlineError, UsageError
from ..lines.line import ConnectorLine
from ..ports.tcp import Listener
from ..sockets.address import is_loopback, parse_address
from ..sockets.preamble import Preamble
from ..sockets.stream import SocketStream
from .requests import MAX_FINDINGS, MAX_STEPS, Data, as_object, read, schema
from .status import Serving, status

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...core.motion.one_axis import OneAxis

LONGEST = 1 << 16  # bytes of a request
QUEUE = 1 << 24  # bytes of replies
SHARE_S = 0.001  # how long requests of a client are answered in a turn of the loop
SHORTEST_TOKEN = 8  # characters
DIRECTIONS = ("chip", "host")


class Control:
    """A port on which clients ask; any number of them at once.

    Args:
        token: what every client must send with its first request, at least 8 characters; None: nothing.

    Raises:
        UsageError: the address is taken, or other machines could reach it and there is no token.
    """

    def __init__(self, server: Serving, address: str, token: str | None = None) -> None:
        self.server, self.token = server, token
        self.clients: list[Client] = []
        if token is not None and len(token) < SHORTEST_TOKEN:
            raise UsageError(
                f"the token of the control port has {len(token)} characters; give {SHORTEST_TOKEN} or more"
            )
        host, _ = parse_address(address, server.allow_remote)
        if token is None and not is_loopback(host):
            raise UsageError(f"address {address!r}: other machines could drive the pins; add --token if they may")
        self.listener = Listener(server.loop, address, self._accept, server.allow_remote)

    @property
    def where(self) -> str:
        """HOST:PORT."""
        return self.listener.where

    def _accept(self, connection: socket.socket, _name: str) -> None:
        self.clients.append(Client(self, connection))

    def close(self) -> None:
        """Close all connections and the port."""
        self.listener.close()
        for client in list(self.clients):
            client.gone("")


class Client:
    """A client of the control port: requests come in, replies go out, one after the other."""

    def __init__(self, control: Control, connection: socket.socket) -> None:
        self.control, self.server, self.connection = control, control.server, connection
        self.incoming = bytearray()
        self.waiting = self.too_long = False
        self.known = self.refused = False  # by the first line
        self.beginning = Preamble()
        self.postponed = False  # requests wait for the next turn of the loop
        self.stream = SocketStream(self.server.loop, connection, self.take, self.gone, self.room, QUEUE, self.ended)

    def room(self) -> int:
        """Return how many bytes may be read now: none while a reply is owed, or replies are not read."""
        return 0 if self.waiting or self.postponed or self.stream.outgoing or self.refused else LONGEST

    def take(self, data: bytes) -> None:
        """Take bytes: requests, or pieces of them."""
        self.incoming += self.beginning.take(data)
        if self.beginning.stranger:
            self.refuse(f"this port does not speak {self.beginning.stranger}")
        self.work()

    def ended(self) -> None:
        """Take notice that no more requests will come."""
        self.incoming += self.beginning.release() + b"\n"
        self.work()

    def work(self) -> None:
        """Answer what has come, for a share of the turn; what is left has its turn after all others."""
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
        """Return whether the first line comes from a client; hang up if not."""
        try:
            token = as_object(line).get("token")
            if self.control.token is not None and not same(token, self.control.token):
                raise UsageError('the first request must have the token of this server: {"token": ..., "do": ...}')
            self.known = True
        except UsageError as error:
            self.refuse(str(error))
        return self.known

    def refuse(self, why: str) -> None:
        """Reply with the reason, and hang up."""
        self.refused = True
        self.reply({}, {"error": f"{why}; connection closed"})
        self.stream.finish()

    def answer(self, line: bytes) -> None:
        """Answer one request, a line."""
        request: Data = {}
        self.server.catch_up()
        try:
            request = read(line)
            found = Requests(self.server, self).perform(request)
            if found is not None:
                self.reply(request, found)
        except (SlewlineError, TypeError, ValueError, KeyError) as error:
            self.reply(request, {"error": str(error)})

    def wait(self, request: Data, reply: Callable[[bool], Data], condition: Condition, limit_ps: int) -> None:
        """Owe a reply until a condition is met, or an instant (ps) is there."""
        self.waiting = True

        def done(met: bool) -> None:
            self.waiting = False
            self.reply(request, reply(met))
            self.server.loop.ask(self.go_on)

        self.server.pace.wait(Wait(condition.met, limit_ps, done, condition.foreseen, condition.nets))

    def go_on(self) -> None:
        """Answer requests that have come meanwhile, and go on reading."""
        self.postponed = False
        self.work()
        if not self.postponed:
            self.stream.resume()

    def reply(self, request: Data, found: Data) -> None:
        """Send the reply to a request, a line."""
        if "id" in request:
            found = {"id": request["id"]} | found
        self.stream.write(json.dumps(found | {"time_ps": self.server.bench.now_ps}).encode() + b"\n")

    def gone(self, _why: str) -> None:
        """Take notice that the connection is closed: pending waits stay active, but their replies are discarded."""
        self.stream.close()
        self.connection.close()
        if self in self.control.clients:
            self.control.clients.remove(self)


def same(token: object, expected: str) -> bool:
    """Return whether it is the token, in a time that does not depend on how much of it is right."""
    return isinstance(token, str) and hmac.compare_digest(token.encode("utf-8", "replace"), expected.encode("utf-8"))


class Requests:
    """What each request does; None: the reply comes later."""

    def __init__(self, server: Serving, client: Client) -> None:
        self.server, self.client, self.bench = server, client, server.bench

    def perform(self, request: Data) -> Data | None:
        """Do what a request asks for."""
        found: Data | None = getattr(self, f"do_{request['do']}")(request)
        return found

    def chip(self, name: str) -> Chip:
        """Return a chip by its name.

        Raises:
            UnknownName: no such chip.
        """
        chips = self.bench.chips
        if name not in chips:
            raise UsageError(f"no chip {name!r}; there are: {', '.join(chips)}{hint(name, chips)}")
        return chips[name]

    def axis(self, request: Data) -> OneAxis:
        """Return the axis of a chip that a request names, the first one by default."""
        return self.chip(request["chip"]).axis(request.get("axis", 1))

    def do_drive(self, request: Data) -> Data:
        """Drive a pin from outside."""
        self.bench.pin(request["pin"]).drive(request["level"])
        return {}

    def do_release(self, request: Data) -> Data:
        """Release a pin from outside."""
        self.bench.pin(request["pin"]).release()
        return {}

    def do_pulse(self, request: Data) -> Data:
        """Drive a pin for a time."""
        self.bench.pin(request["pin"]).pulse(request["level"], request["width"])
        return {}

    def do_read(self, request: Data) -> Data:
        """Reply with the levels of some pins."""
        if not isinstance(request["pins"], list) or not all(isinstance(name, str) for name in request["pins"]):
            raise UsageError(f'pins {request["pins"]!r}; expected a list such as ["x.rdy"]')
        return {"levels": {name: self.bench.pin(name).level for name in request["pins"]}}

    def do_advance(self, request: Data) -> None:
        """Let time pass in lockstep; reply when it has."""
        if not self.server.pace.lockstep:
            raise UsageError("advance: time follows the wall clock here; start the server with --lockstep")
        end = self.bench.now_ps + picoseconds(request["time"])
        self.client.wait(request, lambda _met: {}, NEVER, end)

    def do_until(self, request: Data) -> None:
        """Wait for a condition; reply when it is met, or its time is over."""
        condition = self.condition(request)
        end = self.bench.now_ps + picoseconds(request.get("timeout", "60 s"))
        self.client.wait(request, lambda met: {"met": met}, condition, end)

    def condition(self, request: Data) -> Condition:
        """Return the condition of a request: a pin with its level, or a chip with its position."""
        if {"pin", "level"} <= set(request) and not {"chip", "position"} & set(request):
            return self.bench.pin(request["pin"]).is_(request["level"])
        if {"chip", "position"} <= set(request) and not {"pin", "level"} & set(request):
            if not isinstance(request["position"], int):
                raise UsageError(f"position {request['position']!r}; expected a whole number")
            return self.axis(request).reaches(request["position"])
        raise UsageError("until: give pin and level, or chip and position")

    def line(self, name: str) -> ConnectorLine:
        """Return a serial line by its name, or by that of any chip on it.

        Raises:
            UnknownName: no such line.
        """
        lines = [line for line in self.server.lines.values() if isinstance(line, ConnectorLine)]
        for line in lines:
            if name == line.name or name in (chip.name for chip in line.chips):
                return line
        names = [line.name for line in lines]
        raise UsageError(f"no serial line {name!r}; there are: {', '.join(names) or 'none'}{hint(name, names)}")

    def eeprom(self, request: Data, fails: bool) -> Data:
        """Let the EEPROM of a module fail, or no more."""
        chip = self.chip(request["chip"])
        if not hasattr(chip, "eeprom_fault"):
            raise UsageError(f"chip {chip.name!r}: a {chip.sheet.part} has no EEPROM")
        if {"line", "to", "count", "chance", "seed"} & set(request) or request.get("kind", "eeprom") != "eeprom":
            raise UsageError(f"{request['do']}: a chip takes the kind eeprom only; all others need a line")
        chip.eeprom_fault = fails
        return {}

    def do_fault(self, request: Data) -> Data:
        """Plan faults in the characters of a line, or in a chip's EEPROM."""
        if "chip" in request:
            return self.eeprom(request, True)
        if not {"line", "to"} <= set(request):
            raise UsageError("fault: needs line, to and kind, or chip and the kind eeprom")
        line, to = self.line(request["line"]), request["to"]
        if to not in DIRECTIONS:
            raise UsageError(f"to {to!r}; allowed {', '.join(DIRECTIONS)}")
        noise = line.to_chip if to == "chip" else line.to_host
        noise.plan(request["kind"], request.get("count", 1), request.get("chance", 1), request.get("seed", 0))
        return {}

    def do_clear(self, request: Data) -> Data:
        """End the faults of a line, and reply with how many characters they hit; or those of a chip's EEPROM."""
        if "chip" in request:
            return self.eeprom(request, False)
        if "line" not in request:
            raise UsageError("clear: needs line or chip")
        line = self.line(request["line"])
        line.to_chip.clear()
        line.to_host.clear()
        return {"hits": {"chip": line.to_chip.done, "host": line.to_host.done}}

    def do_power(self, request: Data) -> Data:
        """Switch the supply of a chip."""
        if not isinstance(request["on"], bool):
            raise UsageError(f"on {request['on']!r}; allowed true, false")
        self.chip(request["chip"]).power(request["on"])
        return {}

    def do_status(self, _request: Data) -> Data:
        """Reply with the state of everything."""
        return status(self.server)

    def do_findings(self, request: Data) -> Data:
        """Reply with the last findings, of a chip or part or of all."""
        start = picoseconds(request.get("start", 0))
        owner = self.bench[request["source"]] if "source" in request else self.bench
        found = [one for one in owner.findings if one.time_ps >= start]
        shown = [
            {"time_ps": one.time_ps, "source": one.source, "code": one.code, "text": one.text}
            for one in found[-MAX_FINDINGS:]
        ]
        return {"findings": shown, "omitted": len(found) - len(shown)}

    def do_schema(self, _request: Data) -> Data:
        """Reply with the schema of requests and replies."""
        return {"schema": schema()}

    def do_steps(self, request: Data) -> Data:
        """Reply with the steps of an axis."""
        axis = self.axis(request)
        start, stop = request.get("start", axis.motor.since), request.get("stop", self.bench.now_ps)
        count = axis.motor.count(moment(start), min(moment(stop), self.bench.now_ps))
        if count > MAX_STEPS:
            raise UsageError(f"steps: {count} in this window; ask for windows of at most {MAX_STEPS}")
        steps = axis.steps(start, stop)
        return {name: getattr(steps, name).tolist() for name in ("times_ps", "directions", "positions")}

    def do_quit(self, _request: Data) -> Data:
        """End the server."""
        self.server.stop()
        return {}
