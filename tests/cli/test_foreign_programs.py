"""A program that is not for its chip: status 1, and the chip whose dialect it looks like."""

from __future__ import annotations

import json
from pathlib import Path

from slewline.chips import chip_class, sheet_of
from slewline.cli.dialects import foreign
from tests.rows import rows

EXAMPLES = Path(__file__).parents[2] / "examples"
PROGRAMS = [
    path for path in sorted(EXAMPLES.rglob("*.*")) if path.suffix in (".cy525", ".gs-c200", ".gs-c200s", ".mc1451a")
]
SHUTTLE = ("A 0", "R 100", "N 40", "G")
FAMILY = {"cy525": "cy", "gs-c200s": "gs", "gs-c200": "gs", "mc1451a": "mc"}


def says(text: str, where: str, part: str) -> str:
    return foreign(text, where, chip_class(part), sheet_of(part))


def test_a_program_in_another_dialect_ends_with_status_1(call, write):
    file = write("shuttle.cy525", *SHUTTLE)
    ran = call("run", file, "--chip", "gs-c200s")
    assert ran.status == 1 and "0 steps, 4 findings" in ran.out
    assert ran.err == (
        "slewline: shuttle.cy525: none of its lines is a command of the gs-c200s.  "
        "It looks like a program for the cy525.\n"
    )
    quiet = call("run", file, "--chip", "gs-c200s", "-q")
    assert quiet.status == 1 and "looks like a program for the cy525" in quiet.err
    plain = call("run", file, "--chip", "gs-c200s", "--json")
    assert plain.status == 1 and len(json.loads(plain.out)["findings"]) == 4


def test_so_it_does_on_a_bench_and_in_the_linter(call, write):
    write(
        "b.toml", '[[chip]]\npart = "gs-c200s"\n[[host]]\nchips = ["gs_c200s"]\nscript = ["A 0", "R 100", "N 40", "G"]'
    )
    for command in (("run", "b.toml"), ("lint", "b.toml"), ("lint", write("s.cy525", *SHUTTLE), "--chip", "gs-c200s")):
        ran = call(*command)
        assert ran.status == 1 and "looks like a program for the cy525" in ran.out + ran.err, command


def test_a_chip_that_refuses_before_it_runs_reports_it_too(call, write):
    ran = call("run", write("shuttle.cy525", *SHUTTLE), "--chip", "mc1451a")
    assert ran.status == 2 and ran.err.endswith("command of the mc1451a.  It looks like a program for the cy525.\n")


def test_a_program_that_no_chip_takes_is_refused_in_whole(call, write):
    ran = call("run", write("x.gs-c200s", "hello", "world"))
    assert ran.status == 1
    assert ran.err == "slewline: x.gs-c200s: none of its lines is a command of the gs-c200s.\n"


def test_a_mistake_in_a_program_is_a_finding_and_no_more(call, write):
    assert call("run", write("x.gs-c200s", "S10", "T100", "R1", "hello")).status == 0
    assert call("run", write("z.cy525", "R 200")).status == 0  # a command of the chip, with a wrong value


@rows("path", PROGRAMS)
def test_the_examples_are_for_their_own_chip_and_for_no_other_family(path):
    text, own = path.read_text(), path.suffix[1:]
    assert says(text, path.name, own) == ""
    for part in ("cy525", "gs-c200s", "mc1451a"):
        if FAMILY[part] != FAMILY[own]:
            found = says(text, path.name, part)
            assert not found or found.endswith(f"It looks like a program for the {own}."), (path.name, part)
            assert found or part == "cy525", (path.name, part)  # which takes S, R, G and more of what a GS-C does


def test_bytes_are_not_a_dialect():
    assert says("41 00\n42 00\n", "x.hex", "gs-c200s") == ""
