"""Curves in closed form, and what the picture of a tuned ramp shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from slewline.chips import ramps_of
from slewline.parts.motors.motor_data import DriverData, LoadData
from slewline.parts.motors.motors import read_motor
from slewline.record.pictures.tuned import draw
from slewline.tuning.torque_curves import demand, pull_out, resonance
from slewline.tuning.tune_ramp import perform
from slewline.tuning.tuning_picture import outline, picture_of

from .stand_in import hits, task

MOTOR = replace(read_motor("QSH4218-51-10-049"), iron=0.0, viscous=2e-4)
LR4 = DriverData(kind="voltage", supply=20.0, series=15.0, current=1.0)


def test_pull_out_is_that_of_the_closed_form() -> None:
    found = pull_out((MOTOR, LR4, LoadData()), "full", np.array([400.0, 800.0, 1200.0, 1600.0]))
    assert found == pytest.approx([0.354, 0.269, 0.200, 0.151], abs=0.001)  # L/4R, drag 2e-4 N m s
    held = pull_out((MOTOR, DriverData(kind="current", current=1.0), LoadData()), "full", np.array([0.0]))
    assert held == pytest.approx(0.9 * MOTOR.torque)


def test_the_resonance_is_that_of_a_rotor_at_standstill() -> None:
    assert resonance((MOTOR, DriverData(kind="current", current=1.0), LoadData())) == pytest.approx(302.1, abs=0.1)


def test_a_ramp_demands_inertia_friction_and_load() -> None:
    rates, torques = demand((MOTOR, LR4, LoadData(torque=0.1, friction=0.01)), np.arange(5) * 10**9, 1)
    assert rates == pytest.approx([1000.0] * 4) and torques == pytest.approx([0.11 + MOTOR.friction] * 4)
    rising = np.array([0, 2_000_000_000, 3_000_000_000])
    _, torques = demand((MOTOR, LR4, LoadData()), rising, 1)
    assert torques[0] == pytest.approx(MOTOR.inertia * MOTOR.step * 500 / 1.5e-3 + MOTOR.friction)


def test_the_outline_keeps_every_extreme() -> None:
    values = np.sin(np.arange(50_000) / 3) + (np.arange(50_000) == 12_345) * 9.0
    shown = outline(values)
    assert len(shown) <= 1002 and values[shown].max() == values.max() and list(shown[[0, -1]]) == [0, 49_999]


def test_content_of_the_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("slewline.tuning.tuning_picture.engine", lambda: "python")
    made = task("cy525", "F=3,6,9 R=4..40/6 S=1..250/4", steps=30)
    found = perform(made, ramps_of("cy525"), judge=hits, full_map=True, switching=False)
    picture = picture_of(found, ramps_of("cy525"))
    assert picture.grid is not None and picture.grid.names == ("S", "R")
    first = found.chosen.values["F"]
    for place in found.map:
        if place.values["F"] == first:
            y, x = picture.grid.rows.index(place.values["R"]), picture.grid.columns.index(place.values["S"])
            number = picture.grid.killed[y][x]
            assert (picture.grid.killers[number - 1] if number else None) == place.killer
    x, y = picture.grid.chosen or (0, 0)
    assert (picture.grid.columns[x], picture.grid.rows[y]) == (found.chosen.values["S"], found.chosen.values["R"])
    chosen, *others = picture.curve.demands
    faster = [each.time_ps for each in found.map if each.killer and (each.time_ps or 0) < found.chosen.time_ps]
    assert not chosen.fails and len(others) == bool(faster) and all(each.fails for each in others)
    assert "Lag of F" in picture.description and picture.lag.limit == 1.8
    drawn = draw(picture)
    captions = [axes._left_title for axes in drawn.axes]
    assert captions[1].get_text().startswith("Every move was simulated")
    legends = [text for axes in drawn.axes if axes.get_legend() for text in axes.get_legend().get_texts()]
    assert {each.get_fontsize() for each in [*captions, *legends]} == {8}
