"""Every fact of conformance.toml has a test that proves it, or a reason why it has none."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_facts_and_tests_agree() -> None:
    table = tomllib.loads((ROOT / "conformance.toml").read_text("utf-8"))
    facts = {row["id"]: row for row in [*table["fact"], *table.get("choice", [])]}
    assert len(facts) == len(table["fact"]) + len(table.get("choice", [])), "an id stands twice"

    tests = "\n".join(path.read_text("utf-8") for path in (ROOT / "tests").glob("test_*.py"))
    marks = re.findall(r"mark\.fact\((.*?)\)", tests, re.DOTALL)
    proven = {fact for mark in marks for fact in re.findall(r'"([^"]+)"', mark)}
    assert proven <= set(facts), "a test names a fact that is in no row"
    assert set(facts) - proven == {fact for fact, row in facts.items() if "open" in row}, "prove it, or say open = ..."
