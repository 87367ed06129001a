"""The recorder: the history of a net, stored as it was driven, expanded into edges on request.

A net's log is a list of entries (instant, level or promise), each of which holds until the next; a
promise computes future levels.  So a million steps of an endless move are one entry, expanded only for
the window requested:

    log      (0, 1)      (5 µs, promise of a train)           (9 µs, 0)
    net      1111111111111111|_|1|_|1|_|1|_|1|_|1|____________________________
    edges                    ^ ^ ^ ^ ^ ^ ^ ^ ^ ^ ^

Rules of this file: nothing after the last committed instant is read; the level at the start of a log is
not an edge.  Levels are 0 and 1, on a bus 0 to 255, and FLOATING where nothing drives and nothing pulls.
"""

from __future__ import annotations

import sys
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from ...core.time.events import ask_at
from ...core.time.hook import Hook
from ...core.time.kernel import Kernel
from ...core.time.timebase import readable
from ...core.wires.net import Bus, Net
from ...core.wires.pin import Terminal
from ...core.wires.wave import Wave
from ...errors import NotRecorded, TimeError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Levels: TypeAlias = NDArray[np.int8] | NDArray[np.int16] | NDArray[np.int32]
    Edges: TypeAlias = tuple[NDArray[np.int64], Levels]


class Wires(NamedTuple):
    """A bus queried wire by wire: a level is 256 * (mask of driven wires) + (mask of wires that are high)."""

    net: Net

    @property
    def name(self) -> str:
        """The name of the bus."""
        return self.net.name


Probe: TypeAlias = Net | Terminal | Wires  # a net, or a pin (also one wire of a bus)

FLOATING = -1
LEVELS = frozenset((int, tuple, type(None)))  # types of entries that are not promises
TRIM_FROM = 1024  # entries; shorter logs are not worth trimming
CHUNK_EDGES = 1 << 17  # time that an export expands in one piece
FIRST_CHUNK_PS = 10**10
LONGEST_CHUNK_PS = 10**12  # limits the cost of a burst after a long silence


class EdgeLog(list[tuple[int, Any]]):
    """The log entries of a net.

    Unless `keep_ps` is None, entries older than `keep_ps` are dropped each time that a long log has become
    twice as long as it was after the previous drop.
    """

    __slots__ = ("full", "keep_ps")

    def __init__(self, keep_ps: int | None) -> None:
        super().__init__()
        self.keep(keep_ps)

    def keep(self, keep_ps: int | None) -> None:
        """Set how much of the past to keep (ps); None for all of it."""
        self.keep_ps = keep_ps
        self.full = sys.maxsize if keep_ps is None else TRIM_FROM

    def append(self, entry: tuple[int, Any]) -> None:
        """Add the newest entry (called by the net); trim the log if it has become too long."""
        super().append(entry)
        if len(self) > self.full:
            self.trim(entry[0])

    def trim(self, now: int) -> None:
        """Drop entries older than `keep_ps`, except the newest of these, which holds until the next entry."""
        if self.keep_ps is not None:
            del self[: max(bisect_left(self, (now - self.keep_ps,)) - 1, 0)]
            self.full = max(2 * len(self), TRIM_FROM)


class TextLog:
    """The texts that a hook reports after this log is created; only the last text of each instant is kept."""

    def __init__(self, kernel: Kernel, hook: Hook[[str]], keep_ps: int | None) -> None:
        self.kernel, self.log = kernel, EdgeLog(keep_ps)
        self.log.append((kernel.now, ""))
        hook.add(self.note)

    def note(self, text: str) -> None:
        """Record a text for the current instant, unless it repeats the previous text."""
        now = self.kernel.now
        if self.log[-1][0] == now:
            self.log[-1] = now, text
        elif self.log[-1][1] != text:
            self.log.append((now, text))

    def between(self, start: int, stop: int) -> list[tuple[int, str]]:
        """Return the texts in start <= t <= stop (ps), with their instants."""
        return self.log[bisect_left(self.log, (start,)) : bisect_left(self.log, (stop + 1,))]


class Recorder:
    """A recorder of nets that answers queries about their past."""

    def record(self, probe: Probe, keep_ps: int | None = None) -> None:
        """Start recording a net: keep the last `keep_ps` (ps) of its past, or all of it if `keep_ps` is None.

        If the net is already recorded, recording continues with the new `keep_ps`.
        """
        net = net_of(probe)
        if isinstance(net.log, EdgeLog):
            net.log.keep(keep_ps)
            return
        net.log = EdgeLog(keep_ps)
        net.log.append((net.kernel.seen, _present(net)))
        if net.promise is not None and len(net.drivers) > 1:
            net.follow()  # several drivers: only the net itself can combine their promises

    def since(self, probe: Probe) -> int:
        """Return the first instant (ps) for which a recorded net can be queried.

        Raises:
            NotRecorded: the net is not recorded.
        """
        log = self._kept(probe)
        return log[0][0] if log.keep_ps is None else max(log[0][0], net_of(probe).kernel.seen - log.keep_ps)

    @staticmethod
    def _kept(probe: Probe) -> EdgeLog:
        log = net_of(probe).log
        if not isinstance(log, EdgeLog):
            raise NotRecorded(f"{probe.name} is not recorded; call bench.record({probe.name!r}) before running")
        return log

    def level(self, probe: Probe, ps: int) -> int:
        """Return the level at an instant (ps), after any edge there; FLOATING if nothing drives or pulls the net.

        For an instant after the last committed one, return the level at the last committed instant.

        Raises:
            NotRecorded: the net is not recorded, or its past is no longer kept that far back.
        """
        log, net = self._log(probe, ps), net_of(probe)
        ps = min(ps, net.kernel.seen)
        return _code(probe, _level(log[max(bisect_left(log, (ps + 1,)) - 1, 0)][1], ps))

    def edges(self, probe: Probe, start: int, stop: int) -> Edges:
        """Return the edges in start <= t <= stop (ps), up to the last committed instant.

        There is at most one edge per instant, and at each edge the level really changes.

        Returns:
            Times, (n,) int64 ps, ascending; and the levels after the edges, (n,) int8, FLOATING where nothing
            drives or pulls the net.  On a bus, the levels are int16, 0 to 255; an undriven wire reads 1, unless
            all are undriven.

        Raises:
            NotRecorded: the net is not recorded, or its past is no longer kept that far back.
            TimeError: the window ends beyond 2^63 ps (106 days).
        """
        log, stop = self._window(probe, start, stop)
        first, last = max(bisect_left(log, (start,)) - 1, 0), bisect_left(log, (stop + 1,))
        since, what = log[first]
        if stop < start or (last - first <= 1 and not _promised(what)):  # one level throughout
            return columns(probe, [], [])
        before = _code(probe, _level(what, max(since, start - 1)))
        return real_edges(*_expanded(probe, log[first:last], start, stop), before)

    def each_edge(self, probe: Probe, start: int, stop: int) -> Iterator[tuple[int, int]]:
        """Yield the same edges as `edges`, one by one, as time (ps) and level, for callers that need only a few.

        Raises:
            NotRecorded, TimeError: as for `edges`.
        """
        log, stop = self._window(probe, start, stop)
        first = max(bisect_left(log, (start,)) - 1, 0)
        before = _code(probe, _level(log[first][1], max(log[first][0], start - 1)))
        for number in range(first, len(log)):
            since, what = log[number]
            if since > stop:
                return
            end = min(log[number + 1][0] - 1, stop) if number + 1 < len(log) else stop
            time: int | None = max(since, start)
            while time is not None and time <= end:
                level = _code(probe, _level(what, time))
                if level != before:
                    yield time, level
                    before = level
                time = ask_at(what.after(time)) if _promised(what) else None

    def _window(self, probe: Probe, start: int, stop: int) -> tuple[EdgeLog, int]:
        """Return the log of a net, and `stop` (ps) or the last committed instant, whichever is earlier."""
        log = self._log(probe, start)
        stop = min(stop, net_of(probe).kernel.seen)
        if stop >= 1 << 63:
            raise TimeError("arrays can contain times up to 106 days (2^63 ps); request an earlier window")
        return log, stop

    def _log(self, probe: Probe, start: int) -> EdgeLog:
        since = self.since(probe)
        log = self._kept(probe)
        if start < since:
            remedy = f"call bench.record({probe.name!r}) earlier"
            if log.keep_ps is not None:
                remedy += f", or with a longer keep than {readable(log.keep_ps)!r}"
            raise NotRecorded(f"{probe.name} at {readable(start)}: recorded from {readable(since)} on; {remedy}")
        return log


def chunks(expand: Sequence[Callable[[int, int], Any]], start: int, stop: int, unit: int = 1) -> Iterator[list[Any]]:
    """Yield the changes in start <= t <= stop, window by window: one array for an hour would be too large.

    For each window, yield a list with the result of each function.  The length of a window depends on the
    density of changes in the previous one.  All windows but the last end 1 ps before a multiple of `unit`
    (ps).

    Args:
        expand: functions of a window (start, stop), such as the edges of a net; each returns times and
            values.
        start, stop: ps, not after the last committed instant.
        unit: every window after the first begins at a multiple of this time, ps.
    """
    length = FIRST_CHUNK_PS
    while start <= stop:
        last = min(stop, -(-(start + length) // unit) * unit - 1)
        changes = [expanded(start, last) for expanded in expand]
        yield changes
        found = max(sum(len(times) for times, _ in changes), 1)
        length = max(min(length * CHUNK_EDGES // found, 4 * length, LONGEST_CHUNK_PS), 1)
        start = last + 1


def net_of(probe: Probe) -> Net:
    """Return the net of a probe: the net of a pin or of `Wires`, or the probe itself if it is a net."""
    return probe if isinstance(probe, Net) else probe.net


def width_of(probe: Probe) -> int:
    """Return the number of wires of a probe: 8 for a whole bus, else 1."""
    return 1 if isinstance(probe, Terminal) and probe.bit is not None else net_of(probe).width


# ------------------------------------------------------------------------------------------------- entries to levels
def _promised(what: Any) -> bool:
    return type(what) not in LEVELS


def _present(net: Net) -> Any:
    """Return the promise of a net's only active driver, or the net's level if there is no such promise."""
    driving = [driver for driver in net.drivers if driver.promise is not None or driver.level is not None]
    if len(driving) == 1 and driving[0].promise is not None:
        return driving[0].promise
    return net.level


def _level(what: Any, ps: int) -> Any:
    return what.level(ps) if _promised(what) else what


def _code(probe: Probe, level: Any) -> int:
    """Return the number that represents a level in arrays.

    If the level is None, it is replaced by the net's tie or, without a tie, by the net's pull; a net with
    neither is FLOATING.
    """
    net = net_of(probe)
    if level is None:
        level = net.tie if net.tie is not None else net.pull
    if level is None:
        return FLOATING
    if not isinstance(net, Bus):
        return int(level)
    mask, value = level
    if isinstance(probe, Wires):
        return int(mask << 8 | value & mask)
    if isinstance(probe, Terminal) and probe.bit is not None:
        return int(value) >> probe.bit & 1 if mask >> probe.bit & 1 else FLOATING
    return int(value | ~mask) & 0xFF


def columns(probe: Probe, times: Any, levels: Any) -> Edges:
    """Return times and levels, given as two lists (from log entries) or two arrays, as arrays of edges."""
    import numpy as np

    dtype: Any = np.int8 if width_of(probe) == 1 else np.int32 if isinstance(probe, Wires) else np.int16
    if isinstance(levels, list):
        codes = {level: _code(probe, level) for level in set(levels)}
        if any(code is not level for level, code in codes.items()):  # not for one wire that never floats
            levels = [*map(codes.__getitem__, levels)]
    return np.asarray(times, np.int64), np.asarray(levels, dtype)


def _codes(probe: Probe, levels: Any) -> Any:
    """Return the levels of a promise as the numbers that represent them in arrays.

    `levels` may also be an array, in which a level of a bus is 256 * (mask of driven wires) + value, or negative
    if the bus floats.
    """
    import numpy as np

    if isinstance(levels, list) or not isinstance(net_of(probe), Bus):
        return levels
    if isinstance(probe, Terminal) and probe.bit is not None:
        driven = np.where(levels >> 8 + probe.bit & 1, levels >> probe.bit & 1, FLOATING)
    else:
        driven = levels if isinstance(probe, Wires) else (levels | ~(levels >> 8)) & 0xFF
    return np.where(levels < 0, _code(probe, None), driven)


def _expanded(probe: Probe, entries: Sequence[tuple[int, Any]], start: int, stop: int) -> Edges:
    """Return the edges in start <= t <= stop of log entries; the first entry may begin long before `start`."""
    import numpy as np

    sinces, whats = [since for since, _ in entries], [what for _, what in entries]
    if LEVELS.issuperset(map(type, whats)):  # most entries of a dialogue are; the level before is not an edge
        return columns(probe, sinces, whats)
    times: list[int] = []
    levels: list[Any] = []
    parts: list[Edges] = []
    for since, what, following in zip(sinces, whats, [*sinces[1:], stop + 1], strict=True):
        if type(what) in LEVELS:
            if since >= start:
                times.append(since)
                levels.append(what)
            continue
        if type(what) is Wave and what.whole(since, following) and since >= start:  # the strobes of a dialogue
            times += (since, *what.times)
            levels += (what.before, *what.levels)
            continue
        if since >= start:
            times.append(since)
            levels.append(what.level(since))
        ahead = what.edges(max(since, start - 1), following - 1)
        if isinstance(ahead[0], list):  # too few to be worth an array
            times += ahead[0]
            levels += ahead[1]
        elif len(ahead[0]):
            parts += [columns(probe, times, levels), columns(probe, ahead[0], _codes(probe, ahead[1]))]
            times, levels = [], []
    parts.append(columns(probe, times, levels))
    return np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts])


def real_edges(times: NDArray[np.int64], levels: Levels, before: int) -> Edges:
    """Return the real changes: the last edge at each time, without any that repeats the level before it.

    Args:
        times: (n,) int64 ps, ascending; equal times are allowed.
        levels: the level after each time, (n,).
        before: the level before the first edge.
    """
    import numpy as np

    if len(times):
        last = np.append(times[1:] != times[:-1], True)
        if not last.all():
            times, levels = times[last], levels[last]
        real = np.append(levels[0] != before, levels[1:] != levels[:-1])
        if not real.all():
            times, levels = times[real], levels[real]
    return times, levels
