"""Strangers: a browser can be made to send bytes to a port of this machine, and no such byte may reach a module.

A page of any site may POST to 127.0.0.1, with a body of its choice.  The browser puts a request line in front of it,
and no host of a module begins like one: so the first bytes of a connection are looked at.  As long as they may still
become a request line ("P", "POST") they are held back, but for `HOLD_S` at most: a host that types so is served all the
same, a little later.
"""

from __future__ import annotations

METHODS = ("GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE")
TARGETS = ("/", "*", "http:", "https:")
REQUESTS = tuple(f"{method} {target}".encode("ascii") for method in METHODS for target in TARGETS)
HOLD_S = 0.05


class Beginning:
    """The first bytes of a connection, until it is clear what they are."""

    def __init__(self) -> None:
        self.seen, self.held = b"", b""
        self.holding = self.undecided = True
        self.is_http = False

    def take(self, data: bytes) -> bytes:
        """Return what may be passed on now that these bytes have come; nothing, once it is known as a request."""
        if not self.undecided:
            return b"" if self.is_http else data
        self.seen += data
        self.held += data
        self.is_http = self.seen.startswith(REQUESTS)
        self.undecided = not self.is_http and any(request.startswith(self.seen) for request in REQUESTS)
        if self.is_http or (self.undecided and self.holding):
            return b""
        return self.release()

    def release(self) -> bytes:
        """Return what is held back, and hold back no more; a request that is completed later is known all the same."""
        held, self.held, self.holding = self.held, b"", False
        return held
