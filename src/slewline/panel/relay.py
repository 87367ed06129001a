"""The connection between a page and the control port: each message is one line, which passes unchanged.

    page  --- one websocket ---  relay  --- TCP ---  control port

The first message from a page contains the token from the page's address; a page without a token is read-only.  The
token of the control port itself is sent from here and never reaches a browser.

The control port answers the requests on a connection in order, so a request that waits (`until`, `step`) would block
all later ones, including `pause`.  Each request that waits therefore has its own connection.

Memory use is bounded: a message is passed on before the next one is read, in both directions, so a side that does not
read blocks only the messages sent to it; a page has at most `WAITS` waiting requests.
"""

from __future__ import annotations

import asyncio
import hmac
import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from ..links.control.requests import READING

WAITING = frozenset(("until", "step", "advance"))
NEVER = frozenset(("quit",))  # reserved for the owner of the server
LONGEST = 1 << 16  # characters of a message to the server
LONGEST_REPLY = 1 << 24  # bytes of a line from the server
WAITS = 4
CLIENTS = 16
GREETING_S = 10.0  # time for a page to send its token
CONNECT_S = 5.0

POLICY, TOO_BIG, FULL, WRONG_TOKEN, GONE = 1008, 1009, 1013, 4403, 4502  # codes with which a websocket is closed


class Hangup(Exception):
    """A request to close the websocket.

    Args:
        code: the websocket close code; codes of 4000 and above are the panel's own.
        why: the reason, shown by the page.
    """

    def __init__(self, code: int, why: str) -> None:
        super().__init__(why)
        self.code, self.why = code, why


class NotAllowed(Exception):
    """The refusal of a request from a page; the request is not passed on to the control port.

    Args:
        why: the error in the reply.
        number: the `id` of the request; None if it has none.
    """

    def __init__(self, why: str, number: Any = None) -> None:
        super().__init__(why)
        self.reply = json.dumps({"error": why} | ({} if number is None else {"id": number}))


@dataclass(frozen=True)
class Access:
    """The address of the control port, and the permissions of pages."""

    host: str
    port: int
    token: str  # the page's token
    control_token: str | None = None
    read_only: bool = False
    token_needed: bool = False  # required for reading, too

    def writes(self, greeting: str) -> bool:
        """Return whether the page that sends this first message may operate the bench.

        Raises:
            Hangup: the message is not valid, or its token is wrong, or missing where it is needed.
        """
        try:
            token = parsed(greeting).get("token")
        except NotAllowed as error:
            raise Hangup(POLICY, str(error)) from None
        if token is None and not self.token_needed:
            return False
        if not isinstance(token, str) or not same(token, self.token):
            raise Hangup(WRONG_TOKEN, "The token in the address of the page is not the token of this panel.")
        return not self.read_only


def same(one: str, other: str) -> bool:
    """Return whether two tokens are equal, in a time that does not depend on the number of equal characters."""
    return hmac.compare_digest(one.encode("utf-8", "replace"), other.encode("utf-8"))


def parsed(text: str) -> dict[str, Any]:
    """Return a message as the server will read it.

    Raises:
        NotAllowed: the message is too long, is not an object, or is more than one line: JSON allows line feeds
            between its tokens, and the server would read the text after a line feed as a separate, unchecked request.
    """
    if len(text.encode("utf-8", "replace")) > LONGEST:
        raise NotAllowed(f"the request has more than {LONGEST} bytes")
    if "\n" in text or "\r" in text:
        raise NotAllowed("the request contains a line break; expected one line")
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise NotAllowed('expected an object such as {"do": "status"}')
    return found


def checked(text: str, writes: bool) -> str:
    """Return the verb of a page's request; `writes`: the page may operate the bench.

    Raises:
        NotAllowed: the request is not valid, no page may use its verb, or the page is read-only and the verb
            does more than read.
    """
    request = parsed(text)
    do, number = request.get("do"), request.get("id")
    if not isinstance(do, str) or do in NEVER:
        raise NotAllowed(f"{do}: not allowed from a page", number)
    if not writes and do not in READING:
        raise NotAllowed(f"{do}: this page is read-only", number)
    return do


class Relay:
    """A connected page."""

    def __init__(self, page: WebSocket, access: Access) -> None:
        self.page, self.access = page, access
        self.sending = asyncio.Lock()
        self.waits: set[asyncio.Task[None]] = set()

    async def run(self, admit: Callable[[Relay, bool], object]) -> None:
        """Pass messages in both directions until one side has disconnected.

        Args:
            admit: called with this relay, and with True if the page has sent a token, else False; it raises
                `Hangup` if too many pages with a token, or without one, are open already.
        """
        try:
            await self.page.accept()
            async with asyncio.timeout(GREETING_S):
                greeting = await self.page.receive_text()
        except TimeoutError:
            await self.hang_up(Hangup(POLICY, "No token was received in time."))
            return
        except KeyError as error:
            await self.hang_up(error)
            return
        except (WebSocketDisconnect, RuntimeError):  # RuntimeError: it had disconnected before it was accepted
            return
        try:
            writes = self.access.writes(greeting)
            admit(self, parsed(greeting).get("token") is not None)
            reader, writer = await self.connected()
        except Hangup as error:
            await self.hang_up(error)
            return
        try:
            await self.send(json.dumps({"event": "panel", "writes": writes}))
            await first_to_end(self.upwards(writer, writes), self.downwards(reader))
        except (Hangup, KeyError) as error:
            await self.hang_up(error)
        except OSError:
            await self.hang_up(Hangup(GONE, "The server has ended the connection."))
        except (WebSocketDisconnect, RuntimeError):
            # The page disconnected during a send; a later call on it raises RuntimeError.
            if self.page.application_state is WebSocketState.CONNECTED:
                raise
        finally:
            for task in list(self.waits):
                task.cancel()
            writer.transport.abort()

    async def send(self, text: str) -> None:
        """Send a message to the page, once the page has read the earlier messages."""
        async with self.sending:
            await self.page.send_text(text)

    async def hang_up(self, error: Hangup | KeyError) -> None:
        """Close the websocket because of `error`; a KeyError means that the page has sent a non-text message."""
        code, why = (error.code, error.why) if isinstance(error, Hangup) else (POLICY, "Messages are text.")
        with suppress(WebSocketDisconnect, RuntimeError):
            await self.page.close(code, why)

    async def connected(self) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
        """Return an authenticated connection to the control port.

        Raises:
            Hangup: the control port does not answer, or needs a different token.
        """
        where = f"{self.access.host}:{self.access.port}"
        try:
            async with asyncio.timeout(CONNECT_S):
                reader, writer = await asyncio.open_connection(self.access.host, self.access.port, limit=LONGEST_REPLY)
                if self.access.control_token is not None:
                    greeting = {"token": self.access.control_token, "do": "read", "pins": []}
                    writer.write(f"{json.dumps(greeting)}\n".encode())
                    if "error" in json.loads(await reader.readline() or b'{"error": ""}'):
                        writer.transport.abort()
                        raise Hangup(GONE, f"The control port at {where} needs a different token.")
        except (OSError, ValueError, TimeoutError):
            raise Hangup(GONE, f"There is no server at {where}.") from None
        return reader, writer

    async def upwards(self, writer: asyncio.StreamWriter, writes: bool) -> None:
        """Pass on the page's requests to the control port, but refuse requests that are not allowed."""
        while True:
            text = await self.page.receive_text()
            try:
                if checked(text, writes) in WAITING:
                    self.wait(text)
                    continue
            except NotAllowed as error:
                await self.send(error.reply)
                continue
            writer.write(f"{text}\n".encode("utf-8", "replace"))
            await writer.drain()

    async def downwards(self, reader: asyncio.StreamReader) -> None:
        """Pass on replies and events to the page; read none from the control port while the page does not read."""
        while True:
            await self.send(await line_of(reader))

    def wait(self, text: str) -> None:
        """Start a task that passes on a request whose reply may take a long time.

        Raises:
            NotAllowed: `WAITS` such requests of this page are already waiting.
        """
        if len(self.waits) >= WAITS:
            raise NotAllowed(f"{WAITS} requests are already waiting; wait until one ends", json.loads(text).get("id"))
        task = asyncio.create_task(self.wait_for(text))
        self.waits.add(task)
        task.add_done_callback(self.waits.discard)

    async def wait_for(self, text: str) -> None:
        """Send a request to the control port on a connection of its own, and pass on the reply to the page."""
        number = json.loads(text).get("id")
        try:
            reader, writer = await self.connected()
        except Hangup as error:
            await self.send(NotAllowed(error.why, number).reply)
            return
        try:
            writer.write(f"{text}\n".encode("utf-8", "replace"))
            await self.send(await line_of(reader))
        except Hangup as error:
            await self.send(NotAllowed(error.why, number).reply)
        except (OSError, WebSocketDisconnect, RuntimeError):
            pass  # the page or the server has disconnected; the other two tasks detect that
        finally:
            writer.transport.abort()


async def line_of(reader: asyncio.StreamReader) -> str:
    """Return the next line from the control port.

    Raises:
        Hangup: the connection has ended, or the line is too long.
    """
    try:
        line = await reader.readline()
    except ValueError:
        raise Hangup(TOO_BIG, f"A reply from the server has more than {LONGEST_REPLY} bytes.") from None
    if not line.endswith(b"\n"):
        raise Hangup(GONE, "The server has ended the connection.")
    return line[:-1].decode("utf-8", "replace")


async def first_to_end(*coroutines: Any) -> None:
    """Run coroutines until one of them ends, then cancel the others; if it failed, raise its error.

    A page that disconnects is not an error.
    """
    tasks = [asyncio.ensure_future(coroutine) for coroutine in coroutines]
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
    for task in done:
        with suppress(WebSocketDisconnect):
            task.result()
