r"""Tests of host software: a pySerial URL handler, a pytest plugin, faults, assertions with explanations.

import serial
import slewline.testing                                    # pySerial then knows slewline://

port = serial.serial_for_url("slewline://gs-c200s", baudrate=9600, bytesize=7, parity="O", stopbits=2, timeout=1)
port.write(b"FV\r")                                        # the V is the checksum
port.read_until(b"\r")                                     # b"RR\r"
"""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..core.chip import Chip
    from .controller import Controller
    from .protocol_slewline import Serial

with suppress(ImportError):  # without pySerial there are no URLs; all the rest works
    from serial import protocol_handler_packages

    protocol_handler_packages.append(__name__)


def open_url(url: str, baudrate: int = 9600, **settings: Any) -> Serial:
    """Open a slewline:// URL, as `serial.serial_for_url` does, and return the port, typed as Serial.

    Args:
        url: the URL, such as "slewline://gs-c200s?chs=0".
        baudrate: the baud rate of the line.
        settings: pySerial settings, such as `bytesize=7`; with `allow_code=True`, the URL may name
            module:Class.

    Raises:
        UsageError: there is no such part, strap or option, or this is not a slewline:// URL.
    """
    from ..errors import UsageError
    from .protocol_slewline import Serial
    from .rig import SCHEME

    if not url.startswith(f"{SCHEME}://"):
        raise UsageError(f"{url!r}: expected {SCHEME}://PART; open other ports with serial.serial_for_url")
    return Serial(url, baudrate, **settings)


def running(part: str | type[Chip], on: str | None = None, seed: int = 0, **settings: Any) -> Controller:
    """Return a running module, to be closed at the end, preferably by a `with` block.

    The pytest fixtures return the same kind of object.

    Args:
        part: the name of a part, such as "gs-c200s", or of an entry point; or a class.
        on: the interface for a program: "url", "tcp", "pty" or "rfc2217"; or "host", a host computer on the
            module's bus.  The default is "url" or, for a part without a serial line, "host".
        seed: the seed for everything that is random, such as a garbled character.
        settings: straps, rate, store, and options of the part.

    Raises:
        UsageError: there is no such interface, or a setting is not allowed.
        UnknownName: there is no such part.
    """
    from . import endpoints

    return endpoints.running(part, on, seed, **settings)
