"""A package seen from above: its pins with number, name and level."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import chain
from typing import TYPE_CHECKING

from .markup import HIGH, Markup, element

if TYPE_CHECKING:
    from ..datasheet.packages import Package
    from ..datasheet.table import Pin

PITCH, MARK = 17, 13  # from pin to pin; side of the square that shows a level
LEVEL, NUMBER, NAME = 11, 27, 38  # from the edge of the package to the middle of level and number, and to the name
CHARACTER = 6.4  # its width
BODY = 92  # width of a DIP
MARGIN = 4
SIDES = {"left": (-1, 0), "bottom": (0, 1), "right": (1, 0), "top": (0, -1)}  # direction of its pins
IN_OUT = {"in": "input", "out": "output", "both": "input and output", "power": "supply", "none": "no signal"}
LEVELS = {0: "low", 1: "high", None: "floating"}


def package_drawing(package: Package, part: str, pins: Mapping[str, Pin], levels: Mapping[str, int | None]) -> Markup:
    """Return the drawing of a package as SVG.

    Args:
        part: the part number, which is printed on the package.
        pins: the pins of the part, by name.
        levels: the levels of the signal pins, by name; None for a floating pin.
    """
    named = [name for name in chain(*package.sides) if isinstance(name, str)]
    around = NAME + CHARACTER * max(map(len, named), default=0) + MARGIN
    high = PITCH * max(map(len, package.sides))
    wide, above = (high, around) if package.square else (BODY, MARGIN)
    size = [f"{wide + 2 * around:g}", f"{high + 2 * above:g}"]
    drawn = [
        element("rect", x=around, y=above, width=wide, height=high, rx=4, fill="#8882", stroke="currentColor"),
        _print(part, package, around + wide / 2, above + high / 2),
    ]
    if package.numbered:
        notch = around + wide / 2, above + 10
        drawn.append(element("circle", cx=notch[0], cy=notch[1], r=4, fill="none", stroke="currentColor"))
    for side, row in zip(SIDES if package.square else ("left", "right"), package.sides, strict=True):
        for n, pin in enumerate(row):
            along = (n + 0.5) * PITCH
            x = around + {"left": 0, "right": wide}.get(side, along)
            y = above + {"top": 0, "bottom": high}.get(side, along)
            inside = _pin(pins[pin], levels, side) if isinstance(pin, str) else [_number(str(pin), side)]
            drawn.append(element("g", inside, transform=f"translate({x:g} {y:g})"))
    return element(
        "svg", drawn, viewBox=f"0 0 {size[0]} {size[1]}", width=size[0], height=size[1], role="img",
        aria_label=f"{_called(part, package)}: its pins and their levels", fill="currentColor", font_size=10.5,
    )  # fmt: skip


def _called(part: str, package: Package) -> str:
    return f"{part}, {package.name}" if package.name else part


def _print(part: str, package: Package, x: float, y: float) -> Markup:
    """Return the text printed on a package, centred at (x, y): the part number and the package name."""
    turned = "" if package.square else " rotate(-90)"
    lines = [
        element("text", text, y=4 + 18 * n, font_size=size, font_weight=weight, letter_spacing=1)
        for n, (text, size, weight) in enumerate([(part, 15, 600), (package.name, 11, 400)])
    ]
    return element("g", lines, transform=f"translate({x:g} {y:g}){turned}", text_anchor="middle")


def _pin(pin: Pin, levels: Mapping[str, int | None], side: str) -> list[Markup]:
    """Return the drawing of a pin on one side of the package, with the edge of the package at the origin."""
    right, down = SIDES[side]
    level = f", {LEVELS[levels[pin.name]]}" if pin.name in levels else ""
    active = "" if pin.active is None else f", active {LEVELS[pin.active]}"
    upright = bool(right)
    name = element(
        "text", pin.name, x=NAME * (right or -down), y=4, transform=None if upright else "rotate(-90)",
        text_anchor="end" if -1 in (right, -down) else "start",
        text_decoration="overline" if pin.active == 0 else None, opacity=None if level else 0.6,
    )  # fmt: skip
    return [
        element(
            "title", f"{pin.number or ''} {pin.name}: {IN_OUT[pin.in_out]}{active}{level}. {pin.description}".strip()
        ),
        *(_mark(levels[pin.name], LEVEL * right, LEVEL * down) if level else _wire(side)),
        *([_number(str(pin.number), side)] if pin.number else []),
        name,
    ]


def _mark(level: int | None, x: float, y: float) -> list[Markup]:
    """Return the mark for a level, clear without colour: filled for 1, empty for 0, dashed for floating."""
    fill, line, ink = (HIGH, HIGH, "#14100a") if level == 1 else ("none", "currentColor", "currentColor")
    box = {"x": x - MARK / 2, "y": y - MARK / 2, "width": MARK, "height": MARK, "rx": 2}
    return [
        element("rect", **box, fill=fill, stroke=line, stroke_dasharray="2 2" if level is None else None),
        element("text", "z" if level is None else str(level), x=x, y=y + 3.5, text_anchor="middle", fill=ink),
    ]


def _wire(side: str) -> list[Markup]:
    """Return the drawing of a pin without a signal: a short line, instead of the mark for a level."""
    right, down = SIDES[side]
    return [element("path", d=f"M0 0L{(LEVEL + 6) * right} {(LEVEL + 6) * down}", stroke="currentColor", opacity=0.6)]


def _number(number: str, side: str) -> Markup:
    right, down = SIDES[side]
    return element(
        "text", number, x=NUMBER * right, y=NUMBER * down + 3.5, text_anchor="middle", font_size=9, opacity=0.72
    )
