"""The command line options of `slewline translate`."""

from __future__ import annotations

from typing import Any

import click

from ..options.command_kinds import HintingCommand
from ..options.shared import CHIP, CRYSTAL, EXIT, JSON, path
from ..options.values import FILE, FREQUENCY, WholeNumber


@click.command("translate", cls=HintingCommand, short_help="Move a program to another part or controller.", epilog=EXIT)
@click.argument("file", type=FILE)
@click.option("--to", required=True, metavar="TARGET", help="A part (slewline chips), or another controller.")
@CHIP
@CRYSTAL
@click.option("--target-crystal", type=FREQUENCY, help="The crystal of the target; its usual one by default.")
@path(
    "--output", "-o", help="Write the result to a file (for a bench: a folder), and the report to the standard output."
)
@click.option("--steps-per-mm", type=float, metavar="N", help="For targets that count millimetres; 1 by default.")
@click.option("--axis", default="X", show_default=True, help="The axis, for targets that have several.")
@click.option(
    "--unroll",
    type=WholeNumber(1000, least=1),
    default=1000,
    metavar="N",
    show_default=True,
    help="Greatest number of lines of an unrolled loop, if the target has no loops.",
)
@click.option("--set", "settings", multiple=True, metavar="NAME=VALUE",
              help="A setting that the program leaves open: output1=low, or another of the target.")  # fmt: skip
@click.option("--strict", is_flag=True, help="Write nothing unless every line is the same.")
@click.option("--prove", is_flag=True, help="Run source and result, and compare steps, outputs and times.")
@path("--plot", metavar="F.svg", help="With --prove: draw both runs in one picture (SVG, PNG or PDF).")
@JSON
def translate_command(**options: Any) -> int:
    """Translate a program for another part or controller, and report the result for each line.

    FILE is a program, or a bench file (.toml): each program of a bench becomes a file in the folder
    --output, and if the target is a part, the bench itself is translated as well.

    Each line is reported as the same, as nearly the same (with the difference), or as not possible (with the
    limit of the target, and a manual remedy).  Without --output the result goes to standard output and the
    report to standard error.  Exit status 1 if a line is not possible, or if the runs differ by more than
    the report states.

    Run the result without a load first, or use --prove, which runs and compares both versions.
    """
    from ..files import is_bench

    if is_bench(options["file"]):
        from .translate_bench_command import translate_bench_file

        return translate_bench_file(**options)
    from .translate_command import translate

    return translate(**options)
