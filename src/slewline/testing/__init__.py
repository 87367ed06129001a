r"""For people who test host software: a pySerial URL handler, a pytest plugin, faults, assertions that tell.

import serial
import slewline.testing                                    # from now on, pySerial knows slewline://

port = serial.serial_for_url("slewline://gs-c200s", baudrate=9600, bytesize=7, parity="O", stopbits=2, timeout=1)
port.write(b"FV\r")                                        # the V is the checksum
port.read_until(b"\r")                                     # b"RR\r"
"""

from __future__ import annotations

from contextlib import suppress

with suppress(ImportError):  # without pySerial there are no URLs; all the rest works
    from serial import protocol_handler_packages

    protocol_handler_packages.append(__name__)
