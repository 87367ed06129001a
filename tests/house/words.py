"""Phrases that a native reader stumbles over, by kind: docs/explanation/style.md names the kinds.

How many each area still has is in words.toml; a count may only fall.

    python -m tests.house.words                   lower the table to today's counts, and print both
    python -m tests.house.words --since HEAD      list the phrases that the files have gained since a revision
    python -m tests.house.words speech docs       list the phrases of a kind, of one area or of all

Read are strings of more than one word, comments and names of Python, C and JavaScript, pages without code, and the
names of tests. A quotation in double quotes is not read; there is no other exception.
"""

from __future__ import annotations

import ast
import io
import json
import re
import subprocess
import sys
import tokenize
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from tests.sources import text, tree

ROOT = Path(__file__).parents[2]
TABLE = Path(__file__).with_suffix(".toml")
GENERATED = "<!-- Written by tools/describe_docs.py"
AREAS = {  # the first pattern that a file matches decides; areas with names have a second row, as src_names
    "readme": ("README.md",),
    "changelog": ("CHANGELOG.md",),
    "contributing": ("CONTRIBUTING.md", "SECURITY.md"),
    "lessons": ("docs/lessons/*.ipynb", "docs/lessons/*.md"),
    "docs": ("docs/**/*.md",),
    "templates": ("templates/**/*.py", "templates/**/*.md", "templates/**/*.toml"),
    "conformance": ("conformance/**/*.toml", "conformance/**/*.md"),
    "page": ("src/slewline/panel/page/**/*.js", "src/slewline/panel/page/**/*.html"),
    "src": ("src/**/*.py",),
    "firmware": ("firmware/**/*.[chS]",),
    "tools": ("tools/*.py", "benchmarks/*.py"),
    "tests": ("tests/**/test_*.py", "tests/**/*.js"),  # their names only
}
NAMED = ("src", "page", "firmware")
SOURCES = (*NAMED, "tools")
STEPS = r"(?:(?:the|its|a|an|no|all|their|those|these|every|any|[\d,]+) )?(?:steps?|pulses?|edges?)"
PORT = r"(?:(?:a|an|the|its|your|this|one|each) )?(?:\w+ )?(?:ports?|sockets?|servers?|proxy|gateway|adapters?|URLs?)\b"
TAKES = (
    r"(?:save|list|print|show|compare|keep|read|return|write|get|send|know|have|with|of|for|by|to|from|and|or|than|after"
    r"|before)s?"
)
CLAUSE = r"(?:it|they|is|are|was|were|has|had|a|an|the|this|that|\w+s)\b"
VERB = r"(?:is|are|was|were|has|have|does|do|can|may)"
SUBJECT = r"(?:it|its|they|this|that|the|there|all|a|an|any)"
KINDS: dict[str, dict[str, str]] = {
    "speech": {
        r"\b(?:tells?|told|telling)\b(?! (?:\w+ )?apart)": "report, send, list or note; is notified",
        r"\b(?:hears?|heard|hearing)\b": "receive, read or sample",
        r"\bsaid\b": "sent, reported or given",
        r"\b(?:asks|asked|asking)\b": "query, request, prompt; is requested",
    },
    "person": {
        r"\b(?:takes?|taken|took|taking) (?:no )?notice\b": "record or handle; ignore",
        r"\b(?:make|makes|made|making) friends\b": "shake hands",
        r"\bin peace\b": "uninterrupted",
        r"\bheeds?\b": "follow or observe",
        r"\berrands?\b": "request, job",
        r"\b(?:somebody|whoever)\b": "another program, any client, a user, or the passive",
        r", please\b(?! encode to bytes)": "leave it out (the words of pySerial aside)",
    },
    "behind": {
        rf"(?<!left )(?<!lag )(?<!lags )(?<!fall )(?<!falls )\bbehind\b(?! {PORT})": "after, following; appended",
    },
    "clause": {
        r"(?:^|(?<=[.:;] ))What\b(?! (?:if|for)\b)(?![^.]*\?)": "a noun: the output, the commands that ...",
        rf"\b{TAKES} what {CLAUSE}": "a noun: its output, the list",
        r"(?:^|(?<=[.:;] ))Who\b(?! may\b)(?![^.]*\?)": "name the reader or the program: a client that ...",
        r"\bfor who\b": "name the reader: a user, a client",
    },
    "pointer": {
        r"\bthose (?:there|that|who|which)\b": "the noun: the commands that ..., the existing ...",
        r"\bas (?:it is|they are)\b": "unchanged",
        r"\bso (?:many|much)\b(?! (?:that|as|faster|better|smaller)\b)": "a number of; n",
        r"\bof (?:ours|one's own)\b|\bones own\b": "built-in; custom",
        r"\bthe contrary\b": "the opposite; name it",
    },
    "at_once": {r"\bat once\b": "immediately, or: at the same time, all together"},
    "posture": {
        r"\bstood\b|\bstands\b(?! for\b)": "is, is at rest or is stopped; does not change",
        r"\bstands? there\b": "exists, or: is there",
        r"\b(?:lays?|laid|lies)\b": "planned, queued; is",
        r"\bsits on no\b": "takes no, or: has no",
    },
    "motion": {
        r"\b(?:goes|go|going|went) down\b": "decelerate, fall or go low",
        r"\bways? down\b": "stop ramp",
        r"\b(?:runs?|ran|running) dry\b": "buffer underrun",
        rf"\b(?:make|makes|made|making) {STEPS}\b": "generate, send or take steps",
        r"\b(?:a|the|each|every|last|first|next|one|two) looks?\b(?! at\b)": "sample, sampling point",
    },
    "literal": {
        r"\b(?:the|at|its) begin\b|\bbegin of\b": "the start, or: the beginning",
        r"\banew\b": "again",
        r"\bworked off\b": "processed",
        r"\bin work\b": "in progress",
        r"\b(?:go|goes|going|went) on\b": "continue; resume; keep moving",
        r"\bbeside\b": "next to, besides, compared with",
        r"(?<!all )\bbut for\b": "except, apart from",
        r"\bwants\b": "needs, requests or expects",
        r"\{\}: (?:is|has|contains|cannot be) (?:an?|no|not|empty|given|read|written|open)\b": "no colon before a verb",
        r"\bthere are: (?=\{\})": "available:",
        r"\bgoing to happen\b": "deadlock: no event is pending, so ... cannot become true",
        r"\bthat is over; it is\b": "... is in the past; the time is ...",
        r"\bstill to come; it is\b": "... is in the future; the time is ...",
        r"\bcomes? about\b": "is met, occurs",
        r"\bsay it once\b": "give it once",
        r"\bleave \S+ away\b": "leave out",
        r"\bmay be another one\b": "may differ",
        r"\bgive .+ that is to be new\b": "name a new file",
    },
    "negative": {
        r"(?<!there )\b(?:is|are) no (?!(?:longer|more|less|better|worse|need|way|reason)\b)\w+": "is not a ...",
        r"\bnothing of\b": "no ..., or: none of",
        r"\b(?:range|list|number|set) of nothing\b": "empty ...",
        r"\b(?:nothing|something) to complain\b": "no problems found",
        r"\bmakes? no sense\b": "is malformed",
    },
    "noun": {
        r"\b(?:file|name|its|their|same|known|this) endings?\b": "file extension",
        r"\bendings? of (?:a|the|its) (?:files?|name)\b": "file extension",
        r"\bto its end\b": "to the last byte, completely",
        r"\bguests?\b": "a plug-in",
        r"\bstrangers?\b": "untrusted, third-party, or: a newcomer",
    },
    "question": {  # of sources alone: a lesson may ask its reader
        rf"(?<!what )(?<!where )(?<!how )\b{VERB} {SUBJECT}\b[^.?!]{{0,80}}\?": "Check ...; Return whether ...",
    },
    "name": {r"\b(?:ways?|held|says|peace|breath|patience)\b": "direction, stop ramp, in_out, stop mode; owner; text"},
}  # fmt: skip
FINDERS = {
    kind: [(re.compile(phrase, re.IGNORECASE), instead) for phrase, instead in phrases.items()]
    for kind, phrases in KINDS.items()
}
ANY = re.compile("|".join(phrase for phrases in KINDS.values() for phrase in phrases), re.IGNORECASE)
FENCE = re.compile(r"^( *)(```+|~~~+).*?^\1\2[^\n]*$", re.MULTILINE | re.DOTALL)
QUOTED = re.compile(r'"[^"]{1,300}"|“[^”]{1,300}”')
TOKEN = re.compile(
    r"(?P<comment>/\*.*?\*/|(?://[^\n]*\n\s*)+)|(?P<string>\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|`(?:\\.|[^`\\])*`)"
    r"|(?P<name>[A-Za-z_]\w*)",
    re.DOTALL,
)
TEST = re.compile(r"^\s*(?:async )?def test_(\w+)|\b(?:test|it)\(\s*\"([^\"]+)\"", re.MULTILINE)
Counts = dict[str, dict[str, int]]


class Phrase(NamedTuple):
    """A phrase that is to be replaced."""

    kind: str
    phrase: str
    instead: str
    around: str


def banned(written: str, area: str = "src") -> list[Phrase]:
    """Return the phrases of a text that are to be replaced, each with the remedy and the words around it."""
    plain = " ".join(QUOTED.sub('""', written).split())
    if not ANY.search(plain):
        return []
    return [
        Phrase(kind, found[0].lower(), instead, plain[max(found.start() - 40, 0) : found.end() + 40])
        for kind, finders in FINDERS.items()
        if read_there(kind, area)
        for finder, instead in finders
        for found in finder.finditer(plain)
    ]


def read_there(kind: str, area: str) -> bool:
    """Return whether a kind is looked for in an area."""
    return area.endswith("names") if kind == "name" else kind != "question" or area in SOURCES


def spaced(names: set[str]) -> str:
    """Return names as words, each name between strokes."""
    return " / ".join(re.sub(r"(?<=[a-z0-9])(?=[A-Z])|_+", " ", name) for name in sorted(names))


def strings(parsed: ast.Module) -> Iterator[str]:
    """Yield docstrings and other strings with more than one word; of f-strings the text between the values."""
    parts = set()  # walked after the whole
    for node in ast.walk(parsed):
        if isinstance(node, ast.JoinedStr):
            parts |= {id(part) for part in node.values}
            pieces = (part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
            yield "".join(map(str, pieces))
        elif isinstance(node, ast.Constant) and id(node) not in parts and " " in str(node.value):
            yield str(node.value)


def comments(source: str, names: set[str] | None = None) -> Iterator[str]:
    """Yield the comments of a Python file, consecutive lines joined; the names are added to `names`."""
    last, joined = -1, ""
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            if token.start[0] != last + 1:
                yield joined
                joined = ""
            joined, last = f"{joined} {token.string[1:]}", token.start[0]
        elif token.type == tokenize.NAME and names is not None:
            names.add(token.string)
    yield joined


def prose(page: str) -> str:
    """Return a page without its fences and its words of code; a paragraph or item begins a sentence."""
    words = re.sub(r"`[^`]*`", "``", FENCE.sub("", page))
    return re.sub(r"\n\s*\n(?:[-*] |\d+\. )?|^[-*] ", "; ", words, flags=re.MULTILINE)


def of_code(area: str, source: str) -> Iterator[tuple[str, str]]:
    """Yield the comments, strings and names of C and JavaScript, each with its area."""
    names: set[str] = set()
    for token in TOKEN.finditer(source):
        if token.lastgroup == "name":
            names.add(token[0])
        elif token.lastgroup == "comment" or " " in token[0]:
            yield area, re.sub(r"^\s*(?://|/?\*)|\*/", " ", token[0].strip("\"'`"), flags=re.MULTILINE)
    yield f"{area}_names", spaced(names)


def texts(area: str, file: Path, content: str, parsed: ast.Module | None = None) -> Iterator[tuple[str, str]]:
    """Yield the texts of a file, each with its area."""
    names: set[str] = set()
    if area == "tests":
        yield "tests_names", spaced({python or script for python, script in TEST.findall(content)})
    elif file.suffix == ".py" and area != "templates":  # a template is no Python before it is filled in
        yield from ((area, each) for each in strings(parsed or ast.parse(content)))
        yield from ((area, each) for each in comments(content, names))
        if area in NAMED:
            yield f"{area}_names", spaced(names)
    elif file.suffix in (".c", ".h", ".js"):
        yield from of_code(area, content)
    elif file.suffix == ".ipynb":
        yield from ((area, prose("".join(cell["source"]))) for cell in json.loads(content)["cells"])
    elif area == "changelog":  # what is released is a record
        yield area, prose("\n## ".join(content.split("\n## ")[:2]))
    elif file.suffix == ".toml" and area == "conformance":
        yield from ((area, said) for said in re.findall(r'^\w+ = "(.*)"$', content, re.MULTILINE))
    else:
        yield area, prose(content) if file.suffix == ".md" else content


def files() -> dict[Path, str]:
    """Return the files that are read, with their areas: no decisions, no generated pages."""
    found: dict[Path, str] = {}
    for area, patterns in AREAS.items():
        for file in (file for pattern in patterns for file in sorted(ROOT.glob(pattern)) if file.is_file()):
            if file.suffix != ".md" or not (file.parent.name == "decisions" or text(file).startswith(GENERATED)):
                found.setdefault(file, area)
    return found


def places(file: Path, area: str, content: str | None = None) -> list[tuple[str, Phrase]]:
    """Return the phrases of a file, each with its area; `content`: as it was."""
    python = content is None and file.suffix == ".py" and area not in ("templates", "tests")
    read = texts(area, file, text(file) if content is None else content, tree(file) if python else None)
    return [(where, place) for where, each in read for place in banned(each, where)]


def counted() -> Counts:
    """Return how many phrases of each kind there are, by area."""
    found: dict[str, Counter[str]] = {kind: Counter() for kind in KINDS}
    for file, area in files().items():
        for where, place in places(file, area):
            found[place.kind][where] += 1
    return {kind: dict(sorted(counts.items())) for kind, counts in found.items()}


def listed() -> Counts:
    """Return the table."""
    table: Counts = tomllib.loads(TABLE.read_text("utf-8"))
    return table


def grown(now: Counts, before: Counts) -> list[str]:
    """Return a line for each kind and area that has more phrases than before."""
    return [
        f"{kind} in {area}: {before.get(kind, {}).get(area, 0)} -> {count}"
        for kind, counts in now.items()
        for area, count in counts.items()
        if count > before.get(kind, {}).get(area, 0)
    ]


def lowered(now: Counts, before: Counts) -> Counts:
    """Return the lower of both counts; a kind that is new to the table comes in with all it has."""
    return {
        kind: {area: min(count, before.get(kind, counts).get(area, 0)) for area, count in counts.items()}
        for kind, counts in now.items()
    }


def written(table: Counts) -> str:
    """Return the lines of the table."""
    rows = (
        f"{kind} = {{ {', '.join(f'{area} = {count}' for area, count in sorted(counts.items()) if count)} }}\n"
        for kind, counts in table.items()
    )
    return f"# Written by python -m tests.house.words: a count may only fall.\n{''.join(rows)}"


def since(revision: str) -> Iterator[str]:
    """Yield a line for each phrase that a file has and had not at a revision."""
    git = ["git", "-C", str(ROOT)]
    changed = subprocess.run([*git, "diff", "--name-only", revision], capture_output=True, text=True, check=True)
    read = files()
    for name in changed.stdout.splitlines():
        if area := read.get(ROOT / name):
            then = subprocess.run([*git, "show", f"{revision}:{name}"], capture_output=True, text=True, check=False)
            old = Counter(place for _, place in places(ROOT / name, area, then.stdout)) if then.stdout else Counter()
            for place in Counter(place for _, place in places(ROOT / name, area)) - old:
                yield line(name, place)


def line(name: str, place: Phrase) -> str:
    """Return a phrase as one line."""
    return f"{name}: {place.kind}: {place.phrase!r}, write {place.instead}: ...{place.around}..."


def main(words: list[str]) -> None:
    """Obey the command line."""
    if words[:1] == ["--since"]:
        print("\n".join(since(words[1])) or "no phrase is new")
    elif words:
        for file, area in files().items():
            for where, place in places(file, area):
                if place.kind == words[0] and where in (words[1:] or [where]):
                    print(line(file.relative_to(ROOT).as_posix(), place))
    else:
        before, now = listed() if TABLE.exists() else {}, counted()
        TABLE.write_text(written(lowered(now, before)), "utf-8")
        print(written(now), "\n".join(grown(now, before)) or "nothing has grown", sep="")


if __name__ == "__main__":
    main(sys.argv[1:])
