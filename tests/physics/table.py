"""The rows of the table: what is checked, the value, what is expected, how far off it may be.

    @check(7, "static load angle")
    def load_angle() -> Iterator[Reading]:
        yield near("lag, degrees", value, expected, 0.005)

A check that takes more than a second or two is `long`: `make test-long` runs it, and the table without --quick.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Container, Iterable, Iterator
from dataclasses import dataclass
from math import inf
from types import ModuleType
from typing import Any

CHECKS: list[Check] = []


@dataclass(frozen=True, slots=True)
class Reading:
    """A value, what is expected, and how far it may be below and above that."""

    of: str
    value: float
    expected: float
    below: float
    above: float

    @property
    def passed(self) -> bool:
        """Is the value within the tolerance?"""
        return self.expected - self.below <= self.value <= self.expected + self.above

    @property
    def tolerance(self) -> str:
        """The tolerance in words: relative where something is expected, else absolute."""
        if self.below == self.above == 0:
            return "exact"
        if self.above == inf:
            return "at least"
        if self.below == inf:
            return "at most"
        if self.below == self.above:
            relative = self.below / abs(self.expected) if self.expected else 0
            return f"±{100 * relative:.3g} %" if relative >= 1e-4 else f"±{self.below:.2g}"
        return f"-{100 * self.below / self.expected:.3g}/+{100 * self.above / self.expected:.3g} %"


@dataclass(frozen=True, slots=True)
class Check:
    """A check by its number; it yields readings."""

    number: int
    what: str
    read: Callable[[], Iterator[Reading]]
    long: bool

    @property
    def name(self) -> str:
        """The name of its function."""
        return f"{self.number}-{self.read.__name__}"


Reader = Callable[[], Iterator[Reading]]


def check(number: int, what: str, *, long: bool = False) -> Callable[[Reader], Reader]:
    """Return a decorator that adds a function to the table."""

    def add(read: Reader) -> Reader:
        CHECKS.append(Check(number, what, read, long))
        return read

    return add


def near(of: str, value: float, expected: float, relative: float, above: float | None = None) -> Reading:
    """Return a reading with a relative tolerance: below, and above if that differs."""
    size = abs(expected)
    return Reading(of, float(value), expected, relative * size, (relative if above is None else above) * size)


def within(of: str, value: float, expected: float, off: float) -> Reading:
    """Return a reading with an absolute tolerance."""
    return Reading(of, float(value), expected, off, off)


def at_most(of: str, value: float, limit: float) -> Reading:
    """Return a reading with a limit above it."""
    return Reading(of, float(value), limit, inf, 0.0)


def at_least(of: str, value: float, limit: float) -> Reading:
    """Return a reading with a limit below it."""
    return Reading(of, float(value), limit, 0.0, inf)


def same(of: str, value: float, expected: float) -> Reading:
    """Return a reading that must be equal."""
    return Reading(of, float(value), expected, 0.0, 0.0)


def as_parameters(rows: Iterable[Check], modules: Iterable[ModuleType], system: Container[int] = ()) -> list[Any]:
    """Return the rows of some modules as parameters of a test; those with some numbers run with `make test-system`."""
    import pytest

    names = {module.__name__ for module in modules}
    slow = [pytest.mark.long, pytest.mark.timeout(900)]
    return [
        pytest.param(row, id=row.name, marks=slow if row.long else [pytest.mark.system] * (row.number in system))
        for row in rows
        if row.read.__module__ in names
    ]


def report(rows: Iterable[Check], numbers: set[int], quick: bool, write: Callable[[str], object] = print) -> int:
    """Write the table of checks, of some numbers or of all; return how many rows were missed."""
    write(f"{'no.':>4}  {'what':<86} {'value':>12} {'expected':>12}  {'tolerance':<13} {'':<6} {'s':>6}")
    missed = 0
    for one in rows:
        if (numbers and one.number not in numbers) or (quick and one.long):
            continue
        since = time.perf_counter()
        for reading in one.read():
            spent = time.perf_counter() - since
            what = f"{one.what}: {reading.of}" if reading.of else one.what
            verdict = "pass" if reading.passed else "MISSED"
            missed += not reading.passed
            write(
                f"{one.number:>4}  {what:<86} {reading.value:>12.7g} {reading.expected:>12.7g}  "
                f"{reading.tolerance:<13} {verdict:<6} {spent:>6.1f}"
            )
            since = time.perf_counter()
    write(f"{missed} missed" if missed else "all pass")
    return missed
