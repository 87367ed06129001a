"""Deliberately break the source, one small change at a time, and check that a test fails for each.

    python tools/mutations.py              all of tools/mutations.toml
    python tools/mutations.py WORD ...     only mutations with one of the words in name, old or new text, or tests
    python tools/mutations.py --list       the list

A mutation has a name that states the defect (`name`), the texts before and after (`old`, `new`), and the tests that
should fail (`tests`: files below tests/, and options such as -k).  `old` must occur exactly once in src/slewline, or in
the folder or file of it that `within` names, since sister parts read alike; a file of the firmware is
../../firmware/common/NAME.  Every test file is first run on the unbroken source.  The tests of `make test` run first,
then those of `make test-system`; the output names the ones that failed.
The work is done in copies; the checkout is never changed.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from queue import SimpleQueue

ROOT = Path(__file__).resolve().parent.parent
LIST = Path(__file__).with_suffix(".toml")
COPIED = ("src", "tests", "examples", "conformance", "templates", "share", "pyproject.toml")
COPIED += ("docs/reference", "docs/tutorial", "docs/lessons", "firmware", "tools")
WORKERS = 2
TEST_TIMEOUT, RUN_TIMEOUT = 30, 120  # seconds for one test, and for a whole selection
PASSED, FAILED, NONE = 0, 1, 5  # exit status of pytest: all passed, one failed, there are none; any other: an error
SUITES = {"make test": "not long and not check and not system", "make test-system": "system and not long and not check"}
VERDICT = re.compile(r"^FAILED (.*?)(?: - (.*))?$", re.MULTILINE)


@dataclass(frozen=True)
class Mutation:
    """One defect, and the tests that should detect it."""

    name: str
    old: str
    new: str
    tests: str
    within: str = ""  # the folder or the file of src/slewline in which the old text occurs once; "": in all of it

    @property
    def selection(self) -> tuple[str, ...]:
        """Arguments of pytest."""
        return tuple(f"tests/{word}" if word.endswith(".py") else word for word in shlex.split(self.tests))

    @property
    def files(self) -> list[str]:
        """The test files among them."""
        return [word for word in self.selection if word.endswith(".py")]


@dataclass
class Result:
    """The outcome of a mutation."""

    verdict: str  # "caught", "SURVIVED" or "LIST ERROR"
    text: str
    suite: str = ""  # the first of SUITES that detects it

    @property
    def good(self) -> bool:
        """Whether a test has failed."""
        return self.verdict == "caught"


@dataclass
class Copy:
    """A copy of the project in which one mutation at a time is applied."""

    root: Path
    stamps: Iterator[int] = field(default_factory=lambda: count(int(time.time())))

    @classmethod
    def made(cls, root: Path) -> Copy:
        """Copy the project into a folder, and check that Python imports this copy."""
        for name in COPIED:
            source = ROOT / name
            if source.is_dir():
                shutil.copytree(source, root / name, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(source, root / name)
        copy = cls(root)
        found = copy.python("-c", "import slewline; print(slewline.__file__)").stdout.strip()
        if not found or not Path(found).resolve().is_relative_to(root.resolve()):
            sys.exit(f"the copy is not what is imported, but {found or 'nothing'}")
        return copy

    def python(self, *args: str) -> subprocess.CompletedProcess[str]:
        """Run Python on this copy."""
        environment = os.environ | {
            "PYTHONPATH": str(self.root / "src"),
            "TMPDIR": str(self.root.parent),  # a run that fails keeps its files, and here each should
            "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",  # loading them takes longer than most tests
            "COLUMNS": "300",  # room for the reason after the name of a test
        }
        return subprocess.run(
            [sys.executable, *args],
            cwd=self.root,
            env=environment,
            capture_output=True,
            text=True,
            timeout=RUN_TIMEOUT,
            check=False,
        )

    def tested(self, selection: tuple[str, ...]) -> tuple[int | None, str]:
        """Run tests; return the exit status of pytest (None if it timed out), and the failed tests or its message."""
        names = ("no:cacheprovider", "pytest_timeout", "slewline.testing.plugin")
        plugins = (*(word for name in names for word in ("-p", name)), "-o", f"timeout={TEST_TIMEOUT}")
        try:
            done = self.python("-m", "pytest", "-x", "-q", "--no-header", "--tb=no", *plugins, *selection)
        except subprocess.TimeoutExpired:
            return None, f"hanging for {RUN_TIMEOUT} s"
        failed = VERDICT.search(done.stdout)
        if done.returncode == FAILED and failed:
            hung = ", which hung" if "from pytest-timeout" in (failed[2] or "") else ""
            return FAILED, failed[1].removeprefix("tests/") + hung
        last = (done.stdout + done.stderr).strip().splitlines()[-3:]
        return done.returncode, f"pytest ended with {done.returncode}: {' | '.join(last)}"

    def place(self, old: str, within: str) -> Path | str:
        """Return the file that contains a text, or the error of the text."""
        below = self.root / "src" / "slewline" / within
        paths = [below] if below.is_file() else sorted(below.rglob("*.py"))
        found = [(path, times) for path in paths if (times := path.read_text("utf-8").count(old))]
        if len(found) == 1 and found[0][1] == 1:
            return found[0][0]
        where = ", ".join(f"{times} times in {path.relative_to(self.root)}" for path, times in found)
        return f"the old text occurs {where or 'nowhere'}"

    @contextmanager
    def broken(self, path: Path, mutation: Mutation) -> Iterator[None]:
        """Apply a mutation to the copy, and undo it afterwards."""
        source = path.read_text("utf-8")
        self.write(path, source.replace(mutation.old, mutation.new))
        try:
            yield
        finally:
            self.write(path, source)

    def write(self, path: Path, text: str) -> None:
        """Write a file with a new modification time, or Python would use the compiled form of the previous version."""
        path.write_text(text, "utf-8")
        stamp = next(self.stamps)
        os.utime(path, (stamp, stamp))

    def judged(self, mutation: Mutation) -> Result:
        """Apply a mutation, run its tests, and undo it; return the result."""
        path = self.place(mutation.old, mutation.within)
        if isinstance(path, str):
            return Result("LIST ERROR", path)
        if mutation.new == mutation.old:
            return Result("LIST ERROR", "the new text is the old one")
        ran = False
        with self.broken(path, mutation):
            for suite, marks in SUITES.items():
                status, text = self.tested((*mutation.selection, "-m", marks))
                if status in (FAILED, None):
                    return Result("caught", f"{suite}: {text}", suite)
                if status not in (PASSED, NONE):
                    return Result("LIST ERROR", text)
                ran = ran or status == PASSED
        return Result("SURVIVED" if ran else "LIST ERROR", f"{path.name}; tests: {mutation.tests}")


def chosen(words: list[str]) -> list[Mutation]:
    """Return the mutations that match the words."""
    found = [Mutation(**row) for row in tomllib.loads(LIST.read_text("utf-8"))["mutation"]]
    names = [mutation.name for mutation in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        sys.exit(f"{LIST.name}: twice in the list: {'; '.join(twice)}")
    return [m for m in found if not words or any(word in "\n".join((m.name, m.old, m.new, m.tests)) for word in words)]


def judge_all(mutations: list[Mutation], folder: Path) -> Iterator[tuple[Mutation, Result]]:
    """Yield the mutations with their results, in the order of the list."""
    idle: SimpleQueue[Copy] = SimpleQueue()
    for number in range(WORKERS):
        (folder / str(number)).mkdir()
        idle.put(Copy.made(folder / str(number)))

    def unbroken(file: str) -> str:
        copy = idle.get()
        try:
            status, text = copy.tested((file, "-m", " or ".join(f"({marks})" for marks in SUITES.values())))
            return "" if status == PASSED else f"the tests fail without any mutation: {text}"
        finally:
            idle.put(copy)

    def judged(mutation: Mutation) -> Result:
        if wrong := next(filter(None, map(fails.get, mutation.files)), ""):
            return Result("LIST ERROR", wrong)
        copy = idle.get()
        try:
            return copy.judged(mutation)
        finally:
            idle.put(copy)

    with ThreadPoolExecutor(WORKERS) as pool:
        files = list(dict.fromkeys(file for mutation in mutations for file in mutation.files))
        fails = dict(zip(files, pool.map(unbroken, files), strict=True))
        print(f"{len(files)} test file{'' if len(files) == 1 else 's'} ran without a mutation", flush=True)
        yield from zip(mutations, pool.map(judged, mutations), strict=True)


def main() -> int:
    """Try the selected mutations; return the exit status."""
    parser = argparse.ArgumentParser(description="Break the source on purpose, and see that a test notices.")
    parser.add_argument("words", nargs="*", help="only mutations with one of these words")
    parser.add_argument("--list", action="store_true", help="print the list")
    options = parser.parse_args()
    mutations = chosen(options.words)
    if options.list:
        for mutation in mutations:
            print(f"{mutation.name}\n    {mutation.tests}")
        return 0
    began, caught, by = time.monotonic(), 0, Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        for mutation, result in judge_all(mutations, Path(folder)):
            caught += result.good
            by[result.suite] += result.good
            print(f"{result.verdict:10}  {mutation.name}\n            {result.text}", flush=True)
    how = ", ".join(f"{by[suite]} by {suite}" for suite in SUITES)
    print(f"{caught} of {len(mutations)} caught ({how}), in {time.monotonic() - began:.0f} s")
    return 0 if mutations and caught == len(mutations) else 1


if __name__ == "__main__":
    sys.exit(main())
