"""How to choose S and T: the rules of the data sheet (start-stop speed, slew speed).  R is found by trial.

The sheet balances the power of the load with that of the motor, F L / (6000 t) = T N / 10, in pounds, inches, seconds,
ounce-inches and turns a minute.  One horsepower is 6600 pound-inches a second, or 1,008,000 ounce-inches times turns a
minute, so the 10 has lost its exponent: it is ten to the sixth.
"""

from __future__ import annotations

from slewline.errors import UsageError

LEFT, RIGHT = 6000, 10**6
MARGIN = 0.5  # of the highest rate at which the motor starts
UNIT = 10  # steps/s of S and T
MOST = 1000


def start_stop(pull_in: float) -> int:
    """S for a motor that starts at up to `pull_in` steps/s: half of it, in units of 10 steps/s."""
    return _in_units(MARGIN * pull_in, f"pull-in rate {pull_in:g} steps/s")


def turns_a_minute(force: float, length: float, seconds: float, torque: float) -> float:
    """The speed at which a motor of a torque moves a load.

    Args:
        force: pounds.
        length: of the way, inches.
        seconds: that it may take.
        torque: ounce-inches.
    """
    return RIGHT * force * length / (LEFT * seconds * torque)


def top_speed(force: float, length: float, seconds: float, torque: float, steps_a_turn: int = 200) -> int:
    """T for the same, in units of 10 steps/s."""
    rate = turns_a_minute(force, length, seconds, torque) * steps_a_turn / 60
    return _in_units(rate, f"{rate:g} steps/s")


def _in_units(rate: float, what: str) -> int:
    """A rate in units of 10 steps/s, rounded down: never faster than asked."""
    units = int(rate // UNIT)
    if not 1 <= units <= MOST:
        raise UsageError(f"{what}: makes {units} units of 10 steps/s; allowed 1..{MOST}")
    return units
