"""RFC 2217: a serial port over TCP, including its settings; pySerial opens it as rfc2217://HOST:PORT.

A host sets rate and format, and the line adopts them; if the rate differs from the strapped rate of the
module, the characters are garbled as on a wire.  DTR and RTS are accepted without effect, as on the
three wires of a module; a break holds the line at space.  The protocol is that of pySerial's
PortManager, which needs an object with the properties of pySerial's serial ports: `Remote`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self, cast

from ...core.wires.serial import PARITIES, CharacterFormat, bit_clock
from ...errors import SlewlineError, UsageError
from ...extras import needs
from ..lines.served_line import ConnectorLine
from .tcp import Session, TcpPort

try:
    from serial import rfc2217
except ImportError:
    raise SlewlineError(needs("RFC 2217 needs", "serial")) from None

if TYPE_CHECKING:
    from ..lines.port_line import PortLine
    from ..sockets.loop import Loop

LETTERS = {parity: letter for letter, parity in PARITIES.items()}
LONGEST_OPTION = 256  # bytes of a suboption; real suboptions have only a few
SHARE = 64  # bytes per turn of the loop; each is filtered separately
FASTEST = 10**6  # baud
THEIR_BYTES = "they-BINARY"  # the option of that name in pySerial
CR, NUL = b"\r", b"\0"
MASKS = {
    rfc2217.SET_LINESTATE_MASK: rfc2217.SERVER_SET_LINESTATE_MASK,
    rfc2217.SET_MODEMSTATE_MASK: rfc2217.SERVER_SET_MODEMSTATE_MASK,
}


class Remote:
    """The line as a pySerial serial port, as far as a PortManager needs one.

    The settings of a host apply to the line only during the turn of that host.
    """

    def __init__(self, session: NetSession, line: ConnectorLine, baud: int | str, word: CharacterFormat) -> None:
        self.session, self.port = session, line.port
        self.baud, self.word = baud, word
        self.rts = self.dtr = True
        self.dsr = self.cd = True
        self.ri = self.xonxoff = self._rtscts = False
        self._break = False

    def set_line(self, baud: int | str, word: CharacterFormat) -> None:
        """Set the rate (baud) and format that the line is to have during the turn of this host."""
        bit_clock(baud, self.port.name)
        self.baud, self.word = baud, word.checked(self.port.name)
        if self.session.begun:
            self.apply(baud, word)

    def apply(self, baud: int | str, word: CharacterFormat) -> None:
        """Apply rate and format to the line."""
        if (self.port.baud, self.port.word) != (baud, word):
            self.port.change_line(baud, word.bits, word.parity, word.stop)

    @property
    def baudrate(self) -> int:
        """Rate of the line, baud."""
        return int(self.baud)

    @baudrate.setter
    def baudrate(self, baud: int) -> None:
        if not 1 <= baud <= FASTEST:
            raise UsageError(f"{baud} baud; allowed 1 to {FASTEST}")
        self.set_line(baud, self.word)

    @property
    def bytesize(self) -> int:
        """Number of data bits."""
        return self.word.bits

    @bytesize.setter
    def bytesize(self, bits: int) -> None:
        self.set_line(self.baud, CharacterFormat(bits, self.word.parity, self.word.stop))

    @property
    def parity(self) -> str:
        """Parity, N, O or E; mark and space parity are refused."""
        return LETTERS[self.word.parity]

    @parity.setter
    def parity(self, letter: str) -> None:
        if letter not in PARITIES:
            raise UsageError(f"parity {letter!r}; allowed {', '.join(PARITIES)}")
        self.set_line(self.baud, CharacterFormat(self.word.bits, PARITIES[letter], self.word.stop))

    @property
    def stopbits(self) -> float:
        """Number of stop bits: 1, 1.5 or 2."""
        return float(self.word.stop)

    @stopbits.setter
    def stopbits(self, stop: float) -> None:
        self.set_line(self.baud, CharacterFormat(self.word.bits, self.word.parity, f"{stop:g}"))

    @property
    def cts(self) -> bool:
        """True while CTS of the chip permits sending, or if the chip has no CTS."""
        return self.session.line.clear is not False

    @property
    def rtscts(self) -> bool:
        """True if the host has requested that characters wait for CTS."""
        return self._rtscts

    @rtscts.setter
    def rtscts(self, on: bool) -> None:
        self._rtscts = on
        if self.session.begun:
            self.session.line.obey(on)

    @property
    def break_condition(self) -> bool:
        """True while the host requests a break, which holds the line at space during its turn."""
        return self._break

    @break_condition.setter
    def break_condition(self, on: bool) -> None:
        self._break = on
        if self.session.begun:
            self.port.space(on)

    def reset_input_buffer(self) -> None:
        """Drop nothing: there is no buffer, because characters are sent on arrival."""

    def reset_output_buffer(self) -> None:
        """Drop the host's characters that wait for their turn on the line; keep those of other hosts."""
        self.session.characters.clear()
        if self.session.begun:
            self.port.drop()


class Telnet:
    """The connection through which a PortManager answers."""

    def __init__(self, session: NetSession) -> None:
        self.session = session

    def write(self, data: bytes) -> None:
        """Send bytes of the protocol itself."""
        self.session.stream.write(bytes(data))


class Manager(rfc2217.PortManager):
    """pySerial's PortManager, plus two answers that it omits and that some clients other than pySerial need."""

    def _telnet_process_subnegotiation(self, suboption: bytes) -> None:
        super()._telnet_process_subnegotiation(suboption)  # type: ignore[misc]
        answer = MASKS.get(suboption[1:2]) if suboption[:1] == rfc2217.COM_PORT_OPTION else None
        if answer is not None:
            self.rfc2217_send_subnegotiation(answer, suboption[2:3])

    @property
    def binary(self) -> bool:
        """True if the host has agreed to send bytes unchanged."""
        options = self._telnet_options  # type: ignore[attr-defined]
        return any(option.active for option in options if option.name == THEIR_BYTES)


class NetSession(Session):
    """A host that uses RFC 2217."""

    port: NetPort
    line: ConnectorLine

    def arrive(self) -> None:
        """Connect the host, and start answering its telnet options."""
        super().arrive()
        self.remote = Remote(self, self.line, *self.port.settings)
        self.manager = Manager(self.remote, Telnet(self))  # type: ignore[arg-type]
        self.last = b""  # character

    def begin(self) -> None:
        """Begin the turn of this host, with its rate and format."""
        super().begin()
        self.remote.apply(self.remote.baud, self.remote.word)
        self.line.obey(self.remote.rtscts)
        if self.remote.break_condition:
            self.remote.break_condition = True

    def end(self) -> None:
        """End the turn of this host: the line returns to the settings that it had when the port was opened."""
        if self.remote.break_condition:
            self.remote.break_condition = False
        self.remote.apply(*self.port.settings)

    def room(self) -> int:
        return min(SHARE, super().room())

    def receive(self, data: bytes) -> None:
        """Receive bytes from the host, including telnet commands."""
        for byte in data:
            try:
                for found in self.manager.filter(bytes([byte])):
                    if (self.last, found) != (CR, NUL) or self.manager.binary:  # a telnet carriage return is CR NUL
                        self.characters += found
                    self.last = found
            except Exception as error:  # the PortManager does not check its input
                self.line.event(f"not RFC 2217: {error!r}")
                self.manager.suboption, self.manager.mode = None, rfc2217.M_NORMAL
            if self.manager.suboption is not None and len(self.manager.suboption) > LONGEST_OPTION:
                self.gone("not RFC 2217: a suboption without end")
                return
        self.port.pump()

    def give(self, data: bytes) -> int:
        """Send characters to the host; return the number dropped."""
        return min(super().give(b"".join(self.manager.escape(data))), len(data))


class NetPort(TcpPort):
    """A TCP port for a line, through which a host can also set the rate and format of the line."""

    scheme = "rfc2217"
    make = NetSession

    def __init__(self, loop: Loop, line: PortLine, *more: Any) -> None:
        port = cast("ConnectorLine", line).port  # the server has already done that
        self.settings = port.baud, port.word
        super().__init__(loop, line, *more)

    def again(self) -> Self:
        """Return a new port at the same address; give the line the settings that it had when this port was opened."""
        port = super().again()
        port.settings = self.settings
        baud, word = self.settings
        cast("ConnectorLine", self.line).port.change_line(baud, word.bits, word.parity, word.stop)
        return port
