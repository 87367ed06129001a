"""Options of a chip or a part, as rows: checked once, and read by whoever shows or takes them.

Option("stepwise", "bool", False, "play every motion step by step; slow, and the same to the last edge")
Option("ramp_unit", "int", 452, "clocks that one rate unit takes", low=1, high=65535, unit="clocks", where="s.8")
Option("load", "table", {}, "what the motor drives", table=(Option("inertia", "float", 0.0, "...", unit="kg m2"), ...))
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from types import MappingProxyType
from typing import Any, Literal

from ..errors import SlewlineError, UsageError
from .timebase import picoseconds

Kind = Literal["bool", "int", "float", "time", "text", "choice", "ints", "table", "object"]
EXPECTED: Mapping[Kind, str] = MappingProxyType(
    {
        "bool": "True or False",
        "int": "a whole number",
        "float": "a number",
        "time": "a time such as '20 ms'",
        "text": "text",
        "ints": "whole numbers",
        "table": "a table",
    }
)


@dataclass(frozen=True, slots=True)
class Option:
    """An option that a chip or a part takes when it is made.

    `low` and `high` bound a number, a time (ps) and each of "ints"; `choices` are what a "choice" may be; `table` are
    the rows of a "table".  `check` says what else is wrong with a value, in words, or "".  An "object" is something
    that only Python can hand in (a function, a store).  `none`: None is allowed as well.
    """

    name: str
    kind: Kind
    default: Any
    says: str
    low: float | None = None
    high: float | None = None
    unit: str = ""
    choices: tuple[Any, ...] = ()
    table: tuple[Option, ...] = ()
    check: Callable[[Any], str] | None = None
    none: bool = False
    where: str = ""

    @property
    def allowed(self) -> str:
        """What the option may be, in words."""
        what = ", ".join(map(str, self.choices)) if self.choices else EXPECTED.get(self.kind, self.says)
        if self.table:
            what = f"a table of {', '.join(row.name for row in self.table)}"
        if self.low is not None or self.high is not None:
            what += f", {'' if self.low is None else f'{self.low:g}'}..{'' if self.high is None else f'{self.high:g}'}"
            what += f" {'ps' if self.kind == 'time' else self.unit}".rstrip()
        return what + " or None" * self.none

    def checked(self, owner: str, value: Any) -> Any:
        """Return a value that is allowed; of a table all of it, with what is left out.

        Raises:
            UsageError: it is not; the message says what is.
        """
        if value is None and self.none:
            return None
        if self.kind == "table":
            if not isinstance(value, Mapping):
                raise self._wrong(owner, value)
            return checked(f"{owner}: {self.name}", self.table, value) if self.table else dict(value)
        if self.kind == "ints":
            if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, (Sequence, set, frozenset)):
                raise self._wrong(owner, value)
            value = tuple(value)
        if not self._fits(value) or (self.check is not None and (why := self.check(value))):
            raise self._wrong(owner, value, why if self._fits(value) else "")
        return value

    def _fits(self, value: Any) -> bool:
        if self.kind == "bool":
            return isinstance(value, bool)
        if self.kind in ("text", "choice"):
            return (isinstance(value, str) or self.kind == "choice") and (not self.choices or value in self.choices)
        if self.kind == "object":
            return True
        if self.kind == "ints":
            return all(type(number) is int and self._within(number) for number in value)
        if self.kind == "time":
            try:
                return self._within(picoseconds(value))
            except (SlewlineError, TypeError, ValueError):
                return False
        return (
            isinstance(value, int if self.kind == "int" else (int, float))
            and not isinstance(value, bool)
            and self._within(value)
        )

    def _within(self, number: float) -> bool:
        return (self.low is None or number >= self.low) and (self.high is None or number <= self.high)

    def _wrong(self, owner: str, value: Any, why: str = "") -> UsageError:
        return UsageError(f"{owner}: {self.name} {value!r}; {why or f'allowed {self.allowed}'}")


def checked(owner: str, rows: Iterable[Option], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return every option of some rows: what is given, checked, and the defaults of the others.

    Raises:
        UsageError: an option that there is not, or a value that is not allowed.
    """
    known = {row.name: row for row in rows}
    for name in given:
        if name not in known:
            near = get_close_matches(str(name), known, 1)
            hint = f"; did you mean {near[0]}?" if near else ""
            raise UsageError(f"{owner}: no option {name!r}; options: {', '.join(known) or 'none'}{hint}")
    return {name: row.checked(owner, given[name]) if name in given else row.default for name, row in known.items()}
