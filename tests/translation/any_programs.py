"""Random programs of any commands that a part accepts, with a host that acts during its motions; each from a seed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from random import Random

from slewline.chips import checks_of, sheet_of
from slewline.errors import ProgramError
from slewline.language.lint import lint
from slewline.translation.source_text.reading import read_program

Lines = list[str]


def any_program(part: str, seed: int) -> str:
    """Return a program that the linter accepts without a warning."""
    family = "mc1451a" if part.startswith("mc") else part.removesuffix("s") if part.startswith("gs") else part[:5]
    chance = Random(f"any {part} {seed}")
    while True:
        text = "\n".join(MAKERS[family](chance, part)) + "\n"
        sheet = sheet_of(part)
        if any(problem.severity == "warning" for problem in lint(text, sheet, checks_of(part, sheet))):
            continue
        try:
            read_program(text, part)
        except ProgramError:
            continue
        return text


def some(chance: Random, kinds: list[Callable[[], Lines]], least: int, most: int) -> Lines:
    """Return the lines of a random number of random kinds."""
    return [line for _ in range(chance.randint(least, most)) for line in chance.choice(kinds)()]


def moves(chance: Random, number: Callable[[], int]) -> list[Callable[[], Lines]]:
    """Return the kinds of a relative move: both registers set, one, or none."""
    return [
        lambda: [chance.choice("+-"), f"N {number()}", "G"],
        lambda: [f"N {number()}", "G"],
        lambda: ["G"],
    ]


def letters(chance: Random, part: str) -> Iterator[str]:
    """Yield a program of a CY500, CY512 or CY525."""
    old = part != "cy525"
    zero, run, delay = ("A", "D", "X") if old else ("A 0", "X", "D")
    over, stop = "@until motion_complete=0", ["@drive abort=0", "@until motion_complete=0", "@drive abort=1"]

    def number(low: int = 2, high: int = 300) -> int:
        return chance.randint(low, high)

    acts: list[Callable[[], Lines]] = [
        *moves(chance, number),
        lambda: [chance.choice("BCWU")],
        lambda: [f"R {number(20, 100)}"],
        lambda: ["R 40", zero, chance.choice("+-")],
        lambda: [f"F {number(1, 4)}"] if old else [f"Z {number(1, 4)}"],
    ]
    if part == "cy500":
        acts += [lambda: [f"P {number(0, 2000)}", "G"], lambda: ["O"]]
    else:
        acts += [lambda: [f"P {number(0, 2000)}"], lambda: [f"{delay} {number(10)}"]]
    hosted = [
        *acts,
        lambda: [f"@wait {number()} ms"],
        lambda: ["G", over],
        lambda: [chance.choice("+-"), "N 20000", "G", f"@wait {number(20, 900)} ms", *stop],
        lambda: [f"@drive wait={number(0, 1)}"],
    ]
    if not old:
        hosted += [lambda: ["V 0"], lambda: ["N 65000", "H", "G", f"@wait {number(50, 900)} ms", *stop]]
    yield zero
    yield from [f"R {number(20, 240)}", f"S {number(1, 20)}"] if old else ["F 5", f"R {number(20, 100)}", "S 200"]
    yield from ["+", "N 9000", "G", *some(chance, hosted, 0, 4)]
    if chance.random() < 0.8:
        yield from ["E", *some(chance, acts, 1, 4)]
        if part != "cy500" and chance.random() < 0.3:
            yield f"L {number(2, 4)},0"
        if chance.random() < 0.3:
            yield "T" if old else "T 0"
        yield from ["0", "Q", run]
        for _ in range(number(0, 3)):
            yield "@until run=1"
            yield from some(chance, [lambda: [run], *hosted], 1, 1)


def bits(chance: Random, part: str) -> Iterator[str]:
    """Yield a program of a CY545."""
    over = "@until stopped=1"
    stop = ["@drive inhibit_abort=0", over, "@drive inhibit_abort=1"]

    def number(low: int = 2, high: int = 300) -> int:
        return chance.randint(low, high)

    acts: list[Callable[[], Lines]] = [
        *moves(chance, number),
        lambda: [f"B {chance.choice((0, 1, 2, 16, 17, 18))}"],
        lambda: [f"{chance.choice('WH')} {chance.choice((3, 19))}"],
        lambda: [f"R {number(30, 160)}"],
        lambda: [f"P {number(0, 3000)}"],
        lambda: [f"D {number(10)}"],
        lambda: [f"A {number(0, 5000)}"],
    ]
    hosted = [
        *acts,
        lambda: [f"@wait {number()} ms"],
        lambda: [over],
        lambda: [chance.choice("+-"), "N 20000", "G", f"@wait {number(20, 400)} ms", *stop],
        lambda: ["C", "G", f"@wait {number(50, 400)} ms", *stop],
        lambda: [stop[0], f"N {number()}", "G", "@wait 10 ms", stop[2], over],
        lambda: [
            *("+", "N 400", "G", "@wait 30 ms", "@drive cw_limit=0", over),
            *("-", "N 40", "G", over, "@drive cw_limit=1"),
        ],
        lambda: [f"@drive usrb{number(3, 5)}={number(0, 1)}"],
        lambda: ["? P"],
    ]
    yield from ["A 0", f"F {number(10, 20)}", f"R {number(30, 160)}", f"S {number(150, 250)}", "+", "N 9000", "G"]
    yield from some(chance, hosted, 0, 4)
    if chance.random() < 0.8:
        yield from ["Y 0", "E", *some(chance, acts, 1, 4)]
        if chance.random() < 0.3:
            yield chance.choice((f"L {number(2, 4)},0", "T 3,0", "T 19,0"))
        yield from ["0", "Q", "Y 0", "X"]  # no pin shows its end


def modules(chance: Random, part: str) -> Iterator[str]:
    """Yield what a host sends to a GS-C200 or GS-C200S."""
    low, enter, endless = (0, "P", "G") if part == "gs-c200" else (-3000, "Po", "g")

    def number(least: int = 2, most: int = 300) -> int:
        return chance.randint(least, most)

    acts: list[Callable[[], Lines]] = [
        lambda: [f"{chance.choice('+-')}{number(2, 400)}"],
        lambda: [f"G{number(low, 9000)}"],
        lambda: [f"{chance.choice('ACW')}{number(1, 3)}"],
        lambda: [f"D{number(1, 9)}"],
        lambda: [f"{endless}{chance.choice('+-')}{number(1, 3)}"],
        lambda: [chance.choice((f"S{number(10, 40)}", f"R{number(5)}", "I1"))],
        lambda: ["L0", f"+{number()}", f"A{number(1, 3)}", "D1", f"L{number(2, 3)}"],
    ]
    hosted: list[Callable[[], Lines]] = [
        lambda: ["@until ready", "E", "@until ready"],
        lambda: ["@until ready", "E", f"@wait {number(50, 2000)} ms", chance.choice("KZ"), "@until ready"],
        lambda: ["@until ready", chance.choice(("I3", "V1", "V2"))],
        lambda: [f"@wait {number()} ms"],
        lambda: ["@until ready", "H+", "@wait 300 ms", "@drive home=0", "@until ready", "@release home"],
        lambda: [f"@drive ui{number(1, 3)}={number(0, 1)}"],
    ]

    def program(last: bool) -> Iterator[str]:
        yield from [enter, f"S{number(10, 40)}", f"T{number(60, 500)}", f"R{number(5)}", "+9000"]
        yield from some(chance, acts, 1, 5)
        if last and chance.random() < 0.4:
            yield chance.choice((f"{endless}{chance.choice('+-')}", f"U{number(1, 3)}"))
        yield "E"

    again = chance.random() < 0.5
    yield from ["I3", *program(not again)]
    if again:
        yield from [*some(chance, hosted, 0, 4), "@until ready", *program(True)]


def packets(chance: Random, part: str) -> Iterator[str]:
    """Yield what a host sends to a chipset."""
    start, over = ["CLR_STATUS", "UPDATE"], "wait motion_complete"

    def number(low: int = 50, high: int = 900) -> int:
        return chance.randint(low, high)

    acts: list[Callable[[], Lines]] = [
        lambda: [f"SET_POS {number(-3000, 6000)}", *start, over],
        lambda: [f"SET_VEL {number(2000, 90000)}"],
        lambda: [f"SET_ACC {number(50, 4000)}"],
        lambda: [f"SET_START_VEL {number(0, 3000)}"],
        lambda: [
            *("SET_POS 60000", *start, f"@wait {number()} ms"),
            *(chance.choice(("STOP", "SMOOTH_STOP")), "UPDATE", over),
        ],
        lambda: [
            *("SET_POS 60000", *start, f"@wait {number()} ms"),
            *("@drive poslimit1=1", "@wait 100 ms", "@drive poslimit1=0"),
        ],
        lambda: [f"SET_ACTL_POS {number(-3000, 6000)}"],
        lambda: [chance.choice(("GET_TRGT_POS", f"@wait {number()} ms", "MTR_OFF", "MTR_ON"))],
        lambda: ["SET_2", f"SET_POS {number(-3000, 6000)}", *start, over, "SET_1"],
        lambda: [
            *("SET_PRFL_VEL", f"SET_VEL {number(2000, 60000)}", "UPDATE", f"@wait {number()} ms"),
            *("SET_VEL 0", *start, "@wait 2 s", "SET_PRFL_TRAP", "UPDATE"),
        ],
    ]
    yield from [f"SET_VEL {number(2000, 90000)}", f"SET_ACC {number(50, 4000)}", *some(chance, acts, 2, 6)]


MAKERS: dict[str, Callable[[Random, str], Iterator[str]]] = {
    **dict.fromkeys(("cy500", "cy512", "cy525"), letters),
    "cy545": bits,
    "gs-c200": modules,
    "mc1451a": packets,
}
