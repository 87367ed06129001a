"""Stop ramps: the deceleration of the chip from each step of a motion, as sent to a board.

    table     the plan's own stop ramp, as intervals and counts: sent once per motion
    a record  the number of steps in the stop ramp from each step of the record (RAMP_LEFT)

If a chip has an input that decelerates the motor, the deceleration follows a law of its own, named by a
word of REFLEXES:

    brake         down through the levels (rates) below that of the last step, each in full: from the top
                  rate, the whole stop ramp; during a deceleration, the rest of that deceleration
    brake back    down by as many steps as the acceleration has made; it ends with the first step at the
                  first rate

The board makes the scheduled step, and then the stop ramp.  For a plan that does not begin at rest, or
whose levels change too fast for one record each, no number is sent; then the motor's rate sets the ramp.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import log
from typing import TYPE_CHECKING, NamedTuple

from ...core.motion.plan import Runs, mirrored, steps, tail
from ...core.time.timebase import PS_PER_S
from ..board.boards import FAST_TICKS
from ..board.records import MOST_RAMP_LEFT

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...core.motion.axis import Axis, Segment
    from ...core.motion.plan import Leg, Plan
    from ..board.board_link import Link
    from ..drive_state import DriveState
    from ..feeder import Feeder

LEVELS, BACK = "brake", "brake back"  # words of REFLEXES
QUEUE_LEVELS = 40  # levels that every board can queue
LEVEL_PS = 1_250_000_000  # minimum time per level of a longer ramp: some 800 records per second
FAST_STEPS = 3  # minimum number of fast steps per entry: a board needs that long to load one
Entries = list[tuple[int, int]]  # intervals in 1/256 tick, counts


class RampPiece(NamedTuple):
    """The lengths of the stop ramps from the steps `first` to `end` - 1 of a plan.

    From step `first`, the stop ramp has `ramp_left` steps, or -1 if unknown; with each following step, this
    number changes by `slope`: -1, 0 or 1.
    """

    first: int
    end: int
    ramp_left: int
    slope: int


def law_of(chip: Chip) -> str:
    """Return the law by which an input decelerates a chip's motor, as a word of REFLEXES; "" if no input does."""
    words = {row.reflex for row in chip.sheet.pins}
    return BACK if BACK in words else LEVELS if LEVELS in words else ""


def ramp_pieces(plan: Plan, law: str) -> list[RampPiece]:
    """Return, as pieces, the length of the stop ramp from each step of a plan that begins at rest."""
    found = [RampPiece(0, 1, 0, 0)]
    up = plan.legs[0].runs if plan.legs[0].name == "up" else ()
    slow = up[0][0] if up else 0  # the interval at which a `brake back` ends
    done = 0  # steps of the acceleration so far, which a `brake back` would reverse
    for leg in plan.legs:
        first = leg.first
        for interval, count in leg.runs:
            end = first + count
            if law == LEVELS:
                ramp_left, slope = (leg.end - first - 2, -1) if leg.name == "down" else (below(up, interval) - 1, 0)
            elif interval == slow or not up or leg.name not in ("up", "slew", "down"):
                ramp_left, slope = 0, 0
            elif leg.name == "up":
                ramp_left, slope = done + 1, 1
                done += count
            elif leg.name == "slew":
                ramp_left, slope = done, 0
            else:
                ramp_left, slope = fast(leg, first, slow) - 1, -1
            _add(found, RampPiece(first + 1, end + 1, ramp_left, slope))
            first = end
    return found


def below(up: Runs, interval: int) -> int:
    """Return the number of steps of an acceleration whose intervals are longer than `interval`."""
    return sum(count for each, count in up if each > interval)


def fast(leg: Leg, step: int, slow: int) -> int:
    """Return how many steps of a leg, from step `step` of the plan on, have an interval other than `slow`."""
    return sum(count for each, count in tail(leg.runs, step - leg.first) if each != slow)


def _add(found: list[RampPiece], piece: RampPiece) -> None:
    """Append a piece to `found`, or extend its last piece instead; replace negative lengths of stop ramps by 0."""
    first, end, ramp_left, slope = piece
    if slope < 0 and end > first + ramp_left + 1:  # the last values would be below 0
        zero = max(first + ramp_left + 1, first)
        if zero > first:
            _add(found, RampPiece(first, zero, ramp_left, slope))
        _add(found, RampPiece(zero, end, 0, 0))
        return
    ramp_left = max(ramp_left, 0)
    last = found[-1]
    if last.slope == slope and last.ramp_left + (first - last.first) * slope == ramp_left:
        found[-1] = last._replace(end=end)
    else:
        found.append(RampPiece(first, end, ramp_left, slope))


class StopRamps:
    """The sender of a chip's stop ramps to a drive's board: as tables, and as numbers in records (`pieces`).

    Args:
        send: called with the table of a motion, and the instant at which the motion begins (ps).
    """

    def __init__(self, state: DriveState, link: Link, send: Callable[[Entries, int], object]) -> None:
        self.state, self.link, self._send = state, link, send
        self.law = law_of(state.chip)
        self.tail: Entries = []  # stop ramp that the board has
        self._ident: object = None  # IDENT of that board
        self._plan: Plan | None = None  # plan of this stop ramp
        self._pieces_plan: Plan | None = None  # plan of the present pieces
        self._pieces: list[RampPiece] = []

    def turn(self, feeder: Feeder) -> None:
        """Send a stop ramp for any rate, if the motor runs fast without a plan and the board has no stop ramp yet."""
        state, ident = self.state, self.link.ident
        if not self._knows() or ident is None or self.tail or state.axis.past[-1].plan is not None:
            return
        if 0 < feeder.interval16 >> 16 < FAST_TICKS:
            self.tail = spread(state.board.shortest, state.config.start_stop, ident.tail)
            self.link.tail(self.tail)

    def _knows(self) -> bool:
        """Return whether a board has identified itself; after a new identification, forget the table sent before."""
        ident = self.link.ident
        if ident is not self._ident:
            self._ident, self._plan, self.tail = ident, None, []
        return ident is not None

    def _send_ramp(self, stretch: Segment) -> None:
        """Send the stop ramp of a stretch, with the instant at which the stretch starts, if the ramp has changed."""
        ident = self.link.ident
        if not self._knows() or ident is None or stretch.plan is self._plan:
            return
        self._plan = stretch.plan
        entries = stop_ramp(stretch, self.state.board.hz, ident.tail, self.law)
        if entries and entries != self.tail:
            self.tail = entries
            self._send(entries, stretch.start)

    def pieces(self, stretch: Segment, a: int, b: int) -> Iterator[RampPiece]:
        """Send a stretch's stop ramp if it is new; yield pieces for steps `a` to `b` - 1 of the stretch's train."""
        plan = stretch.plan
        if plan is not None:
            self._send_ramp(stretch)
        if plan is None or not plan.legs or not self.law or stretch.playing is None:
            yield RampPiece(a, b, -1, 0)
            return
        if plan is not self._pieces_plan:
            self._pieces_plan, self._pieces = plan, ramp_pieces(plan, self.law)
            if not is_expressible(plan, self._pieces, stretch.playing.train.clock.ps):
                self._pieces = []
        offset = stretch.step
        if not self._pieces or not from_rest(self.state.axis, stretch):
            yield RampPiece(a, b, -1, 0)
            return
        for first, end, ramp_left, slope in self._pieces:
            start, stop = max(first - offset, a), min(end - offset, b)
            if start < stop:
                yield RampPiece(start, stop, ramp_left + (start + offset - first) * slope, slope)
        if (known := max(self._pieces[-1].end - offset, a)) < b:
            yield RampPiece(known, b, 0, 0)


def is_expressible(plan: Plan, pieces: list[RampPiece], ps: Callable[[int], int]) -> bool:
    """Return whether records can hold the lengths of a plan's stop ramps.

    They cannot if a ramp has too many steps for a record, or if the rates of an acceleration follow each
    other too quickly to send one record for each.
    """
    up = plan.legs[0].runs if plan.legs[0].name == "up" else ()
    if any(
        max(ramp_left, ramp_left + slope * (end - first - 1)) > MOST_RAMP_LEFT
        for first, end, ramp_left, slope in pieces
    ):
        return False
    return len(up) <= QUEUE_LEVELS or ps(sum(interval * count for interval, count in up)) >= LEVEL_PS * len(up)


def from_rest(axis: Axis, stretch: Segment) -> bool:
    """Return whether the plan of a stretch began a motion rather than changed one in progress."""
    past = axis.past
    at = next((number for number in range(len(past) - 1, -1, -1) if past[number] is stretch), 0)
    while at and past[at].step and past[at - 1].plan is stretch.plan:
        at -= 1
    if past[at].step:
        return False
    before = next((past[number].start for number in range(at - 1, -1, -1) if past[number].playing is not None), -1)
    return bool(axis.log.starts(before + 1, past[at].start))


# -------------------------------------------------------------------------------------------------------------- tables
def stop_ramp(stretch: Segment, hz: int, most: int, law: str = "") -> Entries:
    """Return the stop ramp of a stretch's plan as a board's table; empty if there is none or it is too long.

    The ramp is the last decelerating leg of the plan or, if there is none, the mirrored last acceleration,
    without the interval after the last step.  A board has room for `most` entries, so neighbouring intervals
    may share an entry.
    """
    if stretch.plan is None or stretch.playing is None:
        return []
    up, down = ([leg.runs for leg in stretch.plan.legs if leg.name == name] for name in ("up", "down"))
    runs = down[-1] if down else mirrored(up[-1]) if up else ()
    if law == BACK:
        runs = tuple(run for run in runs if not up or run[0] != up[0][0][0])
    elif runs:
        runs = (*runs[:-1], (runs[-1][0], runs[-1][1] - 1))
    rows: list[tuple[int, int, int]] = []  # sum of intervals, count, the longest interval
    for interval, count in runs:
        if count and (not rows or interval > rows[-1][2]):
            rows.append((interval * count, count, interval))
        elif count:
            rows[-1] = rows[-1][0] + interval * count, rows[-1][1] + count, max(interval, rows[-1][2])
    if steps(tuple((row[2], row[1]) for row in rows)) > MOST_RAMP_LEFT:
        return []
    while len(rows) > most:  # merge the two rows with the least error
        join(rows, min(range(len(rows) - 1), key=lambda n: apart(rows[n], rows[n + 1])))
    clock = stretch.playing.train.clock
    entries = [(clock.ps(total) * hz * 256 // (count * PS_PER_S), count) for total, count, _ in rows]
    while (at := too_short(entries)) is not None:
        (one, n), (other, m) = entries[at : at + 2]
        entries[at : at + 2] = [((one * n + other * m) // (n + m), n + m)]
    return entries


def join(rows: list[tuple[int, int, int]], n: int) -> None:
    """Merge row `n` with the next row, in place."""
    rows[n : n + 2] = [(rows[n][0] + rows[n + 1][0], rows[n][1] + rows[n + 1][1], rows[n + 1][2])]


def apart(one: tuple[int, int, int], other: tuple[int, int, int]) -> int:
    """Return the error, in clocks, that merging two rows of a stop ramp would cause."""
    return other[2] * (one[1] + other[1]) - one[0] - other[0]


def too_short(entries: Entries) -> int | None:
    """Return the index of the first entry that is too short for a board to load the next one in time.

    Return None if there is no such entry.
    """
    fast = FAST_TICKS << 8
    return next((n for n, (each, count) in enumerate(entries[:-1]) if each < fast and count < FAST_STEPS), None)


def spread(shortest: int, start_stop: int, most: int) -> Entries:
    """Return a stop ramp from any rate down to the rate at which the motor may stop, for trains without a plan.

    The interval grows by about 1/16 per step, as on a board without a table, but changes only every few
    steps.
    """
    out: Entries = []
    interval = float(shortest)
    while (interval := interval * 17 / 16 * 17 / 16 * 17 / 16) < FAST_TICKS:
        out.append((int(interval * 256), FAST_STEPS))
    left = most - len(out)
    if start_stop <= interval:
        return [each for each in out if each[0] <= start_stop << 8]
    ratio = (start_stop / interval) ** (1 / (left - 1))
    count = max(round(log(ratio) / log(17 / 16)), 1)
    return out + [(round(interval * ratio**n * 256), count) for n in range(left)]
