"""asm, dis, lint, describe, chips: reports on programs and parts, without running anything."""

from __future__ import annotations

import dataclasses
import json
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from ..bench.files.hex_text import hex_bytes, is_named_hex
from ..chips import CATALOGUE, PARTS, checks_of, sheet_of
from ..core.memory.image import ERASED, is_hex, to_hex
from ..core.messages.whole import counted
from ..errors import BenchFileError, UsageError
from ..gate import BOM, read_file
from .files import LISTING, NO_PROGRAMS, STDIN, Outputs, chip_of, is_bench, read_options, read_program, sheet_for

if TYPE_CHECKING:
    from ..bench import Bench
    from ..bench.scripts.script_runner import Script
    from ..core.datasheet.table import Sheet
    from ..language.assemble import Assembly
    from ..language.problems import Problem
    from ..language.statements import Instruction
    from ..parts.hosts.host import Host

SOURCE = "this is a program text, not program bytes; slewline asm converts it"
FORMS = {".hex": "hex", ".bin": "bin", ".ihx": "image", ".ihex": "image"}  # by file extension
HOLD_BYTES = ("eeprom", "raw")  # extensions of files that may hold the bytes of a program
COLOURS = {"error": "red", "warning": "yellow", "note": "cyan"}


def print_json(value: object) -> None:
    """Print a value as JSON text to standard output."""
    click.echo(json.dumps(value, indent=2, ensure_ascii=False))


# ------------------------------------------------------------------------------------------------------------------ asm
def asm(
    file: str, chip: str | None, output: str | None, form: str | None, resolve: bool, checksum: bool, as_json: bool
) -> int:
    """Assemble a program, and write it to `output` or standard output; return 0."""
    from ..language.assemble import assemble
    from ..language.source import read

    sheet, text = sheet_for(file, chip), read_program(file, source=True)
    if checksum and not sheet.plain:
        raise UsageError(f"--checksum: the {sheet.part.upper()} has no checksums; leave out --checksum")
    outputs = Outputs([file])
    outputs.claim(output)
    assembly = assemble(text, sheet, file, resolve)
    for problem in assembly.findings:
        click.echo(f"slewline: {file}, line {problem.line}: {problem.severity}: {problem.message}", err=True)
    if sheet.enter is not None and not read(text, sheet).blocks:
        enter, leave = (row.form for row in assembly.framing)
        remedy = f"write {enter} above the first of them, and {leave} below the last"
        raise UsageError(f"{file} has no program: without {enter}, its commands are host commands; {remedy}")
    if as_json:
        data = json.dumps(assembly_object(assembly), indent=2).encode() + b"\n"
    else:
        extension = Path(output or "").suffix.lower()
        form = form or FORMS.get(extension, "listing")
        data = formatted(assembly, form, checksum)
        if assembly.base and form in ("hex", "bin"):
            remedy = "--format image, or a name that ends in .ihx, keeps the address, for --memory"
            click.echo(
                f"slewline: {file}: the bytes belong at address {assembly.base}, which is not in the file; {remedy}",
                err=True,
            )
    put(data, output, outputs)
    return 0


def formatted(assembly: Assembly, form: str, checksum: bool = False) -> bytes:
    """Return an assembled program in a format: "bin", "ascii", "binary", "image", "hex" or "listing"."""
    from ..language.assemble import to_ascii, to_binary, units

    if form == "bin":
        return assembly.stored
    if form in ("ascii", "binary"):
        return to_ascii(assembly, checksum) if form == "ascii" else to_binary(assembly)
    if form == "image":
        return to_hex(bytes([ERASED]) * assembly.base + assembly.stored).encode()
    if form == "hex":
        return f"{assembly.stored.hex(' ').upper()}\n".encode()
    room = f"of {assembly.sheet.buffer_bytes} " if assembly.sheet.buffer_bytes else ""
    used = f"{len(assembly.stored)} {room}{units(assembly.sheet)}"
    return f"{assembly.listing()}\n; {used}\n".encode()


def put(data: bytes, output: str | None, outputs: Outputs) -> None:
    """Write bytes to the output file, or to standard output if none is named."""
    if output is None or output == STDIN:
        if sys.stdout.isatty() and not data.decode("latin-1").replace("\n", "").isprintable():
            raise UsageError("program bytes are not printed on a terminal; give --output FILE, or write to a pipe")
        click.echo(data, nl=False)
    else:
        outputs.write_bytes(output, data)


def assembly_object(assembly: Assembly) -> dict[str, Any]:
    """Return an assembled program as data for JSON."""
    pairs = zip(assembly.lines, assembly.statements, strict=True)
    return {
        "chip": assembly.sheet.part,
        "program": assembly.stored.hex(),
        "bytes": len(assembly.stored),
        "labels": assembly.labels,
        "lines": [line._asdict() | {"data": assembly.data_of(s).hex()} for line, s in pairs],
        "preset": list(assembly.preset),
        "findings": [dataclasses.asdict(problem) for problem in assembly.findings],
    }


# ------------------------------------------------------------------------------------------------------------------ dis
def dis(
    file: str, chip: str | None, form: str | None, stream: bool, labels: bool, output: str | None, as_json: bool
) -> int:
    """Disassemble a program buffer or, if `stream`, the binary data that a host sends; return 0."""
    from ..language.dialect import dialect_of
    from ..language.disassemble import commands, disassemble, instructions

    sheet = sheet_for(file, chip)
    if stream:
        dialect_of(sheet).check_stream(sheet)
    data = program_bytes(file, form, sheet)
    outputs = Outputs([file])
    outputs.claim(output)
    if not stream and len(data) > sheet.buffer_bytes > 0:
        remedy = "for host data, give --stream" if dialect_of(sheet).streams else "check the file name"
        raise BenchFileError(f"{file}: {len(data)} bytes; the program buffer has {sheet.buffer_bytes}; {remedy}")
    if stream:
        command_lines, notes = commands(data, sheet)
        for note in notes:
            click.echo(f"slewline: {note.code}: {note.text}", err=True)
        found: Any = {"chip": sheet.part, "commands": command_lines}
        text = "".join(f"{command}\n" for command in command_lines)
    else:
        lines = list(instructions(data, sheet))
        found = {"chip": sheet.part, "lines": [line_object(line) for line in lines]}
        unknown = sum(line.row is None for line in lines)
        if 2 * unknown > len(lines):
            message = (
                f"{unknown} of {len(lines)} instructions are not commands of the {sheet.part}; check FILE and --chip"
            )
            click.echo(f"slewline: {file}: {message}", err=True)
        text = disassemble(data, sheet, labels=labels)
    put((json.dumps(found, indent=2) + "\n" if as_json else text).encode(), output, outputs)
    return 0


def line_object(line: Instruction) -> dict[str, Any]:
    """Return an instruction as data for JSON; its name is null if its first byte is not an opcode."""
    name = line.row.name if line.row else None
    return {"address": line.address, "data": line.data.hex(), "name": name, "values": list(line.values)}


def program_bytes(file: str, form: str | None, sheet: Sheet) -> bytes:
    """Return the program bytes of a hex, binary or image file, in format `form` (None: by name and content).

    Raises:
        BenchFileError: the file cannot be read, is empty, has incomplete hex digits, or is a program text or
            another file without program bytes.
    """
    raw = sys.stdin.buffer.read() if file == STDIN else read_file(file)
    if not raw:
        raise BenchFileError(f"{file} is empty")
    if form == "bin":
        return raw
    if form is None and (message := no_bytes(file, raw)):
        raise BenchFileError(f"{file} has no program bytes: it is {message}")
    if form is None and not is_named_hex(file):
        text = raw.removeprefix(BOM)  # a binary file may begin with these by chance
        digits = b"".join(re.sub(rb";[^\r\n]*", b"", text).split())
        if not is_hex(text) and re.fullmatch(rb"[0-9A-Fa-f]+", digits) is None:
            if looks_like_source(raw, sheet):
                raise BenchFileError(f"{file}: {SOURCE}")
            return raw
    try:
        if found := hex_bytes(raw, file):
            return found
    except BenchFileError:
        if form is None and looks_like_source(raw, sheet):
            raise BenchFileError(f"{file}: {SOURCE}") from None
        raise
    raise BenchFileError(f"{file} is empty")


def no_bytes(file: str, raw: bytes) -> str:
    """Return the kind of a file, judged by name or first line, if that kind has no program bytes; else ""."""
    extension = Path(file).suffix[1:].lower()
    if LISTING.match(raw.decode("latin-1")):
        return NO_PROGRAMS["listing"]
    return "" if extension in HOLD_BYTES else NO_PROGRAMS.get(extension, "")


def looks_like_source(raw: bytes, sheet: Sheet) -> bool:
    """Return whether a file is text in which most lines are commands of the part."""
    from ..language.source import host_lines, read

    try:
        text = raw.decode()
    except UnicodeDecodeError:
        return False
    lines = host_lines(text)
    taken = {item.line for item in read(text, sheet).items}
    return (
        b"\n" in raw
        and text.replace("\n", "").replace("\r", "").replace("\t", "").isprintable()
        and (2 * len(taken) > len(lines))
    )


# ----------------------------------------------------------------------------------------------------------------- lint
def lint(
    files: tuple[str, ...], chip: str | None, strict: bool, allow_code: bool, as_json: bool, options: str | None = None
) -> int:
    """Print the problems of programs; return 1 if any is an error (or, if `strict`, a warning), else 0."""
    from ..language.problems import picture

    if allow_code and not any(is_bench(file) for file in files):
        raise click.UsageError("--allow-code needs a bench file; a chip given as module:Class needs no --allow-code")
    if options is not None and any(is_bench(file) for file in files):
        raise click.UsageError("a bench file has the options of its chips; leave out --options")
    found = [each for file in files for each in texts_of(file, chip, allow_code, options)]
    if as_json:
        listed: dict[str, list[dict[str, Any]]] = {}
        for where, _, problems, _ in found:  # two hosts of a bench may play the same file
            listed.setdefault(where, []).extend(dataclasses.asdict(each) for each in problems)
        print_json(listed)
    else:
        for where, text, problems, _ in found:
            for problem in problems:
                head, _, rest = picture(problem, text, where).partition("\n")
                click.echo(f"{click.style(head, fg=COLOURS[problem.severity])}\n{rest}\n")
            click.echo(f"{where}: {tally(problems)}")
        for message in filter(None, (each.foreign for each in found)):
            click.echo(message)
    bad = ("error", "warning") if strict else ("error",)
    return int(any(problem.severity in bad for each in found for problem in each.problems))


class LintResult(NamedTuple):
    """A program's name, text and problems, and a message if it seems to be for another chip (otherwise "")."""

    where: str
    text: str
    problems: list[Problem]
    foreign: str = ""


def texts_of(file: str, chip: str | None, allow_code: bool = False, options: str | None = None) -> list[LintResult]:
    """Return the text and problems of a program file, or of each script of a bench file.

    Args:
        options: a file with options of the chip.

    Raises:
        SlewlineError: the file cannot be read, or is not a valid bench.
    """
    from ..bench import Bench
    from ..bench.file import BenchFile
    from .single import read

    if is_bench(file):
        if chip is not None:
            raise UsageError("a bench file names its chips; leave out --chip")
        bench, scripts = BenchFile(file, allow_code=allow_code).staged()
        found = [linted(bench, host, script, script.where) for host, script in scripts]
        return found or [LintResult(file, "", [])]
    part, text = chip_of(file, chip), read_program(file)
    script, straps = read(text, file, sheet_of(part))
    bench = Bench()
    host = bench.host(bench.add(part, straps=straps, **read_options(options, part)))
    return [linted(bench, host, script, file)]


def linted(bench: Bench, host: Host, script: Script, where: str) -> LintResult:
    """Return a script with its problems and, if it has errors and seems to be for another chip, a message."""
    from .dialects import foreign

    chip = bench.chips[host.chip.name]
    problems = problems_of(bench, host, script)
    bad = any(problem.severity == "error" for problem in problems)
    return LintResult(where, script.text, problems, foreign(script.text, where, type(chip), chip.sheet) if bad else "")


def problems_of(bench: Bench, host: Host, script: Script) -> list[Problem]:
    """Return the problems of a script: all that lint finds, and the lines that `run` would refuse.

    A line with an error is listed once.  A script with commands to several chips is not linted: only the
    lines that `run` would refuse are listed.
    """
    from ..bench.scripts.script import refused
    from ..language.lint import lint as check

    alone = len(host.chips) == 1
    found = []
    if alone:
        sheet = host.chip.sheet
        found = check(script.text, sheet, checks_of(type(bench.chips[host.chip.name]), sheet))
    unsent = refused(bench, host, script)
    odd = {problem.line for problem in unsent if problem.code == "line"}  # never sent by a host
    found = [problem for problem in found if problem.line not in odd]
    wrong = {problem.line for problem in found if problem.severity == "error"}
    return sorted([*found, *(problem for problem in unsent if problem.line not in wrong)])


def tally(problems: list[Problem]) -> str:
    """Return the counts of problems, such as "2 errors, 1 note"."""
    counts = [(sum(p.severity == severity for p in problems), severity) for severity in COLOURS]
    return ", ".join(counted(number, severity) for number, severity in counts if number) or "no problems found"


# ------------------------------------------------------------------------------------------------------ describe, chips
def describe(chip: str, command: str | None, as_json: bool, options: str | None = None) -> int:
    """Print the reference of a chip, or of one of its commands; return 0."""
    from ..language.describe import describe as text_of

    sheet = sheet_of(chip, options=read_options(options, chip) or None)
    text = text_of(sheet, command)
    if as_json:
        print_json(sheet_object(sheet, command))
    elif sys.stdout.isatty():
        from rich.console import Console
        from rich.markdown import Markdown

        Console().print(Markdown(text))
    else:
        click.echo(text, nl=False)
    return 0


def sheet_object(sheet: Sheet, command: str | None) -> dict[str, Any]:
    """Return a data sheet as data for JSON; if a command is named, omit all other commands, the pins, etc."""
    from ..core.datasheet.command_rows import row_object
    from ..core.messages.former_names import published
    from ..language.dialect import dialect_of
    from ..language.lookup import find

    found: dict[str, Any] = {"chip": sheet.part, "title": sheet.title, "manual": sheet.manual}
    if command == dialect_of(sheet).mark and sheet.labels:
        return found | {"commands": [], "labels": sheet.labels}
    rows = find(sheet, command) if command is not None else list(sheet.commands)
    found["commands"] = [row_object(row) for row in rows]
    if command is None:
        found["pins"] = [published(pin) for pin in sheet.pins]
        found["registers"] = [published(register) for register in sheet.registers]
        found["options"] = [option.data() for option in sheet.options]
        found["times"] = {name: published(time) for name, time in sheet.times.items()}
    return found


def chips(as_json: bool) -> int:
    """Print the part number and title of every part; return 1 if any part cannot be loaded, else 0."""
    found, failed = {part: row.description for part, row in PARTS.items()}, False
    for part in CATALOGUE.brought():
        try:
            found[part] = sheet_of(part).title
        except UsageError as error:
            click.echo(f"slewline: {error}", err=True)
            failed = True
    if as_json:
        print_json([{"chip": part, "title": title} for part, title in found.items()])
    else:
        for part, title in found.items():
            click.echo(f"{part:<12}{title}")
    return int(failed)
