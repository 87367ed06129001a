"""The documentation, built once for all tests that look at it."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.browsers import browser  # noqa: F401  (a fixture)

from .blocks import ROOT


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """The folder with the built pages; building them gives no warning."""
    out = tmp_path_factory.mktemp("html")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "-d", str(out / ".doctrees"), str(ROOT / "docs"), str(out)]
    ran = subprocess.run(command, check=False, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    return out


@pytest.fixture
def opened(browser, built):  # noqa: F811
    """Open a built page as a file; nothing may show on its console, and it may ask for nothing but files beside it."""
    pages, wrong = [], []

    def page(name, **more):
        one = browser.new_page(**more)
        pages.append(one)
        one.on("pageerror", lambda error: wrong.append(str(error)))
        one.on("console", lambda said: wrong.append(said.text) if said.type in ("error", "warning") else None)
        one.on("request", lambda asked: None if asked.url.startswith(built.as_uri()) else wrong.append(asked.url))
        one.on("requestfailed", lambda asked: wrong.append(f"{asked.url}: {asked.failure}"))
        one.goto((built / f"{name}.html").as_uri())
        return one

    yield page
    for one in pages:
        one.close()
    assert wrong == []
