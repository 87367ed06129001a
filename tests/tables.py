"""Tables: tests that are parametrized with many quick rows.

`one_item_each` joins the rows of a test into one item: what pytest does around each item costs more than most rows.  It
runs when rows have been selected, so `-k`, `-m` and `file::test[row]` select rows as ever; a row that fails is reported
as a subtest, under its own name.

`pair` thins out what multiplies.  Where a test has cases and, crossed with them, the parts of a family, each case runs
with one part and each part with some case; the other pairs are left to long runs.  `take_turns` lets a test without
cases run with one part, whose choice depends on its name alone, and with all of them in long runs.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Iterable
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Any
from zlib import crc32

import pytest

# Marks that pytest handles for each item; and rows that are not quick.
APART = {"skip", "skipif", "xfail", "usefixtures", "long", "system", "real"}


def pair(items: Iterable[pytest.Item], telling: Collection[str]) -> None:
    """Mark as long what is left out of each table of cases crossed with parts.

    Args:
        items: the tests.
        telling: names by which a test tells its parts apart; one with such a name runs with all of them.
    """
    for rows in with_parts(items, telling).values():
        for row in left_out(rows):
            row.add_marker("long")


def take_turns(items: Iterable[pytest.Item], telling: Collection[str]) -> None:
    """Mark as long all parts but one of each test that has no other parameter; arguments as for `pair`."""
    for name, rows in with_parts(items, telling).items():
        if parameters(rows[0]).keys() == {"part"}:
            for row in set(rows) - {rows[crc32(name.encode()) % len(rows)]}:
                row.add_marker("long")


def with_parts(items: Iterable[pytest.Item], telling: Collection[str]) -> dict[str, list[pytest.Function]]:
    """Return the rows of each test that runs with several parts and does not tell them apart, but not the long ones."""
    tables: dict[str, list[pytest.Function]] = defaultdict(list)
    for item in items:
        if not isinstance(item, pytest.Function) or item.get_closest_marker("long"):
            continue
        if "part" in parameters(item) and not {*telling} & {*item.obj.__code__.co_names}:
            tables[item.nodeid.split("[")[0]].append(item)
    return tables


def left_out(rows: list[pytest.Function]) -> list[pytest.Function]:
    """Return the rows of a table that are not needed for each part and each case to have a row."""
    part_of = {row: parameters(row)["part"] for row in rows}
    case_of = {row: tuple(id(value) for name, value in parameters(row).items() if name != "part") for row in rows}
    parts, cases = (list(dict.fromkeys(column)) for column in (part_of.values(), case_of.values()))
    turns = min(len(parts), len(cases))

    def in_turn(row: pytest.Function) -> bool:
        number = cases.index(case_of[row])
        # in another order each time round, so that cases which alternate themselves meet every part
        return (number + number // turns - parts.index(part_of[row])) % turns == 0

    left, covered = [], set()
    for row in sorted(rows, key=in_turn, reverse=True):
        if in_turn(row) or not {part_of[row], case_of[row]} <= covered:
            covered |= {part_of[row], case_of[row]}
        else:
            left.append(row)
    return left


def parameters(item: pytest.Function) -> dict[str, Any]:
    """Return the parameters of a row, by name; of any other test: none."""
    return item.callspec.params if hasattr(item, "callspec") else {}


def one_item_each(items: list[pytest.Item], folder: Path) -> None:
    """Put one item in place of the rows of each test in a folder, in the list of items itself.

    A test with a fixture that is made anew for each row keeps an item for each row.
    """
    tables: dict[object, list[pytest.Function]] = defaultdict(list)
    for item in items:
        if isinstance(item, pytest.Function) and item.path.is_relative_to(folder) and joins(item):
            marks = frozenset(mark.name for mark in item.iter_markers())
            tables[item.parent, item.originalname, marks].append(item)
    instead = {rows[0]: joined(rows) for rows in tables.values() if len(rows) > 1}
    gone = {row for rows in tables.values() if len(rows) > 1 for row in rows[1:]}
    items[:] = [instead.get(item, item) for item in items if item not in gone]


def joins(item: pytest.Function) -> bool:
    """Return whether an item is a row that may run in one item with others."""
    if not parameters(item) or hasattr(item.obj, "hypothesis"):
        return False
    if any(mark.name in APART for mark in item.iter_markers()):
        return False
    made = item._fixtureinfo.name2fixturedefs  # pytest has no public name for it
    return all(name in made and made[name][-1].scope != "function" for name in fixtures(item))


def fixtures(item: pytest.Function) -> list[str]:
    """Return the names of what a row takes besides its parameters."""
    return [name for name in signature(item.obj).parameters if name not in parameters(item)]


def joined(rows: list[pytest.Function]) -> pytest.Function:
    """Return an item that runs all rows."""
    first, names = rows[0], ["subtests", *fixtures(rows[0])]

    def test(subtests: Any, **shared: Any) -> None:
        for row in rows:
            try:
                row.obj(**parameters(row), **shared)
            except (Exception, pytest.fail.Exception, pytest.skip.Exception) as error:
                with subtests.test(row.callspec.id):
                    raise
                # A timeout comes as a failure, and only once.
                if isinstance(error, pytest.fail.Exception):
                    return

    test.__signature__ = Signature([Parameter(name, Parameter.KEYWORD_ONLY) for name in names])  # type: ignore[attr-defined]
    test.pytestmark = [mark for mark in first.own_markers if mark.name != "parametrize"]  # type: ignore[attr-defined]
    test.__doc__ = first.obj.__doc__
    call: Callable[..., None] = test
    return pytest.Function.from_parent(first.parent, name=first.originalname, callobj=call)
