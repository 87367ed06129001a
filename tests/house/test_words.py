"""Messages, docstrings and pages keep to the words of the field (docs/explanation/glossary.md).

Phrases that a reader stumbles over, each with what to write instead.  A package that is free of them is added.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.sources import tree

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "src/slewline"
PACKAGES = (
    *("core", "language", "chips", "parts", "record", "bench", "links", "testing", "tuning", "modules", "labs", "cli"),
    "errors.py",
)

GENERATED = "<!-- Written by tools/describe_docs.py"
PAGES = [
    page
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
    if page.parent.name != "decisions" and not page.read_text("utf-8").startswith(GENERATED)  # records stay as they are
]

INSTEAD = {
    r"\b(the|at) begin\b|\bbegin of\b": "the start, or: the beginning",
    r"\banew\b": "again",
    r"\b(is|are|was|were|been) told\b(?! apart)": "reported, recorded, listed or noted",
    r"\b(is|are|was|were|been) heard\b": "received, read or sampled",
    r"\bgoing to happen\b": "deadlock: no event is pending, so ... cannot become true",
    r"\b(nothing|something) to complain\b": "no problems found",
    r"\bworked off\b": "processed",
    r"\bin work\b": "in progress",
    r"\bone behind the other\b": "one after the other, or: as separate arguments",
    r"\b(somebody|whoever)\b": "another program, any client, a user, or the passive",
    r"\bat the last look\b": "at the last check, or: sample",
    r"\bstands still\b": "stops",
    r"\bstands? there\b": "exists, or: is there",
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
}
ANY = re.compile("|".join(INSTEAD), re.IGNORECASE)
FENCE = re.compile(r"^( *)(```+|~~~+).*?^\1\2[^\n]*$", re.MULTILINE | re.DOTALL)


def banned(text: str) -> list[str]:
    """The phrases of a text that are to be replaced, each with the remedy."""
    plain = " ".join(text.split())
    if not ANY.search(plain):
        return []
    return [
        f"{found[0]!r}: write {instead}: ...{plain[max(found.start() - 40, 0) : found.end() + 40]}..."
        for phrase, instead in INSTEAD.items()
        for found in re.finditer(phrase, plain, re.IGNORECASE)
    ]


def texts(parsed: ast.Module) -> Iterator[tuple[int, str]]:
    """Docstrings and other strings with more than one word: line and text, of f-strings the text between the values."""
    parts = set()  # walked after the whole
    for node in ast.walk(parsed):
        if isinstance(node, ast.JoinedStr):
            parts |= {id(part) for part in node.values}
            pieces = (part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
            yield node.lineno, "".join(map(str, pieces))
        elif isinstance(node, ast.Constant) and id(node) not in parts and " " in str(node.value):
            yield node.lineno, str(node.value)


def prose(page: str) -> str:
    """A page without its fences and its words of code."""
    return re.sub(r"`[^`]*`", "``", FENCE.sub("", page))


@pytest.mark.parametrize("package", PACKAGES)
def test_messages_and_docstrings_have_the_words_of_the_field(package):
    place = SOURCES / package
    files = sorted(place.rglob("*.py")) if place.is_dir() else [place]
    assert files
    found = [
        f"{file.relative_to(ROOT)}, line {line}: {each}"
        for file in files
        for line, text in texts(tree(file))
        for each in banned(text)
    ]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_pages_have_the_words_of_the_field(page):
    found = banned(prose(page.read_text("utf-8")))
    assert not found, "\n".join(found)


def test_every_phrase_is_found_and_no_other():
    wrong = 'f"{path}: that is over; it is {now}"\n"""A finding is\ntold anew by somebody."""\nx = "begin"\n'
    found = [each for _, text in texts(ast.parse(wrong)) for each in banned(text)]
    assert [each.partition(":")[0] for each in found] == ["'that is over; it is'", "'anew'", "'is told'", "'somebody'"]
    assert not banned(prose("It is over.\n\n```text\nanew\n```\nThe edges are told apart by `somebody`.\n"))
