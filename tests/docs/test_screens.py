"""Every built page in Chromium, on a wide screen, on a phone and in the dark theme: nothing is cut off or pale."""

from __future__ import annotations

from pathlib import Path

import pytest

from .blocks import ROOT

pytestmark = pytest.mark.system

SOURCES = sorted(path for ending in ("md", "ipynb") for path in (ROOT / "docs").rglob(f"*.{ending}"))
PAGES = [*(path.relative_to(ROOT / "docs").with_suffix("").as_posix() for path in SOURCES), "genindex", "search"]
VIEWS = {"wide": (1400, 900, "light"), "phone": (390, 844, "light"), "dark": (1400, 900, "dark")}
UNSEEN = Path(__file__).with_name("screens.js").read_text("utf-8")
UNSEEN = UNSEEN[UNSEEN.index("() =>") :]
DARK = "getComputedStyle(document.body).backgroundColor.match(/\\d+/g).every((one) => one < 64)"
FRAME = "new Promise((drawn) => requestAnimationFrame(() => setTimeout(drawn)))"


def seen(page, view):
    """Look at a page in one of the views; return what cannot be seen of it."""
    width, height, scheme = VIEWS[view]
    page.set_viewport_size({"width": width, "height": height})
    page.emulate_media(color_scheme=scheme)
    page.evaluate(FRAME)  # what a script draws has the new width then
    assert page.evaluate(DARK) == (scheme == "dark")
    return page.evaluate(UNSEEN)


@pytest.mark.parametrize("name", PAGES)
def test_nothing_on_a_page_is_cut_off_or_pale(opened, name):
    page = opened(name)
    assert [(view, flaw) for view in VIEWS for flaw in seen(page, view)] == []


LONG = "word " * 60
FLAWS = {
    '<div style="width: 2000px">wide</div>': "beyond the window",
    f'<p style="white-space: nowrap">{LONG}</p>': "run out of it",
    f'<div style="overflow: hidden; white-space: nowrap">{LONG}</div>': "are cut off on the right",
    '<div style="height: 10px; overflow: hidden">one<br>two</div>': "are cut off below",
    f'<table style="table-layout: fixed; white-space: nowrap; width: 60px"><tr><td>{LONG}</table>': "run out of it",
    '<p><img src="{picture}" style="max-width: none; width: 2000px"></p>': "run out of its place",
    '<p style="color: #ddd">pale</p>': "contrast 1",
    '<details><summary>Answer</summary><p style="color: #ddd">pale</p></details>': "contrast 1",
    '<p style="background: #444">grey on <b style="color: #666">grey</b></p>': "contrast 1",
}


@pytest.mark.parametrize("flaw", FLAWS)
def test_invisible_content_is_found(opened, built, flaw):
    page = opened("explanation/time")
    assert seen(page, "phone") == []
    markup = flaw.replace("{picture}", next((built / "_images").iterdir()).as_uri())
    page.evaluate(
        "(markup) => document.querySelector('article section').insertAdjacentHTML('beforeend', markup)", markup
    )
    page.wait_for_function("[...document.images].every((image) => image.complete)")
    assert any(FLAWS[flaw] in found for found in seen(page, "phone"))


@pytest.mark.parametrize("markup", ["<pre>{}</pre>", '<div style="overflow: auto; white-space: nowrap">{}</div>'])
def test_self_scrolling_elements_are_allowed(opened, markup):
    page = opened("explanation/time")
    page.evaluate(
        "(markup) => document.querySelector('article section').insertAdjacentHTML('beforeend', markup)",
        markup.format(LONG),
    )
    assert seen(page, "phone") == []
