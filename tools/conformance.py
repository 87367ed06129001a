"""Print how much of each data sheet is proven by tests, and the open facts.

    python tools/conformance.py            the tables: per sheet and kind, and the open facts with their reasons
    python tools/conformance.py --check    fail if tables and tests disagree

The table of a sheet is in conformance/<chip folder>/*.toml: `[[fact]]` with id, kind, says, and parts if it applies to
some of them only, and `[[choice]]` for a decision of the model.  A fact without a test has `open` with the reason, or
`later` if it needs a part that is not available; such a fact does not count.  Tests carry the ids in
`@pytest.mark.fact("CMD-A-1")`.

conformance/readme is the table of the first page: the negations and restrictions of README.md, word for word.
"""

from __future__ import annotations

import argparse
import ast
import sys
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from slewline.chips import PARTS

ROOT = Path(__file__).resolve().parent.parent
PROVEN = ("language", "protocol", "pin", "motion", "timing", "limit")  # every fact of these kinds
SYSTEM_SHARE = 0.90  # of kind system


@dataclass
class Table:
    """Facts and choices of a data sheet, by id."""

    title: str  # the parts that it describes; or README
    about: str = "The statements of the manual, and the tests that prove them."
    facts: dict[str, dict[str, str]] = field(default_factory=dict)
    choices: dict[str, dict[str, str]] = field(default_factory=dict)

    def shares(self, tests: Mapping[str, list[str]]) -> dict[str, tuple[int, int]]:
        """Return the numbers of proven facts and of all facts, by kind; later facts do not count."""
        proven: Counter[str] = Counter()
        total: Counter[str] = Counter()
        for fact, row in self.facts.items():
            if "later" not in row:
                total[row["kind"]] += 1
                proven[row["kind"]] += fact in tests
        return {kind: (proven[kind], total[kind]) for kind in (*PROVEN, "system") if total[kind]}


def read(folder: Path) -> Table:
    """Return the table of a data sheet."""
    if folder.name == "readme":
        table = Table("README", "The negations and restrictions of the first page, and the tests that prove them.")
    else:
        parts = [part.upper() for part, row in PARTS.items() if row.folder == folder.name]
        table = Table(" and ".join([", ".join(parts[:-1]), parts[-1]]) if parts[1:] else parts[0])
    for path in sorted(folder.glob("*.toml")):
        data = tomllib.loads(path.read_text("utf-8"))
        for key, into in (("fact", table.facts), ("choice", table.choices)):
            for row in data.get(key, []):
                if row["id"] in into:
                    sys.exit(f"{path.name}: {row['id']} occurs twice")
                into[row["id"]] = row
    return table


def tables() -> dict[str, Table]:
    """Return all tables, by folder."""
    return {folder.name: read(folder) for folder in sorted((ROOT / "conformance").iterdir())}


def ids_of(decorator: ast.expr) -> list[str]:
    """Return the ids in one `@pytest.mark.fact(...)`."""
    if not (isinstance(decorator, ast.Call) and ast.unparse(decorator.func).endswith("mark.fact")):
        return []
    return [arg.value for arg in decorator.args if isinstance(arg, ast.Constant) and isinstance(arg.value, str)]


def markers() -> dict[str, list[str]]:
    """Return the tests that claim each id, from the test files."""
    found: dict[str, list[str]] = defaultdict(list)
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        tree = ast.parse(path.read_text("utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
                for decorator in node.decorator_list:
                    for fact in ids_of(decorator):
                        found[fact].append(f"{path.relative_to(ROOT).as_posix()}::{node.name}")
            elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("pytest.param"):
                for keyword in node.keywords:
                    for fact in (
                        f for call in ast.walk(keyword.value) if isinstance(call, ast.Call) for f in ids_of(call)
                    ):
                        found[fact].append(f"{path.relative_to(ROOT).as_posix()}")
    return found


def disagreements(table: Table, tests: Mapping[str, list[str]]) -> list[str]:
    """Return the disagreements between a table and the tests."""
    wrong = []
    for fact, row in table.facts.items():
        reason = next((key for key in ("open", "later") if key in row), None)
        if fact not in tests and reason is None:
            wrong.append(f"{fact}: no test carries it, and no reason is given")
        if fact in tests and reason is not None:
            wrong.append(f"{fact}: {reason} in the table, but {tests[fact][0]} carries it")
    for kind, (proven, total) in table.shares(tests).items():
        if kind in PROVEN and proven < total:
            wrong.append(f"{table.title}, kind {kind}: {proven} of {total} proven; all are required")
        if kind == "system" and proven < SYSTEM_SHARE * total:
            wrong.append(f"{table.title}, kind system: {proven} of {total} proven; {SYSTEM_SHARE:.0%} are required")
    return wrong


def strangers(every: Iterable[Table], tests: Mapping[str, list[str]]) -> list[str]:
    """Return the ids in tests that no table has."""
    known = {fact for table in every for fact in (*table.facts, *table.choices)}
    return [f"{fact}: carried by {tests[fact][0]}, but in no table" for fact in tests if fact not in known]


def report(table: Table, tests: Mapping[str, list[str]]) -> str:
    """Return the table as text."""
    lines = [
        f"{table.title}: {len(table.facts)} facts, {len(table.choices)} choices",
        "",
        f"  {'kind':10} {'proven':>6} {'of':>5}",
    ]
    for kind, (proven, total) in table.shares(tests).items():
        lines.append(f"  {kind:10} {proven:6} {total:5}  {'' if proven == total else f'{proven / total:.0%}'}")
    for reason in ("open", "later"):
        found = [f"  {fact:20} {row[reason]}" for fact, row in table.facts.items() if reason in row]
        lines += ["", f"{reason}:", *(found or ["  nothing"])]
    covered = sum(choice in tests for choice in table.choices)
    lines += ["", f"choices pinned by a test: {covered} of {len(table.choices)}", ""]
    return "\n".join(lines)


def page(table: Table, tests: Mapping[str, list[str]]) -> str:
    """Return every fact with its tests, as Markdown."""
    lines = [
        f"# {table.title}: conformance",
        "",
        table.about,
        "",
        "| fact | kind | statement | proven by |",
        "|---|---|---|---|",
    ]
    for fact, row in table.facts.items():
        reason = f"*open: {row.get('open') or row.get('later', '')}*"
        says = cell(row["says"]) + (f" *{row['parts']}*" if "parts" in row else "")
        lines.append(f"| {anchor(fact)} | {row['kind']} | {says} | {linked(tests.get(fact, [])) or reason} |")
    if table.choices:
        heads = ["| choice | behaviour of the model | pinned by |", "|---|---|---|"]
        lines += ["", "## Gaps of the manual", "", *heads]
    for choice, row in table.choices.items():
        lines.append(f"| {anchor(choice)} | {cell(row['says'])} | {linked(tests.get(choice, []))} |")
    return "\n".join(lines) + "\n"


def cell(text: str) -> str:
    """Return a text escaped for a table cell."""
    return text.replace("|", "/")


def anchor(fact: str) -> str:
    """Return the id of a fact as an anchor that links to itself, so it can be copied."""
    return f'<a id="{fact}" href="#{fact}">{fact}</a>'


def linked(tests: Iterable[str]) -> str:
    """Return links to tests, with the test's name, or the file's name if only a list has the id."""
    places = (test.partition("::") for test in dict.fromkeys(tests))
    return "<br>".join(f"[`{name or Path(path).name}`](../../{path})" for path, _, name in places)


def main() -> int:
    """Print the tables, or check them; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    every, tests = tables().values(), markers()
    if not parser.parse_args().check:
        for table in every:
            print(report(table, tests))
        return 0
    wrong = [*strangers(every, tests), *(line for table in every for line in disagreements(table, tests))]
    print("\n".join(wrong) or "conformance: tables and tests agree")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
