"""A real serial port of this machine: the host is at the far end of its cable.

Its rate and format are those of the line.  A character from the cable ends when the operating system
delivers it, and only then begins on the virtual line: the module receives it one character time later
than a module on the cable would, and the answer is late by another character time.

If the port disappears (an adapter that is unplugged), the server tries to open it again every half
second.

The loop cannot wait for a Windows COM port.  Two threads copy its bytes to a socket and back; the loop
waits for the other end of the socket.
"""

from __future__ import annotations

import errno
import os
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from threading import Thread
from typing import Any

from ...closing import Closing
from ...errors import SlewlineError, UsageError
from ...extras import needs
from ...gate import error_number
from ..lines.port_line import CableLine
from ..sockets.loop import Loop
from ..sockets.stream import CHUNK, SocketStream
from ..sockets.system import WINDOWS_PORT, Descriptor, pair
from .urls import TAIL, dismissal, no_device, unopened

try:
    import serial
except ImportError:
    raise SlewlineError(needs("a serial port needs", "serial")) from None

RETRY_S = 0.5
LOOK_S = 0.5  # a thread reads for at most this time before it checks whether to end


class Threads:
    """A serial port in the form of a socket: one thread copies from port to socket, the other one back."""

    def __init__(self, port: Any) -> None:
        self.port, self.why, self.over = port, "closed", False
        self.ours, self.theirs = pair()
        self.threads = [
            Thread(target=work, name=f"cable {port.name}", daemon=True) for work in (self._read, self._write)
        ]
        for thread in self.threads:
            thread.start()

    def _read(self) -> None:
        """Copy bytes from the cable, until the port fails or is closed."""
        with self._ending():
            while not self.over:
                data = self.port.read(1)
                if data:
                    self.theirs.sendall(data + self.port.read(min(self.port.in_waiting, CHUNK)))

    def _write(self) -> None:
        """Copy bytes to the cable."""
        with self._ending():
            while data := self.theirs.recv(CHUNK):
                self.port.write(data)

    @contextmanager
    def _ending(self) -> Iterator[None]:
        """Shut down the socket when one thread ends, so that the other one ends, too; keep any error as `why`."""
        try:
            yield
        except Exception as error:  # a port that is closed during a read fails in many ways
            self.why = str(error)
        with suppress(OSError):
            self.theirs.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """End the threads; the caller closes the port."""
        self.over = True
        self.ours.close()
        for stop in ("cancel_read", "cancel_write"):
            with suppress(Exception):
                getattr(self.port, stop)()
        for thread in self.threads:
            thread.join(2 * LOOK_S)
        self.theirs.close()


def refused(device: str, error: Exception, windows: bool = os.name == "nt") -> str:
    """Return the reason why a serial port could not be opened, and a remedy."""
    if WINDOWS_PORT.fullmatch(device) and not windows:
        return "the name of a port on Windows; on this system a serial port is /dev/ttyUSB0 or the like"
    number = error_number(error)
    if number in (errno.EACCES, errno.EPERM) and not windows:
        return "no permission to open this port; add your user to its group (dialout, uucp), and log in again"
    why = "not a serial port" if number == errno.ENOTTY else os.strerror(number) if number else str(error)
    return f"{why}; name a serial port that exists and that you may open (python -m serial.tools.list_ports)"


class DevicePort(Closing):
    """A line on a serial port of this machine.

    Args:
        report: called with a message when the port disappears, and when it is back.
        make: opens the port.  It must not accept URLs, which would let a bench file connect to any address.

    Raises:
        UsageError: the port is missing at the start, or cannot be opened.
    """

    def __init__(
        self,
        loop: Loop,
        line: CableLine,
        device: str,
        report: Callable[[str], object] = lambda _text: None,
        make: Callable[..., Any] = serial.Serial,
    ) -> None:
        self.loop, self.line, self.device, self.report, self.make = loop, line, device, report, make
        self.port: Any = None
        self._latest = b""  # received bytes, in which a server may explain why it closes
        self.threads: Threads | None = None
        try:
            self._open()
        except (OSError, ValueError) as error:
            why = no_device(device) if make is serial.Serial else unopened(device, error)
            raise UsageError(f"{device}: {why or refused(device, error)}") from None

    @property
    def where(self) -> str:
        """Name of the port."""
        return self.device

    def _open(self) -> None:
        word = self.line.setting.word
        self.port = self.make(
            self.device,
            int(self.line.setting.baud),
            bytesize=word.bits,
            parity=word.parity[0].upper(),
            stopbits=float(word.stop),
            timeout=LOOK_S,
            exclusive=True,
        )
        self.stream = SocketStream(self.loop, self._end(), self._take, self._lost, self.line.room)
        self.line.attach(self.device, self.stream.write, self.stream.resume)

    def _end(self) -> socket.socket | Descriptor:
        """Return the object that the loop can wait for: the descriptor of the port, or a socket that threads serve."""
        try:
            return Descriptor(self.port.fileno())
        except (AttributeError, OSError):  # io.UnsupportedOperation is an OSError
            self.threads = Threads(self.port)
            return self.threads.ours

    def _let_go(self, why: str) -> str:
        """Close the port; return the reason given by its threads, or `why` if it has no threads."""
        self.line.leave(why)
        threads, self.threads = self.threads, None
        if threads is not None:
            why = threads.why
            threads.close()
        self.port.close()
        return why

    def _take(self, data: bytes) -> None:
        self._latest = (self._latest + data)[-TAIL:]
        self.line.take(data)

    def _lost(self, why: str) -> None:
        why = self._let_go(why)
        why = dismissal(self._latest) or why
        self.report(f"{self.device}: gone ({why}); retrying until it is back")
        self.loop.after(RETRY_S, self._retry)

    def _retry(self) -> None:
        if self.closed:
            return
        try:
            self._open()
        except (OSError, ValueError):
            self.loop.after(RETRY_S, self._retry)
        else:
            self.report(f"{self.device}: back")

    def again(self) -> DevicePort:
        """Return a new port on the same device, to replace this one after it was closed."""
        return DevicePort(self.loop, self.line, self.device, self.report, self.make)

    def _shut(self) -> None:
        """Close the port."""
        if self.stream.open:
            self.stream.close()
            self._let_go("closed")
