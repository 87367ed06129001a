"""Smaller SVG files: a picture is mostly staircases, and each line of a staircase needs one short number."""

from __future__ import annotations

import re

PATH = re.compile(rb' d="([^"]*)"')
DOT = rb'<use xlink:href="[^"]*" x="[^"]*" y="[^"]*"'
DOTS = re.compile(rb'<g([^>]*)>(\s*)(%b) style="([^"]*)"/>((?:\s*%b style="\4"/>){2,})(\s*)</g>' % (DOT, DOT))
FONT = re.compile(rb"font-family: [^;\"]*; ")
UPRIGHT = re.compile(rb' transform="rotate\(-?0 [^)]*\)"')
WHERE = re.compile(rb' ([xy])="(-?[0-9.]+)"')


def compact(svg: bytes) -> bytes:
    """Return the same drawing with shorter paths: rounded to hundredths, each line relative to its start.

    A group of dots states its common style only once, and several dots in one place are drawn as one.  If
    all text is in a single font, one definition of the font serves all text.
    """
    svg = UPRIGHT.sub(b"", PATH.sub(lambda found: b' d="%s"' % _shorter(found[1].decode()).encode(), svg))
    fonts = set(FONT.findall(svg))
    if len(fonts) == 1 and b"</style>" in svg:
        svg = FONT.sub(b"", svg).replace(b"</style>", b"text{%b}</style>" % fonts.pop().rstrip(b"; "), 1)
    return DOTS.sub(_once, svg)


def _once(found: re.Match[bytes]) -> bytes:
    """Return a group of dots, with their common style and each place stated only once."""
    group, space, first, style, others, end = found.groups()
    dots = first + b"/>" + others.replace(b' style="%b"' % style, b"")
    dots = WHERE.sub(lambda at: b' %b="%b"' % (at[1], _number(_hundredths(at[2].decode())).encode()), dots)
    once = space.join(dict.fromkeys(re.findall(rb"<[^>]*>", dots)))
    return b'<g%b style="%b">%b%b%b</g>' % (group, style, space, once, end)


def _shorter(path: str) -> str:
    """Return the data of a path, shortened if all its lines are straight, otherwise unchanged."""
    words = path.split()
    if not {word for word in words if word.isalpha()} <= {"M", "L", "z"}:
        return path
    short, at, x, y = [], 0, 0, 0
    while at < len(words):
        if words[at] == "z":
            short.append("z")
            at += 1
            continue
        before = x, y
        line, (x, y) = words[at] == "L", map(_hundredths, words[at + 1 : at + 3])
        at += 3
        right, down = x - before[0], y - before[1]
        if not line:
            short.append(f"M{_number(x)}{_next(y)}")
        elif not down:
            short.append(f"h{_number(right)}")
        elif not right:
            short.append(f"v{_number(down)}")
        else:
            short.append(f"l{_number(right)}{_next(down)}")
    return "".join(short)


def _hundredths(number: str) -> int:
    return int(f"{float(number):.2f}".replace(".", ""))


def _number(hundredths: int) -> str:
    """Return a number of hundredths as the shortest decimal text: 713 as 7.13, 50 as .5, -2 as -.02."""
    sign, (whole, parts) = "-" * (hundredths < 0), divmod(abs(hundredths), 100)
    return f"{sign}{whole or ''}.{parts:02}".rstrip("0") if parts else f"{sign}{whole}"


def _next(hundredths: int) -> str:
    """Return hundredths as text that can follow another number: it begins with a space or a minus sign."""
    text = _number(hundredths)
    return text if text.startswith("-") else f" {text}"
