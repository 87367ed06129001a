"""The documentation, built once for all tests that look at it."""

from __future__ import annotations

import os
import subprocess
import sys
import time

import pytest

from tests.browsers import browser  # noqa: F401  (a fixture)

from .blocks import ROOT

BUILD = 1200  # s at most, the lessons included, on a machine that does other things as well


def pytest_collection_modifyitems(items):
    """Give whichever test comes first the time to build the pages."""
    for item in items:
        if "built" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.timeout(BUILD))


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """The folder with the built pages; building them gives no warning.  One worker builds, and the others wait."""
    place = tmp_path_factory.getbasetemp()
    out = (place.parent if "PYTEST_XDIST_WORKER" in os.environ else place) / "html"
    said = out.with_name("sphinx.txt")
    try:
        out.mkdir()
    except FileExistsError:
        while not said.exists():
            time.sleep(0.1)
    else:
        options = ["-q", "-W", "-d", str(out / ".doctrees")]
        command = [sys.executable, "-m", "sphinx", *options, str(ROOT / "docs"), str(out)]
        ran = subprocess.run(command, check=False, capture_output=True, text=True)
        whole = out.with_name("sphinx.part")
        whole.write_text(ran.stderr if ran.returncode else "", "utf-8")
        whole.rename(said)
    assert said.read_text("utf-8") == ""
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
