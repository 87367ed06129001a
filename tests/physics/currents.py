"""Windings and drivers, the rotor blocked or turned: rise and fall of currents, choppers, EMF, braking."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import cos, exp, log, pi, sqrt

import numpy as np

from slewline.parts.motors.integration import MotorTrace
from slewline.parts.motors.law import MotorLaw
from slewline.parts.motors.motor_data import DriverData, LoadData, MotorData

from .runs import F0, NONE, STEP, A, J, K, frequency, passes, ps, restless, seconds, with_state
from .table import Reading, at_most, check, near, same, within

TAU = A.inductance / A.resistance
FINE = 1_000_000  # ps
SHORTED = DriverData(kind="voltage", supply=1e-12)  # 0 would be off
HEAVY = LoadData(inertia=1e3)  # keeps its speed
RELUCTANCE = MotorData(
    name="VR", windings="reluctance", teeth=12, phases=4, current=1.0, resistance=5.0, inductance=8e-3, swing=5e-3,
    inertia=4e-6, iron=0.0,
)  # fmt: skip


def reaches(
    driver: DriverData, bound: float, stop: float, *, command: int = 0, step_ps: int = 0, **state: float
) -> float:
    """Return when the current of winding 1 of a blocked rotor comes to a bound (A), in ms."""
    law = restless(MotorLaw(A, driver, step_ps=step_ps, blocked=True))
    trace = law.integrate(
        NONE, NONE, ps(stop), state=with_state(law, i1=0.0, i2=0.0) if not state else with_state(law, **state),
        command=command, code=law.code(command), engine="python",
    )  # fmt: skip
    return float(passes(seconds(trace), trace["i1"], bound)[0]) * 1e3


@check(4, "current of a blocked rotor, ms")
def current_rise() -> Iterator[Reading]:
    full = 1 - exp(-1)
    yield near("5 V L/R to 63.2 %", reaches(DriverData(kind="voltage", supply=5.0), full, 4e-3), TAU * 1e3, 0.005)
    l_4r = DriverData(kind="voltage", supply=20.0, series=15.0)
    yield near("20 V L/4R to 63.2 %", reaches(l_4r, full, 1e-3), TAU / 4 * 1e3, 0.005)
    chopper = DriverData(kind="chopper", supply=24.0, current=1.0)
    on = {"on1": 1.0, "on2": 1.0}
    rise = reaches(chopper, 0.9999, 1e-3, i1=0.0, i2=0.0, **on)
    yield near("24 V chopper to 1 A", rise, -TAU * log(1 - 5 / 24) * 1e3, 0.005)
    turned = reaches(chopper, 0.9999, 1e-3, i1=-1.0, i2=-1.0, **on)
    yield near("24 V chopper from -1 A to 1 A", turned, TAU * log(29 / 19) * 1e3, 0.005)


@check(5, "EMF at 600 rpm, windings on a voltmeter of 10 kohm")
def emf() -> Iterator[Reading]:
    omega = 600 / 60 * 2 * pi
    meter = replace(SHORTED, series=10e3 - A.resistance)
    law = MotorLaw(A, meter, HEAVY, step_ps=500_000)
    trace = law.integrate(NONE, NONE, ps(0.011), state=with_state(law, omega=omega, i1=0.0, i2=0.0), engine="python")
    late = seconds(trace) >= 0.001
    volts = trace["i1"][late] * 10e3
    rising = passes(seconds(trace)[late], volts, 0.0)
    yield near("peak, V", float(np.abs(volts).max()), K * omega, 0.003)
    yield near("RMS, V", float(np.sqrt((volts * volts).mean())), K * omega / sqrt(2), 0.003)
    yield near("Hz", (len(rising) - 1) / (rising[-1] - rising[0]), A.teeth * 600 / 60, 0.003)


@check(27, "braking torque of shorted windings")
def shorted() -> Iterator[Reading]:
    for omega in (5.0, A.resistance / A.inductance / A.teeth, 50.0):
        law = MotorLaw(A, SHORTED, HEAVY)
        turn = 2 * pi / (A.teeth * omega)  # electrical
        since, until = 0.03, 0.03 + max(1, round(0.05 / turn)) * turn
        trace = law.integrate(
            NONE, NONE, ps(until), state=with_state(law, omega=omega, i1=0.0, i2=0.0), engine="python"
        )
        first, last = (int(np.searchsorted(seconds(trace), when)) for when in (since, until - 2e-5))
        speeds, times = trace["omega"], seconds(trace)
        inertia = HEAVY.inertia + J
        torque = -inertia * (speeds[last] - speeds[first]) / (times[last] - times[first])
        field = A.teeth * omega
        expected = K * K * omega * A.resistance / (A.resistance**2 + (field * A.inductance) ** 2)
        yield near(f"{omega} rad/s, Nm", torque, expected, 0.002)


def chopped(decay: str, *, step_ps: int = 200_000, **driver: float) -> MotorTrace:
    """Return the steady currents of a blocked motor behind a chopper of 24 V, 1 A, 20 kHz."""
    given = DriverData(kind="chopper", supply=24.0, current=1.0, decay=decay, **driver)  # type: ignore[arg-type]
    law = restless(MotorLaw(A, given, step_ps=step_ps, blocked=True))
    return law.integrate(NONE, NONE, ps(4e-3), engine="python")


def ripple(trace: MotorTrace, since: float = 3e-3) -> tuple[float, float]:
    """Return the peak to peak value and the mean of the current, over whole periods from an instant (s) on."""
    late = trace["i1"][seconds(trace) >= since][:-1]
    return float(late.max() - late.min()), float(late.mean())


@check(13, "chopper, slow decay, at standstill")
def chopper_slow() -> Iterator[Reading]:
    high, mean = ripple(chopped("slow", step_ps=100_000))
    expected = (24 - 5) * (5 / 24) / (20e3 * A.inductance)
    yield near("ripple, mA", high * 1e3, expected * 1e3, 0.05)
    yield near("mean, A", mean, 1 - expected / 2, 0.002)


def low_end(steps: list[tuple[float, float]]) -> float:
    """Return the least current of a steady cycle that begins at its peak, 1 A: volts and seconds of what follows."""
    current = 1.0
    for volts, span in steps:
        settled = volts / A.resistance
        current = settled + (current - settled) * exp(-span / TAU)
    return current


def cycle(decay: str, fast: float, diode: float = 0.0) -> tuple[float, float]:
    """Return ripple and duty of a steady cycle, from the exponentials: the rise from the least current ends at 1 A."""
    period = 1 / 20e3
    low, high = 0.0, period
    for _ in range(60):  # the time on, by bisection
        on = (low + high) / 2
        off = period - on
        least = low_end([(-24.0, min(fast, off)), (-diode, max(off - fast, 0.0))])
        rises = TAU * log((24 / A.resistance - least) / (24 / A.resistance - 1)) if least < 1 else 0.0
        low, high = (on, high) if rises > on else (low, on)
    return 1 - least, on / period


@check(101, "chopper, fast and mixed decay, at standstill")
def chopper_fast_and_mixed() -> Iterator[Reading]:
    # Fast decay at a duty above a half would be unstable: (24 + 5) / 48 is; so 12 us of fast decay, and a diode.
    high, _ = ripple(chopped("mixed", fast_part=0.1))
    yield near("mixed, 5 µs fast, ripple, mA", high * 1e3, cycle("mixed", 5e-6)[0] * 1e3, 0.03)
    high, _ = ripple(chopped("mixed", fast_part=0.2))
    yield near("mixed, 10 µs fast, ripple, mA", high * 1e3, cycle("mixed", 10e-6)[0] * 1e3, 0.03)
    high, _ = ripple(chopped("slow", diode=1.0))
    yield near("slow, diode of 1 V, ripple, mA", high * 1e3, cycle("slow", 0.0, 1.0)[0] * 1e3, 0.03)
    law = restless(
        MotorLaw(A, DriverData(kind="chopper", supply=24.0, current=1.0, decay="fast"), step_ps=100_000, blocked=True)
    )
    trace = law.integrate(NONE, NONE, ps(0.7e-3), state=with_state(law, i1=-1.0, i2=1.0), command=0, engine="python")
    # Until the first tick the current falls against the supply: to 0 in 50 us it comes not, i = -4.8 + 5.8 exp(-t/tau).
    at = int(np.searchsorted(trace.times, 40_000_000))
    yield near("fast, 1 A after 40 µs, A", trace["i2"][at], -4.8 + 5.8 * exp(-40e-6 / TAU), 0.002)
    yield near("fast, -1 A after 40 µs, A", trace["i1"][at], 4.8 - 5.8 * exp(-40e-6 / TAU), 0.002)


@check(102, "chopper: blanking sets a least current")
def least_current() -> Iterator[Reading]:
    driver = DriverData(kind="chopper", supply=24.0, current=0.005, least_on=2e-6)
    law = restless(MotorLaw(A, driver, step_ps=200_000, blocked=True))
    state = with_state(law, i1=0.0, i2=0.0)
    _, mean = ripple(law.integrate(NONE, NONE, ps(6e-3), state=state, engine="python"), 5e-3)
    least = 24 * 2e-6 * 20e3 / A.resistance
    yield near("2 µs, mean, A", mean, least * (1 - exp(-5.5e-3 / TAU)), 0.05)


@check(103, "winding that is let go")
def let_go() -> Iterator[Reading]:
    # Wave drive: command 0 -> 1 lets winding 1 go; its current falls against the supply, and stays at 0.
    for kind, supply, resistance in (("chopper", 24.0, 5.0), ("bilevel", 24.0, 5.0), ("voltage", 5.0, 5.0)):
        law = MotorLaw(A, DriverData(kind=kind, supply=supply, current=1.0), steps="wave", step_ps=FINE, blocked=True)  # type: ignore[arg-type]
        state = with_state(law, i1=1.0, i2=0.0)
        trace = restless(law).integrate(NONE, NONE, ps(3e-3), state=state, command=1, engine="python")
        ends = seconds(trace)[trace["i1"] <= 0][0]
        expected = TAU * log(1 + resistance / supply)
        yield within(f"{kind}, ms", ends * 1e3, expected * 1e3, 2e-3)
        late = trace["i1"][seconds(trace) > ends]
        yield same(f"{kind}, current then", float(np.abs(late).max()), 0.0)


@check(104, "bi-level: rise to 1 A, end of the high volts")
def bilevel() -> Iterator[Reading]:
    driver = DriverData(kind="bilevel", supply=5.0, high=40.0, high_time=0.2e-3)
    law = MotorLaw(A, driver, blocked=True)
    trace = law.integrate([1], [2], ps(4e-3), engine="python")  # both windings are reversed at once
    t, i1 = seconds(trace), trace["i1"]
    rise = TAU * log((8 + 1) / 8)  # from -1 A: to 0 only
    yield near("1 A to 0, ms", float(passes(t, -i1, 0.0)[0]) * 1e3, rise * 1e3, 0.005)
    peak = -8 + 9 * exp(-0.2e-3 / TAU)
    at = int(np.searchsorted(t, 0.2e-3))
    yield near("at the end of the high volts, A", i1[at], peak, 0.002)
    at = int(np.searchsorted(t, 2.2e-3))
    yield near("2 ms later, on the low volts, A", i1[at], -1 + (peak + 1) * exp(-2e-3 / TAU), 0.002)
    # Edges of the other winding do not shorten them.
    law = MotorLaw(A, replace(driver, high_time=0.4e-3), steps="half", blocked=True)
    trace = law.integrate([1, ps(0.11e-3), ps(0.27e-3)], [3, 4, 3], ps(2e-3), engine="python")
    volts = np.diff(trace["i1"]) / np.diff(seconds(trace)) * A.inductance + A.resistance * trace["i1"][:-1]
    high = seconds(trace)[:-1][volts < -20]
    yield within("half steps meanwhile, they end after, ms", high[-1] * 1e3 + 0.02, 0.4, 0.0201)
    long = MotorLaw(A, replace(driver, high_time=0.1), blocked=True)
    trace = long.integrate([1], [2], ps(0.2), engine="python")
    yield near("high volts of 100 ms end at last, A", trace["i1"][-1], -1.0, 0.001)


@check(34, "half winding, from 1 A to 0, ms")
def half_winding() -> Iterator[Reading]:
    motor = replace(A, windings="unipolar")
    for name, clamp in (("diode", 0.7), ("Zener diode", 24.0)):
        law = MotorLaw(motor, DriverData(kind="voltage", supply=5.0, clamp=clamp), step_ps=FINE // 2, blocked=True)
        trace = law.integrate(NONE, NONE, ps(5e-3), code=law.code(0, "off"), engine="python")
        ends = seconds(trace)[trace["i1"] <= 0][0]
        yield near(f"{name}, {clamp:g} V", ends * 1e3, TAU * log(1 + 5 / clamp) * 1e3, 0.005)


@check(106, "unipolar: the same torque as bipolar with half a winding")
def unipolar() -> Iterator[Reading]:
    law = MotorLaw(
        replace(A, windings="unipolar"), DriverData(kind="voltage", supply=500.0, series=495.0), step_ps=2_000_000
    )
    trace = law.integrate(NONE, NONE, ps(0.02), state=with_state(law, theta=0.01 * STEP), engine="python")
    damping = K * K / 500 / (2 * sqrt(A.teeth * A.torque * J))
    yield near("natural frequency, Hz", frequency(seconds(trace), trace["theta"]), F0 * sqrt(1 - damping**2), 0.003)


@check(107, "reluctance motor")
def reluctance() -> Iterator[Reading]:
    motor, volts = RELUCTANCE, DriverData(kind="voltage", supply=5.0)
    peak = motor.teeth * motor.swing / 2  # at 1 A
    # A quarter of an electrical turn off, the torque of one phase is at its peak.
    law = MotorLaw(motor, volts, LoadData(inertia=1.0), steps="wave", step_ps=FINE)
    quarter = pi / 2 / motor.teeth
    trace = restless(law).integrate(NONE, NONE, ps(1e-3), state=with_state(law, theta=quarter), engine="python")
    torque = (trace["omega"][-1] - trace["omega"][0]) / 1e-3 * (1.0 + motor.inertia)
    yield near("peak torque of one phase, Nm", torque, -peak, 0.001)
    # At rest, a quarter of the peak torque pulls it asin(1/4) / teeth behind.
    held = replace(motor, viscous=2 * sqrt(motor.teeth * peak * motor.inertia))
    for steps, angle in (("wave", 0.25), ("full", 0.25 / sqrt(2))):
        law = MotorLaw(held, volts, LoadData(torque=peak / 4), steps=steps)
        lag = float(law.integrate(NONE, NONE, ps(0.1), engine="python").lag[-1]) * motor.step
        yield near(
            f"lag with {steps} steps, degrees", lag * 180 / pi, np.degrees(np.arcsin(angle)) / motor.teeth, 0.005
        )
    law = MotorLaw(held, volts, steps="wave")
    times = [ps(0.04 * (n + 1)) for n in range(8)]
    trace = law.integrate(times, list(range(1, 9)), ps(0.4), engine="python")
    yield within("8 steps forward, steps", trace["theta"][-1] / motor.step, 8.0, 0.001)
    # The current of a blocked phase goes with the inductance that is there.
    law = MotorLaw(motor, volts, steps="wave", blocked=True, step_ps=FINE)
    for name, turned in (("aligned", 0.0), ("opposite", pi)):
        state = with_state(law, theta=turned / motor.teeth, i1=0.0)
        trace = law.integrate(NONE, NONE, ps(8e-3), state=state, engine="python")
        rise = passes(seconds(trace), trace["i1"], 1 - exp(-1))[0] * 1e3
        yield near(f"{name}, ms to 63.2 %", rise, (motor.inductance + motor.swing * cos(turned)) / 5 * 1e3, 0.005)
    three = replace(motor, phases=3)
    law = MotorLaw(replace(three, viscous=held.viscous), volts, steps="wave")
    trace = law.integrate(times, list(range(1, 9)), ps(0.4), engine="python")
    yield within("three phases, 8 steps forward, steps", trace["theta"][-1] / three.step, 8.0, 0.001)


@check(108, "reluctance motor: energy from the supply")
def reluctance_energy() -> Iterator[Reading]:
    motor = replace(RELUCTANCE, viscous=1e-4)
    law = MotorLaw(motor, DriverData(kind="voltage", supply=20.0, series=15.0), steps="wave", step_ps=FINE)
    times = [ps(0.005 * (n + 1)) for n in range(8)]
    trace = law.integrate(times, list(range(1, 9)), ps(0.05), engine="python")
    t = np.diff(seconds(trace))
    names = ("i1", "i2", "i3", "i4")
    asked = np.array(law.table)[trace.codes[:-1]]
    supplied = lost = stored = 0.0
    for n, name in enumerate(names):
        current = trace[name]
        on = asked[:, n] > 0
        falls = ~on & (current[:-1] > 0)
        mean = (current[1:] + current[:-1]) / 2
        supplied += float((mean * t * np.where(on, 20.0, np.where(falls, -law.driver.clamp, 0.0))).sum())
        lost += float(((current[1:] ** 2 + current[:-1] ** 2) / 2 * t).sum() * law.resistance)
        inductance = motor.inductance + motor.swing * np.cos(motor.teeth * trace["theta"] - n * pi / 2)
        energy = inductance * current**2 / 2
        stored += float(energy[-1] - energy[0])
    omega = trace["omega"]
    drag = float(((omega[1:] ** 2 + omega[:-1] ** 2) / 2 * t).sum() * motor.drag)
    moving = float(omega[-1] ** 2 - omega[0] ** 2) * motor.inertia / 2
    yield at_most("what is missing, of the input", abs(supplied - lost - stored - drag - moving) / supplied, 1e-3)
