"""Short work of a kind that host software and programs do all day: queries, short moves, and tests of a program."""

from __future__ import annotations

from collections.abc import Callable

import profiled
from rows import REAL, Row, best_of

import slewline

PROGRAM = "Po\rS100\rT1000\rR10\r+50\r-50\rj0\rE\r"
STRAPS = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
TESTS = 200


def looped() -> Callable[[], float]:
    """Return a virtual minute of a GS-C200S that repeats its program of two short moves."""
    bench = slewline.Bench()
    module = bench.add("gs-c200s", straps=STRAPS)
    bench.host(module).send(PROGRAM)
    bench.run("1 s")

    def run() -> float:
        before = module.motor.made
        bench.run("60 s")
        assert module.motor.made > before + 15_000
        return 60.0

    return run


def commanded() -> Callable[[], float]:
    """Return 2,100 short moves of a CY525, each commanded by its host."""
    bench = slewline.Bench()
    chip = bench.add("cy525", "x")
    moves = "".join(("N 3\r", "G\r", "N 5\r", "+\r", "G\r", "-\r")[number % 6] for number in range(6300))
    bench.host(chip).send(f"A 0\rF 10\rR 100\rS 240\rZ 1\r{moves}")

    def run() -> float:
        bench.run_until_idle("1000 s")
        assert len(chip.steps()) == 1050 * 3 + 1050 * 5
        return bench.now_ps / 1e12

    return run


def queried() -> Callable[[], float]:
    """Return 1,000 queries of a CY545 over its serial side."""
    bench = slewline.Bench()
    host = bench.host(bench.add("cy545b", "x"), over="serial")
    host.ask("? N")
    begin = bench.now_ps

    def run() -> float:
        assert {host.ask("? P") for _ in range(1000)} == {"P=00000000"}
        return (bench.now_ps - begin) / 1e12

    return run


def tested() -> Callable[[], float]:
    """Return tests of host software, each of which makes a bench, and runs a program, a move and six exchanges."""

    def test() -> float:
        bench = slewline.Bench()
        module = bench.add("gs-c200s", straps=STRAPS)
        host = bench.host(module)
        for command in ("Po", "S100", "T1000", "R10", "+50", "-50", "E"):
            host.ask(command)
        bench.run_until_idle("10 s")
        for _ in range(6):
            host.ask("F")
        assert module.motor.made == 100
        return bench.now_ps / 1e12

    return lambda: sum(test() for _ in range(TESTS))


CASES: tuple[tuple[str, Callable[[], Callable[[], float]], int, str], ...] = (
    ("GS-C200S: a program of short moves", looped, 60, "per virtual second"),
    ("CY525: 2,100 short moves commanded by the host", commanded, 2100, "per move"),
    ("CY545: 1,000 queries over the serial side", queried, 1000, "per query"),
    ("GS-C200S: 200 tests, each a program, a move and six exchanges", tested, TESTS, "per test"),
)


def rows() -> list[Row]:
    """Return a row for each kind of work."""
    found = []
    for name, prepare, items, item in CASES:
        wall, virtual = best_of(prepare)
        found.append(Row(name, virtual / wall, REAL, None, True, profiled.bound(name, prepare, items, item)))
    return found
