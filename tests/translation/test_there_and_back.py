"""A to B to A: the same program again, or a loss that one of the two reports names."""

from __future__ import annotations

import pytest

from slewline.translation.proof.prove import prove
from slewline.translation.translate import translate, translate_text
from slewline.translation.translation_report import LineKind
from tests.translation.programs import printed


def commands(text: str) -> list[str]:
    """The lines that are no comments."""
    return [code for line in text.splitlines() if (code := line.split(";")[0].strip())]


@pytest.mark.parametrize("path", printed("gs-c200"), ids=lambda path: path.stem)
def test_a_gs_c200_program_comes_back_from_the_gs_c200s_as_it_was_written(path) -> None:  # type: ignore[no-untyped-def]
    there = translate(path, to="gs-c200s")
    back = translate_text(there.text, "gs-c200s", "gs-c200")
    assert there.report.same
    assert commands(back.text) == commands(path.read_text())


@pytest.mark.parametrize("path", printed("cy525"), ids=lambda path: path.stem)
def test_a_cy525_program_does_the_same_after_a_journey_to_the_gs_c200s_or_a_report_names_the_loss(path) -> None:  # type: ignore[no-untyped-def]
    there = translate(path, to="gs-c200s")
    back = translate_text(there.text, "gs-c200s", "cy525", where="back.cy525")
    lost = there.report.counts[LineKind.IMPOSSIBLE] + back.report.counts[LineKind.IMPOSSIBLE]
    assert lost or prove(back).proven
