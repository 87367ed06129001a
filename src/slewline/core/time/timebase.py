"""Time is an integer number of picoseconds; a chip counts clock ticks, and only their sum is converted.

Users write "25 us", "1.5 ms" or an integer number of picoseconds.  A float is refused, because it is already
rounded; the exception is `bench.now`, a float that stores its picoseconds (`Seconds`).  For waiting times and instants
of actions (`picoseconds`), an int from 1 to 999 is refused, too: it was probably meant in another unit, and "5 ps" can
be written instead.  For queries about the past (`moment`) any int is accepted.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache
from math import gcd
from operator import index
from typing import TYPE_CHECKING, Self, TypeAlias

from ...errors import TimeError
from ..messages.decimal_comma import without_comma

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

PS_PER_S = 10**12
MIN_PS = 1000  # the lowest plain number allowed, except 0
UNITS = {
    "ps": 1,
    "ns": 10**3,
    "us": 10**6,
    "µs": 10**6,
    "ms": 10**9,
    "s": PS_PER_S,
    "min": 60 * PS_PER_S,
    "h": 3600 * PS_PER_S,
}
FREQUENCIES = {"hz": 1, "khz": 10**3, "mhz": 10**6}
_QUANTITY = re.compile(r"\s*([+-]?)(\d{1,30})(?:\.(\d{0,30}))?\s*([a-zµ]+)\s*", re.IGNORECASE)


class Seconds(float):
    """An instant, in seconds: a float that prints as "0.170768 s", rounded.

    Attributes:
        ps: the exact instant, in picoseconds.
    """

    __slots__ = ("ps",)
    ps: int

    def __new__(cls, ps: int) -> Self:
        """Return the instant `ps` picoseconds after 0."""
        found = super().__new__(cls, ps / PS_PER_S)
        found.ps = ps
        return found

    def __getnewargs__(self) -> tuple[int]:  # the argument for a copy
        return (self.ps,)

    def __str__(self) -> str:
        return f"{float(self):.6f} s"


Time: TypeAlias = str | int | Seconds  # text with a unit, picoseconds, or bench.now


def _scaled(text: str, units: dict[str, int], what: str, example: str) -> int:
    match = _QUANTITY.fullmatch(text.replace("\N{GREEK SMALL LETTER MU}", "µ"))
    unit = units.get(match[4] if match and match[4] in units else match[4].lower()) if match else None
    if match is None or unit is None:
        message = f"{what} {text!r}: expected a number and a unit ({', '.join(units)}), for example {example!r}"
        raise TimeError(message + without_comma(text))
    decimals = match[3] or ""
    value, rest = divmod(int(match[2] + decimals) * unit, int(10 ** len(decimals)))
    if rest:
        raise TimeError(f"{what} {text!r}: finer than 1 {next(iter(units))}; give a multiple of 1 {next(iter(units))}")
    return -value if match[1] == "-" else value


@lru_cache(maxsize=256)  # a program uses only a few different times
def _in_ps(text: str) -> int:
    return _scaled(text, UNITS, "time", "25 us")


def _whole(time: Time, negative: bool) -> int:
    try:
        if isinstance(time, bool):
            raise TypeError
        ps = _in_ps(time) if isinstance(time, str) else index(time)  # type: ignore[arg-type]
    except TypeError:
        if not isinstance(time, Seconds):
            example = f"{time:g} s" if isinstance(time, float) and "e" not in f"{time:g}" else "25 us"
            raise TimeError(
                f"time {time!r}: expected text such as {example!r}, bench.now, or an integer number of picoseconds; "
                "a float would be rounded"
            ) from None
        ps = time.ps
    if ps < 0 and not negative:
        raise TimeError(f"time {time!r}: virtual time does not run backwards; give 0 or more")
    return ps


def picoseconds(time: Time, *, negative: bool = False) -> int:
    """Return a time in picoseconds; it is given as text such as "25 us", as `bench.now`, or in picoseconds.

    Args:
        time: the time.
        negative: allow a negative time.

    Raises:
        TimeError: a float other than `bench.now`, an unknown unit, a fraction of a picosecond, a negative time, or an
            int from 1 to 999, which lacks its unit.
    """
    ps = _whole(time, negative)
    if 0 < abs(ps) < MIN_PS and not isinstance(time, str | Seconds):
        raise TimeError(f"time {time!r}: a bare number is picoseconds; write its unit, such as '{ps} ms' or '{ps} ps'")
    return ps


def moment(time: Time, *, negative: bool = False) -> int:
    """Return a past instant in picoseconds, as `picoseconds` does, but also accept an int from 1 to 999.

    Args:
        time: the instant.
        negative: allow a negative time.

    Raises:
        TimeError: a float other than `bench.now`, an unknown unit, a fraction of a picosecond, or a
            negative time.
    """
    return _whole(time, negative)


def moments(times: Time | Sequence[Time] | NDArray[np.int64]) -> int | NDArray[np.int64]:
    """Return past instants in picoseconds: an int for one time, int64 with the shape of `times` for several.

    Raises:
        TimeError: as for `moment`.
    """
    if isinstance(times, str | int | Seconds):
        return moment(times)
    import numpy as np

    found = np.asarray(times)
    if not found.ndim:
        return moment(times)  # type: ignore[arg-type]
    return found if found.dtype.kind in "iu" else np.array([moment(time) for time in times], np.int64)


def window(start: Time | None, stop: Time | None, now: int, since: int = 0) -> tuple[int, int]:
    """Return the limits (ps) of a window of the past, by default `since` and `now`; the end is at most `now`.

    Raises:
        TimeError: a limit is not a time, or the window ends before it begins.
    """
    first, last = since if start is None else moment(start), now if stop is None else moment(stop)
    if stop is not None and first > last:
        raise TimeError(
            f"from {readable(first)} to {readable(last)}: the window ends before it begins; give an earlier start, or "
            "a later end"
        )
    return first, min(last, now)


def hertz(frequency: str | int) -> int:
    """Return a frequency in hertz, from text such as "11 MHz" or "3.579545 MHz", or from an int in hertz.

    Raises:
        TimeError: a float, an unknown unit, or a fraction of a hertz.
    """
    if isinstance(frequency, str):
        return _scaled(frequency, FREQUENCIES, "frequency", "11 MHz")
    if isinstance(frequency, int) and not isinstance(frequency, bool):
        return frequency
    raise TimeError(f"frequency {frequency!r}: expected text such as '11 MHz', or an integer number of hertz")


def readable(ps: int) -> str:
    """Return a time (ps) as text, in a suitable unit, rounded down to six decimal places: 3200000000 is "3.2 ms"."""
    for unit in ("s", "ms", "µs", "ns"):
        if abs(ps) >= UNITS[unit]:
            whole, rest = divmod(abs(ps), UNITS[unit])
            decimals = f"{rest:0{len(str(UNITS[unit])) - 1}d}"[:6].rstrip("0")
            return f"{'-' if ps < 0 else ''}{whole}{'.' + decimals if decimals else ''} {unit}"
    return f"{ps} ps"


class Clock:
    """A crystal clock; it computes the exact instant of a tick, rounded down once, so errors do not accumulate.

    Args:
        hz: the frequency, Hz.
    """

    __slots__ = ("d", "hz", "n")

    def __init__(self, hz: int) -> None:
        common = gcd(PS_PER_S, hz)
        self.hz, self.n, self.d = hz, PS_PER_S // common, hz // common

    def ps(self, ticks: int) -> int:
        """Return the instant of a tick, in picoseconds since tick 0."""
        return ticks * self.n // self.d

    def ticks_until(self, ps: int) -> int:
        """Return the last tick at or before an instant (ps since tick 0)."""
        return ((ps + 1) * self.d - 1) // self.n

    def ticks_from(self, ps: int) -> int:
        """Return the first tick at or after an instant (ps since tick 0)."""
        return -(-ps * self.d // self.n)

    def ps_list(self, ticks: list[int]) -> list[int]:
        """Return the instants of ticks, in picoseconds since tick 0."""
        n, d = self.n, self.d
        return [tick * n // d for tick in ticks]

    def ticks_list(self, ps: list[int]) -> list[int]:
        """Return the first tick at or after each of several instants (ps since tick 0)."""
        n, d = self.n, self.d
        return [-(-time * d // n) for time in ps]

    def ticks_array(self, ps: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the first tick at or after each instant (ps since tick 0): int64, same shape as `ps`, all exact."""
        whole, part = ps // self.n, ps % self.n
        guess: NDArray[np.int64] = (part * (self.d / self.n)).astype("int64")  # wrong by one at most, as a float may be
        rest = part * self.d - guess * self.n  # products wrap around, their difference is small
        return whole * self.d + guess - -rest // self.n

    def ps_array(
        self, ticks: NDArray[np.int64], origin: int = 0, out: NDArray[np.int64] | None = None
    ) -> NDArray[np.int64]:
        """Return the instants of ticks `origin + ticks`: int64 ps since tick 0, same shape as `ticks`, all exact.

        Args:
            ticks: int64, ascending, counted from `origin`.
            origin: a tick, counted from tick 0.
            out: the array for the result, which may be `ticks` itself.

        Raises:
            TimeError: an instant is beyond 2^63 ps (106 days), which does not fit in an int64.
        """
        import numpy as np

        base, late = divmod(origin * self.n, self.d)  # the origin's exact instant is late/d ps after `base`
        last = int(ticks[-1]) if len(ticks) else 0
        if self.ps(origin + last) >= 1 << 63:
            raise TimeError("arrays can contain times up to 106 days (2^63 ps); request an earlier window")
        if last * self.n + late < 1 << 63:
            out = np.multiply(ticks, self.n, out=out)
            if self.d > 1:
                out += late
                out //= self.d
        else:  # q*n + r*(n//d) + (r*(n%d) + late)//d does not overflow where ticks*n would
            quotient, rest = np.divmod(ticks, self.d)
            finest = (rest * (self.n % self.d) + late) // self.d
            out = np.add(quotient * self.n + rest * (self.n // self.d), finest, out=out)
        if base:
            out += base
        return out
