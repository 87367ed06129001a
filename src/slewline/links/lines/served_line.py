"""A line between the outside world and modules on a bench: a serial connector, and the modules wired to it.

    host --- stream ---> | noise | ---> SerialPort.write ---> txd ~~~> rxd   module, or several that share the line
                         |       |
         <--- stream --- | noise | <--- a character ends <~~~ rxd  <~~~ txd

A byte from the host begins on the virtual line at the instant of its arrival, or at the end of the
previous byte, if that is later; a character from the module is sent to the host at the instant at which
its last bit ends.  Both are transmitted at the rate of the line.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, cast

from ...bench.runner import Wait
from ...core.wires.receiver import Character
from ...core.wires.serial import LineSetting
from ...language.dialect import dialect_of
from ...parts.hosts.adaptive_host import AdaptiveHost
from ...parts.hosts.ends.adaptive_uart import AdaptiveUart
from ...parts.hosts.serial_host import SerialHost
from ...parts.lines.host_uart import LATE_PS
from ...parts.lines.noise import LINKED, Noise
from ...parts.lines.rs232 import SerialPort
from ..sockets.preamble import TEXT
from ..sockets.stream import CHUNK
from .line_transcript import TO_CHIP, TO_HOST, TranscriptFile
from .outlet import Gate, Outlet, SentBytes
from .pace import Pace

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...parts.base.part import Part

Send = Callable[[bytes, object], object]  # sends bytes to a host; None: to any
BACKLOG = 256  # characters that may wait for their turn on the line
ANSWER_TIMEOUT_PS = 60 * 10**12  # longest wait for an answer, in lockstep or for a host that sends no more


class Detour(Protocol):
    """An alternative destination for the bytes of a host."""

    def send(self, data: bytes) -> object:
        """Send bytes to this destination."""

    def room(self) -> int:
        """Return the number of bytes that may arrive now."""


class HostLine:
    """The modules as seen by a link: bytes in, bytes out, one host at a time.

    `host` receives the bytes from the modules; it is None while no host is connected, and these bytes are
    then lost, as on an unconnected wire.
    """

    ports: tuple[str, ...] = ("tcp", "pty")  # ports on which it can be served
    baud: int | str | None = None  # its rate, if it has one
    greetings = TEXT  # of foreign protocols, whose connections are closed
    share = CHUNK  # bytes read from a host per turn of the loop, so that others get their turn

    def __init__(self, name: str, chips: Sequence[Chip], pace: Pace, log: TranscriptFile) -> None:
        self.name, self.chips, self.pace, self.log = name, tuple(chips), pace, log
        self.kernel = pace.kernel
        self.host: Callable[[bytes], int] | None = None
        self.host_name = ""
        self.resume: Callable[[], object] | None = None
        self.taken = self.given = self.dropped = 0  # bytes from the host, to the host, and bytes that no host read
        self.wait: Wait | None = None  # in lockstep, the wait that lets time pass for received bytes
        self.detour: Detour | None = None  # alternative destination of the host's bytes
        self.beside: list[HostLine] = []  # lines to the same chip
        self.coming_ends: list[str] = []  # incomplete lines at the last check
        self.concludes = True  # a departing host may leave an incomplete line, unless it looks at another branch
        self.outlet = Outlet(self._deliver)
        self.acts: Acts | None = None  # actions on its part besides inputs, if another bench is to repeat them

    @property
    def gate(self) -> Gate | None:
        """Gate that delays bytes to the host, for example until a motor has caught up; None if there is no delay."""
        return self.outlet.gate

    @gate.setter
    def gate(self, gate: Gate | None) -> None:
        self.outlet.gate = gate

    # ---------------------------------------------------------------------------------------------------- the host
    def attach(self, name: str, host: Callable[[bytes], int], resume: Callable[[], object]) -> None:
        """Connect a host: `host(data)` sends bytes to it, and returns the number dropped; `resume()` reads more."""
        self.host, self.host_name, self.resume = host, name, resume
        self.log.event(self.name, f"{name} is connected")

    def detach(self, why: str) -> None:
        """Disconnect the host; bytes that it has already sent still reach the chip."""
        self.log.event(self.name, f"{self.host_name}: {why}")
        self.host, self.host_name = None, ""

    def look_for_ends(self) -> None:
        """Report incomplete requests that have not changed since the last check: their host would wait for ever."""
        coming = [] if self.pace.paused else [chip.unfinished for chip in self.chips]
        if any(coming) and coming == self.coming_ends:
            self.pace.bench.conclude()
        self.coming_ends = coming

    def leave(self, why: str) -> None:
        """Disconnect a host that has left; when all its bytes have reached the chip, report any incomplete request."""
        self.detach(why)
        if self.concludes:
            self.when_answered(self.pace.bench.conclude)

    def take(self, data: bytes) -> None:
        """Receive bytes from the host."""
        self.taken += len(data)
        if self.detour is not None:
            if data := self.whole(data):
                self.detour.send(data)
            return
        self.note(TO_CHIP, data)
        self.feed(data)
        limit_ps = self.kernel.now + ANSWER_TIMEOUT_PS
        if self.wait is not None:
            self.wait.limit_ps = limit_ps
        elif self.pace.lockstep:
            self.wait = Wait(self._all_quiet if self.beside else self.quiet, limit_ps, self._rests)
            self.pace.wait(self.wait)

    def _all_quiet(self) -> bool:
        """Return whether this line is quiet, and all other lines to its chips, where its commands may cause answers."""
        return self.quiet() and all(line.quiet() for line in self.beside)

    def when_answered(self, call: Callable[[], object]) -> None:
        """Call a function when all bytes received from the host have been answered, or after a timeout."""
        limit_ps = self.kernel.now + ANSWER_TIMEOUT_PS
        if self.pace.lockstep:  # time passes for received bytes, not for a waiting host
            limit_ps = self.kernel.now if self.wait is None else self.wait.limit_ps
        self.pace.wait(Wait(lambda: self.quiet() and not self.outlet.waiting, limit_ps, lambda _quiet: call()))

    def _rests(self, quiet: bool) -> None:
        self.wait = None
        if not quiet:
            self.log.event(self.name, "no answer after 60 s of virtual time; time stops here")

    def when_sent(self, call: Callable[[], object]) -> None:
        """Call a function when all bytes received from the host have been sent on, or after a timeout."""
        self.pace.wait(Wait(self.sent, self.kernel.now + ANSWER_TIMEOUT_PS, lambda _sent: call()))

    def event(self, text: str) -> None:
        """Record an event on the line in the transcript."""
        self.log.event(self.name, text)

    def give(self, data: bytes, to: object = None) -> None:
        """Send bytes to the connected host, or only to the host `to`, through the gate if there is one."""
        self.outlet.send(data, self.kernel.now, to)

    def _deliver(self, data: bytes, to: object) -> None:
        if to is not None and self.host is not to:  # the next host has not sent the request
            return
        self.note(TO_HOST, data)
        lost = len(data) if self.host is None else self.host(data)
        self.given += len(data) - lost
        if lost and not self.dropped:
            self.log.event(self.name, "no host is reading: characters of the module are dropped from now on")
        self.dropped += lost

    # ------------------------------------------------------------------------------------------------ another bench
    @property
    def part(self) -> Part:
        """The part that terminates the line on the bench."""
        raise NotImplementedError

    def move(self, bench: Bench, coming: Sequence[SentBytes]) -> None:
        """Connect the line to the part of the same name on another bench; `coming` are characters still in transit."""
        self.kernel = bench.kernel
        self.chips = tuple(bench.chips[chip.name] for chip in self.chips)

    # -------------------------------------------------------------------------------------------- kinds of lines
    def obey(self, on: bool) -> None:
        """Select whether characters to the chip wait for its CTS; this has no effect if the chip has no CTS."""

    def opened_at(self, baud: int) -> None:
        """Record the rate (baud) that a host has set on its port; it has no effect on the line."""

    def note(self, direction: str, data: bytes) -> None:
        """Write into the transcript the bytes that were transferred in a direction ("<" or ">")."""
        self.log.characters(self.name, direction, data)

    def feed(self, data: bytes) -> None:
        """Send bytes towards the module."""
        raise NotImplementedError

    def room(self) -> int:
        """Return the number of bytes that may arrive now; at 0, `resume` is called once there is room again."""
        return self.space() if self.detour is None else self.detour.room()

    def space(self) -> int:
        """Return the number of bytes that may go to the chip now."""
        raise NotImplementedError

    def whole(self, data: bytes) -> bytes:
        """Return the bytes that may be sent to another destination, given the bytes received from the host.

        If requests on this line have a defined end, only complete requests are returned.
        """
        return data

    def forget_half(self) -> None:
        """Discard the start of an incomplete request, whose end will go to another destination."""

    def sent(self) -> bool:
        """Return whether all bytes received from the host have been sent on, so that another host may begin."""
        raise NotImplementedError

    def quiet(self) -> bool:
        """Return whether all bytes received from the host have been sent to the chip and answered."""
        raise NotImplementedError


class Act(NamedTuple):
    """An action that a line performs on the part at its end, and that is not an input; see `Acts.add`.

    `do` performs the action; `ps` is its instant (ps); `inputs` is the number of inputs that the part had
    received before it.
    """

    inputs: int
    ps: int
    do: Callable[[Any, Any, Send], object]


class Acts:
    """The record of the actions that a line performs on the part at its end, and that are not inputs.

    Such actions wait for an answer, or send it.  The journal does not contain them, so another bench that
    replays the inputs of the journal needs this record.

    Args:
        part: the name of the part.
    """

    def __init__(self, part: str) -> None:
        self.part = part
        self.inputs = 0  # of the part, since the beginning
        self.done: deque[Act] = deque()
        self.number = 0  # of acts since the beginning

    def on_input(self, do: str, what: dict[str, Any]) -> None:
        """Count an input that the bench is about to receive, if it is an input to the part."""
        self.inputs += do == "input" and what["part"] == self.part

    def add(self, ps: int, do: Callable[[Any, Any, Send], object]) -> None:
        """Record an action that is performed at an instant (ps).

        `do` performs it; its arguments are the part, the result of the part's last input, and a `Send`.
        """
        self.done.append(Act(self.inputs, ps, do))
        self.number += 1

    def forget(self, before_ps: int) -> None:
        """Discard the actions up to an instant (ps)."""
        while self.done and self.done[0].ps <= before_ps:
            self.done.popleft()


class ConnectorLine(HostLine):
    """A line that ends in a serial connector on the bench."""

    ports = ("tcp", "pty", "rfc2217", "serial")

    def __init__(
        self,
        name: str,
        chips: Sequence[Chip],
        pace: Pace,
        log: TranscriptFile,
        port: SerialPort | SerialHost | AdaptiveHost,
    ) -> None:
        super().__init__(name, chips, pace, log)
        self.coming = 0  # characters whose last bit has not ended
        self.late_ps = 0  # a late character of the module comes then, the next ones after it
        spared = next((bit for chip in chips if (bit := dialect_of(chip.sheet).constant_bit) is not None), None)
        self.to_chip, self.to_host = (Noise(port.word.bits, LINKED, spared) for _ in range(2))
        self._end_in(port)

    def _end_in(self, port: SerialPort | SerialHost | AdaptiveHost) -> None:
        self.port, self.uart = port, port.uart
        self.mute = not port.pins["rxd"].net.drivers  # the chip never sends anything
        port.on_character.add(self._character)

    @property
    def part(self) -> Part:
        """Serial connector on the bench."""
        return self.port

    def move(self, bench: Bench, coming: Sequence[SentBytes]) -> None:
        """Connect the line to the same connector on another bench; `coming` are characters still in transit."""
        super().move(bench, coming)
        self.port.on_character.remove(self._character)
        self._end_in(cast("SerialPort", bench.parts[self.port.name]))
        self.coming = len(coming)
        for sent in coming:
            self.kernel.call_at(sent.ps, partial(self._over, sent.data[0]))

    @property
    def baud(self) -> int | str:  # type: ignore[override]
        """Rate of the line, baud."""
        return self.port.baud

    @property
    def setting(self) -> LineSetting:
        """Rate and format of the line."""
        return self.uart.setting

    def attach(self, name: str, host: Callable[[bytes], int], resume: Callable[[], object]) -> None:
        """Connect a host; if the chip never answers on this line, the transcript says so."""
        super().attach(name, host, resume)
        if self.mute:
            self.log.event(self.name, "the chip only receives on this line: it never answers")

    def opened_at(self, baud: int) -> None:
        """Record the rate (baud) that a host has set on its port; unlike on a real cable, it has no effect."""
        self.port.opened_at(baud)

    def feed(self, data: bytes) -> None:
        """Send bytes to the chip, with the faults that are planned for them."""
        if not self.to_chip.plans:
            self.port.write(data)
            return
        for byte in data:
            passed, fault = self.to_chip.hit(byte)
            if passed is not None:
                self.port.write(bytes([passed]), fault)

    def obey(self, on: bool) -> None:
        """Select whether characters to the chip wait for its CTS, if the chip has CTS."""
        port, wanted = self.port, None if on else False
        if isinstance(port, AdaptiveHost) and port.uart.control.heeding is not wanted:
            port.heed(wanted)

    @property
    def clear(self) -> bool | None:
        """True while CTS permits sending to the chip; None if the chip has no CTS."""
        return self.port.pins["cts"].level == 0 if isinstance(self.port, AdaptiveHost) else None

    def space(self) -> int:
        """Return the number of bytes that may arrive now.

        At 0, `resume` is called after the time that it takes to send half of the waiting bytes.
        """
        uart = self.uart
        room = BACKLOG - uart.backlog
        if room <= 0:
            half = self.kernel.now + uart.clock.ps(uart.word.ticks * BACKLOG // 2)
            self.kernel.call_at(half, lambda: self.resume() if self.resume is not None else None)
        return room

    def sent(self) -> bool:
        """Return whether every character has been sent to the chip."""
        return self.uart.idle

    def quiet(self) -> bool:
        """Return whether every character has been sent to the chip, and no answer is in transit.

        A line that is held up by CTS also counts as quiet, provided that the chip waits for a host on another
        line.
        """
        if self.coming or not (self.uart.idle or self._waits_for_rate()):
            return False
        return not any(chip.answering for chip in self.chips)

    def _waits_for_rate(self) -> bool:
        return (
            isinstance(self.uart, AdaptiveUart)
            and self.uart.waits_for_rate
            and any(chip.awaits_host for chip in self.chips)
        )

    def _character(self, character: Character) -> None:
        self.uart.discard()  # an outside host has them
        self.coming += 1
        self.kernel.call_at(character.end_ps, partial(self._over, character.byte))

    def _over(self, byte: int) -> None:
        passed, fault = self.to_host.hit(byte)
        if fault == "late":
            self.late_ps, fault = self.kernel.now + LATE_PS, ""
        data = b"" if passed is None else bytes([0 if fault else passed])  # a driver replaces a wrong character by NUL
        if self.kernel.now < self.late_ps:
            self.kernel.call_at(self.late_ps, lambda: self._arrive(data))
        else:
            self._arrive(data)

    def _arrive(self, data: bytes) -> None:
        self.coming -= 1
        if data:
            self.give(data)
