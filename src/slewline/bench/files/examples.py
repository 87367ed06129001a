"""The examples and templates that come with the package."""

from __future__ import annotations

import re
from pathlib import Path

from ...errors import UsageError

PACKAGE = Path(__file__).parents[2]
SOUGHT = (PACKAGE, PACKAGE.parents[1])  # of an installed package, of a checkout
HEADS = {".py": r'"""(.*?)(?:"""|\n)', ".c": r"/\*\s*(.*)", ".h": r"/\*\s*(.*)"}
COMMENT = r"[;#]\s*(.*)"
LEAVE_OUT = (".out", ".pyc")  # what a script prints is kept next to it, for the tests


def folder(name: str = "examples") -> Path:
    """Return the folder of the examples, or another one that comes with the package."""
    for place in SOUGHT:
        if (place / name).is_dir():
            return place / name
    raise UsageError(f"no {name} are installed in {PACKAGE}; reinstall the package")


def files(root: Path) -> list[Path]:
    """Return the files of a folder and of those in it, the upper ones first."""
    found = [path for path in root.rglob("*") if path.is_file() and path.suffix not in LEAVE_OUT]
    return sorted(found, key=lambda path: (len(path.parts), path))


def title(path: Path) -> str:
    """Return the title of a file, from its first lines."""
    match = re.match(HEADS.get(path.suffix, COMMENT), path.read_text("utf-8"))
    return match[1].strip() if match else ""
