"""The past comes back under one name, `Past.at`: only the file of choice names the two ways behind it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from tests.sources import SOURCES, tree

SHADOWS = {"bench/past.py"}
PROCESSES = {"links/time/checkpoints.py", "links/time/worlds.py"}
CHOICE = {"links/time/server_past.py"}
NAMES = {  # what names a way, and the files that may
    **dict.fromkeys(("ShadowBench", "shadows"), SHADOWS | CHOICE),
    **dict.fromkeys(("Checkpoint", "Checkpoints", "checkpoints", "fork_checkpoint"), PROCESSES | CHOICE),
    **dict.fromkeys(("World", "worlds"), PROCESSES),
    **dict.fromkeys(("LineTap", "LineTaps", "record_same"), {"links/time/bench_exchange.py"} | CHOICE),
}
ASKERS = {"rerun": {"drive/stopping/rewind.py"}, "world": {"links/time/branches.py"}}


def nodes(root: Path) -> Iterator[tuple[str, ast.AST]]:
    """Yield each node of all sources, with its file."""
    for path in sorted(root.rglob("*.py")):
        for node in ast.walk(tree(path)):
            yield path.relative_to(root).as_posix(), node


def names(node: ast.AST) -> set[str]:
    """Return the names in a node, without those in the nodes below it."""
    if isinstance(node, ast.ImportFrom):
        return {*(node.module or "").split("."), *(each.name for each in node.names)}
    if isinstance(node, ast.Import):
        return {part for each in node.names for part in each.name.split(".")}
    return {getattr(node, field) for field in ("id", "attr", "name") if isinstance(getattr(node, field, None), str)}


def strangers(root: Path) -> set[tuple[str, str]]:
    """Return the files that name a way back and may not, each with the name."""
    found = ((file, name) for file, node in nodes(root) for name in names(node))
    return {(file, name) for file, name in found if file not in NAMES.get(name, {file})}


def asked(root: Path) -> tuple[dict[str, set[str]], set[str]]:
    """Return who brings the past back, by what becomes of the instant; and the files that do so without `at`."""
    through: dict[str, set[str]] = {name: set() for name in ASKERS}
    without: set[str] = set()
    for file, node in nodes(root):
        if isinstance(node, ast.Attribute) and node.attr in ASKERS and file not in CHOICE:
            value = node.value
            if isinstance(value, ast.Call) and isinstance(value.func, ast.Attribute) and value.func.attr == "at":
                through[node.attr].add(file)
            else:
                without.add(file)
    return through, without


def test_going_back_is_named_only_in_the_file_of_choice() -> None:
    assert strangers(SOURCES / "slewline") == set()


def test_each_name_for_going_back_still_exists() -> None:
    there = {name for file, node in nodes(SOURCES / "slewline") for name in names(node)}
    assert NAMES.keys() <= there


def test_the_past_is_brought_back_at_an_instant() -> None:
    assert asked(SOURCES / "slewline") == (ASKERS, set())


def test_a_file_that_goes_around_the_name_is_found(tmp_path: Path) -> None:
    (tmp_path / "views.py").write_text(
        "from ..time import checkpoints\n\ndef back(past):\n    return past.shadows, past.rerun([], 0)\n"
    )
    assert strangers(tmp_path) == {("views.py", "checkpoints"), ("views.py", "shadows")}
    assert asked(tmp_path) == ({"rerun": set(), "world": set()}, {"views.py"})
