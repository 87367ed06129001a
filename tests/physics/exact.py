"""That nothing but the inputs counts: not who looks, nor when, nor in which blocks is integrated."""

from __future__ import annotations

from collections.abc import Iterator

from ..laws.motor_dialogues import differences, made, play
from ..laws.test_motor_law import ways
from .table import Reading, at_least, check, same

DIALOGUES = range(500, 520)  # others than those of the law itself


@check(42, "edges, places and findings in eight ways", long=True)
def eight_ways() -> Iterator[Reading]:
    different = edges = 0
    for seed in DIALOGUES:
        dialogue = made(seed)
        lazy = play(dialogue).told()
        edges += sum(len(times) for times, _ in play(dialogue).edges().values())
        different += sum(bool(differences(lazy, way())) for _, way in ways(dialogue, soon=False))
    yield at_least("edges of 20 dialogues", edges, 1000)
    yield same("ways that differ", different, 0)
