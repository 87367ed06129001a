"""A part on a bus behind an adapter with framing, in virtual time: adapter://NAME, for pySerial.

The tools that read such a part wait for silences; here these cost nothing.  A character that passes the cable may be
spoiled, or the cable cut there.
"""

from __future__ import annotations

from itertools import count

from serial import SerialException, protocol_handler_packages

from slewline.links.lines.framing import FramedLine
from slewline.testing.controller import Controller
from slewline.testing.endpoint import SerialEndpoint
from slewline.testing.endpoints import BusEndpoint
from slewline.testing.rig import NAMED

protocol_handler_packages.append(__package__)
CABLES: dict[str, Cable] = {}  # by URL
NUMBERS = count(1)
BITS = 10  # of a character on the cable


class AdapterEndpoint(BusEndpoint):
    """A part, the host computer on its bus, and the line of text that leads there."""

    def reach(self):
        super().reach()
        self.line = FramedLine(self.chip.name, self.chip, self.pace, self.log, self.host)
        self.key = f"{self.chip.name}_{next(NUMBERS)}"
        NAMED[self.key] = self  # it stays when a port is closed
        self.url = Cable(self).url


def running(part):
    """Return a running part behind an adapter, as a fixture gives it."""
    rig = AdapterEndpoint(part)
    controller = Controller(rig, f"{part} behind an adapter", 0)
    rig.begin()
    return controller


class Cable:
    """A cable to an adapter, which spoils a character, or is cut before it.

    Args:
        way: 0: towards the part, 1: back.
        at: which character of it, from 0 on; -1: none.
        spoil: returns what becomes of it; None: the cable is cut.
    """

    def __init__(self, rig, way=0, at=-1, spoil=None):
        self.rig, self.way, self.left, self.spoil, self.is_cut = rig, way, at, spoil, False
        self.url = f"adapter://cable{next(NUMBERS)}"
        CABLES[self.url] = self

    def carry(self, data, way):
        """Return what comes out at the other end."""
        if way != self.way or self.left < 0:
            return data
        at, self.left = self.left, self.left - len(data)
        if at >= len(data):
            return data
        self.left = -1
        self.is_cut = self.spoil is None
        return data[:at] if self.is_cut else data[:at] + self.spoil(data[at]) + data[at + 1 :]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        del CABLES[self.url]


class Serial:
    """What pySerial opens for such a URL."""

    def __init__(self, port=None, baudrate=9600, timeout=None, **_settings):
        self.port, self.baudrate, self.timeout, self.is_open = port, baudrate, timeout, False

    def open(self):
        self.cable = CABLES[self.port]
        self.end = SerialEndpoint(self.cable.rig, self.port, "pySerial")
        self.is_open = True

    def close(self):
        if self.is_open:
            self.is_open = False
            self.end.hang_up()

    def must_be_whole(self):
        if self.cable.is_cut:
            self.close()
            raise SerialException("the cable is cut")

    def write(self, data):
        self.must_be_whole()
        self.end.sleep(len(data) * BITS / self.baudrate)  # so whoever asks again and again lets time pass
        self.end.write(self.cable.carry(bytes(data), 0))
        return len(data)

    def read(self, size=1):
        self.must_be_whole()
        return self.cable.carry(self.end.read(size, self.timeout), 1) if size else b""

    def read_until(self, end):
        line = b""
        while not line.endswith(end) and (character := self.read(1)):
            line += character
        return line

    @property
    def in_waiting(self):
        self.must_be_whole()
        return len(self.end.buffer)

    def sleep(self, duration):
        """Let virtual time pass."""
        self.end.sleep(duration)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
