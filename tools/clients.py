"""Install the EPICS clients that test a motor record: tools/clients.py [FOLDER].

They get a separate environment (build/clients), because they need other versions of packages than the tests do.
Existing files are kept.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOCK = ROOT / "requirements" / "clients.lock"
PIP = ["-m", "pip", "install", "-qq", "--disable-pip-version-check", "--no-input"]


def python_of(place: Path) -> Path:
    """Return the Python of the environment in a folder."""
    return place / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")


def main(words: list[str]) -> int:
    """Install the clients; return the exit status."""
    place = Path(words[0]).resolve() if words else ROOT / "build" / "clients"
    python, stamp = python_of(place), place / "installed.lock"
    if python.exists() and stamp.exists() and stamp.read_bytes() == LOCK.read_bytes():
        return 0
    base = str(getattr(sys, "_base_executable", sys.executable))
    print(
        f"clients: installing requirements/clients.lock into {place} (the first time takes a minute)", file=sys.stderr
    )
    for command in (
        [base, "-I", "-m", "venv", "--clear", str(place)],
        [str(python), "-I", *PIP, "--only-binary=:all:", "--require-hashes", "-r", str(LOCK)],
    ):
        if subprocess.call(command, cwd=ROOT) != 0:
            print("clients: could not install them; the reason is above", file=sys.stderr)
            return 1
    stamp.write_bytes(LOCK.read_bytes())  # at the end, so an interrupted installation has no stamp
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
