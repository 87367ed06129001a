"""What the MC1451A family does on its pins: PULSE and DIR to the clock, AtRest, home inputs, inputs that are open.

cycle     |    v = 1    |   v = 1     |  v = -1     |
PULSE     ______/‾‾‾‾‾‾‾\\_____/‾‾‾‾‾‾‾\\_____/‾‾‾‾‾‾‾\\      every fall is a step
DIR       ‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\\______________      the cycle that turns round begins with it
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence

import pytest
from mc import (
    AXES,
    MS,
    NS,
    ONE,
    READY,
    S1,
    S1_CYCLES,
    T1,
    T1_CYCLES,
    T4,
    US,
    Rig,
    base,
    each,
    gaps,
    with_axes,
    with_encoder,
)

import slewline
from slewline.errors import UnknownName

TICK = 40 * NS
CYCLE = 8192 * TICK


def drawn(displacements: Sequence[int]) -> list[tuple[int, int]]:
    """(tick, level) of PULSE for displacements cycle by cycle, found clock by clock: the law as it stands."""
    found, lead, level = [], 0, 0  # lead: target minus steps made, in 1/8192 of 1/65536 step
    for cycle, displacement in enumerate(displacements):
        way, before = (1 if displacement > 0 else -1), lead
        for tick in range(1, 8193) if displacement else ():
            lead = before + displacement * tick
            if way * lead >= 8192 * ONE:
                before -= way * 8192 * ONE
                lead -= way * 8192 * ONE
                found.append((8192 * cycle + tick, level := 0))
            elif way * lead >= 8192 * ONE // 2 and not level:
                found.append((8192 * cycle + tick, level := 1))
    return found


def shown(rig: Rig, begun: int) -> list[tuple[int, int]]:
    """(tick, level) of PULSE since the begin of a cycle."""
    ticks_until = rig.x.clock.ticks_until
    return [(ticks_until(time - rig.at(begun)), level) for time, level in rig.edges("pulse1", rig.at(begun) + 1)]


def steady(velocity: int, *setup: str, cycles: int = 12) -> tuple[Rig, int]:
    """An axis at a velocity since the cycle that is returned; PULSE is recorded."""
    rig = base("mc1151a", "pulse1")
    begun = rig.begin(*setup, "SET_PRFL_VEL", f"SET_VEL {velocity}", f"SET_ACC {velocity}")
    rig.next(cycles)
    return rig, begun


# -------------------------------------------------------------------------------------------------------- PULSE and DIR
@each
@pytest.mark.fact("PMD-PULSE-1", "PMD-PULSE-2", "PMD-UND-DIR-IDLE", "PMD-UND-PULSE-IDLE")
@pytest.mark.parametrize(("profile", "way"), [(T1, 1), (T4, -1)])
def test_a_step_is_a_fall_of_pulse_in_the_direction_of_dir(part: str, profile: tuple[str, ...], way: int) -> None:
    rig = base(part, "pulse1", "dir1")
    assert (rig.level("pulse1"), rig.level("dir1")) == (0, 1)
    begun = rig.begin(*profile)
    rig.rest()
    falls = rig.falls("pulse1", rig.at(READY))
    assert len(falls) == 1000 == len(rig.rises("pulse1", rig.at(READY)))
    assert falls == rig.pulses() and rig.x.position == way * 1000
    turns = rig.edges("dir1", rig.at(READY))
    assert turns == ([] if way > 0 else [(rig.at(begun), 0)])
    rig.next(100)
    assert (rig.level("pulse1"), rig.level("dir1")) == (0, int(way > 0))


@pytest.mark.fact("PMD-PULSE-3", "PMD-PULSE-11", "PMD-UND-PULSE-PHASE")
@pytest.mark.parametrize(("velocity", "setup"), [(ONE // 4, ()), (ONE, ()), (3 * ONE, ()), (16 * ONE, ())])
def test_pulse_is_a_square_wave_evenly_spaced_across_the_cycles(velocity: int, setup: tuple[str, ...]) -> None:
    rig, begun = steady(velocity, *setup)
    edges = shown(rig, begun)
    half = ONE * 8192
    assert edges == [(-(-(n + 1) * half // (2 * velocity)), (n + 1) % 2) for n in range(len(edges))]
    assert len(edges) in (2 * 12 * velocity // ONE, 2 * 12 * velocity // ONE + 1)


@pytest.mark.fact("PMD-PULSE-3", "PMD-PULSE-11")
def test_high_and_low_times_of_pulse() -> None:
    rig, begun = steady(ONE // 4)
    assert set(gaps([tick for tick, _ in shown(rig, begun)])) == {655_360_000 // TICK}  # 655.36 us each
    rig, begun = steady(3 * ONE)
    falls = [tick for tick, level in shown(rig, begun) if level == 0]
    assert set(gaps(falls)) == {2730, 2731} and falls[2::3] == [8192 * n for n in range(1, len(falls) // 3 + 1)]


@pytest.mark.fact("PMD-PULSE-5")
def test_the_standard_range_is_16_steps_per_cycle() -> None:
    rig, begun = steady(16 * ONE, cycles=3052)
    assert set(gaps(rig.pulses(rig.at(begun)))) == {20_480 * NS}
    assert sum(time <= rig.at(begun) + 10**12 for time in rig.pulses()) == 48_828


@pytest.mark.fact("PMD-PULSE-6")
def test_the_high_range_is_512_steps_per_cycle() -> None:
    rig, begun = steady(512 * ONE, "SET_OUTPUT_HIGH", cycles=62)
    edges = rig.edges("pulse1", rig.at(begun) + 1)
    assert set(gaps([time for time, _ in edges])) == {320 * NS}
    assert sum(time <= rig.at(begun) + 20 * MS for time in rig.pulses()) == 31_250


@pytest.mark.fact("PMD-PULSE-14")
def test_a_slow_rate_is_not_a_burst_per_cycle() -> None:
    rig, begun = steady(0x100, cycles=1300)
    falls = rig.falls("pulse1", rig.at(begun))
    assert falls == [rig.at(begun + 256 * n) for n in range(1, 6)]  # 83.886 ms


@pytest.mark.fact("PMD-UND-PULSE-PHASE", "PMD-UND-FRACTION", "PMD-UND-DIR-TIMING", "PMD-UND-PULSE-IDLE")
@pytest.mark.parametrize("stopped", [3, 4, 5, 6])
def test_pulse_follows_the_target_clock_by_clock_through_stop_and_reversal(stopped: int) -> None:
    rig = base("mc1151a", "pulse1", "dir1")
    begun = rig.begin("SET_VEL 0x1F123", "SET_ACC 0x5431", "SET_POS 100")
    displacements: list[int] = []
    for cycle in range(begun, begun + 40):
        rig.bench.at(rig.at(cycle, 1), lambda: displacements.append(rig.shows("trgt_vel")))
    rig.to(begun + stopped - 2)
    rig.begin("STOP")
    edges = shown(rig, begun)
    assert rig.level("pulse1") == (edges[-1][1] if edges else 0)
    turned = rig.begin("SET_POS -3")
    rig.to(begun + 40)
    assert displacements[stopped] == 0 and min(displacements) < 0 < max(displacements)
    assert shown(rig, begun) == drawn(displacements)
    assert rig.edges("dir1", rig.at(begun)) == [(rig.at(turned), 0)]
    assert sum(displacements) == -3 * ONE and rig.x.position == -3


@pytest.mark.fact("PMD-PULSE-12", "PMD-UND-DIR-TIMING")
@pytest.mark.parametrize("velocity", [512 * ONE, 511 * ONE + 0x1234, 300 * ONE + 0xC000, 7 * ONE // 5])
def test_dir_turns_between_the_last_step_of_one_direction_and_the_first_of_the_other(velocity: int) -> None:
    rig = base("mc1151a", "pulse1", "dir1")
    begun = rig.begin("SET_OUTPUT_HIGH", "SET_PRFL_VEL", f"SET_VEL {velocity}", f"SET_ACC {velocity // 3}")
    way = 1
    for _ in range(4):
        rig.next(9)
        way = -way
        rig.begin(f"SET_ACC {way * (velocity // 3)}")
        rig.next(9)
    falls, turns = rig.falls("pulse1", rig.at(begun)), rig.edges("dir1", rig.at(begun))
    assert [level for _, level in turns] == [0, 1, 0, 1]
    for turn, _ in turns:
        n = bisect_right(falls, turn)
        assert falls[n] - turn >= 320 * NS and turn - falls[n - 1] >= 0
    directions = rig.x.steps().directions.tolist()
    turned = [time for time, _ in turns]
    assert directions == [1 if bisect_right(turned, fall) % 2 == 0 else -1 for fall in falls]


# --------------------------------------------------------------------------------------------------------------- AtRest
@each
@pytest.mark.fact("PMD-ATREST-1")
def test_at_rest_is_low_for_the_cycles_of_a_move(part: str) -> None:
    rig = base(part, "atrest1")
    assert rig.level("atrest1") == 1
    moves = []
    for profile, cycles in ((T1, T1_CYCLES), (S1, S1_CYCLES)):
        moves.append((rig.begin("SET_ACTL_POS 0", *profile), cycles))
        rig.rest()
    assert rig.lows("atrest1") == moves
    assert rig.level("atrest1") == 1


ENDS: dict[str, Callable[[Rig], object]] = {
    "destination": lambda rig: None,
    "stop": lambda rig: rig.do("STOP", "UPDATE"),
    "limit": lambda rig: rig.drive("neglimit1", 1),
    "motor": lambda rig: rig.do("MTR_OFF"),
}


@pytest.mark.fact("PMD-ATREST-2")
@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("profile", [T1, S1])
def test_at_rest_is_the_inverse_of_in_motion_in_every_cycle(profile: tuple[str, ...], end: str) -> None:
    rig = base("mc1151a")
    rig.update(*profile, "SET_POS 2")

    def watch(cycles: int) -> list[int]:
        found = []
        for cycle in range(rig.cycle + 1, rig.cycle + 1 + cycles):
            for tick in (-1, 0):
                rig.to(cycle, tick)
                found.append(rig.level("atrest1"))
                assert found[-1] == 1 - (rig.shows("status") >> 10 & 1)
        return found

    assert watch(9) == [1] + [0] * 17
    ENDS[end](rig)
    levels = watch(130)
    assert levels == sorted(levels) and levels[-1] == 1  # low, then high


@with_axes
@pytest.mark.fact("PMD-ATREST-3")
def test_each_axis_has_its_own(part: str) -> None:
    axes = range(1, AXES[part] + 1)
    rig = base(part, *(f"atrest{axis}" for axis in axes))
    begun = rig.begin(*T1, axis=2)
    rig.rest()
    found = {axis: rig.lows(f"atrest{axis}") for axis in axes}
    assert found == {axis: [(begun, T1_CYCLES)] if axis == 2 else [] for axis in axes}


@with_encoder
@pytest.mark.fact("PMD-ATREST-4", "PMD-UND-ATREST-GEAR")
@pytest.mark.parametrize("apart", [8192, 3000, 30_000])
def test_in_gear_mode_at_rest_is_low_in_cycles_with_a_step(part: str, apart: int) -> None:
    rig = base(part, "atrest1")
    begun = rig.begin("SET_PRFL_GEAR", f"SET_RATIO {ONE * 3 // 4}")
    rig.turn(8, apart=apart)
    rig.next(40)
    stepped = {(time - rig.at(0) - 1) // CYCLE for time in rig.pulses()}
    low = {fall + n for fall, cycles in rig.lows("atrest1") for n in range(cycles)}
    assert len(rig.pulses()) == 6 and low == stepped and min(low) >= begun
    assert rig.level("atrest1") == 1


# ----------------------------------------------------------------------------------------------------------------- HOME
@each
@pytest.mark.fact("PMD-HOME-2", "PMD-PIN-4", "PMD-UND-HOME-OPEN", "PMD-CON-PARTNAME")
def test_a_home_input_reads_its_level(part: str) -> None:
    rig, axes = base(part), AXES[part]
    open_ = 2**axes - 1
    rig.says(f"05 > {open_:04x} {5 + open_:04x}")
    for axis in range(1, axes + 1):
        rig.drive(f"home{axis}", 0)
        word = open_ & ~(1 << (axis - 1))
        rig.says(f"05 > {word:04x} {5 + word:04x}")
        rig.drive(f"home{axis}", 1)


@each
@pytest.mark.fact("PMD-HOME-2", "PMD-PIN-4")
def test_low_at_home_is_active_and_open_is_not(part: str) -> None:
    rig, last = base(part), AXES[part]
    rig.do("SET_AUTO_UPDATE_OFF", "SET_EXT_BRK", axis=last)
    rig.next(20)
    assert rig.status(last) & 0xFF == 0
    rig.drive(f"home{last}", 0)
    rig.next(2)
    assert rig.status(last) & 0xFF == 4


@each
@pytest.mark.fact("PMD-HOME-3", "PMD-UND-HOME-SAMPLE")
@pytest.mark.parametrize(
    ("falls", "rises", "seen"),
    [
        (-8, 0, False),  # 320 ns
        (-18, -10, False),
        (-11, 1, False),
        (-12, 0, False),  # it counts with the begin of the cycle, which is just too late
        (-13, 0, True),
        (-13, -1, True),  # 480 ns, and the filter holds it for as long again
        (-100, -13, False),  # over before the look
        (100, 8000, False),
    ],
)
def test_a_home_level_counts_when_it_has_lasted_480_ns(part: str, falls: int, rises: int, seen: bool) -> None:
    rig = base(part)
    rig.do("SET_AUTO_UPDATE_OFF", "SET_EXT_BRK")
    cycle = rig.next() + 3
    rig.drive("home1", 0, at=rig.at(cycle, falls))
    rig.drive("home1", 1, at=rig.at(cycle, rises))
    rig.to(cycle, -1)
    assert rig.shows("status") == 0x0300
    rig.to(cycle)
    assert rig.shows("status") == (0x0304 if seen else 0x0300)
    rig.next(5)
    assert rig.shows("status") == (0x0304 if seen else 0x0300)


@each
@pytest.mark.fact("PMD-HOME-4")
def test_without_its_breakpoint_home_has_no_influence(part: str) -> None:
    def moved(*home: int) -> Rig:
        rig = base(part)
        begun = rig.begin(*T1)
        for n, level in enumerate(home):
            rig.drive("home1", level, at=rig.at(begun + 40 * n + 20, 17))
        rig.rest()
        return rig

    toggled, still = moved(*(0, 1) * 10), moved()
    assert toggled.pulses() == still.pulses()
    assert (toggled.status(), toggled.codes) == (0x0301, [])


# -------------------------------------------------------------------------------------------------------------- at rest
@each
@pytest.mark.fact("PMD-PIN-3", "PMD-LIMIT-1")
def test_inputs_that_are_not_wired_do_nothing(part: str) -> None:
    rig = base(part)
    rig.next(3000)
    axes = range(1, AXES[part] + 1)
    assert [rig.status(axis) & 0xFF for axis in axes] == [0] * AXES[part]
    assert {rig.level(f"{pin}limit{axis}") for axis in axes for pin in ("pos", "neg")} == {0}
    assert rig.codes == []


@each
@pytest.mark.fact("PMD-PIN-2")
def test_pins_of_axes_that_a_part_lacks_are_not_there(part: str) -> None:
    rig = base(part)
    for axis in range(1, 5):
        for pin in ("home", "poslimit", "neglimit", "pulse", "dir", "atrest"):
            if axis <= AXES[part]:
                assert rig.level(f"{pin}{axis}") in (0, 1)
            else:
                with pytest.raises(UnknownName, match="has no pin"):
                    rig.drive(f"{pin}{axis}", 1)


@pytest.mark.fact("PMD-PIN-7")
@pytest.mark.parametrize(("ps", "codes"), [(250 * MS, []), (250 * MS - 1, ["early-reset"]), (2 * US, ["early-reset"])])
def test_reset_waits_for_a_quarter_of_a_second_after_the_supply(ps: int, codes: list[str]) -> None:
    bench = slewline.Bench()
    x = bench.add("mc1151a", name="x", straps={"reset": 0}, cold=True)
    bench.run("1 ms")
    x.power(True)
    bench.run(ps)
    x.pin("reset").drive(1)
    assert [found.code for found in x.findings] == codes
    bench.run_until(x.pin("hostrdy").is_(1), timeout="5 ms")


@pytest.mark.fact("PMD-PIN-7")
def test_a_part_kept_in_reset_from_the_beginning_starts_when_it_is_released() -> None:
    bench = slewline.Bench()
    x = bench.add("mc1151a", name="x", straps={"reset": 0})
    bench.run("300 ms")
    assert x.pin("hostrdy").level == 0
    x.pin("reset").drive(1)
    bench.run_until(x.pin("hostrdy").is_(1), timeout="5 ms")
    assert bench.now_ps == 300 * MS + READY * CYCLE and x.findings == []
