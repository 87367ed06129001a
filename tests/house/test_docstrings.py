"""Docstrings of public functions say what a call does, not what the world is like: "Return ...", "Draw ...".

A method that does what its base says has no docstring of its own: `help` and the pages show that of the base.
"""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import Any

import pytest

import slewline
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


def test_a_state_is_distinguished_from_an_imperative() -> None:
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


# --------------------------------------------------------------------------------------------------------- inherited
def classes() -> Iterator[type]:
    """All classes of the package, each once."""
    for module in walk_packages(slewline.__path__, "slewline."):
        if not module.name.endswith("__main__"):
            found = import_module(module.name)
            yield from (own for own in vars(found).values() if inspect.isclass(own) and own.__module__ == module.name)


def methods(cls: type) -> Iterator[tuple[str, Any, Any]]:
    """The methods and properties that a class defines, by name, each with what it overrides; None: nothing."""
    for name, own in vars(cls).items():
        defined = own.fget if isinstance(own, property) else getattr(own, "__func__", own)
        if inspect.isfunction(defined) and defined.__qualname__.endswith(f"{cls.__name__}.{name}"):
            yield name, own, next((vars(base)[name] for base in cls.__mro__[1:] if name in vars(base)), None)


def own_text(method: Any) -> str:
    return inspect.cleandoc(getattr(method, "__func__", method).__doc__ or "")


def repeated(found: Iterable[type]) -> list[str]:
    """The overrides whose docstring is, word for word, that of what they override."""
    return [
        f"{cls.__module__}.{cls.__qualname__}.{name}"
        for cls in found
        for name, own, base in methods(cls)
        if base is not None and (text := own_text(own)) and text == own_text(base)
    ]


def undescribed(found: Iterable[type]) -> list[str]:
    """The public methods of public classes for which `help` has no text, neither their own nor that of a base."""
    return [
        f"{cls.__module__}.{cls.__qualname__}.{name}"
        for cls in found
        for name, own, _ in methods(cls)
        if not (cls.__name__.startswith("_") or name.startswith("_") or inspect.getdoc(getattr(cls, name, own)))
    ]


@pytest.mark.check
def test_no_override_repeats_the_docstring_of_its_base() -> None:
    assert repeated(classes()) == [], "these repeat their base word for word: delete the docstring"


@pytest.mark.check
def test_every_public_method_has_a_docstring_or_overrides_one_that_has() -> None:
    assert undescribed(classes()) == []


def test_a_docstring_that_is_repeated_or_missing_is_found() -> None:
    class Base:
        def said(self) -> None:
            """Say it."""

        @property
        def size(self) -> int:
            """The size."""
            return 0

        def silent(self) -> None: ...

    class Heir(Base):
        def said(self) -> None:
            """Say it."""

        @property
        def size(self) -> int:
            return 1

        def silent(self) -> None: ...

    Base.__qualname__, Heir.__qualname__ = "Base", "Heir"
    assert [name.rpartition(".")[2] for name in repeated([Base, Heir])] == ["said"]
    assert [name.partition("test_docstrings.")[2] for name in undescribed([Base])] == ["Base.silent"]
