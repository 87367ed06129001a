"""A motor by itself, without a chip or a bench, to compute its motion for steps at given times."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...core.messages.calls import answering
from .drivers import read_driver
from .law import MotorLaw
from .loads import check_holds, read_load
from .motor_data import DriverData, LoadData, MotorData
from .motors import read_motor


def read_system(motor: Any, driver: Any, load: Any, name: str = "") -> tuple[MotorData, DriverData, LoadData]:
    """Return the data of a motor, its driver and its load, each described by name, as text, or as a table.

    Args:
        name: prefix of "motor", "driver" and "load" in messages.

    Raises:
        UnknownName, UsageError: a name is unknown, a value not allowed, or the motor cannot hold the load.
    """
    turns = read_motor(motor, f"{name}motor")
    drives = read_driver(driver, f"{name}driver", turns)
    hangs = read_load(load, f"{name}load", turns)
    check_holds(turns, drives, hangs, f"{name}load")
    return turns, drives, hangs


@answering("motor_law()")
def motor_law(
    motor: Any = "QSH4218-51-10-049",
    driver: Any = "24 V, 1 A",
    load: str | Mapping[str, Any] = "",
    steps: str = "full",
    step_ps: int = 0,
    restless: bool = False,
) -> MotorLaw:
    """Return the equations of motion of a motor with driver and load, described as for the part `stepper`.

    Args:
        motor, driver, load: the name of a built-in motor, driver or load, its description as text, or a table.
        steps: the step mode of a command: "full" (two phases on), "wave" (one phase on), "half", or "micro 8".
        step_ps: the step of the integrator, ps; 0: 20 µs, or 1 µs for a switching chopper.
        restless: whether to integrate the motor also at rest, to include chopper ripple.

    Raises:
        UnknownName, UsageError: as for the part `stepper`.
    """
    return MotorLaw(*read_system(motor, driver, load), steps, step_ps, restless=restless)
