"""Pictures of a bench: what its axes did, and its pins; drawn, written into files, and read off at cursors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ...core.chip import Chip
from ...core.messages.calls import answering
from ...core.messages.near import hint
from ...core.motion.axis import Steps
from ...core.motion.motions import Mark
from ...core.motion.one_axis import OneAxis
from ...core.time.timebase import Time, moment, readable
from ...errors import UnknownName, UsageError
from ...parts.base.part import Part
from .curves import Chosen, chosen
from .motions import first_step, moving_from_to
from .recording import Recording
from .told import differences, moments_of, told, without_rest, words_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ...record.pictures.cursors import Readings
    from ...record.pictures.figures import Contents
    from ...record.pictures.tracks import Track
    from ...record.recording.traces import Trace
    from .recording import FilePath

AROUND = 20  # so much of the motion is shown before and after it: 1/20
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
        parts: Sequence[str] | str | None = None,
        runs: Mapping[str, Drawing | Steps] | None = None,
        over: Mapping[str, Trace] | None = None,
        ideal: bool = False,
        cursors: Time | Iterable[Time] = (),
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
            parts: whose quantities are drawn, too: names of parts, or of single quantities such as "driver.current"; by
                default those of all parts around the chips, as far as they change; [] for none.
            runs: further benches by the name that the picture gives them, each laid over this one, its motion
                beginning with this one's; `start` and `stop` then count from there.  Measured steps as well, such as
                `read_vcd(path).steps("pulse")`, their first one at the instant of this bench's first one.
            over: what was measured of pins, such as {"x.slew": measured.trace("slew", shift="-3 ms")}: it is drawn over
                them, stretches in which the two differ are marked, and how late it comes at most is told.
            ideal: lay the ideal of each motion over it, as far as the part defines one, and tell the difference.
            cursors: instants that are marked by numbered lines; `readings` has the values there.
            dark: light on dark.
            width: "page", "phone", or inches.
            ax: draw into these axes of matplotlib, one for each panel, or into a single one for the first panel.
            marks: flag commands, findings, limits and home above the panels.

        Raises:
            UsageError: nothing to draw, an unknown width, too few axes for the panels, or no matplotlib.
            UnknownName: no such axis or part, or no chip on the bench.
            NotRecorded: a pin that is not recorded.
        """
        from ...record.pictures.figures import figure

        contents = self._contents(title, pins, start, stop, axes, parts, runs, over, ideal, cursors, marks)
        return figure(contents, width=width, dark=dark, ax=ax)

    @answering("plot()", '; width is "page", "phone" or inches')
    def plot(
        self,
        path: FilePath,
        title: str | None = None,
        pins: Sequence[str | Trace] | None = None,
        start: Time | None = None,
        stop: Time | None = None,
        *,
        axes: Sequence[int | str] | int | str | None = None,
        parts: Sequence[str] | str | None = None,
        runs: Mapping[str, Drawing | Steps] | None = None,
        over: Mapping[str, Trace] | None = None,
        ideal: bool = False,
        cursors: Time | Iterable[Time] = (),
        dark: bool = False,
        width: str | float = "page",
        marks: bool = True,
    ) -> None:
        """Draw as `figure` does, into a file: SVG, PNG or PDF, as its suffix says.  The same run gives the same bytes.

        Raises:
            UsageError: an unknown suffix, a path that cannot be written, or as `figure`.
            UnknownName, NotRecorded: as `figure`.
        """
        from ...record.pictures.figures import description_of, figure
        from ...record.pictures.pictures import SUFFIXES, save
        from ...record.whole_file import check_suffix

        check_suffix(path, SUFFIXES)
        contents = self._contents(title, pins, start, stop, axes, parts, runs, over, ideal, cursors, marks)
        picture = figure(contents, width=width, dark=dark)
        save(picture, path, contents.title, description_of(picture), dark)

    def show(self, *args: Any, **options: Any) -> None:
        """Show what `figure` draws, with its arguments: in a window, or in the notebook; returns when that is closed.

        Raises:
            UsageError: there is no screen, or as `figure`.
            UnknownName, NotRecorded: as `figure`.
        """
        from ...record.pictures.pictures import show

        show(self.figure(*args, **options))

    def readings(
        self,
        at: Time | Iterable[Time],
        pins: Sequence[str] | None = None,
        axes: Sequence[int | str] | int | str | None = None,
        over: Mapping[str, Trace] | None = None,
        parts: Sequence[str] | str | None = None,
    ) -> Readings:
        """Return the value of every axis, quantity of a part and recorded pin at some instants, and their differences.

        Print it for a table; its `rows` are the same as data.

        Args:
            at: one instant or several, "3 ms" or picoseconds.
            pins, axes, over: as for `figure`; what was measured of a pin has a row below all others.
            parts: whose quantities are listed, as for `figure`; by default those of all parts around the chips.

        Raises:
            UsageError: an instant is still to come, or there is none.
        """
        from ...record.measuring.overlay import checked
        from ...record.pictures.cursors import measured, readings

        instants = moments_of(at)
        if not instants:
            raise UsageError('readings: no instant; give some, such as bench.readings(["10 ms", "20 ms"])')
        if max(instants) > self.kernel.now:
            raise UsageError(f"{readable(max(instants))} is still to come; it is {readable(self.kernel.now)}")
        nets = dict(self.recorded) if pins is None else self._chosen(pins)
        shown = self._axes(axes)
        tracks = [(self._name_of(axis), axis.quantities()) for axis in shown]
        tracks += [(part.name, quantities) for part, quantities in self._parts(parts, shown)]
        found = readings(instants, tracks, [(name, net, self.recorder) for name, net in nets.items()])
        rows = [measured(name, trace, instants) for name, trace in checked(over).items()]
        return replace(found, rows=(*found.rows, *rows))

    # ------------------------------------------------------------------------------------------------- what is shown
    def _contents(
        self,
        title: str | None,
        pins: Sequence[str | Trace] | None,
        start: Time | None,
        stop: Time | None,
        axes: Sequence[int | str] | int | str | None,
        parts: Sequence[str] | str | None,
        runs: Mapping[str, Drawing | Steps] | None,
        over: Mapping[str, Trace] | None,
        ideal: bool,
        cursors: Time | Iterable[Time],
        marks: bool,
    ) -> Contents:
        from ...record.pictures.figures import Contents

        self.catch_up()
        if runs is not None and not isinstance(runs, Mapping):
            raise UsageError(f"runs: {runs!r}; expected benches by name, such as {{'fast': other}}")
        if not self.chips:
            raise UnknownName("the bench has no chip to plot")
        benches = [("", self)] if not runs else [(n, run) for n, run in runs.items() if isinstance(run, Drawing)]
        if runs and not any(bench is self for _, bench in benches):
            benches.insert(0, ("this run", self))
        begins = {name: (bench._motion(bench._axes(axes)) or (0, 0))[0] if runs else 0 for name, bench in benches}
        zero = next(begins[name] for name, bench in benches if bench is self)
        measured = [*self._measured(runs or {}, axes, zero)]
        first, last = self._picture(axes, pins, start, stop, benches, begins, measured)
        shown = moments_of(cursors)
        for ps in shown:
            if not first <= ps <= last:
                within = f"{readable(first)} to {readable(last)}"
                raise UsageError(f"cursors: {readable(ps)} lies outside the picture, {within}; give start or stop, too")
        tracks: list[Track] = []
        for name, bench in benches:
            tracks += bench._tracks(axes, parts, name, begins[name], first, last, ideal)
        tracks += measured
        from ...record.style import TimeAxis

        tracks = [*without_rest(tracks, TimeAxis(first, last))]
        return Contents(
            title or self._named(),
            tracks,
            self._traces(pins, first, last, zero, over),
            first,
            last,
            notes=[*self._notes(tracks), *differences(tracks)],
            cursors=shown,
            zero_is="from the begin of the motion on" if runs else "",
            marks=marks,
        )

    def _picture(
        self,
        axes: Any,
        pins: Sequence[str | Trace] | None,
        start: Time | None,
        stop: Time | None,
        benches: Sequence[tuple[str, Drawing]],
        begins: Mapping[str, int],
        measured: Sequence[Track],
    ) -> tuple[int, int]:
        """Return the window of a picture, in ps of the picture: the motion, unless `start` or `stop` say otherwise.

        A window that begins after the motion, or ends before it, reaches to the end, or the begin, of the run.
        """
        ends = [bench.kernel.now - begins[name] for name, bench in benches]
        longest = max(ends + [track.until - track.zero for track in measured])
        first = None if start is None else moment(start)
        last = None if stop is None else min(moment(stop), longest)
        if first is None or last is None:
            moved = [(bench._motion(bench._axes(axes)), begins[name]) for name, bench in benches]
            spans = [(span[0] - zero, span[1] - zero) for span, zero in moved if span is not None]
            spans += [(t.since - t.zero, t.until - t.zero) for t in measured]
            if not spans and (edges := self._activity(pins)) is not None:
                spans = [edges]
            begin = min((span[0] for span in spans), default=0)
            end = max((span[1] for span in spans), default=longest)
            around = max((end - begin) // AROUND, 1)
            earliest = -min(begins.values())
            loaded = max(
                (bench._loaded(axes, begin + begins[name]) - begins[name] for name, bench in benches), default=0
            )
            if first is None:
                first = max(begin - around, earliest, loaded)
                first = first if last is None or first < last else earliest
            if last is None:
                last = min(end + around, longest)
                last = last if first < last else longest
        if last <= first:
            raise UsageError(
                f"nothing to draw from {readable(first)} to {readable(last)}; let time pass with bench.run() before, "
                "or give start and stop that lie in the past"
            )
        return first, last

    def _motion(self, axes: Sequence[OneAxis]) -> tuple[int, int] | None:
        """The first and the last instant (ps) at which one of the axes moves; None: none does."""
        spans = [span for axis in axes if (span := moving_from_to(axis, axis.motor.since, self.kernel.now)) is not None]
        return (min(begin for begin, _ in spans), max(end for _, end in spans)) if spans else None

    def _loaded(self, axes: Any, before: int) -> int:
        """When a position register was loaded last before an instant (ps): what it held until then is not shown.

        Nor is what is no longer kept.
        """
        motors = [axis.motor for axis in self._axes(axes)]
        loads = [since for motor in motors for since, _ in motor.offsets if since <= before]
        return max([0, *loads, *(motor.since for motor in motors)])

    def _activity(self, pins: Sequence[str | Trace] | None) -> tuple[int, int] | None:
        """From the first to the last edge of the pins that are shown, command or finding; None: there is none."""
        now = self.kernel.now
        traces = self._traces(pins, 0, now, 0)
        found = [int(ps) for trace in traces if len(trace.times_ps) for ps in trace.times_ps[[0, -1]]]
        found += [each.time_ps for chip in self.chips.values() for each in chip.findings]
        found += [ps for log in self.commands.values() for ps, text in log.between(0, now) if text]
        return (min(found), max(found)) if found else None

    def _axes(self, axes: Sequence[int | str] | int | str | None) -> list[OneAxis]:
        """The axes that are asked for; all of them by default."""
        all_of_them = [*self._chip_axes()]
        if axes is None:
            return [axis for _, _, axis in all_of_them]
        wanted = [axes] if isinstance(axes, int | str) else list(axes)
        found: list[OneAxis] = []
        for one in wanted:
            fits = [axis for chip, n, axis in all_of_them if one in (n, axis.name, chip.name)]
            if not fits or isinstance(one, bool):
                names = [axis.name for _, _, axis in all_of_them]
                says = f"axes: no axis {one!r}; there are {', '.join(names)}, and numbers from 1 on"
                raise UnknownName(says + hint(one, names))
            found += [axis for axis in fits if axis not in found]
        return found

    def _owner(self, axis: OneAxis) -> tuple[Chip, int]:
        """The chip of an axis, and its number there."""
        return next((chip, n) for chip, n, one in self._chip_axes() if one.motor is axis.motor)

    def _name_of(self, axis: OneAxis) -> str:
        """An axis as the legend names it: with its chip, if there are several."""
        chip, number = self._owner(axis)
        if chip.sheet.axes == 1:
            return chip.name
        return f"axis {number}" if len(self.chips) == 1 else f"{chip.name} axis {number}"

    def _tracks(self, axes: Any, parts: Any, run: str, zero: int, start: int, stop: int, ideal: bool) -> list[Track]:
        """What the axes did in a window of the picture, those that move; one, if none does.  Below, what parts did."""
        first, last = max(start + zero, 0), min(stop + zero, self.kernel.now)
        chosen = self._axes(axes)
        around = self._parts(parts, chosen)
        if axes is None:
            chosen = [axis for axis in chosen if any(axis.motor.played(first, last))] or chosen[:1]
        tracks = [self._track(axis, zero, first, last, ideal) for axis in chosen]
        tracks += self._tracks_of_parts(around, zero, first, last, parts is None)
        if not run:
            return tracks
        return [replace(track, name=f"{run}, {track.name}" if len(tracks) > 1 else run) for track in tracks]

    def _parts(self, parts: Sequence[str] | str | None, axes: Sequence[OneAxis]) -> list[Chosen]:
        """The parts whose quantities are shown, beside some axes."""
        return chosen(
            self.parts, parts, [*{id(chip): chip for axis in axes for chip in [self._owner(axis)[0]]}.values()]
        )

    def _tracks_of_parts(
        self, around: Sequence[Chosen], zero: int, first: int, last: int, moving: bool
    ) -> Iterator[Track]:
        """What parts did; `moving`: no quantity that does not change."""
        import numpy as np

        from ...record.pictures.tracks import Track

        for part, quantities in around:
            shown = [each for each in quantities if not moving or np.ptp(each.outline(first, last, 1).values)]
            if shown:
                yield Track(
                    part.name,
                    shown,
                    marks=self._findings(part, first, last),
                    zero=zero,
                    until=self.kernel.now,
                    part=True,
                )

    def _track(self, axis: OneAxis, zero: int, first: int, last: int, ideal: bool) -> Track:
        from ...record.pictures.tracks import Track

        motions = axis.motions(first, last)
        if any(axis.motor.played(first + 1, motions[0].time_ps if motions else last)):  # the one before was under way
            motions = [motion for motion in axis.motions(None, first) if motion.time_ps < first][-1:] + motions
        ideals = ((motion, motion.ideal) for motion in motions) if ideal else ()
        return Track(
            self._name_of(axis),
            axis.quantities(),
            motions,
            [*axis.marks(first, last), *self._findings(self._owner(axis)[0], first, last)],
            axis.phases(first, last) if len(motions) <= MOST_PHASED else (),
            [(law, axis.deviation(motion)) for motion, law in ideals if law is not None],
            zero,
            until=self.kernel.now,
            words={name: word for name, word in words_of(self._owner(axis)[0]).items() if word != name.lower()},
        )

    def _findings(self, owner: Chip | Part, first: int, last: int) -> list[Mark]:
        return [Mark(f.time_ps, "finding", f.code) for f in owner.findings if first <= f.time_ps <= last]

    def _measured(self, runs: Mapping[str, Any], axes: Any, zero: int) -> Iterator[Track]:
        """Measured steps among some runs, their first one at that of this bench (ps; `zero` of it is 0)."""
        from ...record.pictures.measured import track

        found = {name: run for name, run in runs.items() if not isinstance(run, Drawing)}
        if not found:
            return
        steps_of = (first_step(axis, self.kernel.now) for axis in self._axes(axes))
        first = min((step for step in steps_of if step is not None), default=zero)
        for name, steps in found.items():
            if not isinstance(steps, Steps):
                raise UsageError(
                    f"runs: {name!r}: expected a bench, or steps such as those of read_vcd(path).steps('pulse')"
                )
            yield track(name, steps, first - zero)

    def _traces(
        self,
        pins: Sequence[str | Trace] | None,
        first: int,
        last: int,
        zero: int,
        over: Mapping[str, Trace] | None = None,
    ) -> list[Trace]:
        """What the pins did in a window of the picture; names without their chip, if there is but one."""
        from ...record.measuring.overlay import checked, fitting
        from ...record.recording.recorder import width_of
        from ...record.recording.traces import Trace

        laid = checked(over)
        found: list[Trace] = []
        shown = list(self.recorded if pins is None else [pins] if isinstance(pins, str) else pins)
        for pin in [*shown, *(name for name in laid if name not in shown)]:
            if isinstance(pin, Trace):
                found.append(pin.shifted(-zero).within(first, last))
                continue
            net = self._chosen([pin])[pin]
            name = pin.partition(".")[2] if len(self.chips) == 1 else pin
            measured = fitting(pin, width_of(net) > 1, laid.get(pin))
            trace = Trace.of(name or pin, net, self.recorder, first + zero, last + zero, measured)
            found.append(trace.shifted(-zero))
        return found

    # --------------------------------------------------------------------------------------------------- what is told
    def _notes(self, tracks: Sequence[Track]) -> Iterator[str]:
        """Lines that tell with which parameters the axes moved."""
        words = {name: word for chip in self.chips.values() for name, word in words_of(chip).items()}
        lines = {track.name: told(track, words) for track in tracks if not track.part}
        if len({*lines.values()}) == 1:
            lines = {"": next(iter(lines.values()))}
        for name, line in [*lines.items()][:MOST_NOTES]:
            if line:
                yield f"{name}: {line}" if name else line
