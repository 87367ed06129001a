"""A pseudo-terminal: a device file that host software opens as a serial port, under the name of a link.

A Linux pseudo-terminal is not a UART.  It passes 8 bits per character, whatever rate and format the
host has set; a 7-bit line uses the lower 7.  It always reports 8 bits and no parity, which the C
library compares with the requested settings: a call that requests 7O2 fails (EINVAL), unless it
changes some other setting.  So the first open succeeds, and the second one, with the same request,
fails.  The remedy:

    packet mode with EXTPROC      the master wakes at every change of settings
    a marker after each change    a flag without effect; the next call clears it: this changes a setting
    PARODD inverted each time     so that even a call that only adds flags changes a setting, PARODD

The C library reads the settings back immediately.  Two markers alternate, so the settings that it
reads differ from the former ones, whether or not the server has already set the next marker.  A call
fails only if it comes before the server wakes: within a few tens of microseconds after the previous
call, or longer on a busy machine.  The host cannot detect the cause; the user is informed (`HINT`).
stty makes its own comparison, and always reports an error.  TCP and RFC 2217 do not have this problem.

macOS has no EXTPROC of this kind: a pseudo-terminal there is for hosts that use 8N1 (`PLAIN`).
"""

from __future__ import annotations

import os
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...closing import Closing
from ...errors import UsageError
from ...gate import LinkPlace
from ..lines.port_line import PortLine
from ..sockets import system
from ..sockets.loop import Loop
from ..sockets.stream import SocketStream
from .symbolic_link import DeviceLink

IFLAG, CFLAG, LFLAG, ISPEED, OSPEED = 0, 2, 3, 4, 5  # indices in the result of tcgetattr
REMEDY = "set 8N1 in the host, or serve with --tcp (socket://) or --rfc2217 (rfc2217://)"
HINT = (
    "a pty has no 7 data bits and no parity: a host that sets them twice within a millisecond, as pySerial "
    f"does for a timeout right after the open, gets EINVAL (invalid argument); {REMEDY}"
)
PLAIN = f"a pty of this system has 8 bits and no parity, and may refuse a host that sets 7O2; {REMEDY}"
NONE = "--pty needs Linux or macOS: this system has no pseudo-terminals; serve with --tcp or --rfc2217 instead"


class PacketStream(SocketStream):
    """The master of a pseudo-terminal in packet mode: each read begins with a byte that describes the rest.

    Args:
        changed: called when the settings of the pseudo-terminal may have changed.
    """

    def __init__(
        self,
        loop: Loop,
        end: system.Descriptor,
        line: PortLine,
        changed: Callable[[], object],
    ) -> None:
        self.changed = changed
        super().__init__(loop, end, line.take, lambda _why: None, line.room)

    def fetch(self, room: int) -> bytes | None:
        """Read a packet, and return its bytes after the first one; empty if only the settings have changed."""
        data = self.end.recv(room + 1)
        if data[:1] != b"\0":  # the settings have changed, or a queue was flushed
            self.changed()
        return data[1:]


class PtyPort(Closing):
    """A line on a pseudo-terminal, which does not show when a host connects or disconnects.

    Args:
        link: the name of a symbolic link, which is removed when the port closes; a link named in a bench
            file must be in the folder that the file's gate (`FileGate`) allows.

    Raises:
        UsageError: the link cannot be made, or its name is in use and is not an old link made by slewline;
            or the system has no pseudo-terminals.
    """

    def __init__(self, loop: Loop, line: PortLine, link: str | LinkPlace) -> None:
        if not hasattr(os, "openpty"):
            raise UsageError(NONE)
        if isinstance(link, str) and system.WINDOWS_PORT.fullmatch(link):
            raise UsageError(
                f"{link} is the name of a port on Windows, for --serial; give the path of a link, such as /tmp/{link}"
            )
        if not link:
            raise UsageError("a pty needs a link; give its path, such as /tmp/x")
        self.loop, self.line, self.place, self.where = loop, line, link, str(Path(str(link)))
        self.master, self.slave = os.openpty()  # without a slave of its own, the master fails when the host closes
        self.name = os.ttyname(self.slave)
        try:
            self._link = DeviceLink(link, self.name)
        except BaseException:
            self._hang_up()
            raise
        self.ours: list[object] = []  # the settings as set here
        self.turn = 0  # index of the next marker
        self._be_raw()
        end = system.Descriptor(self.master)
        if system.EXTPROC is None:
            self.stream = SocketStream(loop, end, line.take, lambda _why: None, line.room)
        else:
            loop.selector.urgent.add(self.master)
            self.stream = PacketStream(loop, end, line, self._changed)
        line.attach(self.name, self.stream.write, self.stream.resume)

    @property
    def hint(self) -> str:
        """Note for users whose host uses 7 data bits."""
        return PLAIN if system.EXTPROC is None else HINT

    # -------------------------------------------------------------------------------------------------- the settings
    def _be_raw(self) -> None:
        import fcntl
        import termios

        settings = termios.tcgetattr(self.slave)
        settings[0] = settings[1] = 0
        for code, baud in system.bauds().items():
            if baud == self.line.baud:
                settings[ISPEED] = settings[OSPEED] = code  # a program that sets no rate gets that of the line
        settings[LFLAG] = system.EXTPROC or 0
        termios.tcsetattr(self.slave, termios.TCSANOW, settings)
        if system.EXTPROC is not None:
            fcntl.ioctl(self.master, termios.TIOCPKT, struct.pack("i", 1))

    def _changed(self) -> None:
        import termios

        settings = termios.tcgetattr(self.slave)
        if settings == self.ours:
            return  # a change made here
        self._mark(settings)
        self.line.obey(bool(settings[CFLAG] & termios.CRTSCTS))
        if (baud := system.bauds().get(settings[OSPEED])) is not None and baud != self.line.baud:
            self.line.opened_at(baud)

    def _mark(self, found: list[Any]) -> None:
        """Set the settings `found`, plus the next marker, which the host's next call will clear."""
        import termios

        markers = (LFLAG, termios.IEXTEN), (IFLAG, termios.IGNBRK)
        self.turn = 1 - self.turn
        settings = [*found]
        for at, flag in markers:
            settings[at] &= ~flag
        at, flag = markers[self.turn]
        settings[at] |= flag
        settings[CFLAG] ^= termios.PARODD
        settings[LFLAG] |= system.EXTPROC or 0
        termios.tcsetattr(self.slave, termios.TCSANOW, settings)
        self.ours = termios.tcgetattr(self.slave)

    # ------------------------------------------------------------------------------------------------------- the end
    def again(self) -> PtyPort:
        """Return a new pseudo-terminal under the same name, to replace this one after it was closed."""
        return PtyPort(self.loop, self.line, self.place)

    def _shut(self) -> None:
        """Remove the link, and close the pseudo-terminal."""
        self._link.remove()
        self.stream.close()
        self.line.leave("closed")
        self._hang_up()

    def _hang_up(self) -> None:
        self.loop.selector.urgent.discard(self.master)
        os.close(self.master)
        os.close(self.slave)
