"""What the first page denies or restricts is listed in conformance/readme, and a test shows that it is so."""

from __future__ import annotations

import re

import pytest

import slewline
from slewline.chips import PARTS, sheet_of
from tests.sources import text
from tools import conformance

from .blocks import ROOT

TABLE = conformance.tables()["readme"]
LISTED = [row["says"] for row in TABLE.facts.values()]
DENIAL = re.compile(r"\b(?:not|cannot|no|none|never|neither|nor|nothing|nobody|only|\w+n't)\b", re.IGNORECASE)
CODE = re.compile(r"^```.*?^```|^ {4}\S[^\n]*|\]\([^)]*\)", re.MULTILINE | re.DOTALL)  # and the targets of links


def prose(page: str) -> str:
    """Return the words of a page, without its code, in one line."""
    return " ".join(CODE.sub("", page).replace("[", "").split())


def unlisted(page: str, listed: list[str]) -> list[str]:
    """Return each denial of a page that is in none of the phrases that are listed, with the words around it."""
    words = prose(page)
    for phrase in listed:
        words = words.replace(phrase, "...")
    return [words[max(found.start() - 40, 0) : found.end() + 40] for found in DENIAL.finditer(words)]


def test_each_denial_of_the_first_page_is_listed():
    assert unlisted(text(ROOT / "README.md"), LISTED) == []


@pytest.mark.parametrize("phrase", LISTED)
def test_a_phrase_that_is_listed_is_on_the_first_page_and_denies_something(phrase):
    assert phrase in prose(text(ROOT / "README.md"))
    assert DENIAL.search(phrase) and len(phrase.split()) > 4  # a word alone would cover all others


def test_each_row_has_a_test_that_exists():
    assert conformance.disagreements(TABLE, conformance.markers()) == []
    assert {key for row in TABLE.facts.values() for key in row} == {"id", "kind", "says"}  # none is open, none later


@pytest.mark.parametrize(
    "added",
    ["It does not fly.", "| motors | none |", "- No axis\n  moves.", "It can't fly.", "[Only one](README.md) of them."],
)
def test_a_denial_that_is_not_listed_is_found(added):
    assert len(unlisted(f"{text(ROOT / 'README.md')}\n\n{added}\n", LISTED)) == 1


def test_code_and_addresses_deny_nothing():
    assert unlisted("```text\nnot this\n```\n\n    nor --this\n\n[that](a.md#what-we-do-not-know)\n", []) == []


def test_a_row_without_a_test_is_found():
    alone = conformance.Table("README", facts={"README-FLIES": {"id": "README-FLIES", "kind": "limit", "says": "no"}})
    assert [line.partition(":")[0] for line in conformance.disagreements(alone, {})] == [
        "README-FLIES",
        "README, kind limit",
    ]


# ------------------------------------------------------------------------------------------------ what the page denies
FOLDERS = ("benchmarks", "conformance", "docs", "examples", "firmware", "share", "src", "templates", "tests")
RECORDED = {".vcd", ".fst", ".sr", ".dsl", ".sal", ".logicdata", ".csv", ".npz", ".h5", ".wav", ".bin"}


def rows(part):
    sheet = sheet_of(part)
    return [*sheet.pins, *sheet.commands, *sheet.times.values(), *sheet.limits]


@pytest.mark.fact("README-SILICON", "README-EMULATOR")
def test_nothing_here_is_a_recording_of_silicon():
    """A recording of a part or a board is a file, or gives rows another kind of trust; then the page must change."""
    files = [file for folder in FOLDERS for file in (ROOT / folder).rglob("*")]
    assert len(files) > 1000 and [file for file in files if file.suffix in RECORDED] == []
    assert {row.trust for part in PARTS for row in rows(part)} == {"stated", "derived", "chosen", "inferred"}


@pytest.mark.fact("README-EMULATOR")
@pytest.mark.parametrize("page", ["docs/howto/real_motors.md", "docs/reference/stability.md"])
def test_the_pages_about_boards_state_it_too(page):
    words = " ".join(text(ROOT / page).split())
    assert re.search(r"Nothing here has been seen on silicon yet|not yet on silicon", words) and "emulator" in words


@pytest.mark.fact("README-OLDER-PARTS", "README-MANUALS")
@pytest.mark.parametrize(
    ("part", "manual", "sections"),
    [
        (
            "cy500",
            "a magazine article with the command set (no date); CY525 manual, 1984, about its predecessors",
            r"art\. |$",
        ),
        ("cy512", "CY525 manual, 1984: history, comparison, CY512 page, selection guide", r"T\.|s\."),
    ],
)
def test_the_older_parts_follow_an_article_and_the_manual_of_their_successor(part, manual, sections):
    assert sheet_of(part).manual == manual
    assert [row.where for row in rows(part) if row.trust != "inferred" and not re.match(sections, row.where)] == []
    assert any(row.trust == "inferred" for row in rows(part))


@pytest.mark.fact("README-LEVELS")
def test_a_pin_goes_from_a_level_to_another_in_no_time():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.record()
    bench.host(x).send("A 0\rR 100\rN 20\rG\r")
    bench.run_until_idle()
    times, levels = bench.edges("x.pulse")
    assert levels.tolist() == [0, 1] * 20 and (times[1:] > times[:-1]).all()  # an edge has one instant
