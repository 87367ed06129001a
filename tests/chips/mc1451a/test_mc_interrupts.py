"""Interrupts of the MC1451A family: which event takes HostIntrpt low and when, which axis it was, how it ends.

event, mask     ______/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾         looked at with the begin of every cycle
HostIntrpt      ‾‾‾‾‾‾\\_____________/‾‾‾\\________      RST_INTRPT, at once; the next event, with the next cycle
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from mc import (
    AXES,
    ENCODERS,
    MS,
    NS,
    ONE,
    PARTS,
    READY,
    SEVERAL,
    T1,
    T1_CYCLES,
    TRAPEZOID,
    Rig,
    base,
    each,
    with_axes,
    with_encoder,
)

SLICE = 2048 * 40 * NS
STEP = (f"SET_VEL {ONE}", f"SET_ACC {ONE}", "SET_POS 1")  # a move of one cycle, so that motion completes


def rig_of(part: str) -> Rig:
    return base(part, "hostintrpt")


def complete(rig: Rig, axis: int = 1, mask: int = 1) -> int:
    """Let the motion of an axis complete, which interrupts; returns the cycle with which it does."""
    rig.do(*STEP, f"SET_INTRPT_MASK {mask}", axis=axis)
    begun = rig.begin(axis=axis)
    rig.to(begun + 1)
    return begun + 1


def lows(rig: Rig) -> list[int]:
    """The levels of the line since it was ready."""
    return [level for _, level in rig.edges("hostintrpt", rig.at(READY))]


# ------------------------------------------------------------------------------------------------------ what interrupts
@each
@pytest.mark.fact("PMD-INT-1", "PMD-INT-2", "PMD-CON-INT-BITS")
def test_the_line_is_high_after_a_reset_and_falls_with_the_event(part: str) -> None:
    rig = rig_of(part)
    assert lows(rig) == [] and rig.level("hostintrpt") == 1
    rig.do("SET_INTRPT_MASK 1")
    begun = rig.begin(*T1)
    rig.rest()
    rig.next(20)
    assert rig.edges("hostintrpt", rig.at(READY)) == [(rig.at(begun + T1_CYCLES), 0)]
    assert rig.status() == 0x0301
    rig.do("RESET")
    assert rig.level("hostintrpt") == 1


def stop(rig: Rig) -> None:
    """Motion complete."""
    rig.do("STOP", "UPDATE")


def wrap(rig: Rig) -> None:
    """Wrap-around, without an end of the motion."""
    rig.do("SET_ACTL_POS 0x3FFFFFFF", "SET_PRFL_VEL", *STEP[:2], "UPDATE")


def break_(rig: Rig) -> None:
    """A breakpoint, which updates nothing."""
    rig.do("SET_AUTO_UPDATE_OFF", "SET_BRK_PNT 0", "SET_POS_BRK")


def stall(rig: Rig) -> None:
    """A motion error, without an end of the motion."""
    rig.do("SET_STEP_RATIO 256", "SET_POS_ERR 5", "SET_PRFL_VEL", *STEP[:2], "UPDATE")


def err(rig: Rig) -> None:
    """A command error: a new acceleration on the way."""
    rig.do(*T1, "UPDATE")
    rig.next()
    rig.do("SET_ACC 1", "UPDATE")


EVENTS: dict[int, tuple[int, Callable[[Rig], object]]] = {  # bit: the events that come with it, and what brings them
    0: (0x01, stop),
    1: (0x02, wrap),
    2: (0x04, break_),
    4: (0x10, stall),
    5: (0x21, lambda rig: rig.drive("poslimit1", 1)),
    6: (0x41, lambda rig: rig.drive("neglimit1", 1)),
    7: (0x80, err),
}


def happens(part: str, bit: int, mask: int) -> Rig:
    """An event, with a mask; it has happened."""
    rig = rig_of(part)
    rig.do(f"SET_INTRPT_MASK {mask}")
    EVENTS[bit][1](rig)
    rig.next(12)
    assert rig.shows("status") & 0xFF == EVENTS[bit][0]
    return rig


@pytest.mark.parametrize(
    ("part", "bit"), [(part, bit) for part in PARTS for bit in EVENTS if bit != 4 or part in ENCODERS]
)
@pytest.mark.fact("PMD-INT-2", "PMD-INT-3", "PMD-INT-4", "PMD-LIMIT-5")
def test_an_event_interrupts_through_its_own_bit_of_the_mask_and_no_other(part: str, bit: int) -> None:
    assert lows(happens(part, bit, 1 << bit)) == [0]
    assert lows(happens(part, bit, 0xFF & ~EVENTS[bit][0])) == []
    assert lows(happens(part, bit, 0)) == []


@each
@pytest.mark.fact("PMD-INT-5", "PMD-INT-19", "PMD-CON-INT-BITS", "PMD-UND-RANGE-VALUES")
def test_the_upper_byte_of_a_mask_is_0_and_nothing_above_bit_7_interrupts(part: str) -> None:
    rig = rig_of(part)
    rig.says("2f ffff > 002e", "56 > 00ff 0155")
    assert rig.codes == ["out-of-range"]
    for command in ("MTR_OFF", "MTR_ON", *TRAPEZOID, "SET_POS 1000", "UPDATE"):
        rig.do(command)
        rig.next(2)
    assert rig.status() == 0x0700 and lows(rig) == []


@each
@pytest.mark.fact("PMD-INT-17", "PMD-UND-INT-MASK-SET", "PMD-UND-INT-RAISE")
def test_a_mask_that_meets_an_event_interrupts_with_the_next_cycle(part: str) -> None:
    rig = rig_of(part)
    complete(rig, mask=0)
    cycle = rig.next(3)
    rig.do("SET_INTRPT_MASK 1")
    rig.next(2)
    assert rig.edges("hostintrpt", rig.at(READY)) == [(rig.at(cycle + 1), 0)]


@each
@pytest.mark.fact("PMD-INT-18", "PMD-INT-21")
def test_an_interrupt_may_be_left_alone(part: str) -> None:
    rig = rig_of(part)
    rig.do("SET_INTRPT_MASK 1")
    for position in (30, 60, 40):
        rig.begin(*STEP, f"SET_POS {position}")
        rig.rest()
    assert rig.x.position == 40 and lows(rig) == [0]
    for value in range(100):
        rig.do(f"SET_POS {value}")
        assert rig.do("GET_POS") == value
    assert lows(rig) == [0] and rig.codes == []


@each
@pytest.mark.fact("PMD-INT-22", "PMD-UND-INT-MASK-CLEAR")
def test_a_pending_interrupt_outlives_its_mask(part: str) -> None:
    rig = rig_of(part)
    complete(rig)
    rig.says("2f 0000 > 002f")
    rig.next(3)
    assert rig.level("hostintrpt") == 0
    rig.says("32 ffff > 0031")
    rig.next(3)
    assert (rig.level("hostintrpt"), rig.status(), lows(rig)) == (1, 0x0301, [0, 1])


# ---------------------------------------------------------------------------------------------------------- how it ends
@each
@pytest.mark.fact("PMD-INT-14", "PMD-UND-INT-CLEARED")
@pytest.mark.parametrize("command", ["CLR_STATUS", "RST_STATUS 0"])
def test_the_status_commands_leave_the_line_low(part: str, command: str) -> None:
    rig = rig_of(part)
    complete(rig)
    rig.do(command)
    rig.next(3)
    assert (rig.status(), rig.level("hostintrpt")) == (0x0300, 0)
    rig.says("32 0000 > 0032")
    assert rig.level("hostintrpt") == 1
    rig.next(3)
    assert lows(rig) == [0, 1]


@each
@pytest.mark.fact("PMD-INT-10", "PMD-INT-11", "PMD-UND-INT-GAP")
def test_after_rst_intrpt_the_line_is_high_until_the_sample_in_the_next_cycle(part: str) -> None:
    rig = rig_of(part)
    rig.do("SET_INTRPT_MASK 0x21")
    rig.drive("poslimit1", 1)
    rig.next(2)
    assert (rig.shows("status"), rig.level("hostintrpt")) == (0x0321, 0)
    cycle = rig.next()
    rig.do("RST_INTRPT 0xFE")
    rig.next(3)
    (_, low), (rises, high), (falls, again) = rig.edges("hostintrpt", rig.at(READY))
    assert (low, high, again) == (0, 1, 0)
    assert rig.at(cycle) + 2 * SLICE < rises < rig.at(cycle) + 2 * SLICE + 1000 * NS  # as HostRdy rises
    assert falls == rig.at(cycle + 1)
    rig.do("RST_INTRPT 0xDF")
    rig.next(3)
    assert (lows(rig), rig.status()) == ([0, 1, 0, 1], 0x0300)


@pytest.mark.fact("PMD-UND-INT-GAP", "PMD-INT-11")
@pytest.mark.parametrize(("early", "gap"), [(1, 0), (0, 1)])
def test_the_gap_is_a_cycle_at_most(early: int, gap: int) -> None:
    rig = rig_of("mc1151a")
    rig.do("SET_INTRPT_MASK 0x21")
    rig.drive("poslimit1", 1)
    cycle = rig.next(2) + 3
    rig.host.write_command(0x32)
    rig.bench.run_to(rig.at(cycle, -early) - SLICE - 280 * NS)  # from there to the end of a word's strobes
    rig.host.write_word(0xFE)
    rig.to(cycle + 2)
    assert rig.edges("hostintrpt", rig.at(cycle - 1)) == [(rig.at(cycle, -early), 1), (rig.at(cycle + gap), 0)]


@each
@pytest.mark.fact("PMD-INT-12")
def test_without_an_interrupt_rst_intrpt_does_nothing(part: str) -> None:
    rig = rig_of(part)
    complete(rig, mask=0)
    rig.says("32 0000 > 0032", "31 > 0301 0332")
    assert lows(rig) == []


# ---------------------------------------------------------------------------------------------------- which axis it was
@with_axes
@pytest.mark.fact("PMD-INT-6")
def test_each_axis_has_its_mask(part: str) -> None:
    rig = rig_of(part)
    rig.do("SET_INTRPT_MASK 1", axis=2)
    assert rig.do("GET_INTRPT_MASK", axis=1) == 0
    complete(rig, axis=1, mask=0)
    assert lows(rig) == []
    complete(rig, axis=2)
    assert lows(rig) == [0]


@with_axes
@pytest.mark.fact("PMD-INT-7", "PMD-UND-INT-RAISE")
def test_one_interrupt_at_a_time(part: str) -> None:
    rig = rig_of(part)
    complete(rig, axis=2)
    complete(rig, axis=1)
    rig.next(3)
    assert lows(rig) == [0]
    rig.says("30 > 1301 1331", "32 0000 > 0032")
    rig.next(2)
    rig.says("30 > 0301 0331")
    assert lows(rig) == [0, 1, 0]


@pytest.mark.parametrize("part", ["mc1451a", "mc1451a-e"])
@pytest.mark.fact("PMD-INT-8", "PMD-UND-INT-RAISE")
def test_of_events_in_one_cycle_that_of_the_lowest_axis_interrupts_first(part: str) -> None:
    rig = rig_of(part)
    for axis in range(1, 5):
        rig.do(*STEP, "SET_INTRPT_MASK 1", axis=axis)
    rig.do("SET_3", "MULTI_UPDATE 0xF")
    rig.next(5)
    for word in ("0301", "1301", "2301", "3301"):
        rig.next(2)
        rig.says(f"30 > {word} {0x30 + int(word, 16):04x}", "32 0000 > 0032")
    rig.next(2)
    assert lows(rig) == [0, 1] * 4
    assert rig.do("GET_STATUS") == 0x2300  # axis 3 has been the current one all the time


@with_axes
@pytest.mark.fact("PMD-INT-9")
def test_rst_intrpt_clears_the_interrupting_axis_and_selects_none(part: str) -> None:
    rig = rig_of(part)
    complete(rig, axis=1, mask=0)
    complete(rig, axis=2)
    rig.do("SET_1")
    rig.says("32 fffe > 0030", "31 > 0301 0332", "02 > 1300 1302")


@with_axes
@pytest.mark.fact("PMD-INT-7", "PMD-UND-INT-CLEARED")
def test_an_axis_whose_events_are_gone_stays_the_interrupting_one(part: str) -> None:
    rig = rig_of(part)
    complete(rig, axis=2)
    rig.do("CLR_STATUS", "SET_1")
    complete(rig, axis=1)
    rig.next(3)
    rig.says("30 > 1300 1330", "08 > 1300 1308", "31 > 1300 1331")


@with_axes
@pytest.mark.fact("PMD-INT-13", "PMD-UND-INT-SETI")
def test_set_i_without_an_interrupt_selects_nothing(part: str) -> None:
    rig = rig_of(part)
    rig.do("SET_2")
    rig.says("08 > 1300 1308", "31 > 1300 1331", "30 > 1300 1330")


# --------------------------------------------------------------------------------------------------------------- a host
def crashed(part: str) -> Rig:
    """Axis 1 is the current one, and axis 2 has run into a stop: motion error and positive limit, which interrupt."""
    rig = rig_of(part)
    rig.do("SET_STEP_RATIO 256", "SET_POS_ERR 5", "SET_INTRPT_MASK 0x70", *T1, "UPDATE", axis=2)
    rig.do("SET_1")
    rig.bench.run_until(lambda: rig.shows("trgt_pos", 2) == 5)
    rig.drive("poslimit2", 1, at=rig.at(rig.cycle + 3, 9))
    rig.bench.run_until(rig.x.pin("hostintrpt").is_(0))
    rig.next(5)
    assert rig.do("GET_STATUS") == 0x0300
    return rig


@pytest.mark.parametrize("part", ["mc1251a-e", "mc1451a-e"])
@pytest.mark.fact("PMD-INT-15", "PMD-CON-INT-LIMIT", "PMD-CON-INT-CLEAN", "PMD-CON-INT-ERROR", "PMD-CON-GET-I")
def test_a_host_deals_with_two_events_one_after_the_other(part: str) -> None:
    rig = crashed(part)
    rig.says("30 > 1331 1361", "08 > 1331 1339", "32 00ef > 0121")
    rig.next()
    rig.says("08 > 1331 1339")  # the error is still there
    rig.do("SYNCH_PRFL", "STOP", "UPDATE")
    rig.next(2)
    rig.says("32 00ef > 0121")
    assert lows(rig) == [0, 1, 0, 1]
    rig.next()
    assert lows(rig) == [0, 1, 0, 1, 0]
    rig.says("08 > 1321 1329", "32 00df > 0111")
    rig.next(10)
    assert lows(rig) == [0, 1, 0, 1, 0, 1]
    assert rig.do("GET_STATUS") == 0x1301  # motion complete was not in the mask


@pytest.mark.parametrize("part", ["mc1251a-e", "mc1451a-e"])
@pytest.mark.fact("PMD-INT-16")
def test_several_events_may_be_cleared_together(part: str) -> None:
    rig = crashed(part)
    rig.do("SET_2", "SYNCH_PRFL", "STOP", "UPDATE")
    rig.next(2)
    rig.says("32 00cf > 0101")
    rig.next(10)
    assert (lows(rig), rig.do("GET_STATUS")) == ([0, 1], 0x1301)


@pytest.mark.parametrize("part", SEVERAL)
@pytest.mark.fact("PMD-INT-20")
def test_a_host_that_notes_clears_and_then_acts_loses_no_event(part: str) -> None:
    rig, axes = rig_of(part), AXES[part]
    for axis in range(1, axes + 1):
        rig.do(*STEP, "SET_POS 30", "SET_INTRPT_MASK 0x61", axis=axis)
    rig.do(f"MULTI_UPDATE {2**axes - 1}")
    rig.next(5)
    rig.drive("poslimit2", 1)
    handled = []
    while len(handled) < axes:
        rig.bench.run_until(rig.x.pin("hostintrpt").is_(0), timeout="100 ms")
        word = rig.do("SET_I")
        assert word is not None
        rig.do("RST_INTRPT 0")
        rig.next()
        handled.append((1 + (word >> 12 & 3), "limit" if word & 0x60 else "complete"))
    assert handled == [(2, "limit"), *((axis, "complete") for axis in range(1, axes + 1) if axis != 2)]
    rig.bench.run(100 * MS)
    assert rig.level("hostintrpt") == 1
    assert [rig.status(axis) & 0xFF for axis in range(1, axes + 1)] == [0] * axes


# ------------------------------------------------------------------------------------------------ an error that lasts
@with_encoder
@pytest.mark.fact("PMD-STAT-16", "PMD-CON-INT-ERROR", "PMD-UND-INT-LASTING")
def test_a_motion_error_that_rst_intrpt_cannot_clear_interrupts_once_and_again_as_it_recurs(part: str) -> None:
    rig = rig_of(part)
    rig.do("SET_STEP_RATIO 256", "SET_POS_ERR 5", "SET_INTRPT_MASK 0x10", "SET_AUTO_STOP_ON")
    rig.begin(*STEP, "SET_POS 10")
    rig.bench.run_until(rig.x.pin("hostintrpt").is_(0))
    assert rig.do("SET_I") == 0x0610  # in the cycle of the stall
    rig.do("RST_INTRPT 0", "SYNCH_PRFL", "MTR_ON")  # and the update comes with the next move
    rig.next(300)
    assert lows(rig) == [0, 1] and rig.status() == 0x0310  # the error is still there, and its bit
    rig.do("CLR_STATUS", "SET_INTRPT_MASK 0", "SET_INTRPT_MASK 0x10")
    rig.next(10)
    assert lows(rig) == [0, 1]
    rig.begin("SET_POS 20")  # nothing turns the encoder: it stalls once more
    rig.next(20)
    assert lows(rig) == [0, 1, 0] and rig.do("SET_I") == 0x0210


@with_encoder
@pytest.mark.fact("PMD-INT-10", "PMD-UND-INT-LASTING")
def test_a_motion_error_that_rst_intrpt_leaves_interrupts_again(part: str) -> None:
    rig = rig_of(part)
    rig.do("SET_STEP_RATIO 256", "SET_POS_ERR 5", "SET_INTRPT_MASK 0x10")
    rig.begin(*STEP, "SET_POS 10")
    rig.rest()
    for _ in range(3):
        assert rig.level("hostintrpt") == 0
        rig.next()
        rig.do("RST_INTRPT 0x10")
        rig.next()
    assert lows(rig) == [0, 1, 0, 1, 0, 1, 0]
