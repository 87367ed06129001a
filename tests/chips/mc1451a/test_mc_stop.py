"""How motions of the MC1451A family end: arrival, stops, motor off, another mode; and what is left of the step."""

from __future__ import annotations

import pytest
from mc import ONE, S1, S1_CYCLES, T1, T1_CYCLES, TRAPEZOID, V1, each
from mc_motion import Mover, mover, trapezoid

UNIT = ONE // 64
DOWN = range(ONE - UNIT, 0, -UNIT)  # 63 cycles, 31.5 steps
QUARTER = ("SET_VEL 0x4000", "SET_ACC 0x4000")  # a quarter of a step per cycle, from the first one on

modes = pytest.mark.parametrize("setup", [T1, V1, S1], ids=["trapezoid", "velocity", "s-curve"])


def coasting(setup: tuple[str, ...] = T1, part: str = "mc1151a", record: tuple[str, ...] = ()) -> tuple[Mover, int]:
    """An axis that moves at a step per cycle, 480 cycles behind its start; returns the cycle of the start."""
    rig = mover(part, *record)
    begun = rig.begin(*setup)
    rig.to(begun + 480)
    return rig, begun


# -------------------------------------------------------------------------------------------------------------- arrival
@each
@pytest.mark.fact("PMD-STAT-18")
@pytest.mark.parametrize(("setup", "cycles"), [(T1, T1_CYCLES), (S1, S1_CYCLES)])
def test_arrival_completes_the_motion(part: str, setup: tuple[str, ...], cycles: int) -> None:
    rig = mover(part)
    begun = rig.begin(*setup)
    rig.to(begun + cycles - 1)
    assert rig.shows("status") == 0x700 and rig.shows("trgt_pos") in (999, 1000)
    rig.next()
    assert rig.shows("status") == 0x301 and rig.shows("trgt_pos") == 1000
    assert rig.rises("atrest1", rig.at(begun)) == [rig.at(begun + cycles)]


# ---------------------------------------------------------------------------------------------------------------- stops
@modes
@pytest.mark.fact("PMD-STOP-1", "PMD-STOP-2", "PMD-STAT-21")
def test_a_stop_ends_the_motion_with_its_update(setup: tuple[str, ...]) -> None:
    rig, begun = coasting(setup)
    rig.heeds(begun + 500, "STOP", "UPDATE")
    place = rig.look().pos
    assert rig.look() == ((452 if setup is S1 else 468), 0, 0x301, 0)
    rig.next(100)
    assert rig.moves() == [place] and rig.lows("atrest1") == [(begun, 500)]
    assert rig.do("GET_TRGT_VEL") == 0 and rig.do("GET_TRGT_POS") == place


@pytest.mark.fact("PMD-STOP-3", "PMD-STAT-20")
@pytest.mark.parametrize("setup", [T1, V1], ids=["trapezoid", "velocity"])
def test_a_smooth_stop_slows_down_with_the_acceleration(setup: tuple[str, ...]) -> None:
    rig, begun = coasting(setup)
    rig.heeds(begun + 500, "SMOOTH_STOP", "UPDATE")
    looks = rig.trace(66)
    assert [look.vel for look in looks] == [*DOWN, 0, 0, 0]
    assert [look.status for look in looks] == [0x700] * 63 + [0x301] * 3
    rig.next(100)
    assert rig.moves() == [500] and rig.lows("atrest1") == [(begun, 563)]


@pytest.mark.fact("PMD-STOP-5", "PMD-UND-START-END")
def test_a_smooth_stop_ends_at_the_start_velocity() -> None:
    rig, begun = coasting((*T1, "SET_START_VEL 0x4000"))
    rig.heeds(begun + 500, "SMOOTH_STOP", "UPDATE")
    assert rig.speeds() == [*DOWN[:48]] and rig.look().status == 0x301
    assert rig.lows("atrest1") == [(begun, 548)]


@pytest.mark.fact("PMD-STOP-4", "PMD-UND-STOP-RESUME")
@pytest.mark.parametrize("stop", ["STOP", "SMOOTH_STOP"])
def test_a_stopped_axis_rests_until_an_update_and_then_continues(stop: str) -> None:
    rig, begun = coasting()
    rig.heeds(begun + 500, stop, "UPDATE")
    rig.rest()
    steps = rig.x.position
    rig.next(10_000)
    assert rig.x.position == steps < 1000 and rig.do("GET_POS") == 1000
    rig.begin()
    rig.rest()
    assert rig.moves() == [1000] and rig.status() == 0x301 and rig.do("GET_TRGT_POS") == 1000


@pytest.mark.fact("PMD-UND-STOP-REG")
def test_a_stop_leaves_the_velocity_register_alone() -> None:
    rig, begun = coasting(V1)
    rig.heeds(begun + 500, "STOP", "UPDATE")
    assert rig.look().vel == 0 and rig.do("GET_VEL") == ONE
    rig.begin()
    assert [look.vel for look in rig.trace(3)] == [UNIT, 2 * UNIT, 3 * UNIT]


@modes
@pytest.mark.fact("PMD-STOP-6", "PMD-UND-STOP-REST")
@pytest.mark.parametrize("stop", ["STOP", "SMOOTH_STOP"])
def test_a_stop_at_rest_completes_the_motion(setup: tuple[str, ...], stop: str) -> None:
    rig = mover("mc1151a")
    begun = rig.update(*setup, stop)
    assert rig.shows("status") == 0x300
    rig.to(begun)
    assert rig.shows("status") == 0x301
    rig.next(50)
    assert not rig.ticks() and not rig.lows("atrest1")


# ------------------------------------------------------------------------------------------------- a fraction of a step
@pytest.mark.fact("PMD-UND-FRACTION", "PMD-UND-PULSE-IDLE")
@pytest.mark.parametrize(("cycles", "high"), [(5, 0), (6, 1), (7, 1), (8, 0)])
def test_a_stop_keeps_the_fraction_of_a_step_and_the_level_of_pulse(cycles: int, high: int) -> None:
    rig = mover("mc1151a", "pulse1")
    begun = rig.begin(*QUARTER, "SET_POS 10")
    rig.heeds(begun + cycles, "STOP", "UPDATE")
    edges = len(rig.edges("pulse1"))
    rig.next(100)
    assert rig.level("pulse1") == high and len(rig.edges("pulse1")) == edges
    again = rig.begin()
    rig.rest()
    assert rig.lows("atrest1")[1] == (again, 40 - cycles)
    assert rig.ticks(again)[0] == 8192 * (4 - cycles % 4)  # the rest of the step
    assert rig.moves() == [10] and rig.level("pulse1") == 0


@pytest.mark.fact("PMD-UND-FRACTION", "PMD-UND-DIR-TIMING")
def test_after_a_stop_in_mid_step_the_return_adds_no_step() -> None:
    rig = mover("mc1151a", "pulse1", "dir1")
    begun = rig.begin(*QUARTER, "SET_POS 10")
    rig.heeds(begun + 7, "STOP", "UPDATE")  # at 1.75, PULSE high
    back = rig.begin("SET_POS 0")
    rig.rest()
    assert rig.edges("dir1") == [(rig.at(back), 0)]
    assert rig.edges("pulse1", rig.at(back)) == [(rig.at(back + 7), 0)]  # high all the way to 0
    assert rig.moves() == [1, -1] and rig.x.position == 0


# ------------------------------------------------------------------------------------------------------------ motor off
@modes
@pytest.mark.fact("PMD-STAT-24", "PMD-PULSE-9", "PMD-UND-MTR-OFF", "PMD-CON-MTR-OFF")
def test_the_motor_off_ends_pulses_and_motion_without_completing_it(setup: tuple[str, ...]) -> None:
    rig, begun = coasting(setup, record=("pulse1", "dir1"))
    rig.heeds(begun + 500, "MTR_OFF")
    place = 452 if setup is S1 else 468
    assert rig.look() == (place, 0, 0x200, 0)
    rig.do("SET_POS -1000", "SET_ACC -0x400", "UPDATE")
    rig.next(1000)
    edges = rig.at(begun + 500)
    assert not rig.edges("pulse1", edges + 1) and not rig.edges("dir1", edges)
    assert rig.status() == 0x200 and rig.shows("trgt_pos") == place == rig.x.position
    assert rig.lows("atrest1") == [(begun, 500)]


@pytest.mark.fact("PMD-UND-MTR-OFF")
def test_a_motor_that_was_off_for_part_of_a_cycle_has_ended_its_motion() -> None:
    rig, begun = coasting()
    rig.to(begun + 499)
    rig.do("MTR_OFF", "MTR_ON")  # both act in this cycle
    assert rig.cycle == begun + 500 and rig.look() == (468, 0, 0x300, 0)


@pytest.mark.fact("PMD-PULSE-10", "PMD-UND-MTR-OFF-UPDATE", "PMD-CON-MTR-OFF")
def test_an_update_while_the_motor_is_off_must_be_repeated_after_motor_on() -> None:
    rig = mover("mc1151a")
    rig.do("MTR_OFF", *T1, "UPDATE")
    rig.next(100)
    rig.do("MTR_ON")
    rig.next(100)
    assert not rig.ticks() and rig.status() == 0x300
    begun = rig.begin("SET_ACC 0x400")
    rig.rest()
    assert rig.lows("atrest1") == [(begun, T1_CYCLES)] and rig.moves() == [1000]


@pytest.mark.fact("PMD-UND-MTR-OFF-UPDATE")
def test_while_the_motor_is_off_updates_copy_and_stop() -> None:
    rig = mover("mc1151a")
    rig.begin("MTR_OFF", *V1, "STOP")
    assert rig.shows("status") == 0x201  # the stop is carried out, and complete
    rig.begin("CLR_STATUS", "SET_PRFL_TRAP", "SET_POS 5")
    assert rig.shows("status") == 0x200  # nothing to complete: it did not start
    rig.do("MTR_ON", "SET_VEL 0")
    rig.heeds(rig.cycle + 2, "SET_PRFL_VEL")
    rig.next(20)
    assert rig.look() == (0, 0, 0x300, 0)
    rig.begin("SET_VEL 0x10000")
    assert rig.look().vel == UNIT


# ---------------------------------------------------------------------------------------------------------- other modes
@pytest.mark.fact("PMD-UND-MODE-SWITCH")
@pytest.mark.parametrize(
    ("setup", "mode"), [(T1, "SET_PRFL_S_CRV"), (V1, "SET_PRFL_S_CRV"), (V1, "SET_PRFL_TRAP"), (S1, "SET_PRFL_TRAP")]
)
def test_a_switch_to_a_point_to_point_mode_in_motion_is_an_abrupt_stop(setup: tuple[str, ...], mode: str) -> None:
    rig, begun = coasting(setup)
    rig.heeds(begun + 500, mode)
    place = 452 if setup is S1 else 468
    assert rig.look() == (place, 0, 0x301, 0) and rig.codes == ["mode-in-motion"]
    rig.next(200)
    assert rig.moves() == [place] and rig.lows("atrest1") == [(begun, 500)]


@modes
@pytest.mark.fact("PMD-UND-MODE-SWITCH")
def test_the_mode_that_is_set_already_changes_nothing(setup: tuple[str, ...]) -> None:
    rig, begun = coasting(setup)
    mode = setup[0] if setup[0].startswith("SET_PRFL") else "SET_PRFL_TRAP"
    rig.heeds(begun + 500, mode)
    assert rig.look().vel == ONE and rig.look().status == 0x700 and not rig.codes


@pytest.mark.fact("PMD-UND-UPDATE-MODE")
@pytest.mark.parametrize("before", ["SET_PRFL_VEL", "SET_PRFL_S_CRV"])
def test_another_mode_starts_nothing_before_an_update(before: str) -> None:
    rig = mover("mc1151a")
    rig.begin(before, *TRAPEZOID, "SET_POS 20", "STOP")
    rig.do("SET_PRFL_TRAP")
    rig.next(100)
    assert not rig.ticks()
    rig.begin()
    rig.rest()
    assert rig.moves() == [20]


# ------------------------------------------------------------------------------------------------ a new number for here
@pytest.mark.fact("PMD-CMD-SET_ACTL_POS-3")
def test_a_position_that_is_set_causes_no_pulse_and_leaves_the_destination() -> None:
    rig = mover("mc1151a", "pulse1")
    rig.begin(*T1)
    rig.rest()
    now = rig.bench.now_ps
    rig.do("SET_ACTL_POS 0")
    rig.next(1000)
    assert not rig.edges("pulse1", now + 1) and rig.do("GET_POS") == 1000 and rig.do("GET_TRGT_POS") == 0
    rig.begin()
    rig.rest()
    assert rig.moves(rig.cycle - 1100) == [1000] and rig.x.position == 1000 and rig.x.travel == 2000


@pytest.mark.fact("PMD-UND-SETACTL-MOTION")
def test_a_position_set_in_motion_keeps_the_destination_of_a_trapezoid() -> None:
    rig, begun = coasting()
    rig.heeds(begun + 500, "SET_ACTL_POS 0")  # in the cycle that begins at 467.5
    assert rig.look() == (1, ONE, 0x700, 0)
    assert rig.speeds() == trapezoid(999 * ONE, ONE, UNIT, speed=ONE)
    assert rig.do("GET_TRGT_POS") == 1000 == rig.x.position and rig.x.travel == 1467


@pytest.mark.fact("PMD-UND-SETACTL-MOTION")
def test_a_position_set_in_motion_keeps_the_distance_of_an_s_curve() -> None:
    rig, begun = coasting(S1)
    rig.heeds(begun + 500, "SET_ACTL_POS 0")  # in the cycle that begins at 451
    assert rig.look() == (1, ONE, 0x700, 4)
    rig.rest()
    assert rig.do("GET_TRGT_POS") == 549 == rig.x.position and rig.x.travel == 1000
    assert rig.lows("atrest1") == [(begun, S1_CYCLES)] and rig.do("GET_POS") == 1000


@pytest.mark.fact("PMD-UND-SETACTL-MOTION")
def test_a_position_set_in_motion_keeps_the_speed_of_velocity_contouring() -> None:
    rig, begun = coasting(V1)
    rig.heeds(begun + 500, "SET_ACTL_POS -7")
    assert [look[:2] for look in rig.trace(50)] == [(n - 6, ONE) for n in range(50)]
