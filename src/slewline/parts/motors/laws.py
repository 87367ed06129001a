"""A motor by itself, without chip and bench: to ask what it does when it is stepped at given times."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .drivers import read_driver
from .law import MotorLaw
from .loads import check_holds, read_load
from .motors import read_motor


def motor_law(
    motor: Any = "QSH4218-51-10-049",
    driver: Any = "24 V, 1 A",
    load: str | Mapping[str, Any] = "",
    steps: str = "full",
    step_ps: int = 0,
) -> MotorLaw:
    """Return the law of a motor with driver and load, given as the part `stepper` takes them.

    Args:
        steps: "full", "wave", "half", "micro 8": what a command is.
        step_ps: of the integrator; 0: 20 us, with a chopper 1 us.

    Raises:
        UnknownName, UsageError: as the part `stepper`.
    """
    its = read_motor(motor)
    drives, hangs = read_driver(driver, "driver", its), read_load(load, "load", its)
    check_holds(its, drives, hangs)
    return MotorLaw(its, drives, hangs, steps, step_ps)
