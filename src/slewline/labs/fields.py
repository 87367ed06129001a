"""Fields of a record on Channel Access: channels of caproto that take what a client puts, and tell what is posted."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any, NamedTuple

from ..errors import SlewlineError
from ..extras import needs

try:
    from caproto import (
        AccessRights,
        AlarmSeverity,
        AlarmStatus,
        ChannelAlarm,
        ChannelDouble,
        ChannelEnum,
        ChannelInteger,
        ChannelShort,
        ChannelString,
    )
except ImportError:
    raise SlewlineError(needs("a motor record needs", "epics")) from None

__all__ = ["AlarmSeverity", "AlarmStatus", "ChannelAlarm"]  # besides what is made here

Put = Callable[[Any], Awaitable[None]]
SEVERITY = ("NO_ALARM", "MINOR", "MAJOR", "INVALID")


class Field:
    """A field of the record: what a client puts goes to `accept`; what the record says is posted."""

    accept: Put | None = None  # None: clients may read alone

    async def write(self, value: Any, **more: Any) -> None:
        """Take what a client puts."""
        if self.accept is not None:  # as `check_access` has it
            await self.accept(self.preprocess_value(value))  # type: ignore[attr-defined]

    async def post(self, value: Any) -> None:
        """Tell clients a value."""
        await super().write(value, verify_value=False)  # type: ignore[misc]

    def check_access(self, hostname: str, username: str) -> AccessRights:
        """Return what a client may do."""
        return AccessRights.READ | (AccessRights.WRITE if self.accept is not None else 0)


class DoubleField(Field, ChannelDouble):
    """A number of the unit of the motor, or of seconds."""


class ShortField(Field, ChannelShort):
    """A flag, or something to be done."""


class IntegerField(Field, ChannelInteger):
    """A whole number."""


class TextField(Field, ChannelString):
    """A text."""


class EnumField(Field, ChannelEnum):
    """One of some words."""


class FieldRow(NamedTuple):
    """A field: its class, its value at the beginning, what it takes from clients."""

    kind: Callable[..., Field]
    value: Any
    accept: Put | None = None
