"""The results of a run: the object that --json prints, and a few lines for human readers."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from ..bench import Bench
from ..core.chip import Chip
from ..core.component import Finding
from ..core.datasheet.channel import HostPort
from ..core.messages.whole import counted
from ..core.motion.one_axis import OneAxis
from ..core.time.timebase import PS_PER_S, readable
from ..parts.hosts.host import Host
from ..parts.hosts.packet_host import PacketHost

WINDOW_PS = 10**13  # steps are counted in windows of 10 s, because those of an hour may not fit into memory


def as_json(bench: Bench, ended: str, whole: bool) -> str:
    """Return the JSON text of a run: of the whole bench if `whole`, else of its only chip."""
    chips = {name: chip_object(bench, chip, ended) for name, chip in bench.chips.items()}
    found: Any = {"chips": chips, "findings": [finding_object(found) for found in bench.findings]}
    if not whole:
        found = next(iter(chips.values())) | {"findings": found["findings"]}
    return json.dumps(found, indent=2, ensure_ascii=False) + "\n"


def chip_object(bench: Bench, chip: Chip, ended: str) -> dict[str, Any]:
    """Return the state of a chip as data for JSON."""
    hosts = [part for part in bench.parts.values() if isinstance(part, Host) and chip.name in part.chips]
    found: dict[str, Any] = {
        "chip": chip.sheet.part,
        "crystal_hz": chip.crystal_hz if chip.sheet.crystal_high_hz else None,
        "time_ps": bench.now_ps,
        "ended": ended,
        "position": chip.position,
        "registers": dict(chip.registers),
        "pins": {row.name: chip.pin(row.name).level for row in chip.sheet.pins if row.in_out not in ("power", "none")},
        "program": chip.program.hex(),
        "steps": steps_object(bench, chip),
        "received": b"".join(received(host) for host in hosts).hex(),
        "findings": [finding_object(found) for found in chip.findings],
    }
    if chip.sheet.channel(HostPort) is not None:
        found["axes"] = [axis_object(bench, chip, number) for number in range(1, chip.sheet.axes + 1)]
        found["results"] = [one._asdict() for host in hosts if isinstance(host, PacketHost) for one in host.results]
    return found


def axis_object(bench: Bench, chip: Chip, number: int) -> dict[str, Any]:
    """Return the state of the axis `number` of a chip with several axes, as data for JSON."""
    axis = chip.axis(number)
    return {
        "axis": number,
        "position": axis.position,
        "registers": dict(axis.registers),
        "steps": steps_object(bench, axis),
    }


def received(host: Host) -> bytes:
    """Return the data that a host has received; each 16-bit word becomes two bytes, the high byte first."""
    if isinstance(host, PacketHost):
        return b"".join(word.to_bytes(2, "big") for word in host.received)
    return bytes(host.received)


def finding_object(found: Finding) -> dict[str, Any]:
    """Return a finding as data for JSON."""
    return {"time_ps": found.time_ps, "source": found.source, "code": found.code, "text": found.text}


def steps_object(bench: Bench, axis: OneAxis) -> dict[str, Any]:
    """Return data about the steps of an axis: number, first and last instants (ps), shortest interval (ps)."""
    count, first, last, shortest = 0, None, None, None
    for times in _windows(bench, axis):
        gaps = [int((times[1:] - times[:-1]).min())] if len(times) > 1 else []
        gaps += [int(times[0]) - last] if last is not None else []
        shortest = min([*gaps, *([] if shortest is None else [shortest])], default=None)
        first = int(times[0]) if first is None else first
        count, last = count + len(times), int(times[-1])
    return {"count": count, "first_ps": first, "last_ps": last, "min_interval_ps": shortest}


def _windows(bench: Bench, axis: OneAxis) -> Iterator[Any]:
    for start in range(0, bench.now_ps + 1, WINDOW_PS):
        times = axis.steps(start, start + WINDOW_PS - 1).times_ps
        if len(times):
            yield times


def summary(bench: Bench, ended: str) -> Iterator[str]:
    """Yield one line about the end of a run, then one line for every axis."""
    yield f"{ended} at {readable(bench.now_ps)}"
    for chip in bench.chips.values():
        for number in range(1, chip.sheet.axes + 1):
            axis = chip.axis(number)
            steps = steps_object(bench, axis)
            items = [f"position {axis.position}", counted(steps["count"], "step")]
            if steps["min_interval_ps"]:
                items.append(f"up to {round(PS_PER_S / steps['min_interval_ps'])} steps/s")
            if number == 1:
                items.append(counted(len(chip.findings), "finding"))
            which = f", axis {number}" if chip.sheet.axes > 1 else ""
            yield f"{chip.name} ({chip.sheet.part}){which}: {', '.join(items)}"
