"""No file names a chip but those of the chip's own folder, and a few that are listed with their reason.

Chips are listed in one place, shown in a demo, and wired as manuals draw them; docstrings show how one is added.
"""

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
OWN = re.compile(r"chips/(?!cy5xx/)\w+/")  # a folder of a chip, or of several that have one data sheet
FAMILY = "chips/cy5xx/"  # names its family, and no chip of it
WHOLE = ("core/", "language/")  # not even in a docstring or a comment
ALLOWED = {  # files, and why they name chips
    "chips/__init__.py": "the list of chips",
    "chips/cy5xx/letters.py": "which letters the chips of the family exchange",
    "parts/__init__.py": "the list of parts: application circuits, and drivers that manuals sell a chip with",
    "parts/drivers/gsd200.py": "a driver module, a part with this name",
    "parts/motors/drivers.py": "driver modules, which have their names from their maker",
    "parts/drivers/gsc_circuits.py": "application circuits of one manual",
    "cli/weld.cy525": "the demo: a program for it",
    "cli/weld.toml": "the demo: the bench file of it",
    "cli/demo.py": "the demo: a machine of one manual",
    "cli/commands.py": "the help of an option gives an example, and that of the demo says what it shows",
    "cli/modules/module_commands.py": "the help of an option gives an example",
    "cli/modules/module_options.py": "the help of an option gives an example",
    "cli/options/command_kinds.py": "a message gives examples of commands",
    "cli/options/shared.py": "the help of an option gives an example",
    "cli/live/serve.py": "a message gives an example",
    "cli/live/ready_made.py": "the list of firmware, by the part that a board replaces",
    "links/control/rows_of_views.py": "the name of an example, as an example",
    "bench/bench.py": "a message gives an example",
    "bench/circuit.py": "a message gives an example",
    "bench/by_name.pyi": "the generated list of what has which type",
    "testing/plugin.py": "fixtures that are named after their modules",
    "testing/protocol_slewline.py": "a message gives an example",
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


def named(source: str, whole: bool, family: str = "") -> Iterator[tuple[int, str]]:
    """Where a source names a chip: line and text; in docstrings and comments only if `whole`; not `family`."""
    if not NAMED.search(source):
        return
    said = docstrings(ast.parse(source))
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        spoken = token.type == tokenize.COMMENT or (token.type == tokenize.STRING and token.start[0] in said)
        found = {word.lower() for word in NAMED.findall(token.string)} - {family}
        if (whole or not spoken) and found:
            yield token.start[0], token.string[:60]


def names_in(path: Path) -> list[tuple[int, str]]:
    """Where a file of the house names a chip: in its name (line 0), and in what it holds."""
    place = path.relative_to(HOUSE).as_posix()
    found = [(0, path.name)] if NAMED.search(path.name) else []
    if path.suffix in (".py", ".pyi"):
        found += named(
            path.read_text("utf-8"), place.startswith(WHOLE), FAMILY.split("/")[1] * place.startswith(FAMILY)
        )
    else:
        found += [(1, text) for text in NAMED.findall(path.read_text("utf-8"))]
    return found


PLACES = [
    place
    for path in sorted(HOUSE.rglob("*"))
    if path.is_file() and "__pycache__" not in path.parts and not OWN.match(place := path.relative_to(HOUSE).as_posix())
]


@pytest.mark.parametrize("room", sorted({place.split("/")[0] for place in PLACES}))
def test_no_file_names_a_chip(room):
    found = {place: names_in(HOUSE / place) for place in PLACES if place.split("/")[0] == room}
    assert {place: names for place, names in found.items() if names and place not in ALLOWED} == {}
    assert [place for place, names in found.items() if not names and place in ALLOWED] == [], "take them off the list"


def test_every_folder_of_the_house_is_searched_except_those_of_chips():
    folders = {place.split("/")[0] for place in PLACES if "/" in place}
    assert folders == {path.name for path in HOUSE.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert ALLOWED.keys() <= set(PLACES)
    owners = {path.name for path in (HOUSE / "chips").iterdir() if OWN.match(f"chips/{path.name}/")} - {"__pycache__"}
    assert owners == {chip.folder for chip in PARTS.values()}


def test_the_search_finds_names():
    lines = '"""About the CY525."""', "x = is_cy525  # GS-C200", 'y = f"{x} of MC1451A"', 'z = "cyan gsm mc"', "Cy5xx"
    source = "\n".join(lines)
    assert [line for line, _ in named(source, whole=False)] == [2, 3, 5]
    assert [line for line, _ in named(source, whole=True)] == [1, 2, 2, 3, 5]
    assert [line for line, _ in named(source, whole=False, family="cy5xx")] == [2, 3]
