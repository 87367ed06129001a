"""Looking at a board before it drives anything: link, crystal, this machine, and the board's own pulses."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from .board.records import DOWN, PAUSE, REST, Record
from .board.wire import BoardEvent, Happening
from .promptness import WakingDelays, measured, recommended_ms

if TYPE_CHECKING:
    from .board.boards import BoardModel
    from .drive import Drive

PULSES, PULSE_RATE = 1000, 10_000  # of the self-test; steps/s
SELF_TEST_S = 1.0
JOG, JOG_RATE, JOG_S = 10, 50, 5.0  # steps; steps/s; s
ESTOP_S = 20.0
SHORT_PAUSE, POLL_S = 1000, 0.001  # ticks; s
LOADS, LOAD_RECORDS, LOAD_S = 10, 20, 5.0  # rehearsed starts of a motion: records of five frames, and one frame more


class Checkup(NamedTuple):
    """What was found: round trips and lateness in ms, ppm of the crystal, pulses that came back; None: no answer.

    `load_ms`: what the link took at worst for all that goes before the first step of a motion; `horizon_ms`: what that
    needs; None: no horizon is long enough.  `counted`: pulses; None: no answer, or the driver is on.  `jogged`: whether
    ten steps to and fro were made; `estop`: whether its contact was seen to open; None: that was not tried.
    """

    board: BoardModel
    priority: str
    late: WakingDelays
    round_trip_ms: tuple[float, float]  # median, worst
    offset_ppm: float
    damaged: int
    load_ms: float
    horizon_ms: int | None
    counted: int | None
    jogged: bool | None
    estop: bool | None

    @property
    def good(self) -> bool:
        """Is all as it must be?"""
        moves = self.counted == PULSES if self.jogged is None else self.jogged
        return moves and self.estop is not False and not self.damaged and self.horizon_ms is not None

    @property
    def lines(self) -> list[str]:
        """What a user reads, a line for each thing."""
        late, (median, worst) = self.late, self.round_trip_ms
        board, step, loop = self.board, self.board.step.printed, self.board.loop.printed
        if self.counted == PULSES:
            pulses = f"{PULSES} pulses sent, {PULSES} counted"
        elif not self.counted:
            pulses = (
                f"{PULSES} pulses sent, none counted: connect {step} to {loop}, and nothing else to either, then "
                "try again"
            )
        else:
            pulses = (
                f"{PULSES} pulses sent, {self.counted} counted: a loose wire from {step} to {loop}, or a board that is "
                "faulty"
            )
        rows = [
            f"board     {board.title}; its crystal differs from this machine's clock by {self.offset_ppm:+.0f} ppm",
            f"link      {median:.1f} ms there and back, {worst:.1f} ms at worst, {self.load_ms:.0f} ms for the start "
            f"of a motion; {self.damaged} frames damaged",
            f"machine   wakes {late.median:.2f} ms late, {late.p99:.2f} ms in the worst of 100, {late.worst:.1f} ms at "
            f"worst; {self.priority}",
            "horizon   none is long enough: this link is too slow; use another adapter"
            if self.horizon_ms is None
            else f'horizon   --horizon "{self.horizon_ms} ms" is enough for this machine and link, as far as was seen',
        ]
        if self.jogged is None:
            rows.append(f"pulses    {pulses}")
        elif self.jogged:
            rows.append(
                f"jog       {JOG} steps up and {JOG} back; if the motor did not turn clockwise first: --invert-dir"
            )
        else:
            rows.append(f"jog       {JOG} steps were not made")
        if self.estop is not None:
            rows.append(
                "e-stop    its contact opened, and the board switched the driver off"
                if self.estop
                else f"e-stop    not seen within {ESTOP_S:g} s: look at its wire and contact"
            )
        return rows


def checked(drive: Drive, seconds: float, priority: str, tell: Callable[[str], object]) -> Checkup:
    """Look at an open drive for so many seconds of the wall clock.

    Args:
        priority: what this process was given.
        tell: called with what goes on.
    """
    tell(f"slewline: looking for {seconds:g} s")
    drive.clock.worst_round_trip_ns = 0  # a board that is being opened answers late
    late = measured(seconds, drive.wall, drive.talk.nap, drive.turn)
    _, worst_ns, median_ns = drive.clock.round_trip_ns
    load_ms = under_load(drive)
    counted = jogged = estop = None
    if drive.enable:
        tell(f"slewline: {JOG} steps up, then {JOG} back: watch the motor")
        jogged = jog(drive)
    else:
        drive.link.check(PULSES, drive.board.hz // PULSE_RATE)
        found = awaited(drive, Happening.CHECKED, SELF_TEST_S)
        counted = None if found is None else found.position
    if any(not each.pin for each in drive.board_inputs):
        tell(f"slewline: open the contact of the emergency stop, within {ESTOP_S:g} s")
        estop = awaited(drive, Happening.ESTOP, ESTOP_S) is not None and not drive.power.on
    trip = median_ns / 1e6, worst_ns / 1e6
    return Checkup(
        drive.board,
        priority,
        late,
        trip,
        drive.clock.offset_ppm,
        drive.link.damaged,
        load_ms,
        recommended_ms(late.worst, load_ms),
        counted,
        jogged,
        estop,
    )


def awaited(drive: Drive, kind: Happening, seconds: float) -> BoardEvent | None:
    """Return the next event of a kind, once the board has answered after it; None: there was none in time."""
    found: list[BoardEvent] = []

    def note(event: BoardEvent) -> None:
        if event.kind == kind:
            found.append(event)

    drive.on_event.add(note)
    end = drive.wall() + round(seconds * 1e9)
    while not (found and drive.link.idle) and drive.wall() < end:
        drive.turn()
        drive.talk.wait(POLL_S)
    drive.on_event.remove(note)
    return found[0] if found else None


def jog(drive: Drive) -> bool:
    """Make ten steps up, and ten back; return whether the board has come to rest after them."""
    interval, pause = drive.board.hz // JOG_RATE, drive.board.hz // 2
    drive.link.push(
        [Record(0, JOG, interval), Record(PAUSE, 0, pause), Record(DOWN, JOG, interval), Record(PAUSE | REST, 0, pause)]
    )
    drive.link.start(drive.clock.ticks(drive.wall()) + drive.horizon)
    return awaited(drive, Happening.REST, JOG_S) is not None


def under_load(drive: Drive) -> float:
    """Return how long the link takes at worst for all that goes before the first step of a motion, ms.

    The records are pauses, which are forgotten again: nothing is started.
    """
    worst = 0
    for _ in range(LOADS):
        began = drive.wall()
        drive.link.push([Record(PAUSE, 0, SHORT_PAUSE, 0, 0)] * LOAD_RECORDS)
        drive.link.outputs(0, 0)
        while not drive.link.idle and drive.wall() - began < LOAD_S * 1e9:
            drive.turn()
            drive.talk.wait(POLL_S)
        worst = max(worst, drive.wall() - began)
        drive.link.reset()
        while not drive.link.idle and drive.wall() - began < 2 * LOAD_S * 1e9:
            drive.turn()
            drive.talk.wait(POLL_S)
    return worst / 1e6
