"""Breakpoints: conditions that pause time each time they are met."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from ...bench.runner import NEVER_PS, Wait
from ...core.wires.pin import Condition
from ...errors import UsageError
from .moments import ArrivalCondition, FindingCondition, PinCondition, RegisterCondition

if TYPE_CHECKING:
    from ...bench import Bench
    from ..lines.pace import Pace


class Breakpoints:
    """The breakpoints of a server.

    Args:
        stopped: called with the text of the breakpoint that was met, once time is paused.
    """

    def __init__(self, bench: Bench, pace: Pace, stopped: Callable[[str], object]) -> None:
        self.bench, self.pace, self.stopped = bench, pace, stopped
        self.rows: list[Mapping[str, Any]] = []  # as requested
        self.conditions: list[Condition] = []
        self.waits: list[Wait] = []
        self.stops = 0  # number of stops

    def replace(self, rows: list[Mapping[str, Any]]) -> list[str]:
        """Replace all breakpoints; return a description of each new breakpoint.

        Raises:
            UsageError, UnknownName: a row names an unknown chip, pin or register; the former breakpoints are
                unchanged.
        """
        conditions = [self.condition(row) for row in rows]
        self.rows, self.conditions = list(rows), conditions
        self.arm()
        return [str(condition) for condition in conditions]

    def move(self, bench: Bench) -> None:
        """Set the same breakpoints on another bench, and wait for them from the current instant on."""
        self.bench = bench
        self.replace(self.rows)

    def condition(self, row: Mapping[str, Any]) -> Condition:
        """Return the condition of a breakpoint, given its row in the request."""
        if "pin" in row:
            return PinCondition(self.bench.pin(row["pin"]), row.get("edge", "any"))
        if "finding" in row:
            return FindingCondition(self.bench, row["finding"])
        chip = self.bench.chips.get(row["chip"])
        if chip is None:
            raise UsageError(f"no chip {row['chip']!r}; allowed: {', '.join(self.bench.chips)}")
        if "address" in row:
            return chip.at_instruction(row["address"])
        axis = chip.axis(row.get("axis", 1))
        if "position" in row:
            return ArrivalCondition(axis, row["position"])
        return RegisterCondition(axis, row["register"], row.get("value"))

    def arm(self) -> None:
        """Start waiting for all breakpoints, from the current instant on."""
        for wait in self.waits:
            self.pace.forget(wait)
        self.waits = []
        for condition in self.conditions:
            condition.begin()
            text = str(condition)
            wait = Wait(condition.met, NEVER_PS, self._done(condition, text), condition.foreseen, condition.nets)
            self.waits.append(wait)
            self.pace.wait(wait)

    def stand(self) -> None:
        """Pause time, and end any client request, such as `step`, that makes time pass during the pause."""
        self.pace.pause_time()
        self.stops += 1

    def _done(self, condition: Condition, text: str) -> Callable[[bool], object]:
        def done(_met: bool) -> None:
            self.stand()
            self.stopped(condition.text if isinstance(condition, FindingCondition) else text)

        return done
