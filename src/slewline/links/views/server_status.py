"""The state of a server as data, and as one line of text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ...core.time.timebase import PS_PER_S
from ..lines.pace import Paced
from ..lines.served_line import ConnectorLine, HostLine

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...core.component import Finding
    from ...core.motion.one_axis import OneAxis
    from ..face import ServerFace

SHOWN_FINDINGS = 20


def status(server: ServerFace) -> dict[str, Any]:
    """Return the complete state of a server, for a client of the control port."""
    return {
        "pace": pace(server),
        "chips": {name: chip_status(server, chip) for name, chip in server.bench.chips.items()},
        "lines": {name: line_status(line) for name, line in server.lines.items()},
        "findings": server.found,
        "troubles": server.troubles,
    }


def pace(server: ServerFace) -> dict[str, Any]:
    """Return the pace of virtual time: lockstep or a rate; for a rate, also the lag behind the wall clock (µs)."""
    lag = server.pace.lag
    found: dict[str, Any] = {"lockstep": server.pace.lockstep}
    if isinstance(server.pace, Paced):
        found |= {"rate": float(server.pace.rate), "events": lag.events, "late": lag.late}
        found |= {"worst_us": lag.worst_ns // 1000, "lost_us": lag.lost_ns // 1000}
    return found


def chip_status(server: ServerFace, chip: Chip) -> dict[str, Any]:
    """Return the state of a chip, with its last findings."""
    return {
        "part": chip.sheet.part,
        **axis_status(chip),
        "axes": [axis_status(chip.axis(number)) for number in range(1, len(chip.axes) + 1)],
        "program": chip.program.hex(),
        "idle": chip.idle,
        "moving": chip.moving,
        "waiting": chip.waiting,
        "steps": server.steps_of(chip),
        "findings": last(chip.findings),
    }


def last(findings: list[Finding]) -> list[dict[str, Any]]:
    """Return the last findings of a list, at most 20, as data."""
    return [{"time_ps": found.time_ps, "code": found.code, "text": found.text} for found in findings[-SHOWN_FINDINGS:]]


def axis_status(axis: OneAxis) -> dict[str, Any]:
    """Return the state of an axis; if given a chip, return the state of its first axis."""
    return {"position": axis.position, "registers": dict(axis.registers)}


def line_status(line: HostLine) -> dict[str, Any]:
    """Return the state of a line: the connected host, and the numbers of bytes transferred and dropped."""
    found: dict[str, Any] = {
        "chips": [chip.name for chip in line.chips],
        "host": line.host_name or None,
        "taken": line.taken,
        "given": line.given,
        "dropped": line.dropped,
    }
    if isinstance(line, ConnectorLine):
        found |= {"baud": int(line.port.baud), "format": str(line.port.word)}
        found |= {"hits": {"chip": line.to_chip.done, "host": line.to_host.done}}
        found |= {"findings": last(line.port.findings)}
    return found


def as_line(server: ServerFace) -> str:
    """Return the state of a server as one line for a terminal."""
    bench, lag = server.bench, server.pace.lag
    parts = [f"{bench.now_ps / PS_PER_S:.3f} s"]
    for name, chip in bench.chips.items():
        positions = ", ".join(str(axis.position) for axis in chip.axes)
        parts.append(f"{name} {'moves at' if chip.moving else 'idle at' if chip.idle else 'busy at'} {positions}")
    hosts = sum(line.host is not None for line in server.lines.values())
    parts.append(f"{hosts} of {len(server.lines)} lines connected")
    dropped = sum(line.dropped for line in server.lines.values())
    if dropped:
        parts.append(f"{dropped} characters dropped")
    if server.found:
        parts.append(f"{server.found} findings")
    if isinstance(server.pace, Paced):
        parts.append(f"{lag.late} of {lag.events} events late, worst {lag.worst_ns / 1e6:.1f} ms")
    return " | ".join([*parts, *(note() for note in server.notes), *server.troubles])
