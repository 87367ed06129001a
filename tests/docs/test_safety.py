"""Each hazard of the page about safety has its tests."""

from __future__ import annotations

import re
import tomllib

from tests.sources import text

from .blocks import ROOT

TESTS = tomllib.loads(text(ROOT / "tests/firmware/hazards.toml"))
PAGE = text(ROOT / "docs/explanation/safety.md")


def causes(page):
    """The second column of the table of hazards."""
    table = page.partition("| hazard | cause |")[2].partition("\n\n")[0]
    return [row.split("|")[2].strip() for row in table.splitlines()[2:]]


def test_each_cause_of_a_hazard_has_tests():
    assert len(causes(PAGE)) > 15
    assert set(causes(PAGE)) == set(TESTS)


def test_the_tests_are_there():
    for cause, names in TESTS.items():
        assert names, cause
        for name in names:
            file, _, test = name.partition("::")
            assert re.search(rf"^def {test}\(", text(ROOT / "tests" / file), re.MULTILINE), name
