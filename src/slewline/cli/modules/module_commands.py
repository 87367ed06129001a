"""The commands for a real module, its program and its motor: names and options."""

from __future__ import annotations

from typing import Any

import click

from ..options.command_kinds import HintingCommand
from ..options.shared import CRYSTAL, EXIT, path
from ..options.values import DIRECTORY, FILE, TimeWithUnit, UnitsPerStep, WholeNumber
from .module_options import PORT, chip_option, module_options, setting_options


@click.command("pull", cls=HintingCommand, short_help="Save the program of a real module.", epilog=EXIT)
@module_options
@path("--output", "-o", required=True, help="A new file for the program, such as weld.gs-c200s.")
@click.option(
    "--from",
    "base",
    type=WholeNumber(256),
    metavar="ADDRESS",
    help="Start of the program, in a memory with addresses.",
)
@click.option(
    "--eeprom",
    is_flag=True,
    help="Also save to a file the program that the EEPROM holds; RAM is restored.",
)
@click.option("--replace", is_flag=True, help="Replace an existing file.")
def pull_command(**options: Any) -> int:
    """Save the program and settings of a real module on PORT to a file for `slewline asm` and `slewline push`.

    PORT is a name or URL that pySerial accepts: /dev/ttyUSB0, COM3, socket://HOST:PORT, rfc2217://HOST:PORT.
    The command reads the program (it is listed until two listings agree), the position, and the registers
    that the part can report.  The module is not changed, and no command is sent that may step the motor.
    Speeds and ramps of a GS-C are only in its program.  A CY525 or CY512 is read through an adapter, which
    accepts the same lines as a chip served with --framing; only the first 48 program bytes are read.

    With --eeprom the program in the EEPROM is saved too: it briefly replaces the one in RAM, which is saved
    first, then restored and verified.  The dialogue is recorded next to FILE, in FILE.dialogue.
    """
    from .pull_push import PullCommand

    return PullCommand(**options).perform()


@click.command("push", cls=HintingCommand, short_help="Send a program to a real module, and verify it.", epilog=EXIT)
@module_options
@click.argument("file", type=FILE)
@click.option("--store", is_flag=True, help="Store the program in the EEPROM, once it is verified.")
@path("--keep", help="Save the old program in this new file; by default FILE with .before in its name.")
@click.option(
    "--pace",
    type=TimeWithUnit(),
    metavar="TIME",
    help="Interval between the characters of a program sent to a memory with addresses; 21 ms by default.",
)
@click.option("--move", is_flag=True, help="Also send commands that may step the motor.")
def push_command(**options: Any) -> int:
    """Send a program to a real module on PORT, and verify it by its listing; it is not run.

    PORT is a name or URL that pySerial accepts: /dev/ttyUSB0, COM3, socket://HOST:PORT, rfc2217://HOST:PORT.
    The old program is saved first.  With --store the module stores the program in its EEPROM, but only after
    the listing has been found to match.  After an error the present content of the module is reported;
    repeating the command resumes from there.

    A GS-C200 stays in program entry, because the only command that ends it, E, also runs the program.
    """
    from .pull_push import PushCommand

    return PushCommand(**options).perform()


@click.command("epics", cls=HintingCommand, short_help="Serve an EPICS motor record for a real module.", epilog=EXIT)
@PORT
@click.argument("parameters", metavar="NAME=VALUE...", nargs=-1)
@chip_option("The part number of the module.")
@setting_options
@path("--dialogue", help="Record the dialogue in this new file.")
@click.option(
    "--record", required=True, metavar="NAME", help="Name of the record: its fields are NAME.VAL, NAME.RBV ..."
)
@click.option(
    "--resolution", type=UnitsPerStep(), default=1.0, metavar="UNITS", help="Units per step; negative: reversed."
)
@click.option("--units", default="steps", show_default=True, metavar="TEXT", help="The unit, such as mm.")
@CRYSTAL
@click.option(
    "--every",
    type=TimeWithUnit(),
    default="2 s",
    show_default=True,
    metavar="TIME",
    help="Interval of position queries at rest.",
)
@click.option("--replace", is_flag=True, help="Let moves replace the program in the module's RAM.")
@click.option("--allow-remote", is_flag=True, help="Other machines may connect, and move the motor.")
def epics_command(**options: Any) -> int:
    """Serve the motor of a real module on PORT as a motor record, over Channel Access, until SIGINT or SIGTERM.

    PORT is a name or URL that pySerial accepts: /dev/ttyUSB0, COM3, socket://HOST:PORT, rfc2217://HOST:PORT.
    The parameters set the ramp of every move, as in `slewline ramp CHIP`: S=10 T="1000 steps/s" R=50.  A put
    to VAL completes when the motor is at rest.

    A GS-C can move only by running a program: each move replaces the program in RAM, but not the one that
    command M has stored.

    Clients on this machine may connect; others only with --allow-remote, and only if
    EPICS_CAS_INTF_ADDR_LIST names an address that they can reach.
    """
    from .epics import EpicsCommand

    return EpicsCommand(**options).perform()


@click.command("firmware", cls=HintingCommand, short_help="Write the firmware of a board, or check it.", epilog=EXIT)
@click.argument("name", required=False)
@click.option("--board", metavar="BOARD", help="The board: pico, uno.")
@path("--output", "-o", help="The file to write; by default its own name in the current directory.")
@click.option("--from", "source", metavar="DIR", type=DIRECTORY, help="The folder of a file built elsewhere.")
@click.option("--check", "port", metavar="PORT", help="Write nothing; check the board on this serial port.")
@setting_options
@click.option("--replace", is_flag=True, help="With --check: also enter a program; the program stored by M is kept.")
@click.option(
    "--move", is_flag=True, help="With --check and --replace: run the program, 120 steps, and send faulty lines."
)
@path("--dialogue", help="With --check: record the dialogue in this new file.")
@click.option("--tolerance", type=TimeWithUnit(), help="With --check: as for slewline compare.")
def firmware_command(**options: Any) -> int:
    """Write the firmware of a board to a file, and print how to load it; without NAME, list all firmware.

    gs-c200s and gs-c200 turn a Raspberry Pi Pico into a replacement for a module; uno turns an Arduino Uno
    into the board for slewline drive.  The command looks for the file next to the installed wheel, in the
    build of a checkout, and in the current directory.

    With --check, a fixed set of lines is sent to the board, and its answers are compared with those of the
    model, as with slewline compare.  First switch the board on, with its user inputs open.  PORT is a name
    or URL that pySerial accepts; rate and checksums are detected.  Exit status 1 if an answer or a delay
    differs.
    """
    from .check_board import firmware

    return firmware(**options)
