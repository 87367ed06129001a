"""The CY545's ramp calculator, for F, R and S; it uses the rates of the sheet, inferred or set by the user."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import log

from ...core.datasheet.table import Sheet
from ...language.ramp_answers import Calculator, Candidate, RampParameter, Search, Values
from ...language.rates import nearest_rate
from ..cy5xx.ramps import UnitRamp
from . import profile


class Cy545Ramps(Calculator):
    """The ramp calculator of the CY545 and CY545B.

    It uses the sheet's law, except that the value `ramp_jumps` selects whether the rate parameter may
    increase by more than one from one step to the next.
    """

    parameter = "rate"

    def __init__(self, sheet: Sheet) -> None:
        self.sheet, self.law = sheet, profile.law_of(sheet)
        self.periods = self.law.periods
        self.number = sheet.commands["N"].args[0]
        rows = {form: sheet.commands[form] for form in "FRS"}
        tried = {"F": "100 steps/s..800 steps/s/5", "R": "400 steps/s..6000 steps/s/14"}

        def rate(value: int) -> float:
            return -log(self.periods[value])

        self.quantities = (
            *(
                RampParameter(
                    form, rows[form].description, rows[form].args[0], per_s=1, measure=rate, tried=tried[form]
                )
                for form in "FR"
            ),
            RampParameter("S", rows["S"].description, rows["S"].args[0], free=True, tried="1..255/12"),
            RampParameter(
                "ramp_jumps",
                "chip option: several rates per step",
                choices=("False", "True"),
                default=str(self.law.jumps),
            ),
        )

    def ramp(self, values: Values, crystal_hz: int) -> UnitRamp:
        """Return the ramp of a full set of values."""
        first, rate, slope = (int(values[name]) for name in "FRS")
        law = self.law._replace(jumps=values["ramp_jumps"] == "True")
        return UnitRamp(
            self.sheet.part,
            values,
            crystal_hz,
            self.periods,
            profile.ramp(first, rate, slope, law),
            self.number,
            lambda number: profile.move(number, first, rate, slope, law),
        )

    def script(self, values: Values, steps: int) -> list[str]:
        """Return the commands that a host sends for a clockwise move of `steps` steps with the given values."""
        return ["+", *(f"{form} {values[form]}" for form in "FRS"), f"N {steps}", "G"]

    def spoken(self, quantity: RampParameter, text: str, crystal_hz: int) -> int | None:
        """Return the rate parameter nearest to a rate in steps/s; None if the text is not a rate."""
        where, top = f"{self.sheet.part}: {quantity.name}", len(self.periods) - 1
        return nearest_rate(where, text, lambda each: Fraction(crystal_hz, self.periods[each]), 0, top)

    def candidates(self, search: Search) -> Iterator[Candidate]:
        """Yield a candidate for every S or, if S is fixed, only one; they are few, and each is cheap to compute."""
        arg = self.arg("S")
        for slope in range(arg.low, arg.high + 1) if "S" in search.free else (None,):
            yield Candidate({} if slope is None else {"S": slope})


ramps = Cy545Ramps  # calculators by sheet
