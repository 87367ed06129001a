"""Two constants that no data sheet lists, found by measurement: a machine's friction, a motor's iron loss.

    start-stop rate   the maximum rate at which the motor starts without a ramp              -> friction
    pull-out rate     the rate at which the motor, slowly accelerated under a torque, stalls -> iron loss

The more friction or iron loss, the lower the rate.  So each constant is the largest value with which the
simulated motor still reaches the measured rate, found by bisection.  If both rates are measured, the two
constants are found alternately until they no longer change, since each also affects the other's rate.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ...errors import UsageError
from .law import MotorLaw
from .motor_data import DriverData, LoadData, MotorData

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

START_STEPS = 60  # steps that a motor must make to have started
SLOWEST = 0.6  # fraction of the pull-out rate at which a sweep begins
SWEEP_S = 1.0  # duration of a sweep
SETTLES_S = 0.1  # time before the sweep
COARSE, TRIES = 0.8, 24  # factors from the largest constant down to 1/200 of it, each 0.8 times its predecessor
EXACT = 1e-3  # relative tolerance of a constant
TURNS = 12  # maximum number of turns of the two searches
SAME = 0.01  # allowed difference between turns, as a fraction of the friction


@dataclass(frozen=True, slots=True)
class Calibration:
    """A motor and a load that reproduce the measurements.

    Attributes:
        motor, load: the motor and the load with the calibrated constants.
        friction, iron: the constants found, N m and N m s; None if the corresponding rate was not measured.
        before: the friction and iron loss before the calibration, N m and N m s.
    """

    motor: MotorData
    load: LoadData
    friction: float | None
    iron: float | None
    before: tuple[float, float]


def calibrate(
    motor: MotorData,
    driver: DriverData,
    load: LoadData = LoadData(),  # noqa: B008  (frozen)
    *,
    start_stop: float | None = None,
    pull_out: float | None = None,
    torque: float = 0.0,
    steps: str = "full",
) -> Calibration:
    """Return a motor and a load with the friction and iron loss that reproduce the measured rates.

    Args:
        load: the load during the measurements; its friction is used if no start-stop rate is passed.
        start_stop: the maximum rate at which the motor starts without a ramp, full steps/s.
        pull_out: the rate at which the motor stalls when accelerated slowly, full steps/s.
        torque: the torque on the shaft at that stall, in addition to the load, N m.
        steps: step mode of the measurements, such as "half".

    Raises:
        UsageError: nothing was measured, or no constant reproduces the measurements.
    """
    if start_stop is None and pull_out is None:
        raise UsageError("nothing to calibrate with; set a start-stop rate, a pull-out rate, or both")
    for name, rate in (("start-stop", start_stop), ("pull-out", pull_out)):
        if rate is not None and not 20 <= rate <= 1e5:
            raise UsageError(f"{name} rate {rate:g} steps/s; allowed 20 to 100000 full steps/s")
    if torque and pull_out is None:
        raise UsageError(f"torque {torque:g} N m needs a pull-out rate; add the rate, or leave the torque out")
    if start_stop is not None and pull_out is not None and pull_out <= start_stop:
        raise UsageError(
            f"start-stop rate {start_stop:g}, pull-out rate {pull_out:g} steps/s: a motor that accelerates slowly "
            "reaches a higher rate than one that starts without a ramp; check whether the two rates are exchanged"
        )
    before = load.friction, motor.drag - motor.viscous
    if start_stop is not None and pull_out is not None:
        motor, load = _both(motor, driver, load, start_stop, pull_out, torque, steps)
    elif start_stop is not None:
        load = _rubbing(load, _friction(motor, driver, load, start_stop, steps))
    elif pull_out is not None:
        motor = replace(motor, iron=_iron(motor, driver, load, pull_out, torque, steps))
    return Calibration(
        motor,
        load,
        None if start_stop is None else load.friction,
        None if pull_out is None else motor.iron,
        before,
    )


def _both(
    motor: MotorData, driver: DriverData, load: LoadData, start_stop: float, pull_out: float, torque: float, steps: str
) -> tuple[MotorData, LoadData]:
    """Return the motor and the load with both constants, each found with the final value of the other.

    Raises:
        UsageError: no pair of constants reproduces both rates.
    """
    friction, tried = 0.0, (0.0, 0.0)  # the previous friction, and by how much it was too small
    for turn in range(TURNS):
        motor = replace(motor, iron=_iron(motor, driver, _rubbing(load, friction), pull_out, torque, steps))
        lacks = _friction(motor, driver, load, start_stop, steps) - friction
        if abs(lacks) <= SAME * (friction + lacks):
            return motor, _rubbing(load, friction)
        slope = (lacks - tried[1]) / (friction - tried[0]) if turn else -1.0
        tried, friction = (friction, lacks), max(friction - lacks / slope if slope else 0.0, 0.0)
    raise UsageError(
        f"start-stop rate {start_stop:g} and pull-out rate {pull_out:g} steps/s: no combination of friction and "
        "iron loss reproduces both; check motor, driver and load, or pass only one of the rates"
    )


def _rubbing(load: LoadData, friction: float) -> LoadData:
    return replace(load, friction=friction, stiction=None)


def _friction(motor: MotorData, driver: DriverData, load: LoadData, rate: float, steps: str) -> float:
    """Return the friction (N m) with which the motor just starts at a rate (full steps/s)."""

    def starts(friction: float) -> bool:
        return _starts(MotorLaw(motor, driver, _rubbing(load, friction), steps), rate)

    most = motor.holding_torque(driver.phase_current(motor))
    return _greatest(
        starts,
        most,
        f"start-stop rate {rate:g} steps/s",
        "friction",
        f"a friction of {most:.3g} N m, which the motor just holds",
    )


def _iron(motor: MotorData, driver: DriverData, load: LoadData, rate: float, torque: float, steps: str) -> float:
    """Return the iron loss (N m s) with which the motor just reaches a rate (full steps/s) under a torque."""
    loaded = replace(load, torque=load.torque + torque)

    def comes(iron: float) -> bool:
        return _comes_to(MotorLaw(replace(motor, iron=iron), driver, loaded, steps), rate)

    most = motor.holding_torque(driver.phase_current(motor)) / (rate * motor.step)
    return _greatest(
        comes,
        most,
        f"pull-out rate {rate:g} steps/s",
        "iron loss",
        f"an iron loss of {most:.3g} N m s, which uses up all of its torque",
    )


def _greatest(does: Callable[[float], bool], most: float, measured: str, what: str, bound: str) -> float:
    """Return the largest value of a constant, less than `most`, with which the motor reaches a measured rate.

    `does` returns whether the motor reaches the rate with a given value.  The search starts from large
    values, because a motor with too little drag may swing itself out of step at medium rates.  `measured`,
    `what` and `bound` are words for error messages.
    """
    if does(most):
        raise UsageError(f"{measured}: this motor is faster than that even with {bound}; check motor, driver and load")
    high = most
    for low in (*(most * COARSE**n for n in range(1, TRIES)), 0.0):
        if does(low):
            break
        high = low
    else:
        raise UsageError(
            f"{measured}: this motor does not reach it even without {what}; check motor, driver, supply and load, "
            "and that the rate is in full steps/s"
        )
    while high - low > EXACT * high and high > most * COARSE**TRIES:
        middle = (low + high) / 2
        low, high = (middle, high) if does(middle) else (low, middle)
    return (low + high) / 2


# -------------------------------------------------------------------------------------------------------- simulation
def _starts(law: MotorLaw, rate: float) -> bool:
    """Return whether the motor starts from rest at a rate (full steps/s) and stops again without losing steps."""
    import numpy as np

    count = START_STEPS * law.micro
    times = np.round(np.arange(1, count + 1) * 1e12 / (rate * law.micro)).astype(np.int64)
    trace = law.integrate(times, np.arange(1, count + 1), int(times[-1]) + 50_000_000_000, limit=law.lost_at)
    return trace.worst < law.lost_at and not trace.lost


def _comes_to(law: MotorLaw, rate: float) -> bool:
    """Return whether the motor, slowly accelerated, reaches a rate (full steps/s) without losing steps.

    The motor begins in step at a lower rate, with a typical lag; how it got to that rate does not matter.
    """
    import numpy as np

    first = SLOWEST * rate
    times = _sweep(first * law.micro, rate * law.micro)
    trace = law.integrate(
        times, np.arange(1, len(times) + 1), int(times[-1]), state=law.turning(first), limit=law.lost_at
    )
    return trace.worst < law.lost_at


def _sweep(first: float, last: float) -> NDArray[np.int64]:
    """Return the instants (ps) of commands whose rate is constant at first, then slowly rises.

    The constant rate is `first` and the final rate `last`, in commands/s.
    """
    import numpy as np

    even = np.arange(1, int(first * SETTLES_S) + 1) / first
    slope = (last - first) / SWEEP_S
    count = np.arange(1, int((first + last) / 2 * SWEEP_S) + 1)
    rising = (np.sqrt(first * first + 2 * slope * count) - first) / slope
    return np.round(np.append(even, (even[-1] if len(even) else 0.0) + rising) * 1e12).astype(np.int64)
