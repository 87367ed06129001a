"""What a module of the sources defines, something reads: another line of it, another file, a test, a tool or a page."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

from tests.sources import text, tree

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "src"
READERS = ("src", "tests", "tools", "benchmarks", "examples", "docs/_extensions")
PAGES = ("README.md", "pyproject.toml", "docs/**/*.md", "docs/*.py", "templates/**/*")
CALLED = {"pytest_configure"}  # by pytest, which finds its hooks by their names
WORD = re.compile(r"\b[A-Za-z_]\w*\b")


def defined(parsed: ast.Module) -> list[str]:
    """Names of constants, functions and classes of a module; a decorator may put what it decorates to use."""
    found = []
    for node in parsed.body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            found += [] if node.decorator_list and not isinstance(node, ast.ClassDef) else [node.name]
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found += [
                part.id
                for target in targets
                for part in ast.walk(target)
                if isinstance(part, ast.Name) and part.id.isupper() and not part.id.startswith("__")
            ]
    return found


def read_inside(parsed: ast.Module) -> set[str]:
    """Names that a module reads, its strings among them: annotations, names of methods that are looked up."""
    names = {node.id for node in ast.walk(parsed) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
    return names | read_elsewhere(parsed)


def read_elsewhere(parsed: ast.Module) -> set[str]:
    """Names that a module takes from others: imports, attributes, words of its strings."""
    found = set()
    for node in ast.walk(parsed):
        if isinstance(node, ast.ImportFrom | ast.Import):
            found |= {word for alias in node.names for word in alias.name.split(".")}
        elif isinstance(node, ast.Attribute):
            found.add(node.attr)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found |= set(WORD.findall(node.value))
    return found


def dead(parsed: ast.Module, others: set[str]) -> list[str]:
    """The names that a module defines, and that neither it nor another file reads."""
    names = defined(parsed)
    inside = read_inside(parsed) if names else set()
    return [name for name in names if name not in inside and name not in others]


@cache
def readers() -> tuple[tuple[Path, frozenset[str]], ...]:
    """Every file that may read a name, and what it reads."""
    files = [file for folder in READERS for file in sorted((ROOT / folder).rglob("*.py"))]
    pages = [page for pattern in PAGES for page in sorted(ROOT.glob(pattern)) if page.is_file()]
    return (
        *((file, frozenset(read_elsewhere(tree(file)))) for file in files),
        *((page, frozenset(WORD.findall(text(page)))) for page in pages),
    )


def test_every_definition_is_read() -> None:
    others = CALLED | {name for _, names in readers() for name in names}
    found = [
        f"{file.relative_to(ROOT)}: {name}"
        for file in sorted(SOURCES.rglob("*.py"))
        for name in dead(tree(file), others)
    ]
    assert found == []


def test_a_name_that_nothing_reads_is_found() -> None:
    source = "LOST, READ = 1, 2\nTABLE: int = READ\ndef gone(): pass\ndef used(): pass\nclass Left: pass\nused()\n"
    assert dead(ast.parse(source), {"TABLE"}) == ["LOST", "gone", "Left"]
