"""The documentation builds without a warning, asks nothing of the outside, and its links lead somewhere."""

from __future__ import annotations

import re

import pytest

from .blocks import ROOT

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
OUTSIDE = [
    ROOT / f"{name}.md" for name in ("README", "CHANGELOG", "CONTRIBUTING", "SECURITY")
]  # Sphinx sees none of it


@pytest.fixture(scope="module")
def html(built):
    """The built pages."""
    return {path: path.read_text("utf-8") for path in built.rglob("*.html")}


def test_all_pages_are_built(html):
    built = {path.stem for path in html}
    assert {page.stem for page in PAGES} - {"README"} <= built


def test_no_page_fetches_anything_from_outside(html):
    fetched = r'<(?:script|img|iframe|source|link)\b[^>]*\b(?:src|href)="((?:https?:)?//[^"]*)"'
    assert {url for text in html.values() for url in re.findall(fetched, text)} == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_links_between_the_pages_lead_somewhere(page):
    for target in re.findall(r"\]\((?!https?:)([^)#\s]+)(?:#[\w-]*)?\)", page.read_text("utf-8")):
        assert (page.parent / target).exists(), target


def headings(page) -> set[str]:
    """The anchors that a code host gives to the headings of a page."""
    text = re.sub(r"```.*?^```", "", page.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    found = (
        re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading) for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    )
    return {re.sub(r"[^\w -]", "", heading.lower()).strip().replace(" ", "-") for heading in found}


@pytest.mark.parametrize("page", OUTSIDE, ids=lambda path: path.name)
def test_links_from_outside_the_pages_lead_to_a_heading(page):
    for target, anchor in re.findall(r"\]\((?!https?:)([^)#\s]*)#?([\w-]*)\)", page.read_text("utf-8")):
        other = page.parent / target if target else page
        assert other.exists(), target
        assert not anchor or anchor in headings(other), f"{target}#{anchor}"


def test_the_examples_of_the_readme_are_short_and_it_begins_with_two_commands():
    text = (ROOT / "README.md").read_text("utf-8")
    blocks = re.findall(r"```(\w+)\n(.*?)```", text, re.DOTALL)
    shown = [line.split(" #")[0].strip() for line in blocks[0][1].splitlines()]
    assert shown == ["$ make demo", "$ . .venv/bin/activate"]
    assert all(len(code.splitlines()) <= 20 for language, code in blocks if language == "python")
