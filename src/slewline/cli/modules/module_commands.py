"""The commands for a real module, its program and its motor in a laboratory: what they take."""

from __future__ import annotations

from typing import Any

import click

from ..options.command_kinds import HintingCommand
from ..options.shared import CRYSTAL, EXIT, path
from ..options.values import DIRECTORY, FILE, TimeWithUnit, UnitsPerStep, WholeNumber
from .module_options import PORT, chip_option, module_options, setting_options


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
    from .pull_push import PullCommand

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
    from .pull_push import PushCommand

    return PushCommand(**options).perform()


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


@click.command("firmware", cls=HintingCommand, short_help="Write the firmware of a board, or check it.", epilog=EXIT)
@click.argument("name", required=False)
@click.option("--board", metavar="BOARD", help="The board it is for: pico, uno.")
@path("--output", "-o", help="Where to write it; by default under its own name in the current directory.")
@click.option("--from", "source", metavar="DIR", type=DIRECTORY, help="The folder of a file that was built elsewhere.")
@click.option("--check", "port", metavar="PORT", help="Write nothing; ask the board at this serial port.")
@setting_options
@click.option("--replace", is_flag=True, help="With --check: enter a program, too; the program stored by M remains.")
@click.option("--move", is_flag=True, help="With --check and --replace: run it: 120 steps; and send faulty lines.")
@path("--dialogue", help="With --check: write the dialogue into this new file.")
@click.option("--tolerance", type=TimeWithUnit(), help="With --check: as of slewline compare.")
def firmware_command(**options: Any) -> int:
    """Write the firmware of a board to a file, and say how it gets onto the board; without NAME, list what there is.

    gs-c200s and gs-c200 make a Raspberry Pi Pico take the place of a module; uno makes an Arduino Uno step for slewline
    drive.  A file is looked for next to the installed wheel, in the build of a checkout, and in the current
    directory.

    With --check fixed lines are sent to the board, and its answers are compared with those of the model, as slewline
    compare does.  Switch the board on before, its user inputs open.  PORT is what pySerial takes; rate and
    checksums are looked for.  Exit status 1 if an answer or a delay differs.
    """
    from .check_board import firmware

    return firmware(**options)
