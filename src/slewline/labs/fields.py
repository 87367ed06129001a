"""Fields of a record on Channel Access: channels of caproto that take puts, and post what the record has."""

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

__all__ = ["AlarmSeverity", "AlarmStatus", "ChannelAlarm"]  # besides what is made here

Put = Callable[[Any], Awaitable[None]]


class Field:
    """A field of the record: what a client puts goes to `accept`; what the record has is posted."""

    row: FieldRow
    accept: Put | None = None  # None: clients may read alone

    async def write(self, value: Any, **more: Any) -> None:
        """Take what a client puts."""
        if self.accept is not None:  # as `check_access` has it
            await self.accept(self.preprocess_value(value))  # type: ignore[attr-defined]

    async def post(self, value: Any) -> None:
        """Post a value to clients."""
        await super().write(value, verify_value=False)  # type: ignore[misc]

    def plain(self, value: Any) -> Any:
        """Return the value of a put as Python has it.

        Raises:
            UsageError: no value of such a field.
        """
        return value.item() if hasattr(value, "item") else value

    def check_access(self, hostname: str, username: str) -> AccessRights:
        """Return what a client may do."""
        return AccessRights.READ | (AccessRights.WRITE if self.accept is not None else 0)


class NumberField(Field):
    """A number."""

    def plain(self, value: Any) -> Any:
        """Return the value of a put, which is finite."""
        number = super().plain(value)
        if not math.isfinite(number):
            raise UsageError(f"{self.row.name} {number}; allowed a number")
        return number


class DoubleField(NumberField, ChannelDouble):
    """A number of the unit of the motor, or of seconds."""


class FloatField(NumberField, ChannelFloat):
    """A number of less precision."""


class ShortField(NumberField, ChannelShort):
    """A flag, or something to be done."""


class LongField(NumberField, ChannelInteger):
    """A whole number."""


class TextField(Field, ChannelString):
    """A text."""

    def plain(self, value: Any) -> str:
        """Return the text of a put."""
        return value.decode("latin-1") if isinstance(value, bytes) else str(value)


class EnumField(Field, ChannelEnum):
    """One of some words, by its number."""

    async def post(self, value: Any) -> None:
        """Post a word to clients."""
        await super().post(self.row.words[value])

    def plain(self, value: Any) -> int:
        """Return the number of the word that is put."""
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
UNIT_ENDS = 7  # characters of a unit, which Channel Access has room for
TEXT_ENDS = 39  # ... of a text


def unit_of(row: FieldRow, unit: str) -> str:
    """Return the unit of a field, by that of the motor; as long as it may be."""
    return row.unit.format(unit)[:UNIT_ENDS]


def bounds_of(row: FieldRow, values: Mapping[str, float]) -> dict[str, float]:
    """Return what a field may be, by the values of all fields: metadata of its channel."""
    if row.name not in LIMITED:
        return {}
    low, high = (round(values[name]) if row.kind == "long" else values[name] for name in LIMITED[row.name])
    lower = dict.fromkeys(("lower_ctrl_limit", "lower_disp_limit"), low)
    return lower | dict.fromkeys(("upper_ctrl_limit", "upper_disp_limit"), high)


def field_of(row: FieldRow, values: Mapping[str, Any], alarm: ChannelAlarm) -> Any:
    """Return the channel of a field that begins with the values of all fields."""
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
