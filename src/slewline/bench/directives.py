"""The directives of a run script: what a host does between the commands.  script.py has the guide to them."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from ..core.timebase import picoseconds
from ..core.waits import first_of, level, until
from ..errors import UsageError
from .stage import Act, Queue, Stage, sending

if TYPE_CHECKING:
    from ..core.chip import Chip
    from ..parts.host import Port

PIN = r"(\w+(?:\.\w+)?)"
Reading = tuple[Queue, str]  # how a directive is queued, and the pin that it needs


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

    return sending(send), ""


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
