"""slewline translate BENCH.toml: translates all programs of a bench and the bench itself; reports on both."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ...errors import ProgramError, SlewlineError, UsageError
from ..files import Outputs
from .translate_command import data, proven, shown, status, writer_options

if TYPE_CHECKING:
    from ...translation.proof.prove import Proof
    from ...translation.proof.prove_bench import BenchProof
    from ...translation.translate import Translation
    from ...translation.whole_bench import BenchTranslation


def translate_bench_file(
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
    """Translate a bench file, write the results into a folder, and print the report; return the exit status."""
    from ...translation.translate import refusal
    from ...translation.whole_bench import translate_bench

    for name, value in (("--chip", chip), ("--crystal", crystal), ("--plot", plot)):
        if value is not None:
            raise UsageError(f"{name} is for a single program; a bench file sets it for each chip")
    if output is None or Path(output).is_file():
        raise UsageError(
            f"{file} is a bench file, which is translated to several files; give a folder for them: --output FOLDER"
        )
    done = translate_bench(
        file, to, options=writer_options(steps_per_mm, axis, unroll, settings), target_crystal=target_crystal
    )
    if strict:
        wrong = [refusal(each.report) for each in done.programs.values() if not each.report.same]
        wrong += [f"{line.what}: {line.remedy}" for line in done.lines if not line.becomes]
        if wrong:
            click.echo("\n".join(f"slewline: {each}" for each in wrong), err=True)
            return 1
    folder = Path(output)
    folder.mkdir(parents=True, exist_ok=True)
    outputs = Outputs([file])
    paths = {name: str(folder / name) for name in done.files}
    for path in paths.values():
        outputs.claim(path)
    for name, path in paths.items():
        outputs.write(path, done.files[name])
    refused = does_not_load(paths[done.bench]) if done.bench else ""
    whole = whole_proof(done, paths[done.bench]) if prove and done.bench and not refused else None
    alone = {name: proven_alone(each) for name, each in done.programs.items()} if prove and not done.bench else {}
    failed = bool(refused) or (whole is not None and not whole.proven)
    proofs = {name: each for name, each in alone.items() if not isinstance(each, str)}
    state = max(status(each, proofs.get(name)) for name, each in done.programs.items())
    if as_json:
        click.echo(json.dumps(bench_data(done, whole, proofs, refused), indent=2, ensure_ascii=False))
        return max(state, int(failed))
    for name, each in done.programs.items():
        click.echo(f"{name}:")
        for text, colour in shown(each.report, proofs.get(name)):
            click.secho(text, fg=colour)
        if isinstance(why := alone.get(name), str):
            click.secho(f"proof    not run: {why}", fg="yellow")
    for text, colour in around(done, whole, refused):
        click.secho(text, fg=colour)
    for path in outputs.written:
        click.echo(f"wrote {path}")
    return max(state, int(failed))


def proven_alone(done: Translation) -> Proof | str:
    """Run a program and its translation without the bench; return the comparison, or why a run is impossible."""
    try:
        return proven(done)
    except ProgramError as error:
        return str(error).splitlines()[0]


def does_not_load(path: str) -> str:
    """Return the reason why the translated bench cannot be loaded; empty if it can."""
    from ...bench.file import BenchFile

    try:
        BenchFile(path).load()
    except SlewlineError as error:
        return str(error)
    return ""


def whole_proof(done: BenchTranslation, path: str) -> BenchProof:
    """Run the original and the translated bench, and return their comparison."""
    from ...translation.proof.prove_bench import prove_bench

    return prove_bench(done, path)


def around(done: BenchTranslation, proof: BenchProof | None, refused: str) -> Iterator[tuple[str, str | None]]:
    """Yield the report on the bench itself, without its programs: each line with its colour (None: default)."""
    for line in done.lines:
        becomes = line.becomes or "nothing"
        yield (
            f"bench    {line.what} => {becomes}{f'; {line.remedy}' if line.remedy else ''}",
            (None if line.becomes and not line.remedy else "yellow"),
        )
    if not done.bench:
        yield f"bench    a controller with {done.to} for each chip: their programs run at the same time", None
    if refused:
        yield f"bench    does not load: {refused}", "red"
    for name, found in ({} if proof is None else proof.compared).items():
        yield f"proof    {name}: {found.text}", None if found.proven else "red"


def bench_data(
    done: BenchTranslation, proof: BenchProof | None, proofs: dict[str, Proof], refused: str
) -> dict[str, Any]:
    """Return the result of translating a bench as plain data, with the proofs and any error in loading it."""
    found: dict[str, Any] = {
        "to": done.to,
        "programs": {name: data(each, proofs.get(name)) for name, each in done.programs.items()},
        "bench": [{"what": line.what, "becomes": line.becomes, "remedy": line.remedy} for line in done.lines],
        "refused": refused,
    }
    if proof is not None:
        found["proof"] = {
            name: {"proven": each.proven, "differences": list(each.differences), "moves": each.moves}
            for name, each in proof.compared.items()
        }
    return found
