"""Timing diagrams of a bench, and the times that data sheets print, checked on what was recorded."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from ...core.messages.near import hint
from ...core.time.timebase import Time, picoseconds
from ...errors import UnknownName, UsageError
from .recording import Recording

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...core.chip import Chip
    from ...record.measuring.intervals import Interval, TimingTable
    from ...record.pictures.diagram import Diagram
    from ...record.recording.traces import Trace
    from .recording import FilePath
    from .window import Between


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
        from ...record.pictures.pictures import SUFFIXES, save
        from ...record.pictures.timing import draw
        from ...record.whole_file import check_suffix

        check_suffix(path, SUFFIXES)
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
        from ...record.pictures.timing import draw

        return draw(self._diagram(pins, start, stop, between, causes, title, over, names, decode, quiet), width, dark)

    def intervals(
        self, between: Iterable[Between], start: Time | None = None, stop: Time | None = None
    ) -> list[Interval]:
        """Measure times between edges of recorded pins, as the arrows of `timing` do, without a picture.

        Raises:
            UsageError: an edge that is none, or is not in the window.
            NotRecorded: a pin is not recorded.
        """
        from .window import Window

        window = Window(self, *self._window_of(self._chosen(None), start, stop))
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
        from ...record.measuring.intervals import TimingTable
        from .window import Window

        self._chosen(None)
        if chips is not None and (isinstance(chips, str) or not isinstance(chips, Iterable)):
            raise UsageError(f"check_timing({chips!r}): expected a list of names of chips, such as {list(self.chips)}")
        window = Window(self, *self._window(start, stop), reach=start is None)
        found = [self._chip(name) for name in chips] if chips is not None else list(self.chips.values())
        return TimingTable(window.check(chip, limit) for chip in found for limit in chip.sheet.limits)

    def _chip(self, name: str) -> Chip:
        if not isinstance(name, str) or name not in self.chips:
            raise UnknownName(f"chip {name!r}: allowed {', '.join(self.chips)}{hint(name, self.chips)}")
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
        from ...record.measuring.overlay import checked
        from ...record.pictures.diagram import Diagram
        from .window import Window

        if isinstance(pins, str):
            raise UsageError(f"pins={pins!r}: expected a list of pins, such as [{pins!r}]")
        chosen = [self._full_name(name) for name in pins] if pins is not None else list(self._chosen(None))
        laid = {self._full_name(name): trace for name, trace in checked(over).items()}
        chosen += [name for name in laid if name not in chosen]
        window = Window(self, *self._window_of(self._chosen(chosen), start, stop))
        labels = {self._full_name(name): label for name, label in (names or {}).items()}
        measured, causing = window.measure(between), window.measure(causes)
        missing = [edge.split()[0] for each in (*measured, *causing) for edge in (each.start, each.end)]
        chosen += [name for name in dict.fromkeys(missing) if name not in chosen]
        owners = {name.partition(".")[0] for name in chosen}
        lanes = [window.lane(name, labels.get(name), len(owners) > 1, decode, laid.get(name)) for name in chosen]
        cut = None if quiet is None else picoseconds(quiet)
        return Diagram(title or self._named(), window.start, window.stop, lanes, measured, causing, cut)
