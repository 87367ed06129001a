"""What a bench remembers: nets that are recorded, and the files that can be written of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from ...core.chip import Chip
from ...core.messages.instead import face
from ...core.motion.one_axis import OneAxis
from ...core.time.kernel import Kernel
from ...core.time.timebase import Time, picoseconds, window
from ...core.wires.net import Bus, Net
from ...core.wires.pin import Terminal
from ...errors import NotRecorded, UnknownName, UsageError
from ...parts.base.part import Part
from .curves import attached, quantity_of

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from ...core.motion.quantity import Quantity
    from ...record.recording.recorder import Probe, Recorder, TextLog
    from ...record.waveforms.vcd import VcdStream
    from ...record.waveforms.vcd_sources import Buses

    FilePath = str | Path

VCD, CSV, NPZ = (".vcd",), (".csv",), (".npz",)  # endings of files
STEPS = (*CSV, *NPZ)
SLICE_PS = 100_000_000_000  # while a VCD file is streamed, time passes in slices of 100 ms


@face
class Recording:
    """The recording half of a bench."""

    chips: dict[str, Chip]
    parts: dict[str, Part]

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self.recorded: dict[str, Net | Terminal] = {}
        self.commands: dict[str, TextLog] = {}  # by the name of the chip
        self._recorder: Recorder | None = None
        self._streams: list[Any] = []

    @property
    def recorder(self) -> Recorder:
        """The recorder, made when it is first needed."""
        if self._recorder is None:
            from ...record.recording.recorder import Recorder

            self._recorder = Recorder()
        return self._recorder

    def pin(self, name: str) -> Terminal:
        """Return a pin by its full name, such as "x.slew".

        Raises:
            UnknownName: no such pin, chip or part.
        """
        raise NotImplementedError

    def _net(self, name: str) -> Net:
        raise NotImplementedError

    def record(self, *pins: str, keep: Time | None = None) -> None:
        """Record pins from now on, all signal pins and buses of all chips when none is named.

        Clock outputs (CLK/15 of the CY525, CLKOUT of the MC1451A family) are recorded only when named: they never rest,
        and would be most of every file.

        Args:
            pins: full names, such as "x.slew".
            keep: forget what is older than this, for endless runs; None keeps everything.

        Raises:
            UnknownName: no such pin, chip or part.
            TimeError: `keep` is no duration.
        """
        keep_ps = None if keep is None else picoseconds(keep)
        for name in pins or self._all_pins():
            probe = self._probe(name)
            self.recorder.record(probe, keep_ps)
            self.recorded[name] = probe
            self._record_commands(name.split(".")[0], keep_ps)

    def _record_commands(self, owner: str, keep_ps: int | None) -> None:
        """What a chip works on is recorded with its pins."""
        from ...record.recording.recorder import TextLog

        if owner in self.commands:
            self.commands[owner].log.keep(keep_ps)
        elif owner in self.chips:
            self.commands[owner] = TextLog(self.kernel, self.chips[owner].on_command, keep_ps)

    def _probe(self, name: str) -> Net | Terminal:
        """The net of a pin; of a pin that is a wire of a bus, the pin."""
        net = self._net(name)
        if not isinstance(net, Bus):
            return net
        try:
            pin = self.pin(name)
        except UnknownName:  # the bus itself
            return net
        return net if pin.bit is None else pin

    def _all_pins(self) -> Iterator[str]:
        for chip in self.chips.values():
            for row in chip.sheet.pins:
                if (
                    row.way in ("in", "out", "both")
                    and row.role != "clock"
                    and not isinstance(chip.pins[row.name].net, Bus)
                ):
                    yield f"{chip.name}.{row.name}"
            if chip.has_bus:
                yield f"{chip.name}.{chip.sheet.bus}"

    def catch_up(self) -> None:
        """Let parts that compute only on demand do so, up to now: listeners hear of the findings made on the way.

        `findings`, pictures, files and the end of a replay do so by themselves.
        """
        for part in self.parts.values():
            part.be_caught_up()

    def quantity(self, name: str) -> Quantity:
        """Return a quantity, which has a value at every instant: `bench.quantity("driver.current").at("3 ms")`.

        Args:
            name: of an axis ("x.velocity", "m.axis2.position") or of a part ("driver.current").

        Raises:
            UnknownName: there is none; the message lists those there are.
        """
        return quantity_of(self.chips, self.parts, name)

    def _window(self, start: Time | None, stop: Time | None) -> tuple[int, int]:
        return window(start, stop, self.kernel.now)

    def _window_of(self, nets: Mapping[str, Net | Terminal], start: Time | None, stop: Time | None) -> tuple[int, int]:
        """A window that recorded nets can be asked about: without `start`, as far back as all of them go."""
        first, last = self._window(start, stop)
        return (
            max((self.recorder.since(net) for net in nets.values()), default=first) if start is None else first
        ), last

    def _chosen(self, pins: Iterable[str] | None) -> dict[str, Net | Terminal]:
        if pins is None:
            if not self.recorded:
                raise NotRecorded("nothing is recorded; call bench.record() before time passes")
            return dict(self.recorded)
        names = [pins] if isinstance(pins, str) else pins
        return {name: self.recorded[name] if name in self.recorded else self._recorded_wire(name) for name in names}

    def _recorded_wire(self, name: str) -> Net | Terminal:
        """A wire of a bus that is recorded as a whole.

        Raises:
            UnknownName: there is no such pin.
            NotRecorded: nobody records it.
        """
        if (wire := self._probe(name)) is not self._net(name) and self._net(name) in self.recorded.values():
            return wire
        raise NotRecorded(f"{name} is not recorded; call bench.record({name!r}) before time passes")

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

    def edges(
        self, pin: str, start: Time | None = None, stop: Time | None = None
    ) -> tuple[NDArray[np.int64], NDArray[np.int8]]:
        """Return the changes of a recorded pin at start <= t <= stop; by default as far as recorded, up to now.

        Returns:
            times: (n,) int64, picoseconds, ascending; levels: (n,) int8, the level from that instant on, -1 floating.

        Raises:
            UnknownName: no such pin.
            NotRecorded: it is not recorded, or no longer that far back.
            TimeError: `start` or `stop` is no time.
        """
        nets = self._chosen([pin])
        return self.recorder.edges(nets[pin], *self._window_of(nets, start, stop))  # type: ignore[return-value]

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
        """Write recorded pins as a VCD file; an existing file is replaced whole or not at all.

        Args:
            path: the file.
            pins: names such as "x.slew"; all that are recorded by default.
            start, stop: the window; by default as far as all of them are recorded, up to now.
            timescale: the unit of its times, 1, 10 or 100 ps to s; they are rounded down.
            buses: "bits": a bus is written as its wires, which every viewer reads; "whole", as PulseView does not;
                "both".
            values: with velocity and position of the axes (acceleration and jerk where the chip has them) and with the
                quantities of the parts around them as reals; with the commands in work, what began the motions under
                way, and the findings as strings.
            layout: write layouts for GTKWave and Surfer beside the file, with its name and .gtkw, .sucl.

        Returns:
            How many changes of level are not in the file, because the level changed again within the same unit.

        Raises:
            UsageError: an unknown timescale or kind of buses, nothing to write, or a path that cannot be written.
            NotRecorded: a pin is not recorded, or not that far back.
            UnknownName: there is no such pin.
        """
        from ...record.waveforms.vcd import write_vcd

        nets = self._chosen(pins)
        first, last = self._window_of(nets, start, stop)
        if values and start is None:
            first = max([first, *(axis.motor.since for _, _, axis in self._chip_axes())])
        options = self._vcd_options(path, nets, buses, values, layout)
        stream = write_vcd(path, nets, self.recorder, first, last, timescale, **options)
        if layout:
            self._save_layouts(stream)
        return stream.lost

    def _vcd_options(
        self, path: FilePath, nets: Mapping[str, Probe], buses: Buses, values: bool, layout: bool
    ) -> dict[str, Any]:
        from ...record.whole_file import check_suffix
        from .waveforms import chips_of, comments_of, values_of

        check_suffix(path, VCD, bare=True)
        self.catch_up()
        if layout:
            from ...record.waveforms.layouts import layout_paths

            layout_paths(path)
        chips = chips_of(self.chips, nets)
        parts = self._parts_of(chips, nets) if values else []
        sources = values_of(chips, self.commands, parts) if values else ()
        return {"buses": buses, "values": sources, "comments": comments_of(chips, values, parts)}

    def _parts_of(self, chips: Sequence[Chip], nets: Iterable[str]) -> list[Part]:
        """The parts around some chips, and those whose own pins are recorded."""
        named, around = {name.split(".")[0] for name in nets}, attached(self.parts.values(), chips)
        return [part for part in self.parts.values() if part in around or part.name in named]

    def _save_layouts(self, stream: VcdStream) -> None:
        from ...record.waveforms.layouts import save_layouts
        from .waveforms import chips_of, view_of

        chips = chips_of(self.chips, stream.nets)
        save_layouts(stream.path, stream.variables, view_of(chips, *stream.window, stream.unit))

    def save_csv(
        self, path: FilePath, pins: Sequence[str] | None = None, start: Time | None = None, stop: Time | None = None
    ) -> None:
        """Write the changes of recorded pins as CSV: time_ps, net, level.

        Raises:
            UnknownName: no such pin.
            NotRecorded: a pin is not recorded, or no longer that far back.
            UsageError: the path cannot be written.
        """
        from ...record.recording.export_csv import save_edges
        from ...record.whole_file import check_suffix

        check_suffix(path, CSV, bare=True)
        self.catch_up()
        nets = self._chosen(pins)
        save_edges(path, nets, self.recorder, *self._window_of(nets, start, stop))

    def save_steps(self, path: FilePath, start: Time | None = None, stop: Time | None = None) -> None:
        """Write the steps of all chips as CSV (time_ps, chip, axis, direction, position), or as arrays: .npz.

        Raises:
            UsageError: a name with another ending, or a path that cannot be written.
            NotRecorded: the past of an axis is no longer kept that far back.
        """
        from ...record.whole_file import check_suffix

        check_suffix(path, STEPS, bare=True)
        self.catch_up()
        steps = [(chip.name, n, axis.steps(start, stop)) for chip, n, axis in self._chip_axes()]
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
            UnknownName: no such pin.
            NotRecorded: a pin is not recorded, or no longer that far back.
            UsageError: a name that does not end in .npz, or a path that cannot be written.
        """
        from ...record.recording.export_npz import edge_columns, save_npz, step_columns
        from ...record.whole_file import check_suffix

        check_suffix(path, NPZ)
        self.catch_up()
        nets = self._chosen(pins) if pins is not None or self.recorded else {}
        first, last = self._window_of(nets, start, stop)
        steps = [(chip.name, n, axis.steps(start, stop)) for chip, n, axis in self._chip_axes()]
        save_npz(path, {**edge_columns(nets, self.recorder, first, last), **step_columns(steps)})

    def _named(self) -> str:
        """The chips and their parts: the title of a picture that has none of its own."""
        parts = [(chip.name, chip.sheet.part.upper()) for chip in self.chips.values()]
        return parts[0][1] if len(parts) == 1 else ", ".join(f"{name}: {part}" for name, part in parts)

    def _chip_axes(self) -> Iterator[tuple[Chip, int, OneAxis]]:
        """Every axis of every chip, with its number."""
        for chip in self.chips.values():
            for number in range(1, chip.sheet.axes + 1):
                yield chip, number, chip.axis(number)

    @contextmanager
    def stream_vcd(
        self,
        path: FilePath,
        pins: Sequence[str] | None = None,
        timescale: str = "1 ns",
        *,
        buses: Buses = "bits",
        values: bool = False,
        layout: bool = False,
    ) -> Iterator[VcdStream]:
        """Write recorded pins to a VCD file while time passes, so that a long window needs no memory.

        The arguments are those of `save_vcd`.  What the `with` statement gives has `lost`, what `save_vcd` returns.

        Raises:
            UsageError, NotRecorded, UnknownName: as `save_vcd`.
        """
        from ...record.waveforms.vcd import VcdStream

        nets = self._chosen(pins)
        options = self._vcd_options(path, nets, buses, values, layout)
        stream = VcdStream(path, nets, self.recorder, timescale, **options)
        self._streams.append(stream)
        try:
            with stream:
                yield stream
                stream.write_until(self.kernel.now)
            if layout:
                self._save_layouts(stream)
        finally:
            self._streams.remove(stream)

    def _advance(self, ps: int) -> None:
        """Let time pass; streams are fed on the way."""
        while self._streams and self.kernel.now < ps:
            self.kernel.run(min(ps, self.kernel.now + SLICE_PS))
            for stream in self._streams:
                stream.write_until(self.kernel.now)
        self.kernel.run(ps)
