"""What the type checker finds for whoever uses the house."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.house.words import ROOT

PLANTED = """
from slewline.core.time.events import Events, NotYet
from slewline.core.wires.wave import Promise


def late(steps: Events, wave: Promise, lag: int) -> int:
    following = steps.time(3)
    if following is None:
        return 0
    edge = wave.after(following)  # error: it may not be known yet
    return following + lag  # error: the same


def right(steps: Events, lag: int) -> int:
    following = steps.time(3)
    return following + lag if isinstance(following, int) else 0
"""


@pytest.mark.check
def test_using_an_unknown_time_as_an_instant_is_found(tmp_path):
    planted = tmp_path / "planted.py"
    planted.write_text(PLANTED, "utf-8")
    ran = subprocess.run(
        [sys.executable, "-m", "mypy", str(planted)],  # strict, as pyproject.toml has it
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=False,
    )
    found = [line for line in ran.stdout.splitlines() if ": error: " in line]
    wrong = [n for n, line in enumerate(PLANTED.splitlines(), 1) if "# error" in line]
    assert [int(line.split(":")[1]) for line in found] == wrong, ran.stdout + ran.stderr
    assert all("NotYet" in line for line in found)
