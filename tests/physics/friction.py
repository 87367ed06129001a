"""Friction, stiction, hard stops, couplings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import asin, degrees, pi, sqrt

import numpy as np

from slewline.parts.motors.law import MotorLaw
from slewline.parts.motors.motor_data import LoadData

from .runs import (
    F0,
    HELD,
    NONE,
    OMEGA0,
    STEP,
    STIFFNESS,
    TORQUE,
    A,
    J,
    frequency,
    ps,
    restless,
    seconds,
    steady,
    turnings,
    with_state,
)
from .table import Reading, at_most, check, near, same, within

RUBS = 5e-3  # N m


def turning_points(start: float, friction: float) -> list[float]:
    """Return where a rotor turns (full steps), by energy: TORQUE / teeth of both cosines is what friction takes."""
    places = [start]
    while TORQUE * abs(np.sin(places[-1] * pi / 2)) > friction:
        here = abs(places[-1])
        low, high = -here, here  # on the other side: low .. 0 .. high, by bisection
        for _ in range(80):
            there = (low + high) / 2
            spent = friction * (here + there) * STEP
            gained = TORQUE / A.teeth * (np.cos(there * pi / 2) - np.cos(here * pi / 2))
            low, high = (there, high) if gained > spent else (low, there)
        places.append(-low if places[-1] > 0 else low)
        if low <= 0:
            break
    return places


@check(30, "friction of 5 mNm, released 0.2 step off")
def coulomb() -> Iterator[Reading]:
    law = MotorLaw(A, HELD, LoadData(friction=RUBS))
    trace = law.integrate(NONE, NONE, ps(0.1), state=with_state(law, theta=0.2 * STEP), engine="python")
    _, places = turnings(trace)
    heights = np.abs(np.append(0.2, places))
    expected = np.abs(turning_points(0.2, RUBS))
    yield near("first turning point, lower by, steps", heights[0] - heights[1], expected[0] - expected[1], 0.02)
    yield near("first turning point by the series 0.0132", heights[0] - heights[1], 0.0132, 0.02)
    falls = -np.diff(heights[4:11])
    yield near("later ones, 2 Tc / k, steps", falls.mean(), 2 * RUBS / STIFFNESS / STEP, 0.02)
    yield within("eighth turning point, steps", heights[8], float(expected[8]), 2e-4)
    yield at_most("rests off by, steps", abs(trace["theta"][-1]) / STEP, RUBS / STIFFNESS / STEP)
    yield same("rests", trace.rests, 1)


@check(31, "dead zone of 50 mNm friction")
def dead_zone() -> Iterator[Reading]:
    expected = degrees(asin(0.05 / TORQUE) / A.teeth)
    law = MotorLaw(A, HELD, LoadData(friction=0.05))
    moved = []
    for turned in np.arange(0.110, 0.125, 0.0001):
        place = np.radians(turned)
        trace = law.integrate(NONE, NONE, ps(1e-3), state=with_state(law, theta=float(place)), engine="python")
        moved.append((turned, trace["theta"][-1] != place))
    edge = next(turned for turned, free in moved if free)
    yield near("leaves its place, degrees", edge, expected, 0.01)
    yield same("stays in every place nearer", sum(free for turned, free in moved if turned < edge), 0)


@check(111, "stiction: a shaft that stands needs more than one that moves")
def stiction() -> Iterator[Reading]:
    law = MotorLaw(A, HELD, LoadData(friction=0.02, stiction=0.08))
    for part, moves in ((0.99, 0), (1.01, 1)):
        place = asin(part * 0.08 / TORQUE) / A.teeth
        trace = law.integrate(NONE, NONE, ps(5e-3), state=with_state(law, theta=place), engine="python")
        yield same(f"{part} of it, moves", float(trace["theta"][-1] != place), moves)
    # Once it moves only friction counts: it turns where the energy says.
    place = asin(1.01 * 0.08 / TORQUE) / A.teeth / STEP
    _, places = turnings(
        law.integrate(NONE, NONE, ps(5e-3), state=with_state(law, theta=place * STEP), engine="python")
    )
    last = places[0] if len(places) else trace["theta"][-1] / STEP
    yield within("first turning point, steps", last, float(turning_points(place, 0.02)[1]), 1e-3)


@check(112, "friction does not change the frequency")
def friction_and_frequency() -> Iterator[Reading]:
    law = restless(MotorLaw(A, HELD, LoadData(friction=1e-9)))
    trace = law.integrate(NONE, NONE, ps(0.03), state=with_state(law, theta=0.01 * STEP), engine="python")
    yield near("1 nNm, Hz", frequency(seconds(trace), trace["theta"]), F0, 0.0005)


@check(113, "hard stop")
def hard_stop() -> Iterator[Reading]:
    wall = 2.3 * STEP
    law = MotorLaw(replace(A, iron=2e-3), HELD, LoadData(high=wall))
    times = steady(200.0, 6)
    trace = law.integrate(times, np.arange(1, 7), ps(0.1), engine="python")
    yield same("never beyond, rad", float(trace["theta"].max()), wall)
    # Command 6 is 3.7 steps off, beyond the unstable place: the rotor falls back a whole turn of the field, to 2.
    yield within("rests, steps", trace["theta"][-1] / STEP, 2.0, 1e-3)
    trace = law.integrate(times[:3], [1, 2, 3], ps(0.1), engine="python")
    yield same("command 3: rests at the wall, rad", trace["theta"][-1], wall)
    yield same("and is at rest", trace.rests, 1)
    trace = law.integrate([*times[:3], ps(0.05), ps(0.06)], [1, 2, 3, 2, 1], ps(0.2), engine="python")
    yield within("leaves it again, to step 1", trace["theta"][-1] / STEP, 1.0, 1e-3)
    law = MotorLaw(A, HELD, LoadData(low=-0.1 * STEP))
    trace = law.integrate(NONE, NONE, ps(0.02), state=with_state(law, theta=0.2 * STEP), engine="python")
    t = seconds(trace)
    # Without loss it falls on the wall with the energy of 0.2 less that of 0.1 step, stays there for no time, and its
    # swing is that of 0.1 step from then on.
    _, places = turnings(trace)
    yield within("swings back from a stop without bounce, steps", places[-1], 0.1, 1e-3)
    at = t[trace["theta"] <= -0.1 * STEP][0]
    # A small swing: cos(w t) = -1/2 after a third of a period; it is seen at the next grid point.
    yield Reading("reaches it after, ms", at * 1e3, 2 * pi / 3 / OMEGA0 * 1e3, 0.0, 0.02)


@check(114, "coupling with friction beyond it")
def coupling_with_friction() -> Iterator[Reading]:
    law = MotorLaw(A, HELD, LoadData(inertia=4 * J, stiffness=10.0, friction=0.05))
    # Held by friction, the load is a wall: the rotor swings alone, against motor and coupling.
    small = 0.004  # N m, that the coupling pulls with
    state = with_state(law, theta=small / 10)
    trace = restless(law).integrate(NONE, NONE, ps(0.02), state=state, engine="python")
    expected = sqrt((STIFFNESS + 10) / J) / 2 / pi
    yield near("rotor against a load that stands, Hz", frequency(seconds(trace), trace["theta"]), expected, 0.001)
    yield same("load stands", float(np.abs(trace["theta2"]).max()), 0.0)
    # One step on, the load stops where motor and coupling in series pull no more than friction.
    law = MotorLaw(
        replace(A, iron=5e-3), HELD, LoadData(inertia=4 * J, stiffness=10.0, friction=0.05, coupling_drag=1e-3)
    )
    trace = law.integrate([1], [1], ps(0.3), engine="python")
    yield same("comes to rest", trace.rests, 1)
    pulls = 10 * (trace["theta"][-1] - trace["theta2"][-1])
    yield at_most("pull at the load, Nm", abs(pulls), 0.05)
    # The rotor stands where the motor pulls as the coupling does.
    motor = -TORQUE * np.sin(A.teeth * (trace["theta"][-1] - STEP))
    yield within("torque of the motor against the coupling, Nm", motor, pulls, 1e-5)


@check(115, "coupling: a load that hangs on it")
def coupling_with_torque() -> Iterator[Reading]:
    law = MotorLaw(replace(A, iron=5e-3), HELD, LoadData(inertia=J, stiffness=5.0, torque=0.1, coupling_drag=1e-3))
    trace = law.integrate(NONE, NONE, ps(0.5), engine="python")
    rotor = -asin(0.1 / TORQUE) / A.teeth
    yield near("rotor, degrees", degrees(trace["theta"][-1]), degrees(rotor), 0.001)
    yield near("load, degrees", degrees(trace["theta2"][-1]), degrees(rotor - 0.1 / 5), 0.001)
