"""Perturbations: what each row changes, what a text means, and in which ways a candidate is judged."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from slewline.errors import UnknownName, UsageError
from slewline.parts.motors.motor_data import DriverData, LoadData
from slewline.tuning.perturbations import NOMINAL, USUAL, alone, read_perturbations, scenarios

from .stand_in import DRIVER, LOAD, MOTOR

SYSTEM = MOTOR, DRIVER, LOAD


def test_each_row_changes_what_it_names() -> None:
    def of(what: str, percent: float, driver: DriverData = DRIVER, load: LoadData = LOAD) -> Any:
        return alone(what, percent).of((MOTOR, driver, load))

    assert of("load", 20) == (MOTOR, DRIVER, replace(LOAD, torque=0.03 * 1.2))
    motor, driver, load = of("inertia", -20)
    assert (motor.inertia, driver, load.inertia) == (6.8e-6 * 0.8, DRIVER, 6.8e-6 * 0.8)
    assert of("supply", -10)[1] == replace(DRIVER, supply=24 * 0.9)
    two = DriverData(kind="bilevel", supply=5.0, high=40.0, high_time=2e-3)
    assert of("supply", -10, two)[1] == replace(two, supply=5 * 0.9, high=40 * 0.9)
    assert of("current", -20)[1] == replace(DRIVER, current=0.8)
    motor, _, load = of("friction", 25, load=replace(LOAD, stiction=8e-3))
    assert (motor.friction, load.friction, load.stiction) == (1.25e-3, 6.25e-3, 10e-3)
    motor, _, load = of("drag", -30, load=replace(LOAD, viscous=1e-4))
    assert motor.drag == pytest.approx(MOTOR.drag * 0.7) and load.viscous == pytest.approx(0.7e-4)


def test_where_resistors_set_the_current_they_change() -> None:
    driver = DriverData(kind="voltage", supply=20, series=15)
    _, changed, _ = alone("current", -20).of((MOTOR, driver, LOAD))
    assert 20 / (changed.series + 5) == pytest.approx(0.8 * 20 / 20)


@pytest.mark.parametrize(("text", "names"), [
    ("none", ["nominal"]),
    ("load 20%", ["load +20 %", "load -20 %", "nominal"]),
    ("supply -10 %", ["supply -10 %", "nominal"]),
    ("load ±5%", ["load +5 %", "load -5 %", "nominal"]),
    ("load +20%, supply -10%", ["worst case", "load +20 %", "supply -10 %", "nominal"]),
    ("Drag -30%, inertia -20%", ["drag -30 %", "inertia -20 %", "nominal"]),
])  # fmt: skip
def test_meaning_of_a_text(text: str, names: list[str]) -> None:
    assert [row.name for row in read_perturbations(text)] == names


def test_rows_may_be_given() -> None:
    assert read_perturbations([alone("load", 50)]) == (alone("load", 50), NOMINAL)
    assert read_perturbations(None) == USUAL


@pytest.mark.parametrize(("text", "error", "says"), [
    ("load", UsageError, "perturbation 'load'; expected a quantity and a percentage, such as"),
    ("laod 20%", UnknownName, "known: load, inertia, supply, current, friction, drag; did you mean load?"),
    ("supply -100%", UsageError, "allowed reductions of less than 100 %"),
    ("load 20%,", UsageError, "perturbation ''; expected a quantity and a percentage, such as"),
])  # fmt: skip
def test_mistakes(text: str, error: type[Exception], says: str) -> None:
    with pytest.raises(error) as caught:
        read_perturbations(text)
    assert says in str(caught.value)


def test_the_usual_perturbations_are_both_directions_of_ten_rows() -> None:
    found = scenarios(SYSTEM, USUAL, "full", 5)
    assert len(found) == 20 == len({each.name for each in found})
    assert found[0].name == "worst case, forward" and found[0].load.torque == pytest.approx(36e-3)
    assert [each.name for each in found if each.nominal] == ["nominal, forward", "nominal, backward"]
    assert {each.direction for each in found} == {1, -1} and {each.step_ps for each in found} == {5}


def test_half_steps_begin_at_an_even_and_an_odd_one() -> None:
    found = scenarios(SYSTEM, (NOMINAL,), "half", 5)
    assert [(each.direction, each.first) for each in found] == [(1, 0), (1, 1), (-1, 0), (-1, 1)]


def test_rows_that_change_nothing_are_left_out() -> None:
    still = scenarios(
        (replace(MOTOR, friction=0.0), replace(DRIVER, kind="current", supply=0.0), LoadData()), USUAL, "full", 5
    )
    names = {each.name.rpartition(",")[0] for each in still}
    assert names == {"worst case", "current -20 %", "inertia +20 %", "nominal", "inertia -20 %", "drag -30 %"}
