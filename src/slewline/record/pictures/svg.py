"""A drawing in fewer bytes: staircases take most of a picture, and each of their lines needs one number, not two."""

from __future__ import annotations

import re

PATH = re.compile(rb' d="([^"]*)"')


def compact(svg: bytes) -> bytes:
    """Return the same drawing with short paths: level and upright lines as such, points to a hundredth."""
    return PATH.sub(lambda found: b' d="%s"' % _shorter(found[1].decode()).encode(), svg)


def _shorter(path: str) -> str:
    """The data of a path of straight lines; with a curve in it, as it is."""
    words = path.split()
    if not {word for word in words if word.isalpha()} <= {"M", "L", "z"}:
        return path
    short, at, x, y = [], 0, "", ""
    while at < len(words):
        if words[at] == "z":
            short.append("z")
            at += 1
            continue
        before = x, y
        line, (x, y) = words[at] == "L", map(_rounded, words[at + 1 : at + 3])
        at += 3
        if line and y == before[1]:
            short.append(f"H{x}")
        elif line and x == before[0]:
            short.append(f"V{y}")
        else:
            short.append(f"{'L' if line else 'M'}{x} {y}")
    return "".join(short)


def _rounded(number: str) -> str:
    text = f"{float(number):.2f}"
    return text.rstrip("0").rstrip(".")
