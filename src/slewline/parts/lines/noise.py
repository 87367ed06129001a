"""Noise on a serial line: characters lost, garbled or late, or with a wrong parity bit or no stop bit.

A plan affects future characters: the next `count` characters, or, with a `chance` below 1, each
character with this probability until `count` characters have been hit.  The random numbers are seeded,
so a plan is repeatable.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ...errors import UsageError

KINDS = ("lost", "garbled", "parity", "framing")  # faults possible on a wire
LINKED = (*KINDS, "late")  # faults possible on a link
WORD = (1 << 64) - 1


class RandomSequence:
    """A seeded sequence of random numbers (splitmix64)."""

    def __init__(self, seed: int) -> None:
        self.state = seed & WORD

    def below(self, number: int) -> int:
        """Return a number from 0 to number-1, all equally likely."""
        self.state = self.state + 0x9E3779B97F4A7C15 & WORD
        mixed = (self.state ^ self.state >> 30) * 0xBF58476D1CE4E5B9 & WORD
        mixed = (mixed ^ mixed >> 27) * 0x94D049BB133111EB & WORD
        return (mixed ^ mixed >> 31) * number >> 64


@dataclass
class NoisePlan:
    """A planned fault: its kind, the number of characters still to hit, and the chance of each hit.

    `after` is the number of characters that pass before the first one that may be hit.
    """

    kind: str
    count: int
    chance: float
    after: int
    source: RandomSequence = field(repr=False)

    def __post_init__(self) -> None:
        for name, least in (("count", 1), ("after", 0)):
            value = getattr(self, name)
            if not isinstance(value, int) or value < least:
                raise UsageError(f"{name} {value!r}; allowed {least} or more characters")
        if not isinstance(self.chance, (int, float)) or not 0 < self.chance <= 1:
            raise UsageError(f"chance {self.chance!r}; allowed above 0 and up to 1")

    def strikes(self) -> bool:
        """Count the character that begins now, and return whether the plan hits this character."""
        if self.after:
            self.after -= 1
            return False
        if self.chance < 1 and self.source.below(WORD + 1) >= self.chance * (WORD + 1):
            return False
        self.count -= 1
        return True


class Noise:
    """The noise in one direction of a line whose characters have a given number of data bits.

    Args:
        bits: the number of data bits.
        kinds: possible faults of a character.
        spared: the index (0: the lowest bit) of a data bit that is never garbled, such as a bit that a
            checksum does not cover; None: any bit may be garbled.
    """

    def __init__(self, bits: int, kinds: tuple[str, ...] = KINDS, spared: int | None = None) -> None:
        self.bits, self.spared = bits, bits if spared is None else spared
        self.plans: list[NoisePlan] = []
        self.done = dict.fromkeys(kinds, 0)  # number of characters hit

    def plan(self, kind: str, count: int = 1, chance: float = 1, seed: int = 0, after: int = 0) -> None:
        """Plan faults of future characters; the plan begins when all earlier plans are completed."""
        if kind not in self.done:
            raise UsageError(f"fault {kind!r}; allowed {', '.join(self.done)}")
        if not isinstance(seed, int):
            raise UsageError(f"seed {seed!r}; expected a whole number")
        self.plans.append(NoisePlan(kind, count, chance, after, RandomSequence(seed)))

    def clear(self) -> None:
        """Cancel all plans."""
        self.plans.clear()

    def strike(self) -> tuple[str, int]:
        """Return the fault ("" if none) of the character that begins now, and the index of the data bit to garble."""
        if not self.plans:
            return "", 0
        plan = self.plans[0]
        if not plan.strikes():
            return "", 0
        if not plan.count:
            self.plans.pop(0)
        self.done[plan.kind] += 1
        bit = plan.source.below(self.bits - (self.spared < self.bits))
        return plan.kind, bit + (bit >= self.spared)

    def hit(self, byte: int) -> tuple[int | None, str]:
        """Return the byte received when `byte` is sent (None if lost), and the fault of its frame ("" if none)."""
        kind, bit = self.strike()
        if kind == "lost":
            return None, ""
        if kind == "garbled":
            return byte ^ 1 << bit, ""
        return byte, kind
