"""Unpack the interpreters of other controllers that run translated programs: tools/interpreters.py FOLDER.

LinuxCNC's `rs274` is in a package that depends on a whole desktop.  No package is installed: they are only unpacked
into FOLDER (build/interpreters), and FOLDER/rs274 calls the program.  Existing files are kept.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = "linuxcnc-uspace"
NEEDED = ("apt-get", "dpkg-deb", "ldd")


class InterpretersError(Exception):
    """A missing program, or the error message of one."""


def called(*words: str | Path, folder: Path, **more: str) -> str:
    """Return the output of a program.

    Raises:
        InterpretersError: the program reports an error.
    """
    ran = subprocess.run(
        [str(word) for word in words],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | more,
    )
    if ran.returncode:
        raise InterpretersError(f"{words[0]} ended with {ran.returncode}:\n{ran.stderr}")
    return ran.stdout


def unpack(package: str, folder: Path) -> Path:
    """Fetch a package, and unpack it into a folder; return the package."""
    called("apt-get", "-qq", "download", package, folder=folder)
    (found,) = folder.glob(f"{package}_*.deb")
    called("dpkg-deb", "-x", found, folder / "files", folder=folder)
    return found


def libraries(folder: Path) -> str:
    """Return the folders of the unpacked libraries, in the format of the loader."""
    found = {path.parent for path in (folder / "files").rglob("*.so*") if "python3" not in path.parts}
    return ":".join(sorted(str(each) for each in found))


def lacking(folder: Path) -> list[str]:
    """Return the libraries that the program does not find."""
    program = folder / "files" / "usr" / "bin" / "rs274"
    told = called("ldd", program, folder=folder, LD_LIBRARY_PATH=libraries(folder))
    return [line.split()[0] for line in told.splitlines() if "not found" in line]


def build(folder: Path) -> Path:
    """Unpack the needed packages into a folder; return the program.

    Raises:
        InterpretersError: the package is not available, or lacks a library.
    """
    program = folder / "rs274"
    if program.exists():
        return program
    if gone := [name for name in NEEDED if shutil.which(name) is None]:
        raise InterpretersError(f"{', '.join(gone)}: not here; on Debian they are")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    package = unpack(PACKAGE, folder)
    depends = called("dpkg-deb", "-f", package, "Depends", folder=folder)
    names = re.findall(r"\blib[\w.+-]+", depends)
    for library in lacking(folder):
        kind = re.match(r"lib[a-z]+", library)
        for name in names:
            if kind and name.startswith(kind[0]) and not name.endswith(("-dev", "-py311")):
                unpack(name, folder)
    if gone := lacking(folder):
        raise InterpretersError(f"rs274 lacks {', '.join(gone)}")
    text = f'#!/bin/sh\nLD_LIBRARY_PATH="{libraries(folder)}" exec "{folder}/files/usr/bin/rs274" "$@"\n'
    program.write_text(text, encoding="utf-8")
    program.chmod(0o755)
    return program


def main(words: list[str]) -> int:
    """Unpack the interpreters, and list them; return the exit status."""
    place = Path(words[0]).resolve() if words else ROOT / "build" / "interpreters"
    try:
        print(build(place))
    except InterpretersError as error:
        print(f"interpreters: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
