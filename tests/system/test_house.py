"""The house: modules import in one direction only."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path

SOURCES = Path(__file__).parents[2] / "src"

ANATOMY = (
    "one chip in several modules that know one another; they become objects with faces of their own in another change"
)
CIRCLES = {  # that are there still: modules, and why
    "chips.gs_c200": ("firmware instructions stepwise", ANATOMY),
    "chips.mc1451a": (
        "cycles firmware horizon ideal instructions motion port pulses quantities registers stepwise stepwise_axis "
        "stepwise_inputs trajectory updates",
        ANATOMY,
    ),
}


def imported(module: str, source: str, package: bool) -> Iterator[str]:
    """What a module imports, at its head, inside functions, and for type checkers."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom):
            above = module.split(".")[: -node.level + package or None] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            yield from (f"{base}.{name.name}" for name in node.names)
        elif isinstance(node, ast.Import):
            yield from (name.name for name in node.names)


def modules() -> dict[str, set[str]]:
    """All modules of slewline, and those that each imports.

    `slewline` itself is a face: it takes a name from below when somebody asks for it, and is imported for its version.
    """
    files = {}
    for path in sorted(SOURCES.rglob("*.py")):
        parts = path.relative_to(SOURCES).with_suffix("").parts
        files[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    graph = {}
    for module, path in files.items():
        found = set(imported(module, path.read_text(), path.name == "__init__.py"))
        names = {name if name in files else name.rpartition(".")[0] for name in found}
        graph[module] = names & set(files) - {module, "slewline"}
    return graph


def circles(graph: Mapping[str, set[str]]) -> list[frozenset[str]]:
    """Modules that import one another, in groups as large as possible (Tarjan)."""
    number: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(module: str) -> None:
        number[module] = low[module] = len(number)
        stack.append(module)
        for other in sorted(graph[module]):
            if other not in number:
                visit(other)
            if other in stack:
                low[module] = min(low[module], low[other])
        if low[module] == number[module]:
            at = stack.index(module)
            group = frozenset(stack[at:])
            del stack[at:]
            if len(group) > 1:
                found.append(group)

    for module in sorted(graph):
        if module not in number:
            visit(module)
    return found


def test_modules_import_in_one_direction_but_for_the_circles_that_are_listed() -> None:
    known = [{f"slewline.{room}.{name}" for name in names.split()} for room, (names, _) in CIRCLES.items()]
    found = circles(modules())
    assert [sorted(group) for group in found if not any(group <= allowed for allowed in known)] == []
    gone = [sorted(allowed) for allowed in known if not any(group & allowed for group in found)]
    assert gone == [], "these circles are gone: take them off the list"


def test_circles_are_found() -> None:
    graph = {"a": {"b"}, "b": {"c", "d"}, "c": {"a"}, "d": {"e"}, "e": {"d", "f"}, "f": set()}
    assert sorted(map(sorted, circles(graph))) == [["a", "b", "c"], ["d", "e"]]


def test_imports_are_read_wherever_they_stand() -> None:
    source = """
from .. import chips
from .net import Net as Wire
import slewline.core.hook
if TYPE_CHECKING:
    from ..bench import Bench
def late():
    from . import pin
"""
    found = {"slewline.chips", "slewline.core.net.Net", "slewline.core.hook", "slewline.bench.Bench"}
    assert set(imported("slewline.core.chip", source, package=False)) == found | {"slewline.core.pin"}
    assert set(imported("slewline.core", "from .net import Net", package=True)) == {"slewline.core.net.Net"}


def bound(tree: ast.AST) -> Iterator[str]:
    """The names that are given a meaning somewhere in a module, but for those that are imported."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id


def test_the_type_of_a_time_is_defined_once() -> None:
    homes = [
        path
        for path in SOURCES.rglob("*.py")
        if "Time" in (source := path.read_text()) and "Time" in bound(ast.parse(source))
    ]
    assert [path.name for path in homes] == ["timebase.py"]
