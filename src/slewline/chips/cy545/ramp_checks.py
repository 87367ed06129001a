"""Lint rules for CY545 motions: whether R is reached; whether R is below F; whether each G has a direction.

The text is followed as the chip would run it, starting with the values after reset; each motion is checked with the
ramp that the chip would generate for it, at the rates of the sheet, whether inferred or given.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from ...core.datasheet.table import Sheet
from ...core.motion.plan import steps
from ...language.lint import Check
from ...language.statements import Source, Statement
from ..cy5xx.checks import Odd, judged
from . import profile
from .profile import Law

SECTION = "ch.5"
SETS = {"FIRSTRATE": "first", "RATE": "rate", "SLOPE": "slope", "NUMBER": "number", "ATPOSITION": "position"}
CHANGES: dict[str, dict[str, Any]] = {
    "CW": {"directed": True},
    "CCW": {"directed": True},
    "CONTINUOUS": {"continuous": True},
    "GO": {"position": None, "continuous": False},
    "HOME": {"position": 0, "directed": True},
}


class State(NamedTuple):
    """The registers, as far as the text of the program determines them; None for an unknown value."""

    first: int | None
    rate: int | None
    slope: int | None
    number: int | None
    position: int | None
    directed: bool = False  # True after +, - or P
    continuous: bool = False  # True after C, until the next motion

    def distance(self, statement: Statement) -> int | None:
        """Return the number of steps of a motion; None if it is not known."""
        if statement.row.name == "GO":
            return self.number
        target = value(statement)
        return None if self.position is None or target is None else abs(target - self.position)


def value(statement: Statement) -> int | None:
    """Return the first argument of a command; None if it is read from switches."""
    return None if statement.operands[0].label else statement.values[0]


def reset(sheet: Sheet) -> State:
    """Return the registers after reset."""
    values = {row.name: row.default for row in sheet.registers}
    return State(values["firstrate"], values["rate"], values["slope"], values["number"], values["position"])


def remarks(law: Law, hz: int, statement: Statement, state: State) -> Iterator[Odd]:
    """Yield the problems found in a motion."""
    name = statement.row.name
    if name not in ("GO", "POSITION"):
        return
    if name == "GO" and not state.directed:
        found = "G without + or - above it: after reset the direction is counter-clockwise (inferred), down from 0"
        yield Odd("no-direction", "note", found, "ch.10; ch.16, PULSE and CCW", "write + or - above it")
    distance = state.distance(statement)
    if name == "GO" and distance == 0 and not state.continuous:
        yield Odd("no-steps", "warning", "G with N 0 takes no step", "ch.4", "N of at least 1")
    first, rate, slope = state[:3]
    if first is not None and rate is not None and rate < first:
        found = f"R {rate} is below F {first}: the whole motion is made at F"
        yield Odd("rate-below-first", "warning", found, SECTION)
    if distance and not state.continuous and first is not None and rate is not None and slope is not None:
        yield from short(law, hz, distance, (first, rate, slope))


def short(law: Law, hz: int, distance: int, made: tuple[int, int, int]) -> Iterator[Odd]:
    """Yield a problem if the motion must decelerate before it has reached R."""
    ramp = steps(profile.ramp(*made, law))
    if distance <= 2 * ramp:
        top = min(interval for interval, _ in profile.move(distance, *made, law).runs)
        found = (
            f"R {made[1]} is not reached: each ramp takes {ramp} steps, but the move has {distance}; "
            f"it reaches rate {law.periods.index(top)}, {hz / top:.0f} steps/s"
        )
        yield Odd("short-move", "note", found, SECTION, f"{2 * ramp + 1} steps or more, or a larger S")


def after(statement: Statement, state: State) -> State:
    """Return the registers after a command, given those before it."""
    name = statement.row.name
    if name in SETS:
        register: dict[str, Any] = {SETS[name]: value(statement)}
        return state._replace(**register)
    if name == "POSITION":
        target = None if state.continuous else value(statement)
        return state._replace(position=target, directed=True, continuous=False)
    return state._replace(**CHANGES.get(name, {}))


def motions(sheet: Sheet) -> Check:
    """Return the rule that checks every motion, with the rates of a sheet."""
    law, begin = profile.law_of(sheet), reset(sheet)

    def step(statement: Statement, state: State) -> State:
        return begin if statement.row.name == "INITIALIZE" else after(statement, state)

    def judge(source: Source) -> None:
        judged(source, begin, lambda statement, state: remarks(law, sheet.crystal_hz, statement, state), step)

    return judge
