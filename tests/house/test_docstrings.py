"""Docstrings of public functions say what a call does, not what the world is like: "Return ...", "Draw ..."."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.sources import tree

SOURCES = Path(__file__).parents[2] / "src/slewline"
ROOMS = ("core", "record", "parts", "bench", "links", "cli", "testing")
# How a sentence begins that describes a state of the world, or asks for one.
STATES = re.compile(
    r"(A|All|An|Are|As|Be|By|Can|Does|Each|Edges|Every|From|Has|How|In|Instants?|Is|It|Its|Levels?|May|Neither|No|Nobody|Not"
    r"|Nothing|Of|Some|Somebody|Something|That|The|There|These|They|This|Time|To|True|Under|What|When|Where|Whether|Which"
    r"|Who|Whose|Will|\w+ion)\W?"
)


def is_property(node: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    return any("property" in ast.unparse(one) or "setter" in ast.unparse(one) for one in node.decorator_list)


def functions(tree: ast.AST) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    """The public functions and methods of a module, but for properties: these are named by a noun."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and node.name.startswith("_"):
            continue
        if isinstance(node, ast.ClassDef):
            yield from functions(node)
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and not is_property(node):
            yield node


def stated(parsed: ast.Module) -> list[str]:
    """The docstrings that are no imperatives, each after the name of its function."""
    found = []
    for node in functions(parsed):
        words = (ast.get_docstring(node) or "Return").split()
        if STATES.fullmatch(words[0]):
            found.append(f"{node.name}: {' '.join(words[:8])}")
    return found


@pytest.mark.parametrize("room", ROOMS)
def test_docstrings_of_public_functions_are_imperatives(room) -> None:
    paths = sorted((SOURCES / room).glob("*.py"))
    assert paths
    found = {path.name: lines for path in paths if (lines := stated(tree(path)))}
    assert found == {}


def test_a_state_of_the_world_is_told_from_an_imperative() -> None:
    source = """
def begun(): "The same, of those steps that count."
def over(): "Is it over?"
def met(): "Condition: it is met."
def start(): "Start the clock."
def _hidden(): "The rest."
class Clock:
    @property
    def now(self): "The present instant."
    def tick(self): "Return the tick."
"""
    assert [line.partition(":")[0] for line in stated(ast.parse(source))] == ["begun", "over", "met"]
