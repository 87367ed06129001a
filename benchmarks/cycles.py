"""Trains of cycles, without a chip: 10 virtual seconds of an axis at top speed, at 61 % of it, in a ramp and in an
S-curve.

Every instant is expanded, window by window into one buffer; targets are computed for every cycle.  The goals are the
times that four such axes may take within the goals of the chip (chipset.py).
"""

from __future__ import annotations

import numpy as np
from rows import Row, best

from slewline.chips.mc1451a.profiles.cycle_train import CYCLE, ONE, CycleTrain, Law, Linear
from slewline.chips.mc1451a.profiles.profile import s_curve
from slewline.chips.mc1451a.profiles.s_curves import SCurve
from slewline.core.time.timebase import Clock

HZ, ODD_HZ = 25_000_000, 24_999_999  # the other period is not a whole number of picoseconds
QUARTER = 7629  # cycles
CYCLES = 4 * QUARTER  # 10 s
PER_S = HZ / CYCLE
TOP = 512 * ONE  # 1.5625 Mpulses/s
AXES, EXPANDING, COUNTING = 4, 20, 1000  # multiples of real time
WINDOW = 1 << 20  # steps in the buffer
STRETCH = 4096  # cycles

EVEN = "multiply, add, round, convert"
UNEVEN = f"{EVEN}; before that, scale and remainder of each cycle are repeated"
CURVE = SCurve(s_curve(TOP * 2 * QUARTER, TOP, TOP, TOP * ONE // QUARTER**2 + 1).pieces())
SECOND = "a second-degree polynomial"
CASES: tuple[tuple[str, Law, str, str], ...] = (
    ("top speed", Linear(TOP), EVEN, SECOND),
    ("61 % of top speed", Linear(TOP * 61 // 100), EVEN, SECOND),
    ("ramp", Linear(0, TOP // CYCLES), UNEVEN, SECOND),
    ("S-curve", CURVE, UNEVEN, "phase look-up, then a cubic polynomial, in floats and in integers"),
)


def pass_over(steps: int) -> float:
    """Return the seconds of a bare multiplication for each step, in the cache."""
    part = np.arange(3.0 * 4096)
    return best(lambda: [np.multiply(part, 0.5, out=part) for _ in range(100)], 20) / 100 * steps / len(part)


def checked(law: Law, hz: int) -> CycleTrain:
    """Return a train after checking that its instants and positions agree."""
    train = CycleTrain(Clock(hz), 123_456, law, CYCLES, lead=4321)
    begins = train.clock.ps_array(np.arange(CYCLES) * CYCLE, train.origin)
    steps = train.positions(0, CYCLES) // ONE
    for i in range(0, CYCLES, STRETCH):
        here = slice(i, i + STRETCH)
        first, last = int(steps[i]), int(steps[here][-1])
        times = train.times(first + 1, last)
        assert (first + np.searchsorted(times, begins[here], side="right") == steps[here]).all()
        assert times[-1] == train.clock.ps(train.end(last - 1))
    return train


def expanding(train: CycleTrain) -> float:
    """Return the seconds for all instants of a train."""
    buffer = np.empty(WINDOW, np.int64)

    def expand() -> None:
        for first in range(0, train.steps, WINDOW):
            train.times(first + 1, first + WINDOW, buffer)

    return best(expand)


def positions(train: CycleTrain) -> float:
    """Return the seconds for the targets of all cycles."""
    return best(lambda: [train.positions(i, min(i + STRETCH, CYCLES)) for i in range(0, CYCLES, STRETCH)])


def rows() -> list[Row]:
    """Return the rows of every law: all instants, and all targets."""
    found = []
    for name, law, expansion, targets in CASES:
        train, odd = checked(law, HZ), checked(law, ODD_HZ)
        wall = expanding(train)
        passes = f"{wall / pass_over(train.steps):.0f} times the time of a bare np.multiply over the steps"
        oddly = f"{odd.steps / expanding(odd) / 1e6:.0f} M at {ODD_HZ:,} Hz"
        goals = AXES * EXPANDING * PER_S * train.steps / CYCLES // 1e6, AXES * COUNTING * PER_S // 1e6
        found += [
            Row(f"train of cycles, {name}: expand", train.steps / wall / 1e6, "M steps/s", goals[0], True,
                f"{passes}: {expansion}; {oddly}"),
            Row("the same: target of every cycle", CYCLES / positions(train) / 1e6, "M cycles/s", goals[1], True,
                targets),
        ]  # fmt: skip
    return found
