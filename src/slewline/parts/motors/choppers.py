"""Effects of a chopper on the motor current: ripple, current due to blanking, and notes to users on both."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

from .drivers import has_own_clock
from .motor_data import DriverData, MotorData

_AMPERES = re.compile(r"\d\s*m?A\b")
UNDER = 0.2  # times the rated current: less is hardly intended, and yields a fifth of the torque
OVER = 1.1  # times the rated current: tolerance of a supply or a resistor
MUCH = 0.1  # fraction of the current: a ripple that costs a twentieth of the torque


def ripple(motor: MotorData, driver: DriverData) -> float:
    """Return the maximum current ripple in slow decay, peak to peak, A.

    It occurs when the mean voltage of the winding is half the supply voltage.  The EMF of a
    turning motor reduces the ripple.  For an averaged driver, which models only the mean current, the result
    is the ripple of a chopper with the same clock.
    """
    share = 2 if driver.off_time else 4  # the off-time is the fixed time, or half a period
    return driver.supply * driver.period / (share * motor.inductance)


def least_current(motor: MotorData, driver: DriverData) -> float:
    """Return the current, A, that blanking time alone drives through a winding at rest in slow decay.

    Return 0 if the driver is not a chopper with slow or auto decay and a blanking time.
    """
    if driver.kind != "chopper" or driver.decay not in ("slow", "auto") or not driver.least_on:
        return 0.0
    period = driver.off_time + driver.least_on if driver.off_time else driver.period
    return driver.supply * driver.least_on / period / motor.resistance


def current_note(motor: MotorData, driver: DriverData, *, little: bool = False) -> str:
    """Return a note if a motor at rest gets more, or much less, than its rated current; else an empty text.

    Args:
        little: whether to report only a much lower current, with which the motor holds almost no load.
    """
    current = driver.current
    if driver.kind in ("voltage", "bilevel"):
        current = driver.supply / (motor.resistance + driver.series)
    message = f"{current:.3g} A per phase, but {motor.name} is rated {motor.current:.3g} A"
    if current > OVER * motor.current and not little:
        return f"{message}: it gets hot, and its iron may saturate, so that the torque is less than calculated"
    if current < UNDER * motor.current:
        return f"{message}: it has {current / motor.current:.1%} of its torque; check the figures of the driver"
    return ""


def chopper_notes(motor: MotorData, driver: DriverData, given: Any) -> tuple[str, ...]:
    """Return notes on a driver's current and on its chopper (switching or averaged); () if there are none.

    Args:
        given: the driver as set by the user; if it has neither a chopper clock nor a known name, 20 kHz
            is assumed.
    """
    notes = [note for note in (current_note(motor, driver),) if note]
    if driver.kind not in ("chopper", "averaged"):
        return tuple(notes)
    if driver.current == motor.current and isinstance(given, str) and not _AMPERES.search(given):
        notes.append(f"{given!r} has no current: {motor.current:g} A is assumed, the rated current of {motor.name}")
    swing = ripple(motor, driver)
    if swing > MUCH * driver.current:
        at = f"a pause of {driver.off_time * 1e6:g} us" if driver.off_time else f"{driver.frequency / 1e3:g} kHz"
        lost = f"{min(swing / driver.current / 2, 1):.0%}"
        message = (
            f"chopper at {at}: the current ripples by up to {swing:.2g} A of {driver.current:.3g} A at high rates, "
        )
        message += f"which costs up to {lost} of the torque"
        if not has_own_clock(given, motor):
            message += "; the frequency is assumed: name the driver, such as DRV8825, or set its frequency, "
            message += "such as 36 kHz"
        notes.append(message)
    least = least_current(motor, replace(driver, kind="chopper"))
    if least > driver.current:
        notes.append(
            f"blanking of {driver.least_on * 1e6:g} us: it alone drives {least:.3g} A through a winding of "
            f"{motor.resistance:g} ohm at rest, so the driver cannot hold {driver.current:.3g} A; use a lower supply, "
            "a winding with more resistance, or mixed decay"
        )
    return tuple(notes)
