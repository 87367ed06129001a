"""calibrate: the friction and iron loss of a motor and its machine, from measurements."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import click

from ...core.datasheet.units import quantity
from ...parts.motors.calibration import Calibration
from ...parts.motors.calibration import calibrate as calibrated
from ...parts.motors.choppers import chopper_notes
from ...parts.motors.drivers import read_driver
from ...parts.motors.loads import read_load
from ...parts.motors.motors import assumptions, is_described, motor_table, read_motor
from ...tuning.tuned_bench_file import toml
from ..programs import print_json
from .own import OPTION, motor_value

REPLACED = ("friction", "stiction", "force")  # of a load, replaced by the friction found


def calibrate(
    motor: str, driver: str, load: str, start_stop: str | None, pull_out: str | None, torque: str, stepping: str,
    as_json: bool,
) -> int:  # fmt: skip
    """Print the constants found from the measurements, and rows `motor` and `load` for a bench file; return 0."""
    given = motor_value(motor)
    its = read_motor(given, OPTION)
    drives = read_driver(driver, "--driver", its)
    notes = chopper_notes(its, drives, driver)
    try:
        found = calibrated(
            its,
            drives,
            read_load(load, "--load", its),
            start_stop=rate(start_stop, "--start-stop", its.full_steps),
            pull_out=rate(pull_out, "--pull-out", its.full_steps),
            torque=quantity(torque, "N m", "--torque"),
            steps=stepping,
        )
    except KeyboardInterrupt as interrupt:
        interrupt.args = ("interrupted; a calibration stores no results: run the command again",)
        raise
    rows = rows_of(found, given, load)
    assumed = [each for each in assumptions(given) if found.iron is None or not each.startswith("iron")]
    if as_json:
        friction, iron = found.before
        print_json(
            {"friction_nm": found.friction, "iron_nms": found.iron, "rows": rows}
            | {"before": {"friction_nm": friction, "iron_nms": iron}, "assumed": assumed, "notes": notes}
        )
        return 0
    for name, value, before, unit in (
        ("friction", found.friction, found.before[0], "mN m"),
        ("iron loss", found.iron, found.before[1], "mN m s"),
    ):
        if value is not None:
            click.echo(f"{name:9}  {value * 1e3:.3g} {unit}; previously assumed {before * 1e3:.3g}")
    if assumed:
        click.echo(f"assumed    {', '.join(assumed)}")
    for note in notes:
        click.echo(f"note       {note}")
    click.echo()
    for row in rows:
        click.echo(row)
    return 0


def rate(text: str | None, name: str, per_turn: int) -> float | None:
    """Return the rate that a text states, in full steps/s; None if the text is None.

    Args:
        per_turn: full steps per revolution of the motor.

    Raises:
        UsageError: the text is not a rate.
    """
    return None if text is None else quantity(text, "steps/s", name, per_turn)


def rows_of(found: Calibration, motor: str | Mapping[str, Any], load: str) -> list[str]:
    """Return the lines `motor` and `load` for a bench file: the user's values, with the constants found."""
    iron = {} if found.iron is None else {"iron": float(f"{found.iron:.3g}")}
    if isinstance(motor, str) and not is_described(motor):
        rows = [f"motor = {toml({'like': motor} | iron if iron else motor)}"]
    else:
        rows = [f"motor = {toml(motor_table(motor) | iron)}"]
    if found.friction is not None:
        kept = [part.strip() for part in load.split(",") if part.strip() and part.split()[0] not in REPLACED]
        load = ", ".join([*kept, f"friction {found.friction * 1e3:.3g} mNm"])
    return [*rows, f'load = "{load}"']
