"""The pairs that people need: nearly all lines are the same or nearly, and both sides run alike."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from slewline.translation.proof.prove import prove
from slewline.translation.translate import Translation, translate, translate_text
from slewline.translation.translation_report import LineKind
from tests.ensembles import members
from tests.rows import rows
from tests.translation.programs import PAIRS, PRINTED, old_cy512, printed, random_program


def done(source: str, to: str) -> list[Translation]:
    """The printed programs of a pair."""
    if source == "cy512":
        return [translate_text(text, source, to, where=name) for name, text in old_cy512().items()]
    return [translate(path, to=to) for path in printed(source)]


def kinds_of(found: Translation) -> list[LineKind]:
    """The result for each command; the directives for the host are not printed in any manual."""
    return [line.kind for line in found.report if not line.code.startswith(("@", "wait "))]


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_nine_tenths_of_the_lines_are_the_same_or_nearly(pair: tuple[str, str]) -> None:
    kinds = [kind for found in done(*pair) for kind in kinds_of(found)]
    assert len(kinds) > 40
    assert kinds.count(LineKind.IMPOSSIBLE) <= len(kinds) / 10


@pytest.mark.parametrize("to", ["linuxcnc", "grbl", "arduino"])
def test_so_are_nine_tenths_at_the_controllers_that_people_need(to: str) -> None:
    kinds = [kind for path in PRINTED for kind in kinds_of(translate(path, to=to))]
    assert len(kinds) > 350
    assert kinds.count(LineKind.IMPOSSIBLE) <= len(kinds) / 10


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_source_and_result_do_the_same_within_what_the_report_states(pair: tuple[str, str]) -> None:
    moves = 0
    for found in done(*pair):
        proof = prove(found)
        assert proof.compared is not None and proof.proven, (found.report.where, proof.compared, proof.lint)
        moves += proof.compared.moves
    assert moves > 20


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
@members("seeds", 6, 300, at_once=30)
def test_so_do_random_programs(pair: tuple[str, str], seeds: range) -> None:
    source, to = pair
    for seed in seeds:
        found = translate_text(random_program(source, seed), source, to)
        proof = prove(found)
        assert proof.proven, (seed, proof.compared)


# ------------------------------------------------------------------------------------------- a proof that can fail
def altered(found: Translation, old: str, new: str) -> Translation:
    """A translation with another line."""
    assert found.text.count(old) >= 1
    return replace(found, text=found.text.replace(old, new, 1))


@pytest.fixture(scope="module")
def weld() -> Translation:
    return translate(next(path for path in printed("cy525") if path.name == "weld.cy525"), to="gs-c200s")


@rows(
    ("old", "new"),
    [
        ("+100", "+101"),
        ("+100", "-100"),
        ("L6", "L5"),
        ("T598", "T300"),
        ("T598", "T900"),
        ("A1\nD5", "C1\nD5"),
        ("C1\n+100", "+100\nC1"),
        ("W1\n", "D9\n"),
        ("D5", "D6"),
        ("D5", "D4"),
    ],
)
def test_a_proof_notices_other_counts_directions_orders_times_and_rates(weld: Translation, old: str, new: str) -> None:
    compared = prove(altered(weld, old, new)).compared
    assert compared is not None and not compared.proven, (old, new)


def test_a_proof_has_a_picture_of_both(weld: Translation, tmp_path: Path) -> None:
    from slewline.translation.proof.picture import draw

    draw(prove(weld), str(tmp_path / "both.svg"), ("cy525", "gs-c200s"))
    picture = (tmp_path / "both.svg").read_text()
    assert "cy525" in picture and "gs-c200s" in picture
