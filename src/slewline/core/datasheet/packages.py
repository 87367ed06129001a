"""The packages of a part: the pins on each side.

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
    """A package, described by its pin names.

    Args:
        name: its name in a chipset; "" if it is the only package.
        numbered: True if its pin numbers are known; if False, the pins are in the manual's order.
        square: True if it has pins on four sides.
        sides: the pin names of each side: left and right for a DIP; left, bottom, right and top if square;
            each from top to bottom, or left to right; a number stands for a pin that is not in the sheet.
        loose: the names of pins with unknown numbers, in a package with numbered pins.
    """

    name: str
    numbered: bool
    square: bool
    sides: tuple[tuple[str | int, ...], ...]
    loose: tuple[str, ...] = ()


def packages(pins: Iterable[Pin]) -> list[Package]:
    """Return the packages of a part that has these pins."""
    return [_arranged(name, own) for name, own in _by_package([*pins]).items()]


def _by_package(pins: Sequence[Pin]) -> dict[str, list[Pin]]:
    """Return the pins of each package, keyed by package name; the only package of a part is named "".

    In a chipset, the `where` field of a pin may state its package.  If it does not, the package follows
    from the list of pins: it is that of the first pin, from this one on, that carries no signal (a supply
    pin, for example) and whose name begins with a package prefix, such as `io_` for the I/O chip.
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
    """Return the package with this name and these pins, arranged by pin number if the numbers are known."""
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
    top = (side + 1) // 2  # pin 1 is in the middle of the upper side; the next pins are to its left
    sides = (
        run(top + 1, top + side),
        run(top + side + 1, top + 2 * side),
        run(top + 3 * side, top + 2 * side + 1),
        (*run(top, 1), *run(count, top + 3 * side + 1)),
    )
    return Package(name, True, True, sides, loose)
