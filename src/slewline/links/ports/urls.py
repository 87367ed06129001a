"""Ports of other programs, by pySerial URL: the reasons why one cannot be opened, or why a server has closed it."""

from __future__ import annotations

import os
import re
import socket
from contextlib import suppress
from typing import Any

DEVICE = "/dev/ttyUSB0 or COM3"
SCHEMES = ("socket", "rfc2217")
SERVED = tuple(f"{scheme}://" for scheme in SCHEMES)
TAIL = 200  # last bytes received, which may be a message of the server
HANGS_UP_S = 0.5  # time in which a server with a host explains why it refuses a second one
DISMISSED = re.compile(rb"slewline: ([ -~]{1,150})\r\n\Z")  # as `dismiss` in tcp.py writes it
ADDRESS = re.compile(r"(?:tcp://|telnet://)?((?:[\w.-]+|\[[0-9A-Fa-f:]+\]):[0-9]{1,5})", re.ASCII)
NUMBER = re.compile(r"[0-9]{2,5}", re.ASCII)


def dismissal(received: bytes) -> str:
    """Return the reason that a server gave in its last line for closing the connection; empty if none."""
    found = DISMISSED.search(received[-TAIL:])
    return f"the server reports: {found[1].decode('ascii')}; end the other program, and call again" if found else ""


def dismissed(where: str, line: Any = None, received: bytes = b"") -> str:
    """Return the reason why a server has closed the connection, from its last bytes or by connecting again.

    The reason is empty if unknown.  When pySerial opens a port, it discards bytes that the server sent
    immediately, such as the reason.

    Args:
        where: the URL of the port.
        line: the pySerial port that was lost.
        received: the last bytes received.
    """
    found = bytearray(received)
    with suppress(Exception):  # a lost port fails in many ways
        while line is not None and len(found) < TAIL and (data := line.read(1)):
            found += data
    if found or not (place := _place(where)):
        return dismissal(bytes(found))
    with suppress(OSError), socket.create_connection(place, HANGS_UP_S) as end:
        while len(found) < TAIL and (data := end.recv(TAIL)):
            found += data
    return dismissal(bytes(found))


def unopened(where: str, error: Exception) -> str:
    """Return the reason why the port of another program was not opened, and a remedy.

    The result is empty if `where` is a device.

    Args:
        where: the URL or device.
        error: the exception that pySerial raised.
    """
    scheme, found, _ = where.partition("://")
    if not found or f"{scheme}://" in ("tcp://", "telnet://"):
        if (meant := _address(where)) and not os.path.exists(where):
            return f"is an address; write the port of another program as socket://{meant}, a device {DEVICE}"
        return ""
    if scheme not in SCHEMES:
        if "not known" not in str(error):
            return ""
        return (
            f"{scheme}:// is not supported here; allowed: a device, such as {DEVICE}, socket://HOST:PORT and "
            "rfc2217://HOST:PORT; slewline serve prints the URL of its port"
        )
    place = _place(where)
    if place is None:
        return f"expected {scheme}://HOST:PORT, such as {scheme}://127.0.0.1:4001, with a port of 1 to 65535"
    host, port = place
    cause = error.__context__ if isinstance(error.__context__, OSError) else error
    if isinstance(cause, ConnectionRefusedError):
        return (
            f"connection refused: nothing listens at {host}:{port}; start its server first, or correct the address "
            "(slewline serve prints the URL of its port)"
        )
    if isinstance(cause, socket.gaierror):
        return f"the name {host!r} cannot be resolved; correct it, or give the address in numbers"
    if isinstance(cause, TimeoutError):
        return f"no answer from {host}; check that it is on, and check the network and its firewall"
    if scheme == "rfc2217" and "RFC2217" in str(error):
        return dismissed(where) or (
            f"the server does not speak RFC 2217; end any other program on the port, or write socket://{host}:"
            f"{port} if it is a plain TCP port"
        )
    number = getattr(cause, "errno", None)
    return f"{os.strerror(number) if number else cause}; check the address, the network and the server"


def no_device(where: str) -> str:
    """Return a message if a text is an address or URL, and so not a serial port; empty if it is neither."""
    if os.path.exists(where) or not (where.startswith(SERVED) or _address(where)):
        return ""
    return f"an address, not a serial port; name a device, such as {DEVICE}; --tcp opens a TCP port"


def _place(where: str) -> tuple[str, int] | None:
    """Return the host and port of a socket:// or rfc2217:// URL; None if `where` is not a valid one."""
    scheme, _, address = where.partition("://")
    host, _, port = address.partition("?")[0].partition("/")[0].rpartition(":")
    ok = scheme in SCHEMES and host and port.isdecimal() and 0 < int(port) < 1 << 16
    return (host.strip("[]"), int(port)) if ok else None


def _address(where: str) -> str:
    """Return HOST:PORT if the text is an address or a port number; empty if not."""
    if NUMBER.fullmatch(where):
        return f"127.0.0.1:{where}"
    found = ADDRESS.fullmatch(where)
    return found[1] if found else ""
