"""The pictures of screens show what panel, debugger and notebook look like today."""

from __future__ import annotations

import re
from itertools import pairwise

import matplotlib.image as images
import numpy as np
import pytest

from tests.browsers import needed

from . import head_pictures
from .terminal.walks import ROOT

pytestmark = [pytest.mark.system, pytest.mark.check]
CELLS = 24  # in each direction; fonts differ from machine to machine, what stands where does not
FAR = 0.08  # of the way from black to white


def cells(path):
    """The mean brightness of the cells of a picture, (CELLS, CELLS), 0 to 1."""
    bright = images.imread(path)[:, :, :3].mean(axis=2)
    rows, columns = (np.linspace(0, size, CELLS + 1).astype(int) for size in bright.shape)
    return np.array(
        [[bright[top:bottom, left:right].mean() for left, right in pairwise(columns)] for top, bottom in pairwise(rows)]
    )


@pytest.mark.parametrize(
    ("draw", "kept"),
    [
        (head_pictures.draw_panel, head_pictures.PANEL),
        (head_pictures.draw_debugger, head_pictures.DEBUGGER),
        (head_pictures.draw_notebook, head_pictures.NOTEBOOK),
    ],
    ids=["panel", "debugger", "notebook"],
)
def test_the_picture_shows_the_present_page(draw, kept, tmp_path):
    """`python -m tests.panel.head_pictures` draws it anew."""
    needed()
    made = tmp_path / "made.png"
    draw(made)
    now, before = images.imread(made), images.imread(kept)
    assert now.shape == before.shape
    assert np.ptp(now[:, :, :3]) > 0.5, "it is all of one colour"
    assert np.abs(cells(made) - cells(kept)).mean() < FAR / 4
    assert np.abs(cells(made) - cells(kept)).max() < FAR * 2


def test_both_are_in_the_readme():
    text = (ROOT / "README.md").read_text("utf-8")
    shown = re.findall(r"!\[[^]]{40,}\]\((docs/images/\w+\.png)\)", text)
    assert {f"docs/images/{path.name}" for path in (head_pictures.PANEL, head_pictures.DEBUGGER)} <= set(shown)
