"""A client of the control port, for asyncio programs: front ends, editors, tests.

    from slewline.links.clients.control_client import ControlClient

    client = await ControlClient.connect("127.0.0.1:4002")     # slewline serve ... --control 127.0.0.1:4002
    await client.request("pause")
    await client.subscribe("50 ms")
    await client.request("step", chip="x", by="instruction")
    print(client.now_ps, client.view["chips"]["x"]["counter"])
    async for event in client.events():                        # until the connection ends
        print(event["event"])
    await client.close()

The requests are described in docs/reference/control.md.  Several requests may be pending at the same
time: each has an id, which its reply repeats.
"""

from __future__ import annotations

import asyncio
import json
import os
import socket
from collections.abc import AsyncIterator
from contextlib import suppress
from typing import Any, Self

from ...core.time.hook import Hook
from ...errors import SlewlineError, UsageError
from ..sockets.address import parse_address

Data = dict[str, Any]
LONGEST = 1 << 26  # bytes of a reply: a complete dialogue may be long
ENDED = "the connection to the control port has ended"
ANSWER_S = 5.0  # timeout of the first request
NONE = "no control port answers there; use the address that slewline serve --control prints after control:"


class ConnectionEnded(SlewlineError, ConnectionError):
    """The loss of the connection: the server has terminated, or has closed it."""


class ControlClient:
    """A connection to a control port, made by `connect`.

    `view` is the view received by `subscribe`, with all later changes; `now_ps` is the latest virtual time
    received (ps).  `on_event` is called with every event, after `view` is updated; `on_end` is called with
    the reason when the connection has ended.
    """

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, token: str | None = None) -> None:
        self.view: Data = {}
        self.now_ps = 0
        self.open = True
        self.on_event: Hook[[Data]] = Hook()
        self.on_end: Hook[[str]] = Hook()
        self._reader, self._writer, self._token = reader, writer, token
        self._owed: dict[int, asyncio.Future[Data]] = {}  # by request number
        self._number = 0
        self._anew = False  # the next view is complete
        self._task = asyncio.create_task(self._read())

    @classmethod
    async def connect(cls, address: str, token: str | None = None, *, remote: bool = False) -> ControlClient:
        """Connect to a control port, HOST:PORT, and check that it answers.

        Args:
            token: the token of the server; None if the server has none.
            remote: True if the server may be on another machine.

        Raises:
            UsageError: the address is invalid, no control port answers there, or the token is wrong.
        """
        host, port = parse_address(address, remote)
        try:
            reader, writer = await asyncio.open_connection(host, port, limit=LONGEST)
        except OSError as error:
            own = not isinstance(error, socket.gaierror) and error.errno  # asyncio has its own messages
            why = os.strerror(own) if own else error.strerror or error
            raise UsageError(
                f"{address}: {why}; give the control port of a running server, or start one: slewline serve ... "
                f"--control {address}"
            ) from None
        client = cls(reader, writer, token)
        try:
            await asyncio.wait_for(client.request("read", pins=[]), ANSWER_S)
        except (TimeoutError, ConnectionEnded) as error:
            await client.close()
            how = "connection closed" if isinstance(error, ConnectionEnded) else f"no answer within {ANSWER_S:g} s"
            raise UsageError(f"{address}: {NONE} ({how})") from None
        except BaseException:
            await client.close()
            raise
        return client

    # ------------------------------------------------------------------------------------------------------- requests
    async def request(self, do: str, **keys: Any) -> Data:
        """Send the request `do` with its keys, and return the reply.

        Raises:
            UsageError: the server refuses the request; the message is the server's.
            ConnectionEnded: the connection ended before the reply.
        """
        if not self.open:
            raise ConnectionEnded(ENDED)
        self._number += 1
        line = {"do": do, "id": self._number, **keys}
        if self._token is not None:
            line["token"], self._token = self._token, None
        owed: asyncio.Future[Data] = asyncio.get_running_loop().create_future()
        self._owed[self._number] = owed
        self._writer.write(json.dumps(line).encode() + b"\n")
        with suppress(ConnectionError):
            await self._writer.drain()
        reply = await owed
        if "error" in reply:
            raise UsageError(str(reply["error"]))
        return reply

    async def subscribe(self, every: str) -> Data:
        """Subscribe to events, at a minimum interval such as "50 ms"; return the view.  Later events update `view`."""
        self.view = (await self.request("subscribe", every=every)).get("view", self.view)
        return self.view

    async def events(self) -> AsyncIterator[Data]:
        """Yield events from this moment until the connection ends."""
        queue: asyncio.Queue[Data | None] = asyncio.Queue()
        take, end = self.on_event.add(queue.put_nowait), self.on_end.add(lambda _why: queue.put_nowait(None))
        try:
            while self.open and (event := await queue.get()) is not None:
                yield event
        finally:
            self.on_event.remove(take)
            self.on_end.remove(end)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def close(self) -> None:
        """Close the connection, and abandon pending requests; a second call does nothing."""
        self._end("closed")
        self._task.cancel()
        with suppress(asyncio.CancelledError):
            await self._task
        self._writer.close()
        with suppress(OSError):
            await self._writer.wait_closed()

    # -------------------------------------------------------------------------------------------------------- reading
    async def _read(self) -> None:
        why = ENDED
        try:
            while line := await self._reader.readline():
                self._take(json.loads(line))
        except (OSError, ValueError) as error:
            why = f"{ENDED}: {error}"
        self._end(why)

    def _take(self, line: Data) -> None:
        """Handle a line from the server: a reply or an event."""
        self.now_ps = line.get("time_ps", self.now_ps)
        if "event" not in line:
            number: int = line.get("id", next(iter(self._owed), 0))  # the error for a refused first line has no number
            owed = self._owed.pop(number, None)
            if owed is not None and not owed.done():  # its caller may have timed out
                owed.set_result(line)
            return
        if line["event"] == "branch":
            self._anew = True
        elif line["event"] == "view":
            self.view = line["view"] if self._anew else merged(self.view, line["view"])
            self._anew = False
        self.on_event(line)

    def _end(self, why: str) -> None:
        if not self.open:
            return
        self.open = False
        for owed in self._owed.values():
            if not owed.done():
                owed.set_exception(ConnectionEnded(why))
        self._owed.clear()
        self.on_end(why)


def reach(address: str, token: str | None = None) -> None:
    """Check that a control port answers at HOST:PORT, so that errors are reported before anything is displayed.

    Raises:
        UsageError: no control port answers, or the token is missing or wrong.
    """

    async def ask() -> None:
        await (await ControlClient.connect(address, token, remote=True)).close()

    try:
        asyncio.run(ask())
    except UsageError as error:
        wants = "" if "token" not in str(error) else "; give it with --token, or in the environment, SLEWLINE_TOKEN"
        raise UsageError(f"--attach {error}{wants}") from None


def merged(old: Any, new: Any) -> Any:
    """Return a view with changes merged in: objects key by key, lists of objects item by item if equally long.

    All other values are replaced.
    """
    if isinstance(old, dict) and isinstance(new, dict):
        return {**old, **{key: merged(old[key], value) if key in old else value for key, value in new.items()}}
    if not isinstance(old, list) or not isinstance(new, list) or len(old) != len(new):
        return new
    if not all(isinstance(each, dict) for each in (*old, *new)):
        return new
    return [merged(one, two) for one, two in zip(old, new, strict=True)]
