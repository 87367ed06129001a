"""The list of mutations fits the source: a lie that is told nowhere any more would be caught by nobody."""

from __future__ import annotations

import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_every_mutation_stands_once_in_the_source_and_names_tests_that_are_there() -> None:
    mutations = tomllib.loads((ROOT / "tools/mutations.toml").read_text("utf-8"))["mutation"]
    sources = {path: path.read_text("utf-8") for path in (ROOT / "src/slewline").rglob("*.py")}

    def times(one: dict[str, str]) -> int:
        within = ROOT / "src/slewline" / one.get("within", "")
        return sum(text.count(one["old"]) for path, text in sources.items() if path.is_relative_to(within))

    assert [one["name"] for one in mutations if times(one) != 1] == []
    files = {word for one in mutations for word in one["tests"].split() if word.endswith(".py")}
    assert [name for name in sorted(files) if not (ROOT / "tests" / name).is_file()] == []
    names = [one["name"] for one in mutations]
    assert len(names) == len(set(names))
