"""Random programs from every part to every target: what became of each, and whether the proof holds.

    python -m tests.translation.ensemble RESULTS.csv [--pairs SOURCE-TO ...] [--seeds FIRST-LAST] [--any]

With --any the programs have any commands, and a host that acts during motions (any_programs.py).
A row for each program is appended to RESULTS.csv; those that it has are not run again, so that a pass can be stopped
and resumed.  What is printed at the end is a table of outcomes by pair.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from pathlib import Path

from slewline.chips import PARTS
from slewline.translation.program_facts import counter_of
from slewline.translation.proof.play import Played
from slewline.translation.proof.prove import played, prove
from slewline.translation.source_text.reading import read_program
from slewline.translation.translate import DRIVEN, translate_text
from slewline.translation.translation_report import LineKind
from slewline.translation.writers import TARGETS
from tests.translation.any_programs import any_program
from tests.translation.programs import random_program

NAMED = [("cy512", "cy525"), ("cy525", "gs-c200s"), ("gs-c200", "gs-c200s")]
NAMED += [(part, to) for to in ("linuxcnc", "grbl", "arduino") for part in PARTS]
OTHERS = [(part, to) for part in PARTS for to in (*PARTS, *TARGETS) if part != to and (part, to) not in NAMED]
PROVEN, FAILED = "proven", "FAILED"
PROVEN_BUT = "proven, but for lines that are not possible"
PARTLY = "not possible, and different by that"
ASSUMED = "an assumption of the report does not hold"
BROKEN = ("wrong-way", "E5")  # findings in the run of the source that break an assumption


@lru_cache(maxsize=32)
def run_of(source: str, text: str) -> Played:
    """Return the run of a program by its own part."""
    return played(read_program(text, source), text)


def outcome(source: str, to: str, text: str) -> tuple[str, str]:
    """Return what became of a program: proven, not possible in part, or failed; and what that is about."""
    done = translate_text(text, source, to)
    impossible = [line for line in done.report if line.kind is LineKind.IMPOSSIBLE]
    uncited = [each.text for line in impossible for each in line.verdicts if each.kind is line.kind and not each.limit]
    if uncited:
        return FAILED, f"no limit: {uncited[0]}"
    proof = prove(done, run_of(source, text))
    if proof.lint or proof.compared is None:
        return FAILED, "; ".join(proof.lint) or "not run"
    driven = any(each.value == DRIVEN for each in done.report.assumed)
    broken = any(finding.code in BROKEN for finding in proof.source.bench.findings) or overflowed(proof.source)
    if not proof.proven and (driven or broken):
        return ASSUMED, proof.compared.text
    if not impossible:
        return (PROVEN if proof.proven else FAILED), proof.compared.text
    about = f"{len(impossible)} of {len(done.report.lines)} lines not possible; {impossible[0].verdicts[0].limit}"
    return (PROVEN_BUT if proof.proven else PARTLY), about


def overflowed(source: Played) -> bool:
    """Return whether a move has led through the overflow of the position counter: no program here moves so far."""
    counter = counter_of(source.chip.sheet)
    moves = [abs(each.value) for each in source.trace.happened if each.kind == "move"]
    return counter is not None and max(moves, default=0) > (counter[1] - counter[0]) // 2


def run(pairs: Iterable[tuple[str, str]], seeds: range, results: Path, made: Callable[[str, int], str]) -> None:
    """Run what a file of results has not yet, and append it."""
    known = {(row[0], row[1], int(row[2])) for row in rows(results)}
    with results.open("a", encoding="utf-8", newline="") as file:
        out = csv.writer(file)
        wanted = sorted(dict.fromkeys(pairs), key=lambda pair: list(PARTS).index(pair[0]))
        for seed, (source, to) in ((seed, pair) for seed in seeds for pair in wanted):
            if (source, to, seed) not in known:
                try:
                    found = outcome(source, to, made(source, seed))
                except Exception as error:  # it is a result, and the others are wanted as well
                    found = (FAILED, repr(error))
                out.writerow((source, to, seed, *found))
                file.flush()


def rows(results: Path) -> Iterator[list[str]]:
    """Yield the rows of a file of results."""
    if results.exists():
        with results.open(encoding="utf-8", newline="") as file:
            yield from csv.reader(file)


def table(results: Path) -> Iterator[str]:
    """Yield a line for each pair: how many of its programs came to what; then those that failed."""
    counts: dict[tuple[str, str], Counter[str]] = {}
    failed = []
    for source, to, seed, what, about in rows(results):
        counts.setdefault((source, to), Counter())[what] += 1
        if what == FAILED:
            failed.append(f"FAILED {source}-{to} {seed}: {about}")
    for (source, to), found in counts.items():
        yield f"{source + ' to ' + to:24}" + ", ".join(f"{number} {what}" for what, number in found.items())
    yield from failed


def main(words: list[str]) -> None:
    """Run the ensemble from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=Path)
    parser.add_argument("--pairs", nargs="*", default=[], metavar="SOURCE:TO", help="named, others, or pairs")
    parser.add_argument("--seeds", default="0-19", metavar="FIRST-LAST")
    parser.add_argument("--any", action="store_true", help="any commands, and a host that acts during motions")
    given = parser.parse_args(words)
    named = {"named": NAMED, "others": OTHERS}
    pairs: list[tuple[str, str]] = []
    for word in given.pairs or ["named", "others"]:
        source, _, to = word.partition(":")
        pairs += named.get(word) or [(source, to)]
    first, last = map(int, given.seeds.split("-"))
    run(pairs, range(first, last + 1), given.results, any_program if given.any else random_program)
    print("\n".join(table(given.results)))


if __name__ == "__main__":
    main(sys.argv[1:])
