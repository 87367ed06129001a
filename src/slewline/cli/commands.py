"""The commands: their names and options, and for each the module that does its work."""

from __future__ import annotations

from typing import Any

import click

from .live.live_commands import debug_command, drive_command, panel_command, serve_command
from .modules.dialogues import DIALOGUE_COMMANDS
from .modules.module_commands import epics_command, firmware_command, pull_command, push_command
from .motors.motor_commands import calibrate_command, tune_command
from .options import completion
from .options.command_kinds import CommandGroup, CommandWithGuide, OncePerName
from .options.shared import ALLOW_CODE, ANYWHERE, CHIP, CRYSTAL, EXIT, JSON, MEMORY, OPTIONS, STRAPS, path
from .options.values import (
    DIRECTORY,
    FILE,
    STEPS,
    Names,
    PartName,
    PinDrive,
    QuantityWithUnit,
    TimeWithUnit,
    WholeNumber,
)
from .packages.new_commands import INTO, new_chip_command, new_part_command
from .translation.translation_commands import translate_command


def _show_version(context: click.Context, _option: click.Parameter, asked: bool) -> None:
    if asked and not context.resilient_parsing:
        from .version_line import version_line

        click.echo(version_line())
        context.exit()


@click.group(
    cls=CommandGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110}, epilog=EXIT
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_show_version,
    help="Show the version and the build, and exit.",
)
def cli() -> None:
    """Programmable stepper motor controllers, as software.

    A file holds the commands that a host computer would send to the chip, one per line.  Try: slewline demo

    CHIP is a part number such as cy525 (slewline chips lists them), or a chip of your own, module:Class.  Python
    searches its usual path for the module, then the current directory.
    """


@cli.command(
    "run", cls=CommandWithGuide, short_help="Run a program, or a bench file of several chips and parts.", epilog=EXIT
)
@click.argument("file", required=False, type=FILE, is_eager=True)  # other options refer to its chip
@CHIP
@CRYSTAL
@click.option("--over", metavar="CHANNEL", help="Channel of a chip with several, such as serial.")
@STRAPS
@click.option(
    "--until", type=TimeWithUnit(), help="Run or replay to this instant, such as '2 s'; by default until all is idle."
)
@click.option("--timeout", type=TimeWithUnit(), help="Longest wait until all is idle; 60 s by default.")
@click.option(
    "--drive", type=PinDrive(), multiple=True, help="Drive a pin: 'abort=0@12 ms', 'x.wait=1'. May be repeated."
)
@click.option("--strict", is_flag=True, help="Exit status 1 if there are findings.")
@click.option("-q", "--quiet", is_flag=True, help="Print no transcript.")
@path("--journal", help="Record every external input, for --replay.")
@path("--replay", help="Repeat the run of a journal, instead of FILE.")
@MEMORY
@path("--save-memory", help="Write the final content of the memory; .hex: as Intel HEX.")
@click.option(
    "--other-laws", is_flag=True, help="Replay a journal even if the behaviour of parts has changed, with a warning."
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
    help="With --vcd: write a bus as single wires, which every viewer reads (the default), as a whole, or both.",
)
@click.option("--vcd-values", is_flag=True, help="With --vcd: also velocity, position, commands and findings.")
@click.option("--layout", is_flag=True, help="With --vcd: layouts for GTKWave and Surfer next to it (.gtkw, .sucl).")
@path("--plot", metavar="F.svg", help="Draw velocity and position (SVG, PNG or PDF).")
@click.option("--dark", is_flag=True, help="Draw the plot light on dark.")
@OPTIONS
def run_command(**options: Any) -> int:
    """Run a program on a virtual chip, or a bench file (BENCH.toml) with several chips and parts.

    FILE holds the text that a host would send; - is the standard input.  The bytes of a .hex file go to a
    chip in binary mode.  A GS-C module is strapped for 9600 baud without checksums, unless --strap sets
    other values.

    A command refused by the chip is a finding.  Findings alone do not fail a run, except with --strict (exit
    status 1).  The exit status is also 1 if the program is for another chip: either no line is a command of
    this chip, or most lines are not commands of it and every line is a command of another chip.
    """
    from .run import RunCommand

    return RunCommand(**options).perform()


@cli.command("asm", short_help="Assemble a stored program.", epilog=EXIT)
@click.argument("file", type=FILE)
@CHIP
@path("--output", "-o", help="Write to a file; the extension .hex, .bin, .ihx or .ihex (an image) selects the format.")
@click.option(
    "--format",
    "form",
    type=click.Choice(["listing", "hex", "bin", "image", "ascii", "binary"]),
    help="hex, bin: the program buffer; image: in Intel HEX, at its address; ascii, binary: host data.",
)
@click.option("--resolve", is_flag=True, help="Replace labels with addresses.")
@click.option("--checksum", is_flag=True, help="With --format ascii: every line ends in its checksum (GS-C).")
@JSON
def asm_command(**options: Any) -> int:
    """Assemble a stored program: address, bytes and source of every instruction, or the bytes alone.

    The program is the part between the commands that begin and end program entry, such as E and Q.
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
    help="Format of FILE; detected by default. hex: pairs of digits, or Intel HEX.",
)
@click.option(
    "--stream", is_flag=True, help="FILE has the bytes that a host sends in binary mode, not a program buffer."
)
@click.option("--labels", is_flag=True, help="Name branch targets.")
@path("--output", "-o", help="Write to a file.")
@JSON
def dis_command(**options: Any) -> int:
    """Disassemble a program buffer; the text assembles to the same bytes."""
    from .programs import dis

    return dis(**options)


@cli.command("lint", short_help="Check programs for mistakes.", epilog=EXIT)
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=FILE)
@CHIP
@click.option("--strict", is_flag=True, help="Exit status 1 for warnings too.")
@ALLOW_CODE
@JSON
@OPTIONS
def lint_command(**options: Any) -> int:
    """Check programs, or the scripts of bench files (BENCH.toml), for mistakes; exit status 1 if there are errors.

    Nothing is run.  A line that makes `run` refuse to start is an error.
    """
    from .programs import lint

    return lint(**options)


cli.add_command(translate_command)


@cli.command("ramp", short_help="Calculate a ramp, or find the parameters of a ramp.", epilog=EXIT)
@click.argument("chip", type=PartName())
@click.argument("parameters", metavar="[NAME=VALUE]...", nargs=-1, shell_complete=completion.parameter)
@CRYSTAL
@click.option("--distance", type=STEPS, metavar="STEPS", help="Also report a move of this many steps.")
@click.option("--time", type=TimeWithUnit(), help="Find the ramp whose time is nearest to this, such as '0.5 s'.")
@click.option(
    "--accel",
    type=QuantityWithUnit("steps/s2"),
    metavar="A",
    help="Find the ramp whose mean acceleration is nearest to A, such as '20000 steps/s2'.",
)
@click.option("--steps", type=STEPS, metavar="N", help="Find the ramp whose number of steps is nearest to N.")
@click.option(
    "--best", type=WholeNumber(5, least=1), metavar="N", help="Number of nearest ramps to list; 5 by default."
)
@click.option("--table", is_flag=True, help="Print the ramp rate by rate, step by step, or cycle by cycle.")
@JSON
@path("--plot", metavar="F.svg", help="Draw velocity and position of the move (SVG, PNG or PDF).")
@OPTIONS
def ramp_command(**options: Any) -> int:
    """Calculate a ramp of a chip: its time, steps and acceleration, and the moves that reach its rate.

    Parameters have the names of the commands that set them: F, R, S, Z (CY525); F, R, S (CY545); S, T, R and
    law (GS-C); SET_VEL, SET_ACC, SET_START_VEL and output, or profile=s-curve with SET_VEL, SET_MAX_ACC,
    SET_JERK and output (MC1451A family).  Try: slewline ramp cy525 F=3 R=127 S=200

    A list of values, S=1,100,200, compares ramps; --plot draws them in one picture.

    A bare number is the value of the command; "SET_VEL=12345 steps/s" or "R=6000 steps/s" selects the value
    nearest to a rate, and "SET_ACC=20000 steps/s2" the value nearest to an acceleration.  With --time,
    --accel or --steps, some parameters may be left out: S and Z (CY525), S (CY545), R (GS-C), one of
    SET_ACC, SET_MAX_ACC and SET_JERK (MC1451A family).  Of all possible ramps, those nearest to the
    requested value are listed; if two are equally near, the slower comes first.  Of several ramps with the
    same time (or acceleration, or steps), only the slowest is listed; if several are equally slow, the one
    with the lowest Z, then with the lowest S, R, acceleration or jerk.
    """
    from .ramp import ramp

    return ramp(**options)


for motors in (calibrate_command, tune_command):
    cli.add_command(motors)


@cli.command(
    "check-capture", short_help="Check a recording of STEP and DIR against a driver's data sheet.", epilog=EXIT
)
@click.argument("file", metavar="CAPTURE", type=FILE)
@click.option(
    "--axis",
    "axes",
    cls=OncePerName,
    metavar="NAME=STEP,DIR",
    multiple=True,
    required=True,
    help="Signals of an axis. May be repeated.",
)
@click.option("--driver", metavar="NAME", help="The driver that receives them: DM542, or 'high 5 us, low 5 us'.")
@click.option("--edge", type=click.Choice(["rising", "falling", "both"]), default="rising", show_default=True,
              help="The edge of STEP that begins a step, at the point of recording.")  # fmt: skip
@click.option(
    "--forward",
    type=WholeNumber(1, least=0, most=1),
    default=1,
    show_default=True,
    help="Level of DIR at which positions count up.",
)
@click.option("--idle", type=WholeNumber(1, least=0, most=1), help="The level of STEP where it floats or is unknown.")
@click.option("--glitch", type=TimeWithUnit(), help="Shorter pulses are glitches; by default half of the median pulse.")
@click.option(
    "--chip", type=PartName(), metavar="CHIP", help="The part whose pins were recorded; its limits are checked, too."
)
@click.option(
    "--pin",
    "pins",
    cls=OncePerName,
    metavar="PIN=NAME",
    multiple=True,
    help="A pin of the part, and its signal. May be repeated.",
)
@CRYSTAL
@click.option("--timescale", type=TimeWithUnit(), help="The unit of the times, if the file states none.")
@click.option("--threshold", metavar="VOLTS", help="The threshold for an oscilloscope's CSV, such as '1.4 V'.")
@click.option("--torn", is_flag=True, help="Accept a truncated file, and read its complete part.")
@path("--plot", metavar="F.svg", help="Draw the worst violation, or the time nearest to its limit (SVG, PNG, PDF).")
@JSON
def check_capture_command(**options: Any) -> int:
    """Check a recording of STEP and DIR: pulse widths, set-up and hold of DIR, glitches, jitter, skew between axes.

    CAPTURE is a VCD file, a CSV file from a logic analyser or an oscilloscope, or a PulseView session (.sr).
    Exit status 1 if a limit is violated by more than the sampling interval can explain, or if there is a
    glitch.
    """
    from .recordings.capture import capture

    return capture(**options)


@cli.command("describe", short_help="Print the reference of a chip, or of a command.", epilog=EXIT)
@click.argument("chip", type=PartName())
@click.argument("command", required=False, shell_complete=completion.command)
@JSON
@OPTIONS
def describe_command(**options: Any) -> int:
    """Print the reference of a chip, or of one of its commands, from its data sheet."""
    from .programs import describe

    return describe(**options)


@cli.command("chips", short_help="List the chips, one line each.", epilog=EXIT)
@JSON
def chips_command(**options: Any) -> int:
    """List the chips, one line each."""
    from .programs import chips

    return chips(**options)


for live in (
    serve_command,
    drive_command,
    panel_command,
    debug_command,
    pull_command,
    push_command,
    *DIALOGUE_COMMANDS,
    epics_command,
):
    cli.add_command(live)


@cli.command("help", hidden=True)
@click.argument("command", required=False)
@click.pass_context
def help_command(ctx: click.Context, command: str | None) -> int:
    """Print the help of a command, or of all commands."""
    if command is None:
        click.echo((ctx.parent or ctx).get_help())
        return 0
    return int(cli.main([command, "--help"], prog_name="slewline", standalone_mode=False) or 0)


@cli.command("demo", short_help="Run the welding machine of the CY525 manual.", epilog=EXIT)
@click.option(
    "--output",
    "-o",
    metavar="DIR",
    default="build/demo",
    show_default=True,
    help="The folder for the files.",
    type=DIRECTORY,
)
def demo_command(output: str) -> int:
    """Run the welding machine of the CY525 manual: six spots on each of two workpieces, with picture and waveform."""
    from .demo import demo

    return demo(output)


@cli.command("examples", short_help="List the examples, or copy one.", epilog=EXIT)
@click.argument("name", required=False, shell_complete=completion.example)
@INTO
def examples_command(**options: Any) -> int:
    """List the examples and lessons that come with the package, or copy one out.

    NAME is a file, whose folder and extension may be omitted, or a folder such as drill, which is copied
    whole.  A bench file is copied with its folder.  The lessons are notebooks: open the folder in Jupyter.
    """
    from .examples import examples

    return examples(**options)


cli.add_command(firmware_command)
cli.add_command(new_chip_command)
cli.add_command(new_part_command)
