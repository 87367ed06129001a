"""The functions of the page that draw nothing: scales, traces, packages, motion between views; run by node."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

TESTS = sorted((Path(__file__).parent / "js").glob("*.test.js"))
NODE = shutil.which("node")


@pytest.mark.check
@pytest.mark.skipif(NODE is None, reason="node is not installed")
@pytest.mark.parametrize("test", TESTS, ids=lambda path: path.name.partition(".")[0])
def test_the_functions_of_the_page(test: Path) -> None:
    assert NODE is not None
    run = subprocess.run([NODE, "--test", str(test)], capture_output=True, text=True, timeout=60, check=False)
    assert run.returncode == 0, run.stdout
