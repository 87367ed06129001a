"""The view of a server for a panel, as data, and its changes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any
from zlib import crc32

from ..lines.pace import Paced

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...parts.base.part import Part
    from ..face import ServerFace

Data = dict[str, Any]


class Views:
    """The views of a server; a view contains the checksum of a stored program, not the program itself."""

    def __init__(self, server: ServerFace) -> None:
        self.server, self.bench = server, server.bench

    def move(self, bench: Bench) -> None:
        """Show another bench from now on."""
        self.bench = bench

    def view(self) -> Data:
        """Return the complete current view, for a panel."""
        found: Data = {"chips": {}, "parts": {}}
        for path, value in self.pieces():
            put(found, path, value)
        return found

    def pieces(self) -> Iterator[tuple[tuple[str, ...], Any]]:
        """Yield the pieces of the view, each as a path of keys, such as ("chips", name), and a value."""
        yield ("pace",), self.pace()
        for name, chip in self.bench.chips.items():
            yield ("chips", name), self.chip(chip)
        for name, part in self.bench.parts.items():
            yield ("parts", name), part_view(part)
        yield ("findings",), self.server.found
        yield ("entries",), self.server.dialogue.number

    def pace(self) -> Data:
        """Return the state of time: mode, pause, rate and branch."""
        pace = self.server.pace
        rate = float(pace.rate) if isinstance(pace, Paced) else 1.0
        return {"lockstep": pace.lockstep, "paused": pace.paused, "rate": rate, "branch": self.server.branch}

    def chip(self, chip: Chip) -> Data:
        """Return the view of a chip."""
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
            "held": {name: pin.held for name, pin in chip.pins.items() if pin.held is not None},
            "registers": dict(chip.registers),
            "axes": axes,
            "counter": chip.program_counter,
            "working": chip.on_command.text,  # type: ignore[attr-defined]
            "waiting": chip.waiting.partition(": ")[2],
            "idle": chip.idle,
            "powered": getattr(chip, "powered", True),  # unknown for a user's own chip
            "program": crc32(chip.program),
        }


def put(view: Data, path: tuple[str, ...], value: Any) -> None:
    """Put a piece into a view, at its path of keys."""
    for key in path[:-1]:
        view = view.setdefault(key, {})
    view[path[-1]] = value


def at(view: Mapping[str, Any], path: tuple[str, ...]) -> Any:
    """Return the piece of a view at a path of keys; None if there is none."""
    found: Any = view
    for key in path:
        found = found.get(key) if isinstance(found, Mapping) else None
    return found


def levels(owner: Chip | Part) -> dict[str, int | None]:
    """Return the levels of the signal pins of a chip or part, by name; None for a pin that floats."""
    return {name: pin.level for name, pin in owner.pins.items() if pin.row.in_out in ("in", "out", "both")}


def part_view(part: Part) -> Data:
    """Return the view of a part."""
    return {"levels": levels(part), "shows": part.shows()}


def difference(before: Mapping[str, Any], after: Mapping[str, Any]) -> Data:
    """Return the changes from one view to another, in the shape of a view; a removed item is None.

    A list that has changed is returned as a whole.
    """
    found: Data = {key: None for key in before if key not in after and before[key] is not None}
    for key, value in after.items():
        old = before.get(key)
        if old == value:
            continue
        if isinstance(value, dict) and isinstance(old, dict):
            found[key] = difference(old, value)
        else:
            found[key] = value
    return found
