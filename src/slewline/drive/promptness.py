"""How late a process wakes, and which horizon that needs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import perf_counter_ns, sleep
from typing import NamedTuple

NAP_S = 0.002
HORIZONS_MS = (20, 50, 100, 250, 500, 1000, 2000)
LONGEST_LOAD_MS = 200  # for twenty records: a ramp at high rates needs a hundred a second
LATE_SAFETY, LOAD_SAFETY = 3, 2  # times the worst that was seen in some seconds: a day has worse, a ramp more records


class WakingDelays(NamedTuple):
    """How late this process woke, in ms: half of the times, 99 of 100, and the worst."""

    median: float
    p99: float
    worst: float


def of_many(late_ms: Sequence[float]) -> WakingDelays:
    """Return the figures of many times, ms, one at least."""
    ordered = sorted(late_ms)
    last = len(ordered) - 1
    return WakingDelays(ordered[last // 2], ordered[last * 99 // 100], ordered[last])


def measured(
    seconds: float,
    clock: Callable[[], int] = perf_counter_ns,
    nap: Callable[[float], object] = sleep,
    each: Callable[[], object] = lambda: None,
) -> WakingDelays:
    """Sleep for two milliseconds, over and over, and measure how late each sleep ends.

    Args:
        seconds: of the wall clock.
        clock, nap: what a sleep is measured with, ns, and what sleeps, s.
        each: called after each sleep: what else has to go on.
    """
    late: list[float] = []
    end = clock() + round(seconds * 1e9)
    while not late or clock() < end:
        due = clock() + round(NAP_S * 1e9)
        nap(NAP_S)
        late.append(max(clock() - due, 0) / 1e6)
        each()
    return of_many(late)


def recommended_ms(late_ms: float, load_ms: float) -> int | None:
    """Return the horizon that a machine and a link need, ms; None: no horizon helps, as the link carries too little.

    Args:
        late_ms: by how much this process woke late, at worst.
        load_ms: how long the link takes for all that goes before the first step of a motion, at worst.
    """
    if load_ms > LONGEST_LOAD_MS:
        return None
    needs = LATE_SAFETY * late_ms + LOAD_SAFETY * load_ms
    return next((horizon for horizon in HORIZONS_MS if horizon >= needs), None)
