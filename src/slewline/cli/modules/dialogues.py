"""The commands about dialogues with a real module: what they take."""

from __future__ import annotations

from typing import Any

import click

from ..options.kinds import HintingCommand
from ..options.shared import EXIT, path
from ..options.values import Frequency, PartName, Strap

MARKINGS = click.option("--markings", default="", metavar="TEXT", help="What is printed on the module, for the record.")


@click.command(
    "proxy", cls=HintingCommand, short_help="Between a host program and its module: record what they say.", epilog=EXIT
)
@click.option("--serial", metavar="DEV", required=True, help="The serial port of the module, as pySerial takes it.")
@click.option("--pty", metavar="LINK", help="The host opens a pseudo-terminal, under the name of this link.")
@click.option("--tcp", metavar="HOST:PORT", help="The host connects to this port.")
@click.option("--part", required=True, type=PartName(), metavar="CHIP", help="What the module is.")
@click.option("--baud", type=int, metavar="RATE", help="Its rate; the highest one that it has by default.")
@click.option("--checksum/--no-checksum", default=None, help="Do lines end in checksums?  Found in the dialogue, else.")
@click.option("--address", type=int, default=0, metavar="N", help="Of the module, on a line of several.")
@click.option("--strap", type=Strap(), multiple=True, help="How it is strapped, such as chs=1. May be repeated.")
@MARKINGS
@click.option("--crystal", type=Frequency(), help="Its clock, such as '11 MHz', where that is known.")
@path("--dialogue", required=True, help="A new file for the dialogue.")
@click.option("--allow-remote", is_flag=True, help="Other machines may connect to the port of --tcp.")
def proxy_command(**options: Any) -> int:
    """Stand between a host program and its module, until SIGINT, SIGTERM or SIGHUP: pass on, and record.

    Every character goes on at once, in both directions; nothing is added, and nothing held back.  What the host sends
    moves the motor as ever.  The record is a dialogue file, which `slewline compare` replays with the model.
    """
    from .proxy import ProxyCommand

    return ProxyCommand(**options).perform()
