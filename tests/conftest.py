"""Settings of all tests."""

from __future__ import annotations

import gc


def pytest_collection_finish() -> None:
    """Keep what was collected, ten thousand tests, out of every collection of garbage."""
    gc.freeze()
