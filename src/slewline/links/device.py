"""A real serial port: the modules are at the far end of a cable.

Its rate and format are those of the line.  A character from the cable is over when the computer hands it over, and then
begins on the virtual line: the module hears it one character later than it would on the cable, and is heard one later.

A port that goes away (an adapter that is unplugged) is looked for every half second until it is back.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..errors import SlewlineError, UsageError
from .line import Line, SerialLine
from .loop import Loop
from .stream import Stream

try:
    import serial
except ImportError:
    raise SlewlineError("a serial port needs pyserial: pip install 'slewline[serial]'") from None

RETRY_S = 0.5


class DevicePort:
    """A line on a serial port of this machine.

    Args:
        tell: is told when the port goes away, and when it is back.

    Raises:
        UsageError: the port is not there at the beginning, or cannot be opened.
    """

    def __init__(self, loop: Loop, line: Line, device: str, tell: Callable[[str], object] = lambda _text: None) -> None:
        assert isinstance(line, SerialLine)  # the server has seen to that
        self.loop, self.line, self.device, self.tell = loop, line, device, tell
        self.closed = False
        self.port: Any = None
        try:
            self._open()
        except (OSError, ValueError) as error:
            raise UsageError(f"{device}: {error}") from None

    @property
    def where(self) -> str:
        """The name of the port."""
        return self.device

    def _open(self) -> None:
        word = self.line.port.word
        self.port = serial.Serial(
            self.device,
            int(self.line.port.baud),
            bytesize=word.bits,
            parity=word.parity[0].upper(),
            stopbits=float(word.stop),
            timeout=0,
            exclusive=True,
        )
        self.stream = Stream(self.loop, self.port.fileno(), self.line.take, self._lost, self.line.room)
        self.line.attach(self.device, self.stream.write, self.stream.resume)

    def _lost(self, why: str) -> None:
        self.line.detach(why)
        self.port.close()
        self.tell(f"{self.device}: gone ({why}); it is looked for until it is back")
        self.loop.after(RETRY_S, self._retry)

    def _retry(self) -> None:
        if self.closed:
            return
        try:
            self._open()
        except (OSError, ValueError):
            self.loop.after(RETRY_S, self._retry)
        else:
            self.tell(f"{self.device}: back")

    def close(self) -> None:
        """Let go of the port."""
        self.closed = True
        if self.stream.open:
            self.stream.close()
            self.line.detach("closed")
            self.port.close()
