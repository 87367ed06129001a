"""slewline demo: the welding machine of the CY525 manual, section 4, with picture and waveform."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from ..core.timebase import readable
from ..errors import UsageError
from .files import Outputs
from .transcript import seconds

if TYPE_CHECKING:
    from ..bench import Bench
    from ..core.net import Net

HERE = Path(__file__).parent
SOURCES = ("weld.toml", "weld.cy525")
PINS = ("x.wait", "x.dowhile", "x.run", "x.programmable_output", "x.slew")


def demo(output: str) -> int:
    """Run the machine; returns the exit status."""
    from ..bench.file import load_bench

    folder = made(output)
    outputs = Outputs([])
    plots = [outputs.claim(str(folder / f"weld{ending}")) for ending in (".svg", ".png")]
    waveform = outputs.claim(str(folder / "weld.vcd"))
    for name in SOURCES:
        outputs.write_bytes(str(folder / name), (HERE / name).read_bytes())

    began = perf_counter()
    bench = load_bench(folder / SOURCES[0])
    bench.record()
    show = Show(bench)
    bench.run_until_idle()
    show.end(perf_counter() - began)

    for path in plots:
        title = "CY525: six welds on each of two workpieces"
        outputs.save(path, lambda path: bench.plot(path, title, PINS, start=show.started))
    outputs.save(waveform, bench.save_vcd)
    says = ("the machine ...", "... and its program: change them, then slewline run", "plot", "plot", "waveform, for GTKWave")
    for path, text in zip(outputs.written, says, strict=True):
        click.echo(f"  {path:<24} {text}")
    return 0


def made(output: str) -> Path:
    """The folder, made if there is none."""
    try:
        Path(output).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"{output}: no folder can be made there ({error.strerror}); give another one with --output") from None
    return Path(output)


class Show:
    """Tells what the machine does while it does it, a line a spot."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.chip = bench, bench["x"]
        self.torch: Any = bench["torch"]
        self.piece = self.spot = self.started = 0
        for pin, observer in (("run", self.ran), ("wait", self.placed), ("programmable_output", self.welded)):
            self.chip.pin(pin).net.watch(observer)
        click.secho("The welding machine of the CY525 manual: six spots on each of two workpieces\n", bold=True)
        click.echo(f"{'seconds':>10}   {'position':>8}")

    def say(self, text: str, **style: Any) -> None:
        """A line: when, where, what."""
        click.echo(f"{seconds(self.bench.now_ps)[:-3]:>10}   {self.chip.position:>8}   {click.style(text, **style)}")

    def ran(self, net: Net) -> None:
        """RUN: the program begins or ends."""
        if net.level == 0:
            self.started = self.bench.now_ps
            self.say(f"the program, {len(self.chip.program)} bytes, runs and waits for a workpiece")
        else:
            self.say("no workpiece is left: the program ends")

    def placed(self, net: Net) -> None:
        """WAIT: a workpiece comes or goes."""
        if net.level == 1:
            self.piece += 1
            self.spot = 0
            self.say(f"workpiece {self.piece} lies ready", fg="cyan")

    def welded(self, net: Net) -> None:
        """PROGRAMMABLE OUTPUT: the torch."""
        if net.level == 0 and self.spot:
            burnt = readable(self.bench.now_ps - self.lit)
            self.say(f"  spot {self.spot}  {'*' * self.spot:<6}  {burnt}", fg="yellow")
        elif net.level == 1:
            self.spot += 1
            self.lit = self.bench.now_ps

    def end(self, took: float) -> None:
        """What it came to."""
        steps = self.chip.steps()
        times = steps.times_ps
        fastest = round(10**12 / int((times[1:] - times[:-1]).min()))
        click.echo(
            f"\n{len(self.torch.spots)} spots, {len(steps):,} steps, up to {fastest} steps/s, {len(self.bench.findings)} findings:"
            f" {readable(self.bench.now_ps // 10**9 * 10**9)} at the machine, {took:.2f} s here\n"
        )
