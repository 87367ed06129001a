"""The commands: what they are called, what they take, and which module does the work."""

from __future__ import annotations

from typing import Any

import click

from .options import completion
from .options.kinds import CommandGroup, CommandWithGuide
from .options.shared import ALLOW_CODE, ANYWHERE, CHIP, CRYSTAL, EXIT, JSON, MEMORY, OPTIONS, path
from .options.values import DIRECTORY, FILE, Drive, Names, PartName, SettingText, Strap, TimeWithUnit
from .options.version_option import version_option


@click.group(
    cls=CommandGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110}, epilog=EXIT
)
@version_option
def cli() -> None:
    """Programmable stepper motor controllers, as software.

    A file holds what a host computer would send to the chip, a command a line.  Try: slewline demo

    CHIP is a part number such as cy525 (slewline chips lists them), or a chip of your own, module:Class.  The module is
    looked for wherever Python looks, then in the current directory.
    """


@cli.command(
    "run", cls=CommandWithGuide, short_help="Run a program, or a bench file of several chips and parts.", epilog=EXIT
)
@click.argument("file", required=False, type=FILE, is_eager=True)  # other options speak of its chip
@CHIP
@CRYSTAL
@click.option("--over", metavar="CHANNEL", help="The channel of a chip that has several, such as serial.")
@click.option("--strap", type=Strap(), multiple=True, help="Fix an input, such as chs=1. May be repeated.")
@click.option(
    "--until", type=TimeWithUnit(), help="Run or replay to this instant, such as '2 s'; else until all is idle."
)
@click.option("--timeout", type=TimeWithUnit(), help="How long to wait for that; 60 s by default.")
@click.option("--drive", type=Drive(), multiple=True, help="Drive a pin: 'abort=0@12 ms', 'x.wait=1'. May be repeated.")
@click.option("--strict", is_flag=True, help="Exit status 1 if there are findings.")
@click.option("-q", "--quiet", is_flag=True, help="No transcript.")
@path("--journal", help="Write every input from outside, for --replay.")
@path("--replay", help="Repeat the run of a journal, instead of FILE.")
@MEMORY
@path("--save-memory", help="Write what that memory holds at the end; .hex: as Intel HEX.")
@click.option(
    "--other-laws", is_flag=True, help="Replay also a journal of parts with another behaviour, with a warning."
)
@ANYWHERE
@ALLOW_CODE
@click.option(
    "--json",
    metavar="F",
    type=FILE,
    is_flag=False,
    flag_value="-",
    help="Write the result as JSON; - prints it.",
)
@path(
    "--steps",
    metavar="F.csv",
    help="Write every step: time_ps, chip, axis, direction, position; .npz: as arrays of NumPy.",
)
@path("--vcd", help="Write all pins as a VCD file, for waveform viewers.")
@click.option("--pins", type=Names(), help="With --vcd: only these pins, such as pulse,direction or x.slew,y.slew.")
@click.option("--timescale", help="With --vcd: the unit of its times, such as '1 us'; 1 ns by default.")
@click.option(
    "--vcd-buses",
    type=click.Choice(["bits", "whole", "both"]),
    help="With --vcd: a bus as its wires, which every viewer reads (the default), as a whole, or both.",
)
@click.option("--vcd-values", is_flag=True, help="With --vcd: also velocity, position, commands and findings.")
@click.option("--layout", is_flag=True, help="With --vcd: layouts for GTKWave and Surfer next to it (.gtkw, .sucl).")
@path("--plot", metavar="F.svg", help="Draw velocity and position (SVG, PNG or PDF).")
@click.option("--dark", is_flag=True, help="Draw the plot light on dark.")
@OPTIONS
def run_command(**options: Any) -> int:
    """Run a program on a virtual chip, or a bench file (BENCH.toml) with several chips and parts.

    FILE holds what a host would send; - is the standard input.  The bytes of a .hex file go to a chip in binary mode.
    A GS-C module is strapped for 9600 baud without checksums, unless --strap sets others.
    """
    from .run import RunCommand

    return RunCommand(**options).perform()


@cli.command("asm", short_help="Assemble a stored program.", epilog=EXIT)
@click.argument("file", type=FILE)
@CHIP
@path("--output", "-o", help="Write to a file; an ending .hex, .bin, .ihx or .ihex (an image) chooses the format.")
@click.option(
    "--format",
    "form",
    type=click.Choice(["listing", "hex", "bin", "image", "ascii", "binary"]),
    help="hex, bin: the program buffer; image: in Intel HEX, at its address; ascii, binary: what a host sends.",
)
@click.option("--resolve", is_flag=True, help="Store addresses where labels are meant.")
@click.option("--checksum", is_flag=True, help="With --format ascii: every line ends in its checksum (GS-C).")
@JSON
def asm_command(**options: Any) -> int:
    """Assemble a stored program: address, bytes and source of every instruction, or the bytes alone.

    The program is what is between the commands that begin and end its entry, such as E and Q.
    """
    from .programs import asm

    return asm(**options)


@cli.command("dis", short_help="Disassemble a program buffer.", epilog=EXIT)
@click.argument("file", type=FILE)
@CHIP
@click.option(
    "--format",
    "form",
    type=click.Choice(["hex", "bin"]),
    help="What FILE holds; by default as its content shows. hex: pairs of digits, or Intel HEX.",
)
@click.option("--stream", is_flag=True, help="FILE is what a host sends in binary mode, not a program buffer.")
@click.option("--labels", is_flag=True, help="Name branch targets.")
@path("--output", "-o", help="Write to a file.")
@JSON
def dis_command(**options: Any) -> int:
    """Disassemble a program buffer; the text assembles to the same bytes."""
    from .programs import dis

    return dis(**options)


@cli.command("lint", short_help="Look for mistakes in programs.", epilog=EXIT)
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=FILE)
@CHIP
@click.option("--strict", is_flag=True, help="Exit status 1 for warnings too.")
@ALLOW_CODE
@JSON
@OPTIONS
def lint_command(**options: Any) -> int:
    """Look for mistakes in programs, or in the scripts of bench files (BENCH.toml); exit status 1 if there are errors.

    Nothing is run; what `run` would refuse to begin with is an error.
    """
    from .programs import lint

    return lint(**options)


@cli.command("ramp", short_help="What a ramp does, and which parameters give the ramp that is wanted.", epilog=EXIT)
@click.argument("chip", type=PartName())
@click.argument("parameters", metavar="[NAME=VALUE]...", nargs=-1, shell_complete=completion.parameter)
@CRYSTAL
@click.option("--distance", type=int, metavar="STEPS", help="Report a move of so many steps, too.")
@click.option("--time", type=TimeWithUnit(), help="Find the ramp whose time is nearest to this, such as '0.5 s'.")
@click.option(
    "--accel", type=float, metavar="A", help="Find the ramp whose mean acceleration is nearest to A, in steps/s^2."
)
@click.option("--steps", type=float, metavar="N", help="Find the ramp whose steps are nearest to N.")
@click.option("--best", type=int, metavar="N", default=5, show_default=True, help="How many of the nearest to list.")
@click.option("--table", is_flag=True, help="Print the ramp rate by rate, step by step, or cycle by cycle.")
@JSON
@path("--plot", metavar="F.svg", help="Draw velocity and position of the move (SVG, PNG or PDF).")
@OPTIONS
def ramp_command(**options: Any) -> int:
    """Calculate a ramp of a chip: its time, its steps, its acceleration, and which moves reach its rate.

    Parameters have the names of the commands that set them: F, R, S, Z (CY525); F, R, S (CY545); S, T, R and law
    (GS-C); SET_VEL, SET_ACC, SET_START_VEL and output, or profile=s-curve with SET_VEL, SET_MAX_ACC, SET_JERK and
    output (MC1451A family).  Try: slewline ramp cy525 F=3 R=127 S=200

    A list of values, S=1,100,200, compares ramps; --plot draws them in one picture.

    A number is what the command takes; "SET_VEL=12345 steps/s" or "R=6000 steps/s" is the nearest to a rate, and
    "SET_ACC=20000 steps/s2" to an acceleration.  With --time, --accel or --steps these may be left out: S and Z, R,
    SET_ACC, one of SET_MAX_ACC and SET_JERK.  The nearest of all ramps that they can give are listed, the slower first
    of two that are equally near.  Of those with the same time (acceleration, steps) only one is listed: the slowest,
    then that with the least Z, then with the least S, R, acceleration or jerk.
    """
    from .ramp import ramp

    return ramp(**options)


@cli.command("compare", short_help="A measured waveform against the model's.", epilog=EXIT)
@click.argument("model", metavar="MODEL.vcd", type=FILE)
@click.argument("measured", metavar="MEASURED.vcd", type=FILE)
@click.option(
    "--map",
    "pairs",
    metavar="NAME=NAME",
    multiple=True,
    help="Signals that belong together, the model's first: x.pulse=D0,x.direction=D1. May be repeated.",
)
@click.option(
    "--shift",
    metavar="TIME",
    default="first",
    show_default=True,
    help="What is added to the measured times, such as '-1.2 ms'; first: the first edges meet; best: the most edges.",
)
@click.option(
    "--tolerance", type=TimeWithUnit(), help="Edges so far apart agree; by default the coarser unit of the two files."
)
@click.option("--timescale", type=TimeWithUnit(), help="The unit of MEASURED.vcd, if it states none.")
@click.option("--torn", is_flag=True, help="MEASURED.vcd may have been cut off; read what is there.")
@JSON
def compare_command(**options: Any) -> int:
    """Compare the signals of a measured waveform file, such as a logic analyser's, with those of a run.

    Reports of each signal which edges are missing, extra, late or early, and the drift of the measured clock; exit
    status 1 if there are such edges.  Without --map signals of the same name are compared, whatever their scopes.
    --shift first and best go by the first signal of the list.
    """
    from .compare import compare

    return compare(**options)


@cli.command("describe", short_help="The reference of a chip, or of a command.", epilog=EXIT)
@click.argument("chip", type=PartName())
@click.argument("command", required=False, shell_complete=completion.command)
@JSON
@OPTIONS
def describe_command(**options: Any) -> int:
    """Print the reference of a chip, or of one of its commands, from its data sheet."""
    from .programs import describe

    return describe(**options)


@cli.command("chips", short_help="The parts, one line each.", epilog=EXIT)
@JSON
def chips_command(**options: Any) -> int:
    """List the chips, one line each."""
    from .programs import chips

    return chips(**options)


@cli.command("serve", short_help="Serve chips on ports, to unmodified host software.", epilog=EXIT)
@click.argument("chip", type=PartName(), required=False, is_eager=True)
@path("--bench", metavar="FILE", help="A bench file with [[serve]] tables, instead of CHIP.")
@path("--pty", metavar="LINK", help="On a pseudo-terminal, found by a link of this name. Linux; macOS: 8N1 only.")
@click.option("--tcp", metavar="HOST:PORT", help="On a TCP socket, 4001 alone: of this machine; port 0: any free one.")
@click.option("--rfc2217", metavar="HOST:PORT", help="On a TCP socket that takes rate, parity, DTR and RTS.")
@path("--serial", metavar="DEV", help="On a serial port of this machine: /dev/ttyUSB0, COM3.")
@click.option(
    "--registers", metavar="HOST:PORT", help="The bus of a chip that also has a serial line: on a TCP socket."
)
@click.option("--framing", is_flag=True, help="For a chip on a bus: lines of text, which can also read back.")
@click.option("--baud", hidden=True)
@click.option("--rate", metavar="R", help="Virtual seconds per second of the wall clock; 1 by default.")
@click.option("--lockstep", is_flag=True, help="Time passes only for the bytes of the line, and by `advance`.")
@click.option("--control", metavar="HOST:PORT", help="JSON lines: pins, time, faults, status; from any language.")
@click.option(
    "--token",
    metavar="TEXT",
    envvar="SLEWLINE_TOKEN",
    help="What clients of the control port must send; also taken from the environment, SLEWLINE_TOKEN.",
)
@click.option("--state", metavar="DIR", type=DIRECTORY, help="Where the EEPROMs are kept.")
@path("--log", help="Append a transcript of all lines to F; -: on standard error.")
@path("--journal", help="Write every input from outside, for slewline run --replay.")
@MEMORY
@ANYWHERE
@ALLOW_CODE
@click.option("--strap", type=Strap(), multiple=True, help="Fix an input, such as chs=0. May be repeated.")
@click.option(
    "--option",
    type=SettingText(),
    multiple=True,
    help="Option of the chip (`describe` lists them), as 'eeprom_time=20 ms'.",
)
@click.option("--allow-remote", is_flag=True, help="Other machines may connect; to the control port with --token only.")
@click.option("--status", is_flag=True, help="Show a status line every second; else SIGUSR1 asks for one.")
@OPTIONS
def serve_command(**options: Any) -> int:
    """Put a chip on a port, where host software finds it as if it were real, until SIGINT, SIGTERM or SIGHUP.

    Each port is printed on the standard output as soon as it is open: its name, and the URL or the device under which
    pySerial finds it.  By default a module has 9600 baud and checksums (--strap chs=0: none).

    A pseudo-terminal has 8 bits and no parity, whatever the host asks for.  A host may open it as 7O2 again and again;
    one that sets 7O2 twice at once gets EINVAL (invalid argument): a timeout set right after the open, one setting
    after the other, an open right after a close, stty.  Set such a host to 8N1, or open socket://HOST:PORT (--tcp)
    or rfc2217://HOST:PORT (--rfc2217); a program in Python can also open slewline://gs-c200s, without any server.

    The MC1451A family has registers instead of a line, and is served with --tcp only.  registers://HOST:PORT takes the
    messages of slewline.links.ports.registers; their other end is slewline.links.clients.chipset_port for a program in
    Python, and examples/mc1451a/slewline_port.h for one in C that reads and writes I/O ports.

    A chip with a bus and a serial line has the line on one of these ports and the bus on --registers: the
    registers of a parallel card, at registers://HOST:PORT, whose other end is slewline.links.clients.card_port.
    The line has 9600 baud, unless a host on --rfc2217 sets another.
    """
    from .serve import ServeCommand

    return ServeCommand(**options).perform()


@cli.command("debug", short_help="Debug a program in the terminal: step, stop, and go back in time.", epilog=EXIT)
@click.argument("target", metavar="[FILE | CHIP | BENCH.toml]", required=False, type=FILE, is_eager=True)
@CHIP
@CRYSTAL
@click.option("--strap", type=Strap(), multiple=True, help="Fix an input, such as chs=1. May be repeated.")
@OPTIONS
@MEMORY
@ANYWHERE
@ALLOW_CODE
@click.option("--rate", type=float, default=1.0, show_default=True, help="Virtual seconds per second, 0.001 to 1000.")
@click.option("--attach", metavar="HOST:PORT", help="Debug what the server with this control port has, instead.")
@click.option("--control", metavar="HOST:PORT", help="No screen: open a control port, for a front end of your own.")
@click.option(
    "--token",
    metavar="TEXT",
    envvar="SLEWLINE_TOKEN",
    help="What clients of the control port must send; also taken from the environment, SLEWLINE_TOKEN.",
)
@click.option("--while-input", is_flag=True, hidden=True)  # ends with the standard input
def debug_command(**options: Any) -> int:
    """Debug a program, a chip or a bench file: registers, pins, the program and the conversation on one screen.

    Time stands at the first instant.  The space bar lets it pass, s goes on by an instruction, b puts a breakpoint, the
    left arrow goes back; ? lists the keys.
    """
    from .debug import DebugCommand

    return DebugCommand(**options).perform()


@cli.command("help", hidden=True)
@click.argument("command", required=False)
@click.pass_context
def help_command(ctx: click.Context, command: str | None) -> int:
    """Print the help of a command, or of all."""
    if command is None:
        click.echo((ctx.parent or ctx).get_help())
        return 0
    return int(cli.main([command, "--help"], prog_name="slewline", standalone_mode=False) or 0)


@cli.command("demo", short_help="The welding machine of the CY525 manual.", epilog=EXIT)
@click.option(
    "--output",
    "-o",
    metavar="DIR",
    default="build/demo",
    show_default=True,
    help="Where the files go.",
    type=DIRECTORY,
)
def demo_command(output: str) -> int:
    """Run the welding machine of the CY525 manual: six spots on each of two workpieces, with picture and waveform."""
    from .demo import demo

    return demo(output)


@cli.command("examples", short_help="Examples: list them, or copy one out.", epilog=EXIT)
@click.argument("name", required=False, shell_complete=completion.example)
@click.option(
    "--output",
    "-o",
    metavar="DIR",
    default=".",
    show_default=True,
    help="Where the files go.",
    type=DIRECTORY,
)
def examples_command(**options: Any) -> int:
    """List the examples that come with the package, or copy one out.

    NAME is a file, whose folder and ending may be left out, or a folder such as drill: all that is in it is copied.  A
    bench file comes with its folder.
    """
    from .examples import examples

    return examples(**options)
