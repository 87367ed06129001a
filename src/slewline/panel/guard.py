"""Protection against pages of other sites, foreign names bound to our address, and frames around the panel's page.

In each request a browser sends the name that it has resolved (Host) and, when it opens a websocket, the origin of the
page (Origin).  A foreign page cannot forge either; a foreign name bound to 127.0.0.1 shows up in Host.

No attacker can choose where a loopback name or an address leads, so these are accepted with any port:
through a tunnel (ssh -L) or a container (docker -p), the port seen by the browser differs from the one
on which we listen.
"""

from __future__ import annotations

import re
from ipaddress import ip_address
from typing import TYPE_CHECKING

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

LOOPBACK_NAMES = ("127.0.0.1", "localhost", "[::1]")
HOST = re.compile(r"(\[[0-9a-f:.]+\]|[^:\[\]]+)(?::([0-9]{1,5}))?")  # a name or an address, and a port
HTTP_PORT = "80"  # left out by browsers
POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' blob: data:",
        "connect-src 'self'",
        "frame-ancestors 'none'",
        "base-uri 'none'",
        "form-action 'none'",
    )
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class Guard:
    """A guard that refuses requests that no page of the panel would make, and adds security headers to answers.

    Args:
        app: the application, which answers all requests that are not refused.
        port: the port on which the panel listens.
        name: the name or address on which the panel listens.
        allow_remote: whether browsers on other machines may connect, by any address or by `name`.
    """

    def __init__(self, app: ASGIApp, port: int, name: str, allow_remote: bool = False) -> None:
        self.app, self.port, self.allow_remote = app, port, allow_remote
        self.name = f"[{name}]" if ":" in name else name.lower()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request or a new websocket to the application, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        why = self.refused(Headers(scope=scope), scope["type"] == "websocket")

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers.update(HEADERS)
                if why is not None:
                    headers["Connection"] = "close"
            await send(message)

        if why is None:
            await self.app(scope, receive, send_guarded)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close"})  # before it is accepted: 403
        else:
            await PlainTextResponse(f"{why}\n", 403)(scope, receive, send_guarded)

    def refused(self, headers: Headers, is_socket: bool) -> str | None:
        """Return the reason why a request is refused; None if it is allowed.  `is_socket`: it opens a websocket."""
        hosts = headers.getlist("host")
        if len(hosts) != 1 or not self.is_ours(hosts[0]):
            return "This panel has a different name or address."
        origins = headers.getlist("origin")
        if is_socket and origins != [f"http://{hosts[0].lower()}"]:
            return "Only the page of this panel may connect."
        return None

    def is_ours(self, host: str) -> bool:
        """Return whether a Host header has a loopback name, our name and port, or (with `allow_remote`) any address."""
        found = HOST.fullmatch(host.lower())
        if found is None:
            return False
        name, port = found.groups()
        if name in LOOPBACK_NAMES or (self.allow_remote and is_address(name)):
            return True
        return name == self.name and (port or HTTP_PORT) == str(self.port)


def is_address(name: str) -> bool:
    """Return whether a host name is in fact an address, which nobody can bind to another address."""
    try:
        return ip_address(name.strip("[]")) is not None
    except ValueError:
        return False
