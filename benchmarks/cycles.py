"""Trains of cycles, without a chip: 10 virtual seconds of an axis at top speed, at 61 % of it, in ramps throughout, and
in an S-curve.

Every instant is expanded, window by window into one buffer; targets are computed for every cycle.  Goals are what four
such axes need for the goals of the chip (chipset.py).
"""

from __future__ import annotations

import numpy as np
from rows import Row, best

from slewline.core.cycles import CYCLE, ONE, CycleTrain, Law, Linear, SCurve
from slewline.core.timebase import Clock

HZ, ODD_HZ = 25_000_000, 24_999_999  # the period of the other is no whole number of picoseconds
CYCLES = 30_516  # 10 s
PER_S = HZ / CYCLE
TOP = 512 * ONE  # 1.5625 Mpulses/s
WINDOW = 1 << 20  # steps in the buffer
STRETCH = 4096  # cycles
AXES, EXPANDING, COUNTING = 4, 20, 1000  # so many times real time


def laws() -> dict[str, Law]:
    """The trains."""
    quarter = CYCLES // 4
    curve = SCurve(TOP * 2 * quarter, 2 * quarter**3, (quarter, 0, quarter, 0, quarter, 0, quarter))
    return {
        "top speed": Linear(TOP),
        "61 % of it": Linear(TOP * 61 // 100),
        "a ramp": Linear(0, TOP // CYCLES),
        "an S-curve": curve,
    }


def pass_of(steps: int) -> float:
    """Seconds of a bare pass over so many steps, in the cache: the measure of an expansion."""
    part = np.arange(1.0, 3 * 4096)
    return best(lambda: np.multiply(part, 16.5, out=part), 999) * steps / len(part)


def expanding(train: CycleTrain, buffer: np.ndarray) -> float:
    """Seconds of all instants of a train."""

    def action() -> None:
        for first in range(0, train.steps, WINDOW):
            train.begins(first, min(first + WINDOW, train.steps), buffer)

    return best(action)


def checked(law: Law, hz: int) -> CycleTrain:
    """A train, once its instants and its positions are seen to tell the same."""
    train = CycleTrain(Clock(hz), 123_456, law, CYCLES, 4321)
    begins = train.clock.ps_array(np.arange(CYCLES) * CYCLE, train.origin)
    whole = train.positions(0, CYCLES) // ONE
    for i in range(0, CYCLES, STRETCH):
        first = int(whole[i])
        times = train.begins(first, int(whole[min(i + STRETCH, CYCLES - 1)]))
        here = slice(i, i + STRETCH)
        assert (first + np.searchsorted(times, begins[here], side="right") == whole[here]).all()
    return train


def rows() -> list[Row]:
    """Of every law: all instants, and all targets."""
    found = []
    buffer = np.empty(WINDOW, np.int64)
    for name, law in laws().items():
        train, odd = checked(law, HZ), checked(law, ODD_HZ)
        wall = expanding(train, buffer)
        positions = best(lambda train=train: [train.positions(i, i + STRETCH) for i in range(0, CYCLES, STRETCH)])
        found += [
            Row(
                f"train of cycles at {name}: expand to picoseconds",
                train.steps / wall / 1e6,
                "M steps/s",
                round(AXES * EXPANDING * train.steps / CYCLES * PER_S / 1e6, 1),
                True,
                f"{wall / pass_of(train.steps):.0f} times a bare np.multiply over them: "
                f"{'a scale and a rest a cycle, repeated; ' if not law.steady else ''}multiply, add, round, convert; "
                f"at {ODD_HZ:,} Hz {odd.steps / expanding(odd, buffer) / 1e6:,.0f} M",
            ),
            Row(
                "the same: target of every cycle",
                CYCLES / positions / 1e6,
                "M cycles/s",
                round(AXES * COUNTING * PER_S / 1e6, 1),
                True,
                "a polynomial of the third degree and the seven phases" if not law.steady and name != "a ramp"
                else "a polynomial of the second degree",
            ),
        ]
    return found
