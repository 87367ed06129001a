"""What a page, or a message, tells somebody to type works from a clone and from a wheel, and on Windows, too."""

from __future__ import annotations

import re
import shlex
import sys
import tomllib
from itertools import combinations

import pytest

import slewline
from slewline import extras

from .blocks import ROOT

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
ENDS = {".py", ".h", ".c", ".toml"}
SOURCES = [path for top in ("src", "examples") for path in (ROOT / top).rglob("*") if path.suffix in ENDS]
LINE = re.compile(r"\b(?:pip install|pipx \w+|uvx|uv (?:run|pip|tool)) [^\n`]+")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
# Before the first release the name on an index is nobody's, or somebody else's: no page may ask an index for it.
RELEASED = re.search(r"^## \S+ \(\d{4}-\d\d-\d\d\)$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
WHEEL = f"slewline-{slewline.__version__}-py3-none-any.whl"


def requirements(line: str) -> list[str]:
    """What a line wants installed."""
    tool, task, *words = shlex.split(re.split(r" {2,}", line)[0].replace("\\", "/"))
    if (tool, task) == ("uv", "run"):
        return []  # the project around it
    if tool == "pip" or task == "pip":
        return [word for word in words if not word.startswith("-") and word != "install"]
    words = [task, *words]  # pipx run --spec, uvx --from; else what is run is what is asked for
    named = [words[at + 1] for at, word in enumerate(words) if word in ("--spec", "--from")]
    return named or [word for word in words if not word.startswith("-") and word not in ("run", "install")][:1]


def complaint(requirement: str) -> str | None:
    """What is wrong with a requirement; as long as nothing is released, no index has slewline."""
    name, wanted, place = re.fullmatch(r"(.*?)(?:\[([\w,]*)\])?(?: @ (.*))?", requirement).groups()
    ours = name in (".", "slewline") or "/" in name
    if ours and not {*(wanted or "").split(",")} - {""} <= {*PROJECT["optional-dependencies"]}:
        return "no such extra"
    if name == "slewline" and not (place or "").startswith("file:///") and (place or not RELEASED):
        return "asks an index for slewline"
    return "no wheel has this name" if place and not place.endswith(f"/{WHEEL}") else None


def lines(paths) -> list[str]:
    """Every line of some files that installs something."""
    return [line.rstrip(" ).,;") for path in paths for line in LINE.findall(path.read_text("utf-8"))]


@pytest.mark.parametrize("line", ["pip install 'slewline[all]'", "uvx slewline demo"])
def test_a_line_that_needs_an_index_works_after_the_release(line, monkeypatch):
    monkeypatch.setattr(sys.modules[__name__], "RELEASED", "## 0.1.0 (2030-01-31)")
    assert not any(complaint(requirement) for requirement in requirements(line))


@pytest.mark.parametrize("line", sorted({*lines(PAGES)}))
def test_no_line_on_a_page_needs_an_index_for_a_package_of_the_clone(line):
    assert [complaint(requirement) for requirement in requirements(line)] == [None] * len(requirements(line))


@pytest.mark.fact("README-INDEX")
def test_pages_say_that_there_is_nothing_on_an_index_until_there_is():
    pages = (ROOT / "README.md", ROOT / "docs/reference/systems.md")
    said = ["no package on an index yet" in " ".join(page.read_text("utf-8").split()) for page in pages]
    assert said == [not RELEASED] * 2


def test_the_lines_are_found():
    wanted = [requirement for line in lines(PAGES) for requirement in requirements(line)]
    assert {".[pytest]", f"slewline[pytest] @ file:///path/to/{WHEEL}", "pytest", "matplotlib"} <= {*wanted}


@pytest.mark.parametrize(
    "line",
    [
        "pip install slewline",
        'pip install -U "slewline[pytest]"',
        "pip install '.[pytset]'",
        "pipx run slewline demo",
        'uvx --from "slewline[all]" slewline demo',
        "uvx slewline demo",
        "uv pip install slewline",
        'pip install "slewline @ https://example.org/slewline.whl"',
        'pip install "slewline[all] @ file:///path/to/slewline.whl"',
    ],
)
def test_a_line_that_cannot_work_is_found(line, monkeypatch):
    monkeypatch.setattr(sys.modules[__name__], "RELEASED", None)
    assert LINE.fullmatch(line)
    assert any(complaint(requirement) for requirement in requirements(line))


@pytest.mark.parametrize(
    "missing", [each for number in (0, 1, 2, len(extras.EXTRAS)) for each in combinations(extras.EXTRAS, number)]
)
def test_a_message_of_the_program_installs_the_missing_package(missing, monkeypatch):
    gone = {module for extra in missing for _, module in extras.EXTRAS[extra]}
    monkeypatch.setattr("importlib.util.find_spec", lambda module: None if module in gone else module)
    for extra, rows in extras.EXTRAS.items():
        *_, last = LINE.findall(extras.needs("this needs", extra).replace(";", "\n"))
        lacking = [name for name, module in rows if module in gone] or [name for name, _ in rows]
        others = [name for other, rows in extras.EXTRAS.items() if other != extra for name, at in rows if at in gone]
        assert requirements(last) == lacking + others


def test_no_other_message_installs_anything():
    literal = [line for path in SOURCES for line in LINE.findall(path.read_text("utf-8"))]
    assert all("{" in line for line in literal), literal  # made of the names of packages, see above
    assert not [path for path in SOURCES if re.search(r"slewline\[", path.read_text("utf-8"))]


# -------------------------------------------------------------------------------------------------------------- Windows
@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_posix_shell_lines_have_their_windows_version_next_to_them(page):
    text = page.read_text("utf-8")
    for posix, twin in ((r"\.venv/bin/(\w+)", r".venv\Scripts" + "\\"), (r"^ +[A-Z]\w+=\S+ \S", "$env:")):
        for found in re.finditer(posix, text, re.MULTILINE):
            wanted = twin + (found[1] if found.groups() else "")
            assert wanted in text, f"{found[0]!r} without {wanted!r}"
    assert not re.search(r"\| *nc\b|^\W*nc ", text, re.MULTILINE)
    if "/tmp/" in text:
        assert "Windows" in text
    if "$ make demo" in text:
        assert "PS> py tools/setup.py demo" in text
