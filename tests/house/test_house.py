"""The house: modules import in one direction only."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path

from tests.sources import SOURCES, text, tree


def imported(module: str, parsed: ast.Module, package: bool) -> Iterator[str]:
    """What a module imports, at its head, inside functions, and for type checkers."""
    for node in ast.walk(parsed):
        if isinstance(node, ast.ImportFrom):
            above = module.split(".")[: -node.level + package or None] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            yield from (f"{base}.{name.name}" for name in node.names)
        elif isinstance(node, ast.Import):
            yield from (name.name for name in node.names)


@cache
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
        found = set(imported(module, tree(path), path.name == "__init__.py"))
        names = {name if name in files else name.rpartition(".")[0] for name in found}
        graph[module] = names & set(files) - {module, "slewline"}
    graph["slewline.links.face"] = set()  # it has the types of all rooms of the links, and nothing that runs
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


def test_the_face_of_a_server_imports_nothing_that_runs() -> None:
    body = tree(SOURCES / "slewline/links/face.py").body
    found = {getattr(node, "module", "") for node in body if isinstance(node, ast.Import | ast.ImportFrom)}
    assert found == {
        "__future__",
        "collections.abc",
        "typing",
    }


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
    assert set(imported("slewline.core.chip", ast.parse(source), package=False)) == found | {"slewline.core.wires.pin"}
    of_package = set(imported("slewline.core.wires", ast.parse("from .net import Net"), package=True))
    assert of_package == {"slewline.core.wires.net.Net"}


def bound(tree: ast.AST) -> Iterator[str]:
    """The names that are given a meaning somewhere in a module, but for those that are imported."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id


def test_the_type_of_a_time_is_defined_once() -> None:
    homes = [path for path in SOURCES.rglob("*.py") if "Time" in text(path) and "Time" in bound(tree(path))]
    assert [path.name for path in homes] == ["timebase.py"]


# ------------------------------------------------------------------------------------------------- depth of classes
DEEPEST = (
    4  # component, chip, family, part; component, part, host, the host of a channel; ... board, the board of a bus
)
ELSEWHERE = 3  # what is neither


def depth(cls: type) -> int:
    """How many classes of slewline stand one upon the other, up to and with this one."""
    return cls.__module__.startswith("slewline.") + max((depth(base) for base in cls.__bases__), default=0)


def classes() -> Iterator[type]:
    """All classes of slewline; protocols and exceptions stand for nothing that is built on."""
    for module in modules():
        if not module.endswith("__main__"):
            for thing in vars(import_module(module)).values():
                ours = isinstance(thing, type) and thing.__module__ == module
                if ours and not (issubclass(thing, BaseException) or getattr(thing, "_is_protocol", False)):
                    yield thing


def test_no_class_has_a_deep_stack_of_bases() -> None:
    from slewline.core.chip import Chip
    from slewline.parts.boards.board import Board
    from slewline.parts.hosts.host import Host

    too_deep = {
        f"{cls.__module__}.{cls.__name__}": depth(cls)
        for cls in classes()
        if depth(cls) > (DEEPEST if issubclass(cls, (Board, Chip, Host)) else ELSEWHERE)
    }
    assert not too_deep


def test_only_our_classes_count_in_a_depth_and_the_longest_path_counts() -> None:
    one = type("One", (dict,), {"__module__": "slewline.room"})
    two = type("Two", (one,), {"__module__": "slewline.room.inner"})
    other = type("Other", (two,), {"__module__": "a.room"})
    both = type("Both", (type("Mixin", (), {"__module__": "slewline.room"}), two), {"__module__": "slewline.room"})
    assert [depth(cls) for cls in (dict, one, two, other, both)] == [0, 1, 2, 2, 3]


# ------------------------------------------------------------------------------------------------------------ rooms
MOST_FILES = 15  # in a room; what a visitor takes in


def test_a_room_has_few_files_and_its_first_line_describes_them() -> None:
    for folder in (path.parent for path in (SOURCES / "slewline").rglob("__init__.py")):
        room = folder.relative_to(SOURCES / "slewline").as_posix()
        assert len([*folder.glob("*.py")]) <= MOST_FILES, room
        said = ast.get_docstring(tree(folder / "__init__.py"))
        assert said and len(said.splitlines()[0]) > 30, room


# Chips have the same chapters, so that who knows one finds the way in all; any other file has a name of its own, so
# that the tab of an editor shows which one it is.
CHAPTERS = {
    "activity", "checks", "firmware", "ideal", "instructions", "interpreter", "motion",
    "profile", "quirks", "ramps", "registers", "sheet", "supply", "twin",
}  # fmt: skip
PYTHONS_OWN = {"__init__", "__main__"}


def recurring(files: Iterable[str]) -> dict[str, list[str]]:
    """Names of files that occur more than once, with where they are, but for chapters of chips and Python's own."""
    found: dict[str, list[str]] = {}
    for file in files:
        found.setdefault(Path(file).stem, []).append(file)
    return {
        name: places
        for name, places in found.items()
        if len(places) > 1
        and name not in PYTHONS_OWN
        and not (name in CHAPTERS and all(place.startswith("chips/") for place in places))
    }


def test_a_file_name_is_unique_except_for_the_chapters_of_chips() -> None:
    files = [path.relative_to(SOURCES / "slewline").as_posix() for path in (SOURCES / "slewline").rglob("*.py")]
    assert recurring(files) == {}
    assert {name for name in CHAPTERS if len([file for file in files if Path(file).stem == name]) > 1} == CHAPTERS


def test_a_recurring_name_is_found() -> None:
    chips = ["chips/a/twin.py", "chips/b/twin.py", "chips/a/__init__.py", "core/__init__.py"]
    assert recurring(chips) == {}
    assert recurring([*chips, "drive/twin.py"]) == {"twin": ["chips/a/twin.py", "chips/b/twin.py", "drive/twin.py"]}
    assert recurring(["drive/state.py", "labs/state.py"]) == {"state": ["drive/state.py", "labs/state.py"]}


LONGEST = 400  # lines of a module
LONGER = {
    "chips/mc1451a/sheet.py": "a data sheet of 74 commands and ten parts: tables",
    "chips/mc1451a/twin/twin_axis.py": "the twin of eight modules, which shares nothing with them",
    "core/chip.py": "all that a bench asks of a chip; a family overrides it where it differs",
    "core/datasheet/table.py": "the rows of a sheet, which refer to one another",
    "core/motion/axis.py": "one past, and all that is asked of it",
    "core/wires/net.py": "drivers and nets commit together, on the path that everything takes",
    "core/wires/views.py": "one small class for each way in which promises compose",
    "language/ramp_answers.py": "what a calculator is asked, and the search, over the same values",
}


def test_a_longer_module_has_a_reason() -> None:
    lines = {
        path.relative_to(SOURCES / "slewline").as_posix(): len(text(path).splitlines())
        for path in (SOURCES / "slewline").rglob("*.py")
    }
    assert {name for name, count in lines.items() if count > LONGEST} == set(LONGER)


# ------------------------------------------------------------------------------------------------------------ drive
def written(parsed: ast.AST, value: str) -> Iterator[str]:
    """The attributes of something of this name that a module writes: `value.name = ...`, `self.value.name += ...`."""
    for node in ast.walk(parsed):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store | ast.Del):
            of = node.value
            if (isinstance(of, ast.Name) and of.id == value) or (isinstance(of, ast.Attribute) and of.attr == value):
                yield node.attr


def test_no_piece_of_a_drive_knows_the_drive() -> None:
    pieces = {name: found for name, found in modules().items() if name.startswith("slewline.drive.")}
    assert [name for name, found in pieces.items() if "slewline.drive.motor_drive" in found] == []
    for path in (SOURCES / "slewline/drive").rglob("*.py"):
        nodes = [*ast.walk(tree(path))]
        named = {node.id for node in nodes if isinstance(node, ast.Name)}
        kept = {node.attr for node in nodes if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)}
        assert path.name == "motor_drive.py" or not {"Drive", "drive", "_drive"} & (named | kept), path


def test_the_state_of_a_drive_has_one_owner() -> None:
    for path in (SOURCES / "slewline/drive").rglob("*.py"):
        found = [*written(tree(path), "state"), *written(tree(path), "_state")]
        assert path.name == "drive_state.py" or not found, path
    assert [
        *written(ast.parse("state.phase = 1; self.state.final |= 2; self.state = 3; x = state.phase"), "state")
    ] == [
        "phase",
        "final",
    ]


# ------------------------------------------------------------------------------------------------------------- names
TWICE = {"Decoder", "Serial"}  # of each dialect that is decoded; pySerial's and serialx's own word
FIELD = {"translation/meaning.py"}  # what a program does, in the field's terms


def test_a_class_name_is_that_of_one_class_except_the_roles_of_every_chip() -> None:
    places: dict[str, list[str]] = {}
    for path in (SOURCES / "slewline").rglob("*.py"):
        for node in tree(path).body:
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name, []).append(path.relative_to(SOURCES / "slewline").as_posix())
    places = {name: [each for each in where if each not in FIELD] for name, where in places.items()}
    twice = {name: where for name, where in places.items() if len(where) > 1}
    assert {name for name, where in twice.items() if not all(each.startswith("chips/") for each in where)} == TWICE


# ----------------------------------------------------------------------------------------------------------- messages
def said(parsed: ast.AST) -> Iterator[str]:
    """The texts of a source that are no docstrings."""
    docstrings = {
        id(node.body[0].value)
        for node in ast.walk(parsed)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        and node.body
        and isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(parsed):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            yield node.value


def advises_removal(message: str) -> bool:
    return re.search(r"(remove|delete) (it|this one|the (file|link|folder))\b", message) is not None


def test_nobody_is_advised_to_remove_a_file() -> None:
    """What is in the way may be all that somebody has of it."""
    assert advises_removal("this file exists; name a new file, or remove it") and not advises_removal("remove the line")
    found = {path.name: each for path in SOURCES.rglob("*.py") for each in said(tree(path)) if advises_removal(each)}
    assert not found


def test_every_warning_points_to_the_line_of_the_user():
    """How many calls lie between differs, and a decorator makes it one more: `level_of_caller` counts them."""
    found = {}
    for path in SOURCES.rglob("*.py"):
        for node in ast.walk(tree(path)):
            if isinstance(node, ast.Call) and ast.unparse(node.func) == "warnings.warn":
                levels = [ast.unparse(each.value) for each in node.keywords if each.arg == "stacklevel"]
                found[f"{path.name}:{node.lineno}"] = any(each.startswith("level_of_caller(") for each in levels)
    assert len(found) >= 4 and all(found.values()), found
