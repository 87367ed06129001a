"""The sampling of a recording: its period determines the uncertainty of the times; their unit seldom does.

    $comment Acquisition with 2/2 channels at 12 MHz $end       the period is 83.3 ns
    $timescale 100 ps $end                                      the unit is finer

The sampling rate is stated in the file, or follows from the instants of changes, which are all whole
periods apart.  A few instants fit many grids by chance, so a grid counts only if chance can be excluded;
of all the grids that count, the coarsest is used.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

from ...core.time.timebase import PS_PER_S, readable

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

# Of analysers and oscilloscopes: rates whose period is not a whole number of the usual units in files.
MANTISSAS = ("1", "1.2", "1.25", "1.5", "1.6", "2", "2.4", "2.5", "3", "3.2", "4", "4.8", "5", "6", "6.25", "6.4",
             "7.5", "8", "9.6")  # fmt: skip
RATES_HZ = sorted(Fraction(digits) * 10**power for digits in MANTISSAS for power in range(3, 10))
FEW = 64  # intervals on which every grid is tried; only grids that fit these are tried on all
CHANCE = 1e-6  # the greatest probability that a grid is chance
LENGTHS = 6  # minimum number of different intervals: a steady wave fits the grid of its own period
FINE = 4  # minimum number of units in a period that is not a whole number of them
LONG = 200  # characters of a comment that are searched for a rate
SIZES = {"": 1, "k": 10**3, "m": 10**6, "g": 10**9}

_RATE = re.compile(r"(?:\bat|sample\s*rate\s*:?)\s*(\d{1,12}(?:\.\d{1,9})?)\s*([kmg]?)(?:hz|sa/s)?\s*$", re.IGNORECASE)


class Sampling(NamedTuple):
    """The sampling of a file.

    Attributes:
        period: the time between two samples, ps.
        unit: the unit of the times in the file, to which they are rounded, ps.
        found: the origin of the period: "comment" (stated in the file), "grid" (on which all times lie) or
            "unit" (the unit of the times).
    """

    period: Fraction
    unit: Fraction
    found: str

    @property
    def resolution_ps(self) -> int:
        """The longest possible delay of a recorded edge, ps: a period, plus any rounding to whole units."""
        whole = self.period % self.unit == 0
        return max(-(-(self.period if whole else self.period + self.unit) // 1), 1)

    def __str__(self) -> str:
        if self.found == "unit":
            return f"the unit of its times, {readable(max(int(self.unit), 1))}"
        return f"the sampling at {frequency(PS_PER_S / self.period)}"


def frequency(hz: Fraction) -> str:
    """Return a frequency as text, such as "12 MHz"."""
    size, name = next(((size, name) for name, size in reversed(SIZES.items()) if hz >= size), (1, ""))
    return f"{float(round(hz / size, 4)):g} {name.upper() if name != 'k' else name}Hz"


def rate_in(text: str) -> Fraction | None:
    """Return the sampling rate (Hz) in a comment such as "Acquisition with 2/2 channels at 12 MHz", or None."""
    match = _RATE.search(" ".join(text[-LONG:].split()))
    hz = Fraction(match[1]) * SIZES[match[2].lower()] if match else Fraction(0)
    return hz if 0 < hz <= PS_PER_S else None


def sampling_of(
    instants: Callable[[], NDArray[np.int64]], unit: Fraction, rate: Fraction | None, exact: bool
) -> Sampling:
    """Return the sampling of a file.

    Args:
        instants: a function that returns the instants of all changes, ps, ascending; called only if `rate`
            and `exact` do not determine the sampling.
        unit: the unit in which the instants were written, ps.
        rate: the sampling rate stated in the file, Hz.  If its period is no longer than `unit`, the rate may
            stem from a conversion of the file: a grid found in the instants then takes precedence.
        exact: True if the instants were not sampled, but computed and rounded to `unit`.
    """
    if exact:
        return Sampling(unit, unit, "unit")
    if rate is not None and PS_PER_S / rate > unit:
        return Sampling(PS_PER_S / rate, unit, "comment")
    found = _grid(instants(), unit)
    if found is not None and found > unit:
        return Sampling(found, unit, "grid")
    return Sampling(unit, unit, "unit" if rate is None or PS_PER_S / rate < unit else "comment")


def _grid(times_ps: NDArray[np.int64], unit: Fraction) -> Fraction | None:
    """Return the period (ps) of the coarsest grid that the times fit other than by chance, or None."""
    import numpy as np

    since = times_ps - times_ps[:1]
    some = np.diff(since[: FEW + 1])
    lengths = np.unique(some // max(int(unit), 1))
    if len(lengths) < LENGTHS:
        return None
    tried = [PS_PER_S / rate for rate in RATES_HZ if PS_PER_S / rate >= FINE * unit]
    common = int(np.gcd.reduce(np.rint(since / float(unit)).astype(np.int64)))
    fitting = [common * unit] if common > 1 and FINE ** -len(lengths) < CHANCE else []
    for period in tried:
        near = min(1.0, float(2 * unit / period))  # the share of all instants that are this close to it
        for part in (since[: FEW + 1], since):
            off = np.abs(part - np.rint(part / float(period)) * float(period))
            if len(off) and off.max() > unit:
                break
        else:
            if near ** len(lengths) * len(tried) < CHANCE:
                fitting.append(period)
    return max(fitting, default=None)
