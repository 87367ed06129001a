"""Integrators made from equations: classical Runge-Kutta, on a fixed grid that restarts at each input edge.

    input edges      |                    |
    grid points      0    h    2h    3h   0    h    2h    3h    ...
                                  ^
                                  a state here is one short step from the preceding grid point

Queries and earlier integration have no influence, so a state is bit-identical for any order of queries.
Plain Python and Numba agree, since they run the same lines: sums, products, square roots and
comparisons, in the same order.  Sine and cosine are computed from these operations, too, because library
functions differ in the last bit between machines.

Whether a driver switches, or friction holds the shaft, is decided at a grid point as if the step after
it had its full length, even if an input edge shortens that step.  Once nothing changes any more, the
motor is at rest until the next edge, and takes no computing time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from .equations import Equations
from .operations import PYTHON, compiled, machine_code

# sqrt(2) sin(pi f / 2) / f as a polynomial of f squared, for f up to 1/2, to 5e-12; two doublings make it the angle.
# They keep s s + c c = 1 for any value, so the short polynomial adds no energy.
SINE = (2.2214414690690765, -0.9135311855141165, 0.1127023300627348, -0.00662030226852122, 0.00022372161964259173)
ANGLE = f"""\
turn = TURNS * theta + ZERO
turn = turn - nearest(turn)
square = turn * turn
root = turn * ({SINE[0]!r} + square * ({SINE[1]!r} + square * ({SINE[2]!r} + square * ({SINE[3]!r}
    + square * {SINE[4]!r}))))
square = root * root
half_sine = root * sqrt(2.0 - square)
twice = half_sine + half_sine
s = twice * (1.0 - square)
c = 1.0 - twice * half_sine"""
PS = "1e-12"


@dataclass(frozen=True)
class Model:
    """Equations of one system, in the order of their evaluation.

    `parameters` are the names in capitals in the equations; `rows` is the number of
    set points (r1, r2 ...) in each row of the driver's table.
    """

    pieces: tuple[Equations, ...]
    parameters: tuple[str, ...]
    rows: int

    @cached_property
    def states(self) -> tuple[str, ...]:
        """Names of the integrated states, position and speed of the rotor first."""
        names = [state for piece in self.pieces for state in piece.states]
        return tuple(
            sorted(names, key=lambda name: ("theta", "omega").index(name) if name in ("theta", "omega") else 2)
        )

    @cached_property
    def kept(self) -> tuple[str, ...]:
        """Names of the values kept from one grid point to the next."""
        return tuple(name for piece in self.pieces for name in piece.kept)

    @property
    def whole(self) -> tuple[str, ...]:
        """Names of all state variables: first the integrated states, then the kept values."""
        return self.states + self.kept

    # ------------------------------------------------------------------------------------------------------- the lines
    def _of(self, what: str) -> list[str]:
        lines = []
        for piece in self.pieces:
            lines += getattr(piece, what).splitlines()
        return lines

    @property
    def _decided(self) -> list[str]:
        """Lines that make the decisions at a grid point and compute the rates of change there."""
        return [
            *self._of("begin"), *ANGLE.splitlines(), *self._of("torque"), *self._of("decide"), *self._of("fixed"),
            *self._of("rates"),
        ]  # fmt: skip

    @property
    def _before(self) -> list[str]:
        """Lines that save each integrated state before a step under its name with a 0, such as `omega0`."""
        return [f"{name}0 = {name}" for name in self.states]

    @property
    def _kept_names(self) -> tuple[str, ...]:
        """Names of the kept values that are constant at rest: all except the values assigned in `begin`."""
        given = [line.split(" = ")[0] for line in self._of("begin")]
        return tuple(name for name in self.kept if name not in given)

    @property
    def _rest(self) -> str:
        """Source text of the condition for rest; the load's conditions come first, because they are seldom true."""
        conditions = [condition for piece in reversed(self.pieces) for condition in piece.rest]
        return " and ".join(f"({condition})" for condition in conditions) or "False"

    @property
    def _step(self) -> list[str]:
        """Lines of code that compute the state `dt` seconds after a grid point from the state and rates there."""
        lines = ["half = 0.5 * dt"]
        rates = [*ANGLE.splitlines(), *self._of("torque"), *self._of("rates")]
        for number, length in ((1, "half"), (2, "half"), (3, "dt")):
            lines += [f"k{number}_{name} = d_{name}" for name in self.states]
            lines += [f"{name} = {name}0 + {length} * d_{name}" for name in self.states]
            lines += rates
        lines.append("sixth = dt / 6.0")
        lines += [
            f"{name} = {name}0 + sixth * (k1_{name} + 2.0 * (k2_{name} + k3_{name}) + d_{name})" for name in self.states
        ]
        return lines + self._of("settle")

    @property
    def _given(self) -> list[str]:
        """Lines that assign the parameters, the state and the set points to their names."""
        return [
            f"({', '.join(self.parameters)},) = parameters",
            f"({', '.join(self.whole)},) = state",
            *(f"r{n + 1} = table[code][{n}]" for n in range(self.rows)),
        ]

    @property
    def _edge(self) -> list[str]:
        """Lines of code that, at an edge of the inputs, load the new set points and apply the edge's effects."""
        numbers = range(1, self.rows + 1)
        old = [f"o{n} = r{n}" for n in numbers if f"o{n}" in "\n".join(self._of("edge"))]
        return [*old, "code = codes[edge]", *(f"r{n} = table[code][{n - 1}]" for n in numbers), *self._of("edge")]

    def advance(self, emit: Sequence[str], begin: Sequence[str], give: str) -> str:
        """Return the source text of the function `advance`, which computes the grid points up to an instant `stop`.

        Args:
            emit: lines that store a grid point.
            begin: lines before the first grid point.
            give: the line that returns the result.
        """
        return "\n".join(
            [
                "def advance(parameters, table, t, state, code, command, times, codes, commands, stop, most, limit,"
                " room):",
                *indented(1, self._given, begin, ["count = edge = 0", "edges = len(times)", "rests = False"]),
                *indented(1, ["while count < most:"]),
                *indented(2, [f"{name}_ = {name}" for name in self._kept_names], self._before, self._decided),
                *indented(2, [f"if {self._rest}:"]),
                *indented(3, [f"{name} = {name}_" for name in self._kept_names]),
                *indented(3, ["if edge == edges or times[edge] > stop:"]),
                *indented(4, ["rests = True", "break"]),
                *indented(3, ["t = times[edge]", "hit = True"]),
                *indented(2, ["else:"]),
                *indented(3, ["following = t + STEP_PS", "hit = edge < edges and times[edge] <= following"]),
                *indented(3, ["if hit:"]),
                *indented(4, ["following = times[edge]"]),
                *indented(3, ["if following > stop:"]),
                *indented(4, ["break"]),
                *indented(3, [f"dt = (following - t) * {PS}"], self._step, ["t = following"]),
                *indented(2, ["if hit:"]),
                *indented(3, self._edge, ["command = commands[edge]", "edge += 1"]),
                *indented(2, emit, ["count += 1"]),
                *indented(2, ["if absolute(command * STEPS_COMMAND - theta * STEPS_RAD) > limit:"]),
                *indented(3, ["break"]),
                *indented(1, [give]),
            ]
        )

    @property
    def after(self) -> str:
        """Source text of the function `after`, which computes the state `span` ps after a grid point.

        That instant must not be later than the next grid point.
        """
        saved = [f"{name}_ = {name}" for name in self._kept_names]
        marks = dict.fromkeys(self.states, "0") | dict.fromkeys(self._kept_names, "_")
        same = f"({', '.join(name + marks.get(name, '') for name in self.whole)},)"
        return "\n".join(
            [
                "def after(parameters, table, t, state, code, span):",
                *indented(1, self._given, saved, self._before, self._decided, [f"if {self._rest}:"]),
                *indented(2, [f"return {same}"]),
                *indented(1, [f"dt = span * {PS}"], self._step, [f"return ({', '.join(self.whole)},)"]),
            ]
        )

    # -------------------------------------------------------------------------------------------------------- engines
    @cached_property
    def python(self) -> Engine:
        """The functions of the model in plain Python."""
        row = ", ".join(["t", "command", "code", *self.whole])
        text = self.advance([f"points.append(({row}))"], ["points = []"], "return points, rests")
        return Engine(compiled("\n".join((self.after, CROSSING, text)), PYTHON))

    @property
    def is_compiled(self) -> bool:
        """True if the functions compiled by Numba have been used."""
        return "numba" in vars(self)

    @cached_property
    def numba(self) -> Engine:
        """The functions of the model, compiled by Numba.

        Raises:
            ImportError: Numba is not installed.
        """
        emit = ["room[0][count] = t", "room[1][count] = command", "room[2][count] = code"]
        emit += [f"room[3][count, {n}] = {name}" for n, name in enumerate(self.whole)]
        return Engine(machine_code((self.after, CROSSING, self.advance(emit, [], "return count, rests"))))


# The first picosecond, between two grid points, at which a position has passed a bound.  Newton's rule from the
# secant of both ends; where it leaves the interval, the interval is halved.
CROSSING = """\
def crossing(parameters, table, t, state, code, low, span, which, factor, bound, rising):
    high = span
    below = state[which] * factor - bound
    above = after(parameters, table, t, state, code, span)[which] * factor - bound
    guess = low + (high - low) // 2
    if above != below:
        guess = int(below / (below - above) * span)
    if guess < low:
        guess = low + (high - low) // 2
    while high - low > 1:
        if guess <= low or guess >= high:
            guess = low + (high - low) // 2
        there = after(parameters, table, t, state, code, guess)
        here = there[which] * factor - bound
        passed = here >= 0.0
        if passed == rising:
            high = guess
        else:
            low = guess
        rate = there[which + 1] * factor * 1e-12
        if rate == 0.0 or absolute(here) > absolute(rate) * span:
            guess = low
        else:
            guess = int(floor(guess - here / rate)) + (passed != rising)
            if guess == high:
                guess = high - 1
            elif guess == low:
                guess = low + 1
    return high
"""


@dataclass(frozen=True)
class Engine:
    """The functions of a model, by name, in plain Python or compiled: `advance`, `after` and `crossing`."""

    functions: dict[str, Callable[..., Any]]

    @property
    def after(self) -> Callable[..., Any]:
        """Function that computes the state a given time after a grid point."""
        return self.functions["after"]

    @property
    def crossing(self) -> Callable[..., Any]:
        """Function that computes the time (ps) from a grid point until a position crosses a bound."""
        return self.functions["crossing"]

    @property
    def advance(self) -> Callable[..., Any]:
        """Function that computes the grid points from a given grid point up to an instant."""
        return self.functions["advance"]


def indented(depth: int, *lines: Iterable[str]) -> list[str]:
    """Return all lines of the given sequences as one list, indented by `depth` more levels."""
    return ["    " * depth + line for some in lines for line in some]
