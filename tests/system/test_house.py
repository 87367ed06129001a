"""The house: modules import in one direction only."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path

SOURCES = Path(__file__).parents[2] / "src"


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


def test_modules_import_in_one_direction() -> None:
    assert circles(modules()) == []


def test_circles_are_found() -> None:
    graph = {"a": {"b"}, "b": {"c", "d"}, "c": {"a"}, "d": {"e"}, "e": {"d", "f"}, "f": set()}
    assert sorted(map(sorted, circles(graph))) == [["a", "b", "c"], ["d", "e"]]


def test_imports_are_read_wherever_they_stand() -> None:
    source = """
from .. import chips
from .wires.net import Net as Wire
import slewline.core.time.hook
if TYPE_CHECKING:
    from ..bench import Bench
def late():
    from .wires import pin
"""
    found = {"slewline.chips", "slewline.core.wires.net.Net", "slewline.core.time.hook", "slewline.bench.Bench"}
    assert set(imported("slewline.core.chip", source, package=False)) == found | {"slewline.core.wires.pin"}
    assert set(imported("slewline.core.wires", "from .net import Net", package=True)) == {"slewline.core.wires.net.Net"}


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


# ------------------------------------------------------------------------------------------------- depth of classes
DEEPEST = 3  # a line chip, the family, the part


def depth(cls: type, room: str) -> int:
    """How many classes of a room stand one upon the other, up to and with this one."""
    if not f"{cls.__module__}.".startswith(f"{room}."):
        return 0
    return 1 + max(depth(base, room) for base in cls.__bases__)


def chip_classes() -> Iterator[type]:
    """All classes that a module of the chips defines."""
    for module in modules():
        if module.startswith("slewline.chips"):
            for thing in vars(import_module(module)).values():
                if isinstance(thing, type) and thing.__module__ == module:
                    yield thing


def test_no_class_of_a_chip_is_more_than_three_deep() -> None:
    found = {f"{cls.__module__}.{cls.__name__}" for cls in chip_classes() if depth(cls, "slewline.chips") > DEEPEST}
    assert not found


def test_only_the_classes_of_the_room_count_in_a_depth_and_the_longest_way_counts() -> None:
    one = type("One", (dict,), {"__module__": "a.room"})
    two = type("Two", (one,), {"__module__": "a.room.inner"})
    other = type("Other", (two,), {"__module__": "a.room_beside"})
    both = type("Both", (type("Mixin", (), {"__module__": "a.room"}), two), {"__module__": "a.room"})
    assert [depth(cls, "a.room") for cls in (dict, one, two, other, both)] == [0, 1, 2, 0, 3]
