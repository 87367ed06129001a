"""The run script: what a host sends, a command a line, and what it does in between.

    ; weld.cy525           a comment runs to the end of the line
    R 80                   goes out with a carriage return
    A$P 40                 a label goes out as it stands
    QX                     Q goes out without a carriage return, as the chip wants it; here X follows
    @until run=1           a line that begins with @ directs the host

A directive begins when the chip is READY after the command above it, or has been at work on it for 1 ms (at 11 MHz: a
motion, a delay, a wait).  Directives take times such as 20 ms, and pins of the chip that the host speaks to (abort) or
of anything on the bench (y.abort):

    @wait 20 ms            let time pass
    @until run=1           wait for a level of a pin
    @until position=40     wait for a position
    @drive abort=0         put a level on a pin, now
    @drive abort=0@12 ms   or at an instant of the run
    @release abort         let go of a pin, now; or, as above, @release abort@15 ms
    @pulse wait=0 20 us    put a level on a pin for a time
    @reset                 pulse RESET
    @live R 20 | B         commands to a running program, through PROG/LIVE
    @rate 60               another rate on the fly, when the motor slews
    @read position         read the position on the fly, while the motor steps
    @verify 3              read a verify group
    @bytes 43 00           send bytes as they are
    @to y                  from here on, speak to chip y of those that share the bus
    @note the door opens   say something in the transcript

While ASCII/BINARY is low, commands go out in binary form.
"""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ..core.net import Driver, Net
from ..core.timebase import picoseconds, readable
from ..core.waits import edge, first_of, level, until
from ..errors import SlewlineError, UsageError
from ..language.assemble import RefusedProgram
from ..language.dialects import Command, Decoder, encode_binary
from ..language.problems import Problem
from ..language.source import host_lines

if TYPE_CHECKING:
    from ..core.chip import Chip, Terminal
    from ..core.table import Sheet
    from ..parts.host import Host, Port
    from .bench import Bench

TAKEN_US = 1000  # a command that keeps the chip busy for longer has begun a motion, a delay or a wait
LONGEST = 1000  # characters of a line; no chip takes as many
EXAMPLES = re.findall(r"^    (@(\w+).*?)  +\S", __doc__ or "", re.MULTILINE)
PIN = r"(\w+(?:\.\w+)?)"

Act = Callable[["Stage", "Port"], Awaitable[None]]
Queue = Callable[["Stage"], None]
Reading = tuple[Queue, str]  # how a directive is queued, and the pin that it needs


@dataclass(frozen=True, slots=True)
class Step:
    """A line of a script.  `queue` puts it into the queue of a host; `pin` and `to` are names that the bench must have."""

    line: int
    column: int
    text: str
    queue: Queue
    pin: str = ""
    to: str = ""

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
        """What is wrong with this line."""
        return Problem(self.line, self.column, min(len(self.text), 60), code, "error", found, remedy=remedy)


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
            raise RefusedProgram(found, self.text, self.where)


# ------------------------------------------------------------------------------------------------------------- playing
class Stage:
    """A host that plays a script on a bench.  `step` is the line that is being queued, `directed` says whether a
    directive follows it."""

    def __init__(self, bench: Bench, host: Host, script: Script) -> None:
        self.bench, self.host, self.script = bench, host, script
        self.kernel = bench.kernel
        self.step: Step | None = None
        self.directed = False
        self.bell, self.rung = Driver(Net(self.kernel, f"{host.name}.(bell)"), host.name), 0

    def do(self, act: Act) -> None:
        """Queue an action of the host for the present line; what goes wrong in it is told with the line."""
        step, script = self.step, self.script
        assert step is not None

        async def action(port: Port) -> None:
            self.host.doing = f"at {step.text[:60]!r} ({script.where}, line {step.line})"
            try:
                await act(self, port)
            except SlewlineError as error:
                raise RefusedProgram([step.problem("refused", str(error))], script.text, script.where) from error

        self.host.do(action)

    def tell(self, text: str) -> None:
        """Say what the host does, in the transcript."""
        if self.host.on_event is not None:
            self.host.on_event(text)

    def ring(self) -> None:
        """Wake who waits for the bell, in the next round."""
        self.rung += 1
        self.bell.drive(self.rung)

    async def next_round(self) -> None:
        """Let the round of this instant end, so that its changes show."""
        self.ring()
        await edge(self.bell.net)

    @contextmanager
    def only_queued(self) -> Iterator[Host]:
        """Calls of the host that are just queued: no time passes, and the journal has the whole script already."""
        host = self.host
        kept = host.wait_for, host.on_input
        host.wait_for = host.on_input = None
        try:
            yield host
        finally:
            host.wait_for, host.on_input = kept

    def chip(self, port: Port) -> Chip:
        """The chip at a port."""
        return self.bench.chips[port.chip]

    def terminal(self, name: str, chip: str) -> Terminal:
        """A pin by its short or full name."""
        return self.bench.pin(name if "." in name else f"{chip}.{name}")

    def put(self, terminal: Terminal, value: int | None) -> None:
        """Drive a pin or let go of it; the journal has the whole script already."""
        kept, terminal.on_input = terminal.on_input, None
        try:
            if value is None:
                terminal.release()
            else:
                terminal.drive(value)
        finally:
            terminal.on_input = kept

    def put_at(self, terminal: Terminal, value: int | None, at: int | None) -> None:
        """The same at an instant; None: now."""
        if at is None:
            self.put(terminal, value)
        else:
            self.bench.at(at, lambda: self.put(terminal, value))


def run_script(bench: Bench, host: Host, script: Script | str | Iterable[str], where: str = "script") -> None:
    """Queue a script on a host; it plays while time passes, side by side with those of other hosts.

    Args:
        script: text, lines, or what `read_script` made of them.
        where: the name of the script in messages.

    Raises:
        ProgramError: lines that cannot be played; all of them are in `.problems`.
    """
    if not isinstance(script, Script):
        script = read_script(script if isinstance(script, str) else "\n".join(script), where)
    check_script(bench, host, script)
    if host.on_input is not None:
        host.on_input("script", [host.port.chip, script.text, script.where])
    stage = Stage(bench, host, script)
    following = [*script.steps[1:], None]
    for stage.step, then in zip(script.steps, following, strict=False):
        stage.directed = then is not None and then.directs
        stage.step.queue(stage)


def check_script(bench: Bench, host: Host, script: Script) -> None:
    """Raise what is wrong with a script, pins and chips that the bench does not have included."""
    found = list(script.problems)
    stage, chip = Stage(bench, host, script), host.port.chip
    for step in script.steps:
        if step.to in host.ports:
            chip = step.to
        elif step.to:
            found.append(step.problem("unknown-chip", f"{host.name} serves {', '.join(host.ports)}, but not {step.to}"))
        if step.pin:
            try:
                stage.terminal(step.pin, chip)
            except SlewlineError as error:
                found.append(step.problem("unknown-pin", str(error)))
    script.refuse(found)


# ------------------------------------------------------------------------------------------------------------- reading
def read_script(text: str, where: str = "script") -> Script:
    """Take a text apart.  Never raises: what is wrong is in `problems`."""
    steps, problems = [], []
    for line, column, body in host_lines(text):
        step = Step(line, column, body, _command(body))
        try:
            _plain(step)
            steps.append(_directive(step) if step.directs else step)
        except UsageError as error:
            example = next((example for example, verb in EXAMPLES if verb == step.verb), "")
            remedy = f"write, for example, {example}" if example else ""
            problems.append(step.problem("directive" if step.directs else "line", str(error), remedy))
    return Script(text, where, tuple(steps), tuple(problems))


def _plain(step: Step) -> None:
    """A host sends printable ASCII, and no line without end."""
    if len(step.text) > LONGEST:
        raise UsageError(f"a line of {len(step.text)} characters; allowed {LONGEST}")
    odd = next((c for c in step.text if not " " <= c <= "~"), None)
    if odd is not None and step.verb != "note":
        raise UsageError(f"{odd!r} at character {step.text.index(odd) + 1} is not printable ASCII; @bytes sends other bytes")


def _directive(step: Step) -> Step:
    if step.verb not in DIRECTIVES:
        raise UsageError(f"no directive @{step.verb}; there are {' '.join('@' + verb for verb in DIRECTIVES)}")
    rest = step.text[1 + len(step.verb) :].strip()
    if bool(rest) == (step.verb == "reset"):
        raise UsageError("@reset takes no argument" if rest else f"@{step.verb} needs an argument")
    queue, pin = DIRECTIVES[step.verb](rest)
    return replace(step, queue=queue, pin=pin, to=rest if step.verb == "to" else "")


# ------------------------------------------------------------------------------------------------------------ commands
def spelled(body: str, sheet: Sheet) -> bytes:
    """A line as a host sends it: with a carriage return, which neither Q takes nor a label that stands alone."""
    at = 0
    while body[at + 1 : at + 2] == "$":
        at += 2
    row = sheet.commands.by_form.get(body[at : at + 1])
    if row is not None and not row.terminated:
        rest = body[at + 1 :]
        return body[: at + 1].encode("ascii") + (spelled(rest, sheet) if rest else b"")
    return body.encode("ascii") + (b"\r" if at < len(body) else b"")


def spelled_binary(body: str, sheet: Sheet) -> bytes:
    """The same in binary form: letter, count, data."""
    decoder, out = Decoder(sheet), b""
    for byte in spelled(body, sheet):
        found = decoder.feed(byte, True, False)
        if isinstance(found, Command):
            out += encode_binary(found.row, found.values)
        elif found is not None:
            raise UsageError("a label, while ASCII/BINARY is low: binary programs branch to addresses (s.3)")
    if not out:
        raise UsageError(f"{body!r} is no command, so it has no binary form; @bytes sends any bytes")
    return out


def _command(body: str) -> Queue:
    async def send(stage: Stage, port: Port) -> None:
        await level(port.ready, 1)
        data = (spelled if port.mode.level != 0 else spelled_binary)(body, port.sheet)
        stage.tell(body)
        await stage.host.send_now(port, data)

    return _sending(send)


def _sending(send: Act) -> Queue:
    def queue(stage: Stage) -> None:
        stage.do(send)
        if stage.directed:
            stage.do(_taken)

    return queue


async def _taken(stage: Stage, port: Port) -> None:
    """The chip is READY again, or at work for so long that it moves or waits."""
    await first_of(stage.kernel, stage.kernel.now + port.ps(TAKEN_US), (port.ready, 1))


# ---------------------------------------------------------------------------------------------------------- directives
def _acting(act: Act) -> Queue:
    return lambda stage: stage.do(act)


async def _tell(stage: Stage, text: str) -> None:
    stage.tell(text)


def _telling(text: str) -> Act:
    return lambda stage, port: _tell(stage, text)


def _number(text: str, low: int, high: int) -> int:
    if not (text.isascii() and text.isdigit() and low <= int(text[:9]) <= high):
        raise UsageError(f"{text}: allowed {low}..{high}")
    return int(text)


def _level(text: str) -> int:
    if text not in ("0", "1"):
        raise UsageError(f"level {text!r}; allowed 0, 1")
    return int(text)


def _matched(pattern: str, text: str) -> list[str]:
    match = re.fullmatch(pattern, text)
    if match is None:
        raise UsageError(f"{text!r} cannot be read")
    return [group or "" for group in match.groups()]


def _wait(rest: str) -> Reading:
    ps = picoseconds(rest)

    async def act(stage: Stage, port: Port) -> None:
        await until(stage.kernel, stage.kernel.now + ps)

    return _acting(act), ""


def _until(rest: str) -> Reading:
    name, value = _matched(PIN + r"\s*=\s*(\w+)", rest)
    if name == "position":
        position = _number(value, 0, 65535)
        return _acting(lambda stage, port: _reached(stage, stage.chip(port), position)), ""
    wanted = _level(value)
    return _acting(lambda stage, port: level(stage.terminal(name, port.chip).net, wanted)), name


async def _reached(stage: Stage, chip: Chip, position: int) -> None:
    """Wait until the position register has a value, whoever changes it; nothing is paid for steps in between."""
    axis = chip.axes[0]
    axis.watchers.append(stage.ring)  # with every plan of the motor
    try:
        await stage.next_round()
        while chip.position != position:
            due = axis.would_arrive(position)
            if due is not None and due <= stage.kernel.now:
                due = None  # the train was cut off before
            if await first_of(stage.kernel, due, (stage.bell.net, None)) is None:
                await stage.next_round()
    finally:
        axis.watchers.remove(stage.ring)


def _drive(rest: str) -> Reading:
    name, value, at = _matched(PIN + r"\s*=\s*(\w+)\s*(?:@\s*(.+))?", rest)
    return _put(name, _level(value), at), name


def _release(rest: str) -> Reading:
    name, at = _matched(PIN + r"\s*(?:@\s*(.+))?", rest)
    return _put(name, None, at), name


def _put(name: str, value: int | None, at: str) -> Queue:
    ps = picoseconds(at) if at else None

    async def act(stage: Stage, port: Port) -> None:
        stage.put_at(stage.terminal(name, port.chip), value, ps)
        await stage.next_round()

    return _acting(act)


def _pulse(rest: str) -> Reading:
    name, value, width = _matched(PIN + r"\s*=\s*(\w+)\s+(.+)", rest)
    wanted, ps = _level(value), picoseconds(width)

    async def act(stage: Stage, port: Port) -> None:
        terminal = stage.terminal(name, port.chip)
        stage.put(terminal, wanted)
        stage.put_at(terminal, None, stage.kernel.now + ps)
        await stage.next_round()

    return _acting(act), name


def _reset(_rest: str) -> Reading:
    async def act(stage: Stage, port: Port) -> None:
        terminal = port.pins["reset"]
        kept, terminal.on_input = terminal.on_input, None
        stage.chip(port).reset()
        terminal.on_input = kept
        await stage.next_round()

    return _acting(act), ""


def _live(rest: str) -> Reading:
    commands = [command.strip() for command in rest.split("|")]
    if not all(commands):
        raise UsageError(f"{rest!r}: an empty command")

    def queue(stage: Stage) -> None:
        stage.do(_telling(f"live {rest}"))
        with stage.only_queued() as host:
            host.live(*commands)

    return queue, ""


def _rate(rest: str) -> Reading:
    rate = _number(rest, 0, 127)

    def queue(stage: Stage) -> None:
        with stage.only_queued() as host:
            host.change_rate(rate)
        stage.do(_telling(f"rate {rate} on the fly"))

    return queue, ""


def _read(rest: str) -> Reading:
    if rest != "position":
        raise UsageError(f"read {rest!r}; allowed position")

    def queue(stage: Stage) -> None:
        with stage.only_queued() as host:
            host.read_position()
        stage.do(lambda stage, port: _tell(stage, f"position {stage.host.answer} on the fly"))

    return queue, ""


def _verify(rest: str) -> Reading:
    group = _number(rest, 0, 3)

    def queue(stage: Stage) -> None:
        with stage.only_queued() as host:
            host.verify(group)
        stage.do(lambda stage, port: _tell(stage, f"verify {group}: {_shown(stage.host.answer)}"))

    return queue, ""


def _shown(data: bytes) -> str:
    return data.decode("ascii") if data.isdigit() else data.hex(" ").upper()


def _bytes(rest: str) -> Reading:
    try:
        data = bytes.fromhex(rest)
    except ValueError:
        raise UsageError(f"{rest!r}: bytes are pairs of hexadecimal digits") from None

    async def send(stage: Stage, port: Port) -> None:
        stage.tell(f"bytes {data.hex(' ').upper()}")
        await stage.host.send_now(port, data)

    return _sending(send), ""


def _to(rest: str) -> Reading:
    def queue(stage: Stage) -> None:
        stage.host.to(rest)

    return queue, ""


def _note(rest: str) -> Reading:
    return _acting(_telling(rest)), ""


DIRECTIVES: dict[str, Callable[[str], Reading]] = {
    "wait": _wait,
    "until": _until,
    "drive": _drive,
    "release": _release,
    "pulse": _pulse,
    "reset": _reset,
    "live": _live,
    "rate": _rate,
    "read": _read,
    "verify": _verify,
    "bytes": _bytes,
    "to": _to,
    "note": _note,
}
