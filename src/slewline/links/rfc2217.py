"""RFC 2217: a serial port over TCP, with its settings: rfc2217://HOST:PORT for pySerial.

A host asks for rate and format, and the line takes them: one that asks for another rate than the module is strapped for
gets what a wrong rate gives on a wire.  DTR and RTS are accepted and lead nowhere, as on the three wires of a module; a
break puts the line to space.  The protocol is that of pySerial's PortManager, which needs an object with the properties
of its serial ports: `Remote` is one.
"""

from __future__ import annotations

import socket
from typing import TYPE_CHECKING

from ..core.serial import PARITIES, Word
from ..errors import SlewlineError, UsageError
from .line import SerialLine
from .tcp import Session, TcpPort

try:
    from serial import rfc2217
except ImportError:
    raise SlewlineError("RFC 2217 needs pyserial: pip install 'slewline[serial]'") from None

if TYPE_CHECKING:
    from .line import Line
    from .loop import Loop

LETTERS = {parity: letter for letter, parity in PARITIES.items()}
LONGEST_OPTION = 256  # bytes of a suboption; no real one has more than a few
FASTEST = 10**6  # baud


class Remote:
    """The line as a serial port of pySerial, as far as a PortManager needs one."""

    def __init__(self, line: SerialLine) -> None:
        self.line, self.port = line, line.port
        self.rts = self.dtr = True
        self.cts = self.dsr = self.cd = True
        self.ri = self.xonxoff = self.rtscts = False
        self._break = False

    def set_line(self, baud: int | str, word: Word) -> None:
        """Take another rate or format."""
        self.port.change_line(baud, word.bits, word.parity, word.stop)

    @property
    def baudrate(self) -> int:
        """The rate of the line."""
        return int(self.port.baud)

    @baudrate.setter
    def baudrate(self, baud: int) -> None:
        if not 1 <= baud <= FASTEST:
            raise UsageError(f"{baud} baud; allowed 1 to {FASTEST}")
        self.set_line(baud, self.port.word)

    @property
    def bytesize(self) -> int:
        """Data bits."""
        return self.port.word.bits

    @bytesize.setter
    def bytesize(self, bits: int) -> None:
        self.set_line(self.port.baud, Word(bits, self.port.word.parity, self.port.word.stop))

    @property
    def parity(self) -> str:
        """N, O or E; mark and space parity are refused."""
        return LETTERS[self.port.word.parity]

    @parity.setter
    def parity(self, letter: str) -> None:
        if letter not in PARITIES:
            raise UsageError(f"parity {letter!r}; allowed {', '.join(PARITIES)}")
        self.set_line(self.port.baud, Word(self.port.word.bits, PARITIES[letter], self.port.word.stop))

    @property
    def stopbits(self) -> float:
        """1, 1.5 or 2."""
        return float(self.port.word.stop)

    @stopbits.setter
    def stopbits(self, stop: float) -> None:
        self.set_line(self.port.baud, Word(self.port.word.bits, self.port.word.parity, f"{stop:g}"))

    @property
    def break_condition(self) -> bool:
        """Is the line held at space?"""
        return self._break

    @break_condition.setter
    def break_condition(self, on: bool) -> None:
        self._break = on
        self.port.space(on)

    def reset_input_buffer(self) -> None:
        """Nothing is kept that could be dropped: characters go out as they come."""

    def reset_output_buffer(self) -> None:
        """Drop what waits for its turn on the line."""
        self.port.drop()


class Telnet:
    """What a PortManager answers through."""

    def __init__(self, session: NetSession) -> None:
        self.session = session

    def write(self, data: bytes) -> None:
        """Send bytes of the protocol itself."""
        self.session.stream.write(bytes(data))


class NetSession(Session):
    """A host that speaks RFC 2217."""

    def __init__(self, port: TcpPort, connection: socket.socket, name: str) -> None:
        super().__init__(port, connection, name)
        assert isinstance(self.line, SerialLine)
        self.kept = self.line.port.baud, self.line.port.word
        self.remote = Remote(self.line)
        self.manager = rfc2217.PortManager(self.remote, Telnet(self))  # type: ignore[arg-type]

    def take(self, data: bytes) -> None:
        characters = bytearray()
        for byte in data:
            try:
                for found in self.manager.filter(bytes([byte])):
                    characters += found
            except Exception as error:  # the PortManager believes what it is sent
                self.line.log.event(self.line.name, f"not RFC 2217: {error!r}")
                self.manager.suboption, self.manager.mode = None, rfc2217.M_NORMAL
            if self.manager.suboption is not None and len(self.manager.suboption) > LONGEST_OPTION:
                self.gone("a suboption without end is not RFC 2217")
                return
        if characters:
            super().take(bytes(characters))

    def give(self, data: bytes) -> int:
        return min(super().give(b"".join(self.manager.escape(data))), len(data))

    def gone(self, why: str) -> None:
        baud, word = self.kept
        if self.remote.break_condition:
            self.remote.break_condition = False
        self.remote.set_line(baud, word)
        super().gone(why)


class NetPort(TcpPort):
    """A line on a TCP port, with its settings."""

    scheme = "rfc2217"
    make = NetSession

    def __init__(self, loop: Loop, line: Line, address: str, allow_remote: bool = False) -> None:
        assert isinstance(line, SerialLine)  # the server has seen to that
        super().__init__(loop, line, address, allow_remote)
