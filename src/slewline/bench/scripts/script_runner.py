"""The execution of a run script by a host: every line becomes an action in its queue."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from ...core.wires.waiters import Event
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
TAKEN_US = 1000  # a command that takes longer has begun a motion, a delay or a wait

Act = Callable[["ScriptRunner", "Chip"], Awaitable[None]]
Queue = Callable[["ScriptRunner"], None]
Fits = Callable[["ScriptRunner", "Chip"], object]


@dataclass(frozen=True, slots=True)
class ScriptLine:
    """A line of a script.

    `queue` puts the line into the queue of a host; the pin `pin` and the chip `to`, if named, must exist on the bench;
    `fits` raises an error if the chip cannot take the line.
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
        """True if the line is a directive to the host."""
        return self.text.startswith("@")

    @property
    def verb(self) -> str:
        """The word after @; "" if the line is not a directive."""
        words = self.text[1:].split(maxsplit=1)
        return words[0] if self.directs and words else ""

    def problem(self, code: str, found: str, remedy: str = "") -> Problem:
        """Return an error in this line as a `Problem`, which states the place of the line."""
        return Problem(self.line, self.column, min(len(self.text), SHOWN), code, "error", found, remedy=remedy)


@dataclass(frozen=True, slots=True)
class Script:
    """A parsed script: its lines, and the problems found in them."""

    text: str
    where: str
    steps: tuple[ScriptLine, ...]
    problems: tuple[Problem, ...]

    def refuse(self, problems: Iterable[Problem]) -> None:
        """Raise a ProgramError if there are problems."""
        found = sorted(problems)
        if found:
            lines = (line if len(line) <= SHOWN else f"{line[:SHOWN]} ..." for line in self.text.splitlines())
            raise RefusedProgram(found, "\n".join(lines), self.where)


class ScriptRunner:
    """A host that executes a script on a bench.

    `step` is the line that is being queued; `directed` is true if the line after `step` is a directive.
    """

    def __init__(self, bench: Bench, host: Host, script: Script, protocol: ScriptProtocol) -> None:
        self.bench, self.host, self.script, self.protocol = bench, host, script, protocol
        self.kernel = bench.kernel
        self.step: ScriptLine | None = None
        self.directed = False
        self.event = Event(self.kernel, f"{host.name}.(bell)")
        # the host, typed by its class: `ScriptLine.fits` has checked it
        self.bus_host, self.line_host = cast("BusHost", host), cast("SerialHost", host)
        self.packet_host, self.flow_host = cast("PacketHost", host), cast("FlowHost", host)
        self.adaptive_host = cast("AdaptiveHost", host)

    def do(self, act: Act) -> None:
        """Queue a host action for the current line; errors of the action are reported together with the line."""
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
        """Return the host's `CommandPort` for a chip on its bus."""
        return self.bus_host.ports[chip.name]

    def packet_port(self, chip: Chip) -> PacketPort:
        """Return the host's `PacketPort` for a chip."""
        return self.packet_host.ports[chip.name]

    def axis(self, chip: Chip) -> Axis:
        """Return the axis that the commands of the host address: the current one, if there are several."""
        return chip.axes[self.protocol.axis(self, chip) - 1]

    def report(self, text: str) -> None:
        """Report a host action in the transcript."""
        self.host.on_event(text)

    async def next_round(self) -> None:
        """Wait for the end of the present round, so that the changes made in it are visible."""
        self.event.set()
        await edge(self.event.net)

    def nested(self) -> AbstractContextManager[None]:
        """Return a context in which inputs are not reported: listeners have already received the whole script.

        Within this context, calls to the host only queue actions.
        """
        return self.kernel.outside.nested()

    def terminal(self, name: str, chip: Chip) -> Terminal:
        """Return the pin with this full name, or the pin of `chip` with this short name."""
        return self.bench.pin(name if "." in name else f"{chip.name}.{name}")

    def put(self, terminal: Terminal, value: int | None, at: int | None = None) -> None:
        """Drive a pin to a level or, if `value` is None, release it: now, or at the instant `at` (ps)."""
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
    """Return a function that queues a command over the host's channel."""
    return lambda runner: runner.protocol.command(body)(runner)


class ScriptProtocol:
    """The rules for scripts on a channel: how commands and bytes are sent, and which axis they address."""

    def command(self, body: str) -> Queue:
        """Return a function that queues a command."""
        raise NotImplementedError

    def send(self, data: bytes, act: Act) -> Queue:
        """Return a function that queues `act`, an action that sends bytes."""
        return lambda runner: runner.do(act)

    async def send_now(self, runner: ScriptRunner, chip: Chip, data: bytes) -> None:
        """Send bytes unchanged."""
        raise NotImplementedError

    def axis(self, runner: ScriptRunner, chip: Chip) -> int:
        """Return the number of the axis that the commands of the host address."""
        return 1
