"""Build wheel, sdist and the firmware of boards into dist/, and check that the build is reproducible.

    python tools/release.py                             build them twice and compare; check the page for an index
    python tools/release.py --tag v0.1.0 --source URL   check first that this version may be released

They are built in two folders that differ in name, file times, permissions, time zone and order of sets; both must
produce the same bytes.  The sdist has the files that git lists, and the wheel is built from the sdist.

Firmware goes into dist/firmware, with the licences of its libraries; if a compiler for a board is not installed, that
firmware is left out, unless there is a tag.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from tempfile import TemporaryDirectory

import pico
from setup import MADE

import firmware as uno
from slewline.version import __version__

ROOT = Path(__file__).resolve().parent.parent
RELEASED = re.compile(r"^## (?P<version>\S+) \((?P<date>\d{4}-\d\d-\d\d)\)$", re.MULTILINE)
PLACES = (  # folder, umask, and what else differs
    ("a", 0o022, {"TZ": "UTC", "PYTHONHASHSEED": "1"}),
    ("another folder/b", 0o077, {"TZ": "Pacific/Auckland", "PYTHONHASHSEED": "2", "LANG": "C"}),
)
DOC = Path("/usr/share/doc")
LICENCES = {  # of the libraries, as installed by the packages of the system
    "picolibc: sqrt and functions of memory, in the firmware of the Pico": DOC / "picolibc-arm-none-eabi/copyright",
    "avr-libc: the start and functions of memory, in the firmware of the Uno": DOC / "avr-libc/copyright",
    "libgcc: arithmetic, in both; GPL with the GCC Runtime Library Exception": DOC / "libgcc-s1/copyright",
    "GNU General Public License, version 3": Path("/usr/share/common-licenses/GPL-3"),
}


def git(root: Path, *arguments: str) -> str:
    """Return the output of git; "" if a folder is not a clone."""
    ran = subprocess.run(["git", *arguments], cwd=root, capture_output=True, text=True, check=False)
    return ran.stdout if ran.returncode == 0 else ""


def files(root: Path) -> list[str]:
    """Return the files of a clone, including new ones, except ignored files; of an sdist, all files."""
    if known := git(root, "ls-files", "-z", "--cached", "--others", "--exclude-standard"):
        return [name for name in known.split("\0") if name and (root / name).is_file()]
    kept = [path.relative_to(root) for path in sorted(root.rglob("*")) if path.is_file()]
    return [path.as_posix() for path in kept if not {*path.parts} & {*MADE, "__pycache__"}]


def hindrances(root: Path, tag: str, source: str) -> list[str]:
    """Return the reasons why a version may not be released."""
    project = tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["project"]
    ours = project.get("urls", {}).get("Source")
    dates = dict(RELEASED.findall((root / "CHANGELOG.md").read_text("utf-8")))
    found = []
    if tag != f"v{__version__}":
        found.append(f"the tag is {tag}, the version in src/slewline/version.py {__version__}")
    if __version__ not in dates:
        found.append(f"CHANGELOG.md has no heading such as '## {__version__} (2030-01-31)'")
    if ours != source:
        found.append(f"Source in [project.urls] of pyproject.toml is {ours!r}, and this repository {source!r}")
    if changed := git(root, "status", "--porcelain").splitlines():
        found.append(f"{len(changed)} files are not committed: {', '.join(line[3:] for line in changed[:5])}")
    return found


def build(root: Path, place: Path, umask: int, environment: dict[str, str]) -> dict[str, bytes]:
    """Return the packages by name, built from a copy of the clone with only the files that git lists."""
    for name in files(root):
        copy = place / "clone" / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(root / name, copy)
        copy.chmod(0o666 & ~umask)
    kept = {name: value for name, value in os.environ.items() if name not in ("SOURCE_DATE_EPOCH", "PYTHONPATH")}
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(place / "dist"), str(place / "clone")]
    ran = subprocess.run(
        command, env=kept | environment, umask=umask, capture_output=True, text=True, check=False, cwd=place
    )
    if ran.returncode:
        sys.exit(f"release: the packages cannot be built:\n{ran.stdout}{ran.stderr}")
    return {path.name: path.read_bytes() for path in sorted((place / "dist").iterdir())}


def built_twice(root: Path) -> dict[str, bytes]:
    """Return the packages by name, if both folders produce the same bytes."""
    with TemporaryDirectory(prefix="slewline-") as folder:
        first, second = (build(root, Path(folder, name), umask, more) for name, umask, more in PLACES)
    if differ := sorted(name for name in first.keys() | second.keys() if first.get(name) != second.get(name)):
        sys.exit(f"release: built twice, and different: {', '.join(differ)}")
    return first


def without_compilers() -> list[str]:
    """Return the missing programs and files for the firmware."""
    return [*uno.missing(), *pico.missing(), *(str(path) for path in LICENCES.values() if not path.exists())]


def built_firmware() -> dict[str, bytes]:
    """Return the firmware of all boards by name, if two folders produce the same bytes."""
    found = []
    with TemporaryDirectory(prefix="slewline-") as folder:
        for name in ("a", "another folder/b"):
            place = Path(folder, name)
            paths = [uno.build(place).path, *(pico.build(place, part=part).path for part in pico.PARTS)]
            found.append({path.name: path.read_bytes() for path in paths})
    if found[0] != found[1]:
        sys.exit("release: the firmware was built twice, and is different")
    return found[0]


def notices() -> str:
    """Return the licences of the firmware, and the versions of the compilers."""
    compilers = [uno.called(name, "--version").splitlines()[0] for name in ("avr-gcc", "arm-none-eabi-gcc")]
    parts = ["slewline: all else that is in it", (ROOT / "LICENSE").read_text("utf-8")]
    for title, path in LICENCES.items():
        parts += [f"{'=' * 100}\n{title}", path.read_text("utf-8")]
    return "\n\n".join([f"The firmware was built by {' and '.join(compilers)}.  It consists of:", *parts])


def write_firmware(target: Path) -> None:
    """Write the firmware, its licences and its checksums into a new folder."""
    target.mkdir()
    made = built_firmware()
    for name, data in made.items():
        (target / name).write_bytes(data)
        print(f"{target.relative_to(ROOT)}/{name}: {len(data):,} bytes, the same twice", flush=True)
    (target / "NOTICES.txt").write_text(notices(), "utf-8")
    sums = [f"{hashlib.sha256(data).hexdigest()}  {name}\n" for name, data in made.items()]
    (target / "SHA256SUMS").write_text("".join(sums), "utf-8")


def main() -> int:
    """Build, check and write; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tag", help="the tag of this commit")
    parser.add_argument("--source", help="the address of the repository")
    asked = parser.parse_args()
    if asked.tag and (found := hindrances(ROOT, asked.tag, asked.source or "")):
        print("release: not yet:", *found, sep="\n  ", file=sys.stderr)
        return 1
    gone = without_compilers()
    if asked.tag and gone:
        print(f"release: not yet: no firmware without {', '.join(gone)}", file=sys.stderr)
        return 1
    target = ROOT / "dist"
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir()
    packages = built_twice(ROOT)
    for name, data in packages.items():
        (target / name).write_bytes(data)
        print(f"dist/{name}: {len(data):,} bytes, the same twice", flush=True)
    if gone:
        print(f"release: no firmware: {', '.join(gone)}: not installed; make boards does it", file=sys.stderr)
    else:
        write_firmware(target / "firmware")
    names = [target / name for name in packages]
    return subprocess.run([sys.executable, "-m", "twine", "check", "--strict", *names], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
