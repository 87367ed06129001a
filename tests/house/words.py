"""Phrases that a reader stumbles over, and how many of them each file still has: words.toml, which may only shrink.

    python -m tests.house.words         writes the table again, and lists what has grown

Python is read by its strings with more than one word and its comments; pages without their fences and words of code;
everything else whole.
"""

from __future__ import annotations

import ast
import io
import json
import re
import tokenize
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from tests.sources import text, tree

ROOT = Path(__file__).parents[2]
TABLE = Path(__file__).with_suffix(".toml")
GENERATED = "<!-- Written by tools/describe_docs.py"
READ = (
    *("src/**/*.py", "src/slewline/panel/page/**/*.js", "src/slewline/panel/page/**/*.html", "firmware/**/*.[chS]"),
    *("tools/*.py", "benchmarks/*.py", "templates/**/*.py", "templates/**/*.md", "README.md", "docs/**/*.md"),
    "docs/lessons/*.ipynb",
)
INSTEAD = {
    r"\b(the|at) begin\b|\bbegin of\b": "the start, or: the beginning",
    r"\banew\b": "again",
    r"\b(tells?|told|telling)\b(?! apart)": "report, send, list or note; is notified",
    r"\b(hears?|heard|hearing)\b": "receive, read or sample",
    r"\bsaid\b": "sent, reported or given",
    r"\bgoing to happen\b": "deadlock: no event is pending, so ... cannot become true",
    r"\b(nothing|something) to complain\b": "no problems found",
    r"\bworked off\b": "processed",
    r"\bin work\b": "in progress",
    r"\bone behind the other\b": "one after the other, or: as separate arguments",
    r"\b(soon|sooner|right|close|directly|sent|comes?|goes|go) behind\b": "after",
    r"\b([nµumk]?s|ticks?|steps?|bytes?|characters?) behind\b": "after",
    r"\b(somebody|whoever)\b": "another program, any client, a user, or the passive",
    r"\bat the last look\b": "at the last check, or: sample",
    r"\bstands still\b": "stops",
    r"\bstands? there\b": "exists, or: is there",
    r"\bstood\b|\bstands\b(?! for\b| still\b| there\b)": "is, is at rest or is stopped",
    r"\bthat is over; it is\b": "... is in the past; the time is ...",
    r"\bstill to come; it is\b": "... is in the future; the time is ...",
    r"\bcomes? about\b": "is met",
    r"\bsay it once\b": "give it once",
    r"\bleave \S+ away\b": "leave out",
    r"\bsits on no\b": "takes no, or: has no",
    r"\bmay be another one\b": "may differ",
    r"\bfor who\b": "name the reader: a user, a client",
    r"\bgive .+ that is to be new\b": "name a new file",
    r", please\b(?! encode to bytes)": "leave it out (the words of pySerial aside)",
    r"\b(takes?|taken|took|taking) (no )?notice\b": "record or handle; ignore",
    r"\bin peace\b": "uninterrupted",
    r"\b(make|makes|made|making) friends\b": "shake hands",
    r"\b(runs?|ran|running) dry\b": "buffer underrun",
    r"\b(goes|go|going|went) down\b": "decelerate, fall or go low",
    r"\bways? down\b": "stop ramp",
    r"\bat once\b": "immediately, or: at the same time",
    r"\b(laid|lays|lies)\b": "planned, queued; is",
    r"\bwants\b": "needs, requests or expects",
    r"\bheeds?\b": "follow or observe",
    r"\berrands?\b": "request",
    r"\bnothing of\b": "no ..., or: none of",
    r"\bas (it is|they are)\b": "unchanged",
    r"\bthose (that are )?there( are)?\b": "those listed, or: the existing ...",
    r"\bthe contrary\b": "the opposite; name it",
    r"\bmakes? no sense\b": "is malformed",
    r"\bguests?\b": "a plug-in",
    r"\bstrangers?\b": "untrusted, third-party, or: a newcomer",
}
ANY = re.compile("|".join(INSTEAD), re.IGNORECASE)
FENCE = re.compile(r"^( *)(```+|~~~+).*?^\1\2[^\n]*$", re.MULTILINE | re.DOTALL)
Counts = dict[str, dict[str, int]]


def banned(written: str) -> list[tuple[str, str, str]]:
    """The phrases of a text that are to be replaced, each with the remedy and what is around it."""
    plain = " ".join(written.split())
    if not ANY.search(plain):
        return []
    return [
        (found[0].lower(), instead, plain[max(found.start() - 40, 0) : found.end() + 40])
        for phrase, instead in INSTEAD.items()
        for found in re.finditer(phrase, plain, re.IGNORECASE)
    ]


def strings(parsed: ast.Module) -> Iterator[str]:
    """Docstrings and other strings with more than one word; of f-strings the text between the values."""
    parts = set()  # walked after the whole
    for node in ast.walk(parsed):
        if isinstance(node, ast.JoinedStr):
            parts |= {id(part) for part in node.values}
            pieces = (part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
            yield "".join(map(str, pieces))
        elif isinstance(node, ast.Constant) and id(node) not in parts and " " in str(node.value):
            yield str(node.value)


def comments(source: str) -> Iterator[str]:
    """The comments of a Python file, those of lines that follow each other as one."""
    last, joined = -1, ""
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            if token.start[0] != last + 1:
                yield joined
                joined = ""
            joined, last = f"{joined} {token.string[1:]}", token.start[0]
    yield joined


def prose(page: str) -> str:
    """A page without its fences and its words of code."""
    return re.sub(r"`[^`]*`", "``", FENCE.sub("", page))


def texts(file: Path) -> Iterator[str]:
    """What is written in a file."""
    if file.suffix == ".py" and "templates" not in file.parts:  # a template is no Python before it is filled in
        yield from strings(tree(file))
        yield from comments(text(file))
    elif file.suffix == ".ipynb":
        yield from (prose("".join(cell["source"])) for cell in json.loads(text(file))["cells"])
    else:
        yield prose(text(file)) if file.suffix == ".md" else text(file)


def files() -> list[Path]:
    """What is read; records of decisions stay unchanged, and generated pages are written by what is read."""
    found = [file for pattern in READ for file in sorted(ROOT.glob(pattern)) if file.is_file()]
    return [
        file
        for file in found
        if file.suffix != ".md" or not (file.parent.name == "decisions" or text(file).startswith(GENERATED))
    ]


def counted() -> Counts:
    """How many of each phrase there are, by file."""
    found = {}
    for file in files():
        counts = Counter(phrase for each in texts(file) for phrase, _, _ in banned(each))
        if counts:
            found[file.relative_to(ROOT).as_posix()] = dict(sorted(counts.items()))
    return found


def listed() -> Counts:
    """What the table has."""
    table: Counts = tomllib.loads(TABLE.read_text("utf-8"))
    return table


def grown(now: Counts, before: Counts) -> dict[tuple[str, str], str]:
    """The phrases of which there are more than before, by file and phrase: how many there were, and are."""
    return {
        (name, phrase): f"{name}: {phrase!r} {before.get(name, {}).get(phrase, 0)} -> {count}"
        for name, counts in now.items()
        for phrase, count in counts.items()
        if count > before.get(name, {}).get(phrase, 0)
    }


def write() -> None:
    """Write the table, and print what has grown."""
    before, now = listed() if TABLE.exists() else {}, counted()
    lines = (
        f'"{name}" = {{ {", ".join(f"{phrase!r} = {count}" for phrase, count in counts.items())} }}\n'
        for name, counts in sorted(now.items())
    )
    TABLE.write_text(f"# Written by python -m tests.house.words: the table may only shrink.\n{''.join(lines)}", "utf-8")
    print("\n".join(grown(now, before).values()) or "nothing has grown")


if __name__ == "__main__":
    write()
