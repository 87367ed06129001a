"""Write into the pages what their code prints and draws now: `python -m tests.docs.refresh [PAGE ...]`.

Read what it changed, and look at the pictures.

Of a lesson, which is a notebook, it writes what the cells print, in `tests/docs/printed`: the prose quotes that.

Where a page leaves lines out with `...`, as many lines before and behind it are kept as there were.
"""

from __future__ import annotations

import os
import re
import shlex
import sys
import tempfile
from pathlib import Path

from . import blocks, lessons, pictures
from .test_pages import CODE, EXPLAINED, TRIED, without_page


def renewed(shown: str, printed: str) -> str:
    """What a page shows from now on."""
    if blocks.differs(shown, printed) is None:
        return shown
    lines, new = shown.splitlines(), printed.splitlines()
    if "..." in lines:
        at = lines.index("...")
        behind = len(lines) - at - 1
        new = [*new[:at], "...", *new[len(new) - behind :]]
    return "".join(f"{line}\n" for line in new)


def refresh(page: Path, languages: tuple[str, ...]) -> None:
    """Run a page, and write its outputs and pictures anew."""
    text = page.read_text("utf-8")
    document = blocks.SYBIL.parse(page)
    for example in document.examples():
        shown, language = str(example.parsed), blocks.language_of(example)
        if language is None:
            pictures.renew(example)
            continue
        if not blocks.wanted(example, languages):
            continue
        if language == "console":
            calls = [call.partition("\n") for call in re.split(r"^\$ ", shown, flags=re.MULTILINE)[1:]]
            new = "".join(
                f"$ {line}\n{renewed(rest, blocks.called(shlex.split(line, comments=True)))}" for line, _, rest in calls
            )
        elif language == "text" and not blocks.NAMED.match(shown):
            new = renewed(shown, example.namespace.pop("__printed__"))
        else:
            example.evaluate()
            continue
        text = text.replace(f"```{language}\n{shown}```", f"```{language}\n{new}```", 1)
    page.write_text(text, "utf-8")


if __name__ == "__main__":
    pages = [Path(page).resolve() for page in sys.argv[1:]] or [*TRIED, *EXPLAINED, *lessons.LESSONS]
    for page in pages:
        with tempfile.TemporaryDirectory() as folder:
            if page in lessons.LESSONS:
                lessons.printed_by(page).write_text(lessons.play(page, Path(folder)).printed, "utf-8")
                continue
            os.chdir(folder)
            with blocks.modules_here():
                refresh(page, tuple(blocks.EVALUATORS) if page in TRIED else CODE)
            os.chdir(blocks.ROOT)
    for left in without_page():
        left.unlink()
