"""The browser of the system, for tests that look at pages as a reader does."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

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


@contextmanager
def own_folder() -> Iterator[dict[str, str]]:
    """An environment in which temporary files go to a folder that is deleted: Chromium leaves some behind."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        yield os.environ | {"TMPDIR": folder}


@contextmanager
def opened():
    """Chromium without a window.  What drives it is a package, and has to be there."""
    from playwright.sync_api import sync_playwright

    with own_folder() as environment, sync_playwright() as running:
        browser = running.chromium.launch(executable_path=needed(), args=["--no-sandbox"], env=environment)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def browser():
    """Chromium, for the tests of a file; where it is missing they are skipped."""
    needed()
    with opened() as running:
        yield running
