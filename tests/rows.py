"""Tables of quick tests: one test that tries every row, in place of one test a row."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from functools import wraps
from typing import Any, TypeVar

import pytest

Test = TypeVar("Test", bound=Callable[..., Any])


def rows(names: str | Iterable[str], table: Iterable[Any]) -> Callable[[Test], Test]:
    """Give a test the rows of a table, as `pytest.mark.parametrize` does, but within one test.

    A test of its own costs a millisecond and more, and most rows take less.  Each row that fails is reported, with
    its values; those that pass cost nothing.  All rows have the same fixtures, so none may leave something in them.
    Two tables on a test: every row of the one with every row of the other.
    """
    keys = [names] if isinstance(names, str) else [*names]
    given = [named(keys, row) for row in table]
    assert given, f"a table without a row: {names}"

    def decorated(test: Test) -> Test:
        body, inner = getattr(test, "rows", (test, [{}]))
        every = [outer | row for outer in given for row in inner]

        @wraps(test)  # with its marks
        def tried(subtests: pytest.Subtests, **fixtures: Any) -> None:
            for row in every:
                try:
                    body(**fixtures, **row)
                except BaseException as found:
                    if "from pytest-timeout" in str(found):  # its time is that of all rows
                        raise
                    with subtests.test(**row):
                        raise

        given_by_rows = {*every[0]}
        own = [one for name, one in inspect.signature(body).parameters.items() if name not in given_by_rows]
        first = inspect.Parameter("subtests", inspect.Parameter.POSITIONAL_OR_KEYWORD)
        tried.rows = body, every  # type: ignore[attr-defined]
        tried.__signature__ = inspect.Signature([first, *own])  # type: ignore[attr-defined]
        return tried  # type: ignore[return-value]

    return decorated


def named(keys: list[str], row: Any) -> dict[str, Any]:
    """Return a row as arguments of the test."""
    if isinstance(row, type(pytest.param())):
        assert all(mark.name == "fact" for mark in row.marks), "a row has no marks but those of facts"
        values = row.values
    else:
        values = (row,) if len(keys) == 1 else tuple(row)
    assert len(values) == len(keys), f"{keys}: {values}"
    return dict(zip(keys, values, strict=True))
