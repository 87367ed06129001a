"""Parts around a chip: the time of a move of 60,000 steps with each of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rows import Row, best_of

import slewline

STEPS = 60_000
GOAL_MS = 20.0
ROUNDS = 7


def cy525() -> tuple[slewline.Bench, Any, Callable[[], None]]:
    """Return a CY525 and a host that starts the move."""
    bench = slewline.Bench()
    x: Any = bench.add("cy525", name="x")
    bench.host(x).send(f"A 0\rF 10\rR 100\rS 200\rZ 1\rN {STEPS}\rG\r")
    return bench, x, lambda: bench.run_until_idle(timeout="1000 s")


def module() -> tuple[slewline.Bench, Any, Callable[[], None]]:
    """Return a GS-C200S with a program for the move."""
    bench = slewline.Bench()
    x: Any = bench.add("gs-c200s", name="x", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0})
    host = bench.host(x)
    for line in ("Po", "S100", "T1000", "R100", f"+{STEPS}"):
        host.ask(line)
    host.ask("E")
    return bench, x, lambda: bench.run("100 s")


def bare() -> Callable[[], None]:
    return cy525()[2]


def encoder() -> Callable[[], None]:
    """Return a workload: an encoder after an inverter, and its counts."""
    bench, _, run = cy525()
    bench.part("inverter", name="gate")
    part = bench.part("encoder", name="shaft", counts=4000, steps=400)
    bench.wire("x.pulse", "gate.in1")
    bench.wire("gate.out", "shaft.pulse")
    bench.wire("x.direction", "shaft.dir")

    def act() -> None:
        run()
        assert abs(part.counts) >= 10 * (STEPS - 1)

    return act


def translator() -> Callable[[], None]:
    bench, _, run = cy525()
    part = bench.part("translator", to="x")

    def act() -> None:
        run()
        assert abs(part.position) == STEPS

    return act


def motors(pull_in: float = 20_000) -> Callable[[], None]:
    """Return a workload: a translator, and a motor that samples at every pulse."""
    bench, _, run = cy525()
    part = bench.part("translator", to="x")
    motor = bench.part("motor", lag="10 us", pull_in=pull_in, acceleration=pull_in)
    bench.wire("x.pulse", "motor.pulse")
    bench.wire("x.direction", "motor.direction")

    def act() -> None:
        run()
        assert abs(part.position) == motor.pulses == STEPS
        assert (motor.lost == 0) is (pull_in > 500) and motor.lost + abs(motor.position) == STEPS

    return act


def gs_d200() -> Callable[[], None]:
    bench, x, run = module()
    part = bench.part("gs_d200", to="x")

    def act() -> None:
        run()
        assert x.position == STEPS and part.state == STEPS % 8 + 1

    return act


def spent(prepare: Callable[[], Callable[[], None]]) -> float:
    """Return the milliseconds of CPU time."""
    prepare()()  # which loads what it needs
    return best_of(prepare, ROUNDS)[0] * 1e3


def rows() -> list[Row]:
    """Return the time of each part."""
    what = (
        ("CY525, bare", bare, "the host's bytes, and the plan"),
        ("encoder after an inverter", encoder, "the same; a view and a clock for each leg of the move"),
        ("translator", translator, "the same; a clock for each leg"),
        ("translator and motor with limits", motors, "the instants of all steps, computed once, in arrays"),
        (
            "translator and motor with limits, most steps lost",
            lambda: motors(500),
            "each lost pulse is processed individually",
        ),
        ("GS-C200S, gs_d200", gs_d200, "characters of the line; four views for each leg"),
    )
    return [
        Row(f"60,000 steps: {name}", spent(how), "ms", None if "lost" in name else GOAL_MS, False, bound)
        for name, how, bound in what
    ]


if __name__ == "__main__":
    from rows import table

    print(table(rows()))
