"""Tables of rows within one test: none is left out, and each that fails is reported."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from tests.rows import rows


class Reported:
    """In place of pytest's subtests: the rows that have failed."""

    def __init__(self) -> None:
        self.rows: list[dict[str, Any]] = []

    @contextmanager
    def test(self, **row: Any) -> Iterator[None]:
        try:
            yield
        except AssertionError:
            self.rows.append(row)


def test_every_row_is_tried_and_each_that_fails_is_reported() -> None:
    tried, reported = [], Reported()

    @rows("a", [1, 2])
    @pytest.mark.timeout(9)
    @rows(("b", "c"), [(3, 4), pytest.param(5, 6)])
    def test(a: int, b: int, c: int, folder: str) -> None:
        tried.append((a, b, c, folder))
        assert b == 3 and a == 1

    assert [*inspect.signature(test).parameters] == ["subtests", "folder"]
    assert [mark.args for mark in test.pytestmark] == [(9,)]
    test(reported, folder="here")  # type: ignore[arg-type]
    assert tried == [(1, 3, 4, "here"), (1, 5, 6, "here"), (2, 3, 4, "here"), (2, 5, 6, "here")]
    assert reported.rows == [{"a": 1, "b": 5, "c": 6}, {"a": 2, "b": 3, "c": 4}, {"a": 2, "b": 5, "c": 6}]


def test_a_row_of_another_length_and_a_table_without_rows_are_mistakes() -> None:
    for table in ([(1, 2, 3)], []):
        with pytest.raises(AssertionError):
            rows(("a", "b"), table)


def test_a_timeout_ends_the_whole_test() -> None:
    @rows("a", [1, 2])
    def test(a: int) -> None:
        pytest.fail("Timeout (>9.0s) from pytest-timeout.")

    with pytest.raises(pytest.fail.Exception, match="Timeout"):
        test(Reported())
