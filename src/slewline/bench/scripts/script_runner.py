"""How a host plays a run script: every line becomes an action in its queue."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from ...core.wires.event import Event
from ...core.wires.waits import edge
from ...errors import SlewlineError
from ...language.assemble import RefusedProgram
from ...language.problems import Problem

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...core.motion.axis import Axis
    from ...core.wires.pin import Terminal
    from ...parts.hosts.adaptive_host import AdaptiveHost
    from ...parts.hosts.bus_host import BusHost
    from ...parts.hosts.ends.handshake_port import CommandPort
    from ...parts.hosts.ends.packet_port import PacketPort
    from ...parts.hosts.flow_host import FlowHost
    from ...parts.hosts.host import Host
    from ...parts.hosts.packet_host import PacketHost
    from ...parts.hosts.serial_host import SerialHost
    from ..bench import Bench

SHOWN = 160  # characters of a line in a message
US_PS = 1_000_000
TAKEN_US = 1000  # a command that keeps the chip busy for longer has begun a motion, a delay or a wait

Act = Callable[["ScriptRunner", "Chip"], Awaitable[None]]
Queue = Callable[["ScriptRunner"], None]
Fits = Callable[["ScriptRunner", "Chip"], object]


@dataclass(frozen=True, slots=True)
class ScriptLine:
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
        """The word after @."""
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
    steps: tuple[ScriptLine, ...]
    problems: tuple[Problem, ...]

    def refuse(self, problems: Iterable[Problem]) -> None:
        """Raise what is wrong, if anything is."""
        found = sorted(problems)
        if found:
            lines = (line if len(line) <= SHOWN else f"{line[:SHOWN]} ..." for line in self.text.splitlines())
            raise RefusedProgram(found, "\n".join(lines), self.where)


class ScriptRunner:
    """A host that plays a script on a bench.

    `step` is the line that is being queued, `directed`: a directive follows it.
    """

    def __init__(self, bench: Bench, host: Host, script: Script, protocol: ScriptProtocol) -> None:
        self.bench, self.host, self.script, self.protocol = bench, host, script, protocol
        self.kernel = bench.kernel
        self.step: ScriptLine | None = None
        self.directed = False
        self.event = Event(self.kernel, f"{host.name}.(bell)")
        # the host by its class, of which it is one: `ScriptLine.fits` has seen to that
        self.bus_host, self.line_host = cast("BusHost", host), cast("SerialHost", host)
        self.packet_host, self.flow_host = cast("PacketHost", host), cast("FlowHost", host)
        self.adaptive_host = cast("AdaptiveHost", host)

    def do(self, act: Act) -> None:
        """Queue an action of the host for the present line; what goes wrong in it is reported with the line."""
        step, script, host = cast("ScriptLine", self.step), self.script, self.host
        chip = self.bench.chips[host.chip.name]
        text = f"at {step.text[:60]!r} ({script.where}, line {step.line})"

        async def action() -> None:
            try:
                await act(self, chip)
            except SlewlineError as error:
                script.refuse([step.problem("refused", str(error))])

        host.queue.post(text, action)

    def port(self, chip: Chip) -> CommandPort:
        """Return what the host has on the bus of a chip."""
        return self.bus_host.ports[chip.name]

    def packet_port(self, chip: Chip) -> PacketPort:
        """Return what the host has on the host port of a chip."""
        return self.packet_host.ports[chip.name]

    def axis(self, chip: Chip) -> Axis:
        """Return the axis that the host speaks of: the current one, where there are several."""
        return chip.axes[self.protocol.axis(self, chip) - 1]

    def tell(self, text: str) -> None:
        """Report what the host does, in the transcript."""
        self.host.on_event(text)

    async def next_round(self) -> None:
        """Let the round of this instant end, so that its changes show."""
        self.event.set()
        await edge(self.event.net)

    def nested(self) -> AbstractContextManager[None]:
        """Report no input that is made in here: listeners have had the whole script.

        Calls of the host only queue.
        """
        return self.kernel.outside.nested()

    def terminal(self, name: str, chip: Chip) -> Terminal:
        """Return a pin by its short or full name."""
        return self.bench.pin(name if "." in name else f"{chip.name}.{name}")

    def put(self, terminal: Terminal, value: int | None, at: int | None = None) -> None:
        """Drive a pin or let go of it, now or at an instant."""
        if at is not None:
            self.bench.at(f"{at} ps", lambda: self.put(terminal, value))
            return
        with self.nested():
            if value is None:
                terminal.release()
            else:
                terminal.drive(value)


# ------------------------------------------------------------------------------------------------------------ commands
def command(body: str) -> Queue:
    """Send a command as the channel of the host has it."""
    return lambda runner: runner.protocol.command(body)(runner)


class ScriptProtocol:
    """What a script sends over a channel, and how: a command, bytes as they are, and of which axis."""

    def command(self, body: str) -> Queue:
        """Return how a command is queued."""
        raise NotImplementedError

    def send(self, data: bytes, act: Act) -> Queue:
        """Return how an act is queued that sends bytes."""
        return lambda runner: runner.do(act)

    async def send_now(self, runner: ScriptRunner, chip: Chip, data: bytes) -> None:
        """Send bytes as they are."""
        raise NotImplementedError

    def axis(self, runner: ScriptRunner, chip: Chip) -> int:
        """Return the number of the axis that the host speaks of."""
        return 1
