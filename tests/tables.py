"""Tables: tests that are parametrized with many quick rows.

`one_item_each` joins the rows of a test into one item: what pytest does around each item costs more than most rows.  It
runs when rows have been selected, so `-k`, `-m` and `file::test[row]` select rows as ever; a row that fails is reported
as a subtest, under its own name.

`pair` thins out what multiplies.  Where a test has cases and, crossed with them, the parts of a family, each case runs
with one part and each part with some case; the other pairs are left to long runs.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Iterable
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Any

import pytest

# Marks that pytest handles for each item; and rows that are not quick.
APART = {"skip", "skipif", "xfail", "usefixtures", "long", "system", "real"}


def pair(items: Iterable[pytest.Item]) -> None:
    """Mark as long what is left out of each table of cases crossed with parts."""
    tables: dict[object, list[pytest.Function]] = defaultdict(list)
    for item in items:
        crossed = any(mark.args[0] == "part" for mark in item.iter_markers("parametrize"))
        if crossed and isinstance(item, pytest.Function) and not item.get_closest_marker("long"):
            tables[item.parent, item.originalname].append(item)
    for rows in tables.values():
        keys = [
            (row.callspec.params["part"], tuple(id(value) for name, value in row.callspec.params.items() if name != "part"))
            for row in rows
        ]
        parts, cases = (list(dict.fromkeys(column)) for column in zip(*keys, strict=True))
        turns = min(len(parts), len(cases))
        for row, (part, case) in zip(rows, keys, strict=True):
            number = cases.index(case)
            # in another order each time round: cases that alternate themselves meet every part
            if (number + number // turns - parts.index(part)) % turns and turns > 1:
                row.add_marker("long")


def one_item_each(items: list[pytest.Item], folder: Path, shared: Collection[str]) -> None:
    """Put one item in place of the rows of each test.

    Args:
        items: what has been collected; it is changed.
        folder: the tests that are joined.
        shared: fixtures that are the same for all rows; a test with others keeps an item for each row.
    """
    tables: dict[object, list[pytest.Function]] = defaultdict(list)
    for item in items:
        if isinstance(item, pytest.Function) and item.path.is_relative_to(folder) and joins(item, shared):
            marks = frozenset(mark.name for mark in item.iter_markers())
            tables[item.parent, item.originalname, marks].append(item)
    instead = {rows[0]: joined(rows) for rows in tables.values() if len(rows) > 1}
    gone = {row for rows in tables.values() if len(rows) > 1 for row in rows[1:]}
    items[:] = [instead.get(item, item) for item in items if item not in gone]


def joins(item: pytest.Function, shared: Collection[str]) -> bool:
    """Return whether an item is a row that may run in one item with others."""
    if not hasattr(item, "callspec") or hasattr(item.obj, "hypothesis"):
        return False
    if any(mark.name in APART for mark in item.iter_markers()):
        return False
    return all(name in shared for name in fixtures(item))


def fixtures(item: pytest.Function) -> list[str]:
    """Return the names of what a row takes besides its parameters."""
    return [name for name in signature(item.obj).parameters if name not in item.callspec.params]


def joined(rows: list[pytest.Function]) -> pytest.Function:
    """Return an item that runs all rows."""
    first, names = rows[0], ["subtests", *fixtures(rows[0])]

    def test(subtests: Any, **shared: Any) -> None:
        for row in rows:
            try:
                row.obj(**row.callspec.params, **shared)
            except (Exception, pytest.fail.Exception, pytest.skip.Exception) as error:
                with subtests.test(row.callspec.id):
                    raise
                # A timeout comes as a failure, and only once.
                if first.session.shouldfail or isinstance(error, pytest.fail.Exception):
                    return

    test.__signature__ = Signature([Parameter(name, Parameter.KEYWORD_ONLY) for name in names])  # type: ignore[attr-defined]
    test.pytestmark = [mark for mark in first.own_markers if mark.name != "parametrize"]  # type: ignore[attr-defined]
    test.__doc__ = first.obj.__doc__
    call: Callable[..., None] = test
    return pytest.Function.from_parent(first.parent, name=first.originalname, callobj=call)
