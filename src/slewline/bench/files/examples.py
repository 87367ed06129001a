"""The examples that come with the package, and the lessons among them."""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath

from ...errors import UsageError

PACKAGE = Path(__file__).parents[2]
CHECKOUT = PACKAGE.parents[1]
SOUGHT = (  # of an installed package, of a checkout: the folders, each by what the names of its files begin with
    {"": PACKAGE / "examples"},
    {"": CHECKOUT / "examples", "lessons": CHECKOUT / "docs/lessons"},
)
HEADS = {
    ".py": r'"""(.*?)(?:"""|\n)',
    ".c": r"/\*\s*(.*)",
    ".h": r"/\*\s*(.*)",
    ".ipynb": r'(?s:.*?)"# (.*?)(?:\\n)?"',
}
COMMENT = r"[;#]\s*(.*)"
LEAVE_OUT = (".out", ".pyc", ".md")  # what a script prints is kept next to it, for the tests; the page of the lessons


def named() -> dict[str, Path]:
    """Return the files by their names, such as "drill/looped.toml", the upper ones first.

    Raises:
        UsageError: the package has been installed without them.
    """
    for folders in SOUGHT:
        if folders[""].is_dir():
            found = {
                (PurePosixPath(begins) / path.relative_to(folder).as_posix()): path
                for begins, folder in folders.items()
                for path in folder.rglob("*")
                if path.is_file() and path.suffix not in LEAVE_OUT
            }
            shown = [name for name in found if not any(part.startswith(".") for part in name.parts)]
            return {str(name): found[name] for name in sorted(shown, key=lambda name: (len(name.parts), name))}
    raise UsageError(f"no examples are installed in {PACKAGE}; reinstall the package")


def title(path: Path) -> str:
    """Return the title of a file, from its first lines."""
    match = re.match(HEADS.get(path.suffix, COMMENT), path.read_text("utf-8"))
    return match[1].strip() if match else ""
