"""Pictures: their points, and the drawing time relative to matplotlib drawing one line of 900 points."""

from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
from rows import Row, by_turns

import slewline
from slewline.core.motion.axis import Axis
from slewline.core.motion.quantity import Position, Velocity
from slewline.core.motion.train import Playing, StepTrain
from slewline.record.recording import outlines

BOUND = "matplotlib: about 50 ticks and 100 texts, and the PNG of 1.3 million pixels"


def line() -> None:
    """Draw a bare figure of one line of 900 points, as PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 6.5), dpi=144)
    FigureCanvasAgg(figure)
    figure.add_subplot().plot(np.arange(900), np.arange(900) % 7)
    figure.savefig(io.BytesIO(), format="png", dpi=144)


def moved(commands: str, until: str | None) -> tuple[slewline.Bench, Velocity, Position]:
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.record("x.pulse", "x.slew", "x.phase1")
    bench.host(x).send(f"A 0\rF 20\rR 127\rS 200\rZ 1\r{commands}")
    if until is None:
        bench.run_until_idle("60 s")
    else:
        bench.run(until)
    return bench, Velocity(x.motor), Position(x.motor)


def drawn(bench: slewline.Bench, velocity: Velocity, position: Position) -> Callable[[], None]:
    """Return a function that computes all points of a picture: velocity, position and the recorded pins."""
    now = bench.now_ps

    def points() -> None:
        velocity.outline(0, now, 900), position.outline(0, now, 900)
        for net in bench.recorded.values():
            outlines.edges(bench._signals.recorder, net, 0, now)

    return points


def looping(bench: slewline.Bench, axis: Axis) -> None:
    """Play an hour of 12,000 moves of 250 runs, back and forth."""
    runs = [(2000 + 10 * abs(125 - k), 2) for k in range(250)]
    clock = bench.chips["x"].clock
    for n in range(12_000):
        bench.run_to(bench.now_ps + 300_000_000_000 - bench.now_ps % 300_000_000_000)
        axis.follow(Playing(StepTrain(clock, clock.ticks_from(bench.now_ps), runs)), 1 if n % 2 else -1)


def repeated() -> slewline.Bench:
    """Return an hour of a program that moves back and forth repeatedly, with recorded pins."""
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.record("x.pulse", "x.slew", "x.run", "x.direction")
    bench.host(x).send("A 0\rF 20\rR 127\rS 200\rZ 1\rE\rA$P 3000\rP 0\rJ A\r0\rQX\r")
    bench.run("1 h")
    return bench


def pictures() -> list[Row]:
    """Return the rows of a long move and of an hour: their points, and whole pictures."""
    long, hour = moved("N 60000\r+\rG\r", None), moved("N 60000\rH\rG\r", "1 h")
    assert len(long[0].chips["x"].steps()) == 60_000 and hour[0].chips["x"].travel > 34_000_000
    to_and_fro = moved("", "1 ms")
    looping(to_and_fro[0], to_and_fro[0].chips["x"].motor)
    program = repeated()
    assert program.chips["x"].motor.count(0, program.now_ps) > 18_000_000
    assert to_and_fro[0].chips["x"].motor.count(0, to_and_fro[0].now_ps) == 11_999 * 500 + 1

    def row(name: str, action: Callable[[], None], goal: float, bound: str) -> Row:
        sides = by_turns(line, action, 3)
        took = min(ours for _, ours in sides) * 1e3
        return Row(name, None, "x a bare line", goal, False, f"{bound} ({took:.0f} ms)", sides)

    def picture(bench: slewline.Bench) -> Callable[[], None]:
        return lambda: bench.figure().savefig(io.BytesIO(), format="png")

    return [
        row("60,000 steps: points of a picture", drawn(*long), 0.2, "a bisection per column, 250 runs"),
        row("figure of 60,000 steps", picture(long[0]), 5, BOUND),
        row("an hour at 9,675 steps/s: points", drawn(*hour), 0.5, "900 columns, 531 wraps, 600 queries per pin"),
        row("the same: figure", picture(hour[0]), 8, BOUND),
        row(
            "an hour of 6,000 moves of a program: figure",
            picture(program),
            8,
            "each move is drawn separately, with 40 flags",
        ),
        row("an hour of 12,000 moves: points", drawn(*to_and_fro), 10, "each move is processed separately, in Python"),
    ]
