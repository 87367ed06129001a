"""The judge: decides whether a move stays in step under a scenario.

It is a pure function of plain data, so that any executor can run it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from .perturbations import Scenario

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ..parts.motors.law import MotorLaw

AT_REST = 0.6  # full steps off the command at rest: lost
SETTLING, WATCHED, LONGEST = 60_000_000_000, 15_000_000_000, 600_000_000_000  # ps
DIVERGED = 1e6  # full steps, of a state that has become NaN


@dataclass(frozen=True, slots=True)
class Trial:
    """The data to be judged: the instants of the steps, int64 ps, and the scenario."""

    times: NDArray[np.int64]
    scenario: Scenario


@dataclass(frozen=True, slots=True)
class Verdict:
    """The result of a trial: whether steps were lost; the lag (full steps) at rest (`error`) and at its worst."""

    lost: bool
    error: float
    worst: float


def judge(run: Trial) -> Verdict:
    """Return the verdict on a move: whether its lag is so large, at rest or in motion, that steps are lost.

    A lag of 0.6 full steps or more at rest, or of more than 3.9 in motion (2.9 for a three-phase reluctance
    motor), is too large.  The rotor may ring after the last step: it is observed until its lag has been
    below 0.6 for 15 ms; if this does not happen within 0.6 s, steps are lost.
    """
    import numpy as np

    scenario = run.scenario
    law = law_of(scenario)
    numbers = scenario.first + scenario.direction * np.arange(1, len(run.times) + 1, dtype=np.int64)
    times = run.times - run.times[0] + 1  # an edge at 0 would not be an edge
    end, command = int(times[-1]), scenario.first
    start, stop, state, worst, error = 0, end + SETTLING, law.at_rest(command), 0.0, 0.0
    while start < end + LONGEST:
        trace = law.integrate(
            times, numbers, stop, start=start, state=state, command=command, limit=law.lost_at, engine=engine()
        )
        lag = np.nan_to_num(trace.lag, nan=DIVERGED, posinf=DIVERGED, neginf=-DIVERGED)
        error = float(np.clip(lag[-1], -DIVERGED, DIVERGED))
        worst = max(worst, min(float(np.max(np.abs(lag))), DIVERGED))
        if worst > law.lost_at:
            break
        if trace.rests or np.max(np.abs(lag[trace.times >= stop - WATCHED])) < AT_REST:
            return Verdict(abs(error) >= AT_REST, error, worst)
        state, command, start = tuple(trace.states[-1].tolist()), int(trace.commands[-1]), int(trace.times[-1])
        times, numbers, stop = times[:0], numbers[:0], stop + SETTLING
    return Verdict(True, error, worst)


@lru_cache(maxsize=64)
def law_of(scenario: Scenario) -> MotorLaw:
    """Return the law of motion for the motor, driver and load of a scenario."""
    from ..parts.motors.law import MotorLaw

    return MotorLaw(scenario.motor, scenario.driver, scenario.load, scenario.stepping, scenario.step_ps)


def engine() -> str:
    """Return the name of the fastest engine available; all engines produce the same results, bit for bit."""
    from ..parts.motors.integration import numba_is_there

    return "numba" if numba_is_there() else "python"
