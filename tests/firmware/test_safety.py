"""Hazards of a real motor: whatever host, user and line do, what the pins of the board show is allowed."""

from __future__ import annotations

from random import Random

import pytest

from tests.ensembles import members

from .trials import FAMILIES, SET_UP, Followed, least_set_up, levels_at_edges, moves, prepared

pytestmark = [pytest.mark.system, pytest.mark.timeout(600)]


# ------------------------------------------------------------------------------------------------------------------ DIR
@members("seeds", 1, 21)
@pytest.mark.parametrize("invert", [False, True])
@pytest.mark.parametrize("name", FAMILIES)
def test_dir_has_the_level_of_the_chips_own_pin_at_every_step(emulator, name, invert, seeds):
    for seed in seeds:
        rnd = Random(f"dir {name} {seed}")
        family = FAMILIES[name]
        trial = prepared(emulator, name, seed, text=family.first, invert_dir=invert)
        row = next((row for row in trial.x.sheet.pins if row.plays("direction", 1)), None)
        assert (row is None) == (name == "cy500")
        pin = None if row is None else Followed(trial.bench, trial.x.pin(row.name))
        place = 0
        with trial.drive as drive:
            drive.run("200 ms")
            for steps in [7, -5, *moves(rnd, 4)]:
                trial.send(family.move(steps, place))
                place += steps
                drive.run("250 ms")
            drive.run_until_rest()
            drive.run("150 ms")
            steps = trial.x.steps()
            own = pin.at(steps.times_ps) if pin else [int(way > 0) for way in steps.directions]
            assert set(own) == {0, 1} and place == int(steps.directions.sum()) == trial.edges
            assert [level ^ invert for level in levels_at_edges(trial.board)] == own
            assert least_set_up(trial.board) >= SET_UP
            assert not drive.troubles
