"""What a board tells of its motor, and what the drive makes of it: findings of the chip, states of the drive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ...core.time.timebase import readable
from ..board.wire import HOST, Answer, BoardEvent, BoardState, FrameKind, FrameResult, Happening

if TYPE_CHECKING:
    from ...core.motion.axis import Axis
    from ..driven import Driven, FoundBoard

TROUBLES: Mapping[int, tuple[str, str]] = {  # finding and text by what a board tells
    Happening.UNDERRUN: (
        "underrun",
        "the board ran dry: the host was later than the horizon of {horizon}; the motor goes down to a stop; choose a "
        "longer horizon, or give this machine less to do",
    ),
    Happening.WATCHDOG: (
        "host-silent",
        "the board has not heard its host for {watchdog}; the motor goes down to a stop",
    ),
    Happening.STOPPED: ("board-stopped", "{cause} stopped the motor at once"),
    Happening.BRAKED: ("board-stopped", "{cause} stops the motor by its way down"),
    Happening.ESTOP: ("e-stop", "emergency stop at {cause}; close its contact again, then clear the drive"),
    Happening.LATE: ("board-late", "a step came too soon for the board, which stopped before it; choose a lower rate"),
}
MOVING = (BoardState.RUN, BoardState.BRAKE)
AT_ONCE = (Happening.STOPPED, Happening.ESTOP, Happening.LATE)  # the motor has no way down
RESULTS = {
    FrameResult.WRONG_STATE: "not in this state",
    FrameResult.BAD_CONTENT: "its content makes no sense",
    FrameResult.LATE: "too late",
    FrameResult.NO_ROOM: "no room",
}


def signed(number: int) -> int:
    """Return a number modulo 2^32 as a signed one."""
    return (number + (1 << 31)) % (1 << 32) - (1 << 31)


class Troubles:
    """Hears the board for a drive.

    `told` is what has gone wrong, in words.
    """

    def __init__(self, drive: Driven) -> None:
        self.drive, self.told = drive, list[str]()
        drive.link.on_event.add(self.event)
        drive.link.on_boot.add(self.booted)
        drive.link.on_refused.add(self.refused)

    def report(self, code: str, text: str, position: int | None = None) -> None:
        """Report a trouble as a finding of the chip, and, with a position, set its register."""
        drive = self.drive
        self.told.append(f"{code}: {text}")
        drive.chip.motor_report(code, text, drive.axis_number, position)

    # ---------------------------------------------------------------------------------------------------------- events
    def event(self, event: BoardEvent) -> None:
        """Hear what has happened on the board."""
        drive = self.drive
        drive.on_event(event)
        event = event._replace(position=signed(event.position - drive.count_origin))  # as the model counts
        if drive.state == "ok":
            tick = drive.clock.unwrap(event.tick)
            if event.kind == Happening.REST:
                drive.feeder.rest(tick)
                self._check_count(event)
            elif event.kind in TROUBLES:
                self._stopped(event, tick)
        elif drive.state == "halted" and not self._final and event.kind in AT_ONCE:
            self._cut_short(event)
        if drive.state == "halted" and event.state == BoardState.HALT and not self._final:
            self._final = True
            drive.stopping.halted(event)

    _final = False  # the board stands, and its count has been heard

    def _stopped(self, event: BoardEvent, tick: int) -> None:
        """The board makes no more steps of the model."""
        drive = self.drive
        rate = self._rate(tick)
        drive.state, self._final = "halted", False
        expected = drive.stopping.expects(event)
        if not expected:
            self._report_stop(event)
        if event.kind in AT_ONCE and rate > (allowed := self._start_stop()):
            self.uncertain(
                f"the motor stood at once at {rate:.0f} steps/s, and may do so up to {allowed:.0f}: it may have lost "
                "steps; home it",
            )
        elif event.kind == Happening.ESTOP:
            drive.power.doubt()
        drive.feeder.halt()
        drive.stopping.stopped(event)

    def _cut_short(self, event: BoardEvent) -> None:
        """Something has stopped the motor at once on its way down."""
        self._report_stop(event)
        self.uncertain(
            "the motor stood at once on its way down, at a rate that is not known: it may have lost steps; home it"
        )

    def uncertain(self, text: str) -> None:
        """Report that nobody knows any more where the motor is."""
        self.drive.power.doubt()
        self.report("position-uncertain", text)

    def _report_stop(self, event: BoardEvent) -> None:
        """Report what has stopped the motor, and where."""
        drive, (code, text) = self.drive, TROUBLES[event.kind]
        words = {
            "horizon": readable(drive.horizon_ps),
            "watchdog": readable(drive.config.watchdog * 10**12 // drive.board.hz),
            "cause": "the host" if event.which == HOST else f"input {event.which}",
        }
        self.report(code, f"{text.format_map(words)} (at {self._position(event.position)})")

    def _check_count(self, event: BoardEvent) -> None:
        """The board stands: has it counted what it was sent?"""
        drive, net = self.drive, self.drive.feeder.net
        if not drive.feeder.running and event.position != (wanted := signed(drive.counted_from + net)):
            self.report(
                "count-differs",
                f"the board has counted {signed(event.position - drive.counted_from)} steps, and was sent {net}: home "
                "the motor, and report this",
            )
            drive.counted_from += event.position - wanted

    def _position(self, count: int) -> int:
        """Return the position register that belongs to a count of the board."""
        axis = self.drive.axis
        return self._register(axis, signed(axis.travel - count))

    @staticmethod
    def _register(axis: Axis, missing: int) -> int:
        """Return the position register without some steps; one that did not count them stays."""
        counted = missing if axis.past[-1].counts or not axis.past[-1].playing else 0
        return axis.low + (axis.position - counted - axis.low) % axis.modulus

    def _rate(self, tick: int) -> float:
        """Return the velocity of the motor at a tick of the board, in steps/s."""
        drive = self.drive
        at = drive.ticks.ps(tick - drive.horizon)
        return abs(drive.axis.velocity_at(min(max(at, 0), drive.kernel.now)))

    def _start_stop(self) -> float:
        """Return the rate up to which the motor may stand at once."""
        drive = self.drive
        if drive.start_stop is not None:
            return drive.start_stop
        first = drive.feeder.first_interval16
        return drive.board.hz * 65536 / first if first else drive.board.hz / drive.config.start_stop

    def goes_on(self, found: FoundBoard, keep_count: bool) -> None:
        """A board is opened: was it in use before, and where is its motor?"""
        if found.state == BoardState.BOOT or not (found.counted or found.moving or found.state == BoardState.HALT):
            return
        axis = self.drive.axis
        stood = "was in motion, and has been stopped" if found.moving else "stands"
        has = f"the board has kept its supply since it was used last: the motor {stood} at its count {found.counted}"
        if found.unsure:
            has += ", and may be elsewhere"
        if keep_count and axis.low <= found.counted < axis.low + axis.modulus:
            self.report("board-went-on", f"{has}; the position register is set to that", found.counted)
            return
        why = f"; the register has {axis.low} to {axis.low + axis.modulus - 1}" if keep_count else ""
        self.report(
            "board-went-on",
            f"{has}, which the model does not know{why}: home it; or begin again with --keep-count (keep_count=True), "
            "which sets the position register to that count",
        )

    def taken_over(self, missing: int, known: bool) -> None:
        """The chip is at rest, and has made steps that the motor has not: so many, net."""
        axis = self.drive.axis
        if not known:
            self.uncertain("the chip was stopped by reset or supply: its position is lost; home it")
        elif missing:
            register = self._register(axis, missing)
            self.report(
                "position-taken-over",
                f"the motor stands at {register}: {abs(missing)} steps of the model were not made; the position "
                f"register is set to {register}",
                register,
            )

    def port_lost(self, error: OSError) -> None:
        """The port is gone: so is the supply of a board that has it from there."""
        if self.drive.state not in ("closed", "unknown"):
            self.report(
                "port-lost",
                f"the port of the board is gone ({error.strerror or error}): nobody knows where the motor is; put the "
                "cable back, clear the drive, and home",
            )
            self._lose_count()

    def _lose_count(self) -> None:
        """The count of the board is lost: stop the chip."""
        drive = self.drive
        before, drive.state = drive.state, "unknown"
        drive.power.doubt()
        drive.feeder.halt()
        drive.cable.flush()  # its ticks are those of the board's life before
        if before == "ok" or not self._final:
            drive.stopping.stopped(self._unknown())

    def _unknown(self) -> BoardEvent:
        """The event of a board that has lost its count."""
        return BoardEvent(0, Happening.BOOT, HOST, BoardState.BOOT, 0, signed(self.drive.axis.travel), 0)

    def silent(self, while_: str) -> None:
        """The board does not answer: a motor that was moving has been stopped by it, or has no supply."""
        drive = self.drive
        self.report(
            "board-silent",
            f"the board has not answered for {while_}: look for its cable and its supply",
        )
        if drive.state == "ok" and drive.cable.under_way:
            drive.link.abandon()
            self._halt()

    _before_halt: Answer | None = None  # the last one before the drive halted of which the board had told nothing

    def heard(self) -> None:
        """The board has said something: behind a halt of which it had told nothing, its count, once it stands."""
        drive, answer = self.drive, self.drive.link.answer
        if self._before_halt is None or answer is None or answer is self._before_halt:
            return
        if drive.state != "halted" or self._final:
            self._before_halt = None
        elif answer.state == BoardState.RUN and drive.link.idle:
            drive.link.stop(1)  # a START that was lost, and came after the stop
        elif answer.state not in MOVING and drive.link.idle:
            self._before_halt, self._final = None, True
            count = signed(answer.position - drive.count_origin)
            drive.stopping.halted(self._unknown()._replace(state=answer.state, position=count))

    def booted(self) -> None:
        """The board was reset, or had no supply: its count is lost."""
        if self.drive.state not in ("closed", "unknown"):
            self.report(
                "board-reset",
                "the board was reset, or lost its supply: its count is lost, and nobody knows where the motor is; "
                "clear the drive, then home",
            )
            self._lose_count()
            self.drive.link.open(self.drive.config)  # it does not move, and tells the time again

    def refused(self, answer: Answer) -> None:
        """The board has not taken a frame."""
        drive = self.drive
        if drive.state != "ok":
            return
        kind = FrameKind(answer.kind).name
        if answer.kind == FrameKind.START and answer.result == FrameResult.LATE:
            drive.feeder.restart(drive.clock.unwrap(answer.tick) + drive.horizon // 2)
            self.report("late-start", "the host was too late to start a motion: the motor makes all of it, later")
            return
        if answer.kind == FrameKind.OUTPUTS and drive.enable and not drive.power.on:  # before a motion
            self.switched_off()
            return
        if answer.state not in (BoardState.BRAKE, BoardState.HALT, BoardState.BOOT):  # of those there is an event
            why = RESULTS.get(FrameResult(answer.result), str(answer.result))
            self.report("board-refused", f"the board has refused {kind}: {why}; stop the motor, and report this")

    def moved_by_itself(self) -> None:
        """Halt the drive: the chip moves, and nobody has told it to."""
        drive = self.drive
        drive.state, self._final = "halted", True
        self.report(
            "moved-by-itself",
            "the chip began to move before a host had said anything: a program that starts at power-up; the motor "
            "stands. Let it by --self-start (self_start=True)",
        )
        drive.feeder.halt()
        drive.stopping.stopped(self._unknown())

    def too_fast(self, error: Exception) -> None:
        """The model makes steps faster than the board can."""
        self._halt()
        self.report("too-fast", f"{error}; steps were not made")

    def not_started(self) -> None:
        """The board has not taken the start of a motion a horizon after it was due."""
        self.drive.link.abandon()
        self._halt()
        self.report(
            "not-started",
            "the board has not taken the start of a motion: the line damages too much, or is too slow; the motor does "
            "not move. Check the cable, or choose a longer horizon (--check recommends one)",
        )

    def stopped_at_rest(self) -> None:
        """Halt the drive: the host stops a motor that is at rest, and steps are to come."""
        self.drive.link.abandon()
        self._halt()
        self.report(
            "board-stopped", "the host stops the motor, which is at rest; further steps of its chip are not made"
        )

    def switched_off(self) -> None:
        """The board has switched the driver off by itself, at rest."""
        self._halt()
        self.report(
            "driver-off",
            "the board has switched the driver off, as no message came from its host, and does not switch it on by "
            "itself: the motor may have moved; clear the drive, and home",
        )

    def clock_jumped(self) -> None:
        """This computer slept, so its clock did not run, and the board's did."""
        drive = self.drive
        if drive.state == "ok" and drive.cable.under_way:
            self._halt()
            self.report(
                "computer-slept",
                "this computer slept during a motion, which the board has ended; keep it awake",
            )
        drive.cable.flush()  # its ticks are those of before

    def _halt(self) -> None:
        """Halt the drive for a reason that the board does not know."""
        drive = self.drive
        drive.link.stop(1)
        drive.state, self._final = "halted", False
        self._before_halt = drive.link.answer  # of a board that stands already no event comes
        drive.feeder.halt()
        drive.stopping.stopped(self._unknown())

    @property
    def final(self) -> bool:
        """Whether the count of a halted board at rest is known."""
        return self._final
