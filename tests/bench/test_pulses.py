"""Pulses from outside: one after the other, within one another, and overlapping."""

from __future__ import annotations

import numpy as np
import pytest

import slewline

US = 10**6


def shown(*pulses: tuple[int, int, int], before: int | None = None) -> tuple[list[tuple[int, int]], int | None]:
    """The edges of a pin (us, level) that is pulsed at some instants for some time (us), and how it is driven then."""
    bench = slewline.Bench()
    pin = bench.add("cy525", name="x").pin("abort")
    if before is not None:
        pin.drive(before)
    bench.record("x.abort")
    for level, at, width in pulses:
        pin.pulse(level, width * US, at=at * US)
    bench.run("1 ms")
    times, levels = bench.edges("x.abort")
    return list(zip((np.asarray(times) // US).tolist(), np.asarray(levels).tolist(), strict=True)), pin.held


@pytest.mark.parametrize("before", [None, 0, 1])
@pytest.mark.parametrize(
    "pulses",
    [
        [(0, 10, 10)],
        [(0, 10, 10), (0, 30, 10)],
        [(0, 10, 10), (0, 15, 10)],
        [(0, 10, 20), (1, 15, 5)],
        [(0, 10, 20), (1, 15, 30)],
        [(0, 10, 10), (0, 20, 10)],
        [(0, 20, 10), (0, 10, 10)],
        [(0, 10, 10), (0, 10, 5), (1, 12, 0)],
    ],
)
def test_after_all_pulses_a_pin_is_driven_as_before_the_first(
    pulses: list[tuple[int, int, int]], before: int | None
) -> None:
    assert shown(*pulses, before=before)[1] == before


def test_of_pulses_that_overlap_the_one_begun_last_decides() -> None:
    assert shown((0, 10, 10), (0, 15, 10))[0] == [(10, 0), (25, 1)]
    assert shown((0, 10, 20), (1, 15, 5))[0] == [(10, 0), (15, 1), (20, 0), (30, 1)]
    assert shown((0, 10, 20), (1, 15, 30))[0] == [(10, 0), (15, 1)]
    assert shown((0, 20, 10), (0, 10, 10))[0] == [(10, 0), (30, 1)]


def test_levels_driven_during_a_pulse_end_with_it() -> None:
    bench = slewline.Bench()
    pin = bench.add("cy525", name="x").pin("abort")
    pin.pulse(0, "10 us")
    pin.drive(1, at="5 us")
    bench.run("1 ms")
    assert pin.held is None
