"""Facts that the pages state: code between backticks, options, commands, figures with their units, links.

page_facts.txt has the facts of the pages before they were rewritten, page_facts_dropped.toml those that were dropped
since, with the reasons.

    python -m tests.house.page_facts 93833cdd     write page_facts.txt from the pages of a revision
    python -m tests.house.page_facts              list the facts that no page states any more
"""

from __future__ import annotations

import posixpath
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path

from tests.sources import text

ROOT = Path(__file__).parents[2]
KEPT = Path(__file__).with_suffix(".txt")
DROPPED = Path(__file__).with_name("page_facts_dropped.toml")
FOLDERS = ("howto", "tutorial", "explanation", "reference")
GENERATED = "<!-- Written by tools/describe_docs.py"
MEASURED = "reference/performance.md"  # figures that change with each measurement
KINDS = ("code", "option", "command", "figure", "link")
WARNING = re.compile(r"^```\{warning\}\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FENCE = re.compile(r"^( *)(```+|~~~+)[^\n]*\n(.*?)^\1\2 *$", re.MULTILINE | re.DOTALL)
PROMPT = re.compile(r"^(?:\$|PS>) (.+)$", re.MULTILINE)
PROGRAMS = (
    "slewline|python|pip|make|pytest|pyserial|cc|cl|avrdude|socat|qemu|sudo|VBoxManage|com2tcp|install|cat|gtkwave"
)
COMMAND = re.compile(rf"^ {{4,}}((?:{PROGRAMS})\b.*)$", re.MULTILINE)
CODE = re.compile(r"(?<!`)(`+)(?!`)(.+?)(?<!`)\1(?!`)", re.DOTALL)
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]*")
LINK = re.compile(r"\]\(([^)\s]+)\)")
NUMBER = r"\d+(?:[ ,\u202f\u00a0]\d{3})*(?:\.\d+)?"
GROUPED = re.compile(r"[ ,\u202f\u00a0]")
UNITS = (
    "steps/s²|steps/s2|steps/s|full steps|steps?|ms|µs|us|ns|ps|s|seconds?|minutes?|min|hours?|h|MHz|kHz|Hz|kΩ|kohm"
    "|ohm|Ω|V|mA|A|%|mm|kB|KB|MB|GB|bits?|bytes?|baud|µF|nF|Nm|mNm|ppm|rpm|g cm²|counts/s|counts?|cycles?|clocks?"
    "|characters?|lines?|pins?|locations?|columns|rows|commands?|samples?|axes"
)
FIGURE = re.compile(rf"(?<![\w.,])({NUMBER})\s?({UNITS})(?![\w/²])")


def facts(page: str, folder: str = "") -> Iterator[tuple[str, str]]:
    """Yield the facts of a page, each with its kind; `folder`: where the page is, for links to other pages."""
    page = WARNING.sub(r"\1", page)
    for option in OPTION.findall(page):
        yield "option", option
    blocks = [found[3] for found in FENCE.finditer(page)]
    prose = FENCE.sub("", page)
    for command in (found for part in (*blocks, prose) for found in (*PROMPT.findall(part), *COMMAND.findall(part))):
        yield "command", re.sub(r" {3,}.*", "", command).strip()
    for _, code in CODE.findall(prose):
        yield "code", " ".join(code.split())
    prose = CODE.sub("``", prose)
    for target in LINK.findall(prose):
        outside = "://" in target
        yield "link", target if outside else posixpath.normpath(posixpath.join(folder, target.partition("#")[0] or "."))
    for number, unit in FIGURE.findall(LINK.sub("]", prose)):
        yield "figure", f"{GROUPED.sub('', number)} {plain(unit)}"


def plain(unit: str) -> str:
    """Return a unit in one spelling."""
    unit = {"us": "µs", "min": "minute", "h": "hour", "steps/s2": "steps/s²", "kohm": "kΩ", "ohm": "Ω"}.get(unit, unit)
    return unit.removesuffix("s") if unit.endswith("s") and len(unit) > 3 and "/" not in unit else unit


def collected(pages: Mapping[str, str]) -> dict[str, set[str]]:
    """Return the facts of pages, by kind; the pages are given by their names below docs."""
    found: dict[str, set[str]] = {kind: set() for kind in KINDS}
    for name, page in pages.items():
        for kind, fact in facts(page, posixpath.dirname(name)):
            found[kind].add(fact)
    return found


def today() -> dict[str, str]:
    """Return all pages of today."""
    docs = ROOT / "docs"
    files = (file for folder in FOLDERS for file in sorted((docs / folder).rglob("*.md")))
    return {file.relative_to(docs).as_posix(): text(file) for file in files}


def then(revision: str) -> dict[str, str]:
    """Return the pages of a revision that are written by hand."""

    def git(*words: str) -> str:
        return subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True, check=True).stdout

    names = git("ls-tree", "-r", "--name-only", revision, *(f"docs/{folder}/" for folder in FOLDERS)).splitlines()
    pages = {name.removeprefix("docs/"): git("show", f"{revision}:{name}") for name in names if name.endswith(".md")}
    return {name: page for name, page in pages.items() if not page.startswith(GENERATED) and name != MEASURED}


def kept() -> dict[str, set[str]]:
    """Return the list."""
    found: dict[str, set[str]] = {}
    for line in KEPT.read_text("utf-8").splitlines():
        kind, _, rest = line.partition("\t")
        found[kind] = set(rest.split("\t"))
    return found


def dropped() -> dict[str, str]:
    """Return the facts that were dropped, each with the reason."""
    groups = tomllib.loads(DROPPED.read_text("utf-8"))["dropped"]
    return {fact: group["reason"] for group in groups for fact in group["facts"]}


def missing(now: Mapping[str, set[str]], before: Mapping[str, set[str]]) -> list[tuple[str, str]]:
    """Return the facts that are on no page any more, each with its kind."""
    return [(kind, fact) for kind in KINDS for fact in sorted(before.get(kind, set()) - now[kind])]


def main(arguments: list[str]) -> None:
    """Write the list, or show what is missing."""
    if arguments:
        found = collected(then(arguments[0]))
        lines = ("\t".join((kind, *sorted(found[kind]))) for kind in KINDS)
        KEPT.write_text("".join(f"{line}\n" for line in lines), "utf-8")
    for kind, fact in missing(collected(today()), kept()):
        if fact not in dropped():
            print(f"{kind}\t{fact}")


if __name__ == "__main__":
    main(sys.argv[1:])
