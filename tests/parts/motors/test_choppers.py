"""Choppers of drivers as they are sold: a fixed pause instead of a clock, and decay that depends on the step."""

from __future__ import annotations

from math import exp, log

import numpy as np
import pytest

import slewline
from slewline.errors import UsageError
from slewline.parts.motors.choppers import chopper_notes, least_current, ripple
from slewline.parts.motors.drivers import DRIVERS, read_driver
from slewline.parts.motors.integration import numba_is_there
from slewline.parts.motors.law import MotorLaw
from slewline.parts.motors.motor_data import DriverData
from slewline.parts.motors.motors import read_motor
from tests.physics.runs import restless
from tests.rows import rows

A = read_motor("QSH4218-51-10-049")  # 5 ohm, 8 mH
TAU = A.inductance / A.resistance
PAUSE = 30e-6
SMALL = "QSH4218-47-28-040"  # 0.6 mH


def currents(driver: DriverData, stop: float = 4e-3, steps: str = "full", edges=(), step_ps: int = 200_000):
    """The first current of a motor that is held, over time: seconds, and amperes."""
    law = restless(MotorLaw(A, driver, steps=steps, step_ps=step_ps, blocked=True))
    times = [round(at * 1e12) for at in edges]
    trace = law.integrate(times, range(1, len(times) + 1), round(stop * 1e12), engine="python")
    return np.array(trace.times) * 1e-12, trace["i1"], trace["i2"]


def peaks(seconds, amperes, since: float) -> np.ndarray:
    """The instants of the peaks."""
    late = np.flatnonzero(seconds >= since)
    i = amperes[late]
    return seconds[late][1:-1][(i[1:-1] > i[:-2]) & (i[1:-1] >= i[2:])]


@rows(("volts", "pause"), [(24.0, 30e-6), (12.0, 12e-6), (40.0, 20e-6)])
def test_a_fixed_pause_has_the_period_and_the_ripple_of_the_exponentials(volts, pause):
    driver = DriverData(kind="chopper", supply=volts, current=1.0, off_time=pause)
    seconds, amperes, _ = currents(driver, step_ps=100_000)
    least = exp(-pause / TAU)
    on = TAU * log((volts / A.resistance - least) / (volts / A.resistance - 1))
    late = amperes[seconds > 3e-3]
    assert late.max() - late.min() == pytest.approx(1 - least, abs=volts / A.inductance * 100e-9)  # the grid
    assert np.diff(peaks(seconds, amperes, 2e-3)).mean() == pytest.approx(pause + on, rel=0.01)


def test_a_lower_duty_is_a_higher_frequency_without_a_clock_and_the_same_with_one():
    def period(volts: float, **more: float) -> float:
        driver = DriverData(kind="chopper", supply=volts, current=1.0, **more)
        seconds, amperes, _ = currents(driver)
        return float(np.diff(peaks(seconds, amperes, 2e-3)).mean())

    assert period(12.0, off_time=PAUSE) > 1.3 * period(40.0, off_time=PAUSE)
    assert period(12.0, frequency=20e3) == pytest.approx(period(40.0, frequency=20e3), rel=0.01)


def test_auto_decay_is_fast_only_after_a_step_to_less_current():
    # micro 4: the first current becomes less with each step from command 0 on, the second one more
    found = {}
    for decay in ("slow", "mixed", "auto"):
        driver = DriverData(kind="chopper", supply=24.0, current=0.7, frequency=30e3, decay=decay, fast_part=0.3)
        seconds, one, two = currents(driver, 1.2e-3, "micro 4", edges=(0.9e-3,))
        after = (seconds > 0.9e-3) & (seconds < 1.05e-3)
        found[decay] = (one[after].min(), (two[after][1:] - two[after][:-1]).min())
        before = (seconds > 0.6e-3) & (seconds < 0.9e-3)
        found[decay] += (one[before].max() - one[before].min(),)
    slow, mixed, auto = (found[decay] for decay in ("slow", "mixed", "auto"))
    assert abs(auto[0] - mixed[0]) < slow[0] - auto[0] > 0.03  # the current that falls
    assert auto[1] == slow[1] > mixed[1]  # the one that rises falls slowly in its pauses
    assert auto[2] == slow[2] < mixed[2]  # and so do both before any step


@pytest.mark.skipif(not numba_is_there(), reason="Numba is not installed")
@rows("text", ["A4988, 24 V, 1 A", "DRV8825, 24 V, 1 A", "24 V, 1 A, off 12 us, mixed decay", "24 V, 1 A, auto decay"])
def test_both_engines_give_the_same_bits(text):
    law = MotorLaw(A, read_driver(text, "d", A), steps="micro 8", step_ps=5_000_000)
    times = [1_500_000_000 * n + 400_000_007 * (n % 3) for n in range(1, 40)]
    plain, fast = (law.integrate(times, range(1, 40), 80_000_000_000, engine=name) for name in ("python", "numba"))
    assert plain.states.tobytes() == fast.states.tobytes() and plain.rests == fast.rests


@rows("text", ["A4988, 24 V, 1 A", "DRV8825, 24 V, 1 A"])
def test_with_such_a_chopper_a_motor_comes_to_rest(text):
    law = MotorLaw(A, read_driver(text, "d", A), steps="half")
    trace = law.integrate([1_000_000_000, 2_000_000_000], [1, 2], 500_000_000_000)
    assert trace.rests and trace.lag[-1] == pytest.approx(0, abs=0.05)


def test_named_drivers_have_their_own_chopper():
    rows_of = {name: (row.data.kind, row.data.frequency, row.data.off_time) for name, row in DRIVERS.items()}
    assert rows_of == {
        "GS-D200": ("chopper", 17e3, 0.0),
        "GS-D200S": ("chopper", 17e3, 0.0),
        "L297+L298": ("chopper", 20e3, 0.0),
        "A4988": ("chopper", 0.0, 12e-6),
        "DRV8825": ("chopper", 30e3, 0.0),
        "TMC2208": ("averaged", 35.14e3, 0.0),
        "TMC2209": ("averaged", 35.14e3, 0.0),
    }
    assert pytest.approx(12e-6, rel=0.02) == 10e3 / 825 * 1e-6  # ROSC, ohm, to s
    assert pytest.approx(35.14e3, rel=1e-3) == 2 / 683 * 12e6
    a, drv = (read_driver(f"{name}, 24 V, 1 A", "d", A) for name in ("A4988", "DRV8825"))
    assert (a.off_time, a.decay, a.fast_part, a.period) == (12e-6, "auto", 0.3125, 12e-6)
    assert (drv.frequency, drv.decay, drv.least_on, drv.period) == (30e3, "auto", 3.75e-6, 1 / 30e3)
    clocked = read_driver("A4988, 24 V, 1 A, 25 kHz", "d", A)
    assert (clocked.off_time, clocked.period) == (0.0, 1 / 25e3)
    assert read_driver("TMC2209, 24 V, 1 A", "d", A).kind == "averaged"
    assert read_driver("TMC2209, 24 V, 1 A, chopper", "d", A).kind == "chopper"
    with pytest.raises(UsageError, match=r"a chopper has either a clock .* or a fixed pause .*: leave one out"):
        read_driver("24 V, 1 A, 20 kHz, off 12 us", "d", A)


@rows(
    ("motor", "driver", "says"),
    [
        (SMALL, "24 V, 2.8 A chopper", "chopper at 20 kHz: the current ripples by up to 0.5 A of 2.8 A at high rates, "
         "which costs up to 9% of the torque; the frequency is assumed: name the driver, such as DRV8825, or set its "
         "frequency, such as 36 kHz"),
        (SMALL, "24 V, 2.8 A", "chopper at 20 kHz: the current ripples by up to 0.5 A of 2.8 A"),
        (SMALL, "24 V, 2.8 A chopper, 36 kHz", ""),
        (SMALL, "24 V, 2.8 A, 20 kHz", "costs up to 9% of the torque"),
        (SMALL, "A4988, 24 V, 1.4 A", "chopper at a pause of 12 us: the current ripples by up to 0.24 A of 1.4 A"),
        (SMALL, "current 2.8 A", ""),
        ("QSH4218-51-10-049", "24 V, 1 A chopper", ""),
        ("QSH4218-51-10-049", "L/4R 20 V", ""),
    ],
)  # fmt: skip
def test_a_large_ripple_is_reported_and_an_assumed_frequency_is_marked(motor, driver, says):
    its = read_motor(motor)
    notes = chopper_notes(its, read_driver(driver, "d", its), driver)
    notes = tuple(note for note in notes if "blanking" not in note)
    assert len(notes) == bool(says) and all(says in note for note in notes)
    own = any(each in driver for each in ("kHz", "A4988"))
    assert all(("the frequency is assumed" in note) != own for note in notes)


@rows("text", ["24 V, 2.8 A chopper, 20 kHz", "24 V, 2.8 A chopper, 36 kHz", "24 V, 2.8 A, off 20 us"])
def test_the_ripple_is_that_of_a_winding_with_half_of_the_supply(text):
    # A resistance takes the volts that the EMF takes in motion, 0.47 of them: at a half a clocked one is unstable.
    # With the resistance the current falls along an exponential, by up to a tenth less.
    its = read_motor({"like": SMALL, "resistance": 0.47 * 24 / 2.8})
    driver = read_driver(text, "d", its)
    law = restless(MotorLaw(its, driver, step_ps=100_000, blocked=True))
    trace = law.integrate([], [], 3_000_000_000, engine="python")
    late = trace["i1"][np.array(trace.times) > 2_000_000_000]
    assert late.max() - late.min() == pytest.approx(ripple(its, driver), rel=0.13)


def test_a_restless_law_shows_the_ripple_at_rest():
    quiet, going = (slewline.motor_law(driver="DRV8825, 24 V, 1 A", restless=restless) for restless in (False, True))
    traces = [law.integrate([], [], 3_000_000_000, engine="python") for law in (quiet, going)]
    assert traces[0].rests and not traces[1].rests and traces[1].times[-1] > 2_990_000_000
    late = traces[1]["i1"][traces[1].times > 2_000_000_000]
    assert late.max() == pytest.approx(1, rel=0.01) and 0.01 < late.max() - late.min() < ripple(A, going.driver)


@rows("text", ["DRV8825, 24 V, 1.7 A", "A4988, 24 V, 1.4 A"])
def test_blanking_that_drives_too_much_is_reported_with_the_resulting_current(text):
    its = read_motor(SMALL)
    driver = read_driver(text, "d", its)
    law = slewline.motor_law(SMALL, text, restless=True, step_ps=250_000)
    trace = law.integrate([], [], 12_000_000_000, engine="numba" if numba_is_there() else "python")
    mean = trace["i1"][trace.times > 10_000_000_000].mean()
    assert mean == pytest.approx(least_current(its, driver), rel=0.05) and mean > 2 * driver.current
    (says,) = [note for note in chopper_notes(its, driver, text) if note.startswith("blanking of")]
    assert f"it alone drives {least_current(its, driver):.3g} A through a winding of 0.5 ohm at rest" in says
    for other in (f"{text}, mixed decay", text.replace("24 V", "8.5 V").replace("1.7", "1.76"), "24 V, 1.7 A, 30 kHz"):
        held = chopper_notes(read_motor("QSH4218-51-10-049"), read_driver(other, "d", its), other)
        assert not any("blanking" in note for note in held)
