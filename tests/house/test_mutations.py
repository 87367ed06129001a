"""The list of mutations fits the source: a lie that is told nowhere any more would be caught by nobody."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_every_mutation_occurs_once_in_the_source_and_names_existing_tests() -> None:
    mutations = tomllib.loads((ROOT / "tools/mutations.toml").read_text("utf-8"))["mutation"]
    house = ROOT / "src/slewline"

    @cache
    def source(within: str) -> str:
        files = [house / within] if (house / within).is_file() else sorted((house / within).rglob("*.py"))
        return "\0".join(path.read_text("utf-8") for path in files)

    def times(one: dict[str, str]) -> int:
        return source(one.get("within", "")).count(one["old"])

    assert [one["name"] for one in mutations if times(one) != 1] == []
    files = {word for one in mutations for word in one["tests"].split() if word.endswith(".py")}
    assert [name for name in sorted(files) if not (ROOT / "tests" / name).is_file()] == []
    names = [one["name"] for one in mutations]
    assert len(names) == len(set(names))
