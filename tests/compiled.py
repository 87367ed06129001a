"""The tests over the compiled build.

    make compiled
    python -m pytest -p tests.compiled           all tests; those that start Python start it with that build, too

What is imported is build/compiled, in which a wheel with extension modules is unpacked, beside the environment that
runs the tests.  A run in which the kernel turns out to be plain Python ends at once.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

FOLDER = Path(sys.prefix).parent / "build" / "compiled"

sys.path.insert(0, str(FOLDER))
# of what tests start, and of the workers of pytest-xdist
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(FOLDER), os.environ.get("PYTHONPATH")]))


def pytest_configure() -> None:
    """Refuse to test the plain build under the name of the compiled one."""
    from slewline.cli.version_line import COMPILED, version_line
    from slewline.core.time import kernel

    if COMPILED not in version_line() or FOLDER not in Path(str(kernel.__file__)).parents:
        raise pytest.UsageError(f"{kernel.__file__} is not the compiled build; make compiled builds it in {FOLDER}")


def pytest_report_header() -> str:
    """Say what is tested."""
    from slewline.cli.version_line import version_line

    return version_line()
