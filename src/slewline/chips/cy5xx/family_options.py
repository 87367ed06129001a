"""Options common to the family's sheets, generated from the sheets' registers, times and step periods."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from ...core.datasheet.option import Option
from ...core.datasheet.table import Register, Timing


def at_power_up(registers: Sequence[Register]) -> tuple[Option, ...]:
    """Return one option per register, to set the register's value at power-up."""
    template = "at power-up: {}; random in the part"
    return tuple(
        Option(
            row.name,
            "int",
            row.default,
            template.format(row.description),
            low=0,
            high=(1 << row.bits) - 1,
            where=row.where,
        )
        for row in registers
    )


def clocks(times: Mapping[str, Timing]) -> tuple[Option, ...]:
    """Return one option per inferred time, to replace that time."""
    return tuple(
        Option(
            name, "int", time.ticks, f"inferred: {time.description}", low=1, high=10**6, unit="clocks", where=time.where
        )
        for name, time in times.items()
    )


def slopes(periods: Sequence[int], least: int, phases: Sequence[int], where: str) -> tuple[Option, ...]:
    """Return the options that replace the step periods, the start of ramps and the half steps (slope.py).

    Args:
        periods: the duration of a step in clocks, for each rate parameter from 0 upwards.
        least: the duration of the shortest allowed step, in clocks.
        phases: the phase pattern of each half step, with phase 1 in the high bit.
    """
    top = len(periods) - 1
    law = f"inferred: clocks per step by rate parameter, 0 to {top}; none: from {periods[0]} to {periods[top]}"
    start = "inferred: the rate parameter at which ramps begin and end"
    half = "inferred: the phases in half steps, phase 1 in the high bit, 0 energises; full steps use every second one"
    whole = _many(0, top + 1)
    return (
        Option("periods", "ints", (), law, low=least, high=1 << 24, check=whole, unit="clocks", where=where),
        Option("ramp_start", "int", 1, start, low=0, high=top, where=where),
        Option("phases", "ints", tuple(phases), half, low=0, high=15, check=_many(len(phases)), where=where),
    )


def _many(*counts: int) -> Callable[[Sequence[int]], str]:
    """Return a check of a list: a function that returns an error text if the length is not in `counts`, else ""."""
    allowed = " or ".join(str(count) if count else "none" for count in counts)
    return lambda given: "" if len(given) in counts else f"{len(given)} numbers; allowed {allowed}"
