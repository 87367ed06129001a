r"""Value change dumps (IEEE 1364), for GTKWave, PulseView, Surfer and similar programs.

    #1200                  time, in units of the timescale
    0!                     one wire: level and identifier
    b1010 "                a bus as a whole
    r5978.26 #             a real: a velocity
    sP\x20300 $            a string: the command in progress

Times are rounded down to the timescale.  Of several changes of a variable within one unit, the last one counts; a
glitch within one unit is not in the file, but is counted as lost.  Changes at the same instant share one time entry.
The same run produces the same bytes, whether written as a whole or in parts.

All programs can read a file of wires.  libsigrok 0.5.2 refuses a file that contains a bus, so a bus is written as its
wires unless the user requests otherwise; libsigrok skips reals silently, and strings with a warning each.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import count
from pathlib import Path
from struct import pack, unpack
from typing import TYPE_CHECKING, Any

from ...closing import WholeOrNothing
from ...core.messages.plain import ascii_of
from ...core.time.timebase import UNITS, readable
from ...errors import UsageError
from ..recording.recorder import Probe, Recorder, chunks, net_of, real_edges
from ..whole_file import WholeFile
from .vcd_lines import ChangeTexts
from .vcd_sources import Buses, NetSource, Variable, VariableSource

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .vcd_sources import Changes

TIMESCALES = {f"{n} {unit}": n * UNITS[unit] for unit in ("ps", "ns", "us", "ms", "s") for n in (1, 10, 100)}
ID_FIRST, ID_COUNT = 33, 94  # identifiers are made of the printable characters
# A reader that skips a string takes its identifier for the next item in the file: no item begins like these.
MISREAD = frozenset("#$01xXzZuUwWlLhH-bBrRsSpP")
ESCAPES = str.maketrans({" ": "\\x20", "\\": "\\\\", "\t": "\\t", "\n": "\\n", "\r": "\\r"})


class VcdStream(WholeOrNothing):
    """A VCD file that grows with virtual time: `write_until` appends all changes since its last call.

    The file begins with the values at `start` and is put in place by `close`.  As a context manager, the
    stream closes the file, or discards it if the block raises an exception.

    Args:
        path: the file.
        nets: recorded nets or pins, keyed by name; dots separate scopes, so that "x.slew" is variable slew
            in scope x.
        recorder: the recorder that recorded the nets.
        timescale: one of TIMESCALES.
        start: the start of the file, ps; None for now.
        buses: "bits" for a bus as its wires, "whole" as one variable, or "both".
        values: sources of further variables in the file: quantities and text.
        comments: texts that are written as comments at the head of the file.

    Raises:
        UsageError: an unknown timescale, no nets, names that do not fit a VCD file, or a path that cannot be
            written.
        NotRecorded: a net is not recorded, or its past is no longer kept back to `start` or to the last
            call of `write_until`.
    """

    def __init__(
        self,
        path: str | Path,
        nets: Mapping[str, Probe],
        recorder: Recorder,
        timescale: str = "1 ns",
        start: int | None = None,
        buses: Buses = "bits",
        values: Sequence[VariableSource] = (),
        comments: Iterable[str] = (),
    ) -> None:
        self.path, self.nets, self.unit = Path(path), list(nets), unit_of(timescale)
        if not nets:
            raise UsageError(f"{path}: no nets to write; name at least one")
        self._kernel = net_of(next(iter(nets.values()))).kernel
        self._start = self._reached = self._kernel.seen if start is None else start
        self._sources = [*(NetSource(recorder, name, probe, buses) for name, probe in nets.items()), *values]
        for source in self._sources:
            source.values_at(self._reached)
        self.variables = [variable for source in self._sources for variable in source.variables]
        self._ids = identifiers(self.variables)
        self._header = _header(self.variables, self._ids, timescale, comments)
        self._first: list[int] = []  # of every wire, the code of its level 0
        texts: list[str] = []
        for variable, name in zip(self.variables, self._ids, strict=True):
            self._first.append(len(texts) + 1)  # FLOATING, which is -1, comes first
            texts += _levels(variable, name)
        self._table = ChangeTexts(texts)
        self._now: list[Any] = []  # the values written last; empty until the first unit is complete
        self._written = self._reached // self.unit  # the last time written, in units
        self._next = (self._written + 1) * self.unit  # nothing after this instant has been written yet
        self.lost = 0
        """Number of wire changes that are not in the file, because others followed in the same unit."""
        self._file = WholeFile(path)

    @property
    def window(self) -> tuple[int, int]:
        """The instants (ps) at which the file begins and at which it ends so far."""
        return self._start, self._reached

    def write_until(self, ps: int) -> None:
        """Append the changes up to an instant (ps); those in an incomplete time unit wait for the next call."""
        self._reached = max(self._reached, min(ps, self._kernel.seen))
        over = (self._reached + 1) // self.unit * self.unit
        if over >= self._next:
            self._append(over - 1)

    def close(self) -> None:
        """Append the remaining changes, write the last instant as the end time, and put the file in place."""
        self._append(self._reached)
        end = self._reached // self.unit
        if end > self._written:
            self._file.write(b"#%d\n" % end)
            self._written = end
        self._file.close()

    def discard(self) -> None:
        """Discard the file, unless it has been closed."""
        self._file.discard()

    def _append(self, stop: int) -> None:
        if not self._now:
            self._begin(min(self._next - 1, stop))
        for changes in chunks([source.changes for source in self._sources], self._next, stop, self.unit):
            table, units, codes = self._merged(changes)
            if len(units):
                self._file.write(table.lines(units, codes))
                self._written = int(units[-1])
        self._next = max(self._next, stop + 1)

    def _begin(self, ps: int) -> None:
        """Write the header of the file and the initial value of every variable.

        The initial values are those at `ps`, which is the end of the first time unit.
        """
        self._now = [value for source in self._sources for value in source.values_at(self._start)]
        if ps > self._start:
            self._settled([source.changes(self._start + 1, ps) for source in self._sources])
        dump = "".join(map(self._line, range(len(self._now)), self._now))
        self._file.write(f"{self._header}#{self._written}\n$dumpvars\n{dump}$end\n".encode("ascii"))

    def _line(self, number: int, value: Any) -> str:
        kind = self.variables[number].kind
        if kind == "wire":
            return self._table.texts[self._first[number] + int(value)]
        return f"{real(value) if kind == 'real' else string(value)} {self._ids[number]}\n"

    def _settled(self, changes: list[Changes]) -> list[tuple[NDArray[np.int64], Any]]:
        """Return, for every variable, the file's time units in which it changes, and its value after each."""
        settled: list[tuple[NDArray[np.int64], Any]] = []
        for source, (times, values) in zip(self._sources, changes, strict=True):
            for column in source.split(values):
                number = len(settled)
                if self.variables[number].all:
                    units, column = _joined(times // self.unit, column)
                else:
                    units, column, lost = self._last(times, column, number, len(source.variables) > 1)
                    self.lost += lost if self.variables[number].kind == "wire" else 0
                if len(units):
                    self._now[number] = column[-1]
                settled.append((units, column))
        return settled

    def _last(
        self, times: NDArray[np.int64], values: NDArray[Any], number: int, shared: bool
    ) -> tuple[NDArray[np.int64], NDArray[Any], int]:
        """Keep only the last change of a variable in each time unit of the file.

        If `shared`, `times` also contains the times at which only other variables of the source change.  These
        are dropped first.

        Returns:
            The time units in which the variable changes, its value after each of them, and the number of changes
            that were lost.
        """
        before = self._now[number]
        if shared:
            times, values = real_edges(times, values, before)
        units, kept = real_edges(times // self.unit, values, before)
        return units, kept, len(times) - len(units)

    def _merged(self, changes: list[Changes]) -> tuple[ChangeTexts, NDArray[np.int64], NDArray[np.int64]]:
        """Return the changes of all variables in a chunk, in the order in which they are written.

        Returns:
            The table of the lines that may be written; for each change, its time in time units of the file, and
            its code, which is the index of its line in the table.
        """
        import numpy as np

        more: list[str] = []
        marks: list[tuple[NDArray[np.int64], NDArray[np.int64]]] = []
        for number, (units, values) in enumerate(self._settled(changes)):
            if not len(units):
                continue
            if self.variables[number].kind == "wire":
                marks.append((units, values + np.int64(self._first[number])))
            else:
                texts, which = np.unique(values, return_inverse=True)
                marks.append((units, which + (len(self._table.texts) + len(more))))
                more += [self._line(number, value) for value in texts.tolist()]
        table = self._table.with_more(more)
        base = min((int(units[0]) for units, _ in marks), default=0)
        keys = [np.empty(0, np.int64)]
        for units, codes in marks:
            key = units - base
            key <<= table.bits
            key += codes
            keys.append(key)
        merged = np.concatenate(keys)
        merged.sort(kind="stable")  # a few ascending rows, one per variable: merging them is much faster than sorting
        codes = merged & ((1 << table.bits) - 1)
        merged >>= table.bits
        merged += base
        return table, merged, codes


def write_vcd(
    path: str | Path,
    nets: Mapping[str, Probe],
    recorder: Recorder,
    start: int,
    stop: int,
    timescale: str = "1 ns",
    **options: Any,
) -> VcdStream:
    """Write the changes in start <= t <= stop (ps), up to the last committed instant, to a VCD file.

    The window is expanded in pieces, so a long window needs no more memory than a short one.  `options` and
    further exceptions are those of VcdStream.

    Returns:
        The closed stream, whose `lost` counts the wire changes that the timescale hides.

    Raises:
        UsageError: the window ends before it begins.
    """
    if stop < start:
        raise UsageError(f"{path}: the window ends at {readable(stop)}, before it begins at {readable(start)}")
    with VcdStream(path, nets, recorder, timescale, start, **options) as stream:
        stream.write_until(stop)
    return stream


def unit_of(timescale: str) -> int:
    """Return the length of a timescale in picoseconds.

    Raises:
        UsageError: VCD files have no such timescale.
    """
    if timescale not in TIMESCALES:
        raise UsageError(f"timescale {timescale!r}: allowed {', '.join(TIMESCALES)}")
    return TIMESCALES[timescale]


def identifier(number: int) -> str:
    """Return the short name of variable `number` in the file.

    It has one character for the numbers 0 ("!") to 93, and more characters from 94.
    """
    text = ""
    while True:
        number, character = divmod(number, ID_COUNT)
        text += chr(ID_FIRST + character)
        if number == 0:
            return text
        number -= 1


def identifiers(variables: Iterable[Variable]) -> list[str]:
    """Return the short names of all variables in the file.

    The name of a string variable never begins like an item of the file (a time, a value or a keyword),
    because a reader that skips strings takes the name for the next item.
    """
    names = map(identifier, count())
    return [
        next(name for name in names if variable.kind != "string" or name[0] not in MISREAD) for variable in variables
    ]


def real(bits: int) -> str:
    """Return a real, given as its 64 bits, as text for the file: exact, in its shortest form."""
    (value,) = unpack("<d", pack("<q", bits))
    return f"r{value!r}".removesuffix(".0")


def string(text: str) -> str:
    r"""Return text as a string value for the file: one word of ASCII; viewers show \x20 as a space."""
    return "s" + ascii_of(text.translate(ESCAPES))


def _joined(units: NDArray[np.int64], texts: Sequence[str]) -> tuple[NDArray[np.int64], list[str]]:
    """Join all texts that fall into the same time unit, separated by "; ", so that no text is lost.

    Returns:
        The units that have texts, and the text of each.
    """
    import numpy as np

    together: dict[int, str] = {}
    for unit, text in zip(units.tolist(), texts, strict=True):
        together[unit] = f"{together[unit]}; {text}" if unit in together else text
    return np.array(list(together), np.int64), list(together.values())


def _levels(variable: Variable, name: str) -> list[str]:
    """Return a line for each possible level of a wire or a bus, floating first; [] for any other variable."""
    if variable.kind != "wire":
        return []
    if variable.size == 1:
        return [f"{level}{name}\n" for level in "z01"]
    return [f"bz {name}\n", *(f"b{level:b} {name}\n" for level in range(1 << variable.size))]


def _header(variables: Iterable[Variable], names: Iterable[str], timescale: str, comments: Iterable[str]) -> str:
    """Return the header up to $enddefinitions, without a date: the same run produces the same bytes."""
    tree: dict[str, Any] = {}
    for variable, identifier in zip(variables, names, strict=True):
        name = variable.name
        *scopes, last = name.split(".") if "." in name else ("slewline", name)
        level = tree
        for scope in scopes:
            level = level.setdefault(scope, {})
            if not isinstance(level, dict):
                raise UsageError(
                    f"{name!r}: {scope!r} is already the name of a variable in the file; rename one of them"
                )
        if not all(part and part.isascii() and part.isprintable() and " " not in part for part in (*scopes, last)):
            raise UsageError(
                f"{name!r}: not a name for a signal in a VCD file; use printable ASCII without spaces, and dots "
                "between scopes"
            )
        if last in level:
            what = "scope" if isinstance(level[last], dict) else "variable"
            raise UsageError(f"{name!r}: {last!r} is already the name of a {what} in the file; rename one of them")
        level[last] = f"$var {variable.kind} {variable.size} {identifier} {last} $end\n"
    comment_lines = "".join(f"$comment {ascii_of(comment)} $end\n" for comment in comments)
    return f"$timescale {timescale} $end\n$version slewline $end\n{comment_lines}{_scopes(tree)}$enddefinitions $end\n"


def _scopes(tree: dict[str, Any]) -> str:
    return "".join(
        what if isinstance(what, str) else f"$scope module {name} $end\n{_scopes(what)}$upscope $end\n"
        for name, what in tree.items()
    )
