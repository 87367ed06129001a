"""Over-travel of the MC1451A family: a limit switch halts its axis, and the axis is brought back; homing."""

from __future__ import annotations

import pytest
from mc import ONE, S1, T1, T1_CYCLES, TRAPEZOID, V1, each
from mc_motion import Mover, mover

DOWN = range(ONE - ONE // 64, 0, -ONE // 64)
modes = pytest.mark.parametrize("setup", [T1, V1, S1], ids=["trapezoid", "velocity", "s-curve"])


def halted(setup: tuple[str, ...] = T1, switch: str = "poslimit1") -> tuple[Mover, int]:
    """An axis in the cycle in which a switch has halted it, 500 cycles behind its start, which is returned."""
    rig = mover("mc1151a", "pulse1")
    begun = rig.begin(*setup)
    rig.to(begun + 499, 4000)
    rig.drive(switch, 1)
    rig.to(begun + 500)
    return rig, begun


# ------------------------------------------------------------------------------------------------------------- the halt
@modes
@pytest.mark.fact("PMD-LIMIT-2", "PMD-LIMIT-3", "PMD-STAT-22")
@pytest.mark.parametrize(("switch", "bit"), [("poslimit1", 0x20), ("neglimit1", 0x40)])
def test_a_switch_halts_its_axis_immediately(setup: tuple[str, ...], switch: str, bit: int) -> None:
    rig, begun = halted(setup, switch)
    place = 452 if setup is S1 else 468
    assert rig.look() == (place, 0, 0x301 | bit, 0) and rig.level("atrest1") == 1
    rig.next(100)
    assert rig.moves() == [place] and rig.lows("atrest1") == [(begun, 500)]
    assert not rig.edges("pulse1", rig.at(begun + 500) + 1) and rig.do("GET_TRGT_VEL") == 0


@pytest.mark.fact("PMD-LIMIT-3", "PMD-CON-MC-GEAR", "PMD-UND-LIMIT-VEL", "PMD-UND-MC-GEAR", "PMD-UND-LIMIT-MC")
def test_a_switch_halts_an_axis_in_gear_until_an_update_after_a_cleared_bit() -> None:
    rig = mover("mc1151a-e")
    begun = rig.begin("SET_PRFL_GEAR", f"SET_RATIO {ONE}")
    rig.turn(100, apart=8192)
    rig.to(begun + 20, 4000)
    rig.drive("poslimit1", 1)
    rig.to(begun + 21)
    assert rig.look() == (19, 0, 0x320, 0)
    rig.drive("poslimit1", 0)
    rig.begin()
    assert {look.vel for look in rig.trace(5)} == {0}  # the bit is set
    rig.do("CLR_STATUS")
    rig.next()
    assert {look.vel for look in rig.trace(5)} == {0}  # no update yet
    rig.begin()
    assert [look.vel for look in rig.trace(5)] == [0] + [ONE] * 4 and rig.status() == 0x300


@pytest.mark.fact("PMD-UND-LIMIT-VEL", "PMD-UND-LIMIT-OUT")
def test_with_the_bit_set_the_gear_does_not_begin_to_follow() -> None:
    rig = mover("mc1151a-e")
    rig.drive("poslimit1", 1)
    rig.next()
    rig.drive("poslimit1", 0)
    rig.begin("SET_PRFL_GEAR", f"SET_RATIO {ONE}")
    rig.turn(30, apart=8192)
    rig.next(10)
    assert rig.look() == (0, 0, 0x321, 0)
    rig.begin("CLR_STATUS")
    rig.next(3)
    assert rig.look()[1:] == (ONE, 0x300, 0)


@pytest.mark.fact("PMD-UND-LIMIT-VEL")
def test_the_gear_drops_steps_towards_an_active_switch() -> None:
    rig = mover("mc1151a-e")
    rig.drive("poslimit1", 1)
    rig.next()
    rig.begin("CLR_STATUS", "SET_PRFL_GEAR", f"SET_RATIO {ONE}")
    rig.turn(10, apart=8192)
    rig.next(15)
    assert rig.look() == (0, 0, 0x300, 0)
    rig.turn(-10, apart=8192)
    rig.next(15)
    assert rig.look() == (-10, 0, 0x300, 0) and rig.moves() == [-10]


@each
@pytest.mark.fact("PMD-LIMIT-8")
def test_with_sensing_off_nothing_is_halted(part: str) -> None:
    rig = mover(part)
    rig.do("LMTS_OFF")
    begun = rig.begin(*T1)
    rig.to(begun + 200)
    rig.drive("poslimit1", 1)
    rig.rest()
    assert rig.status() == 0x301 and rig.do("GET_TRGT_POS") == 1000
    assert rig.lows("atrest1") == [(begun, T1_CYCLES)]


# ------------------------------------------------------------------------------------------------------------- refusals
@pytest.mark.fact("PMD-ERRC-17", "PMD-UND-LIMIT-REFUSED")
@pytest.mark.parametrize("mode", ["SET_PRFL_TRAP", "SET_PRFL_S_CRV"])
@pytest.mark.parametrize(("switch", "way"), [("poslimit1", 1), ("neglimit1", -1)])
def test_a_move_into_an_active_limit_is_refused_and_the_next_update_decides_again(
    mode: str, switch: str, way: int
) -> None:
    rig = mover("mc1151a")
    rig.drive(switch, 1)
    rig.next(2)
    rig.do("CLR_STATUS", *TRAPEZOID, "SET_MAX_ACC 0x400", "SET_JERK 0x200000", mode)
    rig.begin(f"SET_POS {50 * way}")
    assert rig.look() == (0, 0, 0x380, 0)
    rig.next(200)
    assert not rig.ticks() and rig.status() == 0x380 and not rig.lows("atrest1")
    rig.begin("CLR_STATUS", f"SET_POS {-50 * way}")
    rig.rest()
    assert rig.moves() == [-50 * way] and rig.status() == 0x301
    rig.drive(switch, 0)
    rig.next()
    rig.begin(f"SET_POS {50 * way}")
    rig.rest()
    assert rig.shows("trgt_pos") == 50 * way and rig.status() == 0x301


@pytest.mark.fact("PMD-LIMIT-15", "PMD-UND-LIMIT-VEL")
@pytest.mark.parametrize(
    ("switch", "into", "out"), [("poslimit1", "0x400", "-0x400"), ("neglimit1", "-0x400", "0x400")]
)
def test_velocity_contouring_into_an_active_limit_does_not_move_or_report(switch: str, into: str, out: str) -> None:
    rig = mover("mc1151a")
    rig.drive(switch, 1)
    rig.next(2)
    rig.begin("CLR_STATUS", *V1, f"SET_ACC {into}")
    rig.next(100)
    assert not rig.ticks() and rig.look() == (0, 0, 0x300, 0)
    rig.begin(f"SET_ACC {out}")
    rig.next(100)
    assert rig.ticks() and rig.status() == 0x700


@pytest.mark.fact("PMD-LIMIT-12", "PMD-UND-LIMIT-OUT", "PMD-CON-LIMIT-COMMAND-ERROR")
def test_with_the_bit_set_a_move_out_is_refused() -> None:
    rig, _ = halted()
    rig.begin("SET_POS 0")
    assert rig.look() == (468, 0, 0x3A1, 0)
    rig.next(100)
    assert rig.moves() == [468] and rig.status() == 0x3A1


@pytest.mark.fact("PMD-UND-LIMIT-OUT")
@pytest.mark.parametrize("nothing", [("STOP",), ("SET_POS 468",), ("MTR_OFF",)])
def test_with_the_bit_set_updates_that_start_nothing_are_tolerated(nothing: tuple[str, ...]) -> None:
    rig = mover("mc1151a")
    rig.begin("SET_VEL 0x10000", "SET_ACC 0x10000", "SET_POS 468")
    rig.rest()
    rig.drive("poslimit1", 1)
    rig.begin("SET_POS 0", *nothing)
    assert rig.shows("status") & 0xFF == 0x21


# ---------------------------------------------------------------------------------------------------------- the way out
@pytest.mark.fact("PMD-LIMIT-10", "PMD-LIMIT-11", "PMD-UND-LIMIT-OUT")
def test_with_the_bit_cleared_the_axis_leaves_the_active_switch_and_arms_it_again() -> None:
    rig, begun = halted()
    rig.says("34 ffde > 0012")
    out = rig.begin("SET_POS 0")
    looks = rig.trace(100)
    assert looks[-1].vel == -ONE and {look.status for look in looks} == {0x700}
    rig.drive("poslimit1", 0)
    assert {look.status for look in rig.trace(10)} == {0x700}
    rig.drive("poslimit1", 1)
    rig.next(1)
    assert rig.look()[1:3] == (0, 0x321)
    assert rig.lows("atrest1") == [(begun, 500), (out, 111)]


@pytest.mark.fact("PMD-LIMIT-20", "PMD-UND-LIMIT-OUT")
def test_the_axis_may_also_leave_with_sensing_off() -> None:
    rig, _ = halted()
    rig.do("LMTS_OFF", "CLR_STATUS")
    for place in (460, 450, 440):  # small moves
        rig.begin(f"SET_POS {place}")
        rig.rest()
    assert rig.do("GET_TRGT_POS") == 440
    rig.drive("poslimit1", 0)
    rig.do("LMTS_ON", "CLR_STATUS")
    rig.next(10)
    assert rig.status() == 0x300 and rig.moves() == [468, -28]


@pytest.mark.fact("PMD-UND-LIMIT-OUT")
def test_with_sensing_off_a_set_bit_refuses_nothing() -> None:
    rig, _ = halted()
    rig.begin("LMTS_OFF", "SET_POS 400")
    assert rig.look().status == 0x721
    rig.rest()
    assert rig.moves() == [468, -68]


# --------------------------------------------------------------------------------------------------------------- homing
HOMING = ("10 0000 3039 > 3049", "11 0000 5ba0 > 5bb1", "12 0000 0159 > 016b", "1a > 001a", "5e > 005e", "46 > 0046")


@pytest.mark.fact("PMD-HOME-1")
def test_a_homing_move_ends_at_the_home_switch() -> None:
    rig = mover("mc1451a")
    rig.says("05 > 000f 0014", *HOMING)
    rig.bench.run_until(rig.x.reaches(1000))
    met = rig.cycle + 1
    rig.drive("home1", 0)
    rig.rest()
    assert rig.lows("atrest1")[0][0] + rig.lows("atrest1")[0][1] == met + 1
    assert rig.status() == 0x305 and rig.x.position in (1000, 1001) and rig.moves() == [rig.x.position]
    assert rig.do("GET_HOME") == 0xE


@pytest.mark.fact("PMD-HOME-5", "PMD-UND-HOME-HOMED")
def test_at_home_already_the_stop_waits_for_another_update() -> None:
    rig = mover("mc1151a", straps={"home1": 0})
    *move, stop = HOMING
    rig.says("05 > 0000 0005", *move)
    armed = rig.cycle
    rig.to(armed + 1)
    assert rig.shows("status") == 0x704
    rig.next()
    rig.says(stop)
    rig.next(200)
    assert rig.status() == 0x704
    rig.begin()
    assert rig.look().vel == 0 and rig.look().status == 0x305


@each
@pytest.mark.fact("PMD-HOME-4")
def test_home_does_not_affect_an_axis_without_its_breakpoint(part: str) -> None:
    rig = mover(part)
    begun = rig.begin(*T1)
    for level in (0, 1) * 5:
        rig.drive("home1", level)
        rig.next(20)
        assert rig.shows("status") == 0x700
    rig.rest()
    assert rig.lows("atrest1") == [(begun, T1_CYCLES)] and rig.status() == 0x301


@pytest.mark.fact("PMD-HOME-6")
@pytest.mark.parametrize(
    ("low", "width", "seen"),
    [(100, 8192, True), (100, 25, False), *((8192 - early, 25, early in range(13, 38)) for early in (12, 13, 37, 38))],
)
def test_home_is_sampled_once_per_cycle(low: int, width: int, seen: bool) -> None:
    rig = mover("mc1151a")
    rig.do("SET_AUTO_UPDATE_OFF", "SET_EXT_BRK")
    cycle = rig.next(2)
    rig.drive("home1", 0, at=rig.at(cycle, low))
    rig.drive("home1", 1, at=rig.at(cycle, low + width))
    rig.to(cycle + 3)
    assert rig.shows("status") == (0x304 if seen else 0x300)
