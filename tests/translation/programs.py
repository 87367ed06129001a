"""Programs that are translated: those of the examples, and random ones of every part, each from a seed."""

from __future__ import annotations

from pathlib import Path
from random import Random

EXAMPLES = Path(__file__).parents[2] / "examples"
PRINTED = sorted(
    path
    for folder in ("programs", "drill", "mc1451a")
    for path in (EXAMPLES / folder).iterdir()
    if path.suffix in (".cy525", ".gs-c200", ".gs-c200s", ".mc1451a")
)
PAIRS = (("cy512", "cy525"), ("cy525", "gs-c200s"), ("gs-c200", "gs-c200s"))  # that people need


def printed(part: str) -> list[Path]:
    """Return the programs of the manuals that are for a part."""
    return [path for path in PRINTED if path.suffix == f".{part}"]


def old_cy512() -> dict[str, str]:
    """Return programs for a CY512, by name: no manual of it is at hand, so these say what its commands do."""
    return {
        "shuttle": "A\nR 120\nS 8\nE\nC\n+\nN 300\nG\nB\n-\nG\n0\nQ\nD\n",
        "welding": "A\nR 100\nS 6\nE\nW\n+\nN 100\nB\nX 500\nC\nG\nL 6,5\nP 0\nT\n0\nQ\nD\n",
        "slow": "R 40\nF 3\nN 25\n+\nG\n-\nG\n",
        "positions": "A\nR 200\nS 12\nP 900\nP 100\nP 0\n",
        "signals": "R 90\nS 5\nN 60\nE\nU\nB\nG\nC\nW\nG\nX 120\nL 3,0\n0\nQ\nD\n",
        "jumping": "A\nR 150\nS 9\nE\nP 40\nC\nP 0\nB\nJ 0\nQ\nD\n",
    }


def random_program(part: str, seed: int) -> str:
    """Return a program of a part, made of its motions, outputs, delays and a loop."""
    chance = Random(f"{part} {seed}")
    family = "mc1451a" if part.startswith("mc") else "cy545" if part.startswith("cy545") else part
    return MAKERS[family](chance, part)


def lettered(chance: Random, part: str) -> str:
    """Return a program of letters and numbers."""
    rates = {
        "cy500": [f"R {chance.randint(20, 240)}", f"S {chance.randint(1, 20)}"],
        "cy512": [f"R {chance.randint(20, 250)}", f"S {chance.randint(1, 20)}"],
        "cy525": [f"F {chance.randint(3, 8)}", f"R {chance.randint(10, 100)}", f"S {chance.randint(150, 250)}"],
        "cy545": [f"F {chance.randint(10, 20)}", f"R {chance.randint(30, 160)}", f"S {chance.randint(150, 250)}"],
    }[part.removesuffix("b") if part.startswith("cy545") else part]
    zero = "A" if part in ("cy500", "cy512") else "A 0"
    lines = [zero, *rates, "+", "N 9000", "G"]  # far from the end of the counter
    if part.startswith("cy545"):
        lines.append("Y 0")
    body = [chance.choice("+-")]
    room = {"cy500": 10, "cy512": 36}.get(part, 44)
    while room > 8:
        kind = chance.randrange(4)
        steps = chance.randint(2, 300)
        if kind == 0 or part == "cy500":
            body += [chance.choice("+-"), f"N {steps}", "G"]
            room -= 5
        elif kind == 1:
            body.append(f"P {8000 + 10 * steps}")
            room -= 3
        elif kind == 2:
            letter = {"cy512": "X"}.get(part, "D")
            body.append(f"{letter} {chance.randint(1, 30) * 10}")
            room -= 3
        else:
            high, low = ("B 0", "B 16") if part.startswith("cy545") else ("B", "C")
            body += [high, low] if chance.random() < 0.5 else [low, high]
            room -= 2 * (len(high) + 1 if part.startswith("cy545") else 1)
    if part in ("cy512", "cy525"):
        body.append(f"L {chance.randint(2, 4)},0")
    run = "D" if part in ("cy500", "cy512") else "X"
    if part.startswith("cy545"):
        return "\n".join([*lines, "E", *body, "0", "Q", "Y 0", run]) + "\n"
    return "\n".join([*lines, "E", *body, "0", "Q", run]) + "\n"


def lines(chance: Random, part: str) -> str:
    """Return a program of a module."""
    body = [f"S{chance.randint(10, 40)}", f"T{chance.randint(60, 500)}", f"R{chance.randint(5, 300)}", "L0"]
    position = 9000
    for _ in range(chance.randint(4, 9)):
        kind = chance.randrange(4)
        if kind == 0:
            body.append(f"{chance.choice('+-')}{chance.randint(2, 400)}")
        elif kind == 1:
            position = chance.randint(9000, 12000)
            body.append(f"G{position}")
        elif kind == 2:
            body.append(f"D{chance.randint(1, 9)}")
        else:
            output = chance.randint(1, 3)
            body += [f"A{output}", "D1", f"C{output}"]
    body += [f"L{chance.randint(2, 3)}", "G0"]
    enter = "Po" if part == "gs-c200s" else "P"
    return "\n".join(["I3", enter, "S20", "T40", "R9", "+19000", *body, "E", "@until ready"]) + "\n"


def packets(chance: Random, part: str) -> str:
    """Return what a host sends to a chipset."""
    found = [f"SET_VEL {chance.randint(2000, 90000)}", f"SET_ACC {chance.randint(50, 4000)}"]
    for _ in range(chance.randint(2, 5)):
        found += [f"SET_POS {chance.randint(-3000, 6000)}", "CLR_STATUS", "UPDATE", "wait motion_complete"]
    return "\n".join(found) + "\n"


MAKERS = {
    **dict.fromkeys(("cy500", "cy512", "cy525", "cy545"), lettered),
    **dict.fromkeys(("gs-c200", "gs-c200s"), lines),
    "mc1451a": packets,
}
