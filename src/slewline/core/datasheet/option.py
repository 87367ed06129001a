"""Options of a chip or a part, as rows: checked once, and used by all code that shows or accepts them.

Option("stepwise", "bool", False, "play every motion step by step; slow, and the same to the last edge")
Option("ramp_unit", "int", 452, "clocks that one rate unit takes", low=1, high=65535, unit="clocks", where="s.8")
Option("load", "table", {}, "what the motor drives", table=(Option("inertia", "float", 0.0, "...", unit="kg m2"), ...))

The rows of a chip are in its sheet, and the rows of a part in its class; `checked` returns the values of
all rows to the constructor.  Text, from a URL or a command line, is first converted to a value by the
method `read` of the row.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from numbers import Integral
from types import MappingProxyType
from typing import Any, Literal

from ...errors import SlewlineError, UsageError
from ..messages.former_names import formerly
from ..messages.near import hint
from ..time.timebase import hertz, picoseconds, readable
from .units import expected, measured, other_kind

Kind = Literal[
    "bool",
    "int",
    "float",
    "number",
    "time",
    "frequency",
    "quantity",
    "text",
    "choice",
    "ints",
    "bytes",
    "table",
    "object",
]
EXPECTED: Mapping[Kind, str] = MappingProxyType(
    {
        "bool": "True, False",
        "int": "a whole number",
        "float": "a number",
        "number": "a number",
        "time": "a time",
        "frequency": "a frequency",
        "quantity": "a number",
        "text": "text",
        "ints": "whole numbers",
        "bytes": "text, bytes, or whole numbers from 0 to 255",
        "table": "a table",
        "object": "a Python object",
    }
)


SHOWN = 80  # longest value in a message, characters; a longer one is shown by its start and the wrong number
LIKE: Mapping[Kind, str] = MappingProxyType({"number": "9600 or '37.5'", "time": "'20 ms'", "frequency": "'11 MHz'"})


def _many(value: Any) -> bool:
    return isinstance(value, (Sequence, set, frozenset)) and not isinstance(value, (str, bytes, bytearray))


def _whole(value: Any) -> bool:
    return isinstance(value, Integral) and not isinstance(value, bool)


FITS: Mapping[Kind, Callable[[Any], bool]] = MappingProxyType(  # checks of the kind of a value, not of its range
    {
        "bool": lambda value: isinstance(value, bool),
        "int": _whole,
        "float": lambda value: _whole(value) or (isinstance(value, float) and abs(value) < float("inf")),
        "number": lambda value: _whole(value) or isinstance(value, (str, Fraction)),
        "time": lambda value: isinstance(value, str) or _whole(value),
        "frequency": lambda value: _whole(value) or isinstance(value, str),
        "quantity": lambda value: _whole(value) or isinstance(value, (str, float)),
        "text": lambda value: isinstance(value, str),
        "ints": lambda value: _many(value) and all(map(_whole, value)),
        "bytes": lambda value: (
            isinstance(value, (str, bytes, bytearray))
            or (_many(value) and all(_whole(byte) and 0 <= byte <= 255 for byte in value))
        ),
        "object": lambda _: True,
    }
)
SIZES: Mapping[Kind, Callable[[Any], Any]] = MappingProxyType(  # the number that the range limits
    {"number": Fraction, "time": picoseconds, "frequency": hertz}
)


def _read_int(text: str) -> int:
    return int(text, 16 if text.lower().startswith("0x") else 10)


def _read_time(text: str) -> str | int:
    return int(text) if text.isdecimal() else text


READ: Mapping[Kind, Callable[[str], Any]] = MappingProxyType(
    {
        "bool": lambda text: {"true": True, "false": False}[text.lower()],
        "int": _read_int,
        "float": float,
        "time": _read_time,
        "frequency": _read_time,
        "ints": lambda text: tuple(_read_int(number.strip()) for number in text.split(",") if number.strip()),
    }
)


@formerly(description="says")
@dataclass(frozen=True, slots=True)
class Option:
    """An option with which a chip or a part is created.

    Attributes:
        name: the name.
        kind: the kind of value.  Simple kinds are "bool", "int", "float", "time" (ps), "frequency" (Hz),
            "ints", "text" and "bytes".  A "choice" is one of `choices`, or its text.  A "table" has the rows
            in `table`.  A "number" is exact: a whole number, or a decimal as text.  A "quantity" is a number
            in `unit`, or text such as "68 g cm2", and becomes a float.  An "object" is one of `choices`, or
            an object that only Python can pass, such as a function or a store.
        default: the value used if none is given; ... (Ellipsis) if the option is required.
        description: text that describes the effect of the option.
        low: the minimum: of a number, a time in ps, a frequency in Hz, or each of "ints"; None for no limit.
        high: the maximum, for the same kinds as `low`; None for no limit.
        unit: the unit of the value; for a "quantity" an SI unit.
        choices: the allowed values.
        table: the rows of a "table", each of which is an option.
        check: a function that takes a value of the right kind and range, and returns text
            that describes its fault; "" if it has none.
        none: True if None is also allowed.
        like: an example value, for a "text" or an "object".
        where: the section of the manual.
    """

    name: str
    kind: Kind
    default: Any
    description: str
    low: float | None = None
    high: float | None = None
    unit: str = ""
    choices: tuple[Any, ...] = ()
    table: tuple[Option, ...] = ()
    check: Callable[[Any], str] | None = None
    none: bool = False
    like: str = ""
    where: str = ""

    @property
    def required(self) -> bool:
        """True if the option has no default."""
        return self.default is ...

    @property
    def allowed(self) -> str:
        """Text that describes the allowed values."""
        words = [*map(str, self.choices)]
        if not self.choices or self.kind == "object":
            words.append(self._expected)
        return ", ".join(words + ["None"] * self.none)

    @property
    def _expected(self) -> str:
        if self.table:
            return f"a table of {', '.join(row.name for row in self.table)}"
        bounded = self.low is not None or self.high is not None
        what = self._range if bounded else f"{EXPECTED[self.kind]}{f' ({self.unit})' if self.unit else ''}"
        if bounded and self.kind == "ints":
            what = f"whole numbers, each {what}"
        if self.kind == "quantity":
            return expected(self.unit, what)
        like = self.like or LIKE.get(self.kind)
        return f"{what}{',' if bounded else ''} such as {like}" if like else what

    @property
    def _range(self) -> str:
        low, high = (None if bound is None else self._spelled(bound) for bound in (self.low, self.high))
        if self.kind == "time" and self.low == 1 and high is None:
            return "more than 0"
        bounds = f"{low}..{high}" if low and high else f"{low} or more" if low else f"up to {high}"
        return f"{bounds} {self.unit}".rstrip()

    def _spelled(self, value: Any) -> str:
        if self.kind == "time" and _whole(value):
            return readable(value)
        return f"{value:g}" if isinstance(value, float) else str(value)

    @property
    def shown(self) -> str:
        """The default as text; "" if the option is required, or is a table or object with an empty or None default."""
        if self.required:
            return ""
        if self.kind == "time" and _whole(self.default):
            return readable(self.default) if self.default else "0"
        return "" if self.kind in ("table", "object") and not self.default else repr(self.default)

    def checked(self, owner: str, value: Any) -> Any:
        """Check a value, and return it in its final type; rows that a table lacks are added with their defaults.

        Raises:
            UsageError: the value is not allowed; the message states the reason, or the allowed values.
        """
        if value is None and self.none:
            return None
        if self.kind == "table" and isinstance(value, Mapping):
            return checked(f"{owner}: {self.name}", self.table, value)
        if _whole(value) or isinstance(value, str):  # types that may name a choice
            for choice in self.choices:
                if str(choice) == str(value):
                    return choice
        why = self._wrong(value)
        if why is not None:
            meant = self.read(value) if isinstance(value, str) else value
            plain = f"; write {meant}, without quotes" if type(meant) is int and self._wrong(meant) is None else ""
            raise UsageError(f"{owner}: {self.name} {_cut(value)}; {why or f'allowed {self.allowed}'}{plain}")
        if self.kind == "ints":
            return tuple(map(int, sorted(value) if isinstance(value, (set, frozenset)) else value))
        if self.kind == "quantity":
            return measured(value, self.unit)
        return int(value) if _whole(value) else value

    def _wrong(self, value: Any) -> str | None:
        """Return the reason why a value is refused; None if the value is allowed.

        The reason is "" if a message only needs to list the allowed values.
        """
        if self.kind == "ints" and isinstance(value, (list, tuple)) and len(repr(value)) > SHOWN:
            odd = next((k for k, each in enumerate(value) if not _whole(each) or not self._within(each)), None)
            if odd is not None:
                return f"{value[odd]!r} at {odd}; allowed {self.allowed}"
        if self.kind not in FITS or (self.choices and self.kind != "object") or not FITS[self.kind](value):
            return ""
        if self.low is not None or self.high is not None or self.kind in SIZES or self.kind == "quantity":
            try:
                value = measured(value, self.unit) if self.kind == "quantity" else value
                sizes = value if self.kind == "ints" else [SIZES.get(self.kind, _same)(value)]
            except SlewlineError as error:
                return str(error)
            except (ValueError, ZeroDivisionError):
                other = other_kind(value, self.unit) if self.kind == "quantity" else ""
                return f"{other}allowed {self.allowed}" if other else ""
            if not all(self._within(size) for size in sizes):
                return ""
        return (self.check(value) or None) if self.check is not None else None

    def _within(self, size: Any) -> bool:
        return (self.low is None or size >= self.low) and (self.high is None or size <= self.high)

    def read(self, text: str) -> Any:
        """Return the value that a text represents; return invalid text unchanged, which `checked` then refuses."""
        if self.none and text.lower() == "none":
            return None
        value: Callable[[str], Any] = READ.get(self.kind, _same)
        try:
            return value(text)
        except (KeyError, ValueError):
            return text

    def data(self) -> dict[str, Any]:
        """Return the row as plain data for other programs, without `check` and `like`."""
        plain = None if self.required or (self.kind in ("table", "object") and not self.default) else self.default
        return {
            "name": self.name,
            "kind": self.kind,
            "default": list(plain) if isinstance(plain, (bytes, tuple)) else plain,
            "required": self.required,
            "says": self.description,
            "low": self.low,
            "high": self.high,
            "unit": self.unit,
            "choices": list(self.choices),
            "table": [row.data() for row in self.table],
            "none": self.none,
            "where": self.where,
        }


def _cut(value: Any) -> str:
    """Return the text of a value for a message; text longer than SHOWN characters is cut off."""
    text = repr(value)
    return text if len(text) <= SHOWN else f"{text[:SHOWN]} ..."


def _same(value: Any) -> Any:
    return value


def nowhere(_name: str, _value: object) -> str:
    """Return "", which means that a setting cannot be made in any other way (see `elsewhere` in `checked`)."""
    return ""


def checked(
    owner: str,
    rows: Iterable[Option],
    given: Mapping[str, Any],
    beside: str = "",
    elsewhere: Callable[[str, object], str] = nowhere,
) -> dict[str, Any]:
    """Return the values of all rows: the given ones, checked, and the defaults of the others.

    Args:
        beside: text that lists further allowed arguments, for the message about an unknown option.
        elsewhere: a function that takes a name that is not an option, and the value for it, and returns
            text on how else to set it; "" if it cannot be set.

    Raises:
        UsageError: an option that does not exist, a value that is not allowed, or a required option that is
            missing.
    """
    known = {row.name: row for row in rows}
    for name in given:
        if name not in known:
            if otherwise := elsewhere(name, given[name]):
                raise UsageError(f"{owner}: no option {name!r}: {otherwise}")
            allowed = ", ".join(known) or "none"
            within = {row.name: f"{table.name}.{row.name}" for table in known.values() for row in table.table}
            meant = f"; did you mean {within[name]}?" if name in within else hint(name, known)
            raise UsageError(f"{owner}: no option {name!r}; its options: {allowed}{beside}{meant}")
    found = {}
    for name, row in known.items():
        if name not in given and row.required:
            raise UsageError(f"{owner} needs the option {name}: {row.allowed}")
        is_default = name not in given and row.kind != "table"
        found[name] = row.default if is_default else row.checked(owner, given.get(name, row.default))
    return found


def read(rows: Iterable[Option], pairs: Iterable[tuple[str, str]]) -> dict[str, Any]:
    """Return the options given as (name, text): ("stepwise", "true") or, in a table, ("load.inertia", "2e-5").

    Texts for unknown names, and texts that are not valid, are returned unchanged; `checked` refuses them.
    """
    known = {row.name: row for row in rows}
    found: dict[str, Any] = {}
    tables: dict[str, list[tuple[str, str]]] = {}
    for name, text in pairs:
        table, dot, rest = name.partition(".")
        if dot and table in known and known[table].table:
            tables.setdefault(table, []).append((rest, text))
        else:
            found[name] = known[name].read(text) if name in known else text
    return {name: read(known[name].table, within) for name, within in tables.items()} | found


def defaulted(rows: Iterable[Option], given: Mapping[str, Any]) -> tuple[Option, ...]:
    """Return the rows with the given values as their defaults, without checking these values.

    The value given for a table is a mapping, which sets the defaults of the rows in that table.
    """
    found = []
    for row in rows:
        if row.name in given and row.table:
            row = replace(row, table=defaulted(row.table, given[row.name]))
        elif row.name in given:
            row = replace(row, default=given[row.name])
        found.append(row)
    return tuple(found)


def defaults(rows: Iterable[Option]) -> dict[str, Any]:
    """Return the defaults of all rows, keyed by full name: "ramp_jumps" or, in a table, "inferred.rates"."""
    return {name: row.default for name, row in flat(rows)}


def flat(rows: Iterable[Option], of: str = "") -> Iterator[tuple[str, Option]]:
    """Yield (full name, row) for every row; after a table come the rows in it, such as ("load.inertia", row)."""
    for row in rows:
        yield f"{of}{row.name}", row
        yield from flat(row.table, f"{of}{row.name}.")
