"""The commands for dialogues with a real module: names and options."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..options.command_kinds import HintingCommand
from ..options.shared import ALLOW_CODE, EXIT, JSON, MEMORY, OPTIONS, STRAPS, path
from ..options.values import FILE, TimeWithUnit, WholeNumber
from .module_options import CLOCK, ECHO, MARKINGS, PORT, chip_option, setting_options

ADDRESS = click.option("--address", type=WholeNumber(2), metavar="N", help="Address of the module, on a shared line.")
CHECKSUM = click.option(
    "--checksum/--no-checksum", default=None, help="Lines end in checksums, or not; by default as in the dialogue."
)


@click.command(
    "proxy", cls=HintingCommand, short_help="Record the dialogue of a host program and its module.", epilog=EXIT
)
@click.option(
    "--serial",
    metavar="DEV",
    required=True,
    help="The serial port of the module: a device or URL that pySerial accepts.",
)
@click.option("--pty", metavar="LINK", help="Open a pseudo-terminal for the host, with a link of this name.")
@click.option("--tcp", metavar="HOST:PORT", help="Open this TCP port for the host.")
@chip_option("The part number of the module.")
@click.option(
    "--baud", type=WholeNumber(9600), metavar="RATE", help="Rate of the module; by default the highest one that it has."
)
@CHECKSUM
@ADDRESS
@ECHO
@STRAPS
@MARKINGS
@CLOCK
@path("--dialogue", required=True, help="A new file for the dialogue.")
@click.option("--allow-remote", is_flag=True, help="Other machines may connect to the port of --tcp.")
def proxy_command(**options: Any) -> int:
    """Relay characters between a host program and its module, and record them, until SIGINT, SIGTERM or SIGHUP.

    Every character is passed on immediately, in both directions; none is added or held back.  The commands of the host
    move the motor as usual.  The record is a dialogue file, which `slewline compare` replays with the model.
    """
    from .proxy import ProxyCommand

    return ProxyCommand(**options).perform()


@click.command("decode", cls=HintingCommand, short_help="Print the dialogue on two wires of a recording.", epilog=EXIT)
@click.argument("file", metavar="CAPTURE", type=FILE)
@chip_option("The part number of the module.")
@click.option("--host", metavar="SIGNAL", required=True, help="The wire on which the host sends, such as D0.")
@click.option("--module", metavar="SIGNAL", required=True, help="The wire on which the module sends.")
@click.option(
    "--baud", type=WholeNumber(9600), metavar="RATE", help="The rate; by default the best fit of the part's rates."
)
@CHECKSUM
@ADDRESS
@click.option("--timescale", type=TimeWithUnit(), help="The unit of the times, if the file states none.")
@click.option("--threshold", metavar="VOLTS", help="The threshold for an oscilloscope's CSV, such as '1.4 V'.")
@click.option("--torn", is_flag=True, help="Accept a truncated file, and read its complete part.")
@path("--dialogue", help="Write the dialogue to this new file, which `slewline compare` replays with the model.")
def decode_command(**options: Any) -> int:
    """Read the characters on two recorded wires, and print the dialogue of host and module.

    CAPTURE is a VCD file, a CSV file from a logic analyser or an oscilloscope, or a PulseView session (.sr).
    The character format is that of the part; TTL and RS-232 levels are detected.  Exit status 1 if a
    character is damaged.
    """
    from ..recordings.decode import decode

    return decode(**options)


@click.command(
    "terminal", cls=HintingCommand, short_help="Open a terminal to a real module, line by line.", epilog=EXIT
)
@PORT
@chip_option("The part number of the module.")
@setting_options
@path("--dialogue", help="Record the dialogue in this new file.")
@click.option("--plain", is_flag=True, help="Use Python's line input, without menus.")
@click.option("--model/--no-model", default=True, help="Check every line with the model, or not.")
@STRAPS
@MARKINGS
@CLOCK
@OPTIONS
def terminal_command(**options: Any) -> int:
    """Exchange lines with a real module on PORT, until Ctrl-D; the lines that you send may move the motor.

    PORT is a name or URL that pySerial accepts: /dev/ttyUSB0, COM3, socket://HOST:PORT, rfc2217://HOST:PORT.
    Lines are sent with the checksum, the address and the terminator that the part needs.  The tab key
    completes commands, the row below the prompt shows the text of the manual, and :help lists all commands.
    Every line also goes to the model, which starts in the state after power-up; findings of the model are
    printed below the line, each with a !.
    """
    from .terminal import TerminalCommand

    return TerminalCommand(**options).perform()


@click.command(
    "compare",
    cls=HintingCommand,
    short_help="Compare a measured waveform, or a dialogue, with the model's.",
    epilog=EXIT,
)
@click.argument("model", metavar="MODEL.vcd | DIALOGUE", type=FILE)
@click.argument("measured", metavar="[MEASURED]", type=FILE, required=False)
@click.option(
    "--tolerance",
    type=TimeWithUnit(),
    help="Times that differ by less agree; by default the sampling interval of two waveforms, or a computer's time to "
    "receive.",
)
@JSON
@click.option(
    "--map",
    "pairs",
    metavar="NAME=NAME",
    multiple=True,
    help="Waveforms: signals that belong together, the model's first: x.pulse=D0,x.direction=D1. May be repeated.",
)
@click.option(
    "--shift",
    metavar="TIME",
    default="first",
    show_default=True,
    help="Waveforms: offset of the measured times, such as '-1.2 ms'; first: align the first edges; best: align the "
    "most edges.",
)
@click.option(
    "--invert",
    metavar="NAME",
    multiple=True,
    help="Waveforms: this signal was measured inverted, as after an optocoupler; all: every signal. May be repeated.",
)
@click.option(
    "--threshold", metavar="VOLTS", help="Waveforms: the threshold for an oscilloscope's CSV, such as '1.4 V'."
)
@click.option("--timescale", type=TimeWithUnit(), help="Waveforms: the unit of the measured times, if none is stated.")
@click.option("--torn", is_flag=True, help="Waveforms: accept a truncated file, and read its complete part.")
@click.option(
    "--port", metavar="PORT", help="Dialogue: repeat it with the module on this port, and compare the result."
)
@click.option("--move", is_flag=True, help="With --port: allow commands that may step the motor.")
@click.option("--replace", is_flag=True, help="With --port: allow commands that replace the program of the module.")
@path("--report", help="Dialogue: write a file for a report: part, markings, crystal and transcript only.")
@chip_option("Dialogue: the part, if it differs from the recorded one.", required=False)
@click.option(
    "--baud", type=WholeNumber(9600), metavar="RATE", help="Dialogue: the rate, if it differs from the recorded one."
)
@CHECKSUM
@ADDRESS
@ECHO
@STRAPS
@MARKINGS
@CLOCK
@MEMORY
@OPTIONS
@ALLOW_CODE
def compare_command(**options: Any) -> int:
    """Compare a measurement with the model: the signals of a waveform file, or the dialogue with a module.

    For two waveforms, one of a run and one of a logic analyser, the missing, extra, late and early edges of
    each signal are reported, and the drift of the measured clock; exit status 1 if any edge differs.
    Without --map, signals of the same name are compared, whatever their scopes.  --shift first and
    --shift best use only the first of the compared signals for the alignment.  MEASURED is a VCD file, a
    CSV file from a logic analyser or an oscilloscope, or a PulseView session (.sr).

    For a dialogue, as recorded by `slewline proxy` and other commands, every line is sent to the model at
    its recorded time, in virtual time, and every answer or delay that differs is reported; exit status 1 if
    any of them differs.  The module and its model should begin in the same state: start the recording with a
    module that has just been switched on.
    """
    return compare(**options)


WAVEFORMS = ("pairs", "shift", "timescale", "torn", "invert", "threshold")  # options for waveforms, and for dialogues
DIALOGUES = (
    *(
        "port",
        "move",
        "replace",
        "report",
        "part",
        "baud",
        "checksum",
        "address",
        "echo",
        "strap",
        "markings",
        "crystal",
        "memory",
    ),
    "options",
    "allow_code",
)


def compare(model: str, measured: str | None, **options: Any) -> int:
    """Compare two waveforms or, if `measured` is None, a dialogue with the model; return the exit status."""
    from .compare_dialogue import CompareDialogue, is_dialogue

    for name in filter(None, (model, measured)):
        if measured is not None and Path(name).is_file() and is_dialogue(name):
            raise click.UsageError(f"{name} is a dialogue, which is compared only with the model; name {ALLOWED}")
    wrong = DIALOGUES if measured is not None else WAVEFORMS
    given = [name for name in wrong if options[name] not in (None, False, (), "first")]
    if given:
        names = ", ".join(f"--{'map' if name == 'pairs' else name}" for name in given)
        has = "two waveforms" if measured is not None else "a dialogue"
        raise click.UsageError(f"{names}: not an option for {has}; leave it out, or name {ALLOWED}")
    rest = {name: value for name, value in options.items() if name not in wrong}
    if measured is None:
        if model.lower().endswith(".vcd"):
            raise click.UsageError(f"Missing argument 'MEASURED.vcd'.  Name {ALLOWED}")
        if not is_dialogue(model):
            raise click.UsageError(f"{model} is not a dialogue; name {ALLOWED}")
        return CompareDialogue(dialogue=model, **rest).perform()
    from ..recordings.compare import compare as compare_waveforms

    return compare_waveforms(model, measured, **rest)


ALLOWED = "MODEL.vcd and MEASURED.vcd, or a dialogue that slewline has recorded"

DIALOGUE_COMMANDS = (compare_command, decode_command, proxy_command, terminal_command)
