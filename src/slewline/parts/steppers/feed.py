"""Inputs of a motor over time: the commanded position, and the set points that the pins select.

    pieces      |------------------|---------|------------------------->
                 past pin levels               pin promises

The law of a motor has a table of set points, and the pins determine which row applies.  Only changes of
the commanded position or of the row are edges.

A piece is the state of the pins from an instant until the level or promise of one of them is replaced.
Promises are values, so the past can be queried again, and a long slew takes no computing time.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from ...core.time.events import earliest
from ...core.wires.wave import Level, Promise, alike, promised

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ..motors.law import MotorLaw


class Edges(NamedTuple):
    """Edges of the inputs: instants (ps), and the commands and table rows after them, (n,) int64 each."""

    times: NDArray[np.int64]
    commands: NDArray[np.int64]
    codes: NDArray[np.int64]


class Piece(NamedTuple):
    """State of the pins after an instant (ps): for each pin, in order, a promise or a constant level."""

    since: int
    shown: Sequence[Promise | Level]

    def levels(self, ps: int) -> list[Level]:
        """Return the levels at an instant (ps)."""
        return [what.level(ps) if promised(what) else what for what in self.shown]

    def look_after(self, ps: int) -> int | None:
        """Return the instant of the first edge of any pin after the instant `ps`; None if none is foreseen.

        If a promise has not found its next edge yet, the result may instead be the instant (ps) at which to
        search again.
        """
        return earliest([what.after(ps) for what in self.shown if promised(what)])

    @property
    def until(self) -> int | None:
        """The instant (ps) before which all promises of the piece hold, or None if they hold forever."""
        return min((what.until for what in self.shown if promised(what) and what.until is not None), default=None)


class Reading(NamedTuple):
    """The levels of the pins over a stretch of time: at its start, and at each instant at which a pin has an edge.

    `high` is (n + 1, pins) bool; the first row contains the levels before the first instant.
    """

    times: NDArray[np.int64]
    high: NDArray[np.bool_]


Asked = Callable[[Reading, int], tuple[Any, Any]]  # from the previous command: commands and codes, one per instant


class Feed:
    """Inputs of a motor.

    Args:
        asked: a function that converts pin levels to commands and table rows.
    """

    def __init__(self, asked: Asked) -> None:
        self.asked = asked
        self.pieces = [Piece(0, ())]  # nothing is wired yet

    def show(self, since: int, shown: Sequence[Promise | Level]) -> None:
        """Use a new state of the pins from an instant (ps) on."""
        if len(shown) == len(self.now.shown) and all(map(alike, shown, self.now.shown)):
            return
        if self.now.since >= since or not self.now.shown:
            self.pieces.pop()
        self.pieces.append(Piece(since, shown))

    @property
    def now(self) -> Piece:
        """Present state of the pins; empty before they are wired."""
        return self.pieces[-1] if self.pieces else Piece(0, ())

    def edges(self, start: int, stop: int, command: int, code: int) -> Edges:
        """Return the edges at start < t <= stop (ps), given the command and the table row (`code`) at `start`."""
        import numpy as np

        found = []
        for reading in self._readings(start, stop):
            commands, codes = self.asked(reading, command)
            changed = changes(commands, command) | changes(codes, code)
            if changed.any():
                found.append((reading.times[changed], commands[changed], codes[changed]))
                command, code = int(commands[-1]), int(codes[-1])
        if not found:
            return Edges(*(np.empty(0, np.int64) for _ in range(3)))
        return Edges(*(np.concatenate(column) for column in zip(*found, strict=True)))

    def _readings(self, start: int, stop: int) -> list[Reading]:
        """Return the levels of the pins at start < t <= stop, piece by piece."""
        first = max(bisect_right(self.pieces, start, key=lambda piece: piece.since) - 1, 0)
        readings = []
        for n in range(first, len(self.pieces)):
            piece = self.pieces[n]
            if piece.since > stop or not piece.shown:
                break
            end = min(stop, self.pieces[n + 1].since - 1) if n + 1 < len(self.pieces) else stop
            if n > first or piece.since > start:  # the levels before it are those of the preceding piece
                before = self.pieces[n - 1].levels(piece.since - 1) if n else piece.levels(piece.since)
                readings.append(reading(piece, piece.since - 1, end, before))
            elif end > start:
                readings.append(reading(piece, start, end, piece.levels(start)))
        return readings

    def forget(self, before: int) -> None:
        """Drop the past before an instant (ps)."""
        del self.pieces[: max(bisect_right(self.pieces, before, key=lambda piece: piece.since) - 1, 0)]


def changes(values: Any, before: int) -> Any:
    """Return which values differ from their predecessors: (n,) bool; `before` precedes the first value."""
    import numpy as np

    differ = np.empty(len(values), bool)
    differ[:1] = values[:1] != before
    np.not_equal(values[1:], values[:-1], out=differ[1:])
    return differ


def reading(piece: Piece, start: int, stop: int, before: Sequence[Level]) -> Reading:
    """Return the pin levels at start < t <= stop, preceded by the levels `before`; an open pin reads high."""
    import numpy as np

    edges: list[tuple[Any, Any]] = []
    for what, level in zip(piece.shown, before, strict=True):
        here = what.level(start + 1) if promised(what) else what
        times, levels = what.edges(start, stop) if promised(what) else ((), ())
        times, levels = np.asarray(times, np.int64), high_of(levels)
        if (here != 0) != (level != 0) and not (len(times) and times[0] == start + 1):
            times, levels = np.append(start + 1, times), np.append(here != 0, levels)
        edges.append((times, levels))
    changing = [times for times, _ in edges if len(times)]
    if not changing:
        times = np.empty(0, np.int64)
    else:
        times = changing[0] if len(changing) == 1 else np.unique(np.concatenate(changing))
    high = np.empty((len(times) + 1, len(edges)), bool)
    for n, ((own, levels), level) in enumerate(zip(edges, before, strict=True)):
        if not len(own):
            high[:, n] = level != 0
        elif own is times:
            high[0, n], high[1:, n] = level != 0, levels
        else:
            high[:, n] = np.append(level != 0, levels)[np.append(0, np.searchsorted(own, times, side="right"))]
    return Reading(times, high)


def high_of(levels: Any) -> NDArray[np.bool_]:
    """Return which edge levels (0, 1 or None) read high: (n,) bool."""
    import numpy as np

    if isinstance(levels, np.ndarray):
        found: NDArray[np.bool_] = levels != 0
        return found
    return np.array([level != 0 for level in levels], bool)


# ------------------------------------------------------------------------------------------------ commands from pins
@dataclass(frozen=True)
class Pins:
    """The column of each pin in a reading, and the active level of the pin; a pin that is not read is missing."""

    columns: Mapping[str, tuple[int, bool]]

    def __call__(self, reading: Reading, name: str, otherwise: bool) -> Any:
        """Return whether a pin is active in each row of a reading, (n + 1,) bool; `otherwise` if it is not read."""
        import numpy as np

        found = self.columns.get(name)
        if found is None:
            return np.full(len(reading.high), otherwise)
        column, active = found
        return reading.high[:, column] == active

    def level(self, reading: Reading) -> Any:
        """Return the motor current level that MOV, RAMP and ENABLE select, as an index into the law's `LEVELS`.

        The result is (n,) int64; or the int 0 ("slew") for a motor without MOV that is enabled throughout.
        """
        import numpy as np

        enabled = self(reading, "enable", True)[1:]
        if "mov" not in self.columns and enabled.all():
            return 0
        moving, ramping = self(reading, "mov", True)[1:], self(reading, "ramp", False)[1:]
        return np.where(enabled, np.where(ramping, 1, np.where(moving, 0, 2)), 3).astype(np.int64)


def steps_asked(law: MotorLaw, pins: Pins) -> Asked:
    """Return a function that converts PULSE and DIRECTION to commands; each step adds or subtracts 1."""

    def asked(reading: Reading, command: int) -> tuple[Any, Any]:
        import numpy as np

        pulse, forward = pins(reading, "pulse", True), pins(reading, "direction", True)[1:]
        steps = (pulse[1:] & ~pulse[:-1]) * np.where(forward, 1, -1)
        commands = command + np.cumsum(steps)
        return commands, commands % law.cycle + law.cycle * pins.level(reading)

    return asked


def phases_asked(law: MotorLaw, pins: Pins, names: Sequence[str], fields: Sequence[int | None]) -> Asked:
    """Return a function that converts the levels of phase pins to commands.

    The phases that are on determine the field of the motor: a command from 0 to `law.cycle - 1`.  Since the
    field repeats every `law.cycle` commands, the new command is the one with this field that is nearest to
    the present command.  If the phases have no field, or if two commands are equally near, the command is
    unchanged.

    Args:
        names: the names of the phase pins.
        fields: the field for each combination of phases that are on, or None for no field.  The index of a
            combination is the sum of 1 for the first phase, 2 for the second, 4 for the third ...; it is
            also the row of the table, before the current level is included.
    """

    def asked(reading: Reading, command: int) -> tuple[Any, Any]:
        import numpy as np

        number = np.zeros(len(reading.high) - 1, np.int64)
        for n, name in enumerate(names):
            number |= pins(reading, name, False)[1:].astype(np.int64) << n
        codes = number + len(fields) * pins.level(reading)
        commands = np.empty(len(number), np.int64)
        half = law.cycle // 2
        for n, bits in enumerate(number.tolist()):
            field = fields[bits]
            turn = 0 if field is None else (field - command + half) % law.cycle - half
            command += turn if turn != -half else 0  # unchanged if opposite: both directions are equally near
            commands[n] = command
        return commands, codes

    return asked
