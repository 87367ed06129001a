"""Rates in common units, and in the registers of a chip that counts in cycles.

For a register with `fraction` binary places and the unit steps/cycle^n, where n is `cycles`:

    register = rate * 2^fraction / (cycles per second)^cycles

For example, 12,345 steps/s are 4.04521 steps/cycle, or 265107 in the register, since a second has
25 MHz / 8192 = 3051.7578125 cycles.  The worked examples of a manual may assume a round number of cycles
per second, 3030 (330 µs per cycle), and truncate steps per cycle to six digits before scaling:
4.07425 steps/cycle, or 267010.  `manual` computes register values in this way; with them, the motor runs
0.72 % too fast.

Scripts and hosts may write a rate with its unit, which `spoken` reads: 12345 steps/s, 0.5 steps/cycle2,
8e5 steps/s^3.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from decimal import ROUND_DOWN, Context, Decimal
from fractions import Fraction
from math import floor

from ..core.datasheet.table import Arg, Sheet
from ..core.datasheet.units import in_steps
from ..errors import UsageError

_SPOKEN = re.compile(
    r"([+-]?(?:[0-9]{1,20}(?:\.[0-9]{0,20})?|\.[0-9]{1,20})(?:[eE][+-]?[0-9]{1,2})?)\s*steps/(s|cycle)(?:\^?([23]))?"
)
_SIX_DIGITS = Context(prec=6, rounding=ROUND_DOWN)

Rate = int | float | Fraction | Decimal


def cycles_per_s(sheet: Sheet, crystal_hz: int | None = None) -> Fraction:
    """Return the exact number of cycles per second at `crystal_hz`, or by default at the sheet's frequency."""
    return Fraction(crystal_hz or sheet.crystal_hz, sheet.times["cycle"].ticks)


def register(arg: Arg, rate: Rate, per_s: Fraction) -> int:
    """Return the register value nearest to a rate, in steps/s, steps/s^2 or steps/s^3 as the register requires.

    Raises:
        UsageError: the rate is beyond the register's range, or is not a number.
    """
    return _within_range(arg, _number(rate) / per_s**arg.cycles, rate)


def spoken(arg: Arg, text: str, per_s: Fraction) -> int | None:
    """Return the register value nearest to a rate given as text, or None if the text is not a rate.

    A rate halfway between two register values is rounded up.

    Args:
        text: a decimal number followed by steps/s or steps/cycle, with the unit of time to the right
            power for an acceleration or a jerk: steps/s2 or steps/s^2, steps/cycle3.
        per_s: cycles per second.

    Raises:
        UsageError: the unit belongs to another register, or the rate is beyond this register's range.
    """
    match = _SPOKEN.fullmatch(text.strip())
    if match is None:
        _refuse_turns(text)
        return None
    number, time, power = match.groups()
    if int(power or 1) != arg.cycles:
        raise UsageError(f"{arg.name} {text.strip()}: allowed {units(arg)}")
    return _within_range(arg, Fraction(number) / (per_s**arg.cycles if time == "s" else 1), text.strip())


def steps_per_s(text: str) -> Fraction | None:
    """Return the exact rate, in steps/s, of a text such as "4000 steps/s"; None if the text is not such a rate.

    Raises:
        UsageError: the rate is in revolutions, which requires the motor's steps per revolution.
    """
    match = _SPOKEN.fullmatch(text.strip())
    if match is None:
        _refuse_turns(text)
    return Fraction(match[1]) if match and (match[2], match[3]) == ("s", None) else None


def nearest_rate(
    where: str, text: str, rates: Callable[[int], Fraction], low: int, high: int, source: str = ""
) -> int | None:
    """Return the parameter value nearest to a rate such as "500 steps/s"; None if the text is not a rate.

    Args:
        where: part and parameter, for messages.
        rates: returns the rate, steps/s, of a parameter value from `low` to `high`; it increases with the
            value.
        source: where the manual lists the rates, for messages.

    Raises:
        UsageError: the rate is less than half the lowest rate, or more than twice the highest.
    """
    rate = steps_per_s(text)
    if rate is None:
        return None
    slowest, fastest = rates(low), rates(high)
    if not slowest / 2 <= rate <= fastest * 2:
        allowed = f"{float(slowest):.0f}..{float(fastest):.0f} steps/s{source}"
        raise UsageError(f"{where} {text.strip()}; allowed {allowed}")
    return min(range(low, high + 1), key=lambda each: abs(rates(each) - rate))


def _refuse_turns(text: str) -> None:
    if in_steps(text.strip(), 1) != text.strip():
        raise UsageError(
            f"rate {text.strip()!r}: the motor's steps per revolution are not known here; convert the rate to steps/s: "
            "multiply rev/s by the steps per revolution, or rpm by the steps per revolution / 60"
        )


def units(arg: Arg) -> str:
    """Return the units in which a rate for a register may be written: "steps/s2 or steps/cycle2"."""
    power = str(arg.cycles) if arg.cycles > 1 else ""
    return f"steps/s{power} or steps/cycle{power}"


def manual(arg: Arg, rate: Rate, round_per_s: int) -> int:
    """Return the register value of a rate, computed as in the manual's examples.

    They use a round number of cycles per second, and cut the steps per cycle to six digits.
    """
    exact = _number(rate)
    cut = _SIX_DIGITS.divide(Decimal(exact.numerator), Decimal(exact.denominator) * round_per_s**arg.cycles)
    return _within_range(arg, Fraction(cut), rate)


def per_second(arg: Arg, value: int, per_s: Fraction) -> Fraction:
    """Return the exact rate of a register value, in steps per second (to the power of `arg.cycles`)."""
    return Fraction(value, 1 << arg.fraction) * per_s**arg.cycles


def step_ratio(arg: Arg, counts: int, steps: int) -> int:
    """Return the encoder counts per step, in the format of the register for stall detection.

    Args:
        counts: the encoder counts per motor revolution.
        steps: the steps per motor revolution.

    Raises:
        UsageError: `counts` or `steps` is below 1; their ratio is not a whole number in the register's unit,
            so that the position error would drift; or the ratio is out of the register's range.
    """
    if counts < 1 or steps < 1:
        raise UsageError(f"{counts} counts and {steps} steps per revolution; allowed 1 or more of each")
    exact = Fraction(counts << arg.fraction, steps)
    if exact.denominator != 1:
        shown = f"{float(exact):.6g}"
        raise UsageError(
            f"{counts} counts for {steps} steps: {1 << arg.fraction} * counts / steps is {shown}; allowed whole "
            "numbers only, because otherwise the position drifts"
        )
    return _within_range(arg, Fraction(counts, steps), f"{counts}/{steps}")


def _number(rate: Rate) -> Fraction:
    if isinstance(rate, bool) or not isinstance(rate, int | float | Fraction | Decimal):
        raise UsageError(f"{rate!r} is not a rate; expected a finite number")
    try:
        return Fraction(rate)
    except (ValueError, OverflowError):
        raise UsageError(f"{rate!r} is not a rate; expected a finite number") from None


def _within_range(arg: Arg, exact: Fraction, shown: object) -> int:
    """Return the register value nearest to a number in the register's unit; half a register unit is rounded up.

    Raises:
        UsageError: the value is out of the register's range.
    """
    value = floor(exact * (1 << arg.fraction) + Fraction(1, 2))
    if not arg.allows(value):
        # ten digits: eight would round the highest velocity and the highest jerk up to refused values
        allowed = f"{arg.low / (1 << arg.fraction):.10g}..{arg.high / (1 << arg.fraction):.10g}"
        raise UsageError(f"{arg.name} {shown}: {float(exact):.10g} {arg.unit}; allowed {allowed}")
    return value
