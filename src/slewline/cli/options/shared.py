"""Options that several commands have."""

from __future__ import annotations

from functools import partial

import click

from .command_kinds import OncePerName
from .values import FILE, FREQUENCY, PartName, Strap, look_here

EXIT = "Exit status: 0 all is well, 1 a problem was found or time ran out, 2 wrong use."
MOTOR_HELP = "A name of the list, figures 'current 2 A, resistance 1.4 ohm, ...', or a file MOTOR.toml with them."
path = partial(click.option, metavar="F", type=FILE)
CHIP = click.option(
    "--chip",
    type=PartName(),
    is_eager=True,
    metavar="CHIP",
    help="The part; by default that of the ending of FILE, as in .cy525.",
)
ALLOW_CODE = click.option(
    "--allow-code",
    is_flag=True,
    callback=look_here,
    help="Bench files, journals, dialogues may name a chip or part as module:Class, which runs the code of the module.",
)
CRYSTAL = click.option("--crystal", type=FREQUENCY, help="Such as '11 MHz'; the chip's own by default.")
MEMORY = path("--memory", help="Image of the memory beside the chip: a dump, or Intel HEX.")
ANYWHERE = click.option(
    "--anywhere",
    is_flag=True,
    help="The bench file may name files and links outside its own folder, and any device.",
)
OPTIONS = click.option(
    "--options",
    metavar="F.toml",
    help='Options of the chip (`describe` lists them), as a bench file has them: rate_table = "27k", [inferred] ...',
)
STRAPS = click.option(
    "--strap", cls=OncePerName, type=Strap(), multiple=True, help="Fix an input, such as chs=1. May be repeated."
)
TOKEN = click.option(
    "--token",
    metavar="TEXT",
    envvar="SLEWLINE_TOKEN",
    help="What clients of the control port must send; also taken from the environment, SLEWLINE_TOKEN.",
)
JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON instead.")
