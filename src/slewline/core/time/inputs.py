"""The methods by which a user acts on a chip or a part.

    @from_outside
    def press(self, key: str) -> None:
        self.input("press", key)        told to the outside of the run: a journal writes it down, and calls it again

A journal may come from anywhere: it calls no methods but those that are declared so.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])


def from_outside(method: F) -> F:
    """Declare a method of a chip or a part as an input from outside, which a journal keeps.

    The method must report each call with `input`.
    """
    vars(method)["from_outside"] = True
    return method


def is_from_outside(value: object) -> bool:
    """Return whether this is a method that is declared so."""
    return getattr(value, "__dict__", {}).get("from_outside") is True
