"""A record's fields on Channel Access: caproto channels that accept puts and post the record's values."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from ..errors import SlewlineError, UsageError
from ..extras import needs
from .field_table import LIMITED, FieldRow

try:
    from caproto import (
        AccessRights,
        AlarmSeverity,
        AlarmStatus,
        ChannelAlarm,
        ChannelDouble,
        ChannelEnum,
        ChannelFloat,
        ChannelInteger,
        ChannelShort,
        ChannelString,
    )
except ImportError:
    raise SlewlineError(needs("a motor record needs", "epics")) from None

__all__ = ["AlarmSeverity", "AlarmStatus", "ChannelAlarm"]  # keywords besides those set here

Put = Callable[[Any], Awaitable[None]]


class Field:
    """A field of the record: a client's put is passed to `accept`; the record's values are posted to clients."""

    row: FieldRow
    accept: Put | None = None  # None: clients may only read

    async def write(self, value: Any, **more: Any) -> None:
        """Handle a client's put."""
        if self.accept is not None:  # as in `check_access`
            await self.accept(self.preprocess_value(value))  # type: ignore[attr-defined]

    async def post(self, value: Any) -> None:
        """Post a value to clients."""
        await super().write(value, verify_value=False)  # type: ignore[misc]

    def plain(self, value: Any) -> Any:
        """Return the value in a put as a Python value.

        Raises:
            UsageError: the value is not valid for this field.
        """
        return value.item() if hasattr(value, "item") else value

    def check_access(self, hostname: str, username: str) -> AccessRights:
        """Return a client's access rights."""
        return AccessRights.READ | (AccessRights.WRITE if self.accept is not None else 0)


class NumberField(Field):
    """A number."""

    def plain(self, value: Any) -> Any:
        """Return the value in a put, which must be a finite number."""
        number = super().plain(value)
        if not math.isfinite(number):
            raise UsageError(f"{self.row.name} {number}; expected a finite number")
        return number


class DoubleField(NumberField, ChannelDouble):
    """A number in the motor's unit, or in seconds."""


class FloatField(NumberField, ChannelFloat):
    """A single-precision number."""


class ShortField(NumberField, ChannelShort):
    """A flag, or a button."""


class LongField(NumberField, ChannelInteger):
    """A whole number."""


class TextField(Field, ChannelString):
    """A text."""

    def plain(self, value: Any) -> str:
        """Return the text in a put."""
        return value.decode("latin-1") if isinstance(value, bytes) else str(value)


class EnumField(Field, ChannelEnum):
    """A field whose value is one of a list of words, represented by the word's number."""

    async def post(self, value: Any) -> None:
        """Post a word, given by its number, to clients."""
        await super().post(self.row.words[value])

    def plain(self, value: Any) -> int:
        """Return the number of the word in a put."""
        words = self.row.words
        text = value.decode("latin-1") if isinstance(value, bytes) else value
        number = words.index(text) if text in words else super().plain(value)
        if not isinstance(number, int) or not 0 <= number < len(words):
            raise UsageError(f"{self.row.name} {text!r}; allowed {', '.join(words)}")
        return number


KINDS: dict[str, Callable[..., Any]] = {
    "double": DoubleField,
    "float": FloatField,
    "short": ShortField,
    "long": LongField,
    "string": TextField,
    "enum": EnumField,
}
NUMBERS = ("double", "float", "short", "long")
UNIT_ENDS = 7  # longest unit in Channel Access, characters
TEXT_ENDS = 39  # longest text, characters


def unit_of(row: FieldRow, unit: str) -> str:
    """Return a field's unit, derived from the motor's unit, cut to the permitted length."""
    return row.unit.format(unit)[:UNIT_ENDS]


def bounds_of(row: FieldRow, values: Mapping[str, float]) -> dict[str, float]:
    """Return a field's lower and upper limit as channel metadata; empty if the field has no limits.

    `values` are the values of all fields; the limits are two of these values.
    """
    if row.name not in LIMITED:
        return {}
    low, high = (round(values[name]) if row.kind == "long" else values[name] for name in LIMITED[row.name])
    lower = dict.fromkeys(("lower_ctrl_limit", "lower_disp_limit"), low)
    return lower | dict.fromkeys(("upper_ctrl_limit", "upper_disp_limit"), high)


def field_of(row: FieldRow, values: Mapping[str, Any], alarm: ChannelAlarm) -> Any:
    """Return a field's channel with its initial value; `values` are the initial values of all fields."""
    more: dict[str, Any] = {}
    value = values[row.name]
    if row.kind == "enum":
        more, value = {"enum_strings": row.words}, row.words[value]
    elif row.kind in NUMBERS:
        more = {"units": unit_of(row, values["EGU"])} | bounds_of(row, values)
        if row.kind in ("double", "float"):
            more["precision"] = values["PREC"]
    field = KINDS[row.kind](value=value, alarm=alarm, reported_record_type="motor", **more)
    field.row = row
    return field
