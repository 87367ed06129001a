"""Files of a bench: waveforms, and edges and steps as CSV files or arrays.

This module collects the content of a waveform file other than the pins: axis quantities, comments, and layout.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from ...core.chip import Chip
from ...core.messages.instead import missing
from ...core.motion.axis import Steps
from ...core.time.timebase import Time
from ...errors import UsageError
from ...parts.base.part import Part
from ..runner import TimedStream
from .named_curves import attached, axes_of, moving_from_to
from .signals import Signals

if TYPE_CHECKING:
    from pathlib import Path

    from ...record.recording.recorder import Probe, TextLog
    from ...record.waveforms.vcd import VcdStream
    from ...record.waveforms.vcd_sources import Buses, VariableSource
    from ...record.waveforms.viewer_layouts import ViewerSetup

    FilePath = str | Path

VCD, CSV, NPZ = (".vcd",), (".csv",), (".npz",)  # file extensions
STEPS = (*CSV, *NPZ)
NOT_ENTERED = 'use it in a with statement: with bench.stream_vcd("run.vcd"):'
_time = attrgetter("time_ps")
MAX_MARKS = 26  # that a viewer names
AROUND = 50  # before and after the motion, a layout shows a fiftieth of it
APART = 30  # distance of marks that keeps their names legible: a thirtieth of the view


class WaveformFiles:
    """The methods of a bench that write recorded signals, and steps, to files."""

    def __init__(self, signals: Signals, streams: list[TimedStream]) -> None:
        self.signals, self.circuit, self.streams = signals, signals.circuit, streams

    def save_vcd(
        self,
        path: FilePath,
        pins: Sequence[str] | None = None,
        start: Time | None = None,
        stop: Time | None = None,
        timescale: str = "1 ns",
        *,
        buses: Buses = "bits",
        values: bool = False,
        layout: bool = False,
    ) -> int:
        """Write recorded pins as a VCD file; an existing file is replaced completely or not at all.

        Args:
            path: the file.
            pins: names such as "x.slew"; by default all recorded pins.
            start, stop: the window; by default from the earliest instant at which all these pins are recorded, up
                to now.
            timescale: the unit of time in the file, "1", "10" or "100" with a unit from "ps" to "s"; times are rounded
                down to it.
            buses: "bits": each wire of a bus separately, which every viewer reads; "whole": the bus as a vector, which
                PulseView does not read; or "both".
            values: write, as reals, the velocity and position of the axes (acceleration and jerk if the chip has
                them) and the quantities of parts connected to the chips; and, as strings, the commands in progress, the
                commands that began the motions in progress, and the findings.
            layout: write layouts for GTKWave and Surfer next to the file, with the same name and the extensions .gtkw
                and .sucl.

        Returns:
            The number of level changes that are lost, because the level changed again within the same unit of time.

        Raises:
            UsageError: an unknown timescale or kind of buses, nothing to write, or a path that cannot be written.
            NotRecorded: a pin is not recorded, or its past is not recorded that far back.
            UnknownName: there is no such pin.
        """
        from ...record.waveforms.vcd import write_vcd

        nets = self.signals.chosen(pins)
        first, last = self.signals.window_of(nets, start, stop)
        if values and start is None:
            first = max([first, self.circuit.since, *(axis.motor.since for _, _, axis in self.circuit.axes())])
        options = self._vcd_options(path, nets, buses, values, layout)
        stream = write_vcd(path, nets, self.signals.recorder, first, last, timescale, **options)
        if layout:
            self._save_layouts(stream)
        return stream.lost

    def _vcd_options(
        self, path: FilePath, nets: Mapping[str, Probe], buses: Buses, values: bool, layout: bool
    ) -> dict[str, Any]:
        from ...record.whole_file import check_suffix

        check_suffix(path, VCD, bare=True)
        self.circuit.catch_up()
        if layout:
            from ...record.waveforms.viewer_layouts import layout_paths

            layout_paths(path)
        chips = chips_of(self.circuit.chips, nets)
        parts = self._parts_of(chips, nets) if values else []
        sources = values_of(chips, self.signals.commands, parts) if values else ()
        return {"buses": buses, "values": sources, "comments": comments_of(chips, values, parts)}

    def _parts_of(self, chips: Sequence[Chip], nets: Iterable[str]) -> list[Part]:
        """Return the parts connected to some chips, and the parts whose own pins are recorded."""
        named, around = {name.split(".")[0] for name in nets}, attached(self.circuit.parts.values(), chips)
        return [part for part in self.circuit.parts.values() if part in around or part.name in named]

    def _save_layouts(self, stream: VcdStream) -> None:
        from ...record.waveforms.viewer_layouts import save_layouts

        chips = chips_of(self.circuit.chips, stream.nets)
        save_layouts(stream.path, stream.variables, view_of(chips, *stream.window, stream.unit))

    def save_csv(
        self, path: FilePath, pins: Sequence[str] | None = None, start: Time | None = None, stop: Time | None = None
    ) -> None:
        """Write the changes of recorded pins as CSV: time_ps, net, level.

        Args:
            path: the file.
            pins: names such as "x.slew"; by default all recorded pins.
            start, stop: the window; by default from the earliest instant at which all of them are recorded, up
                to now.

        Raises:
            UnknownName: there is no such pin.
            NotRecorded: a pin is not recorded, or its past is no longer kept that far back.
            UsageError: an extension other than .csv, or a path that cannot be written.
        """
        from ...record.recording.export_csv import save_edges
        from ...record.whole_file import check_suffix

        check_suffix(path, CSV, bare=True)
        self.circuit.catch_up()
        nets = self.signals.chosen(pins)
        save_edges(path, nets, self.signals.recorder, *self.signals.window_of(nets, start, stop))

    def save_steps(self, path: FilePath, start: Time | None = None, stop: Time | None = None) -> None:
        """Write the steps of all chips as CSV (time_ps, chip, axis, direction, position) or as arrays (.npz).

        Raises:
            UsageError: an extension other than .csv or .npz, or a path that cannot be written.
            NotRecorded: the past of an axis is no longer kept that far back.
        """
        from ...record.whole_file import check_suffix

        check_suffix(path, STEPS, bare=True)
        self.circuit.catch_up()
        steps = self._steps(start, stop)
        if str(path).lower().endswith(NPZ):
            from ...record.recording.export_npz import save_npz, step_columns

            save_npz(path, step_columns(steps))
        else:
            from ...record.recording.export_csv import save_steps

            save_steps(path, steps)

    def save_npz(
        self, path: FilePath, pins: Sequence[str] | None = None, start: Time | None = None, stop: Time | None = None
    ) -> None:
        """Write the changes of recorded pins, and all steps, as arrays: `numpy.load(path)["x.slew.times_ps"]`.

        Raises:
            UnknownName: there is no such pin.
            NotRecorded: a pin is not recorded, or its past is no longer kept that far back.
            UsageError: the file name does not end in .npz, or the path cannot be written.
        """
        from ...record.recording.export_npz import edge_columns, save_npz, step_columns
        from ...record.whole_file import check_suffix

        check_suffix(path, NPZ)
        self.circuit.catch_up()
        nets = self.signals.chosen(pins) if pins is not None or self.signals.recorded else {}
        first, last = self.signals.window_of(nets, start, stop)
        edges = edge_columns(nets, self.signals.recorder, first, last)
        save_npz(path, {**edges, **step_columns(self._steps(start, stop))})

    def _steps(self, start: Time | None, stop: Time | None) -> list[tuple[str, int, Steps]]:
        return [(chip.name, n, axis.steps(start, stop)) for chip, n, axis in self.circuit.axes()]

    def stream_vcd(
        self,
        path: FilePath,
        pins: Sequence[str] | None = None,
        timescale: str = "1 ns",
        *,
        buses: Buses = "bits",
        values: bool = False,
        layout: bool = False,
    ) -> Streaming:
        """Write recorded pins to a VCD file while time passes, so that a long window takes up no memory.

        The arguments are those of `save_vcd`, without `start` and `stop`.  The call returns a context manager: changes
        during its `with` block are written.  In `with ... as vcd`, `vcd.lost` is the number that `save_vcd` returns.

        Raises:
            UsageError, NotRecorded, UnknownName: as for `save_vcd`.
        """
        nets = self.signals.chosen(pins)
        options = self._vcd_options(path, nets, buses, values, layout)

        streaming = Streaming(self.streams, self._streamed(path, nets, timescale, options, layout))
        self.streams.append(streaming)
        return streaming

    @contextmanager
    def _streamed(
        self, path: FilePath, nets: Mapping[str, Probe], timescale: str, options: Mapping[str, Any], layout: bool
    ) -> Iterator[VcdStream]:
        from ...record.waveforms.vcd import VcdStream

        with VcdStream(path, nets, self.signals.recorder, timescale, **options) as stream:
            yield stream
            stream.write_until(self.circuit.kernel.now)
        if layout:
            self._save_layouts(stream)


class Streaming:
    """The result of `stream_vcd`: changes during its `with` block are written to the file."""

    def __init__(self, streams: list[TimedStream], manager: AbstractContextManager[VcdStream]) -> None:
        self._streams, self._manager = streams, manager
        self._stream: VcdStream | None = None

    def __enter__(self) -> VcdStream:
        self._stream = self._manager.__enter__()
        return self._stream

    def __exit__(self, *error: Any) -> bool | None:
        self._streams.remove(self)
        return self._manager.__exit__(*error)

    def feed(self, ps: int) -> None:
        """Write all changes up to an instant (ps)."""
        if self._stream is not None:
            self._stream.write_until(ps)

    def check_entered(self) -> None:
        """Check, before time passes, that the stream is used in a `with` statement.

        Raises:
            UsageError: its `with` block has not been entered.
        """
        if self._stream is None:
            self._streams.remove(self)
            raise UsageError(f"stream_vcd: {NOT_ENTERED}")


missing(Streaming, **dict.fromkeys(("close", "write", "lost", "write_until"), NOT_ENTERED))


def chips_of(chips: Mapping[str, Chip], names: Iterable[str]) -> list[Chip]:
    """Return the chips that own the pins with the given full names."""
    owners = {name.split(".")[0] for name in names}
    return [chip for name, chip in chips.items() if name in owners]


def values_of(
    chips: Iterable[Chip], commands: Mapping[str, TextLog], parts: Iterable[Part] = ()
) -> list[VariableSource]:
    """Return the sources of the values that a waveform file contains besides the pins.

    These are, for every chip, its findings and the command in progress; for every axis, the command that moves it, and
    its quantities; for every part with quantities, the quantities and its findings.
    """
    from ...record.waveforms.vcd_sources import CurveSource, TextSource, reference

    sources: list[VariableSource] = []
    for chip in chips:
        sources.append(TextSource(f"{chip.name}.finding", partial(_findings, chip)))
        if chip.name in commands:
            sources.append(TextSource(f"{chip.name}.command", commands[chip.name].between, all=False))
        for scope, axis in axes_of(chip):
            sources.append(TextSource(f"{scope}.motion", axis.motor.log.texts, all=False))
            sources += [CurveSource(reference(scope, quantity.name), quantity) for quantity in axis.quantities()]
    for part in parts:
        if quantities := part.quantities():
            sources.append(TextSource(f"{part.name}.finding", partial(_findings, part)))
            sources += [CurveSource(reference(part.name, quantity.name), quantity) for quantity in quantities]
    return sources


def comments_of(chips: Iterable[Chip], values: bool, parts: Iterable[Part] = ()) -> Iterator[str]:
    """Yield the header lines of a waveform file: the part numbers of the chips, and the units of the quantities.

    The units of axis quantities are left out unless `values` is true.
    """
    from ...record.waveforms.vcd_sources import reference

    for chip in chips:
        crystal = f", {chip.crystal_hz} Hz" if chip.sheet.crystal_high_hz else ""
        yield f"{chip.name}: {chip.sheet.part.upper()}{crystal}"
        for scope, axis in axes_of(chip) if values else ():
            yield from (f"{reference(scope, quantity.name)} in {quantity.unit}" for quantity in axis.quantities())
    for part in parts:
        yield from (f"{reference(part.name, quantity.name)} in {quantity.unit}" for quantity in part.quantities())


def view_of(chips: Sequence[Chip], start: int, stop: int, unit: int) -> ViewerSetup:
    """Return a viewer's marks, and its initial view: the motion, or the whole window (ps) if nothing moves."""
    from ...record.waveforms.viewer_layouts import ViewerSetup

    axes = [axis for chip in chips for _, axis in axes_of(chip)]
    spans = [span for axis in axes if (span := moving_from_to(axis, start, stop)) is not None]
    begin, end = (min(a for a, _ in spans), max(b for _, b in spans)) if spans else (start, stop)
    around = (end - begin) // AROUND
    begin, end = max(begin - around, start), min(end + around, stop)
    found = [(ps, text.split(":")[0]) for chip in chips for ps, text in _findings(chip, start, stop)]
    begun = [(motion.time_ps, motion.text) for axis in axes for motion in axis.motor.motions(start, stop)]
    marks = _apart([*sorted(found), *sorted(begun)], (end - begin) // APART)
    scale = 10 ** ((len(str(unit)) - 1) % 3)
    return ViewerSetup(begin // unit, end // unit, [(ps // unit, text) for ps, text in marks], scale)


def _apart(marks: Iterable[tuple[int, str]], distance: int) -> list[tuple[int, str]]:
    """Return, in chronological order, marks that are far enough apart; at most as many as a viewer has names for.

    The marks are tried in the order given; a mark is left out unless it is more than `distance` away from
    every mark kept so far.
    """
    kept: list[tuple[int, str]] = []
    for mark in marks:
        if len(kept) < MAX_MARKS and all(abs(mark[0] - other) > distance for other, _ in kept):
            kept.append(mark)
    return sorted(kept)


def _findings(owner: Chip | Part, start: int, stop: int) -> list[tuple[int, str]]:
    findings = owner.findings
    first, end = bisect_left(findings, start, key=_time), bisect_right(findings, stop, key=_time)
    return [(found.time_ps, f"{found.code}: {found.text}") for found in findings[first:end]]
