r"""The ramp calculator's queries to a part, and the part's answers.  No time passes, and no chip runs.

    rate                                      forward:  parameters -> time, steps and acceleration of the ramp,
     top .......________                                the moves that reach the rate, and the time of a move
              _/        \_                    back:     a time, a number of steps or an acceleration -> the values of
     start  _/            \_                            the free parameters whose ramp is nearest
            |<->| time, steps

A part provides a `Calculator` (in its `ramps.py`): its parameters (named after the commands that set
them), the `Ramp` of a set of values, and a search for free parameters.  The results of a calculator
always follow from the equations of motion of its part (`profile.py`).
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

from ..core.datasheet.table import Arg, Sheet
from ..core.messages.decimal_comma import without_comma
from ..core.messages.instead import missing
from ..core.messages.near import hint
from ..core.messages.whole import whole
from ..core.motion.train import Train
from ..core.time.timebase import PS_PER_S, readable
from ..errors import UnknownName, UsageError
from .packets import range_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Value = int | str
Values = Mapping[str, Value]
Goal = Literal["time", "acceleration", "steps"]
ANYTHING = (float("-inf"), float("inf"))
_WHOLE = re.compile(r"([+-]?)(?:0[xX]|\$)([0-9a-fA-F]+)|[+-]?\d+")


# ------------------------------------------------------------------------------------------------------------- queries
@dataclass(frozen=True, slots=True)
class RampParameter:
    """A ramp parameter: a number within the range of `arg`, or one of the names in `choices`.

    `default` applies if no value is given.  A search may vary a `free` parameter.  `per_s` is the power of
    seconds in the denominator of its unit: 1 for a rate, 2 for an acceleration.  If `only` is, for
    example, ("profile", "s-curve"), the parameter exists only if the parameter "profile" is "s-curve".

    `measure` is the scale on which ramp trials (slewline tune) space their values evenly: a function that
    maps a value to a number, and increases with the value.  `tried` is a text that states the values tried
    by default.
    """

    name: str
    description: str
    arg: Arg | None = None
    choices: tuple[str, ...] = ()
    default: Value | None = None
    free: bool = False
    per_s: int = 0
    only: tuple[str, str] | None = None
    measure: Callable[[int], float] = float
    tried: str = ""

    @property
    def allowed(self) -> str:
        """The allowed values, as text."""
        if self.arg is None:
            return ", ".join(self.choices)
        return range_of(self.arg)


class Wanted(NamedTuple):
    """The goal of a search: a time in ps, a mean acceleration in steps/s^2, or a number of steps."""

    goal: Goal
    value: float

    def error(self, ramp: Ramp) -> float:
        """Return the absolute difference between a ramp and the goal, in the goal's unit."""
        return abs(self.of(ramp) - self.value)

    def of(self, ramp: Ramp) -> float:
        """Return a ramp's time, acceleration or number of steps, whichever is the goal."""
        return {"time": ramp.time_ps, "acceleration": ramp.acceleration, "steps": ramp.steps}[self.goal]

    def beyond(self, bounds: tuple[float, float]) -> float:
        """Return the distance of the goal from the interval `bounds`, in the goal's unit; 0 if it is inside.

        A ramp whose time, acceleration or number of steps is within `bounds` misses the goal by at
        least this distance.
        """
        return max(bounds[0] - self.value, self.value - bounds[1], 0.0)


# ------------------------------------------------------------------------------------------------------------- answers
class RampSegment(NamedTuple):
    """A ramp segment: steps at one rate or, for a part that works in cycles, one cycle.

    Attributes:
        begin_ps: the start of the segment, counted from the start of the ramp's first step or cycle, ps.
        position: the number of steps in the ramp before the segment.
        steps: the number of steps in the segment.
        rate: the rate, steps/s.
        parameter: the value of the part's rate parameter in this segment; None if the part has none.
    """

    begin_ps: int
    position: float
    steps: float
    rate: float
    parameter: int | None = None


class Accelerations(NamedTuple):
    """The accelerations of a ramp, steps/s^2.

    Attributes:
        first: the acceleration at the start of the ramp.
        mean: the increase in rate divided by the ramp time.
        greatest: the maximum acceleration.
    """

    first: float
    mean: float
    greatest: float


class Move(ABC):
    """A complete move, from rest to rest.

    Attributes:
        steps: the number of steps.
        time_ps: the time from the start of the first step or cycle until the part reports the end of the
            move, ps.
        top: the highest rate, steps/s.
        reached: True if `top` is the top rate of the ramp; False if the move is too short to reach that
            rate.
        legs: the legs in sequence, each as its name ("up", "slew", "down" ...) and its number of steps.
    """

    called = "move"  # in messages
    steps: int
    time_ps: int
    top: float
    reached: bool
    legs: Sequence[tuple[str, float]]

    def __repr__(self) -> str:
        legs = ", ".join(f"{name} {steps}" for name, steps in self.legs)
        return f"<Move of {self.steps} steps: {legs}; up to {self.top:.0f} steps/s, in {readable(self.time_ps)}>"

    @abstractmethod
    def trains(self) -> Sequence[Train]:
        """Return the step trains of the move, in sequence; the first begins at time 0."""

    def times(self) -> NDArray[np.int64]:
        """Return the start times of all steps: (n,) int64 ps, ascending."""
        import numpy as np

        return np.concatenate([train.times(1, train.steps) for train in self.trains()])


class Ramp(ABC):
    """The acceleration ramp of a part with given parameters, from the start rate to the top rate.

    Attributes:
        part: the part number.
        values: the values of all parameters, keyed by name.
        crystal_hz: the frequency of the crystal, Hz.
        start: the rate of the first step, steps/s.
        top: the rate after the ramp, steps/s.
        time_ps: the time from the start of the first step or cycle to the start of the first step or cycle
            at `top`, ps.
        steps: the number of steps in that time; a whole number, unless the part works in cycles.
    """

    called = "ramp"  # in messages
    part: str
    values: Values
    crystal_hz: int
    start: float
    top: float
    time_ps: int
    steps: float

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value!r}" for name, value in self.values.items())
        return f"<Ramp {values}: {self.start:.0f} to {self.top:.0f} steps/s in {readable(self.time_ps)}>"

    @property
    def acceleration(self) -> float:
        """The mean acceleration, steps/s^2: the increase in rate divided by the ramp time; 0 if that time is 0."""
        return (self.top - self.start) * PS_PER_S / self.time_ps if self.time_ps else 0.0

    @property
    @abstractmethod
    def accelerations(self) -> Accelerations:
        """The first, mean and maximum accelerations of the ramp."""

    @property
    @abstractmethod
    def reached_from(self) -> int | None:
        """The number of steps of the shortest move that reaches `top`; None if no move does."""

    @abstractmethod
    def table(self) -> Iterator[RampSegment]:
        """Yield the segments of the ramp, in order of time."""

    def move(self, distance: int) -> Move:
        """Return a move with this ramp.

        Args:
            distance: the number of steps, from the minimum to the maximum in `distances`.

        Raises:
            UsageError: `distance` is not a whole number, or the part cannot make such a move.
        """
        number, (least, most, remark) = whole(distance), self.distances
        if number is None or not least <= number <= most:
            raise UsageError(f"{self.part}: a move of {distance!r} steps; allowed {least}..{most}{remark}")
        return self.made(number)

    @property
    @abstractmethod
    def distances(self) -> tuple[int, int, str]:
        """The minimum and maximum numbers of steps of a move, and a text that names the limiting parameter: " (N)"."""

    @abstractmethod
    def made(self, distance: int) -> Move:
        """Return the move of `distance` steps; the caller has checked that the number is within `distances`."""


for kind in (Ramp, Move):
    missing(
        kind,
        **dict.fromkeys(("time", "duration", "seconds", "length_ps"), "{it}.time_ps"),
        **dict.fromkeys(("accel", "acc"), "{it}.acceleration"),
        **dict.fromkeys(("distance", "count", "length"), "{it}.steps"),
    )
missing(
    Ramp,
    **dict.fromkeys(("speed", "velocity", "rate"), "{it}.start and {it}.top, in steps/s"),
    **dict.fromkeys(("parameters", "params", "registers"), "{it}.values"),
    **dict.fromkeys(("times", "intervals", "profile", "stretches"), "{it}.table(), or {it}.move(1000).times()"),
    **dict.fromkeys(("plot", "figure", "draw"), "slewline ramp PART ... --plot ramp.svg draws it"),
)
missing(
    Move,
    **dict.fromkeys(("speed", "velocity", "rate"), "{it}.top, in steps/s"),
    acceleration="it is the ramp's: slewline.ramp(...).acceleration",
)


class Search(NamedTuple):
    """A search for values of the parameters named in `free`, such that the ramp comes nearest to `wanted`.

    All other parameters keep their values in `fixed`.  The search finds at most `best` ramps.
    """

    wanted: Wanted
    fixed: Values
    free: Sequence[str]
    crystal_hz: int
    best: int = 5


class Candidate(NamedTuple):
    """A value for each free parameter, and bounds for the ramp that results from these values.

    The time, acceleration or number of steps of the ramp, whichever is the goal, is within `bounds`.
    """

    values: dict[str, int]
    bounds: tuple[float, float] = ANYTHING


class Calculator(ABC):
    """The ramp calculator of a part: its parameters and its ramps."""

    sheet: Sheet
    quantities: tuple[RampParameter, ...]
    parameter = ""  # name of `parameter` in a segment of a ramp

    def quantity(self, name: str) -> RampParameter:
        """Return the parameter with the given name; case is ignored.

        Raises:
            UnknownName: there is no such parameter; the message lists the parameters.
        """
        for quantity in self.quantities:
            if quantity.name.lower() == name.lower():
                return quantity
        names = [quantity.name for quantity in self.quantities]
        message = f"{self.sheet.part}: no parameter {name!r}; available: {', '.join(names)}"
        raise UnknownName(message + hint(name, names))

    def level(self, ramp: Ramp) -> str:
        """Return the reason why a ramp has no steps: `top` is not above `start`; "" if the ramp has steps."""
        if ramp.time_ps or ramp.top > ramp.start:
            return ""
        rates = [f"{each.name} {ramp.values[each.name]}" for each in self.quantities if each.per_s]
        return f"the rate is not above the first one ({', '.join(rates)})"

    def without_defaults(self, values: Values) -> dict[str, Value]:
        """Return the values, omitting parameters that are at their defaults and cannot be searched for."""
        defaults = {quantity.name: quantity.default for quantity in self.quantities if not quantity.free}
        return {name: value for name, value in values.items() if value != defaults.get(name)}

    def arg(self, name: str) -> Arg:
        """Return the `Arg` of a numeric parameter, which contains its range.

        Raises:
            UsageError: the parameter is not numeric.
        """
        arg = self.quantity(name).arg
        if arg is None:
            raise UsageError(
                f"{name} is not numeric: its row in the calculator has no `arg`, which gives the range; set `arg`"
            )
        return arg

    @abstractmethod
    def ramp(self, values: Values, crystal_hz: int) -> Ramp:
        """Return the ramp that results from values of all parameters, which must be within their ranges."""

    def fitted(self, values: Values) -> dict[str, Value | bool]:
        """Return the values of parameters that are options of the part and are not at their defaults."""
        options = {option.name for option in self.sheet.options}
        truth: dict[Value, bool] = {"True": True, "False": False}
        return {
            name: truth.get(value, value) for name, value in self.without_defaults(values).items() if name in options
        }

    def script(self, values: Values, steps: int) -> list[str]:
        """Return the commands that a host sends for a move of `steps` steps: the parameters, then the move.

        Raises:
            UsageError: the calculator of the part does not define these commands.
        """
        raise UsageError(
            f"{self.sheet.part}: its calculator has no `script` method, which returns commands for a move; define it"
        )

    @abstractmethod
    def spoken(self, quantity: RampParameter, text: str, crystal_hz: int) -> int | None:
        """Return the value of a parameter that is nearest to a rate given as text with its unit (rates.py).

        Return None if the text is not a rate.

        Raises:
            UsageError: the unit does not belong to this parameter, or the rate is far outside its range.
        """

    @abstractmethod
    def candidates(self, search: Search) -> Iterable[Candidate]:
        """Yield candidates, each with a value for each free parameter; the best ones are among them.

        They come in the order of the distance between their `bounds` and the goal, smallest distance first.

        Raises:
            UsageError: these parameters cannot be searched for together.
        """


# ------------------------------------------------------------------------------------------------------ reading values
def read(calculator: Calculator, given: Values, crystal_hz: int, search: bool) -> tuple[dict[str, Value], list[str]]:
    """Check a user's values; return all values, and the names of the parameters to search for.

    Args:
        given: values by name, in upper or lower case: whole numbers are command arguments; for a rate, text
            such as "4000 steps/s" is also allowed.
        search: search for `free` parameters that are not given; otherwise every parameter needs a value or a
            default.

    Raises:
        UnknownName: there is no such parameter.
        UsageError: a value is out of range, of the wrong kind, or missing.
    """
    part = calculator.sheet.part
    named: dict[str, Value] = {}
    for name, value in given.items():
        quantity = calculator.quantity(name)
        if quantity.name in named:
            raise UsageError(f"{part}: {name} is given twice; give one value")
        named[quantity.name] = value_of(calculator, quantity, value, crystal_hz)
    values: dict[str, Value] = {}
    missing: list[RampParameter] = []
    free: list[str] = []
    for quantity in calculator.quantities:
        if quantity.only is not None and values.get(quantity.only[0]) != quantity.only[1]:
            if quantity.name in named:
                which = " ".join(quantity.only)
                raise UsageError(
                    f"{part}: {quantity.name} applies only to {which}; leave it out, or set {'='.join(quantity.only)}"
                )
        elif quantity.name in named:
            values[quantity.name] = named[quantity.name]
        elif quantity.free and search:
            free.append(quantity.name)
        elif quantity.default is not None:
            values[quantity.name] = quantity.default
        else:
            missing.append(quantity)
    if missing:
        names = ", ".join(f"{quantity.name} ({quantity.description}, {quantity.allowed})" for quantity in missing)
        raise UsageError(f"{part}: no value for {names}")
    return values, free


def value_of(calculator: Calculator, quantity: RampParameter, value: object, crystal_hz: int) -> Value:
    """Return a user's value of a parameter as the part needs it: a number in range, or one of the choices.

    Raises:
        UsageError: the value is out of range or of the wrong kind.
    """
    where = f"{calculator.sheet.part}: {quantity.name} {value!r}"
    if quantity.arg is None:
        for choice in quantity.choices:
            if str(value).lower() == choice.lower():
                return choice
        raise UsageError(f"{where}; allowed {quantity.allowed}")
    comma = without_comma(value)
    if isinstance(value, str):
        value = _number(calculator, quantity, value, crystal_hz)
    number = whole(value)
    if number is None or not quantity.arg.allows(number):
        rates = f", or text such as '4000 {_unit(quantity)}'" if quantity.per_s else ""
        raise UsageError(f"{where}; allowed {quantity.allowed}{rates}{comma}")
    return number


def _number(calculator: Calculator, quantity: RampParameter, text: str, crystal_hz: int) -> int | None:
    """Return the number in a text, or the parameter value for a rate in it; None if the text is neither."""
    if whole := _WHOLE.fullmatch(text.strip()):
        return int(whole[1] + whole[2], 16) if whole[2] else int(text)
    return calculator.spoken(quantity, text, crystal_hz) if quantity.per_s else None


def _unit(quantity: RampParameter) -> str:
    return "steps/s" + ("" if quantity.per_s == 1 else str(quantity.per_s))


# ----------------------------------------------------------------------------------------------------------- searching
def nearest(calculator: Calculator, search: Search) -> list[Ramp]:
    """Return the ramps nearest to the goal, best first.

    Of two ramps equally near to the goal, the one that takes longer comes first.  Of ramps that have the
    same time, acceleration or steps, whichever is the goal, only the one that takes longest is listed.  If
    several of these take equally long, only the ramp whose last free parameter is smallest is listed; if
    these are equal, too, the one whose last parameter but one is smallest, and so on.
    """
    wanted = search.wanted
    best: dict[float, tuple[tuple[float, int, tuple[int, ...]], Ramp]] = {}
    for candidate in calculator.candidates(search):
        if len(best) == search.best and wanted.beyond(candidate.bounds) > max(key[0] for key, _ in best.values()):
            break  # the rest are further off than all ramps found
        ramp = calculator.ramp({**search.fixed, **candidate.values}, search.crystal_hz)
        key = (wanted.error(ramp), -ramp.time_ps, tuple(reversed(candidate.values.values())))
        has = wanted.of(ramp)
        if has not in best or key < best[has][0]:
            best[has] = key, ramp
        if len(best) > search.best:
            del best[max(best, key=lambda each: best[each][0])]
    return [ramp for _, ramp in sorted(best.values(), key=lambda found: found[0])]


def least(enough: Callable[[int], bool], low: int, high: int) -> int | None:
    """Return the smallest number from `low` to `high` for which `enough` is true; None if there is none.

    If `enough` is true for a number, it must be true for all larger numbers, too.
    """
    if not enough(high):
        return None
    while low < high:
        middle = (low + high) // 2
        if enough(middle):
            high = middle
        else:
            low = middle + 1
    return low


def levels(measure: Callable[[int], float], target: float, low: int, high: int, count: int) -> Iterator[int]:
    """Yield values from `low` to `high` around the smallest value whose `measure` is `target` or less.

    The order is: up to `count` values from that value upwards, then up to `count` values below it.
    `measure` must not increase with the value.  Of values with the same measure, only the
    smallest is included.
    """

    def first(most: float) -> int:
        """Return the smallest value whose measure is `most` or less; `high` if there is no such value."""
        value = least(lambda each: measure(each) <= most, low, high)
        return high if value is None else value

    middle = first(max(target, measure(high)))
    value = middle
    for _ in range(count):  # further down
        yield value
        here = measure(value)
        lower = least(lambda each, here=here: measure(each) < here, value, high)  # type: ignore[misc]
        if lower is None:
            break
        value = lower
    value = middle
    for _ in range(count):  # further up
        if value == low:
            break
        value = first(measure(value - 1))
        yield value
