"""Reads tables (CSV) of levels, as logic analysers export them, and of voltages, as oscilloscopes do.

A row may be a change, or one of millions of samples; a file is read in blocks, and only changes are
kept.  Voltages become levels by a threshold with hysteresis, so that noise on a slow edge does not count
as edges.  The threshold is the midpoint of the two voltages between which a signal switches; spikes do
not affect it.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from ...core.time.timebase import PS_PER_S
from ...errors import WaveformError
from ...gate import BOM, MAX_LINE
from .csv_head import DECIMAL_COMMA, PREAMBLE, CsvHead, read_head
from .vcd_header import DeclaredVariable, Header
from .waveforms import Waveforms

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

BLOCK = 1 << 20  # bytes
HYSTERESIS = 0.1  # of the swing of a signal, to both sides of the threshold
ROWS = 16  # number of rows that shows whether they are samples
BINS = 256  # from the lowest voltage of a signal to its highest
NEAR = 4  # bins to both sides count as the same voltage
APART = 32  # minimum number of bins between two levels: the remainder with spikes of three times the swing
MOST = 0.9  # of the samples that are not at rest: samples beyond are spikes
HUGE = 1e30  # neither a voltage nor a reading of a converter
QUIET_V = 0.5  # a signal that swings less does not move
SHOWN = 60  # characters of a line in a message
ENDS = b"\x1a\0\r\n\t "  # of files: of DOS files, of padded files


def read_csv(
    path: str | Path, file: BinaryIO, timescale: int | None, torn: bool = False, threshold_v: float | None = None
) -> Waveforms:
    """Return the waveforms in a table.

    Args:
        path: the file, for messages.
        file: the same file, opened.
        timescale: the unit of the file's times, or the time between two rows, ps; None if the file states
            it.
        torn: True to ignore text after the last line end.
        threshold_v: the voltage at and above which a level is 1; None for the midpoint between the two
            levels of each signal.

    Raises:
        WaveformError: the content cannot be read; the message states the line.
        UsageError: the time between rows is not stated.
    """
    beginning = _plain(file.read(BLOCK)).decode("utf-8", "replace").rstrip("\n").split("\n")
    head = read_head(str(path), beginning[: PREAMBLE + 1], timescale)
    table = TableRows(str(path), file, head, torn)
    changes = TableChanges(head, table, None)
    if changes.analog:
        low, high = levels_in(table, changes.lowest, changes.highest)
        changes = TableChanges(head, table, Thresholds(low, high, threshold_v))
    names = {name: name.encode() for name in head.columns}
    variables = {identifier: DeclaredVariable("bits", 1) for identifier in names.values()}
    return Waveforms(path, Header(head.unit, variables, names, rate=head.rate or changes.rate, whole=True), changes)


def _plain(block: bytes) -> bytes:
    """Return a block of text with line feeds as line ends, and without a byte order mark."""
    block = block.removeprefix(BOM)
    return block.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in block else block


class TableRows:
    """The rows of a table, block by block; each iteration starts at the first block."""

    def __init__(self, path: str, file: BinaryIO, head: CsvHead, torn: bool) -> None:
        self.path, self.file, self.head, self.torn = path, file, head, torn
        self.used = [*([head.time] if head.time is not None else []), *head.columns.values()]

    def __iter__(self) -> Iterator[tuple[int, NDArray[np.float64]]]:
        """Yield, for each block, the number of lines before it in the file, and its rows.

        A row has the time, if there is a column of times, and then the value of each signal.
        """
        self.file.seek(0)
        rest, number, skip = b"", self.head.lines, self.head.lines
        more = True
        while more:
            block = self.file.read(BLOCK)
            more, block = bool(block), _plain(rest + block)
            end = block.rfind(b"\n") + 1 if more or self.torn else len(block)
            block, rest = block[:end], block[end:]
            if len(rest) > MAX_LINE:
                raise WaveformError(
                    f"{self.path}: a line of more than {MAX_LINE} bytes; check that the file is a table (CSV)"
                )
            if not more:
                block = block.rstrip(ENDS)
            while skip and block:
                _, _, block = block.partition(b"\n")
                skip -= 1
            if block.strip():
                yield number, self._rows(block, number)
                number += block.count(b"\n")

    def _rows(self, block: bytes, number: int) -> NDArray[np.float64]:
        import numpy as np

        mark = self.head.delimiter
        self._check_cells(block, number)
        if mark != "," and b"," in block:
            block = block.replace(b",", b".")
        try:
            return np.loadtxt(io.BytesIO(block), np.float64, comments=None, delimiter=mark, usecols=self.used, ndmin=2)
        except ValueError:
            raise self._wrong(block, number) from None

    def _check_cells(self, block: bytes, number: int) -> None:
        """Check that no row has more cells than the first row; decimal commas, for example, cause extra cells."""
        import numpy as np

        mark = self.head.delimiter.encode()
        codes = np.frombuffer(block, np.uint8)
        ends = np.append(np.flatnonzero(codes == ord("\n")), len(codes))
        marks = np.diff(np.searchsorted(np.flatnonzero(codes == ord(mark)), ends), prepend=0)
        for row in np.flatnonzero(marks > self.head.marks):
            line = block[ends[row - 1] + 1 if row else 0 : ends[row]].rstrip(mark + b" ")
            if line.count(mark) > self.head.marks:
                what = f"{line.count(mark) + 1} cells, and the first row has {self.head.marks + 1}; {DECIMAL_COMMA}"
                raise self.error(number + int(row) + 1, line, what)

    def _wrong(self, block: bytes, number: int) -> WaveformError:
        """Return the error for a block: it states the first line that lacks a number in a used column.

        `number` is the number of lines before the block.
        """
        for row, line in enumerate(block.split(b"\n"), number + 1):
            cells = line.decode("latin-1").split(self.head.delimiter)
            try:
                for n in self.used if line.strip() else ():
                    float(cells[n])
            except (ValueError, IndexError):
                return self.error(row, line, "expected a number in each column; the file may be cut off or damaged")
        return self.error(number + 1, block[:SHOWN], "expected rows of numbers")

    def error(self, number: int, line: bytes, what: str) -> WaveformError:
        """Return an error that states the number of a line, the beginning of the line, and the fault."""
        return WaveformError(f"{self.path}, line {number}: {line[:SHOWN].decode('latin-1')!r}: {what}")


def levels_in(
    table: TableRows, lowest: NDArray[np.float64], highest: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the low and high voltages between which each signal switches, ignoring spikes: (signals,) float64.

    Args:
        lowest, highest: the extreme voltages of each signal, (signals,) V.
    """
    import numpy as np

    count = len(lowest)
    size = np.where(highest > lowest, highest - lowest, 1.0) / BINS
    seen = np.zeros((count, BINS), np.int64)
    for _, block in table:
        places = np.clip((block[:, -count:] - lowest) / size, 0, BINS - 1).astype(np.int64)
        for n in range(count):
            seen[n] += np.bincount(places[:, n], minlength=BINS)
    levels = np.array([_levels(row) for row in seen]).reshape(-1, 2)
    low, high = lowest + (levels.T + 0.5) * size
    return low, high


def _levels(seen: NDArray[np.int64]) -> tuple[int, int]:
    """Return the bins of a signal's low level and high level, ignoring spikes.

    The first level found is the bin with the most samples in and near it.  The other level is on the side,
    above or below, that has more samples at a distance of at least `APART` bins.

    Args:
        seen: the number of samples in each bin, (BINS,).
    """
    import numpy as np

    rest = int(np.convolve(seen, np.ones(2 * NEAR + 1, np.int64), "same").argmax())
    below, above = np.cumsum(seen[: max(rest - APART, 0)][::-1]), np.cumsum(seen[rest + APART :])
    if below.sum() and (not len(above) or below[-1] > above[-1]):
        return rest - APART - 1 - int(np.searchsorted(below, MOST * below[-1])), rest
    far = int(np.searchsorted(above, MOST * above[-1])) if len(above) else 0
    return rest, min(rest + APART + far, BINS - 1)


class Thresholds:
    """Two voltages per signal: its level is 1 at and above the upper, 0 below the lower, unchanged in between."""

    def __init__(self, low: NDArray[np.float64], high: NDArray[np.float64], given: float | None) -> None:
        import numpy as np

        swing = high - low
        middle = (high + low) / 2 if given is None else np.full(len(swing), given)
        still = swing < QUIET_V
        middle = np.where(still, high.max(initial=0.0) / 2 if given is None else middle, middle)
        half = np.where(still, 0.0, HYSTERESIS * swing)
        self.middle, self.above, self.below = middle, middle + half, middle - half


class TableChanges:
    """The changes in a table, in the form that `Waveforms` needs.

    `analog` is True if the table contains any value other than 0 and 1; `lowest` and `highest` are the
    extreme values of each signal.  `rate` is the sampling rate, Hz, if the rows are at equal intervals,
    otherwise None.
    """

    def __init__(self, head: CsvHead, table: TableRows, thresholds: Thresholds | None) -> None:
        import numpy as np

        count = len(head.columns)
        self.unit, self.end = Fraction(1), 0
        self.begin: int | None = 0
        self.head, self.analog = head, False
        self.lowest, self.highest = np.full(count, np.inf), np.full(count, -np.inf)
        self._parts: list[list[tuple[Any, Any]]] = [[] for _ in range(count)]
        self.rate: Fraction | None = None
        self._last: Any = None  # the levels of the last row
        rows, first, before = 0, 0.0, -np.inf
        least, most = np.inf, 0.0  # between rows, in units of the file
        for number, block in table:
            times = block[:, 0] if head.time is not None else np.arange(rows, rows + len(block), dtype=np.float64)
            values = block[:, 1:] if head.time is not None else block
            wrong = ~(np.isfinite(times) & (np.abs(values) < HUGE).all(axis=1))
            with np.errstate(invalid="ignore"):  # infinite ones
                wrong |= np.diff(times, prepend=before) < 0
            if wrong.any():
                row = int(np.argmax(wrong))
                shown = ", ".join(f"{value:g}" for value in block[row]).encode()
                raise table.error(number + row + 1, shown, "a time before the one above, or not a finite number")
            if not rows:
                first = min(float(times[0]), 0.0)  # times before the trigger are negative: the record begins at 0
            at = self._picoseconds(table, times - first)
            if not rows:
                self.begin = int(at[0])
            apart = np.diff(times, prepend=before)[not rows :]
            least, most = apart.min(initial=least), apart.max(initial=most)
            rows, before, self.end = rows + len(block), times[-1], int(at[-1])
            if thresholds is None:
                np.minimum(self.lowest, values.min(axis=0), out=self.lowest)
                np.maximum(self.highest, values.max(axis=0), out=self.highest)
                self.analog = self.analog or not ((values == 0) | (values == 1)).all()
            self._keep(at, self._levels(values, thresholds))
        if rows > ROWS and (most - least) * float(head.factor) <= 2.5 * float(head.unit) and self.end > self.begin:
            self.rate = Fraction(PS_PER_S * (rows - 1), self.end - self.begin).limit_denominator(10**4)

    def _picoseconds(self, table: TableRows, times: NDArray[np.float64]) -> NDArray[np.int64]:
        import numpy as np

        factor = float(self.head.factor)
        if float(times[-1]) * factor >= 1 << 62:
            raise WaveformError(f"{table.path}: a time is too large; allowed less than 2^62 ps (53 days)")
        return np.rint(times * factor).astype(np.int64)

    def _levels(self, values: NDArray[np.float64], thresholds: Thresholds | None) -> NDArray[np.int8]:
        import numpy as np

        if thresholds is None:
            return (values > 0.5).astype(np.int8)
        known = np.where(values >= thresholds.above, 1, np.where(values < thresholds.below, 0, -1)).astype(np.int8)
        start = self._last if self._last is not None else (values[0] >= thresholds.middle).astype(np.int8)
        known[0] = np.where(known[0] < 0, start, known[0])
        place = np.where(known >= 0, np.arange(len(known))[:, None], 0)
        np.maximum.accumulate(place, axis=0, out=place)
        found: NDArray[np.int8] = np.take_along_axis(known, place, axis=0)
        return found

    def _keep(self, at: NDArray[np.int64], levels: NDArray[np.int8]) -> None:
        import numpy as np

        before = np.full((1, levels.shape[1]), -1, np.int8) if self._last is None else self._last[None]
        changed = np.diff(levels, axis=0, prepend=before) != 0
        for number, parts in enumerate(self._parts):
            here = np.flatnonzero(changed[:, number])
            if len(here):
                parts.append((at[here], levels[here, number]))
        self._last = levels[-1].copy()

    def series(self) -> dict[bytes, tuple[DeclaredVariable, NDArray[np.int64], NDArray[Any]]]:
        """Return the changes, keyed by signal identifier: its variable, times, (n,) int64 ps, and values, (n,)."""
        import numpy as np

        out: dict[bytes, tuple[DeclaredVariable, NDArray[np.int64], NDArray[Any]]] = {}
        for name, parts in zip(self.head.columns, self._parts, strict=True):
            times = np.concatenate([np.empty(0, np.int64), *(at for at, _ in parts)])
            levels = np.concatenate([np.empty(0, np.int8), *(values for _, values in parts)])
            out[name.encode()] = DeclaredVariable("bits", 1), times, levels
        return out
