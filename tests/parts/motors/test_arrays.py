"""Text of equations as calls of NumPy that write into arrays that are there."""

from __future__ import annotations

from textwrap import indent

import numpy as np
import pytest

from slewline.parts.motors.arrays import in_place
from slewline.parts.motors.operations import compiled, numpy_names

HEAD = "def many(parameters, state, count):\n    (A, B,) = parameters\n    (x, y,) = state\n"


def looped(body: str) -> str:
    return HEAD + "    while count:\n        count -= 1\n" + indent(body, " " * 8) + "    return (x, y)"


def made(body: str) -> list[str]:
    """Lines of the loop that a body becomes."""
    lines = in_place(looped(body)).splitlines()
    return [line.strip() for line in lines[lines.index("    while count:") + 2 : -1]]


def run(body: str, count: int = 3) -> list[list[float]]:
    """Run a body as it stands, one number at a time, and in place; both must be the same."""
    text = looped(body)
    columns = np.array([0.5, -2.0, 3.0, 0.0]), np.array([1.0, 0.0, -7.5, 4.0])
    names = {"where": lambda condition, yes, no: yes if condition else no, "absolute": abs}
    alone = [compiled(text, names)["many"]((0.3, 2.0), pair, count) for pair in zip(*columns, strict=True)]
    space = compiled(in_place(text), numpy_names())
    found = space["many"]((0.3, np.full(4, 2.0)), columns, count)
    assert np.stack(found, 1).tolist() == [list(pair) for pair in alone]
    return [column.tolist() for column in found]


def test_an_array_whose_value_is_no_longer_needed_is_used_again() -> None:
    assert made("x = x * A + y * y\n") == [
        "multiply(x, c0, x)",
        "multiply(y, y, p0)",
        "add(x, p0, p0)",
        "x, p0 = p0, x",
    ]


def test_what_parameters_alone_give_is_made_before_the_loop() -> None:
    text = in_place(looped("x = x * (-A / B)\n"))
    assert "    c0 = asarray(-A / B)\n" in text[: text.index("while")]


def test_names_that_are_exchanged_exchange_their_arrays() -> None:
    assert made("z = x\nx = y\ny = z\n") == ["x, y = y, x"]
    run("z = x\nx = y\ny = z\n")


def test_one_value_of_two_names_is_copied() -> None:
    assert run("y = x\nif count:\n    y = y + 1.0\n") == [[0.5, -2.0, 3.0, 0.0]] * 2


def test_where_asks_for_the_second_condition_only_where_the_first_may_hold() -> None:
    assert made("x = where((x > A) & (y > B), -x, x)\n") == [
        "greater(x, c0, q0)",
        "if count_nonzero(q0):",
        "greater(y, c1, q1)",
        "bitwise_and(q0, q1, q1)",
        "if count_nonzero(q1):",
        "negative(x, p0)",
        "copyto(x, p0, where=q1)",
    ]


@pytest.mark.parametrize(
    "body",
    [
        "x = where((x > A) & (y < B), 0.5 * x + y, where(y == 0.0, A, x))\n",
        "z = where(x > 0.0, x, y)\ny = where(z > y, y, x)\nx = z * z\n",
        "old = x\nx = x + y\nif count:\n    x = where((x > 1.0) and (y > 1.0), old, x)\n",
        "x = 1.0\ny = y - x\n",
        "big = x > y\nz = x * A\nif count:\n    x = where(big, z, y)\n    y = absolute(z)\n",
        "half = 0.5 * count\nx = x * half\nhalf = half + 1.0\ny = y * half - x\n",
        "z = where(x > 0.0, 0.5 * x, x)\ny = z + x\n",
    ],
)
def test_bits_are_those_of_the_text(body: str) -> None:
    run(body)
