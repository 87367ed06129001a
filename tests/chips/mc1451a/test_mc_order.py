"""What comes before what within a cycle of the MC1451A family."""

from __future__ import annotations

import pytest
from mc_motion import mover

MOVE = ("SET_VEL 0x10000", "SET_ACC 0x10000")  # a step in every cycle


@pytest.mark.fact("PMD-UND-CYCLE-ORDER")
def test_a_limit_is_sampled_after_the_update_and_before_the_first_displacement() -> None:
    rig = mover("mc1151a")
    begun = rig.update(*MOVE, "SET_POS 10")
    rig.drive("neglimit1", 1, at=rig.at(begun) - 1)
    rig.to(begun)
    assert rig.shows("status") == 0x341 and rig.shows("trgt_vel") == 0  # halted, not refused
    rig.next(3)
    assert not rig.ticks() and not rig.lows("atrest1")


@pytest.mark.fact("PMD-UND-CYCLE-ORDER")
def test_a_breakpoint_is_tested_after_the_arrival_and_updates_in_the_next_cycle() -> None:
    rig = mover("mc1151a")
    begun = rig.begin(*MOVE, "SET_POS 5")
    rig.do("SET_MTN_CMPLT_BRK", "SET_POS 0")
    rig.next(10)
    assert rig.lows("atrest1") == [(begun, 5), (begun + 6, 5)]
    assert rig.moves() == [5, -5] and rig.shows("status") == 0x305


@pytest.mark.fact("PMD-UND-CYCLE-ORDER")
def test_the_time_counts_after_everything_else() -> None:
    rig = mover("mc1151a")
    rig.do(*MOVE, "SET_POS 5", "SET_BRK_PNT 40", "SET_TIME_BRK")
    rig.to(40)
    assert rig.shows("status") == 0x304 and rig.shows("time") == 40
    rig.rest()
    assert rig.lows("atrest1") == [(41, 5)]
