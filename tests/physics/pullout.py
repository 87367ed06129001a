"""Pull-out torque, start-stop rates, stalls: what a motor follows, and where it falls out of step.

The load rises slowly, in pieces of 5 ms, from 0 on at a steady rate; the rotor is lost 3.9 steps behind.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import exp, pi, sqrt

import numpy as np

from slewline.parts.motors.law import MotorLaw
from slewline.parts.motors.motor_data import DriverData, LoadData, MotorData

from .runs import (
    F0,
    L_4R,
    STEP,
    TORQUE,
    A,
    Going,
    J,
    K,
    damped,
    fast,
    highest,
    loaded,
    pull_out,
    starts,
    steady,
    up_to,
)
from .table import Reading, at_least, at_most, check, near, same, within

HELD = DriverData(kind="current", current=1.0)
DRAG = 2e-4
L_R = DriverData(kind="voltage", supply=5.0)
SINES = "micro 32"


def formula_8(rate: float, volts: float, resistance: float, drag: float) -> float:
    """Return the pull-out torque (N m) of motor A at a rate, behind sines of so many volts."""
    field = 2 * pi * rate / 4
    omega = field / A.teeth
    z = sqrt(resistance**2 + (field * A.inductance) ** 2)
    return K * volts / z - K * K * omega * resistance / (z * z) - drag * omega


@check(8, "pull-out on L/4R", long=True)
def pull_out_on_voltage() -> Iterator[Reading]:
    law = MotorLaw(replace(A, iron=DRAG), L_4R, LoadData(inertia=33.8e-6 - J))
    for rate in (400.0, 800.0, 1200.0, 1600.0):
        expected = formula_8(rate, 20 * 4 / pi, 20.0, DRAG)
        found = pull_out(law, rate, slope=0.05, greatest=0.5)
        yield near(f"{rate:g} steps/s, Nm", found, expected, 0.01, 0.04)


@check(25, "pull-out at 600 steps/s", long=True)
def pull_out_l_r() -> Iterator[Reading]:
    # On L/R it swings itself out of step (check 110): without load with 5 times the inertia, and above 0.08 Nm with the
    # rotor alone.  So the load rises at 0.1 Nm/s, at once, before the swing has grown.
    found = []
    for name, driver in (("L/R", L_R), ("L/4R", L_4R)):
        law = MotorLaw(replace(A, iron=DRAG), driver)
        expected = formula_8(600.0, driver.supply * 4 / pi, law.resistance, DRAG)
        found.append(pull_out(law, 600.0, slope=0.1, greatest=0.5, warm=0.0))
        yield near(f"{name}, Nm", found[-1], expected, 0.04)
    yield near("ratio", found[1] / found[0] if found[0] else 0.0, 0.310 / 0.102, 0.04)


@check(28, "pull-out behind sines of 20 V", long=True)
def pull_out_on_sines() -> Iterator[Reading]:
    law = MotorLaw(replace(A, iron=DRAG), L_4R, LoadData(inertia=33.8e-6 - J), steps=SINES)
    for rate in (400.0, 800.0, 1200.0, 1600.0):
        found = pull_out(law, rate, slope=0.01, greatest=0.5)
        yield near(f"{rate:g} steps/s, Nm", found, formula_8(rate, 20.0, 20.0, DRAG), 0.01, 0.02)


@check(29, "steady angle of the voltage ahead of the rotor", long=True)
def voltage_angle() -> Iterator[Reading]:
    micro = 256
    law = MotorLaw(replace(A, iron=DRAG), L_4R, LoadData(inertia=33.8e-6 - J, torque=0.1), steps=f"micro {micro}")
    for rate in (400.0, 800.0, 1200.0):
        field = 2 * pi * rate / 4
        omega = field / A.teeth
        # dq, steady: iq carries the torque, id follows from the size of the voltage
        iq = (0.1 + DRAG * omega) / K
        reactance = field * A.inductance
        emf = K * omega
        roots = np.roots([
            20.0**2 + reactance**2,
            2 * reactance * (20 * iq + emf) - 2 * 20 * reactance * iq,
            (reactance * iq) ** 2 + (20 * iq + emf) ** 2 - 20.0**2,
        ])  # fmt: skip
        angles = [np.arctan2(20 * iq + reactance * i.real + emf, 20 * i.real - reactance * iq) for i in roots]
        expected = float(np.degrees(min(angles, key=abs)))
        times = up_to(rate, 1.5, micro=micro, acceleration=1000.0)
        trace = law.integrate(times, np.arange(1, len(times) + 1), int(times[-1]), engine=fast())
        # Each step of the staircase is held: its sine is half a step behind it.
        at = np.searchsorted(trace.times, times[-int(rate / 4 * micro * 0.4) :])
        ahead = float(trace.lag[at].mean() - 0.5 / micro) * 90
        yield within(f"{rate:g} steps/s, degrees", ahead, expected, 0.01)


@check(9, "start-stop rate over f0, and how inertia lowers it", long=True)
def start_stop() -> Iterator[Reading]:
    first = 0.0
    for ratio in (0, 1, 3, 8):
        inertia = J * (1 + ratio)
        own = F0 / sqrt(1 + ratio)
        law = MotorLaw(replace(A, iron=damped(0.039, inertia)), HELD, LoadData(inertia=inertia - J))
        found = highest(
            np.arange(8.2, 6.0, -0.005) * own, lambda rate, law=law, own=own: starts(law, rate, settle=40 / own)
        )
        yield near(f"{ratio} times its inertia, of f0", found / own, 6.99, 0.02)
        first = first or found
        yield near(f"{ratio} times its inertia, of that without", found / first, 1 / sqrt(1 + ratio), 0.02)


def stall_rate(rate: float, law: MotorLaw, over: float) -> float:
    """Return how many steps (lag at rest) a motor is behind after it was overloaded at a rate, then freed."""
    edges = up_to(rate, 0.25, acceleration=4000.0)
    going = Going(law, edges, engine=fast())
    since = rate / 4000.0 + 0.1
    going.go(since)
    going.go(since + 0.05, over)
    going.go(float(edges[-1]) * 1e-12 + 0.4, 0.0)
    assert going.trace is not None
    return float(going.trace.lag[-1])


@check(22, "a stall ends a multiple of four steps off", long=True)
def stall() -> Iterator[Reading]:
    law = MotorLaw(replace(A, iron=1e-3), L_4R, LoadData(inertia=J))
    lag = stall_rate(500.0, law, 0.45)
    yield at_least("steps lost", abs(lag), 3.9)
    yield within("to the nearest multiple of four", lag - 4 * round(lag / 4), 0.0, 0.05)


@check(41, "all stalls of a sweep", long=True)
def stalls() -> Iterator[Reading]:
    count = off = 0
    worst = 0.0
    for driver in (L_4R, DriverData(kind="averaged", supply=24.0, current=1.0)):
        law = MotorLaw(replace(A, iron=1e-3), driver, LoadData(inertia=J))
        for rate in np.linspace(300, 900, 13):
            for over in (0.42, 0.6, 1.0):
                lag = stall_rate(float(rate), law, over)
                near_four = abs(lag - 4 * round(lag / 4))
                count += abs(lag) > 0.6
                off += abs(lag) > 0.6 and near_four > 0.05
                worst = max(worst, near_four)
    yield at_least("motors that stalled", count, 60)
    yield same("those not a multiple of four off", off, 0)
    yield at_most("furthest from a multiple of four", worst, 0.05)


def predictor(motor: MotorData, rpm: float) -> float:
    """Return the torque of a public predictor: T / sqrt 2 times the part of the current that comes up in a step."""
    amperes, volts = motor.current, 24.0
    emf = motor.constant * rpm / 60 * 2 * pi / sqrt(2)
    span = 60 / rpm / motor.full_steps
    tau = motor.inductance / motor.resistance * amperes * motor.resistance / (volts - emf)
    return motor.torque / sqrt(2) * (1 - exp(-span / tau))


def half_steps(motor: MotorData, expected: tuple[float, float, float], tolerance: float) -> Iterator[Reading]:
    """Yield the pull-out torque at 300, 600 and 900 rpm, half steps with an even torque, 24 V; the peak is rated."""
    driver = DriverData(kind="chopper", supply=24.0, current=motor.current / sqrt(2), boost=True, frequency=36e3)
    law = MotorLaw(motor, driver, LoadData(inertia=motor.inertia), steps="half")
    for rpm, torque in zip((300, 600, 900), expected, strict=True):
        rate = rpm / 60 * motor.full_steps
        found = pull_out(law, rate, slope=0.1, greatest=1.0, acceleration=6000.0, warm=0.2)
        yield near(f"{rpm} rpm, Nm", found, torque, tolerance)


KYSAN = MotorData(
    name="Kysan 1124090", current=1.5, resistance=2.8, inductance=4.8e-3, torque=0.2543 * 1.5 * sqrt(2), inertia=6.8e-6,
    iron=2.66e-3 * 0.54,
)  # fmt: skip


@check(14, "Kysan 1124090, 24 V, half steps", long=True)
def kysan() -> Iterator[Reading]:
    yield from half_steps(KYSAN, (0.352, 0.224, 0.106), 0.15)


@check(36, "OMC 17HS19-2004S1, 24 V, half steps", long=True)
def omc_19() -> Iterator[Reading]:
    motor = MotorData(name="17HS19-2004S1", current=2.0, resistance=1.4, inductance=3e-3, torque=0.59, inertia=8.2e-6)
    yield from half_steps(motor, (0.401, 0.295, 0.179), 0.18)


@check(37, "LDO 42STH47-1684AC, 24 V, half steps", long=True)
def ldo_47() -> Iterator[Reading]:
    motor = MotorData(
        name="42STH47-1684AC", current=1.68, resistance=1.65, inductance=2.8e-3, torque=0.49, inertia=6.8e-6
    )
    yield from half_steps(motor, (0.341, 0.275, 0.179), 0.18)


@check(38, "OMC 17HS24-2104S, 24 V, half steps", long=True)
def omc_24() -> Iterator[Reading]:
    motor = MotorData(name="17HS24-2104S", current=2.1, resistance=1.6, inductance=3e-3, torque=0.65, inertia=14.8e-6)
    yield from half_steps(motor, (0.438, 0.312, 0.180), 0.18)


@check(24, "17HS4401 class, 24 V chopper, no load: start-stop rate", long=True)
def self_start() -> Iterator[Reading]:
    motor = MotorData(name="17HS4401", current=1.7, resistance=1.5, inductance=2.8e-3, torque=0.42, inertia=5.4e-6)
    law = MotorLaw(motor, DriverData(kind="chopper", supply=24.0, current=1.7))
    found = highest(np.arange(2600.0, 1000.0, -20.0), lambda rate: starts(law, rate))
    yield at_least("steps/s", found, 1500.0)
    yield at_most("steps/s", found, 2400.0)


@check(39, "pull-in: 24 microsteps, current behind a lag", long=True)
def pull_in() -> Iterator[Reading]:
    amperes = 1.697 / sqrt(2)
    motor = MotorData(
        name="pull-in", current=amperes, resistance=1.0, inductance=1e-3, torque=0.214 * amperes * sqrt(2),
        detent=11e-3, inertia=7 * 37e-7, iron=1e-4,
    )  # fmt: skip
    law = MotorLaw(motor, DriverData(kind="current", current=amperes, lag=0.295e-3), steps="micro 24")
    expected = {200: (242, 240), 300: (224, 228), 425: (198, 196), 575: (148, 158), 775: (88, 92), 1500: (0, 0)}
    # From phase A on, which is half a step before command 0; the first microstep comes after its time.
    first = -12
    commands = first + np.arange(1, 24 * 200 + 1)
    for rate, (failure, success) in expected.items():
        times = steady(24.0 * rate, 24 * 200)
        passed = [
            loaded(law, torque * 1e-3)
            .integrate(times, commands, int(times[-1]), command=first, limit=2.0, engine=fast())
            .worst <= 2
            for torque in range(0, 400, 2)
        ]  # fmt: skip
        if rate == 1500:
            yield same("1500 steps/s, loads that it starts with", sum(passed), 0)
        else:
            yield within(f"{rate} steps/s, first failure, mNm", 2 * passed.index(False), failure, 5)
            yield within(f"{rate} steps/s, last success, mNm", 398 - 2 * passed[::-1].index(True), success, 5)


@check(109, "pull-out, current held, full steps", long=True)
def pull_out_held() -> Iterator[Reading]:
    # With much inertia the rotor turns evenly, and the mean of the torque counts: 2 sqrt 2 / pi of what holds.
    law = MotorLaw(replace(A, iron=1e-4), HELD, LoadData(inertia=100 * J, viscous=2e-3))
    rate = 400.0
    found = pull_out(law, rate, slope=0.05, greatest=0.6, acceleration=400.0)
    yield near("400 steps/s, Nm", found, 2 * sqrt(2) / pi * TORQUE - 2.1e-3 * rate * STEP, 0.02)


@check(120, "averaged source over chopper, 2.8 A, 24 V, half steps", long=True)
def averaged_over_chopper() -> Iterator[Reading]:
    motor = MotorData(
        name="QSH4218-47-28-040", current=2.8, resistance=0.5, inductance=0.6e-3, torque=0.4, detent=0.02,
        inertia=6.8e-6, iron=2.4e-3 * 0.4,
    )  # fmt: skip
    chopper = DriverData(kind="chopper", supply=24.0, current=2.8, boost=True, frequency=36e3)
    load = LoadData(inertia=6.8e-6)
    for rate, more in ((1000.0, 0.01), (2000.0, 0.02), (4000.0, 0.07)):
        switched, averaged = (
            pull_out(
                MotorLaw(motor, driver, load, steps="half", step_ps=step_ps), rate, slope=0.1, greatest=0.6,
                acceleration=8000.0, warm=0.2,
            )
            for driver, step_ps in ((chopper, 500_000), (replace(chopper, kind="averaged"), 0))
        )  # fmt: skip
        yield near(f"{rate:g} steps/s", averaged / switched, 1 + more, 0.02)
