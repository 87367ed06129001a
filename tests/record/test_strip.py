"""The picture of one parameter: what holds, what a search tried, and its answer."""

from __future__ import annotations

from pathlib import Path

import pytest

from slewline.errors import UsageError
from slewline.record.pictures.strip import StripPicture, draw, save_strip

VALUES = [500, 1000, 2000, 4000, 8000]
HOLDS = [False, False, True, False, True]


def texts(picture: StripPicture) -> list[str]:
    return [each.get_text() for each in draw(picture).axes[0].texts]


def test_a_search_that_ends_at_what_it_never_tried() -> None:
    picture = StripPicture("Chip", "Acceleration", VALUES, HOLDS, (3, 1), 0)
    assert texts(picture) == ["1. fails: slower", "2. fails: slower", "the answer: 500 was never tried, and fails"]
    assert picture.description == (
        "2 of 5 values of Acceleration hold. Tried: 4000 fails, 1000 fails. Answer: 500, which fails."
    )


def test_a_search_that_ends_at_what_holds() -> None:
    picture = StripPicture("Chip", "Acceleration", VALUES, HOLDS, (2, 3), 2)
    assert texts(picture) == ["1. holds: faster", "2. fails: slower", "the answer: 2000 holds"]
    axes = draw(picture).axes[0]
    ticks = [each.get_text().replace("\u2009", " ") for each in axes.get_xticklabels()]
    assert ticks == ["500", "1 000", "2 000", "5 000", "10 000"]
    low, high = axes.get_xlim()
    assert low == pytest.approx(500 / 2**0.5) and high == pytest.approx(8000 * 2**0.5)


def test_its_title_is_larger_than_all_other_text() -> None:
    figure = draw(StripPicture("Chip", "Acceleration", VALUES, HOLDS, (2, 3), 2))
    (axes,) = figure.axes
    others = [*axes.texts, *axes.get_xticklabels(), axes.xaxis.label, *figure.legends[0].get_texts()]
    assert figure.get_suptitle() == "Chip"
    assert figure._suptitle.get_fontsize() == 11 > max(each.get_fontsize() for each in others)


def test_a_strip_alone_is_saved(tmp_path: Path) -> None:
    picture = StripPicture("Chip", "Acceleration", VALUES, HOLDS)
    assert texts(picture) == [] and picture.description == "2 of 5 values of Acceleration hold."
    save_strip(picture, tmp_path / "strip.svg")
    assert "2 of 5 values" in (tmp_path / "strip.svg").read_text("utf-8")
    with pytest.raises(UsageError, match=r"allowed .*svg|\.svg"):
        save_strip(picture, tmp_path / "strip.txt")
