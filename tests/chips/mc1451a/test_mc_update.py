"""Double buffers of the MC1451A family: what waits for an update, when an update acts, and in which order."""

from __future__ import annotations

import pytest
from mc import AXES, ONE, S1, S1_CYCLES, T1, T1_CYCLES, V1, base, each, gaps, with_axes, with_encoder
from mc_motion import IN_MOTION, Mover, mover

UNIT = ONE // 64  # the acceleration of T1 and V1
SHORT = (f"SET_VEL {ONE}", f"SET_ACC {ONE}", "SET_POS 10")  # ten cycles, a step in each
DIFFERENT = ("SET_POS 5", "SET_VEL 0x8000", "SET_ACC 77", "SET_MAX_ACC 78", "SET_JERK 79", "SET_RATIO 80")
UPDATE = 0x1A

one_of_each = pytest.mark.parametrize("part", ["mc1151a", "mc1451a-e"])


def running(part: str, **shafts: dict[str, int]) -> Mover:
    """An axis that goes on at a step per cycle for good, since ten cycles."""
    rig = mover(part, **shafts)
    rig.to(rig.begin(*V1) + 74)
    assert rig.look().vel == ONE
    return rig


# ------------------------------------------------------------------------------------------------- buffered registers
@each
@pytest.mark.parametrize(("move", "cycles"), [(T1, T1_CYCLES), (S1, S1_CYCLES)], ids=["trapezoid", "s-curve"])
@pytest.mark.fact("PMD-BUF-1", "PMD-BUF-2")
def test_registers_that_are_written_in_motion_wait_and_are_read_back(part: str, move: tuple, cycles: int) -> None:
    rig = mover(part)
    n = rig.begin(*move)
    rig.to(n + 300)
    rig.do(*DIFFERENT)
    rig.rest()
    assert rig.lows("atrest1") == [(n, cycles)]
    codes = [code for code in rig.codes if code != "no-encoder"]
    assert (rig.x.position, rig.status(), codes) == (1000, 0x0301, ["no-update"])
    for line in DIFFERENT:
        name, value = line.split()
        assert rig.do(name.replace("SET", "GET")) == int(value, 0)


@each
@pytest.mark.fact("PMD-BUF-1")
def test_velocity_contouring_continues_at_the_speed_of_the_last_update(part: str) -> None:
    rig = running(part)
    rig.do(*DIFFERENT)
    rig.next()
    assert {look.vel for look in rig.trace(200)} == {ONE}


@each
@pytest.mark.fact("PMD-BUF-3", "PMD-BUF-4")
def test_an_update_copies_all_registers_and_leaves_them_for_the_next(part: str) -> None:
    rig = mover(part)
    rig.begin(f"SET_VEL {ONE}", f"SET_ACC {ONE // 4}", "SET_POS 20")
    first = rig.speeds()
    assert (first[:5], sum(first)) == ([ONE // 4, ONE // 2, 3 * ONE // 4, ONE, ONE], 20 * ONE)
    rig.begin("SET_POS 40")
    assert rig.speeds() == first
    assert (rig.do("GET_VEL"), rig.do("GET_ACC"), rig.do("GET_POS")) == (ONE, ONE // 4, 40)


@pytest.mark.fact("PMD-BUF-1")
@pytest.mark.parametrize("stepwise", [False, True], ids=["blocks", "stepwise"])
def test_a_register_written_between_two_updates_of_a_cycle_counts_as_written(stepwise: bool) -> None:
    for between, events in ((("SET_ACC 77",), 0x80), ((), 0)):  # what may not change in motion is a command error
        rig = mover("mc1151a", options={"stepwise": stepwise, "busy_ticks": 64})
        rig.to(rig.begin(*T1) + 100)
        cycle = rig.cycle
        rig.do("UPDATE", *between, "UPDATE")
        assert rig.cycle == cycle
        rig.next(2)
        assert rig.look().status & 0x80 == events
        rig.heeds(rig.cycle + 2, "CLR_STATUS")
    cycle = rig.cycle
    rig.do("SET_ACC 77", "UPDATE", "SET_POS 900", "UPDATE")  # nor does the second one make it unwritten
    assert rig.cycle == cycle
    rig.next(2)
    assert rig.look().status & 0x80


# --------------------------------------------------------------------------------------------------- buffered actions
@each
@pytest.mark.parametrize("action", ["STOP", "SMOOTH_STOP", "SYNCH_PRFL"])
@pytest.mark.fact("PMD-BUF-5")
def test_an_action_waits_for_its_update(part: str, action: str) -> None:
    rig = running(part)
    before, position = rig.cycle, rig.look().pos
    rig.do(action)
    rig.next(1000)
    assert set(gaps(rig.ticks(before))) == {8192}
    assert (rig.look().vel, rig.look().pos - position) == (ONE, rig.cycle - before)


@each
@pytest.mark.parametrize("action", ["STOP", "SMOOTH_STOP"])
@pytest.mark.fact("PMD-BUF-6", "PMD-BUF-15", "PMD-UND-STOP-REG")
def test_an_update_takes_its_stop_with_it_and_leaves_the_velocity(part: str, action: str) -> None:
    rig = running(part)
    n = rig.update(action)
    rig.rest()
    assert rig.look().status == 0x0301 and rig.cycle == n + (63 if action == "SMOOTH_STOP" else 0)
    assert rig.do("GET_VEL") == ONE
    rig.begin()
    assert [look.vel for look in rig.trace(65)] == [*range(UNIT, ONE + 1, UNIT), ONE]
    rig.begin()
    assert {look.vel for look in rig.trace(20)} == {ONE}


@with_encoder
@pytest.mark.fact("PMD-BUF-6")
def test_an_update_takes_its_synchronisation_with_it(part: str) -> None:
    rig = mover(part, quadrature={})
    rig.shafts["quadrature"].push(37)
    rig.begin("SYNCH_PRFL")
    assert rig.look().pos == 37
    rig.shafts["quadrature"].push(5)
    rig.begin()
    assert (rig.look().pos, rig.shows("actl_pos")) == (37, 42)


# ----------------------------------------------------------------------------------------------------------- at once
@each
@pytest.mark.fact("PMD-BUF-7")
def test_everything_else_acts_without_an_update(part: str) -> None:
    rig = base(part)
    rig.do("SET_PRFL_VEL", "SET_OUTPUT_HIGH", "SET_AUTO_UPDATE_OFF", "SET_AUTO_STOP_ON")
    rig.do("SET_BRK_PNT 5", "SET_INTRPT_MASK 6", "SET_POS_ERR 7", "SET_STEP_RATIO 8", "SET_START_VEL 9")
    names = ("MODE", "BRK_PNT", "INTRPT_MASK", "POS_ERR", "STEP_RATIO", "START_VEL")
    assert [rig.do(f"GET_{name}") for name in names] == [0x0E80, 5, 6, 7, 8, 9]
    rig.says("42 > 0042", "31 > 0200 0231", "43 > 0043", "31 > 0300 0331")
    rig.do("SET_BRK_PNT 0", "SET_POS_BRK")
    rig.next()
    assert rig.status() == 0x0304
    rig.do("SET_LMT_SENSE 1")
    rig.next()
    assert rig.status() == 0x0325


# -------------------------------------------------------------------------------------------------- when an update acts
@each
@pytest.mark.fact("PMD-BUF-8", "PMD-CON-UPDATE-WHEN")
def test_an_update_acts_with_the_next_cycle_wherever_in_a_cycle_it_comes(part: str) -> None:
    rig = mover(part)
    rig.do(*SHORT)
    begun = []
    for tick in (0, 1, 4096, 8190, 8191, 8192):
        cycle = rig.cycle + 20
        rig.to(cycle, tick - 2048 - 3)  # a strobe, and the slice of the command
        rig.host.write_command(UPDATE)
        rig.bench.run_until(rig.x.pin("hostrdy").is_(1))
        assert rig.bench.now_ps == rig.at(cycle, tick)
        begun.append((cycle + 1 + tick // 8192, 10))  # with the begin of a cycle it comes too late for that one
        rig.rest()
        rig.do("SET_ACTL_POS 0")
    assert rig.lows("atrest1") == begun


def twice(rig: Mover) -> None:
    """Two updates within one cycle; it is the next one then."""
    rig.next()
    cycle = rig.cycle
    for _ in range(2):
        rig.host.write_command(UPDATE)
    rig.bench.run_until(rig.x.pin("hostrdy").is_(1))
    assert rig.cycle == cycle
    rig.next()


@one_of_each
@pytest.mark.parametrize(("action", "cycles"), [("STOP", 4), ("SMOOTH_STOP", 70)])
@pytest.mark.fact("PMD-UND-UPDATE-TWICE")
def test_two_updates_in_a_cycle_are_one(part: str, action: str, cycles: int) -> None:
    rig = running(part)
    rig.do(action)
    twice(rig)
    rig.next(cycles)
    assert (rig.look().vel, rig.look().status) == (0, 0x0301)  # the second one does not start it again


@with_encoder
@pytest.mark.fact("PMD-UND-UPDATE-TWICE")
def test_two_updates_in_a_cycle_synchronise_once(part: str) -> None:
    rig = mover(part, quadrature={})
    rig.shafts["quadrature"].push(37)
    rig.do("SYNCH_PRFL")
    twice(rig)
    assert rig.look().pos == 37


@one_of_each
@pytest.mark.fact("PMD-UND-UPDATE-TWICE")
def test_two_updates_in_a_cycle_refuse_what_one_would(part: str) -> None:
    rig = mover(part)
    rig.begin(*T1)
    rig.do(f"SET_ACC {2 * UNIT}")  # not while it is in motion
    twice(rig)
    assert rig.status() & 0x80


@each
@pytest.mark.parametrize("move", [T1, S1], ids=["trapezoid", "s-curve"])
@pytest.mark.fact("PMD-BUF-13")
def test_updates_with_nothing_new_do_not_disturb_a_move(part: str, move: tuple[str, ...]) -> None:
    quiet, disturbed = mover(part), mover(part)
    far = 1000 if part == "mc1151a" else 200
    quiet.begin(*move, f"SET_POS {far}")
    n = disturbed.begin(*move, f"SET_POS {far}")
    speeds = []
    while disturbed.look().status & IN_MOTION:
        speeds.append(disturbed.look().vel)
        if len(speeds) % 50 == 25:
            disturbed.do("UPDATE")
            assert disturbed.cycle == n + len(speeds) - 1
        disturbed.next()
    assert speeds == quiet.speeds()
    assert (disturbed.x.position, disturbed.look().status) == (far, 0x0301)


@each
@pytest.mark.fact("PMD-BUF-12")
def test_an_update_clears_no_event(part: str) -> None:
    rig = mover(part)
    rig.do("UPDATE")
    rig.next()
    assert rig.look().status == 0x0301
    rig.begin(*SHORT)
    assert rig.look().status == 0x0701
    rig.rest()
    rig.do("SET_POS_BRK")
    rig.next(2)
    assert rig.look().status == 0x0305
    rig.begin("SET_POS 20")
    assert rig.look().status == 0x0705
    rig.begin("STOP")
    assert rig.look().status == 0x0305


# ------------------------------------------------------------------------------------------------------- several axes
@with_axes
@pytest.mark.fact("PMD-BUF-9", "PMD-BUF-16", "PMD-CMD-MULTI_UPDATE-1")
def test_multi_update_starts_and_stops_its_axes_in_the_same_cycle(part: str) -> None:
    axes = range(1, AXES[part] + 1)
    rig = base(part, *(f"atrest{axis}" for axis in axes))
    for axis in axes:
        rig.do(*T1, axis=axis)
    rig.next()
    rig.says("5b 000f > 006a")
    started = rig.next()
    rig.rest()
    for axis in axes:
        rig.do("SET_POS 2000", axis=axis)
    rig.do("MULTI_UPDATE 15")
    again = rig.next()
    rig.next(100)
    for axis in axes:
        rig.do("STOP", axis=axis)
    rig.next()
    rig.says("5b 000f > 006a")
    stopped = rig.next()
    lows = [rig.lows(f"atrest{axis}") for axis in axes]
    assert lows == [[(started, T1_CYCLES), (again, stopped - again)]] * AXES[part]


@pytest.mark.parametrize("part", ["mc1151a", "mc1251a", "mc1151a-e", "mc1251a-e"])
@pytest.mark.fact("PMD-BUF-10")
def test_multi_update_passes_over_axes_that_are_not_there(part: str) -> None:
    rig = base(part)
    for axis in range(1, AXES[part] + 1):
        rig.do(*SHORT, axis=axis)
    rig.says("5b 000f > 006a")
    rig.next()
    rig.rest()
    assert [rig.x.axis(axis).position for axis in range(1, AXES[part] + 1)] == [10] * AXES[part]
    assert rig.codes == []


@with_axes
@pytest.mark.fact("PMD-BUF-11")
def test_every_axis_has_registers_of_its_own(part: str) -> None:
    names = [line.split()[0].removeprefix("SET_") for line in DIFFERENT]
    names += ["START_VEL", "BRK_PNT", "INTRPT_MASK", "STEP_RATIO", "POS_ERR"]
    rig = base(part)
    axes = range(1, AXES[part] + 1)
    for number, name in enumerate(names):
        for axis in axes:
            rig.do(f"SET_{name} {10 * number + axis}", axis=axis)
    for axis in reversed(axes):
        assert [rig.do(f"GET_{name}", axis=axis) for name in names] == [10 * n + axis for n in range(len(names))]
    for axis in axes:
        assert rig.status(axis) == 0x0300 | axis - 1 << 12
    rig.do("SET_PRFL_VEL", "SET_POS_BRK", "SET_BRK_PNT 0", *SHORT, "UPDATE", axis=2)
    rig.next(5)
    assert [rig.x.axis(axis).registers["trgt_pos"] > 0 for axis in axes] == [axis == 2 for axis in axes]
    assert [rig.status(axis) & 0x404 for axis in axes] == [0x404 * (axis == 2) for axis in axes]
    assert [rig.do("GET_MODE", axis=axis) for axis in axes] == [0x0800 * (axis == 2) for axis in axes]


# ----------------------------------------------------------------------------------------------------- order, and modes
@each
@pytest.mark.fact("PMD-UND-UPDATE-ORDER", "PMD-BUF-14")
def test_stop_wins_over_a_smooth_stop_and_over_a_start(part: str) -> None:
    rig = running(part)
    rig.begin("STOP", "SMOOTH_STOP", "SET_VEL 0x8000")
    assert (rig.look().vel, rig.look().status) == (0, 0x0301)
    rig.do("SET_PRFL_TRAP", "SET_ACTL_POS 0", "CLR_STATUS")
    rig.begin(*SHORT, "STOP")
    assert [look.vel for look in rig.trace(20)] == [0] * 20
    assert rig.look().status == 0x0301
    n = rig.begin()
    rig.rest()
    assert rig.lows("atrest1")[-1] == (n, 10)


@with_encoder
@pytest.mark.fact("PMD-UND-UPDATE-ORDER", "PMD-BUF-14")
def test_an_update_synchronises_first_then_takes_the_registers_then_stops(part: str) -> None:
    rig = running(part, quadrature={})
    rig.shafts["quadrature"].push(37)
    n = rig.begin("SYNCH_PRFL", "SET_POS 500", "STOP", "SMOOTH_STOP")
    assert rig.look()[:3] == (37, 0, 0x0301)
    rig.next(20)
    assert (rig.do("GET_POS"), rig.ticks(n)) == (500, [])
    assert rig.look().pos == 37
    rig.do("SET_PRFL_TRAP", "SET_ACTL_POS 0")
    rig.shafts["quadrature"].push(7)
    rig.next()
    rig.begin(*SHORT, "SYNCH_PRFL")
    assert rig.look()[:2] == (7, ONE)  # the way to 10 is reckoned from the actual position
    rig.rest()
    assert rig.x.position == 10


@each
@pytest.mark.fact("PMD-UND-UPDATE-MODE")
def test_an_update_takes_over_what_the_mode_does_not_use(part: str) -> None:
    rig = mover(part)
    n = rig.begin(*S1)
    rig.heeds(n + 400, f"SET_ACC {-2 * UNIT}", "UPDATE")
    assert rig.look().vel == ONE and not rig.look().status & 0x80
    rig.heeds(n + 500, "SET_PRFL_VEL")
    looks = rig.trace(64)
    assert [look.vel for look in looks[:3]] == [ONE - 2 * UNIT, ONE - 4 * UNIT, ONE - 6 * UNIT]
    assert looks[-1].vel < 0


@each
@pytest.mark.parametrize("mode", ["VEL", "GEAR"])
@pytest.mark.fact("PMD-UND-UPDATE-MODE")
def test_a_destination_of_another_mode_waits_for_an_update(part: str, mode: str) -> None:
    rig = mover(part)
    rig.begin(f"SET_PRFL_{mode}", f"SET_VEL {ONE}", f"SET_START_VEL {ONE // 2}", "SET_POS 10")
    rig.do("SET_PRFL_TRAP", "CLR_STATUS")
    rig.next()
    assert {look[:3] for look in rig.trace(50)} == {(0, 0, 0x0300)}
    rig.begin()
    rig.rest()
    assert rig.x.position == 10


# ---------------------------------------------------------------------------------------------------------- auto update
@each
@pytest.mark.parametrize("command", ["UPDATE", "MULTI_UPDATE 1"])
@pytest.mark.fact("PMD-BUF-17", "PMD-CMD-SET_AUTO_UPDATE_OFF-1", "PMD-UND-BRK-OFF-AUTO")
def test_with_auto_update_off_only_the_host_updates(part: str, command: str) -> None:
    rig = mover(part)
    rig.do("SET_AUTO_UPDATE_OFF", *SHORT, "SET_POS_BRK")
    rig.next(20)
    assert rig.look()[:3] == (0, 0, 0x0304)
    rig.do(command)
    rig.next(20)
    assert rig.look()[:3] == (10, 0, 0x0305)
