"""The kinds of phrase that docs/explanation/style.md names are found, and only become fewer (words.toml)."""

from __future__ import annotations

import ast
import re

import pytest

from tests.house.words import (
    KINDS,
    NAMED,
    ROOT,
    SOURCES,
    banned,
    comments,
    counted,
    files,
    grown,
    listed,
    lowered,
    places,
    prose,
    strings,
    written,
)
from tests.sources import text

RULES = (ROOT / "docs/explanation/style.md").read_text("utf-8").partition("## A message")[0].split("\n### ")[1:]
ROW = re.compile(r"^\| [\"`](.+?)[\"`] \| [\"`](.+)[\"`] \|$", re.MULTILINE)
PYTHON, SCRIPT, NOTEBOOK, TEST = (
    'x = f"""{0}"""  # {0}\n',
    '/* {0} */\nsay("{0}");\n',
    '{{"cells": [{{"source": ["{0}"]}}]}}',
    "def test_{1}():\n",
)
PLANTED = {  # a file of each area, a text that has a phrase, and how often
    "README.md": ("{0}\n", 1),
    "CHANGELOG.md": ("# Changelog\n\n## 0.2\n\n- {0}\n\n## 0.1\n\n- {0}\n", 1),
    "CONTRIBUTING.md": ("{0}\n", 1),
    "docs/howto/serve.md": ("# Title\n\n{0}\n\n```text\n{0}\n```\n", 1),
    "docs/lessons/1_ramps.ipynb": (NOTEBOOK, 1),
    "templates/chip/README.md": ("{0}\n", 1),
    "conformance/cy525/language.toml": ('[[fact]]\nid = "A"\nsays = "{0}"\n', 1),
    "src/slewline/errors.py": (PYTHON, 2),
    "src/slewline/panel/page/panel.js": (SCRIPT, 2),
    "firmware/common/motion.c": (SCRIPT, 2),
    "tools/setup.py": (PYTHON, 2),
}


def phrase_of(kind: str) -> str:
    """Return an example of a kind, from the page."""
    section = next(rule for rule in RULES if f"`{kind}`" in rule.rpartition("*Counted as*")[2])
    area = "src_names" if kind == "name" else "src"
    examples = [before.replace("_", " ") for before, _ in ROW.findall(section)]
    return next(each for each in examples if [place.kind for place in banned(each, area)] == [kind])


def test_phrases_that_readers_stumble_over_only_become_fewer() -> None:
    more = grown(counted(), listed())
    assert not more, "\n".join((*more, "where: python -m tests.house.words --since HEAD, or a revision before"))


def test_the_page_has_ten_rules_and_names_every_kind() -> None:
    assert len(RULES) == 10
    named = [kind for rule in RULES for kind in re.findall(r"`(\w+)`", rule.rpartition("*Counted as*")[2])]
    assert sorted(named) == sorted(KINDS)
    assert [*listed()] == [*KINDS]


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.partition(".")[0])
def test_of_each_example_the_first_is_found_and_the_second_is_not(rule) -> None:
    kinds = set(re.findall(r"`(\w+)`", rule.rpartition("*Counted as*")[2]))
    rows = ROW.findall(rule)
    assert len(rows) > 1
    for before, after in rows:
        area = "src_names" if " " not in before else "src"
        assert {place.kind for place in banned(before.replace("_", " "), area)} & kinds, before
        assert banned(after.replace("_", " "), area) == [], after


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_that_is_planted_in_an_area_is_found(kind) -> None:
    phrase, read, missed = phrase_of(kind), files(), []
    for name, (planted, count) in PLANTED.items():
        area = read[ROOT / name]
        found = [where for where, each in places(ROOT / name, area, planted.format(phrase)) if each.kind == kind]
        if kind != "name" and (kind != "question" or area in SOURCES) and found != [area] * count:
            missed.append((name, found))
    assert missed == []


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("person", "question")])
@pytest.mark.parametrize(
    ("name", "planted"),
    [
        ("src/slewline/errors.py", "def {}():\n    pass\n"),
        ("src/slewline/panel/page/panel.js", "function {}() {{}}\n"),
        ("firmware/common/motion.c", "void {}(void);\n"),
        ("tests/house/test_words.py", "def test_{}() -> None:\n"),
    ],
)
def test_each_kind_is_found_in_names(kind, name, planted) -> None:
    phrase = "return what it has" if kind == "clause" else phrase_of(kind)
    area, named = files()[ROOT / name], re.sub(r"\W+", "_", f"a_{phrase}").strip("_")
    found = [(where, place.kind) for where, place in places(ROOT / name, area, planted.format(named))]
    assert (f"{area}_names", kind) in found and (area in NAMED or area == "tests")


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("{}: is a directory; give the name of a file in it", "{} is a directory; give the name of a file in it"),
        ("{}: cannot be read: {}", "{} cannot be read: {}"),
        ("no port {}; there are: {}", "no port {}; available: {}"),
    ],
)
def test_a_message_is_a_sentence_from_its_subject_on(before: str, after: str) -> None:
    assert [place.kind for place in banned(before)] == ["literal"] and banned(after) == []


def test_a_quotation_is_not_read_and_neither_is_code() -> None:
    assert not banned('The manual says "the motor stands still, as it is told".')
    assert not banned(prose("The end.\n\n```text\nanew\n```\nThe edges are told apart by `somebody`.\n"))
    assert [place.phrase for place in banned('told "told" anew')] == ["told", "anew"]


def test_strings_and_comments_of_python_are_read_whole() -> None:
    wrong = (
        'f"{path}: that is over; it is {now}"\n"""A finding is\ntold anew by somebody."""\nx = "begin"  # at\n# once\n'
    )
    found = [place.phrase for each in strings(ast.parse(wrong)) for place in banned(each)]
    assert sorted(found) == ["anew", "somebody", "that is over; it is", "told"]
    assert [place.phrase for each in comments(wrong) for place in banned(each)] == ["at once"]


@pytest.mark.parametrize(
    "right",
    [
        "a chip behind a serial port", "The panel lags behind the chip.", "What is it?", "tell them apart",
        "stands for a pin", "there is no pin",
        "it is no longer served", "no such pin; did you mean SLEW?", "so many that none is left",
    ],
)  # fmt: skip
def test_idiom_is_not_found(right) -> None:
    assert banned(right) == []


def test_a_count_that_rises_fails_and_the_table_is_only_lowered() -> None:
    before = {"speech": {"docs": 2, "src": 1}, "noun": {}}
    now = {"speech": {"docs": 3}, "noun": {"src": 1}, "behind": {"docs": 4}}
    assert grown(now, before) == ["speech in docs: 2 -> 3", "noun in src: 0 -> 1", "behind in docs: 0 -> 4"]
    assert lowered(now, before) == {"speech": {"docs": 2}, "noun": {"src": 0}, "behind": {"docs": 4}}
    assert written({"speech": {"src": 1, "docs": 2}, "noun": {"src": 0}}).splitlines()[1:] == [
        "speech = { docs = 2, src = 1 }",
        "noun = {  }",
    ]


def test_every_room_is_read() -> None:
    read = files()
    names = {file.relative_to(ROOT).as_posix() for file in read}
    assert {
        "README.md", "firmware/common/motion.c", "firmware/common/protocol.h", "firmware/uno/step.S", "tools/setup.py",
        "src/slewline/drive/talk.py", "src/slewline/panel/web_server.py", "src/slewline/errors.py", "benchmarks/run.py",
        "docs/howto/serve.md", "CHANGELOG.md", "docs/lessons/index.md", "templates/part/README.md",
    } <= names  # fmt: skip
    assert {area for area in read.values()} >= {"lessons", "page", "conformance", "tests"}
    assert not any(name.startswith("docs/decisions/") for name in names)
    assert not any(text(file).startswith("<!-- Written by") for file in read if file.suffix == ".md")
