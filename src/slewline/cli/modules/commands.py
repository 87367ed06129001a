"""The commands for the program of a real module: what they take."""

from __future__ import annotations

from typing import Any

import click

from ..options.kinds import HintingCommand
from ..options.shared import EXIT, path
from ..options.values import FILE, TimeWithUnit, WholeNumber
from .options import module_options


@click.command("pull", cls=HintingCommand, short_help="Save what a real module holds.", epilog=EXIT)
@module_options
@path("--output", "-o", required=True, help="A new file for the program, such as weld.gs-c200s.")
@click.option(
    "--from",
    "base",
    type=WholeNumber(256),
    metavar="ADDRESS",
    help="Where the program begins in a memory with addresses.",
)
@click.option(
    "--eeprom",
    is_flag=True,
    help="Save also the program that is kept without power; RAM is put back.",
)
@click.option("--replace", is_flag=True, help="The file may be there already.")
def pull_command(**options: Any) -> int:
    """Save what a real module on PORT holds into a file that `slewline asm` and `slewline push` take.

    PORT is what pySerial takes: /dev/ttyUSB0, COM3, socket://HOST:PORT, rfc2217://HOST:PORT.  Read are the program, by
    its listing until two listings agree, the position, and the registers for which the part may be asked.  Nothing in
    the module changes, and nothing is sent that may make a step.  Speeds and ramps of a GS-C are only in its program.
    A CY525 or CY512 is read through an adapter, which takes the lines that a served one takes with --framing, and gives
    the first 48 bytes of its program.

    With --eeprom the program that is kept without power takes the place of that in RAM, which is saved first, put back,
    and verified.  Beside FILE stands all that was said, FILE.dialogue.
    """
    from .programs import PullCommand

    return PullCommand(**options).perform()


@click.command("push", cls=HintingCommand, short_help="Send a program to a real module, and verify it.", epilog=EXIT)
@module_options
@click.argument("file", type=FILE)
@click.option("--store", is_flag=True, help="Let the module keep the program without power, once it is verified.")
@path("--keep", help="Save what was there into this new file; by default FILE with .before in its name.")
@click.option(
    "--pace",
    type=TimeWithUnit(),
    metavar="TIME",
    help="From one character of a program to the next, where a memory takes them: 21 ms.",
)
@click.option("--move", is_flag=True, help="Send also commands that may make the motor step.")
def push_command(**options: Any) -> int:
    """Send a program to a real module on PORT, and verify it by its listing; nothing is run.

    PORT is what pySerial takes: /dev/ttyUSB0, COM3, socket://HOST:PORT, rfc2217://HOST:PORT.  What was there is saved
    first.  With --store the module keeps the program without power, but only after its listing has agreed.  Where
    something goes wrong, what stands in the module is said; the same command again goes on from there.

    A GS-C200 stays in program entry, since only E ends it, which runs the program.
    """
    from .programs import PushCommand

    return PushCommand(**options).perform()
