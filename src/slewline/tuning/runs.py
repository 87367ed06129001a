"""Runs, each judged only once: by this process, by a pool, or by an earlier session that left a log."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from dataclasses import dataclass, field
from typing import NamedTuple

from ..errors import UsageError
from .candidates import Candidates
from .executors import Workers
from .judging import Trial, Verdict
from .perturbations import Scenario
from .sweep_log import Log

Judge = Callable[[Trial], Verdict]
EXECUTORS_FAIL = (BrokenExecutor, CancelledError, OSError)
Order = Callable[[int], Sequence[Scenario]]  # by number in the row: the scenarios of a candidate


class Outcome(NamedTuple):
    """A candidate's outcome: the scenario in which it fails, if any, and its maximum lag.

    The lag is the maximum over the scenarios that were judged; these end with the one in which it fails.
    """

    place: int
    killer: Scenario | None
    worst: float
    names: tuple[str, ...]  # of the scenarios that were judged

    @property
    def holds(self) -> bool:
        """True if the candidate stays in step under every scenario."""
        return self.killer is None


@dataclass(slots=True)
class _Chain:
    """The scenarios of a candidate, which are judged one after another until steps are lost in one."""

    number: int
    place: int
    key: str
    scenarios: Sequence[Scenario]
    worst: float = 0.0
    names: list[str] = field(default_factory=list)

    def follow(self, verdicts: dict[tuple[str, str], Verdict]) -> Outcome | None:
        """Return the outcome of the candidate, if the known verdicts determine it; otherwise None.

        After None, `next` is the first scenario without a known verdict.
        """
        while len(self.names) < len(self.scenarios):
            scenario = self.scenarios[len(self.names)]
            verdict = verdicts.get((self.key, scenario.name))
            if verdict is None:
                return None
            self.names.append(scenario.name)
            self.worst = max(self.worst, verdict.worst)
            if verdict.lost:
                return Outcome(self.place, scenario, self.worst, tuple(self.names))
        return Outcome(self.place, None, self.worst, tuple(self.names))

    @property
    def next(self) -> Scenario:
        """The next scenario to be judged: the first one without a known verdict."""
        return self.scenarios[len(self.names)]

    @property
    def asks(self) -> tuple[str, str]:
        """The key of the next scenario's verdict."""
        return self.key, self.next.name


@dataclass(slots=True)
class _Row:
    """The progress of one call of `Runs.outcomes`: outcomes found, runs in flight, and waiting chains."""

    done: dict[int, Outcome] = field(default_factory=dict)  # by number
    flying: dict[Future[Verdict], _Chain] = field(default_factory=dict)
    waiting: dict[tuple[str, str], list[_Chain]] = field(default_factory=dict)  # moves with the same steps


class Runs:
    """All known verdicts, and the computation of further ones.

    Args:
        judge: a pure function that can be pickled.
        log: earlier verdicts, and the file for new ones; None if verdicts are not kept.
    """

    def __init__(self, judge: Judge, candidates: Candidates, workers: Workers, log: Log | None) -> None:
        self.judge, self.candidates, self.workers, self.log = judge, candidates, workers, log
        self.verdicts: dict[tuple[str, str], Verdict] = {} if log is None else log.verdicts
        self.here = 0  # runs judged in this session
        self.asked: set[tuple[str, str]] = set()  # runs on which an outcome depends
        self.killed: Counter[str] = Counter()  # candidates, by the scenario in which they failed

    def outcomes(self, places: Sequence[int], order: Order, known: Callable[[int], int]) -> Iterator[Outcome]:
        """Yield the outcomes of grid points in the order of `places`, whatever the order of computation.

        Args:
            order: a function that returns the scenarios of the nth candidate, in the order of judging.
            known: a function that returns the number of outcomes that must have been yielded before `order` can
                be called for the nth candidate.
        """
        row = _Row()
        begun = yielded = 0
        normal = False
        try:
            while yielded < len(places):
                if yielded in row.done:
                    outcome = row.done.pop(yielded)
                    yielded += 1
                    self._count(outcome)
                    normal = True
                    yield outcome
                    normal = False
                    continue
                while (
                    yielded not in row.done
                    and begun < len(places)
                    and len(row.flying) < self.workers.window
                    and known(begun) <= yielded
                ):
                    place = places[begun]
                    self._go_on(_Chain(begun, place, self.candidates.key(place), order(begun)), row)
                    begun += 1
                if yielded in row.done:
                    continue
                for future in wait(row.flying, return_when=FIRST_COMPLETED).done:
                    chain = row.flying.pop(future)
                    others = row.waiting.pop(chain.asks)
                    self._keep(chain, future)
                    for each in (chain, *others):
                        self._go_on(each, row)
            normal = True
        finally:
            self._land(row, normal)

    def _go_on(self, chain: _Chain, row: _Row) -> None:
        """Advance a chain as far as verdicts are known; then record its outcome, or submit its next run.

        If another chain has already submitted the same run, wait for that run instead.
        """
        outcome = chain.follow(self.verdicts)
        if outcome is not None:
            row.done[chain.number] = outcome
        elif chain.asks in row.waiting:
            row.waiting[chain.asks].append(chain)
        else:
            run = Trial(self.candidates.times(chain.place), chain.next)
            try:
                future = self.workers.executor.submit(self.judge, run)
            except EXECUTORS_FAIL as error:
                raise self._gone(error) from error
            row.flying[future] = chain
            row.waiting[chain.asks] = []

    def _keep(self, chain: _Chain, future: Future[Verdict]) -> None:
        """Record an executor's verdict on the run of a chain that is judged next."""
        try:
            verdict = future.result()
        except EXECUTORS_FAIL as error:
            raise self._gone(error) from error
        except Exception as error:
            if type(error).__module__.partition(".")[0] != "distributed":
                raise
            raise self._gone(error) from error
        self.here += 1
        if self.log is not None:
            self.log.add(chain.asks, self.candidates.values(chain.place), verdict)
        self.verdicts[chain.asks] = verdict

    def _land(self, row: _Row, normal: bool) -> None:
        """Cancel the runs that have not begun, and record the verdicts of the finished ones.

        If no error has occurred (`normal`), wait for the runs in progress before recording.
        """
        left = {future: chain for future, chain in row.flying.items() if not future.cancel()}
        if normal:
            wait(left)
        for future, chain in left.items():
            if future.done() and not future.cancelled() and future.exception() is None:
                self._keep(chain, future)

    def _count(self, outcome: Outcome) -> None:
        key = self.candidates.key(outcome.place)
        self.asked.update((key, name) for name in outcome.names)
        if outcome.killer is not None:
            self.killed[outcome.killer.name] += 1

    def _gone(self, error: BaseException) -> UsageError:
        found = (str(error).splitlines() or [""])[0] or type(error).__name__
        again = "run the same command again to continue"
        kept = "" if self.log is None else f"; {self.log.path} has all verdicts so far: {again}"
        return UsageError(f"{self.workers.remedy or 'the executor has failed'} (error: {found}){kept}")
