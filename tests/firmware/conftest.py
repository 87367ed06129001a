"""The firmware, built once, and a processor that runs it."""

from __future__ import annotations

import pytest

from tools.firmware import build, build_on_pc

from . import needs
from .emulated import Emulator


@pytest.fixture(scope="session")
def firmware(tmp_path_factory):
    """What tools/firmware.py makes."""
    needs.need()
    return build(tmp_path_factory.mktemp("firmware"))


@pytest.fixture(scope="package")
def emulator(firmware):
    """A processor, for one board after the other."""
    emulator = Emulator(firmware)
    yield emulator
    emulator.close()


@pytest.fixture(scope="session")
def script(tmp_path_factory):
    """What boards have in common, as a program of this machine that does what it reads."""
    needs.need()
    return build_on_pc(tmp_path_factory.mktemp("pc"), "script")
