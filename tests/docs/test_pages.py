"""The code on the pages runs as it stands, and prints what the pages say."""

from __future__ import annotations

import re

import pytest

from . import pictures
from .blocks import EVALUATORS, ROOT, languages_of, run_page

TYPED = ROOT / "docs/howto/new_chip.md"  # installs what it makes: test_new_chip.py
TRIED = [
    ROOT / "README.md",
    *sorted((ROOT / "docs/tutorial").glob("*.md")),
    *sorted({*(ROOT / "docs/howto").glob("*.md")} - {TYPED}),
]
EXPLAINED = [
    ROOT / "docs/index.md",
    *sorted((ROOT / "docs/explanation").glob("*.md")),
    ROOT / "docs/reference/api.md",
    ROOT / "docs/reference/api/errors.md",
    ROOT / "docs/reference/build.md",
]
CODE = ("python", "console")  # of these, and what they print; other text is no output
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def name(path):
    return path.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("page", TRIED, ids=name)
def test_every_block_of_a_page_runs_and_prints_the_output_shown(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert languages_of(page) <= set(EVALUATORS)
    assert run_page(page) >= 3


@pytest.mark.parametrize("page", EXPLAINED, ids=name)
def test_python_and_commands_on_the_other_pages_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert languages_of(page) <= {*EVALUATORS}
    run_page(page, CODE)


def pictures_of(page):
    return {(page.parent / found["target"]).resolve() for found in pictures.IMAGE.finditer(page.read_text("utf-8"))}


def without_page():
    """The files in docs/images that no page shows."""
    return sorted({*(ROOT / "docs/images").iterdir()} - {path for page in PAGES for path in pictures_of(page)})


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_picture_is_on_a_tested_page_at_the_start_of_a_line(page):
    if page not in [*TRIED, *EXPLAINED]:
        assert pictures_of(page) == set()
    text = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text("utf-8"), flags=re.DOTALL)
    assert len(re.findall(r"!\[|<img|<picture", text)) == len(pictures.IMAGE.findall(text))


def test_every_picture_is_on_a_page_and_all_of_them_are_small():
    assert without_page() == []
    assert sum(path.stat().st_size for path in (ROOT / "docs/images").iterdir()) < 1_500_000


def test_a_chip_of_ten_commands_takes_less_than_sixty_lines():
    page = (ROOT / "docs/tutorial/a_chip_of_your_own.md").read_text("utf-8")
    sheet, chip = [block.split("```")[0] for block in page.split("```python\n")[1:3]]
    assert "Sheet(" in sheet and "class Mx10(LineChip)" in chip
    lines = [line for line in (sheet + chip).splitlines() if line.strip() and not line.strip().startswith("#")]
    assert len(lines) < 60
    assert sheet.count('    row("') == 10
