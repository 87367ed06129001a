"""Pictures of a bench: what its axes did, and its pins; drawn, written into files, and read off at cursors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..core.axis import Mark
from ..core.chip import Chip, OneAxis
from ..core.timebase import Time, moment, picoseconds, readable
from ..errors import UnknownName, UsageError
from .recording import FilePath, Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..record.cursors import Readings
    from ..record.figures import Contents
    from ..record.lanes import Trace
    from ..record.panels import Track

AROUND = 20  # so much of the motion is shown before and after it: 1/20
TOLD = 3  # values of a parameter that are told, of motions in which it differs
MOST_PHASED = 100  # motions, above which their phases would be narrower than their names
MOST_NOTES = 4  # lines of parameters


class Drawing(Recording):
    """The drawing half of a bench."""

    def figure(
        self,
        title: str | None = None,
        pins: Sequence[str | Trace] | None = None,
        start: Time | None = None,
        stop: Time | None = None,
        *,
        axes: Sequence[int | str] | int | str | None = None,
        runs: Mapping[str, Drawing] | None = None,
        ideal: bool = False,
        cursors: Iterable[Time] = (),
        dark: bool = False,
        width: str | float = "page",
        ax: Axes | Sequence[Axes] | None = None,
        marks: bool = True,
    ) -> Figure:
        """Draw the motions of the axes, and recorded pins below; return a matplotlib Figure.

        Velocity and position share one column of panels, whatever the number of axes; of parts that have them,
        acceleration and jerk as well.  An axis that does not move is left out when others do.

        Args:
            title: by default the chips and their parts.
            pins: recorded pins, or traces of a file; all that are recorded by default, [] for none.
            start, stop: the window; by default the motion, and a twentieth of it before and after.
            axes: which axes: numbers from 1 on, names of chips, or names such as "x axis 2"; by default all.
            runs: further benches by the name that the picture gives them, each laid over this one, its motion
                beginning with this one's; `start` and `stop` then count from there.
            ideal: lay the ideal of each motion over it, as far as the part defines one, and tell the difference.
            cursors: instants that are marked by numbered lines; `readings` has the values there.
            dark: light on dark.
            width: "page", "phone", or inches.
            ax: draw into these axes of matplotlib, one for each panel, or into a single one for the first panel.
            marks: flag commands, findings, limits and home above the panels.

        Raises:
            UsageError: nothing to draw, an unknown width, too few axes for the panels, or no matplotlib.
            UnknownName: no such axis, or no chip on the bench.
            NotRecorded: a pin that is not recorded.
        """
        from ..record.figures import figure

        contents = self._contents(title, pins, start, stop, axes, runs, ideal, cursors, marks)
        return figure(contents, width=width, dark=dark, ax=ax)

    def plot(
        self,
        path: FilePath,
        title: str | None = None,
        pins: Sequence[str | Trace] | None = None,
        start: Time | None = None,
        stop: Time | None = None,
        *,
        axes: Sequence[int | str] | int | str | None = None,
        runs: Mapping[str, Drawing] | None = None,
        ideal: bool = False,
        cursors: Iterable[Time] = (),
        dark: bool = False,
        width: str | float = "page",
        marks: bool = True,
    ) -> None:
        """Draw as `figure` does, into a file: SVG, PNG or PDF, as its suffix says.  The same run gives the same bytes.

        Raises:
            UsageError: as `figure`, and for an unknown suffix or a path that cannot be written.
        """
        from ..record.figures import description_of, figure
        from ..record.pictures import check_suffix, save

        check_suffix(path)
        contents = self._contents(title, pins, start, stop, axes, runs, ideal, cursors, marks)
        picture = figure(contents, width=width, dark=dark)
        save(picture, path, contents.title, description_of(picture), dark)

    def readings(
        self,
        at: Iterable[Time],
        pins: Sequence[str] | None = None,
        axes: Sequence[int | str] | int | str | None = None,
    ) -> Readings:
        """Return what every axis and every recorded pin is at some instants, and the differences between neighbours.

        Print it for a table; its `rows` are the same as data.

        Raises:
            UsageError: an instant is still to come, or there is none.
        """
        from ..record.cursors import readings

        instants = self._instants(at)
        if not instants:
            raise UsageError('readings: no instant; give some, such as bench.readings(["10 ms", "20 ms"])')
        nets = dict(self.recorded) if pins is None else self._chosen(pins)
        tracks = [(self._name_of(axis), axis.quantities()) for axis in self._axes(axes)]
        return readings(instants, tracks, [(name, net, self.recorder) for name, net in nets.items()])

    # ------------------------------------------------------------------------------------------------- what is shown
    def _contents(
        self,
        title: str | None,
        pins: Sequence[str | Trace] | None,
        start: Time | None,
        stop: Time | None,
        axes: Sequence[int | str] | int | str | None,
        runs: Mapping[str, Drawing] | None,
        ideal: bool,
        cursors: Iterable[Time],
        marks: bool,
    ) -> Contents:
        from ..record.figures import Contents

        if not self.chips:
            raise UnknownName("the bench has no chip to plot")
        benches: list[tuple[str, Drawing]] = [("", self)]
        if runs:
            benches = [*runs.items()] if self in runs.values() else [("this run", self), *runs.items()]
        begins = {name: (bench._motion(bench._axes(axes)) or (0, 0))[0] if runs else 0 for name, bench in benches}
        first, last = self._picture(axes, pins, start, stop, benches, begins)
        tracks: list[Track] = []
        for name, bench in benches:
            tracks += bench._tracks(axes, name, begins[name], first, last, ideal)
        zero = next(begins[name] for name, bench in benches if bench is self)
        return Contents(
            title or self._named(),
            tracks,
            self._traces(pins, first, last, zero),
            first,
            last,
            notes=[*self._notes(tracks), *differences(tracks)],
            cursors=[picoseconds(cursor) for cursor in cursors],
            zero_is="from the begin of the motion on" if runs else "",
            marks=marks,
        )

    def _named(self) -> str:
        """The chips and their parts."""
        parts = [(chip.name, chip.sheet.part.upper()) for chip in self.chips.values()]
        return parts[0][1] if len(parts) == 1 else ", ".join(f"{name}: {part}" for name, part in parts)

    def _picture(
        self,
        axes: Any,
        pins: Sequence[str | Trace] | None,
        start: Time | None,
        stop: Time | None,
        benches: Sequence[tuple[str, Drawing]],
        begins: Mapping[str, int],
    ) -> tuple[int, int]:
        """The window of a picture, in ps of the picture: the motion, unless it is told otherwise."""
        longest = max(bench.kernel.now - begins[name] for name, bench in benches)
        first = None if start is None else moment(start)
        last = None if stop is None else min(moment(stop), longest)
        if first is None or last is None:
            moved = [(bench._motion(bench._axes(axes)), begins[name]) for name, bench in benches]
            spans = [(span[0] - zero, span[1] - zero) for span, zero in moved if span is not None]
            if not spans and (edges := self._activity(pins)) is not None:
                spans = [edges]
            begin = min((span[0] for span in spans), default=0)
            end = max((span[1] for span in spans), default=longest)
            around = max((end - begin) // AROUND, 1)
            earliest = -min(begins.values())
            loaded = max(
                (bench._loaded(axes, begin + begins[name]) - begins[name] for name, bench in benches), default=0
            )
            first = max(begin - around, earliest, loaded) if first is None else first
            last = min(end + around, longest) if last is None else last
        if last <= first:
            raise UsageError(
                f"nothing to draw from {readable(first)} to {readable(last)}; let time pass with bench.run() before, "
                "or give start and stop that lie in the past"
            )
        return first, last

    def _motion(self, axes: Sequence[OneAxis]) -> tuple[int, int] | None:
        """The first and the last instant (ps) at which one of the axes moves; None: none does."""
        spans = [span for axis in axes if (span := moving_from_to(axis, 0, self.kernel.now)) is not None]
        return (min(begin for begin, _ in spans), max(end for _, end in spans)) if spans else None

    def _loaded(self, axes: Any, before: int) -> int:
        """When a position register was loaded last before an instant (ps): what it held until then is not shown."""
        return max(
            (since for axis in self._axes(axes) for since, _ in axis.motor.offsets if since <= before), default=0
        )

    def _activity(self, pins: Sequence[str | Trace] | None) -> tuple[int, int] | None:
        """The first and the last edge of the pins that are shown; None: there is none."""
        first, last = self.kernel.now, -1
        for trace in self._traces(pins, 0, self.kernel.now, 0):
            if len(trace.times_ps):
                first, last = min(first, int(trace.times_ps[0])), max(last, int(trace.times_ps[-1]))
        return (first, last) if last >= first else None

    def _axes(self, axes: Sequence[int | str] | int | str | None) -> list[OneAxis]:
        """The axes that are asked for; all of them by default."""
        all_of_them = [(n, axis) for _, n, axis in self._chip_axes()]
        if axes is None:
            return [axis for _, axis in all_of_them]
        wanted = [axes] if isinstance(axes, int | str) else list(axes)
        found: list[OneAxis] = []
        for one in wanted:
            fits = [axis for n, axis in all_of_them if one in (n, axis.name, self._chip_of(axis).name)]
            if not fits or isinstance(one, bool):
                names = ", ".join(axis.name for _, axis in all_of_them)
                raise UnknownName(f"axes: no axis {one!r}; there are {names}, and numbers from 1 on")
            found += [axis for axis in fits if axis not in found]
        return found

    def _chip_of(self, axis: OneAxis) -> Chip:
        return axis if isinstance(axis, Chip) else axis.chip  # type: ignore[attr-defined]

    def _name_of(self, axis: OneAxis) -> str:
        """An axis as the legend names it: with its chip, if there are several."""
        chip = self._chip_of(axis)
        number = getattr(axis, "number", None)
        if number is None or chip.sheet.axes == 1:
            return chip.name
        return f"axis {number}" if len(self.chips) == 1 else f"{chip.name} axis {number}"

    def _tracks(self, axes: Any, run: str, zero: int, start: int, stop: int, ideal: bool) -> list[Track]:
        """What the axes did in a window of the picture, those that move; one, if none does."""
        first, last = max(start + zero, 0), min(stop + zero, self.kernel.now)
        chosen = self._axes(axes)
        if axes is None:
            chosen = [axis for axis in chosen if any(axis.motor.played(first, last))] or chosen[:1]
        tracks = [self._track(axis, zero, first, last, ideal) for axis in chosen]
        if not run:
            return tracks
        return [replace(track, name=f"{run}, {track.name}" if len(tracks) > 1 else run) for track in tracks]

    def _track(self, axis: OneAxis, zero: int, first: int, last: int, ideal: bool) -> Track:
        from ..record.panels import Track

        motions = axis.motions(first, last)
        if any(axis.motor.played(first + 1, motions[0].time_ps if motions else last)):  # the one before was under way
            motions = [motion for motion in axis.motions(0, first) if motion.time_ps < first][-1:] + motions
        ideals = ((motion, motion.ideal) for motion in motions) if ideal else ()
        return Track(
            self._name_of(axis),
            axis.quantities(),
            motions,
            [*axis.marks(first, last), *self._findings(self._chip_of(axis), first, last)],
            axis.phases(first, last) if len(motions) <= MOST_PHASED else (),
            [(law, axis.deviation(motion)) for motion, law in ideals if law is not None],
            zero,
            self.kernel.now,
        )

    def _findings(self, chip: Chip, first: int, last: int) -> list[Mark]:
        return [Mark(f.time_ps, "finding", f.code) for f in chip.findings if first <= f.time_ps <= last]

    def _traces(self, pins: Sequence[str | Trace] | None, first: int, last: int, zero: int) -> list[Trace]:
        """What the pins did in a window of the picture; names without their chip, if there is but one."""
        from ..record.lanes import Trace

        found: list[Trace] = []
        for pin in self.recorded if pins is None else pins:
            if isinstance(pin, Trace):
                found.append(pin.shifted(-zero).within(first, last))
                continue
            net = self._chosen([pin])[pin]
            begin = max(first + zero, self.recorder.since(net))
            name = pin.partition(".")[2] if len(self.chips) == 1 else pin
            found.append(Trace.of(name or pin, net, self.recorder, begin, max(last + zero, begin)).shifted(-zero))
        return found

    # --------------------------------------------------------------------------------------------------- what is told
    def _notes(self, tracks: Sequence[Track]) -> Iterator[str]:
        """Lines that tell with which parameters the axes moved."""
        words = {row.form: row.name for chip in self.chips.values() for row in chip.sheet.commands}
        lines = {track.name: told(track, words) for track in tracks}
        if len({*lines.values()}) == 1:
            lines = {"": next(iter(lines.values()))}
        for name, line in [*lines.items()][:MOST_NOTES]:
            if line:
                yield f"{name}: {line}" if name else line

    def _instants(self, times: Iterable[Time]) -> list[int]:
        instants = [moment(time) for time in ([times] if isinstance(times, str) else times)]
        for time, instant in zip([*times], instants, strict=False):
            if instant > self.kernel.now:
                raise UsageError(f"{time!r} is still to come; it is {readable(self.kernel.now)}")
        return instants


def moving_from_to(axis: OneAxis, start: int, stop: int) -> tuple[int, int] | None:
    """Return the first and the last instant of a window at which an axis moves; None: it makes no step there."""
    played = [(train, a, b) for _, train, a, b in axis.motor.played(start, stop)]
    if not played:
        return None
    train, a, _ = played[0]
    begin = max(train.clock.ps(train.begin(a) if a else train.origin), start)
    train, _, b = played[-1]
    last = train.clock.ps(train.begin(b - 1))
    times, values = axis.quantities()[0].outline(last, stop, 100)
    rests = times[values == 0]
    return begin, int(rests[0]) if len(rests) else stop


def differences(tracks: Sequence[Track]) -> Iterator[str]:
    """Yield what the ideals that are laid over tell: how far the motions of a track leave them at most."""
    from ..record.style import few

    for track in tracks:
        if track.ideals:
            position = max(abs(deviation.position) for _, deviation in track.ideals)
            velocity = max(abs(deviation.velocity) for _, deviation in track.ideals)
            whose = f"{track.name}: d" if len(tracks) > 1 else "D"
            steps = f"{few(position)} step{'s' * (position != 1)}"
            yield f"{whose}otted: the ideal; position within {steps}, velocity within {few(velocity)} steps/s"


def told(track: Track, words: Mapping[str, str]) -> str:
    """Return the parameters of the motions of a track: "slope S = 240, number N = 300, 500"."""
    from ..record.style import grouped

    values: dict[str, list[str]] = {}
    for notes in {id(motion.notes): motion.notes for motion in track.motions}.values():  # motions may share them
        for name, value in notes.items():
            text = grouped(value)
            if text not in values.setdefault(name, []):
                values[name].append(text)
    parts = []
    for name, texts in values.items():
        word = words.get(name, name)
        called = f"{word.lower().replace('_', ' ')} {name}" if word != name else name
        shown = ", ".join(texts[:TOLD]) + (" …" if len(texts) > TOLD else "")
        parts.append(f"{called} = {shown}")
    return "; ".join(parts) if any("," in part for part in parts) else ", ".join(parts)
