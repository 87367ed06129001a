"""The contents of a waveform file: the edges of signals, in the same form as the recorded edges of a bench.

A logic analyser's recording of a real board is queried like a run of the model, so that the recording
and the run can be overlaid and compared.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn, Protocol

from ...core.messages.near import hint
from ...core.messages.whole import counted
from ...core.motion.axis import Steps
from ...core.time.timebase import Time, moment, picoseconds, readable, window
from ...errors import NotRecorded, UnknownName, UsageError
from ..measuring.compare_edges import inverted
from ..recording.recorder import FLOATING, real_edges
from ..recording.traces import EVER, Trace
from .sampling import Sampling, sampling_of
from .vcd_header import DeclaredVariable, Header
from .vcd_words import MAX_BITS, UNKNOWN

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

EDGES = {"falling": (0,), "rising": (1,), "both": (0, 1)}  # the levels after them
LISTED = 12  # names in a message
CALLED = {  # names of a signal on drivers, and its possible names in a recording
    "step": ("pulse", "clock", "stp", "pul", "clk"),
    "dir": ("direction", "sign", "cw"),
}


class Signal(NamedTuple):
    """One signal: its variable, its level at the start, and its edges: times, (n,) int64 ps, and levels, (n,)."""

    variable: DeclaredVariable
    level: Any
    times_ps: NDArray[np.int64]
    levels: NDArray[Any]


class SignalChanges(Protocol):
    """The result of a reader: the time unit (ps), the first and the last time (in that unit), and the changes."""

    unit: Fraction
    begin: int | None
    end: int

    def series(self) -> Mapping[bytes, tuple[DeclaredVariable, NDArray[np.int64], NDArray[Any]]]:
        """Return, per identifier, the variable, its times, (n,) int64 ps, ascending, and its values, (n,)."""


class Waveforms:
    """The signals of a waveform file, as returned by `slewline.read_vcd` and `slewline.read_waveforms`.

    Names are those in the file, with their scopes: "x.slew".  The last part of a name is enough if only one
    name ends with it.  "x.db" also means x.db0, x.db1 ..., or x.db[0], x.db[1] ..., together, bit 0 being
    the lowest.

    Levels are 0 and 1, or numbers on a bus; FLOATING (-1) for z, UNKNOWN (-2) for x.  A floating wire of a
    bus reads 1, unless all wires of the bus float.  If a VCD file states no value for a wire before its
    first change, that change is taken to be a change from the opposite level.

    Attributes:
        path: the path of the file.
        names: the names of the signals.
        start_ps: the first time in the file, ps.
        stop_ps: the last time in the file, ps.
        timescale_ps: the unit of time in the file, ps.  It may be finer than the sampling period.
    """

    def __init__(self, path: str | Path, header: Header, changes: SignalChanges) -> None:
        self.path = str(path)
        self._unit, self._rate, self._exact = header.unit or changes.unit, header.rate, header.exact
        self.names: tuple[str, ...] = tuple(header.names)
        self.timescale_ps = max(int(self._unit), 1)
        self.start_ps = (changes.begin or 0) * changes.unit // 1
        self.stop_ps = max(changes.end, 0) * changes.unit // 1
        by_identifier = {
            identifier: _signal(variable, times, values, self.start_ps)
            for identifier, (variable, times, values) in changes.series().items()
        }
        self._signals = {name: by_identifier[identifier] for name, identifier in header.names.items()}

    def __contains__(self, name: object) -> bool:
        try:
            return isinstance(name, str) and self._find(name) is not None
        except UnknownName:
            return False

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __getitem__(self, name: object) -> NoReturn:
        raise UsageError(f"waveforms[{name!r}]: waveforms cannot be indexed; write waveforms.edges({name!r})")

    def __len__(self) -> int:
        return len(self.names)

    def __repr__(self) -> str:
        span = f"{readable(self.start_ps)} to {readable(self.stop_ps)}"
        sampled = "" if self.sampling.found == "unit" else f", {str(self.sampling).removeprefix('the ')}"
        units = f"in units of {readable(self.timescale_ps)}{sampled}"
        return f"<Waveforms of {self.path}: {counted(len(self), 'signal')}, {span}, {units}>"

    # ----------------------------------------------------------------------------------------------------- sampling
    @cached_property
    def sampling(self) -> Sampling:
        """The sampling of the file: stated in a comment, else the grid on which all times lie, else the time unit."""
        return sampling_of(self._instants, self._unit, self._rate, self._exact)

    def _instants(self) -> NDArray[np.int64]:
        """Return the instants of the changes of all signals (ps), ascending."""
        import numpy as np

        of = {id(signal): signal.times_ps for signal in self._signals.values()}
        return np.unique(np.concatenate([np.empty(0, np.int64), *of.values()]))

    @property
    def sampling_ps(self) -> int:
        """The longest possible delay of a recorded edge, ps: a sampling period, plus any rounding to units."""
        return self.sampling.resolution_ps

    # ------------------------------------------------------------------------------------------------------ queries
    def kind(self, name: str) -> str:
        """Return the kind of a signal: "bits", "real" or "string".

        Raises:
            UnknownName: there is no such signal.
        """
        return self._find(name).variable.kind

    def width(self, name: str) -> int:
        """Return the number of bits of a signal; 64 for a real, 0 for a string.

        Raises:
            UnknownName: there is no such signal.
        """
        variable = self._find(name).variable
        return {"real": 64, "string": 0}.get(variable.kind, variable.width)

    def edges(
        self, name: str, start: Time | None = None, stop: Time | None = None
    ) -> tuple[NDArray[np.int64], NDArray[Any]]:
        """Return the changes of a signal in start <= t <= stop, as `bench.edges` does.

        The level at the start of the recording is not a change; a signal that is initially unknown changes when it
        becomes known.

        Returns:
            times: (n,) int64, picoseconds, ascending; values: (n,), the value after each change: int8 for a wire,
            int16 for a bus, int64 for a bus of more than 15 bits, float64 for a real, str objects for a string.

        Raises:
            UnknownName: there is no such signal.
            UsageError: the signal has more than 63 bits.
            TimeError: `start` or `stop` is not a time, or `stop` comes before `start`.
        """
        import numpy as np

        signal = self._readable(name)
        times = signal.times_ps
        begin, end = window(start, stop, EVER, since=-EVER)
        first, last = int(np.searchsorted(times, begin)), int(np.searchsorted(times, end, side="right"))
        return times[first:last], signal.levels[first:last]

    def level_at(self, name: str, time: Time) -> Any:
        """Return the value of a signal at an instant, after any change there; after the end, the last value.

        Raises:
            UnknownName: there is no such signal.
            NotRecorded: the instant is before the start of the recording.
            UsageError: the signal has more than 63 bits.
            TimeError: `time` is not a time.
        """
        import numpy as np

        ps = moment(time)
        if ps < self.start_ps:
            raise NotRecorded(f"{name} at {readable(ps)}: {self.path} begins at {readable(self.start_ps)}")
        signal = self._readable(name)
        index = int(np.searchsorted(signal.times_ps, ps, side="right"))
        value = signal.levels[index - 1] if index else signal.level
        return value.item() if isinstance(value, np.generic) else value

    def trace(
        self,
        signal: str,
        name: str | None = None,
        shift: Time = 0,
        *,
        tolerance: Time | None = None,
        invert: bool = False,
    ) -> Trace:
        """Return a signal as a trace for a picture, to be drawn next to the pins of a bench or over one of them.

        Args:
            signal: the name of the signal.
            name: the label in the picture; by default the signal name without scopes.
            shift: a time, possibly negative, that is added to all times to align the trace with another
                recording.
            tolerance: if the trace is drawn over a pin, time differences between the two are marked only if
                they are longer than this; by default `sampling_ps`.
            invert: invert the levels, for a signal measured after an inverting optocoupler.

        Raises:
            UnknownName: there is no such signal.
            UsageError: the signal is a real or a string, or has more than 63 bits, or is a bus that is to be
                inverted.
            TimeError: `shift` or `tolerance` is not a time.
        """
        import numpy as np

        found = self._readable(signal)
        if found.variable.kind != "bits":
            raise UsageError(f"{signal} is a {found.variable.kind} variable, which has no levels; name a wire or bus")
        if invert:
            self._wire(signal)
            found = found._replace(levels=inverted(found.levels), level=inverted(np.array([found.level]))[0])
        levels = np.where(found.levels == UNKNOWN, FLOATING, found.levels).astype(found.levels.dtype)
        name = signal.rpartition(".")[2] if name is None else name
        level, bus = max(int(found.level), FLOATING), found.variable.width > 1
        agrees = self.sampling_ps if tolerance is None else picoseconds(tolerance)
        trace = Trace(name, found.times_ps, levels, level, bus, self.start_ps, self.stop_ps, agrees)
        return trace.shifted(moment(shift, negative=True))

    def steps(
        self,
        pulse: str,
        direction: str | None = None,
        edge: str = "falling",
        *,
        forward: int = 1,
        position: int = 0,
        idle: int | None = None,
    ) -> Steps:
        """Return the steps in a step signal, as a chip's `steps` does, for `slewline.record.measuring.measure`.

        Args:
            pulse: the step signal.
            direction: the direction signal, which is sampled at each step; without it, all steps go forward.
            edge: the edge of `pulse` at which a step begins: "falling", "rising", or "both" for a driver that
                steps on every edge.
            forward: the level of `direction` at which positions count up, 0 or 1.
            position: the position before the first step.
            idle: the level to assume for `pulse` while it floats or is unknown, 0 or 1; by default, it is
                an error if a step may be lost while `pulse` floats or is unknown.

        Raises:
            UnknownName: there is no such signal.
            UsageError: an unknown edge, a signal that is not a wire, a step signal that is unknown where a step
                may begin, or a direction that is unknown at a step.
        """
        import numpy as np

        if edge not in EDGES or forward not in (0, 1):
            edges = ", ".join(map(repr, EDGES))
            raise UsageError(f"edge={edge!r}, forward={forward!r}: allowed: edge {edges}; forward 0, 1")
        if idle not in (None, 0, 1):
            raise UsageError(f"idle={idle!r}: allowed 0, 1 or None")
        found = self._wire(pulse)
        levels = np.append(found.level, found.levels)
        if idle is None:
            self._check_known(pulse, found, EDGES[edge])
        else:
            levels = np.where(levels < 0, idle, levels)
        times = found.times_ps[np.isin(levels[1:], EDGES[edge]) & (levels[:-1] == 1 - levels[1:])]
        signs = np.ones(len(times), np.int8)
        if direction is not None:
            direction_wire = self._wire(direction)
            levels = np.append(direction_wire.level, direction_wire.levels)[
                np.searchsorted(direction_wire.times_ps, times, side="right")
            ]
            if (levels < 0).any():
                at = readable(int(times[np.argmax(levels < 0)]))
                raise UsageError(f"{direction} is floating or unknown at the step at {at}; allowed 0 or 1 at each step")
            signs[levels != forward] = -1
        return Steps(times, signs, position + np.cumsum(signs, dtype=np.int64))

    def _check_known(self, pulse: str, signal: Signal, begins: tuple[int, ...]) -> None:
        """Check that a step signal is at 0 or 1 wherever a step might otherwise be missed.

        The signal must be at 0 or 1 from the first edge on.  If that edge leads to a level at which a step
        begins, the level before the edge must be known too.

        Raises:
            UsageError: the signal floats or is unknown there.
        """
        import numpy as np

        lost = np.flatnonzero(signal.levels < 0)
        if signal.level < 0 and len(signal.levels) and signal.levels[0] in begins:
            lost = np.append(0, lost)
        if len(lost):
            at = readable(int(signal.times_ps[lost[0]]))
            raise UsageError(
                f"{pulse} is floating or unknown {'before' if signal.levels[lost[0]] >= 0 else 'from'} {at}, so a step "
                f"may be missed; give the level of {pulse} there: steps(..., idle=0) or idle=1"
            )

    # --------------------------------------------------------------------------------------------------- by its name
    def _wire(self, name: str) -> Signal:
        found = self._readable(name)
        if found.variable.kind != "bits":
            raise UsageError(f"{name} is a {found.variable.kind} variable, which has no levels; name a wire")
        if found.variable.width != 1:
            raise UsageError(f"{name} has {self.width(name)} bits; name one of them, such as {name}0")
        return found

    def _readable(self, name: str) -> Signal:
        found = self._find(name)
        if found.variable.kind == "bits" and found.variable.width > MAX_BITS:
            width = found.variable.width
            raise UsageError(f"{name} has {width} bits; allowed up to {MAX_BITS}; record it as several buses")
        return found

    def _find(self, name: str) -> Signal:
        signal = self._signals.get(name)
        if signal is not None:
            return signal
        ends = [known for known in self.names if known.endswith("." + name)]
        if len({id(self._signals[end]) for end in ends}) == 1:
            return self._signals[ends[0]]
        if len(ends) > 1:
            raise UnknownName(
                f"{self.path}: {name!r} matches the end of several names: {_listed(ends)}; give the whole name"
            )
        bits = self._bits(name)
        if not bits:
            last = [known.rpartition(".")[2] for known in self.names]
            called = [known for known in CALLED.get(name.lower(), ()) if known in map(str.lower, last)]
            near = f"; did you mean {called[0]}?" if called else hint(name, self.names) or hint(name, last)
            raise UnknownName(f"{self.path}: no signal {name!r}; available: {_listed(self.names)}{near}")
        self._signals[name] = joined = _joined(bits)
        return joined

    def _bits(self, name: str) -> list[Signal]:
        """Return the signals that are the bits of a bus, lowest bit first; [] if there is no such bus."""
        for form in ("{}{}", "{}[{}]"):
            bits: list[Signal] = []
            while len(bits) <= MAX_BITS and (bit := self._bit(form.format(name, len(bits)))) is not None:
                bits.append(bit)
            if 1 < len(bits) <= MAX_BITS:
                return bits
        return []

    def _bit(self, name: str) -> Signal | None:
        ends = [name] if name in self._signals else [known for known in self.names if known.endswith("." + name)]
        signal = self._signals[ends[0]] if len(ends) == 1 else None
        return signal if signal is not None and signal.variable == DeclaredVariable("bits", 1) else None


def _signal(variable: DeclaredVariable, times: NDArray[np.int64], values: NDArray[Any], start: int) -> Signal:
    import numpy as np

    first = int(np.searchsorted(times, start, side="right"))
    level: Any = values[first - 1] if first else {"bits": UNKNOWN, "real": np.nan, "string": ""}[variable.kind]
    if variable.kind == "bits":
        if not first and variable.width == 1 and len(values) and values[0] >= 0:
            level = 1 - int(values[0])  # a signal that changes later had a level before
        width = variable.width
        values = values.astype(np.int8 if width == 1 else np.int16 if width < 16 else np.int64, copy=False)
    return Signal(variable, level, *real_edges(times[first:], values[first:], level))


def _joined(bits: list[Signal]) -> Signal:
    """Return bits, lowest first, as one bus: UNKNOWN while any bit is unknown, FLOATING while all bits float."""
    import numpy as np

    times = np.unique(np.concatenate([bit.times_ps for bit in bits]))
    dtype: Any = np.int16 if len(bits) < 16 else np.int64
    levels = np.zeros(len(times) + 1, dtype)
    unknown, driven = np.zeros((2, len(times) + 1), np.bool_)
    for number, bit in enumerate(bits):
        wire = np.append(bit.level, bit.levels)[np.append(0, np.searchsorted(bit.times_ps, times, side="right"))]
        levels |= (wire & 1).astype(dtype) << number  # a bit that floats reads 1
        unknown |= wire == UNKNOWN
        driven |= wire >= 0
    levels[~driven] = FLOATING
    levels[unknown] = UNKNOWN
    return Signal(DeclaredVariable("bits", len(bits)), levels[0], *real_edges(times, levels[1:], int(levels[0])))


def _listed(names: tuple[str, ...] | list[str]) -> str:
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return ", ".join(names[:LISTED]) + more
