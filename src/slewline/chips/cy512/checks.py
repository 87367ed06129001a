"""Lint rules that apply to the CY512 only: factors after a slope, and moves too short for their ramps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from ...core.datasheet.table import Sheet
from ...core.motion.plan import steps
from ...language.lint import Check
from ...language.statements import Source, Statement
from ..cy5xx.checks import Odd, judged, written_for
from .profile import LAW


class State(NamedTuple):
    """The registers after a command, as far as the text of the program determines them."""

    rate: int | None = None
    slope: int = 0
    number: int | None = None
    position: int | None = None


def remarks(statement: Statement, state: State) -> Iterator[Odd]:
    """Yield the problems found in a command."""
    name = statement.row.name
    if name == "FACTOR" and state.slope:
        yield Odd("factor-in-slope", "warning", "F after S divides the rates of the ramps, too", "s.3 F")
    if name == "POSITION":
        distance = None if state.position is None else abs(statement.values[0] - state.position)
    else:
        distance = state.number if name == "GO" else None
    if distance and state.rate:
        ramp = steps(LAW.up(state.rate, state.slope))
        if distance < 2 * ramp:
            found = f"{distance} steps are too few for two ramps of {ramp}: the whole move is made at R {LAW.start}"
            yield Odd("short-move", "note", found, "s.3, comparison, item 10", f"at least {2 * ramp} steps")


def after(statement: Statement, state: State) -> State:
    """Return the registers after a command."""
    value = statement.values[0] if statement.values else 0
    changes: dict[str, dict[str, Any]] = {
        "ATHOME": {"position": 0},
        "GO": {"position": None},
        "NUMBER": {"number": value},
        "POSITION": {"position": value},
        "RATE": {"rate": value},
        "SLOPE": {"slope": value},
    }
    return state._replace(**changes.get(statement.row.name, {}))


def ramps(source: Source) -> None:
    """Step through the text of a program, and check its ramps."""
    judged(source, State(), remarks, after)


def checks(sheet: Sheet) -> tuple[Check, ...]:
    """Return this part's rules for `language.lint.lint`."""
    return (ramps, written_for)
