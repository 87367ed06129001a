"""The methods with which a user operates a chip or a part.

    @from_outside
    def press(self, key: str) -> None:
        self.input("press", key)     reported outside the run: journals record the call, replays repeat it

A journal may come from anywhere; its replay calls only methods that are declared in this way.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])


def from_outside(method: F) -> F:
    """Declare a method of a chip or a part as an external input, which journals record.

    The method must report each call with `self.input`.
    """
    vars(method)["from_outside"] = True
    return method


def is_from_outside(value: object) -> bool:
    """Return whether an object is a method declared by `from_outside`."""
    return getattr(value, "__dict__", {}).get("from_outside") is True
