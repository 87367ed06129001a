"""Ports of this machine for programs that are told their number beforehand."""

from __future__ import annotations

import socket
from random import SystemRandom

NOBODYS = range(20_000, 30_000)  # below those that a system gives to whoever asks for any: nobody gets one meanwhile


def free_port() -> int:
    """Return a port of loopback, of TCP and UDP, that nobody has."""
    while True:
        where = "127.0.0.1", SystemRandom().choice(NOBODYS)
        try:
            with socket.create_server(where), socket.socket(type=socket.SOCK_DGRAM) as probe:
                probe.bind(where)
                return where[1]
        except OSError:
            continue
