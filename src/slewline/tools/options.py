"""Values of options that click does not know."""

from __future__ import annotations

import re
from typing import Any

import click

from ..core.timebase import hertz, picoseconds
from ..errors import TimeError


class Time(click.ParamType[int]):
    """A time with its unit."""

    name = "time"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Picoseconds."""
        try:
            return picoseconds(value)
        except TimeError as error:
            self.fail(str(error), param, ctx)


class Frequency(click.ParamType[str]):
    """A frequency with its unit."""

    name = "frequency"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """As it was written."""
        try:
            hertz(value)
        except TimeError as error:
            self.fail(str(error), param, ctx)
        return str(value)


class Drive(click.ParamType[tuple[str, int, int]]):
    """pin=level@time."""

    name = "pin=level@time"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, int, int]:
        """(pin, level, picoseconds)."""
        if isinstance(value, tuple):
            return value
        match = re.fullmatch(r"\s*(\w+(?:\.\w+)?)\s*=\s*([01])\s*(?:@(.*))?", value)
        if match is None:
            self.fail(f"{value!r}: give pin, level and instant, such as 'abort=0@12 ms' or 'x.abort=1'", param, ctx)
        try:
            return match[1], int(match[2]), picoseconds(match[3] or 0)
        except TimeError as error:
            self.fail(str(error), param, ctx)
