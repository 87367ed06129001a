"""Possible deviations from the data sheets, as rows; each row changes properties of motor, driver and load."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from ..core.messages.near import hint
from ..errors import UnknownName, UsageError
from ..parts.motors.motor_data import DriverData, LoadData, MotorData

System: TypeAlias = tuple[MotorData, DriverData, LoadData]


# ----------------------------------------------------------------------------------------------------------- changes
def load(system: System, factor: float) -> System:
    """Return a system whose load torque is multiplied by a factor."""
    motor, driver, load = system
    return motor, driver, replace(load, torque=load.torque * factor)


def inertia(system: System, factor: float) -> System:
    """Return a system whose rotor and load inertias are multiplied by a factor."""
    motor, driver, load = system
    return replace(motor, inertia=motor.inertia * factor), driver, replace(load, inertia=load.inertia * factor)


def supply(system: System, factor: float) -> System:
    """Return a system whose driver supply (or both supplies, if there are two) is multiplied by a factor."""
    motor, driver, load = system
    return motor, replace(driver, supply=driver.supply * factor, high=driver.high * factor), load


def current(system: System, factor: float) -> System:
    """Return a system whose current is multiplied by a factor; if resistors set it, their value is changed."""
    motor, driver, load = system
    if driver.kind in ("voltage", "bilevel"):
        series = (motor.resistance + driver.series) / factor - motor.resistance
        return motor, replace(driver, series=max(series, 0.0)), load
    return motor, replace(driver, current=driver.current * factor), load


def friction(system: System, factor: float) -> System:
    """Return a system in which the friction and stiction of motor and load are multiplied by a factor."""
    motor, driver, load = system
    stiction = None if load.stiction is None else load.stiction * factor
    loaded = replace(load, friction=load.friction * factor, stiction=stiction)
    return replace(motor, friction=motor.friction * factor), driver, loaded


def drag(system: System, factor: float) -> System:
    """Return a system with the viscous drag of motor and load scaled by a factor; below 1, it is less damped."""
    motor, driver, load = system
    iron = (motor.drag - motor.viscous) * factor
    less = replace(motor, iron=iron, viscous=motor.viscous * factor)
    return less, driver, replace(load, viscous=load.viscous * factor)


CHANGES: dict[str, Callable[[System, float], System]] = {
    "load": load,
    "inertia": inertia,
    "supply": supply,
    "current": current,
    "friction": friction,
    "drag": drag,
}


# -------------------------------------------------------------------------------------------------------------- rows
@dataclass(frozen=True, slots=True)
class Perturbation:
    """Changes to a system (motor, driver, load) that are applied together, as pairs (quantity, factor)."""

    name: str
    changes: tuple[tuple[str, float], ...] = ()

    def of(self, system: System) -> System:
        """Return a system to which these changes have been applied."""
        for what, factor in self.changes:
            system = CHANGES[what](system, factor)
        return system


def alone(what: str, percent: float) -> Perturbation:
    """Return a perturbation that changes a single quantity by a given percentage."""
    return Perturbation(f"{what} {percent:+g} %", ((what, 1 + percent / 100),))


NOMINAL = Perturbation("nominal")
WORST = tuple((what, 1 + percent / 100) for what, percent in {
    "load": 20, "inertia": 20, "supply": -10, "current": -20, "friction": 25, "drag": -30,
}.items())  # fmt: skip
USUAL = (  # tried first while no counts are known: the perturbations that caused most step losses in trials
    Perturbation("worst case", WORST),
    alone("current", -20),
    alone("inertia", 20),
    alone("supply", -10),
    NOMINAL,
    alone("load", 20),
    alone("load", -20),
    alone("inertia", -20),
    alone("friction", 25),
    alone("drag", -30),
)
_ITEM = re.compile(r"\s*([A-Za-z]+)\s*(±|\+-|\+/-|[+-])?\s*(\d+(?:\.\d+)?)\s*%\s*")
EXAMPLE = 'such as "load 20%, supply -10%" (without a sign: both up and down), or "none"'


def read_perturbations(given: str | Iterable[Perturbation] | None) -> tuple[Perturbation, ...]:
    """Return the perturbations that a user selects; they always include the nominal row, which changes nothing.

    For None, return the usual rows (`USUAL`).

    Raises:
        UnknownName: a quantity does not exist.
        UsageError: the text does not have the form "load 20%, supply -10%", or a reduction is 100 % or more.
    """
    if given is None:
        return USUAL
    if not isinstance(given, str):
        rows = tuple(given)
        return rows if NOMINAL in rows else (*rows, NOMINAL)
    if given.strip().lower() in ("none", ""):
        return (NOMINAL,)
    found: dict[str, Perturbation] = {}
    for item in given.split(","):
        for row in _rows(item):
            found[row.name] = row
    bad = {row.changes[0] for row in found.values()} & {*WORST}
    together = (Perturbation("worst case", tuple(each for each in WORST if each in bad)),) * (len(bad) > 1)
    return (*together, *found.values(), NOMINAL)


def _rows(item: str) -> Iterator[Perturbation]:
    match = _ITEM.fullmatch(item)
    if match is None:
        raise UsageError(f"perturbation {item.strip()!r}; expected a quantity and a percentage, {EXAMPLE}")
    what, sign, percent = match[1].lower(), match[2], float(match[3])
    if what not in CHANGES:
        raise UnknownName(f"perturbation {what!r}; known: {', '.join(CHANGES)}{hint(what, CHANGES)}")
    for factor in (1, -1) if sign not in ("+", "-") else (1 if sign == "+" else -1,):
        if factor * percent <= -100:
            raise UsageError(f"perturbation {item.strip()!r}; allowed reductions of less than 100 %")
        yield alone(what, factor * percent)


# --------------------------------------------------------------------------------------------------------- scenarios
@dataclass(frozen=True, slots=True)
class Scenario:
    """A condition under which a candidate is judged; `first` is the commanded step at which the move begins."""

    name: str
    motor: MotorData
    driver: DriverData
    load: LoadData
    stepping: str
    step_ps: int
    direction: int = 1
    first: int = 0
    nominal: bool = False


def scenarios(
    system: System, rows: Sequence[Perturbation], stepping: str, step_ps: int, suffix: str = ""
) -> tuple[Scenario, ...]:
    """Return scenarios for all rows, in both directions; of rows with the same effect, only one is used.

    For half steps, there are further scenarios in which the move begins at an odd step.

    Args:
        suffix: a suffix for the names of all scenarios.
    """
    found = []
    seen: list[System] = []
    for row in sorted(rows, key=lambda row: bool(row.changes)):  # scenarios equal to the nominal one are omitted
        changed = row.of(system)
        if changed not in seen:
            seen.append(changed)
            found.append(row)
    starts = ((0, ""), (1, ", from an odd step")) if stepping == "half" else ((0, ""),)
    return tuple(
        Scenario(
            f"{row.name}, {direction_name}{odd}{suffix}",
            *row.of(system),
            stepping,
            step_ps,
            direction,
            first,
            not row.changes,
        )
        for row in sorted(found, key=rows.index)
        for direction, direction_name in ((1, "forward"), (-1, "backward"))
        for first, odd in starts
    )
