"""Ten little suites as other projects have them, each run as it would be there: pass, and leave nothing.

python -m tests.testing.test_foreign_suites           the same by hand, with the time that a test of each takes
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import pytest

HERE = Path(__file__).with_name("foreign")
SUMMARY = re.compile(r"(\d+) passed(?:, (\d+) skipped)?.* in ([0-9.]+)s")
OF_UNITTEST = re.compile(r"Ran (\d+) tests in ([0-9.]+)s\n\nOK")


class Suite(NamedTuple):
    """A suite: its tests, the plugins of pytest that it loads, the packages that it needs, the arguments."""

    tests: int
    plugins: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    arguments: tuple[str, ...] = ()


SUITES = {
    "xdist": Suite(25, ("xdist",), ("xdist",), ("-n", "2")),
    "random_order": Suite(9, ("pytest_randomly",), ("pytest_randomly",)),
    "asyncio": Suite(5, ("anyio",), ("anyio", "serialx")),
    "unittest": Suite(6),
    "hypothesis": Suite(2, ("_hypothesis_pytestplugin",), ("hypothesis",)),
    "session": Suite(8),
    "threads": Suite(5),
    "visa": Suite(3, (), ("pyvisa", "pyvisa_py")),
    "pymeasure": Suite(2, (), ("pymeasure",)),
    "c_on_a_pty": Suite(4),
}


def run(name: str, folder: Path) -> tuple[int, int, float]:
    """Run a suite in a folder of its own; return how many passed and were skipped, and the seconds it took."""
    suite, module = SUITES[name], f"test_{name}"
    shutil.copy(HERE / "feeder.py", folder)
    shutil.copy(HERE / f"suite_{name}.py", folder / f"{module}.py")
    (folder / "pytest.ini").write_text("[pytest]\n")
    environment = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    plugins = [f"-p{plugin}" for plugin in ("slewline.testing.plugin", "no:cacheprovider", *suite.plugins)]
    words = ["-m", "unittest", module] if name == "unittest" else ["-m", "pytest", "-q", *plugins, *suite.arguments]
    ran = subprocess.run(
        [sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False
    )
    said = ran.stdout + ran.stderr
    found = (OF_UNITTEST if name == "unittest" else SUMMARY).search(said)
    if ran.returncode or found is None:
        pytest.fail(f"{name}: status {ran.returncode}\n{said}", pytrace=False)
    passed, *skipped, seconds = found.groups()
    return int(passed), int(next(iter(skipped), None) or 0), float(seconds)


ON_TERMINALS = [pytest.param("c_on_a_pty", marks=pytest.mark.posix)]


@pytest.mark.system
@pytest.mark.parametrize("name", [*(name for name in SUITES if name != "c_on_a_pty"), *ON_TERMINALS])
def test_a_foreign_suite_passes(name, tmp_path):
    missing = [package for package in SUITES[name].needs if find_spec(package) is None]
    if missing:
        pytest.skip(f"needs {', '.join(missing)}")
    passed, skipped, _ = run(name, tmp_path)
    assert passed + skipped == SUITES[name].tests
    assert passed


def test_every_suite_in_the_folder_is_run():
    assert {path.stem.removeprefix("suite_") for path in HERE.glob("suite_*.py")} == SUITES.keys()


def main() -> None:
    """Print what each suite takes."""
    for name, suite in SUITES.items():
        with TemporaryDirectory() as folder:
            if all(find_spec(package) for package in suite.needs):
                passed, skipped, seconds = run(name, Path(folder))
                print(f"{name:<14} {passed:>3} passed {skipped:>2} skipped {1000 * seconds / passed:>8.1f} ms a test")
            else:
                print(f"{name:<14} needs {', '.join(suite.needs)}")


if __name__ == "__main__":
    main()
