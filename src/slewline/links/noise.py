"""Noise on a line: characters that are lost, garbled, late, or come with a wrong parity bit or without stop bit.

A plan says what happens to the characters to come: to each of the next `count` ones, or, with a `chance` below 1, to
each character with this chance until so many were hit.  The source of chance is seeded, so a plan is repeatable.
"""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from ..errors import UsageError
from ..parts.rs232 import FAULTS

KINDS = ("lost", "garbled", *FAULTS)


@dataclass
class Plan:
    """What is to happen to characters."""

    kind: str
    count: int
    chance: float
    random: Random

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UsageError(f"fault {self.kind!r}; allowed {', '.join(KINDS)}")
        if not isinstance(self.count, int) or self.count < 1:
            raise UsageError(f"count {self.count!r}; allowed 1 and more characters")
        if not isinstance(self.chance, (int, float)) or not 0 < self.chance <= 1:
            raise UsageError(f"chance {self.chance!r}; allowed above 0, up to 1")


class Noise:
    """The noise in one direction of a line of so many data bits."""

    def __init__(self, bits: int) -> None:
        self.bits = bits
        self.plans: list[Plan] = []
        self.done = dict.fromkeys(KINDS, 0)  # how many characters were hit

    def plan(self, kind: str, count: int = 1, chance: float = 1, seed: int = 0) -> None:
        """Plan what is to happen to the next characters; plans queue up."""
        self.plans.append(Plan(kind, count, chance, Random(seed)))

    def clear(self) -> None:
        """No more noise."""
        self.plans.clear()

    def hit(self, byte: int) -> tuple[int | None, str]:
        """A character passes: what comes out of it (None: nothing), and the fault of its frame, if any."""
        if not self.plans:
            return byte, ""
        plan = self.plans[0]
        if plan.chance < 1 and plan.random.random() >= plan.chance:
            return byte, ""
        plan.count -= 1
        if not plan.count:
            self.plans.pop(0)
        self.done[plan.kind] += 1
        if plan.kind == "lost":
            return None, ""
        if plan.kind == "garbled":
            return byte ^ 1 << plan.random.randrange(self.bits), ""
        return byte, plan.kind
