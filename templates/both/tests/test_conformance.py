"""Every fact of conformance.toml has a test that proves it, or a reason why it has none."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_facts_and_tests_agree() -> None:
    table = tomllib.loads((ROOT / "conformance.toml").read_text("utf-8"))
    rows = [*table["fact"], *table.get("choice", [])]
    facts = {row["id"]: row for row in rows}
    assert len(facts) == len(rows), "two rows have the same id"

    tests = "\n".join(path.read_text("utf-8") for path in (ROOT / "tests").glob("test_*.py"))
    marks = re.findall(r"mark\.fact\((.*?)\)", tests, re.DOTALL)
    proven = {fact for mark in marks for fact in re.findall(r'"([^"]+)"', mark)}
    left_open = {fact for fact, row in facts.items() if "open" in row}
    for wrong, why in (
        (proven - set(facts), "a test names it, but no row has it"),
        (set(facts) - proven - left_open, 'no test proves it, and its row does not state why (open = "...")'),
        (proven & left_open, "open, but a test proves it"),
    ):
        assert not wrong, f"{', '.join(sorted(wrong))}: {why}"
