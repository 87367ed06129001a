"""The directives of a run script: actions of a host between its commands.  script.py describes them."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from ...core.datasheet.channel import BusHandshake, Channel, HostPort, SerialLine
from ...core.datasheet.command_rows import PacketRow
from ...core.datasheet.table import Arg
from ...core.messages.near import hint
from ...core.time.timebase import picoseconds, readable
from ...core.wires.waits import first_of, level, until
from ...errors import Timeout, UnknownName, UsageError
from ...language import packets
from ...language.dialect import spoken_as
from ...language.lines import Lines
from ...parts.hosts.packet_host import POLL
from .protocols import answers, asking, meaning, returned
from .script_runner import Act, Fits, Queue, ScriptRunner

if TYPE_CHECKING:
    from ...core.chip import Chip

PIN = r"(\w+(?:\.\w+)?)"
ANY = Arg("value", 4, -1 << 31, (1 << 32) - 1)  # values that a chipset can return
POLL_PS = 5 * 10**10  # interval of the queries of a host that waits for a module


class DirectiveKind(NamedTuple):
    """A directive: a function that queues it, the pin that it uses, and a check that it suits the chip.

    `fits` raises an error if the directive does not suit the chip.
    """

    queue: Queue
    pin: str = ""
    fits: Fits | None = None


MEANT = {  # the chips that a directive is for, by the channel
    BusHandshake: "a directive for a chip on a bus",
    SerialLine: "a directive for a module on a serial line",
    HostPort: "a directive for a chipset that takes packets",
}
LETTERS = "a directive for a chip that takes letters"  # where packets are used instead


def _over(kind: type[Channel]) -> Fits:
    """Return a check that refuses a directive if the host's channel is not of this kind."""

    def fits(runner: ScriptRunner, chip: Chip) -> None:
        found = type(runner.host.channel)
        if found is not kind:
            _refuse(kind, found, chip)

    return fits


def _refuse(kind: type[Channel], found: type[Channel], chip: Chip) -> None:
    meant, instead = MEANT[kind], found.instead
    if kind is HostPort:
        instead = "takes none"
    elif found is HostPort and kind is BusHandshake:
        meant, instead = LETTERS, "takes packets"
    raise UsageError(f"{meant}; {chip.name} ({chip.sheet.part}) {instead}")


_on_bus, _on_line, _with_packets = _over(BusHandshake), _over(SerialLine), _over(HostPort)


def _has_state(runner: ScriptRunner, chip: Chip) -> None:
    _on_line(runner, chip)
    if not chip.sheet.acting("state"):
        raise UsageError(f"{chip.name} ({chip.sheet.part}) has no command to query its busy state")


def _resettable(runner: ScriptRunner, chip: Chip) -> None:
    if chip.sheet.role("reset") is None:
        _refuse(BusHandshake, SerialLine, chip)


def _acting(act: Act) -> Queue:
    return lambda runner: runner.do(act)


async def _report(runner: ScriptRunner, text: str) -> None:
    runner.report(text)


def _reporting(text: str) -> Act:
    return lambda runner, chip: _report(runner, text)


def _number(text: str, low: int, high: int) -> int:
    if re.fullmatch(r"[+-]?[0-9]+", text) is None or not low <= int(text[:12]) <= high:
        raise UsageError(f"{text}: allowed {low}..{high}")
    return int(text)


def _level(text: str) -> int:
    if text not in ("0", "1"):
        raise UsageError(f"level {text!r}; allowed 0, 1")
    return int(text)


def _matched(pattern: str, text: str, form: str) -> list[str]:
    match = re.fullmatch(pattern, text)
    if match is None:
        raise UsageError(f"{text!r}; expected {form}")
    return [group or "" for group in match.groups()]


# ---------------------------------------------------------------------------------------------------- for every chip
def _wait(rest: str) -> DirectiveKind:
    if re.fullmatch(r"!?[A-Za-z_]+", rest):
        return _wait_status(rest)
    ps = picoseconds(rest)

    async def act(runner: ScriptRunner, chip: Chip) -> None:
        await until(runner.kernel, runner.kernel.now + ps)

    return DirectiveKind(_acting(act))


def _until(rest: str) -> DirectiveKind:
    if rest == "ready":
        return DirectiveKind(_acting(_ready), fits=_has_state)
    name, value = _matched(PIN + r"\s*=\s*([+-]?\w+)", rest, "PIN=LEVEL, position=NUMBER, or ready")
    if name == "position":

        def position(_stage: ScriptRunner, chip: Chip) -> int:
            return _number(value, chip.axes[0].positions[0], chip.axes[0].positions[-1])

        return DirectiveKind(
            _acting(lambda runner, chip: _reached(runner, chip, position(runner, chip))), fits=position
        )
    wanted = _level(value)
    return DirectiveKind(_acting(lambda runner, chip: level(runner.terminal(name, chip).net, wanted)), name)


async def _reached(runner: ScriptRunner, chip: Chip, position: int) -> None:
    """Wait, without computing each step, until the position register reaches `position` or is set to it."""
    axis = runner.axis(chip)
    axis.on_change.add(runner.event.set)
    try:
        await runner.next_round()
        while axis.position != position:
            due = axis.would_arrive(position)
            if due is not None and due <= runner.kernel.now:
                due = None  # the train was cut off earlier
            if await first_of(runner.kernel, due, (runner.event.net, None)) is None:
                await runner.next_round()
    finally:
        axis.on_change.remove(runner.event.set)


def _drive(rest: str) -> DirectiveKind:
    name, value, at = _matched(PIN + r"\s*=\s*(\w+)\s*(?:@\s*(.+))?", rest, "PIN=LEVEL or PIN=LEVEL @ TIME")
    return DirectiveKind(_put(name, _level(value), at), name)


def _release(rest: str) -> DirectiveKind:
    name, at = _matched(PIN + r"\s*(?:@\s*(.+))?", rest, "PIN or PIN @ TIME")
    return DirectiveKind(_put(name, None, at), name)


def _put(name: str, value: int | None, at: str) -> Queue:
    ps = picoseconds(at) if at else None

    async def act(runner: ScriptRunner, chip: Chip) -> None:
        runner.put(runner.terminal(name, chip), value, ps)
        await runner.next_round()

    return _acting(act)


def _pulse(rest: str) -> DirectiveKind:
    name, value, width = _matched(PIN + r"\s*=\s*(\w+)\s+(.+)", rest, "PIN=LEVEL WIDTH, such as wait=0 5 ms")
    wanted, ps = _level(value), picoseconds(width)

    async def act(runner: ScriptRunner, chip: Chip) -> None:
        terminal = runner.terminal(name, chip)
        runner.put(terminal, wanted)
        runner.put(terminal, None, runner.kernel.now + ps)
        await runner.next_round()

    return DirectiveKind(_acting(act), name)


def _power(rest: str) -> DirectiveKind:
    if rest not in ("on", "off"):
        raise UsageError(f"power {rest!r}; allowed 'on', 'off'")

    async def act(runner: ScriptRunner, chip: Chip) -> None:
        runner.report(f"power {rest}")
        with runner.nested():
            chip.power(rest == "on")
        await runner.next_round()

    return DirectiveKind(_acting(act))


def _bytes(rest: str) -> DirectiveKind:
    try:
        data = bytes.fromhex(rest)
    except ValueError:
        raise UsageError(f"{rest!r}: bytes are pairs of hexadecimal digits") from None

    async def send(runner: ScriptRunner, chip: Chip) -> None:
        runner.report(f"bytes {data.hex(' ').upper()}")
        await runner.protocol.send_now(runner, chip, data)

    return DirectiveKind(lambda runner: runner.protocol.send(data, send)(runner))


def _to(rest: str) -> DirectiveKind:
    def queue(runner: ScriptRunner) -> None:
        runner.host.to(rest)

    return DirectiveKind(queue)


def _tell_part(rest: str) -> DirectiveKind:
    name, verb, number = _matched(r"(\w+)\s+(\w+)(?:\s+([+-]?[0-9]+))?", rest, "PART VERB or PART VERB NUMBER")

    def fits(runner: ScriptRunner, _chip: Chip) -> None:
        if name not in runner.bench.parts:
            parts = runner.bench.parts
            raise UnknownName(f"the bench has no part {name!r}; available: {', '.join(parts)}{hint(name, parts)}")
        verbs = runner.bench.parts[name].verbs
        if verb not in verbs:
            allowed = f"allowed {', '.join(map(repr, verbs))}" if verbs else "a script cannot operate this part"
            raise UsageError(f"tell {name} {verb!r}; {allowed}{hint(verb, verbs)}")

    async def act(runner: ScriptRunner, chip: Chip) -> None:
        part = runner.bench.parts[name]
        runner.report(f"tell {rest}")
        with runner.nested():
            getattr(part, verb)(*([int(number)] if number else []))
        await runner.next_round()

    return DirectiveKind(_acting(act), fits=fits)


def _note(rest: str) -> DirectiveKind:
    return DirectiveKind(_acting(_reporting(rest)))


# ------------------------------------------------------------------------------------- to a chip that has a reset pin
def _reset(_rest: str) -> DirectiveKind:
    async def act(runner: ScriptRunner, chip: Chip) -> None:
        with runner.nested():
            chip.reset()
        await runner.next_round()
        pin = chip.sheet.role("reset")
        if pin is not None:
            await level(chip.pins[pin.name].net, 0 if pin.active else 1)

    return DirectiveKind(_acting(act), fits=_resettable)


# ---------------------------------------------------------------------------------------------------------- on a bus
def _live(rest: str) -> DirectiveKind:
    commands = [command.strip() for command in rest.split("|")]
    if not all(commands):
        raise UsageError(f"{rest!r}: an empty command")

    async def act(runner: ScriptRunner, chip: Chip) -> None:
        runner.report(f"live {rest}")
        for group, data in await runner.port(chip).live(commands):
            runner.report(f"verify {group}: {_shown(data)}")

    return DirectiveKind(_acting(act), fits=_on_bus)


def _rate(rest: str) -> DirectiveKind:
    rate = _number(rest, 0, 127)

    def queue(runner: ScriptRunner) -> None:
        with runner.nested():
            runner.bus_host.change_rate(rate)
        runner.do(_reporting(f"rate {rate} on the fly"))

    return DirectiveKind(queue, fits=_on_bus)


def _read(rest: str) -> DirectiveKind:
    if rest != "position":
        raise UsageError(f"read {rest!r}; allowed 'position'")

    def queue(runner: ScriptRunner) -> None:
        with runner.nested():
            runner.bus_host.read_position()
        request = runner.host.queue.requests[-1]
        runner.do(lambda runner, chip: _report(runner, f"position {request.result} on the fly"))

    return DirectiveKind(queue, fits=_on_bus)


def _verify(rest: str) -> DirectiveKind:
    group = _number(rest, 0, 3)

    async def act(runner: ScriptRunner, chip: Chip) -> None:
        port = runner.port(chip)
        await port.command_mode(f"@until run=1 waits for its end, @live V {group} reads through PROG/LIVE")
        runner.report(f"verify {group}: {_shown(await port.verify(group))}")

    return DirectiveKind(_acting(act), fits=_on_bus)


def _shown(data: bytes) -> str:
    return data.decode("ascii") if data.isdigit() else data.hex(" ").upper()


# -------------------------------------------------------------------------------------------------- on a serial line
def _ask(rest: str) -> DirectiveKind:
    return DirectiveKind(asking(rest), fits=_on_line)


async def _ready(runner: ScriptRunner, chip: Chip) -> None:
    """Query the state of a module until the module is no longer busy, and report its last answer."""
    question = chip.sheet.acting("state")[0].form
    while True:
        found = await answers(runner, chip, question)
        if found != [spoken_as(chip.sheet, Lines).busy]:
            runner.report(f"{question} -> {meaning(found, chip.sheet)}")
            return
        await until(runner.kernel, runner.kernel.now + POLL_PS)


# ---------------------------------------------------------------------------------------------------------- in packets
def _wait_status(bit: str) -> DirectiveKind:
    async def act(runner: ScriptRunner, chip: Chip) -> None:
        def never() -> bool:
            """Return True if the awaited bit is motion_complete, and nothing can move the axis any more."""
            at_rest = chip.idle and not chip.armed and runner.kernel.next_time() is None
            return bit.lower() == "motion_complete" and at_rest

        port = runner.packet_port(chip)
        try:
            word = await port.until_status(bit, picoseconds(POLL), never=never)
        except Timeout:
            found = f"wait {bit}: axis {port.axis} is at rest and no event is pending, so the bit cannot change"
            runner.packet_host.finding("expect", f"{found}{_not_started(chip, port.axis)}")
            return
        runner.report(f"wait {bit} -> {returned(chip.sheet, chip.sheet.rows(PacketRow)['GET_STATUS'].reads[0], word)}")

    def fits(runner: ScriptRunner, chip: Chip) -> None:
        _with_packets(runner, chip)
        packets.status_bit(chip.sheet, bit.removeprefix("!"))

    return DirectiveKind(_acting(act), fits=fits)


def _not_started(chip: Chip, axis: int) -> str:
    """Return, as text, the finding that explains why an axis is at rest; "" if none, or if the axis moved later."""
    found = [each for each in chip.findings if each.code == "no-start" and each.text.startswith(f"axis {axis}:")]
    if not found or chip.axis(axis).motor.count(found[-1].time_ps + 1, chip.kernel.now):
        return ""
    return f"; {found[-1].code} at {readable(found[-1].time_ps)}: {found[-1].text}"


def _expect(rest: str) -> DirectiveKind:
    if packets.number(rest, ANY) is None:
        raise UsageError(f"{rest!r}: expected a decimal number, or a hexadecimal number after 0x or $")

    async def act(runner: ScriptRunner, chip: Chip) -> None:
        results = runner.packet_host.results
        if not results:
            raise UsageError("no command above has returned a value")
        axis, command, value = results[-1]
        arg = chip.sheet.rows(PacketRow)[command].reads[0]
        if packets.number(rest, arg) != value:
            found = f"{command} of axis {axis} returned {returned(chip.sheet, arg, value)}, expected {rest}"
            runner.packet_host.finding("expect", found)

    return DirectiveKind(_acting(act), fits=_with_packets)


DIRECTIVES: dict[str, Callable[[str], DirectiveKind]] = {
    "wait": _wait,
    "until": _until,
    "drive": _drive,
    "release": _release,
    "pulse": _pulse,
    "power": _power,
    "bytes": _bytes,
    "to": _to,
    "tell": _tell_part,
    "note": _note,
    "reset": _reset,
    "live": _live,
    "rate": _rate,
    "read": _read,
    "verify": _verify,
    "ask": _ask,
    "expect": _expect,
}
