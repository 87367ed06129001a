"""A proxy between a host program and its module: every character is passed on immediately and recorded.

    host program <--> pty or TCP port <--> proxy <--> serial port <--> module
                                             |
                                       dialogue file

One thread does nothing but pass characters on, and a second thread writes the file, so that a slow disk
never delays a character.  The rate and the RTS/CTS flow control that a host sets on a pty are applied to
the serial port.
"""

from __future__ import annotations

import os
import socket
import stat
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from queue import Empty, SimpleQueue
from threading import Thread
from time import monotonic_ns
from typing import TYPE_CHECKING, Any

from serial import serial_for_url

from ..core.wires.serial import LineSetting
from ..links.ports.device import DevicePort
from ..links.sockets.loop import Loop
from ..links.sockets.preamble import TEXT
from ..links.sockets.stream import CHUNK
from ..links.sockets.system import fine_timer
from .echo import EchoFilter

if TYPE_CHECKING:
    from ..links.face import OpenPort
    from .dialogue import DialogueFile

BACKLOG = 4096  # characters that may wait for the serial port; a host that sends more is held up
FULL_S = 0.01  # interval of further attempts
SILENCE_S = 1.0  # time after which an incomplete line is written into the file
BIN_US, BINS = 10, 1000
NS_PER_S = 1_000_000_000


def prompt_port(url: str, *more: Any, **options: Any) -> Any:
    """Open a port as pySerial does; if it is a socket, let it send every character immediately."""
    port = serial_for_url(url, *more, **options)
    with suppress(AttributeError, OSError):  # the port has no descriptor
        if stat.S_ISSOCK(os.fstat(port.fileno()).st_mode):
            with socket.socket(fileno=os.dup(port.fileno())) as end:
                end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return port


class LatenessHistogram:
    """A histogram of the delays of characters in a proxy, in bins of 10 µs; the last bin is for 10 ms or more."""

    def __init__(self) -> None:
        self.counts = [0] * (BINS + 1)
        self.worst_ns = 0

    def note(self, late_ns: int, characters: int = 1) -> None:
        """Count a number of characters that were passed on with a given delay (ns)."""
        self.counts[min(late_ns // (BIN_US * 1000), BINS)] += characters
        self.worst_ns = max(self.worst_ns, late_ns)

    @property
    def characters(self) -> int:
        """Number of all characters counted."""
        return sum(self.counts)

    def within_us(self, share: float) -> float:
        """Return the delay (µs) within which a given share of all characters, such as 0.99, was passed on."""
        wanted, seen = share * self.characters, 0
        for number, count in enumerate(self.counts[:-1]):
            seen += count
            if seen >= wanted:
                return min((number + 1) * BIN_US, self.worst_ns / 1000)
        return self.worst_ns / 1000

    def __str__(self) -> str:
        if not self.characters:
            return "no characters"
        half, most = self.within_us(0.5), self.within_us(0.99)
        return (
            f"{self.characters} characters, half of them within {half:.0f} µs, 99 % within {most:.0f} µs, "
            f"all within {self.worst_ns / 1000:.0f} µs"
        )


class DialogueRecorder:
    """A writer of a dialogue file in a separate thread, which inherits the priority of the creating thread."""

    def __init__(self, file: DialogueFile) -> None:
        self.file = file
        self._calls: SimpleQueue[Callable[[], object] | None] = SimpleQueue()
        self._thread = Thread(target=self._write, name="recorder", daemon=True)
        self._thread.start()

    def characters(self, end: ProxyEnd, data: bytes, ns: int) -> None:
        """Write characters received at one end of the proxy, and the instant (ns) at which they were received."""
        write = self.file.host if isinstance(end, HostEnd) else self.file.module
        self._calls.put(partial(write, data, ns))

    def note(self, text: str) -> None:
        """Write a remark into the file."""
        self._calls.put(partial(self.file.note, text))

    def _write(self) -> None:
        call: Callable[[], object] | None = self.file.end
        while call is not None:
            call()
            try:
                call = self._calls.get(timeout=SILENCE_S)
            except Empty:
                call = self.file.end

    def close(self) -> None:
        """Write all pending entries, and close the file."""
        self._calls.put(None)
        self._thread.join()
        self.file.close()


class ProxyEnd:
    """One end of a proxy, which its port uses like a serial line; data received here is output at the other end."""

    greetings, share = TEXT, CHUNK

    def __init__(self, proxy: Proxy, name: str) -> None:
        self.proxy, self.name = proxy, name
        self.write: Callable[[bytes], int] | None = None  # returns the number of bytes dropped
        self.resume: Callable[[], object] = lambda: None
        self.lost = 0  # dropped characters at this end
        self.lateness = LatenessHistogram()

    @property
    def setting(self) -> LineSetting:
        """Rate and format of the serial port."""
        return self.proxy.setting

    @property
    def baud(self) -> int | str:
        """Rate of the serial port."""
        return self.setting.baud

    def attach(self, name: str, host: Callable[[bytes], int], resume: Callable[[], object]) -> None:
        """Connect a receiver: `host` takes the characters that this end outputs, and returns the number it dropped.

        The receiver also sends; `resume` makes it continue to send when there is room again.
        """
        self.write, self.resume = host, resume
        self.event(f"{self.name}: connected")

    def leave(self, why: str) -> None:
        """Disconnect the receiver, and record the reason."""
        self.write = None
        self.event(f"{self.name}: {why}")

    def event(self, text: str) -> None:
        """Record an event as a remark in the dialogue file."""
        self.proxy.recorder.note(text)

    def take(self, data: bytes) -> None:
        """Pass on bytes received at this end to the other end."""
        self.proxy.passed_on(self, data)

    def put(self, data: bytes) -> None:
        """Output characters at this end; characters that no receiver takes are lost."""
        lost = len(data) if self.write is None else self.write(data)
        if lost and not self.lost:
            self.event(f"{self.name}: takes no characters; {lost} and all further ones are lost")
        self.lost = self.lost + lost if lost else 0

    def room(self) -> int:
        """Return the number of bytes that this end may receive now."""
        return CHUNK

    def sent(self) -> bool:
        """Return True, because everything received is passed on immediately."""
        return True

    def when_sent(self, call: Callable[[], object]) -> None:
        """Call a function immediately, because everything received has already been passed on."""
        call()

    def when_answered(self, call: Callable[[], object]) -> None:
        """Ignore `call`, so that a host that has finished sending receives answers until it closes the connection.

        Only the module knows when its answers end.
        """

    def obey(self, on: bool) -> None:
        """Do nothing; only `HostEnd` switches RTS/CTS flow control."""

    def opened_at(self, baud: int) -> None:
        """Do nothing; only `HostEnd` sets the rate."""


class HostEnd(ProxyEnd):
    """The end of a proxy that is connected to the host program."""

    def room(self) -> int:
        """Return the number of bytes that the host may send now; if there is no room, call `resume` after `FULL_S`."""
        room = BACKLOG - self.proxy.waiting
        if room <= 0:
            self.proxy.loop.after(FULL_S, self.resume)
        return room

    def obey(self, on: bool) -> None:
        """Switch the RTS/CTS flow control of the serial port on or off."""
        self.proxy.set_port("rtscts", on)

    def opened_at(self, baud: int) -> None:
        """Set the serial port to the rate at which the host has opened its port, and record any change of rate."""
        if self.proxy.set_port("baudrate", baud):
            self.proxy.setting = LineSetting(baud, self.setting.word)
            self.event(f"the host has set {baud} baud")


class Proxy:
    """A proxy between a host program and a module on a serial port.

    Args:
        device: the serial port, a device or URL that pySerial accepts.
        setting: the rate and format of the line.
        recorder: records all characters.
        open_host: opens the port for the host, given the loop and the host's end of the proxy.
        report: called with messages for the user.
        echo: whether the module's line echoes; the echo is then neither sent to the host nor recorded.

    Raises:
        UsageError: a port cannot be opened.
    """

    def __init__(
        self,
        device: str,
        setting: LineSetting,
        recorder: DialogueRecorder,
        open_host: Callable[[Loop, ProxyEnd], OpenPort],
        report: Callable[[str], object] = lambda _text: None,
        echo: bool = False,
    ) -> None:
        self.setting, self.recorder, self.report = setting, recorder, report
        self.echo, self._is_reported = EchoFilter(echo), False
        self.loop = Loop()
        self.over = False
        self.host, self.module = HostEnd(self, "host"), ProxyEnd(self, "module")
        try:
            self.device = DevicePort(self.loop, self.module, device, report, prompt_port)
            try:
                self.port = open_host(self.loop, self.host)
            except BaseException:
                self.device.close()
                raise
        except BaseException:
            self.loop.close()
            raise

    @property
    def waiting(self) -> int:
        """Number of characters that wait to be sent to the serial port."""
        return len(self.device.stream.outgoing)

    def set_port(self, name: str, value: Any) -> bool:
        """Set a property of the serial port; return False if it already had this value, or if the port refuses it."""
        port = self.device.port
        try:
            if getattr(port, name) == value:
                return False
            setattr(port, name, value)
        except (OSError, ValueError) as error:
            self.recorder.note(f"{name} {value}: refused by the serial port ({error})")
            return False
        return True

    def passed_on(self, end: ProxyEnd, data: bytes) -> None:
        """Send the characters received at one end to the other end, then record them."""
        now_ns = monotonic_ns()
        if end is self.host:
            self.echo.sent(data, now_ns / NS_PER_S, len(data) * self.setting.character_s)
        else:
            data = self._answers(data, now_ns)
            if not data:
                return
        (self.module if end is self.host else self.host).put(data)
        self.loop.dirty.append(partial(self._out, end, data, now_ns))  # after the data that woke the loop

    def _answers(self, data: bytes, now_ns: int) -> bytes:
        """Return data received on the module's line, without the line's echo if the echo is to be dropped."""
        data = self.echo.rest(data, now_ns / NS_PER_S)
        if self.echo.shows and not self._is_reported:
            self._is_reported = True
            self.report(
                "the host's characters come back from the module: this line echoes; give --echo to drop the echo"
            )
        if self.echo.drops and self.echo.keeps:
            self.loop.after(max(self.echo.until - now_ns / NS_PER_S, 0) + FULL_S, self._let_go)
        return data

    def _let_go(self) -> None:
        """Pass on characters that were held back because they might be the start of an echo."""
        if self.echo.keeps:
            self.passed_on(self.module, b"")

    def _out(self, end: ProxyEnd, data: bytes, came_ns: int) -> None:
        end.lateness.note(monotonic_ns() - came_ns, len(data))
        self.recorder.characters(end, data, came_ns)

    def run(self) -> None:
        """Pass on characters until `stop` is called."""
        with fine_timer():
            while not self.over:
                self.loop.serve(self.loop.sleep(None))

    def stop(self) -> None:
        """End `run`; may be called from any thread, or from a signal handler."""
        self.over = True
        self.loop.ask(lambda: None)

    def close(self) -> None:
        """Close both ports and the dialogue file."""
        self.port.close()
        self.device.close()
        self.loop.close()
        self.recorder.close()
