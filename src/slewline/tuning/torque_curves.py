"""Torque curves in closed form: a motor's pull-out torque, and the torque that a ramp requires.

No verdict depends on them.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING

from .perturbations import System

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

FUNDAMENTAL = {"full": 0.900, "half": 0.832, "wave": 0.637}  # of the holding torque: mean over a turn
BOOSTED = 0.974  # half steps with sqrt(2) times the current if one phase is on alone


def hold(system: System) -> float:
    """Return the holding torque with two phases on, N m."""
    motor, driver, _ = system
    return motor.holding_torque(driver.phase_current(motor))


def resonance(system: System) -> float:
    """Return the natural frequency of the rotor at a held position, Hz, for small oscillations."""
    motor, _, load = system
    inertia = motor.inertia + (0.0 if load.stiffness else load.inertia)
    return sqrt(motor.teeth * hold(system) / inertia) / (2 * pi)


def pull_out(system: System, stepping: str, rates: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the pull-out torques (N m) at given rates (full steps/s), limited by the supply."""
    import numpy as np

    motor, driver, _ = system
    kinds = {"full": 1.0, "half": 0.924, "wave": 1 / sqrt(2)}
    mechanical = rates * motor.step  # rad/s
    electrical = motor.teeth * mechanical
    factor = BOOSTED if stepping == "half" and driver.boost else FUNDAMENTAL.get(stepping, 1.0)
    ceiling = factor * hold(system)
    if driver.kind == "current":
        return np.maximum(ceiling - motor.drag * mechanical, 0.0)
    volts = 4 / pi * (driver.high or driver.supply) * kinds.get(stepping, 1.0)
    series = driver.series if driver.kind in ("voltage", "bilevel") else 0.0
    resistance = motor.resistance + series
    impedance = np.hypot(resistance, electrical * motor.inductance)
    constant = motor.constant
    driven = constant * volts / impedance - constant**2 * mechanical * resistance / impedance**2
    limited = driven if driver.kind == "voltage" else np.minimum(driven, ceiling)
    torques: NDArray[np.float64] = np.maximum(limited - motor.drag * mechanical, 0.0)
    return torques


def demand(system: System, times: NDArray[np.int64], micro: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a move's rates (full steps/s), and the torque (N m) that inertia, friction and load require at each."""
    import numpy as np

    motor, _, load = system
    intervals = np.diff(times) * 1e-12
    if not len(intervals):
        return np.zeros(1), np.full(1, load.torque + load.friction + motor.friction)
    rates = 1 / (intervals * micro)
    between = (intervals[:-1] + intervals[1:]) / 2
    rises = np.append(np.diff(rates) / between, 0.0) if len(rates) > 1 else np.zeros(1)
    inertia = motor.inertia + load.inertia
    torques = inertia * motor.step * rises + load.viscous * motor.step * rates
    return rates, torques + load.torque + load.friction + motor.friction
