"""Timing diagrams of a bench, and the times that data sheets print, checked on what was recorded."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...core.messages.near import hint
from ...core.time.timebase import Time, picoseconds, window
from ...errors import UnknownName, UsageError
from .signals import Signals

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...core.chip import Chip
    from ...record.measuring.intervals import Interval, TimingTable
    from ...record.pictures.diagram import Diagram
    from ...record.recording.traces import Trace
    from .waveforms import FilePath
    from .window import Between


@dataclass(frozen=True, slots=True)
class DiagramOptions:
    """What a timing diagram is to show: arguments of `bench.timing`."""

    pins: Sequence[str] | None
    start: Time | None
    stop: Time | None
    between: Iterable[Between]
    causes: Iterable[tuple[str, str]]
    title: str | None
    over: Mapping[str, Trace] | None
    names: Mapping[str, str] | None
    decode: bool
    quiet: Time | None


class TimingDiagrams:
    """What draws and measures recorded signals."""

    def __init__(self, signals: Signals) -> None:
        self.signals, self.circuit = signals, signals.circuit

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
                the data sheet, "t14".  The second edge of a pair is the first such one after the first; a number asks
                for a later one.  A time that the sheet prints limits of is checked against them.
            causes: pairs of edges, the second brought about by the first: curved arrows.
            over: what was measured of pins, such as {"x.slew": measured.trace("slew", shift="-3 ms")}: it is drawn over
                them, stretches in which the two differ are marked, and its greatest lag is noted.
            names: labels of pins instead of their names.
            decode: write the characters over serial lines.
            quiet: cut stretches without any edge short from this length on; "0 s": none; by default as it fits.
            width: "page", "phone", or inches.

        Raises:
            UsageError: an unknown suffix, an edge that is none or is not in the window, an empty window, a path that
                cannot be written.
            NotRecorded: nothing is recorded, or not this pin.
        """
        from ...record.pictures.pictures import SUFFIXES, save
        from ...record.pictures.timing import draw
        from ...record.whole_file import check_suffix

        check_suffix(path, SUFFIXES)
        diagram = self._diagram(DiagramOptions(pins, start, stop, between, causes, title, over, names, decode, quiet))
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
        from ...record.pictures.timing import draw

        options = DiagramOptions(pins, start, stop, between, causes, title, over, names, decode, quiet)
        return draw(self._diagram(options), width, dark)

    def intervals(
        self, between: Iterable[Between], start: Time | None = None, stop: Time | None = None
    ) -> list[Interval]:
        """Measure times between edges of recorded pins, as the arrows of `timing` do, without a picture.

        Raises:
            UsageError: an edge that is none, or is not in the window.
            NotRecorded: a pin is not recorded.
        """
        from .window import Window

        return Window(self.signals, *self.signals.window_of(self.signals.chosen(None), start, stop)).measure(between)

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
        from ...record.measuring.intervals import TimingTable
        from .window import Window

        self.signals.chosen(None)
        if chips is not None and (isinstance(chips, str) or not isinstance(chips, Iterable)):
            known = list(self.circuit.chips)
            raise UsageError(f"check_timing({chips!r}): expected a list of names of chips, such as {known}")
        recorded = Window(self.signals, *window(start, stop, self.circuit.kernel.now), reach=start is None)
        found = [self._chip(name) for name in chips] if chips is not None else list(self.circuit.chips.values())
        return TimingTable(recorded.check(chip, limit) for chip in found for limit in chip.sheet.limits)

    def _chip(self, name: str) -> Chip:
        if not isinstance(name, str) or name not in self.circuit.chips:
            raise UnknownName(f"chip {name!r}: allowed {', '.join(self.circuit.chips)}{hint(name, self.circuit.chips)}")
        return self.circuit.chips[name]

    def _diagram(self, options: DiagramOptions) -> Diagram:
        from ...record.measuring.overlay import checked
        from ...record.pictures.diagram import Diagram
        from .window import Window

        if isinstance(options.pins, str):
            raise UsageError(f"pins={options.pins!r}: expected a list of pins, such as [{options.pins!r}]")
        signals, full_name = self.signals, self.signals.full_name
        chosen = list(signals.chosen(None)) if options.pins is None else [full_name(name) for name in options.pins]
        laid = {full_name(name): trace for name, trace in checked(options.over).items()}
        chosen += [name for name in laid if name not in chosen]
        window = Window(signals, *signals.window_of(signals.chosen(chosen), options.start, options.stop))
        labels = {full_name(name): label for name, label in (options.names or {}).items()}
        measured, causing = window.measure(options.between), window.measure(options.causes)
        missing = [edge.split()[0] for each in (*measured, *causing) for edge in (each.start, each.end)]
        chosen += [name for name in dict.fromkeys(missing) if name not in chosen]
        owners = {name.partition(".")[0] for name in chosen}
        several, decode = len(owners) > 1, options.decode
        lanes = [window.lane(name, labels.get(name), several, decode, laid.get(name)) for name in chosen]
        cut = None if options.quiet is None else picoseconds(options.quiet)
        return Diagram(options.title or self.circuit.title, window.start, window.stop, lanes, measured, causing, cut)
