"""Timing diagrams of a bench, and a check of recorded signals against data sheet times."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from ...core.messages.calls import answering
from ...core.messages.near import hint
from ...core.time.timebase import Time, picoseconds, window
from ...errors import UnknownName, UsageError
from .picture_options import DIAGRAM, DiagramOptions
from .signals import Signals

if TYPE_CHECKING:
    from typing import Unpack

    from matplotlib.figure import Figure

    from ...core.chip import Chip
    from ...record.measuring.intervals import Interval, TimingTable
    from ...record.pictures.diagram import Diagram
    from ...record.recording.traces import Trace
    from .waveform_files import FilePath
    from .window import Between


class TimingDiagrams:
    """Diagrams and measurements of recorded signals."""

    def __init__(self, signals: Signals) -> None:
        self.signals, self.circuit = signals, signals.circuit

    @answering("timing()", "", DiagramOptions, DIAGRAM)
    def timing(
        self,
        path: FilePath,
        pins: Sequence[str | Trace] | None = None,
        start: Time | None = None,
        stop: Time | None = None,
        **options: Unpack[DiagramOptions],
    ) -> list[Interval]:
        """Draw recorded pins as a timing diagram, and return the measured times.

        Args:
            path: the file, SVG, PNG or PDF by its suffix.
            pins: names such as "x.ready", from top to bottom; the owner may be left out if only one chip has such a
                pin.  A measured trace is drawn as a separate lane.  By default all recorded pins.
            start, stop: the window; by default from the earliest instant at which all these pins are recorded, up to
                now.
            between: the times to measure and draw as arrows: pairs of edges, such as
                ("io_request falls", "ready falls 2"), or the symbol of a time in the data sheet, "t14".  The
                time of a pair ends at the next edge of the second kind after the first edge, or with a number n,
                as in "falls 2", at the n-th such edge.  A time from the data sheet is also checked against
                its data sheet limits.
            causes: pairs of edges, cause and effect, drawn as curved arrows.
            title: the title; by default the names of the chips and their part numbers.
            over: measured traces of pins, such as {"x.slew": measured.trace("slew", shift="-3 ms")}: each is drawn over
                its pin, with marks where the two differ, and a note of the trace's greatest lag relative to the pin.
            names: labels to show instead of pin names, keyed by pin name.
            decode: print the decoded characters above serial lines.
            quiet: shorten stretches of at least this length without any edge; "0 s" shortens none; by default as
                needed.
            width: "page", "phone", or a number of inches.
            dark: draw light lines on a dark background.

        Raises:
            UsageError: an unknown suffix, an edge that does not exist or is not in the window, an empty window, or a
                path that cannot be written.
            NotRecorded: nothing is recorded, or a pin is not recorded.
        """
        from ...record.pictures.picture_files import SUFFIXES, save
        from ...record.pictures.timing_diagram import draw
        from ...record.whole_file import check_suffix

        check_suffix(path, SUFFIXES)
        diagram = self._diagram(pins, start, stop, options)
        picture = draw(diagram, options["width"], options["dark"])
        save(picture, path, diagram.title, diagram.description, options["dark"])
        return list(diagram.measured)

    @answering("timing_figure()", "", DiagramOptions, DIAGRAM)
    def timing_figure(
        self,
        pins: Sequence[str | Trace] | None = None,
        start: Time | None = None,
        stop: Time | None = None,
        **options: Unpack[DiagramOptions],
    ) -> Figure:
        """Return the diagram of `timing`, as a matplotlib Figure.

        Raises:
            UsageError, NotRecorded: as for `timing`.
        """
        from ...record.pictures.timing_diagram import draw

        return draw(self._diagram(pins, start, stop, options), options["width"], options["dark"])

    def intervals(
        self, between: Iterable[Between], start: Time | None = None, stop: Time | None = None
    ) -> list[Interval]:
        """Measure times between edges of recorded pins, as `timing` does, without drawing a diagram.

        Args:
            between: pairs of edges, or symbols of the data sheet, as for `timing`.
            start, stop: the window; by default from the start of the pin recording that began last, up to now.

        Raises:
            UsageError: an edge that does not exist or is not in the window.
            NotRecorded: a pin is not recorded.
        """
        from .window import Window

        return Window(self.signals, *self.signals.window_of(self.signals.chosen(None), start, stop)).measure(between)

    def check_timing(
        self, chips: Iterable[str] | None = None, start: Time | None = None, stop: Time | None = None
    ) -> TimingTable:
        """Check the recorded pins against every time limit in the data sheets; `print` shows the result as a table.

        Args:
            chips: a list of names of chips; by default all chips.
            start, stop: the window; by default, for each pin, from the start of its recording up to now.

        Raises:
            NotRecorded: nothing is recorded.
            UsageError: `chips` is not a list of names.
            UnknownName: there is no such chip.
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

    def _diagram(
        self, pins: Sequence[str | Trace] | None, start: Time | None, stop: Time | None, options: DiagramOptions
    ) -> Diagram:
        from ...record.measuring.overlay import checked
        from ...record.pictures.diagram import Diagram
        from ...record.recording.traces import Trace
        from .window import Window

        if isinstance(pins, str | Trace):
            raise UsageError(f"pins={pins!r}: expected a list of pins, such as [{pins!r}]")
        signals, full_name = self.signals, self.signals.full_name
        chosen: list[str | Trace] = (
            [*signals.chosen(None)]
            if pins is None
            else [pin if isinstance(pin, Trace) else full_name(pin) for pin in pins]
        )
        overlaid = {full_name(name): trace for name, trace in checked(options["over"]).items()}
        names = [pin for pin in chosen if isinstance(pin, str)]
        chosen += [name for name in overlaid if name not in names]
        names += [name for name in overlaid if name not in names]
        window = Window(signals, *signals.window_of(signals.chosen(names), start, stop))
        labels = {
            name if any(isinstance(pin, Trace) and pin.name == name for pin in chosen) else full_name(name): label
            for name, label in (options["names"] or {}).items()
        }
        measured, causing = window.measure(options["between"]), window.measure(options["causes"])
        missing = [edge.split()[0] for each in (*measured, *causing) for edge in (each.start, each.end)]
        chosen += [name for name in dict.fromkeys(missing) if name not in names]
        owners = {name.partition(".")[0] for name in (*names, *missing)}
        several, decode = len(owners) > 1, options["decode"]
        lanes = [
            window.measured_lane(pin, labels.get(pin.name))
            if isinstance(pin, Trace)
            else window.lane(pin, labels.get(pin), several, decode, overlaid.get(pin))
            for pin in chosen
        ]
        cut = None if options["quiet"] is None else picoseconds(options["quiet"])
        return Diagram(options["title"] or self.circuit.title, window.start, window.stop, lanes, measured, causing, cut)
