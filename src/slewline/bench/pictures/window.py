"""A window of a recorded bench: signals, the intervals between their edges, and the lanes of a diagram."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from typing import TYPE_CHECKING

from ...core.chip import Chip
from ...core.datasheet.channel import AdaptiveLine, HostPort, SerialLine
from ...core.datasheet.table import Limit
from ...core.time.timebase import Clock
from ...core.wires.serial import OVERSAMPLING, RS232, TTL, CharacterFormat
from ...errors import NotRecorded, UsageError
from ...record.measuring.intervals import Bound, Checked, Edge, Interval, SignalEdges, intervals

if TYPE_CHECKING:
    from ...record.measuring.intervals import Spans
    from ...record.pictures.diagram import Lane
    from ...record.pictures.diagram import LaneText as Written
    from ...record.recording.traces import Trace
    from .signals import Signals

Between = str | tuple[str, str]  # two edges, or the symbol of a time in the data sheet
STAYS = 1_000_000  # ps: longest time that a word remains on the bus after its strobe


class Window:
    """The recorded signals from `start` to `stop` (ps).

    If `reach` is true, a signal whose recording began after `start` is accepted; it begins there.
    """

    def __init__(self, signals: Signals, start: int, stop: int, *, reach: bool = False) -> None:
        self.signals, self.start, self.stop, self.reach = signals, start, stop, reach
        self.signal = cache(self._signal)
        self.found = cache(self._found)

    def _signal(self, name: str) -> SignalEdges:
        """Return the signal of the pin or bus with this full name."""
        probe, recorder = self.signals.chosen([name])[name], self.signals.recorder
        since = max(self.start, recorder.since(probe)) if self.reach else self.start
        return SignalEdges.of(probe, recorder, since, self.stop)

    def _found(self, chip: Chip, limit: Limit) -> Spans:
        """Return the starts and the ends (ps) of all intervals to which a limit applies."""
        return intervals(limit, lambda pin: self.signal(f"{chip.name}.{pin}"))

    def check(self, chip: Chip, limit: Limit) -> Checked:
        """Check all intervals to which a limit applies.

        If the limit needs a pin that is not recorded, nothing is checked, and the result only names that pin.
        """
        bound = Bound.of(limit, chip.crystal_hz)
        for pin in (limit.start.split()[0], limit.end.split()[0], *(pin for pin, _ in (*limit.given, *limit.before))):
            try:
                self.signal(f"{chip.name}.{pin}")
            except NotRecorded:
                return Checked(chip.name, bound, missing=pin)
        return Checked.of(chip.name, bound, *self.found(chip, limit))

    # ---------------------------------------------------------------------------------------------------------- arrows
    def measure(self, between: Iterable[Between]) -> list[Interval]:
        """Return the intervals between pairs of edges, and the intervals of data sheet times given by symbol."""
        if isinstance(between, str) or not isinstance(between, Iterable):
            raise UsageError(f"between={between!r}: expected a list of pairs of edges, or of symbols such as 't14'")
        return [interval for each in between for interval in self._measured(each)]

    def _measured(self, between: Between) -> Iterator[Interval]:
        if isinstance(between, str):
            yield from self._named(between)
            return
        if not isinstance(between, Sequence) or len(between) != 2:
            raise UsageError(f"between {between!r}: expected two edges, or the symbol of a time in the data sheet")
        first, second = (Edge.read(text) for text in between)
        first, second = (edge._replace(pin=self.signals.full_name(edge.pin)) for edge in (first, second))
        begin = first.find(self.signal(first.pin), self.start, include=True)
        end = None if begin is None else second.find(self.signal(second.pin), begin, include=first.pin != second.pin)
        if begin is None or end is None:
            which = repr(between[0]) if begin is None else f"{between[1]!r} after {between[0]!r}"
            raise UsageError(f"between {between!r}: there is no {which} in the window")
        yield self._interval(first, second, begin, end)

    def _interval(self, first: Edge, second: Edge, begin: int, end: int) -> Interval:
        """Return the interval between two edges, with the data sheet limits that apply to it."""
        bounds = []
        owner, _, pin = first.pin.partition(".")
        chip = self.signals.circuit.chips.get(owner)
        if chip is not None and second.pin.startswith(f"{owner}."):
            for limit in chip.sheet.limits:
                if (limit.start.split()[0], limit.end.split()[0]) != (pin, second.pin.partition(".")[2]):
                    continue
                if not self.check(chip, limit).missing and (begin, end) in _rows(self.found(chip, limit)):
                    bounds.append(Bound.of(limit, chip.crystal_hz))
        return Interval(f"{first.pin} {first.change}", f"{second.pin} {second.change}", begin, end, tuple(bounds))

    def _named(self, symbol: str) -> Iterator[Interval]:
        """Yield, for each data sheet time with this symbol, its recorded interval with the least margin."""
        limits = [(chip, limit) for chip in self.signals.circuit.chips.values() for limit in chip.sheet.limits]
        named = [(chip, limit) for chip, limit in limits if limit.symbol == symbol]
        if not named:
            known = ", ".join(dict.fromkeys(limit.symbol for _, limit in limits if limit.symbol))
            pair = '; two edges are a pair in the list: [("x.slew falls", "x.slew rises")]' if " " in symbol else ""
            raise UsageError(
                f"between {symbol!r}: the data sheet has no time with this symbol; its symbols: {known or 'none'}{pair}"
            )
        seen = False
        for chip, limit in named:
            if self.check(chip, limit).missing:
                continue
            rows = sorted(_rows(self.found(chip, limit)), key=lambda row: row[1] - row[0], reverse=limit.least is None)
            for begin, end in rows[:1]:
                seen = True
                bound = Bound.of(limit, chip.crystal_hz)
                yield Interval(f"{chip.name}.{limit.start}", f"{chip.name}.{limit.end}", begin, end, (bound,))
        if not seen:
            raise UsageError(f"between {symbol!r}: this time is not in the window, or its pins are not recorded")

    # ----------------------------------------------------------------------------------------------------------- lanes
    def lane(self, name: str, label: str | None, several: bool, decode: bool, over: Trace | None) -> Lane:
        """Return a pin or bus as a lane, with `over` drawn over it.

        If `several` is true, the default label of the lane also names the owner of the pin.
        """
        from ...record.measuring.overlay import fitting
        from ...record.pictures.diagram import Lane

        owner, _, pin = name.partition(".")
        chip = self.signals.circuit.chips.get(owner)
        if label is None:
            label = (f"{owner}: " if several else "") + _printed(chip, pin)
        signal = self.signal(name)
        line = chip.pins.get(pin) if chip is not None and decode else None
        serial = line is not None and line.row.role in ("serial_in", "serial_out")
        words = self._characters(chip, name) if chip is not None and serial else []
        return Lane(
            name, label, signal, words, self._meaning(chip) if signal.bus else None, fitting(name, signal.bus, over)
        )

    def measured_lane(self, trace: Trace, label: str | None) -> Lane:
        """Return a measured trace as a separate lane; where its file has no data, the lane shows a floating level."""
        from ...record.pictures.diagram import Lane

        return Lane(trace.name, label or trace.name, SignalEdges.of_trace(trace, self.start, self.stop))

    def _characters(self, chip: Chip, name: str) -> list[Written]:
        """Return the characters on a serial line, including characters that only begin or end in the window."""
        from ...record.measuring.sampled_characters import characters, shown
        from ...record.pictures.diagram import LaneText as Written

        port: SerialLine | AdaptiveLine | None = chip.sheet.channel(SerialLine) or chip.sheet.channel(AdaptiveLine)
        baud = getattr(chip, "baud", 0)
        if port is None or not baud:
            return []
        word, clock = CharacterFormat(port.bits, port.parity, port.stop), Clock(round(baud * OVERSAMPLING))
        mark = RS232 if isinstance(port, SerialLine) else TTL
        probe, recorder = self.signals.chosen([name])[name], self.signals.recorder
        stop = min(self.stop + clock.ps(word.ticks), self.signals.circuit.kernel.now)
        whole = SignalEdges.of(probe, recorder, recorder.since(probe), stop)
        found = characters(whole, stop, clock, word, mark)
        return [
            Written(c.start_ps, c.end_ps, shown(c.byte), not c.good)
            for c in found
            if c.end_ps > self.start and c.start_ps < self.stop
        ]

    def _meaning(self, chip: Chip | None) -> Callable[[int, int], str]:
        """Return a function that takes a bus value, and returns its character or command, or "" if it has none.

        The second argument of the function is the instant (ps) at which the value ends.
        """
        if chip is None or chip.sheet.channel(HostPort) is None:
            return lambda value, _end: f"'{chr(value)}'" if 32 < value < 127 else "CR" if value == 13 else ""
        try:
            command, write = (self.signal(f"{chip.name}.{pin}") for pin in _strobes(chip))
        except NotRecorded:
            return lambda _value, _end: ""
        rows, strobes = chip.sheet.commands.by_code, write.edges("rises")

        def describe(value: int, end: int) -> str:
            before = bisect_right(strobes, end)
            if not before or value not in rows or end - (strobe := strobes[before - 1]) >= STAYS:
                return ""
            return rows[value].name if command.levels_at(strobe - 1) == 1 else ""

        return describe


def _strobes(chip: Chip) -> tuple[str, str]:
    """Return the names of two pins: the pin that is active while a command byte is written, and the write strobe."""
    return chip.sheet.in_role("command").name, chip.sheet.in_role("write").name


def _rows(found: Spans) -> list[tuple[int, int]]:
    begins, ends = found
    return list(zip(begins.tolist(), ends.tolist(), strict=True))


def _printed(chip: Chip | None, pin: str) -> str:
    """Return a pin name as data sheets print it: in capitals, with a slash if the pin is active low."""
    text = pin.upper().replace("IO_", "I/O ").replace("_", " ")
    row = next((row for row in chip.sheet.pins if row.name == pin), None) if chip is not None else None
    return f"/{text}" if row is not None and row.active == 0 else text
