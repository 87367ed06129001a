"""Print how much of each chip's data sheet is proven by a test, and what is open.

    python tools/conformance.py            the table: per chip and kind, and the open facts with their reasons
    python tools/conformance.py --check    fail where table and tests disagree
    python tools/conformance.py --page F   the same as a Markdown page, every fact with its tests

The table of a chip lies in conformance/<chip>/*.toml: `[[fact]]` with id, kind, says (and `open` with a reason), and
`[[choice]]` for what the model had to decide.  Tests carry the ids in `@pytest.mark.fact("CMD-A-1")`.
"""

from __future__ import annotations

import argparse
import ast
import sys
import tomllib
from collections import Counter, defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROVEN = ("language", "protocol", "pin", "motion", "timing")  # every fact of these kinds
SYSTEM_SHARE = 0.90  # of kind system, without what comes with other parts
LATER = ("PANEL-", "CIRCUIT-CY232", "CIRCUIT-EEPROM", "CIRCUIT-CYB002")


def table(chip: str) -> tuple[dict[str, dict[str, str]], dict[str, dict[str, str]]]:
    """Facts and choices of a chip, by id."""
    facts: dict[str, dict[str, str]] = {}
    choices: dict[str, dict[str, str]] = {}
    for path in sorted((ROOT / "conformance" / chip).glob("*.toml")):
        data = tomllib.loads(path.read_text("utf-8"))
        for key, into in (("fact", facts), ("choice", choices)):
            for row in data.get(key, []):
                if row["id"] in into:
                    sys.exit(f"{path.name}: {row['id']} stands twice")
                into[row["id"]] = row
    return facts, choices


def ids_of(decorator: ast.expr) -> list[str]:
    """The ids in one `@pytest.mark.fact(...)`."""
    if not (isinstance(decorator, ast.Call) and ast.unparse(decorator.func).endswith("mark.fact")):
        return []
    return [arg.value for arg in decorator.args if isinstance(arg, ast.Constant) and isinstance(arg.value, str)]


def markers() -> dict[str, list[str]]:
    """Which tests claim which id, from the test files themselves."""
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


def disagreements(
    facts: dict[str, dict[str, str]], choices: dict[str, dict[str, str]], tests: dict[str, list[str]]
) -> list[str]:
    """Where table and tests do not fit."""
    wrong = [
        f"{fact}: carried by {tests[fact][0]}, but not in the table"
        for fact in tests
        if fact not in facts and fact not in choices
    ]
    for fact, row in facts.items():
        if fact not in tests and "open" not in row:
            wrong.append(f"{fact}: no test carries it, and no reason says why it is open")
        if fact in tests and "open" in row:
            wrong.append(f"{fact}: open in the table, but {tests[fact][0]} carries it")
    for kind, (proven, total) in shares(facts, tests).items():
        if kind in PROVEN and proven < total:
            wrong.append(f"kind {kind}: {proven} of {total} proven; all are wanted")
        if kind == "system" and proven < SYSTEM_SHARE * total:
            wrong.append(f"kind system: {proven} of {total} proven; {SYSTEM_SHARE:.0%} are wanted")
    return wrong


def shares(facts: dict[str, dict[str, str]], tests: dict[str, list[str]]) -> dict[str, tuple[int, int]]:
    """Per kind: facts proven and facts in all; what comes with other parts does not count."""
    proven: Counter[str] = Counter()
    total: Counter[str] = Counter()
    for fact, row in facts.items():
        if not fact.startswith(LATER):
            total[row["kind"]] += 1
            proven[row["kind"]] += fact in tests
    return {kind: (proven[kind], total[kind]) for kind in (*PROVEN, "system") if total[kind]}


def report(
    chip: str, facts: dict[str, dict[str, str]], choices: dict[str, dict[str, str]], tests: dict[str, list[str]]
) -> str:
    """The table for people."""
    lines = [
        f"{chip.upper()}: {len(facts)} facts, {len(choices)} choices",
        "",
        f"  {'kind':10} {'proven':>6} {'of':>5}",
    ]
    for kind, (proven, total) in shares(facts, tests).items():
        lines.append(f"  {kind:10} {proven:6} {total:5}  {'' if proven == total else f'{proven / total:.0%}'}")
    later = sum(fact.startswith(LATER) for fact in facts)
    lines += [f"  {'later':10} {'':6} {later:5}  (with the panel, the CY232, CY250 and CYB-002)", "", "open:"]
    lines += [f"  {fact:20} {row['open']}" for fact, row in facts.items() if "open" in row] or ["  nothing"]
    covered = sum(choice in tests for choice in choices)
    lines += ["", f"choices pinned by a test: {covered} of {len(choices)}"]
    return "\n".join(lines)


def page(
    chip: str, facts: dict[str, dict[str, str]], choices: dict[str, dict[str, str]], tests: dict[str, list[str]]
) -> str:
    """Every fact with its tests, as Markdown."""
    lines = [
        f"# {chip.upper()}: conformance",
        "",
        "What the manual states, and which test proves it.",
        "",
        "| fact | kind | says | proven by |",
        "|---|---|---|---|",
    ]
    for fact, row in facts.items():
        by = (
            "<br>".join(f"`{test.split('::')[-1]}`" for test in tests.get(fact, [])[:3])
            or f"*open: {row.get('open', '')}*"
        )
        lines.append(f"| {fact} | {row['kind']} | {row['says'].replace('|', '/')} | {by} |")
    lines += ["", "## What the manual leaves open", "", "| choice | what the model does | pinned by |", "|---|---|---|"]
    for choice, row in choices.items():
        by = "<br>".join(f"`{test.split('::')[-1]}`" for test in tests.get(choice, [])[:2])
        lines.append(f"| {choice} | {row['says'].replace('|', '/')} | {by} |")
    return "\n".join(lines) + "\n"


def main() -> int:
    """Print, check, or write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--page", type=Path)
    options = parser.parse_args()
    tests = markers()
    wrong = []
    for folder in sorted((ROOT / "conformance").iterdir()):
        facts, choices = table(folder.name)
        wrong += disagreements(facts, choices, tests)
        if options.page:
            options.page.write_text(page(folder.name, facts, choices, tests), "utf-8")
        elif not options.check:
            print(report(folder.name, facts, choices, tests))
    if options.check:
        print("\n".join(wrong) or "conformance: table and tests agree")
        return 1 if wrong else 0
    return 0


if __name__ == "__main__":
    sys.exit(main())
