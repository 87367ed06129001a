"""Options shared by several commands."""

from __future__ import annotations

from functools import partial

import click

from .command_kinds import OncePerName
from .values import FILE, FREQUENCY, PartName, Strap, look_here

EXIT = "Exit status: 0 success, 1 a problem was found or time ran out, 2 wrong use."
MOTOR_HELP = "A name from the list, figures 'current 2 A, resistance 1.4 ohm, ...', or a file MOTOR.toml with them."
path = partial(click.option, metavar="F", type=FILE)
CHIP = click.option(
    "--chip",
    type=PartName(),
    is_eager=True,
    metavar="CHIP",
    help="The part; by default the extension of FILE, such as .cy525.",
)
ALLOW_CODE = click.option(
    "--allow-code",
    is_flag=True,
    callback=look_here,
    help="Bench files, journals, dialogues may name a chip or part as module:Class, which runs the code of the module.",
)
CRYSTAL = click.option(
    "--crystal", type=FREQUENCY, help="Crystal frequency, such as '11 MHz'; by default the chip's usual one."
)
MEMORY = path("--memory", help="Image of the chip's external memory: a dump, or Intel HEX.")
ANYWHERE = click.option(
    "--anywhere",
    is_flag=True,
    help="Let the bench file name files and links outside its own folder, and any device.",
)
OPTIONS = click.option(
    "--options",
    metavar="F.toml",
    help='Options of the chip (`describe` lists them), as in a bench file: rate_table = "27k", [inferred] ...',
)
STRAPS = click.option(
    "--strap",
    cls=OncePerName,
    type=Strap(),
    multiple=True,
    help="Strap an input to a level, such as chs=1. May be repeated.",
)
TOKEN = click.option(
    "--token",
    metavar="TEXT",
    envvar="SLEWLINE_TOKEN",
    help="Token for clients of the control port; also taken from the environment, SLEWLINE_TOKEN.",
)
JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON instead.")
