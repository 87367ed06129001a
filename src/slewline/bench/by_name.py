"""What `bench.add("cy525")`, `bench.part("uart")` and `bench.host(x)` return, for those who check types.

The stub beside this file says it, name by name; tools/stubs.py writes it.  When the program runs, nothing is here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def adds(function: Callable[..., Any]) -> Any:
    """Return the method itself: for types, `bench.add` by the name or the class of the chip."""
    return function


def makes(function: Callable[..., Any]) -> Any:
    """Return the method itself: for types, `bench.part` by the kind of the part."""
    return function


def hosts(function: Callable[..., Any]) -> Any:
    """Return the method itself: for types, `bench.host` by the class of the chip."""
    return function
