"""Motors on the market, from their data sheets; and user-defined motors, by name, as text, or as a table of figures.

motor = "QSH4218-51-10-049"
motor = "current 2 A, resistance 1.4 ohm, inductance 3 mH, holding torque 0.44 Nm, inertia 57 g cm2"
motor = "like QSH4218-51-10-049, inertia 80 g cm2"
motor = { like = "QSH4218-51-10-049", inertia = "80 g cm2" }
motor = { current = 2.8, resistance = 0.9, inductance = "2.5 mH", torque = "1.26 Nm", inertia = "300 g cm2" }
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, replace
from types import MappingProxyType
from typing import Any

from ...core.datasheet.option import Option, checked, defaulted
from ...core.datasheet.units import measured
from ...core.messages.near import same_part
from ...errors import UnknownName, UsageError
from .motor_data import IRON_S, MotorData
from .motor_figures import complaint, figure, of_text, positive

QSH4218 = "Trinamic, QSH4218 manual, V1.10"
QSH5718 = "Trinamic, QSH5718 manual, V2.6"
QSH6018 = "Trinamic, QSH6018 manual, V1.20; without detent torque"
AS1000 = "Beckhoff, AS1000 documentation, 3.7; the detent torque is the middle of its range"
SANYO = "Sanyo Denki, Sanmotion sheet of the SS242; without detent torque"
COPIES = "vendors' copies of a sheet by an unknown maker"
KYSAN = "Kysan: windings and torque from StepperSim; inertia of motors of this size"
LISTED = "public tables of motors, not the maker's sheet; without detent torque"


def _motor(
    name: str, current: float, resistance: float, inductance: float, torque: float, detent: float, inertia: float,
    source: str,
) -> MotorData:  # fmt: skip
    return MotorData(
        name=name,
        current=current,
        resistance=resistance,
        inductance=inductance,
        torque=torque,
        detent=detent,
        inertia=inertia,
        source=source,
    )


# fmt: off
_ROWS = (  # hybrid motors with 200 full steps per revolution, holding torque with two phases on
    #                           A     ohm   H        N m    N m     kg m2
    _motor("QSH4218-35-10-027", 1.0,  5.3,  6.6e-3,  0.27,  22e-3,  35e-7,   QSH4218),
    _motor("QSH4218-41-10-035", 1.0,  4.5,  7.5e-3,  0.35,  25e-3,  54e-7,   QSH4218),
    _motor("QSH4218-51-10-049", 1.0,  5.0,  8.0e-3,  0.49,  28e-3,  68e-7,   QSH4218),
    _motor("QSH4218-47-28-040", 2.8,  0.5,  0.6e-3,  0.40,  20e-3,  68e-7,   f"{QSH4218}; detent torque estimated"),
    _motor("QSH5718-41-28-055", 2.8,  0.7,  1.4e-3,  0.55,  20e-3,  120e-7,  QSH5718),
    _motor("QSH5718-51-28-101", 2.8,  0.83, 2.2e-3,  1.01,  35e-3,  275e-7,  QSH5718),
    _motor("QSH5718-56-28-126", 2.8,  0.9,  2.5e-3,  1.26,  39e-3,  300e-7,  QSH5718),
    _motor("QSH5718-76-28-189", 2.8,  1.13, 3.6e-3,  1.89,  66e-3,  480e-7,  QSH5718),
    _motor("QSH6018-45-28-110", 2.8,  0.75, 2.0e-3,  1.10,  0.0,    275e-7,  QSH6018),
    _motor("QSH6018-56-28-165", 2.8,  0.9,  3.6e-3,  1.65,  0.0,    400e-7,  QSH6018),
    _motor("QSH6018-65-28-210", 2.8,  1.2,  4.6e-3,  2.10,  0.0,    570e-7,  QSH6018),
    _motor("QSH6018-86-28-310", 2.8,  1.5,  6.8e-3,  3.10,  0.0,    840e-7,  QSH6018),
    _motor("AS1010",            1.0,  4.1,  9.5e-3,  0.38,  15e-3,  56e-7,   AS1000),
    _motor("AS1030",            1.5,  0.8,  3.8e-3,  0.60,  30.5e-3, 210e-7, AS1000),
    _motor("AS1050",            5.0,  0.28, 0.86e-3, 1.20,  52e-3,  360e-7,  AS1000),
    _motor("AS1060",            5.0,  0.36, 2.8e-3,  5.00,  181e-3, 3000e-7, AS1000),
    _motor("SS2421-5041",       1.0,  3.5,  1.2e-3,  0.083, 0.0,    15e-7,   SANYO),
    _motor("SS2422-5041",       1.0,  5.4,  2.9e-3,  0.186, 0.0,    28e-7,   SANYO),
    _motor("1124090",           1.5,  2.8,  4.8e-3,  0.54,  0.0,    68e-7,   KYSAN),
    _motor("17HS4401",          1.7,  1.5,  2.8e-3,  0.42,  22e-3,  54e-7,   COPIES),
    _motor("17HS19-2004S1",     2.0,  1.4,  3.0e-3,  0.59,  0.0,    82e-7,   f"StepperOnline: {LISTED}"),
    _motor("17HS24-2104S",      2.1,  1.6,  3.0e-3,  0.65,  0.0,    148e-7,  f"StepperOnline: {LISTED}"),
    _motor("42STH47-1684AC",    1.68, 1.65, 2.8e-3,  0.49,  0.0,    68e-7,   f"LDO: {LISTED}"),
)
# fmt: on
MOTORS: Mapping[str, MotorData] = MappingProxyType({row.name: row for row in _ROWS})

FIGURES = (  # figures of a table, in the order of MotorData
    Option("name", "text", "own motor", "name of the motor", like="'my motor'"),
    Option("windings", "choice", "bipolar", "type of windings", choices=("bipolar", "unipolar", "reluctance")),
    Option("teeth", "int", 50, "pole pairs; 50 make 200 full steps per revolution", low=1),
    Option("phases", "int", 4, "windings of a reluctance motor", low=3),
    positive("current", "A", "rated current of a phase"),
    positive("resistance", "ohm", "resistance of a phase"),
    positive("inductance", "H", "inductance of a phase; for a reluctance motor, its mean"),
    figure("swing", "H", "amplitude of the inductance of a reluctance motor around its mean"),
    figure("torque", "N m", "holding torque at the rated current"),
    Option("rated", "choice", "two", "number of phases on at the holding torque", choices=("two", "one")),
    figure("detent", "N m", "detent torque, without current"),
    positive("inertia", "kg m2", "inertia of the rotor"),
    figure("iron", "N m s", "drag by iron loss; None: 2.66e-3 s times the holding torque", None),
    figure("viscous", "N m s", "bearing drag"),
    figure("friction", "N m", "Coulomb friction of bearings and seals"),
    Option("source", "text", "own figures", "source of the figures", like="'data sheet, 2012'"),
)


EXAMPLE = "current 2 A, resistance 1.4 ohm, inductance 3 mH, holding torque 0.44 Nm, inertia 57 g cm2"
OWN = f"use the figures of its data sheet: '{EXAMPLE}'"
SPELLED: Mapping[str, str] = MappingProxyType(  # names of the figures on data sheets
    {
        "holding torque": "torque", "detent torque": "detent", "rated current": "current", "phase current": "current",
        "phase resistance": "resistance", "phase inductance": "inductance", "rotor inertia": "inertia",
        "iron loss": "iron", "step angle": "step_angle", "bipolar": "windings bipolar", "unipolar": "windings unipolar",
        "reluctance": "windings reluctance",
    }
)  # fmt: skip
BESIDE = ("like", "step_angle")
NEEDED = ("current", "resistance", "inductance", "torque", "inertia")
ASSUMED: Mapping[str, str] = MappingProxyType(  # for a user-defined motor, the default for a figure that is left out
    {
        "windings": "bipolar windings",
        "teeth": "200 full steps per revolution (step angle 1.8 deg)",
        "rated": "holding torque with two phases on",
        "detent": "no detent torque",
        "iron": f"iron loss {IRON_S * 1e3:g} ms times the holding torque",
        "viscous": "no bearing drag",
        "friction": "no bearing friction",
    }
)


def motor_named(name: str, place: str = "motor") -> MotorData:
    """Return the data of the motor with the given name.

    Raises:
        UnknownName: no motor has this name.
    """
    if name not in MOTORS:
        meant = same_part(name, MOTORS) or f"; for another motor {OWN}"
        raise UnknownName(f"{place} {name!r}; known: {', '.join(MOTORS)}{meant}")
    return MOTORS[name]


def is_described(text: str) -> bool:
    """Return whether a text contains the figures of a motor, rather than a name."""
    words = (*(row.name for row in FIGURES), *SPELLED, *BESIDE)
    return text not in MOTORS and ("," in text or any(re.match(rf"\s*{each}[ =:]", text, re.I) for each in words))


def motor_table(value: str | Mapping[str, Any], name: str = "motor") -> dict[str, Any]:
    """Return the table of figures for a motor described by text or by a table.

    Raises:
        UsageError: the text is not understood, a figure occurs twice, or the step angle is not allowed.
    """
    given = of_text(value, FIGURES, name, SPELLED, BESIDE) if isinstance(value, str) else {**value}
    if given.get("step_angle") is not None and "teeth" in given:
        raise UsageError(f"{name}: step_angle and teeth both set the full steps per revolution; leave one out")
    if "step_angle" in given and given.get("windings") == "reluctance":
        raise UsageError(f"{name}: step_angle does not apply to a reluctance motor; set teeth and phases instead")
    if "step_angle" in given:
        given["teeth"] = _teeth(given.pop("step_angle"), name)
    return given


def _teeth(angle: Any, name: str) -> int:
    """Return the number of pole pairs for a step angle, with four full steps per pole pair."""
    try:
        teeth = 90 / measured(angle, "deg")
    except (ValueError, ZeroDivisionError):
        teeth = 0.0
    if not 1 <= teeth <= 1000 or abs(teeth - round(teeth)) > 1e-3 * teeth:
        raise UsageError(f"{name}: step_angle {angle!r}; expected 90 deg divided by a whole number, such as 1.8 deg")
    return round(teeth)


def read_motor(value: Any, name: str = "motor") -> MotorData:
    """Return a motor described by its name, by its figures as text, or by a table of figures.

    Text and table may name a motor with `like`; their other figures then replace those of the named motor.

    Args:
        name: the motor's name in messages.

    Raises:
        UnknownName: no motor has this name.
        UsageError: a figure is unknown, missing, or out of range.
    """
    if isinstance(value, MotorData):
        return value
    if isinstance(value, str) and not is_described(value):
        return motor_named(value, name)
    if not isinstance(value, (str, Mapping)):
        table = ", ".join((*BESIDE, *(row.name for row in FIGURES)))
        raise UsageError(
            f"{name} {value!r}; expected the name of a motor, text such as '{EXAMPLE}', or a table (keys: {table})"
        )
    given, rows = motor_table(value, name), [*FIGURES]
    if "like" in given:
        like = _named_like(given.pop("like"), name)
        changed = f"{like.source}; changed: {', '.join(given)}" if given else like.source
        rows = [*defaulted(rows, asdict(replace(like, name=f"like {like.name}", source=changed)))]
    else:
        _check_whole(given, name)
    return _consistent(MotorData(**checked(name, rows, given, beside=f", {', '.join(BESIDE)}")), name)


def assumptions(value: Any) -> tuple[str, ...]:
    """Return, in words, the assumptions for figures that a user has left out; an empty tuple for a named motor.

    Args:
        value: the motor, as passed to `read_motor`.
    """
    if not isinstance(value, (str, Mapping)) or (isinstance(value, str) and not is_described(value)):
        return ()
    given = motor_table(value)
    if "like" in given:
        return ()
    magnetic = ("windings", "teeth", "rated", "iron") if given.get("windings") == "reluctance" else ()
    return tuple(note for figure, note in ASSUMED.items() if given.get(figure) is None and figure not in magnetic)


def _check_whole(given: Mapping[str, Any], name: str) -> None:
    """Refuse a motor with missing figures, and name all missing figures."""
    reluctance = given.get("windings") == "reluctance"
    needed = [each.replace("torque", "swing") if reluctance else each for each in NEEDED]
    rows = {row.name: row for row in FIGURES}
    missing = [each for each in needed if given.get(each) is None]
    if missing and all(each in rows for each in given):
        missing_figures = ", ".join(f"{each} ({rows[each].unit}: {rows[each].description})" for each in missing)
        raise UsageError(
            f"{name} needs {missing_figures}; write, for example, '{EXAMPLE}', or add 'like' and the name of a motor"
        )


def _named_like(like: object, name: str) -> MotorData:
    if not isinstance(like, str):
        raise UsageError(f"{name}: 'like' is {like!r}; expected the name of a motor, such as {next(iter(MOTORS))}")
    return motor_named(like, f"{name}: 'like' is")


def _consistent(motor: MotorData, name: str) -> MotorData:
    """Return a motor after checking that its figures are consistent."""
    if motor.windings == "reluctance":
        if not 0 < motor.swing < motor.inductance:
            raise UsageError(
                f"{name}: swing {motor.swing:g} H of a reluctance motor; must be more than 0 and less than the "
                f"inductance ({motor.inductance:g} H)"
            )
        return motor
    if motor.swing:
        raise UsageError(f"{name}: swing {motor.swing:g} H; only a reluctance motor has a swing: leave it out")
    if not motor.torque > motor.detent:
        raise UsageError(
            f"{name}: torque {motor.torque:g} N m; must be more than the detent torque ({motor.detent:g} N m): "
            "give the holding torque at the rated current"
        )
    return motor


motor_complaint = complaint(read_motor)
