"""Energy, accuracy against an independent solver, the same bits from each engine."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from math import pi
from typing import Any

import numpy as np

from slewline.parts.motors.integration import MotorTrace, numba_is_there
from slewline.parts.motors.law import MotorLaw
from slewline.parts.motors.motor_data import DriverData, LoadData, MotorData

from .currents import RELUCTANCE
from .runs import L_4R, STEP, A, Floats, Ints, J, K, fast, ps, ramp, up_to, with_state
from .table import Reading, at_most, check, near, same, within


# ------------------------------------------------------------------------------------------------------------- energy
def missing(trace: MotorTrace) -> float:
    """Return what is missing of the energy from the supply, as a part of it: trapezoids between grid points."""
    law = trace.law
    motor = law.motor
    asked = np.array(law.table)[trace.codes[:-1]]
    t = np.diff(trace.times * 1e-12)

    def over(values: Floats) -> float:
        return float(((values[1:] + values[:-1]) / 2 * t).sum())

    def change(values: Floats) -> float:
        return float(values[-1] - values[0])

    omega = trace["omega"]
    supplied = lost = stored = 0.0
    for n, name in enumerate(("i1", "i2")):
        current = trace[name]
        supplied += float((asked[:, n] * (current[1:] + current[:-1]) / 2 * t).sum())
        lost += over(current**2) * law.resistance
        stored += change(current**2) * motor.inductance / 2
    stored += change(omega**2) * (motor.inertia + law.load.inertia) / 2
    field = motor.teeth * trace["theta"] + pi / 4
    stored += change(-np.cos(4 * field)) * motor.detent / (4 * motor.teeth)
    lost += over(omega**2) * motor.drag + over(omega) * law.load.torque
    return (supplied - lost - stored) / supplied


@check(23, "energy of a ramp from 300 to 1000 steps/s")
def energy() -> Iterator[Reading]:
    motor = replace(A, detent=0.028, iron=1e-3)
    times = ramp(300.0, 1000.0, 4000.0)
    found = []
    for us in (5, 10, 20):
        law = MotorLaw(motor, L_4R, LoadData(inertia=J, torque=0.1), step_ps=us * 1_000_000)
        trace = law.integrate(times, np.arange(1, len(times) + 1), int(times[-1]), engine="python")
        found.append(missing(trace))
        if us == 5:
            yield at_most("worst lag, steps", trace.worst, 2.0)
            yield at_most("5 µs, missing, of the input", abs(found[0]), 1e-4)
    yield near("10 µs over 5 µs", found[1] / found[0], 4.0, 0.15)
    yield near("20 µs over 10 µs", found[2] / found[1], 4.0, 0.15)


# ----------------------------------------------------------------------------------------------------------- accuracy
def solved(law: MotorLaw, edges: Ints, state: list[float], stops: list[float]) -> list[float]:
    """Return the place (rad) at some instants, by another way: extrapolated midpoints from edge to edge, NumPy's sine.

    The equations are those of the text, written out once more; between edges nothing jumps.
    """
    motor, r = law.motor, law.resistance
    inertia = motor.inertia + law.load.inertia
    volts = np.array(law.table)

    def rates(y: Floats, v: Floats) -> Floats:
        s, c = np.sin(motor.teeth * y[0] + pi / 4), np.cos(motor.teeth * y[0] + pi / 4)
        torque = K * (y[3] * c - y[2] * s) - motor.detent * np.sin(4 * (motor.teeth * y[0] + pi / 4))
        return np.array([
            y[1],
            (torque - motor.drag * y[1] - law.load.torque) / inertia,
            (v[0] - r * y[2] + K * y[1] * s) / motor.inductance,
            (v[1] - r * y[3] - K * y[1] * c) / motor.inductance,
        ])  # fmt: skip

    def midpoints(y: Floats, v: Floats, span: float, count: int) -> Floats:
        h = span / count
        before, here = y, y + h * rates(y, v)
        for _ in range(count - 1):
            before, here = here, before + 2 * h * rates(here, v)
        return (before + here + h * rates(here, v)) / 2

    counts = (2, 4, 6, 8, 10, 12)

    def across(y: Floats, v: Floats, span: float) -> Floats:  # Gragg, Bulirsch and Stoer
        rows: list[Floats] = []
        for n, count in enumerate(counts):
            row = [midpoints(y, v, span, count)]
            for k in range(1, n + 1):
                factor = (count / counts[n - k]) ** 2 - 1
                row.append(row[k - 1] + (row[k - 1] - rows[n - 1][k - 1]) / factor)
            rows.append(row)  # type: ignore[arg-type]
        return rows[-1][-1]

    y, now, command = np.array(state), 0.0, 0
    marks = sorted([(edge * 1e-12, True) for edge in edges.tolist()] + [(stop, False) for stop in stops])
    found = []
    for when, is_edge in marks:
        if when > max(stops):
            break
        pieces = max(1, int(np.ceil((when - now) / 2.5e-4)))
        for _ in range(pieces):
            y = across(y, volts[law.code(command)], (when - now) / pieces)
        now = when
        if is_edge:
            command += 1
        else:
            found.append(float(y[0]))
    return found


STOPS = [0.01, 0.02, 0.05, 0.08, 0.1]
PRINTED = [3.2564126, 9.0433661, 38.6921113, 86.4077425, 128.2108508]  # full steps, from command 0 on


def check_35(step_ps: int) -> tuple[MotorLaw, Ints, list[float]]:
    """Return law, edges and first state of check 35."""
    motor = replace(A, detent=28e-3, iron=1.3e-3)
    driver = DriverData(kind="voltage", supply=24.0, series=15.0)
    law = MotorLaw(motor, driver, LoadData(inertia=13.6e-6 - J, torque=0.02), step_ps=step_ps)
    n = np.arange(1, 201)
    edges = np.rint((np.sqrt(9e4 + 4e4 * n) - 300) / 2e4 * 1e12).astype(np.int64)
    return law, edges, with_state(law, i1=1.2, i2=1.2)


def places(law: MotorLaw, edges: Ints, state: list[float], engine: str = "python") -> Floats:
    """Return where the rotor is at the instants of check 35, in full steps."""
    trace = law.integrate(edges, np.arange(1, len(edges) + 1), ps(0.1), state=state, engine=engine)
    found = []
    for stop in STOPS:
        at = int(np.searchsorted(trace.times, ps(stop), "right")) - 1
        point = (int(trace.times[at]), trace.states[at].tolist(), int(trace.codes[at]))
        found.append(law.after(*point, ps(stop) - point[0])[0] / STEP)
    return np.array(found)


@check(35, "a ramp, against an independent solver")
def solver() -> Iterator[Reading]:
    law, edges, state = check_35(20_000_000)
    expected = np.array(solved(law, edges, state, STOPS)) / STEP
    # The rotor begins at pi/200 from phase A, which is command 0; the printed steps count from there.
    errors = {}
    for us, tolerance in ((20, 1e-6), (50, 2e-5)):
        found = places(check_35(us * 1_000_000)[0], edges, state)
        errors[us] = float(np.abs(found - expected).max())
        for stop, place, printed in zip(STOPS, found, PRINTED, strict=True):
            yield within(f"{us} us, at {stop * 1e3:.0f} ms, steps", place, printed, tolerance)
        yield at_most(f"{us} us, furthest from the solver here, steps", errors[us], tolerance)


def falls(laws: list[MotorLaw], edges: Ints, state: list[float], stop: float) -> list[float]:
    """Return by what the error falls from one law to the next; the last one is the exact one."""
    ends = []
    for law in laws:
        trace = law.integrate(edges, np.arange(1, len(edges) + 1), ps(stop), state=state, engine=fast())
        at = len(trace.times) - 1
        span = ps(stop) - int(trace.times[at])
        end = law.after(int(trace.times[at]), trace.states[at].tolist(), int(trace.codes[at]), span)
        ends.append(np.array(end[:2]) / (STEP, 1.0))
    errors = [abs(float(end[0] - ends[-1][0])) for end in ends[:-1]]
    return [one / two for one, two in pairwise(errors)]


@check(117, "the error falls with the fourth power of the step", long=True)
def fourth_power() -> Iterator[Reading]:
    # Edges on the grid of every step, so that each step is whole.
    edges = np.arange(1, 21, dtype=np.int64) * 2_000_000_000
    for name, driver in (
        ("voltage", DriverData(kind="voltage", supply=24.0, series=15.0)),
        ("current", DriverData(kind="current", current=1.0)),
        ("lag", DriverData(kind="current", current=1.0, lag=0.3e-3)),
    ):
        motor = replace(A, detent=28e-3, iron=1.3e-3)
        spans = (100, 50, 25, 1)
        laws = [MotorLaw(motor, driver, LoadData(inertia=J, torque=0.02), step_ps=us * 1_000_000) for us in spans]
        ratios = falls(laws, edges, with_state(laws[0]), 0.043)
        yield near(f"{name}, 100 µs over 50 µs", ratios[0], 16.0, 0.25)
        yield near(f"{name}, 50 µs over 25 µs", ratios[1], 16.0, 0.15)


@check(118, "the averaged source", long=True)
def averaged_source() -> Iterator[Reading]:
    # What it decides depends on the step, so the model itself changes with it: its error falls with the step alone.
    edges = np.arange(1, 21, dtype=np.int64) * 2_000_000_000
    driver = DriverData(kind="averaged", supply=24.0, current=1.0)
    motor = replace(A, detent=28e-3, iron=1.3e-3)
    laws = [
        MotorLaw(motor, driver, LoadData(inertia=J, torque=0.02), step_ps=us * 1_000_000) for us in (40, 20, 10, 5, 1)
    ]
    ratios = falls(laws, edges, with_state(laws[0]), 0.043)
    for n, (one, two) in enumerate(((40, 20), (20, 10))):
        yield Reading(f"{one} us over {two} us, 2 to 4", ratios[n], 2.5, 1.0, 2.0)


# ------------------------------------------------------------------------------------------------------------ engines
UNIPOLAR = replace(A, windings="unipolar", detent=0.01)
WITH_DETENT = replace(A, detent=0.02, iron=None)
KINDS: tuple[tuple[str, MotorData, dict[str, Any], LoadData, str], ...] = (
    ("current", A, {"kind": "current", "current": 1.0}, LoadData(), "half"),
    ("lag", WITH_DETENT, {"kind": "current", "current": 1.0, "lag": 3e-4}, LoadData(friction=5e-3), "micro 8"),
    ("averaged", WITH_DETENT, {"kind": "averaged", "supply": 24.0, "current": 1.0}, LoadData(friction=5e-3), "full"),
    ("voltage", WITH_DETENT, {"kind": "voltage", "supply": 40.0, "series": 35.0}, LoadData(), "half"),
    (
        "bilevel", WITH_DETENT, {"kind": "bilevel", "supply": 5.0, "high": 40.0, "high_time": 3e-4},
        LoadData(inertia=5e-6, stiffness=9.0, friction=2e-3), "wave",
    ),
    ("slow", WITH_DETENT, {"kind": "chopper", "supply": 24.0, "current": 1.0, "boost": True}, LoadData(), "half"),
    (
        "fast", WITH_DETENT, {"kind": "chopper", "supply": 24.0, "current": 1.0, "decay": "fast", "least_on": 2e-6},
        LoadData(damper_inertia=7e-6, damper_drag=1e-3), "full",
    ),
    (
        "mixed", WITH_DETENT, {"kind": "chopper", "supply": 24.0, "current": 1.0, "decay": "mixed", "diode": 0.7},
        LoadData(friction=2e-3, damper_inertia=7e-6, damper_drag=1e-3, high=2.0), "micro 4",
    ),
    ("unipolar", UNIPOLAR, {"kind": "voltage", "supply": 20.0, "series": 15.0}, LoadData(low=-0.01), "full"),
    ("reluctance", RELUCTANCE, {"kind": "voltage", "supply": 20.0, "series": 15.0}, LoadData(friction=1e-3), "half"),
)  # fmt: skip


def different(law: MotorLaw, edges: Ints) -> tuple[int, int]:
    """Return the number of grid points, and of those whose bits are not the same from both engines."""
    stop = int(edges[-1])
    given = (edges, np.arange(1, len(edges) + 1), stop)
    one, two = (law.integrate(*given, engine=engine) for engine in ("python", "numba"))
    if len(one.times) != len(two.times):
        return len(one.times), abs(len(one.times) - len(two.times))
    same_bits = (one.states.view(np.int64) == two.states.view(np.int64)).all(axis=1) & (one.times == two.times)
    return len(one.times), int((~same_bits).sum())


@check(43, "plain Python and Numba give the same bits", long=True)
def engines() -> Iterator[Reading]:
    if not numba_is_there():
        return
    law = MotorLaw(WITH_DETENT, DriverData(kind="voltage", supply=48.0, series=43.0), LoadData(friction=2e-3))
    count, off = different(law, up_to(4000.0, 0.08, acceleration=30_000.0))
    yield same(f"ramp to 4,000 steps/s, of {count} points, different", off, 0)
    for name, motor, driver, load, steps in KINDS:
        law = MotorLaw(motor, DriverData(**driver), load, steps=steps)
        seconds = (14_000 if law.step_ps == 1_000_000 else 10_500) * law.step_ps * 1e-12
        # A ramp that ends when the points are made: with 20 us it comes to 2,000 steps/s
        fastest = 2000.0 if law.step_ps > 1_000_000 else 3000.0
        edges = ramp(100.0 * law.micro, fastest * law.micro, (fastest - 100) * law.micro / seconds)
        count, off = different(law, edges)
        yield Reading(f"{name}, points", count, 10_000, 0.0, float("inf"))
        yield same(f"{name}, different", off, 0)
