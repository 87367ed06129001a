"""Option values of kinds that click does not provide."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.shell_completion import CompletionItem

from ...core.datasheet.units import KINDS, quantity
from ...core.messages.decimal_comma import without_comma
from ...core.messages.near import hint
from ...core.time.timebase import hertz, picoseconds
from ...errors import TimeError, UsageError
from . import completion

if TYPE_CHECKING:
    from ...core.datasheet.table import Sheet

T = TypeVar("T")


class Completed(click.ParamType[T]):
    """A kind of value that a shell can complete; `complete` returns the completions."""

    complete: completion.Complete

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """Return the completions for the shell."""
        return self.complete(ctx, param, incomplete)


class PathName(Completed[str]):
    """The name of a file or a directory, which the shell completes."""

    name = "text"

    def __init__(self, complete: completion.Complete) -> None:
        self.complete = complete


FILE, DIRECTORY = PathName(completion.file), PathName(completion.directory)


class TimeWithUnit(click.ParamType[int]):
    """A time with its unit."""

    name = "time"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return a time in picoseconds."""
        try:
            return picoseconds(value)
        except TimeError as error:
            self.fail(str(error), param, ctx)


class UnitsPerStep(click.ParamType[float]):
    """A number of units per step, written without the unit; the option --units sets the unit."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number."""
        parts = re.fullmatch(r"\s*([-+.0-9eE]*)\s*(.*?)\s*", str(value))
        number, unit = parts.groups() if parts is not None else ("", "")
        try:
            found = float(number)
        except ValueError:
            self.fail(f"{value!r}: expected a number, such as 0.005{without_comma(value)}", param, ctx)
        if unit:
            self.fail(f"{value!r}: write {number}, and --units {unit}", param, ctx)
        return found


class WholeNumber(click.ParamType[int]):
    """A whole number.

    Args:
        example: an example, for messages.
        noun: the things counted, such as "steps"; the word may follow the number.
        also: text added to the message about a wrong value.
        least, most: the allowed range; if `most` is None, there is no upper limit; if `least` is None, the
            range is not checked here, but later by the command.
    """

    name = "number"

    def __init__(
        self, example: int, noun: str = "", also: str = "", least: int | None = None, most: int | None = None
    ) -> None:
        self.example, self.noun, self.also, self.least, self.most = example, noun, also, least, most

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the number; `noun` may follow it in the text, as in "400 steps"."""
        noun = rf"(?:{self.noun}?)?" if self.noun else ""
        found = re.fullmatch(rf"\s*([+-]?[0-9]{{1,12}})\s*{noun}\s*", str(value))
        if found is None:
            what = f"a whole number{self.noun and f' of {self.noun}'}, such as {self.example}"
            self.fail(f"{value!r}: expected {what}{self.also}{without_comma(value)}", param, ctx)
        number = int(found[1])
        if self.least is not None and not self.least <= number <= (number if self.most is None else self.most):
            most = "or more" if self.most is None else f"to {self.most}"
            self.fail(f"{value!r}; allowed {self.least} {most}", param, ctx)
        return number


class AnyNumber(click.ParamType[float]):
    """A number.

    Args:
        example: an example, for messages.
    """

    name = "number"

    def __init__(self, example: str) -> None:
        self.example = example

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number."""
        try:
            return float(value)
        except ValueError:
            self.fail(f"{value!r}: expected a number, such as {self.example}{without_comma(value)}", param, ctx)


STEPS = WholeNumber(400, "steps", "; most motors have 200 per revolution")


class QuantityWithUnit(click.ParamType[float]):
    """A number with any of the units in one row of the table of units.

    Args:
        unit: one of the units in that row; the number is converted to this unit.
    """

    name = "quantity"

    def __init__(self, unit: str) -> None:
        self.unit = unit

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number, converted to `unit`."""
        try:
            return quantity(value, self.unit, KINDS[self.unit])
        except UsageError as error:
            self.fail(str(error), param, ctx)


class CheckedText(click.ParamType[str]):
    """A text that is checked when the command line is read, but converted later.

    Args:
        name: the kind of value, for the usage line.
        read: a function that converts the text; it raises UsageError or TimeError if the text is wrong.
    """

    def __init__(self, name: str, read: Callable[[str], object]) -> None:
        self.name, self.read = name, read

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the text as it was written."""
        try:
            self.read(str(value))
        except (TimeError, UsageError) as error:
            self.fail(str(error), param, ctx)
        return str(value)


def step_rate(text: str) -> None:
    """Check that a text is a rate in steps per second, with its unit."""
    from ...drive.terminals import steps_a_second  # most commands do not need it

    steps_a_second(text)


FREQUENCY, TIME, STEP_RATE = (
    CheckedText("frequency", hertz),
    CheckedText("time", picoseconds),
    CheckedText("rate", step_rate),
)


class PinDrive(Completed[tuple[str, int, int]]):
    """A pin, its new level, and the time of the change (0 if omitted): pin=level@time."""

    name = "pin=level@time"
    complete = staticmethod(completion.drive)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, int, int]:
        """Return (pin, level, time in picoseconds)."""
        if isinstance(value, tuple):
            return value
        match = re.fullmatch(r"\s*(\w+(?:\.\w+)?)\s*=\s*([01])\s*(?:@(.*))?", value)
        if match is None:
            message = wrong_level(value) or "give pin, level and instant, such as 'abort=0@12 ms' or 'x.abort=1'"
            self.fail(f"{value!r}: {message}", param, ctx)
        try:
            return match[1], int(match[2]), picoseconds(match[3] or 0)
        except TimeError as error:
            self.fail(str(error), param, ctx)


def wrong_level(value: str) -> str:
    """Return a message if the text assigns a pin a level other than 0 or 1; otherwise an empty string."""
    match = re.fullmatch(r"\s*(\w+(?:\.\w+)?)\s*=\s*([^\s@]+)\s*(@.*)?", value)
    if match is None or match[2] in ("0", "1"):
        return ""
    return f"{match[2]!r} is not a level; levels are 0 (low) and 1 (high), such as '{match[1]}=0{match[3] or ''}'"


class PartName(Completed[str]):
    """The name of a chip: a part number, or module:Class."""

    name = "chip"
    complete = staticmethod(completion.parts)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the name as it was written; if it has a colon, allow imports from the current directory."""
        look_here(None, None, ":" in value)
        return str(value)


def look_here(ctx: click.Context | None, param: click.Parameter | None, wanted: bool) -> bool:
    """Append the current directory to the module path if `wanted`; return `wanted`.

    `python -m` adds that directory too, but before all others.
    """
    if wanted and os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())
    return wanted


class Names(Completed[tuple[str, ...]]):
    """Names of pins, separated by commas."""

    name = "a,b,c"
    complete = staticmethod(completion.pins)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, ...]:
        """Return the names."""
        if isinstance(value, tuple):
            return value
        names = tuple(name.strip() for name in value.split(","))
        if not all(re.fullmatch(r"\w+(?:\.\w+)?", name) for name in names):
            self.fail(
                f"{value!r}: give names of pins separated by commas, such as 'pulse,slew' or 'x.slew'", param, ctx
            )
        return names


class Strap(Completed[tuple[str, int]]):
    """An input pin and its fixed level: pin=level."""

    name = "pin=level"
    complete = staticmethod(completion.strap)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, int]:
        """Return (pin, level)."""
        if isinstance(value, tuple):
            return value
        match = re.fullmatch(r"\s*(\w+)\s*=\s*([01])\s*", value)
        sheet = None if ctx is None else completion.sheet(ctx)
        if match is None:
            self.fail(f"{value!r}: {self.wrong(value, sheet)}", param, ctx)
        if sheet is not None and not any(row.name == match[1] for row in sheet.pins):
            self.fail(f"{value!r}: {self.wrong(value, sheet)}", param, ctx)
        return match[1], int(match[2])

    def wrong(self, value: str, sheet: Sheet | None) -> str:
        """Return a message for a wrong strap: the error and, for a wrong pin, the chip's inputs and a similar name."""
        if sheet is None:
            return wrong_level(value) or "give a pin and its level, 0 or 1, such as 'chs=0'"
        inputs = {row.name: row.description for row in sheet.pins if row.in_out in ("in", "both")}
        like = next(iter([*sheet.plain, *sheet.fastest, *inputs]))
        name = value.partition("=")[0].strip()
        message = (
            wrong_level(value) or f"give a pin and its level, 0 or 1, such as '{name if name in inputs else like}=0'"
        )
        if name in inputs:
            return message
        if name.isidentifier() and "=" in value:
            message = f"the {sheet.part} has no pin {name!r}"
        about = [f"{pin} ({what})" for pin, what in inputs.items() if name and name.lower() in what.lower()]
        meant = f"; the {name} is on {', '.join(about)}" if about else hint(name, inputs)
        return f"{message}; its inputs: {', '.join(inputs)}{meant}"


class SettingText(Completed[tuple[str, str]]):
    """A setting, name=value or table.name=value; the part interprets the value.

    Args:
        what: the kind of setting, for messages.
        example: an example of name and value.
    """

    name = "name=value"
    complete = staticmethod(completion.setting)

    def __init__(self, what: str = "an option and its value", example: str = "eeprom_time=20 ms") -> None:
        self.what, self.example = what, example

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, str]:
        """Return (name, value), both as text."""
        if isinstance(value, tuple):
            return value
        name, equals, text = (part.strip() for part in value.partition("="))
        if not equals or not all(map(str.isidentifier, name.split("."))):
            self.fail(f"{value!r}: give {self.what}, such as '{self.example}'", param, ctx)
        return name, text
