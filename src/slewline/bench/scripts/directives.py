"""The directives of a run script: what a host does between the commands.  script.py has the guide to them."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from ...core.datasheet.channel import AdaptiveLine, BusHandshake, Channel, FlowBus, HostPort, SerialLine
from ...core.datasheet.table import Arg
from ...core.messages.near import hint
from ...core.time.timebase import picoseconds, readable
from ...core.wires.waits import first_of, level, until
from ...errors import Timeout, UnknownName, UsageError
from ...language import packets
from ...language.dialect import spoken_as
from ...language.lines import Lines
from ...parts.hosts.packet_host import POLL
from .speech import answers, asking, meaning, returned
from .stage import Act, Fits, Queue, Stage

if TYPE_CHECKING:
    from ...core.chip import Chip

PIN = r"(\w+(?:\.\w+)?)"
ANY = Arg("value", 4, -1 << 31, (1 << 32) - 1)  # what a chipset may return
POLL_PS = 5 * 10**10  # a host that waits for a module asks it so often


class Reading(NamedTuple):
    """How a directive is queued, the pin that it needs, and what raises if a chip does not know such a thing."""

    queue: Queue
    pin: str = ""
    fits: Fits | None = None


MEANT = {  # whom a directive is for, by the channel
    BusHandshake: "a directive for a chip on a bus",
    SerialLine: "a directive for a module on a serial line",
    HostPort: "for a chipset that takes packets",
}
INSTEAD: dict[type[Channel], str] = {  # what the host is on instead
    BusHandshake: "has a bus",
    SerialLine: "is on a serial line",
    HostPort: "has a bus",
    FlowBus: "is asked by its own commands",
    AdaptiveLine: "is asked by its own commands",
}
LETTERS = "a directive for a chip that takes letters"  # where packets are taken instead


def _over(kind: type[Channel]) -> Fits:
    """Refuse a directive to a host on another kind of channel."""

    def fits(stage: Stage, chip: Chip) -> None:
        found = type(stage.host.channel)
        if found is not kind:
            _refuse(kind, found, chip)

    return fits


def _refuse(kind: type[Channel], found: type[Channel], chip: Chip) -> None:
    meant, instead = MEANT[kind], INSTEAD[found]
    if kind is HostPort:
        instead = "takes none"
    elif found is HostPort and kind is BusHandshake:
        meant, instead = LETTERS, "takes packets"
    raise UsageError(f"{meant}; {chip.name} ({chip.sheet.part}) {instead}")


_on_bus, _on_line, _with_packets = _over(BusHandshake), _over(SerialLine), _over(HostPort)


def _has_state(stage: Stage, chip: Chip) -> None:
    _on_line(stage, chip)
    if not chip.sheet.acting("state"):
        raise UsageError(f"{chip.name} ({chip.sheet.part}) has no command that asks whether it is busy")


def _resettable(stage: Stage, chip: Chip) -> None:
    if chip.sheet.role("reset") is None:
        _refuse(BusHandshake, SerialLine, chip)


def _acting(act: Act) -> Queue:
    return lambda stage: stage.do(act)


async def _tell(stage: Stage, text: str) -> None:
    stage.tell(text)


def _telling(text: str) -> Act:
    return lambda stage, chip: _tell(stage, text)


def _number(text: str, low: int, high: int) -> int:
    if re.fullmatch(r"[+-]?[0-9]+", text) is None or not low <= int(text[:12]) <= high:
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


# ---------------------------------------------------------------------------------------------------- for every chip
def _wait(rest: str) -> Reading:
    if re.fullmatch(r"!?[A-Za-z_]+", rest):
        return _wait_status(rest)
    ps = picoseconds(rest)

    async def act(stage: Stage, chip: Chip) -> None:
        await until(stage.kernel, stage.kernel.now + ps)

    return Reading(_acting(act))


def _until(rest: str) -> Reading:
    if rest == "ready":
        return Reading(_acting(_ready), fits=_has_state)
    name, value = _matched(PIN + r"\s*=\s*([+-]?\w+)", rest)
    if name == "position":

        def position(_stage: Stage, chip: Chip) -> int:
            return _number(value, chip.axes[0].positions[0], chip.axes[0].positions[-1])

        return Reading(_acting(lambda stage, chip: _reached(stage, chip, position(stage, chip))), fits=position)
    wanted = _level(value)
    return Reading(_acting(lambda stage, chip: level(stage.terminal(name, chip).net, wanted)), name)


async def _reached(stage: Stage, chip: Chip, position: int) -> None:
    """Wait until the position register has a value, whoever changes it; nothing is paid for steps in between."""
    axis = stage.axis(chip)
    axis.on_change.add(stage.bell.ring)
    try:
        await stage.next_round()
        while axis.position != position:
            due = axis.would_arrive(position)
            if due is not None and due <= stage.kernel.now:
                due = None  # the train was cut off before
            if await first_of(stage.kernel, due, (stage.bell.net, None)) is None:
                await stage.next_round()
    finally:
        axis.on_change.remove(stage.bell.ring)


def _drive(rest: str) -> Reading:
    name, value, at = _matched(PIN + r"\s*=\s*(\w+)\s*(?:@\s*(.+))?", rest)
    return Reading(_put(name, _level(value), at), name)


def _release(rest: str) -> Reading:
    name, at = _matched(PIN + r"\s*(?:@\s*(.+))?", rest)
    return Reading(_put(name, None, at), name)


def _put(name: str, value: int | None, at: str) -> Queue:
    ps = picoseconds(at) if at else None

    async def act(stage: Stage, chip: Chip) -> None:
        stage.put(stage.terminal(name, chip), value, ps)
        await stage.next_round()

    return _acting(act)


def _pulse(rest: str) -> Reading:
    name, value, width = _matched(PIN + r"\s*=\s*(\w+)\s+(.+)", rest)
    wanted, ps = _level(value), picoseconds(width)

    async def act(stage: Stage, chip: Chip) -> None:
        terminal = stage.terminal(name, chip)
        stage.put(terminal, wanted)
        stage.put(terminal, None, stage.kernel.now + ps)
        await stage.next_round()

    return Reading(_acting(act), name)


def _power(rest: str) -> Reading:
    if rest not in ("on", "off"):
        raise UsageError(f"power {rest!r}; allowed on, off")

    async def act(stage: Stage, chip: Chip) -> None:
        stage.tell(f"power {rest}")
        with stage.nested():
            chip.power(rest == "on")
        await stage.next_round()

    return Reading(_acting(act))


def _bytes(rest: str) -> Reading:
    try:
        data = bytes.fromhex(rest)
    except ValueError:
        raise UsageError(f"{rest!r}: bytes are pairs of hexadecimal digits") from None

    async def send(stage: Stage, chip: Chip) -> None:
        stage.tell(f"bytes {data.hex(' ').upper()}")
        await stage.speech.send_now(stage, chip, data)

    return Reading(lambda stage: stage.speech.send(data, send)(stage))


def _to(rest: str) -> Reading:
    def queue(stage: Stage) -> None:
        stage.host.to(rest)

    return Reading(queue)


def _told(rest: str) -> Reading:
    name, verb, number = _matched(r"(\w+)\s+(\w+)(?:\s+([+-]?[0-9]+))?", rest)

    def fits(stage: Stage, _chip: Chip) -> None:
        if name not in stage.bench.parts:
            parts = stage.bench.parts
            raise UnknownName(f"the bench has no part {name!r}; there are: {', '.join(parts)}{hint(name, parts)}")
        verbs = stage.bench.parts[name].verbs
        if verb not in verbs:
            raise UsageError(f"tell {name} {verb!r}; allowed {', '.join(verbs) or 'nothing'}{hint(verb, verbs)}")

    async def act(stage: Stage, chip: Chip) -> None:
        part = stage.bench.parts[name]
        stage.tell(f"tell {rest}")
        with stage.nested():
            getattr(part, verb)(*([int(number)] if number else []))
        await stage.next_round()

    return Reading(_acting(act), fits=fits)


def _note(rest: str) -> Reading:
    return Reading(_acting(_telling(rest)))


# ------------------------------------------------------------------------------------- to a chip that has a reset pin
def _reset(_rest: str) -> Reading:
    async def act(stage: Stage, chip: Chip) -> None:
        with stage.nested():
            chip.reset()
        await stage.next_round()
        pin = chip.sheet.role("reset")
        if pin is not None:
            await level(chip.pins[pin.name].net, 0 if pin.active else 1)

    return Reading(_acting(act), fits=_resettable)


# ---------------------------------------------------------------------------------------------------------- on a bus
def _live(rest: str) -> Reading:
    commands = [command.strip() for command in rest.split("|")]
    if not all(commands):
        raise UsageError(f"{rest!r}: an empty command")

    async def act(stage: Stage, chip: Chip) -> None:
        stage.tell(f"live {rest}")
        for group, data in await stage.port(chip).live(commands):
            stage.tell(f"verify {group}: {_shown(data)}")

    return Reading(_acting(act), fits=_on_bus)


def _rate(rest: str) -> Reading:
    rate = _number(rest, 0, 127)

    def queue(stage: Stage) -> None:
        with stage.nested():
            stage.bus_host.change_rate(rate)
        stage.do(_telling(f"rate {rate} on the fly"))

    return Reading(queue, fits=_on_bus)


def _read(rest: str) -> Reading:
    if rest != "position":
        raise UsageError(f"read {rest!r}; allowed position")

    def queue(stage: Stage) -> None:
        with stage.nested():
            stage.bus_host.read_position()
        request = stage.host.queue.requests[-1]
        stage.do(lambda stage, chip: _tell(stage, f"position {request.result} on the fly"))

    return Reading(queue, fits=_on_bus)


def _verify(rest: str) -> Reading:
    group = _number(rest, 0, 3)

    async def act(stage: Stage, chip: Chip) -> None:
        port = stage.port(chip)
        await port.command_mode(f"@until run=1 waits for its end, @live V {group} reads through PROG/LIVE")
        stage.tell(f"verify {group}: {_shown(await port.verify(group))}")

    return Reading(_acting(act), fits=_on_bus)


def _shown(data: bytes) -> str:
    return data.decode("ascii") if data.isdigit() else data.hex(" ").upper()


# -------------------------------------------------------------------------------------------------- on a serial line
def _ask(rest: str) -> Reading:
    return Reading(asking(rest), fits=_on_line)


async def _ready(stage: Stage, chip: Chip) -> None:
    """Ask a module for its state until it is no longer busy."""
    question = chip.sheet.acting("state")[0].form
    while True:
        found = await answers(stage, chip, question)
        if found != [spoken_as(chip.sheet, Lines).busy]:
            stage.tell(f"{question} -> {meaning(found, chip.sheet)}")
            return
        await until(stage.kernel, stage.kernel.now + POLL_PS)


# ---------------------------------------------------------------------------------------------------------- in packets
def _wait_status(bit: str) -> Reading:
    async def act(stage: Stage, chip: Chip) -> None:
        def never() -> bool:
            """Does nobody move the axis any more?"""
            at_rest = chip.idle and not chip.armed and stage.kernel.next_time() is None
            return bit.lower() == "motion_complete" and at_rest

        port = stage.packet_port(chip)
        try:
            word = await port.until_status(bit, picoseconds(POLL), never=never)
        except Timeout:
            found = f"wait {bit}: axis {port.axis} is at rest, and nothing is going to happen any more"
            stage.packet_host.finding("expect", f"{found}{_not_started(chip, port.axis)}")
            return
        stage.tell(f"wait {bit} -> {returned(chip.sheet, chip.sheet.commands['GET_STATUS'].reads[0], word)}")

    def fits(stage: Stage, chip: Chip) -> None:
        _with_packets(stage, chip)
        packets.status_bit(chip.sheet, bit.removeprefix("!"))

    return Reading(_acting(act), fits=fits)


def _not_started(chip: Chip, axis: int) -> str:
    """Why an axis of a chipset is at rest, if a finding tells; one behind which it has moved tells nothing."""
    found = [each for each in chip.findings if each.code == "no-start" and each.text.startswith(f"axis {axis}:")]
    if not found or chip.axis(axis).motor.count(found[-1].time_ps + 1, chip.kernel.now):
        return ""
    return f"; {found[-1].code} at {readable(found[-1].time_ps)}: {found[-1].text}"


def _expect(rest: str) -> Reading:
    if packets.number(rest, ANY) is None:
        raise UsageError(f"{rest!r}: expected a number, decimal or hexadecimal behind 0x or $")

    async def act(stage: Stage, chip: Chip) -> None:
        results = stage.packet_host.results
        if not results:
            raise UsageError("no command above has returned anything")
        axis, command, value = results[-1]
        arg = chip.sheet.commands[command].reads[0]
        if packets.number(rest, arg) != value:
            found = f"{command} of axis {axis} returned {returned(chip.sheet, arg, value)}, expected {rest}"
            stage.packet_host.finding("expect", found)

    return Reading(_acting(act), fits=_with_packets)


DIRECTIVES: dict[str, Callable[[str], Reading]] = {
    "wait": _wait,
    "until": _until,
    "drive": _drive,
    "release": _release,
    "pulse": _pulse,
    "power": _power,
    "bytes": _bytes,
    "to": _to,
    "tell": _told,
    "note": _note,
    "reset": _reset,
    "live": _live,
    "rate": _rate,
    "read": _read,
    "verify": _verify,
    "ask": _ask,
    "expect": _expect,
}
