"""Another run of the model, after a board has stopped its motor by itself: the inputs to repeat, and when."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...core.motion.axis import Axis


class Cause(NamedTuple):
    """The cause of a board's stop: inputs, with their instants in the model (ps).

    The first input is the one that stopped the board.
    """

    entries: Sequence[Mapping[str, Any]]
    without: tuple[int, ...] = ()
    lead_ps: int = 0  # time from the first input to the stop of the motor

    def at(self, instant: int) -> list[dict[str, Any]]:
        """Return the inputs, shifted in time so that the motor stops at an instant (ps).

        The first input is moved to `lead_ps` before this instant.  Any other input that would then come before
        the first is moved to the same time as the first.
        """
        first = instant - self.lead_ps
        return [
            {**entry, "t": first if number == 0 else max(int(entry["t"]), first)}
            for number, entry in enumerate(self.entries)
        ]


class Rewound(NamedTuple):
    """Another run of the model, and how the motion in it ended."""

    bench: Bench
    instant: int  # at which the chip received the inputs (ps)
    since_ps: int  # time of the first input
    missing: int  # missing steps, in the direction of the motion; below 0: too many steps
    rest_ps: int  # time of the last step
    is_at_rest: bool  # the motion has ended


def following(tried: Mapping[int, Rewound], times: Sequence[int]) -> int | None:
    """Return the instant (ps) at which the next try repeats the inputs; None if no instant is left to try.

    A try was too early if steps were missing in its motion, and too late if the motion had too many steps.
    If there are tries of both kinds, the result is interpolated between the latest early try and the
    earliest late one.  Otherwise it is derived from the last try: if 3 steps were missing (too many), it is
    just after the step that is 3 steps later (earlier) in `times`, the instants of the steps (ps).  The
    result is None if `times` does not extend so far.
    """
    early = max((at for at, found in tried.items() if found.missing > 0), default=None)
    late = min((at for at, found in tried.items() if found.missing < 0), default=None)
    if early is not None and late is not None:
        missing, more = tried[early].missing, -tried[late].missing
        return early + (late - early) * missing // (missing + more)
    last = [*tried][-1]
    step = sum(at <= last for at in times) - 1 + tried[last].missing
    return times[step] + 1 if 0 <= step < len(times) else None


def named(chip: Chip, text: str) -> str:
    """Return the name of a command, given its text as a chip reports it; "" if it is not in the data sheet."""
    forms = {row.form: row.name for row in chip.sheet.commands}
    return forms.get(text, forms.get(text.partition(" ")[0], ""))


def travelled(axis: Axis, start: int, stop: int) -> tuple[list[int], list[int], int]:
    """Return the steps at start <= t <= stop (ps): instants, travel after each, and last direction (0: none)."""
    times: list[int] = []
    travel: list[int] = []
    sign = 0
    for stretch, train, a, b in axis.played(start, stop):
        if b > a:
            sign = stretch.sign
            times += train.times(a + 1, b).tolist()
            travel += [stretch.travel + sign * (number + 1) for number in range(a, b)]
    return times, travel, sign
