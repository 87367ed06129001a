"""Each promise of SECURITY.md has its tests."""

from __future__ import annotations

import re
import tomllib

from tests.sources import text

from .blocks import ROOT

TESTS = tomllib.loads(text(ROOT / "tests/security.toml"))


def test_each_promise_has_tests():
    table = text(ROOT / "SECURITY.md").partition("| untrusted input or client |")[2].partition("\n\n")[0]
    promises = [row.split("|")[1].strip() for row in table.splitlines()[2:]]
    assert len(promises) > 5
    assert promises == [*TESTS]


def test_the_tests_are_there():
    for promise, names in TESTS.items():
        assert names, promise
        for name in names:
            file, _, test = name.partition("::")
            assert re.search(rf"^def {test}\(", text(ROOT / "tests" / file), re.MULTILINE), name
