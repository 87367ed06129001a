r"""A bench in virtual time: chips, hosts and parts on one kernel, wired by nets.

bench = slewline.Bench()
x = bench.add("cy525", name="x", crystal="11 MHz")
host = bench.host(x)
host.send("R 100\r")
bench.run_until_idle()
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from os import PathLike
from random import Random
from typing import TYPE_CHECKING, Any, ClassVar

from ..chips import CATALOGUE as CHIPS
from ..core.messages.calls import answering
from ..core.messages.instead import Face, missing
from ..core.messages.near import hint
from ..core.messages.whole import whole
from ..core.time.kernel import Kernel
from ..core.time.timebase import Seconds, Time, picoseconds, readable
from ..errors import NoSuchAttribute, UsageError
from .by_name import adds, hosts, makes
from .circuit import Circuit
from .hosting import connect, make_host
from .pictures.curves import quantity_of
from .pictures.drawing import PictureOptions, Pictures
from .pictures.signals import Signals
from .pictures.timing import DiagramOptions, TimingDiagrams
from .pictures.waveforms import WaveformFiles
from .runner import Runner

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from ..core.chip import Chip, Finding
    from ..core.motion.axis import Steps
    from ..core.motion.quantity import Quantity
    from ..core.wires.pin import Condition, Terminal
    from ..parts.base.part import Part
    from ..parts.hosts.computer import Computer
    from ..record.measuring.intervals import Interval, TimingTable
    from ..record.pictures.cursors import Readings
    from ..record.recording.recorder import Recorder
    from ..record.recording.traces import Trace
    from ..record.waveforms.vcd import VcdStream
    from ..record.waveforms.vcd_sources import Buses
    from .files.journal import Journal
    from .pictures.waveforms import FilePath
    from .pictures.window import Between

SHOWN = 8  # chips and parts in the text of a bench

FIXED = {  # what a bench is made with, or has of itself, and what to do instead of setting it
    "seed": "it is given where the bench is made: slewline.Bench(seed=...)",
    "journal": "it is given where the bench is made: slewline.Bench(journal=...)",
    **dict.fromkeys(("on_finding", "on_input", "on_commit"), "add a listener: .add(function)"),
    "chips": 'bench.add("PART") puts a chip on it',
    "parts": "bench.part(KIND) puts a part on it",
}


def _check_made_with(journal: object, shuffle: object, stores: object) -> None:
    """Check what a bench is made with, beside its seed."""
    for name, given, fits, allowed in (
        ("journal", journal, isinstance(journal, (str, PathLike)), "the name of a file"),
        ("shuffle", shuffle, whole(shuffle) is not None, "a whole number, the seed of the order"),
        ("stores", stores, callable(stores), "a function that is given a name and returns a memory"),
    ):
        if given is not None and not fits:
            raise UsageError(f"Bench({name}={given!r}): allowed {allowed}, None")


def _pictures(runs: Mapping[str, Bench | Steps] | None) -> Mapping[str, Pictures | Steps] | None:
    """What draws each of some benches."""
    if not isinstance(runs, Mapping):
        return runs
    return {name: run._pictures if isinstance(run, Bench) else run for name, run in runs.items()}


class Bench(Face):
    """Chips and the parts around them, in virtual time from 0 on.

    Args:
        seed: of every random element that is given a source of chance; a whole number.
        journal: a file that takes every input from outside, to be replayed with `slewline.replay`.
        shuffle: run the tasks of a round in random order (from this seed): results must not change.
        stores: called with the name of a chip, returns its non-volatile memory; by default it is lost with the bench.
        keep: forget where the axes have been before that, for endless runs; None keeps everything.  Of pins,
            `record(keep=)` says it.

    Raises:
        BenchFileError: the journal cannot be written, or something else than a journal stands there.
        TimeError: `keep` is no duration.
    """

    for_users: ClassVar[tuple[str, ...]] = (
        *("add", "host", "part", "wire", "pin", "chips", "parts", "run", "run_to", "run_until", "run_until_idle", "at"),
        *("now", "now_ps", "findings", "quantity", "until", "until_idle", "wait", "connect", "place", "catch_up"),
        *("conclude", "record", "edges", "plot", "figure", "show", "readings", "timing", "timing_figure", "intervals"),
        *("check_timing", "save_vcd", "save_csv", "save_steps", "save_npz", "stream_vcd", "journal", "seed", "stores"),
        *("on_finding", "on_input", "on_commit"),
    )
    to_set: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("now", "now_ps"), 'time passes: bench.run("1 ms"), or bench.run_to("5 ms")'
    )

    @answering("Bench()", '; a chip is put on it by add("cy525")')
    def __init__(
        self,
        seed: int = 0,
        journal: str | PathLike[str] | None = None,
        shuffle: int | None = None,
        stores: Callable[[str], Any] | None = None,
        keep: Time | None = None,
    ) -> None:
        _check_made_with(journal, shuffle, stores)
        self.kernel = kernel = Kernel(None if shuffle is None else Random(shuffle))
        self._circuit = Circuit(kernel, stores, None if keep is None else picoseconds(keep))
        number = whole(seed)
        if number is None:
            raise UsageError(
                f"Bench({seed!r}): allowed a whole number, the seed of chance; add() puts a chip on a bench"
            )
        self.seed, self.chips, self.parts = number, self._circuit.chips, self._circuit.parts
        self._runner = Runner(self._circuit)
        self._signals = Signals(self._circuit)
        self._files = WaveformFiles(self._signals, self._runner.streams)
        self._pictures = Pictures(self._signals)
        self._diagrams = TimingDiagrams(self._signals)
        self.recorded = self._signals.recorded
        self.outside = kernel.outside
        self.outside.let_pass = self._runner.let_pass
        self.journal: Journal | None = None
        if journal is not None:
            from .files.journal import Journal

            self.journal = Journal(journal, kernel, number)
            self.outside.write = self.journal.write
        self.on_finding, self.on_input = self._circuit.on_finding, self.outside.on_input
        self.on_commit = kernel.on_commit

    def __setattr__(self, name: str, value: object) -> None:
        if name[0] != "_" and "on_commit" in vars(self):  # which is the last that it is given when it is made
            if name in FIXED and vars(self)[name] is not value:
                raise NoSuchAttribute(f"bench: {name} cannot be set; {FIXED[name]}")
            if type(self) is Bench and name not in vars(self) and not hasattr(Bench, name):
                meant = hint(name, [*self.for_users, *FIXED]) or "; keep what is yours in a variable"
                raise NoSuchAttribute(f"bench has no {name!r} that could be set{meant}")
        super().__setattr__(name, value)

    @property
    def recorder(self) -> Recorder:
        """What keeps the recorded pins."""
        return self._signals.recorder

    # ------------------------------------------------------------------------------------------------------ the circuit
    @adds
    def add(
        self,
        /,
        part: str | type[Chip],
        name: str | None = None,
        crystal: str | int | None = None,
        straps: Mapping[str, int] | None = None,
        bare: bool = False,
        **options: Any,
    ) -> Chip:
        """Put a chip on the bench, at any time; it powers up at once.

        Open strap pins read as the sheet says: a GS-C module listens at 110 baud, with checksums.  `slewline run`,
        `serve`, slewline:// and the pytest plugin strap it for 9600 baud (a table in docs/reference/api.md).

        Args:
            part: part number in lower case, for example "cy525"; a chip of one's own by the name of its entry point
                (slewline.chips), as "my_lab.mx10:Mx10", which imports the module, or the class itself.
            name: defaults to the part number, numbered when there are several.
            crystal: "11 MHz", or hertz; the sheet's own by default.
            straps: fixed levels of input pins.
            bare: leave out the standard wiring (ABORT high, STEP INHIBIT low ...).
            options: of the part, for example rate=80 or stepwise=True.

        Raises:
            UnknownName: no such part, or a strap that is no pin of it; the message lists those there are.
            UsageError: a name that is taken, a crystal, strap or option out of range, a module that cannot be imported.
        """
        return self._circuit.add(part, name, crystal, straps, bare, options)

    @makes
    def part(
        self,
        /,
        kind: str | type[Part],
        name: str | None = None,
        to: Chip | Part | str | None = None,
        on: Part | str | None = None,
        **options: Any,
    ) -> Part:
        """Make a part and put it on the bench, at any time; it works from this instant on.

        Args:
            kind: for example "uart"; slewline.parts.KINDS lists ours.  A part of one's own by the name of its entry
                point (slewline.parts), as "my_lab.lamp:Lamp", which imports the module, or the class itself.
            name: defaults to the kind, or the class in lower case; numbered when there are several.
            to: chip or part to whose pins those of the new part are wired in the standard way: by their roles.
            on: part on whose shaft the new part sits: a motor, a gear, a carriage.
            options: of the part.

        Raises:
            UnknownName: no such kind or neighbour.
            UsageError: a name that is taken, an option that the kind does not have or allow; it does not sit there; a
                module that cannot be imported.
            WiringError: the neighbour lacks a pin that the part needs; nothing has been put on the bench then.
        """
        return self._circuit.part(kind, name, to, on, options)

    def place(self, part: Part) -> Part:
        """Put a part on the bench; its pins can be wired from now on."""
        return self._circuit.place(part)

    def wire(self, a: str, b: str, invert: bool = False) -> None:
        """Connect two pins, at any time; with `invert` an inverter drives the second from the first.

        "x.db" and "y.db" are whole buses ("x.hostdata", where the chip calls it so).

        Raises:
            UnknownName: no such pin.
            WiringError: a bus and a single pin, or a pin that carries no signal.
        """
        self._circuit.wire(a, b, invert)

    def pin(self, name: str) -> Terminal:
        """Return a pin by its full name, for example "x.slew".

        Raises:
            UnknownName: no such chip, part or pin; the message lists those there are.
        """
        return self._circuit.pin(name)

    @hosts
    def host(
        self,
        *chips: Chip,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> Computer:
        """Put a host computer on the command port of a chip, or of several that share its bus or its line, at any time.

        Args:
            delay: what the host's own program takes before each byte (on a bus).
            baud: another rate than the chip is strapped for (on a serial line).
            line: a part of kind rs232_line between the host and the chips.
            over: "bus", "serial", "port" or "parallel", of a chip that has several channels; its first one by default.

        Raises:
            UsageError: no chip, a channel that one of them does not have, chips that are spoken to in different ways,
                or an argument that does not fit them.
            WiringError: a chip's serial line has a host already, or a chip of one's own has no pins for one.
        """
        return make_host(self._circuit, chips, name, delay, baud, line, over)

    def connect(self, connector: Part, chips: Sequence[Chip]) -> None:
        """Wire a serial connector to modules on one line; several need the pull-down of the last one.

        Raises:
            UsageError: no part, or no list of chips.
        """
        connect(self._circuit, connector, chips)

    @property
    def stores(self) -> Callable[[str], Any] | None:
        """What returns the non-volatile memory of a chip, by its name; None: it is lost with the bench."""
        return self._circuit.stores

    @stores.setter
    def stores(self, stores: Callable[[str], Any] | None) -> None:
        self._circuit.stores = stores

    @property
    def findings(self) -> list[Finding]:
        """What hosts did wrong, of all chips and parts, in order of time; parts that are lazy catch up first."""
        return self._circuit.findings

    def catch_up(self) -> None:
        """Let parts that compute only on demand do so, up to now: listeners hear of the findings made on the way.

        `findings`, pictures, files and the end of a replay do so by themselves.
        """
        self._circuit.catch_up()

    def __contains__(self, name: object) -> bool:
        return any(name in owners for owners in (self.chips, self.parts))

    def __iter__(self) -> Iterator[str]:
        """The names of chips and parts, in the order in which they came."""
        return iter([*self.chips, *self.parts])

    def __repr__(self) -> str:
        names = [f"{chip.name} ({chip.sheet.part})" for chip in self.chips.values()] + [*self.parts]
        if len(names) > SHOWN:
            names[SHOWN:] = [f"{len(names) - SHOWN} more"]
        return f"<Bench: {', '.join(names) or 'empty'}; {readable(self.kernel.now)}>"

    def __getitem__(self, name: str) -> Chip | Part:
        """A chip or part by name."""
        return self._circuit[name]

    # ------------------------------------------------------------------------------------------------------------- time
    @property
    def now_ps(self) -> int:
        """Virtual time now, in picoseconds since the beginning."""
        return self.kernel.now

    @property
    def now(self) -> Seconds:
        """Virtual time now, in seconds: a float that prints as "0.170768 s" and may be given wherever a time is."""
        return Seconds(self.kernel.now)

    def at(self, time: Time, function: Callable[[], object]) -> None:
        """Call a function at an instant, in its first round: everything still reads as it was before.

        Args:
            time: since the beginning, not before now: "12 ms", or picoseconds (0, or at least 1000).
            function: takes nothing; what it returns is ignored. It must not let time pass.

        Raises:
            TimeError: not a time.
            UsageError: the instant is over, or `function` is none.
        """
        self._runner.at(time, function)

    def run(self, duration: Time) -> None:
        """Let virtual time pass.

        Args:
            duration: "12 ms", or picoseconds (0, or at least 1000).

        Raises:
            TimeError: not a duration.
            UsageError: the call comes from within a run.
        """
        self._runner.run(duration)

    def run_to(self, time: Time) -> None:
        """Let virtual time pass up to an instant, that instant included.

        Args:
            time: since the beginning: "12 ms", or picoseconds (0, or at least 1000).

        Raises:
            TimeError: not a time.
            UsageError: the instant is over, or the call comes from within a run.
        """
        self._runner.run_to(time)

    def run_until(self, condition: Condition | Callable[[], bool], timeout: Time = "60 s") -> None:
        """Run until a condition is met: x.reaches(40), pin.is_(0), pin.edges(3), host.got(b"Y"), or one of two (`|`).

        Args:
            condition: or a function that returns true then. It is called after every instant, every step of every motor
                being one meanwhile: exact, and slow.
            timeout: of virtual time, from now on.

        Raises:
            Timeout: it is not met in time; the message says what everybody waits for.
            TimeError: `timeout` is no duration.
            UsageError: neither a condition nor a function, or the call comes from within a run.
        """
        self._runner.run_until(condition, timeout)

    def run_until_idle(self, timeout: Time = "60 s") -> None:
        """Run until every host queue is empty and every chip idle.

        Args:
            timeout: of virtual time, from now on.

        Raises:
            Timeout: something still waits; the message says what for.
            TimeError: `timeout` is no duration.
            UsageError: the call comes from within a run.
        """
        self._runner.run_until_idle(timeout)

    def conclude(self) -> None:
        """Let chips tell, as findings, what their hosts have begun and not gone on with: a setting without its update.

        `run_until_idle`, the fixtures of tests, `slewline run` and a server that a host leaves do so by themselves.  Of
        a host that has more to say nothing is told yet.
        """
        self._runner.conclude()

    async def until(self, condition: Condition | Callable[[], bool], timeout: Time = "60 s") -> None:
        """Wait until a condition is met, in a task of asyncio: `run_until` for a host that does several things at once.

        The loop must be one of virtual time: `slewline.testing.aio.run(main())`.

        Args:
            condition: as `run_until` takes it.
            timeout: of virtual time, from now on.

        Raises:
            Timeout: it is not met in time; the message says what everybody waits for.
            TimeError: `timeout` is no duration.
            UsageError: neither a condition nor a function, or the loop goes by the wall clock.
        """
        await self._runner.until(condition, timeout)

    async def until_idle(self, timeout: Time = "60 s") -> None:
        """Wait until every host queue is empty and every chip idle, in a task of asyncio; raises as `until`."""
        await self._runner.until_idle(timeout)

    async def wait(self, duration: Time) -> None:
        """Wait for a time, in a task of asyncio; others go on meanwhile.

        Args:
            duration: "12 ms", or picoseconds (0, or at least 1000).

        Raises:
            TimeError: not a duration.
            UsageError: the loop goes by the wall clock.
        """
        await self._runner.wait(duration)

    # ------------------------------------------------------------------------------------------------ signals and files
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
        self._signals.record(pins, keep)

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
        return self._signals.edges(pin, start, stop)

    def quantity(self, name: str) -> Quantity:
        """Return a quantity, which has a value at every instant: `bench.quantity("driver.current").at("3 ms")`.

        Args:
            name: of an axis ("x.velocity", "m.axis2.position") or of a part ("driver.current").

        Raises:
            UnknownName: there is none; the message lists those there are.
        """
        return quantity_of(self.chips, self.parts, name)

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
        return self._files.save_vcd(path, pins, start, stop, timescale, buses, values, layout)

    def save_csv(
        self, path: FilePath, pins: Sequence[str] | None = None, start: Time | None = None, stop: Time | None = None
    ) -> None:
        """Write the changes of recorded pins as CSV: time_ps, net, level.

        Raises:
            UnknownName: no such pin.
            NotRecorded: a pin is not recorded, or no longer that far back.
            UsageError: the path cannot be written.
        """
        self._files.save_csv(path, pins, start, stop)

    def save_steps(self, path: FilePath, start: Time | None = None, stop: Time | None = None) -> None:
        """Write the steps of all chips as CSV (time_ps, chip, axis, direction, position), or as arrays: .npz.

        Raises:
            UsageError: a name with another ending, or a path that cannot be written.
            NotRecorded: the past of an axis is no longer kept that far back.
        """
        self._files.save_steps(path, start, stop)

    def save_npz(
        self, path: FilePath, pins: Sequence[str] | None = None, start: Time | None = None, stop: Time | None = None
    ) -> None:
        """Write the changes of recorded pins, and all steps, as arrays: `numpy.load(path)["x.slew.times_ps"]`.

        Raises:
            UnknownName: no such pin.
            NotRecorded: a pin is not recorded, or no longer that far back.
            UsageError: a name that does not end in .npz, or a path that cannot be written.
        """
        self._files.save_npz(path, pins, start, stop)

    def stream_vcd(
        self,
        path: FilePath,
        pins: Sequence[str] | None = None,
        timescale: str = "1 ns",
        *,
        buses: Buses = "bits",
        values: bool = False,
        layout: bool = False,
    ) -> AbstractContextManager[VcdStream]:
        """Write recorded pins to a VCD file while time passes, so that a long window needs no memory.

        The arguments are those of `save_vcd`.  What the `with` statement gives has `lost`, what `save_vcd` returns.

        Raises:
            UsageError, NotRecorded, UnknownName: as `save_vcd`.
        """
        return self._files.stream_vcd(path, pins, timescale, buses, values, layout)

    # --------------------------------------------------------------------------------------------------------- pictures
    def figure(
        self,
        title: str | None = None,
        pins: Sequence[str | Trace] | None = None,
        start: Time | None = None,
        stop: Time | None = None,
        *,
        axes: Sequence[int | str] | int | str | None = None,
        parts: Sequence[str] | str | None = None,
        runs: Mapping[str, Bench | Steps] | None = None,
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
        shown = PictureOptions(
            title, pins, start, stop, axes, parts, _pictures(runs), over, ideal, cursors, dark, width, marks
        )
        return self._pictures.figure(shown, ax)

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
        runs: Mapping[str, Bench | Steps] | None = None,
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
        shown = PictureOptions(
            title, pins, start, stop, axes, parts, _pictures(runs), over, ideal, cursors, dark, width, marks
        )
        self._pictures.plot(path, shown)

    def show(self, *args: Any, **options: Any) -> None:
        """Show what `figure` draws, with its arguments: in a window, or in the notebook; returns when that is closed.

        Raises:
            UsageError: there is no screen, or as `figure`.
            UnknownName, NotRecorded: as `figure`.
        """
        from ..record.pictures.pictures import show

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
        return self._pictures.readings(at, pins, axes, over, parts)

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
        shown = DiagramOptions(pins, start, stop, between, causes, title, over, names, decode, quiet, width, dark)
        return self._diagrams.save(path, shown)

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
        shown = DiagramOptions(pins, start, stop, between, causes, title, over, names, decode, quiet, width, dark)
        return self._diagrams.figure(shown)

    def intervals(
        self, between: Iterable[Between], start: Time | None = None, stop: Time | None = None
    ) -> list[Interval]:
        """Measure times between edges of recorded pins, as the arrows of `timing` do, without a picture.

        Raises:
            UsageError: an edge that is none, or is not in the window.
            NotRecorded: a pin is not recorded.
        """
        return self._diagrams.intervals(between, start, stop)

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
        return self._diagrams.check_timing(chips, start, stop)


missing(
    Bench,
    **{
        name: f'chips and parts are found by their names: bench["{name}"]'
        for name in ("x", "y", "z", "motor", "driver")
    },
    **{name.replace("-", "_"): f'a chip is put on it: x = bench.add("{name}")' for name in CHIPS.ours},
    **dict.fromkeys(("send", "command", "write"), "bench.host(x).send(...), of x = bench.add(...)"),
    **dict.fromkeys(("ask", "query"), "bench.host(x).ask(...), of x = bench.add(...)"),
    **dict.fromkeys(("add_chip", "chip"), 'bench.add("PART")'),
    **dict.fromkeys(("add_part", "add_host"), "bench.part(KIND), or bench.host(x)"),
    **dict.fromkeys(("sleep", "advance", "step", "run_for"), 'bench.run("10 ms")'),
    **dict.fromkeys(
        ("wait_until", "run_idle", "until_is_idle"), "bench.run_until(x.reaches(40)) or bench.run_until_idle()"
    ),
    **dict.fromkeys(("remove", "delete", "reset", "clear"), "a bench only grows: make a new one, slewline.Bench()"),
    **dict.fromkeys(("time", "time_ps", "clock"), "bench.now, or bench.now_ps"),
    **dict.fromkeys(("save", "export", "write_vcd", "vcd"), 'bench.save_vcd("run.vcd"), save_csv or save_steps'),
    **dict.fromkeys(
        ("close", "stop", "quit", "shutdown", "exit"), "there is nothing to close; a journal: bench.journal.close()"
    ),
    save_edges='bench.save_csv("edges.csv"), or save_npz("edges.npz")',
    **dict.fromkeys(("picture", "draw", "savefig", "save_plot"), 'bench.plot("run.svg")'),
    **dict.fromkeys(("connect_pins", "join", "net"), 'bench.wire("x.run", "y.wait")'),
    **{name: f"it is a chip's: x.{name}, of x = bench.add(...)" for name in ("position", "steps", "pins")},
    **dict.fromkeys(("errors", "warnings", "log"), "bench.findings"),
)
