"""Handlers of the requests that control time."""

from __future__ import annotations

from collections.abc import Callable

from ...bench.runner import NEVER, waiting_for
from ...core.time.timebase import moment, picoseconds, readable
from ...core.wires.pin import Condition
from ...errors import UsageError
from ..lines.pace import Paced
from ..time.moments import (
    CommandCondition,
    FindingCondition,
    InstantCondition,
    PinCondition,
    StepCondition,
)
from .pin_verbs import Verbs
from .value_kinds import Data

RESTING = "no command or program is in progress"


class TimeVerbs(Verbs):
    """Handlers of pauses, steps, waits, breakpoints, and returns to the past."""

    def do_pause(self, _request: Data) -> Data:
        """Pause time; also end any wait that lets time run during a pause."""
        self.server.breakpoints.stand()
        return {}

    def do_go(self, request: Data) -> Data:
        """End a pause: time follows the wall clock again or, in lockstep, runs only while a wait needs it."""
        pace = self.server.pace
        if isinstance(pace, Paced):
            pace.go(request.get("rate"))
            found: Data = {"rate": float(pace.rate)}
        else:
            if "rate" in request:
                raise UsageError(
                    "go: rate: in lockstep, there is no rate: time passes only when a host needs it; leave rate out"
                )
            pace.go()
            found = {"rate": 1.0}
        self.server.breakpoints.arm()
        return found

    def do_step(self, request: Data) -> None:
        """Pause time, then let it run until the next event of the requested kind."""
        condition = self.next_event(request)
        self.server.pace.pause_time()
        self.server.breakpoints.arm()
        self.push(request, condition, self.limit(request))

    def push(self, request: Data, condition: Condition, limit_ps: int) -> None:
        """Let paused time run until a condition is met, or to `limit_ps`; `pause`, `go` or a breakpoint stops this."""
        server, stops = self.server, self.server.breakpoints.stops
        pushing = Pushing(condition, lambda: server.breakpoints.stops != stops or not server.pace.paused)
        is_awaited = request["do"] != "advance"

        def reply(_over: bool) -> Data:
            if pushing.reached or pushing.broken_off():
                return {"met": pushing.reached}
            return self.outcome(False, condition)

        self.client.wait(request, reply if is_awaited else lambda _over: {}, pushing, limit_ps, True)

    def outcome(self, met: bool, condition: Condition) -> Data:
        """Return the reply to a wait: whether its condition was met and, if not, the reason.

        The reason consists of an error in the condition, if any (such as an address where no instruction
        begins), and the activity of each busy chip and part.
        """
        if met:
            return {"met": True}
        odd = str(condition).removeprefix(condition.text).lstrip(", ")
        doing = waiting_for(self.bench.chips.values(), self.bench.parts.values())
        return {"met": False, "why": "; ".join(filter(None, (odd, *(doing or [RESTING]))))}

    def do_advance(self, request: Data) -> None:
        """Let time run for the requested duration, in lockstep or while time is paused; reply afterwards."""
        pace = self.server.pace
        end = self.bench.now_ps + picoseconds(request["time"])
        if pace.paused:
            self.server.breakpoints.arm()
            self.push(request, NEVER, end)
        elif pace.lockstep:
            self.client.wait(request, lambda _met: {}, NEVER, end, False)
        else:
            raise UsageError(
                "advance: time follows the wall clock; `pause` time first, or start the server with --lockstep"
            )

    def next_event(self, request: Data) -> Condition:
        """Return the condition that ends the requested step: an edge of a pin, or an event of a chip."""
        if "pin" in request:
            return PinCondition(self.bench.pin(request["pin"]), request.get("edge", "any"))
        chip, by = self.chip(request["chip"]), request["by"]
        if by == "instruction":
            if not chip.program_rows() and chip.program_counter is None:
                raise UsageError(f"{chip.name}: no program is stored, so there is no next instruction")
            return chip.at_instruction()
        if by == "step":
            return StepCondition(self.axis(request))
        return CommandCondition(chip) if by == "command" else FindingCondition(self.bench, chip.name)

    def do_until(self, request: Data) -> None:
        """Wait for a condition; reply when it is met or the wait has timed out."""
        condition = self.condition(request)
        limit = condition.at if isinstance(condition, InstantCondition) else self.limit(request)
        if self.server.pace.paused:
            self.server.breakpoints.arm()
            self.push(request, condition, limit)
        else:
            condition.begin()
            self.client.wait(request, lambda met: self.outcome(met, condition), condition, limit, False)

    def condition(self, request: Data) -> Condition:
        """Return the condition in a request: a pin level, an axis position, a program instruction, or an instant."""
        if "pin" in request:
            return self.bench.pin(request["pin"]).is_(request["level"])
        if "position" in request:
            return self.axis(request).reaches(request["position"])
        if "address" in request:
            return self.chip(request["chip"]).at_instruction(request["address"])
        return self.instant(moment(request["time"]))

    def instant(self, at: int) -> Condition:
        """Return a condition that is met at an instant (ps)."""
        if at < self.bench.now_ps:
            now = readable(self.bench.now_ps)
            raise UsageError(f"until: {readable(at)} is in the past; the time is {now}; for a past time, use `back`")
        return InstantCondition(self.bench.kernel, at)

    def renewed(self, request: Data, before: Condition) -> Condition:
        """Return a pending request's condition for the current bench; `before` is the one for the former bench."""
        by = {"until": self.condition, "step": self.next_event}.get(request["do"], lambda _request: NEVER)
        condition = before if isinstance(before, InstantCondition) else by(request)
        if isinstance(before, InstantCondition):
            before.kernel = self.bench.kernel
        if isinstance(before, Pushing):
            return Pushing(condition, before.broken_off)
        condition.begin()
        return condition

    def do_breakpoints(self, request: Data) -> Data:
        """Replace the breakpoints, if the request has a list of new ones; reply with the current breakpoints."""
        breakpoints = self.server.breakpoints
        if "breakpoints" in request:
            breakpoints.replace(request["breakpoints"])
        return {"breakpoints": [*map(str, breakpoints.conditions)], "rows": breakpoints.rows}

    def do_back(self, request: Data) -> None:
        """Go back to a past instant of the branch that the request names, by default the current branch."""
        at = moment(request["time"])
        self.server.branches.back(at, request.get("branch"), self.client.answer_later(request))

    def do_branches(self, request: Data) -> None:
        """Reply with all branches: the first run, and every run that began with a return to the past."""
        self.server.branches.listed(self.client.answer_later(request))

    def do_branch(self, request: Data) -> None:
        """Return to a branch, in the state in which it was left."""
        self.server.branches.show(request["number"], self.client.answer_later(request))


class Pushing(Condition):
    """A condition whose wait can also be ended early, by a breakpoint, `pause` or `go`."""

    def __init__(self, condition: Condition, broken_off: Callable[[], bool]) -> None:
        condition.begin()
        self.condition, self.broken_off = condition, broken_off
        self.text, self.nets = condition.text, condition.nets
        self.reached = False

    def met(self) -> bool:
        """Return whether the condition has been met, or its wait has been ended early."""
        self.reached = self.reached or self.condition.met()
        return self.reached or self.broken_off()

    @property
    def foreseen(self) -> Callable[[], int | None] | None:
        """Function that predicts when (ps) the condition will be met; None if there is no such function.

        The function uses edges that are already scheduled, and returns None if it can predict nothing.
        """
        return self.condition.foreseen
