"""A shaft on the face of its motor, animated with its recorded movement.

The animation is CSS: the positions at equal time intervals, played in a loop.  If the user's settings
request reduced motion, the shaft is shown at its last position.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, pi, sin
from zlib import crc32

from .markup import ACCENT, Markup, element

SIZE, TICKS, LONG = 120, 40, 5  # of the face; ticks around it, every fifth one longer
PAUSE_S = 1.0  # pause at the end


def shaft_dial(turns: Sequence[float], play_s: float) -> Markup:
    """Return the motor face and the shaft as SVG.

    Args:
        turns: the angle of the shaft, in revolutions clockwise, at equal time intervals; a single value if
            the shaft has not turned.
        play_s: the duration of the animation, in seconds, without the pause at its end.
    """
    drawn = [*_face()]
    rotor: dict[str, object] = {"transform": f"rotate({360 * (turns[-1] % 1):.1f})"}
    if len(turns) > 1:
        name = f"slewline-{crc32(repr((turns, play_s)).encode()):08x}"
        drawn.insert(0, element("style", _frames(name, turns, play_s)))
        rotor["class_"] = name
    half = SIZE / 2
    caption = f"A shaft that has turned {turns[-1] - turns[0]:.2f} times" if len(turns) > 1 else "A shaft at rest"
    return element(
        "svg", drawn, element("g", _rotor(), **rotor), viewBox=f"{-half:g} {-half:g} {SIZE} {SIZE}",
        width=SIZE, height=SIZE, role="img", aria_label=caption,
    )  # fmt: skip


def _frames(name: str, turns: Sequence[float], play_s: float) -> Markup:
    """Return the animation as CSS, which contains no text from outside this module."""
    moving = 100 * play_s / (play_s + PAUSE_S)
    first = turns[0] // 1
    frames = "".join(
        f"{moving * n / (len(turns) - 1):.2f}%{{transform:rotate({360 * (turn - first):.1f}deg)}}"
        for n, turn in enumerate(turns)
    )
    last = f"to{{transform:rotate({360 * (turns[-1] - first):.1f}deg)}}"
    return Markup(
        f"@keyframes {name}{{{frames}{last}}}"
        f"@media (prefers-reduced-motion: no-preference)"
        f"{{.{name}{{animation:{name} {play_s + PAUSE_S:.2f}s linear infinite}}}}"
    )


def _face() -> list[Markup]:
    """Return the fixed part of the drawing: the flange with its screws, and the scale."""
    half, screw = SIZE / 2 - 1, 0.41 * SIZE
    line = {"fill": "none", "stroke": "currentColor"}
    corners = [(x, y) for x in (-screw, screw) for y in (-screw, screw)]
    ticks = []
    for n in range(TICKS):
        x, y = sin(2 * pi * n / TICKS), -cos(2 * pi * n / TICKS)
        inner = (0.40 if n % LONG else 0.375) * SIZE
        ticks.append(f"M{0.43 * SIZE * x:.1f} {0.43 * SIZE * y:.1f}L{inner * x:.1f} {inner * y:.1f}")
    return [
        element("rect", x=-half, y=-half, width=2 * half, height=2 * half, rx=0.09 * SIZE, **line),
        *(element("circle", cx=f"{x:g}", cy=f"{y:g}", r=0.028 * SIZE, **line) for x, y in corners),
        element("path", d="".join(ticks), opacity=0.72, **line),
    ]


def _rotor() -> list[Markup]:
    """Return the rotating part of the drawing: a disc with a pointer, and the shaft with its flat."""
    disc, shaft = 0.33 * SIZE, 0.08 * SIZE
    return [
        element("circle", r=f"{disc:g}", fill="#8883", stroke="currentColor"),
        element("path", d=f"M0 {-disc + 2:.1f}L6 {-disc + 20:.1f}H-6Z", fill=ACCENT),
        element("path", d=f"M{-shaft:.1f} {-shaft / 2:.1f}H{shaft:.1f}A{shaft:.1f} {shaft:.1f} 0 1 1 {-shaft:.1f} "
                f"{-shaft / 2:.1f}Z", fill="currentColor", opacity=0.6),
    ]  # fmt: skip
