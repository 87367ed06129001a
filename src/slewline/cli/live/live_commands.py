"""The commands that run until they are stopped: names, options, and the modules that do their work."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from ..options.command_kinds import HintingCommand, OncePerName
from ..options.shared import ALLOW_CODE, ANYWHERE, CHIP, CRYSTAL, EXIT, MEMORY, OPTIONS, STRAPS, TOKEN, path
from ..options.values import DIRECTORY, FILE, STEP_RATE, TIME, AnyNumber, PartName, SettingText, WholeNumber

Command = Callable[..., Any]


def together(*options: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """Return several options as one decorator, for commands that share them."""

    def decorate(command: Command) -> Command:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


PORTS = together(
    click.argument("chip", type=PartName(), required=False, is_eager=True),
    path("--bench", metavar="FILE", help="A bench file with [[serve]] tables, instead of CHIP."),
    path("--pty", metavar="LINK", help="Serve on a pseudo-terminal, with a link of this name. Linux; macOS: 8N1 only."),
    click.option(
        "--tcp", metavar="HOST:PORT", help="Serve on a TCP socket; 4001 alone: on this machine; port 0: any free port."
    ),
    click.option(
        "--rfc2217", metavar="HOST:PORT", help="Serve on a TCP socket that accepts rate, parity, DTR and RTS settings."
    ),
    path("--serial", metavar="DEV", help="Serve on a serial port of this machine: /dev/ttyUSB0, COM3."),
    click.option(
        "--registers", metavar="HOST:PORT", help="Serve the bus of a chip that also has a serial line, on a TCP socket."
    ),
    click.option(
        "--card", help="The interface board of a chipset: pi-c842, or offsets such as data=0,command=1,status=1."
    ),
    click.option("--framing", is_flag=True, help="For a chip on a bus: lines of text, with read-back."),
    click.option("--prologix", is_flag=True, help="For a chip on a bus: a GPIB controller with Prologix commands."),
    click.option("--baud", hidden=True),
)
SERVED = together(
    click.option(
        "--control",
        metavar="HOST:PORT",
        help="Control port with JSON lines: pins, time, faults, status; for any language.",
    ),
    TOKEN,
    click.option("--state", metavar="DIR", type=DIRECTORY, help="The folder for the contents of EEPROMs."),
    path("--log", help="Append a transcript of all lines to F; -: to standard error."),
    path("--journal", help="Record every external input, for slewline run --replay."),
    MEMORY,
    ANYWHERE,
    ALLOW_CODE,
    STRAPS,
    click.option(
        "--option",
        cls=OncePerName,
        type=SettingText(),
        multiple=True,
        help="Option of the chip (`describe` lists them), such as 'eeprom_time=20 ms'.",
    ),
    click.option(
        "--allow-remote", is_flag=True, help="Other machines may connect; to the control port with --token only."
    ),
    click.option("--status", is_flag=True, help="Show a status line every second; without it, on SIGUSR1."),
)


@click.command(
    "serve", cls=HintingCommand, short_help="Serve chips on ports, to unmodified host software.", epilog=EXIT
)
@PORTS
@click.option("--rate", metavar="R", help="Virtual seconds per second of the wall clock; 1 by default.")
@click.option("--lockstep", is_flag=True, help="Let time pass only while bytes are on the line, and by `advance`.")
@SERVED
@click.option(
    "--panel",
    metavar="HOST:PORT",
    is_flag=False,
    flag_value="127.0.0.1:0",
    help="Also open a panel, a page for a web browser; without HOST:PORT on any free port.",
)
@OPTIONS
def serve_command(**options: Any) -> int:
    """Serve a chip on a port, where host software finds it as if it were real, until SIGINT, SIGTERM or SIGHUP.

    Each port is printed on the standard output as soon as it is open: its name, and the URL or the device
    under which pySerial finds it.  By default a module runs at 9600 baud with checksums (--strap chs=0
    switches them off).

    A pseudo-terminal has 8 bits and no parity, whatever the host sets.  A host may request 7O2
    repeatedly, but the second of two requests in quick succession fails with EINVAL (invalid argument).  A
    host makes such requests if it sets a timeout right after it opens the port, makes its settings one by
    one, opens the port right after closing it, or uses stty.  Set such a host to 8N1, or open
    socket://HOST:PORT (--tcp) or rfc2217://HOST:PORT (--rfc2217); a program in Python can also open
    slewline://gs-c200s, without any server.

    The MC1451A family has registers instead of a serial line, and is served with --tcp only.
    registers://HOST:PORT accepts the messages of slewline.links.ports.register_port; the client is
    slewline.links.clients.chipset_port for a program in Python, and examples/mc1451a/slewline_port.h for one
    in C that reads and writes I/O ports.

    For a chip with a bus and a serial line, use one of the serial ports above for the line, and --registers
    for the bus: it serves the registers of a parallel card at registers://HOST:PORT, and the client is
    slewline.links.clients.card_port.  The line runs at 9600 baud, unless a host on --rfc2217 sets
    another rate.
    """
    from .serve import ServeCommand

    return ServeCommand(**options).perform()


@click.command(
    "drive", cls=HintingCommand, short_help="Drive a real motor with a chip, a board, and the old host.", epilog=EXIT
)
@PORTS
@path("--board", metavar="PORT", required=True, help="The serial port of the board; twin: a simulated board.")
@click.option("--of", metavar="CHIP[.AXIS]", help="The chip and axis of the motor, if a bench has several.")
@click.option("--enable", is_flag=True, help="Energise the driver. Without it: dry run, no pulses and no current.")
@click.option(
    "--pulses",
    is_flag=True,
    help="Output pulses in a dry run too; the motor moves if ENABLE of its driver is not wired.",
)
@click.option(
    "--driver",
    metavar="NAME",
    help="The driver, such as DM542: sets the level of ENABLE and checks pulse times; --enable needs it.",
)
@click.option(
    "--enable-off",
    type=click.Choice(["rest", "halt", "never"]),
    default="halt",
    show_default=True,
    help="When the board switches the driver off: whenever the motor is at rest; after a halt or without a host; "
    "never. Except with never, also at the end. An E-stop always does.",
)
@click.option(
    "--enable-hold",
    type=TIME,
    metavar="TIME",
    default="60 s",
    show_default=True,
    help="Delay before the driver is switched off.",
)
@click.option("--invert-dir", is_flag=True, help="Invert DIR against the direction pin of the chip.")
@click.option(
    "--filter",
    type=WholeNumber(3, least=0, most=15),
    default=0,
    help="Number of equal samples, 4 us apart, before a change of an input counts; an E-stop is not filtered.",
)
@click.option(
    "--input",
    cls=OncePerName,
    type=SettingText("an input of the board and its signal", "A1=home"),
    multiple=True,
    help="Signal of an input of the board, such as A1=home or A0=estop. May be repeated.",
)
@click.option(
    "--output",
    cls=OncePerName,
    type=SettingText("an output of the board and its signal", "D12=fault"),
    multiple=True,
    help="Signal of an output of the board: D2=uo1, D12=fault, D8=energised; by default the pins that programs set. "
    "May be repeated.",
)
@click.option(
    "--horizon",
    type=TIME,
    metavar="TIME",
    default="100 ms",
    show_default=True,
    help="Delay from a step of the model to that of the motor; it must exceed any pause of this machine.",
)
@click.option(
    "--start-stop",
    type=STEP_RATE,
    metavar="RATE",
    help="Highest rate at which the motor stops without a ramp, such as '500 steps/s'.",
)
@click.option(
    "--stop",
    type=click.Choice(["abort", "kill", "reset", "power"]),
    help="How the chip is stopped when the board has stopped by itself.",
)
@click.option("--self-start", is_flag=True, help="Let a program that the chip starts by itself move the motor.")
@click.option(
    "--keep-count",
    is_flag=True,
    help="Start the position register at the count of a board that has kept running since an earlier session.",
)
@click.option("--homed", is_flag=True, help="Confirm that the count of the board is the position of the motor.")
@click.option(
    "--check",
    is_flag=True,
    help="Check link, machine and board for ten seconds, with D9 wired only to D4. With --enable, jog the motor by "
    "ten steps instead; with an E-stop among the inputs, test that it opens.",
)
@click.option(
    "--black-box", metavar="DIR", type=DIRECTORY, help="Record sessions in this folder, instead of the usual one."
)
@click.option("--no-black-box", is_flag=True, help="Record nothing.")
@SERVED
@OPTIONS
def drive_command(**options: Any) -> int:
    """Replace a failed chip with a virtual one: a port connects the old host, and a board steps the motor.

    The board can stop by itself, and it counts the steps, but it is not a safety device: an E-stop must cut
    the supply of the driver.

    The board is an Arduino Uno or Nano with the firmware that `make boards` builds.  The host is connected
    to the chip by one of the ports, as with `slewline serve`.  While the motor moves, steps and characters
    are output with a fixed delay, the horizon.  A board that stops by itself, because of an input, an E-stop
    or a lost host, reports its position; the drive is then halted until `clear` is typed or SIGUSR2 is
    received.  If the board has switched the driver off, the driver stays off until you type `clear homing`,
    to home the motor, or `clear homed`, if you know its position.
    """
    from .drive import DriveCommand

    return DriveCommand(**options).perform()


@click.command("panel", cls=HintingCommand, short_help="Show and operate a chip in a web browser.", epilog=EXIT)
@click.argument("what", metavar="[CHIP | BENCH.toml | PROGRAM]", required=False, is_eager=True)
@CHIP
@click.option(
    "--attach", metavar="HOST:PORT", help="Attach to the control port of a running server, instead of a chip."
)
@TOKEN
@click.option(
    "--listen", metavar="HOST:PORT", default="127.0.0.1:0", help="The address of the page; by default any free port."
)
@click.option("--read-only", is_flag=True, help="Let the page view, but not operate.")
@click.option("--rate", metavar="R", help="Virtual seconds per second of the wall clock; 1 by default.")
@click.option("--run", is_flag=True, help="Let time run from the start; otherwise a program waits for the page.")
@click.option("--no-browser", is_flag=True, help="Open no web browser; print the address only.")
@STRAPS
@path("--journal", help="Record every external input, for slewline run --replay.")
@ANYWHERE
@ALLOW_CODE
@click.option("--allow-remote", is_flag=True, help="Other machines may connect; they need the address with its token.")
def panel_command(**options: Any) -> int:
    """Open a panel, a web page that shows a chip and operates it, until SIGINT, SIGTERM or SIGHUP.

    It shows pins, registers, program and conversation; you can pause time, advance it in steps, and go back.
    The host sends a PROGRAM to the chip, as `slewline run` does; time is paused until *Run the program* is
    pressed, unless --run is given.  If a bench file has [[serve]] tables, their ports are opened, and time
    runs from the start.  With --attach the panel shows the bench of a running server, whatever host program
    is connected; the token of its control port is taken from the environment, SLEWLINE_TOKEN.

    The address of the page is printed.  Any browser with the page's token may operate the chip; without the
    token the page is read-only.
    """
    from .panel import PanelCommand

    return PanelCommand(**options).perform()


@click.command(
    "debug",
    cls=HintingCommand,
    short_help="Debug a program in the terminal: step, stop, and go back in time.",
    epilog=EXIT,
)
@click.argument("target", metavar="[FILE | CHIP | BENCH.toml]", required=False, type=FILE, is_eager=True)
@CHIP
@CRYSTAL
@STRAPS
@OPTIONS
@MEMORY
@ANYWHERE
@ALLOW_CODE
@click.option(
    "--rate", type=AnyNumber("0.5"), default=1.0, show_default=True, help="Virtual seconds per second, 0.001 to 1000."
)
@click.option("--attach", metavar="HOST:PORT", help="Debug the bench of the server with this control port, instead.")
@click.option(
    "--control", metavar="HOST:PORT", help="Show no screen: open a control port, for a front end of your own."
)
@TOKEN
@click.option("--while-input", is_flag=True, hidden=True)  # ends with the standard input
def debug_command(**options: Any) -> int:
    """Debug a program, a chip or a bench file: registers, pins, the program and the conversation on one screen.

    Time is paused at the first instant.  The space bar lets it run, s steps one instruction, b sets a breakpoint, the
    left arrow goes back; ? lists the keys.
    """
    from .debug import DebugCommand

    return DebugCommand(**options).perform()
