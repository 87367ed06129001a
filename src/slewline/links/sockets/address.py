"""The addresses on which ports listen, HOST:PORT, and a check of which machines can reach them."""

from __future__ import annotations

import ipaddress
import socket

from ...errors import UsageError


def parse_address(text: str, allow_remote: bool = False) -> tuple[str, int]:
    """Return the host and port of "HOST:PORT"; port 0 means any free port, and no host means this machine.

    Raises:
        UsageError: the text is not of this form; or, without `allow_remote`, other machines can reach it.
    """
    host, colon, port = text.rpartition(":") if ":" in text else ("127.0.0.1", ":", text.strip())
    host = host.strip("[]")
    high = f": port {port} is above 65535" if port.isdecimal() and int(port) > 65535 else ""
    if not colon or not host or not port.isdecimal() or high or "/" in host:
        raise UsageError(
            f"address {text!r}{high}; expected HOST:PORT, such as 127.0.0.1:4001, or a port number of this machine, "
            "such as 4001 (0: any free port)"
        )
    if not allow_remote and not is_loopback(host):
        resolved(host, text)
        raise UsageError(f"address {text!r}: other machines could reach it; add --allow-remote to permit this")
    return host, int(port)


def is_loopback(host: str) -> bool:
    """Return whether a host is "localhost" or a loopback address; False for any other name."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def resolved(host: str, address: str) -> int:
    """Return the address family of a host name; `address` is the complete address, for the error message."""
    try:
        return socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)[0][0]
    except (OSError, UnicodeError):
        raise UsageError(
            f"address {address!r}: the name {host!r} cannot be resolved; give a name or address of this machine"
        ) from None
