"""The standard wiring: which pins of a part meet which pins of a neighbour.

A part names, for each of its pins, the role of the pin that it needs (Part.wiring); what has a pin in that role is a
neighbour for it, chip or part.  A pin that drives meets one that does not; a pin that listens also shares the wire of
another one that does.

    translator      wiring         cy525          gs-c200        mc1451a, axis 2
    pulse           step           pulse (fall)   clock (rise)   pulse2 (fall)
    direction       direction      direction      dir            dir2
"""

from __future__ import annotations

from collections.abc import Iterator

from ..core.chip import Chip
from ..core.net import Bus
from ..core.pin import Terminal
from ..core.table import AXIS_ROLES, ROLES
from ..errors import WiringError
from ..parts.part import Part

LEVEL = ("low", "high")


def joints(kind: str, part: Part, neighbour: Chip | Part) -> list[tuple[Terminal, Terminal]]:
    """Return what the standard wiring joins: pins of the part, and the pins of the neighbour that they meet.

    Raises:
        WiringError: the neighbour lacks a pin that the part needs, or has it with the contrary sense; or the part has
            no standard wiring.
    """
    if not part.wiring:
        raise WiringError(
            f"{part.name}: a part of kind {kind} has no standard wiring; connect {', '.join(part.pins)} with bench.wire"
        )
    return list(_joints(kind, part, neighbour))


def _joints(kind: str, part: Part, neighbour: Chip | Part) -> Iterator[tuple[Terminal, Terminal]]:
    axis = getattr(part, "axis", 1)
    for name, role in part.wiring.items():
        own = part.pins[name]
        theirs = met(own, role, axis, neighbour)
        if theirs is None and name not in part.optional:
            raise WiringError(
                f"{part.name}: a part of kind {kind} needs {_wanted(role, axis)}; {_called(neighbour)} has none"
            )
        if theirs is not None:
            _check(own, theirs)
            yield own, theirs


def met(own: Terminal, role: str, axis: int, neighbour: Chip | Part) -> Terminal | None:
    """Return the pin in a role that a pin of a part meets; None: there is none."""
    if role not in ROLES or not any(pin.row.role for pin in neighbour.pins.values()):  # by the pin's name, for now
        return _named(role, neighbour)
    way = own.row.way
    found = [
        pin for pin in neighbour.pins.values() if pin.row.plays(role, axis) and (way, pin.row.way) != ("out", "out")
    ]
    return min(found, key=lambda pin: pin.row.way == way, default=None) or neighbour.pins.get(role)


def _named(name: str, neighbour: Chip | Part) -> Terminal | None:
    if isinstance(neighbour, Chip) and name == neighbour.sheet.bus:
        name += "0"
    return neighbour.pins.get(name)


def in_role(owner: Chip | Part, role: str, axis: int = 1) -> Terminal:
    """Return the pin that has a role.

    Raises:
        WiringError: there is none.
    """
    for pin in owner.pins.values():
        if pin.row.plays(role, axis):
            return pin
    raise WiringError(f"{_called(owner)} has no pin that {ROLES[role]}")


def _check(own: Terminal, theirs: Terminal) -> None:
    if isinstance(own.net, Bus) != isinstance(theirs.net, Bus):
        raise WiringError(f"{own.name} and {theirs.name}: a bus of eight wires does not fit a single pin")
    senses = own.row.sense, theirs.row.sense
    if None not in senses and senses[0] != senses[1]:
        here, there = (LEVEL[sense] for sense in senses if sense is not None)
        raise WiringError(
            f"{own.name} is meant for a pin that {ROLES[theirs.row.role]} with {here} level; {theirs.name} has it with "
            f"{there} level: bench.wire(..., invert=True) puts an inverter between"
        )


def _wanted(role: str, axis: int) -> str:
    """A pin that somebody needs, in words."""
    return f"a pin that {ROLES.get(role, role)}{f' (axis {axis})' if role in AXIS_ROLES and axis != 1 else ''}"


def _called(neighbour: Chip | Part) -> str:
    return f"{neighbour.name}, a {neighbour.sheet.part.upper()}," if isinstance(neighbour, Chip) else neighbour.name
