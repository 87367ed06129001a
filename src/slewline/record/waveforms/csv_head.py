"""The head of a table of levels or voltages: names, units, the rate, and in which line the numbers begin.

It differs from program to program:

Time [s],STEP,DIR                     Logic 2
; Channels (2/2): STEP, DIR           sigrok-cli and PulseView, DSView: comments, with the rate;
nanoseconds,logic,logic               then units, or names, or nothing
Time,Channel A                        oscilloscopes: names, then units
(ms),(V)
X,CH1,Start,Increment                 or a number of each sample, and the time between two
Sequence,Volt,-6.0e-03,1.0e-06
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from fractions import Fraction

from ...core.time.timebase import PS_PER_S
from ...errors import UsageError, WaveformError
from .sampling import rate_in

PREAMBLE = 200  # lines before the first number
MOST_COLUMNS = 1024
LONG = 100  # characters of a cell of the head that count
DIGITS = 12  # after the decimal point: picoseconds of a second
TIMES = {  # by what heads call them, ps
    **dict.fromkeys(("s", "sec", "second", "seconds"), Fraction(PS_PER_S)),
    **dict.fromkeys(("ms", "millisecond", "milliseconds"), Fraction(10**9)),
    **dict.fromkeys(("us", "µs", "μs", "microsecond", "microseconds"), Fraction(10**6)),
    **dict.fromkeys(("ns", "nanosecond", "nanoseconds"), Fraction(1000)),
    **dict.fromkeys(("ps", "picosecond", "picoseconds"), Fraction(1)),
}
NOTHING = frozenset(("v", "mv", "volt", "volts", "logic", "samples", "sequence", ""))  # other units
DATE = re.compile(r"\d{4}-\d\d-\d\d[T ]")

_TIME = re.compile(r"time\b|time[\[(]|second|x-axis|t\s*[\[(]|zeit", re.IGNORECASE)
_INDEX = re.compile(r"x$|sequence$|samples?$|sample number$|point$|index$|#$", re.IGNORECASE)
_UNIT = re.compile(r".*[\[(]\s*([^\[\]()]*?)\s*[\])]\s*")
_CHANNELS = re.compile(r"channels \(\d+/\d+\):\s*(.*\S)", re.IGNORECASE)
_NUMBER = re.compile(r"\s*[+-]?(?:\d+(?:[.,](\d*))?|[.,]\d+)([eE][+-]?\d+)?\s*")


@dataclass(slots=True)
class CsvHead:
    """What the head of a table says.

    `columns` are those of signals, by name; `time` is the column of times, None if rows are one `period` apart.  A time
    is a number of `factor` ps, to `unit` ps.
    """

    delimiter: str = ","
    lines: int = 0  # before the first number
    columns: dict[str, int] = field(default_factory=dict)
    time: int | None = None
    factor: Fraction = Fraction(1)
    unit: Fraction = Fraction(1)
    rate: Fraction | None = None


def read_head(path: str, lines: list[str], timescale: int | None) -> CsvHead:
    """Read the head of a table.

    Args:
        lines: the first lines of the file.
        timescale: the unit of its times, or the time between two rows, ps; None: as the file says.

    Raises:
        WaveformError: no row of numbers.
        UsageError: nothing says how far apart the rows are, or in which unit times are.
    """
    head, sigrok = CsvHead(), False
    texts: list[list[str]] = []
    channels: list[str] = []
    first: list[str] = []
    for head.lines, line in enumerate(lines[:PREAMBLE]):
        bare = line.strip()
        if bare.startswith((";", "#", "META ")) or not bare:
            head.rate = head.rate or rate_in(bare)
            sigrok = sigrok or "libsigrok" in bare
            named = _CHANNELS.search(bare)
            channels = [each[:LONG].strip() for each in named[1].split(",")] if named else channels
            continue
        head.delimiter = next((mark for mark in ("\t", ";", ",") if mark in bare), head.delimiter)
        cells = [cell[:LONG].strip().strip('"') for cell in bare.split(head.delimiter)]
        filled = [cell for cell in cells if cell]
        if filled and all(_NUMBER.fullmatch(cell) for cell in filled):
            first = cells
            break
        texts.append(cells)
        head.rate = head.rate or _rate_of(cells)
    if not first:
        shown = next((line for line in lines if DATE.search(line)), "")
        remedy = "export times as seconds, not as dates" if shown else "expected columns of numbers under their names"
        raise WaveformError(f"{path}: no row of numbers in its first {min(len(lines), PREAMBLE)} lines; {remedy}")
    if len(first) > MOST_COLUMNS:
        raise WaveformError(f"{path}: {len(first)} columns; allowed {MOST_COLUMNS}")
    names, units = _names(texts, len(first))
    _increment(head, names, texts)
    known = [n for n, cell in enumerate(first) if cell]
    head.time = _time_column(names, units)
    counted = bool(known) and _INDEX.match((units or names)[0] or names[0] or "-") is not None
    if head.time is not None:
        _scale(head, (names[0], units[0] if units else ""), lines[head.lines :], sigrok, timescale)
    elif timescale is None and head.rate is None:
        raise UsageError(
            f"{path}: has no column of times, and states no sample rate; export times too, or give the time between "
            "two rows: timescale='1 us', or --timescale '1 us'"
        )
    else:
        head.factor = head.unit = (
            Fraction(timescale) if timescale is not None else PS_PER_S / (head.rate or Fraction(1))
        )
    signals = [n for n in known if n != head.time and not (counted and n == 0)]
    for place, n in enumerate(signals):
        name = channels[place] if len(channels) == len(signals) else names[n] if not _said(names[n]) else ""
        name = _UNIT.sub(lambda found: found[0].partition("(")[0].partition("[")[0].strip(), name) or f"D{place}"
        number = 2
        while name in head.columns:
            name, number = f"{name.partition('#')[0]}#{number}", number + 1
        head.columns[name] = n
    return head


def _said(cell: str) -> bool:
    """Is it a unit, and no name?"""
    return cell.strip("()[] ").lower() in NOTHING | TIMES.keys()


def _names(texts: list[list[str]], count: int) -> tuple[list[str], list[str]]:
    """The names of the columns, and their units, if they have a line of their own."""
    rows = [cells + [""] * (count - len(cells)) for cells in texts[-2:] if len(cells) > 1 or count == 1]
    if rows and all(_said(cell) or _NUMBER.fullmatch(cell) for cell in rows[-1]):
        return (rows[0] if len(rows) > 1 else rows[-1]), rows[-1]
    return (rows[-1] if rows else [""] * count), []


def _increment(head: CsvHead, names: list[str], texts: list[list[str]]) -> None:
    """The time between two samples, in a column of its own that only the line of units has."""
    for n, name in enumerate(names):
        if name.lower() == "increment" and n < len(texts[-1]):
            head.rate = head.rate or _inverse(texts[-1][n])


def _inverse(text: str) -> Fraction | None:
    """The rate (Hz) of a time between two samples, in seconds; None: it is no such time."""
    text = text.replace(",", ".")
    likely = _NUMBER.fullmatch(text) is not None and 1 / PS_PER_S <= float(text) <= 1000
    return 1 / Fraction(text) if likely else None


def _rate_of(cells: list[str]) -> Fraction | None:
    """The rate (Hz) in a line of the preamble: "Sample Interval,4.0e-09", "Sample Rate,1 MHz"."""
    key, value = cells[0].lower().rstrip(": "), next(filter(None, cells[1:]), "")
    if key in ("sample interval", "sampling period"):
        return _inverse(value)
    return rate_in(f"{key} {value}")


def _time_column(names: list[str], units: list[str]) -> int | None:
    own = units[0].strip("()[] ").lower() if units else ""
    named = _TIME.match(names[0]) is not None if names else False
    return 0 if named or own in TIMES or (names and names[0].strip("()[] ").lower() in TIMES) else None


def _scale(head: CsvHead, heads: tuple[str, str], rows: list[str], sigrok: bool, timescale: int | None) -> None:
    """How long a unit of the times is, and how finely they are written."""
    bracket = _UNIT.fullmatch(heads[0])
    said = [heads[1].strip("()[] "), bracket[1] if bracket else "", heads[0]]
    unit = next((TIMES[each.lower()] for each in said if each.lower() in TIMES), None)
    if timescale is not None:
        unit = Fraction(timescale)
    if unit is None and sigrok and head.rate:  # without a unit; the first row is at the first period
        unit = next((size for size in (TIMES["ms"], TIMES["us"], TIMES["ns"], TIMES["ps"])
                     if str(int(PS_PER_S / size / head.rate)) == rows[0].split(head.delimiter)[0]), None)  # fmt: skip
    if unit is None:
        unit = TIMES["s"]
    head.factor = unit
    steps = int(PS_PER_S / unit / head.rate) if head.rate else 0
    if sigrok and head.rate and steps:  # libsigrok counts in whole units, of which a period has a fraction more
        head.factor = head.unit = PS_PER_S / head.rate / steps
        return
    written = [_NUMBER.match(row.strip().strip('"').split(head.delimiter)[0]) for row in rows]
    decimals = max((len(each[1] or "") for each in written if each), default=0)
    exponents = any(each[2] for each in written if each)
    head.unit = Fraction(1) if exponents else max(unit / 10 ** min(decimals, DIGITS), Fraction(1))
