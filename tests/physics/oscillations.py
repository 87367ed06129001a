"""Small oscillations, single steps and how to end them, damping rings, two masses, the separatrix."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import asin, degrees, exp, pi, sqrt

import numpy as np

from slewline.parts.motors.law import MotorLaw
from slewline.parts.motors.motor_data import DriverData, LoadData

from .runs import (
    F0,
    HELD,
    L_4R,
    NONE,
    OMEGA0,
    STEP,
    STIFFNESS,
    TORQUE,
    A,
    Floats,
    J,
    K,
    damped,
    elliptic_k,
    frequency,
    ps,
    restless,
    seconds,
    steady,
    swing,
    turnings,
    with_state,
)
from .table import Reading, at_least, at_most, check, near, same, within

HALF_TURN = elliptic_k(sqrt(0.5)) / pi / F0  # s, from one end of a swing of one full step to the other


def released(law: MotorLaw, steps: float, stop: float) -> tuple[Floats, Floats]:
    """Return instants and places (rad) of a rotor that is released so many full steps off."""
    trace = law.integrate(NONE, NONE, ps(stop), state=with_state(law, theta=steps * STEP), engine="python")
    return seconds(trace), trace["theta"]


@check(1, "natural frequency, current held")
def natural_frequency() -> Iterator[Reading]:
    for steps, torque in (("full", TORQUE), ("wave", TORQUE / sqrt(2))):
        found = frequency(*released(MotorLaw(A, HELD, steps=steps), 0.01, 0.04))
        yield near(f"{steps} steps, Hz", found, sqrt(A.teeth * torque / J) / (2 * pi), 0.003)


@check(2, "natural frequency with a detent of 28 mNm")
def natural_frequency_with_detent() -> Iterator[Reading]:
    motor = replace(A, detent=0.028)
    for steps, torque, sign in (("full", TORQUE, -1), ("wave", TORQUE / sqrt(2), 1)):
        stiffness = A.teeth * torque + sign * 4 * A.teeth * motor.detent
        found = frequency(*released(MotorLaw(motor, HELD, steps=steps), 0.01, 0.04))
        yield near(f"{steps} steps, Hz", found, sqrt(stiffness / J) / (2 * pi), 0.005)


@check(3, "one full step without loss")
def full_step() -> Iterator[Reading]:
    law = MotorLaw(A, HELD)
    times, places = turnings(law.integrate(NONE, NONE, ps(3e-3), state=law.at_rest(0), command=1, engine="python"))
    yield near("peak, steps", places[0], 2.0, 0.002)
    yield near("peak, ms", times[0] * 1e3, HALF_TURN * 1e3, 0.002)


def ring(law: MotorLaw, since: float, stop: float) -> tuple[float, float]:
    """Return the frequency (Hz) of the ring after one step, and the time (s) in which it falls to 1/e."""
    trace = law.integrate(NONE, NONE, ps(stop), state=law.at_rest(0), command=1, engine="python")
    times, places = turnings(trace)
    late = times > since
    times, heights = times[late], np.abs(places[late] - 1)
    slope = np.polyfit(times, np.log(heights), 1)[0]
    return (len(times) - 1) / (times[-1] - times[0]) / 2, -1 / slope


def ringing(resistance: float) -> complex:
    """Return the root of (L s + R)(J s2 + k) + K2 s that rings."""
    roots = np.roots([A.inductance * J, resistance * J, A.inductance * STIFFNESS + K * K, resistance * STIFFNESS])
    return complex(roots[np.argmax(roots.imag)])


@check(6, "ring after one step behind a resistance")
def ring_on_voltage() -> Iterator[Reading]:
    for name, driver, since in (
        ("L/R", DriverData(kind="voltage", supply=5.0), 0.025),
        ("L/4R", L_4R, 0.012),
    ):
        root = ringing(A.resistance + driver.series)
        found, falls = ring(MotorLaw(A, driver), since, since + 0.025)
        yield near(f"{name}, Hz", found, root.imag / (2 * pi), 0.01)
        yield near(f"{name}, envelope, ms", falls * 1e3, -1e3 / root.real, 0.05)


@check(10, "phase reversal ends a step")
def bang_bang() -> Iterator[Reading]:
    # From rest to half a step: t1 = 1/w0 times the integral of dx / sqrt(2 sin x) up to 45 degrees; with x = u2
    nodes, weights = np.polynomial.legendre.leggauss(30)
    u = (nodes + 1) / 2 * sqrt(pi / 4)
    half = float((weights * 2 * u / np.sqrt(2 * np.sin(u * u))).sum() * sqrt(pi / 4) / 2)
    yield near("t1 w0, as the text has it", half, 1.26654, 1e-5)
    for part in (1.0, 0.8, 1.2):
        t1 = part * half / OMEGA0
        law = MotorLaw(A, HELD)
        trace = law.integrate(
            [ps(t1), ps(2 * t1)], [0, 1], ps(2 * t1 + 0.02), state=law.at_rest(0), command=1, engine="python"
        )
        yield (
            at_most("ring, steps p-p", swing(trace), 0.01)
            if part == 1
            else within(f"{part} t1, ring, steps p-p", swing(trace), 0.6, 0.03)
        )


@check(11, "second step at the peak of the first")
def delayed_last_step() -> Iterator[Reading]:
    for part in (1.0, 0.9):
        law = MotorLaw(A, HELD)
        second = part * HALF_TURN
        trace = law.integrate([ps(second)], [2], ps(second + 0.02), state=law.at_rest(0), command=1, engine="python")
        if part == 1:
            yield at_most("ring, steps p-p", swing(trace), 0.005)
        else:  # from a place d off and a speed, by the energy: sin2(ring/2) of both
            t, w = seconds(trace), trace["omega"]
            at = int(np.searchsorted(t, second - 1e-12))
            x = A.teeth * (trace["theta"][at] - 2 * STEP)
            height = np.arccos(np.cos(x) - w[at] ** 2 * J * A.teeth / (2 * TORQUE)) / A.teeth / STEP
            yield within(f"{part}, ring, steps p-p", swing(trace), 0.48, 0.03)
            yield near(f"{part}, ring by the energy at that instant", swing(trace), 2 * float(height), 0.002)


@check(12, "200 steps near the resonance stay in step")
def resonance() -> Iterator[Reading]:
    for zeta, kept in ((0.02, 0), (0.10, 1)):
        for part in (0.5, 0.8, 0.9, 1.0, 1.1):
            law = MotorLaw(replace(A, iron=damped(zeta)), HELD)
            times = steady(part * F0, 200)
            trace = law.integrate(times, np.arange(1, 201), int(times[-1]) + ps(0.02), limit=3.9, engine="python")
            yield same(f"damping {zeta}, {part} f0", float(trace.worst <= 3.9), kept)


@check(16, "two masses, motor held")
def two_masses() -> Iterator[Reading]:
    coupling, load = 10.0, 27.2e-6
    law = MotorLaw(A, HELD, LoadData(inertia=load, stiffness=coupling))
    matrix = np.array([[(STIFFNESS + coupling) / J, -coupling / J], [-coupling / load, coupling / load]])
    expected = np.sqrt(np.sort(np.linalg.eigvals(matrix))) / (2 * pi)
    state = with_state(law, theta=1e-3 * STEP, theta2=1e-3 * STEP)
    trace = restless(law).integrate(NONE, NONE, ps(0.1), state=state, engine="python")
    # Of two oscillations, x[n+2] + x[n-2] = a (x[n+1] + x[n-1]) + b x[n]: the roots give both frequencies.
    every = 20
    x = trace["theta"][::every]
    known = np.stack([x[3:-1] + x[1:-3], x[2:-2]], 1)
    a, b = np.linalg.lstsq(known, x[4:] + x[:-4], rcond=None)[0]
    found = np.sort(np.abs(np.angle(np.roots([1, -a, -b, -a, 1]))))[1::2] / (2 * pi * every * law.step_ps * 1e-12)
    for which in (0, 1):
        yield near(("lower", "higher")[which] + ", Hz", float(found[which]), float(expected[which]), 0.005)


@check(33, "separatrix: the rotor passes its place")
def separatrix() -> Iterator[Reading]:
    yield near("8 f0, steps/s, from 4 sqrt(TORQUE / teeth / J)", 2 * sqrt(TORQUE / A.teeth / J) / STEP, 8 * F0, 1e-9)
    law = MotorLaw(A, HELD)
    for part in (0.995, 1.005):
        state = with_state(law, omega=part * 8 * F0 * STEP)
        trace = law.integrate(NONE, NONE, ps(0.05), state=state, engine="python")
        if part < 1:
            yield at_most(f"{part}, worst lag, steps", trace.worst, 2.0)
        else:
            yield at_least(f"{part}, steps after 50 ms", float(trace["theta"][-1] / STEP), 20.0)


@check(7, "static load angle, current held")
def load_angle() -> Iterator[Reading]:
    # With much drag, so that the rotor creeps to its place and does not swing beyond it.
    motor = replace(A, viscous=2 * sqrt(STIFFNESS * J))
    for torque in (0.245, 0.485, 0.495):
        law = MotorLaw(motor, HELD, LoadData(torque=torque))
        trace = law.integrate(NONE, NONE, ps(0.3), engine="python")
        if torque < TORQUE:
            expected = degrees(asin(torque / TORQUE) / A.teeth)
            yield near(f"{torque} Nm, lag, degrees", float(trace.lag[-1]) * 1.8, expected, 0.005)
        else:
            yield at_least(f"{torque} Nm slips, steps", float(trace.lag[-1]), 4.0)


@check(15, "microsteps with a detent of 28 mNm")
def microsteps() -> Iterator[Reading]:
    motor = replace(A, detent=0.028, viscous=2 * sqrt(STIFFNESS * J))
    law = MotorLaw(motor, HELD, steps="micro 64")
    times = steady(1 / 15e-3, 64)
    trace = law.integrate(times, np.arange(1, 65), int(times[-1]) + ps(15e-3), engine="python")
    settled = np.append(np.searchsorted(trace.times, times)[1:] - 1, len(trace.times) - 1)
    worst = float(np.abs(trace.lag[settled]).max())
    expected = degrees(asin(motor.detent / TORQUE) / A.teeth)
    yield near("worst error, degrees", worst * 1.8, expected, 0.02)


@check(105, "a free rotor loses its ring as its drag says")
def held_with_drag() -> Iterator[Reading]:
    zeta = 0.05
    law = restless(MotorLaw(replace(A, iron=damped(zeta)), HELD))
    state = with_state(law, theta=0.01 * STEP)
    _, places = turnings(law.integrate(NONE, NONE, ps(0.02), state=state, engine="python"))
    ratio = float(np.abs(places[1:9] / places[:8]).mean())
    yield near("each turning point to that before", ratio, exp(-pi * zeta / sqrt(1 - zeta * zeta)), 0.001)
