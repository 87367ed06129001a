"""Files of the command line: programs to be read, and outputs that are checked before anything runs."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..bench.files.hex_text import is_named_hex
from ..bench.files.toml import read_toml
from ..bench.scripts.program_file import program_text
from ..chips import CATALOGUE, sheet_of
from ..core.datasheet.option import checked
from ..core.datasheet.table import Sheet
from ..core.messages.near import hint
from ..errors import BenchFileError, UsageError
from ..gate import read_text

if TYPE_CHECKING:
    from ..core.chip import Chip

if TYPE_CHECKING:
    from ..record.whole_file import WholeFile

LONGEST = 1000  # characters of a line
STDIN = "-"


class Refused(click.ClickException):
    """An error in the command line or its files: nothing is run."""

    exit_code = 2

    def show(self, file: Any = None) -> None:
        """Print the message to standard error."""
        click.echo(f"slewline: {self.message}", err=True)


NO_PROGRAMS = {  # by file extension
    **dict.fromkeys(
        ("vcd", "csv", "sr"),
        "a recording; slewline compare MODEL.vcd MEASURED reads it, and so do check-capture and decode",
    ),
    "dialogue": "a dialogue; slewline compare DIALOGUE compares it with the model",
    **dict.fromkeys(("journal", "jsonl"), "a journal; slewline run --replay JOURNAL repeats it"),
    **dict.fromkeys(("svg", "png", "pdf"), "a picture"),
    "npz": "a result of a run",
    "ipynb": "a notebook; jupyter opens it",
    "listing": "a listing of slewline asm; the bytes are written by:  slewline asm FILE -o F.hex",
    "json": "JSON, such as results of a run; a bench file is TOML",
    **dict.fromkeys(("eeprom", "raw"), "the memory or the raw characters of a module"),
}


VCD = re.compile(r"\s*\$(comment|date|scope|timescale|var|version)\s")
LISTING = re.compile(r"[0-9A-F]{2,5}  [0-9A-F]{2}( [0-9A-F]{2})*  +\S")
NOTEBOOK = re.compile(r'\s*\{\s*"(cells|nbformat|metadata)":')
BEGINNINGS = {  # of texts, whatever their file names
    "; slewline raw ": "raw",
    '{"slewline":': "dialogue",
    '{"do":': "journal",
    **dict.fromkeys(("<!DOCTYPE", "<html", "{\\rtf"), "a document; save it as plain text, one command per line"),
    **dict.fromkeys(("<svg", "<?xml", "%PDF"), "svg"),
    **dict.fromkeys(("{", "[{"), "json"),
}


def read_program(path: str, source: bool = False) -> str:
    """Return the text of a program file, or of standard input for "-".

    Args:
        source: the text must consist of commands; the bytes of a .hex file are refused.
    """
    if source and is_named_hex(path):
        raise BenchFileError(
            f"{path} contains program bytes, judging by its extension; slewline dis {path} --chip CHIP converts them "
            "to commands"
        )
    text = program_text(path, sys.stdin.buffer.read() if path == STDIN else None)
    for pattern, what in ((VCD, "vcd"), (LISTING, "listing"), (NOTEBOOK, "ipynb")):
        if pattern.match(text) and not is_named_hex(path):
            raise BenchFileError(f"{path} is not a program but {NO_PROGRAMS[what]}")
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > LONGEST:
            found = f"{path}, line {number}: {len(line)} characters"
            raise BenchFileError(f"{found}; allowed up to {LONGEST}; check the file name")
    if not any(line.split(";", 1)[0].strip() for line in text.splitlines()):
        if (extension := Path(path).suffix[1:].lower()) in NO_PROGRAMS:
            raise BenchFileError(f"{path} is not a program but {NO_PROGRAMS[extension]}")
        raise BenchFileError(f"{path} has no commands; write one command per line, such as R 100")
    kind = next((kind for beginning, kind in BEGINNINGS.items() if text.lstrip().startswith(beginning)), None)
    if kind is not None:
        raise BenchFileError(f"{path} is not a program but {NO_PROGRAMS.get(kind, kind)}")
    return text


def chip_of(path: str, chip: str | None, fits: Callable[[Sheet], object] | None = None) -> str:
    """Return the part for which a file is meant, named by --chip or by the file extension.

    Args:
        path: the path of the file.
        chip: the value of --chip.
        fits: raises UsageError for a part that the command does not support; error messages do not suggest such parts.

    Raises:
        UsageError: neither --chip nor the file extension names a part.
    """
    if chip is not None:
        return chip
    part = Path(path).suffix[1:].lower()
    if part in CATALOGUE.ours:
        return part
    names = CATALOGUE.names()
    if part in names:
        return part
    if Path(path).is_dir():
        raise UsageError(f"{path} is a directory; name the files in it")
    if part in NO_PROGRAMS:
        raise UsageError(f"{path} is not a program but {NO_PROGRAMS[part]}")
    if is_bench(path):
        raise UsageError(
            f"{path} is a bench file, judging by its extension; the commands run, lint, serve, panel and debug read "
            "bench files"
        )
    if fits is not None:
        names = [name for name in names if _fits(name, fits)]
    extensions = ", ".join(f".{name}" for name in names)
    near = hint(part, names) if part else ""
    raise UsageError(f"{path}: no chip given; give --chip {names[0]}, or a file name ending in {extensions}{near}")


def is_bench(path: str) -> bool:
    """Return whether a file name is that of a bench file."""
    return path.lower().endswith(".toml")


def is_program(path: str) -> bool:
    """Return whether a file name is that of a program for one of this package's chips, or of a bench file."""
    return is_bench(path) or Path(path).suffix[1:].lower() in CATALOGUE.ours


def read_options(path: str | None, part: str | type[Chip]) -> dict[str, Any]:
    """Return the options of a part from a TOML file; {} if `path` is None.

    Raises:
        BenchFileError: the file cannot be read, is not TOML, or is a bench file, whose chips have their own options.
        UsageError: the part has no such option, or a value is not allowed.
    """
    if path is None:
        return {}
    found = read_toml(path, read_text(path))
    if "chip" in found:
        raise BenchFileError(f"{path} is a bench file; allowed: options of a chip, such as rate = 80, one per line")
    sheet = sheet_of(part)
    checked(f"{path}: {sheet.part}", sheet.options, found)
    return found


def _fits(name: str, fits: Callable[[Sheet], object]) -> bool:
    try:
        fits(sheet_of(name))
    except UsageError:
        return False
    return True


def sheet_for(path: str, chip: str | None, fits: Callable[[Sheet], object] | None = None) -> Sheet:
    """Return the data sheet of the part for which a file is meant; the arguments are those of `chip_of`."""
    return sheet_of(chip_of(path, chip, fits))


def report_replaced(journal: str | None) -> None:
    """Warn on standard error if an existing journal will be replaced.

    Raises:
        BenchFileError: the file exists, but is not a journal.
    """
    from ..bench.files.journal import replaced

    if journal is not None and replaced(journal):
        click.echo(f"slewline: {journal}: the existing journal is replaced", err=True)


class Outputs:
    """Files that a command will write.  Each is checked when it is claimed, and is written completely or not at all.

    Args:
        inputs: files that must not be overwritten.
    """

    def __init__(self, inputs: Iterable[str]) -> None:
        self.taken = {os.path.realpath(path) for path in inputs}
        self.written: list[str] = []
        self._growing: WholeFile | None = None

    def claim(
        self, path: str | None, extensions: tuple[str, ...] = (), bare: bool = False, own: bool = False
    ) -> str | None:
        """Check that a file can be written, and has one of the `extensions` (if any are given); return its path.

        Args:
            path: the path of the file; None and "-" (standard output) are not checked.
            bare: a name without an extension is allowed too.
            own: the name was chosen by the command, not by the user.

        Raises:
            UsageError: the file cannot be written, is an input, or has already been claimed.
        """
        from ..record.whole_file import WholeFile, check_suffix

        if path is None or path == STDIN:
            return path
        if extensions:
            check_suffix(path, extensions, bare=bare)
        real = os.path.realpath(path)
        if real in self.taken:
            raise UsageError(f"{path}: this command already uses the file; give each file a different name")
        WholeFile(path, own).discard()
        if os.path.exists(real) and not os.access(real, os.W_OK):
            raise UsageError(f"{path} is write-protected")
        self.taken.add(real)
        return path

    def write(self, path: str, text: str) -> None:
        """Write a text to a claimed file, or to standard output for "-"."""
        if path == STDIN:
            click.echo(text, nl=False)
        else:
            self.write_bytes(path, text.encode())

    def write_bytes(self, path: str, data: bytes) -> None:
        """Write bytes to a claimed file."""
        from ..record.whole_file import WholeFile

        with WholeFile(path) as file:
            file.write(data)
        self.written.append(path)

    def save(self, path: str | None, write: Callable[[str], object]) -> None:
        """Call `write`, which writes a claimed file; do nothing if `path` is None."""
        if path is not None:
            write(path)
            self.written.append(path)

    # --------------------------------------------------------------------------------------------------- the journal
    def partial(self, path: str | None) -> str | None:
        """Return the temporary name of a file that grows during a run; `keep` changes it to the final name.

        A pipe or a device keeps its own name.  None if `path` is None.
        """
        from ..record.whole_file import WholeFile

        if path is None:
            return None
        real = Path(os.path.realpath(path))
        if real.exists() and not real.is_file():
            return path  # a pipe or a device
        self._growing = WholeFile(path)
        return str(self._growing.part)

    def keep(self) -> None:
        """Give the growing file its final name."""
        if self._growing is not None:
            self._growing.close()
            self.written.append(str(self._growing.path))
            self._growing = None

    def __enter__(self) -> Outputs:
        return self

    def __exit__(self, *_: object) -> None:
        if self._growing is not None:
            self._growing.discard()
