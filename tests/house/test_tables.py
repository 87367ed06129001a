"""Rows that are joined into one item: which of them run, and how one that fails is reported."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

CONFTEST = """
import pytest
from pathlib import Path
from tests import tables

HERE = Path(__file__).parent

@pytest.hookimpl(wrapper=True)
def pytest_collection_modifyitems(items):
    tables.pair(items, ("TOLD",))
    tables.take_turns(items, ("TOLD",))
    yield
    tables.one_item_each(items, HERE)

@pytest.fixture
def fresh():
    return []
"""
TESTS = """
import pytest

TOLD = "a"
parts = pytest.mark.parametrize("part", ["a", "b"])

@pytest.mark.parametrize("number", range(4))
def test_odd(number):
    assert number % 2 == 1

@pytest.mark.parametrize("number", range(4))
def test_fresh(fresh, number):
    assert not fresh
    fresh.append(number)

@parts
@pytest.mark.parametrize("number", range(4))
def test_crossed(part, number):
    print("crossed", part, number)

@parts
def test_alone(part):
    print("alone", part)

@parts
def test_apart(part):
    print("apart", part, part == TOLD)
"""
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory):
    folder = tmp_path_factory.mktemp("tables")
    (folder / "conftest.py").write_text(CONFTEST)
    (folder / "test_rows.py").write_text(TESTS)
    (folder / "pytest.ini").write_text(
        f"[pytest]\npythonpath = {ROOT}\nmarkers = long\naddopts = -p no:cacheprovider\n"
    )

    def outcome(*arguments: str) -> str:
        words = [sys.executable, "-m", "pytest", "-rA", "-p", "no:cacheprovider", *arguments]
        return subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=60, check=False).stdout

    return outcome


def test_each_row_that_fails_is_reported_by_its_name(run):
    found = run("-k", "odd")
    assert "SUBFAILED[0] test_rows.py::test_odd" in found and "SUBFAILED[2] test_rows.py::test_odd" in found
    assert "SUBFAILED[1]" not in found and "SUBFAILED[3]" not in found
    assert "SUBFAILED[2]" not in run("-x", "-k", "odd")


def test_rows_are_selected_as_ever(run):
    assert "1 passed" in run("test_rows.py::test_odd[1]") and "1 failed" in run("test_rows.py::test_odd[2]")
    assert "SUBFAILED" not in run("-k", "odd and 1")


def test_items_made_for_each_row_are_kept_apart(run):
    assert "4 passed" in run("-k", "fresh")


def test_cases_run_with_one_part_each_and_with_all_in_long_runs(run):
    found = run("-k", "crossed", "-m", "not long")
    seen = [f"crossed {part} {number}" in found for part in "ab" for number in range(4)]
    assert [sum(seen[number::4]) for number in range(4)] == [1] * 4 and sum(seen[:4]) == 2
    rest = run("-k", "crossed", "-m", "long")
    assert [f"crossed {part} {number}" in rest for part in "ab" for number in range(4)] == [not each for each in seen]


def test_a_test_without_cases_runs_with_one_part_unless_it_distinguishes_them(run):
    found = run("-k", "alone", "-m", "not long")
    assert ("alone a" in found) != ("alone b" in found)
    found = run("-k", "apart", "-m", "not long")
    assert "apart a True" in found and "apart b False" in found
