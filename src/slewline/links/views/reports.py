"""Findings on a terminal: each cause at most once a minute, with the number of its repetitions.

Two findings have the same cause if they differ only in numbers and in the host's data, which is quoted.  The number of
causes per source and code is limited; all further causes are counted together.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from ...core.component import Finding
from ..lines.pace import Lag
from ..sockets.loop import Loop

PERIOD_S = 60.0
CAUSES = 8
SHOWN = 80  # characters of a repeated text
CALM_CHECKS = 2  # checks without a loss after which the lag is over
OTHERS = "others"
ELLIPSIS = "..."
_VARIES = re.compile(r"""b?'(?:[^'\\]|\\.)*'|b?"(?:[^"\\]|\\.)*"|[+-]?(?:0x[0-9a-fA-F]+|[0-9]+)""")

Key = tuple[str, str, str]  # source, code, cause


def cause_of(finding: Finding) -> str:
    """Return the text of a finding without numbers and without the host's data."""
    return _VARIES.sub(ELLIPSIS, finding.text)


def clause(text: str) -> str:
    """Return the first clause of a text, cut between words if it is long."""
    text = text.partition("; ")[0]
    return text if len(text) <= SHOWN else f"{text[:SHOWN].rpartition(' ')[0]} ..."


class FindingReports:
    """The reporter of findings.

    The first finding of a cause is reported immediately, the number of its repetitions a minute later.
    """

    def __init__(self, loop: Loop, report: Callable[[str], object]) -> None:
        self.loop, self.report = loop, report
        self.more: dict[Key, int] = {}  # since the last report of this cause
        self.first: dict[Key, str] = {}  # its last text

    def found(self, finding: Finding) -> None:
        """Report a finding, or only count it if its cause was reported within the last minute."""
        key = finding.source, finding.code, cause_of(finding)
        if key not in self.more and sum(other[:2] == key[:2] for other in self.more) >= CAUSES:
            key = *key[:2], OTHERS
        if key in self.more:
            self.more[key] += 1
            if key[2] != OTHERS and clause(finding.text) != self.first[key]:
                self.first[key] = clause(key[2])  # their common text
        elif key[2] == OTHERS:
            self._begin(key, "")
            self.more[key] = 1
        else:
            self.report(f"{finding.source}: {finding.code}: {finding.text}")
            self._begin(key, clause(finding.text))

    def _begin(self, key: Key, first: str) -> None:
        self.more[key], self.first[key] = 0, first
        self.loop.after(PERIOD_S, lambda: self._over(key))

    def _over(self, key: Key) -> None:
        first = self.first[key]
        if self._count(key):
            self._begin(key, first)

    def _count(self, key: Key) -> int:
        count, first = self.more.pop(key), self.first.pop(key)
        if count:
            what = "with other causes" if key[2] == OTHERS else f"like this: {first}"
            self.report(f"{key[0]}: {key[1]}: {count} more {what}")
        return count

    def close(self) -> None:
        """Report the remaining counts."""
        for key in list(self.more):
            self._count(key)


class Lateness:
    """The reporter of lag: it reports when virtual time cannot follow the wall clock, and when it can again.

    Args:
        lag: the lag of virtual time, including the lost time, as measured by the server's `pace`.
        rate: the requested rate, in virtual seconds per wall-clock second.
        report: called with each message.
    """

    def __init__(self, lag: Lag, rate: float, report: Callable[[str], object]) -> None:
        self.lag, self.rate, self.report = lag, rate, report
        self.seen_ns = self.before_ns = 0  # lost at the last check, and before the present lag
        self.calm = CALM_CHECKS  # checks without a loss

    @property
    def is_late(self) -> bool:
        """True while virtual time lags."""
        return self.calm < CALM_CHECKS

    def check(self) -> None:
        """Report if virtual time has begun to lag, or follows the wall clock again; called every few seconds."""
        lost = self.lag.lost_ns
        if lost == self.seen_ns:
            if self.is_late:
                self.calm += 1
                if not self.is_late:
                    self._over()
            return
        if not self.is_late:
            self.before_ns = self.seen_ns
            self.report(
                f"virtual time lags behind the wall clock ({self._lost()} so far): this machine is too slow, or "
                f"too busy, for --rate {self.rate:g}; give a lower rate, or --lockstep"
            )
        self.seen_ns, self.calm = lost, 0

    def _lost(self) -> str:
        return f"{(self.lag.lost_ns - self.before_ns) / 1e9:.1f} s lost"

    def _over(self) -> None:
        self.report(f"virtual time follows the wall clock again; {self._lost()}")

    def close(self) -> None:
        """Report the lost time, if virtual time still lags at the end."""
        self.check()
        if self.is_late:
            self.report(f"virtual time lagged until the end; {self._lost()}")
