"""The web server of the panel: it serves the files of the page, and the page's websocket.

    panel = PanelServer(access, "127.0.0.1", 0)
    print(panel.url)
    panel.run()

`run` serves until `stop` is called, or SIGINT or SIGTERM arrives.
"""

from __future__ import annotations

import asyncio
import logging
import signal
import socket
from pathlib import Path
from typing import TYPE_CHECKING

import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.routing import Mount, WebSocketRoute
from starlette.staticfiles import StaticFiles
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from ..errors import UsageError
from ..links.sockets.address import resolved
from .guard import Guard
from .relay import CLIENTS, FULL, LONGEST, Access, Hangup, Relay

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

PAGE = Path(__file__).with_name("page")
CONNECTIONS = 64  # connections of all kinds
IDLE_S = 10  # longest silence, or longest incomplete request, of a connection
PING_S = 20.0
END_S = 1


class HttpConnection(H11Protocol):
    """An HTTP connection that is closed if no request arrives in time.

    If there are too many connections, the oldest idle one is closed, too.
    """

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Accept a connection; if there are then too many, close the oldest idle one, or this one if none is idle."""
        super().connection_made(transport)
        if len(self.connections) > CONNECTIONS:
            idle = [one for one in self.connections if isinstance(one, HttpConnection) and one.is_idle]
            if not idle:
                transport.abort()
                return
            min(idle, key=lambda one: one.deadline.when()).transport.abort()  # beyond that the oldest one is closed
        self.deadline = self.loop.call_later(IDLE_S, self.give_up)

    @property
    def is_idle(self) -> bool:
        """True while no request is being answered on this connection."""
        return hasattr(self, "deadline") and self.cycle is None

    def connection_lost(self, exc: Exception | None) -> None:
        """Record that the connection is closed."""
        if hasattr(self, "deadline"):
            self.deadline.cancel()
        super().connection_lost(exc)

    def give_up(self) -> None:
        """Close the connection if it is idle, but not if it has become a websocket."""
        if self in self.connections and self.cycle is None:
            self.transport.abort()


class PageSocket(WebSocketsSansIOProtocol):
    """A websocket that stops reading while the page leaves pongs unread: nothing else would limit their number."""

    is_paused = False

    def handle_ping(self) -> None:
        """Answer a ping from the page; stop reading while the page does not read the answers."""
        super().handle_ping()
        if not self.writable.is_set() and not self.read_paused:
            self.read_paused = self.is_paused = True
            self.transport.pause_reading()

    def resume_writing(self) -> None:
        """Start to read again, now that the page has read the answers."""
        super().resume_writing()
        if self.is_paused and self.queue.empty():  # otherwise the server waits for the next message of the page
            self.read_paused = False
            self.transport.resume_reading()
        self.is_paused = False


class Pages:
    """The open pages: pages with the token, read-only pages, and pages that have not sent their first message yet.

    Each of these kinds has its own limit, so that pages without the token never shut out the user's own pages.
    """

    def __init__(self) -> None:
        self.undecided: dict[Relay, asyncio.Task[None]] = {}  # the oldest one first
        self.own: set[Relay] = set()
        self.readers: set[Relay] = set()

    async def run(self, relay: Relay) -> None:
        """Serve a page until it is closed."""
        if len(self.undecided) >= CLIENTS:
            next(iter(self.undecided.values())).cancel()
        self.undecided[relay] = asyncio.ensure_future(relay.run(self.admit))
        try:
            await self.undecided[relay]
        except asyncio.CancelledError:
            if (task := asyncio.current_task()) is None or task.cancelling():
                raise  # the panel ends
            why = f"{CLIENTS} pages have connected and sent nothing yet; load this page again."
            await relay.hang_up(Hangup(FULL, why))
        finally:
            self.undecided.pop(relay, None)
            self.own.discard(relay)
            self.readers.discard(relay)

    def admit(self, relay: Relay, own: bool) -> None:
        """Count a page, now that its first message has arrived, as one with the token (`own`) or as one without it.

        Raises:
            Hangup: there are already too many pages of that kind.
        """
        self.undecided.pop(relay, None)
        pages = self.own if own else self.readers
        if len(pages) >= CLIENTS:
            kind = "with" if own else "without"
            raise Hangup(FULL, f"{CLIENTS} pages {kind} a token are already open; close one of them.")
        pages.add(relay)


def application(access: Access, port: int, name: str, allow_remote: bool = False) -> Starlette:
    """Return the web application.

    Args:
        access: the control port, and the permissions of pages.
        port: the port of the application.
        name: the name or address on which the application listens.
        allow_remote: whether browsers on other machines may connect.
    """
    pages = Pages()

    async def link(page: WebSocket) -> None:
        await pages.run(Relay(page, access))

    return Starlette(
        routes=[WebSocketRoute("/link", link), Mount("/", StaticFiles(directory=PAGE, html=True))],
        middleware=[Middleware(Guard, port=port, name=name, allow_remote=allow_remote)],
    )


class PanelServer:
    """A panel on its own port.

    Args:
        access: the control port, and the permissions of pages.
        host: the address on which the panel listens.
        port: the port number; 0: any free port.
        allow_remote: whether browsers on other machines may connect.

    Raises:
        UsageError: the port is in use.
    """

    def __init__(self, access: Access, host: str, port: int, allow_remote: bool = False) -> None:
        address = f"{host}:{port}"
        try:
            self.socket = socket.create_server((host, port), family=resolved(host, address), backlog=CONNECTIONS)
        except OSError as error:
            raise UsageError(f"address {address!r}: {error.strerror or error}; choose another address") from None
        self.port = self.socket.getsockname()[1]
        shown = f"[{host}]" if ":" in host else host
        self.url = f"http://{shown}:{self.port}/#token={access.token}"
        logging.getLogger("asyncio").setLevel(logging.ERROR)  # a closed page is not reported on the terminal
        self.server = uvicorn.Server(
            uvicorn.Config(
                application(access, self.port, host, allow_remote),
                http=HttpConnection,
                ws=PageSocket,
                ws_max_size=LONGEST,
                ws_ping_interval=PING_S,
                ws_ping_timeout=PING_S,
                ws_per_message_deflate=False,  # a small message could expand into a large one
                lifespan="off",
                log_config=None,
                log_level="error",
                access_log=False,
                proxy_headers=False,
                server_header=False,
                timeout_keep_alive=IDLE_S,
                timeout_graceful_shutdown=END_S,
            )
        )

    def run(self) -> None:
        """Serve until `stop` is called, or SIGINT or SIGTERM arrives."""
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: None)  # the server raises the signal again when it has ended
        asyncio.run(self.server.serve([self.socket]))

    def stop(self) -> None:
        """End `run`; may be called from any thread."""
        self.server.should_exit = True
