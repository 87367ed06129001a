"""Every printed program to every other part: each line has its verdict, and the result is one that the part takes."""

from __future__ import annotations

import re

import pytest

from slewline.chips import PARTS
from slewline.translation.own.part_writer import linted
from slewline.translation.target_writer import WARNING
from slewline.translation.translate import Translation, translate, translate_text
from slewline.translation.translation_report import LineKind
from tests.ensembles import few, members
from tests.translation.programs import PRINTED, old_cy512, random_program

SOURCES = ("cy500", "cy512", "cy525", "cy545", "cy545b", "gs-c200", "gs-c200s", "mc1451a")


def check(done: Translation, text: str) -> None:
    """What holds for every translation."""
    code = [number for number, line in enumerate(text.splitlines(), 1) if line.split(";")[0].strip()]
    assert [line.number for line in done.report.lines] == code
    assert done.text.splitlines()[: len(WARNING)] == [f"; {line}" for line in WARNING]
    assert linted(done.text, done.report.to) == []
    for line in done.report.lines:
        for verdict in line.verdicts:
            assert verdict.kind is not LineKind.IMPOSSIBLE or verdict.limit, (line.code, verdict)
            assert verdict.kind is not LineKind.NEARLY or (verdict.description and verdict.off), (line.code, verdict)
    comments = [line.partition(";")[2].strip() for line in text.splitlines() if ";" in line]
    kept = [line.partition(";")[2].strip() for line in done.text.splitlines()]
    assert [comment for comment in comments if comment and comment not in kept] == []


@pytest.mark.parametrize("part", PARTS)
def test_each_line_of_a_printed_program_is_classified_and_the_result_has_no_errors(part: str) -> None:
    for path in PRINTED:
        if path.suffix != f".{part}":
            check(translate(path, to=part), path.read_text())
    for text in old_cy512().values():
        check(translate_text(text, "cy512", part), text)


@pytest.mark.parametrize("source", few(SOURCES, 4))
@members("seeds", 2, 300, at_once=60)
def test_so_is_each_line_of_random_programs(source: str, seeds: range) -> None:
    for seed in seeds:
        text = random_program(source, seed)
        for part in list(PARTS)[seed % 3 :: 3]:
            if part != source:
                check(translate_text(text, source, part), text)


def test_a_program_for_the_same_part_remains_what_it_was() -> None:
    for path in PRINTED:
        part = path.suffix[1:]
        done = translate(path, to=part)
        assert done.report.same, path
        if part.startswith("cy"):  # the modules have lines of their own around a program
            assert bare(done.text) == bare(path.read_text()), path


def bare(text: str) -> list[str]:
    """The commands without labels and targets, which may be written either way; QX is two of them."""
    code = [line.split(";")[0].strip() for line in text.splitlines()]
    parts = [part for line in code for part in ([line[0], line[1:]] if line[:1] == "Q" else [line])]
    plain = [re.sub(r"^([JT]|L \d+,?) ?\w*$", r"\1", re.sub(r"^[A-E]\$", "", part)) for part in parts]
    return [part for part in plain if part]


def test_comments_keep_their_order_and_neighbours() -> None:
    path = next(path for path in PRINTED if path.name == "bar.gs-c200")
    text = translate(path, to="gs-c200s").text
    beside = {line.partition(";")[2].strip(): line.partition(";")[0].strip() for line in text.splitlines()}
    assert beside["start"] == "W1" and beside["the first hole"] == "+250" and beside["the blade comes down"] == "A1"
    order = [text.index(word) for word in ("start", "the first hole", "drill now", "four passes", "blade")]
    assert order == sorted(order)


def test_a_program_that_does_not_fit_is_left_out_whole() -> None:
    body = "".join(f"N {n}\nG\n" for n in range(100, 107))
    done = translate_text(f"A\nR 100\nS 8\nE\n+\n{body}0\nQ\nD\n", "cy512", "cy500")
    (line,) = [line for line in done.report.lines if line.code == "E"]
    assert line.kind is LineKind.IMPOSSIBLE and "18 bytes" in line.verdicts[0].limit
    assert not [text for text in done.text.splitlines() if text.startswith(("E", "N", "G", "Q", "D"))]
    assert "; DOES NOT FIT: E" in done.text
