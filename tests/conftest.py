"""Settings of all tests."""

from __future__ import annotations

import gc
import os

import pytest

gc.disable()  # while tests are collected: whatever is made then stays, and to look through it took half of that time


def pytest_collection_finish() -> None:
    """Keep what was collected, ten thousand tests, out of every collection of garbage."""
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave out what needs POSIX where there is none: pseudo-terminals, its signals, its permissions."""
    if not hasattr(os, "openpty"):
        for item in items:
            if item.get_closest_marker("posix"):
                item.add_marker(pytest.mark.skip(reason="needs POSIX"))
