"""The CY545: sixteen million steps at the top rate, planned, and made while nobody looks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rows import Row, best, best_of

import slewline
from slewline.chips import sheet_of
from slewline.chips.cy545 import profile
from slewline.core.motion.train import StepTrain
from slewline.core.time.timebase import Clock

NUMBER, FIRST, RATE, SLOPE = 16_000_000, 14, 255, 220


def prepared() -> Callable[[], Any]:
    """A chip that is about to make the motion."""
    bench = slewline.Bench()
    chip = bench.add("cy545", "x")
    host = bench.host(chip)
    host.send(f"+\rF {FIRST}\rR {RATE}\rS {SLOPE}\rN {NUMBER}\r")
    bench.run_until_idle()

    def run() -> Any:
        host.send("G\r")
        bench.run_until_idle("1000 s")
        return chip

    return run


def rows() -> list[Row]:
    """The rows of this table."""
    law, clock = profile.law_of(sheet_of("cy545")), Clock(12_000_000)

    def planned() -> StepTrain:
        return StepTrain(clock, 0, profile.move(NUMBER, FIRST, RATE, SLOPE, law).runs)

    assert planned().steps == NUMBER
    wall, chip = best_of(prepared)
    assert chip.position == NUMBER and len(chip.motor.past) == 2
    return [
        Row("move of 16,000,000 steps: plan", best(planned, 20) * 1e3, "ms", 1, False, "500 runs of equal intervals"),
        Row("the same, unobserved", chip.kernel.now / 1e12 / wall, "x real time", 20_000, True, "a handful of events"),
    ]
