"""What a host forgets in its first hour with an MC1451A: told once, at run time and by the linter, from one rule."""

from __future__ import annotations

import pytest
from mc_motion import Mover, mover

from slewline.chips import checks_of, sheet_of
from slewline.language.lint import lint

both = pytest.mark.parametrize("stepwise", [False, True], ids=["blocks", "stepwise"])
CURVE, CONTOUR, GEAR = "SET_PRFL_S_CRV", "SET_PRFL_VEL", "SET_PRFL_GEAR"
VEL, ACC, POS, START = "SET_VEL 65536", "SET_ACC 1024", "SET_POS 100", "SET_START_VEL 9"
NOT_TOLD = [  # what moves, or is not asked to
    (VEL, ACC, POS),
    (VEL, START, POS),
    (VEL, ACC),  # to where it is
    ("SET_VEL 0", ACC, POS),  # it is to rest
    ("SET_VEL 0", POS),
    (CURVE, "SET_VEL 0", POS),
    (CURVE, VEL, "SET_MAX_ACC 9", "SET_JERK 9", POS),
    (CURVE, VEL),
    (CONTOUR, VEL, ACC),
    (CONTOUR, "SET_VEL 0", ACC),
    (CONTOUR, POS),  # there is no destination
    (GEAR, "SET_RATIO 9"),
    (GEAR, "SET_RATIO 0"),
    (POS, "STOP"),
    (POS, "SMOOTH_STOP"),
]
TOLD = [
    ((POS,), "SET_VEL SET_ACC"),
    ((POS, ACC), "SET_VEL"),
    ((POS, START), "SET_VEL"),
    ((POS, VEL), "SET_ACC"),
    ((POS, VEL, "SET_ACC 0"), "SET_ACC"),
    ((CURVE, POS), "SET_VEL SET_MAX_ACC SET_JERK"),
    ((CURVE, POS, START, ACC), "SET_VEL SET_MAX_ACC SET_JERK"),  # neither counts in an S-curve
    ((CURVE, POS, "SET_MAX_ACC 9", "SET_JERK 9"), "SET_VEL"),
    ((CURVE, POS, VEL, "SET_MAX_ACC 9"), "SET_JERK"),
    ((CURVE, POS, VEL, "SET_JERK 9"), "SET_MAX_ACC"),
    ((CONTOUR, ACC), "SET_VEL"),
    ((CONTOUR, VEL), "SET_ACC"),
    ((CONTOUR, VEL, START), "SET_ACC"),  # which way?
    ((GEAR, POS), "SET_RATIO"),
]


def begun(commands: tuple[str, ...], stepwise: bool = False) -> Mover:
    """An axis behind some commands and an update, ten cycles later; of the last axis, since any may be meant."""
    rig = mover("mc1451a-e", options={"stepwise": stepwise})
    rig.do("SET_4", *commands, "UPDATE")
    rig.next(10)
    return rig


def starts(rig: Mover) -> list[str]:
    return [found.text for found in rig.x.findings if found.code == "no-start"]


def linted(*commands: str) -> list[str]:
    problems = lint("\n".join(("RESET", "SET_4", *commands)), sheet_of("mc1451a-e"), checks_of("mc1451a-e"))
    return [problem.found for problem in problems if problem.code == "no-start"]


@both
@pytest.mark.parametrize(("commands", "missing"), TOLD)
def test_an_update_without_effect_is_reported_with_the_missing_command(commands, missing, stepwise) -> None:
    rig = begun(commands, stepwise)
    assert len(starts(rig)) == 1 and rig.x.axis(4).travel == 0
    if not stepwise:
        (text,) = starts(rig)
        assert text.startswith("axis 4: UPDATE while ") and text.endswith(
            f": no motion starts; send {missing.replace(' ', ' and ')} before it"
        )
    (text,) = linted(*commands, "UPDATE")
    assert f"without {missing.replace(' ', ' and ')}:" in text


@both
@pytest.mark.parametrize("commands", NOT_TOLD)
def test_an_update_that_moves_or_is_not_meant_to_is_not_reported(commands, stepwise) -> None:
    assert starts(begun(commands, stepwise)) == []
    assert linted(*commands, "UPDATE") == []


@both
def test_a_motor_that_is_off_is_reason_enough(stepwise) -> None:
    for commands in ((POS,), (GEAR, POS)):
        assert starts(begun(("MTR_OFF", *commands), stepwise)) == []


@both
def test_it_is_reported_once_while_the_same_is_missing(stepwise) -> None:
    rig = begun((POS,), stepwise)
    steps = (
        (("UPDATE",), 1),
        (("SET_POS 7", "UPDATE"), 1),
        ((VEL, "UPDATE"), 2),  # now it is the acceleration alone
        (("UPDATE",), 2),
        ((ACC, "UPDATE"), 2),  # and it moves
        (("SET_ACC 0", "SET_POS 0"), 2),
    )
    for commands, told in steps:
        rig.do(*commands)
        rig.next(3)
        assert len(starts(rig)) == told, commands
    rig.bench.run_until_idle()
    for _ in range(2):
        rig.do("UPDATE")
        rig.next(3)
        assert len(starts(rig)) == 3  # a new cause
    rig.do("RESET")
    rig.bench.run("10 ms")
    rig.do("SET_4", POS, "UPDATE")
    rig.next(3)
    assert len(starts(rig)) == 4


@both
def test_a_breakpoint_is_named_as_the_cause_of_an_update(stepwise) -> None:
    rig = mover("mc1151a", options={"stepwise": stepwise})
    rig.do("SET_MTN_CMPLT_BRK", "SET_VEL 0", "UPDATE", "CLR_STATUS")
    rig.next(3)
    assert starts(rig) == []
    rig.do("CLR_STATUS", POS, "SET_BRK_PNT 0", "SET_POS_BRK")
    rig.next(3)
    assert starts(rig) == []  # its velocity of 0 was written
    rig.do(VEL, POS, "SET_POS_BRK")
    rig.next(3)
    assert len(starts(rig)) == 1
    assert stepwise or "SET_POS_BRK while acceleration is 0" in starts(rig)[0]


# ---------------------------------------------------------------------------------------------------------- no update
def left(rig: Mover) -> list[str]:
    return [found.text for found in rig.x.findings if found.code == "no-update"]


@both
def test_commands_that_wait_for_an_update_are_reported_when_all_is_at_rest(stepwise) -> None:
    rig = mover("mc1451a", options={"stepwise": stepwise})
    rig.do(VEL, POS, "SET_3", "STOP")
    rig.bench.run_until_idle()
    assert [text.partition(" without an update: ")[0] for text in left(rig)] == [
        "axis 1: SET_POS 100, SET_VEL 65536",
        "axis 3: STOP",
    ]
    rig.bench.run_until_idle()
    assert len(left(rig)) == 2
    rig.do("MULTI_UPDATE 5")
    rig.bench.run_until_idle()
    rig.do("SET_1", POS)
    rig.bench.run_until_idle()
    assert len(left(rig)) == 3 and left(rig)[2].startswith("axis 1: SET_POS 100 without")


@pytest.mark.parametrize("action", ["SMOOTH_STOP", "SYNCH_PRFL", "SET_RATIO 1", "SET_JERK 1", "SET_MAX_ACC 1"])
def test_every_buffered_register_and_action_waits(action) -> None:
    rig = mover("mc1151a-e")
    rig.do(action)
    rig.bench.run_until_idle()
    assert len(left(rig)) == 1 and left(rig)[0].startswith(f"axis 1: {action} without an update: send UPDATE, ")


@pytest.mark.parametrize(
    ("commands", "told"),
    [
        (("SET_EXT_BRK", POS), 0),
        (("SET_EXT_BRK", "SET_AUTO_UPDATE_OFF", POS), 1),
        (("SET_EXT_BRK", "SET_BRK_OFF", POS), 1),
        (("SET_START_VEL 5", "SET_OUTPUT_HIGH", "SET_INTRPT_MASK 1"), 0),  # act at once
        ((POS, "RESET"), 0),
    ],
)
def test_a_breakpoint_that_updates_is_an_announcement(commands, told) -> None:
    rig = mover("mc1151a")
    rig.do(*commands)
    rig.bench.run("10 ms")
    rig.bench.run_until_idle()
    assert len(left(rig)) == told


def test_without_a_supply_nothing_waits() -> None:
    rig = mover("mc1151a")
    rig.do(POS)
    rig.x.power(False)
    rig.bench.run_until_idle()
    assert left(rig) == []
