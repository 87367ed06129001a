"""What the checks have in common: the reference motor, trains of commands, slowly rising loads, readings of a trace."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slewline.parts.motors.integration import MotorTrace, numba_is_there
from slewline.parts.motors.law import MotorLaw
from slewline.parts.motors.motor_data import DriverData, MotorData

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# QSH4218-51-10-049, without any loss: K is 0.346482 N m/A
A = MotorData(name="A", current=1.0, resistance=5.0, inductance=8e-3, torque=0.49, inertia=6.8e-6, iron=0.0)
TORQUE = A.torque
K = A.constant
J = A.inertia
STEP = A.step
STIFFNESS = A.teeth * TORQUE  # N m/rad, about the place of a full step
OMEGA0 = sqrt(STIFFNESS / J)
F0 = OMEGA0 / (2 * pi)
HELD = DriverData(kind="current", current=1.0)
L_4R = DriverData(kind="voltage", supply=20.0, series=15.0)
NONE: tuple[int, ...] = ()


def ps(seconds: float) -> int:
    """Return picoseconds."""
    return round(seconds * 1e12)


def fast() -> str | None:
    """Return the fastest engine there is."""
    return "numba" if numba_is_there() else None


# ------------------------------------------------------------------------------------------------------ closed forms
def elliptic_k(k: float) -> float:
    """Return the complete elliptic integral of the first kind, by the arithmetic-geometric mean."""
    a, b = 1.0, sqrt(1 - k * k)
    while abs(a - b) > 1e-15:
        a, b = (a + b) / 2, sqrt(a * b)
    return pi / (a + b)


# ------------------------------------------------------------------------------------------------------------ trains
def steady(rate: float, count: int, since: float = 0.0) -> Ints:
    """Return so many edges (ps), the first one a period after an instant."""
    return np.rint((since + np.arange(1, count + 1) / rate) * 1e12).astype(np.int64)


def at_once(rate: float, count: int) -> Ints:
    """Return so many edges (ps), the first one at once: 1 ps after 0."""
    return np.rint(np.arange(count) / rate * 1e12).astype(np.int64) + 1


def ramp(low: float, high: float, acceleration: float) -> Ints:
    """Return the edges (ps) of a constant acceleration from one rate to another."""
    n = np.arange(1, int((high * high - low * low) / (2 * acceleration)) + 1)
    times = (np.sqrt(low * low + 2 * acceleration * n) - low) / acceleration
    return np.rint(times * 1e12).astype(np.int64)


def up_to(rate: float, seconds: float, *, low: float = 100.0, acceleration: float = 2000.0, micro: int = 1) -> Ints:
    """Return the edges (ps) of a ramp up to a rate (full steps/s), and of that rate for so many seconds."""
    rising = ramp(low * micro, rate * micro, acceleration * micro)
    since = rising[-1] * 1e-12 if rising.size else 0.0
    return np.concatenate([rising, steady(rate * micro, int(rate * micro * seconds), since)])


# ------------------------------------------------------------------------------------------------- loads that change
def loaded(law: MotorLaw, torque: float) -> MotorLaw:
    """Return the same motor with another torque of the load."""
    other = replace(law, load=replace(law.load, torque=float(torque)))
    other.__dict__["table"] = law.table
    return other


def restless(law: MotorLaw) -> MotorLaw:
    """Return the same motor that never comes to rest, so that its chopper goes on."""
    return replace(law, restless=True)


@dataclass
class Going:
    """A motor on its way through a train, in pieces between which its load changes."""

    law: MotorLaw
    times: Ints
    trace: MotorTrace | None = None
    limit: float = float("inf")
    engine: str | None = None

    def go(self, stop: float, torque: float | None = None) -> MotorTrace:
        """Go on to an instant (s), with another load if one is given."""
        if torque is not None:
            self.law = loaded(self.law, torque)
        more: dict[str, Any] = {}
        first = 0
        if self.trace is not None:
            last = self.trace
            more = {
                "start": int(last.times[-1]), "state": last.states[-1].tolist(), "command": int(last.commands[-1]),
                "code": int(last.codes[-1]),
            }  # fmt: skip
            first = int(np.searchsorted(self.times, last.times[-1], "right"))
        end = int(np.searchsorted(self.times, ps(stop), "right"))
        self.trace = self.law.integrate(
            self.times[first:end], np.arange(first + 1, end + 1), ps(stop), limit=self.limit, engine=self.engine, **more
        )
        return self.trace

    @property
    def slipped(self) -> bool:
        """Has it gone beyond the limit?"""
        return self.trace is not None and abs(float(self.trace.lag[-1])) > self.limit


def pull_out(
    law: MotorLaw,
    rate: float,
    *,
    slope: float,
    greatest: float,
    warm: float = 0.3,
    acceleration: float = 2000.0,
    piece: float = 0.005,
) -> float:
    """Return the load (N m) at which a motor at a rate (full steps/s) falls out of step; `slope` in N m/s."""
    going = Going(law, up_to(rate, warm + greatest / slope + 1, acceleration=acceleration, micro=law.micro), limit=3.9,
                  engine=fast())  # fmt: skip
    since = rate / acceleration + warm
    going.go(since)
    torque = 0.0
    while not going.slipped and torque < greatest:
        now = piece + (0.0 if going.trace is None else float(going.trace.times[-1]) * 1e-12)
        torque = slope * max(now - piece / 2 - since, 0.0)
        going.go(now, torque)
    return torque


# ---------------------------------------------------------------------------------------------------------- readings
def seconds(trace: MotorTrace) -> Floats:
    """Return the instants of a trace in seconds."""
    found: Floats = trace.times * 1e-12
    return found


def passes(t: Floats, values: Floats, bound: float, rising: bool = True) -> Floats:
    """Return when values pass a bound, between two points in a straight line."""
    over = values - bound
    found = np.flatnonzero((over[:-1] < 0) & (over[1:] >= 0) if rising else (over[:-1] >= 0) & (over[1:] < 0))
    where: Floats = t[found] - over[found] * (t[found + 1] - t[found]) / (over[found + 1] - over[found])
    return where


def frequency(t: Floats, values: Floats, middle: float = 0.0) -> float:
    """Return the frequency of an oscillation, from its first to its last passage upward."""
    found = passes(t, values, middle)
    return float((len(found) - 1) / (found[-1] - found[0]))


def turnings(trace: MotorTrace) -> tuple[Floats, Floats]:
    """Return when the rotor turns, and where (full steps); its speed is a straight line between two points."""
    t, omega, theta = seconds(trace), trace["omega"], trace["theta"]
    found = np.flatnonzero(omega[:-1] * omega[1:] < 0)
    part = omega[found] / (omega[found] - omega[found + 1]) * (t[found + 1] - t[found])
    return t[found] + part, (theta[found] + omega[found] * part / 2) / trace.law.motor.step


def swing(trace: MotorTrace) -> float:
    """Return how far the rotor swings, from the one end to the other, in full steps, at the end of a trace."""
    _, places = turnings(trace)
    return float(places[-20:].max() - places[-20:].min()) if len(places) > 1 else 0.0


def with_state(law: MotorLaw, **values: float) -> list[float]:
    """Return the law's state at rest, with other values for some names."""
    given = dict(zip(law.names, law.at_rest(), strict=True)) | values
    return [float(value) for value in given.values()]


def highest(rates: Sequence[float] | Floats, passed: Callable[[float], bool]) -> float:
    """Return the first of some rates, from the highest on down, that passes; 0 if none does."""
    return next((float(rate) for rate in rates if passed(float(rate))), 0.0)


def starts(law: MotorLaw, rate: float, count: int = 60, settle: float = 0.06) -> bool:
    """Return whether a motor follows so many steps that start at once at a rate and end so."""
    times = at_once(rate * law.micro, count * law.micro)
    stop = int(times[-1]) + ps(settle)
    trace = law.integrate(times, np.arange(1, len(times) + 1), stop, limit=3.9, engine=fast())
    return abs(trace.worst) <= 3.9 and abs(float(trace.lag[-1])) < 0.6


def damped(zeta: float, inertia: float = J) -> float:
    """Return the drag (N m s) that makes a damping ratio about the place of a full step of motor A."""
    return 2 * zeta * sqrt(STIFFNESS * inertia)
