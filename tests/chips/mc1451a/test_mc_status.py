"""The status word and the mode word of an MC1451A axis: what sets each bit, and when, and what clears it.

bit   15 14   13 12    11      10       9      8      7     6    5     4       3       2      1      0
       0  0   axis-1    0   in motion   1   motor   error  neg  pos  stall  capture  break  wrap  complete
"""

from __future__ import annotations

from typing import NamedTuple

import pytest
from mc import AXES, ENCODERS, ONE, S1, S1_CYCLES, T1, T1_CYCLES, TRAPEZOID, V1, Rig, base, each, with_encoder

FAST = (f"SET_VEL {ONE}", f"SET_ACC {ONE}")  # a step per cycle at once
PHASES = (32, 32, 32, 904, 32, 32, 32)  # cycles of S1
FAMILY = pytest.mark.parametrize("part", ["mc1451a", "mc1451a-e"])


class Change(NamedTuple):
    """A cycle in which the status word becomes another one."""

    cycle: int
    word: int
    target: int


def changes(rig: Rig, first: int, last: int) -> list[Change]:
    """Changes of the status word from one cycle on, which may be under way, up to another; the first is what it was."""
    found: list[Change] = []
    for cycle in range(first, last + 1):
        if rig.cycle < cycle:
            rig.to(cycle)
        word = rig.shows("status")
        if not found or word != found[-1].word:
            found.append(Change(cycle, word, rig.shows("trgt_pos")))
    return found


def words(rig: Rig, first: int, last: int) -> dict[int, int]:
    """The same without the target: {cycle: word}."""
    return {change.cycle: change.word for change in changes(rig, first, last)}


def coast(rig: Rig, *setup: str) -> int:
    """T1 on its way, ten cycles past the end of the ramp; returns its first cycle."""
    begun = rig.begin(*(setup or T1))
    rig.to(begun + 74)
    return begun


# --------------------------------------------------------------------------------------------------- what sets the bits
@each
@pytest.mark.fact("PMD-STAT-1", "PMD-STAT-10", "PMD-STAT-18", "PMD-ATREST-2")
def test_motion_complete_comes_with_the_destination_and_in_motion_goes_with_it(part: str) -> None:
    rig = base(part)
    begun = rig.update(*T1)
    assert words(rig, begun - 1, begun + 3) == {begun - 1: 0x0300, begun: 0x0700}
    assert rig.status() == 0x0700
    end = begun + T1_CYCLES
    assert words(rig, end - 50, end + 2) == {end - 50: 0x0700, end: 0x0301}
    rig.to(end + 2)
    assert (rig.status(), rig.shows("trgt_pos")) == (0x0301, 1000)


@pytest.mark.fact("PMD-STAT-1", "PMD-STAT-18")
@pytest.mark.parametrize(("profile", "cycles"), [(T1, T1_CYCLES), (S1, S1_CYCLES)])
def test_the_target_is_there_when_motion_completes(profile: tuple[str, ...], cycles: int) -> None:
    rig = base("mc1151a")
    end = rig.update(*profile) + cycles
    found = []
    for cycle in (end - 1, end):
        rig.to(cycle)
        found.append((rig.shows("trgt_pos"), rig.shows("status") & 1))
    assert found == [(999, 0), (1000, 1)]


@each
@pytest.mark.parametrize(("start", "sign"), [(0x3FFFFFF0, 1), (-0x3FFFFFF0, -1)])
@pytest.mark.fact("PMD-STAT-2")
def test_an_end_of_the_range_sets_wrap_around(part: str, start: int, sign: int) -> None:
    rig = base(part)
    begun = rig.update(f"SET_ACTL_POS {start}", "SET_PRFL_VEL", f"SET_VEL {ONE}", f"SET_ACC {sign * ONE}")
    wraps = begun + (16 if sign > 0 else 17)  # the range ends at 3fffffff and at -40000000
    _, wrapped = changes(rig, begun, begun + 20)
    assert wrapped == (wraps, 0x0702, -(1 << 30) if sign > 0 else (1 << 30) - 1)


@each
@pytest.mark.fact("PMD-STAT-3")
def test_a_breakpoint_sets_its_bit(part: str) -> None:
    rig = base(part)
    rig.do("SET_BRK_PNT 500", "SET_POS_BRK")
    begun = rig.begin(*T1)
    _, reached = changes(rig, begun, begun + 600)
    assert reached[1:] == (0x0704, 500)  # at a step per cycle: not 499, not 501
    rig.rest()
    assert rig.status() == 0x0305


@with_encoder
@pytest.mark.fact("PMD-STAT-4", "PMD-CAPT-1", "PMD-UND-CAPTURE", "PMD-CON-CAPTURE", "PMD-CON-BIT3")
def test_nothing_can_capture(part: str) -> None:
    rig = base(part, "hostintrpt")
    rig.do("SET_INTRPT_MASK 8")
    for source in ("64 > 0064", "65 > 0065"):
        rig.says(source, "36 > 0000 0000 0036")
        rig.x.pin("home1").pulse(0, "3 ms")
        rig.turn(40)
        rig.bench.run("10 ms")
        rig.says("36 > 0000 0000 0036")
        assert rig.status() == 0x0300
    assert rig.shows("actl_pos") == 80 and rig.shows("capt") == 0
    assert rig.falls("hostintrpt") == []


@pytest.mark.parametrize("part", [part for part in AXES if part not in ENCODERS])
@pytest.mark.fact("PMD-STAT-4", "PMD-UND-ENC-ABSENT", "PMD-CON-CAPTURE")
def test_without_an_encoder_the_commands_of_captures_are_accepted(part: str) -> None:
    rig = base(part)
    rig.says("64 > 0064", "65 > 0065", "36 > 0000 0000 0036")
    rig.x.pin("home1").pulse(0, "3 ms")
    rig.bench.run("10 ms")
    assert (rig.status(), rig.codes) == (0x0300, ["no-encoder"] * 3)


@with_encoder
@pytest.mark.fact("PMD-STAT-5", "PMD-STAT-25")
def test_a_position_error_beyond_its_limit_sets_motion_error(part: str) -> None:
    rig = base(part)
    rig.do("SET_STEP_RATIO 256", "SET_POS_ERR 100")
    begun = rig.begin(*T1)
    _, wrong = changes(rig, begun, begun + 200)
    assert wrong[1:] == (0x0710, 101)
    end = begun + T1_CYCLES  # the motor does not move, the trajectory does
    assert words(rig, end - 1, end) == {end - 1: 0x0710, end: 0x0311}
    assert (rig.shows("actl_pos"), rig.shows("actl_pos_err")) == (0, -1000)


@each
@pytest.mark.fact("PMD-STAT-6")
@pytest.mark.parametrize(("pin", "word"), [("poslimit1", 0x0321), ("neglimit1", 0x0341)])
def test_a_limit_switch_sets_its_bit(part: str, pin: str, word: int) -> None:
    rig = base(part)
    rig.x.pin(pin).pulse(1, "1 ms")
    rig.bench.run("5 ms")
    assert rig.status() == word


@each
@pytest.mark.fact("PMD-STAT-7")
def test_a_command_error_sets_its_bit(part: str) -> None:
    rig = base(part)
    begun = coast(rig)
    refused = rig.update("SET_ACC 0x800")
    assert words(rig, refused - 1, refused + 1) == {refused - 1: 0x0700, refused: 0x0780}
    end = begun + T1_CYCLES
    assert words(rig, end - 1, end) == {end - 1: 0x0780, end: 0x0381}


@each
@pytest.mark.fact("PMD-STAT-8")
def test_a_bit_shows_whether_the_motor_is_on(part: str) -> None:
    rig = base(part)
    rig.says("42 > 0042", "31 > 0200 0231", "43 > 0043", "31 > 0300 0331")


@each
@pytest.mark.fact("PMD-STAT-9", "PMD-STAT-12", "PMD-STAT-15", "PMD-UND-RESERVED-BITS")
def test_bit_9_is_always_1_and_bits_11_14_and_15_are_always_0(part: str) -> None:
    rig = base(part)
    for axis in range(1, AXES[part] + 1):
        found = [rig.do(f"SET_{axis}")]
        for command in ("MTR_OFF", "UPDATE", "MTR_ON", "STOP", *V1, "UPDATE", "CLR_STATUS", "UPDATE", "RST_STATUS 0"):
            rig.do(command)
            rig.next()
            found.append(rig.status())
        found.append(rig.do("GET_INTRPT"))
        assert {word & 0xFA00 for word in found} == {0x0200 | (axis - 1) << 12}
        assert {word & 0x0FFF for word in found} == {0x0200, 0x0300, 0x0301, 0x0700}


@FAMILY
@pytest.mark.fact("PMD-STAT-11", "PMD-STAT-26")
def test_the_number_of_the_axis_is_in_bits_13_and_12(part: str) -> None:
    rig = base(part)
    assert [rig.status(axis) for axis in range(1, 5)] == [0x0300, 0x1300, 0x2300, 0x3300]
    assert [rig.do(f"SET_{axis}") for axis in range(1, 5)] == [0x0300, 0x1300, 0x2300, 0x3300]


@FAMILY
@pytest.mark.fact("PMD-STAT-26")
def test_words_of_some_states(part: str) -> None:
    rig = base(part)
    assert rig.status() == 0x0300
    rig.begin(*T1)
    rig.rest()
    rig.begin("SET_POS 2000")
    assert rig.status() == 0x0701
    rig.begin(*T1, axis=2)
    rig.drive("poslimit2", 1)
    rig.next(2)
    assert rig.status(axis=2) == 0x1321
    rig.drive("neglimit4", 1)
    rig.next(2)
    rig.do("CLR_STATUS", axis=4)
    rig.begin(*TRAPEZOID, "SET_POS -5", axis=4)
    assert rig.status(axis=4) == 0x3380


# --------------------------------------------------------------------------------------------------- how long they last
CLEARERS = {
    "CLR_STATUS": lambda rig: rig.do("CLR_STATUS"),
    "RST_STATUS": lambda rig: rig.do("RST_STATUS 0xFE"),
    "RST_INTRPT": lambda rig: (rig.do("SET_INTRPT_MASK 1"), rig.next(2), rig.do("RST_INTRPT 0xFE")),
    "RESET": lambda rig: rig.do("RESET"),
    "reset": lambda rig: (rig.x.reset(), rig.bench.run_until(rig.x.pin("hostrdy").is_(1))),
}


@each
@pytest.mark.parametrize("clearer", CLEARERS)
@pytest.mark.fact("PMD-STAT-13", "PMD-STAT-14")
def test_events_last_until_they_are_cleared(part: str, clearer: str) -> None:
    rig = base(part)
    rig.begin(*FAST, "SET_POS 20")
    rig.rest()
    assert rig.status() == 0x0301
    begun = rig.begin("SET_POS 60")
    assert rig.status() == 0x0701  # of the move before
    rig.begin("STOP")
    rig.begin()
    assert rig.status() == 0x0701
    rig.begin("SET_POS 60", "STOP")
    rig.next(100)
    assert rig.cycle > begun + 100 and rig.status() == 0x0301
    CLEARERS[clearer](rig)
    assert rig.status() == 0x0300


@each
@pytest.mark.fact("PMD-STAT-10", "PMD-STAT-15")
@pytest.mark.parametrize("command", ["CLR_STATUS", "RST_STATUS 0"])
def test_the_upper_half_cannot_be_cleared(part: str, command: str) -> None:
    rig = base(part)
    last = AXES[part]
    rig.begin(*FAST, "SET_POS 1", axis=last)
    rig.rest()
    rig.begin("SET_POS 200", axis=last)
    upper = (last - 1) << 12
    assert rig.status(last) == upper | 0x0701
    rig.do(command, axis=last)
    assert rig.status(last) == upper | 0x0700
    rig.do("MTR_OFF", axis=last)
    rig.next()
    rig.do(command, axis=last)
    assert rig.status(last) == upper | 0x0200


@each
@pytest.mark.fact("PMD-STAT-13")
def test_a_mask_clears_the_events_whose_bits_are_0(part: str) -> None:
    def set_up() -> Rig:
        rig = base(part)
        rig.drive("neglimit1", 1)  # complete, negative limit
        rig.next(2)
        rig.do("SET_POS 5", "SET_VEL 1", "SET_ACC 1", "SET_BRK_PNT 0", "SET_POS_BRK")  # breakpoint
        rig.begin()  # command error
        assert rig.status() == 0x03C5
        return rig

    for bit in (0, 2, 6, 7):
        rig = set_up()
        rig.do(f"RST_STATUS {0xFF & ~(1 << bit)}")
        assert rig.status() == 0x03C5 & ~(1 << bit)
    rig = set_up()
    rig.do("RST_STATUS 0xFFFF")
    assert rig.status() == 0x03C5


@with_encoder
@pytest.mark.fact("PMD-STAT-16", "PMD-UND-STALL-CLEAR", "PMD-CON-INT-ERROR")
@pytest.mark.parametrize("command", ["CLR_STATUS", "RST_STATUS 0"])
def test_a_motion_error_that_lasts_cannot_be_cleared(part: str, command: str) -> None:
    rig = base(part)
    rig.do("SET_STEP_RATIO 256", "SET_POS_ERR 5")
    rig.begin(*FAST, "SET_POS 10")
    rig.rest()
    assert rig.status() == 0x0311
    rig.next()
    rig.do(command)
    assert rig.shows("status") == 0x0310  # without a gap
    rig.next(2)
    assert rig.status() == 0x0310
    rig.turn(5, apart=20)
    rig.next(2)
    assert (rig.shows("actl_pos_err"), rig.status()) == (-5, 0x0310)  # no more, but it has been
    rig.do(command)
    rig.next(2)
    assert rig.status() == 0x0300


@with_encoder
@pytest.mark.fact("PMD-STAT-17", "PMD-UND-MC-GEAR", "PMD-CON-MC-GEAR")
def test_in_gear_mode_neither_bit_works(part: str) -> None:
    rig = base(part)
    rig.begin("SET_PRFL_GEAR", f"SET_RATIO {ONE}")
    rig.turn(40, apart=2048)
    for _ in range(12):
        rig.next()
        assert rig.shows("status") == 0x0300
    assert rig.x.position == 40
    rig.begin("STOP")
    rig.drive("neglimit1", 1)
    rig.next(2)
    assert rig.status() == 0x0340


# ---------------------------------------------------------------------------------------------- what completes a motion
@each
@pytest.mark.fact("PMD-STAT-19")
def test_velocity_0_completes_when_the_axis_is_at_rest(part: str) -> None:
    rig = base(part)
    coast(rig, *V1)
    slows = rig.update("SET_VEL 0")
    assert words(rig, slows - 1, slows + 62) == {slows - 1: 0x0700}
    assert rig.shows("trgt_vel") == ONE // 64
    assert words(rig, slows + 63, slows + 70) == {slows + 63: 0x0301}
    assert rig.shows("trgt_vel") == 0


@each
@pytest.mark.fact("PMD-STAT-20")
def test_a_smooth_stop_completes_when_the_axis_is_at_rest(part: str) -> None:
    rig = base(part)
    coast(rig)
    slows = rig.update("SMOOTH_STOP")
    assert words(rig, slows - 1, slows + 70) == {slows - 1: 0x0700, slows + 63: 0x0301}


@each
@pytest.mark.fact("PMD-STAT-21", "PMD-ATREST-2")
def test_a_stop_completes_immediately(part: str) -> None:
    rig = base(part, "atrest1")
    begun = coast(rig)
    stops = rig.update("STOP")
    assert words(rig, stops - 1, stops + 1) == {stops - 1: 0x0700, stops: 0x0301}
    assert rig.lows("atrest1") == [(begun, stops - begun)]


@each
@pytest.mark.fact("PMD-STAT-22")
def test_a_limit_switch_completes_immediately(part: str) -> None:
    rig = base(part)
    coast(rig)
    cycle = rig.next()
    rig.drive("poslimit1", 1, at=rig.at(cycle, 5000))
    assert words(rig, cycle, cycle + 2) == {cycle: 0x0700, cycle + 1: 0x0321}


@each
@pytest.mark.fact("PMD-STAT-23", "PMD-ATREST-5")
def test_a_move_to_the_present_position_completes_immediately_without_a_step(part: str) -> None:
    rig = base(part, "pulse1", "dir1", "atrest1")
    completes = rig.update(*TRAPEZOID, "SET_POS 0")
    assert words(rig, completes - 1, completes + 2) == {completes - 1: 0x0300, completes: 0x0301}
    rig.bench.run("10 ms")
    assert all(time <= 1_000_000 for pin in ("pulse1", "dir1", "atrest1") for time, _ in rig.edges(pin))


@each
@pytest.mark.fact("PMD-STAT-24", "PMD-ATREST-2")
def test_switching_the_motor_off_does_not_complete_a_motion(part: str) -> None:
    rig = base(part, "atrest1")
    begun = coast(rig)
    cycle = rig.next()
    rig.do("MTR_OFF")
    assert words(rig, cycle, cycle + 2) == {cycle: 0x0600, cycle + 1: 0x0200}
    assert rig.lows("atrest1") == [(begun, cycle + 1 - begun)]


@with_encoder
@pytest.mark.fact("PMD-STAT-24")
def test_a_stall_that_switches_the_motor_off_does_not_complete_a_motion(part: str) -> None:
    rig = base(part)
    rig.do("SET_STEP_RATIO 256", "SET_POS_ERR 5", "SET_AUTO_STOP_ON")
    begun = rig.begin(*FAST, "SET_POS 100")
    assert words(rig, begun, begun + 100) == {begun: 0x0700, begun + 6: 0x0610, begun + 7: 0x0210}


# -------------------------------------------------------------------------------------------------------- the mode word
@each
@pytest.mark.fact("PMD-MODE-2", "PMD-MODE-3", "PMD-MODE-4", "PMD-MODE-7", "PMD-UND-RESERVED-BITS")
def test_settings_by_commands_show_in_the_mode_word(part: str) -> None:
    rig = base(part)
    for command, word in (
        ("SET_OUTPUT_HIGH", 0x0200),
        ("SET_OUTPUT_STNDRD", 0x0000),
        ("SET_AUTO_UPDATE_OFF", 0x0400),
        ("SET_AUTO_UPDATE_ON", 0x0000),
        ("SET_PRFL_VEL", 0x0800),
        ("SET_PRFL_S_CRV", 0x1000),
        ("SET_PRFL_GEAR", 0x1800),
        ("SET_PRFL_TRAP", 0x0000),
    ):
        rig.do(command)
        rig.says(f"48 > {word:04x} {0x48 + word:04x}")


@with_encoder
@pytest.mark.fact("PMD-MODE-1", "PMD-MODE-8")
def test_auto_stop_shows_in_the_mode_word(part: str) -> None:
    rig = base(part)
    rig.says("45 > 0045", "48 > 0080 00c8", "44 > 0044", "48 > 0000 0048")
    rig.do("SET_AUTO_STOP_ON", "SET_OUTPUT_HIGH", "SET_AUTO_UPDATE_OFF", "SET_PRFL_VEL")
    rig.says("48 > 0e80 0ec8")


@each
@pytest.mark.fact("PMD-MODE-5", "PMD-MODE-6", "PMD-MODE-7", "PMD-UND-PHASE-END")
def test_the_phase_of_an_s_curve_shows_in_the_mode_word(part: str) -> None:
    rig = base(part)
    rig.do(*S1)
    rig.says("48 > 1000 1048")
    cycle = rig.update()
    rig.to(cycle, -1)
    assert rig.shows("mode") == 0x1000
    for phase, cycles in enumerate(PHASES, 1):
        rig.to(cycle)
        assert rig.shows("mode") == phase << 13 | 0x1000
        rig.to(cycle + cycles // 2)
        assert rig.do("GET_MODE") == phase << 13 | 0x1000
        cycle += cycles
        rig.to(cycle, -1)
        assert rig.shows("mode") == phase << 13 | 0x1000
    rig.to(cycle)
    assert rig.do("GET_MODE") == 0x1000


@pytest.mark.fact("PMD-MODE-9")
@pytest.mark.parametrize(("profile", "word"), [(T1, 0x0000), (V1, 0x0800)])
def test_the_other_modes_have_no_phases(profile: tuple[str, ...], word: int) -> None:
    rig = base("mc1151a")
    rig.do(*S1[1:-1])
    begun = coast(rig, *profile)
    assert rig.do("GET_MODE") == word
    for cycle in (begun + 80, begun + 96, begun + 200):
        rig.to(cycle)
        assert rig.shows("mode") == word
