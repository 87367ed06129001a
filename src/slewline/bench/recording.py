"""What a bench remembers: nets that are recorded, and the files that can be written of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from os import PathLike
from typing import TYPE_CHECKING, Any

from ..core.chip import Chip, Terminal
from ..core.kernel import Kernel
from ..core.net import Bus, Net
from ..core.timebase import picoseconds
from ..errors import NotRecorded, UnknownName

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ..record.recorder import Recorder

Time = str | int
Path = str | PathLike[str]
SLICE_PS = 100_000_000_000  # while a VCD file is streamed, time passes in slices of 100 ms
QUIET = ("clk15",)  # clocks are recorded only when asked for by name


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
                if row.way in ("in", "out", "both") and row.name not in QUIET and not isinstance(chip.pins[row.name].net, Bus):
                    yield f"{chip.name}.{row.name}"
            yield f"{chip.name}.db"

    def _window(self, start: Time | None, stop: Time | None) -> tuple[int, int]:
        return (
            0 if start is None else picoseconds(start),
            self.kernel.now if stop is None else min(picoseconds(stop), self.kernel.now),
        )

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

    def edges(self, pin: str, start: Time | None = None, stop: Time | None = None) -> tuple[NDArray[np.int64], NDArray[np.int8]]:
        """Changes of a recorded pin at start <= t <= stop.

        Returns:
            times: (n,) int64, picoseconds, ascending; levels: (n,) int8, the level from that instant on, -1 floating.
        """
        net = self._chosen([pin])[pin]
        first, last = self._window(start, stop)
        return self.recorder.edges(net, max(first, self.recorder.since(net)) if start is None else first, last)

    def save_vcd(self, path: Path, pins: Sequence[str] | None = None, start: Time | None = None, stop: Time | None = None, timescale: str = "1 ns") -> None:
        """Write recorded pins as a VCD file; an existing file is replaced whole or not at all."""
        from ..record.vcd import write_vcd

        first, last = self._window(start, stop)
        write_vcd(path, self._chosen(pins), first, last, timescale=timescale, recorder=self.recorder)

    def save_csv(self, path: Path, pins: Sequence[str] | None = None, start: Time | None = None, stop: Time | None = None) -> None:
        """Write the changes of recorded pins as CSV: time_ps, net, level."""
        from ..record.export_csv import write_edges

        first, last = self._window(start, stop)
        write_edges(path, self._chosen(pins), first, last, recorder=self.recorder)

    def save_steps(self, path: Path, start: Time | None = None, stop: Time | None = None) -> None:
        """Write the steps of all chips as CSV: time_ps, chip, axis, direction, position."""
        from ..record.export_csv import write_steps

        first, last = self._window(start, stop)
        write_steps(path, [(chip.name, 1, chip.steps(first, last)) for chip in self.chips.values()])

    @contextmanager
    def stream_vcd(self, path: Path, pins: Sequence[str] | None = None, timescale: str = "1 ns") -> Iterator[None]:
        """Write recorded pins to a VCD file while time passes, so that a long window needs no memory."""
        from ..record.vcd import VcdStream

        stream = VcdStream(path, self._chosen(pins), timescale=timescale, recorder=self.recorder, start=self.kernel.now)
        self._streams.append(stream)
        try:
            yield
            stream.write_until(self.kernel.now)
            stream.close()
        except BaseException:
            stream.discard()
            raise
        finally:
            self._streams.remove(stream)

    def _advance(self, ps: int) -> None:
        """Let time pass; streams are fed on the way."""
        while self._streams and self.kernel.now < ps:
            self.kernel.run(min(ps, self.kernel.now + SLICE_PS))
            for stream in self._streams:
                stream.write_until(self.kernel.now)
        self.kernel.run(ps)

    def plot(self, path: Path, chip: str | None = None, pins: Sequence[str] | None = None, start: Time | None = None, stop: Time | None = None) -> None:
        """Draw velocity and position over time with the parameters named, and chosen recorded pins below (SVG or PNG)."""
        from ..record.plots import plot

        if not self.chips:
            raise UnknownName("the bench has no chip to plot")
        of = self.chips[chip] if chip is not None else next(iter(self.chips.values()))
        first, last = self._window(start, stop)
        nets = self._chosen(pins) if pins is not None or self.recorded else {}
        plot(path, of, nets, first, last, recorder=self.recorder)
