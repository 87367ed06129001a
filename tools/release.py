"""Build wheel and sdist into dist/, and see that they are what anyone else would build.

    python tools/release.py                             build them twice and compare; check what an index will show
    python tools/release.py --tag v0.1.0 --source URL   see first that this version may be released

They are built in two folders that differ in name, age of files, rights, time zone and order of sets; both must give the
same bytes.  The sdist has what git knows, and the wheel is built from the sdist.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from tempfile import TemporaryDirectory

from setup import MADE

from slewline.version import __version__

ROOT = Path(__file__).resolve().parent.parent
RELEASED = re.compile(r"^## (?P<version>\S+) \((?P<date>\d{4}-\d\d-\d\d)\)$", re.MULTILINE)
PLACES = (  # folder, umask, and what else differs
    ("a", 0o022, {"TZ": "UTC", "PYTHONHASHSEED": "1"}),
    ("another folder/b", 0o077, {"TZ": "Pacific/Auckland", "PYTHONHASHSEED": "2", "LANG": "C"}),
)


def git(root: Path, *arguments: str) -> str:
    """Return what git prints; nothing where a folder is no clone."""
    ran = subprocess.run(["git", *arguments], cwd=root, capture_output=True, text=True, check=False)
    return ran.stdout if ran.returncode == 0 else ""


def files(root: Path) -> list[str]:
    """Return the files of a clone, new ones too, but for those that git is to ignore; of an sdist, all files."""
    if known := git(root, "ls-files", "-z", "--cached", "--others", "--exclude-standard"):
        return [name for name in known.split("\0") if name and (root / name).is_file()]
    kept = [path.relative_to(root) for path in sorted(root.rglob("*")) if path.is_file()]
    return [path.as_posix() for path in kept if not {*path.parts} & {*MADE, "__pycache__"}]


def hindrances(root: Path, tag: str, source: str) -> list[str]:
    """Return why a version may not be released."""
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
    """Return the packages by name, built of a copy of the clone; the copy has no more than git would have."""
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
    """Return the packages by name, if both places give the same bytes."""
    with TemporaryDirectory(prefix="slewline-") as folder:
        first, second = (build(root, Path(folder, name), umask, more) for name, umask, more in PLACES)
    if differ := sorted(name for name in first.keys() | second.keys() if first.get(name) != second.get(name)):
        sys.exit(f"release: built twice, and different: {', '.join(differ)}")
    return first


def main() -> int:
    """Build, check, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tag", help="the tag of this commit")
    parser.add_argument("--source", help="the address of the repository")
    asked = parser.parse_args()
    if asked.tag and (found := hindrances(ROOT, asked.tag, asked.source or "")):
        print("release: not yet:", *found, sep="\n  ", file=sys.stderr)
        return 1
    target = ROOT / "dist"
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir()
    for name, data in built_twice(ROOT).items():
        (target / name).write_bytes(data)
        print(f"dist/{name}: {len(data):,} bytes, the same twice", flush=True)
    return subprocess.run(
        [sys.executable, "-m", "twine", "check", "--strict", *target.iterdir()], check=False
    ).returncode


if __name__ == "__main__":
    sys.exit(main())
