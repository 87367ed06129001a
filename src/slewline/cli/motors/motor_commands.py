"""The commands about motors: names and options."""

from __future__ import annotations

from typing import Any

import click

from ..options.command_kinds import HintingCommand
from ..options.shared import CRYSTAL, EXIT, JSON, MOTOR_HELP, OPTIONS, path
from ..options.values import STEPS, PartName, WholeNumber
from .wizard import AskingCommand


@click.command(
    "calibrate",
    cls=HintingCommand,
    short_help="Find friction and iron loss of a motor from the rates at which it stalls.",
    epilog=EXIT,
)
@click.option("--motor", required=True, metavar="MOTOR", help=MOTOR_HELP)
@click.option("--driver", required=True, metavar="TEXT", help="Its driver, such as 'L/4R 20 V' or '24 V, 1 A'.")
@click.option("--load", default="", metavar="TEXT", help="Its load, such as 'inertia 68 g cm2'.")
@click.option("--start-stop", metavar="RATE", help="The highest rate at which it starts from rest, '900 steps/s'.")
@click.option("--pull-out", metavar="RATE", help="The rate at which it stalls when accelerated slowly, '1800 steps/s'.")
@click.option(
    "--torque",
    default="0",
    metavar="TEXT",
    help="Torque on the shaft at that stall, in addition to the load: '50 mNm'.",
)
@click.option("--stepping", default="full", show_default=True, metavar="HOW", help="full, wave, half, or 'micro 8'.")
@JSON
def calibrate_command(**options: Any) -> int:
    """Find the two constants of a motor that no data sheet lists, friction and iron loss.

    Measure a real motor with a known driver and load: the highest rate at which it starts from rest
    determines the friction; the rate at which it stalls when accelerated slowly, over a second or more,
    determines the iron loss.  Rates are in full steps/s.  The command prints the constants, the values
    assumed before this calibration, and the rows for a bench file.
    """
    from .calibrate import calibrate

    return calibrate(**options)


@click.command(
    "tune", cls=AskingCommand, short_help="Find the fastest ramp of a chip that a motor can follow.", epilog=EXIT
)
@click.argument("chip", type=PartName())
@click.option("--motor", required=True, metavar="MOTOR", help=MOTOR_HELP)
@click.option(
    "--driver", required=True, metavar="TEXT", help="Its driver, such as 'L/4R 20 V' or '24 V, 1 A averaged'."
)
@click.option("--load", metavar="TEXT", help="Its load, such as 'inertia 68 g cm2, friction 5 mNm, torque 30 mNm'.")
@click.option(
    "--steps",
    type=STEPS,
    required=True,
    metavar="N",
    help="Steps of the move, from rest to rest.",
)
@click.option("--stepping", default="full", show_default=True, metavar="HOW", help="full, wave, half, or 'micro 8'.")
@click.option("--grid", metavar="TEXT", help="Values to try: 'F=3..10 R=4..40/12 S=1,100,200'; others have defaults.")
@click.option(
    "--perturb", metavar="TEXT", help="Perturbations: 'load 20%, supply -10%'; 'none'; by default ten of them."
)
@click.option(
    "--jobs",
    type=WholeNumber(2),
    metavar="N",
    help="Number of processes; by default all processors for a map, else one.",
)
@click.option(
    "--dask",
    "cluster",
    metavar="ADDRESS",
    help="A Dask cluster, tcp://HOST:PORT. It runs any code sent to it: use only your own.",
)
@path("--store", metavar="F.jsonl", help="Log of all runs, from which an interrupted sweep continues.")
@click.option(
    "--map", "full_map", is_flag=True, help="Simulate every candidate, and print the perturbation that makes it fail."
)
@click.option(
    "--switching/--no-switching",
    default=True,
    help="Also simulate the recommended ramp with a switching chopper, or not.",
)
@CRYSTAL
@JSON
@path("--plot", metavar="F.svg", help="Draw map, pull-out curve and lag (SVG, PNG or PDF).")
@path("--bench", metavar="F.toml", help="Write a bench file with the ramp, for slewline run.")
@OPTIONS
def tune_command(**options: Any) -> int:
    """Find, among the ramps of a chip, the fastest that a motor with its driver and load can follow.

    Every move that the chip can make on a grid of parameters is a candidate.  Candidates are simulated, the
    fastest first, with the physics of the motor, under perturbations of load, inertia, supply, current,
    friction and drag, until one completes without lost steps under all of them: this is the best move.  The
    recommended move is the fastest that also never lags by more than 1.8 steps, and none of whose neighbours
    in the grid loses steps.

    A Dask cluster runs any code that a client sends, and the results that it returns can run code in the
    client: name only your own cluster.
    """
    from .tune import tune

    return tune(**options)
