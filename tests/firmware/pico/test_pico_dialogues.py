"""Random dialogues at the pins of Picos: answers, steps and outputs are those of the model."""

from __future__ import annotations

import pytest

from .emulated import HZ, Emulator
from .model import PIN_PS, STEP_PS, TOLERANCE_PS
from .replay import converse

pytestmark = pytest.mark.system

# In one of some hundred an input changes within microseconds of a step: before it on the board, which makes all steps
# of a motion as late as the first one, and after it in the model.
MOST = 0.01


def wrong(boards: Emulator, seed: int, part: str = "gs-c200s") -> tuple[int, int, list[str]]:
    """Play a dialogue; return how many modules had a part in it, their steps, and what was wrong."""
    modules, steps, found = 0, 0, []
    for number, shown in enumerate(converse(boards, seed, part)):
        modules += 1
        steps += shown.steps
        is_late = shown.answer > TOLERANCE_PS or shown.pin > PIN_PS + 10**12 * shown.bit // HZ // 16
        if shown.difference or shown.first > TOLERANCE_PS or shown.later > STEP_PS or is_late:
            found.append(f"seed {seed}, module {number}: {shown}")
    return modules, steps, found


def test_dialogues(boards: Emulator) -> None:
    played = [wrong(boards, seed) for seed in range(24)]
    assert not [found for _, _, each in played for found in each]
    assert sum(modules for modules, _, _ in played) >= 24
    assert sum(steps for _, steps, _ in played) > 5000


def test_dialogues_of_a_gs_c200(boards_of_a_gs_c200: Emulator) -> None:
    played = [wrong(boards_of_a_gs_c200, seed, "gs-c200") for seed in range(12)]
    assert not [found for _, _, each in played for found in each]
    assert sum(modules for modules, _, _ in played) >= 12
    assert sum(steps for _, steps, _ in played) > 2000


@pytest.mark.long
@pytest.mark.timeout(1800)
def test_many_dialogues(boards: Emulator) -> None:
    played = [wrong(boards, seed) for seed in range(24, 400)]
    modules, found = sum(count for count, _, _ in played), [text for _, _, each in played for text in each]
    print(*found, sep="\n")
    assert modules >= 370 and sum(steps for _, steps, _ in played) > 100_000
    assert len(found) <= MOST * modules, found
