"""The header of a table of levels or voltages: names, units, sampling rate, and the line in which the numbers begin.

It differs from program to program:

Time [s],STEP,DIR                     Logic 2
; Channels (2/2): STEP, DIR           sigrok-cli and PulseView, DSView: comments, with the rate;
nanoseconds,logic,logic               then units, or names, or nothing
Time,Channel A                        oscilloscopes: names, then units
(ms),(V)
X,CH1,Start,Increment                 or sample numbers, and the time between two samples
Sequence,Volt,-6.0e-03,1.0e-06
Record Length,2500,,-5.0e-05,3.30     or the header next to the first rows
Source,CH1,,-4.0e-05,3.28
-5.0e-05,3.30                         or nothing: a column that rises from row to row is time
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from ...core.time.timebase import PS_PER_S
from ...errors import UsageError, WaveformError
from .sampling import rate_in

PREAMBLE = 200  # lines before the first number
MOST_COLUMNS = 1024
ENOUGH = 3  # rows that show a rise
LONG = 100  # characters of a cell of the head that count
DIGITS = 12  # after the decimal point: picoseconds of a second
TIMES = {  # by their names in heads, ps
    **dict.fromkeys(("s", "sec", "second", "seconds"), Fraction(PS_PER_S)),
    **dict.fromkeys(("ms", "millisecond", "milliseconds"), Fraction(10**9)),
    **dict.fromkeys(("us", "µs", "μs", "microsecond", "microseconds"), Fraction(10**6)),
    **dict.fromkeys(("ns", "nanosecond", "nanoseconds"), Fraction(1000)),
    **dict.fromkeys(("ps", "picosecond", "picoseconds"), Fraction(1)),
}
NOTHING = frozenset(("v", "mv", "volt", "volts", "value", "logic", "samples", "sequence", ""))  # other units
SOURCES = ("source", "label", "channel", "channels")  # keys of the preamble that name the signals
DECIMAL_COMMA = "if numbers have decimal commas, separate cells by ; or tabs, or export decimal points"
DATE = re.compile(r"\d{4}-\d\d-\d\d[T ]")

_TIME = re.compile(r"time\b|time[\[(]|timestamp|second|x-axis|t\s*[\[(/]|in [mµnp]?s$|zeit", re.IGNORECASE)
_INDEX = re.compile(r"x$|sequence$|samples?$|sample number$|point$|index$|#$", re.IGNORECASE)
_UNIT = re.compile(r"([^\[(]*)[\[(].*?([^\[\]()]*)[\])]\s*")
_CHANNELS = re.compile(r"channels \(\d+/\d+\):\s*(.*\S)", re.IGNORECASE)
_NUMBER = re.compile(r"\s*[+-]?(?:\d+(?:[.,](\d*))?|[.,]\d+)([eE][+-]?\d+)?\s*")


@dataclass(slots=True)
class CsvHead:
    """The information in the header of a table.

    Attributes:
        marks: the number of delimiters in a row.
        columns: the numbers of the signal columns, keyed by signal name.
        time: the number of the column of times; None: there is none, and the rows are `factor` ps apart.
        factor: the unit of the times, ps.
        unit: the resolution of the times, ps.
        rate: the sampling rate, Hz; None if it is not stated.
    """

    delimiter: str = ","
    lines: int = 0  # before the first number
    marks: int = 0
    columns: dict[str, int] = field(default_factory=dict)
    time: int | None = None
    factor: Fraction = Fraction(1)
    unit: Fraction = Fraction(1)
    rate: Fraction | None = None


class HeadLines(NamedTuple):
    """The lines before the numbers, split into cells; channels named in a comment; the first row of numbers.

    `sigrok` is True if a comment names libsigrok.
    """

    texts: list[list[str]]
    channels: list[str]
    first: list[str]
    sigrok: bool


def read_head(path: str, lines: list[str], timescale: int | None) -> CsvHead:
    """Read the header of a table.

    Args:
        lines: the first lines of the file.
        timescale: the unit of the file's times, or the time between two rows, ps; None if the file states
            it.

    Raises:
        WaveformError: there is no row of numbers, a number has no column name, or there are too many
            columns.
        UsageError: there is no column of times, and neither the file nor `timescale` states the time between
            rows.
    """
    head = CsvHead()
    texts, channels, first, sigrok = _preamble(path, head, lines)
    known = [n for n, cell in enumerate(first) if cell]
    beside = _beside(head, lines, known[0])
    own = [cells[1 : known[0] if beside else None] for cells in texts if cells[0].lower() in SOURCES]
    names, units = _names(texts[: len(texts) - beside], len(first))
    _increment(head, names, texts)
    head.time = _time_column(names, units)
    if head.time is not None and (more := sum(not names[n] for n in known)):
        raise WaveformError(f"{path}, line {head.lines + 1}: {more} numbers without a column name; {DECIMAL_COMMA}")
    counted = _INDEX.match((units or names)[0] or names[0] or "-") is not None
    if head.time is None and not counted and timescale is None and (beside or head.rate is None):
        head.time = _rising(lines[head.lines :], head.delimiter, known)
    if head.time is not None:
        heads = names[head.time], units[head.time] if units else ""
        _scale(head, heads, lines[head.lines :], sigrok, timescale)
    elif timescale is None and head.rate is None:
        raise UsageError(
            f"{path} has no column of times, and states no sample rate; export the times too, or give the time from "
            "one row to the next: timescale='1 us', or --timescale '1 us'"
        )
    else:
        head.factor = head.unit = (
            Fraction(timescale) if timescale is not None else PS_PER_S / (head.rate or Fraction(1))
        )
    signals = [n for n in known if n != head.time and not (counted and n == 0)]
    head.columns = _columns(signals, names, channels, own)
    return head


def _preamble(path: str, head: CsvHead, lines: list[str]) -> HeadLines:
    """Return the lines before the numbers; set the delimiter, the rate and the first line of numbers in `head`."""
    sigrok = False
    texts: list[list[str]] = []
    channels: list[str] = []
    for head.lines, line in enumerate(lines[:PREAMBLE]):
        bare = line.strip()
        if bare.startswith((";", "#", "META ")) or not bare:
            head.rate = head.rate or rate_in(bare)
            sigrok = sigrok or "libsigrok" in bare
            named = _CHANNELS.search(bare)
            channels = [each[:LONG].strip() for each in named[1].split(",")] if named else channels
            continue
        head.delimiter = next((mark for mark in ("\t", ";", ",") if mark in bare), head.delimiter)
        cells = _cells(line, head.delimiter)
        if _numbers(cells):
            if len(cells) > MOST_COLUMNS:
                raise WaveformError(f"{path}: {len(cells)} columns; allowed up to {MOST_COLUMNS}")
            head.marks = len(cells) - 1
            return HeadLines(texts, channels, cells, sigrok)
        texts.append(cells)
        head.rate = head.rate or _rate_of(cells)
    shown = next((line for line in lines if DATE.search(line)), "")
    remedy = "export times as seconds, not as dates" if shown else "expected columns of numbers under their names"
    raise WaveformError(f"{path}: no row of numbers in its first {min(len(lines), PREAMBLE)} lines; {remedy}")


def _columns(signals: list[int], names: list[str], channels: list[str], own: list[list[str]]) -> dict[str, int]:
    """Return the numbers of the signal columns, keyed by signal name.

    Names are taken from a channel comment; without one, from the columns if these have distinct names,
    otherwise from the preamble.  A signal without any name is D0, D1 ...
    """
    alike = len({names[n] for n in signals}) < len(signals) or all(_states_values(names[n]) for n in signals)
    if own and alike and not channels:
        channels = [name for name in own[-1] if name]
    columns: dict[str, int] = {}
    for place, n in enumerate(signals):
        name = channels[place] if len(channels) == len(signals) else names[n] if not _states_values(names[n]) else ""
        name = _split(name)[0] or f"D{place}"
        number = 2
        while name in columns:
            name, number = f"{name.partition('#')[0]}#{number}", number + 1
        columns[name] = n
    return columns


def _cells(line: str, delimiter: str) -> list[str]:
    return [cell[:LONG].strip().strip('"') for cell in line.strip(" \r\n").split(delimiter)]


def _numbers(cells: list[str]) -> bool:
    """Return whether at least one cell is filled, and all filled cells are numbers."""
    filled = [cell for cell in cells if cell]
    return bool(filled) and all(_NUMBER.fullmatch(cell) for cell in filled)


def _beside(head: CsvHead, lines: list[str], begin: int) -> int:
    """Extend the table upwards by the rows that have header cells before their numbers; return how many.

    `begin` is the column at which the numbers begin.
    """
    count = 0
    while begin and head.lines and _numbers(_cells(lines[head.lines - 1], head.delimiter)[begin:]):
        head.lines, count = head.lines - 1, count + 1
    return count


def _rising(rows: list[str], delimiter: str, known: list[int]) -> int | None:
    """Return the first column of numbers if it contains times: rising from row to row, not all whole.

    Return None if it does not contain times, or if it is the only column.
    """
    at = [cells[known[0]].replace(",", ".") for row in rows if len(cells := _cells(row, delimiter)) > known[-1]]
    found = [float(cell) for cell in at if _NUMBER.fullmatch(cell)]
    rises = len(found) >= ENOUGH and all(one < other for one, other in pairwise(found))
    return known[0] if rises and len(known) > 1 and not all(cell.lstrip("+-").isdigit() for cell in at) else None


def _split(cell: str) -> tuple[str, str]:
    """Return the name and the unit ("" if none) in a cell such as "CH1 (V)", "t / s" or "C1 in V"."""
    if (bracket := _UNIT.fullmatch(cell)) is not None:
        return bracket[1].strip(), bracket[2].strip()
    for mark in ("/", " in "):
        name, found, unit = f" {cell}".rpartition(mark)
        if found and unit.strip().lower() in (NOTHING | TIMES.keys()) - {""}:
            return name.strip(), unit.strip()
    return cell, ""


def _states_values(cell: str) -> bool:
    """Return whether a cell is a unit rather than a name."""
    return cell.strip("()[] ").lower() in NOTHING | TIMES.keys()


def _names(texts: list[list[str]], count: int) -> tuple[list[str], list[str]]:
    """Return the names and the units of the columns; the units are [] if they have no line of their own."""
    rows = [cells + [""] * (count - len(cells)) for cells in texts[-2:] if len(cells) > 1 or count == 1]
    if rows and all(_states_values(cell) or _NUMBER.fullmatch(cell) for cell in rows[-1]):
        return (rows[0] if len(rows) > 1 else rows[-1]), rows[-1]
    return (rows[-1] if rows else [""] * count), []


def _increment(head: CsvHead, names: list[str], texts: list[list[str]]) -> None:
    """Set the rate in `head` from the "Increment" column.

    Its only value, the time between two samples, is in the line of the units.
    """
    for n, name in enumerate(names):
        if name.lower() == "increment" and n < len(texts[-1]):
            head.rate = head.rate or _inverse(texts[-1][n])


def _inverse(text: str) -> Fraction | None:
    """Return the rate (Hz) for a sample interval given as text, in seconds; None if the text is not an interval."""
    text = text.replace(",", ".")
    likely = _NUMBER.fullmatch(text) is not None and 1 / PS_PER_S <= float(text) <= 1000
    return 1 / Fraction(text) if likely else None


def _rate_of(cells: list[str]) -> Fraction | None:
    """Return the rate (Hz) stated in a preamble line, such as "Sample Interval,4.0e-09" or "Sample Rate,1 MHz".

    Return None if the line states no rate.
    """
    key, value = cells[0].lower().rstrip(": "), next(filter(None, cells[1:]), "")
    if key in ("sample interval", "sampling period"):
        return _inverse(value)
    return rate_in(f"{key} {value}")


def _time_column(names: list[str], units: list[str]) -> int | None:
    own = units[0].strip("()[] ").lower() if units else ""
    named = _TIME.match(names[0]) is not None if names else False
    return 0 if named or own in TIMES or (names and names[0].strip("()[] ").lower() in TIMES) else None


def _scale(head: CsvHead, heads: tuple[str, str], rows: list[str], sigrok: bool, timescale: int | None) -> None:
    """Set the unit of the times, and their resolution, in `head`."""
    units = [heads[1].strip("()[] "), _split(heads[0])[1], heads[0]]
    unit = next((TIMES[each.lower()] for each in units if each.lower() in TIMES), None)
    if timescale is not None:
        unit = Fraction(timescale)
    if unit is None and sigrok and head.rate:  # without a unit; the first row is at the first period
        unit = next((size for size in (TIMES["ms"], TIMES["us"], TIMES["ns"], TIMES["ps"])
                     if str(int(PS_PER_S / size / head.rate)) == rows[0].split(head.delimiter)[0]), None)  # fmt: skip
    if unit is None:
        unit = TIMES["s"]
    head.factor = unit
    steps = int(PS_PER_S / unit / head.rate) if head.rate else 0
    if sigrok and head.rate and steps:  # libsigrok counts in whole units; a period is a fraction longer
        head.factor = head.unit = PS_PER_S / head.rate / steps
        return
    column = head.time or 0
    written = [_NUMBER.match(cells[column]) for row in rows if len(cells := _cells(row, head.delimiter)) > column]
    decimals = max((len(each[1] or "") for each in written if each), default=0)
    exponents = any(each[2] for each in written if each)
    head.unit = Fraction(1) if exponents else max(unit / 10 ** min(decimals, DIGITS), Fraction(1))
