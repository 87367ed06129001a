"""The search: moves are judged fastest first; for each, the most frequent causes of failure come first.

A move holds if it loses no steps under any scenario; the search ends with the first move that holds.  No
conclusion is drawn from one move about another; the first move that holds is therefore the fastest,
whatever the shape of the region of moves that hold.

Several candidates may be judged at a time.  Therefore, only the first n/2 candidates determine the order
in which the scenarios of the nth candidate are judged: the scenario under which most of them have failed
comes first.  So the order, and with it the result, depends neither on how many runs are in progress nor
on which of them ends first.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from .perturbations import Scenario
from .runs import Outcome, Runs

WORST = 1.8  # maximum lag of a recommended move, steps; at 2 the rotor is at an unstable equilibrium


class Progress(NamedTuple):
    """The progress of a search.

    `left` is the number of undecided candidates that are faster than the best so far.
    """

    doing: str  # "listing the moves", "the fastest that holds" ...
    done: int
    total: int
    left: int
    best: int | None  # place
    runs: int  # in this session
    time_ps: int | None = None  # of the best so far


OnProgress = Callable[[Progress], object]


@dataclass(frozen=True, slots=True)
class Picked:
    """The two moves that a search picks: the fastest move that holds, and the recommended move.

    Each is None if there is no such move.  `switched` is True if the recommended move was judged with a
    switching chopper as well.
    """

    best: Outcome | None
    recommended: Outcome | None
    switched: bool  # the recommended move was judged with a switching chopper, too


class BestFirst:
    """One search.

    Args:
        runs: all known verdicts, and the computation of further ones.
        scenarios: all scenarios under which a move must hold.
        switching: the same scenarios with a switching chopper, for the recommended move; may be empty.
        whole: True to judge every candidate, under the nominal scenarios first; the result is a map.
    """

    def __init__(
        self,
        runs: Runs,
        scenarios: Sequence[Scenario],
        switching: Sequence[Scenario] = (),
        whole: bool = False,
        on_progress: OnProgress = lambda _: None,
    ) -> None:
        self.runs, self.candidates, self.whole, self.on_progress = runs, runs.candidates, whole, on_progress
        self.scenarios, self.switching = tuple(scenarios), tuple(switching)
        self.known: dict[int, Outcome] = {}  # by place
        self._killers: list[str | None] = []  # of the candidates, fastest first
        self._kills: Counter[str] = Counter()  # of the first `_counted` of them
        self._counted = 0

    def find(self) -> Picked:
        """Return the fastest move that holds, and the recommended move; None for a move that does not exist."""
        best: Outcome | None = None
        for outcome in self.runs.outcomes(self.candidates.order, self._order, lambda number: number // 2):
            self.known[outcome.place] = outcome
            self._killers.append(outcome.killer.name if outcome.killer else None)
            best = best or (outcome if outcome.holds else None)
            self._report("map of the grid" if self.whole else "the fastest that holds", len(self.known), best)
            if best and not self.whole:
                break
        if best is None:
            return Picked(None, None, False)
        return self._recommended(best)

    def _report(self, doing: str, done: int, best: Outcome | None) -> None:
        total = len(self.candidates)
        left = max((self.candidates.rank[best.place] + 1 if best else total) - done, 0)
        place = None if best is None else best.place
        time = None if place is None else self.candidates.time_ps[place]
        self.on_progress(Progress(doing, done, total, left, place, self.runs.here, time))

    # ----------------------------------------------------------------------------------------------- order of scenarios
    def _order(self, number: int) -> Sequence[Scenario]:
        """Return the scenarios for the nth candidate, the most frequent causes of failure first.

        Only failures of the first n/2 candidates count, so that the order does not depend on how many candidates
        are judged at a time.  If every candidate is judged (`whole`), the nominal scenarios come first.
        """
        while self._counted < number // 2:
            killer = self._killers[self._counted]
            if killer is not None:
                self._kills[killer] += 1
            self._counted += 1
        return self._sorted(self._kills)

    def _sorted(self, kills: Counter[str]) -> list[Scenario]:
        return sorted(self.scenarios, key=lambda each: (not (self.whole and each.nominal), -kills[each.name]))

    # ------------------------------------------------------------------------------------------------- the recommended
    def _recommended(self, best: Outcome) -> Picked:
        """Return `best`, and the fastest move that has enough margin to be recommended (None if there is none)."""
        order = self._sorted(Counter(filter(None, self._killers)))
        first = self.candidates.rank[best.place]
        for done, place in enumerate(self.candidates.order[first:], first):
            self._report("the recommended one", done, best)
            around = self.candidates.neighbours(place)
            if any(each in self.known and not self.known[each].holds for each in around):
                continue
            if (
                all(each.holds and each.worst <= WORST for each in self._settled([place], order))
                and all(each.holds for each in self._settled(around, order))
                and self._switched(place, around)
            ):
                return Picked(best, self.known[place], bool(self.switching))
        return Picked(best, None, False)

    def _settled(self, places: Sequence[int], order: Sequence[Scenario]) -> Iterator[Outcome]:
        """Yield the outcomes of grid points, known ones first; the others are judged on demand."""
        yield from (self.known[each] for each in places if each in self.known)
        unknown = [each for each in places if each not in self.known]
        for outcome in self.runs.outcomes(unknown, lambda _: order, lambda _: 0):
            self.known[outcome.place] = outcome
            yield outcome

    def _switched(self, place: int, around: Sequence[int]) -> bool:
        """Return whether a move and its grid neighbours (`around`) hold with a switching chopper.

        The neighbours are judged without perturbations.  If there are no switching scenarios, return True.
        """
        nominal = [each for each in self.switching if each.nominal]
        if not self.switching:
            return True
        for places, scenarios in (([place], self.switching), (around, nominal)):
            for outcome in self.runs.outcomes(places, lambda _, scenarios=scenarios: scenarios, lambda _: 0):  # type: ignore[misc]
                if not outcome.holds:
                    return False
        return True
