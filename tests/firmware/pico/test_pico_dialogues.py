"""Random dialogues at the pins of Picos: answers, steps and outputs as the model has them."""

from __future__ import annotations

import pytest

from .emulated import HZ, Emulator
from .model import PIN_PS, STEP_PS, TOLERANCE_PS
from .replay import converse

pytestmark = pytest.mark.system

# A switch or a string comes within some microseconds of a step, before it on the board and after it in the model.
COINCIDENCES: dict[int, str] = {
    80: "HOME falls 3.5 us after a step that the board makes 3.9 us late",
    343: "EOT is low for 1 us, 4.6 us before a step, which is then 14 us late",
}


def check(boards: Emulator, seeds: range) -> tuple[int, int]:
    """Play dialogues; return how many modules had a part in them, and their steps."""
    modules = steps = 0
    for seed in seeds:
        for number, shown in enumerate(converse(boards, seed)):
            if seed in COINCIDENCES:
                continue
            assert not shown.difference, (seed, number, shown.difference)
            assert shown.first <= TOLERANCE_PS and shown.later <= STEP_PS, (seed, number, shown)
            assert shown.answer <= TOLERANCE_PS, (seed, number, shown)
            assert shown.pin <= PIN_PS + 10**12 * shown.bit // HZ // 16, (seed, number, shown)
            modules += 1
            steps += shown.steps
    return modules, steps


def test_dialogues(boards: Emulator) -> None:
    modules, steps = check(boards, range(24))
    assert modules >= 24 and steps > 5000


@pytest.mark.long
@pytest.mark.timeout(1800)
def test_many_dialogues(boards: Emulator) -> None:
    modules, steps = check(boards, range(24, 400))
    assert modules >= 370 and steps > 100_000
