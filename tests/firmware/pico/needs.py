"""What the tests of the Pico need of the system: a compiler for ARM, its library, node and an emulator."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from tools import pico

ROOT = Path(__file__).resolve().parents[3]
RP2040JS = Path(os.environ.get("SLEWLINE_BOARDS", ROOT / "build" / "boards")) / "node_modules" / "rp2040js"


def missing() -> list[str]:
    """Return what is not here."""
    gone = pico.missing()
    if shutil.which("node") is None:
        gone.append("node")
    if not RP2040JS.exists():
        gone.append("rp2040js")
    return gone


def need() -> None:
    """Skip the test where something is missing; in CI (`CI` is set) only the compiler may be."""
    if not (gone := missing()):
        return
    reason = f"{', '.join(gone)}: not installed; this does it:  make boards"
    if os.environ.get("CI") and not pico.missing():
        pytest.fail(f"{reason}\n.ci/run does it: this test must not be skipped in CI")
    pytest.skip(reason)
