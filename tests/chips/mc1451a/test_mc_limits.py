"""Limit switches of the MC1451A family: when they are looked at, what a trip does, the way out, who may move and when.

cycle         |  n-1  |   n   |  n+1  |
POSLIMIT      ___/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾       a level at the begin of a cycle, as it was just before
displacement   1       0       0             so the axis stands from cycle n on
"""

from __future__ import annotations

import pytest
from mc import (
    AXES,
    ENCODERS,
    ONE,
    PARTS,
    READY,
    S1,
    T1,
    TRAPEZOID,
    V1,
    Rig,
    base,
    each,
    with_axes,
    with_encoder,
)

OUTPUTS = ("pulse1", "dir1", "atrest1")
BACK = (f"SET_VEL {ONE}", f"SET_ACC {ONE}")  # a step per cycle at once
SWITCHES = (("poslimit1", 0x0321, 1), ("neglimit1", 0x0341, -1))
switches = pytest.mark.parametrize(("pin", "word", "way"), SWITCHES)


def coast(part: str, *setup: str) -> tuple[Rig, int]:
    """A move at a step per cycle; returns its first cycle."""
    rig = base(part, *OUTPUTS)
    begun = rig.begin(*(setup or T1))
    rig.to(begun + 100)
    return rig, begun


def tripped(part: str) -> Rig:
    """T1 on its way, stopped by the positive limit switch, which stays active."""
    rig, _ = coast(part)
    rig.drive("poslimit1", 1)
    rig.next(2)
    assert rig.shows("status") == 0x0321
    return rig


def still(rig: Rig) -> bool:
    """Does no output of axis 1 move, up to ten cycles from now?"""
    since = rig.bench.now_ps
    rig.next(10)
    return not any(rig.edges(pin, since + 1) for pin in OUTPUTS)


# --------------------------------------------------------------------------------------------------------------- a trip
@each
@pytest.mark.fact("PMD-LIMIT-1", "PMD-LIMIT-4", "PMD-LIMIT-17", "PMD-UND-LIMIT-MC", "PMD-PIN-3")
@switches
def test_a_switch_that_goes_high_trips_at_rest_too(part: str, pin: str, word: int, way: int) -> None:
    rig = base(part)
    rig.drive(pin, 0)
    rig.next(5)
    assert rig.status() == 0x0300
    rig.drive(pin, 1)
    rig.next()
    assert rig.shows("status") == word
    assert rig.status() == word


@each
@pytest.mark.fact("PMD-LIMIT-2", "PMD-UND-LIMIT-SAMPLE", "PMD-UND-LIMIT-DIRECTION", "PMD-ATREST-2")
@pytest.mark.parametrize("pin", ["poslimit1", "neglimit1"])
@pytest.mark.parametrize(("tick", "cycles"), [(-1, 0), (0, 1), (1, 1), (8191, 1)])
def test_a_trip_halts_the_axis_with_the_next_cycle(part: str, pin: str, tick: int, cycles: int) -> None:
    rig, begun = coast(part)
    cycle = rig.cycle + 2
    rig.drive(pin, 1, at=rig.at(cycle, tick))
    halted = cycle + cycles
    rig.to(halted, -1)
    assert (rig.shows("status") & 0x61, rig.shows("trgt_vel"), rig.level("atrest1")) == (0, ONE, 0)
    rig.to(halted)
    assert (rig.shows("status") & 0x61 != 0, rig.shows("trgt_vel"), rig.level("atrest1")) == (True, 0, 1)
    rig.next(50)
    assert rig.lows("atrest1") == [(begun, halted - begun)]
    assert rig.pulses()[-1] <= rig.at(halted)
    assert len(rig.pulses()) == rig.shows("trgt_pos") == rig.x.position


@each
@pytest.mark.fact("PMD-LIMIT-3", "PMD-UND-LIMIT-DIRECTION")
@pytest.mark.parametrize("profile", [T1, S1, V1, (*V1[:-1], "SET_ACC -0x400")])
@switches
def test_a_trip_halts_every_profile(part: str, profile: tuple[str, ...], pin: str, word: int, way: int) -> None:
    rig, _ = coast(part, *profile)
    rig.drive(pin, 1)
    rig.next()
    assert rig.status() == word
    assert still(rig) and rig.shows("trgt_vel") == 0


@with_encoder
@pytest.mark.fact("PMD-LIMIT-3", "PMD-UND-LIMIT-MC", "PMD-CON-MC-GEAR")
def test_a_trip_halts_the_gear(part: str) -> None:
    rig = base(part, *OUTPUTS)
    rig.begin("SET_PRFL_GEAR", f"SET_RATIO {ONE}")
    rig.turn(60, apart=2048)
    rig.next(3)
    assert rig.level("atrest1") == 0
    rig.drive("poslimit1", 1)
    rig.next()
    assert rig.status() == 0x0320  # motion complete does not work there
    assert still(rig)


@each
@pytest.mark.fact("PMD-UND-LIMIT-SAMPLE", "PMD-UND-LIMIT-EDGE")
def test_inputs_are_sampled_once_per_cycle_without_a_filter(part: str) -> None:
    rig = base(part)
    cycle = rig.next() + 2
    for first, last in ((1, 8190), (8192 + 8191, 8192 + 8192)):  # a clock past the look to the one before it; at it
        rig.drive("poslimit1", 1, at=rig.at(cycle, first))
        rig.drive("poslimit1", 0, at=rig.at(cycle, last - 1))
    rig.to(cycle + 4)
    assert rig.status() == 0x0300
    rig.drive("poslimit1", 1, at=rig.at(cycle + 6, 8191))
    rig.drive("poslimit1", 0, at=rig.at(cycle + 7))
    rig.to(cycle + 9)
    assert rig.status() == 0x0321


@pytest.mark.fact("PMD-LIMIT-16", "PMD-UND-LIMIT-RESET")
@pytest.mark.parametrize("part", PARTS)
def test_a_switch_that_is_active_when_sensing_begins_trips(part: str) -> None:
    rig = base(part, poslimit1=1, ready=False)
    rig.bench.run_to(rig.at(0))
    assert rig.shows("status") == 0x0321
    rig.to(READY)
    assert rig.status() == 0x0321
    rig.do("LMTS_OFF", "CLR_STATUS")
    rig.next(3)
    assert rig.status() == 0x0300
    cycle = rig.next()
    rig.do("LMTS_ON")
    rig.to(cycle + 1, -1)
    assert rig.shows("status") == 0x0300
    rig.to(cycle + 1)
    assert rig.shows("status") == 0x0321


@with_axes
@pytest.mark.fact("PMD-LIMIT-18", "PMD-STAT-26")
def test_the_switches_of_an_axis_are_its_own(part: str) -> None:
    rig = base(part)
    for axis in range(1, AXES[part] + 1):
        rig.do(*TRAPEZOID, "SET_POS 200", axis=axis)
    rig.do(f"MULTI_UPDATE {2 ** AXES[part] - 1}")
    rig.next(150)
    rig.drive("poslimit2", 1)
    rig.rest()
    assert (rig.x.axis(1).position, rig.status(1)) == (200, 0x0301)
    assert 0 < rig.x.axis(2).position < 200 and rig.status(2) == 0x1321
    assert all(rig.status(axis) & 0xFF == 1 for axis in range(3, AXES[part] + 1))


# -------------------------------------------------------------------------------------------------------------- sensing
@each
@pytest.mark.fact("PMD-LIMIT-6", "PMD-PIN-3")
def test_a_1_in_the_sense_word_makes_its_input_active_low(part: str) -> None:
    axes = AXES[part]
    for bit in range(2 * axes):
        pin, event = (f"poslimit{bit // 2 + 1}", 0x21) if bit % 2 == 0 else (f"neglimit{bit // 2 + 1}", 0x41)
        rig = base(part)
        rig.do("LMTS_OFF", f"SET_LMT_SENSE {1 << bit}")
        rig.drive(pin, 1)  # not active, tied like this where it is not used
        rig.do("LMTS_ON")
        rig.next(2)
        assert [rig.shows("status", axis) & 0xFF for axis in range(1, axes + 1)] == [0] * axes
        rig.drive(pin, 0)
        rig.next()
        found = [rig.shows("status", axis) & 0xFF for axis in range(1, axes + 1)]
        assert found == [event if axis == bit // 2 else 0 for axis in range(axes)]


@each
@pytest.mark.fact("PMD-UND-LIMIT-SENSE-CHANGE")
def test_an_input_that_becomes_active_by_the_sense_word_trips_with_the_next_cycle(part: str) -> None:
    rig = base(part)
    cycle = rig.next()
    rig.do("SET_LMT_SENSE 2")
    rig.to(cycle + 1, -1)
    assert rig.shows("status") == 0x0300
    rig.to(cycle + 1)
    assert rig.shows("status") == 0x0341


@each
@pytest.mark.fact("PMD-LIMIT-7")
def test_levels_are_read_whatever_the_sense(part: str) -> None:
    rig = base(part)
    rig.do("LMTS_OFF")
    rig.drive("poslimit1", 1)
    for sense in range(4):
        rig.do(f"SET_LMT_SENSE {sense}")
        rig.says("67 > 0001 0068")
    rig.drive("neglimit1", 1)
    rig.drive("poslimit1", 0)
    rig.says("67 > 0002 0069")


@pytest.mark.parametrize("part", [part for part in PARTS if AXES[part] < 4])
@pytest.mark.fact("PMD-LIMIT-19", "PMD-CON-PARTNAME")
def test_bits_of_axes_that_a_part_lacks_are_0_and_ignored(part: str) -> None:
    rig, every = base(part), 4 ** AXES[part] - 1
    rig.do("LMTS_OFF")
    for axis in range(1, AXES[part] + 1):
        rig.drive(f"poslimit{axis}", 1)
        rig.drive(f"neglimit{axis}", 1)
    rig.says(f"67 > {every:04x} {0x67 + every:04x}")
    rig.do("SET_LMT_SENSE 0xFF", "LMTS_ON")
    rig.next(3)
    assert [rig.status(axis) & 0xFF for axis in range(1, AXES[part] + 1)] == [0] * AXES[part]
    rig.says(f"67 > {every:04x} {0x67 + every:04x}")


@each
@pytest.mark.fact("PMD-LIMIT-8")
def test_with_sensing_off_nothing_trips(part: str) -> None:
    rig = base(part, *OUTPUTS)
    rig.do("LMTS_OFF")
    begun = rig.begin(*T1)
    rig.drive("poslimit1", 1)
    rig.drive("neglimit1", 1)
    rig.rest()
    assert (rig.status(), rig.x.position, rig.lows("atrest1")) == (0x0301, 1000, [(begun, 1063)])


@each
@pytest.mark.fact("PMD-LIMIT-9")
def test_switching_sensing_off_clears_nothing(part: str) -> None:
    rig = tripped(part)
    rig.do("LMTS_OFF")
    rig.next(3)
    assert rig.status() == 0x0321


# ---------------------------------------------------------------------------------------------------------- the way out
@each
@pytest.mark.fact("PMD-LIMIT-10", "PMD-LIMIT-11", "PMD-UND-LIMIT-OUT", "PMD-UND-LIMIT-EDGE")
def test_with_the_bits_cleared_the_axis_may_move_out_and_then_trip_again(part: str) -> None:
    rig = tripped(part)
    stood = rig.shows("trgt_pos")
    rig.says("34 ffde > 0012")
    rig.begin(*BACK, "SET_POS -200")
    rig.next(100)
    assert rig.level("poslimit1") == 1 and rig.shows("trgt_pos") == stood - 100
    assert rig.status() == 0x0700
    rig.drive("poslimit1", 0)
    rig.next(2)
    rig.drive("poslimit1", 1)
    rig.next(2)
    assert rig.status() == 0x0321  # armed again
    assert still(rig)


@each
@pytest.mark.fact("PMD-LIMIT-12", "PMD-UND-LIMIT-OUT", "PMD-CON-LIMIT-COMMAND-ERROR")
def test_while_the_bit_is_set_a_move_out_is_a_command_error(part: str) -> None:
    rig = tripped(part)
    for position in (0, 2000):
        rig.begin(f"SET_POS {position}")
        assert rig.status() == 0x03A1 and still(rig)
        rig.do("RST_STATUS 0x7F")
    rig.drive("poslimit1", 0)
    rig.begin("SET_POS 0")
    assert rig.status() == 0x03A1 and still(rig)  # the bit counts, not the switch
    rig.do("RST_STATUS 0x5F")
    rig.begin()
    assert rig.status() == 0x0701


@each
@pytest.mark.fact("PMD-UND-LIMIT-OUT")
def test_updates_that_start_nothing_are_tolerated_while_the_bit_is_set(part: str) -> None:
    rig = tripped(part)
    here = rig.shows("trgt_pos")
    rig.do("RST_STATUS 0xFE")
    rig.begin("SET_POS 5", "STOP")
    assert rig.status() == 0x0321
    rig.do("MTR_OFF")
    rig.begin()
    assert rig.status() == 0x0221
    rig.do("MTR_ON", f"SET_ACTL_POS {here}")
    rig.begin(f"SET_POS {here}")
    assert rig.status() == 0x0321 and still(rig)


@each
@pytest.mark.fact("PMD-LIMIT-20", "PMD-UND-LIMIT-OUT")
def test_with_sensing_off_every_move_starts(part: str) -> None:
    rig = tripped(part)
    rig.do("LMTS_OFF")
    rig.begin(*BACK, "SET_POS 2000")
    assert rig.status() == 0x0721
    rig.begin("STOP")
    rig.do("CLR_STATUS")
    rig.begin("SET_POS 0")
    assert rig.status() == 0x0700
    rig.drive("poslimit1", 0)
    rig.do("LMTS_ON")
    rig.rest()
    assert (rig.status(), rig.x.position) == (0x0301, 0)


@each
@pytest.mark.fact("PMD-LIMIT-13", "PMD-UND-LIMIT-EDGE")
def test_a_switch_that_stays_active_trips_once(part: str) -> None:
    rig = tripped(part)
    rig.says("33 > 0033")
    for _ in range(3):
        rig.next(300)
        assert rig.status() == 0x0300
    rig.drive("poslimit1", 0)
    rig.next(2)
    rig.drive("poslimit1", 1)
    rig.next(2)
    assert rig.status() == 0x0321


# -------------------------------------------------------------------------------------------------------- one at a time
@each
@pytest.mark.fact("PMD-LIMIT-14", "PMD-UND-LIMIT-SECOND")
@pytest.mark.parametrize(
    ("first", "second", "bits"), [("neglimit1", "poslimit1", (0x41, 0x20)), ("poslimit1", "neglimit1", (0x21, 0x40))]
)
def test_the_other_switch_counts_when_the_first_is_inactive_and_its_bit_cleared(
    part: str, first: str, second: str, bits: tuple[int, int]
) -> None:
    rig = base(part)
    rig.drive(first, 1)
    rig.next(2)
    rig.drive(second, 1)
    rig.next(2)
    assert rig.status() == 0x0300 | bits[0]
    rig.do("CLR_STATUS")
    rig.next(2)
    assert rig.status() == 0x0300  # the first one is still active
    rig.drive(first, 0)
    rig.next()
    assert rig.status() == 0x0301 | bits[1]


@each
@pytest.mark.fact("PMD-LIMIT-14", "PMD-UND-LIMIT-SECOND")
def test_a_bit_that_is_still_set_holds_the_other_switch_off(part: str) -> None:
    rig = base(part)
    rig.x.pin("neglimit1").pulse(1, "1 ms")
    rig.next(5)
    rig.drive("poslimit1", 1)
    rig.next(2)
    assert rig.status() == 0x0341
    cycle = rig.next()
    rig.do("CLR_STATUS")
    rig.to(cycle + 1)
    assert rig.shows("status") == 0x0321


@each
@pytest.mark.fact("PMD-UND-LIMIT-BOTH")
def test_of_two_switches_in_one_cycle_the_positive_one_trips(part: str) -> None:
    rig = base(part)
    rig.drive("neglimit1", 1)
    rig.drive("poslimit1", 1)
    rig.next()
    assert rig.status() == 0x0321
    rig.do("CLR_STATUS")
    rig.drive("poslimit1", 0)
    rig.next(2)
    assert rig.status() == 0x0341


# ------------------------------------------------------------------------------------------------------ into the switch
@each
@pytest.mark.fact("PMD-ERRC-17", "PMD-ATREST-5", "PMD-UND-LIMIT-REFUSED")
@pytest.mark.parametrize("mode", ["SET_PRFL_TRAP", "SET_PRFL_S_CRV"])
@switches
def test_a_move_further_into_an_active_switch_is_a_command_error(
    part: str, mode: str, pin: str, word: int, way: int
) -> None:
    rig = base(part, *OUTPUTS)
    rig.drive(pin, 1)
    rig.next(2)
    rig.do("CLR_STATUS", mode, *S1[1:-1], *TRAPEZOID)
    rig.begin(f"SET_POS {way * 50}")
    assert rig.status() == 0x0380  # motion does not complete
    assert still(rig)
    rig.do("CLR_STATUS")
    rig.drive(pin, 0)
    rig.begin()  # what was refused is in force, and this update decides anew
    assert rig.status() == 0x0700
    rig.rest()
    assert rig.x.position == way * 50


@each
@pytest.mark.fact("PMD-LIMIT-15", "PMD-UND-LIMIT-VEL", "PMD-UND-LIMIT-OUT")
@switches
def test_velocity_contouring_refuses_silently(part: str, pin: str, word: int, way: int) -> None:
    rig = base(part, *OUTPUTS)
    rig.drive(pin, 1)
    rig.next(2)
    rig.begin("SET_PRFL_VEL", f"SET_VEL {ONE}", f"SET_ACC {-way * ONE}")
    assert rig.status() == word and still(rig)  # out, but the bit is set
    rig.do("CLR_STATUS")
    rig.begin(f"SET_ACC {way * ONE}")
    assert rig.status() == 0x0300 and still(rig)  # further in
    begun = rig.begin(f"SET_ACC {-way * ONE}")
    rig.to(begun + 20)
    assert (rig.status(), rig.x.position) == (0x0700, -way * 20)


@pytest.mark.parametrize("part", ENCODERS)
@pytest.mark.fact("PMD-UND-LIMIT-VEL")
def test_the_gear_drops_steps_into_the_switch_and_follows_again_after_a_cleared_bit_and_an_update(part: str) -> None:
    rig = base(part)
    rig.begin("SET_PRFL_GEAR", f"SET_RATIO {ONE}")
    rig.drive("poslimit1", 1)
    rig.next(2)

    def turned(counts: int) -> int:
        before = rig.x.position
        rig.turn(counts, apart=100)
        rig.next(10)
        return rig.x.position - before

    assert (rig.status(), turned(5)) == (0x0320, 0)
    rig.begin()
    assert turned(-5) == 0  # the bit is still set
    rig.do("CLR_STATUS")
    assert turned(-5) == 0  # and no update since
    rig.begin()
    assert (turned(7), turned(-5), turned(5)) == (0, -5, 0)
    rig.drive("poslimit1", 0)
    assert turned(5) == 5
    assert rig.status() == 0x0300
