"""Runs a bench and its translation, each wired as its own file says, and compares their chips one by one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from os import PathLike

from ...bench import Bench
from ...bench.file import BenchFile
from ...errors import Timeout
from ..whole_bench import BenchTranslation
from .compare_runs import Compared, compared
from .play import numbered, record_of, trace_of
from .prove import bounds_of


@dataclass(frozen=True, slots=True)
class BenchProof:
    """The result of the comparison for every chip with a program, by chip name."""

    compared: Mapping[str, Compared]

    @property
    def proven(self) -> bool:
        """True if every chip agrees with its counterpart within the bounds of its report."""
        return all(each.proven for each in self.compared.values())


def prove_bench(done: BenchTranslation, result: str | PathLike[str]) -> BenchProof:
    """Run a bench file, and its translation in the file `result`, and compare the chips of both.

    Raises:
        BenchFileError, ProgramError: the result is not a bench that runs.
    """
    theirs = {name: numbered(list(each.program.wiring.items()), "output") for name, each in done.programs.items()}
    mine = {
        name: numbered([(role, pin) for role, _, pin in each.report.wiring], "output")
        for name, each in done.programs.items()
    }
    one, one_cut = ran(done.where, theirs)
    two, two_cut = ran(result, mine)
    found = {}
    for name, each in done.programs.items():
        before, levels = record_of(one, one.chips[name], theirs[name])
        after, started = record_of(two, two.chips[name], mine[name])
        bounds = replace(bounds_of(each.program, each.report), hosted=None)  # a pause may be due to another chip
        found[name] = compared(
            trace_of(each.report.part, before, one_cut),
            trace_of(done.to, after, two_cut),
            bounds,
            ({number: level for number, level in levels.items() if number in mine[name]}, started),
            list(mine[name]),
        )
    return BenchProof(found)


def ran(path: str | PathLike[str], outputs: Mapping[str, Mapping[int, str]]) -> tuple[Bench, bool]:
    """Run a bench file until it is idle; return the bench, and whether the run was cut off at its timeout.

    Args:
        outputs: the names of the pins to record, by chip name and output number.
    """
    file = BenchFile(path)
    recorded = [f"{name}.{pin}" for name, pins in outputs.items() for pin in pins.values()]
    bench = file.load(lambda bench: bench.record(*recorded))
    try:
        bench.run_until_idle(file.tables.bench.timeout)
    except Timeout:
        return bench, True
    return bench, False
