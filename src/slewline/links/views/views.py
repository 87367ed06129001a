"""What a panel shows of a server, as data, and what of it has changed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol
from zlib import crc32

from ..lines.pace import Pace, Paced

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...parts.base.part import Part
    from .dialogue import Dialogue

Data = dict[str, Any]


class Viewed(Protocol):
    """What is seen of a server."""

    bench: Bench
    pace: Pace
    found: int
    branch: int

    @property
    def dialogue(self) -> Dialogue:
        """What hosts and chips have said."""


class Views:
    """The views of a server; of a stored program they have the sum, which tells another one from it."""

    def __init__(self, server: Viewed) -> None:
        self.server, self.bench = server, server.bench

    def view(self) -> Data:
        """Return everything that a panel shows, now."""
        server = self.server
        return {
            "pace": self.pace(),
            "chips": {name: self.chip(chip) for name, chip in self.bench.chips.items()},
            "parts": {name: part_view(part) for name, part in self.bench.parts.items()},
            "findings": server.found,
            "entries": server.dialogue.number,
        }

    def pace(self) -> Data:
        """Return how time passes."""
        pace = self.server.pace
        rate = float(pace.rate) if isinstance(pace, Paced) else 1.0
        return {"lockstep": pace.lockstep, "paused": pace.paused, "rate": rate, "branch": self.server.branch}

    def chip(self, chip: Chip) -> Data:
        """Return what is seen of a chip."""
        several = chip.sheet.axes > 1
        axes = [
            {
                "position": axis.position,
                "velocity": axis.motor.velocity_at(chip.kernel.seen),
                "moving": axis.motor.moving,
                **({"registers": dict(axis.registers)} if several else {}),
            }
            for axis in (chip.axis(number) for number in range(1, chip.sheet.axes + 1))
        ]
        return {
            "levels": levels(chip),
            "registers": dict(chip.registers),
            "axes": axes,
            "counter": chip.program_counter,
            "working": chip.on_command.text,  # type: ignore[attr-defined]
            "waiting": chip.waiting.partition(": ")[2],
            "idle": chip.idle,
            "program": crc32(chip.program),
        }


def levels(owner: Chip | Part) -> dict[str, int | None]:
    """Return the levels of the pins that carry a signal, by name; None: it floats."""
    return {name: pin.level for name, pin in owner.pins.items() if pin.row.way in ("in", "out", "both")}


def part_view(part: Part) -> Data:
    """Return what is seen of a part."""
    return {"levels": levels(part), "shows": part.shows()}


def difference(before: Mapping[str, Any], after: Mapping[str, Any]) -> Data:
    """Return what has changed from one view to another, in its shape.  Lists of objects keep their places."""
    found: Data = {}
    for key, value in after.items():
        old = before.get(key)
        if old == value:
            continue
        if isinstance(value, dict) and isinstance(old, dict):
            found[key] = difference(old, value)
        else:
            found[key] = value
    return found
