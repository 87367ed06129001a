"""What is wired to a board, in the user's words: outputs, driver, phases; and how the board is configured for it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..core.messages.near import hint
from ..core.time.timebase import PS_PER_S
from ..errors import UsageError
from .board.wire import BoardConfig
from .drivers import check_pulse, step_driver

if TYPE_CHECKING:
    from ..core.chip import Chip
    from .board.boards import BoardModel

START_STOP = 500  # steps/s, of the way down of a board that has no table
WATCHDOG_PS = 50 * 10**9  # beyond the horizon, without a word from the host
ACTIVE_LOW_ENABLE = 2  # a bit of the polarity


def steps_a_second(rate: str | int) -> int:
    """Return the steps/s of a rate such as "500 steps/s", or of a whole number.

    Raises:
        UsageError: no such rate, or 0.
    """
    found = re.fullmatch(r"\s*(\d{1,7})\s*(steps/s)?\s*", str(rate))
    if found is None or not int(found[1]):
        raise UsageError(f"rate {rate!r}; expected steps per second, such as '500 steps/s'")
    return int(found[1])


def outputs_of(board: BoardModel, chip: Chip, wiring: Mapping[str, str] | None) -> dict[int, str]:
    """Return the pins of a chip by the number of the board's output that shows them.

    Args:
        wiring: pins by the printed names of outputs, such as {"D2": "uo1"}; None: those that programs set.

    Raises:
        UsageError: no such output of the board, or no such output of the chip.
    """
    printed = [pin.printed for pin in board.outputs]
    rows = {row.name: row for row in chip.sheet.pins if row.way in ("out", "both")}
    if wiring is None:
        roles = {row.role: row.name for row in rows.values()}
        return {
            number: roles[f"output{number + 1}"] for number in range(len(printed)) if f"output{number + 1}" in roles
        }
    found = {}
    for name, pin in wiring.items():
        if name.upper() not in printed:
            raise UsageError(f"output {name!r} of the board; allowed {', '.join(printed)}")
        if pin not in rows:
            raise UsageError(
                f"output {name}: {pin!r} is no output of {chip.name}; allowed {', '.join(rows)}{hint(pin, rows)}"
            )
        found[printed.index(name.upper())] = pin
    return found


def polarity_of(board: BoardModel, driver: str | None) -> int:
    """Return the polarity of a board for a driver; without one, ENABLE is active high.

    Raises:
        UnknownName: no such driver.
        UsageError: the pulses of the board are too short for it.
    """
    if driver is None:
        return 0
    row = step_driver(driver)
    check_pulse(row, *(ticks * PS_PER_S // board.hz for ticks in (board.high, board.low, board.setup, board.hold)))
    return 0 if row.enabled else ACTIVE_LOW_ENABLE


def pattern_of(chip: Chip) -> tuple[int, ...]:
    """Return the phases of a chip by the index of half steps, phase 1 in bit 0; a chip without phases has none."""
    whole = [sum(level << n for n, level in enumerate(row)) for row in chip.phase_patterns()]
    if len(whole) in (0, 8):
        return tuple(whole) or (0,) * 8
    return tuple(
        value for one, after in zip(whole, (*whole[1:], whole[0]), strict=True) for value in (one, one | after)
    )


def usual_config(
    board: BoardModel, chip: Chip, horizon_ps: int, start_stop: int | None, driver: str | None
) -> BoardConfig:
    """Return the configuration of a board for a chip and a driver, without inputs.

    Args:
        start_stop: steps/s; None: the usual one.
    """
    return BoardConfig(
        start_stop=board.hz // (start_stop or START_STOP),
        watchdog=(horizon_ps + WATCHDOG_PS) * board.hz // PS_PER_S,
        polarity=polarity_of(board, driver),
        pattern=pattern_of(chip),
    )
