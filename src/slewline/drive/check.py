"""Looking at a board before it drives anything: link, crystal, this machine, and the board's own pulses."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from .board.records import PAUSE, Record
from .board.wire import BoardEvent, Happening
from .promptness import WakingDelays, measured, recommended_ms

if TYPE_CHECKING:
    from .board.boards import BoardModel
    from .drive import Drive

PULSES, PULSE_RATE = 1000, 10_000  # of the self-test; steps/s
SELF_TEST_S = 1.0
SHORT_PAUSE, POLL_S = 1000, 0.001  # ticks; s
LOADS, LOAD_RECORDS, LOAD_S = 10, 20, 5.0  # rehearsed starts of a motion: records of five frames, and one frame more


class Checkup(NamedTuple):
    """What was found: round trips and lateness in ms, ppm of the crystal, pulses that came back; None: no answer.

    `load_ms`: what the link took at worst for all that goes before the first step of a motion; `horizon_ms`: what that
    needs; None: no horizon is long enough.
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

    @property
    def good(self) -> bool:
        """Is all as it must be?"""
        return self.counted == PULSES and not self.damaged and self.horizon_ms is not None

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
        return [
            f"board     {board.title}; its crystal differs from this machine's clock by {self.offset_ppm:+.0f} ppm",
            f"link      {median:.1f} ms there and back, {worst:.1f} ms at worst, {self.load_ms:.0f} ms for the start of "
            f"a motion; {self.damaged} frames damaged",
            f"machine   wakes {late.median:.2f} ms late, {late.p99:.2f} ms in the worst of 100, {late.worst:.1f} ms at "
            f"worst; {self.priority}",
            "horizon   none is long enough: this link is too slow; use another adapter"
            if self.horizon_ms is None
            else f'horizon   --horizon "{self.horizon_ms} ms" is enough for this machine and link, as far as was seen',
            f"pulses    {pulses}",
        ]


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
    counted: list[int] = []

    def hear(event: BoardEvent) -> None:
        if event.kind == Happening.CHECKED:
            counted.append(event.position)

    drive.on_event.add(hear)
    drive.link.check(PULSES, drive.board.hz // PULSE_RATE)
    end = drive.wall() + round(SELF_TEST_S * 1e9)
    while not counted and drive.wall() < end:
        drive.turn()
        drive.talk.wait(POLL_S)
    drive.on_event.remove(hear)
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
        counted[0] if counted else None,
    )


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
