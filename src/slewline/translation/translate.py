"""Translation, as called from Python: a program for one part becomes a program for another part.

done = slewline.translate("weld.cy525", to="gs-c200s")
print(done.text)
for line in done.report:
    print(line.number, line.code, line.kind.value)
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

from ..bench.circuit import crystal_for
from ..bench.scripts.program_file import program_text
from ..chips import CATALOGUE, sheet_of
from ..core.messages.calls import answering
from ..core.messages.near import hint
from ..errors import UnknownName, UsageError
from .host_directives import drives_input
from .meaning import Assumed, HostDirective, Program
from .own.part_writer import OwnWriter
from .program_facts import started_plainly
from .source_text.reading import read_program
from .target_writer import WARNING, Target, WriterOptions, Written
from .translation_report import LineKind, LineVerdict, OutLine, Report, ReportLine
from .writers import TARGETS, target

DRIVEN = "change in the same way at the target"
COLUMN = 13  # column of a comment next to a command


@dataclass(frozen=True, slots=True)
class Translation:
    """A translated program.

    Attributes:
        text: the result, for the target.
        report: the verdicts on each source line, the assumptions, and the wiring.
        program: the source as a `Program`: its lines, each with the actions that it causes.
        source: the text of the source.
    """

    text: str
    report: Report
    program: Program
    source: str
    options: WriterOptions
    source_hz: int | None = None

    def __repr__(self) -> str:
        counts = ", ".join(f"{number} {kind.value}" for kind, number in self.report.counts.items())
        return f"<Translation of {self.report.where} for {self.report.to}: {counts}>"


@answering("translate()")
def translate(
    file: str | PathLike[str],
    *,
    to: str,
    part: str | None = None,
    crystal: str | int | None = None,
    target_crystal: str | int | None = None,
    steps_per_mm: float = 1.0,
    axis: str = "X",
    unroll: int = 1000,
    strict: bool = False,
    settings: Mapping[str, str] | None = None,
) -> Translation:
    """Translate a program for another part or controller; return the result, with a report on each line.

    Args:
        file: the program; its extension names the part of the source, unless `part` is given.
        to: the target, a part number or the name of another controller.
        part: the part of the source.
        crystal, target_crystal: the crystals of source and target, such as "11 MHz"; by default the usual
            crystals.
        steps_per_mm: the number of steps per millimetre, for targets that count millimetres.
        axis: the name of the axis, for targets that have several axes.
        unroll: the maximum number of lines that a loop may become, if the target has no loops.
        strict: whether to refuse a result that has any line with a verdict other than "the same".
        settings: facts missing from the text, by name: {"output1": "low"} for the initial level of an
            output, and target settings such as {"library": "fastaccelstepper"}.

    Raises:
        UnknownName: the part or target does not exist.
        UsageError: an argument is out of range, or `strict` is set and a line's verdict is not "the same".
        ProgramError: the source's part does not accept some lines.
        BenchFileError: the file cannot be read, or is not text.
    """
    path = str(file)
    return translate_text(
        program_text(path),
        part or Path(path).suffix[1:],
        to,
        where=path,
        crystal=crystal,
        target_crystal=target_crystal,
        options=WriterOptions(steps_per_mm=steps_per_mm, axis=axis, unroll=unroll, values=settings or {}),
        strict=strict,
    )


def translate_text(
    text: str,
    part: str,
    to: str,
    *,
    where: str = "<text>",
    crystal: str | int | None = None,
    target_crystal: str | int | None = None,
    options: WriterOptions | None = None,
    strict: bool = False,
    interrupted: bool = False,
) -> Translation:
    """Translate a text for another part or controller; arguments and errors are as for `translate`.

    `where` is the name of the text in messages.  `interrupted`: the surroundings may end a motion early, as
    limit switches do.
    """
    options = options or WriterOptions()
    sheet = sheet_of(part)
    source_hz = None if crystal is None else crystal_for(sheet, crystal)
    program = read_program(text, part, where, source_hz, interrupted)
    name = known(to)
    check_settings(options.values, name)
    if name in TARGETS:
        program = with_levels(program, options.values)
        other: Target | None = target(name)
        program = with_driven_inputs(program)
        written = target(name).write(started_plainly(program), options)
    else:
        other, mine = None, sheet_of(name)
        if target_crystal is not None:
            options = WriterOptions(
                options.steps_per_mm, options.axis, options.unroll, crystal_for(mine, target_crystal), options.values
            )
        written = OwnWriter(program, name, options, source_hz).write()
    report = reported(program, name, written)
    result = joined(program, name, other, written)
    if strict and not report.same:
        raise UsageError(refusal(report))
    return Translation(result, report, program, text, options, source_hz)


def known(to: str) -> str:
    """Return the canonical name of a target; `to` is the name given by the user.

    Raises:
        UnknownName: the target does not exist; the message lists the targets.
    """
    name = CATALOGUE.canonical(to) if isinstance(to, str) else ""
    if name in TARGETS:
        return name
    try:
        sheet_of(name)
    except UnknownName:
        names = [*CATALOGUE.names(), *TARGETS]
        raise UnknownName(f"no target {to!r}; known: {', '.join(names)}{hint(str(to), names)}") from None
    return name


def check_settings(values: Mapping[str, str], to: str) -> None:
    """Refuse settings that the target `to` does not have.

    Raises:
        UsageError: the target has no such setting, or an output level is neither "low" nor "high".
    """
    own = dict(TARGETS[to].settings) if to in TARGETS else {}
    levels = {f"output{number}": "low or high: its level at the start" for number in (1, 2, 3)}
    allowed = own | (levels if to in TARGETS else {})
    for name, value in values.items():
        if name not in allowed:
            rows = [f"{each} ({description})" for each, description in allowed.items()]
            near = hint(name, list(allowed))
            raise UsageError(f"setting {name}: {to} has no such setting; allowed {', '.join(rows) or 'none'}{near}")
        if name in levels and value not in ("low", "high"):
            raise UsageError(f"setting {name}={value}: allowed low or high")


def with_levels(program: Program, values: Mapping[str, str]) -> Program:
    """Return a program whose assumptions contain the initial output levels that the user has set."""
    assumed = [each for each in program.assumed if f"output{each.about[7:8]}" not in values]
    given = [(int(name[-1]), value) for name, value in values.items() if name.startswith("output")]
    for number, value in given:
        pin = program.wiring.get(f"output{number}", "a pin")
        assumed.append(Assumed(f"output {number} ({pin})", f"{value} at the start, as set"))
    return replace(program, assumed=tuple(assumed))


def with_driven_inputs(program: Program) -> Program:
    """Add an assumption to a program whose host drives inputs; return the resulting program.

    The assumption is that the inputs of the target change in the same way.  A program whose host drives no
    inputs is returned unchanged.
    """
    found = [action for action in program.actions if isinstance(action, HostDirective)]
    if not any(drives_input(action.text, sheet_of(program.part)) for action in found):
        return program
    return replace(program, assumed=(*program.assumed, Assumed("inputs that the host drives", DRIVEN)))


def reported(program: Program, to: str, written: Written) -> Report:
    """Return the report on the result of a writer, for the target `to`."""
    verdicts: dict[int, list[LineVerdict]] = {}
    for verdict in written.verdicts:
        verdicts.setdefault(verdict.line, []).append(verdict)
    texts: dict[int, list[str]] = {}
    for line in written.lines:
        if line.text:
            texts.setdefault(line.source, []).append(line.text)
    lines = tuple(
        ReportLine(
            line.number,
            line.code,
            tuple(texts.get(line.number, ())),
            tuple(sorted(verdicts.get(line.number, ()), key=lambda each: -each.kind.worth)),
        )
        for line in program.lines
        if line.code
    )
    assumed = (*program.assumed, *(Assumed(about, value) for about, value in written.assumed))
    wiring = tuple((role, theirs, mine) for role, theirs, mine in written.wiring)
    return Report(program.where, program.part, to, lines, tuple(verdicts.get(0, ())), assumed, wiring)


def joined(program: Program, to: str, other: Target | None, written: Written) -> str:
    """Return the text of a result, with the warning at its head.

    `other` is the target, or None for our own parts.
    """

    def comment(text: str) -> str:
        return other.comment(text) if other is not None else f"; {text}".rstrip() if text else ";"

    head = [
        *map(comment, WARNING),
        comment(f"{Path(program.where).name}, for the {program.part}, as a program for {to}."),
    ]
    return "\n".join([*head, *lines_of(written.lines, other)]) + "\n"


def lines_of(lines: Iterable[OutLine], other: Target | None) -> Iterable[str]:
    """Yield the lines of a result with their comments; `other`: the target, None for our own parts."""
    for line in lines:
        if other is not None:
            yield other.joined(line)
        elif line.text:
            yield f"{line.text:<{COLUMN - 1}} ; {line.comment}" if line.comment else line.text
        else:
            yield f"; {line.comment}" if line.comment else ""


def refusal(report: Report) -> str:
    """Return the message that lists the lines whose verdict is not "the same"."""
    wrong = [line for line in report.lines if line.kind is not LineKind.SAME]
    problems = [f"{report.where}, line {line.number}: {line.code}: {line.verdicts[0].text}" for line in wrong]
    problems += [f"{report.where}: {each.text}" for each in report.whole if each.kind is not LineKind.SAME]
    return "\n".join(
        [
            f"{report.where}: {len(problems)} lines are not the same at the {report.to}; leave out "
            "--strict to allow it",
            *problems,
        ]
    )
