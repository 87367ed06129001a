"""Options of a chip from a TOML file: a rate table of one's own, and every tool speaks of it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import slewline
from slewline.cli.commands import serve_command
from slewline.cli.live.serve import ServeCommand
from slewline.errors import UsageError

MINE = [10 * (k + 1) for k in range(256)]


@pytest.fixture
def mine(write):
    return write("mine.toml", "ramp_jumps = false", "[inferred]", f"rates = {MINE}")


@pytest.mark.fact("CY545-RATE-4")
def test_the_ramp_calculator_uses_the_rates_in_the_file(call, mine):
    ours = call("ramp", "cy545", "F=14", "R=100", "S=220", "--distance", "10000")
    theirs = call("ramp", "cy545", "F=14", "R=100", "S=220", "--distance", "10000", "--options", mine)
    assert "370 to 4119 steps/s" in ours.out and "up 1599, slew 6802, down 1599" in ours.out
    assert "150 to 1010 steps/s" in theirs.out and "up 455, slew 9090, down 455" in theirs.out
    asked = call("ramp", "cy545", "F=14", "R=2000 steps/s", "--time", "0.5 s", "--options", mine, "--json").json
    assert asked["found"][0]["parameters"] == {"F": 14, "R": 199, "S": 245, "ramp_jumps": "False"}
    assert slewline.ramp("cy545", F=14, R=100, S=220, options={"inferred": {"rates": MINE}}).top == pytest.approx(
        1010, 1e-4
    )


def test_the_reference_lists_the_rates_in_the_file(call, mine):
    assert "| **8** | 90 | 100 | 110 |" in call("describe", "cy545b", "--options", mine).out
    assert "| **8** | 220 | 245 | 270 |" in call("describe", "cy545b").out


def test_lint_uses_the_rates_in_the_file(call, mine, write):
    program = write("p.cy545", "+", "N 2000", "G")
    assert "R 100 is not reached: each ramp takes 1599 steps" in call("lint", program).out
    assert "no problems found" in call("lint", program, "--options", mine).out


@pytest.mark.parametrize("how", ["file", "bench"])
def test_a_run_and_the_script_of_a_bench_file_have_them(call, mine, write, how):
    program = write("p.cy545", "+", "F 9", "R 9", "N 30", "G")
    if how == "file":
        told = call("run", program, "--options", mine, "--json", "-").json
    else:
        options = f"options = {{ inferred = {{ rates = {json.dumps(MINE)} }} }}"
        bench = write("b.toml", "[[chip]]", 'part = "cy545"', options, "[[host]]", f'file = "{program}"')
        told = call("run", bench, "--json", "-").json["chips"]["cy545"]
        lines = Path(program).read_text().splitlines()
        write("p.cy545", *lines[:1], "N 2000", "G")  # lint reckons with the options of the chip, too
        assert "short-move" not in call("lint", bench).out
    assert 0.3 * 10**12 < told["time_ps"] < 0.31 * 10**12  # 30 steps, 100 a second


def test_an_invalid_file_is_refused_with_the_allowed_keys(call, write):
    for lines, says in (
        (("rate_table = ",), "bad.toml: not TOML"),
        (("[[chip]]", 'part = "cy545"'), "bad.toml is a bench file; allowed: options of a chip"),
        (('rate_table = "30k"',), "rate_table '30k'; allowed 20k, 27k"),
        (("rates = [1, 2]",), "did you mean inferred.rates?"),
        (("[inferred]", "rates = [1, 2]"), "2 numbers; allowed 256 or none"),
        (("[inferred]", f"rates = {[100] * 255 + [0]}"), "100, 100, ...; 0 at 255; allowed whole numbers, each 1.."),
        (("[inferred]", f"rates = {[100] * 9 + [1.5] + [100] * 246}"), "...; 1.5 at 9; allowed whole numbers"),
    ):
        bad = write("bad.toml", *lines)
        status, _, err = call("ramp", "cy545", "F=14", "R=100", "S=220", "--options", bad)
        assert status == 2 and says in err, err
    program = write("p.cy545", "G")
    bench = write("b.toml", "[[chip]]", 'part = "cy545"')
    assert call("lint", bench, "--options", bad).status == 2
    assert call("run", bench, "--options", bad).status == 2
    status, _, err = call("run", program, "--options", "missing.toml")
    assert status == 2 and "missing.toml cannot be read" in err


def test_a_message_about_a_wrong_option_names_the_file_and_the_part(call, write):
    program, bad = write("p.cy545", "G"), write("bad.toml", 'crystal = "12 MHz"')
    for command in (
        ("run", program), ("lint", program), ("ramp", "cy545"), ("describe", "cy545"),
        ("serve", "cy545", "--tcp", "127.0.0.1:0"),
    ):  # fmt: skip
        status, _, err = call(*command, "--options", bad)
        assert status == 2 and f"{bad}: cy545: no option 'crystal'; its options: " in err, err
    status, _, err = call("serve", "cy545", "--tcp", "127.0.0.1:0", "--option", "straps=1")
    assert status == 2 and "cy545: no option 'straps'" in err


def test_from_python_wrong_options_are_refused_likewise():
    with pytest.raises(UsageError, match="allowed 20k, 27k"):
        slewline.ramp("cy545", F=14, R=100, S=220, options={"rate_table": "30k"})


def test_served_parts_have_them_too_and_an_option_on_the_command_line_wins(mine):
    given = ["cy545", "--tcp", "127.0.0.1:0", "--options", mine, "--option", "inferred.pulse_low=80"]
    context = serve_command.make_context("serve", [*given, "--option", "ramp_jumps=true"])
    chip = ServeCommand(**context.params).new_bench(None).chips["cy545"]
    assert chip.sheet.rates == tuple(MINE)
    assert chip.options.inferred["pulse_low"] == 80 and chip.options.ramp_jumps
