"""Files that come with the package: examples, including those of the lessons, and templates."""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath

from ...errors import UsageError

PACKAGE = Path(__file__).parents[2]
CHECKOUT = PACKAGE.parents[1]
SOUGHT = {  # of an installed package, of a checkout: folders, by the prefix of their files' names
    "examples": (
        {"": PACKAGE / "examples"},
        {"": CHECKOUT / "examples", "lessons": CHECKOUT / "docs/lessons"},
    ),
    "templates": ({"": PACKAGE / "templates"}, {"": CHECKOUT / "templates"}),
}
HEADS = {
    ".py": r'"""(.*?)(?:"""|\n)',
    ".c": r"/\*\s*(.*)",
    ".h": r"/\*\s*(.*)",
    ".ipynb": r'(?s:.*?)"# (.*?)(?:\\n)?"',
}
COMMENT = r"[;#]\s*(.*)"
LEAVE_OUT = (".out", ".pyc")  # the output of a script is kept next to it, for the tests
PAGE = "index.md"  # of the lessons


def named(what: str = "examples") -> dict[str, Path]:
    """Return the files, keyed by names such as "drill/looped.toml", top-level files first.

    Args:
        what: "examples" or "templates".

    Raises:
        UsageError: the package has been installed without these files.
    """
    for folders in SOUGHT[what]:
        if folders[""].is_dir():
            found = {
                (PurePosixPath(begins) / path.relative_to(folder).as_posix()): path
                for begins, folder in folders.items()
                for path in folder.rglob("*")
                if path.is_file() and path.suffix not in LEAVE_OUT and path.name != PAGE
            }
            shown = [name for name in found if not any(part.startswith(".") for part in name.parts)]
            return {str(name): found[name] for name in sorted(shown, key=lambda name: (len(name.parts), name))}
    raise UsageError(f"no {what} are installed in {PACKAGE}; reinstall the package")


def title(path: Path) -> str:
    """Return the title of a file, from its first lines; "" if it has none."""
    match = re.match(HEADS.get(path.suffix, COMMENT), path.read_text("utf-8"))
    return match[1].strip() if match else ""
