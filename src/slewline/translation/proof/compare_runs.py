"""Two traces: what one did and the other did not, and by how much times and rates differ."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from ...core.time.timebase import readable
from ..target_writer import Happened, PlayedTrace

SLACK = 0.01  # of a time, beyond what the report states: steps are whole, and so are clocks
SLACK_PS = 1_000_000_000  # 1 ms
RATE_SLACK = 0.02


@dataclass(frozen=True, slots=True)
class StatedBounds:
    """What a report states.

    Attributes:
        time, rate: by how much times of moves and rates may differ, as fractions.
        top: the greatest rate of the result, steps/s.
    """

    time: float
    rate: float
    top: float


@dataclass(frozen=True, slots=True)
class Compared:
    """The result of a comparison.

    Attributes:
        moves, outputs, inputs: how many of each were compared.
        differences: what is different beyond what the report states, in words; empty: it is proven.
        time_off: the greatest difference of the time of a move, as a fraction.
        rate_off: the greatest difference of a greatest rate, as a fraction.
        stated: the bounds of the report.
        cut: one of the runs had no end and was cut off: as much was compared as both did.
    """

    moves: int
    outputs: int
    inputs: int
    differences: tuple[str, ...]
    time_off: float
    rate_off: float
    stated: StatedBounds
    cut: bool = False

    @property
    def proven(self) -> bool:
        """Whether both did the same within what the report states."""
        return not self.differences

    @property
    def text(self) -> str:
        """What was compared, in a line."""
        counts = ((self.moves, "moves"), (self.outputs, "changes of outputs"), (self.inputs, "changes of inputs"))
        what = ", ".join(f"{number} {name}" for number, name in counts if number)
        times = f"times within {100 * self.time_off:.2g} % (stated {100 * self.stated.time:.2g} %)"
        rates = f"greatest rates within {100 * self.rate_off:.2g} % of each other"
        ended = "; cut off" if self.cut else ""
        if self.proven:
            return f"the same: {what or 'nothing moved'}, in the same order; {times}; {rates}{ended}"
        return f"different: {self.differences[0]}" + (
            f", and {len(self.differences) - 1} more" if len(self.differences) > 1 else ""
        )


def compared(
    one: PlayedTrace,
    two: PlayedTrace,
    bounds: StatedBounds,
    levels: tuple[Mapping[int, int], Mapping[int, int]] = ({}, {}),
    wired: Collection[int] = (1, 2, 3),
) -> Compared:
    """Return how two traces differ.

    Args:
        bounds: what the report states.
        levels: of the outputs at the start of both, by number.
        wired: the outputs that the result has, too; others of the source are left out.
    """
    theirs = [each for each in one.happened if each.kind != "output" or each.number in wired]
    every = sorted({*levels[0], *levels[1]})
    unlike = [number for number in every if levels[0].get(number) != levels[1].get(number)]
    found = [
        matched(without(theirs, dropped - set(kept)), without(two.happened, kept), one.stopped or two.stopped, bounds)
        for kept in subsets(unlike)
        for dropped in (set(unlike),)
    ]
    return min(found, key=lambda each: (len(each.differences), -each.moves - each.outputs))


def matched(theirs: Sequence[Happened], mine: Sequence[Happened], cut: bool, bounds: StatedBounds) -> Compared:
    """Return how two lists of what happened differ; `cut`: one of the runs was cut off."""
    differences: list[str] = []
    time_off = rate_off = 0.0
    counts = {"move": 0, "run": 0, "output": 0, "input": 0}
    for a, b in zip(theirs, mine, strict=False):
        if (a.kind, a.number, a.value) != (b.kind, b.number, b.value):
            differences.append(f"{in_words(a)}, but the result: {in_words(b)}")
            break
        counts[a.kind] += 1
        if a.lasts_ps and b.lasts_ps is not None and abs(a.value) > 1:
            off = abs(b.lasts_ps - a.lasts_ps) / a.lasts_ps
            time_off = max(time_off, off)
            if off > bounds.time + SLACK and abs(b.lasts_ps - a.lasts_ps) > SLACK_PS:
                differences.append(f"{in_words(a)} takes {readable(a.lasts_ps)}, at the result {readable(b.lasts_ps)}")
        if a.rate and b.rate:
            rate_off = max(rate_off, abs(b.rate - a.rate) / a.rate)
            if b.rate > bounds.top * (1 + RATE_SLACK):
                differences.append(f"{in_words(b)}: {b.rate:.0f} steps/s, stated {bounds.top:.0f} at most")
    extra = theirs[len(mine) :] or mine[len(theirs) :]
    if extra and not cut and not differences:
        which = "the source" if len(theirs) > len(mine) else "the result"
        differences.append(f"{which} alone: {in_words(extra[0])}")
    return Compared(
        counts["move"] + counts["run"],
        counts["output"],
        counts["input"],
        tuple(differences),
        time_off,
        rate_off,
        bounds,
        cut,
    )


def subsets(numbers: Sequence[int]) -> list[set[int]]:
    """Return all sets of some numbers."""
    return [{n for at, n in enumerate(numbers) if mask >> at & 1} for mask in range(1 << len(numbers))]


def without(happened: Sequence[Happened], outputs: set[int]) -> list[Happened]:
    """Return what happened, without the first change of some outputs: to the level that the other part begins with."""
    found, left = [], set(outputs)
    for each in happened:
        if each.kind == "output" and each.number in left:
            left.discard(each.number)
        elif each.kind != "delay":
            found.append(each)
    return found


def in_words(each: Happened) -> str:
    """Return something that happened, in words."""
    what = (
        f"{each.value:+d} steps"
        if each.kind == "move"
        else f"{each.kind} {each.number} {'high' if each.value else 'low'}"
    )
    return f"{what} at {readable(each.time_ps)}" if each.time_ps is not None else what
