"""The pySerial URL handler: slewline://gs-c200s is a module in the process of the program that opens it.

    slewline://gs-c200s                          a new module, at 9600 baud, with checksum, only for this port object
    slewline://gs-c200s?chs=0&br0=1              straps; here no checksum, 4800 baud
    slewline://gs-c200s?name=left                the same module whenever it is opened under this name
    slewline://gs-c200s?store=left.eeprom        a file holds the EEPROM
    slewline://gs-c200s?rate=1.0                 virtual time follows the wall clock
    slewline://gs-c200s?eeprom_time=20 ms        any option of the part; load.v5_20=80 sets one entry of a table;
                                                 also seed=..., and log=FILE for a transcript
    slewline://my_lab.mx10:Mx10                  a custom chip, which imports a Python module; only where the program
                                                 allows it: serial_for_url(url, allow_code=True).  A chip from an
                                                 installed package is always allowed: slewline://mx10

Virtual time passes while the program waits: a read lets it pass until the characters have arrived or the
read's timeout has expired, and takes hardly any real time.  A poll (in_waiting, timeout=0) takes one
character time, so that a loop that polls makes progress; to sleep, call `port.sleep`, or set a rate.  A
read without a timeout raises slewline.Timeout if nothing can arrive, instead of blocking forever.

A timeout is in virtual time, even if virtual time follows the wall clock: at rate=10, a timeout of 1 s
expires after 0.1 s.  One thread may read while another writes; characters written during a read take
effect immediately.  A write never waits, so `write_timeout` and `cancel_write` have no effect.

The line has three wires.  As usual with such a cable, the connector bridges RTS to CTS, and DTR to DSR
and DCD.  A module with its own CTS controls the data flow if rtscts=True.
"""

from __future__ import annotations

import io
import sys
from typing import Any

from serial.serialutil import PortNotOpenError, SerialBase, SerialException

from ..core.time.timebase import PS_PER_S
from ..core.wires.serial import CharacterFormat
from .endpoint import SerialEndpoint, word_of
from .rig import HasRig, Rig, from_url, seconds

NO_FILE = (
    "is a module of slewline, not a file; a program that waits for one, such as pyserial-asyncio or select, gets a "
    'module on a port of the machine: slewline_module("...", on="tcp"), whose url is socket://..., or on="pty", opened '
    "as 8N1; in asyncio, serialx opens this URL"
)
WAIT_FOR_FILES = {"serial_asyncio", "serial_asyncio_fast"}  # they would wait forever: a callback raises there


def waits_for_a_file() -> bool:
    """Return whether the callers include a library that needs a real file and would wait forever for this port."""
    if not WAIT_FOR_FILES & sys.modules.keys():
        return False
    frame = sys._getframe()
    while frame is not None and frame.f_globals.get("__name__", "").partition(".")[0] not in WAIT_FOR_FILES:
        frame = frame.f_back  # type: ignore[assignment]
    return frame is not None


class Serial(HasRig, SerialBase):
    """A serial port with a slewline module at its other end."""

    _allow_code = False
    _url: str | None = None  # the port whose module the rig has
    _end: SerialEndpoint

    def __init__(self, *args: Any, allow_code: bool = False, **settings: Any) -> None:
        self._allow_code = allow_code
        super().__init__(*args, **settings)

    # ------------------------------------------------------------------------------------------------- open and close
    def open(self) -> None:
        """Connect to the module, which is already switched on; a reopened port gets the same module as before."""
        if self.port is None:
            raise SerialException("a port is opened by its URL, such as slewline://gs-c200s")
        if self.is_open:
            raise SerialException(f"{self.port} is open already")
        if waits_for_a_file():
            raise SerialException(f"{self.port}: {NO_FILE}")
        self._word()  # an error here makes no module
        if self._url != self.port:
            self.rig, self._url = self._found(), self.port
        if why := self.rig.look():
            raise SerialException(f"could not open port {self.port}: {why}")
        if self.rig.line.host is not None:
            raise SerialException(f"{self.port}: it is open in another program; close it there")
        self._end = SerialEndpoint(self.rig, self.port, "pySerial", SerialException)
        self._reconfigure_port()
        self.is_open = True

    def fileno(self) -> int:
        """Raise an exception: a module in this process is not a file."""
        raise io.UnsupportedOperation(f"{self.port}: {NO_FILE}")

    def _found(self) -> Rig:
        try:
            return from_url(str(self.port), self._allow_code)
        except FileNotFoundError as error:
            raise SerialException(f"could not open port {error}") from None

    def close(self) -> None:
        """Send the characters written so far, and close the line.

        The state of the module is unchanged, and its time stops.
        """
        if self.is_open:
            self._end.flush()
            self.is_open = False
            self._end.hang_up()

    def _reconfigure_port(self) -> None:
        self._end.check()
        self._end.change_line(self.baudrate, self._word())
        self.rig.do(lambda: self.rig.line.obey(bool(self.rtscts)))

    def _word(self) -> CharacterFormat:
        """Return the character format that the port's settings define; raise an error if the line cannot use it."""
        return word_of(str(self.port), self.baudrate, self.bytesize, self.parity, self.stopbits, self.xonxoff)

    # -------------------------------------------------------------------------------------------------------- reading
    @property
    def in_waiting(self) -> int:
        """The number of characters that can be read immediately."""
        self._must_be_open()
        self.rig.poll()
        return len(self._end.buffer)

    def read(self, size: int = 1) -> bytes:
        """Return up to `size` characters, or fewer when the timeout expires or the read is cancelled.

        Raises:
            Timeout: there is neither a timeout nor a rate, and nothing can arrive.
        """
        self._must_be_open()
        return self._end.read(size, self.timeout, self.inter_byte_timeout)

    def cancel_read(self) -> None:
        """Cancel the read that waits in another thread or, if none does, the next read that would wait.

        The cancelled read returns the characters received so far.  Closing the port has the same effect.
        """
        if self.is_open:
            self._end.cancel()

    def read_until(self, expected: bytes = b"\n", size: int | None = None) -> bytes:
        """Return the characters up to and including `expected`: at most `size`, or fewer if the timeout expires."""
        now = self.rig.present()
        end = None if self.timeout is None else now + seconds(self.timeout)
        line = bytearray()
        while character := self.read(1):
            line += character
            if line.endswith(expected) or len(line) == size or (end is not None and self.rig.bench.now_ps >= end):
                break
        return bytes(line)

    def reset_input_buffer(self) -> None:
        """Discard the received characters."""
        self._must_be_open()
        self._end.buffer.clear()

    # -------------------------------------------------------------------------------------------------------- writing
    def write(self, b: Any, /) -> int:
        """Queue characters and return their number; as time passes, they are sent as fast as the line allows."""
        self._must_be_open()
        if isinstance(b, str):  # as pySerial has it
            raise TypeError(f"unicode strings are not supported, please encode to bytes: {b!r}")
        return self._end.write(bytes(b))

    def cancel_write(self) -> None:
        """Do nothing: a write never waits."""

    @property
    def out_waiting(self) -> int:
        """The number of written characters that have not yet been sent."""
        self._must_be_open()
        return self.rig.host.uart.backlog

    def flush(self) -> None:
        """Wait until all written characters have been sent."""
        self._must_be_open()
        self._end.flush()

    def reset_output_buffer(self) -> None:
        """Discard the unsent characters, except one whose transmission has already begun."""
        self._must_be_open()
        self.rig.do(self.rig.host.drop)

    # ------------------------------------------------------------------------------ pySerial methods of a single system
    def set_buffer_size(self, rx_size: int = 4096, tx_size: int | None = None) -> None:  # of Windows
        """Do nothing: a module's port keeps all received characters."""
        self._must_be_open()

    def set_low_latency_mode(self, low_latency_settings: bool) -> None:  # of Linux
        """Do nothing: no character is late in virtual time."""
        self._must_be_open()

    def set_input_flow_control(self, enable: bool = True) -> None:
        """Raise an exception: flow control by XON and XOFF is impossible, since commands contain these characters.

        Raises:
            UsageError: always, as for xonxoff=True.
        """
        self._must_be_open()
        word_of(str(self.port), self.baudrate, self.bytesize, self.parity, self.stopbits, True)

    set_output_flow_control = set_input_flow_control

    # ------------------------------------------------------------------------------------------- break and modem lines
    def send_break(self, duration: float = 0.25) -> None:
        """Hold the line at space (a break) for `duration` seconds."""
        self.break_condition = True
        self.sleep(duration)
        self.break_condition = False

    def sleep(self, duration: float) -> None:
        """Let `duration` seconds of virtual time pass, as time.sleep does in real time for a real port."""
        self._must_be_open()
        self._end.sleep(duration)

    def clock(self) -> float:
        """Return the virtual time (s): the counterpart of time.monotonic for a real port."""
        return self.rig.pace.kernel.now / PS_PER_S

    def _update_break_state(self) -> None:
        self._must_be_open()
        self._end.space(self.break_condition)

    def _update_rts_state(self) -> None:
        pass

    def _update_dtr_state(self) -> None:
        pass

    @property
    def cts(self) -> bool:
        """True if CTS is on: the module's own CTS if it has one, otherwise RTS, to which CTS is bridged."""
        self._must_be_open()
        return self.rts if (clear := self.rig.line.clear) is None else clear

    @property
    def dsr(self) -> bool:
        """True if DSR is on, which is bridged to DTR."""
        self._must_be_open()
        return self.dtr

    @property
    def cd(self) -> bool:
        """True if DCD is on, which is bridged to DTR."""
        self._must_be_open()
        return self.dtr

    @property
    def ri(self) -> bool:
        """False, since RI is always off."""
        self._must_be_open()
        return False

    def _must_be_open(self) -> None:
        if not self.is_open:
            raise PortNotOpenError
        self._end.check()
