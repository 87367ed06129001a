"""The quantities of a stepper over time, for pictures and queries: curves through the points of its run."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ...core.motion.history import Polyline
from ..motors.integration import Point

if TYPE_CHECKING:
    from ...core.time.kernel import Kernel
    from ..motors.law import MotorLaw
    from .motor_run import Run


def curve(kernel: Kernel, run: Run, name: str, unit: str, of: Callable[[MotorLaw, tuple[Any, ...]], Any]) -> Polyline:
    """Return the quantity that `of` computes from a law and its points (times, states, commands, codes)."""
    import numpy as np

    def changes(start: int, stop: int) -> tuple[Any, Any]:
        found, before = [], run.at_or_before(max(start, 0))
        for part in run.between(start, stop):
            found.append((part.law, with_jumps(part.law, before, part.columns)))
            before = Point(*(column[-1] for column in part.columns))
        times = [columns[0] for _, columns in found]
        values = [of(law, columns) for law, columns in found]
        return np.concatenate([np.empty(0, np.int64), *times]), np.concatenate([np.empty(0), *values])

    def at(times: Any) -> Any:
        values = []
        for ps in times.tolist():
            point, law = run.at_or_before(ps), run.stretch_at(ps).law
            columns = np.array([ps]), np.array([run.state(ps)]), np.array([point.command]), np.array([point.code])
            values.append(of(law, columns)[0])
        return np.array(values)

    return Polyline(kernel, name, unit, at, changes)


def current_of(name: str, law: MotorLaw, points: tuple[Any, ...]) -> Any:
    """Return the current with the given name at some grid points, A: (n,) float64."""
    return points[1][:, law.names.index(name)]


def with_jumps(law: MotorLaw, before: Point, columns: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the points of a curve, with two points at each input edge: before and after the edge.

    The point before the edge has the old command and table row, and the point after it has the new ones.
    `before` is the point that precedes the points in `columns`.
    """
    import numpy as np

    times, states, commands, codes = columns
    earlier, asked = np.append(before.command, commands[:-1]), np.append(before.code, codes[:-1])
    at = np.flatnonzero((commands != earlier) | (codes != asked))
    whole = states[at]
    if len(before.state) == states.shape[1]:
        kept_columns = [law.names.index(name) for name in law.model.kept]
        whole[:, kept_columns] = np.vstack([before.state, states[:-1]])[at][:, kept_columns]
    return (
        np.insert(times, at, times[at]),
        np.insert(states, at, whole, axis=0),
        np.insert(commands, at, earlier[at]),
        np.insert(codes, at, asked[at]),
    )
