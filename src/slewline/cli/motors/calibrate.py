"""calibrate: friction and iron loss of a motor and its machine, from what was measured on it."""

from __future__ import annotations

import re

import click

from ...core.datasheet.units import quantity
from ...errors import UsageError
from ...parts.motors.calibrate import Calibration
from ...parts.motors.calibrate import calibrate as calibrated
from ...parts.motors.drivers import read_driver
from ...parts.motors.loads import read_load
from ...parts.motors.motors import read_motor
from ..programs import print_json

RATE = re.compile(r"([0-9]+(?:\.[0-9]*)?)\s*(steps/s)?")
REPLACED = ("friction", "stiction", "force")  # of a load, by the friction that was found


def calibrate(
    motor: str, driver: str, load: str, start_stop: str | None, pull_out: str | None, torque: str, stepping: str,
    as_json: bool,
) -> int:  # fmt: skip
    """Print the constants, and the rows for a bench file."""
    its = read_motor(motor, "--motor")
    found = calibrated(
        its,
        read_driver(driver, "--driver", its),
        read_load(load, "--load", its),
        start_stop=rate(start_stop, "--start-stop"),
        pull_out=rate(pull_out, "--pull-out"),
        torque=quantity(_number(torque), "N m", "--torque"),
        steps=stepping,
    )
    rows = rows_of(found, motor, load)
    if as_json:
        friction, iron = found.before
        print_json(
            {"friction_nm": found.friction, "iron_nms": found.iron, "rows": rows}
            | {"before": {"friction_nm": friction, "iron_nms": iron}}
        )
        return 0
    for name, value, before, unit in (
        ("friction", found.friction, found.before[0], "mN m"),
        ("iron loss", found.iron, found.before[1], "mN m s"),
    ):
        if value is not None:
            click.echo(f"{name:9}  {value * 1e3:.3g} {unit}; so far {before * 1e3:.3g}")
    click.echo()
    for row in rows:
        click.echo(row)
    return 0


def rate(text: str | None, name: str) -> float | None:
    """Return a rate in full steps/s.

    Raises:
        UsageError: it is none.
    """
    if text is None:
        return None
    found = RATE.fullmatch(text.strip())
    if found is None:
        raise UsageError(f"{name} {text!r}; allowed full steps/s, such as '1800 steps/s'")
    return float(found[1])


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def rows_of(found: Calibration, motor: str, load: str) -> list[str]:
    """Return the lines for a bench file."""
    iron = "" if found.iron is None else f", iron = {found.iron:.3g}"
    rows = [f'motor = {{ like = "{motor}"{iron} }}'] if iron else [f'motor = "{motor}"']
    if found.friction is not None:
        kept = [part.strip() for part in load.split(",") if part.strip() and part.split()[0] not in REPLACED]
        load = ", ".join([*kept, f"friction {found.friction * 1e3:.3g} mNm"])
    return [*rows, f'load = "{load}"']
