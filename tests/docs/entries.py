"""The entries of the API: what the pages take from docstrings when the documentation is built."""

from __future__ import annotations

import inspect
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path

PAGES = sorted((Path(__file__).parents[2] / "docs/reference/api").glob("*.md"))
DIRECTIVE = re.compile(
    r"^\.\. (?P<what>currentmodule|py:type|auto\w+):: (?P<name>[\w.]+)(?:\(\))?\n(?P<options>(?: {3}.*\n)*)",
    re.MULTILINE,
)
SECTION = re.compile(r"^(?P<title>[A-Z]\w+):\n(?P<rows>(?: {4}.*\n?|\n(?= {4}))*)", re.MULTILINE)


def section(doc: str, title: str) -> dict[str, str]:
    """Return the rows of a section of a docstring, such as "Args", by their names."""
    rows = next((found["rows"] for found in SECTION.finditer(doc) if found["title"] == title), "")
    pairs = re.findall(r"^ {4}(\S[^:\n]*): (.*)", rows, re.MULTILINE)
    return {name.split(" (")[0].lstrip("*"): text for names, text in pairs for name in names.split(", ")}


def _entries() -> Iterator[tuple[str, str]]:
    """Yield modules and names of the directives, of a member with its class."""
    module = ""
    for page in PAGES:
        for found in DIRECTIVE.finditer(page.read_text("utf-8")):
            if found["what"] == "currentmodule":
                module = found["name"]
                continue
            yield module, found["name"]
            members = re.search(r":members: (.*)", found["options"])
            yield from ((module, f"{found['name']}.{member}") for member in (members[1].split(", ") if members else ()))


ENTRIES = list(_entries())


def subject(module: str, name: str) -> object:
    """Return what an entry is about: of an attribute that only objects have, None."""
    found: object = import_module(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    return found


def top(module: str, name: str) -> object:
    """Return what an entry is about: a class, a function, or the class of a member."""
    return getattr(import_module(module), name.partition(".")[0], None)


def _members() -> Mapping[type, set[str]]:
    found: dict[type, set[str]] = defaultdict(set)
    for module, name in ENTRIES:
        cls, member = top(module, name), name.partition(".")[2]
        if inspect.isclass(cls):
            found[cls] |= {member} - {""} | set(section(inspect.getdoc(cls) or "", "Attributes"))
    return found


MEMBERS = _members()


def named_of(one: object) -> set[str]:
    """Return the names of an object that have entries with one of its classes."""
    return set().union(*(MEMBERS.get(cls, set()) for cls in type(one).__mro__))
