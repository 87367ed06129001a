"""A judge without physics: a function of a move and a scenario, with holes in the region of what holds."""

from __future__ import annotations

import os
from dataclasses import replace
from math import log
from time import sleep
from typing import Any

import numpy as np

from slewline.chips import ramps_of
from slewline.parts.motors.motor_data import DriverData, LoadData, MotorData
from slewline.tuning.candidates import Candidates
from slewline.tuning.grid import read_grid
from slewline.tuning.judging import Trial, Verdict
from slewline.tuning.perturbations import read_perturbations
from slewline.tuning.task import TuningTask

MOTOR = MotorData(
    name="stand-in", current=1.0, resistance=5.0, inductance=8e-3, torque=0.49, inertia=6.8e-6, friction=1e-3
)
DRIVER = DriverData(kind="averaged", supply=24.0, current=1.0)
LOAD = LoadData(inertia=6.8e-6, friction=5e-3, torque=30e-3)

GRIDS = {  # of every family
    "cy500": ("R=20..240/8 S=1..200/6", 200),
    "cy512": ("R=20..240/8 S=1..200/6", 200),
    "cy525": ("F=3..9 by 3 R=4..40/9 S=1..254/7", 1000),
    "cy545": ("F=100..800 steps/s/3 R=400..5000 steps/s/8 S=1..255/6", 1000),
    "cy545b": ("F=100..800 steps/s/3 R=400..5000 steps/s/8 S=1..255/6", 1000),
    "gs-c200": ("S=10..80/3 T=30..400/8 R=1..800/7", 1000),
    "gs-c200s": ("S=10..80/3 T=30..600/8 R=1..800/7", 1000),
    "mc1151a": ("SET_VEL=300..4000 steps/s/8 SET_ACC=2000..200000 steps/s2/8 SET_START_VEL=0,400 steps/s", 1000),
    "mc1451a": ("profile=s-curve SET_VEL=300..4000 steps/s/6 SET_MAX_ACC=2000..200000 steps/s2/6 SET_JERK=/", 1000),
}
SISTERS = ("cy512", "cy545b", "gs-c200s")  # parts whose moves are those of the one before
GRIDS["mc1451a"] = (GRIDS["mc1451a"][0].replace("=/", "=1e5 steps/s3..3e7 steps/s3/5"), 1000)


def task(part: str = "cy525", grid: Any = None, steps: int | None = None, **more: Any) -> TuningTask:
    """A task of a part."""
    calculator = ramps_of(part)
    usual, distance = GRIDS[part]
    hz = calculator.sheet.crystal_hz
    made = TuningTask(part, hz, {}, steps or distance, "full", MOTOR, DRIVER, LOAD,
                read_grid(calculator, grid or usual, hz), read_perturbations(None))  # fmt: skip
    return replace(made, **more)


def candidates(task: TuningTask) -> Candidates:
    """The candidates of a task."""
    return Candidates(ramps_of(task.part), task.grid, task.crystal_hz, task.steps)


def hits(run: Trial) -> Verdict:
    """Lose steps above a limit, and in bands of rates and accelerations below it, as resonances are."""
    scenario = run.scenario
    motor, driver, load = scenario.motor, scenario.driver, scenario.load
    rates = 1e12 / np.diff(run.times)
    top, first = float(rates.max()), float(rates[0])
    steepest = float(np.abs(np.diff(rates) * rates[1:]).max(initial=0.0)) + first**2 / 8
    strength = driver.current * min(driver.supply / 24, 1) / (motor.inertia + load.inertia) * 1.36e-5
    drags = 1 + load.torque * 5 * scenario.direction + (load.friction + motor.friction) * 3
    limit, rate_limit = 200_000 * strength / drags, 2600 * driver.supply / 24 * driver.current / drags
    inertia = motor.inertia + load.inertia
    ringing = int(log(steepest * top * inertia) * 5) % 6 == 3 and motor.drag + load.viscous < 1.2e-3 * 1.2
    worst = 1.9 * max(steepest / limit, top / rate_limit)
    if steepest > limit or top > rate_limit or (ringing and scenario.direction > 0):
        return Verdict(True, 4.0, max(worst, 2.0))
    return Verdict(False, 0.05, worst)


def counted(run: Trial) -> Verdict:
    """The same, slowly; every run is noted in a file."""
    with open(os.environ["STAND_IN_COUNTS"], "a", encoding="ascii") as file:
        file.write(f"{run.times[-1]} {run.scenario.name}\n")
    sleep(0.001)
    return hits(run)
