"""A motor record on Channel Access: its addresses, port and lifetime."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from ..errors import SlewlineError, UsageError
from ..extras import needs

try:
    from caproto.asyncio.server import Context
except ImportError:
    raise SlewlineError(needs("a motor record needs", "epics")) from None

if TYPE_CHECKING:
    from .record import MotorRecord

LOOPBACK = "127.0.0.1"


def interfaces() -> list[str]:
    """Return the addresses to listen on: those in EPICS_CAS_INTF_ADDR_LIST, by default only 127.0.0.1."""
    return os.environ.get("EPICS_CAS_INTF_ADDR_LIST", "").split() or [LOOPBACK]


def port_of_server() -> int | None:
    """Return the port in EPICS_CAS_SERVER_PORT or, if unset, EPICS_CA_SERVER_PORT; None for the library's default.

    Raises:
        UsageError: the value is not a port.
    """
    named = None
    for name in ("EPICS_CA_SERVER_PORT", "EPICS_CAS_SERVER_PORT"):
        if text := os.environ.get(name, ""):
            if not (text.isascii() and text.isdecimal() and 0 < int(text) < 1 << 16):
                raise UsageError(
                    f"{name} {text!r} in the environment; allowed port numbers, 1 to 65535; set the variable to one, "
                    "or unset it"
                )
            named = int(text)
    return named


async def serve(record: MotorRecord, addresses: Sequence[str], began: Callable[[int], object], every_s: float) -> None:
    """Serve a record until the task is cancelled.

    Args:
        addresses: addresses of this machine to listen on.
        began: is called with the port once clients can connect.
        every_s: the interval at which the position of a motor at rest is queried (s).
    """
    if all(address.startswith("127.") for address in addresses):  # no packets into the network
        os.environ.setdefault("EPICS_CAS_AUTO_BEACON_ADDR_LIST", "NO")
        os.environ.setdefault("EPICS_CAS_BEACON_ADDR_LIST", LOOPBACK)
    log = logging.getLogger("caproto")  # it would print a traceback for every refused put
    log.propagate = False
    log.addHandler(logging.NullHandler())
    port = port_of_server()
    context = Context(dict(record.channels), list(addresses))
    context.ca_server_port = port or context.ca_server_port  # the library recognises only one of the two names

    async def begin(_library: object) -> None:
        began(context.port)
        await record.check(every_s)

    try:
        await context.run(startup_hook=begin)
    finally:
        for circuit in context.circuits:
            circuit.client.close()
        record.close()
