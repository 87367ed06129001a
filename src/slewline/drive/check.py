"""The check of a board before it drives a motor: link, crystal, this machine, and the board's own pulses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import perf_counter_ns, sleep
from typing import TYPE_CHECKING, NamedTuple

from .board.records import DOWN, PAUSE, REST, Record
from .board.wire import BoardEvent, Happening

if TYPE_CHECKING:
    from ..core.time.hook import Hook
    from .board.boards import BoardModel
    from .drive_state import DrivePath, DriveState
    from .talk import Talk

PULSES, PULSE_RATE = 1000, 10_000  # of the self-test; steps/s
SELF_TEST_S = 1.0
JOG, JOG_RATE, JOG_S = 10, 50, 5.0  # steps; steps/s; s
ESTOP_S = 20.0
SHORT_PAUSE, POLL_S = 1000, 0.001  # ticks; s
LOADS, LOAD_RECORDS, LOAD_S = 10, 20, 5.0  # simulated starts of a motion: records of five frames, and one more frame

NAP_S = 0.002
HORIZONS_MS = (20, 50, 100, 250, 500, 1000, 2000)
LONGEST_LOAD_MS = 200  # for twenty records: a ramp at high rates needs a hundred per second
LATE_SAFETY, LOAD_SAFETY = 3, 2  # factors on the worst of a few seconds: a day has worse delays, a ramp more records


class WakingDelays(NamedTuple):
    """The wake-up delays of this process, in ms: the median, the 99th percentile, and the worst."""

    median: float
    p99: float
    worst: float


def of_many(late_ms: Sequence[float]) -> WakingDelays:
    """Return the median, the 99th percentile and the worst of one or more delays, ms."""
    ordered = sorted(late_ms)
    last = len(ordered) - 1
    return WakingDelays(ordered[last // 2], ordered[last * 99 // 100], ordered[last])


def measured(
    seconds: float,
    clock: Callable[[], int] = perf_counter_ns,
    nap: Callable[[float], object] = sleep,
    each: Callable[[], object] = lambda: None,
) -> WakingDelays:
    """Repeatedly sleep for two milliseconds; return statistics of the delays with which this process woke up.

    Args:
        seconds: the duration by the wall clock.
        clock, nap: the clock used for the measurement, ns, and the sleep function, s.
        each: called after each sleep, for other work.
    """
    late: list[float] = []
    end = clock() + round(seconds * 1e9)
    while not late or clock() < end:
        due = clock() + round(NAP_S * 1e9)
        nap(NAP_S)
        late.append(max(clock() - due, 0) / 1e6)
        each()
    return of_many(late)


def recommended_ms(late_ms: float, load_ms: float) -> int | None:
    """Return the horizon that a machine and a link need, ms; None if the link is too slow for any horizon.

    Args:
        late_ms: the worst wake-up delay of this process.
        load_ms: the longest time taken to transfer all the frames that precede the first step of a motion.
    """
    if load_ms > LONGEST_LOAD_MS:
        return None
    needs = LATE_SAFETY * late_ms + LOAD_SAFETY * load_ms
    return next((horizon for horizon in HORIZONS_MS if horizon >= needs), None)


class Checkup(NamedTuple):
    """The results of a check of a board.

    Round trips and delays are in ms, the error of the crystal is in ppm.

    Attributes:
        load_ms: the longest time taken to transfer all the frames that precede the first step of a motion.
        horizon_ms: the horizon needed; None if none is long enough.
        counted: the number of pulses that the board counted in its self-test; None if the board did not
            report it, or if there was no self-test because the driver is on.
        jogged: whether ten steps in each direction were made; None if this was not tried.
        estop: whether the emergency-stop contact opened; None if this was not tried.
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
        """True if all results are within limits."""
        moves = self.counted == PULSES if self.jogged is None else self.jogged
        return moves and self.estop is not False and not self.damaged and self.horizon_ms is not None

    @property
    def lines(self) -> list[str]:
        """The report for the user, one line per result."""
        late, (median, worst) = self.late, self.round_trip_ms
        board, step, loop = self.board, self.board.step.printed, self.board.loop.printed
        if self.counted == PULSES:
            pulses = f"{PULSES} pulses sent, {PULSES} counted"
        elif not self.counted:
            pulses = (
                f"{PULSES} pulses sent, none counted: connect {step} to {loop}, and no other wire to either, then "
                "try again"
            )
        else:
            pulses = (
                f"{PULSES} pulses sent, {self.counted} counted: the wire from {step} to {loop} is loose, or the "
                "board is faulty"
            )
        rows = [
            f"board     {board.title}; its crystal differs from this machine's clock by {self.offset_ppm:+.0f} ppm",
            f"link      {median:.1f} ms round trip, {worst:.1f} ms at worst, {self.load_ms:.0f} ms for the start "
            f"of a motion; {self.damaged} frames damaged",
            f"machine   wakes {late.median:.2f} ms late (median), {late.p99:.2f} ms (99th percentile), "
            f"{late.worst:.1f} ms at worst; {self.priority}",
            "horizon   none is long enough: this link is too slow; use another adapter"
            if self.horizon_ms is None
            else f'horizon   --horizon "{self.horizon_ms} ms" is enough for this machine and link, by this measurement',
        ]
        if self.jogged is None:
            rows.append(f"pulses    {pulses}")
        elif self.jogged:
            rows.append(
                f"jog       {JOG} steps up and {JOG} back; if the motor did not turn clockwise first: --invert-dir"
            )
        else:
            rows.append(f"jog       {JOG} steps were not output")
        if self.estop is not None:
            rows.append(
                "e-stop    its contact opened, and the board switched the driver off"
                if self.estop
                else f"e-stop    not detected within {ESTOP_S:g} s: check its wire and contact"
            )
        return rows


class Check:
    """The check of a board whose link is open.

    Args:
        turn: a function that runs one turn of the drive.
        estop: True if an input of the board is an emergency stop.
    """

    def __init__(
        self,
        state: DriveState,
        path: DrivePath,
        talk: Talk,
        on_event: Hook[[BoardEvent]],
        turn: Callable[[], object],
        estop: bool,
    ) -> None:
        self.state, self.talk, self.on_event, self.turn, self.estop = state, talk, on_event, turn, estop
        self.wall, self.clock, self.link = path.wall, path.clock, path.link

    def look(self, seconds: float, priority: str, report: Callable[[str], object]) -> Checkup:
        """Check the board, and return the results; delays are measured for a number of wall-clock seconds.

        Args:
            priority: the priority of this process, for the report.
            report: called with progress messages, and with instructions for the user.
        """
        report(f"slewline: measuring for {seconds:g} s")
        self.clock.worst_round_trip_ns = 0  # a board answers late while it is being opened
        late = measured(seconds, self.wall, self.talk.nap, self.turn)
        _, worst_ns, median_ns = self.clock.round_trip_ns
        load_ms = self.under_load()
        counted = jogged = estop = None
        if self.state.enable:
            report(f"slewline: {JOG} steps up, then {JOG} back: watch the motor")
            jogged = self.jog()
        else:
            self.link.check(PULSES, self.state.board.hz // PULSE_RATE)
            found = self._awaited(Happening.CHECKED, SELF_TEST_S)
            counted = None if found is None else found.position
        if self.estop:
            report(f"slewline: open the contact of the emergency stop, within {ESTOP_S:g} s")
            estop = self._awaited(Happening.ESTOP, ESTOP_S) is not None and not self.talk.power.on
        return Checkup(
            self.state.board,
            priority,
            late,
            (median_ns / 1e6, worst_ns / 1e6),
            self.clock.offset_ppm,
            self.link.damaged,
            load_ms,
            recommended_ms(late.worst, load_ms),
            counted,
            jogged,
            estop,
        )

    def _awaited(self, kind: Happening, seconds: float) -> BoardEvent | None:
        """Wait until an event of a kind has come and the board has taken all commands.

        Return the event; None if no such event came within the time limit.
        """
        found: list[BoardEvent] = []

        def note(event: BoardEvent) -> None:
            if event.kind == kind:
                found.append(event)

        self.on_event.add(note)
        self._pass_while(lambda: not (found and self.link.idle), self.wall() + round(seconds * 1e9))
        self.on_event.remove(note)
        return found[0] if found else None

    def _pass_while(self, goes_on: Callable[[], bool], end: float) -> None:
        """Let time run while `goes_on` returns True, up to a wall-clock limit (ns)."""
        while goes_on() and self.wall() < end:
            self.turn()
            self.talk.wait(POLL_S)

    def jog(self) -> bool:
        """Make ten steps up and ten steps back; return whether the board then came to rest within 5 s."""
        hz = self.state.board.hz
        interval, pause = hz // JOG_RATE, hz // 2
        moves = Record(0, JOG, interval), Record(DOWN, JOG, interval)
        self.link.push([moves[0], Record(PAUSE, 0, pause), moves[1], Record(PAUSE | REST, 0, pause)])
        self.link.start(self.clock.ticks(self.wall()) + self.state.horizon)
        return self._awaited(Happening.REST, JOG_S) is not None

    def under_load(self) -> float:
        """Return the longest time taken to transfer all the frames that precede the first step of a motion, ms.

        The records sent are pauses, which are then discarded: no motion is started.
        """
        worst = 0
        for _ in range(LOADS):
            began = self.wall()
            self.link.push([Record(PAUSE, 0, SHORT_PAUSE, 0, 0)] * LOAD_RECORDS)
            self.link.outputs(0, 0)
            self._pass_while(lambda: not self.link.idle, began + LOAD_S * 1e9)
            worst = max(worst, self.wall() - began)
            self.link.reset()
            self._pass_while(lambda: not self.link.idle, began + 2 * LOAD_S * 1e9)
        return worst / 1e6
