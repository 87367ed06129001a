"""Records of a board's queue, and the fitting of a few records to many instants.

A record is a number of steps in quadratic progression, or a pause.  Time is counted in whole units of
1/65536 tick, as on the board.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from struct import Struct
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...errors import UsageError
from .wire import RECORD_BYTES, USER_OUTPUTS

if TYPE_CHECKING:
    from numpy.typing import NDArray

DOWN, REST, PAUSE, OUT, HALF, RAMP_LEFT = 1, 2, 4, 8, 16, 64  # flags

PER_TICK = 65_536
MOST_STEPS = 65_535  # per record
SHORTEST_PAUSE, LONGEST = 256, 2**31 - 1  # ticks
STEEPEST = 2**31 - 1  # limits of `add`
_LONG_PAUSE = 2**30  # ticks of each pause in a longer gap

MOST_RAMP_LEFT = 65_535  # steps

_RECORD = Struct("<BHIHi")


class Record(NamedTuple):
    """A number of steps, or one interval without a step (PAUSE).

    Each interval between the steps is longer than the previous one by `add`, which may be negative.
    `interval` is in ticks, `fraction` and `add` in 1/65536 tick.  With RAMP_LEFT the interval is constant,
    and `add` has another meaning.  Its low 16 bits then hold the number of steps of a stop ramp that starts
    at the first step.  Its high 16 bits hold the change of that number with each step (signed: -1, 0 or 1).
    """

    flags: int
    count: int  # type: ignore[assignment]  # of a tuple, which nobody counts in
    interval: int
    fraction: int = 0
    add: int = 0

    def pack(self) -> bytes:
        """Return the record as 13 bytes."""
        return _RECORD.pack(*self)

    def with_ramp_left(self, ramp_left: int, slope: int) -> Record:
        """Return a copy of this record with RAMP_LEFT; the intervals of this record must be equal.

        Args:
            ramp_left: the number of steps of a stop ramp that starts at the first step.
            slope: the change of that number with each step.
        """
        return self._replace(flags=self.flags | RAMP_LEFT, add=slope << 16 | ramp_left)

    @property
    def growth(self) -> int:
        """The growth of each interval over the previous one, in 1/65536 tick."""
        return 0 if self.flags & RAMP_LEFT else self.add

    @property
    def slope(self) -> int:
        """The change in the stop ramp's length per step: -1, 0 or 1 steps; only for a record with RAMP_LEFT."""
        return self.add >> 16

    def ramp_left(self, step: int) -> int | None:
        """Return the number of steps of a stop ramp that starts at `step` (0: the first); None without RAMP_LEFT."""
        return (self.add & 0xFFFF) + step * self.slope if self.flags & RAMP_LEFT and not self.flags & PAUSE else None

    @property
    def first(self) -> int:
        """The first interval, in 1/65536 tick."""
        return self.interval << 16 | self.fraction

    @property
    def last(self) -> int:
        """The last interval, in 1/65536 tick."""
        return self.first if self.flags & PAUSE else self.first + (self.count - 1) * self.growth

    @property
    def length(self) -> int:
        """The total duration, in 1/65536 tick."""
        if self.flags & PAUSE:
            return self.first
        return self.count * self.first + self.count * (self.count - 1) // 2 * self.growth

    def times(self, base: int) -> Iterator[int]:
        """Yield the instants of the record's steps, in 1/65536 tick, if the record begins at `base`."""
        if self.flags & PAUSE:
            return
        interval = self.first
        for _ in range(self.count):
            base += interval
            yield base
            interval += self.growth

    def good(self, shortest: int) -> bool:
        """Return whether a board accepts the record, if steps must be at least `shortest` ticks apart."""
        if self.flags & PAUSE:
            masks = self.count >> 8, self.count & 255
            sets = max(masks) <= USER_OUTPUTS if self.flags & OUT else self.count == 0
            return sets and self.flags < 32 and SHORTEST_PAUSE <= self.interval <= LONGEST
        ends = self.first >> 16, self.last >> 16
        if self.flags & RAMP_LEFT:
            last = self.ramp_left(self.count - 1) or 0
            if abs(self.slope) > 1 or not 0 <= last <= MOST_RAMP_LEFT:
                return False
        known = not self.flags & ~(DOWN | HALF | RAMP_LEFT)
        return known and self.count > 0 and shortest <= min(ends) and max(ends) <= LONGEST


def unpack(payload: bytes) -> list[Record]:
    """Return the records of a payload that contains whole records."""
    return [Record(*fields) for fields in _RECORD.iter_unpack(payload)]


def pack(records: Iterable[Record]) -> bytes:
    """Return the payload of a PUSH frame with these records."""
    return b"".join(_RECORD.pack(*record) for record in records)


assert _RECORD.size == RECORD_BYTES  # noqa: S101


def length(records: Iterable[Record]) -> int:
    """Return the total duration of records, in 1/65536 tick, after which the next record starts."""
    return sum(record.length for record in records)


def pauses(gap: int, flags: int = 0) -> list[Record]:
    """Return pauses with a given total duration, in 1/65536 tick; all have the given flags.

    Raises:
        UsageError: the gap is shorter than 256 ticks.
    """
    if gap < SHORTEST_PAUSE << 16:
        raise UsageError(f"a pause of {gap / PER_TICK:g} ticks; expected {SHORTEST_PAUSE} or more")
    out = []
    while gap > LONGEST << 16:
        out.append(Record(flags | PAUSE, 0, _LONG_PAUSE))
        gap -= _LONG_PAUSE << 16
    return [*out, Record(flags | PAUSE, 0, gap >> 16, gap & 0xFFFF)]


# ----------------------------------------------------------------------------------------------------------------- fit
_STEPS = np.arange(1, MOST_STEPS + 1, dtype=np.int64)
_SUMS = _STEPS * (_STEPS - 1) // 2  # factor of `add` in the instant of each step


def fit(
    ticks: Sequence[int] | NDArray[np.int64],
    base: int,
    *,
    tolerance: int = 8 * PER_TICK,
    flags: int = 0,
    shortest: int = 224,
    even: bool = False,
) -> list[Record]:
    """Return records whose steps are within `tolerance` of the instants `ticks`.

    All times are in 1/65536 tick, except `shortest`, the minimum interval, in ticks.  Each record is as long
    as possible, and begins where the board's arithmetic will end the previous one, so errors do not
    accumulate.  `base` is the start of the first record.  A step that would be more than 2^31 ticks after
    the start of its record is preceded by pauses.  If `even` is True, the intervals within each record are
    equal.

    Raises:
        UsageError: steps are closer together than `shortest`.
    """
    out: list[Record] = []
    instants = np.asarray(ticks, dtype=np.int64)
    at = 0
    while at < len(instants):
        offsets = instants[at : at + MOST_STEPS] - base
        if offsets[0] > LONGEST << 16:
            out.append(Record(flags | PAUSE, 0, _LONG_PAUSE))
            base += _LONG_PAUSE << 16
            continue
        count, first, add = _longest(offsets, tolerance, shortest << 16, 0 if even else STEEPEST)
        if not count:
            raise UsageError(
                f"step {at} of {len(instants)}: {offsets[0] / PER_TICK:g} ticks after the previous step; expected "
                f"{shortest} or more; choose a lower rate, or a faster board"
            )
        record = Record(flags, count, first >> 16, first & 0xFFFF, add)
        out.append(record)
        base += record.length
        at += count
    return out


Found = tuple[int, int, int]  # steps, first interval, add


def _longest(offsets: NDArray[np.int64], tolerance: int, shortest: int, steepest: int) -> Found:
    """Return the longest record that fits the steps at `offsets`, beginning with the first of them.

    `offsets` are counted from the start of the record.  The result is the number of steps, the first
    interval and `add`; the number is 0 if not even the first step fits.
    """
    most = len(offsets)
    low, high = offsets - tolerance, offsets + tolerance
    best: Found = (0, 0, 0)
    bounds = (-steepest, steepest)  # bounds of `add`, proved by the steps that are certainly in the record
    too_many, trial = most + 1, 1
    while best[0] + 1 < too_many:
        found, proved = _through(low[:trial], high[:trial], shortest, bounds, best[2])
        if found is None:
            too_many = trial
        else:
            bounds = proved
            best = _extended(trial, *found, low[: too_many - 1], high[: too_many - 1], shortest)
        trial = min(most, 4 * best[0]) if too_many > most else (best[0] + too_many) // 2
    return best


def _through(
    low: NDArray[np.int64], high: NDArray[np.int64], shortest: int, bounds: tuple[int, int], add: int
) -> tuple[tuple[int, int] | None, tuple[int, int]]:
    """Search for a first interval and an `add` that put every step n between `low[n]` and `high[n]`.

    Return these two numbers, or None if there are none; and bounds within which `add` must be.  The search
    begins at the argument `add`.

    Each step limits the first interval for a given `add`.  If the highest lower limit is above the lowest
    upper limit, these two limits show whether `add` must be greater or smaller.
    """
    count = len(low)
    steps, sums = _STEPS[:count], _SUMS[:count]
    least, greatest = bounds
    while least <= greatest:
        moved = sums * add
        floors, ceilings = -((moved - low) // steps), (high - moved) // steps
        below, above = int(floors.argmax()), int(ceilings.argmin())
        floor, ceiling = int(floors[below]), int(ceilings[above])
        # position of the limit on the line: half the index of the step; first and last interval are limits as well
        places = [(floor, below / 2), (shortest, 0.0), (shortest - (count - 1) * add, count - 1.0)]
        floor, lower = max(places)
        longest = (LONGEST << 16) + 0xFFFF
        ceiling, upper = min((ceiling, above / 2), (longest, 0.0), (longest - (count - 1) * add, count - 1.0))
        if floor <= ceiling:
            # the best fit of the last step: the next record begins there
            wish = round((int(low[-1]) + int(high[-1]) - 2 * int(moved[-1])) / (2 * count))
            return (min(max(wish, floor), ceiling), add), (least, greatest)
        if lower == upper:
            break
        missing = (floor - ceiling) / (lower - upper)  # change of `add` that these two limits need
        upwards = lower > upper
        if upwards:
            least = add + max(1, int(missing))
        else:
            greatest = add - max(1, int(-missing))
        bounded = least > -STEEPEST and greatest < STEEPEST
        add = (least + greatest) // 2 if bounded else (least if upwards else greatest)
    return None, bounds


def _extended(
    count: int, first: int, add: int, low: NDArray[np.int64], high: NDArray[np.int64], shortest: int
) -> Found:
    """Return a record of `count` steps, lengthened by the next steps that are also within `low` and `high`.

    `first` and `add` remain unchanged.
    """
    end = min(len(low), 8 * count)
    if add < 0:
        end = min(end, (first - shortest) // -add + 1)
    elif add > 0:
        end = min(end, ((LONGEST << 16) - first) // add + 1)
    if end <= count:
        return count, first, add
    steps = _STEPS[count:end] * first + _SUMS[count:end] * add
    wrong = (steps < low[count:end]) | (steps > high[count:end])
    beyond = int(wrong.argmax())
    return (count + beyond if wrong[beyond] else end), first, add
