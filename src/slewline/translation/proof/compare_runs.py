"""Comparison of two traces: events that only one of them contains, and differences in times and rates.

Moves, outputs and inputs are compared in their order.  For each move, its steps, its time from the first
step to the last, and its maximum rate are compared.  There is an exception after a run that was stopped:
for the first move to an absolute position, only the position that it reaches is compared.  For a stored
program, each pause is compared as well: it begins with the last step of a move, or with a change of an
output or input, and ends with the next first step or change.  The duration of a wait for an input is not
compared, and neither are pauses in which a host sends commands, since both depend on the surroundings.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from ...core.messages.whole import counted
from ...core.time.timebase import readable
from ..target_writer import Happened, PlayedTrace

SLACK = 0.01  # fraction of a time allowed beyond the report: steps and clocks are whole numbers
SLACK_PS = 1_000_000_000  # 1 ms
RATE_SLACK = 0.02


@dataclass(frozen=True, slots=True)
class StatedBounds:
    """Bounds stated in a report.

    Attributes:
        time, rate: the allowed relative differences in move times and in rates.
        top: the maximum rate of the result, steps/s.
        pause: the allowed relative difference in delays.
        command_ps: an additional allowance for a pause, ps, because parts need time for a command.
        hosted: the number of events at the start that host commands cause; the pauses before them are not
            compared; None: no pauses are compared.
        runs: the number of times that a host runs a stored program; the pause before every run except the
            first depends on the host.
        long: moves with more steps than this complete the ramp to the top rate, in source and result.
    """

    time: float
    rate: float
    top: float
    pause: float = 0.0
    command_ps: int = 0
    hosted: int | None = None
    runs: int = 1
    long: float = float("inf")


@dataclass(frozen=True, slots=True)
class Compared:
    """The result of a comparison.

    Attributes:
        moves, outputs, inputs: the numbers of compared moves, output changes and input changes.
        differences: differences beyond the bounds of the report, in words; empty: the translation is proven.
        time_off: the greatest relative difference in a move time, as a fraction.
        rate_off: the greatest relative difference in the maximum rate of a long move, as a fraction; None:
            there was no long move.
        pause_off_ps: the greatest of the pause differences within the bounds, ps; None: there is none.
        stated: the bounds stated in the report.
        cut: whether one of the runs had no end and was cut off, so that only the common part was compared.
    """

    moves: int
    outputs: int
    inputs: int
    differences: tuple[str, ...]
    time_off: float
    rate_off: float | None
    stated: StatedBounds
    cut: bool = False
    pause_off_ps: int | None = None

    @property
    def proven(self) -> bool:
        """True if both runs agree within the bounds of the report."""
        return not self.differences

    @property
    def text(self) -> str:
        """The result of the comparison in one line: if proven, the compared events; else the first difference."""
        counts = ((self.moves, "move"), (self.outputs, "output change"), (self.inputs, "input change"))
        what = ", ".join(counted(number, name) for number, name in counts if number)
        allows = f"(the report allows {100 * self.stated.time:.2g} %)"
        times = f"times differ by at most {100 * self.time_off:.2g} % {allows}"
        rates = "no rate exceeds the rates in the report"
        if self.rate_off is not None:
            bound = f"(the report allows {100 * self.stated.rate:.2g} %)"
            rates = f"rates of long moves differ by at most {100 * self.rate_off:.2g} % {bound}"
        off = self.pause_off_ps
        pauses = "" if off is None else f"; pauses differ by at most {readable(round(off, -8))}"
        ended = "; cut off" if self.cut else ""
        if self.proven and not what:
            return "nothing moved or switched on either side: this proves nothing"
        if self.proven:
            return f"the same: {what}, in the same order; {times}; {rates}{pauses}{ended}"
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
    """Return the comparison of two traces.

    Args:
        one, two: the traces of source and result.
        bounds: the bounds stated in the report.
        levels: the initial output levels of the source and of the result, each by output number.
        wired: the numbers of the outputs that the result has; the source's other outputs are left out.
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
    """Return the comparison of the source's events and the result's; `cut`: one of the runs was cut off."""
    differences: list[str] = []
    late: list[str] = []
    time_off = 0.0
    rate_off: float | None = None
    pause_off: int | None = None
    counts = {"move": 0, "run": 0, "output": 0, "input": 0}
    before, after = paused(theirs), paused(mine)
    theirs, mine = [each for each, _ in before], [each for each, _ in after]
    apart: Counter[int] = Counter()  # positions of the axes, result less source, after runs that were stopped
    for at, ((a, one), (b, two)) in enumerate(zip(before, after, strict=False)):
        if a.kind == b.kind == "run" and a.net is not None and b.net is not None:
            apart[a.number] += b.net - a.net
        meets = a.kind == b.kind == "move" and a.number == b.number and a.value == b.value + apart[a.number]
        if meets and a.value != b.value:  # both move to the same position
            apart[a.number] = 0
        elif (a.kind, a.number, a.value) != (b.kind, b.number, b.value):
            differences.append(f"{in_words(a)}, but the result: {in_words(b)}")
            break
        counts[a.kind] += 1
        if a.lasts_ps and b.lasts_ps is not None and abs(a.value) > 1 and a.value == b.value:
            off = abs(b.lasts_ps - a.lasts_ps) / a.lasts_ps
            time_off = max(time_off, off)
            if off > bounds.time + SLACK and abs(b.lasts_ps - a.lasts_ps) > SLACK_PS:
                differences.append(f"{in_words(a)} takes {readable(a.lasts_ps)}, in the result {readable(b.lasts_ps)}")
        if one is not None and two is not None and bounds.hosted is not None and at > bounds.hosted:
            if abs(two - one) > (bounds.pause + SLACK) * one + bounds.command_ps:
                late.append(f"{readable(one)} before {in_words(a)}, in the result {readable(two)}")
            else:
                pause_off = max(pause_off or 0, abs(two - one))
        if a.rate and b.rate:
            if abs(a.value) > bounds.long:
                off = abs(b.rate - a.rate) / a.rate
                rate_off = max(rate_off or 0.0, off)
                if off > bounds.rate + RATE_SLACK:
                    description = f"{a.rate:.0f} steps/s, in the result {b.rate:.0f}"
                    differences.append(f"{in_words(a)}: {description}")
            if b.rate > max(bounds.top, a.rate) * (1 + RATE_SLACK):
                differences.append(f"{in_words(b)}: {b.rate:.0f} steps/s, stated {bounds.top:.0f} at most")
    if len(late) >= bounds.runs:
        differences += late
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
        pause_off,
    )


def paused(happened: Sequence[Happened]) -> list[tuple[Happened, int | None]]:
    """Return the events except delays, each with the pause before it, ps.

    The pause is None if it is unknown, or is a wait for an input.  A pause before or after a single step
    counts as unknown, since some parts then wait for the period of their start rate.
    """
    found: list[tuple[Happened, int | None]] = []
    delays, over = 0, None
    single = False
    for each in happened:
        if each.kind == "delay":
            delays += each.value
            continue
        begins = each.time_ps if each.first_ps is None else each.first_ps
        pause = delays if begins is None else None if over is None else begins - over
        before, single = single, each.kind == "move" and abs(each.value) == 1
        found.append((each, None if each.kind == "input" or not found or single or before else pause))
        delays = 0
        over = None if begins is None or each.kind == "run" else begins + (each.lasts_ps or 0)
    return found


def subsets(numbers: Sequence[int]) -> list[set[int]]:
    """Return all subsets of some numbers."""
    return [{n for at, n in enumerate(numbers) if mask >> at & 1} for mask in range(1 << len(numbers))]


def without(happened: Sequence[Happened], outputs: set[int]) -> list[Happened]:
    """Return the events without the first change of each given output.

    Such a change may only set the level that the same output of the other part has from the start.
    """
    found, left = [], set(outputs)
    for each in happened:
        if each.kind == "output" and each.number in left:
            left.discard(each.number)
        else:
            found.append(each)
    return found


def in_words(each: Happened) -> str:
    """Return an event in words."""
    what = (
        f"{each.value:+d} steps"
        if each.kind == "move"
        else f"{each.kind} {each.number} {'high' if each.value else 'low'}"
    )
    return f"{what} at {readable(each.time_ps)}" if each.time_ps is not None else what
