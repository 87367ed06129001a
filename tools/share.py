"""Write share/man/man1/slewline.1, the man page, from the command line.

python tools/share.py            write it
python tools/share.py --check    fail if the committed one differs from the command line

The wheel has share/ in the place where systems expect it, with man pages and shell completion.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import command_line

from slewline import __version__

MAN_PAGE = Path(__file__).resolve().parent.parent / "share/man/man1/slewline.1"
NOTE = "Written by tools/share.py; change the code, not this file."
ENVIRONMENT = (
    ("NO_COLOR", "If not empty, output is not coloured."),
    ("SLEWLINE_CACHE", "Folder for machine code of motors; if empty, none is kept."),
    ("SLEWLINE_TOKEN", "The token of a control port, hidden from process lists."),
)
EXAMPLES = (
    ("The welding machine of the CY525 manual, with a picture and a waveform:", "slewline demo"),
    ("A GS-C200 on a TCP port, whose program survives power-off:",
     "slewline serve gs-c200 --strap chs=0 --tcp 127.0.0.1:4001 --state eeprom/"),
    ("A program, with its transcript and all pins as a waveform:", "slewline run shuttle.cy525 --vcd shuttle.vcd"),
    ("Times and steps of a ramp:", "slewline ramp cy525 F=3 R=127 S=200"),
)  # fmt: skip


def roff(text: str) -> str:
    """Return a text as roff: with hyphens that can be copied, bold options, and no line that would be a request."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    text = re.sub(r"(?<![\w-])(?:\\-){1,2}[a-z][a-z0-9]*(?:\\-[a-z0-9]+)*", r"\\fB\g<0>\\fR", text)
    return re.sub(r"^(?=[.'])", r"\\&", text, flags=re.MULTILINE)


def prose(text: str) -> Iterator[str]:
    """Yield the lines of paragraphs."""
    for paragraph in filter(None, text.split("\n\n")):
        yield from (".PP", roff(paragraph))


def tagged(rows: Iterator[tuple[str, str]]) -> Iterator[str]:
    """Yield the lines of a list: the name of each row, and its description."""
    for written, says in rows:
        yield from (".TP", roff(written) if written.startswith("-") else f"\\fB{roff(written)}\\fR", roff(says))


def verbatim(lines: list[str]) -> Iterator[str]:
    """Yield lines that are kept unchanged."""
    yield from (".PP", ".nf", *(re.sub(r"\\f[BR]", "", roff(line)) for line in lines), ".fi")


def man_page() -> str:
    """Return the man page."""
    what, statuses = command_line.about()
    first, _, rest = what.partition("\n\n")
    lines = [
        f'.\\" {NOTE}',
        f'.TH SLEWLINE 1 "" "slewline {__version__}" "User Commands"',
        ".SH NAME",
        f"slewline \\- {roff(first[0].lower() + first[1:].rstrip('.'))}",
        ".SH SYNOPSIS",
        ".B slewline",
        "[\\fIOPTIONS\\fR] \\fICOMMAND\\fR [\\fIARGS\\fR]...",
        ".SH DESCRIPTION",
        *prose(rest),
        ".SH COMMANDS",
    ]
    for command in command_line.commands():
        lines += [f".SS {roff(command.name)}", f"\\fB{roff(command.usage)}\\fR", *prose(command.text)]
        lines += tagged(iter(command.options))
    lines += [".SH RUN SCRIPTS", *verbatim(command_line.script_guide())]
    lines += [".SH EXIT STATUS", roff(statuses.removeprefix("Exit status: "))]
    lines += [".SH ENVIRONMENT", *tagged(iter(ENVIRONMENT)), ".SH EXAMPLES"]
    for says, typed in EXAMPLES:
        lines += [*prose(says), *verbatim([f"    $ {typed}"])]
    return re.sub(r"^(\.SH .*)\n\.PP$", r"\1", "\n".join(lines), flags=re.MULTILINE) + "\n"


def main() -> int:
    """Write the man page, or check it; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    if not parser.parse_args().check:
        MAN_PAGE.write_text(man_page(), "utf-8")
    elif MAN_PAGE.read_text("utf-8") != man_page():
        print("share/man/man1/slewline.1 differs from the command line; run: python tools/share.py")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
