"""The house knows no chip by name, but where chips are listed, shown, or wired as a manual draws them."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

from slewline.chips import PARTS

HOUSE = Path(__file__).parents[2] / "src/slewline"
FAMILIES = ("cy5[0-9]{2}", "cy5xx", "gs[-_]?c", "gs[-_]?d200", "gsc", "mc1[0-9]{3}a?", "mc1x51")
NAMED = re.compile("|".join([*map(re.escape, PARTS), *FAMILIES]), re.IGNORECASE)
WHOLE = ("core", "language")  # not even in a comment
CODE = ("bench", "links", "cli")  # in no name and no text; docstrings may show how a part is added
ALLOWED = {
    "cli/demo.py": "the demo: a machine of one manual",
    "cli/commands.py": "the help of an option gives an example",
    "cli/serve.py": "a message gives an example",
    "bench/furnishing.py": "a message gives an example",
}


def docstrings(tree: ast.AST) -> set[int]:
    """The lines on which docstrings begin."""
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    bodies = [node.body for node in ast.walk(tree) if isinstance(node, kinds)]
    return {
        body[0].lineno
        for body in bodies
        if body and isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant)
    }


def named(path: Path, whole: bool) -> Iterator[tuple[int, str]]:
    """Where a source file names a chip: line and text; in docstrings and comments only if `whole`."""
    source = path.read_text("utf-8")
    said = docstrings(ast.parse(source))
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        spoken = token.type == tokenize.COMMENT or (token.type == tokenize.STRING and token.start[0] in said)
        if (whole or not spoken) and NAMED.search(token.string):
            yield token.start[0], token.string[:60]


FILES = [(folder, path) for folder in (*WHOLE, *CODE) for path in sorted((HOUSE / folder).rglob("*.py"))]


@pytest.mark.parametrize(("folder", "path"), FILES, ids=[str(path.relative_to(HOUSE)) for _, path in FILES])
def test_no_file_names_a_chip(folder, path):
    found = list(named(path, folder in WHOLE))
    if str(path.relative_to(HOUSE)) in ALLOWED:
        assert found, "it names none any more: take it off the list"
    else:
        assert not found


def test_the_search_finds_names(tmp_path):
    file = tmp_path / "one.py"
    file.write_text('"""About the CY525."""\nx = is_cy525  # GS-C200\ny = f"a {x} of MC1451A"\nz = "cyan gsm mc"\n')
    assert [line for line, _ in named(file, whole=False)] == [2, 3]
    assert [line for line, _ in named(file, whole=True)] == [1, 2, 2, 3]
