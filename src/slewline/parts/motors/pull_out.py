"""Pull-out torque of a motor versus its rate, measured on the model as on a test bench.

torque of the load    . . . . . . . /|         the motor turns at a constant rate; the load grows slowly,
                      . . . . /      |         until the motor falls out of step
                      . ./           v

A single rate may mislead: at some rates a motor oscillates, and a chopper whose clock is a multiple of
the step rate beats with the steps at that rate only.  So the neighbours of each rate are measured, too.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from ...core.datasheet.units import quantity
from ...core.messages.calls import answering
from ...errors import UsageError
from .law import MotorLaw

if TYPE_CHECKING:
    from collections.abc import Sequence

RISE_S = 4.0  # time in which the load would reach the holding torque
PIECE_PS = 10_000_000_000  # time in which the load is constant
SETTLES_PS = 100_000_000_000  # time before the load begins to grow
LEAST, MOST = 20.0, 1e5  # full steps/s
BESIDE = 0.006  # distance of the neighbours from a rate, as a fraction of it
APART = 0.1  # fraction of the holding torque: both neighbours of an isolated rate differ by more


class PullOutPoint(NamedTuple):
    """The pull-out torque at a rate, and at its neighbours.

    Attributes:
        rate: the rate, full steps/s.
        torque: the maximum torque in addition to the load, N m; 0: the motor does not turn.
        neighbours: (rate, torque) of the neighbouring rates, 0.6 % below and above; empty if not measured.
        holding: the holding torque, N m.
    """

    rate: float
    torque: float
    neighbours: tuple[tuple[float, float], ...]
    holding: float

    @property
    def isolated(self) -> str:
        """Text "success" if the torque is far above that of both neighbours, "failure" if far below, else empty."""
        apart = [self.torque - torque for _, torque in self.neighbours]
        limit = APART * self.holding
        if apart and min(apart) > limit:
            return "success"
        return "failure" if apart and max(apart) < -limit else ""

    def __str__(self) -> str:
        found = f"{self.rate:.6g} steps/s: {self.torque:.3g} N m"
        if not self.isolated:
            return found
        beside = ", ".join(f"{torque:.3g} N m at {rate:.6g} steps/s" for rate, torque in self.neighbours)
        cause = "probably a beat between the chopper and the steps, or a resonance"
        return f"{found}, an isolated {self.isolated}: {beside}; {cause}"


@answering("pull_out()")
def pull_out(law: MotorLaw, rates: Sequence[float | str], *, neighbours: bool = True) -> list[PullOutPoint]:
    """Return, for each rate, the maximum torque in addition to the load, at that rate and at its neighbours.

    Resonances show in the result as rates at which a motor loses steps with little load, or with none.

    Args:
        rates: full steps/s, or text with a unit, such as "600 rpm".
        neighbours: whether to measure 0.6 % below and above each rate as well, which takes three times as
            long.

    Raises:
        UsageError: a rate is not allowed.
    """
    holding = law.motor.holding_torque(law.driver.phase_current(law.motor))
    found = []
    wanted = [_rate(given, law) for given in rates]
    try:
        for rate in wanted:
            beside = (rate * (1 - BESIDE), rate * (1 + BESIDE)) if neighbours else ()
            found.append(PullOutPoint(rate, _at(law, rate), tuple((each, _at(law, each)) for each in beside), holding))
    except KeyboardInterrupt as interrupt:
        interrupt.args = (f"interrupted after {len(found)} of {len(wanted)} rates; nothing is kept",)
        raise
    return found


def _rate(given: Any, law: MotorLaw) -> float:
    rate = quantity(given, "steps/s", "rate", law.motor.full_steps)
    if not LEAST <= rate <= MOST:
        raise UsageError(f"rate {given!r}: {rate:g} steps/s; allowed {LEAST:g} to {MOST:g} full steps/s")
    return rate


def _at(law: MotorLaw, rate: float) -> float:
    """Return the maximum torque (N m) in addition to the load at a rate (full steps/s); 0 if the motor stalls."""
    import numpy as np

    most = law.motor.holding_torque(law.driver.phase_current(law.motor))
    state, since, command, torque = law.turning(rate), 0, 0, 0.0
    interval = 1e12 / (rate * law.micro)
    while torque < most:
        until = since + (SETTLES_PS if not since else PIECE_PS)
        counts = np.arange(command + 1, int(until / interval) + 2)
        times = np.round(counts * interval).astype(np.int64)
        counts, times = counts[times <= until], times[times <= until]  # an edge at the end belongs to this piece
        now = replace(law, load=replace(law.load, torque=law.load.torque + torque))
        trace = now.integrate(
            times, counts, until, start=since, state=state, command=command, code=law.code(command), limit=law.lost_at,
        )  # fmt: skip
        if trace.worst >= law.lost_at:
            break
        last = int(trace.times[-1])
        state = now.after(last, tuple(trace.states[-1].tolist()), int(trace.codes[-1]), until - last)
        command, since = int(trace.commands[-1]), until
        torque += most * PIECE_PS * 1e-12 / RISE_S
    return max(torque - most * PIECE_PS * 1e-12 / RISE_S, 0.0)
