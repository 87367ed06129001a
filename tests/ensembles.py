"""Ensembles: a few members in every run, all of them in `make test-long`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import pytest

Test = TypeVar("Test", bound=Callable[..., Any])
AT_ONCE = 20  # members in a long test


def few(members: Iterable[Any], count: int) -> list[Any]:
    """Return the members as parameters: `count` of them, from all parts of the ensemble, in every run."""
    members = list(members)
    every = {number * len(members) // count for number in range(count)}
    return [member if number in every else in_long_runs(member) for number, member in enumerate(members)]


def in_long_runs(member: Any) -> Any:
    """Return a member as a parameter of long runs."""
    return pytest.param(member, marks=pytest.mark.long)


def members(name: str, count: int, many: int, at_once: int = AT_ONCE) -> Callable[[Test], Test]:
    """Give a test ranges of numbers: the first `count` in every run, in long ones all that are below `many`."""
    others = [in_long_runs(range(at, min(at + at_once, many))) for at in range(count, many, at_once)]
    given = pytest.mark.parametrize(name, [range(count), *others], ids=lambda each: f"{each[0]} to {each[-1]}")

    def decorated(test: Test) -> Test:
        return pytest.mark.timeout(600)(given(test))

    return decorated
