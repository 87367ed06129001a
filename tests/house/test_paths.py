"""Files that comments and docstrings name are there: who follows a pointer finds what it points to."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from tests.sources import tree

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "src/slewline"
READ = ("src/**/*.py", "tests/**/*.py", "tools/**/*.py", "benchmarks/**/*.py", "docs/_extensions/**/*.py",
        "firmware/**/*.[chS]", "src/slewline/panel/page/**/*.js", "src/slewline/panel/page/**/*.css")  # fmt: skip
IN_THE_ROOT = (
    r"(?:src/slewline|tests|docs|tools|firmware|benchmarks|examples|conformance|templates|share)/[\w.*/-]*\w/?"
)
A_FILE = r"[\w*-]+(?:/[\w*.-]+)*/[\w*-]+\.(?:py|pyi|c|h|S|js|css|md|toml|json)\b"  # elsewhere: in a room of the house
NAMED = re.compile(rf"(?<![\w./<>{{}}-])(?:{IN_THE_ROOT}|{A_FILE})(?![\w/<>{{}}])")
ALONE = re.compile(r"(?<![\w./*<>{}-])\w+\.(?:py|c|h|S|js)\b(?![\w/(])")
MADE = {"test_it.py"}  # what a page shows is written to a file of this name
COMMENT = re.compile(r"/\*.*?\*/|(?<![:\"'])//[^\n]*", re.DOTALL)


def said(file: Path) -> Iterator[str]:
    """Yield comments and docstrings."""
    text = file.read_text("utf-8")
    if file.suffix != ".py":
        yield from COMMENT.findall(text)
        return
    for node in ast.walk(tree(file)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield ast.get_docstring(node) or ""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.string


def missing(text: str, file: Path) -> list[str]:
    """The files and folders that a text names and that are nowhere: in the root, in the sources, or near the file."""
    places = [
        ROOT,
        SOURCES,
        ROOT / "tests",
        ROOT / "examples",
        *(each for each in file.parents if each.is_relative_to(ROOT)),
    ]
    gone = [name for name in NAMED.findall(text) if not any(any(place.glob(name.rstrip("/"))) for place in places)]
    return gone + [name for name in ALONE.findall(text) if name not in names()]


@cache
def names() -> set[str]:
    """The names of all files that are read."""
    return {file.name for pattern in (*READ, "benchmarks/*.c") for file in ROOT.glob(pattern)} | MADE


def test_files_that_comments_and_docstrings_name_are_there() -> None:
    files = [file for pattern in READ for file in sorted(ROOT.glob(pattern))]
    assert len(files) > 1000
    found = [
        f"{file.relative_to(ROOT)}: {name}" for file in files for text in said(file) for name in missing(text, file)
    ]
    assert not found, "\n".join(found)


def test_a_file_that_has_moved_is_found() -> None:
    board = SOURCES / "drive/board/wire.py"
    assert missing("/* The host's half is src/slewline/drive/wire.py. */", board) == ["src/slewline/drive/wire.py"]
    assert missing("src/slewline/drive/board/wire.py, board/twin_board.py, drive/board/*.py, tests/laws", board) == []
    assert missing("see board/none.py or tests/nowhere.", board) == ["board/none.py", "tests/nowhere"]
