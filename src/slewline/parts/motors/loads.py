"""Loads of a motor, described as text or as a table of figures; a linear axis is described by its mass and lead.

load = "inertia 68 g cm2, friction 5 mNm"
load = { inertia = "68 g cm2", friction = "5 mNm", low = -200, high = 4000 }
load = { mass = "2 kg", lead = "5 mm", force = "10 N", efficiency = 0.8, vertical = true }
"""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Any

from ...core.datasheet.option import Option, checked
from ...errors import UsageError
from .motor_data import DriverData, LoadData, MotorData
from .motor_figures import complaint, figure, of_text, share, signed
from .motors import MOTORS

GRAVITY = 9.80665  # m/s2
AXIS = ("mass", "lead", "efficiency", "force", "vertical")

FIGURES = (
    figure("inertia", "kg m2", "inertia of all that turns with the shaft, except the rotor"),
    figure("viscous", "N m s", "drag that grows with the speed"),
    figure("friction", "N m", "Coulomb friction"),
    figure("stiction", "N m", "torque that a shaft at rest resists; None: the friction", None),
    signed("torque", "N m", "torque acting backwards, such as that of a lifted weight; negative: forward"),
    figure("stiffness", "N m/rad", "stiffness of the coupling to the inertia; 0: rigid"),
    figure("coupling_drag", "N m s", "viscous drag of the coupling"),
    figure("damper_inertia", "kg m2", "inertia of a damper on the shaft"),
    figure("damper_drag", "N m s", "viscous drag between the damper and the shaft"),
    Option("low", "float", None, "position of the lower hard stop", unit="full steps", none=True),
    Option("high", "float", None, "position of the upper hard stop", unit="full steps", none=True),
    figure("mass", "kg", "mass of a linear axis"),
    figure("lead", "m", "travel of the axis per turn"),
    Option("efficiency", "float", 1.0, "efficiency of the screw, for the force", check=share),
    figure("force", "N", "friction force on the axis"),
    Option("vertical", "bool", False, "the axis lifts its mass as it counts up"),
)
NEEDS = (  # figures that have no effect without another figure
    ("mass", "lead"),
    ("force", "lead"),
    ("lead", "mass or force"),
    ("vertical", "mass"),
    ("coupling_drag", "stiffness"),
    ("stiffness", "inertia or mass"),
    ("damper_inertia", "damper_drag"),
    ("damper_drag", "damper_inertia"),
)


def read_load(value: Any, name: str, motor: MotorData) -> LoadData:
    """Return a load described by text or by a table of figures.

    Args:
        name: the load's name in messages.
        motor: the driving motor; the hard stops are expressed in its full steps.

    Raises:
        UsageError: a figure is unknown, out of range, or has no effect without another figure.
    """
    if isinstance(value, LoadData):
        return value
    if not isinstance(value, (str, Mapping)):
        table = ", ".join(row.name for row in FIGURES)
        raise UsageError(
            f"{name} {value!r}; expected text such as 'inertia 68 g cm2, friction 5 mNm', or a table (keys: {table})"
        )
    found = checked(name, FIGURES, of_text(value, FIGURES, name, {}) if isinstance(value, str) else value)
    for each, others in NEEDS:
        if found[each] and not any(found[other] for other in others.split(" or ")):
            raise UsageError(f"{name}: {each} has no effect without {others}; add {others}, or leave {each} out")
    if None not in (found["low"], found["high"]) and not found["low"] < found["high"]:
        raise UsageError(f"{name}: 'low' {found['low']:g}; must be less than 'high' ({found['high']:g} full steps)")
    for stop, beyond in (("low", (found["low"] or 0) > 0), ("high", (found["high"] or 0) < 0)):
        if beyond:
            raise UsageError(
                f"{name}: {stop!r} {found[stop]:g} full steps; the motor begins at 0: allowed low <= 0 <= high"
            )
    mass, lead, efficiency, force, vertical = (found.pop(each) for each in AXIS)
    arm = lead / (2 * pi)  # m of the axis per rad
    found["inertia"] += mass * arm**2
    found["friction"] += force * arm / efficiency
    found["torque"] += mass * GRAVITY * arm if vertical else 0.0
    if found["stiction"] is not None and found["stiction"] < found["friction"]:
        raise UsageError(
            f"{name}: stiction {found['stiction']:g} N m; must be at least the friction ({found['friction']:g} N m)"
        )
    for stop in ("low", "high"):
        found[stop] = None if found[stop] is None else found[stop] * motor.step
    return LoadData(**found)


FAR = 10  # times the holding torque: a figure with a wrong unit is more likely than such a motor
REMEDY = "use a higher current, a stronger motor or a smaller load"


def check_holds(motor: MotorData, driver: DriverData, load: LoadData, name: str = "load") -> None:
    """Refuse a load that the motor cannot hold at rest, or cannot turn even slowly.

    Raises:
        UsageError: the motor cannot hold or turn the load; the message lists the torques.
    """
    stiction = load.friction if load.stiction is None else load.stiction
    for when, factor, wanted, how in (
        ("at rest", driver.rest, abs(load.torque) - stiction, f"{abs(load.torque):g} less {stiction:g} of stiction"),
        (
            "in motion",
            max(driver.slew, driver.ramp),
            abs(load.torque) + load.friction,
            f"{abs(load.torque):g} and {load.friction:g} of friction",
        ),
    ):
        current = driver.phase_current(motor) * factor
        most = motor.holding_torque(current)
        if wanted > most:
            raise UsageError(
                f"{name}: {wanted:.4g} N m {when} ({how}); the {motor.name} holds {most:.4g} N m at {current:.4g} A: "
                f"{'check the units of the load' if wanted > FAR * most else REMEDY}"
            )


load_complaint = complaint(lambda value, name: read_load(value, name, next(iter(MOTORS.values()))))
