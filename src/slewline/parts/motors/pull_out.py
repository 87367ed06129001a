"""The torque at which a motor falls out of step, over its rate: measured on the model, as on a test bench.

torque of the load    . . . . . . . /|         the motor turns evenly; the load grows slowly,
                      . . . . /      |         until it is out of step
                      . ./           v
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from .law import MotorLaw

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

RISE_S = 4.0  # in which the load would come to the holding torque
PIECE_PS = 10_000_000_000  # in which it stays as it is
SETTLES_PS = 100_000_000_000  # before it begins to grow


def pull_out(law: MotorLaw, rates: Sequence[float]) -> NDArray[np.float64]:
    """Return the greatest torque at some rates (full steps/s), N m, beside the load; 0: it does not turn.

    A law with its own resonances shows as much: there a motor is lost with little load, or with none.
    """
    import numpy as np

    return np.array([_at(law, rate) for rate in rates])


def _at(law: MotorLaw, rate: float) -> float:
    """The torque at a rate."""
    import numpy as np

    most = law.motor.held(law.driver.phase_current(law.motor))
    state, since, command, torque = law.turning(rate), 0, 0, 0.0
    interval = 1e12 / (rate * law.micro)
    while torque < most:
        until = since + (SETTLES_PS if not since else PIECE_PS)
        counts = np.arange(command + 1, int(until / interval) + 1)
        now = replace(law, load=replace(law.load, torque=law.load.torque + torque))
        trace = now.integrate(
            np.round(counts * interval).astype(np.int64), counts, until,
            start=since, state=state, command=command, code=law.code(command), limit=law.lost_at,
        )  # fmt: skip
        if trace.worst >= law.lost_at:
            break
        last = int(trace.times[-1])
        state = now.after(last, tuple(trace.states[-1].tolist()), int(trace.codes[-1]), until - last)
        command, since = int(trace.commands[-1]), until
        torque += most * PIECE_PS * 1e-12 / RISE_S
    return max(torque - most * PIECE_PS * 1e-12 / RISE_S, 0.0)
