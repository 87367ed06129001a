"""Every decision that the manual leaves to us names a test, and that test names the decision."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from slewline.chips.cy500.quirks import QUIRKS as CY500
from slewline.chips.cy512.quirks import QUIRKS as CY512
from slewline.chips.cy525.quirks import QUIRKS as CY525
from slewline.chips.cy545.quirks import QUIRKS as CY545
from slewline.chips.gs_c200.quirks import QUIRKS as GS_C200
from slewline.chips.mc1451a.quirks import QUIRKS as MC1451A

QUIRKS = (*CY500, *CY512, *CY525, *CY545, *GS_C200, *MC1451A)
TESTS = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def marked() -> dict[str, set[str]]:
    """Of each test function in a file that names a quirk, all texts and names of marks in its decorators."""
    named = re.compile("|".join(re.escape(quirk.id) for quirk in QUIRKS))
    found: dict[str, set[str]] = {}
    for source in (path.read_text(encoding="utf-8") for path in TESTS.rglob("test_*.py")):
        for node in ast.walk(ast.parse(source)) if named.search(source) else ():
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
                inner = [each for decorator in node.decorator_list for each in ast.walk(decorator)]
                texts = {each.value for each in inner if isinstance(each, ast.Constant) and isinstance(each.value, str)}
                marks = {each.attr for each in inner if isinstance(each, ast.Attribute)}
                found.setdefault(node.name, set()).update(texts | marks)
    return found


@pytest.mark.check
@pytest.mark.parametrize("quirk", QUIRKS, ids=lambda quirk: quirk.id)
def test_a_quirk_is_pinned_by_a_test_that_names_it(quirk, marked: dict[str, set[str]]) -> None:
    assert quirk.test in marked, f"{quirk.test} does not exist"
    assert quirk.id in marked[quirk.test], f"{quirk.test} does not carry {quirk.id}"
    assert marked[quirk.test].isdisjoint({"long", "system"}), f"{quirk.test} does not run in make test"


def test_quirks_are_described_once_and_completely() -> None:
    ids = [quirk.id for quirk in QUIRKS]
    assert len(ids) == len(set(ids))
    assert all(re.match("(CY500-|CY512-|CY545-|GSC-|PMD-)?(UND|CON)-", quirk.id) and all(quirk) for quirk in QUIRKS)
