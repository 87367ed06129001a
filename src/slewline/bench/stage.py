"""How a host plays a run script: every line becomes an action in its queue."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from ..core.channel import BusHandshake, Channel, HostPort, SerialLine
from ..core.net import Driver, Net
from ..core.waits import edge, first_of, level
from ..errors import SlewlineError
from ..language import packets
from ..language.assemble import RefusedProgram
from ..language.dialect import dialect_of, spoken_as
from ..language.letters import Letters
from ..language.problems import Problem
from ..parts.computer import Computer
from ..parts.host import Host, Port
from ..parts.packet_host import USUAL, PacketHost, Result
from ..parts.packet_port import operations, packet_of
from ..parts.rs232 import SerialHost

if TYPE_CHECKING:
    from ..core.axis import Axis
    from ..core.chip import Chip
    from ..core.kernel import Kernel
    from ..core.pin import Terminal
    from ..core.table import Arg, Sheet
    from ..core.timebase import Time
    from ..parts.packet_port import PacketPort
    from ..parts.part import Part

SHOWN = 160  # characters of a line in a message
TAKEN_US = 1000  # a command that keeps the chip busy for longer has begun a motion, a delay or a wait

Act = Callable[["Stage", "Chip"], Awaitable[None]]
Queue = Callable[["Stage"], None]
Fits = Callable[["Stage", "Chip"], object]


class Scene(Protocol):
    """What a script needs of the bench on which it is played."""

    @property
    def kernel(self) -> Kernel:
        """The time of the bench."""

    @property
    def chips(self) -> Mapping[str, Chip]:
        """The chips, by name."""

    @property
    def parts(self) -> Mapping[str, Part]:
        """The parts, by name."""

    def pin(self, name: str) -> Terminal:
        """Return a pin by its full name; UnknownName if there is none."""

    def at(self, time: Time, function: Callable[[], object]) -> None:
        """Call a function at an instant; UsageError if it is over."""


@dataclass(frozen=True, slots=True)
class Step:
    """A line of a script.

    `queue` puts it into the queue of a host; the bench must have what `pin` and `to` name, and `fits` raises what is
    wrong with it for the chip that is spoken to.
    """

    line: int
    column: int
    text: str
    queue: Queue
    pin: str = ""
    to: str = ""
    fits: Fits | None = None

    @property
    def directs(self) -> bool:
        """Is it a directive to the host?"""
        return self.text.startswith("@")

    @property
    def verb(self) -> str:
        """The word behind @."""
        words = self.text[1:].split(maxsplit=1)
        return words[0] if self.directs and words else ""

    def problem(self, code: str, found: str, remedy: str = "") -> Problem:
        """Return what is wrong with this line, as a problem in its place."""
        return Problem(self.line, self.column, min(len(self.text), SHOWN), code, "error", found, remedy=remedy)


@dataclass(frozen=True, slots=True)
class Script:
    """A script that was read: its lines, and what is wrong with them."""

    text: str
    where: str
    steps: tuple[Step, ...]
    problems: tuple[Problem, ...]

    def refuse(self, problems: Iterable[Problem]) -> None:
        """Raise what is wrong, if anything is."""
        found = sorted(problems)
        if found:
            lines = (line if len(line) <= SHOWN else f"{line[:SHOWN]} ..." for line in self.text.splitlines())
            raise RefusedProgram(found, "\n".join(lines), self.where)


class Stage:
    """A host that plays a script on a bench.

    `step` is the line that is being queued, `directed` says whether a directive follows it.
    """

    def __init__(self, scene: Scene, host: Computer, script: Script) -> None:
        self.scene, self.host, self.script = scene, host, script
        self.kernel = scene.kernel
        self.speech = SPEECH[type(host.channel)]
        self.step: Step | None = None
        self.directed = False
        self.bell, self.rung = Driver(Net(self.kernel, f"{host.name}.(bell)"), host.name), 0

    def do(self, act: Act) -> None:
        """Queue an action of the host for the present line; what goes wrong in it is told with the line."""
        step, script, host = self.step, self.script, self.host
        chip = self.scene.chips[host.chip.name]
        assert step is not None
        text = f"at {step.text[:60]!r} ({script.where}, line {step.line})"

        async def action() -> None:
            try:
                await act(self, chip)
            except SlewlineError as error:
                script.refuse([step.problem("refused", str(error))])

        host.work(text, action)

    @property
    def bus_host(self) -> Host:
        """The host, which has a bus; `Step.fits` has seen to that."""
        assert isinstance(self.host, Host)
        return self.host

    @property
    def line_host(self) -> SerialHost:
        """The host, which has a serial line."""
        assert isinstance(self.host, SerialHost)
        return self.host

    @property
    def packet_host(self) -> PacketHost:
        """The host, which sends packets."""
        assert isinstance(self.host, PacketHost)
        return self.host

    def port(self, chip: Chip) -> Port:
        """Return what the host has on the bus of a chip."""
        return self.bus_host.ports[chip.name]

    def packet_port(self, chip: Chip) -> PacketPort:
        """Return what the host has on the host port of a chip."""
        return self.packet_host.ports[chip.name]

    def axis(self, chip: Chip) -> Axis:
        """Return the axis that the host speaks of: the current one, where there are several."""
        return chip.axes[self.speech.axis(self, chip) - 1]

    def tell(self, text: str) -> None:
        """Say what the host does, in the transcript."""
        self.host.on_event(text)

    def ring(self) -> None:
        """Wake who waits for the bell, in the next round."""
        self.rung += 1
        self.bell.drive(self.rung)

    async def next_round(self) -> None:
        """Let the round of this instant end, so that its changes show."""
        self.ring()
        await edge(self.bell.net)

    def nested(self) -> AbstractContextManager[None]:
        """Tell nothing of what is done in here: whoever hears of inputs has heard of the whole script.

        Calls of the host only queue.
        """
        return self.kernel.outside.nested()

    def terminal(self, name: str, chip: Chip) -> Terminal:
        """Return a pin by its short or full name."""
        return self.scene.pin(name if "." in name else f"{chip.name}.{name}")

    def put(self, terminal: Terminal, value: int | None, at: int | None = None) -> None:
        """Drive a pin or let go of it, now or at an instant."""
        if at is not None:
            self.scene.at(f"{at} ps", lambda: self.put(terminal, value))
            return
        with self.nested():
            if value is None:
                terminal.release()
            else:
                terminal.drive(value)


# ------------------------------------------------------------------------------------------------------------ commands
def command(body: str) -> Queue:
    """Send a command as the channel of the host has it."""
    return lambda stage: stage.speech.command(body)(stage)


class Speech:
    """What a script says over a channel, and how: a command, bytes as they are, and of which axis."""

    def command(self, body: str) -> Queue:
        """Return how a command is queued."""
        raise NotImplementedError

    def send(self, data: bytes, act: Act) -> Queue:
        """Return how an act is queued that sends bytes."""
        return lambda stage: stage.do(act)

    async def send_now(self, stage: Stage, chip: Chip, data: bytes) -> None:
        """Send bytes as they are."""
        raise NotImplementedError

    def axis(self, stage: Stage, chip: Chip) -> int:
        """Return the number of the axis that the host speaks of."""
        return 1


class OverBus(Speech):
    """A command goes out when the chip is READY, as text or in binary form, as the chip takes it then."""

    def command(self, body: str) -> Queue:
        """Return how a command is queued: as text or in binary form, as the chip takes it when its turn comes."""

        async def send(stage: Stage, chip: Chip) -> None:
            port = stage.port(chip)
            await level(port.ready, 1)
            letters = spoken_as(port.sheet, Letters)
            data = (letters.sent if port.mode.level != 0 else letters.sent_binary)(port.sheet, body)
            stage.tell(body)
            await stage.bus_host.send_now(port, data)

        return sending(send)

    def send(self, data: bytes, act: Act) -> Queue:
        """Return how an act is queued that sends bytes."""
        return sending(act)

    async def send_now(self, stage: Stage, chip: Chip, data: bytes) -> None:
        """Send bytes by the handshake."""
        await stage.bus_host.send_now(stage.port(chip), data)


class OverLine(Speech):
    """A command is a line that is answered."""

    def command(self, body: str) -> Queue:
        """Return how a line is sent, and its answer told."""
        return asking(body)

    async def send_now(self, stage: Stage, chip: Chip, data: bytes) -> None:
        """Send bytes as they are, and tell what the module answers if a line ends with them."""
        if data.endswith(b"\r"):
            stage.tell(f"-> {meaning(await answers(stage, chip, data), chip.sheet)}")
        else:
            stage.line_host.send(data)


class OverPort(Speech):
    """A command is a packet, and the host waits for what it returns."""

    def command(self, body: str) -> Queue:
        """Return how a command is sent as a packet, and what it returns told."""
        return exchanging(body)

    async def send_now(self, stage: Stage, chip: Chip, data: bytes) -> None:
        """Send a command byte, and words behind it."""
        port = stage.packet_port(chip)
        for part, is_command in operations(data):
            await port.write(part, is_command, USUAL)
        port.note_axis(data[0])
        await port.ready()
        port.note_update(data[0])

    def axis(self, stage: Stage, chip: Chip) -> int:
        """Return the number of the current axis, as far as the host knows it."""
        return stage.packet_port(chip).axis or 1


SPEECH: Mapping[type[Channel], Speech] = {BusHandshake: OverBus(), SerialLine: OverLine(), HostPort: OverPort()}


def sending(send: Act) -> Queue:
    """Bytes over a bus; a directive behind them waits until the chip has taken them."""

    def queue(stage: Stage) -> None:
        stage.do(send)
        if stage.directed:
            stage.do(_taken)

    return queue


async def _taken(stage: Stage, chip: Chip) -> None:
    """The chip is READY again, or at work for so long that it moves or waits."""
    port = stage.port(chip)
    await first_of(stage.kernel, stage.kernel.now + port.ps(TAKEN_US), (port.ready, 1))


def asking(text: str) -> Queue:
    """Return how a line is sent over a serial line, and its answer told."""

    async def ask(stage: Stage, chip: Chip) -> None:
        stage.tell(f"{text} -> {meaning(await answers(stage, chip, text), chip.sheet)}")

    return lambda stage: stage.do(ask)


async def answers(stage: Stage, chip: Chip, line: str | bytes) -> list[str]:
    """Send a line, and return what the module answers."""
    return await stage.line_host.to(chip.name).exchange(line)


def meaning(found: Sequence[str], sheet: Sheet) -> str:
    """Answers, with what the sheet says to one that is an error or a state."""
    if not found:
        return "no answer"
    says = dialect_of(sheet).said(found[0])
    return f"{' '.join(found)}{f' ({says})' if says else ''}"


def exchanging(text: str) -> Queue:
    """Return how a command is sent as a packet, and what it returns told."""

    async def exchange(stage: Stage, chip: Chip) -> None:
        host, port, command = (
            stage.packet_host,
            stage.packet_port(chip),
            packets.command(chip.sheet, text, chip.crystal_hz),
        )
        row = command.row
        found = await host.exchange(port, packet_of(row, command.values))
        for arg, value in zip(row.reads, packets.values(row.reads, found), strict=True):
            host.results.append(Result(port.axis, row.name, value))
            stage.tell(f"{text} -> {returned(chip.sheet, arg, value)}")
        if not found:
            stage.tell(f"{text} = {command.values[0]}" if "/" in text else text)

    return lambda stage: stage.do(exchange)


def returned(sheet: Sheet, arg: Arg, value: int) -> str:
    """Return in words what a chipset returned: words of bits in hexadecimal, with the names of those that are 1."""
    dialect = spoken_as(sheet, packets.Packets)
    bits = {"status": dialect.status, "mode": dialect.mode}.get(arg.name, ())
    if arg.unit and not arg.unit.startswith("bits"):
        return str(value)
    names = packets.shown(value, bits)
    return f"0x{value:04X}{f' ({names})' if names else ''}"
