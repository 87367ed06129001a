"""What the tests of firmware need of the system: compilers, node and an emulator."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
AVR8JS = Path(os.environ.get("SLEWLINE_BOARDS", ROOT / "build" / "boards")) / "node_modules" / "avr8js"
PROGRAMS = ("gcc", "avr-gcc", "avr-objcopy", "avr-size", "avr-nm", "node")
LIBRARY = Path("/usr/lib/avr/include/avr/io.h")


def missing() -> list[str]:
    """Return what is not here."""
    gone = [name for name in PROGRAMS if shutil.which(name) is None]
    if "avr-gcc" not in gone and not LIBRARY.exists():
        gone.append("avr-libc")
    if not AVR8JS.exists():
        gone.append("avr8js")
    return gone


def need() -> None:
    """Skip the test where something is missing; in CI (`CI` is set) that is a failure."""
    if not (gone := missing()):
        return
    reason = f"{', '.join(gone)}: not installed; this does it:  make boards"
    if os.environ.get("CI"):
        pytest.fail(f"{reason}\n.ci/run does it: this test must not be skipped in CI")
    pytest.skip(reason)
