"""`slewline calibrate` prints constants, and the rows that have them."""

from __future__ import annotations

import pytest

GIVEN = (
    "calibrate",
    "--motor",
    "QSH4218-51-10-049",
    "--driver",
    "L/4R 20 V",
    "--load",
    "inertia 68 g cm2, friction 1 mNm",
)


@pytest.mark.long  # docs/howto/motors.md has the same lines for another motor
def test_constants_and_rows_are_printed(call):
    lines = call(*GIVEN, "--start-stop", "1190 steps/s", "--pull-out", "2450 steps/s").out.splitlines()
    friction, iron, _, motor, load = lines
    assert friction.startswith("friction ") and friction.endswith(" mN m; so far 1")
    assert iron.startswith("iron loss ") and iron.endswith(" mN m s; so far 1.3")
    assert motor.startswith('motor = { like = "QSH4218-51-10-049", iron = 0.00')
    assert (
        load.startswith('load = "inertia 68 g cm2, friction ')
        and load.endswith(' mNm"')
        and load.count("friction") == 1
    )


def test_the_same_as_data(call, monkeypatch):
    monkeypatch.setattr("slewline.parts.motors.calibration.EXACT", 0.3)
    found = call(*GIVEN, "--pull-out", "2450 steps/s", "--torque", "5 mNm", "--json").json
    assert found["friction_nm"] is None and 0 < found["iron_nms"] < 3e-3
    assert found["before"]["friction_nm"] == 0.001
    assert found["rows"][1] == 'load = "inertia 68 g cm2, friction 1 mNm"'


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ((), "nothing to calibrate with"),
        (
            ("--pull-out", "fast"),
            "--pull-out 'fast'; allowed a number (steps/s), or text with a unit: steps/s, rev/s, rpm",
        ),
        (
            ("--pull-out", "2450 steps/s", "--torque", "5 kg"),
            "--torque '5 kg'; kg is a unit of mass; allowed a number (N m), or text with a unit",
        ),
        (("--start-stop", "9000 steps/s"), "does not reach it even without friction"),
        (("--start-stop", "900 steps/s", "--torque", "5 mNm"), "torque 0.005 N m needs a pull-out rate"),
        (("--pull-out", "2000 steps/s", "--torque", "50"), "--torque '50'; 50 has no unit; allowed a number (N m)"),
        (("--start-stop", "1210 steps/s", "--pull-out", "1100 steps/s"), "check whether the two rates are exchanged"),
    ],
)
def test_mistakes_are_reported(call, given, says):
    ran = call(*GIVEN, *given)
    assert ran.status == 2 and says in ran.err


def test_an_interrupt_reports_that_nothing_is_kept(call, monkeypatch):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("slewline.cli.motors.calibrate.calibrated", interrupt)
    ran = call(*GIVEN, "--pull-out", "2450 steps/s")
    assert ran.status == 1
    assert ran.err.strip() == "slewline: interrupted; a calibration stores no results: run the command again"
