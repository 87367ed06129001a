"""Value change dumps (IEEE 1364), for GTKWave, PulseView and their like.

    #1200            time, in units of the timescale
    0!               one wire: level and identifier
    b1010 "          a bus

Times are rounded down to the timescale.  Of several changes of a net inside one unit the last one counts; a glitch
that is over within its unit is not in the file.  Changes of one instant stand under one time.  The same run gives the
same bytes, whether written at once or in parts.

Lines are made by table: every change is one number, time and code in one, so that one sort puts them in order; digits
come out of a table four at a time; the lines of a chunk are one matrix of bytes, from which a mask cuts what is not
needed (a time that was said already, the padding of short values).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from ..core.timebase import UNITS, readable
from ..errors import UsageError
from .recorder import Probe, Recorder, chunks, net_of, real_edges, width_of
from .whole_file import WholeFile

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .recorder import Edges

TIMESCALES = {f"{n} {unit}": n * UNITS[unit] for unit in ("ps", "ns", "us", "ms", "s") for n in (1, 10, 100)}
BLOCK_ROWS = 1 << 14  # rows that the processor's cache holds
ID_FIRST, ID_COUNT = 33, 94  # identifiers are made of the printable characters


class VcdStream:
    """A VCD file that grows with virtual time: `write_until` appends what has happened since the last call.

    `nets` maps names to recorded nets or pins; dots make scopes, so that "x.slew" is variable slew in scope x.  The
    file begins with the levels at `start` (ps; None: now) and is put in place by `close`.  As a context manager it
    closes, or discards when the block raises.

    Raises:
        UsageError: an unknown timescale, no nets, names that do not fit a VCD file, or a path that cannot be written.
        NotRecorded: a net is not recorded, or no longer as far back as `start` or as the last call.
    """

    def __init__(
        self,
        path: str | Path,
        nets: Mapping[str, Probe],
        recorder: Recorder,
        timescale: str = "1 ns",
        start: int | None = None,
    ) -> None:
        if timescale not in TIMESCALES:
            raise UsageError(f"timescale {timescale!r}: allowed {', '.join(TIMESCALES)}")
        if not nets:
            raise UsageError(f"{path}: no nets to write; name at least one")
        self._probes, self._recorder, self._unit = list(nets.values()), recorder, TIMESCALES[timescale]
        self._kernel = net_of(self._probes[0]).kernel
        self._reached = self._kernel.seen if start is None else start
        for probe in self._probes:
            recorder.level_at(probe, self._reached)
        self._table = Table([width_of(probe) for probe in self._probes])
        self._header = _header(nets, timescale)
        self._levels: list[int] = []  # the last ones written; none before the first unit is over
        self._said = self._reached // self._unit  # the last time written, in units
        self._next = (self._said + 1) * self._unit  # from this instant on, nothing is written yet
        self._file = WholeFile(path)

    def write_until(self, ps: int) -> None:
        """Append the changes up to an instant; what lies in a unit that is not over stays back for the next call."""
        self._reached = max(self._reached, min(ps, self._kernel.seen))
        over = (self._reached + 1) // self._unit * self._unit
        if over >= self._next:
            self._append(over - 1)

    def close(self) -> None:
        """Append what stayed back and, as the end, the instant of the last call; put the file in place."""
        self._append(self._reached)
        end = self._reached // self._unit
        if end > self._said:
            self._file.write(b"#%d\n" % end)
            self._said = end
        self._file.commit()

    def discard(self) -> None:
        """Throw the file away, unless it is closed."""
        self._file.discard()

    def _append(self, stop: int) -> None:
        if not self._levels:
            self._begin(min(self._next - 1, stop))
        for edges in chunks(self._recorder, self._probes, self._next, stop, self._unit):
            units, codes = self._merged(edges)
            if len(units):
                self._file.write(self._table.lines(units, codes))
                self._said = int(units[-1])
        self._next = max(self._next, stop + 1)

    def _begin(self, ps: int) -> None:
        self._levels = [self._recorder.level_at(probe, ps) for probe in self._probes]
        dump = "".join(self._table.change(net, level) for net, level in enumerate(self._levels))
        self._file.write(f"{self._header}#{self._said}\n$dumpvars\n{dump}$end\n".encode())

    def _merged(self, chunk: list[Edges]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Times in units and codes of all changes of a chunk, by time, then in the order of the nets."""
        import numpy as np

        base, bits = self._next // self._unit, self._table.bits
        keys = [np.empty(0, np.int64)]
        for net, (times, levels) in enumerate(chunk):
            units, levels = real_edges(times // self._unit, levels, self._levels[net])
            if len(units):
                self._levels[net] = int(levels[-1])
                key = units - base
                key <<= bits
                key += levels
                key += self._table.first[net]
                keys.append(key)
        merged = np.concatenate(keys)
        merged.sort(kind="stable")  # a few ascending rows, one a net: merging them is much faster than sorting
        codes = merged & ((1 << bits) - 1)
        merged >>= bits
        merged += base
        return merged, codes

    def __enter__(self) -> VcdStream:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self.close()
        finally:
            self.discard()


def write_vcd(
    path: str | Path, nets: Mapping[str, Probe], recorder: Recorder, start: int, stop: int, timescale: str = "1 ns"
) -> None:
    """Write what some nets did at start <= t <= stop (ps, as far as the last committed instant) to a VCD file.

    The window is expanded in pieces, so a long one needs no more memory than a short one.

    Raises:
        UsageError, NotRecorded: as VcdStream does; or the window ends before it begins.
    """
    if stop < start:
        raise UsageError(f"{path}: the window ends at {readable(stop)}, before it begins at {readable(start)}")
    with VcdStream(path, nets, recorder, timescale, start) as stream:
        stream.write_until(stop)


def identifier(number: int) -> str:
    """The short name of variable `number` in the file: "!" for 0, and so on, further characters when those run out."""
    text = ""
    while True:
        number, character = divmod(number, ID_COUNT)
        text += chr(ID_FIRST + character)
        if number == 0:
            return text
        number -= 1


def _header(nets: Mapping[str, Probe], timescale: str) -> str:
    """Everything up to $enddefinitions.  No date: the same run gives the same bytes."""
    tree: dict[str, Any] = {}
    for number, (name, probe) in enumerate(nets.items()):
        *scopes, variable = name.split(".") if "." in name else ("slewline", name)
        level = tree
        for scope in scopes:
            level = level.setdefault(scope, {})
            if not isinstance(level, dict):
                raise UsageError(f"{name!r}: {scope!r} is the name of a variable in the file and cannot be a scope too")
        if not all(part and part.isascii() and part.isprintable() and " " not in part for part in (*scopes, variable)):
            raise UsageError(
                f"{name!r}: no name for a VCD file; use printable ASCII without blanks, dots between scopes"
            )
        if variable in level:
            raise UsageError(f"{name!r}: {variable!r} is the name of a scope in the file and cannot be a variable too")
        level[variable] = f"$var wire {width_of(probe)} {identifier(number)} {variable} $end\n"
    return f"$timescale {timescale} $end\n$version slewline $end\n{_scopes(tree)}$enddefinitions $end\n"


def _scopes(tree: dict[str, Any]) -> str:
    return "".join(
        what if isinstance(what, str) else f"$scope module {name} $end\n{_scopes(what)}$upscope $end\n"
        for name, what in tree.items()
    )


# --------------------------------------------------------------------------------------------------- lines by table
class Table:
    """The lines of all changes there can be, by code; the code of a change is `first` of its net plus level."""

    def __init__(self, widths: Sequence[int]) -> None:
        import numpy as np

        self.first: list[int] = []
        self._texts: list[str] = []
        for number, width in enumerate(widths):
            name = identifier(number)
            self.first.append(len(self._texts) + 1)  # FLOATING, which is -1, comes first
            if width == 1:
                self._texts += [f"{level}{name}\n" for level in "z01"]
            else:
                self._texts += [f"bz {name}\n", *(f"b{level:b} {name}\n" for level in range(1 << width))]
        self.bits = len(self._texts).bit_length()
        self._lengths = np.array([len(text) for text in self._texts])
        width = int(self._lengths.max())
        self._even = bool((self._lengths == width).all())
        # "\n" in front: a time ends with it, and so the commonest row is a whole number of 4-byte words
        padded = "".join("\n" + text.ljust(width) for text in self._texts)
        self._rows = np.frombuffer(padded.encode(), np.uint8).reshape(-1, width + 1)

    def change(self, net: int, level: int) -> str:
        """The line of one change."""
        return self._texts[self.first[net] + level]

    def lines(self, units: NDArray[np.int64], codes: NDArray[np.int64]) -> bytes:
        """The lines of changes, each instant named once.

        Args:
            units: (n,) int64, times in units of the file, ascending.
            codes: (n,) int64.
        """
        import numpy as np

        named = np.append(True, units[1:] != units[:-1])
        parts = []
        begin = 0
        while begin < len(units):  # rows of equal width: times of equally many digits
            digits = len(str(units[begin]))
            end = min(int(np.searchsorted(units, 10**digits)), begin + BLOCK_ROWS)
            parts.append(self._block(units[begin:end], codes[begin:end], named[begin:end], digits))
            begin = end
        return b"".join(parts)

    def _block(
        self, units: NDArray[np.int64], codes: NDArray[np.int64], named: NDArray[np.bool_], digits: int
    ) -> bytes:
        import numpy as np

        width = self._rows.shape[1]
        rows = np.empty((len(units), 1 + digits + width), np.uint8)
        _put_times(rows, units, digits)
        if width == 4:
            _words(rows, 1 + digits)[:] = self._rows.view(np.uint32)[:, 0][codes]
        else:
            rows[:, 1 + digits :] = self._rows[codes]
        repeated = np.flatnonzero(~named)
        if self._even and 16 * len(repeated) < len(rows):  # a few times to cut out
            return _without(rows, repeated, digits + 2)
        needed = _needed(digits, width - 1).take(named * width + self._lengths[codes], axis=0)
        return bytes(rows[needed].data)


@cache
def _needed(digits: int, longest: int) -> NDArray[np.bool_]:
    """Which bytes of a row are needed, for changes of 0 to `longest` bytes: first without the time, then with it."""
    import numpy as np

    column = np.arange(digits + 2 + longest)
    lengths = np.arange(longest + 1)[:, None]
    change = (column >= digits + 2) & (column < digits + 2 + lengths)
    return np.concatenate([change, change | (column < digits + 2)])


def _without(rows: NDArray[np.uint8], shorter: NDArray[np.intp], head: int) -> bytes:
    """All bytes of the rows but the first `head` of some."""
    flat = rows.ravel().data
    begins = (shorter * rows.shape[1]).tolist()
    return b"".join(flat[a:b] for a, b in zip([0, *(n + head for n in begins)], [*begins, len(flat)], strict=True))


def _words(rows: NDArray[np.uint8], column: int) -> NDArray[np.uint32]:
    """Four columns of a matrix of bytes, seen as one of words: (n,) uint32."""
    import numpy as np

    words: NDArray[np.uint32] = rows[:, column : column + 4].view(np.uint32)[:, 0]
    return words


def _put_times(rows: NDArray[np.uint8], units: NDArray[np.int64], digits: int) -> None:
    """Write "#" and the digits of the times into the first columns of the rows."""
    fours, lead = divmod(digits, 4)
    words = []
    for _ in range(fours):
        upper = units // 10_000
        words.append(_digits(4)[units - upper * 10_000])
        units = upper
    # "#" and the odd digits fill a word, if need be with rubbish that what follows writes over
    words.append(_digits(lead, "#")[units])
    for number, word in enumerate(reversed(words)):
        _words(rows, max(lead + 4 * number - 3, 0))[:] = word


@cache
def _digits(count: int, sign: str = "") -> NDArray[np.uint32]:
    """The numbers of `count` digits behind a sign, as words of four characters: (10**count,) uint32."""
    import numpy as np

    numbers = [f"{number:0{count}d}" if count else "" for number in range(10**count)]
    return np.frombuffer("".join((sign + number).ljust(4) for number in numbers).encode(), np.uint32)
