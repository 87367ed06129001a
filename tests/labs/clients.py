"""Programs with clients of EPICS, in processes of their own: ophyd, ophyd-async, bluesky, pyepics.

They run under the Python of `make clients`.  Each says what it has seen in lines of JSON, and goes on after a line.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDER = Path(os.environ.get("SLEWLINE_CLIENTS", ROOT / "build" / "clients"))
PYTHON = FOLDER / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
BEGIN = """
import json, sys, time, warnings
def tell(*what): print(json.dumps(what, default=float), flush=True)
def until(met):
    end = time.monotonic() + 40
    while not met():
        if time.monotonic() > end: raise TimeoutError
        time.sleep(0.01)
"""
EPICS = "import epics\n"
# A move that begins while ophyd still ends the one before is never over for ophyd: settle_time keeps them apart.
OPHYD = """
from ophyd import EpicsMotor
motor = EpicsMotor("m1", name="motor", settle_time=0.1)
motor.wait_for_connection(timeout=40)
"""
ASYNC = """
import asyncio
from ophyd_async.epics.motor import Motor, OffsetMode, UseSetMode
motor = Motor("ca://m1", name="motor")
"""


def need() -> None:
    """Skip the test where they are missing; in CI (`CI` is set) that is a failure."""
    if PYTHON.exists():
        return
    reason = "the clients of EPICS are not installed; this does it:  make clients"
    if os.environ.get("CI"):
        pytest.fail(f"{reason}\n.ci/run does it: this test must not be skipped in CI")
    pytest.skip(reason)


class Client:
    """A program under a Python, by default that of `make clients`."""

    def __init__(self, script: str, python: Path | str = PYTHON) -> None:
        self.process = subprocess.Popen(
            [str(python), "-c", BEGIN + script],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={name: value for name, value in os.environ.items() if not name.startswith("PYTHON")},
            text=True,
        )

    def go_on(self) -> None:
        """Send it a line."""
        assert self.process.stdin is not None
        self.process.stdin.write("\n")
        self.process.stdin.flush()

    def told(self) -> list[object]:
        """Return what it says next."""
        assert self.process.stdout is not None and self.process.stderr is not None
        line = self.process.stdout.readline()
        assert line, self.process.stderr.read()
        seen: list[object] = json.loads(line)
        return seen

    def end(self) -> None:
        """End it, if it has not ended."""
        self.process.kill()
        self.process.communicate()
