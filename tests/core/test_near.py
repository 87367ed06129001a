"""One measure for all suggestions: what is near, and what is too far to be suggested."""

from __future__ import annotations

import ast
from pathlib import Path

import slewline
from slewline.cli.commands import cli
from slewline.core.messages.near import distance, hint, near
from tests.rows import rows

SOURCES = Path(slewline.__file__).parent
OPTIONS = sorted({name for command in cli.commands.values() for each in command.params for name in each.opts})
COMMANDS = [*cli.commands]
PARTS = ["cy500", "cy512", "cy525", "cy545", "cy545b", "gs-c200", "gs-c200s", "mc1151a", "mc1451a", "mc1451a-e"]
PINS = ["pulse", "direction", "slew", "abort", "motion_complete", "wait", "io_select", "dowhile"]
FORMS = ["SET_VEL", "GET_VEL", "SET_ACC", "SET_JERK", "GET_VRSN", "UPDATE"]
NEAR = [
    ("--jason", OPTIONS, "--json"),
    ("--quite", OPTIONS, "--quiet"),
    ("--no_browser", OPTIONS, "--no-browser"),
    ("--timout", OPTIONS, "--timeout"),
    ("--strpa", OPTIONS, "--strap"),
    ("--crystel", OPTIONS, "--crystal"),
    ("--allowcode", OPTIONS, "--allow-code"),
    ("--journl", OPTIONS, "--journal"),
    ("--resol", OPTIONS, "--resolve"),
    ("rnu", COMMANDS, "run"),
    ("descirbe", COMMANDS, "describe"),
    ("exmaples", COMMANDS, "examples"),
    ("cmopare", COMMANDS, "compare"),
    ("newchip", COMMANDS, "new-chip"),
    ("cy255", PARTS, "cy525"),
    ("GSC200S", PARTS, "gs-c200s"),
    ("mc1451", PARTS, "mc1451a"),
    ("abrt", PINS, "abort"),
    ("slow", PINS, "slew"),
    ("motioncomplete", PINS, "motion_complete"),
    ("dir", PINS, "direction"),
    ("SET_VLE", FORMS, "SET_VEL"),
    ("GETVRSN", FORMS, "GET_VRSN"),
    ("ZZ", ["Z", "X"], "Z"),
    (1451, ["m1451"], "m1451"),
]
FAR = [
    ("--port", ["--rate", "--listen", "--strap", "--attach"]),
    ("--verbose", ["--over", "--vcd-buses", "--quiet"]),
    ("--stop", ["--steps", "--strap"]),
    ("--start", ["--strap", "--strict", "--rate"]),
    ("--time", ["--timescale", "--timeout"]),  # two go on so
    ("--output", ["--input", "--options"]),
    ("--baud", ["--board", "--bench"]),
    ("--speed", ["--steps"]),
    ("--debug", ["--bench"]),
    ("install", COMMANDS),
    ("train", COMMANDS),
    ("simulate", COMMANDS),
    ("tmc2209", PARTS),
    ("a4988", PARTS),
    ("cy", PARTS),
    ("clock", PINS),
    ("position", PINS),
    ("speed", ["current", "torque"]),
    ("driver.speed", ["driver.current", "driver.supply"]),
    ("BR", ["BB", "RR"]),
    ("", PINS),
]


@rows(("word", "names", "meant"), NEAR)
def test_a_near_name_is_suggested(word, names, meant):
    assert near(word, names)[0] == meant and hint(word, names) == f"; did you mean {meant}?"


@rows(("word", "names"), FAR)
def test_distant_names_are_not_suggested(word, names):
    assert near(word, names) == [] and hint(word, names) == ""


def test_the_nearest_comes_first_and_case_stays():
    assert near("set_vel", ["SET_VLE", "SET_VEL", "SET_VELS"])[0] == "SET_VEL"


@rows(
    ("one", "other", "slips"),
    [
        ("", "abc", 3),
        ("abc", "", 3),
        ("run", "rnu", 1),
        ("ca", "abc", 3),
        ("kitten", "sitting", 3),
        ("axis", "axis", 0),
    ],
)
def test_a_slip_is_a_letter_or_two_that_are_swapped(one, other, slips):
    assert distance(one, other) == distance(other, one) == slips


def test_there_is_no_other_measure():
    measures = {"difflib", "get_close_matches", "possibilities"}
    for path in SOURCES.rglob("*.py"):
        names = {
            getattr(node, "id", None) or getattr(node, "attr", None) or getattr(node, "module", None)
            for node in ast.walk(ast.parse(path.read_text("utf-8")))
        }
        assert not names & measures, path
