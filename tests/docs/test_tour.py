"""The reading tour names twelve files, pieces of them that exist, and as many lines as there are to read."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from tests.sources import text, tree

from .blocks import ROOT

PAGE = (ROOT / "docs/explanation/tour.md").read_text("utf-8")
STOPS = re.findall(r"^### (\d+)\. `([\w/.]+)`\n\nRead (.*?)\.(?:\n| )(.*?)(?=^##)", PAGE, re.MULTILINE | re.DOTALL)
TOLD = 0.1  # by how much the lines may differ from those that the page tells


def found(path: str) -> Path:
    """Return a file of the page: below the package, or in the clone."""
    return next(file for top in ("src/slewline", ".") if (file := ROOT / top / path).is_file())


def pieces(path: Path) -> dict[str, int]:
    """Return how many lines the head, the classes, functions and methods of a file have."""
    module = tree(path)
    lines = {"the head": module.body[0].end_lineno}
    for node in module.body:
        for prefix, one in ((node, node), *((node, inner) for inner in getattr(node, "body", ()))):
            if isinstance(one, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
                name = one.name if prefix is one else f"{getattr(prefix, 'name', '')}.{one.name}"
                first = min(one.lineno, *(each.lineno for each in one.decorator_list), one.lineno)
                lines[name] = one.end_lineno - first + 1
    return lines


def read(path: str, what: str) -> int:
    """Return how many lines of a file are to be read."""
    if what.startswith("all of it"):
        return len(text(found(path)).splitlines())
    lines = pieces(found(path))
    return sum(lines[name] for name in [*re.findall(r"`([\w.]+)`", what), *re.findall("the head", what)])


def test_there_are_twelve_stops_in_their_order():
    assert [int(number) for number, *_ in STOPS] == list(range(1, 13))
    assert len({path for _, path, *_ in STOPS}) == 12


@pytest.mark.parametrize(("path", "what", "rest"), [stop[1:] for stop in STOPS], ids=[stop[1] for stop in STOPS])
def test_a_stop_states_its_reading_length_and_has_a_question_with_its_answer(path, what, rest):
    (said,) = re.findall(r"(\d+)\s+lines", what)
    lines = read(path, what)
    assert abs(lines - int(said)) <= TOLD * lines, f"{lines} lines"
    order = ("\nLook for: ", "\nQuestion: ", "\n<details><summary>Answer</summary>\n\n", "\n\n</details>\n")
    places = [rest.index(each) for each in order]
    assert places == sorted(places) and [rest.count(each) for each in order] == [1] * 4
    assert ("\nNext: " in rest) == (path != STOPS[-1][1])


def test_the_page_states_the_total_number_of_lines():
    (said,) = re.findall(r"some ([\d,]+) lines in twelve files", PAGE)
    lines = sum(read(path, what) for _, path, what, _ in STOPS)
    assert abs(lines - int(said.replace(",", ""))) <= TOLD / 4 * lines, f"{lines} lines"


def test_the_model_of_each_kind_of_test_exists():
    rows = re.findall(r"^\| [\w ]+ \| `(test_\w+)` in `([\w/.]+)` \|", PAGE, re.MULTILINE)
    assert len(rows) == 7
    assert [name for name, path in rows if f"def {name}(" not in text(ROOT / path)] == []


def test_the_files_and_tables_of_the_exercises_exist():
    exercises = PAGE.split("## Now try")[1]
    files = {path: found(path) for path in re.findall(r"`([\w/.]+/\w+\.(?:py|toml|h|md))`", exercises)}
    assert len(files) >= 12
    named = set(re.findall(r"`([A-Z]+[A-Z_]*)`", exercises))
    assert {"QUIRKS", "REQUESTS", "BOARDS", "A_PIN"} <= named
    assert [name for name in named if not any(re.search(rf"\b{name}\b", text(file)) for file in files.values())] == []
