"""The firmware of the Pico, built once, and a process that emulates boards."""

from __future__ import annotations

import pytest

from tools.pico import build

from . import needs
from .emulated import Emulator


@pytest.fixture(scope="session")
def pico(tmp_path_factory):
    """What tools/pico.py makes."""
    needs.need()
    return build(tmp_path_factory.mktemp("pico"))


@pytest.fixture(scope="package")
def boards(pico):
    """A process, for one board after the other."""
    emulator = Emulator(pico)
    yield emulator
    emulator.close()
