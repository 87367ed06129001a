"""slewline:// for serialx, sync and async: the same URLs as in pySerial, and the same modules.

    import serialx
    import slewline.testing.for_serialx                        # serialx then knows slewline://

    with serialx.serial_for_url("slewline://gs-c200s?chs=0", byte_size=7, parity="O", stopbits=2) as port: ...
    reader, writer = await serialx.open_serial_connection("slewline://gs-c200s?chs=0", 9600, ...)

Sync: virtual time passes while the program waits, as in pySerial.

Async: in a loop of `slewline.testing.aio`, virtual time passes while all tasks wait.  In any other loop,
virtual time passes until the written bytes are answered; but if the URL sets a rate, such as rate=1, it
follows the wall clock.

A read returns the available characters as soon as there are any, as serialx does on a real port.
"""

from __future__ import annotations

import asyncio
from typing import Any

from serialx import (
    BaseSerial,
    BaseSerialTransport,
    ModemPins,
    PinState,
    SerialException,
    register_uri_handler,
)

from ..bench.runner import Wait
from ..errors import UsageError
from .aio import time_of
from .endpoint import SILENCE_PS, SerialEndpoint, word_of
from .rig import SCHEME, HasRig, Rig, from_url


class Serial(HasRig, BaseSerial):
    """A serialx port with a slewline module at its other end."""

    end: SerialEndpoint | None = None
    _found_at: str | None = None  # the port whose module the rig has

    def __init__(self, *args: Any, allow_code: bool = False, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self._allow_code = allow_code

    # ------------------------------------------------------------------------------------------------- open and close
    def _open(self) -> None:
        where = str(self.path)
        if self.end is not None:
            raise SerialException(f"{where} is open already")
        self._word()  # an error here makes no module
        if self._found_at != where:
            self.rig, self._found_at = self._found(), where
        if why := self.rig.look():
            raise SerialException(f"{where}: {why}")
        if self.rig.line.host is not None:
            raise SerialException(f"{where}: it is open in another program; close it there")
        self.end = SerialEndpoint(self.rig, where, "serialx", SerialException)
        self.set_modem_pins(self._modem_pins_on_open())

    def _found(self) -> Rig:
        try:
            return from_url(str(self.path), self._allow_code)
        except FileNotFoundError as error:
            raise SerialException(str(error)) from None

    def _close(self) -> None:
        if self.end is not None:
            self.end.flush()
            self._hang_up()

    def _hang_up(self) -> None:
        end, self.end = self.end, None
        if end is not None:
            end.hang_up()

    @property
    def is_open(self) -> bool:
        """True if the port is open."""
        return self.end is not None

    def _word(self) -> Any:
        return word_of(
            str(self.path), self.baudrate, self.byte_size, self.parity.value, self.stopbits.value, self._xonxoff
        )

    def _reconfigure_port(self, update: Any) -> None:
        self._line.change_line(self.baudrate, self._word())

    @property
    def _line(self) -> SerialEndpoint:
        if self.end is None:
            raise SerialException(f"{self.path} is not open")
        self.end.check()
        return self.end

    # --------------------------------------------------------------------------------------------- reading and writing
    def _readinto(self, b: Any, *, timeout: float | None) -> int:
        view = memoryview(b).cast("B")
        data = self._line.read(len(view), timeout, least=1)
        view[: len(data)] = data
        return len(data)

    def num_unread_bytes(self) -> int:
        """Return the number of characters that can be read immediately."""
        self._line.rig.poll()
        return len(self._line.buffer)

    def _reset_read_buffer(self) -> None:
        self._line.buffer.clear()

    def _write(self, data: Any, *, timeout: float | None) -> int:
        return self._line.write(bytes(data))

    def num_unwritten_bytes(self) -> int:
        """Return the number of characters that have not been sent."""
        return self._line.rig.host.uart.backlog

    def _flush(self) -> None:
        self._line.flush()

    def _reset_write_buffer(self) -> None:
        rig = self._line.rig
        rig.do(rig.host.drop)

    def sleep(self, duration: float) -> None:
        """Let `duration` seconds of virtual time pass: the counterpart of time.sleep for a real port."""
        self._line.sleep(duration)

    # ---------------------------------------------------------------------------------------------------- modem lines
    def _get_modem_pins(self) -> ModemPins:
        """Return the modem lines: RTS is bridged to CTS, DTR to DSR and DCD, and RI is always off."""
        rts, dtr = self._rts_state, self._dtr_state
        return ModemPins(cts=rts, dsr=dtr, car=dtr, rng=PinState.LOW)

    def _set_modem_pins(self, modem_pins: ModemPins) -> None:
        """Do nothing: RTS and DTR lead only to inputs of this port, not to the module."""


class Transport(BaseSerialTransport):
    """An asyncio transport with a slewline module at its other end."""

    transport_name = SCHEME
    make = Serial
    _serial: Serial | None

    def __init__(self, loop: asyncio.AbstractEventLoop, protocol: asyncio.Protocol) -> None:
        super().__init__(loop, protocol)
        self._paused = self._called = False

    async def _connect(self, *, path: str | None, **settings: Any) -> None:
        self._serial = port = self.make(path, **settings)
        port.open()
        self._extra["serial"] = port
        self._end.notify = self._arrived
        self._time = time_of(self._loop, port.rig)
        self._time.join(self)
        self._call_protocol_connection_made()

    @property
    def _port(self) -> Serial:
        """The open port."""
        if self._serial is None:
            raise UsageError(f"{SCHEME}: no port is open; await the connection first")
        return self._serial

    @property
    def _end(self) -> SerialEndpoint:
        return self._port._line

    # -------------------------------------------------------------------------------------------------------- reading
    def _arrived(self) -> None:
        if not self._called:
            self._called = True
            self._loop.call_soon(self._deliver)

    def _deliver(self) -> None:
        self._called = False
        if self._connection_lost_called or self._closing or self._paused:
            return
        end = self._port.end
        if end is None:
            return
        data = bytes(end.buffer)
        end.buffer.clear()
        if data:
            self._protocol.data_received(data)
        if end.lost:
            self._closing = True
            self._lost(end.error())

    def pause_reading(self) -> None:
        """Hold back received characters until `resume_reading` is called."""
        self._paused = True

    def resume_reading(self) -> None:
        """Pass the held characters, and all later ones, to the protocol."""
        self._paused = False
        self._arrived()

    def is_reading(self) -> bool:
        """Return whether received characters are passed to the protocol."""
        return not self._paused and not self._closing

    # -------------------------------------------------------------------------------------------------------- writing
    def write(self, data: bytes | bytearray | memoryview[int]) -> None:
        """Queue characters; they are sent as fast as the line allows while time passes."""
        if self._closing:
            return
        end = self._end
        end.write(bytes(data))
        self._time.answer(end.rig.line.quiet)

    def get_write_buffer_size(self) -> int:
        """Return the number of characters that have not been sent."""
        return 0 if self._serial is None or self._serial.end is None else self._serial.end.rig.host.uart.backlog

    async def _flush(self) -> None:
        sent = asyncio.Event()
        self._when_sent(lambda _: sent.set())
        await sent.wait()

    def _when_sent(self, call: Any) -> None:
        end = self._end
        if end.sent():
            call(True)
            return

        def done(was: bool) -> None:  # as long as it takes
            call(True) if was else self._when_sent(call)

        self._time.wait(Wait(end.sent, end.rig.bench.now_ps + SILENCE_PS, done))

    async def _reconfigure_port(self, update: Any) -> None:
        self._port._reconfigure_port(update)

    async def _get_modem_pins(self) -> ModemPins:
        return self._port.get_modem_pins()

    async def _set_modem_pins(self, modem_pins: ModemPins) -> None:
        self._port.set_modem_pins(modem_pins)

    # ---------------------------------------------------------------------------------------------------------- close
    def close(self) -> None:
        """Close the line once all written characters have been sent."""
        self._end_with(drain=True)

    def abort(self) -> None:
        """Close the line; characters that have not been sent are discarded."""
        self._end_with(drain=False)

    def _end_with(self, drain: bool) -> None:
        if self._connection_lost_called or (self._closing and drain):
            return
        self._closing = True
        self._mark_user_closed()
        if self._serial is None or self._serial.end is None:
            self._call_protocol_connection_lost(None)
        elif drain:
            self._arm_close_timeout()
            self._when_sent(lambda _: self._loop.call_soon(self._lost))
        else:
            self._serial._reset_write_buffer()
            self._loop.call_soon(self._lost)

    def _lost(self, error: Exception | None = None) -> None:
        if self._connection_lost_called:
            return
        self._port._hang_up()
        self._time.leave(self)
        self._call_protocol_connection_lost(error)


register_uri_handler(
    scheme=f"{SCHEME}://",
    unique_scheme=f"{SCHEME}://",
    sync_cls=Serial,
    async_transport_cls=Transport,
    connect_kwargs=frozenset({"allow_code"}),
)
