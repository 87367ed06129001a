"""The packages of a part: which pins are on which side.

DIP                    PLCC, counted from the middle of its upper side
1 |‾u‾| 8                   3 2 1 12 11
2 |   | 7                 4 |‾‾‾‾‾‾‾| 10
3 |   | 6                   |       |
4 |___| 5                   5 6 7 8 9
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .table import Pin

SIZES = (8, 14, 16, 18, 20, 24, 28, 38, 40, 44, 48, 64, 68, 84)  # numbers of pins of packages
LARGEST_DIP = 40
PREFIX = re.compile("([a-z]+)_")
STATED = re.compile(r"(.+? chip)\b")
SIGNALS = ("in", "out", "both")  # values of `way` for pins that carry a signal


@dataclass(frozen=True, slots=True)
class Package:
    """A package, by the names of its pins.

    Args:
        name: its name in a chipset; empty if it is the only one.
        numbered: True: the numbers of its pins are known; False: they are in the order of the manual.
        square: True: it has pins on four sides.
        sides: left and right of a DIP; left, bottom, right and top of a square one: each from top to bottom, or from
            left to right; a number is a pin that is not in the sheet.
        loose: pins whose number is not known, in a package with numbered pins.
    """

    name: str
    numbered: bool
    square: bool
    sides: tuple[tuple[str | int, ...], ...]
    loose: tuple[str, ...] = ()


def packages(pins: Iterable[Pin]) -> list[Package]:
    """Return the packages of a part with these pins."""
    return [_arranged(name, own) for name, own in _by_package([*pins]).items()]


def _by_package(pins: Sequence[Pin]) -> dict[str, list[Pin]]:
    """Return the pins of each package.

    In a chipset, `where` names the package of a pin; otherwise the pins without a signal have the package before their
    name, and a package ends with the last one of these.
    """
    numbers = [pin.number for pin in pins if pin.number]
    if len({*numbers}) == len(numbers):
        return {"": [*pins]}
    found: dict[str, list[Pin]] = {}
    for n, pin in enumerate(pins):
        stated = STATED.match(pin.where)
        prefix = next(filter(None, map(_prefix, pins[n:])), "")
        name = stated[1] if stated else prefix and f"{'I/O' if prefix == 'io' else prefix.upper()} chip"
        found.setdefault(name, []).append(pin)
    return found


def _prefix(pin: Pin) -> str:
    named = None if pin.in_out in SIGNALS else PREFIX.match(pin.name)
    return named[1] if named else ""


def _arranged(name: str, pins: Sequence[Pin]) -> Package:
    """Return the package of some pins."""
    at = {pin.number: pin.name for pin in pins if pin.number}
    if not at:
        names = [pin.name for pin in pins]
        half = (len(names) + 1) // 2
        return Package(name, False, False, (tuple(names[:half]), tuple(names[half:])))

    def run(first: int, last: int) -> tuple[str | int, ...]:
        numbers = range(first, last + 1) if first <= last else range(first, last - 1, -1)
        return tuple(at.get(number, number) for number in numbers)

    highest = max(at)
    count = next((size for size in SIZES if size >= highest), highest + highest % 2)
    loose = tuple(pin.name for pin in pins if not pin.number)
    if count <= LARGEST_DIP:
        return Package(name, True, False, (run(1, count // 2), run(count, count // 2 + 1)), loose)
    side = count // 4
    top = (side + 1) // 2  # pin 1 is in the middle of the upper side; the next ones are to its left
    sides = (
        run(top + 1, top + side),
        run(top + side + 1, top + 2 * side),
        run(top + 3 * side, top + 2 * side + 1),
        (*run(top, 1), *run(count, top + 3 * side + 1)),
    )
    return Package(name, True, True, sides, loose)
