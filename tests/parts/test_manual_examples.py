"""Examples of sections 10 and 13 that need hands at the pins."""

from __future__ import annotations

from itertools import pairwise

import pytest

US, MS = 10**6, 10**9

FIG_10_13 = "R 80\rF 10\rN 1\rC\rE\rB\rG\rD 500\rL 3,1\rC\rU\rB\rG\rD 330\rL 3,11\rC\rT 0\r0\rQX\r"
FIG_10_15 = "C\rR 90\rS 200\rF 10\rN 3\rE\rB\r+\rG\rC\r-\rG\rT 0\rB\rC\r0\rQX\r"
OUT = "x.programmable_output"


def started(circuit, text, *recorded):
    c = circuit(*recorded, slope=255, divisor=1, position=0)
    c.host = c.bench.host(c.x)
    c.host.send("A 0\rS 255\rZ 1\r" + text)
    c.settle()
    c.bench.run_until(c.x.pin("run").is_(0))
    return c


# --------------------------------------------------------------------------------------------------------- figure 10.13
@pytest.mark.fact("EXAMPLE-10.13-1")
def test_three_slow_steps_a_wait_and_three_faster_ones(circuit):
    c = started(circuit, FIG_10_13, "x.pulse", OUT, "x.run")
    begin = c.bench.now_ps
    c.bench.run("3 s")
    assert c.x.position == 3
    assert c.x.waiting.startswith("x: waiting for wait=0 (U)")
    assert c.level(OUT) == 0
    c.x.pin("wait").drive(0)
    released = c.bench.now_ps
    c.finish()
    pulses = c.falls("x.pulse")
    gaps = [b - a for a, b in pairwise(pulses)]
    assert [gap // MS for gap in (gaps[0], gaps[1], gaps[3], gaps[4])] == [501, 501, 331, 331]  # the delay, and a step
    assert gaps[0] - 500 * MS == gaps[3] - 330 * MS
    high = [t for t in c.rises(OUT) if t > begin]
    low = [t for t in c.falls(OUT) if t > begin]
    assert high[0] < pulses[0] < pulses[2] < low[0]
    assert low[0] < released < high[1] < pulses[3] < pulses[5] < low[1]
    assert high[1] - low[0] > 100 * MS
    assert len(c.rises("x.run")) == 1


@pytest.mark.fact("EXAMPLE-10.13-2")
def test_step_inhibit_delays_one_step_and_dowhile_repeats_the_program(circuit):
    c = started(circuit, FIG_10_13, "x.pulse", "x.run", OUT)
    c.x.pin("wait").drive(0)
    c.x.pin("dowhile").drive(0)
    c.bench.run_until(c.x.reaches(1))
    c.bench.run("100 ms")
    c.x.pin("step_inhibit").drive(1)
    c.bench.run("900 ms")
    assert len(c.falls("x.pulse")) == 1
    c.x.pin("step_inhibit").drive(0)
    released = c.bench.now_ps
    c.bench.run_until(c.x.reaches(7))  # the second pass
    second = c.falls("x.pulse")[1]
    assert 0 < second - released <= 3 * US  # the next look at the pin
    c.x.pin("dowhile").drive(1)
    c.finish()
    assert c.x.position == 12
    assert len(c.falls("x.pulse")) == 12
    assert len(c.rises("x.run")) == 1
    assert len([t for t in c.rises(OUT) if t > c.falls("x.run")[0]]) == 4


# --------------------------------------------------------------------------------------------------------- figure 10.15
@pytest.mark.fact("EXAMPLE-10.15")
def test_three_steps_forth_and_back_until_dowhile_is_high(circuit):
    c = started(circuit, FIG_10_15, "x.pulse", "x.direction", "x.run", OUT)
    c.x.pin("dowhile").drive(0)
    assert len(c.x.program) == 11
    c.bench.run_until(lambda: len(c.x.steps()) == 15)
    c.x.pin("dowhile").drive(1)
    c.finish()
    steps = c.x.steps()
    assert steps.directions.tolist() == [1, 1, 1, -1, -1, -1] * 3
    assert c.x.position == 0
    run = c.falls("x.run")[0]
    outputs = [(t, level) for t, level in c.edges(OUT) if t > run]
    assert [level for _, level in outputs] == [1, 0] * 4  # three clockwise halves, and the pulse at the end
    for number, (time, sign) in enumerate(zip(steps.times_ps.tolist(), steps.directions.tolist(), strict=True)):
        marked = [level for t, level in outputs if t < time][-1]
        assert marked == (1 if sign > 0 else 0), number
        assert c.bench._signals.recorder.level(c.x.pin("direction").net, time) == (1 if sign > 0 else 0)
    (last_high, _), (last_low, _) = outputs[-2:]
    assert last_low - last_high < MS
    assert c.rises("x.run")[0] > last_low


@pytest.mark.fact("EXAMPLE-10.15")
def test_step_inhibit_delays_motion_complete(circuit):
    c = started(circuit, FIG_10_15, "x.pulse", "x.motion_complete", "x.ready")
    c.bench.run_until(c.x.reaches(3))
    c.x.pin("step_inhibit").drive(1)
    c.bench.run("200 ms")
    assert c.level("x.motion_complete") == 1
    assert (c.level("x.pulse"), c.level("x.ready")) == (0, 0)
    c.x.pin("step_inhibit").drive(0)
    released = c.bench.now_ps
    c.bench.run_until(c.x.pin("motion_complete").is_(0))
    assert 0 < c.bench.now_ps - released <= 3 * US + 3 * US  # the look, and 2.5 us high


# ------------------------------------------------------------------------------------------------- section 13, step 19
@pytest.mark.fact("EXAMPLE-13")
def test_e_and_q_toggle_prog(circuit):
    c = circuit("x.prog")
    host = c.bench.host(c.x)
    host.send("E\r")
    c.finish()
    assert c.level("x.prog") == 0
    host.send("Q")
    c.finish()
    assert [level for _, level in c.edges("x.prog")] == [0, 1]


@pytest.mark.fact("EXAMPLE-13")
def test_repeated_single_steps_walk_through_the_phase_table(circuit):
    c = circuit("x.pulse", rate=10, firstrate=10, slope=255, divisor=1)
    host = c.bench.host(c.x)
    patterns = []
    for number in range(1, 6):
        host.send("A 0\rP 1\r")
        c.finish()
        assert len(c.edges("x.pulse")) == 2 * number  # low, and high again
        patterns.append(tuple(c.level(f"x.phase{n}") for n in (1, 2, 3, 4)))
    assert len(set(patterns[:4])) == 4
    assert patterns[4] == patterns[0]
    assert all(sum(pattern) == 2 for pattern in patterns)


@pytest.mark.fact("EXAMPLE-13")
def test_with_step_inhibit_high_a_single_step_waits_until_it_is_low(circuit):
    c = circuit("x.pulse", "x.phase1", "x.phase2", "x.phase3", "x.phase4", rate=10, firstrate=10, slope=255, divisor=1)
    host = c.bench.host(c.x)
    c.x.pin("step_inhibit").drive(1)
    host.send("A 0\rP 1\r")
    c.settle()
    c.bench.run("2 s")
    pins = ("x.pulse", "x.phase1", "x.phase2", "x.phase3", "x.phase4")
    assert all(c.edges(pin) == [] for pin in pins)
    c.x.pin("step_inhibit").drive(0)
    c.finish()
    assert len(c.edges("x.pulse")) == 2
    assert c.x.position == 1
