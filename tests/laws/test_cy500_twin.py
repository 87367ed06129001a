"""The CY500's fast path and its step-by-step twin leave the same edges on every pin, whatever happens when."""

from __future__ import annotations

import pytest

from tests.ensembles import few

from . import cy500_dialogues
from .twins import agree


@pytest.mark.parametrize("block", few(range(2), 1))
def test_fast_path_and_twin_agree(block: int) -> None:
    agree(cy500_dialogues, range(block * 8, block * 8 + 8))


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_thousand_dialogues_agree() -> None:
    counted = agree(cy500_dialogues, range(10_000, 12_000))
    assert all(counted[kind] >= 200 for kind in cy500_dialogues.KINDS), counted
