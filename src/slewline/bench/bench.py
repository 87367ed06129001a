r"""A bench in virtual time: chips, hosts and parts on one kernel, connected by nets.

bench = slewline.Bench()
x = bench.add("cy525", name="x", crystal="11 MHz")
host = bench.host(x)
host.send("R 100\r")
bench.run_until_idle()
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import wraps
from operator import attrgetter
from os import PathLike
from random import Random
from typing import TYPE_CHECKING, Any, ClassVar, Concatenate, ParamSpec, TypeVar, cast

from ..chips import CATALOGUE as CHIPS
from ..core.messages.calls import answering
from ..core.messages.instead import CALLS_OF_HOSTS, face, missing
from ..core.messages.near import hint
from ..core.messages.whole import whole
from ..core.time.kernel import Kernel
from ..core.time.timebase import Seconds, Time, picoseconds, readable
from ..errors import NoSuchAttribute, UsageError
from .circuit import Circuit
from .hosting import connect, host
from .pictures.bench_pictures import Pictures
from .pictures.picture_options import PICTURE, PictureOptions
from .pictures.signals import Signals
from .pictures.timing import TimingDiagrams
from .pictures.waveform_files import WaveformFiles
from .runner import Runner

if TYPE_CHECKING:
    from typing import Unpack

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..core.chip import Chip
    from ..core.component import Finding
    from ..parts.base.part import Part
    from ..record.recording.traces import Trace
    from .by_name import Adds, Hosts, Makes
    from .files.journal import Journal
    from .pictures.waveform_files import FilePath

SHOWN = 8  # chips and parts in the text of a bench

FIXED = {  # arguments and attributes of a bench, with the remedy for setting them
    "seed": "give it when the bench is made: slewline.Bench(seed=...)",
    "journal": "give it when the bench is made: slewline.Bench(journal=...)",
    **dict.fromkeys(("on_finding", "on_input", "on_commit"), "add a listener: .add(function)"),
    "chips": 'bench.add("PART") puts a chip on it',
    "parts": "bench.part(KIND) puts a part on it",
}


def _check_made_with(journal: object, shuffle: object, stores: object) -> None:
    """Check the arguments `journal`, `shuffle` and `stores` of `Bench`."""
    for name, given, fits, allowed in (
        ("journal", journal, isinstance(journal, (str, PathLike)), "the name of a file"),
        ("shuffle", shuffle, whole(shuffle) is not None, "a whole number, the seed of the task order"),
        ("stores", stores, callable(stores), "a function that takes a name and returns a memory"),
    ):
        if given is not None and not fits:
            raise UsageError(f"Bench({name}={given!r}): allowed {allowed}, None")


P = ParamSpec("P")
R = TypeVar("R")


def delegate(to: str, method: Callable[Concatenate[Any, P], R]) -> Callable[Concatenate[Any, P], R]:
    """Return a bench method that calls `method` on one of the bench's attributes, namely the one named `to`.

    The bench method has the signature and docstring of `method`.
    """
    owner, answered = attrgetter(to), answering(f"{method.__name__}()")(method)

    @wraps(method)
    def delegated(bench: Bench, /, *args: P.args, **options: P.kwargs) -> R:
        return answered(owner(bench), *args, **options)

    return delegated


@face
class Bench:
    """Chips and the parts around them, in virtual time that starts at 0.

    Args:
        seed: the seed of every random element, a whole number.
        journal: the file to which every external input is written; replay it with `slewline.replay`.
        shuffle: a second seed, for tests: tasks that are due in the same round then run in a random order, which
            must not change the results; None keeps the usual order.
        stores: a function that returns the non-volatile memory of a chip or part, given its name; by default
            this memory is lost with the bench.
        keep: for endless runs, the length of the past that is kept.  It applies to positions of axes and
            shafts, recorded pins (unless `record(keep=)` overrides it), findings, and data received by
            hosts.  None keeps everything, which takes 1 to 4 KB per move, or hundreds of megabytes for an
            hour of short moves.

    Attributes:
        chips: the chips, keyed by name, in the order in which they were added.
        parts: the parts and hosts, keyed by name, in the order in which they were added.
        recorded: the pins that are recorded, keyed by full name.
        journal: the `Journal` that is being written; None if there is none.
        seed: the seed of every random element.
        on_finding: hook, called with each `Finding` of any chip or part.
        on_input: hook, called with each external input: its kind, such as "drive", and its details, a dict of plain
            data.
        on_commit: hook, called with an instant, ps, before which everything is final.

    Raises:
        BenchFileError: the journal cannot be written, or its path is a file that is not a journal.
        TimeError: `keep` is not a duration.
    """

    _for_users: ClassVar[tuple[str, ...]] = (
        *("add", "host", "part", "wire", "pin", "chips", "parts", "run", "run_to", "run_until", "run_until_idle", "at"),
        *("now", "now_ps", "findings", "quantity", "quantities", "until", "until_idle", "wait", "connect", "place"),
        *("catch_up", "conclude", "record", "recorded", "edges", "plot", "figure", "show", "readings", "timing"),
        *("timing_figure", "intervals", "check_timing"),
        *("save_vcd", "save_csv", "save_steps", "save_npz", "stream_vcd", "journal", "seed", "stores"),
        *("on_finding", "on_input", "on_commit"),
    )
    _to_set: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("now", "now_ps"), 'let time pass: bench.run("1 ms"), or bench.run_to("5 ms")'
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
            raise UsageError(f"Bench({seed!r}): expected a whole number, the random seed; add() puts a chip on a bench")
        self.seed, self.chips, self.parts = number, self._circuit.chips, self._circuit.parts
        self._runner = Runner(self._circuit)
        self._signals = Signals(self._circuit)
        self._files = WaveformFiles(self._signals, self._runner.streams)
        self._pictures = Pictures(self._signals)
        self._diagrams = TimingDiagrams(self._signals)
        self.recorded = self._signals.recorded
        outside = kernel.outside
        outside.let_pass = self._runner.let_pass
        self.journal: Journal | None = None
        if journal is not None:
            from .files.journal import Journal

            self.journal = Journal(journal, kernel, number)
            outside.write = self.journal.write
        self.on_finding, self.on_input = self._circuit.on_finding, outside.on_input
        self.on_commit = kernel.on_commit

    def __setattr__(self, name: str, value: object) -> None:
        if name[0] != "_" and "on_commit" in vars(self):  # the constructor sets this attribute last
            if name in FIXED and vars(self)[name] is not value:
                raise NoSuchAttribute(f"bench: {name} cannot be set; {FIXED[name]}")
            if type(self) is Bench and name not in vars(self) and not hasattr(Bench, name):
                meant = hint(name, [*self._for_users, *FIXED]) or "; keep your own data in a variable"
                raise NoSuchAttribute(f"bench has no {name!r} to set{meant}")
        super().__setattr__(name, value)

    # ------------------------------------------------------------------------------------------------------ the circuit
    add = cast("Adds", delegate("_circuit", Circuit.add))
    part = cast("Makes", delegate("_circuit", Circuit.part))
    place = delegate("_circuit", Circuit.place)
    wire = delegate("_circuit", Circuit.wire)
    pin = delegate("_circuit", Circuit.pin)
    host = cast("Hosts", delegate("_circuit", host))
    connect = delegate("_circuit", connect)

    @property
    def stores(self) -> Callable[[str], Any] | None:
        """The function that returns the non-volatile memory of a chip or part, given its name.

        If this is None, such memories are lost with the bench.
        """
        return self._circuit.stores

    @stores.setter
    def stores(self, stores: Callable[[str], Any] | None) -> None:
        self._circuit.stores = stores

    @property
    def findings(self) -> list[Finding]:
        """The findings of all chips and parts, in chronological order; parts that compute on demand catch up first."""
        return self._circuit.findings

    catch_up = delegate("_circuit", Circuit.catch_up)

    def __contains__(self, name: object) -> bool:
        return any(name in owners for owners in (self.chips, self.parts))

    def __iter__(self) -> Iterator[str]:
        """Yield the names of chips and parts, in the order in which they were added."""
        return iter([*self.chips, *self.parts])

    def __repr__(self) -> str:
        names = [f"{chip.name} ({chip.sheet.part})" for chip in self.chips.values()] + [*self.parts]
        if len(names) > SHOWN:
            names[SHOWN:] = [f"{len(names) - SHOWN} more"]
        return f"<Bench: {', '.join(names) or 'empty'}; {readable(self.kernel.now)}>"

    _ipython_key_completions_ = __iter__  # bench["

    def __getitem__(self, name: str) -> Chip | Part:
        """Return a chip or part by name."""
        return self._circuit[name]

    # ------------------------------------------------------------------------------------------------------------- time
    @property
    def now_ps(self) -> int:
        """Virtual time now, in picoseconds since time 0."""
        return self.kernel.now

    @property
    def now(self) -> Seconds:
        """Virtual time now, in seconds: a float that prints as "0.170768 s" and is accepted wherever a time is."""
        return Seconds(self.kernel.now)

    at = delegate("_runner", Runner.at)
    run = delegate("_runner", Runner.run)
    run_to = delegate("_runner", Runner.run_to)
    run_until = delegate("_runner", Runner.run_until)
    run_until_idle = delegate("_runner", Runner.run_until_idle)
    conclude = delegate("_runner", Runner.conclude)
    until = delegate("_runner", Runner.until)
    until_idle = delegate("_runner", Runner.until_idle)
    wait = delegate("_runner", Runner.wait)

    # ------------------------------------------------------------------------------------------------ signals and files
    record = delegate("_signals", Signals.record)
    edges = delegate("_signals", Signals.edges)
    quantity = delegate("_signals", Signals.quantity)
    quantities = delegate("_signals", Signals.quantities)
    save_vcd = delegate("_files", WaveformFiles.save_vcd)
    save_csv = delegate("_files", WaveformFiles.save_csv)
    save_steps = delegate("_files", WaveformFiles.save_steps)
    save_npz = delegate("_files", WaveformFiles.save_npz)
    stream_vcd = delegate("_files", WaveformFiles.stream_vcd)

    # --------------------------------------------------------------------------------------------------------- pictures
    @answering("figure()", '; width is "page", "phone" or inches', PictureOptions, PICTURE)
    def figure(
        self,
        title: str | None = None,
        pins: Sequence[str | Trace] | None = None,
        start: Time | None = None,
        stop: Time | None = None,
        *,
        ax: Axes | Sequence[Axes] | None = None,
        **options: Unpack[PictureOptions],
    ) -> Figure:
        """Draw the motions of the axes, with recorded pins below; return a matplotlib Figure.

        There is one column of panels, whatever the number of axes: velocity and position, and also acceleration
        and jerk for chips that define these.  By default, axes that do not move are left out if any other axis
        moves.

        Args:
            title: the title; by default the names of the chips and their part numbers.
            pins: recorded pins, or traces of a file; by default all recorded pins, [] for none.
            start, stop: the window; by default the motion, with a margin of one twentieth of its length at either end.
            axes: the axes to draw: numbers counted from 1, names of chips, or names such as "x axis 2"; by
                default all that move, or the first if none moves.
            parts: the parts whose quantities are drawn, by name, or single quantities such as "driver.current"; by
                default all changing quantities of parts connected to the chips; [] for none.
            runs: further benches, keyed by their names in the legend; each is drawn over this one, shifted so
                that the motions begin together; `start` and `stop` then count from that instant.  Measured steps
                are allowed as well, such as `read_vcd(path).steps("pulse")`, shifted so that the first steps
                coincide.
            over: measured traces of pins, such as {"x.slew": measured.trace("slew", shift="-3 ms")}: each is drawn over
                its pin, with marks where the two differ, and a note of the trace's greatest lag relative to the pin.
            ideal: draw the ideal curve of each motion as well, if the chip defines one, and note the motion's greatest
                deviation from it.
            cursors: instants that are marked by numbered lines; `readings` returns the values at these instants.
            dark: draw light lines on a dark background.
            width: "page", "phone", or a number of inches.
            marks: mark commands, findings, limits and home with flags above the panels.
            ax: matplotlib axes to draw into, one for each panel; a single axes object is used for the first
                panel.

        Raises:
            UsageError: nothing to draw, an unknown width, too few axes for the panels, or no matplotlib.
            UnknownName: no such axis or part, or no chip on the bench.
            NotRecorded: a pin is not recorded.
        """
        return self._pictures.figure({"title": title, "pins": pins, "start": start, "stop": stop, **options}, ax)

    @answering("plot()", '; width is "page", "phone" or inches', PictureOptions, PICTURE)
    def plot(
        self,
        path: FilePath,
        title: str | None = None,
        pins: Sequence[str | Trace] | None = None,
        start: Time | None = None,
        stop: Time | None = None,
        **options: Unpack[PictureOptions],
    ) -> None:
        """Draw the picture of `figure` into a file: SVG, PNG or PDF, as selected by its suffix.

        Identical runs produce identical files.

        Raises:
            UsageError: an unknown suffix, a path that cannot be written, or as for `figure`.
            UnknownName, NotRecorded: as for `figure`.
        """
        self._pictures.plot(path, {"title": title, "pins": pins, "start": start, "stop": stop, **options})

    def show(self, *args: Any, **options: Any) -> None:
        """Show the picture of `figure`, with the same arguments: in a window, or in the notebook.

        The call returns when the window is closed.

        Raises:
            UsageError: there is no screen, or as for `figure`.
            UnknownName, NotRecorded: as for `figure`.
        """
        from ..record.pictures.picture_files import show

        show(self.figure(*args, **options))

    def _repr_svg_(self) -> str | None:
        """Return the picture as SVG for a notebook; None if nothing can be drawn (the `repr` is then shown)."""
        return self._pictures.svg()

    readings = delegate("_pictures", Pictures.readings)
    timing = delegate("_diagrams", TimingDiagrams.timing)
    timing_figure = delegate("_diagrams", TimingDiagrams.timing_figure)
    intervals = delegate("_diagrams", TimingDiagrams.intervals)
    check_timing = delegate("_diagrams", TimingDiagrams.check_timing)


missing(
    Bench,
    **{
        name: f'chips and parts are found by their names: bench["{name}"]'
        for name in ("x", "y", "z", "motor", "driver")
    },
    **{name.replace("-", "_"): f'a chip is put on it: x = bench.add("{name}")' for name in CHIPS.ours},
    **dict.fromkeys(("send", "command", "write"), "bench.host(x).send(...), with x = bench.add(...)"),
    **{name: f"a host has it: bench.host(x).{name}, with x = bench.add(...)" for name in CALLS_OF_HOSTS},
    **dict.fromkeys(("ask", "query"), "bench.host(x).ask(...), with x = bench.add(...)"),
    **dict.fromkeys(("add_chip", "chip"), 'bench.add("PART")'),
    **dict.fromkeys(("add_part", "add_host"), "bench.part(KIND), or bench.host(x)"),
    **dict.fromkeys(("sleep", "advance", "step", "run_for"), 'bench.run("10 ms")'),
    timeout='bench.run("10 ms"), in asyncio await bench.wait("10 ms")',
    **dict.fromkeys(
        ("process", "spawn", "schedule", "start_soon", "call_later"),
        'bench.at("1 ms", function) calls it at an instant; slewline.testing.aio has tasks',
    ),
    **dict.fromkeys(
        ("wait_until", "run_idle", "until_is_idle"), "bench.run_until(x.reaches(40)) or bench.run_until_idle()"
    ),
    **dict.fromkeys(
        ("remove", "delete", "reset", "clear"), "nothing can be removed from a bench: make a new one, slewline.Bench()"
    ),
    **dict.fromkeys(("time", "time_ps", "clock"), "bench.now, or bench.now_ps"),
    **dict.fromkeys(("save", "export", "write_vcd", "vcd"), 'bench.save_vcd("run.vcd"), save_csv or save_steps'),
    **dict.fromkeys(
        ("close", "stop", "quit", "shutdown", "exit"),
        "a bench does not need to be closed; a journal does: bench.journal.close()",
    ),
    save_edges='bench.save_csv("edges.csv"), or save_npz("edges.npz")',
    **dict.fromkeys(("picture", "draw", "savefig", "save_plot"), 'bench.plot("run.svg")'),
    **dict.fromkeys(("connect_pins", "join", "net"), 'bench.wire("x.run", "y.wait")'),
    **{name: f"it belongs to a chip: x.{name}, with x = bench.add(...)" for name in ("position", "steps", "pins")},
    **dict.fromkeys(("errors", "warnings", "log"), "bench.findings"),
)
