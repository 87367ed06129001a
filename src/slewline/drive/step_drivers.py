"""Step drivers: minimum pulse times, set-up and hold times of DIR, and the active level of ENABLE.

The times are required by the data sheets, at the pins of the driver.  Modules with optocouplers are
wired as on the page of each board: the inputs marked - to ground, the inputs marked + to the board.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from ..core.messages.near import same_part
from ..core.time.timebase import picoseconds, readable
from ..errors import UnknownName, UsageError

NS = 1000  # ps


TIMES = ("high", "low", "setup", "hold")
OWN = "high 30 us, low 30 us, setup 5 us, hold 5 us"


class StepDriver(NamedTuple):
    """A driver with STEP and DIR inputs.

    `high_ps`, `low_ps`: the minimum times for which STEP must be high and low; `setup_ps`, `hold_ps`: the
    minimum times for which DIR must be stable before and after STEP rises; `enabled`: the level of ENABLE at
    which the driver energises the motor; `source`: the data sheet.
    """

    name: str
    high_ps: int
    low_ps: int
    setup_ps: int
    hold_ps: int
    enabled: int
    source: str


def _row(name: str, times_ns: tuple[int, int, int, int], enabled: int, source: str) -> StepDriver:
    high, low, setup, hold = (time * NS for time in times_ns)
    return StepDriver(name, high, low, setup, hold, enabled, source)


STEP_DRIVERS: Mapping[str, StepDriver] = MappingProxyType(
    {
        row.name: row
        for row in (
            _row("A4988", (1000, 1000, 200, 200), 0, "Allegro, A4988 data sheet: timing of STEP, setup and hold"),
            _row("DRV8825", (1900, 1900, 650, 650), 0, "Texas Instruments, DRV8825 data sheet: timing requirements"),
            _row("TMC2209", (100, 100, 20, 20), 0, "Trinamic, TMC2209 data sheet: STEP/DIR interface timing"),
            _row(
                "TB6600",
                (2200, 2200, 5000, 5000),
                0,
                "Toshiba, TB6600HG data sheet: clock; DIR as usual for optocouplers",
            ),
            _row("DM542", (2500, 2500, 5000, 5000), 0, "Leadshine, DM542 manual: sequence chart of control signals"),
            _row("L297", (500, 500, 1000, 4000), 1, "SGS-Thomson, L297 data sheet: clock time, set-up and hold time"),
        )
    }
)


def step_driver(
    name: str, remedy: str = "leave it out, and compare its data sheet with the times of the board"
) -> StepDriver:
    """Return a driver by its name, in upper or lower case.

    Args:
        name: the driver.
        remedy: the remedy that the message names if the driver is unknown.

    Raises:
        UnknownName: there is no driver of this name.
    """
    for known, row in STEP_DRIVERS.items():
        if known.lower() == name.lower():
            return row
    there = ", ".join(STEP_DRIVERS)
    raise UnknownName(f"driver {name!r}; known: {there}{same_part(name, STEP_DRIVERS)}; for any other driver, {remedy}")


def own_driver(text: str) -> StepDriver:
    """Return a driver defined by its data sheet times: "high 30 us, low 30 us, setup 5 us, hold 5 us".

    Raises:
        UsageError: a key is unknown or is given twice, or neither `high` nor `low` is given.
        TimeError: the text after a key is not a time.
    """
    found: dict[str, int] = {}
    for each in text.split(","):
        key, _, time = each.strip().partition(" ")
        if key not in TIMES or key in found:
            raise UsageError(f"driver {text!r}: {key!r}; allowed {', '.join(TIMES)}, each once, such as {OWN!r}")
        found[key] = picoseconds(time.strip())
    if not found.keys() & {"high", "low"}:
        raise UsageError(f"driver {text!r}: expected minimum times of STEP high or low, such as {OWN!r}")
    high, low, setup, hold = (found.get(key, 0) for key in TIMES)
    return StepDriver("this driver", high, low, setup, hold, 0, "its data sheet")


def check_pulse(driver: StepDriver, high_ps: int, low_ps: int, setup_ps: int, hold_ps: int) -> None:
    """Check that the times of a board are long enough for a driver.

    Args:
        high_ps, low_ps, setup_ps, hold_ps: the minimum times that the board guarantees, ps.

    Raises:
        UsageError: one of them is too short.
    """
    rows = (
        ("STEP is high", high_ps, driver.high_ps),
        ("STEP is low", low_ps, driver.low_ps),
        ("DIR is stable before STEP", setup_ps, driver.setup_ps),
        ("DIR is stable after STEP", hold_ps, driver.hold_ps),
    )
    for what, has, needs in rows:
        if has < needs:
            raise UsageError(
                f"driver {driver.name}: {what} for at least {readable(has)}, but the driver needs {readable(needs)}; "
                "use another driver"
            )
