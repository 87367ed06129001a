"""The relay between a client and the process of a branch (a run that began with a return to the past)."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from ...core.time.timebase import PS_PER_S, picoseconds
from ..sockets.stream import SocketStream
from ..time.roads import connection, greeting
from .requests import READING
from .value_kinds import Data

if TYPE_CHECKING:
    from ..face import ClientFace

QUEUE = 1 << 24  # bytes of requests
HARMLESS = READING | {"record", "pause", "breakpoints"}  # requests that do not change a branch
MARK = "of the branch"  # the id of a request made here
MARKED = json.dumps({"id": MARK})[:-1].encode()


class Beyond:
    """A relay for one client: it forwards requests to the process of a branch, and sends replies and events back.

    Raises:
        OSError: the branch does not answer.
    """

    def __init__(self, client: ClientFace, where: str) -> None:
        self.client = client
        self.owed: list[Data] = []  # requests without a reply
        self.socket = connection(where)
        self.stream = SocketStream(client.server.loop, self.socket, self.take, self.gone, queue=QUEUE)
        self.rest = b""
        self.greeted = False
        self.stream.write(greeting(client.token))
        if client.every_s:
            self.send({"do": "subscribe", "every": in_ps(client.every_s), "id": MARK})

    def send(self, request: Data) -> None:
        """Send a request to the branch."""
        self.stream.write(json.dumps(request).encode() + b"\n")

    def forward(self, request: Data) -> None:
        """Forward a request from the client to the branch.

        This server also stores new breakpoints, for the next branch, and the new interval of a subscription.
        """
        client = self.client
        if request["do"] == "breakpoints":
            client.perform(request)  # requests for the next branch
        if request["do"] == "subscribe":
            client.watch(picoseconds(request["every"]) / PS_PER_S)
        if request["do"] not in HARMLESS:
            client.server.branches.touch()
        client.waiting = not client.every_s
        self.owed.append(request)
        self.send(request)

    def take(self, data: bytes) -> None:
        """Receive bytes from the branch, and pass replies and events on to the client."""
        client = self.client
        *lines, self.rest = (self.rest + data).split(b"\n")
        for line in lines:
            if not self.greeted:
                self.greeted = True
            elif line.startswith(b'{"event"'):
                client.stream.write(line + b"\n")
            elif line.startswith(MARKED):
                found = json.loads(line)
                client.event({"event": "view", "view": found.get("view", {}), "time_ps": found["time_ps"]})
            else:
                self.settle(line)
                client.stream.write(line + b"\n")
                client.waiting = False
                client.server.loop.ask(client.go_on)

    def settle(self, reply: bytes) -> None:
        """Record that a reply has come: remove the oldest outstanding request with the id of the reply."""
        known = json.loads(reply).get("id") if len(self.owed) > 1 else None  # a client that waits for each has one
        at = next((n for n, request in enumerate(self.owed) if request.get("id") == known), 0)
        del self.owed[at : at + 1]

    def gone(self, why: str) -> None:
        """Close the connection; answer outstanding requests with the error "the branch has ended: " and `why`."""
        self.close(f"the branch has ended: {why}")

    def close(self, why: str = "another branch is shown now") -> None:
        """Close the connection to the branch; answer the client's outstanding requests with the error `why`."""
        self.stream.close()
        self.socket.close()
        owed, self.owed = self.owed, []
        for request in owed:
            self.client.waiting = False
            self.client.reply(request, {"error": f"{request['do']}: {why}"})
        if owed:
            self.client.server.loop.ask(self.client.go_on)


def in_ps(seconds: float) -> int:
    """Return a time in seconds as whole picoseconds."""
    return int(seconds * PS_PER_S)
