"""slewline demo: the welding machine of the CY525 manual, section 4, with a picture and a waveform."""

from __future__ import annotations

import os
import shutil
import sys
import sysconfig
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from ..core.time.timebase import readable
from ..errors import UsageError
from ..record.waveforms.viewer_layouts import layout_paths
from .files import Outputs
from .transcript import seconds

if TYPE_CHECKING:
    from ..bench import Bench
    from ..core.wires.net import Net

HERE = Path(__file__).parent
MACHINE, PROGRAM = "weld.toml", "weld.cy525"
TITLE = "CY525: six welds on each of two workpieces"
AROUND_PS = 10**11  # shown in the plot before the first workpiece and after the end
TIMESCALE = "1 us"  # no pulse is shorter; PulseView stores one sample per unit
DESCRIPTIONS = (
    "the bench file",
    "the program",
    "velocity, position and pins",
    "the same picture",
    "all pins, velocity and position, for a waveform viewer such as PulseView",
    "their layout for GTKWave",
    "their layout for Surfer",
)
PINS = ("x.wait", "x.dowhile", "x.run", "x.programmable_output", "x.slew")


def demo(output: str) -> int:
    """Run the welding machine, and write its picture and waveform to a folder; return the exit status."""
    from ..bench.file import BenchFile

    folder = made(output)
    outputs = Outputs([])
    waveform = folder / "weld.vcd"
    pictures, layouts = [folder / "weld.svg", folder / "weld.png"], layout_paths(waveform)
    copies = [folder / name for name in (MACHINE, PROGRAM)]
    for path in (*pictures, waveform, *layouts, *copies):
        outputs.claim(str(path), own=True)
    for copy in copies:
        outputs.write_bytes(str(copy), (HERE / copy.name).read_bytes())

    bench = BenchFile(folder / MACHINE).load()
    bench.record()
    show = Show(bench)
    began = perf_counter()
    bench.run_until_idle()
    show.end(perf_counter() - began)

    bench.run(AROUND_PS)
    for picture in pictures:
        outputs.save(str(picture), lambda path: bench.plot(path, TITLE, PINS, start=show.started - AROUND_PS))
    outputs.save(str(waveform), lambda path: bench.save_vcd(path, timescale=TIMESCALE, values=True, layout=True))
    outputs.written += [str(layout) for layout in layouts]
    for name, text in zip(outputs.written, DESCRIPTIONS, strict=True):
        click.echo(f"{name:<{len(str(folder)) + 12}}  {text}")
    machine = word(folder / MACHINE)
    click.echo(f"\nChange the machine or the program, then: {called_as()} run {machine}")
    click.echo(f"Watch it run, and operate its pins, in a web browser: {called_as()} panel {machine}")
    return 0


def made(output: str) -> Path:
    """Return the path of a folder, which is created if it does not exist."""
    try:
        Path(output).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"{output}: cannot create this folder ({error.strerror})"
        raise UsageError(f"{message}; give another folder with --output") from None
    return Path(output)


def called_as() -> str:
    """Return the shell command that calls this installation of slewline from the current folder.

    It is "slewline" if the shell finds this installation by that name, otherwise the path of its script; if
    the package is not installed, it is python -m slewline.
    """
    own = shutil.which("slewline", path=sysconfig.get_path("scripts"))
    if own is None:  # the package is next to the caller, not installed
        return f"{word(sys.executable)} -m slewline"
    # The additions of `uv run` to the PATH are lost when it ends.
    found = None if "UV_RUN_RECURSION_DEPTH" in os.environ else shutil.which("slewline")
    if found and os.path.samefile(found, own):
        return "slewline"
    script = Path(own).with_suffix("")  # the name as typed, without .exe
    return word(script.relative_to(Path.cwd()) if script.is_relative_to(Path.cwd()) else script)


def word(path: str | Path) -> str:
    """Return a path quoted as a single shell word."""
    return f'"{path}"' if " " in str(path) else str(path)


class Show:
    """A live report of the welding machine, with a line for each spot."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.chip = bench, bench.chips["x"]
        self.piece = self.spot = self.spots = self.started = self.lit = 0
        for pin, observer in (("run", self.ran), ("wait", self.placed), ("programmable_output", self.welded)):
            self.chip.pin(pin).net.watch(observer)
        click.secho("The welding machine of the CY525 manual: six spots on each of two workpieces\n", bold=True)
        click.echo(f"{'seconds':>10}   {'position':>8}")

    def print_line(self, text: str, **style: Any) -> None:
        """Print a line with the present time and position, and a text."""
        click.echo(f"{seconds(self.bench.now_ps)[:-3]:>10}   {self.chip.position:>8}   {click.style(text, **style)}")

    def ran(self, net: Net) -> None:
        """Report a change of RUN: the program starts or ends."""
        if net.level == 0:
            self.print_line(f"the program, {len(self.chip.program)} bytes, runs and waits for a workpiece")
        else:
            self.print_line("no other workpiece: the program ends")

    def placed(self, net: Net) -> None:
        """Report a change of WAIT: a workpiece arrives or leaves."""
        if net.level == 1:
            self.started = self.started or self.bench.now_ps
            self.piece += 1
            self.spot = 0
            self.print_line(f"workpiece {self.piece} is in place", fg="cyan")

    def welded(self, net: Net) -> None:
        """Report a change of PROGRAMMABLE OUTPUT, which switches the torch."""
        if net.level == 1:
            self.spot += 1
            self.lit = self.bench.now_ps
        elif self.spot:
            self.spots += 1
            burnt = readable(self.bench.now_ps - self.lit)
            self.print_line(f"  spot {self.spot}  {'*' * self.spot:<6}  {burnt}", fg="yellow")

    def end(self, took: float) -> None:
        """Print the results; `took` is the computing time in seconds."""
        times = self.chip.steps().times_ps
        fastest = round(10**12 / int((times[1:] - times[:-1]).min()))
        click.echo(f"\n{self.spots} spots, {len(times):,} steps, up to {fastest:,} steps/s", nl=False)
        click.echo(f"; {seconds(self.bench.now_ps)[:-3]} s of the machine took {took:.3f} s here\n")
