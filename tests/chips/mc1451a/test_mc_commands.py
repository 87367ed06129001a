"""What the commands of the MC1451A family do, besides the words that test_mc_words.py has: on every part."""

from __future__ import annotations

import pytest
from mc import AXES, ONE, S1, T1, T4, V1, base, each, with_axes, with_encoder
from mc_motion import mover

UNIT = ONE // 64  # the acceleration of T1
FAR = 1 << 20
SHORT = (f"SET_VEL {ONE}", f"SET_ACC {ONE}", "SET_POS 10")  # ten cycles, a step in each


# -------------------------------------------------------------------------------------------------------------- update
@each
@pytest.mark.fact("PMD-CMD-UPDATE-1")
def test_nothing_moves_before_an_update(part: str) -> None:
    rig = mover(part, "pulse1")
    rig.do(*T1)
    rig.next(20)
    assert rig.edges("pulse1", rig.at(1)) == [] and rig.shows("trgt_pos") == 0
    n = rig.begin()
    rig.rest()
    # speeds go up by 1/64 step per cycle; the first step is over 9/11 of the way through the eleventh cycle
    assert rig.ticks(n)[0] == 10 * 8192 + -(-9 * 8192 // 11)
    assert len(rig.ticks(n)) == 1000


@with_axes
@pytest.mark.fact("PMD-CMD-MULTI_UPDATE-1")
def test_multi_update_is_an_update_of_every_axis_in_its_mask(part: str) -> None:
    rig = base(part)
    axes = range(1, AXES[part] + 1)
    for axis in axes:
        rig.do(*SHORT, axis=axis)
    odd = {axis: 10 * (axis % 2) for axis in axes}
    rig.says("5b 0005 > 0060")
    rig.next(20)
    assert {axis: rig.x.axis(axis).position for axis in axes} == odd
    rig.says("5b 000a > 0065")
    rig.next(20)
    assert {axis: rig.x.axis(axis).position for axis in axes} == dict.fromkeys(axes, 10)


@with_axes
@pytest.mark.fact("PMD-CMD-MULTI_UPDATE-2")
def test_multi_update_leaves_the_current_axis_alone_and_may_be_empty(part: str) -> None:
    rig = base(part)
    rig.do(*SHORT, axis=2)
    rig.do(*SHORT, axis=1)
    rig.says("5b 0000 > 005b")
    rig.next(20)
    assert (rig.x.axis(1).position, rig.x.axis(2).position) == (0, 0)
    rig.says("5b 0002 > 005d", "31 > 0300 0331")
    rig.next(20)
    assert (rig.x.axis(1).position, rig.x.axis(2).position) == (0, 10)
    rig.says("31 > 0300 0331")


# ------------------------------------------------------------------------------------------------------ target, speed
@each
@pytest.mark.fact("PMD-CMD-GET_TRGT_POS-1", "PMD-CMD-GET_TRGT_VEL-1")
def test_target_position_and_velocity_have_a_sign(part: str) -> None:
    rig = base(part)
    for move, coasting, over in (
        (T1, "1e > 0001 0000 001f", "1d > 0000 03e8 0405"),
        (("SET_ACTL_POS 0", *T4), "1e > ffff 0000 001d", "1d > ffff fc18 fc34"),
    ):
        n = rig.begin(*move)
        rig.to(n + 500)
        rig.says(coasting)
        rig.rest()
        rig.says(over, "1e > 0000 0000 001e")


@with_encoder
@pytest.mark.fact("PMD-CMD-GET_TRGT_POS-1", "PMD-CMD-GET_TRGT_VEL-1")
def test_target_position_and_velocity_are_shown_in_every_mode(part: str) -> None:
    rig = mover(part, quadrature={})
    rig.begin(*S1)
    rig.rest()
    rig.says("1d > 0000 03e8 0405", "1e > 0000 0000 001e", "4d 0000 0000 > 004d")
    n = rig.begin(*V1)
    rig.to(n + 64)
    rig.says("1d > 0000 0020 003d")  # 32.5 steps
    rig.says("1e > 0001 0000 001f")
    rig.begin("STOP", "SET_RATIO 65536")
    rig.begin("SET_PRFL_GEAR", "SET_ACTL_POS 0")
    rig.shafts["quadrature"].push(10)
    rig.next(2)  # counted in one cycle, displaced in the next
    rig.says("1e > 000a 0000 0028", "1d > 0000 000a 0027", "1e > 0000 0000 001e")


@each
@pytest.mark.fact("PMD-CMD-SET_START_VEL-1")
def test_a_start_velocity_needs_no_update(part: str) -> None:
    rig = mover(part)
    rig.do(*T1, "SET_EXT_BRK", "SET_START_VEL 0x4000")
    rig.drive("home1", 0)
    rig.next()
    assert [look.vel for look in rig.trace(3)] == [0, 0x4000, 0x4000 + UNIT]


# --------------------------------------------------------------------------------------------------------------- stops
@each
@pytest.mark.fact("PMD-CMD-STOP-1")
def test_stop_waits_for_its_update_and_acts_immediately_then(part: str) -> None:
    rig = mover(part)
    n = rig.begin(*T1)
    rig.to(n + 400)
    rig.says("46 > 0046")
    rig.next()
    assert {look.vel for look in rig.trace(100)} == {ONE}
    rig.heeds(n + 600, "UPDATE")
    assert rig.look().vel == 0
    rig.next(100)
    assert rig.ticks(n)[-1] == 599 * 8192 + 4096  # the coast is half a step behind the cycles
    rig.says("1e > 0000 0000 001e", "31 > 0301 0332")


@each
@pytest.mark.fact("PMD-CMD-SMOOTH_STOP-1", "PMD-CON-RESERVED-4E")
def test_smooth_stop_decelerates_with_the_acceleration(part: str) -> None:
    rig = mover(part)
    n = rig.begin(*T1)
    rig.to(n + 400)
    rig.says("4e > 004e")
    rig.heeds(n + 500, "UPDATE")
    assert rig.speeds() == [UNIT * left for left in range(63, 0, -1)]  # 31.5 steps, with the half makes 32
    assert len(rig.ticks(n + 500)) == 32
    rig.says("31 > 0301 0332")


@each
@pytest.mark.fact("PMD-CMD-MTR_OFF-1", "PMD-CMD-MTR_ON-1")
def test_mtr_off_ends_the_pulses_and_mtr_on_restores_none(part: str) -> None:
    rig = mover(part)
    n = rig.begin(*T1)
    rig.to(n + 500)
    rig.says("42 > 0042")
    rig.next()
    rig.says("31 > 0200 0231", "1e > 0000 0000 001e", "43 > 0043")
    rig.next(1000)
    assert rig.ticks(n)[-1] == 500 * 8192 + 4096
    rig.says("31 > 0300 0331")
    rig.begin("SET_POS 600")
    rig.rest()
    assert (rig.x.position, rig.shows("trgt_pos"), rig.status()) == (600, 600, 0x0301)


# --------------------------------------------------------------------------------------------------- events, interrupts
@each
@pytest.mark.fact("PMD-CMD-CLR_STATUS-1")
def test_clr_status_clears_the_events_and_nothing_else(part: str) -> None:
    rig = base(part)
    rig.do("SET_INTRPT_MASK 1")
    rig.begin("MTR_OFF", "STOP")
    rig.says("31 > 0201 0232", "33 > 0033", "31 > 0200 0231")
    assert rig.level("hostintrpt") == 0


@each
@pytest.mark.fact("PMD-CMD-RST_STATUS-1")
def test_rst_status_clears_where_its_mask_is_0(part: str) -> None:
    rig = base(part)
    rig.drive("poslimit1", 1)
    rig.do("SET_POS_BRK")
    rig.next(2)
    rig.says("31 > 0325 0356", "34 fffb > 002f", "31 > 0321 0352", "34 00de > 0112", "31 > 0300 0331")


@each
@pytest.mark.fact("PMD-CMD-RST_INTRPT-1", "PMD-CMD-SET_INTRPT_MASK-1")
def test_rst_intrpt_clears_where_its_mask_is_0_and_lets_the_line_go(part: str) -> None:
    rig = base(part)
    rig.says("32 00ef > 0121", "32 00df > 0111")
    rig.do("SET_INTRPT_MASK 0x31", "SET_POS_BRK")
    rig.next(3)  # fires, and its update has nowhere to go: motion complete
    rig.says("31 > 0305 0336")
    assert rig.level("hostintrpt") == 0
    rig.says("32 00fe > 0130", "31 > 0304 0335")
    rig.next(10)
    assert rig.level("hostintrpt") == 1
    rig.do("SET_INTRPT_MASK 4")
    rig.next()
    assert rig.level("hostintrpt") == 0


@with_axes
@pytest.mark.fact("PMD-CMD-RST_INTRPT-1")
def test_rst_intrpt_is_for_the_interrupting_axis_whichever_is_current(part: str) -> None:
    rig = base(part)
    rig.do("SET_INTRPT_MASK 1", "UPDATE", axis=2)
    rig.do("UPDATE", axis=1)
    rig.next(2)
    rig.says("32 fffe > 0030", "31 > 0301 0332", "02 > 1300 1302")


# -------------------------------------------------------------------------------------------------------------- limits
@each
@pytest.mark.fact("PMD-CMD-SET_LMT_SENSE-1")
def test_each_bit_of_the_sense_word_turns_one_switch_round(part: str) -> None:
    rig = base(part)
    axes = range(1, AXES[part] + 1)
    for bit in range(2 * AXES[part]):
        rig.do(f"SET_LMT_SENSE {1 << bit}")
        rig.next()
        events = {axis: rig.x.axis(axis).registers["status"] & 0xFE for axis in axes}
        assert events == dict.fromkeys(axes, 0) | {bit // 2 + 1: (0x20, 0x40)[bit % 2]}
        rig.do("SET_LMT_SENSE 0")
        rig.do("CLR_STATUS", axis=bit // 2 + 1)


@each
@pytest.mark.fact("PMD-CMD-LMTS_OFF-1", "PMD-CMD-LMTS_ON-1")
def test_sensing_is_switched_for_all_axes(part: str) -> None:
    rig = mover(part)
    axes = range(1, AXES[part] + 1)
    rig.says("71 > 0071")
    n = rig.begin(*T1)
    for axis in axes:
        rig.drive(f"poslimit{axis}", 1)
    rig.to(n + 100)
    assert [rig.look(axis).status & 0xFF for axis in axes] == [0] * AXES[part]
    assert rig.look().vel == ONE
    for axis in axes:
        rig.drive(f"poslimit{axis}", 0)
    rig.says("70 > 0070")
    rig.next()
    for axis in axes:
        rig.drive(f"poslimit{axis}", 1)
    rig.next()
    assert [rig.look(axis).status & 0xFF for axis in axes] == [0x21] * AXES[part]


# -------------------------------------------------------------------------------------------------------- pulse range
@with_axes
@pytest.mark.fact("PMD-PULSE-7", "PMD-CMD-SET_OUTPUT_HIGH-1")
def test_each_axis_has_a_pulse_range_of_its_own(part: str) -> None:
    rig = mover(part)
    for axis in (1, 2):
        rig.do(f"SET_VEL {600 * ONE}", f"SET_ACC {600 * ONE}", f"SET_POS {FAR}", axis=axis)
    rig.says("01 > 0300 0301", "3b > 003b", "48 > 0200 0248", "02 > 1300 1302", "48 > 0000 0048")
    rig.do("MULTI_UPDATE 3")
    rig.next(10)
    assert (rig.look(1).vel, rig.look(2).vel) == (512 * ONE, 16 * ONE)
    before = [rig.x.axis(axis).position for axis in (1, 2)]
    rig.next(3)
    assert [rig.x.axis(axis).position - before[axis - 1] for axis in (1, 2)] == [3 * 512, 3 * 16]


# ------------------------------------------------------------------------------------------------------------- encoder
@with_encoder
@pytest.mark.fact("PMD-CMD-SYNCH_PRFL-1", "PMD-CMD-GET_ACTL_POS_ERR-1")
def test_synch_prfl_takes_the_target_to_the_actual_position_with_an_update(part: str) -> None:
    rig = mover(part, quadrature={})
    rig.do("SET_STEP_RATIO 0x100")
    rig.shafts["quadrature"].push(37)
    rig.next(2)
    rig.says("60 > 0025 0085", "47 > 0047")
    rig.next(10)
    rig.says("1d > 0000 0000 001d", "60 > 0025 0085", "46 > 0046", "1a > 001a")
    rig.next()
    rig.says("1d > 0000 0025 0042", "60 > 0000 0060", "37 > 0000 0025 005c")
    assert rig.ticks() == []


@each
@pytest.mark.fact("PMD-CMD-SET_ACTL_POS-1")
def test_set_actl_pos_declares_both_positions_at_the_same_time(part: str) -> None:
    encoder = part.endswith("-e")
    rig = mover(part, "pulse1", **{"quadrature": {}} if encoder else {})
    rig.do("SET_STEP_RATIO 0x100")
    for shaft in rig.shafts.values():
        shaft.push(37)
    rig.next(2)
    before = rig.cycle
    rig.says("4d 0000 1388 > 13d5")
    assert rig.cycle == before  # not even a cycle later
    rig.says("1d > 0000 1388 13a5")
    if encoder:
        rig.says("37 > 0000 1388 13bf", "60 > 0000 0060")
    rig.next(100)
    assert rig.edges("pulse1", rig.at(1)) == []
    assert (rig.x.position, rig.shows("actl_pos_err")) == (5000, 0)


@with_encoder
@pytest.mark.fact("PMD-CMD-GET_ACTL_POS_ERR-1", "PMD-UND-ERR-SIGN")
def test_the_position_error_is_the_actual_position_less_the_target(part: str) -> None:
    rig = mover(part, quadrature={})
    rig.do("SET_STEP_RATIO 0x100")
    rig.begin(*SHORT)
    rig.rest()
    rig.says("60 > fff6 0056")
    rig.shafts["quadrature"].push(10)
    rig.next()
    rig.says("60 > 0000 0060")


@with_encoder
@pytest.mark.fact("PMD-CMD-SET_AUTO_STOP_ON-1", "PMD-CMD-SET_AUTO_STOP_OFF-1", "PMD-CMD-SET_STEP_RATIO-1")
@pytest.mark.fact("PMD-CMD-SET_POS_ERR-1", "PMD-UND-AUTOSTOP-DEFAULT")
@pytest.mark.parametrize("auto_stop", [None, "OFF", "ON"])
def test_a_motion_error_may_switch_the_motor_off(part: str, auto_stop: str | None) -> None:
    rig = mover(part)
    rig.do("SET_STEP_RATIO 0x100", "SET_POS_ERR 10", *([f"SET_AUTO_STOP_{auto_stop}"] if auto_stop else []))
    rig.begin(*T1)
    looks = rig.trace(200)  # the encoder stands still
    error = next(n for n, look in enumerate(looks) if look.pos > 10)
    assert [bool(look.status & 0x10) for look in looks] == [n >= error for n in range(200)]
    last = error if auto_stop == "ON" else 199
    assert [look.vel > 0 for look in looks] == [n <= last for n in range(200)]
    assert [look.status >> 8 & 1 for look in looks] == [n < error or auto_stop != "ON" for n in range(200)]


@pytest.mark.parametrize("part", ["mc1151a", "mc1251a", "mc1451a"])
@pytest.mark.fact("PMD-UND-ENC-ABSENT", "PMD-CMD-SET_PRFL_GEAR-1")
def test_without_an_encoder_chip_there_is_nothing_to_count_to_lose_or_to_follow(part: str) -> None:
    rig = mover(part)
    rig.do("SET_STEP_RATIO 0x100", "SET_POS_ERR 0", "SET_AUTO_STOP_ON", "SET_RATIO 65536")
    rig.begin(*SHORT)
    rig.rest()
    rig.says("37 > 0000 0000 0037", "60 > 0000 0060", "31 > 0301 0332", "47 > 0047", "46 > 0046", "1a > 001a")
    rig.next(2)
    rig.says("1d > 0000 000a 0027", "4d 0000 0005 > 0052", "37 > 0000 0000 0037", "0c > 000c", "1a > 001a")
    rig.next(100)
    assert len(rig.ticks()) == 10
