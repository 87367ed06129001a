"""The control port: pins, time, faults and status, for tests and panels in any language.

A client connects by TCP, sends one JSON object a line, and gets one JSON object a line for each, in order.  A reply has
`time_ps`, virtual time; one that has `error` says what was wrong, and nothing was done.  Whatever else a request has as
`id` is in its reply.  Times are text with a unit ("250 ms") or whole picoseconds; pins have their full names.

    {"do": "drive", "pin": "x.enable", "level": 0}                       put a level on a pin
    {"do": "release", "pin": "x.enable"}                                 let go of it
    {"do": "pulse", "pin": "x.ui1", "level": 0, "width": "20 us"}        put a level on it for a time
    {"do": "read", "pins": ["x.mov", "x.rdy"]}                           levels: {"x.mov": 0, "x.rdy": 1}; null: floats
    {"do": "advance", "time": "250 ms"}                                  let time pass (lockstep only)
    {"do": "until", "pin": "x.rdy", "level": 1, "timeout": "5 s"}        met: true or false, when it is so
    {"do": "until", "chip": "x", "axis": 2, "position": 400}             the same; axis 1, timeout 60 s, if left out
    {"do": "fault", "line": "x", "to": "chip", "kind": "parity", "count": 3, "chance": 0.5, "seed": 1}
                                                                         noise on the next characters: lost, garbled,
                                                                         parity, framing, late; to the chip or the host
    {"do": "clear", "line": "x"}                                         no more noise; hits: how many were hit
    {"do": "fault", "chip": "x", "kind": "eeprom"}                       programming the EEPROM fails, until it is
    {"do": "clear", "chip": "x"}                                         clear: M and X are answered E6
    {"do": "power", "chip": "x", "on": false}                            switch the supply of a module
    {"do": "status"}                                                     chips, lines, pace
    {"do": "steps", "chip": "x", "axis": 2, "start": 0, "stop": "1 s"}   times_ps, directions, positions
    {"do": "quit"}                                                       end the server

In lockstep, `until` lets time pass as `advance` does; paced, time passes by itself.  A client that waits sends its next
request when it likes; it is read when the reply to the one before has gone out.  A client that says no more still gets
every reply; its last line may lack the line feed.  Empty lines are ignored.
"""

from __future__ import annotations

import json
import socket
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from ..core.pin import Condition
from ..core.timebase import moment, picoseconds
from ..errors import SlewlineError, UsageError
from .line import SerialLine
from .pace import Wait
from .status import status
from .stream import Stream
from .tcp import Listener

if TYPE_CHECKING:
    from ..core.chip import Chip, OneAxis
    from ..core.net import Net
    from .server import Server

LONGEST = 1 << 16  # bytes of a request
QUEUE = 1 << 24  # bytes of replies
MOST_STEPS = 100_000  # in one reply
TEXTS = ("pin", "chip", "line", "to", "kind")
Reply = dict[str, Any]
DIRECTIONS = ("chip", "host")


class Control:
    """A port on which clients ask; any number of them at once."""

    def __init__(self, server: Server, address: str) -> None:
        self.server = server
        self.clients: list[Client] = []
        self.listener = Listener(server.loop, address, self._accept, server.allow_remote)

    @property
    def where(self) -> str:
        """HOST:PORT."""
        return self.listener.where

    def _accept(self, connection: socket.socket, _name: str) -> None:
        self.clients.append(Client(self, connection))

    def close(self) -> None:
        """Hang up on everybody."""
        self.listener.close()
        for client in list(self.clients):
            client.gone("")


class Client:
    """A client of the control port: requests come in, replies go out, one after the other."""

    def __init__(self, control: Control, connection: socket.socket) -> None:
        self.control, self.server, self.connection = control, control.server, connection
        self.incoming = bytearray()
        self.waiting = self.too_long = False
        self.stream = Stream(self.server.loop, connection.fileno(), self.take, self.gone, self.room, QUEUE, self.ended)

    def room(self) -> int:
        """Nothing is read while a reply is owed, or replies are not read."""
        return 0 if self.waiting or self.stream.outgoing else LONGEST

    def take(self, data: bytes) -> None:
        """Requests, or pieces of them."""
        self.incoming += data
        self.work()

    def ended(self) -> None:
        """No more requests will come."""
        self.incoming += b"\n"
        self.work()

    def work(self) -> None:
        """Answer what has come."""
        while not self.waiting and self.stream.open:
            line, end, rest = self.incoming.partition(b"\n")
            self.too_long |= len(line) > LONGEST
            if not end:
                if self.too_long:
                    self.incoming.clear()
                if self.stream.at_end:
                    self.stream.finish()
                return
            self.incoming = rest
            if self.too_long:
                self.reply({}, {"error": f"a request of more than {LONGEST} bytes"})
                self.too_long = False
            elif line.strip():
                self.answer(bytes(line))

    def answer(self, line: bytes) -> None:
        """One request."""
        request: Reply = {}
        try:
            request = read(line)
            found = Requests(self.server, self).perform(request)
            if found is not None:
                self.reply(request, found)
        except (SlewlineError, TypeError, ValueError, KeyError) as error:
            self.reply(request, {"error": str(error)})

    def wait(
        self,
        request: Reply,
        reply: Callable[[bool], Reply],
        met: Callable[[], bool],
        limit_ps: int,
        when: Callable[[], int | None] | None = None,
        nets: Iterable[Net] = (),
    ) -> None:
        """Owe a reply until a condition comes about, or an instant."""
        self.waiting = True

        def done(met: bool) -> None:
            self.waiting = False
            self.reply(request, reply(met))
            self.server.loop.ask(self.go_on)

        self.server.pace.wait(Wait(met, limit_ps, done, when, nets))

    def go_on(self) -> None:
        """Requests that have come meanwhile, and those that are still to be read."""
        self.work()
        self.stream.resume()

    def reply(self, request: Reply, found: Reply) -> None:
        """One line."""
        if "id" in request:
            found = {"id": request["id"]} | found
        self.stream.write(json.dumps(found | {"time_ps": self.server.bench.now_ps}).encode() + b"\n")

    def gone(self, _why: str) -> None:
        """The client has gone; what it waited for may come about all the same."""
        self.stream.close()
        self.connection.close()
        if self in self.control.clients:
            self.control.clients.remove(self)


def read(line: bytes) -> Reply:
    """A request.

    Raises:
        UsageError: no JSON object with a known "do".
    """
    try:
        request: Any = json.loads(line)
    except (ValueError, RecursionError):
        raise UsageError(f'{line[:60]!r} is not JSON; expected a line such as {{"do": "status"}}') from None
    do = request.get("do") if isinstance(request, dict) else request
    if not isinstance(do, str) or do not in KEYS:
        raise UsageError(f"do {do!r}; allowed {', '.join(KEYS)}")
    needed, optional = KEYS[do]
    for key in needed:
        if key not in request:
            raise UsageError(f"{do}: needs {', '.join(needed)}; {key} is missing")
    for key in request:
        if key in TEXTS and not isinstance(request[key], str):
            raise UsageError(f"{do}: {key} {request[key]!r}; expected text")
        if key not in ("do", "id", *needed, *optional):
            raise UsageError(f"{do}: {key} is unknown; allowed {', '.join((*needed, *optional)) or 'nothing'}")
    return dict(request)


KEYS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {  # what a request needs, and what it may have
    "drive": (("pin", "level"), ()),
    "release": (("pin",), ()),
    "pulse": (("pin", "level", "width"), ()),
    "read": (("pins",), ()),
    "advance": (("time",), ()),
    "until": ((), ("pin", "level", "chip", "position", "axis", "timeout")),
    "fault": (("kind",), ("line", "to", "count", "chance", "seed", "chip")),
    "clear": ((), ("line", "chip")),
    "power": (("chip", "on"), ()),
    "status": ((), ()),
    "steps": (("chip",), ("start", "stop", "axis")),
    "quit": ((), ()),
}


class Requests:
    """What each request does; None: the reply comes later."""

    def __init__(self, server: Server, client: Client) -> None:
        self.server, self.client, self.bench = server, client, server.bench

    def perform(self, request: Reply) -> Reply | None:
        """Do what a request says."""
        found: Reply | None = getattr(self, f"do_{request['do']}")(request)
        return found

    def chip(self, name: str) -> Chip:
        """A chip by its name."""
        if name not in self.bench.chips:
            raise UsageError(f"no chip {name!r}; there are: {', '.join(self.bench.chips)}")
        return self.bench.chips[name]

    def axis(self, request: Reply) -> OneAxis:
        """An axis of a chip, the first one unless another is named."""
        return self.chip(request["chip"]).axis(request.get("axis", 1))

    def do_drive(self, request: Reply) -> Reply:
        self.bench.pin(request["pin"]).drive(request["level"])
        return {}

    def do_release(self, request: Reply) -> Reply:
        self.bench.pin(request["pin"]).release()
        return {}

    def do_pulse(self, request: Reply) -> Reply:
        self.bench.pin(request["pin"]).pulse(request["level"], request["width"])
        return {}

    def do_read(self, request: Reply) -> Reply:
        if not isinstance(request["pins"], list) or not all(isinstance(name, str) for name in request["pins"]):
            raise UsageError(f'pins {request["pins"]!r}; expected a list such as ["x.rdy"]')
        return {"levels": {name: self.bench.pin(name).level for name in request["pins"]}}

    def do_advance(self, request: Reply) -> None:
        if not self.server.pace.lockstep:
            raise UsageError("advance: time follows the wall clock here; start the server with --lockstep")
        end = self.bench.now_ps + picoseconds(request["time"])
        self.client.wait(request, lambda _met: {}, lambda: False, end)

    def do_until(self, request: Reply) -> None:
        condition = self.condition(request)
        end = self.bench.now_ps + picoseconds(request.get("timeout", "60 s"))
        self.client.wait(request, lambda met: {"met": met}, condition.met, end, condition.foreseen, condition.nets)

    def condition(self, request: Reply) -> Condition:
        """A pin with its level, or a chip with its position."""
        if {"pin", "level"} <= set(request) and not {"chip", "position"} & set(request):
            return self.bench.pin(request["pin"]).is_(request["level"])
        if {"chip", "position"} <= set(request) and not {"pin", "level"} & set(request):
            if not isinstance(request["position"], int):
                raise UsageError(f"position {request['position']!r}; expected a whole number")
            return self.axis(request).reaches(request["position"])
        raise UsageError("until: give pin and level, or chip and position")

    def line(self, name: str) -> SerialLine:
        """A serial line by its name."""
        lines = {line.name: line for line in self.server.lines.values() if isinstance(line, SerialLine)}
        if name not in lines:
            raise UsageError(f"no serial line {name!r}; there are: {', '.join(lines) or 'none'}")
        return lines[name]

    def eeprom(self, request: Reply, fails: bool) -> Reply:
        """Let the EEPROM of a module fail, or no more."""
        chip = self.chip(request["chip"])
        if not hasattr(chip, "eeprom_fault"):
            raise UsageError(f"chip {chip.name!r}: a {chip.sheet.part} has no EEPROM")
        if {"line", "to", "count", "chance", "seed"} & set(request) or request.get("kind", "eeprom") != "eeprom":
            raise UsageError(f"{request['do']}: a chip has the kind eeprom alone; all others are those of a line")
        chip.eeprom_fault = fails
        return {}

    def do_fault(self, request: Reply) -> Reply:
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

    def do_clear(self, request: Reply) -> Reply:
        if "chip" in request:
            return self.eeprom(request, False)
        if "line" not in request:
            raise UsageError("clear: needs line or chip")
        line = self.line(request["line"])
        line.to_chip.clear()
        line.to_host.clear()
        return {"hits": {"chip": line.to_chip.done, "host": line.to_host.done}}

    def do_power(self, request: Reply) -> Reply:
        if not isinstance(request["on"], bool):
            raise UsageError(f"on {request['on']!r}; allowed true, false")
        self.chip(request["chip"]).power(request["on"])
        return {}

    def do_status(self, _request: Reply) -> Reply:
        return status(self.server)

    def do_steps(self, request: Reply) -> Reply:
        axis = self.axis(request)
        start, stop = request.get("start", 0), request.get("stop", self.bench.now_ps)
        count = axis.motor.count(moment(start), min(moment(stop), self.bench.now_ps))
        if count > MOST_STEPS:
            raise UsageError(f"steps: {count} of them; ask for windows of at most {MOST_STEPS}")
        steps = axis.steps(start, stop)
        return {name: getattr(steps, name).tolist() for name in ("times_ps", "directions", "positions")}

    def do_quit(self, _request: Reply) -> Reply:
        self.server.stop()
        return {}
