"""A Lanchester damper, against Den Hartog; the growth of an oscillation behind a resistance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import pi, sqrt

import numpy as np

from slewline.parts.motors.law import MotorLaw
from slewline.parts.motors.motor_data import DriverData, LoadData

from .runs import F0, HELD, NONE, OMEGA0, STIFFNESS, A, J, K, fast, loaded, ps, restless, seconds, with_state
from .table import Reading, check, near

DRAG = 7.452e-3
PIECES = 40  # of a period, in each of which the torque is constant


def amplitude(law: MotorLaw, frequency: float, torque: float) -> float:
    """Return how far a small torque of a frequency moves the rotor, to where it would hold it if it were steady."""
    middle = (np.arange(PIECES) + 0.5) / PIECES
    laws = [loaded(law, torque * np.sin(2 * pi * part)) for part in middle]
    state, start = law.at_rest(), 0
    t: list[float] = []
    theta: list[float] = []
    periods = 24
    for n in range(periods * PIECES):
        stop = ps((n + 1) / PIECES / frequency)
        # A grid point at the end of each piece: an edge that changes nothing
        trace = laws[n % PIECES].integrate([stop], [0], stop, start=start, state=state, engine="python")
        state, start = tuple(trace.states[-1].tolist()), int(trace.times[-1])
        t.append(start * 1e-12)
        theta.append(state[0])
    late = slice(-8 * PIECES, None)
    turn = np.exp(-2j * pi * frequency * np.array(t[late]))
    found = abs((np.array(theta[late]) * turn).mean()) * 2
    first = np.sinc(1 / PIECES)  # of the staircase, its sine is so much smaller
    return float(found / (torque / STIFFNESS) / first)


@check(32, "Lanchester damper, Jd = J, amplitude over static")
def lanchester() -> Iterator[Reading]:
    law = MotorLaw(A, HELD, LoadData(damper_inertia=J, damper_drag=DRAG))
    yield near("its best drag, from Den Hartog, mNms", 2 * J * OMEGA0 / sqrt(2 * 2 * 3) * 1e3, DRAG * 1e3, 0.001)
    for frequency, text in ((200.0, 2.320), (sqrt(2 / 3) * F0, 3.000), (300.0, 2.046)):
        w = 2 * pi * frequency
        ring = 1j * w * DRAG * (1j * w * J) / (1j * w * J + DRAG)  # what the ring adds, N m/rad
        expected = abs(STIFFNESS / (STIFFNESS - w * w * J + ring))
        found = amplitude(law, frequency, 1e-3)
        yield near(f"{frequency:.2f} Hz", found, expected, 0.01)
        yield near(f"{frequency:.2f} Hz, as the text has it", found, text, 0.01)


@check(116, "damper: the momentum is shared")
def momentum() -> Iterator[Reading]:
    law = MotorLaw(A, DriverData(kind="current", current=1e-9), LoadData(damper_inertia=3 * J, damper_drag=DRAG))
    trace = law.integrate(NONE, NONE, ps(0.01), state=with_state(law, omega=8.0), engine="python")
    yield near("speed of rotor and ring, rad/s", trace["omega"][-1], 2.0, 1e-4)
    yield near("and of the ring", trace["omega3"][-1], 2.0, 1e-4)
    t = seconds(trace)
    tau = 1 / (DRAG * (1 / J + 1 / (3 * J)))
    at = int(np.searchsorted(t, 1e-3))
    yield near("after 1 ms", trace["omega"][at], 2 + 6 * np.exp(-t[at] / tau), 1e-3)


@check(110, "a motor that swings itself out of step", long=True)
def instability() -> Iterator[Reading]:
    # 600 steps/s on 5 V sines, 5 times the inertia: the dq equations, made linear, have a root that grows.
    volts, resistance, drag, inertia, rate, micro = 5 * 4 / pi, 5.0, 2e-4, 33.8e-6, 600.0, 64
    field = 2 * pi * rate / 4
    omega, x, n = field / A.teeth, field * A.inductance, A.teeth
    iq = drag * omega / K
    across = resistance * iq + K * omega
    roots = np.roots([
        resistance**2 + x * x, 2 * x * across - 2 * resistance * x * iq, (x * iq) ** 2 + across**2 - volts**2
    ])  # fmt: skip
    current = float(max(roots.real))
    vd, vq = resistance * current - x * iq, across + x * current
    inductance = A.inductance
    matrix = np.array([
        [0, -n, 0, 0],
        [0, -drag / inertia, 0, K / inertia],
        [-vq / inductance, n * iq, -resistance / inductance, field],
        [vd / inductance, -(n * inductance * current + K) / inductance, -field, -resistance / inductance],
    ])  # fmt: skip
    root = max(np.linalg.eigvals(matrix), key=lambda value: value.real)
    law = MotorLaw(
        replace(A, iron=drag), DriverData(kind="voltage", supply=volts), LoadData(inertia=inertia - J),
        steps=f"micro {micro}",
    )  # fmt: skip
    # Begin in step, a hair off: the currents of dq, turned to where the rotor is.
    ahead = np.arctan2(vq, vd)
    place = pi / 4 - pi / 4 / micro - ahead + 1e-3  # electrical; the staircase is half a step behind at first
    i1 = current * np.cos(place) - iq * np.sin(place)
    i2 = current * np.sin(place) + iq * np.cos(place)
    state = with_state(law, theta=float((place - pi / 4) / n), omega=float(omega), i1=float(i1), i2=float(i2))
    times = np.rint(np.arange(1, int(rate * micro * 0.25)) / rate / micro * 1e12).astype(np.int64)
    trace = law.integrate(times, np.arange(1, len(times) + 1), int(times[-1]), state=state, engine=fast())
    at = np.searchsorted(trace.times, times)
    t = times * 1e-12
    lag = (trace.lag[at] - 0.5 / micro) * pi / 2 - ahead
    late = (t > 0.05) & (t < 0.15)
    peaks = np.flatnonzero((lag[1:-1] > lag[:-2]) & (lag[1:-1] >= lag[2:]) & late[1:-1]) + 1
    slope = np.polyfit(t[peaks], np.log(lag[peaks]), 1)[0]
    yield near("growth, 1/s", float(slope), root.real, 0.05)
    turns = (len(peaks) - 1) / (t[peaks[-1]] - t[peaks[0]])
    yield near("frequency, Hz", float(turns), abs(root.imag) / 2 / pi, 0.01)


@check(119, "one step behind 24 V, 1 A: a chopper damps", long=True)
def chopper_damps() -> Iterator[Reading]:
    # The text gives 61 ms, 72 % and 129 ms, from another program; slow decay, 20 kHz.
    for kind, settles in (("chopper", 61.0), ("averaged", 129.0)):
        driver = DriverData(kind=kind, supply=24.0, current=1.0)  # type: ignore[arg-type]
        law = restless(MotorLaw(replace(A, iron=3e-4), driver))
        trace = law.integrate([1], [1], ps(0.2), engine=fast())
        last = np.flatnonzero(np.abs(trace.lag) > 0.05)[-1]
        yield near(f"{kind}, to 5 % of a step, ms", seconds(trace)[last] * 1e3, settles, 0.02)
        if kind == "chopper":
            yield near("overshoot, steps", -float(trace.lag.min()), 0.72, 0.02)
