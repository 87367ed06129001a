"""Commands after a semicolon: a host would not send them, so they are pointed out; comments are not."""

from __future__ import annotations

from pathlib import Path

import pytest

import slewline
from slewline.bench.scripts.script import run_script
from slewline.chips import CATALOGUE, sheet_of
from slewline.errors import ProgramError, UsageError
from slewline.language.assemble import assemble
from slewline.language.lint import lint
from slewline.language.source import BEGINS, commented
from slewline.modules.programs.restore import ProgramText

ROOT = Path(__file__).parents[2]
ONE_LINE = [  # the part, a line, what of it is not sent
    ("cy525", "A 0; F 10; R 80", "F 10; R 80"),
    ("gs-c200s", "Po; S10; T100", "S10; T100"),
    ("gs-c200", "+100; E", "E"),
    ("cy500", "A; R 100;", "R 100"),
    ("cy512", "R 100 ;;N 5", "N 5"),
    ("cy525", "N 20; G", "G"),
    ("cy525", "R 80; F 999", "F 999"),
    ("cy525", "A$N 5; T A", "T A"),
    ("cy545", "R 10; F 1;G", "F 1; G"),
    ("mc1451a", "SET_POS 5; UPDATE", "UPDATE"),
]
COMMENTS = [  # of the CY525
    *("R 80 ; the rate", "; R 80", "0 ; 0", "R 80 ;", "N 20 ; steps; slow", "R 80; r 80", "R 80; R 80 steps/s"),
    *("G ; go", "@wait 1 ms ; G", "A 0 ; ABSOLUTE 0", "R 80 ; A$", "F 10 ; F is 10", ""),
]


@pytest.mark.parametrize(("part", "line", "lost"), ONE_LINE)
def test_commands_after_a_semicolon_are_pointed_out_by_lint_and_by_the_host_that_does_not_send_them(part, line, lost):
    (problem,) = commented(f"; a head\n{line}\n", sheet_of(part))
    assert problem in lint(f"; a head\n{line}\n", sheet_of(part))
    assert (problem.line, problem.column) == (2, line.index(";") + 1)
    assert problem.found == f"{lost} after a semicolon is a comment, and is not sent"
    bench = slewline.Bench()
    host = bench.host(bench.add(part, straps={"chs": 0} if part.startswith("gs-c") else {}))
    run_script(bench, host, line)
    (found,) = host.findings
    assert (found.code, found.text) == ("comment", f"script, line 1: {problem.found}; write one command per line")


@pytest.mark.parametrize("line", COMMENTS)
def test_a_comment_is_not_pointed_out(line):
    assert commented(line, sheet_of("cy525")) == []


@pytest.mark.parametrize("part", ["cy500", "cy525", "cy545", "gs-c200", "gs-c200s", "mc1451a"])
@pytest.mark.parametrize("line", ["# my", "// x", "/* x", "% x"])
def test_a_comment_of_another_language_has_one_remedy(part, line):
    sheet = sheet_of(part)
    for problem in (*lint(line, sheet), *commented(line, sheet)):
        assert problem.remedy == "a comment begins with ;"
    assert len(lint(line, sheet)) == 1
    with pytest.raises(ProgramError, match="a comment begins with ;"):
        assemble(line, sheet)


@pytest.mark.parametrize("line", ["F 10 # first", "F 10 // first"])
def test_a_comment_of_another_language_is_a_finding_of_the_host_that_sends_it(line):
    bench = slewline.Bench()
    host = bench.host(bench.add("cy525"))
    run_script(bench, host, f'A 0\n{line}\n@note # x\n; # x\n"# x"')
    (found,) = host.findings
    assert found.text == f"script, line 2: {line[5:]} is sent to the part; a comment begins with ;"


@pytest.mark.parametrize("line", ["R #", "L #,A", "R # ; switches", '"# x"'])
def test_the_switches_and_the_strings_of_a_cy545_are_not_comments(line):
    assert commented(line, sheet_of("cy545")) == []


def texts():
    """Every program of the repository, and every line with a semicolon of the pages, with the parts it is tried on."""
    for folder in ("examples", "src", "templates", "docs"):
        for path in sorted((ROOT / folder).rglob("*")):
            part = path.suffix[1:]
            if part in CATALOGUE.ours:
                yield path, part, path.read_text("utf-8")
            elif part in ("md", "toml"):
                for line in path.read_text("utf-8").splitlines():
                    if ";" in line and not line.startswith("|"):
                        for part in ("cy500", "cy525", "cy545", "gs-c200s", "mc1451a"):
                            yield path, part, line


def test_no_comment_of_our_programs_and_pages_is_pointed_out():
    seen = 0
    for path, part, text in texts():
        seen += 1
        if not text.startswith("commands "):  # as tune prints them
            found = commented(text, sheet_of(part))
            assert [each for each in found if path.suffix not in (".md", ".toml") or each.remedy != BEGINS] == [], path
    assert seen > 1000


def test_a_program_with_such_a_line_goes_into_no_module():
    with pytest.raises(UsageError, match=r"w\.gs-c200s, line 2: T100 after a semicolon is a comment, and is not sent"):
        ProgramText.read("Po\nS10; T100\nR5\n+9\nE\n", sheet_of("gs-c200s"), "w.gs-c200s")
