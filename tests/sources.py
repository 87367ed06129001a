"""What the sources hold, for tests that read them: each file is read and parsed once in a process."""

from __future__ import annotations

import ast
import gc
from functools import cache
from pathlib import Path

SOURCES = Path(__file__).parents[1] / "src"


@cache
def text(path: Path) -> str:
    """Return what a file holds."""
    return path.read_text("utf-8")


@cache
def tree(path: Path) -> ast.Module:
    """Return the syntax tree of a file, which stays: all who ask get the same one, and change nothing in it.

    No garbage comes of parsing, and to look for it takes as long again.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        return ast.parse(text(path))
    finally:
        if was_on:
            gc.enable()
