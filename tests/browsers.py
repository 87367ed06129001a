"""The browser of the system, for tests that look at pages as a reader does."""

from __future__ import annotations

import shutil

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")


def chromium():
    """The program; None: it is not here."""
    return next(filter(None, map(shutil.which, NAMES)), None)


def needed():
    """The program; where it is missing the test is skipped."""
    path = chromium()
    if path is None:
        pytest.skip("no Chromium is installed; on Debian:  apt install chromium")
    return path


@pytest.fixture(scope="module")
def browser():
    """Chromium without a window.  What drives it is a package, and has to be there."""
    path = needed()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as running:
        opened = running.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield opened
        opened.close()
