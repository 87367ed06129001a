"""Values of options that click does not know."""

from __future__ import annotations

import re
from typing import Any

import click

from ..core.timebase import hertz, picoseconds
from ..errors import TimeError


class TimeWithUnit(click.ParamType[int]):
    """A time with its unit."""

    name = "time"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the picoseconds of a time."""
        try:
            return picoseconds(value)
        except TimeError as error:
            self.fail(str(error), param, ctx)


class Frequency(click.ParamType[str]):
    """A frequency with its unit."""

    name = "frequency"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the frequency as it was written."""
        try:
            hertz(value)
        except TimeError as error:
            self.fail(str(error), param, ctx)
        return str(value)


class Drive(click.ParamType[tuple[str, int, int]]):
    """pin=level@time."""

    name = "pin=level@time"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, int, int]:
        """Return (pin, level, picoseconds)."""
        if isinstance(value, tuple):
            return value
        match = re.fullmatch(r"\s*(\w+(?:\.\w+)?)\s*=\s*([01])\s*(?:@(.*))?", value)
        if match is None:
            self.fail(f"{value!r}: give pin, level and instant, such as 'abort=0@12 ms' or 'x.abort=1'", param, ctx)
        try:
            return match[1], int(match[2]), picoseconds(match[3] or 0)
        except TimeError as error:
            self.fail(str(error), param, ctx)


class Names(click.ParamType[tuple[str, ...]]):
    """Names with commas between."""

    name = "a,b,c"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, ...]:
        """Return the names."""
        if isinstance(value, tuple):
            return value
        names = tuple(name.strip() for name in value.split(","))
        if not all(re.fullmatch(r"\w+(?:\.\w+)?", name) for name in names):
            self.fail(
                f"{value!r}: give names of pins with commas between, such as 'pulse,slew' or 'x.slew'", param, ctx
            )
        return names


class Strap(click.ParamType[tuple[str, int]]):
    """pin=level."""

    name = "pin=level"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, int]:
        """Return (pin, level)."""
        if isinstance(value, tuple):
            return value
        match = re.fullmatch(r"\s*(\w+)\s*=\s*([01])\s*", value)
        if match is None:
            self.fail(f"{value!r}: give a pin and its level, such as 'chs=0'", param, ctx)
        return match[1], int(match[2])


class Setting(click.ParamType[tuple[str, str]]):
    """name=value, or table.name=value; the part says what the text stands for."""

    name = "name=value"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, str]:
        """Return (name, text)."""
        if isinstance(value, tuple):
            return value
        name, equals, text = (part.strip() for part in value.partition("="))
        if not equals or not all(map(str.isidentifier, name.split("."))):
            self.fail(f"{value!r}: give an option and its value, such as 'eeprom_time=20 ms'", param, ctx)
        return name, text
