"""The differences between recorded and expected events, as text: "step 412 is 2 ticks late".

Recorded and expected events are sequences of pairs: an instant (ps), and a direction or a level.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from ..core.messages.whole import counted
from ..core.time.timebase import PS_PER_S, readable

Event = tuple[int, int]


def difference(
    found: Sequence[Event], expected: Sequence[Event], noun: str, words: Mapping[int, str], hz: int = PS_PER_S
) -> str:
    """Return text with the first difference and the number of further differences; "" if there is none.

    Args:
        noun: the word for an event, "step" or "edge".
        words: the names of the event values: {1: "cw", -1: "ccw"}.
        hz: the frequency of a clock; a time difference is given in its ticks if it is a whole number
            of ticks.
    """
    wrong = [n for n, (one, other) in enumerate(zip(found, expected, strict=False)) if one != other]
    if not wrong:
        return _rest(found, expected, noun, words)
    n = wrong[0]
    if found[n:] == expected[n + 1 :]:
        return f"{noun} {n + 1} is missing: expected {_event(expected[n], words)}"
    if found[n + 1 :] == expected[n:]:
        return f"{noun} {n + 1} is one too many: {_event(found[n], words)}"
    more = f"; {counted(len(wrong) - 1, 'more error')}" if len(wrong) > 1 else ""
    many = f"; {counted(len(found), noun)} found, expected {len(expected)}" if len(found) != len(expected) else ""
    return _wrong(found[n], expected[n], f"{noun} {n + 1}", words, hz) + more + many


def _rest(found: Sequence[Event], expected: Sequence[Event], noun: str, words: Mapping[int, str]) -> str:
    """Return text about the extra events of the longer of two sequences; "" if both are equally long."""
    missing = expected[len(found) :]
    extra = found[len(expected) :]
    if not missing and not extra:
        return ""
    first, what = (missing[0], "missing at the end") if missing else (extra[0], "too many at the end")
    number = counted(len(missing or extra), noun)
    return f"{number} {what}: {len(found)} found, expected {len(expected)}; the first is {_event(first, words)}"


def _wrong(found: Event, expected: Event, name: str, words: Mapping[int, str], hz: int) -> str:
    late = found[0] - expected[0]
    if not late:
        return f"{name} is {_event(found, words)}, expected {words[expected[1]]}"
    how = f"{name} is {amount(abs(late), hz)} {'late' if late > 0 else 'early'}"
    return f"{how}: {_event(found, words)}, expected {_event(expected, words)}"


def _event(event: Event, words: Mapping[int, str]) -> str:
    return f"{words[event[1]]} at {readable(event[0])}"


def amount(ps: int, hz: int) -> str:
    """Return a duration as text: in whole ticks of a clock that runs at `hz`, if possible, else in a unit of time."""
    ticks = round(Fraction(ps * hz, PS_PER_S))
    if hz < PS_PER_S and ticks and abs(ps - Fraction(ticks * PS_PER_S, hz)) < 1:  # both instants are rounded down
        return counted(ticks, "tick")
    return readable(ps)
