"""A motor of one's own on the command line: as text, as a table, in a file; and rates in turns."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from slewline.cli.motors.own import motor_value
from slewline.parts.motors.motors import EXAMPLE, assumptions, read_motor
from tests.rows import rows

FIGURES = """current = "2 A"
resistance = "1.4 ohm"
inductance = "3 mH"
torque = "0.44 Nm"
inertia = "57 g cm2"
"""
TABLE = "{ " + ", ".join(FIGURES.splitlines()) + " }"
LOAD = ("--driver", "24 V, 2 A averaged", "--load", "inertia 20 g cm2")
TUNE = (*LOAD, "--steps", "24", "--perturb", "none", "--no-switching")
QUICK = (*TUNE, "--grid", "F=4 R=8,14 S=200")


@pytest.fixture(autouse=True)
def quick(monkeypatch, folder):
    monkeypatch.setattr("slewline.tuning.judging.engine", lambda: "python")
    monkeypatch.setattr("slewline.parts.motors.calibration.EXACT", 0.3)
    for name, text in (
        ("own.toml", FIGURES),
        ("ROW.TOML", f"motor = {TABLE}\n"),
        ("text.toml", f"motor = '{EXAMPLE}'\n"),
    ):
        (folder / name).write_text(text)


@rows("given", [EXAMPLE, TABLE, "own.toml", "ROW.TOML", "text.toml"])
def test_all_forms_of_giving_a_motor_are_the_same_motor(given):
    named = {"name": Path(given).stem} if given.lower().endswith("oml") and given != "text.toml" else {}
    motor = read_motor(motor_value(given))
    assert motor == read_motor(tomllib.loads(FIGURES) | named)


@rows("given", [EXAMPLE, TABLE, "own.toml"])
def test_both_commands_take_it_and_list_the_assumptions(call, given):
    says = ", ".join(assumptions(EXAMPLE))
    ran = call("tune", "cy525", "--motor", given, *QUICK, "--bench", "found.toml")
    assert ran.status == 0 and f"assumed       {says}\n" in ran.out
    assert call("run", "found.toml").status == 0
    assert call("tune", "cy525", "--motor", given, *QUICK, "--json").json["assumed"] == [*assumptions(EXAMPLE)]
    Path("found.toml").unlink()
    ran = call("calibrate", "--motor", given, *LOAD, "--start-stop", "150 rpm")
    assert ran.status == 0 and f"assumed    {says}\n" in ran.out


def test_a_motor_with_a_name_has_no_line_of_assumptions(call):
    assert "assumed" not in call("tune", "cy525", "--motor", "17HS4401", *QUICK).out


def test_calibrated_values_are_not_assumptions_and_their_row_is_a_motor(call):
    ran = call("calibrate", "--motor", EXAMPLE, *LOAD, "--pull-out", "900 rpm")
    row = next(line for line in ran.out.splitlines() if line.startswith("motor = "))
    assert "assumed" in ran.out and "iron loss 2.66" not in ran.out
    Path("calibrated.toml").write_text(f"{row}\n")
    motor = read_motor(motor_value("calibrated.toml"))
    assert motor.iron == pytest.approx(float(ran.out.split("iron loss")[1].split()[0]) * 1e-3)
    assert (motor.current, motor.inertia) == (2.0, 5.7e-6)


def test_rates_in_turns_are_those_of_the_motor_and_its_steps(call):
    for angle, stepping, per_turn in (("", "full", 200), (", step angle 0.9 deg", "full", 400), ("", "micro 4", 800)):
        turns = "SET_VEL=60 rpm,2 rev/s SET_ACC=20 rev/s2 SET_START_VEL=0"
        steps = f"SET_VEL={per_turn} steps/s,{2 * per_turn} steps/s SET_ACC={20 * per_turn} steps/s2 SET_START_VEL=0"
        more = ("--motor", EXAMPLE + angle, *TUNE, "--stepping", stepping, "--map", "--jobs", "1", "--json")
        found = [call("tune", "mc1451a", *more, "--grid", grid).json["map"] for grid in (turns, steps)]
        assert found[0] == found[1] and len(found[0]) == 2


@rows(
    ("given", "says"),
    [
        ("17HE19-2004S", "; for another motor use the figures of its data sheet: 'current 2 A, resistance 1.4 ohm"),
        ("current 2 A, inertia 57 g cm2", "motor needs resistance (ohm: resistance of a phase), inductance (H: "),
        ("{ current = 2 }", "--motor needs resistance (ohm: resistance of a phase), inductance (H: "),
        ("{ current = ", "--motor: not TOML"),
        ("gone.toml", "gone.toml cannot be read"),
        ("short.toml", "short.toml needs resistance (ohm: resistance of a phase)"),
        ("bench.toml", "bench.toml is a bench file; allowed: the figures of one motor"),
        ("word.toml", "word.toml: no option 'volts'"),
        ("unit.toml", "unit.toml: torque '0.44 kg'; kg is a unit of mass; allowed 0 or more N m"),
    ],
)
def test_a_motor_that_cannot_be_is_refused(call, folder, given, says):
    (folder / "short.toml").write_text('current = "2 A"\n')
    (folder / "bench.toml").write_text('[[part]]\nkind = "stepper"\n')
    (folder / "word.toml").write_text(f"{FIGURES}volts = 3\n")
    (folder / "unit.toml").write_text(FIGURES.replace("0.44 Nm", "0.44 kg"))
    for command in (("tune", "cy525", *QUICK), ("calibrate", *LOAD, "--pull-out", "900 steps/s")):
        ran = call(*command, "--motor", given)
        assert ran.status == 2 and says in ran.err and "did you mean 17" not in ran.err


@rows(
    ("command", "says"),
    [
        (
            ("ramp", "mc1451a", "SET_VEL=600 rpm"),
            "the motor's steps per revolution are not known here; convert the rate to steps/s",
        ),
        (("ramp", "gs-c200s", "T=600 rpm"), "rate '600 rpm': the motor's steps per revolution"),
        (("calibrate", "--motor", EXAMPLE, *LOAD, "--pull-out", "5 Nm"), "--pull-out '5 Nm'; Nm is a unit of torque"),
        (
            ("calibrate", "--motor", EXAMPLE, *LOAD, "--pull-out", "900 steps/s", "--torque", "3 rpm"),
            "rpm is a unit of rate",
        ),
    ],
)
def test_a_unit_that_does_not_fit_is_named(call, command, says):
    ran = call(*command)
    assert ran.status == 2 and says in ran.err


def test_a_large_ripple_is_reported_by_both_commands(call):
    small = ("--motor", "QSH4218-47-28-040", "--driver", "24 V, 2.8 A averaged", "--load", "inertia 68 g cm2")
    says = "chopper at 20 kHz: the current ripples by up to 0.5 A of 2.8 A"
    ran = call("tune", "cy525", *QUICK, *small)
    assert ran.status == 0 and f"note          {says}" in ran.out
    assert [each[: len(says)] for each in call("tune", "cy525", *QUICK, *small, "--json").json["notes"]] == [says]
    held = call("tune", "cy525", *QUICK, *small, "--driver", "24 V, 2.8 A averaged", "--motor", "AS1010").out
    assert "ripples" not in held and "note          2.8 A per phase, but AS1010 is rated 1 A: it gets hot" in held
    ran = call("calibrate", *small, "--start-stop", "900 steps/s")
    assert ran.status == 0 and f"note       {says}" in ran.out
