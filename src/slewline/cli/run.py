"""slewline run: run a program or a bench file, and report the results."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import click

from ..bench.pictures.waveform_files import STEPS, VCD
from ..chips import sheet_of
from ..core.messages.whole import counted
from ..core.time.timebase import picoseconds, readable
from ..errors import ProgramError, Timeout, TornJournal, UsageError
from ..record.pictures.picture_files import SUFFIXES
from ..record.waveforms.vcd import unit_of
from ..record.waveforms.viewer_layouts import layout_paths
from .files import STDIN, Outputs, Refused, chip_of, is_bench, is_program, read_options, read_program, report_replaced
from .single import BenchOptions, single
from .transcript import Transcript, seconds

if TYPE_CHECKING:
    from ..bench import Bench
    from ..core.chip import Chip
    from ..core.component import Finding
    from ..parts.base.part import Part
    from ..parts.memories.memory import Eeprom, Ram
    from ..record.waveforms.vcd_sources import Buses

TIMEOUT = "60 s"
PLOTTED = (  # roles of the pins below the curves
    *("running", "slewing", "motion_complete", "moving", "ramping", "output1", "output2", "output3", "interrupt"),
)
DEFAULT_BUSES: Buses = "bits"
OF_VCD = ("pins", "timescale", "vcd_buses", "vcd_values", "layout")
COLOURS = {"finding": "red", "motion": "green", "host": "cyan"}


@dataclass
class RunCommand(BenchOptions):
    """The program and the options of a run."""

    file: str | None
    crystal: str | None
    memory: str | None
    save_memory: str | None
    until: int | None
    timeout: int | None
    drive: tuple[tuple[str, int, int], ...]
    strict: bool
    quiet: bool
    journal: str | None
    replay: str | None
    other_laws: bool
    json: str | None
    steps: str | None
    vcd: str | None
    pins: tuple[str, ...] | None
    timescale: str | None
    vcd_buses: Buses | None
    vcd_values: bool
    layout: bool
    plot: str | None
    dark: bool
    options: str | None = None
    over: str | None = None
    torn: bool = False  # the journal that is replayed was cut off

    def __post_init__(self) -> None:
        self.program: tuple[str, str, str] | None = None  # text, file, part
        self.scripts: list[tuple[str, str, str]] = []  # scripts of hosts: chip, text, place

    def perform(self) -> int:
        """Run the program or bench; return the exit status."""
        self.check_options()
        with Outputs(path for path in (self.file, self.replay, self.memory) if path) as outputs:
            for path in (self.json, self.journal, self.save_memory):
                outputs.claim(path)
            outputs.claim(self.steps, STEPS, bare=True)
            outputs.claim(self.vcd, VCD, bare=True)
            for path in self.layouts:
                outputs.claim(path, own=True)
            outputs.claim(self.plot, SUFFIXES)
            report_replaced(self.journal)
            try:
                bench = self.replayed(self.replay) if self.replay else self.new_bench(outputs.partial(self.journal))
                ended = self.ended(bench)
            except ProgramError as error:  # a line of a script that cannot be played
                raise Refused(self.refusal(error)) from error
            self.write(bench, ended, outputs)
            outputs.keep()
            self.conclude(bench, ended, outputs)
            foreign = self.foreign(bench)
        return int(ended == "timeout" or self.torn or foreign or bool(self.wrong(bench)))

    def check_options(self) -> None:
        """Refuse options that exclude each other, or that lack another option that they need."""
        self.quiet = self.quiet or self.json == STDIN
        if self.file is None and self.replay is None:
            outputs = {name: getattr(self, name) for name in ("plot", "vcd", "steps", "json", "journal", "save_memory")}
            for name, path in outputs.items():
                if path is not None and is_program(path):
                    option = f"--{name.replace('_', '-')}"
                    raise click.UsageError(
                        f"{option} uses {path} as its output file, so there is no program: write "
                        f"slewline run {path} {option} FILE"
                    )
        if (self.file is None) == (self.replay is None):
            raise click.UsageError("give exactly one of these: a program, a bench file, --replay JOURNAL")
        if self.vcd is None:
            given = [f"--{name.replace('_', '-')}" for name in OF_VCD if getattr(self, name) not in (None, False)]
            if given:
                raise click.UsageError(f"{', '.join(given)}: needs --vcd FILE")
        if self.dark and self.plot is None:
            raise click.UsageError("--dark: needs --plot FILE")
        if self.timescale is not None and self.vcd is not None:
            unit_of(self.timescale)
        names = ("chip", "crystal", "over", "strap", "options", "memory", "timeout", "drive", "journal")
        given = [name for name in names if getattr(self, name) not in (None, ())]
        if self.replay is not None and given:
            raise click.UsageError(f"--replay repeats a run unchanged; leave out --{' --'.join(given)}")
        if self.other_laws and self.replay is None:
            raise click.UsageError("--other-laws needs --replay")
        if self.anywhere and not self.is_bench:
            raise click.UsageError("--anywhere needs a bench file")
        if self.allow_code and not (self.is_bench or self.replay):
            raise click.UsageError(
                "--allow-code needs a bench file or --replay; a chip given as module:Class needs no --allow-code"
            )
        if self.is_bench and {"chip", "crystal", "over", "strap", "options", "memory"} & set(given):
            raise click.UsageError(
                "a bench file names its chips; leave out --chip, --crystal, --over, --strap, --options, --memory"
            )

    @property
    def is_bench(self) -> bool:
        """True if the file is a bench file."""
        return self.file is not None and is_bench(self.file)

    @property
    def layouts(self) -> list[str]:
        """The paths of the layout files to be written with the waveform; empty if none are requested."""
        return [str(path) for path in layout_paths(self.vcd)] if self.vcd is not None and self.layout else []

    # ------------------------------------------------------------------------------------------------------ the bench
    def new_bench(self, journal: str | None) -> Bench:
        """Return the bench, ready to run; `journal` is the file for its external inputs, or None."""
        file = cast("str", self.file)  # without one a journal is replayed
        if not self.is_bench:
            return self.single(file, journal)
        bench_file = self.bench_file(file)
        times = bench_file.tables.bench
        bench_file.check_times()
        if self.until is None and self.timeout is None and times.until is not None:
            self.until = picoseconds(times.until)
        if self.timeout is None:
            self.timeout = picoseconds(times.timeout)
        return bench_file.load(self.prepare, journal=journal)

    def single(self, file: str, journal: str | None) -> Bench:
        """Return a bench with a chip, a host and the program in a file."""
        text = read_program(file)
        part = chip_of(file, self.chip)
        self.program = text, file, part
        return single(
            part,
            (text, file),
            crystal=self.crystal,
            strap=dict(self.strap),
            options=read_options(self.options, part),
            memory=self.memory,
            over=self.over,
            journal=journal,
            prepare=self.prepare,
        )

    def prepare(self, bench: Bench) -> None:
        """Drive pins, start the recordings and the transcript, and refuse options that would have no effect."""
        if not bench.chips:
            raise Refused(f"{self.file or self.replay}: no chip on the bench, so there is nothing to run")
        if self.save_memory is not None:
            memory_of(bench, self.save_memory)
        bench.kernel.outside.on_input.add(self.take_script)
        for pin, level, at in self.drive:
            name = self.full_name(bench, pin)
            check_input(bench, name, f"--drive {pin}={level}")
            bench.pin(name).drive(level, f"{at} ps" if at else None)
        if self.vcd and self.pins:
            bench.record(*(name for pin in self.pins if (name := self.full_name(bench, pin)) not in bench.recorded))
        elif self.vcd and not bench.recorded:
            bench.record()
        if self.plot:
            bench.record(*self.plotted(bench))
        if not self.quiet:
            width = max(map(len, [*bench.chips, *bench.parts]))
            Transcript(bench, lambda ps, who, kind, text: show(ps, f"{who:<{width}}", kind, text)).attach()

    def full_name(self, bench: Bench, pin: str) -> str:
        """Return the full name of a pin, chip.pin; if there is only one chip, the user may omit the chip's name."""
        if "." in pin or len(bench.chips) != 1:
            return pin
        return f"{next(iter(bench.chips))}.{pin}"

    def plotted(self, bench: Bench) -> list[str]:
        """Return the full names of the first chip's pins that are drawn below the curves of the plot."""
        name, chip = next(iter(bench.chips.items()))
        return [f"{name}.{row.name}" for role in PLOTTED for row in chip.sheet.pins if row.role == role]

    # --------------------------------------------------------------------------------------------------------- running
    def replayed(self, journal: str) -> Bench:
        """Replay a journal and return its bench; print warnings to standard error."""
        from ..bench import replay

        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            bench = replay(
                journal,
                until=self.until,
                prepare=self.prepare,
                other_laws=self.other_laws,
                allow_code=self.allow_code,
            )
        for warning in caught:
            click.echo(f"slewline: {warning.message}", err=True)
        self.torn = any(issubclass(warning.category, TornJournal) for warning in caught)
        return bench

    def ended(self, bench: Bench) -> str:
        """Run the bench, unless it was replayed; return the reason why the run ended: idle, until or timeout."""
        if self.replay:
            owners: list[Chip | Part] = [*bench.chips.values(), *bench.parts.values()]
            return "idle" if self.until is None and all(owner.idle for owner in owners) else "until"
        timeout = picoseconds(TIMEOUT) if self.timeout is None else self.timeout
        with progress(bench, timeout if self.until is None else self.until, self.quiet):
            if self.until is not None:
                bench.run_to(f"{self.until} ps")
                bench.conclude()
                return "until"
            try:
                bench.run_until_idle(f"{timeout} ps")
            except Timeout as error:
                bench.conclude()
                click.echo(f"slewline: timed out: {error}", err=True)
                return "timeout"
        return "idle"

    # ------------------------------------------------------------------------------------------------------- afterwards
    def write(self, bench: Bench, ended: str, outputs: Outputs) -> None:
        """Write the requested files."""
        from ..bench.files.images import write_image
        from .report import as_json

        if bench.journal is not None:
            bench.journal.close()
        if self.json:
            outputs.write(self.json, as_json(bench, ended, self.is_bench or len(bench.chips) != 1))
        outputs.save(self.steps, bench.save_steps)
        outputs.save(self.save_memory, lambda path: write_image(path, memory_of(bench, path).content))
        outputs.save(self.vcd, lambda path: self.write_vcd(bench, path))
        outputs.written += self.layouts
        outputs.save(self.plot, lambda path: bench.plot(path, pins=self.plotted(bench), dark=self.dark))

    def write_vcd(self, bench: Bench, path: str) -> None:
        """Write the waveform; report on standard error any changes that are shorter than the file's time unit."""
        pins = None if self.pins is None else [self.full_name(bench, pin) for pin in self.pins]
        timescale, buses = self.timescale or "1 ns", self.vcd_buses or DEFAULT_BUSES
        lost = bench.save_vcd(path, pins, timescale=timescale, buses=buses, values=self.vcd_values, layout=self.layout)
        if lost:
            what = f"{path}: {lost} changes of level last less than {timescale} and are not in the file"
            click.echo(f"slewline: {what}; a finer --timescale shows them", err=True)

    def conclude(self, bench: Bench, ended: str, outputs: Outputs) -> None:
        """Print a summary and the names of the files written; if quiet, print only the findings that fail the run."""
        from .report import summary

        if not self.quiet:
            for line in summary(bench, ended):
                click.secho(line, bold=True)
            for path in outputs.written:
                click.echo(f"wrote {path}")
        else:
            wrong = self.wrong(bench)
            for found in wrong:
                click.echo(f"slewline: {found}", err=True)
            if hidden := len(bench.findings) - len(wrong):
                what = counted(hidden, "finding")
                click.echo(
                    f"slewline: {what}; the transcript without -q shows them, --strict makes them a failure", err=True
                )

    def take_script(self, do: str, what: dict[str, Any]) -> None:
        """Keep an external input that is a script for a host, to check later whether it is for another chip."""
        if do == "script":
            self.scripts.append(tuple(what["args"]))

    def refusal(self, error: ProgramError) -> str:
        """Return a message with the lines that cannot be played and the chip, if any, that they seem to be for."""
        from .dialects import foreign

        if self.program is None:
            return str(error)
        text, file, part = self.program
        return "\n".join(filter(None, (str(error), foreign(text, file, part, sheet_of(part)))))

    def foreign(self, bench: Bench) -> bool:
        """Report, on standard error, each script written for another chip; return whether there are any.

        A script should be written for the chip that its host commands.
        """
        from .dialects import foreign

        chips = bench.chips if bench.findings else {}
        found = [
            message
            for name, text, place in self.scripts
            if name in chips and (message := foreign(text, place, type(chips[name]), chips[name].sheet))
        ]
        for message in found:
            click.echo(f"slewline: {message}", err=True)
        return bool(found)

    def wrong(self, bench: Bench) -> list[Finding]:
        """Return the findings that fail the run: all in a strict run, else only the failed expectations of scripts."""
        return [found for found in bench.findings if self.strict or found.code == "expect"]


def check_input(bench: Bench, name: str, option_text: str) -> None:
    """Refuse a pin that the chip itself drives.

    Raises:
        UsageError: the pin is an output.
    """
    owner, _, pin = name.partition(".")
    chip = bench.chips.get(owner)
    if chip is None or pin not in chip.pins or chip.sheet.pin(pin).in_out != "out":
        return
    inputs = ", ".join(row.name for row in chip.sheet.pins if row.in_out in ("in", "both"))
    raise UsageError(f"{option_text}: {pin} is an output; the inputs of the {chip.sheet.part}: {inputs}")


def memory_of(bench: Bench, path: str) -> Eeprom | Ram:
    """Return the memory whose content will be saved to a file; refuse a bench without exactly one memory."""
    from ..parts.memories.memory import Eeprom, Ram

    found = [part for part in bench.parts.values() if isinstance(part, Eeprom | Ram)]
    if len(found) != 1:
        what = f"{len(found)} of them" if found else "none"
        raise Refused(
            f"{path}: --save-memory needs exactly one memory on the bench, which has {what}; leave out --save-memory"
        )
    return found[0]


def show(ps: int, who: str, kind: str, text: str) -> None:
    """Print a line of the transcript."""
    mark = "! " if kind == "finding" else ""
    click.echo(f"{seconds(ps):>13}  {who}  {click.style(mark + text, fg=COLOURS.get(kind), bold=bool(mark))}")


@contextmanager
def progress(bench: Bench, total: int, quiet: bool) -> Iterator[None]:
    """Show the progress of virtual time on a terminal, unless a transcript is printed there.

    Rich draws in its own thread and only reads the virtual time, so the run is not affected.
    """
    if not sys.stderr.isatty() or not (quiet or not sys.stdout.isatty()):
        yield
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, ProgressColumn, Task, TimeElapsedColumn
    from rich.text import Text

    class VirtualTime(ProgressColumn):
        def render(self, task: Task) -> Text:
            return Text(f"{seconds(bench.now_ps)} of {readable(total)}")

    class Bar(BarColumn):
        def render(self, task: Task) -> Any:
            task.completed = bench.now_ps
            return super().render(task)

    with Progress(Bar(), VirtualTime(), TimeElapsedColumn(), console=Console(stderr=True), transient=True) as shown:
        shown.add_task("run", total=total)
        yield
