"""Promises of trains against plain functions of the instant."""

from __future__ import annotations

from random import Random

from slewline.core.time.events import NotYet, ask_at
from slewline.core.time.timebase import Clock


def bounds(random: Random, ticks: list[int], clock: Clock) -> list[int | None]:
    """No bound, and bounds before, at, just after and between the begins."""
    some = [clock.ps(random.choice(ticks) + random.choice([-1, 0, 1, 4])) + random.choice([0, 1]) for _ in range(3)]
    return [None, *some]


def check_promise(view, first: int, last: int, plain, until) -> None:
    """`level`, `after` and `edges` of a promise against a plain function of the instant; `until` bounds it."""

    def level(ps):
        return plain(ps if until is None or ps < until else until - 1)

    assert view.until == until
    edges = [ps for ps in range(first + 1, last + 1) if level(ps) != level(ps - 1)]
    for ps in range(first, last + 1):
        assert view.level(ps) == level(ps)
    for start in range(first, last + 1, max(1, (last - first) // 60)):
        assert view.after(start) == next((ps for ps in edges if ps > start), None)
        for stop in (start, start + 1, (start + last) // 2, last):
            times, levels = view.edges(start, stop)
            inside = [ps for ps in edges if start < ps <= stop]
            assert times.tolist() == inside
            assert levels.tolist() == [level(ps) for ps in inside]


class Asked:
    """A promise that counts how often it is asked for the next edge."""

    until, asked = None, 0

    def __init__(self, of):
        self.of = of

    def level(self, ps):
        return self.of.level(ps)

    def edges(self, start, stop):
        return self.of.edges(start, stop)

    def after(self, ps):
        self.asked += 1
        return self.of.after(ps)


class Early:
    """A promise that answers early: it asks to be asked again before the edge, or though there is none for a while."""

    def __init__(self, promise, stride: int) -> None:
        self.promise, self.stride = promise, stride
        self.level, self.edges = promise.level, promise.edges

    @property
    def until(self):
        return self.promise.until

    def after(self, ps: int):
        edge = self.promise.after(ps)
        at = ask_at(edge)
        return edge if at is None or at <= ps + self.stride else NotYet(ps + self.stride)
