"""Timing diagrams of a bench, and the times that data sheets print, checked on what was recorded."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING

from ..core.channel import HostPort, SerialLine
from ..core.chip import Chip
from ..core.serial import RS232, Word, bit_clock
from ..core.table import Limit
from ..core.timebase import Time, picoseconds
from ..errors import NotRecorded, UnknownName, UsageError
from ..record.intervals import Bound, Checked, Edge, Interval, Signal, TimingTable, intervals
from .recording import FilePath, Recording

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..record.diagram import Diagram, Lane
    from ..record.diagram import Word as Written
    from ..record.intervals import Spans
    from ..record.traces import Trace

Between = str | tuple[str, str]
STAYS = 1_000_000  # ps: so long, at most, a word stays on the bus behind the strobe that has written it


class TimingDiagrams(Recording):
    """The timing half of a bench."""

    def timing(
        self,
        path: FilePath,
        pins: Sequence[str] | None = None,
        start: Time | None = None,
        stop: Time | None = None,
        *,
        between: Iterable[Between] = (),
        causes: Iterable[tuple[str, str]] = (),
        title: str | None = None,
        over: Mapping[str, Trace] | None = None,
        names: Mapping[str, str] | None = None,
        decode: bool = False,
        quiet: Time | None = None,
        width: str | float = "page",
        dark: bool = False,
    ) -> list[Interval]:
        """Draw recorded pins as a timing diagram (SVG, PNG or PDF), and return the times of its arrows.

        Args:
            pins: from top to bottom, "x.ready"; the owner may be left out where only one chip has such a pin.
            start: of the window; and its `stop`.
            between: what to measure: pairs of edges, ("io_request falls", "ready falls 2"), or the symbol of a time of
                the data sheet, "t14".  The second edge of a pair is the first such one behind the first; a number asks
                for a later one.  A time that the sheet prints limits of is checked against them.
            causes: pairs of edges, the second brought about by the first: curved arrows.
            over: what was measured of pins, such as {"x.slew": measured.trace("slew", shift="-3 ms")}: it is drawn over
                them, stretches in which the two differ are marked, and how late it comes at most is told.
            names: what to write beside pins instead of their names.
            decode: write the characters over serial lines.
            quiet: cut stretches without any edge short from this length on; "0 s": none; by default as it fits.
            width: "page", "phone", or inches.

        Raises:
            UsageError: an unknown suffix, an edge that is none or is not in the window, an empty window, a path that
                cannot be written.
            NotRecorded: nothing is recorded, or not this pin.
        """
        from ..record.pictures import check_suffix, save
        from ..record.timing import draw

        check_suffix(path)
        diagram = self._diagram(pins, start, stop, between, causes, title, over, names, decode, quiet)
        save(draw(diagram, width, dark), path, diagram.title, diagram.description, dark)
        return list(diagram.measured)

    def timing_figure(
        self,
        pins: Sequence[str] | None = None,
        start: Time | None = None,
        stop: Time | None = None,
        *,
        between: Iterable[Between] = (),
        causes: Iterable[tuple[str, str]] = (),
        title: str | None = None,
        over: Mapping[str, Trace] | None = None,
        names: Mapping[str, str] | None = None,
        decode: bool = False,
        quiet: Time | None = None,
        width: str | float = "page",
        dark: bool = False,
    ) -> Figure:
        """Return the picture that `timing` writes as a matplotlib Figure.

        Raises:
            UsageError, NotRecorded: as `timing`.
        """
        from ..record.timing import draw

        return draw(self._diagram(pins, start, stop, between, causes, title, over, names, decode, quiet), width, dark)

    def intervals(
        self, between: Iterable[Between], start: Time | None = None, stop: Time | None = None
    ) -> list[Interval]:
        """Measure times between edges of recorded pins, as the arrows of `timing` do, without a picture.

        Raises:
            UsageError: an edge that is none, or is not in the window.
            NotRecorded: a pin is not recorded.
        """
        window = _Window(self, *self._window_of(self._chosen(None), start, stop))
        return window.measure(between)

    def check_timing(
        self, chips: Iterable[str] | None = None, start: Time | None = None, stop: Time | None = None
    ) -> TimingTable:
        """Check every time that the data sheets print on what was recorded; `print` shows it as a table.

        Args:
            chips: names; all chips by default.
            start: of the window, by default as far back as the pins were recorded; and its `stop`.

        Raises:
            NotRecorded: nothing is recorded.
        """
        self._chosen(None)
        if chips is not None and (isinstance(chips, str) or not isinstance(chips, Iterable)):
            raise UsageError(f"check_timing({chips!r}): expected a list of names of chips, such as {list(self.chips)}")
        window = _Window(self, *self._window(start, stop), reach=start is None)
        found = [self._chip(name) for name in chips] if chips is not None else list(self.chips.values())
        return TimingTable(window.check(chip, limit) for chip in found for limit in chip.sheet.limits)

    def _chip(self, name: str) -> Chip:
        if not isinstance(name, str) or name not in self.chips:
            raise UnknownName(f"chip {name!r}: allowed {', '.join(self.chips)}")
        return self.chips[name]

    def _diagram(
        self,
        pins: Sequence[str] | None,
        start: Time | None,
        stop: Time | None,
        between: Iterable[Between],
        causes: Iterable[tuple[str, str]],
        title: str | None,
        over: Mapping[str, Trace] | None,
        names: Mapping[str, str] | None,
        decode: bool,
        quiet: Time | None,
    ) -> Diagram:
        from ..record.diagram import Diagram
        from ..record.overlay import checked

        if isinstance(pins, str):
            raise UsageError(f"pins={pins!r}: expected a list of pins, such as [{pins!r}]")
        chosen = [self._full_name(name) for name in pins] if pins is not None else list(self._chosen(None))
        laid = {self._full_name(name): trace for name, trace in checked(over).items()}
        chosen += [name for name in laid if name not in chosen]
        window = _Window(self, *self._window_of(self._chosen(chosen), start, stop))
        labels = {self._full_name(name): label for name, label in (names or {}).items()}
        measured, causing = window.measure(between), window.measure(causes)
        missing = [edge.split()[0] for each in (*measured, *causing) for edge in (each.start, each.end)]
        chosen += [name for name in dict.fromkeys(missing) if name not in chosen]
        owners = {name.partition(".")[0] for name in chosen}
        lanes = [window.lane(name, labels.get(name), len(owners) > 1, decode, laid.get(name)) for name in chosen]
        cut = None if quiet is None else picoseconds(quiet)
        return Diagram(title or self._named(), window.start, window.stop, lanes, measured, causing, cut)

    def _full_name(self, name: str) -> str:
        """Return the full name of a recorded pin; the owner may be missing where only one has such a pin.

        Raises:
            UsageError: several have.
            NotRecorded: it is not recorded.
        """
        if not isinstance(name, str) or "." in name or not name:
            self._chosen([name])
            return name
        found = [full for full in self._chosen(None) if full.partition(".")[2] == name]
        if len(found) > 1:
            raise UsageError(f"pin {name!r}: there are {' and '.join(found)}; write one of them")
        if not found:
            owners = list(self.chips)
            full = f"{owners[0]}.{name}" if len(owners) == 1 else name
            self._chosen([full])  # says what is wrong
        return found[0]


class _Window:
    """What was recorded in a window (ps); `reach`: a signal begins where its recording does, if that is later."""

    def __init__(self, bench: TimingDiagrams, start: int, stop: int, *, reach: bool = False) -> None:
        self.bench, self.start, self.stop, self.reach = bench, start, stop, reach
        self.signal = cache(self._signal)
        self.found = cache(self._found)

    def _signal(self, name: str) -> Signal:
        """What a pin or bus did, by its full name."""
        probe, recorder = self.bench._chosen([name])[name], self.bench.recorder
        since = max(self.start, recorder.since(probe)) if self.reach else self.start
        return Signal.of(probe, recorder, since, self.stop)

    def _found(self, chip: Chip, limit: Limit) -> Spans:
        """Begin and end of every interval that a limit is about (ps)."""
        return intervals(limit, lambda pin: self.signal(f"{chip.name}.{pin}"))

    def check(self, chip: Chip, limit: Limit) -> Checked:
        """What a limit's intervals say of it, or which pin is not recorded."""
        bound = Bound.of(limit, chip.crystal_hz)
        for pin in (limit.start.split()[0], limit.end.split()[0], *(pin for pin, _ in (*limit.given, *limit.before))):
            try:
                self.signal(f"{chip.name}.{pin}")
            except NotRecorded:
                return Checked(chip.name, bound, missing=pin)
        return Checked.of(chip.name, bound, *self.found(chip, limit))

    # ---------------------------------------------------------------------------------------------------------- arrows
    def measure(self, between: Iterable[Between]) -> list[Interval]:
        """The times of pairs of edges, and of symbols."""
        if isinstance(between, str) or not isinstance(between, Iterable):
            raise UsageError(f"between={between!r}: expected a list of pairs of edges, or of symbols such as 't14'")
        return [interval for each in between for interval in self._measured(each)]

    def _measured(self, between: Between) -> Iterator[Interval]:
        if isinstance(between, str):
            yield from self._named(between)
            return
        if not isinstance(between, Sequence) or len(between) != 2:
            raise UsageError(f"between {between!r}: expected two edges, or the symbol of a printed time")
        first, second = (Edge.read(text) for text in between)
        first, second = (edge._replace(pin=self.bench._full_name(edge.pin)) for edge in (first, second))
        begin = first.find(self.signal(first.pin), self.start, include=True)
        end = None if begin is None else second.find(self.signal(second.pin), begin, include=first.pin != second.pin)
        if begin is None or end is None:
            which = between[0] if begin is None else f"{between[1]} behind {between[0]}"
            raise UsageError(f"between {between!r}: there is no {which} in the window")
        yield self._interval(first, second, begin, end)

    def _interval(self, first: Edge, second: Edge, begin: int, end: int) -> Interval:
        """An interval with the printed limits that are about these two edges."""
        bounds = []
        owner, _, pin = first.pin.partition(".")
        chip = self.bench.chips.get(owner)
        if chip is not None and second.pin.startswith(f"{owner}."):
            for limit in chip.sheet.limits:
                if (limit.start.split()[0], limit.end.split()[0]) != (pin, second.pin.partition(".")[2]):
                    continue
                if not self.check(chip, limit).missing and (begin, end) in _rows(self.found(chip, limit)):
                    bounds.append(Bound.of(limit, chip.crystal_hz))
        return Interval(f"{first.pin} {first.change}", f"{second.pin} {second.change}", begin, end, tuple(bounds))

    def _named(self, symbol: str) -> Iterator[Interval]:
        """Of each printed time of this symbol that was recorded, the interval that is nearest to its limit."""
        limits = [(chip, limit) for chip in self.bench.chips.values() for limit in chip.sheet.limits]
        named = [(chip, limit) for chip, limit in limits if limit.symbol == symbol]
        if not named:
            known = ", ".join(dict.fromkeys(limit.symbol for _, limit in limits if limit.symbol))
            raise UsageError(f"between {symbol!r}: no such time is printed; the symbols: {known or 'none'}")
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
            raise UsageError(f"between {symbol!r}: it does not occur in the window, or its pins are not recorded")

    # ----------------------------------------------------------------------------------------------------------- lanes
    def lane(self, name: str, label: str | None, several: bool, decode: bool, over: Trace | None) -> Lane:
        """A pin or bus as a lane, and what is laid over it; `several`: the owner's name stands before it."""
        from ..record.diagram import Lane
        from ..record.overlay import fitting

        owner, _, pin = name.partition(".")
        chip = self.bench.chips.get(owner)
        if label is None:
            label = (f"{owner}: " if several else "") + _printed(chip, pin)
        signal = self.signal(name)
        line = chip.pins.get(pin) if chip is not None and decode else None
        serial = line is not None and line.row.role in ("serial_in", "serial_out")
        words = self._characters(chip, name) if chip is not None and serial else []
        return Lane(
            name, label, signal, words, self._meaning(chip) if signal.bus else None, fitting(name, signal.bus, over)
        )

    def _characters(self, chip: Chip, name: str) -> list[Written]:
        """The characters on a serial line, also those that only begin or end in the window."""
        from ..record.characters import characters, shown
        from ..record.diagram import Word as Written

        port, baud = chip.sheet.channel(SerialLine), getattr(chip, "baud", 0)
        if port is None or not baud:
            return []
        word, clock = Word(port.bits, port.parity, port.stop), bit_clock(baud, chip.name)
        probe, recorder = self.bench._chosen([name])[name], self.bench.recorder
        stop = min(self.stop + clock.ps(word.ticks), self.bench.kernel.now)
        whole = Signal.of(probe, recorder, recorder.since(probe), stop)
        found = characters(whole, stop, clock, word, RS232)
        return [
            Written(c.start_ps, c.end_ps, shown(c.byte), not c.good)
            for c in found
            if c.end_ps > self.start and c.start_ps < self.stop
        ]

    def _meaning(self, chip: Chip | None) -> Callable[[int, int], str]:
        """What a value of the bus means: a character, or the command that is written."""
        if chip is None or chip.sheet.channel(HostPort) is None:
            return lambda value, _end: f"'{chr(value)}'" if 32 < value < 127 else "CR" if value == 13 else ""
        try:
            command, write = (self.signal(f"{chip.name}.{pin}") for pin in _strobes(chip))
        except NotRecorded:
            return lambda _value, _end: ""
        rows, strobes = chip.sheet.commands.by_code, write.edges("rises")

        def says(value: int, end: int) -> str:
            before = bisect_right(strobes, end)
            if not before or value not in rows or end - (strobe := strobes[before - 1]) >= STAYS:
                return ""
            return rows[value].name if command.level_at(strobe - 1) == 1 else ""

        return says


def _strobes(chip: Chip) -> tuple[str, str]:
    """The pins that say that a command is on the bus, and that it is written."""
    command, write = chip.sheet.role("command"), chip.sheet.role("write")
    assert command is not None and write is not None  # a host port has both
    return command.name, write.name


def _rows(found: Spans) -> list[tuple[int, int]]:
    begins, ends = found
    return list(zip(begins.tolist(), ends.tolist(), strict=True))


def _printed(chip: Chip | None, pin: str) -> str:
    """A pin as data sheets write it: in capitals, a slash before what is active low."""
    text = pin.upper().replace("IO_", "I/O ").replace("_", " ")
    row = next((row for row in chip.sheet.pins if row.name == pin), None) if chip is not None else None
    return f"/{text}" if row is not None and row.active == 0 else text
