"""The documentation, built once for all tests that look at it."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.browsers import browser  # noqa: F401  (a fixture)

from .blocks import ROOT


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """The folder with the built pages; building them gives no warning."""
    out = tmp_path_factory.mktemp("html")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "-d", str(out / ".doctrees"), str(ROOT / "docs"), str(out)]
    ran = subprocess.run(command, check=False, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    return out
