"""What a bench remembers: nets that are recorded, and the files that can be written of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.chip import Chip, OneAxis
from ..core.kernel import Kernel
from ..core.net import Bus, Net
from ..core.pin import Terminal
from ..core.timebase import Time, moment, picoseconds
from ..errors import NotRecorded

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ..record.recorder import Recorder

FilePath = str | Path
SLICE_PS = 100_000_000_000  # while a VCD file is streamed, time passes in slices of 100 ms
QUIET = ("clk15", "clkout")  # clocks are recorded only when asked for by name


class Recording:
    """The recording half of a bench."""

    chips: dict[str, Chip]

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self.recorded: dict[str, Net] = {}
        self._recorder: Recorder | None = None
        self._streams: list[Any] = []

    @property
    def recorder(self) -> Recorder:
        """The recorder, made when it is first needed."""
        if self._recorder is None:
            from ..record.recorder import Recorder

            self._recorder = Recorder()
        return self._recorder

    def pin(self, name: str) -> Terminal:
        """A pin by its full name."""
        raise NotImplementedError

    def _net(self, name: str) -> Net:
        raise NotImplementedError

    def record(self, *pins: str, keep: Time | None = None) -> None:
        """Record pins from now on, all signal pins and buses of all chips when none is named.

        Clock outputs (CLK/15 of the CY525, CLKOUT of the MC1451A family) are recorded only when named: they never rest,
        and would be most of every file.

        Args:
            keep: forget what is older than this, for endless runs; None keeps everything.
        """
        keep_ps = None if keep is None else picoseconds(keep)
        for name in pins or self._all_pins():
            net = self._net(name)
            self.recorder.record(net, keep_ps)
            self.recorded[name] = net

    def _all_pins(self) -> Iterator[str]:
        for chip in self.chips.values():
            for row in chip.sheet.pins:
                if (
                    row.way in ("in", "out", "both")
                    and row.name not in QUIET
                    and not isinstance(chip.pins[row.name].net, Bus)
                ):
                    yield f"{chip.name}.{row.name}"
            if chip.has_bus:
                yield f"{chip.name}.{chip.sheet.bus}"

    def _window(self, start: Time | None, stop: Time | None) -> tuple[int, int]:
        return (
            0 if start is None else moment(start),
            self.kernel.now if stop is None else min(moment(stop), self.kernel.now),
        )

    def _window_of(self, nets: dict[str, Net], start: Time | None, stop: Time | None) -> tuple[int, int]:
        """A window that recorded nets can be asked about: without `start`, as far back as all of them go."""
        first, last = self._window(start, stop)
        return (
            max((self.recorder.since(net) for net in nets.values()), default=first) if start is None else first
        ), last

    def _chosen(self, pins: Iterable[str] | None) -> dict[str, Net]:
        if pins is None:
            if not self.recorded:
                raise NotRecorded("nothing is recorded; call bench.record() before time passes")
            return dict(self.recorded)
        names = list(pins)
        for name in names:
            if name not in self.recorded:
                self._net(name)  # UnknownName if there is no such pin
                raise NotRecorded(f"{name} is not recorded; call bench.record({name!r}) before time passes")
        return {name: self.recorded[name] for name in names}

    def edges(
        self, pin: str, start: Time | None = None, stop: Time | None = None
    ) -> tuple[NDArray[np.int64], NDArray[np.int8]]:
        """Changes of a recorded pin at start <= t <= stop.

        Returns:
            times: (n,) int64, picoseconds, ascending; levels: (n,) int8, the level from that instant on, -1 floating.
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
    ) -> None:
        """Write recorded pins as a VCD file; an existing file is replaced whole or not at all."""
        from ..record.vcd import write_vcd

        nets = self._chosen(pins)
        write_vcd(path, nets, self.recorder, *self._window_of(nets, start, stop), timescale)

    def save_csv(
        self, path: FilePath, pins: Sequence[str] | None = None, start: Time | None = None, stop: Time | None = None
    ) -> None:
        """Write the changes of recorded pins as CSV: time_ps, net, level."""
        from ..record.export_csv import save_edges

        nets = self._chosen(pins)
        save_edges(path, nets, self.recorder, *self._window_of(nets, start, stop))

    def save_steps(self, path: FilePath, start: Time | None = None, stop: Time | None = None) -> None:
        """Write the steps of all chips as CSV: time_ps, chip, axis, direction, position."""
        from ..record.export_csv import save_steps

        first, last = self._window(start, stop)
        save_steps(path, [(chip.name, n, axis.steps(first, last)) for chip, n, axis in self._chip_axes()])

    def _chip_axes(self) -> Iterator[tuple[Chip, int, OneAxis]]:
        """Every axis of every chip, with its number."""
        for chip in self.chips.values():
            for number in range(1, chip.sheet.axes + 1):
                yield chip, number, chip.axis(number)

    @contextmanager
    def stream_vcd(self, path: FilePath, pins: Sequence[str] | None = None, timescale: str = "1 ns") -> Iterator[None]:
        """Write recorded pins to a VCD file while time passes, so that a long window needs no memory."""
        from ..record.vcd import VcdStream

        stream = VcdStream(path, self._chosen(pins), self.recorder, timescale)
        self._streams.append(stream)
        try:
            with stream:
                yield
                stream.write_until(self.kernel.now)
        finally:
            self._streams.remove(stream)

    def _advance(self, ps: int) -> None:
        """Let time pass; streams are fed on the way."""
        while self._streams and self.kernel.now < ps:
            self.kernel.run(min(ps, self.kernel.now + SLICE_PS))
            for stream in self._streams:
                stream.write_until(self.kernel.now)
        self.kernel.run(ps)
