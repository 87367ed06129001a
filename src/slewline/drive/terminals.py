"""The wiring of a board, in the user's words (outputs, driver, phases), and the configuration that follows from it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from ..core.datasheet.units import other_kind
from ..core.messages.decimal_comma import without_comma
from ..core.messages.near import hint
from ..core.time.timebase import PS_PER_S, Time, picoseconds, readable
from ..errors import TimeError, UsageError
from .board.wire import ENABLE_LOW, UP_IS_HIGH, BoardConfig, DriverFlag, EnableOff
from .step_drivers import STEP_DRIVERS, check_pulse, step_driver

if TYPE_CHECKING:
    from ..core.chip import Chip
    from .board.boards import BoardModel

START_STOP = 500  # steps/s, for the stop ramp of a board without a table
WATCHDOG_PS = 50 * 10**9  # beyond the horizon, without a message from the host
ENABLE_OFF: Mapping[str, EnableOff] = {"rest": EnableOff.REST, "halt": EnableOff.HALT, "never": EnableOff.NEVER}
USUAL_OFF, USUAL_HOLD = "halt", "60 s"
HOLD_TICKS = 1 << 16
LEAST_HORIZON_PS, MOST_HORIZON_PS = 10 * 10**9, 2 * PS_PER_S
LAMPS = ("fault", "energised")  # signals that the board itself can output


def steps_a_second(rate: str | int) -> int:
    """Return the rate in steps/s, from a text such as "500 steps/s" or from an int.

    Raises:
        UsageError: it is not a rate, or is 0, or the text has a number without its unit.
    """
    text = f"{rate} steps/s" if isinstance(rate, int) and not isinstance(rate, bool) else str(rate)
    found = re.fullmatch(r"\s*(\d{1,7})\s*steps/s\s*", text)
    if found is None or not int(found[1]):
        message = f"rate {rate!r}: {other_kind(rate, 'steps/s')}expected steps per second with their unit"
        raise UsageError(f"{message}, such as '500 steps/s'{without_comma(rate)}")
    return int(found[1])


def exchanged(name: str, wired: str, names: Iterable[str]) -> str:
    """Return a remedy to append to a message if the user has swapped a board pin and a chip pin; else ""."""
    return f"; the pin of the board comes first: {wired}={name}" if str(wired).upper() in names else ""


def time_of(name: str, time: Time) -> int:
    """Return a time in picoseconds.

    Raises:
        TimeError: it is not a time; the message contains `name`.
    """
    try:
        return picoseconds(time)
    except TimeError as error:
        raise TimeError(f"{name}: {error}") from None


def checked_horizon(horizon: Time) -> int:
    """Return a horizon in picoseconds.

    Raises:
        TimeError: it is not a time.
        UsageError: it is out of range.
    """
    ps = time_of("horizon", horizon)
    if not LEAST_HORIZON_PS <= ps <= MOST_HORIZON_PS:
        allowed = f"{readable(LEAST_HORIZON_PS)} to {readable(MOST_HORIZON_PS)}"
        raise UsageError(f"horizon {horizon!r}; allowed {allowed}")
    return ps


def checked_driver(driver: str | None, enable: bool) -> None:
    """Check that the driver has been named if it is to be enabled.

    Raises:
        UsageError: no driver is named.
    """
    if enable and driver is None:
        raise UsageError(
            "enable needs the name of the driver, for the level of its ENABLE: driver='DM542' (--driver); "
            "known: " + ", ".join(STEP_DRIVERS)
        )


def outputs_of(board: BoardModel, chip: Chip, wiring: Mapping[str, str] | None) -> dict[int, str]:
    """Return the signals of a board's outputs, by output number: pins of a chip, "fault" or "energised".

    Args:
        wiring: the signals, keyed by the printed names of outputs, such as {"D2": "uo1"}: pins, "fault" or
            "energised"; None: the pins that programs set.

    Raises:
        UsageError: the board or the chip has no such output; or an output of the board, "fault" or
            "energised" is given twice.
    """
    printed = [pin.printed for pin in board.outputs]
    rows = {row.name: row for row in chip.sheet.pins if row.in_out in ("out", "both")}
    if wiring is None:
        roles = {row.role: row.name for row in rows.values()}
        return {
            number: roles[f"output{number + 1}"] for number in range(len(printed)) if f"output{number + 1}" in roles
        }
    found: dict[int, str] = {}
    for name, pin in wiring.items():
        if name.upper() not in printed:
            raise UsageError(
                f"output {name!r} of the board; allowed {', '.join(printed)}{exchanged(name, pin, printed)}"
            )
        if printed.index(name.upper()) in found:
            raise UsageError(f"output {name} is given twice; leave one out")
        if any(row.name == pin for row in chip.sheet.pins if row.in_out == "in"):
            raise UsageError(
                f"output {name}: {pin} is an input of {chip.name}; set it from an input of the board: "
                f"inputs={{'A1': '{pin}'}} (--input A1={pin})"
            )
        if pin not in rows and pin not in LAMPS:
            allowed = (*rows, *LAMPS)
            raise UsageError(
                f"output {name}: {pin!r} is not an output of {chip.name}; allowed {', '.join(allowed)}"
                f"{hint(pin, allowed)}"
            )
        if pin in LAMPS and pin in found.values():
            other = printed[next(number for number, own in found.items() if own == pin)]
            raise UsageError(f"output {name}: {pin} is assigned to output {other} already; leave one out")
        found[printed.index(name.upper())] = pin
    return found


def pins_of(outputs: Mapping[int, str]) -> dict[int, str]:
    """Return the names of the chip pins that board outputs show, by output number."""
    return {number: name for number, name in outputs.items() if name not in LAMPS}


def direction_polarity(chip: Chip, axis: int, *, invert: bool = False) -> int:
    """Return the polarity flag with which DIR follows the chip's direction pin or, if `invert`, its inverse.

    If the chip has no such pin, DIR is high for clockwise (upward) motion or, if `invert`, low.
    """
    row = next((row for row in chip.sheet.pins if row.plays("direction", axis)), None)
    clockwise = 1 if row is None or row.sense is None else row.sense
    return UP_IS_HIGH if bool(clockwise) != invert else 0


def driver_polarity(board: BoardModel, driver: str | None) -> int:
    """Return the polarity flag of ENABLE: ENABLE_LOW, or 0 if it is active high or `driver` is None.

    Raises:
        UnknownName: there is no such driver.
        UsageError: the pulses of the board are too short for the driver.
    """
    if driver is None:
        return 0
    row = step_driver(driver)
    check_pulse(row, *(ticks * PS_PER_S // board.hz for ticks in (board.high, board.low, board.setup, board.hold)))
    return 0 if row.enabled else ENABLE_LOW


def pattern_of(chip: Chip) -> tuple[int, ...]:
    """Return the phase levels of a chip at each of its eight half-steps, as eight numbers.

    Bit 0 of a number is the level of phase 1.  All numbers are 0 if the chip has no phases.
    """
    whole = [sum(level << n for n, level in enumerate(row)) for row in chip.phase_patterns()]
    if len(whole) in (0, 8):
        return tuple(whole) or (0,) * 8
    return tuple(
        value for one, after in zip(whole, (*whole[1:], whole[0]), strict=True) for value in (one, one | after)
    )


def lamp(outputs: Mapping[int, str], name: str) -> int:
    """Return 1 + the number of the output with the signal `name` ("fault" or "energised"); 0 if there is none."""
    return next((number + 1 for number, shows in outputs.items() if shows == name), 0)


def off_policy(word: str) -> EnableOff:
    """Return the policy by which a board switches the driver off by itself.

    Raises:
        UsageError: the word is not one of "rest", "halt" and "never".
    """
    if word not in ENABLE_OFF:
        raise UsageError(f"enable_off {word!r}; allowed {', '.join(ENABLE_OFF)}")
    return ENABLE_OFF[word]


def hold_of(board: BoardModel, hold: Time) -> int:
    """Return a hold time, `enable_hold`, in the board's units of 65,536 ticks.

    Raises:
        TimeError: it is not a time.
        UsageError: it is negative, or longer than the board can count.
    """
    ps, most = time_of("enable_hold", hold), HOLD_TICKS * 0xFFFF * 10**12 // board.hz
    if not 0 <= ps <= most:
        raise UsageError(f"enable_hold {hold!r}; allowed 0 s to {readable(most // 10**12 * 10**12)}")
    return min(ps * board.hz // (HOLD_TICKS * 10**12), 0xFFFF)


def least_hold(off: EnableOff, horizon: int) -> int:
    """Return the shortest hold, in units of 65,536 ticks, that keeps the driver on until a motion's first step.

    It is 0 unless the policy `off` is to switch the driver off at rest.

    Args:
        horizon: the time from the host's message that begins the motion to the first step, in ticks.
    """
    return horizon // HOLD_TICKS + 2 if off == EnableOff.REST else 0


def usual_config(
    board: BoardModel,
    chip: Chip,
    axis: int,
    outputs: Mapping[int, str],
    horizon_ps: int,
    start_stop: int | None,
    driver: str | None,
    dry: bool,
    off: EnableOff,
    hold: Time,
    *,
    invert_dir: bool,
    filter: int,
) -> BoardConfig:
    """Return the configuration of a board for a chip and a driver, without inputs.

    Args:
        start_stop: the rate from which the motor may stop without a ramp (steps/s); None: the default rate.
        driver: the name of the driver; None: the board does not set ENABLE.
        dry: STEP has no edges.
        off: the policy by which the board switches the driver off by itself, after the time `hold`.
        invert_dir: the level of DIR is opposite to that of the chip's own direction pin.
    """
    return BoardConfig(
        start_stop=board.hz // (start_stop or START_STOP),
        watchdog=(horizon_ps + WATCHDOG_PS) * board.hz // PS_PER_S,
        polarity=direction_polarity(chip, axis, invert=invert_dir) | driver_polarity(board, driver),
        driver=(DriverFlag.DRY if dry else 0) | (0 if driver is None else DriverFlag.ENABLE),
        fault_output=lamp(outputs, "fault"),
        power_output=lamp(outputs, "energised"),
        pattern=pattern_of(chip),
        enable_off=off,
        enable_hold=max(hold_of(board, hold), least_hold(off, horizon_ps * board.hz // PS_PER_S)),
        filter=filter,
    )
