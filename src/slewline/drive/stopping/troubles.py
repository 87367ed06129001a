"""A board's reports about its motor, and their consequences: findings, and changes in the drive's state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ...core.time.timebase import readable
from ..board.wire import HOST, Answer, BoardEvent, BoardState, FrameKind, FrameResult, Happening, PowerFlag
from .findings import DriveFindings, signed

if TYPE_CHECKING:
    from ...core.time.hook import Hook
    from ..drive_state import DrivePath, DriveState, FoundBoard, Stopping

TROUBLES: Mapping[int, tuple[str, str]] = {  # finding and text by the event of a board
    Happening.UNDERRUN: (
        "underrun",
        "buffer underrun: the host was later than the horizon of {horizon}; the motor decelerates to a stop; choose a "
        "longer horizon, or reduce the load of this machine",
    ),
    Happening.WATCHDOG: (
        "host-silent",
        "no message from the host for {watchdog} (watchdog); the motor decelerates to a stop",
    ),
    Happening.STOPPED: ("board-stopped", "{cause} stopped the motor immediately"),
    Happening.BRAKED: ("board-stopped", "{cause} stops the motor along its stop ramp"),
    Happening.ESTOP: ("e-stop", "emergency stop at {cause}; close its contact again, then clear the drive"),
    Happening.LATE: ("board-late", "a step was due too soon for the board, which has stopped; choose a lower rate"),
}
MOVING = (BoardState.RUN, BoardState.BRAKE)
AT_ONCE = (Happening.STOPPED, Happening.ESTOP, Happening.LATE)  # the motor has no stop ramp
RESULTS = {
    FrameResult.WRONG_STATE: "not in this state",
    FrameResult.BAD_CONTENT: "its content is invalid",
    FrameResult.LATE: "too late",
    FrameResult.NO_ROOM: "no room",
}


class Troubles:
    """The object that handles the reports of the board, and halts the drive if necessary.

    Args:
        stopping: the object that stops the chip; another one may replace it later.
        on_event: called with each event, before the event has any effect.
    """

    def __init__(
        self,
        state: DriveState,
        path: DrivePath,
        findings: DriveFindings,
        stopping: Stopping,
        on_event: Hook[[BoardEvent]],
    ) -> None:
        self.state, self.stopping, self.on_event = state, stopping, on_event
        self.clock, self.link, self.ticks = path.clock, path.link, path.ticks
        self.feeder, self.cable = path.feeder, path.cable
        self.findings, self.report = findings, findings.report
        self._before_halt: Answer | None = None  # the last answer before an unreported halt
        self.link.on_event.add(self.event)
        self.link.on_boot.add(self.booted)
        self.link.on_refused.add(self.refused)

    # ---------------------------------------------------------------------------------------------------------- events
    def event(self, event: BoardEvent) -> None:
        """Handle an event that the board has reported."""
        state = self.state
        self.on_event(event)
        event = event._replace(position=signed(event.position - state.count_origin))  # as the model counts
        if state.phase == "ok":
            tick = self.clock.unwrap(event.tick)
            if event.kind == Happening.REST:
                self.feeder.rest(tick)
                self._check_count(event)
            elif event.kind in TROUBLES:
                self._stopped(event, tick)
        elif state.phase == "halted" and not state.final and event.kind in AT_ONCE:
            self._cut_short(event)
        if state.phase == "halted" and event.state == BoardState.HALT and not state.final:
            state.finish()
            self.stopping.halted(event)

    def _stopped(self, event: BoardEvent, tick: int) -> None:
        """Halt the drive, because the board has stopped making the model's steps."""
        state = self.state
        rate = self._rate(tick)
        state.halt()
        expected = self.stopping.expects(event)
        if not expected:
            self._report_stop(event)
        if event.kind in AT_ONCE and rate > (allowed := self._start_stop()):
            self.findings.uncertain(
                f"the motor was stopped dead from {rate:.0f} steps/s; allowed up to {allowed:.0f}: it may have lost "
                "steps; home it",
            )
        elif event.kind == Happening.ESTOP:
            state.trust(False)
        self.feeder.halt()
        self.stopping.stopped(event)

    def _cut_short(self, event: BoardEvent) -> None:
        """Handle an immediate stop of the motor during its stop ramp."""
        self._report_stop(event)
        self.findings.uncertain(
            "the motor was stopped dead during its stop ramp, at an unknown rate: it may have lost steps; home it"
        )

    def _report_stop(self, event: BoardEvent) -> None:
        """Report the cause and the position of a stop."""
        state, (code, text) = self.state, TROUBLES[event.kind]
        words = {
            "horizon": readable(state.horizon_ps),
            "watchdog": readable(state.config.watchdog * 10**12 // state.board.hz),
            "cause": "the host" if event.which == HOST else f"input {event.which}",
        }
        self.report(code, f"{text.format_map(words)} (at {self._position(event.position)})")

    def _check_count(self, event: BoardEvent) -> None:
        """Check, at rest, that the board has counted all steps sent to it; otherwise report and adopt its count."""
        state, net = self.state, self.feeder.net
        if not self.feeder.running and event.position != (wanted := signed(state.counted_from + net)):
            self.report(
                "count-differs",
                f"the board has counted {signed(event.position - state.counted_from)} steps, but was sent {net}: home "
                "the motor, and report this",
            )
            state.correct(event.position - wanted)

    def _position(self, count: int) -> int:
        """Return the value of the position register that corresponds to a count of the board."""
        return self.findings.register(signed(self.state.axis.travel - count))

    def _rate(self, tick: int) -> float:
        """Return the motor's velocity at a tick of the board, in steps/s."""
        state = self.state
        at = self.ticks.ps(tick - state.horizon)
        return abs(state.axis.velocity_at(min(max(at, 0), state.kernel.now)))

    def _start_stop(self) -> float:
        """Return the highest rate at which the motor may stop without a ramp."""
        state = self.state
        if state.start_stop is not None:
            return state.start_stop
        first = self.feeder.first_interval16
        return state.board.hz * 65536 / first if first else state.board.hz / state.config.start_stop

    def goes_on(self, found: FoundBoard) -> None:
        """Handle a board that has kept running since an earlier use: report its count and the state of its motor."""
        if found.state == BoardState.BOOT or not (found.counted or found.moving or found.state == BoardState.HALT):
            return
        axis = self.state.axis
        state_text = "was in motion, and has been stopped" if found.moving else "is at rest"
        has = f"the board has kept its supply since its last use: the motor {state_text} at count {found.counted}"
        if found.unsure:
            has += ", but its position is uncertain"
        keep_count = self.state.keep_count
        if keep_count and axis.low <= found.counted < axis.low + axis.modulus:
            self.report("board-went-on", f"{has}; the position register is set to this count", found.counted)
            return
        why = f"; the register holds only {axis.low} to {axis.low + axis.modulus - 1}" if keep_count else ""
        self.report(
            "board-went-on",
            f"{has}; the model does not know this count{why}: home the motor, or start again with --keep-count "
            "(keep_count=True), which sets the position register to the count",
        )

    def port_lost(self, error: OSError) -> None:
        """Handle the loss of the port, which may also power the board."""
        if self.state.phase not in ("closed", "unknown"):
            self.report(
                "port-lost",
                f"the port of the board is gone ({error.strerror or error}): the position of the motor is unknown; "
                "reconnect the cable, clear the drive, and home",
            )
            self._lose_count()

    def _lose_count(self) -> None:
        """Stop the chip, because the count of the board is lost."""
        before = self.state.phase
        self.state.lose()
        self.feeder.halt()
        self.cable.flush()  # its ticks are those before the restart of the board
        if before == "ok" or not self.state.final:
            self.stopping.stopped(self._unknown())

    def _unknown(self) -> BoardEvent:
        """Return an event in place of a stop that the board has not reported.

        Its position is the present travel of the model.
        """
        return BoardEvent(0, Happening.BOOT, HOST, BoardState.BOOT, 0, signed(self.state.axis.travel), 0)

    def silent(self, while_: str) -> None:
        """Handle a board that has not answered for some time; stop any motion in progress.

        `while_` is that time as text, such as "500 ms".
        """
        self.report(
            "board-silent",
            f"the board has not answered for {while_}: check its cable and its supply",
        )
        if self.state.phase == "ok" and self.cable.in_progress:
            self.link.abandon()
            self._halt()

    def note_message(self) -> None:
        """Handle a message from the board: after a halt without an event, take over the count of the board.

        The count is taken over as soon as the board is at rest.
        """
        state, answer = self.state, self.link.answer
        if self._before_halt is None or answer is None or answer is self._before_halt:
            return
        if state.phase != "halted" or state.final:
            self._before_halt = None
        elif answer.state == BoardState.RUN and self.link.idle:
            self.link.stop(1)  # a START that was lost, and arrived after the stop
        elif answer.state not in MOVING and self.link.idle:
            self._before_halt = None
            state.finish()
            count = signed(answer.position - state.count_origin)
            self.stopping.halted(self._unknown()._replace(state=answer.state, position=count))

    def booted(self) -> None:
        """Handle a reset or a power failure of the board: its count is lost."""
        if self.state.phase not in ("closed", "unknown"):
            self.report(
                "board-reset",
                "the board was reset, or lost its supply: its count and the position of the motor are lost; "
                "clear the drive, then home",
            )
            self._lose_count()
            self.link.open(self.state.config)  # it is at rest, and reports its time again

    def refused(self, answer: Answer) -> None:
        """Handle a frame that the board has refused."""
        state = self.state
        if state.phase != "ok":
            return
        kind = FrameKind(answer.kind).name
        if answer.kind == FrameKind.START and answer.result == FrameResult.LATE:
            self.feeder.restart(self.clock.unwrap(answer.tick) + state.horizon // 2)
            self.report("late-start", "the host started a motion too late: the motor makes the whole motion, but later")
            return
        energised = answer.flags & PowerFlag.ENERGISED
        if answer.kind == FrameKind.OUTPUTS and state.enable and not energised:  # before a motion
            self.switched_off()
            return
        if answer.state not in (BoardState.BRAKE, BoardState.HALT, BoardState.BOOT):  # these have an event
            why = RESULTS.get(FrameResult(answer.result), str(answer.result))
            self.report("board-refused", f"the board has refused {kind}: {why}; stop the motor, and report this")

    def moved_by_itself(self) -> None:
        """Halt the drive, because the chip moves without a command."""
        self.state.halt(final=True)
        self.report(
            "moved-by-itself",
            "the chip began to move before any command from a host, because of a program that starts at power-up; the "
            "motor is held at rest. To allow this, give --self-start (self_start=True)",
        )
        self.feeder.halt()
        self.stopping.stopped(self._unknown())

    def too_fast(self, error: Exception) -> None:
        """Handle steps of the model that are too fast for the board."""
        self._halt()
        self.report("too-fast", f"{error}; steps were not output")

    def not_started(self) -> None:
        """Handle a motion that the board has still not accepted one horizon after the motion's scheduled start."""
        self.link.abandon()
        self._halt()
        self.report(
            "not-started",
            "the board has not accepted the start of a motion: the line is too noisy or too slow; the motor does "
            "not move. Check the cable, or choose a longer horizon (--check recommends one)",
        )

    def stopped_at_rest(self) -> None:
        """Halt the drive, because the host has ordered a stop while the motor is at rest and steps are pending."""
        self.link.abandon()
        self._halt()
        self.report(
            "board-stopped",
            "the host ordered a stop while the motor was at rest; further steps of its chip are not output",
        )

    def switched_off(self) -> None:
        """Handle a driver that the board has switched off by itself while the motor was at rest."""
        self._halt()
        self.report(
            "driver-off",
            "the board has switched the driver off by itself, without a message from its host, and does not "
            "switch it on again: the motor may have moved; clear the drive, and home",
        )

    def clock_jumped(self) -> None:
        """Handle a jump of this computer's clock, which, unlike the board's, stopped while the computer slept."""
        if self.state.phase == "ok" and self.cable.in_progress:
            self._halt()
            self.report(
                "computer-slept",
                "this computer slept during a motion, so the board has stopped the motor; keep the computer awake",
            )
        self.cable.flush()  # its ticks are the old ones

    def _halt(self) -> None:
        """Halt the drive for a reason that the board does not know."""
        self.link.stop(1)
        self.state.halt()
        self._before_halt = self.link.answer  # a board that is at rest already sends no event
        self.feeder.halt()
        self.stopping.stopped(self._unknown())
