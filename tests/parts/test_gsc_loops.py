"""Around ENABLE and the user lines: synchronised modules, the closed loop, a motor that loses steps, damping."""

from __future__ import annotations

from itertools import pairwise

import pytest
from modules import C200S, MS, STR, US, Modules, both

import slewline

LOW = 1_700_000  # CLOCK low, ps
RELEASE = 5 * US  # ENABLE high to the step that it held
LAG = 3 * MS


# --------------------------------------------------------------------------------------------------- synchronisation
@both
@pytest.mark.fact("GSC-SYS-SYNC-1")
def test_a_common_enable_line_starts_and_holds_modules_together(part):
    m = Modules(part, "x", "y", "z")
    m.wire("x.enable y.enable", "y.enable z.enable")
    m.connect()
    m.bench.pin("x.enable").drive(0)
    for name in "xyz":
        m.start(*STR, "+100", name=name)
    m.bench.run("500 ms")
    assert [m.pulses(name) for name in "xyz"] == [[], [], []]
    m.bench.pin("x.enable").release()
    released = m.bench.now_ps
    m.bench.run("50 ms")
    m.bench.pin("x.enable").drive(0)
    held = m.bench.now_ps
    m.bench.run("300 ms")
    steps = m.pulses("x")
    assert steps[0] == released + RELEASE
    assert 0 < len(steps) < 100
    assert steps[-1] < held
    assert m.pulses("y") == m.pulses("z") == steps
    m.bench.pin("x.enable").release()
    m.bench.run_until_idle()
    assert m.pulses("x") == m.pulses("y") == m.pulses("z")
    assert len(m.pulses("x")) == 100
    assert m.pulses("x")[len(steps)] == held + 300 * MS + RELEASE


@both
@pytest.mark.fact("GSC-SYS-SYNC-2")
def test_user_lines_let_two_programs_wait_for_each_other(part):
    m = Modules(part, "x", "y")
    m.wire("x.uo1 y.ui1", "y.uo1 x.ui1")
    m.bench.record("x.uo1", "y.uo1", "x.enable", "y.enable")
    m.connect()
    m.enter(*STR, "+50", "A1", "W1", "+50", name="x")
    m.start(*STR, "+200", "A1", "W1", "+50", name="y")
    assert m.ask("E", "x") == "Y"
    m.bench.run_until_idle()
    (x_ready,), (y_ready,) = m.rises("x.uo1", 1), m.rises("y.uo1", 1)
    assert x_ready < m.pulses("y")[199] < y_ready
    x_starts, y_starts = m.pulses("x")[50], m.pulses("y")[200]
    assert y_starts == y_ready + 2 * MS + 10 * US  # W1 is met at once; +50 takes its time, then DIR leads
    waited = -(-(y_ready - x_ready) // MS) * MS  # x looks every millisecond
    assert x_starts == x_ready + waited + MS + 10 * US
    assert abs(x_starts - y_starts) <= MS
    assert (len(m.pulses("x")), len(m.pulses("y"))) == (100, 250)
    assert m.edges("x.enable", 1) == m.edges("y.enable", 1) == []


# ------------------------------------------------------------------------------------------------------- closed loop
def looped(part: str, closed: bool = True, shuffle: int | None = None, **motor: object) -> Modules:
    m = Modules(part, shuffle=shuffle)
    m.motor = m.bench.part("motor", name="motor", to="x", **motor)
    if closed:
        m.check = m.bench.part("step_check", name="check", to="x")
        m.wire("motor.x check.x", "motor.y check.y")
    m.connect()
    return m


@both
@pytest.mark.fact("GSC-SYS-CL-1")
def test_the_closed_loop_waits_for_a_slow_motor(part):
    m = looped(part, lag="3 ms")
    m.bench.record("x.enable")
    m.run(*STR, "+200")
    assert (m.motor.position, m.motor.lost, len(m.pulses()), m.x.position) == (200, 0, 200, 200)
    gaps = [after - before for before, after in pairwise(m.pulses())]
    free = Modules(part)
    free.connect()
    free.run(*STR, "+200")
    own = [after - before for before, after in pairwise(free.pulses())]
    assert gaps == [max(interval, LOW + LAG + RELEASE) for interval in own]
    assert min(gaps) >= LAG > min(own)
    assert m.falls("x.enable", m.pulses()[0] - 1) == m.pulses()
    assert m.rises("x.enable", m.pulses()[0] - 1) == [time + LOW + LAG for time in m.pulses()]


@both
@pytest.mark.fact("GSC-SYS-CL-1")
def test_without_the_loop_the_slow_motor_loses_steps(part):
    m = looped(part, closed=False, lag="3 ms")
    m.run(*STR, "+200")
    assert m.x.position == 200
    assert m.motor.position == 200 - m.motor.lost < 100


@both
@pytest.mark.fact("GSC-SYS-CL-1")
def test_the_detector_reports_the_direction(part):
    m = looped(part, lag="100 us")
    m.run(*STR, "+7", "-5", "+1")
    assert (m.motor.position, m.x.position, m.check.behind) == (3, 3, 0)
    assert (m.bench.pin("motor.x").level, m.bench.pin("motor.y").level) == (0, 1)


@both
@pytest.mark.fact("GSC-SYS-CL-1")
def test_a_step_that_is_never_made_holds_the_module(part):
    m = looped(part, loses=[4])
    m.start(*STR, "+10")
    with pytest.raises(slewline.Timeout, match=r"held by enable=0"):
        m.bench.run_until_idle("10 s")
    assert (m.x.position, m.motor.position) == (4, 3)
    assert (m.ask("F"), m.ask("K"), m.ask("F")) == ("B", "Y", "R")


@both
@pytest.mark.fact("GSC-SYS-CL-1")
def test_a_step_that_the_load_turns_back_does_not_free_the_module(part):
    m = looped(part, loses=[1])
    m.start(*STR, "+10")
    m.bench.run("5 ms")
    turn = lambda x, y: (m.bench.pin("check.x").drive(x), m.bench.pin("check.y").drive(y))  # noqa: E731
    m.bench.pin("motor.x").net.drivers[0].drive(None)  # a hand turns the shaft
    m.bench.pin("motor.y").net.drivers[0].drive(None)
    turn(0, 1)
    m.bench.run("50 ms")
    assert (m.check.behind, len(m.pulses())) == (2, 1)
    turn(0, 0)
    m.bench.run("50 ms")
    assert (m.check.behind, len(m.pulses())) == (1, 1)
    turn(1, 0)
    m.bench.run("50 ms")
    assert (m.check.behind, len(m.pulses())) == (1, 2)  # the next step, which nobody makes


@both
@pytest.mark.fact("GSC-SYS-CL-2")
def test_without_the_loop_lost_steps_go_unnoticed(part):
    m = looped(part, closed=False, loses=[3, 50, 99])
    m.run(*STR, "+100")
    assert int(m.ask("V1").removeprefix("V")) == 100
    assert m.ask("F") == "R"
    assert (m.motor.position, m.motor.pulses, m.motor.lost) == (97, 100, 3)


@pytest.mark.fact("GSC-SYS-CL-1")
@pytest.mark.parametrize("shuffle", [1, 2, 3])
def test_the_order_of_tasks_in_an_instant_does_not_matter(shuffle):
    runs = []
    for seed in (None, shuffle):
        m = looped(C200S, lag="3 ms", shuffle=seed)
        m.run(*STR, "+40", "-15")
        runs.append((m.pulses(), m.motor.position, m.bench.now_ps))
    assert runs[0] == runs[1]


# ------------------------------------------------------------------------------------------------------- ramp by trial
@both
@pytest.mark.fact("GSC-SYS-RAMPSEL-1")
def test_a_ramp_that_is_too_short_loses_steps(part):
    """From 100 to 1000 steps/s in R steps takes 990,000 / 2R steps/s^2; this motor gives 10,000: R is 49.5 or more."""
    m = looped(part, closed=False, pull_in=300, acceleration=10_000)
    m.enter("S10", "T100", "R999", "+300")
    lost = {}
    for ramp in (120, 80, 51, 50, 49, 40, 10):
        before = m.motor.lost
        m.run("S10", "T100", f"R{ramp}", "+300")
        lost[ramp] = m.motor.lost - before
    assert [ramp for ramp, steps in lost.items() if not steps] == [120, 80, 51, 50]
    assert all(lost[ramp] > 100 for ramp in (49, 40, 10))


@both
@pytest.mark.fact("GSC-SYS-RAMPSEL-1")
def test_a_motor_starts_only_up_to_its_pull_in_rate_and_is_at_rest_when_it_turns_round(part):
    m = looped(part, closed=False, pull_in=300, acceleration=45_000)
    m.run("S30", "T30", "R1", "+20")
    assert m.motor.lost == 0
    m.run("S31", "T31", "R1", "+20")
    assert m.motor.lost == 19  # all but the first one, which comes after a rest
    assert m.motor.position == 21
    m.run("S30", "T400", "R200", "+500")  # 16e6 / 400 steps/s^2
    assert m.motor.position == 521
    m.run("S30", "T30", "R1", "+5", "-5")
    assert (m.motor.position, m.motor.lost) == (521, 19)


@pytest.mark.fact("GSC-SYS-RAMPSEL-1")
@pytest.mark.parametrize(("way", "lost"), [(1, 0), (0, 1)])
def test_a_motor_at_speed_loses_the_step_that_turns_it_round(way, lost):
    bench = slewline.Bench()
    motor = bench.part("motor", pull_in=300, acceleration=45_000)
    time = 0
    for rate in (300, 300, 400, 500, 500):  # the root of 300^2 + 90,000 is 424
        time += 10**12 // rate
        bench.pin("motor.pulse").pulse(0, "10 us", at=time)
        bench.pin("motor.pulse").drive(1, at=time + 10 * US)
    bench.pin("motor.direction").drive(way, at=time - MS)
    bench.run_to(time + MS)
    assert (motor.pulses, motor.lost) == (5, lost)


def test_a_motor_with_nonsense_is_refused():
    with pytest.raises(slewline.UsageError, match="m: pull_in -1; allowed 0 or more steps/s"):
        slewline.Bench().part("motor", "m", pull_in=-1)
    with pytest.raises(slewline.UsageError, match=r"m: acceleration 5001; allowed up to 5000 with pull_in 100"):
        slewline.Bench().part("motor", "m", pull_in=100, acceleration=5001)
    with pytest.raises(slewline.UsageError, match="m: acceleration 1; allowed 0 without pull_in"):
        slewline.Bench().part("motor", "m", acceleration=1)


# ------------------------------------------------------------------------------------------------------------ damping
def damped(part: str, **times: object) -> Modules:
    m = Modules(part)
    m.damping = m.bench.part("damping", name="damping", to="x", **times)
    m.driver = m.bench.part("gs_d200", name="driver")
    m.wire("damping.clock_out driver.clock", "damping.dir_out driver.direction", "x.reset driver.reset")
    m.bench.record("driver.clock", "driver.direction", "damping.a", "damping.b", "damping.c")
    m.connect()
    m.trace = []

    def clocked(net) -> None:
        if net.level == 1:
            m.trace.append((m.bench.now_ps, m.bench.pin("driver.direction").level))

    m.driver.pin("clock").net.watch(clocked)
    return m


@both
@pytest.mark.fact("GSC-SYS-DAMP-2")
def test_the_sequencer_adds_a_step_back_and_a_step_forth(part):
    m = damped(part, t1="2 ms", t2="3 ms")
    m.run(*STR, "+50")
    m.bench.run("10 ms")
    last = m.pulses()[-1]
    assert m.falls("damping.a", 1) == [last + LOW]
    clocks = m.falls("driver.clock", 1)
    assert clocks == [*m.pulses(), last + LOW + 2 * MS, last + LOW + 3 * MS]
    assert [way for _, way in m.trace] == [1] * 50 + [0, 1]
    assert [time for time, _ in m.trace] == [time + LOW for time in clocks]
    assert m.falls("damping.c", 1) == clocks[50:]
    (turned, _), (back, _) = m.edges("driver.direction", 1)
    assert last + LOW < turned < clocks[50]
    assert clocks[50] + LOW < back < clocks[51]
    assert (m.rises("damping.b"), m.falls("damping.b")) == ([turned], [back])
    assert m.x.position == 50
    assert m.codes("damping") == []


@both
@pytest.mark.fact("GSC-SYS-DAMP-2")
def test_a_move_in_the_other_direction_is_damped_in_the_other_direction(part):
    m = damped(part)
    m.run(*STR, "+9", "-4")
    m.bench.run("10 ms")
    assert [way for _, way in m.trace] == [1] * 9 + [0, 1] + [0] * 4 + [1, 0]
    assert (m.x.position, m.driver.state) == (5, 6)


@both
@pytest.mark.fact("GSC-SYS-DAMP-1")
def test_the_driver_is_left_at_the_target_with_both_pulses_and_a_step_short_with_one(part):
    states = {}
    for after in ("1.9 ms", "2.1 ms", "2.9 ms", "3.1 ms"):
        n = damped(part)
        n.start(*STR, "+11")
        n.bench.run_until(n.bench.pin("x.mov").edges(2))
        n.bench.run(after)
        states[after] = n.driver.state
    assert states == {"1.9 ms": 4, "2.1 ms": 3, "2.9 ms": 3, "3.1 ms": 4}
    short = damped(part, t2=0)
    short.run(*STR, "+11")
    short.bench.run("10 ms")
    assert ([way for _, way in short.trace], short.driver.state) == ([1] * 11 + [0], 3)


@both
@pytest.mark.fact("GSC-SYS-DAMP-1")
def test_a_motion_that_begins_too_early_is_reported(part):
    m = damped(part, t1="2 ms", t2="30 ms")
    m.run(*STR, "+11", "+11")
    assert m.codes("damping") == ["damping-cut"]
    with pytest.raises(slewline.UsageError, match=r"t1 '2 ms', t2 '1 ms'; allowed t1 above 1\.7 µs, t2 either 0 or"):
        damped(part, t2="1 ms")
    with pytest.raises(slewline.UsageError, match="t1 0"):
        damped(part, t1=0)
