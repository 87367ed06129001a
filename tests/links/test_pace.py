"""How virtual time passes: against a wall clock that the test moves."""

from __future__ import annotations

import pytest

import slewline
from slewline.bench.runner import Wait
from slewline.errors import UsageError
from slewline.links.lines.pace import LOST_NS, SLICE_NS, Lockstep, Paced
from slewline.parts.lines.host_uart import POWER_UP_PS

MS = 10**9  # ps
MS_NS = 10**6


class Wall:
    """A wall clock."""

    def __init__(self):
        self.ns = 12345
        self.step = 0  # of every look at it

    def __call__(self):
        self.ns += self.step
        return self.ns


@pytest.fixture
def wall():
    return Wall()


@pytest.fixture
def bench():
    return slewline.Bench()


def started(bench, wall, rate=1):
    pace = Paced(bench, rate, wall)
    pace.start()
    return pace


@pytest.mark.parametrize(("rate", "passed"), [(1, 5 * MS), ("0.1", MS // 2), (1000, 5000 * MS), ("2.5", 25 * MS // 2)])
def test_virtual_time_is_the_wall_clock_times_the_rate(bench, wall, rate, passed):
    pace = started(bench, wall, rate)
    wall.ns += 5 * MS_NS
    assert pace.pass_time()
    assert bench.now_ps == POWER_UP_PS + passed


def test_nothing_drifts(bench, wall):
    pace = started(bench, wall, "0.3")
    for _ in range(1000):
        wall.ns += 333
        pace.pass_time()
    assert bench.now_ps == POWER_UP_PS + 333_000 * 1000 * 3 // 10


def test_the_loop_sleeps_until_the_next_event_and_no_longer(bench, wall):
    pace = started(bench, wall, 2)
    assert pace.pause() is None
    bench.at(POWER_UP_PS + 20 * MS, lambda: None)
    assert pace.pause() == 0.010
    wall.ns += 4 * MS_NS
    assert pace.pause() == 0.006
    wall.ns += 40 * MS_NS
    assert pace.pause() == 0


def test_a_notified_part_is_served_before_the_loop_sleeps(bench, wall):
    port = bench.part("serial_port")
    pace = started(bench, wall)
    port.write(b"F")
    assert 0 < pace.pause() < 0.002  # the end of its character


def test_outside_inputs_find_the_bench_at_the_present(bench, wall):
    pace = started(bench, wall)
    wall.ns += 700 * MS_NS  # nothing was to be done: the loop has slept
    pace.present()
    assert bench.now_ps == POWER_UP_PS + 700 * MS


def test_lag_counts_events_that_come_late(bench, wall):
    pace = started(bench, wall)
    for due in (1, 2, 3):
        bench.at(POWER_UP_PS + due * MS, lambda: None)
    for passed in (1, 1, 8):  # the third is due at 3, and comes at 10
        wall.ns += passed * MS_NS
        pace.pass_time()
    assert (pace.lag.events, pace.lag.late, pace.lag.worst_ns, pace.lag.lost_ns) == (3, 1, 7 * MS_NS, 0)


def test_a_lag_of_more_than_a_second_is_dropped_and_reported(bench, wall):
    pace = started(bench, wall)
    bench.at(POWER_UP_PS + MS, lambda: None)
    wall.ns += MS_NS + LOST_NS + 5
    pace.pass_time()
    assert bench.now_ps == POWER_UP_PS + MS
    assert pace.lag.lost_ns == LOST_NS + 5
    wall.ns += MS_NS
    pace.pass_time()
    assert bench.now_ps == POWER_UP_PS + 2 * MS


def test_a_bench_with_too_much_to_do_leaves_the_world_its_turn(bench, wall):
    pace = started(bench, wall)

    def again():
        bench.at(bench.now_ps + 1000, again)

    bench.at(POWER_UP_PS + 1000, again)
    wall.step = MS_NS  # every look at the clock costs a millisecond
    assert not pace.pass_time()
    assert SLICE_NS <= wall.ns - 12345 <= SLICE_NS + 5 * MS_NS
    assert bench.now_ps < POWER_UP_PS + 20 * MS


@pytest.mark.parametrize("rate", ["0", "-1", "fast", "1/0"])
def test_a_rate_is_positive(bench, rate):
    with pytest.raises(UsageError, match="expected virtual seconds per second"):
        Paced(bench, rate)


# ----------------------------------------------------------------------------------------------------------- waiting
@pytest.mark.parametrize("kind", ["lockstep", "paced"])
def test_a_condition_is_met_at_its_instant_however_short_it_is(bench, wall, kind):
    x = bench.add("cy525", name="x")
    pace = Lockstep(bench) if kind == "lockstep" else Paced(bench, 1, wall)
    bench.run(0)
    pace.start()
    x.pin("wait").pulse(0, "1 us", at="7 ms")
    told = []
    condition = x.pin("wait").is_(0)
    pace.wait(Wait(condition.met, 50 * MS, lambda met: told.append((met, bench.now_ps)), nets=condition.nets))
    wall.ns += 200 * MS_NS
    while not pace.pass_time():
        pass
    assert told == [(True, 7 * MS)]
    assert bench.now_ps == (7 * MS if kind == "lockstep" else POWER_UP_PS + 200 * MS)


def test_an_unmet_condition_is_reported_at_its_limit(bench):
    pace = Lockstep(bench)
    told = []
    pace.wait(Wait(lambda: False, 50 * MS, lambda met: told.append((met, bench.now_ps))))
    pace.wait(Wait(lambda: False, 20 * MS, lambda met: told.append((met, bench.now_ps))))
    assert pace.pass_time()
    assert told == [(False, 20 * MS), (False, 50 * MS)]
    assert bench.now_ps == 50 * MS


def test_a_position_is_met_between_two_events(bench):
    x = bench.add("cy525", name="x")
    host = bench.host(x)
    pace = Lockstep(bench)
    host.send("R 100\rS 200\rF 20\rA 0\rN 400\rG\r")
    told = []
    condition = x.reaches(123)
    pace.wait(Wait(condition.met, 10**13, told.append, condition.when, condition.nets))
    while not pace.pass_time():
        pass
    assert told == [True]
    assert x.position == 123
    assert x.steps(bench.now_ps, bench.now_ps).positions.tolist() == [123]


def test_in_lockstep_time_does_not_advance_by_itself(bench):
    pace = Lockstep(bench)
    bench.at("1 us", lambda: pytest.fail("time has passed"))
    assert pace.pass_time()
    assert (bench.now_ps, pace.pause()) == (0, None)
