"""The command that puts a real module into a laboratory: what it takes."""

from __future__ import annotations

from typing import Any

import click

from ..options.kinds import HintingCommand
from ..options.shared import CRYSTAL, EXIT, path
from ..options.values import TimeWithUnit, UnitsPerStep
from .options import PORT, chip_option, setting_options


@click.command("epics", cls=HintingCommand, short_help="A motor record of EPICS for a real module.", epilog=EXIT)
@PORT
@click.argument("parameters", metavar="NAME=VALUE...", nargs=-1)
@chip_option("What it is.")
@setting_options
@path("--dialogue", help="Write what is said into this new file.")
@click.option("--record", required=True, metavar="NAME", help="Of the record: its fields are NAME.VAL, NAME.RBV ...")
@click.option(
    "--resolution", type=UnitsPerStep(), default=1.0, metavar="UNITS", help="Units per step; below 0: turned round."
)
@click.option("--units", default="steps", show_default=True, metavar="TEXT", help="Such as mm.")
@CRYSTAL
@click.option(
    "--every",
    type=TimeWithUnit(),
    default="2 s",
    show_default=True,
    metavar="TIME",
    help="How often a motor at rest is asked where it is.",
)
@click.option("--replace", is_flag=True, help="Moves may replace the program in the module's RAM.")
@click.option("--allow-remote", is_flag=True, help="Other machines may connect, and move the motor.")
def epics_command(**options: Any) -> int:
    """Serve the motor behind a real module on PORT as a motor record, on Channel Access, until SIGINT or SIGTERM.

    PORT is what pySerial takes: /dev/ttyUSB0, COM3, socket://HOST:PORT, rfc2217://HOST:PORT.  The parameters are those
    of the ramp of every move, as `slewline ramp CHIP` has them: S=10 T="1000 steps/s" R=50.  A put to VAL completes
    when the motor is at rest.

    A GS-C takes moves in programs alone: each replaces the program in RAM, not the one that M has kept.

    Clients of this machine may connect; others only if EPICS_CAS_INTF_ADDR_LIST names an address that they
    reach, with --allow-remote.
    """
    from .epics import EpicsCommand

    return EpicsCommand(**options).perform()
