"""A real serial port, or any pySerial URL, with the instants of received characters.

    /dev/ttyUSB0   COM3   /tmp/controller (a pty)   socket://HOST:PORT   rfc2217://HOST:PORT   slewline://PART

Silence is measured by counting reads that return no data, not by the computer's clock; so it is measured
correctly on a port in virtual time, too.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from ..closing import Closing
from ..errors import UsageError
from ..links.ports.urls import SERVED, TAIL, dismissed, unopened
from .echo import EchoFilter
from .failures import NoAnswer, PortLost

if TYPE_CHECKING:
    from ..core.wires.serial import LineSetting
    from .raw import RawRecord

Result = TypeVar("Result")
SLICE_S = 0.02  # longest wait of a read
WRITE_S = 5.0  # timeout of a port that takes no characters
IFLAG = 0  # index in the result of termios.tcgetattr


class Chunk(NamedTuple):
    """Characters received together, and the instant of reception (ns of `time.monotonic_ns`)."""

    data: bytes
    ns: int


class ModulePort(Closing):
    """An open serial port, for exclusive use if the system supports that.

    Args:
        where: the port, a device or URL that pySerial accepts.
        setting: the rate and format of the line.
        raw: records all characters on the line.
        echo: whether the line echoes; the echo is then dropped.

    Raises:
        UsageError: there is no such port, it is in use, or it does not support the setting.
    """

    _latest = b""  # received bytes, in which a server may explain why it closes

    def __init__(self, where: str, setting: LineSetting, raw: RawRecord | None = None, echo: bool = False) -> None:
        from ..links.ports.device import refused  # which reports a missing pySerial

        self.where, self.setting, self.raw, self.echo = where, setting, raw, EchoFilter(echo)
        word = setting.word
        import serial

        try:
            self.line: Any = serial.serial_for_url(
                where,
                int(setting.baud),
                bytesize=word.bits,
                parity=word.parity[0].upper(),
                stopbits=float(word.stop),
                timeout=SLICE_S,
                write_timeout=WRITE_S,
                exclusive=True,
            )
        except (OSError, ValueError, TypeError) as error:
            raise UsageError(f"{where}: {unopened(where, error) or refused(where, error)}") from None
        self._see_faults()
        self._note_setting()

    def _note_setting(self) -> None:
        if self.raw is not None:
            self.raw.note(self.setting.in_full)

    def _see_faults(self) -> None:
        """Make the driver, if it can, deliver NUL in place of each character with a parity or framing fault."""
        try:
            import termios

            device = self.line.fileno()
        except (ImportError, AttributeError, OSError):  # not supported here, or not a device
            return
        with suppress(termios.error):
            settings = termios.tcgetattr(device)
            settings[IFLAG] |= termios.INPCK
            settings[IFLAG] &= ~(termios.IGNPAR | termios.PARMRK)
            termios.tcsetattr(device, termios.TCSANOW, settings)

    def change(self, setting: LineSetting) -> None:
        """Change the rate of the port to that of the given setting.

        Raises:
            PortLost: the port is gone, or does not support the rate.
        """
        self.setting = setting
        self._do(lambda: setattr(self.line, "baudrate", int(setting.baud)))
        self._see_faults()
        self._note_setting()

    def check_echo(self) -> None:
        """Check that sent characters do not come back, unless the port was opened with `echo`.

        Raises:
            NoAnswer: sent characters come back.
        """
        if self.echo.shows:
            raise NoAnswer(
                f"{self.where}: sent characters come back: this line echoes, as an adapter for two wires (RS-485) or a "
                "modem does; give --echo"
            )

    # --------------------------------------------------------------------------------------------------- out and back
    def write(self, data: bytes) -> int:
        """Send characters; return the instant just before the write (ns of `time.monotonic_ns`).

        Raises:
            PortLost: the port is gone, or accepts no characters for `WRITE_S`.
        """
        now = time.monotonic_ns()
        self.echo.sent(data, self.clock(), len(data) * self.setting.character_s)
        self._do(lambda: self.line.write(data))
        if self.raw is not None:
            self.raw.sent(data, now)
        return now

    def read(self, silence: float) -> Chunk:
        """Return the next characters; the chunk is empty if nothing arrives for `silence` seconds.

        Raises:
            PortLost: the port is gone.
        """
        waited = 0.0
        while not (data := self._take(self._next)):
            waited += SLICE_S
            if waited >= silence:
                break
        return Chunk(data, time.monotonic_ns())

    def waiting(self) -> bytes:
        """Return the characters that have already arrived, without waiting.

        Raises:
            PortLost: the port is gone.
        """
        return self._take(self._rest)

    def _next(self) -> bytes:
        first: bytes = self.line.read(1)
        return first + self._rest() if first else first

    def _rest(self) -> bytes:
        data: bytes = self.line.read(self.line.in_waiting)
        return data

    def _take(self, read: Callable[[], bytes]) -> bytes:
        data: bytes = self._do(read)
        self._latest = (self._latest + data)[-TAIL:]
        if self.raw is not None:
            self.raw.came(data, time.monotonic_ns())
        return self.echo.rest(data, self.clock())

    def clock(self) -> float:
        """Return a monotonic time in seconds: the computer's or, for a port in virtual time, the virtual time."""
        return float(getattr(self.line, "clock", time.monotonic)())

    def pause(self, seconds: float) -> None:
        """Wait for a number of seconds; a port in virtual time lets its virtual time pass."""
        getattr(self.line, "sleep", time.sleep)(seconds)

    def _do(self, call: Callable[[], Any]) -> Any:
        try:
            return call()
        except (OSError, TypeError, AttributeError) as error:  # raised by pySerial for a lost port
            from serial import SerialTimeoutException

            if isinstance(error, SerialTimeoutException):
                raise PortLost(
                    f"{self.where}: the port has accepted no characters for {WRITE_S:g} s; use a port without flow "
                    "control, check the adapter, and try again"
                ) from None
            found = os.strerror(error.errno) if isinstance(error, OSError) and error.errno else str(error)
            why = found.partition("(")[0].strip()  # the rest of the text is a guess of pySerial
            if reason := dismissed(self.where, self.line, self._latest):
                raise PortLost(f"{self.where}: {reason}") from None
            remedy = "start its server again" if self.where.startswith(SERVED) else "plug it in"
            raise PortLost(f"{self.where}: the port is gone ({why}); {remedy}, and try again") from None

    # ----------------------------------------------------------------------------------------------------------- close
    def _shut(self) -> None:
        """Close the port."""
        with suppress(OSError):
            self.line.close()
