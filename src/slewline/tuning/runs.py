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
RunKey = tuple[str, str]  # the key of a candidate's move, and the name of a scenario


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

    def follow(self, verdicts: dict[RunKey, Verdict]) -> Outcome | None:
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
    def run_key(self) -> RunKey:
        """The key of the next scenario's verdict."""
        return self.key, self.next.name


@dataclass(slots=True)
class _Row:
    """The progress of one call of `Runs.outcomes`: outcomes found, runs in flight, and waiting chains.

    A run in flight for which no chain waits is judged ahead: an earlier scenario of its candidate may still fail.
    """

    done: dict[int, Outcome] = field(default_factory=dict)  # by number
    flying: dict[Future[Verdict], tuple[int, RunKey]] = field(default_factory=dict)  # with the place of the candidate
    waiting: dict[RunKey, list[_Chain]] = field(default_factory=dict)  # of each run in flight: chains that need it


class Runs:
    """All known verdicts, and the computation of further ones.

    Args:
        judge: a pure function that can be pickled.
        log: earlier verdicts, and the file for new ones; None if verdicts are not kept.
    """

    def __init__(self, judge: Judge, candidates: Candidates, workers: Workers, log: Log | None) -> None:
        self.judge, self.candidates, self.workers, self.log = judge, candidates, workers, log
        self.verdicts: dict[RunKey, Verdict] = {} if log is None else log.verdicts
        self.here = 0  # runs judged in this session
        self.needed: set[RunKey] = set()  # runs on which an outcome depends
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
                if begun == len(places):
                    self._fill(row)
                for future in wait(row.flying, return_when=FIRST_COMPLETED).done:
                    place, run_key = row.flying.pop(future)
                    chains = row.waiting.pop(run_key)
                    self._keep(place, run_key, future)
                    for chain in chains:
                        self._go_on(chain, row)
            normal = True
        finally:
            self._land(row, normal)

    def _go_on(self, chain: _Chain, row: _Row) -> None:
        """Advance a chain as far as verdicts are known; then record its outcome, or let it wait for its next run.

        The run is submitted unless it is already in flight, for another chain or judged ahead.
        """
        outcome = chain.follow(self.verdicts)
        if outcome is not None:
            row.done[chain.number] = outcome
            return
        if chain.run_key not in row.waiting:
            self._submit(chain, chain.next, row)
        row.waiting[chain.run_key].append(chain)

    def _fill(self, row: _Row) -> None:
        """Submit further runs of the last candidates, the first ones first, until enough runs are in flight."""
        waiting = sorted({each.number: each for chains in row.waiting.values() for each in chains}.items())
        ahead = ((chain, each) for _, chain in waiting for each in chain.scenarios[len(chain.names) + 1 :])
        while len(row.flying) < self.workers.window and (found := next(ahead, None)):
            chain, scenario = found
            run_key = chain.key, scenario.name
            if run_key not in self.verdicts and run_key not in row.waiting:
                self._submit(chain, scenario, row)

    def _submit(self, chain: _Chain, scenario: Scenario, row: _Row) -> None:
        try:
            future = self.workers.executor.submit(self.judge, Trial(self.candidates.times(chain.place), scenario))
        except EXECUTORS_FAIL as error:
            raise self._gone(error) from error
        run_key = chain.key, scenario.name
        row.flying[future] = chain.place, run_key
        row.waiting[run_key] = []

    def _keep(self, place: int, run_key: RunKey, future: Future[Verdict]) -> None:
        """Record an executor's verdict on the run of a candidate in a scenario."""
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
            self.log.add(run_key, self.candidates.values(place), verdict)
        self.verdicts[run_key] = verdict

    def _land(self, row: _Row, normal: bool) -> None:
        """Cancel the runs that have not begun, and record the verdicts of the finished ones.

        If no error has occurred (`normal`), wait for the runs in progress before recording.
        """
        left = {future: run for future, run in row.flying.items() if not future.cancel()}
        if normal:
            wait(left)
        for future, run in left.items():
            if future.done() and not future.cancelled() and future.exception() is None:
                self._keep(*run, future)

    def _count(self, outcome: Outcome) -> None:
        key = self.candidates.key(outcome.place)
        self.needed.update((key, name) for name in outcome.names)
        if outcome.killer is not None:
            self.killed[outcome.killer.name] += 1

    def _gone(self, error: BaseException) -> UsageError:
        found = (str(error).splitlines() or [""])[0] or type(error).__name__
        again = "run the same command again to continue"
        kept = "" if self.log is None else f"; {self.log.path} has all verdicts so far: {again}"
        return UsageError(f"{self.workers.remedy or 'the executor has failed'} (error: {found}){kept}")
