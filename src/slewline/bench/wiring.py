"""The standard wiring: which pins of a part are connected to which pins of a neighbour.

For each of its pins, a part names the role of the mating pin (Part.wiring); a chip or part with pins in these roles can
be its neighbour.  A driving pin is connected to one that does not drive; an input may also share the wire of another
input.

    translator      wiring         cy525          gs-c200        mc1451a, axis 2
    pulse           step           pulse (fall)   clock (rise)   pulse2 (fall)
    direction       direction      direction      dir            dir2
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import replace
from itertools import chain, count

from ..chips import CATALOGUE, sheet_of
from ..core.chip import Chip
from ..core.datasheet.roles import AXIS_ROLES, ROLES
from ..core.datasheet.table import Pin
from ..core.wires.net import Bus
from ..core.wires.pin import Terminal
from ..errors import WiringError
from ..parts.base.part import Part


def joints(kind: str, part: Part, neighbour: Chip | Part) -> list[tuple[Terminal, Terminal]]:
    """Return the connections of the standard wiring, each as a pin of the part and a pin of the neighbour.

    Raises:
        WiringError: the neighbour lacks a pin that the part needs, or a pin does not match; or the part has
            no standard wiring.
    """
    if not part.wiring:
        remedy = f"connect {', '.join(part.pins)} with bench.wire" if part.pins else "it has no pins; leave out to="
        raise WiringError(f"{part.name}: a part of kind {kind} has no standard wiring; {remedy}")
    axis = getattr(part, "axis", 1)
    found = {name: met(part.pins[name], role, axis, neighbour) for name, role in part.wiring.items()}
    for name, role in part.wiring.items():
        if found[name] is None and (name not in part.optional or not any(found.values())):
            raise WiringError(
                f"{part.name}: a part of kind {kind} needs {_wanted(role, axis)}; {_called(neighbour)} has none"
                f"{_elsewhere(role)}"
            )
    pairs = [(part.pins[name], theirs) for name, theirs in found.items() if theirs is not None]
    for own, theirs in pairs:
        _check(part, own, theirs)
    return pairs


def _elsewhere(role: str) -> str:
    """Return text, for a message, that names the built-in chips with a pin in this role; "" if there are none."""
    found = [part for part in CATALOGUE.ours if any(row.plays(role, 1) for row in sheet_of(part).pins)]
    return f"; {', '.join(found)} {'has' if len(found) == 1 else 'have'} one" if found else ""


def met(own: Terminal, role: str, axis: int, neighbour: Chip | Part) -> Terminal | None:
    """Return the neighbour's pin in a role, to be connected to the part's pin `own`; None if there is none."""
    in_out = own.row.in_out
    found = [pin for pin in neighbour.pins.values() if pin.row.plays(role, axis)]
    found = [pin for pin in found if (in_out, pin.row.in_out) != ("out", "out")]
    return min(found, key=lambda pin: pin.row.in_out == in_out, default=None)


def as_needed(row: Pin) -> Pin:
    """Return a copy of a pin with its `active` replaced by `sense`, the level at which its role is active.

    The two levels differ if the pin is named for the opposite of its role.
    """
    return replace(row, active=row.sense)


def in_role(owner: Chip | Part, role: str, axis: int = 1) -> Terminal:
    """Return the pin of a chip or part that has this role.

    Raises:
        WiringError: no pin has this role.
    """
    for pin in owner.pins.values():
        if pin.row.plays(role, axis):
            return pin
    raise WiringError(f"{_called(owner)} has no pin that {ROLES[role]}")


def _check(part: Part, own: Terminal, theirs: Terminal) -> None:
    if isinstance(own.net, Bus) != isinstance(theirs.net, Bus):
        raise WiringError(f"{own.name} and {theirs.name}: a bus of eight wires does not fit a single pin")
    if why := part.objection(own.row.name, theirs.row):
        raise WiringError(f"{own.name}: {theirs.name} {why}")


def _wanted(role: str, axis: int) -> str:
    """Return a description, for a message, of the pin that a part requires."""
    purpose = ROLES[role].partition(";")[0]
    return f"a pin that {purpose}{f' (axis {axis})' if role in AXIS_ROLES and axis != 1 else ''}"


def _called(neighbour: Chip | Part) -> str:
    return f"{neighbour.name} ({neighbour.sheet.part})" if isinstance(neighbour, Chip) else neighbour.name


def stem_of(kind: str, cls: type[Part]) -> str:
    """Return the default name for a part of this kind, to which a number is added if necessary."""
    return cls.__name__.lower() if ":" in kind else kind.replace("-", "_")


def free_name(stem: str, taken: Container[str]) -> str:
    """Return a name that is not taken: the stem, with a number added if necessary."""
    return next(name for name in chain((stem,), (f"{stem}_{number}" for number in count(2))) if name not in taken)
