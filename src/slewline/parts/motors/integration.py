"""Integration of a motor's equations at grid points, in plain Python until compiling them saves time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Protocol

from ...core.messages.near import hint
from ...errors import UnknownName, UsageError
from ...extras import needs
from .integrator import Engine

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .integrator import Model

CHUNK = 1 << 12  # maximum number of grid points that plain Python computes per call
ROOM = 1 << 17  # the same for Numba
SOON = 20_000  # steps in plain Python that take less time than compiling by Numba


class Integrable(Protocol):
    """Protocol of a system that can be integrated: a `MotorLaw` (law.py)."""

    @property
    def model(self) -> Model:
        """The equations of the system."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the state variables."""

    @property
    def parameters(self) -> tuple[Any, ...]:
        """Values of the parameters that `model.parameters` names, in the same order."""

    @property
    def table(self) -> tuple[tuple[float, ...], ...]:
        """The driver's set points, row by row."""

    @property
    def rows(self) -> NDArray[np.float64]:
        """The driver's set points as an array: (rows, windings) float64."""

    @property
    def step_ps(self) -> int:
        """The grid step, ps."""

    @property
    def step(self) -> float:
        """The angle of a full step, rad."""

    @property
    def micro(self) -> int:
        """Number of commands per full step."""

    @property
    def period(self) -> int:
        """Number of full steps per electrical turn."""


@dataclass(frozen=True, slots=True)
class MotorTrace:
    """The motion of a motor at the grid points of an integration; `trace["theta"]` returns a state variable by name.

    Attributes:
        law: the `MotorLaw` that was integrated.
        times: the grid points, (n,) int64 ps, ascending.
        states: the state variables, (n, k) float64, with one column for each of `law.names`.
        commands: the command in force from each grid point, (n,) int64.
        codes: the table row in force from each grid point, (n,) int64.
        rests: True if nothing changes after the last grid point.
    """

    law: Integrable
    times: NDArray[np.int64]
    states: NDArray[np.float64]
    commands: NDArray[np.int64]
    codes: NDArray[np.int64]
    rests: bool

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Return the state variable with the given name at all grid points, (n,) float64.

        Raises:
            UnknownName: the law has no such state.
        """
        if name not in self.law.names:
            raise UnknownName(f"no state {name!r}; known: {', '.join(self.law.names)}{hint(name, self.law.names)}")
        column: NDArray[np.float64] = self.states[:, self.law.names.index(name)]
        return column

    @property
    def lag(self) -> NDArray[np.float64]:
        """The lag of the rotor relative to its command at each grid point, in full steps: (n,) float64."""
        lag: NDArray[np.float64] = self.commands / self.law.micro - self["theta"] / self.law.step
        return lag

    @property
    def worst(self) -> float:
        """The greatest distance between the rotor and its command at any grid point, in full steps."""
        import numpy as np

        return float(np.abs(self.lag).max())

    @property
    def lost(self) -> int:
        """Full steps lost by the last grid point; positive if the rotor lags, negative if it leads."""
        return round(float(self.lag[-1]) / self.law.period) * self.law.period


@dataclass(frozen=True, slots=True)
class Point:
    """A grid point: its instant (ps), the state there, and the command and table row in force from then on."""

    t: int
    state: tuple[float, ...]
    command: int
    code: int


class Integration:
    """Integrator of a motor's equations, first in plain Python, then compiled as soon as that saves time.

    The results of plain Python and compiled code are bit-identical.
    """

    def __init__(self, law: Integrable, engine: str | None = None) -> None:
        if engine not in (None, "python", "numba"):
            raise UsageError(f"engine {engine!r}; allowed python, numba, None")
        self.law, self.named = law, engine
        self.made = 0  # grid points so far

    @property
    def engine(self) -> Engine:
        """The engine to use now: set by the user, or else chosen by the number of grid points computed so far."""
        model = self.law.model
        if self.named is None and numba_is_there() and (model.is_compiled or self.made >= SOON):
            return model.numba
        if self.named != "numba":
            return model.python
        if not numba_is_there():
            raise UsageError(needs("engine 'numba' needs", "fast"))
        return model.numba

    def trace(
        self,
        times: NDArray[np.int64],
        commands: NDArray[np.int64],
        codes: NDArray[np.int64],
        stop: int,
        point: Point,
        limit: float = float("inf"),
    ) -> MotorTrace:
        """Return the motion at `point` and the grid points up to `stop` (ps), or until the lag exceeds `limit`."""
        import numpy as np

        parts: list[tuple[Any, ...]] = []
        rests, full, before, edge = False, True, point, 0
        while full and not rests:
            full, rests, found = self._advance(before, times[edge:], commands[edge:], codes[edge:], stop, limit)
            parts.append(found if not parts else tuple(column[1:] for column in found))
            t, command, code = (int(column[-1]) for column in found[:3])
            before = Point(t, tuple(found[3][-1].tolist()), command, code)
            edge = int(np.searchsorted(times, t, "right"))
        columns = parts[0] if len(parts) == 1 else [np.concatenate(column) for column in zip(*parts, strict=True)]
        return MotorTrace(self.law, columns[0], columns[3], columns[1], columns[2], rests)

    def _advance(
        self, point: Point, times: Any, commands: Any, codes: Any, stop: int, limit: float
    ) -> tuple[bool, bool, tuple[Any, ...]]:
        """Return whether more grid points may follow, whether the motor is at rest, and the next points as columns.

        The columns are instants, commands, codes and states; their first row is `point`.  If Numba computed
        them, they may be views of larger arrays.
        """
        import numpy as np

        law, engine = self.law, self.engine
        first = point.t, point.command, point.code
        if engine is law.model.python:
            given = [column[:CHUNK].tolist() for column in (times, codes, commands)]
            points, rests = engine.advance(
                law.parameters, law.table, point.t, point.state, point.code, point.command, *given, stop, CHUNK, limit,
                None,
            )  # fmt: skip
            self.made += len(points)
            points.insert(0, (*first, *point.state))
            ints = (np.array([row[n] for row in points], np.int64) for n in range(3))
            return len(points) > CHUNK, rests, (*ints, np.array([row[3:] for row in points], np.float64))
        edges = int(np.searchsorted(times, stop, "right"))
        most = max(1, min(ROOM, (stop - point.t) // law.step_ps + edges + 1))
        size = most + 1
        room = (
            np.empty(size, np.int64), np.empty(size, np.int64), np.empty(size, np.int64),
            np.empty((size, len(law.names))),
        )  # fmt: skip
        room[0][0], room[1][0], room[2][0], room[3][0] = *first, point.state
        count, rests = engine.advance(
            law.parameters, law.rows, point.t, point.state, point.code, point.command, times, codes, commands,
            stop, most, limit, tuple(column[1:] for column in room),
        )  # fmt: skip
        self.made += count
        found = tuple(column[: count + 1] for column in room)
        return count == most == ROOM, rests, found if 2 * count > most else tuple(column.copy() for column in found)


@lru_cache(maxsize=1)
def numba_is_there() -> bool:
    """Return whether Numba is installed."""
    from importlib.util import find_spec

    return find_spec("numba") is not None
