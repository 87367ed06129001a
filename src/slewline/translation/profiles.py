"""Motion profiles calculated from a part's parameters, and the parameters nearest to a motion profile.

read    values of the part's parameters -> start rate, top rate, ramp, by the part's calculator
fit     a profile -> the parameter values whose motions come nearest, by the inverse calculator
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from ..chips import ramps_of, sheet_of
from ..core.datasheet.table import Row, Sheet
from ..core.time.timebase import PS_PER_S
from ..errors import UsageError
from ..language.ramp_answers import Calculator, Ramp, RampParameter, Search, Value, Wanted, nearest, read
from .meaning import Profile
from .rows_of_roles import PROFILE_ROLES, rows_by_role

ODD_RATE = 1000  # steps/s: an unreachable rate above this is too high for the part, one below it too low


@dataclass(frozen=True, slots=True)
class Fitted:
    """Parameter values of the target, keyed by command form, and the profile that they produce.

    Of all values that the target allows, these come nearest to a wanted profile.
    """

    values: Mapping[str, int]
    profile: Profile


class Profiles:
    """The motion profiles that a part with a given crystal can make."""

    def __init__(self, sheet: Sheet, crystal_hz: int, calculator: Calculator | None = None) -> None:
        self.sheet, self.hz = sheet, crystal_hz
        self.calculator = calculator or ramps_of(sheet.part)
        rows = rows_by_role(sheet)
        self.rows: dict[str, Row] = {role: rows[role] for role in PROFILE_ROLES if role in rows}
        self.names = {each.name for each in self.calculator.quantities}
        self.values_of = self.names | {row.form for row in self.rows.values()}
        self._moves = lru_cache(maxsize=4096)(self._move)
        self._read = lru_cache(maxsize=4096)(self._profile)
        self._fitted: dict[tuple[float, float, int], Fitted] = {}

    # ------------------------------------------------------------------------------------------------------- reading
    def read(self, values: Mapping[str, Value]) -> Profile | None:
        """Return the profile that parameter values define, or None if they are incomplete or not allowed."""
        return self._read(frozenset(values.items()))

    def _profile(self, items: frozenset[tuple[str, Value]]) -> Profile | None:
        values = dict(items)
        top, ramp = self.rows["top_rate"].form, self.rows["ramp"].form
        if top not in values:
            return None
        if not values.get(ramp, 0) and "rate_divisor" in self.rows:  # every step at R, divided by the factor
            steepest = self.rows["ramp"].args[0].high
            rate = self._ramp({top: values[top], ramp: steepest}).top / int(
                values.get(self.rows["rate_divisor"].form, 1)
            )
            return Profile(rate, rate, values=values)
        try:
            found = self._ramp(values)
        except UsageError:
            return None
        return self.profile_of(found, values)

    def _ramp(self, values: Mapping[str, Value]) -> Ramp:
        known = {name: value for name, value in values.items() if name in self.names}
        return self.calculator.ramp(read(self.calculator, known, self.hz, search=False)[0], self.hz)

    @staticmethod
    def profile_of(ramp: Ramp, values: Mapping[str, Value]) -> Profile:
        """Convert a ramp to a profile that includes the parameter values that define it."""
        if not ramp.time_ps:
            return Profile(ramp.top, ramp.top, values=dict(values))
        return Profile(ramp.start, ramp.top, ramp.time_ps, ramp.steps, dict(values))

    def move_ps(self, profile: Profile, steps: int) -> int | None:
        """Return the time (ps) from the first step of a move to its last, or None if it is not known.

        The time ends at the last step because some parts report the end of a move before the last step interval,
        and others after it.
        """
        return self._moves(frozenset(profile.values.items()), 0.0 if profile.ramped else profile.top, abs(steps))

    def _move(self, items: frozenset[tuple[str, Value]], constant: float, steps: int) -> int | None:
        if steps < 2:
            return 0
        if constant and "rate_divisor" in self.rows:
            return round((steps - 1) * PS_PER_S / constant)
        try:
            times = self._ramp(dict(items)).move(steps).times()
        except UsageError:
            return None
        return int(times[-1] - times[0])

    # ------------------------------------------------------------------------------------------------------- fitting
    def fit(self, wanted: Profile) -> Fitted:
        """Return the values whose profile is nearest to `wanted`: first the rates are fitted, then the ramp time."""
        key = wanted.start, wanted.top, wanted.time_ps
        if key not in self._fitted:
            self._fitted[key] = self._fit(wanted)
        return self._fitted[key]

    def _fit(self, wanted: Profile) -> Fitted:
        if own := self._own(wanted):
            return own
        values: dict[str, Value] = {}
        flat = not wanted.ramped
        for role, rate in (("start_rate", wanted.start), ("top_rate", wanted.top)):
            if role in self.rows:
                values[self.rows[role].form] = self._nearest_rate(role, rate)
        if flat:
            return self._constant(wanted, values)
        fixed, free = read(self.calculator, values, self.hz, search=True)
        goal = Wanted("time", float(wanted.time_ps))
        found = nearest(self.calculator, Search(goal, fixed, free, self.hz, 1))
        best = found[0]
        chosen = {name: int(value) for name, value in best.values.items() if self._written(name)}
        return Fitted(dict(chosen), self.profile_of(best, best.values))

    def ends(self, role: str) -> tuple[float, float]:
        """Return the lowest and the highest rate that the command with the given role can set, steps/s."""
        row, ramp, top = self.rows[role], self.rows["ramp"], self.rows["top_rate"]
        first = self.rows.get("start_rate")
        found = []
        for value in (row.args[0].low, row.args[0].high):
            values = {top.form: value, ramp.form: ramp.args[0].high}
            if first is not None:
                values[first.form] = value if row is first else first.args[0].low
            profile = self.read({**{each.form: 1 for each in self.rows.values()}, **values})
            found.append(0.0 if profile is None else profile.top)
        return min(found), max(found)

    def _own(self, wanted: Profile) -> Fitted | None:
        """Return the source's own values if they produce exactly the wanted profile on the target, else None."""
        mine = {name: int(value) for name, value in wanted.values.items() if self._written(name) and is_number(value)}
        if mine.keys() != {name for name, value in wanted.values.items() if name.isupper()}:
            return None
        try:
            if not all(self.sheet.commands.by_form[name].args[0].allows(value) for name, value in mine.items()):
                return None
            found = self.read(mine)
        except (UsageError, KeyError):
            return None
        same = found is not None and (found.start, found.top, found.time_ps) == (
            wanted.start,
            wanted.top,
            wanted.time_ps,
        )
        return Fitted(mine, found) if same and found is not None else None

    def _constant(self, wanted: Profile, values: dict[str, Value]) -> Fitted:
        """Return the values for motions at the wanted constant rate, without ramps."""
        top = self.rows["top_rate"].form
        if "rate_divisor" in self.rows:  # rate and factor, without a slope
            factor, rate = self._divided(wanted.top)
            ramp = self.rows["ramp"]
            chosen = {top: rate, self.rows["rate_divisor"].form: factor}
            if ramp.args[0].allows(0):
                chosen[ramp.form] = 0
            found = self.read({**chosen, ramp.form: 0})
            assert found is not None  # noqa: S101  # both are within their ranges
            return Fitted(chosen, found)
        chosen = {name: int(value) for name, value in values.items()}
        gentle = {
            each.form: each.args[0].high if role == "ramp" else each.args[0].low
            for role, each in self.rows.items()
            if each.form not in chosen
        }
        found = self.read({**chosen, **gentle})
        unset = {register.letter for register in self.sheet.registers if not register.default}
        chosen |= {
            form: value for form, value in gentle.items() if form in unset
        }  # the part moves only if all of them are set
        return Fitted(dict(chosen), found or Profile(wanted.top, wanted.top, values=chosen))

    def _divided(self, rate: float) -> tuple[int, int]:
        """Return the divisor and rate parameter nearest to `rate`; of equally near pairs, the lowest divisor wins."""
        row, factor = self.rows["top_rate"].args[0], self.rows["rate_divisor"].args[0]
        steepest = self.rows["ramp"].args[0].high
        form, slope = self.rows["top_rate"].form, self.rows["ramp"].form
        tops = {each: self._ramp({form: each, slope: steepest}).top for each in range(row.low, row.high + 1)}
        pairs = (
            (abs(tops[value] / by - rate), by, value)
            for value in tops
            for by in {max(factor.low, min(factor.high, round(tops[value] / rate) or 1)), 1}
        )
        _, by, value = min(pairs)
        return by, value

    def _nearest_rate(self, role: str, rate: float) -> int:
        """Return the parameter value whose rate is nearest to `rate`; if out of range, the nearer limit."""
        row = self.rows[role]
        quantity: RampParameter = self.calculator.quantity(row.form)
        arg = self.calculator.arg(row.form)
        if rate <= 0:
            return arg.low
        try:
            found = self.calculator.spoken(quantity, f"{rate:.6f} steps/s", self.hz)
        except UsageError:
            found = arg.high if rate > ODD_RATE else arg.low
        return min(max(int(found or 0), arg.low), arg.high)

    def _written(self, name: str) -> bool:
        """Return whether the parameter `name` is set by a command of the part."""
        return name in self.values_of and name in self.sheet.commands.by_form


@lru_cache(maxsize=32)
def profiles_of(part: str, hz: int) -> Profiles | None:
    """Return the motion profiles of a part with a given crystal, or None if the part has no ramp calculator."""
    try:
        return Profiles(sheet_of(part), hz)
    except UsageError:
        return None


def is_number(value: Value) -> bool:
    """Return whether a parameter value is a number rather than a name."""
    return isinstance(value, int)
