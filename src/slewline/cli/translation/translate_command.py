"""slewline translate: rewrites a program so that it runs on another part or controller; report and proof."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import click

from ...chips import chip_class
from ...core.messages.whole import counted
from ...errors import ProgramError, UsageError
from ...record.pictures.picture_files import SUFFIXES
from ..files import STDIN, Outputs, chip_of, read_program

if TYPE_CHECKING:
    from ...translation.proof.prove import Proof
    from ...translation.target_writer import WriterOptions
    from ...translation.translate import Translation
    from ...translation.translation_report import LineVerdict, Report

COLOURS = {"same": None, "nearly": "yellow", "not possible": "red"}
MOST_STEPS_PER_MM = 1e6
MISSING = "a line that is not possible counts as a difference: replace it, and prove again"
WIDTH = 24  # of the output for a line


def translate(
    file: str,
    to: str,
    chip: str | None,
    crystal: str | None,
    target_crystal: str | None,
    output: str | None,
    steps_per_mm: float | None,
    axis: str,
    unroll: int,
    settings: Sequence[str],
    strict: bool,
    prove: bool,
    plot: str | None,
    as_json: bool,
) -> int:
    """Translate a program, and print the result and the report; return the exit status."""
    from ...translation.translate import known, refusal, translate_text

    known(to)
    options = writer_options(steps_per_mm, axis, unroll, settings)
    text = read_program(file, source=True)
    part = chip_of(file, chip)
    if plot is not None and not prove:
        raise UsageError("--plot: needs --prove")
    outputs = Outputs([file])
    outputs.claim(output)
    outputs.claim(plot, SUFFIXES)
    try:
        done = translate_text(
            text, part, to, where=file, options=options, crystal=crystal, target_crystal=target_crystal
        )
    except ProgramError as error:
        raise ProgramError("\n".join(filter(None, (str(error), meant(text, file, part))))) from None
    if strict and not done.report.same:
        click.echo(f"slewline: {refusal(done.report)}", err=True)
        return 1
    proof = proven(done) if prove else None
    if plot is not None and proof is not None:
        outputs.save(plot, lambda path: drawn(proof, path, done))
    if as_json:
        click.echo(json.dumps(data(done, proof), indent=2, ensure_ascii=False))
        return status(done, proof)
    aside = output is None or output == STDIN
    outputs.write(output or STDIN, done.text)
    for line, colour in shown(done.report, proof):
        click.secho(line, fg=colour, err=aside)
    for path in outputs.written:
        click.echo(f"wrote {path}", err=aside)
    return status(done, proof)


def writer_options(steps_per_mm: float | None, axis: str, unroll: int, settings: Sequence[str] = ()) -> WriterOptions:
    """Return the user's settings for the program that is written for the target.

    Raises:
        UsageError: a value is out of range, or a setting is not of the form NAME=VALUE.
    """
    from ...translation.target_writer import WriterOptions

    if steps_per_mm is not None and not 0 < steps_per_mm < MOST_STEPS_PER_MM:
        raise UsageError(f"--steps-per-mm {steps_per_mm:g}; allowed more than 0, below {MOST_STEPS_PER_MM:g}")
    values = {}
    for each in settings:
        name, equals, value = each.partition("=")
        if not name.strip() or not equals or not value.strip():
            raise UsageError(f"--set {each}: write NAME=VALUE, such as output1=low")
        values[name.strip()] = value.strip()
    return WriterOptions(steps_per_mm=steps_per_mm or 1.0, axis=axis, unroll=unroll, values=values)


def meant(text: str, file: str, part: str) -> str:
    """Return a message that names the parts that a program may be for; empty if it seems to be for `part`."""
    from ..dialects import foreign

    cls = chip_class(part)
    return foreign(text, file, cls, cls.sheet)


def proven(done: Translation) -> Proof:
    """Run the program and its translation, and return the comparison of the two runs."""
    from ...translation.proof.prove import prove

    return prove(done)


def drawn(proof: Proof, path: str, done: Translation) -> None:
    """Draw the runs of a program and of its translation into the picture file `path`."""
    from ...translation.proof.picture import draw

    draw(proof, path, (done.report.part, done.report.to))


def status(done: Translation, proof: Proof | None) -> int:
    """Return the exit status: 1 if a line or the whole program is "not possible", or the proof fails; else 0."""
    failed = proof is not None and proof.compared is not None and not proof.proven
    return int(failed or done.report.counts[worst()] > 0 or any(each.kind is worst() for each in done.report.whole))


def worst() -> Any:
    """Return the worst kind of verdict, "not possible"."""
    from ...translation.translation_report import LineKind

    return LineKind.IMPOSSIBLE


# ---------------------------------------------------------------------------------------------------------------- text
def shown(report: Report, proof: Proof | None) -> Iterator[tuple[str, str | None]]:
    """Yield the lines of a report, and of the proof if there is one, each with its colour (None: default)."""
    counts = ", ".join(f"{number} {kind.value}" for kind, number in report.counts.items())
    yield f"{report.where}: {report.part} to {report.to}: {counted(len(report.lines), 'line')}: {counts}", None
    for line in report.lines:
        kind, written = line.kind.value, " | ".join(once(line.written)) or "-"
        yield f"{line.number:>4}  {line.code:<{WIDTH}}  {written:<{WIDTH}}  {kind}".rstrip(), COLOURS[kind]
        for verdict in line.verdicts:
            if message := described(verdict):
                yield f"      {message}", COLOURS[verdict.kind.value]
    for verdict in report.whole:
        yield f"      {verdict.text}", COLOURS[verdict.kind.value]
    for each in report.assumed:
        yield f"assumed  {each.about}: {each.value}{f'; {each.remedy}' if each.remedy else ''}", None
    for role, theirs, mine in report.wiring:
        yield f"wire     {theirs} -> {mine or 'nothing'} ({role})", None if mine else "yellow"
    if proof is not None:
        yield f"proof    {proved(proof)}", None if proof.proven else "red"
        if not proof.proven and proof.compared is not None and report.counts[worst()]:
            yield f"         {MISSING}", None


def once(lines: Sequence[str]) -> Iterator[str]:
    """Yield the lines; identical consecutive lines become one line that states their number: "T1 (3 times)"."""
    for text, same in groupby(lines):
        number = len(list(same))
        yield text if number == 1 else f"{text} ({number} times)"


def described(verdict: LineVerdict) -> str:
    """Return the description, the limit and the remedy of a verdict as one text; empty if it has none of them."""
    return "; ".join(filter(None, (verdict.description, verdict.limit, verdict.remedy)))


def proved(proof: Proof) -> str:
    """Return the result of a proof as one line."""
    if proof.compared is None:
        return "not run: this target cannot be run here"
    lint = f"; the linter reports: {proof.lint[0]}" if proof.lint else ""
    return f"{proof.compared.text}; the translated program was run by {proof.by}{lint}"


# ---------------------------------------------------------------------------------------------------------------- data
def data(done: Translation, proof: Proof | None) -> dict[str, Any]:
    """Return the result of a translation, with the proof if there is one, as plain data."""
    report = done.report
    found: dict[str, Any] = {
        "from": report.part,
        "to": report.to,
        "text": done.text,
        "counts": {kind.value: number for kind, number in report.counts.items()},
        "lines": [
            {
                "line": line.number,
                "code": line.code,
                "written": list(line.written),
                "kind": line.kind.value,
                "verdicts": [verdict_object(each) for each in line.verdicts],
            }
            for line in report.lines
        ],
        "whole": [verdict_object(each) for each in report.whole],
        "assumed": [{"about": each.about, "value": each.value} for each in report.assumed],
        "wiring": [{"role": role, "source": theirs, "target": mine} for role, theirs, mine in report.wiring],
    }
    if proof is not None:
        compared = proof.compared
        found["proof"] = {
            "run_by": proof.by,
            "proven": proof.proven,
            "differences": [] if compared is None else list(compared.differences),
            "moves": 0 if compared is None else compared.moves,
        }
    return found


def verdict_object(verdict: LineVerdict) -> dict[str, Any]:
    """Return a verdict as plain data."""
    return {
        "kind": verdict.kind.value,
        "says": verdict.description,
        "limit": verdict.limit,
        "remedy": verdict.remedy,
        "off": verdict.off,
        "off_ps": verdict.off_ps,
    }
