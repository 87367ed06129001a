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


@pytest.fixture(scope="module")
def boards_of_a_gs_c200(tmp_path_factory):
    """The same with the firmware of a GS-C200."""
    needs.need()
    emulator = Emulator(build(tmp_path_factory.mktemp("pico"), part="gs-c200"))
    yield emulator
    emulator.close()
