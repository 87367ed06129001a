"""Lint rules that apply to the CY500 only: the warnings in the magazine article about it (see sheet.py).

Each warning is reported at the command that it concerns.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from ...core.datasheet.table import Sheet
from ...core.motion.plan import steps
from ...language.lint import Check
from ...language.statements import Source, Statement
from ..cy5xx.checks import Odd, judged, written_for
from ..cy5xx.stepping.slope import Law
from .sheet import PERIODS

TURNS = ("CW", "CCW")


class State(NamedTuple):
    """The modes and registers after a command, as far as the text of the program determines them."""

    last: str = ""
    home: bool = False
    jog: bool = False
    absolute: bool = False  # True if P was sent after N
    rate: int | None = None
    slope: int = 0
    number: int | None = None


def remarks(statement: Statement, state: State) -> Iterator[Odd]:
    """Yield the article's warnings about a command."""
    name = statement.row.name
    if name == "ATHOME" and state.last in TURNS:
        found = "command A directly follows a change of direction"
        yield Odd("a-after-direction", "warning", found, "T.2 A", "a command in between")
    if name == "ATHOME" and state.home:
        yield Odd("a-twice", "warning", "command A is repeated with no RESET or I in between", "T.2 A")
    if name == "NUMBER" and state.last == "ATHOME":
        less = f"command N directly after A moves one step less: {statement.values[0] - 1}"
        yield Odd("n-after-a", "warning", less, "T.2 N", "any command between")
    if name == "FACTOR" and state.slope:
        yield Odd("factor-in-slope", "warning", "slopes force the factor to 1", "T.2 S", "send S 0 to end the slopes")
    if name == "TIL" and state.jog:
        yield Odd("til-and-jog", "warning", "command T is sent in jog mode; both T and jog mode use XSS", "T.2 J, T")
    if name == "GOSTEP" and state.jog:
        found = "command G is ignored in jog mode, in which XSS starts and stops the motor"
        yield Odd("go-in-jog", "warning", found, "T.2 J")
    elif name == "GOSTEP" and state.rate and state.number and not state.absolute:
        ramp = steps(Law(PERIODS).up(state.rate, state.slope))
        if state.number < 2 * ramp:
            found = f"N {state.number} is too short for slopes of {ramp} steps: the motion ends abruptly"
            yield Odd("short-slope", "warning", found, "T.2 S", f"at least {2 * ramp} steps")


def after(statement: Statement, state: State) -> State:
    """Return the state after a command."""
    value = statement.values[0] if statement.values else 0
    number = value - (state.last == "ATHOME")
    changes: dict[str, dict[str, Any]] = {
        "ATHOME": {"home": True},
        "INITIALIZE": {"home": False, "jog": False, "slope": 0},
        "JOG": {"jog": True},
        "NUMBER": {"number": number, "absolute": False},
        "POSITION": {"absolute": True},
        "RATE": {"rate": value},
        "SLOPE": {"slope": value},
    }
    return state._replace(last=statement.row.name, **changes.get(statement.row.name, {}))


def warnings(source: Source) -> None:
    """Step through the text of a program, and report the article's warnings."""
    judged(source, State(), remarks, after)


def checks(sheet: Sheet) -> tuple[Check, ...]:
    """Return this part's rules for `language.lint.lint`."""
    return (warnings, written_for)
