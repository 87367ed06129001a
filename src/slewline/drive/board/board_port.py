"""The serial port of a board: it never blocks, and reopening it does not reset the board."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from typing import Any, Protocol

from ...errors import UsageError
from ...extras import needs
from ...gate import error_number
from .boards import BAUD
from .reader_thread import PortReader
from .rehearsal import TWIN, TwinPort

KEPT = 64  # last bytes received, for the message that the sender is not a board
LISTED = "python -m serial.tools.list_ports lists all ports"


class BoardPort(Protocol):
    """A port that exchanges bytes with a board without blocking."""

    def read(self) -> bytes:
        """Return the bytes received since the last call."""

    def write(self, data: bytes) -> int:
        """Send bytes, or keep them until they can be sent; return the number accepted."""

    def fileno(self) -> int | None:
        """Return a descriptor on which a loop can wait; None if the port has none."""

    def close(self) -> None:
        """Close the port."""


def opened(name: str) -> BoardPort:
    """Open the port of a board with the given name, and return it; the name "twin" opens a software board.

    Raises:
        UsageError: the port cannot be opened.
    """
    return TwinPort() if name.lower() == TWIN else BoardSerial(name)


class BoardSerial:
    """A serial port to which a board is connected: 8N1, opened for exclusive use.

    Opening a port raises DTR, and a rising edge of DTR resets an Uno.  HUPCL is cleared, so that DTR stays
    high when the port is closed: the board is reset once, when its cable is connected, and then keeps its
    count.

    Args:
        name: the name of the port, such as "/dev/ttyUSB0" or "COM3".

    Raises:
        UsageError: the port does not exist, is in use, or may not be opened; or pySerial is not installed.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.received = bytearray()  # last bytes received
        self._open()

    def _open(self) -> None:
        try:
            import serial
        except ImportError:
            raise UsageError(needs("a board on a serial port needs", "serial")) from None
        self._unsent = b""
        try:
            self._port: Any = serial.Serial(self.name, BAUD, timeout=0, write_timeout=0, exclusive=True)
        except (OSError, ValueError) as error:
            raise UsageError(f"{self.name}: {_refused(error)}") from None
        with suppress(ImportError, OSError, AttributeError):
            self._keep_dtr()
        self._reader: PortReader | None = None
        with suppress(AttributeError, OSError):  # Windows has no descriptor, and its reads do not wait
            self._reader = PortReader(self._port.fileno())

    def _keep_dtr(self) -> None:
        """Keep DTR high when the port is closed (POSIX)."""
        import termios

        fd = self._port.fileno()
        attributes = termios.tcgetattr(fd)
        attributes[2] &= ~termios.HUPCL
        termios.tcsetattr(fd, termios.TCSANOW, attributes)

    def reopen(self) -> None:
        """Reopen the port after its cable was unplugged and reconnected.

        Raises:
            UsageError: for the same reasons as when the port is first opened.
        """
        self.close()
        self._open()

    def fileno(self) -> int | None:
        """Return the descriptor on which a loop can wait; None if this system has none, or the port is closed."""
        return None if self._reader is None else self._reader.fileno()

    def read(self) -> bytes:
        """Return all bytes received since the last call.

        Raises:
            OSError: the port is gone.
        """
        data: bytes = self._port.read(4096) if self._reader is None else self._reader.read()
        self.received += data
        del self.received[:-KEPT]
        if self._unsent:
            self.write(b"")
        return data

    def write(self, data: bytes) -> int:
        """Send bytes and return len(data); any that do not fit are kept for the next `read` or `write`.

        Raises:
            OSError: the port is gone.
        """
        unsent = self._unsent + data
        if unsent:
            self._unsent = unsent[self._port.write(unsent) or 0 :]
        return len(data)

    def close(self) -> None:
        """Close the port; the board keeps its supply, its count, and its outputs."""
        reader, self._reader = self._reader, None
        if reader is not None:
            reader.close()
        with suppress(OSError):
            self._port.close()


def _refused(error: Exception) -> str:
    """Return the reason why a port could not be opened, followed by a remedy."""
    number, text = error_number(error), str(error)
    if number == errno.ENOENT or isinstance(error, FileNotFoundError) or "FileNotFoundError" in text:
        return f"no such port; name the port of the board ({LISTED}), or {TWIN}, a simulated board"
    if number in (errno.EACCES, errno.EPERM) or "PermissionError" in text:
        if os.name == "nt":
            return "another program uses this port, or you have no permission; close the other program"
        return "no permission to open this port; add your user to its group (dialout, uucp), and log in again"
    if number in (errno.EBUSY, errno.EAGAIN) or "lock" in text:
        return "another program uses this port; close it"
    why = "not a serial port" if number == errno.ENOTTY else os.strerror(number) if number else text
    return f"{why}; name the serial port of the board ({LISTED})"
