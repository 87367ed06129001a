"""The pictures on the pages: each is the file that a block before it has written into the current directory.

A picture is there once, on white paper: a code host shows it as it is, the built pages turn light and dark around by
CSS in their dark theme.  So the block on the page writes one file, and that file is what the reader gets.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from sybil import Document, Example, Region

IMAGE = re.compile(r"^!\[(?P<alt>[^\]]*)\]\((?P<target>[^)\s]+)\)", re.MULTILINE)
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")
HASHED = re.compile(r"\b[a-zA-Z][0-9a-f]{10}\b")  # names that matplotlib makes of what is drawn
POINT = 0.05  # no eye sees it
SCREENS = ("panel.png", "debugger.png", "notebook.png")  # drawn and compared by tests/panel/test_head_pictures.py
REFRESH = "look at it, then: python -m tests.docs.refresh"


def images(document: Document) -> Iterator[Region]:
    """A parser for Sybil: every picture of a page."""
    for found in IMAGE.finditer(document.text):
        yield Region(*found.span(), found.groupdict(), shown)


def shown(example: Example) -> str | None:
    """What is wrong with a picture, if the page does not show what its blocks have drawn."""
    alt, target = example.parsed["alt"], example.parsed["target"]
    made, kept = drawn(target), Path(example.path).parent / target
    if not alt.strip():
        return f"{target}: say in the brackets what is to be seen"
    if Path(target).name in SCREENS and kept.exists():
        return None
    if made is None:
        return f"{target}: no block before the picture writes {Path(target).name}"
    if not kept.exists():
        return f"{target}: not there yet; {REFRESH}"
    return None if same(kept.read_bytes(), made.read_bytes()) else f"{target}: another picture is drawn; {REFRESH}"


def renew(example: Example) -> None:
    """Keep what the blocks have drawn as the picture of the page."""
    made, kept = drawn(example.parsed["target"]), Path(example.path).parent / example.parsed["target"]
    if kept.name in SCREENS:
        return
    assert made, shown(example)
    if not kept.exists() or not same(kept.read_bytes(), made.read_bytes()):
        kept.write_bytes(made.read_bytes())


def drawn(target: str) -> Path | None:
    """The file that the blocks have written, in the current directory or below."""
    return next(Path.cwd().rglob(Path(target).name), None)


def same(kept: bytes, made: bytes) -> bool:
    """Whether two files are one picture.

    On one machine they are so to the byte.  On another one the last digit of a coordinate may differ, since compilers
    round products and sums together or apart: words must agree then, and points to a twentieth.
    """
    if kept == made:
        return True
    try:
        return alike(pieces(kept), pieces(made))
    except (UnicodeDecodeError, ElementTree.ParseError):  # of another kind, or torn
        return False


def pieces(svg: bytes) -> list[tuple[str, str]]:
    """Words and values of a drawing in their order: what they are, and the text."""
    text, names = svg.decode("utf-8"), {}
    text = HASHED.sub(lambda name: names.setdefault(name[0], f"name-{'i' * len(names)}"), text)
    found = []
    for element in ElementTree.fromstring(text).iter():
        found.append(("words", f"{element.tag} {element.text} {element.tail}"))
        found.extend((name, value) for name, value in sorted(element.items()))
    return found


def alike(kept: list[tuple[str, str]], made: list[tuple[str, str]]) -> bool:
    """Whether two drawings say the same words, and draw the same lines as far as an eye can see."""
    if [name for name, _ in kept] != [name for name, _ in made]:
        return False
    for (name, old), (_, new) in zip(kept, made, strict=True):
        if old == new:
            continue
        if name == "words" or NUMBER.split(old) != NUMBER.split(new):
            return False
        numbers = zip(NUMBER.findall(old), NUMBER.findall(new), strict=True)
        if not all(math.isclose(float(one), float(other), rel_tol=0, abs_tol=POINT) for one, other in numbers):
            return False
    return True
