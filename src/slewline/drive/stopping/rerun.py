"""Another run of a chip: why it is made, where its motion comes to rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...core.motion.axis import Axis


class Cause(NamedTuple):
    """Why the board has stopped: inputs with their instants of the model (ps), the first one is what stopped it."""

    entries: Sequence[Mapping[str, Any]]
    without: tuple[int, ...] = ()
    lead_ps: int = 0  # so much before the motor stops the first one comes

    def at(self, instant: int) -> list[dict[str, Any]]:
        """Return the inputs, with the first one moved so that it acts at an instant (ps); none comes before it."""
        first = instant - self.lead_ps
        return [
            {**entry, "t": first if number == 0 else max(int(entry["t"]), first)}
            for number, entry in enumerate(self.entries)
        ]


class Rewound(NamedTuple):
    """Another run, and what it has come to."""

    bench: Bench
    instant: int  # at which the chip was told (ps)
    since_ps: int  # when the first input came
    missing: int  # how many steps it has made too few, in the direction of the motion; below 0: too many
    rest_ps: int  # when the last one was
    stands: bool  # the motion has come to its end


def following(tried: Mapping[int, Rewound], times: Sequence[int]) -> int | None:
    """Return which instant to try next (ps): between one that is too early and one too late, if there are both.

    With one of them alone so many steps on as are missing; None: there are none.
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
    """Return the name of the command that a chip works on, from the text by which it says so."""
    forms = {row.form: row.name for row in chip.sheet.commands}
    return forms.get(text, forms.get(text.partition(" ")[0], ""))


def travelled(axis: Axis, start: int, stop: int) -> tuple[list[int], list[int], int]:
    """Return the steps of an axis at start <= t <= stop (ps): instants, travel after each, and the last direction."""
    times: list[int] = []
    travel: list[int] = []
    sign = 0
    for stretch, train, a, b in axis.played(start, stop):
        if b > a:
            sign = stretch.sign
            times += train.times(a + 1, b).tolist()
            travel += [stretch.travel + sign * (number + 1) for number in range(a, b)]
    return times, travel, sign
