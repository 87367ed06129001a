"""Breakpoints of the MC1451A family: seven conditions, when each fires, and what it brings into force."""

from __future__ import annotations

from itertools import permutations

import pytest
from mc import AXES, ENCODERS, ONE, PARTS, T1, T1_CYCLES, T4, TRAPEZOID, V1, base, each, with_axes, with_encoder
from mc_motion import Look, Mover, mover

UNIT = ONE // 64  # the acceleration of T1
SHORT = (f"SET_VEL {ONE}", f"SET_ACC {ONE}", "SET_POS 50")  # fifty cycles, a step in each
FIRED = 4  # bit 2 of the status word
BLIND = ("MTN_CMPLT", "EXT")  # kinds that do not look at the comparison value
VALUES = {"POS": 5, "NEG": -5, "ACTL_POS": 5, "ACTL_NEG": -5}
KINDS = ("TIME", *VALUES, *BLIND)
SOON = 30  # cycles, up to what a breakpoint on time waits for here

each_kind = pytest.mark.parametrize(
    ("part", "kind"),
    [
        pytest.param(part, kind, marks=[pytest.mark.long] * (AXES[part] == 2))
        for part in PARTS
        for kind in KINDS
        if part in ENCODERS or "ACTL" not in kind
    ],
)


def arm(rig: Mover, kind: str) -> None:
    """Arm a breakpoint whose condition is not met."""
    if kind not in BLIND:
        rig.do(f"SET_BRK_PNT {VALUES.get(kind, rig.cycle + SOON)}")
    rig.do(f"SET_{kind}_BRK")


def meet(rig: Mover, kind: str) -> None:
    """Let the condition of a kind be met, without a motion."""
    if kind == "TIME":
        rig.next(SOON)
    elif kind == "MTN_CMPLT":
        rig.do("STOP", "UPDATE")
    elif kind == "EXT":
        rig.drive("home1", 0)
    else:
        rig.do(f"SET_ACTL_POS {2 * VALUES[kind]}")
    rig.next(3)


def unmeet(rig: Mover, kind: str) -> None:
    """Let no condition be met, and clear the events."""
    rig.drive("home1", 1)
    rig.do("SET_ACTL_POS 0")
    if kind == "TIME":
        rig.do(f"SET_BRK_PNT {rig.cycle + SOON}")
    rig.do("CLR_STATUS")


def fired(rig: Mover) -> bool:
    """Has a breakpoint fired since its event was cleared?"""
    return bool(rig.look().status & FIRED)


def first(looks: list[Look]) -> int:
    """In which of these cycles the event stands first; from there on it does."""
    events = [bool(look.status & FIRED) for look in looks]
    assert events == sorted(events) and any(events)
    return events.index(True)


# ------------------------------------------------------------------------------------------------------ of every kind
@each_kind
@pytest.mark.fact("PMD-BRK-11", "PMD-BRK-12")
def test_a_breakpoint_fires_once_and_its_bit_stays(part: str, kind: str) -> None:
    rig = mover(part)
    arm(rig, kind)
    rig.next(5)
    assert not fired(rig)
    meet(rig, kind)
    assert fired(rig)
    rig.next(50)
    assert fired(rig)
    for _ in range(2):
        unmeet(rig, kind)
        meet(rig, kind)
        assert not fired(rig)


@each_kind
@pytest.mark.parametrize("auto_update", ["ON", "OFF"])
@pytest.mark.fact("PMD-BRK-25", "PMD-BRK-13", "PMD-BRK-14", "PMD-UND-BRK-OFF-AUTO")
@pytest.mark.fact("PMD-CMD-SET_AUTO_UPDATE_ON-1", "PMD-CMD-SET_AUTO_UPDATE_OFF-1")
def test_it_is_an_update_unless_auto_update_is_off_and_fires_once_all_the_same(
    part: str, kind: str, auto_update: str
) -> None:
    rig = mover(part)
    arm(rig, kind)
    rig.do(*SHORT, f"SET_AUTO_UPDATE_{auto_update}")
    meet(rig, kind)
    rig.next(3)
    assert fired(rig) and bool(rig.ticks()) == (auto_update == "ON")
    rig.do("SET_AUTO_UPDATE_ON")
    rig.rest()
    unmeet(rig, kind)
    steps = rig.ticks()
    meet(rig, kind)
    assert not fired(rig) and rig.ticks() == steps


@each_kind
@pytest.mark.fact("PMD-BRK-15", "PMD-BRK-16", "PMD-CMD-SET_BRK_OFF-1", "PMD-UND-BRK-OFF-LIST", "PMD-CON-BRK-OFF-LIST")
def test_set_brk_off_disarms_it(part: str, kind: str) -> None:
    rig = mover(part)
    rig.do(*SHORT)
    arm(rig, kind)
    rig.says("6d > 006d")
    meet(rig, kind)
    assert not fired(rig) and rig.ticks() == []


@each_kind
@pytest.mark.fact("PMD-UND-BRK-UPDATE")
def test_an_update_leaves_it_armed(part: str, kind: str) -> None:
    rig = mover(part)
    rig.do("SET_PRFL_VEL", f"SET_VEL {ONE}")  # without acceleration nothing starts, so nothing completes
    arm(rig, kind)
    rig.begin()
    assert not fired(rig)
    meet(rig, kind)
    assert fired(rig)


@each_kind
@pytest.mark.fact("PMD-BRK-22", "PMD-BRK-13")
def test_it_interrupts_if_bit_2_of_the_mask_is_set(part: str, kind: str) -> None:
    for mask, line in (("0xFA", 1), ("4", 0)):
        rig = mover(part)
        rig.do(f"SET_INTRPT_MASK {mask}", "SET_AUTO_UPDATE_OFF")
        arm(rig, kind)
        meet(rig, kind)
        assert fired(rig) and rig.level("hostintrpt") == line


@pytest.mark.parametrize(("kind", "last"), [pair for pair in permutations(KINDS, 2) if {*pair} & {*BLIND}])
@pytest.mark.fact("PMD-BRK-18", "PMD-UND-BRK-REPLACE")
def test_the_kind_that_is_armed_last_replaces_the_one_before(kind: str, last: str) -> None:
    rig = mover("mc1151a-e")
    arm(rig, kind)
    arm(rig, last)
    meet(rig, kind)
    assert not fired(rig)
    meet(rig, last)
    assert fired(rig)


# ------------------------------------------------------------------------------------------------------------ positions
@each
@pytest.mark.fact("PMD-BRK-1", "PMD-BRK-25", "PMD-CMD-SET_POS_BRK-1")
def test_a_target_at_the_value_or_above_changes_the_speed_in_the_next_cycle(part: str) -> None:
    rig = mover(part)
    rig.begin(*T1, "SET_BRK_PNT 500", "SET_POS_BRK")
    rig.do("SET_VEL 0x8000")
    rig.next()
    looks = rig.trace(700)
    at = first(looks)
    assert [looks[n].pos for n in (at - 1, at)] == [499, 500]
    assert [look.vel for look in looks[at - 1 : at + 3]] == [ONE, ONE, ONE - UNIT, ONE - 2 * UNIT]
    assert looks[at + 40].vel == 0x8000


@each
@pytest.mark.fact("PMD-BRK-2", "PMD-BRK-21", "PMD-BRK-25", "PMD-CMD-SET_NEG_BRK-1", "PMD-UND-BRK-SIGN")
def test_a_target_at_the_value_or_below_stops_the_axis_in_the_next_cycle(part: str) -> None:
    rig = mover(part)
    rig.begin(*T4, "SET_BRK_PNT -500", "SET_NEG_BRK")
    rig.do("STOP")
    rig.next()
    looks = rig.trace(700)
    at = first(looks)
    assert [look[:2] for look in looks[at - 1 : at + 2]] == [(-499, -ONE), (-500, -ONE), (-501, 0)]
    assert (looks[-1].pos, looks[-1].status) == (-501, 0x0305)


@each
@pytest.mark.fact("PMD-BRK-21", "PMD-BRK-1")
def test_the_axis_halts_a_cycle_after_the_position_every_time(part: str) -> None:
    rig = mover(part)
    for _ in range(3):
        rig.begin(*T1, "SET_BRK_PNT 500", "SET_POS_BRK")
        rig.do("STOP")
        rig.rest()
        assert rig.look()[:3] == (501, 0, 0x0305)
        rig.do("SET_ACTL_POS 0", "CLR_STATUS")


@each
@pytest.mark.fact("PMD-BRK-11", "PMD-BRK-14")
def test_passing_the_position_back_and_forth_does_not_fire_again(part: str) -> None:
    rig = mover(part)
    rig.do("SET_AUTO_UPDATE_OFF", "SET_BRK_PNT 20", "SET_POS_BRK")
    rig.begin(*SHORT)
    rig.rest()
    assert fired(rig)
    rig.do("CLR_STATUS", "SET_AUTO_UPDATE_ON")
    for position in (0, 50, 0):
        rig.begin(f"SET_POS {position}")
        rig.rest()
        assert rig.x.position == position and not fired(rig)


@each
@pytest.mark.fact("PMD-BRK-13", "PMD-CMD-SET_AUTO_UPDATE_OFF-1")
def test_with_auto_update_off_the_speed_waits_for_the_host(part: str) -> None:
    rig = mover(part)
    rig.begin(*T1, "SET_BRK_PNT 200", "SET_POS_BRK", "SET_AUTO_UPDATE_OFF")
    rig.do("SET_VEL 0x8000")
    rig.next()
    looks = rig.trace(400)
    assert looks[first(looks)].pos == 200
    assert {look.vel for look in looks[63:]} == {ONE}
    rig.begin()
    assert rig.look().vel == ONE - UNIT


@each
@pytest.mark.fact("PMD-BRK-19", "PMD-UND-BRK-VALUE")
def test_a_value_that_is_written_later_counts(part: str) -> None:
    rig = mover(part)
    n = rig.begin(*T1, "SET_BRK_PNT 500", "SET_POS_BRK")
    rig.to(n + 300)
    rig.do("SET_BRK_PNT 700")
    rig.next()
    looks = rig.trace(500)
    assert looks[first(looks)].pos == 700


@each
@pytest.mark.fact("PMD-BRK-19", "PMD-UND-BRK-VALUE")
def test_a_value_counts_from_the_cycle_after_the_command(part: str) -> None:
    rig = mover(part)
    rig.do("SET_BRK_PNT 5", "SET_POS_BRK")
    cycle = rig.next()
    rig.host.write_command(0x16)
    for _ in range(2):
        rig.host.write_word(0)
    rig.bench.run_until(rig.x.pin("hostrdy").is_(1))
    assert rig.cycle == cycle and not fired(rig)
    rig.next()
    assert fired(rig)


@each
@pytest.mark.fact("PMD-BRK-20", "PMD-UND-BRK-TRUE", "PMD-UND-BRK-SIGN")
def test_a_position_that_satisfies_it_already_fires_in_the_next_cycle(part: str) -> None:
    rig = mover(part)
    rig.do("SET_ACTL_POS 1000")
    for kind, value, at_once in (
        *(("POS", 500, True), ("POS", 1000, True), ("POS", 1001, False)),
        *(("NEG", 1500, True), ("NEG", 1000, True), ("NEG", 999, False)),
        *(("POS", -1, True), ("POS", -(1 << 31), True), ("NEG", -1, False), ("NEG", (1 << 31) - 1, True)),
    ):
        rig.do("SET_BRK_OFF", "CLR_STATUS", f"SET_BRK_PNT {value}")
        rig.next()
        rig.do(f"SET_{kind}_BRK")
        assert not fired(rig)
        rig.next()
        assert fired(rig) == at_once, (kind, value)
        rig.next(20)
        assert fired(rig) == at_once, (kind, value)


# -------------------------------------------------------------------------------------------------------------- actual
@with_encoder
@pytest.mark.parametrize(("kind", "way"), [("ACTL_POS", 1), ("ACTL_NEG", -1)])
@pytest.mark.fact("PMD-BRK-3", "PMD-BRK-4", "PMD-CMD-SET_ACTL_POS_BRK-1", "PMD-CMD-SET_ACTL_NEG_BRK-1")
@pytest.mark.fact("PMD-CON-BRK-UNITS")
def test_actual_positions_are_compared_in_counts(part: str, kind: str, way: int) -> None:
    rig = mover(part, quadrature={})
    rig.do("SET_STEP_RATIO 0x200", f"SET_BRK_PNT {way * 30}", f"SET_{kind}_BRK")  # 30 counts are 15 steps
    rig.do(*TRAPEZOID, f"SET_POS {way * 8}")  # the target goes nowhere near 30
    rig.begin()
    counts = []
    for _ in range(60):
        rig.shafts["quadrature"].push(way)
        rig.next()
        counts.append((rig.shows("actl_pos"), fired(rig)))
    assert [count for count, _ in counts] == [way * n for n in range(1, 61)]
    assert [event for _, event in counts] == [n >= 30 for n in range(1, 61)]


@pytest.mark.parametrize("part", [part for part in PARTS if part not in ENCODERS])
@pytest.mark.parametrize(("kind", "value", "fires"), [("ACTL_POS", 0, True), ("ACTL_POS", 1, False),
                                                      ("ACTL_NEG", 0, True), ("ACTL_NEG", -1, False)])  # fmt: skip
@pytest.mark.fact("PMD-UND-BRK-NOENC")
def test_without_an_encoder_chip_the_actual_position_is_0(part: str, kind: str, value: int, fires: bool) -> None:
    rig = mover(part)
    rig.do(f"SET_ACTL_POS {9 if value > 0 else -9}", f"SET_BRK_PNT {value}", f"SET_{kind}_BRK")
    rig.next(20)
    assert fired(rig) == fires


# ---------------------------------------------------------------------------------------------------------------- time
@each
@pytest.mark.fact("PMD-BRK-5", "PMD-BRK-22", "PMD-BRK-25", "PMD-CMD-SET_TIME_BRK-1")
def test_a_time_fires_in_its_cycle_and_starts_the_move_in_the_next(part: str) -> None:
    rig = mover(part, "hostintrpt")
    brk = rig.do("GET_TIME") + 1000
    rig.do(f"SET_BRK_PNT {brk}", "SET_INTRPT_MASK 4", "SET_TIME_BRK", *T1)
    rig.to(brk - 1)
    assert not fired(rig)
    rig.to(brk)
    assert fired(rig) and rig.look().vel == 0
    rig.rest()
    assert rig.lows("atrest1") == [(brk + 1, T1_CYCLES)]
    assert [rig.in_cycles(fall) for fall in rig.falls("hostintrpt", rig.at(1))] == [brk]


@each
@pytest.mark.fact("PMD-BRK-6", "PMD-UND-BRK-TRUE", "PMD-UND-BRK-SIGN")
def test_a_past_time_fires_when_the_32_bits_have_wrapped(part: str) -> None:
    rig = mover(part)
    rig.to(100)
    rig.do("SET_BRK_PNT 90", "SET_TIME_BRK")
    rig.to((1 << 32) + 89)
    assert not fired(rig)
    rig.to((1 << 32) + 90)
    assert fired(rig)


@each
@pytest.mark.fact("PMD-UND-BRK-SIGN")
def test_a_time_has_no_sign(part: str) -> None:
    rig = mover(part)
    rig.do("SET_BRK_PNT 0x80000001", "SET_TIME_BRK")
    rig.to(1 << 31)
    assert not fired(rig)
    rig.next()
    assert fired(rig)


@with_axes
@pytest.mark.fact("PMD-BRK-23")
def test_axes_with_the_same_time_start_in_the_same_cycle(part: str) -> None:
    axes = range(1, AXES[part] + 1)
    rig = base(part, *(f"atrest{axis}" for axis in axes))
    for axis in axes:
        rig.do(*T1, "SET_BRK_PNT 100", "SET_TIME_BRK", axis=axis)
    rig.to(102)
    rig.rest()
    assert [rig.lows(f"atrest{axis}") for axis in axes] == [[(101, T1_CYCLES)]] * AXES[part]


@with_axes
@pytest.mark.fact("PMD-BRK-17", "PMD-BUF-11")
def test_axes_have_breakpoints_of_their_own(part: str) -> None:
    rig = mover(part)
    rig.do("SET_BRK_PNT 100", "SET_TIME_BRK", axis=1)
    rig.do("SET_BRK_PNT 20", "SET_POS_BRK", axis=2)
    rig.begin(*SHORT)
    one, two = [], []
    for _ in range(100):
        one.append(rig.look(1))
        two.append(rig.look(2))
        rig.next()
    begun = rig.cycle - 100
    assert begun + first(one) == 100
    assert two[first(two)].pos == 20
    assert {look.pos for look in one} == {0}


# ----------------------------------------------------------------------------------------------------- motion complete
@each
@pytest.mark.fact("PMD-BRK-7", "PMD-BRK-25", "PMD-CMD-SET_MTN_CMPLT_BRK-1")
def test_the_end_of_a_motion_starts_the_next_one(part: str) -> None:
    rig = mover(part)
    n = rig.begin(*T1)
    rig.do("SET_POS 2000", "SET_MTN_CMPLT_BRK")
    rig.to(n + T1_CYCLES)
    assert rig.look().status == 0x0305
    rig.next()
    assert rig.look().status == 0x0705
    rig.rest()
    assert rig.lows("atrest1") == [(n, T1_CYCLES), (n + T1_CYCLES + 1, T1_CYCLES)]  # a cycle of rest between them
    assert rig.x.position == 2000


@each
@pytest.mark.fact("PMD-BRK-8", "PMD-UND-BRK-TRUE", "PMD-BRK-24")
def test_motion_complete_that_is_still_set_fires_in_the_next_cycle(part: str) -> None:
    rig = mover(part)
    rig.begin(*T1, "SET_BRK_PNT 0x7FFFFFFF")
    rig.rest()
    rig.do("SET_POS 2000")
    n = rig.next()
    rig.do("SET_MTN_CMPLT_BRK")
    assert rig.look().status == 0x0301
    rig.next()
    assert rig.look().status == 0x0305
    rig.rest()
    assert rig.lows("atrest1")[-1] == (n + 2, T1_CYCLES)


# ---------------------------------------------------------------------------------------------------------------- home
@each
@pytest.mark.fact("PMD-BRK-9", "PMD-BRK-24", "PMD-BRK-25", "PMD-CMD-SET_EXT_BRK-1")
def test_home_stops_the_axis(part: str) -> None:
    rig = mover(part)
    n = rig.begin(*T1, "SET_BRK_PNT 0x7FFFFFFF", "SET_EXT_BRK")
    rig.do("STOP")
    rig.drive("home1", 0, at=rig.at(n + 300, 4096))
    rig.to(n + 300)
    looks = rig.trace(5)
    assert [(look.vel, look.status) for look in looks] == [(ONE, 0x0700), (ONE, 0x0704), *[(0, 0x0305)] * 3]


@each
@pytest.mark.fact("PMD-BRK-10", "PMD-UND-BRK-TRUE")
def test_a_home_that_is_low_already_fires_in_the_next_cycle(part: str) -> None:
    rig = mover(part)
    rig.drive("home1", 0)
    rig.do(*T1)
    n = rig.next()
    rig.do("SET_EXT_BRK")
    rig.to(n + 1)
    assert rig.look().status == 0x0304
    rig.to(n + 2)
    rig.rest()
    assert rig.lows("atrest1") == [(n + 2, T1_CYCLES)]


@with_axes
@pytest.mark.fact("PMD-BRK-9", "PMD-BRK-17")
def test_each_axis_has_its_own_home(part: str) -> None:
    rig = base(part)
    axes = range(1, AXES[part] + 1)
    for axis in axes:
        rig.do("SET_EXT_BRK", axis=axis)
    for axis in axes:
        rig.drive(f"home{axis}", 0)
        rig.next(2)
        assert [bool(rig.x.axis(other).registers["status"] & FIRED) for other in axes] == [o <= axis for o in axes]


# --------------------------------------------------------------------------------------------------------------- reset
@each
@pytest.mark.fact("PMD-UND-BRK-RESET", "PMD-RESET-6")
def test_after_a_reset_no_breakpoint_is_armed(part: str) -> None:
    rig = mover(part)
    rig.next(1000)
    assert rig.look().status == 0x0300
    rig.do("SET_BRK_PNT 5", "SET_POS_BRK")  # with value 0 it would be met behind the reset
    rig.do("RESET")
    rig.next(1000)
    assert rig.look().status == 0x0300


@each
@pytest.mark.fact("PMD-UND-CYCLE-ORDER")
def test_a_cycle_tests_breakpoints_after_its_update_and_acts_on_them_in_the_next(part: str) -> None:
    rig = mover(part)
    n = rig.begin(*V1)
    rig.to(n + 74)
    rig.heeds(n + 80, "SET_MTN_CMPLT_BRK", "STOP", "UPDATE")
    assert rig.look()[1:3] == (0, 0x0305)  # the stop completes the motion, the breakpoint sees it in the same cycle
    rig.next()
    assert rig.look()[1:3] == (UNIT, 0x0705)  # and its update starts anew in the next
