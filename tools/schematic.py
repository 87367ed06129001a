"""Draw the board of a GS-C200S with a Pico from its netlist: tools/schematic.py [--check].

Each part is a box with its pins; a wire is a name, the same at both ends.  Resistors and capacitors are in a list.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from html import escape
from pathlib import Path

from netlist import FOLDER, MODULE, ROOT, Board, read, value

from slewline.chips.gs_c200.sheet import GS_C200S

OUT = ROOT / "hardware" / "gs_c200s" / "schematic.svg"
ROW, BODY, WIRE, GAP = 15, 118, 26, 34
COLUMNS = (("U5", "U6", "D1", "D3", "D2"), ("U2", "U3"), ("U1",), ("U4", "Q1", "U8", "Q2", "U7"))
LEFT_WAYS = ("in", "supply", "passive", "ground")


def sides(board: Board, part: str) -> tuple[list[str], list[str]]:
    """Return the pins drawn on the left of a part, and those on the right."""
    pins = [pin for pin in board.pins if pin.startswith(f"{part}.")]
    if part == "U1":
        gpio = [pin for pin in pins if pin.startswith("U1.GP")]
        return gpio[:16], gpio[16:] + [pin for pin in pins if pin not in gpio]
    if len(pins) <= 4 and all(board.pins[pin].what == "passive" for pin in pins):
        return pins[: len(pins) // 2], pins[len(pins) // 2 :]
    left = [pin for pin in pins if board.pins[pin].what in LEFT_WAYS]
    return left, [pin for pin in pins if pin not in left]


def text(x: float, y: float, words: str, anchor: str = "start", kind: str = "") -> str:
    """Return an SVG text."""
    of = f' class="{kind}"' if kind else ""
    return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}"{of}>{escape(words)}</text>'


def pin_row(board: Board, x: float, y: float, pin: str, label: str, on_left: bool) -> Iterator[str]:
    """Yield a pin of a box: its stub, its name inside, its net outside."""
    end = x - WIRE if on_left else x + WIRE
    yield f'<path d="M{x:g} {y:g}H{end:g}"/>'
    yield text(x + (5 if on_left else -5), y + 4, label, "start" if on_left else "end")
    net = board.net_of(pin)
    kind = "supply" if net in board.supplies else "net"
    yield text(end + (-3 if on_left else 3), y + 4, net or "-", "end" if on_left else "start", kind)


def box(board: Board, part: str, x: float, y: float, width: float = BODY) -> tuple[list[str], float]:
    """Return the drawing of a part, and its height."""
    left, right = sides(board, part)
    height = max(len(left), len(right)) * ROW + 8
    out = [text(x, y - 16, part, kind="part"), text(x, y - 4, value(board, part).split(",")[0][:34])]
    out.append(f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}"/>')
    for pins, at, on_left in ((left, x, True), (right, x + width, False)):
        for row, pin in enumerate(pins):
            name = (
                f"{pin.partition('.')[2]} {board.pins[pin].number}"
                if on_left
                else f"{board.pins[pin].number} {pin.partition('.')[2]}"
            )
            out += pin_row(board, at, y + 12 + row * ROW, pin, name, on_left)
    return out, height + GAP + 6


def connector(board: Board, x: float, y: float) -> list[str]:
    """Return the module's own pins in their physical order: 1 to 19 on the left, 38 to 20 on the right."""
    pins = list(GS_C200S.pins)
    out = [text(x, y - 16, f"{MODULE}  the 38 pins of the module", kind="part")]
    out.append(f'<rect x="{x:g}" y="{y:g}" width="190" height="{19 * ROW + 8}"/>')
    for row in range(19):
        for pin, at, on_left in ((pins[row], x, True), (pins[37 - row], x + 190, False)):
            label = f"{pin.number} {pin.name}" if on_left else f"{pin.name} {pin.number}"
            out += pin_row(board, at, y + 12 + row * ROW, f"{MODULE}.{pin.name}", label, on_left)
    return out


def two_ended(board: Board, x: float, y: float) -> list[str]:
    """Return resistors and capacitors: each with its value between its two nets."""
    out = [text(x, y - 8, "Resistors and capacitors", kind="part")]
    names = [name for name, kind in board.kinds.items() if kind in ("resistor", "capacitor")]
    rows = 10
    for at, name in enumerate(names):
        left, top = x + at // rows * 205, y + 10 + at % rows * ROW
        one, other = (board.net_of(f"{name}.{end}") for end in "12")
        out.append(text(left + 55, top, one, "end", "supply" if one in board.supplies else "net"))
        out.append(f'<path d="M{left + 58:g} {top - 4:g}h8m50 0h8"/>')
        out.append(f'<rect x="{left + 66:g}" y="{top - 11:g}" width="50" height="13"/>')
        size = value(board, name).partition(" ")[2].replace(" kilohm", "k").replace(" ohm", "").replace(" uF", "u")
        out.append(text(left + 91, top, f"{name} {size}", "middle"))
        out.append(text(left + 127, top, other, kind="supply" if other in board.supplies else "net"))
    return out


def drawn(board: Board) -> str:
    """Return the whole picture, SVG."""
    out: list[str] = []
    lefts = (110, 390, 665, 965)
    bottoms = []
    for column, left in zip(COLUMNS, lefts, strict=True):
        y = 60.0
        for part in column:
            lines, height = box(board, part, left, y)
            out += lines
            y += height
        bottoms.append(y)
    below = max(bottoms[:3]) + 20
    out += connector(board, 430, below)
    bottom = max(below + 19 * ROW + 50, max(bottoms) + 20)
    out += two_ended(board, 40, bottom)
    height = bottom + 175
    style = (
        "svg{background:#fff}text{font:10px sans-serif;fill:#222}.part{font-weight:bold;font-size:12px}"
        ".net{fill:#0b5a8a}.supply{fill:#a02020}rect{fill:#fbf8ee;stroke:#444}path{stroke:#444;fill:none}"
    )
    title = "A GS-C200S with a Raspberry Pi Pico: wires with the same name are connected. Nobody has soldered it yet."
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1190 {height:g}" role="img">',
            f"<title>{title}</title><style>{style}</style>",
            text(40, 24, title),
            *out,
            "</svg>",
            "",
        ]
    )


def main(words: list[str]) -> int:
    """Write the picture, or compare it with the one in the docs; return the exit status."""
    picture = drawn(read(FOLDER))
    if words == ["--check"]:
        if OUT.exists() and OUT.read_text("utf-8") == picture:
            return 0
        print(f"{OUT.relative_to(ROOT)} is not what tools/schematic.py draws: run it", file=sys.stderr)
        return 1
    Path(OUT).write_text(picture, "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
