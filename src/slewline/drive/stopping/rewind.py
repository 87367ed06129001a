"""Stops of the motor by board inputs, reproduced on the chip, which stops by itself when its input changes.

    model     ......m.............. now          the present; the board is a horizon behind it
    board     ......| stops at k                 by its reflex, immediately, and reports the instant
    rewound         |....... now'                another bench, in which the pin changed at m; it stops at k by itself

Meanwhile the motor is at rest.  All output that the first run made after m is still in the cable.  *The count overrides
the time stamp*: if the chip samples the pin between the time stamp and the step, the model would make one step more or
fewer than the board made; the input is then moved past the next sample, until the counts agree.  If no instant leads to
the board's count, the run with the nearest count is used, and the position register is set to the position of the
motor.  If the chip does not stop, or going back would take longer than is allowed, or the time stamp is older than the
last rest, the chip is stopped at the present, and takes over the count of the board: the finding is `late-input`.

A host command that acts immediately (`at_once` of its row) bypasses the horizon on its way to the board; going back
shifts the instant of the command, as it does that of an input.  An input that holds the motor counts as an input that
stops it: in the other run the chip itself holds the motor, and continues when the input is released.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...bench.past import driven, given
from ...core.time.timebase import readable
from ...errors import SlewlineError, UsageError
from ..board.wire import HOST, BoardEvent, Happening
from .reflexes import NO_HOMING, BoardInput, Homing, configured
from .rerun import Cause, Rewound, following, named, travelled

if TYPE_CHECKING:
    from ...bench import Bench
    from ...bench.past import Past
    from ...core.motion.axis import Axis
    from ...core.time.hook import Hook
    from ..drive_state import DrivePath, DriveState, Movable, Stopping
    from .findings import DriveFindings

STOPS = (Happening.STOPPED, Happening.BRAKED)
TRIES = 6
REST_PS = 5 * 10**12  # time for a chip to come to rest
SLICE_PS = 10**10
FOLLOW_PS = 2 * 10**11  # at rest: following more often would keep an idle drive busy
MOST_NS = 10_000_000  # time per turn for following the past
LINE_MS = 40  # longest delay of a line and a board, from a command to its answer
MEASURED = 10  # number of entries over which the cost per entry is measured
LOOK_BACK_PS = 10**12  # range of the search for the step at which the board has stopped
ALLOWED_S = 0.25  # time that going back may take on a usual machine
WRITES = ("write", "send")  # journal entries with bytes of a host


class Rewind:
    """The piece that takes the model back, so that the chip stops by itself where the board stopped the motor.

    Args:
        otherwise: the piece that stops the chip at the present instant if the model cannot be taken back.
        motor: the motor, which can be stopped, moved to another bench, and resumed after a stop.
        past: the history of the bench; this object keeps it up to date.

    Raises:
        UsageError: the bench writes no journal; going back in time needs one.
    """

    def __init__(
        self,
        state: DriveState,
        path: DrivePath,
        findings: DriveFindings,
        otherwise: Stopping,
        motor: Movable,
        inputs: Sequence[BoardInput],
        past: Past,
        on_event: Hook[[BoardEvent]],
    ) -> None:
        _ = past.path  # check that there is a journal
        self.state, self.findings, self.otherwise, self.motor = state, findings, otherwise, motor
        self.wall, self.clock, self.link, self.ticks = path.wall, path.clock, path.link, path.ticks
        self.feeder, self.cable = path.feeder, path.cable
        self.past, self.allowed_s = past, ALLOWED_S
        self.inputs = {each.number: each for each in inputs}
        self.levels: dict[int, int] = {}  # levels of pins, as last set
        self.edges: list[tuple[BoardInput, int, int]] = []  # since the board has stopped: level, instant of the model
        self.stop: BoardEvent | None = None  # the event that stopped it
        self.final: BoardEvent | None = None  # the event at rest
        self.not_before = 0  # an instant (ps) at which the chip is at rest in the run to be taken over
        self.command: tuple[int, str] | None = None  # instant and name of the host's command that stopped it
        self.homing = NO_HOMING  # for which the board is configured
        self.rewinds, self.config = 0, state.config
        state.configure(configured(state.config, inputs))
        on_event.add(self.event)
        state.chip.on_command.add(self.commanded)

    # ------------------------------------------------------------------------------------------------------ each turn
    def before_turn(self) -> None:
        """Update the past if the axis is at rest, and prepare the board's inputs if a homing run begins or ends."""
        state = self.state
        if state.phase != "ok":
            return
        if not self.feeder.running:
            self.command = None  # the motor was at rest before the board received it
        if not self.levels and self.link.answer is not None:
            self._see(self.link.answer.inputs)
        if not self.cable.in_progress and not state.axis.moving and state.kernel.now > self.past.since_ps + FOLLOW_PS:
            before, played, began = state.kernel.now - 1, self.past.played, self.wall()
            self.past.follow(before, lambda: self.wall() > began + MOST_NS)
            if (more := self.past.played - played) > MEASURED and (spent := self.wall() - began) > 0:
                self.past.entry_s = spent / more / 10**9
        homing = Homing.of(state.axis)
        if homing != self.homing and self.link.idle and not self.feeder.running:
            self.homing = homing
            state.configure(configured(self.config, self.inputs.values(), homing))
            self.link.configure(state.config)

    def _see(self, inputs: int) -> None:
        """Set each wired chip pin to the level of its board input (bit n of `inputs`), if that has changed."""
        for number, each in self.inputs.items():
            level = each.level(inputs)
            if each.pin and self.levels.get(number) != level:
                self.state.chip.pin(each.pin).drive(level)
            self.levels[number] = level

    def commanded(self, text: str) -> None:
        """Handle a command from the host; if it acts immediately, also stop the motor now, not one horizon later."""
        state = self.state
        row = next(
            (row for row in state.chip.sheet.commands if row.at_once and row.name in (text, named(state.chip, text))),
            None,
        )
        if row is None or state.phase != "ok" or not self.feeder.running or self.command is not None:
            return
        self.command = state.kernel.now, text
        self.motor.stop(at_once=row.at_once == "stop")

    def event(self, event: BoardEvent) -> None:
        """Handle the input levels in an event of the board: apply each change, or record it for going back."""
        state = self.state
        instant = self._instant(event)
        for number, each in self.inputs.items():
            level = each.level(event.inputs)
            before, self.levels[number] = self.levels.get(number, 1 - each.acts), level
            if not each.pin or level == before:
                continue
            if event.kind in STOPS and event.which == number:
                self.edges = [(each, level, instant)]
            elif self.stop is not None:
                self.edges.append((each, level, instant))
            elif event.kind == Happening.MARK and event.which == number and self.cable.in_progress:
                self._mark(each, level, instant)
            elif not self._stops(event):
                state.chip.pin(each.pin).drive(level)

    def _stops(self, event: BoardEvent) -> bool:
        return event.kind in STOPS and event.which in self.inputs

    def _instant(self, event: BoardEvent) -> int:
        """Return the instant of the model that corresponds to an event of the board (ps)."""
        state = self.state
        late = state.horizon if self.cable.in_progress or self.stop is not None else 0
        return min(max(self.ticks.ps(self.clock.unwrap(event.tick) - late), 1), state.kernel.now)

    # ------------------------------------------------------------------------------------------------- what was stopped
    def expects(self, event: BoardEvent) -> bool:
        """Return whether an event is a stop that the chip also makes: by one of its pins, or by a host command."""
        if event.kind not in STOPS:
            return False
        each = self.inputs.get(event.which)
        return (each is not None and bool(each.pin)) or (event.which == HOST and self.command is not None)

    def stopped(self, event: BoardEvent) -> None:
        """Record that the board has stopped, or is ramping down."""
        if not self.expects(event):
            self._forget()
            self.otherwise.stopped(event)
            return
        self.stop = event
        self.state.leave_open(True)
        each = self.inputs.get(event.which)
        if each is not None and not self.edges:  # it was already active, but against the other direction
            self.edges = [(each, each.level(event.inputs), self._instant(event))]

    @property
    def going_back_to(self) -> int | None:
        """Tick after which no output may leave the cable, because going back may withdraw it; None if there is no stop.

        If a command has stopped the motor, its answer may leave, because it is the same in both runs.
        """
        state, stop = self.state, self.stop
        if stop is None:
            return None
        line = state.board.hz * LINE_MS // 1000
        if stop.which == HOST and self.command is not None:
            return (self.ticks.at(self.command[0]) >> 16) + state.horizon + line
        return self.clock.unwrap(stop.tick) - line

    def halted(self, event: BoardEvent) -> None:
        """Record that the board is at rest, so that its count is final."""
        if self.stop is None:
            self.otherwise.halted(event)
        else:
            self.final = event

    def turn(self) -> None:
        """Go back once the board's count is final; if going back fails, stop the chip now and report `late-input`."""
        if self.stop is None:
            self.otherwise.turn()
            return
        if self.final is None or self.state.kernel.now < self.not_before:
            return
        stop, final, edges = self.stop, self.final, self.edges
        try:
            why = self._go_back(stop, final.position)
        except (SlewlineError, OSError) as error:
            why = str(error)
        if why is None:
            return
        self._forget()
        if why:
            self.findings.report(
                "late-input",
                f"an input stopped the motor, but the chip samples it only now: {why}; the chip is stopped now, and "
                "takes over the count of the board",
            )
            for each, level, _ in edges:
                self.state.chip.pin(each.pin).drive(level)
            self.otherwise.stopped(stop)
            self.otherwise.halted(final)

    def _forget(self) -> None:
        """Discard the recorded stop, because the model is not to be taken back to it any more."""
        self.stop, self.final, self.edges, self.command = None, None, [], None
        self.state.leave_open(False)

    @property
    def settled(self) -> bool:
        """True while no stop remains to be reproduced, and the chip is at rest at the position of the motor."""
        return self.stop is None and self.otherwise.settled

    def clear(self) -> None:
        """Release a chip that was stopped without going back; discard input levels, which may be out of date."""
        self.levels.clear()
        self.otherwise.clear()

    # ------------------------------------------------------------------------------------------------------ going back
    def _cause(self, stop: BoardEvent, instant: int) -> Cause:
        """Return the cause of the stop, to be repeated in the other run: inputs of the chip, or a command.

        Raises:
            UsageError: the bytes of the command are not found.
        """
        if stop.which != HOST or self.command is None:
            hold_input = self._hold_input
            if hold_input is not None and (kept := self._kept(stop, hold_input)) is not None:
                offset, at = kept
                return Cause(
                    [driven(f"{self.state.chip.name}.{hold_input.pin}", hold_input.acts, at)], (offset,), instant - at
                )
            edges = [edge for number, edge in enumerate(self.edges) if not number or edge[0] is not hold_input]
            return Cause([driven(f"{self.state.chip.name}.{each.pin}", level, at) for each, level, at in edges])
        received_ps, text = self.command
        found = None
        for offset, entry in self.past.entries():
            if entry["do"] == "input" and entry["verb"] in WRITES and entry["t"] <= received_ps:
                found = offset, entry
        if found is None:
            raise UsageError(f"the journal has no record of the bytes of {text} since the motor was last at rest")
        offset, entry = found
        moved = given(entry["part"], entry["verb"], entry["args"], instant)
        return Cause([moved], (offset,), max(received_ps - int(entry["t"]), 0))

    @property
    def _hold_input(self) -> BoardInput | None:
        """The board input that has caused the stop, if it holds the motor only while it is active; otherwise None."""
        each = None if self.stop is None else self.inputs.get(self.stop.which)
        return each if each is not None and each.reflex == "hold" else None

    def _kept(self, stop: BoardEvent, hold_input: BoardInput) -> tuple[int, int] | None:
        """Return the offset and instant (ps) of the journal entry that last released the hold input.

        Return None if there is no such entry, or if a step was made since.  The other run omits the entry, and
        so holds the motor.
        """
        state, name, found = self.state, f"{self.state.chip.name}.{hold_input.pin}", None
        for offset, entry in self.past.entries():
            if entry["do"] == "drive" and entry["pin"] == name and entry["level"] != hold_input.acts:
                found = offset, int(entry["t"])
        if found is None:
            return None
        times, travel, sign = travelled(state.axis, found[1] + 1, state.kernel.now)
        before = travel[0] - sign if times else state.axis.travel
        return found if before == stop.position else None

    def _go_back(self, stop: BoardEvent, position: int) -> str | None:
        """Go back, to bring the chip to the position of the board.

        Return "" on success, the reason if it fails, or None if the chip in the other run is not at rest yet.
        """
        state = self.state
        now, instant = state.kernel.now, self._instant(stop)
        cause = self._cause(stop, instant)
        times, travel, sign = travelled(state.axis, max(instant - LOOK_BACK_PS, 0), now)
        if not times:
            return "the motor took no step"
        wanted = [at for at, there in zip(times, travel, strict=True) if there == stop.position]
        if wanted:  # the step after which the board received the stop
            at = min(wanted, key=lambda step: abs(step - instant))
            after = times[times.index(at) + 1] if at != times[-1] else now
            instant = min(max(instant, at), after - 1)
        tried: dict[int, Rewound] = {}  # by the instant of the chip's input
        candidate: int | None = instant
        while candidate is not None and len(tried) < TRIES and candidate not in tried:
            if candidate - cause.lead_ps <= self.past.since_ps:
                return f"{readable(candidate)} is before the motor was last at rest"
            found = tried[candidate] = self._run(cause, candidate, now, position, sign)
            if not found.missing:
                return self._take_at_rest(found, cause, now, position, sign)
            candidate = following(tried, times)
        best = min(tried.values(), key=lambda each: abs(each.missing))
        if best.is_at_rest:
            return self._take_at_rest(best, cause, now, position, sign)
        return f"by its equations of motion, the chip does not stop at the count of the board, {position}"

    def _run(self, cause: Cause, instant: int, now: int, position: int, sign: int) -> Rewound:
        """Run the model again with the cause at an instant (ps); return the run, and its distance from `position`."""
        first, inputs = instant - cause.lead_ps, cause.at(instant)
        bench = self.past.at(first).rerun(inputs, now, without=cause.without, allowed_s=self.allowed_s)
        axis: Axis = bench.chips[self.state.chip.name].axis(self.state.number).motor
        missing, rest = self._missing(axis, instant, now, position, sign)
        if axis.moving and rest >= now - SLICE_PS:  # it is still moving
            while axis.moving and bench.now_ps < now + REST_PS:
                bench.run_to(f"{bench.now_ps + SLICE_PS} ps")
            missing, rest = self._missing(axis, instant, bench.now_ps, position, sign)
        is_at_rest = not axis.moving or rest < axis.kernel.now - SLICE_PS
        return Rewound(bench, instant, first, missing, rest, is_at_rest)

    def _take_at_rest(self, found: Rewound, cause: Cause, now: int, position: int, sign: int) -> str | None:
        """Take over another run and return "" if its chip is at rest by `now`; else note when to retry, return None."""
        if found.rest_ps >= now:
            self.not_before = found.rest_ps + SLICE_PS
            return None
        latest = not found.missing and found.bench.now_ps == now  # its copy of the journal has not been overwritten
        return self._take(found if latest else self._run(cause, found.instant, now, position, sign), sign)

    @staticmethod
    def _missing(axis: Axis, instant: int, now: int, position: int, sign: int) -> tuple[int, int]:
        """Return by how many steps a motion in direction `sign` falls short of `position`, and when it ends (ps)."""
        times, travel, _ = travelled(axis, max(instant - LOOK_BACK_PS, 0), now)
        if not times:
            return (position - axis.travel) * sign, instant
        last, before = times[0], travel[0]
        for at, there in zip(times, travel, strict=True):
            if at > instant and (there - before) * sign < 0:
                break  # the way back
            last, before = at, there
        return (position - before) * sign, last

    def _take(self, found: Rewound, sign: int) -> str:
        """Continue with the bench of another run, from the position of the motor; return ""."""
        state, hold_input = self.state, self._hold_input
        self._move(found.bench, found.since_ps)
        if hold_input is not None and self.levels[hold_input.number] != hold_input.acts:
            state.chip.pin(hold_input.pin).drive(self.levels[hold_input.number])
        self.homing = Homing.of(state.axis)
        state.configure(configured(self.config, self.inputs.values(), self.homing))
        if found.missing:
            self.findings.taken_over(-found.missing * sign)
        times, travel, _ = travelled(state.axis, found.rest_ps, state.kernel.now)
        self.motor.resume(travel[0] if times else state.axis.travel, found.rest_ps)
        if (answer := self.link.answer) is not None:
            self._see(answer.inputs)  # changes made while the board was being reopened have no event
        return ""

    def _move(self, bench: Bench, since_ps: int) -> None:
        """Replace the present bench by another one, whose run was identical up to an instant (ps)."""
        self.state.chip.on_command.remove(self.commanded)
        self.past.go_on(bench, since_ps)
        self.motor.move(bench)
        self.state.chip.on_command.add(self.commanded)
        self.rewinds += 1

    # ------------------------------------------------------------------------------------------------------------ marks
    def _mark(self, each: BoardInput, level: int, instant: int) -> None:
        """Apply an input edge at a past instant (ps) by going back, or now if that fails or would change the steps."""
        state = self.state
        name = f"{state.chip.name}.{each.pin}"
        now, why = state.kernel.now, "it is before the motor was last at rest"
        if instant > self.past.since_ps:
            try:
                bench = self.past.at(instant).rerun([driven(name, level, instant)], now, allowed_s=self.allowed_s)
                axis = bench.chips[state.chip.name].axis(state.number).motor
                if travelled(axis, instant, now) == travelled(state.axis, instant, now):
                    self._move(bench, instant)
                    return
                why = "the motor would not have continued"
            except (SlewlineError, OSError) as error:
                why = str(error)
        self.findings.report(
            "late-input", f"{each.pin} changed at {readable(instant)}, but the chip samples it only now: {why}"
        )
        state.chip.pin(each.pin).drive(level)
