"""The ramp calculator from Python: the ramp for given parameters, and the parameters for a required ramp.

ramp = slewline.ramp("cy525", F=3, R=127, S=200, Z=1)
ramp.time_ps, ramp.steps, ramp.move(5000).time_ps
slewline.find_ramps("cy525", time="0.5 s", F=3, R="6000 steps/s")[0].values
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..chips import ramps_of
from ..core.messages.calls import answering
from ..core.messages.whole import whole
from ..core.time.timebase import Time, picoseconds
from ..errors import UsageError
from ..language.ramp_answers import Goal, Ramp, Search, Value, Wanted, nearest, read
from .circuit import crystal_for


@answering("ramp()")
def ramp(
    part: str, *, crystal: str | int | None = None, options: Mapping[str, Any] | None = None, **values: Value
) -> Ramp:
    """Return the ramp of a part with these parameters.

    Args:
        part: the part number, "cy525", "gs-c200" ...
        crystal: such as "11 MHz"; by default the usual crystal of the part.
        options: options of the part, as for `bench.add`, such as a custom rate table.
        values: parameters by name: F, R, S, Z (CY525); F, R, S (CY545); S, T, R, law (GS-C); SET_VEL, SET_ACC ...
            (MC1451A family).  A whole number is the argument of the command; a string may be a rate, such as "4000
            steps/s".

    Raises:
        UnknownName: there is no such part or parameter.
        UsageError: a value is missing or out of range.
    """
    calculator = ramps_of(part, options)
    hz = calculator.sheet.crystal_hz if crystal is None else crystal_for(calculator.sheet, crystal)
    return calculator.ramp(read(calculator, values, hz, search=False)[0], hz)


@answering("find_ramps()")
def find_ramps(
    part: str,
    *,
    time: Time | None = None,
    acceleration: float | None = None,
    steps: float | None = None,
    crystal: str | int | None = None,
    count: int = 5,
    options: Mapping[str, Any] | None = None,
    **values: Value,
) -> list[Ramp]:
    """Search all values of the free parameters for the ramps nearest to a goal; return them, the nearest first.

    Free parameters are S and Z of the CY525, R of the GS-C modules, and one of SET_ACC, SET_MAX_ACC and
    SET_JERK of the MC1451A family, unless a value is given.  Of two ramps that are equally near, the slower
    one comes first.  Of several ramps with the same value of the goal (the same time, for example), only the
    slowest is returned.  If several of these are equally slow, the one with the lowest Z is returned; if Z is
    equal too, or the part has no Z, the one with the lowest S, R, acceleration or jerk.

    Args:
        part, crystal, options, values: as for `ramp`.
        time, acceleration, steps: the goal, exactly one of the three: the duration of the ramp, such as
            "0.5 s" or a number of ps; its mean acceleration, steps/s^2; or its number of steps.
        count: the number of ramps to return, 1 or more.

    Raises:
        UnknownName: there is no such part or parameter.
        UsageError: no goal or more than one, no free parameter, or a value that is missing or out of range.
    """
    calculator = ramps_of(part, options)
    hz = calculator.sheet.crystal_hz if crystal is None else crystal_for(calculator.sheet, crystal)
    wanted = _wanted(
        {"time": None if time is None else picoseconds(time), "acceleration": acceleration, "steps": steps}
    )
    best = whole(count)
    if best is None or best < 1:
        raise UsageError(f"count {count!r}; allowed 1 or more")
    fixed, free = read(calculator, values, hz, search=True)
    if not free:
        names = " or ".join(quantity.name for quantity in calculator.quantities if quantity.free)
        raise UsageError(f"{calculator.sheet.part}: every parameter is given; leave out {names} to search for it")
    return nearest(calculator, Search(wanted, fixed, free, hz, best))


def _wanted(goals: dict[Goal, float | None]) -> Wanted:
    """Return the goal that is given; exactly one must be given."""
    given = [(goal, value) for goal, value in goals.items() if value is not None]
    if len(given) != 1:
        raise UsageError("the ramp needs exactly one goal: time, acceleration or steps")
    goal, value = given[0]
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < float("inf"):
        raise UsageError(f"{goal} {value!r}; allowed more than 0")
    return Wanted(goal, value)
