"""Pictures of a bench: its axes and its pins; drawn, saved to files, and read at cursors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ...core.chip import Chip
from ...core.messages.near import hint
from ...core.motion.axis import Steps
from ...core.motion.motions import Mark
from ...core.motion.one_axis import OneAxis
from ...core.time.timebase import Time, moment, readable
from ...errors import SlewlineError, UnknownName, UsageError
from ...parts.base.part import Part
from .named_curves import Chosen, chosen, first_step, moments_of, moving_from_to
from .picture_options import PICTURE, Picture
from .signals import Signals
from .track_notes import differences, parameters_of, words_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ...record.pictures.cursors import Readings
    from ...record.pictures.figures import Contents
    from ...record.pictures.tracks import Track
    from ...record.recording.traces import Trace
    from ...record.style import TimeAxis
    from .waveform_files import FilePath

AROUND = 20  # 1/20 of the motion is shown before and after it
MAX_PHASED = 100  # with more motions, their phases would be narrower than their names
MAX_NOTES = 4  # lines of parameters
MOST_PINS = 12  # with more recorded pins a notebook shows none: use bench.plot

AxisNames = Sequence[int | str] | int | str | None


class Pictures:
    """The pictures of a circuit and its recorded signals."""

    def __init__(self, signals: Signals) -> None:
        self.signals, self.circuit, self.kernel = signals, signals.circuit, signals.circuit.kernel

    def figure(self, options: Picture, ax: Axes | Sequence[Axes] | None) -> Figure:
        """Draw the motions of the axes, with the recorded pins below them."""
        from ...record.pictures.figures import figure

        return figure(self.contents(options), width=options["width"], dark=options["dark"], ax=ax)

    def plot(self, path: FilePath, options: Picture) -> None:
        """Draw a picture into a file."""
        from ...record.pictures.figures import description_of, figure
        from ...record.pictures.picture_files import SUFFIXES, save
        from ...record.whole_file import check_suffix

        check_suffix(path, SUFFIXES)
        contents = self.contents(options)
        picture = figure(contents, width=options["width"], dark=options["dark"])
        save(picture, path, contents.title, description_of(picture), options["dark"])

    def svg(self) -> str | None:
        """Return the picture of a bench for a notebook; None if nothing has moved or matplotlib is missing."""
        from ...record.pictures.figures import description_of, figure
        from ...record.pictures.picture_files import drawn

        recorded, motors = len(self.signals.recorded), [axis.motor for _, _, axis in self.circuit.axes()]
        if not recorded and not any(any(motor.played(motor.since, self.kernel.now)) for motor in motors):
            return None
        try:
            contents = self.contents(PICTURE | {"pins": None if recorded <= MOST_PINS else []})
            picture = figure(contents)
        except SlewlineError:
            return None
        return drawn(picture, "svg", contents.title, description_of(picture)).decode("utf-8")

    def readings(
        self,
        at: Time | Iterable[Time],
        pins: Sequence[str | Trace] | None = None,
        axes: Sequence[int | str] | int | str | None = None,
        over: Mapping[str, Trace] | None = None,
        parts: Sequence[str] | str | None = None,
    ) -> Readings:
        """Return the values of all axes, part quantities and recorded pins at some instants, and their differences.

        `print` shows them as a table; `rows` has the same data.

        Args:
            at: one instant or several, "3 ms" or picoseconds.
            pins, axes, over: as for `figure`; measured traces are listed last.
            parts: the parts whose quantities are listed, as for `figure`; by default all connected to the chips.

        Raises:
            UsageError: an instant is in the future, or none is given.
            TimeError: an instant is not a time.
            UnknownName, NotRecorded: as for `figure`.
        """
        from ...record.measuring.overlay import checked
        from ...record.pictures.cursors import measured, readings
        from ...record.recording.traces import Trace

        instants = moments_of(at)
        if not instants:
            raise UsageError(
                'readings: no instants given; give at least one, such as bench.readings(["10 ms", "20 ms"])'
            )
        if max(instants) > self.kernel.now:
            raise UsageError(f"{readable(max(instants))} is in the future; the time is {readable(self.kernel.now)}")
        given = list(self.signals.recorded if pins is None else [pins] if isinstance(pins, str | Trace) else pins)
        nets = self.signals.chosen([pin for pin in given if not isinstance(pin, Trace)])
        traces = [(pin.name, pin) for pin in given if isinstance(pin, Trace)]
        shown = self._axes(axes)
        tracks = [(self.name_of(axis), axis.quantities()) for axis in shown]
        tracks += [(part.name, quantities) for part, quantities in self._parts(parts, shown)]
        found = readings(instants, tracks, [(name, net, self.signals.recorder) for name, net in nets.items()])
        rows = [measured(name, trace, instants) for name, trace in (*traces, *checked(over).items())]
        return replace(found, rows=(*found.rows, *rows))

    # ------------------------------------------------------------------------------------------------------ contents
    def contents(self, options: Picture) -> Contents:
        """Return the contents of a picture, to be drawn."""
        from ...record.pictures.figures import Contents
        from ...record.style import TimeAxis

        self.circuit.catch_up()
        runs, axes = options["runs"], options["axes"]
        if runs is not None and not isinstance(runs, Mapping):
            raise UsageError(f"runs: {runs!r}; expected benches by name, such as {{'fast': other}}")
        if not self.circuit.chips:
            raise UnknownName("the bench has no chip to plot")
        others: list[tuple[str, Pictures]]
        others = [(name, run._pictures) for name, run in (runs or {}).items() if hasattr(run, "_pictures")]
        benches = others if runs else [("", self)]
        if runs and not any(bench is self for _, bench in benches):
            benches.insert(0, ("this run", self))
        begins = {name: (bench._motion(bench._axes(axes)) or (0, 0))[0] if runs else 0 for name, bench in benches}
        zero = next(begins[name] for name, bench in benches if bench is self)
        measured = [*self._measured(options, zero)]
        first, last = self._window(options, benches, begins, measured)
        shown = moments_of(options["cursors"])
        for ps in shown:
            if not first <= ps <= last:
                within = f"{readable(first)} to {readable(last)}"
                raise UsageError(f"cursors: {readable(ps)} is outside the picture, {within}; give start or stop too")
        moved = [each for name, bench in benches for each in bench._tracks(options, name, begins[name], first, last)]
        tracks = [*without_rest([*moved, *measured], TimeAxis(first, last))]
        return Contents(
            options["title"] or self.circuit.title,
            tracks,
            self._traces(options["pins"], first, last, zero, options["over"]),
            first,
            last,
            notes=[*self._notes(tracks), *differences(tracks)],
            cursors=shown,
            zero_is="from the start of the motion" if runs else "",
            marks=options["marks"],
        )

    def _window(
        self,
        options: Picture,
        benches: Sequence[tuple[str, Pictures]],
        begins: Mapping[str, int],
        measured: Sequence[Track],
    ) -> tuple[int, int]:
        """Return the window of the picture (ps after its time 0); by default the motion, with a margin at either end.

        If only `start` is given, and is after the motion, the window ends at the end of the run; if only `stop`
        is given, and is before the motion, the window begins at the start of the run.
        """
        ends = [bench.kernel.now - begins[name] for name, bench in benches]
        longest = max(ends + [track.until - track.zero for track in measured])
        first = None if options["start"] is None else moment(options["start"])
        last = None if options["stop"] is None else moment(options["stop"])
        if first is not None and last is not None and last <= first:
            raise UsageError(f"start {readable(first)}, stop {readable(last)}: give a stop after the start")
        last = last and min(last, longest)
        if first is None or last is None:
            moved = [(bench._motion(bench._axes(options["axes"])), begins[name]) for name, bench in benches]
            spans = [(span[0] - zero, span[1] - zero) for span, zero in moved if span is not None]
            spans += [(t.since - t.zero, t.until - t.zero) for t in measured]
            if not spans and (edges := self._activity(options["pins"])) is not None:
                spans = [edges]
            begin = min((span[0] for span in spans), default=0)
            end = max((span[1] for span in spans), default=longest)
            around = max((end - begin) // AROUND, 1)
            earliest = -min(begins.values())
            loaded = max(bench._loaded(options["axes"], begin + begins[name]) - begins[name] for name, bench in benches)
            if first is None:
                first = max(begin - around, earliest, loaded)
                first = first if last is None or first < last else earliest
            if last is None:
                last = min(end + around, longest)
                last = last if first < last else longest
        if last <= first:
            found = f"nothing to draw from {readable(first)} to {readable(last)}"
            raise UsageError(f"{found}; call bench.run() first, or give start and stop in the past")
        return first, last

    def _motion(self, axes: Sequence[OneAxis]) -> tuple[int, int] | None:
        """Return the first and the last instant (ps) at which one of the axes moves; None if no axis moves."""
        spans = [span for axis in axes if (span := moving_from_to(axis, axis.motor.since, self.kernel.now)) is not None]
        return (min(begin for begin, _ in spans), max(end for _, end in spans)) if spans else None

    def _loaded(self, axes: AxisNames, before: int) -> int:
        """Return the instant (ps) of the last load of a position register at or before the instant `before` (ps).

        Positions before the result are not shown.  If history is kept only from a later instant on, that instant
        is returned.
        """
        motors = [axis.motor for axis in self._axes(axes)]
        loads = [since for motor in motors for since, _ in motor.offsets if since <= before]
        return max([self.circuit.since, *loads, *(motor.since for motor in motors)])

    def _activity(self, pins: Sequence[str | Trace] | None) -> tuple[int, int] | None:
        """Return the first and the last instant (ps) of pin edges, commands and findings; None if there are none."""
        now = self.kernel.now
        traces = self._traces(pins, 0, now, 0, None)
        found = [int(ps) for trace in traces if len(trace.times_ps) for ps in trace.times_ps[[0, -1]]]
        found += [each.time_ps for chip in self.circuit.chips.values() for each in chip.findings]
        found += [ps for log in self.signals.commands.values() for ps, text in log.between(0, now) if text]
        return (min(found), max(found)) if found else None

    def _axes(self, axes: AxisNames) -> list[OneAxis]:
        """Return the requested axes; by default all of them."""
        all_of_them = [*self.circuit.axes()]
        if axes is None:
            return [axis for _, _, axis in all_of_them]
        wanted = [axes] if isinstance(axes, int | str) else list(axes)
        found: list[OneAxis] = []
        for one in wanted:
            fits = [axis for chip, n, axis in all_of_them if one in (n, axis.name, chip.name)]
            if not fits or isinstance(one, bool):
                names = [axis.name for _, _, axis in all_of_them]
                message = f"axes: no axis {one!r}; allowed {', '.join(names)}, or numbers from 1"
                raise UnknownName(message + hint(one, names))
            found += [axis for axis in fits if axis not in found]
        return found

    def _owner(self, axis: OneAxis) -> tuple[Chip, int]:
        """Return the chip of an axis, and the number of the axis."""
        return next((chip, n) for chip, n, one in self.circuit.axes() if one.motor is axis.motor)

    def name_of(self, axis: OneAxis) -> str:
        """Return the name of an axis in the legend: for a chip with only one axis, the chip's name, such as "x".

        If the chip has several axes, the name is "axis 2", or "x axis 2" if the bench has several chips.
        """
        chip, number = self._owner(axis)
        if chip.sheet.axes == 1:
            return chip.name
        return f"axis {number}" if len(self.circuit.chips) == 1 else f"{chip.name} axis {number}"

    def _tracks(self, options: Picture, run: str, zero: int, start: int, stop: int) -> list[Track]:
        """Return the tracks of the axes, then those of the parts.

        By default, every axis that moves has a track; if none moves, the first axis has one.
        """
        first, last = max(start + zero, 0), min(stop + zero, self.kernel.now)
        chosen = self._axes(options["axes"])
        around = self._parts(options["parts"], chosen)
        if options["axes"] is None:
            chosen = [axis for axis in chosen if any(axis.motor.played(first, last))] or chosen[:1]
        tracks = [self._track(axis, zero, first, last, options["ideal"]) for axis in chosen]
        tracks += self._tracks_of_parts(around, zero, first, last, options["parts"] is None)
        if not run:
            return tracks
        return [replace(track, name=f"{run}, {track.name}" if len(tracks) > 1 else run) for track in tracks]

    def _parts(self, parts: Sequence[str] | str | None, axes: Sequence[OneAxis]) -> list[Chosen]:
        """Return the parts whose quantities are shown; by default the parts connected to the chips of the axes."""
        return chosen(self.circuit.parts, parts, list(dict.fromkeys(self._owner(axis)[0] for axis in axes)))

    def _tracks_of_parts(
        self, around: Sequence[Chosen], zero: int, first: int, last: int, moving: bool
    ) -> Iterator[Track]:
        """Yield the tracks of parts; if `moving` is true, leave out quantities that are constant in the window."""
        import numpy as np

        from ...record.pictures.tracks import Track

        for part, quantities in around:
            shown = [each for each in quantities if not moving or np.ptp(each.outline(first, last, 1).values)]
            if shown:
                marks = self._findings(part, first, last)
                yield Track(part.name, shown, marks=marks, zero=zero, until=self.kernel.now, part=True)

    def _track(self, axis: OneAxis, zero: int, first: int, last: int, ideal: bool) -> Track:
        from ...record.pictures.tracks import Track

        motions = axis.motions(first, last)
        if any(axis.motor.played(first + 1, motions[0].time_ps if motions else last)):  # the last one is in progress
            motions = [motion for motion in axis.motions(None, first) if motion.time_ps < first][-1:] + motions
        ideals = ((motion, motion.ideal) for motion in motions) if ideal else ()
        return Track(
            self.name_of(axis),
            axis.quantities(),
            motions,
            [*axis.marks(first, last), *self._findings(self._owner(axis)[0], first, last)],
            axis.phases(first, last) if len(motions) <= MAX_PHASED else (),
            [(law, axis.deviation(motion)) for motion, law in ideals if law is not None],
            zero,
            until=self.kernel.now,
            words={name: word for name, word in words_of(self._owner(axis)[0]).items() if word != name.lower()},
        )

    def _findings(self, owner: Chip | Part, first: int, last: int) -> list[Mark]:
        return [Mark(f.time_ps, "finding", f.code) for f in owner.findings if first <= f.time_ps <= last]

    def _measured(self, options: Picture, zero: int) -> Iterator[Track]:
        """Yield the measured steps in `runs` as tracks, shifted so that each begins at the bench's first step.

        `zero` is the instant (ps) of the bench that the picture shows as 0.
        """
        from ...record.pictures.measured import track

        found = {name: run for name, run in (options["runs"] or {}).items() if not hasattr(run, "_pictures")}
        if not found:
            return
        steps_of = (first_step(axis, self.kernel.now) for axis in self._axes(options["axes"]))
        first = min((step for step in steps_of if step is not None), default=zero)
        for name, steps in found.items():
            if not isinstance(steps, Steps):
                raise UsageError(
                    f"runs: {name!r}: expected a bench, or steps such as those of read_vcd(path).steps('pulse')"
                )
            yield track(name, steps, first - zero)

    def _traces(
        self, pins: Sequence[str | Trace] | None, first: int, last: int, zero: int, over: Mapping[str, Trace] | None
    ) -> list[Trace]:
        """Return the traces of pins in a window (ps after `zero`); their names omit the chip if there is only one."""
        from ...record.measuring.overlay import checked, fitting
        from ...record.recording.recorder import width_of
        from ...record.recording.traces import Trace

        overlaid = checked(over)
        found: list[Trace] = []
        shown = list(self.signals.recorded if pins is None else [pins] if isinstance(pins, str | Trace) else pins)
        for pin in [*shown, *(name for name in overlaid if name not in shown)]:
            if isinstance(pin, Trace):
                found.append(pin.shifted(-zero).within(first, last))
                continue
            net = self.signals.chosen([pin])[pin]
            name = pin.partition(".")[2] if len(self.circuit.chips) == 1 else pin
            measured = fitting(pin, width_of(net) > 1, overlaid.get(pin))
            trace = Trace.of(name or pin, net, self.signals.recorder, first + zero, last + zero, measured)
            found.append(trace.shifted(-zero))
        return found

    def _notes(self, tracks: Sequence[Track]) -> Iterator[str]:
        """Yield lines that list the motion parameters of the axes."""
        words = {name: word for chip in self.circuit.chips.values() for name, word in words_of(chip).items()}
        lines = {track.name: parameters_of(track, words) for track in tracks if not track.part}
        if len({*lines.values()}) == 1:
            lines = {"": next(iter(lines.values()))}
        for name, line in [*lines.items()][:MAX_NOTES]:
            if line:
                yield f"{name}: {line}" if name else line


def without_rest(tracks: Sequence[Track], axis: TimeAxis) -> Iterator[Track]:
    """Yield the tracks; omit the positions if none of them changes (all axes are at rest, or homing)."""
    import numpy as np

    still = not any(
        np.ptp(np.nan_to_num(quantity.outline(*track.window(axis), 1).values))
        for track in tracks
        for quantity in track.quantities
        if quantity.name == "position"
    )
    for track in tracks:
        yield replace(track, quantities=[q for q in track.quantities if not still or q.name != "position"])
