"""The lessons: stored without outputs, complete, in plain words; executed, they print what their prose quotes."""

from __future__ import annotations

import json
import re
from base64 import b64decode

import pytest

from tools.lessons import clean

from .blocks import ROOT
from .lessons import LESSONS, play, printed_by

SECONDS = 8  # of a processor: 6 of one that does nothing else
PATHS = re.compile(r"(?:^|[\s\"'(=])(?:/(?:home|Users|root|tmp|work|usr|var)/|[A-Za-z]:\\\\|file:)")
each_lesson = pytest.mark.parametrize("lesson", LESSONS, ids=lambda path: path.stem)


def cells(lesson, kind):
    book = json.loads(lesson.read_text("utf-8"))
    return ["".join(cell["source"]) for cell in book["cells"] if cell["cell_type"] == kind]


def prose(lesson):
    return "\n\n".join(cells(lesson, "markdown"))


@each_lesson
def test_a_lesson_is_kept_without_outputs(lesson):
    text = lesson.read_text("utf-8")
    assert text == clean(text), "python tools/lessons.py cleans it"
    assert not PATHS.search(text)


def test_leftovers_of_jupyter_are_cleaned(tmp_path):
    """The cleaned form is that which Jupyter writes, so that saving a lesson changes no other line."""
    text = LESSONS[0].read_text("utf-8")
    book = json.loads(text)
    for number, cell in enumerate(cell for cell in book["cells"] if cell["cell_type"] == "code"):
        cell |= {"execution_count": number, "outputs": [{"name": "stdout", "output_type": "stream", "text": ["1\n"]}]}
        cell["metadata"] |= {"ExecuteTime": "now", "scrolled": True}
    book["metadata"]["language_info"]["version"] = "3.11.7"
    assert clean(json.dumps(book)) == text


@each_lesson
def test_a_lesson_has_an_aim_questions_with_folded_answers_exercises_and_a_next_step(lesson):
    text = prose(lesson)
    assert re.match(rf"# Lesson {lesson.stem[0]}: \S", text)
    assert "**Aim.**" in text and "**You need** " in text and "\n## Next\n" in text
    assert text.count("<details><summary>") == text.count("\n\n</details>") >= 4
    hidden = [cell for cell in json.loads(lesson.read_text("utf-8"))["cells"] if cell["metadata"]]
    assert hidden  # solutions: folded in Jupyter as well as on the pages
    assert all(cell["metadata"]["jupyter"]["source_hidden"] and cell["metadata"]["tags"] for cell in hidden)


@each_lesson
def test_a_lesson_has_short_code_and_links_that_lead_somewhere(lesson):
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[\w-]*)?\)", prose(lesson)):
        assert (lesson.parent / target).exists(), target
    for code in cells(lesson, "code"):
        assert len(code.splitlines()) <= 45


def test_the_page_of_the_lessons_lists_all_of_them():
    page = (ROOT / "docs/lessons/index.md").read_text("utf-8")
    assert re.findall(r"\]\((\w+\.ipynb)\)", page) == [path.name for path in LESSONS]
    assert page.split("```{toctree}")[1].split()[1:-1] == [path.stem for path in LESSONS]


@each_lesson
def test_a_lesson_prints_the_quotes_in_its_prose_in_a_few_seconds_and_leaves_no_file(lesson, tmp_path):
    (first := tmp_path / "first").mkdir()
    (second := tmp_path / "second").mkdir()
    played = play(lesson, first)
    quoted = printed_by(lesson).read_text("utf-8")
    assert played.printed == quoted, "see what the prose says of it, then: python -m tests.docs.refresh"
    # The first time what is fast is compiled, and kept.
    assert played.seconds < SECONDS or play(lesson, second).seconds < SECONDS
    pictures = [b64decode(data["image/png"]) for data in played.shown]
    assert len(pictures) >= 3 and all(len(picture) > 5000 for picture in pictures)  # none is empty
    assert [*first.iterdir(), *second.iterdir()] == []
