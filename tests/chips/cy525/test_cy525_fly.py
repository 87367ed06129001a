"""Rates on the fly (s.7): when a request is seen, what it changes, and what an abort makes of it.  Clocks of 11 MHz."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from random import Random
from statistics import mean
from typing import Any

import pytest

from tests.ensembles import few

Make = Callable[..., Any]
SMALL = "F 10\rR 12\rS 245\rZ 10\r"  # one unit every 49,720 clocks
LOW, MID, TOP = 11_000, 10_000, 9167
UP = [LOW] * 5 + [MID] * 5
DOWN = UP[::-1]
READY = 180  # clocks from MOTION COMPLETE to READY
US = 11


@pytest.mark.fact("FLY-RATE-1", "BIN-12", "SLEW-3")
@pytest.mark.parametrize("straps", [{}, {"ascii_binary": 0}])
def test_the_byte_on_the_bus_is_the_new_rate_in_both_modes(rig: Make, straps: dict[str, int]) -> None:
    x = rig(straps=straps, record=("slew",), firstrate=3, rate=60, slope=200, divisor=1, number=60_000)
    begin = b"H\x00G\x00" if straps else b"H\rG\r"
    x.host.send(begin)
    x.bench.run_until(x.x.pin("slew").is_(0))
    for byte, period in ((0x50, 1840), (0x7F, 1137), (0x1F, 3548)):
        x.host.change_rate(byte)
        x.bench.run_until(x.x.pin("slew").is_(0))
        start = x.bench.now_ps
        x.bench.run("10 ms")
        times = x.x.steps(start).times_ps.tolist()
        clocks = [x.x.clock.ticks_until(time) for time in times]
        assert {after - before for before, after in pairwise(clocks)} == {period}
    assert x.level("ready") == 0


@pytest.mark.fact("FLY-RATE-2", "FLY-RATE-3", "UND-FLY-SAME", "UND-FLY-SAMPLE")
@pytest.mark.parametrize(("rate", "period"), [(3, 36_667), (127, 1137)])
@pytest.mark.parametrize("seed", few([525, 526], 1))
def test_a_request_at_any_phase_is_answered_within_the_present_step(
    mover: Make, seed: int, rate: int, period: int
) -> None:
    x = mover("instrobe", firstrate=rate, rate=rate)
    x.endless("")
    chance, waited = Random(seed), []
    for _ in range(200):
        x.run(chance.randrange(period, 3 * period))
        asked = x.now
        waited.append(x.ask(rate) + x.origin - asked)
        x.until(slew=0)
    assert min(waited) > 0 and max(waited) <= period
    assert mean(waited) == pytest.approx(period / 2, rel=0.1)
    slew = x.changes("slew")[1:]
    rises, falls = slew[::2], slew[1::2]
    assert [fall - rise for (rise, _), (fall, _) in zip(rises, falls, strict=True)] == [period] * 200
    strobes = [clock for clock, level in x.changes("instrobe") if level == 0]
    assert strobes == [rise for rise, _ in rises]  # each request is taken once, as SLEW rises
    assert set(x.periods()) == {period}


@pytest.mark.fact("UND-FLY-SAMPLE", "FLY-RATE-2")
@pytest.mark.parametrize(("clock", "late"), [(-1, 0), (0, TOP), (1, TOP)])
def test_the_request_is_sampled_as_a_step_begins_and_the_byte_is_read_there(mover: Make, clock: int, late: int) -> None:
    x = mover("instrobe")
    look = x.endless(SMALL) + 20 * TOP
    x.byte(look - TOP + 1, 99)
    x.byte(look + late - 1, 11)  # what lies on the bus at the look counts
    x.byte(look + late, 127)
    x.on(look + clock, "io_request", 0)
    x.on(look + 2 * TOP, "io_request", 1)
    x.till(look + 200_000)
    rise = look + late
    assert x.changes("slew")[1:] == [(rise, 1), (rise + 5 * MID, 0)]
    assert x.changes("instrobe") == [(rise, 0), (rise + US, 1)]
    assert x.periods_from(rise)[:10] == [MID] * 10


@pytest.mark.fact("FLY-RATE-4", "RAMP-6")
def test_a_change_follows_the_segment_of_the_start_ramp_between_the_two_rates(mover: Make) -> None:
    x = mover()
    x.endless("F 40\rR 40\rS 150\rZ 1\r")
    x.run(100_000)
    up, curve = x.ask(80), x.way_up(40, 80, 150)
    x.until(slew=0)
    assert x.now - x.origin == up + sum(curve)
    x.run(50 * 1840)
    down = x.ask(40)
    x.until(slew=0)
    assert x.now - x.origin == down + sum(curve)
    x.run(20 * 2750)
    after = x.periods_from(up)
    slewed = (down - up - sum(curve)) // 1840
    assert after[: 2 * len(curve) + slewed] == curve + [1840] * slewed + curve[::-1]
    assert set(after[2 * len(curve) + slewed :]) == {2750}
    y = mover()  # the same segment when a motion starts with it
    y.endless("F 40\rR 80\rS 150\rZ 1\r")
    assert y.periods() == curve and y.now - y.origin == sum(curve)


def aborted(x: Any, *changes: int) -> list[int]:
    """F 3, R 80; rates on the fly one after the other, then ABORT held low: clocks of the steps from then on."""
    x.endless("F 3\rR 80\rS 200\rZ 1\r")
    for rate in changes:
        x.run(100_000)
        x.ask(rate)
        x.until(slew=0)
    x.run(100_000)
    x.put(x.now, "abort", 0)
    low = x.now - x.origin
    x.finish()
    x.put(x.now, "abort", 1)
    return x.periods_from(low)


@pytest.mark.fact("FLY-RATE-5", "ABORT-10", "CON-FLY-LAST")
def test_case_2_a_higher_rate_leaves_the_first_rate_to_the_abort(mover: Make) -> None:
    x = mover()
    assert aborted(x, 127) == x.way_up(3, 127, 200)[::-1]


@pytest.mark.fact("FLY-RATE-6", "ABORT-10")
def test_case_1_after_a_lower_rate_the_abort_is_a_crash_stop(mover: Make) -> None:
    x = mover()
    assert aborted(x, 60) == []
    assert x.periods()[-1] == 2140  # 194.5 us
    low = next(clock for clock, level in reversed(x.changes("slew")) if level == 1)
    assert x.changes("motion_complete")[-1] == (low, 0)


@pytest.mark.fact("FLY-RATE-8", "ABORT-10", "CON-FLY-LAST")
@pytest.mark.parametrize(
    ("changes", "bottom"), [((60, 100), 60), ((100, 60), None), ((60, 100, 90), None), ((100, 60, 70, 127), 60)]
)
def test_for_the_abort_the_last_changes_count(mover: Make, changes: tuple[int, ...], bottom: int | None) -> None:
    x = mover()
    down = [] if bottom is None else x.way_up(bottom, changes[-1], 200)[::-1]
    assert aborted(x, *changes) == down
    if bottom is not None:
        assert x.periods()[-1] == x.period(bottom)


@pytest.mark.fact("FLY-RATE-7")
@pytest.mark.parametrize("change", [60, 127])
def test_the_next_motion_has_its_own_rates_again(mover: Make, change: int) -> None:
    x = mover()
    aborted(x, change)
    x.send("N 20000\r")
    x.begin()
    x.finish()
    up = x.way_up(3, 80, 200)
    assert x.periods() == up + [1840] * (20_000 - 2 * len(up)) + up[::-1]
    assert (x.x.registers["firstrate"], x.x.registers["rate"]) == (3, 80)


@pytest.mark.fact("FLY-RATE-9")
def test_a_change_of_rate_crosses_the_nominal_target_without_a_stop(mover: Make) -> None:
    x = mover()
    x.send(SMALL + "N 300\r")
    x.begin("H\rG\r")
    look = sum(UP) + 286 * TOP  # 296 steps are over: the target lies in the way down
    x.request(look - 500, 10)
    x.till(look + 500_000)
    assert x.periods()[:316] == UP + [TOP] * 286 + DOWN + [LOW] * 10
    assert x.x.pin("slew").level == 0
    x.on(x.now - x.origin, "abort", 0)
    x.finish()
    assert x.periods()[-1] == LOW and x.x.travel == len(x.periods()) > 316


@pytest.mark.fact("FLY-RATE-10", "BIN-12", "UND-R-0-2")
def test_bytes_1_and_127_are_rates(mover: Make) -> None:
    x = mover()
    x.endless("F 3\rR 20\rS 255\rZ 1\r")
    for byte, period in ((1, 38_869), (127, 1137)):
        x.run(100_000)
        x.ask(byte)
        x.until(slew=0)
        start = x.now - x.origin
        x.run(10 * period)
        assert set(x.periods_from(start)) == {period}


@pytest.mark.fact("UND-FLY-BIT7")
@pytest.mark.parametrize("byte", [0x80, 0xFF])
def test_bytes_above_127_are_rate_127_and_never_the_zero_rate(mover: Make, byte: int) -> None:
    x = mover()
    x.endless("F 100\rR 100\rS 200\rZ 1\r")
    x.run(10_000)
    x.ask(byte)
    x.until(slew=0)
    start = x.now - x.origin
    x.run(100_000)
    assert set(x.periods_from(start)) == {1137}
    assert x.codes.count("range") == 1


@pytest.mark.fact("FLY-RATE-11", "UND-FLY-NORMAL")
@pytest.mark.parametrize("steps", [2, 7, 100, 270, 279])
def test_a_request_in_a_normal_motion_halts_it_without_ramp(mover: Make, steps: int) -> None:
    x = mover("instrobe", position=0)
    plain = UP + [TOP] * 260 + DOWN
    x.send(SMALL + "N 280\r")
    x.begin()
    end = sum(plain[:steps])
    x.on(end - 100, "io_request", 0)
    x.on(end + 1, "io_request", 1)
    x.finish()
    assert x.periods() == plain[:steps]
    assert x.changes("motion_complete")[-1] == (end, 0)
    assert x.changes("ready")[-1] == (end + READY, 1)
    assert x.changes("instrobe") == []  # nothing is read
    assert x.x.position == steps
    assert x.codes.count("fly-rate-outside-continuous") == 1


@pytest.mark.fact("FLY-RATE-11", "UND-FLY-NORMAL")
def test_a_request_that_came_while_the_first_step_was_inhibited_halts_after_it(mover: Make) -> None:
    x = mover(position=0)
    x.send(SMALL + "N 280\r")
    x.put(x.now, "step_inhibit", 1)
    x.give("G\r")
    x.run(50_000)
    x.put(x.now, "io_request", 0)
    x.run(1000)
    x.put(x.now, "step_inhibit", 0)
    x.run(10_000)
    x.bench.run("1 ms")
    x.put(x.now, "io_request", 1)
    x.finish()
    assert x.x.position == 1


@pytest.mark.fact("FLY-RATE-11", "UND-FLY-NORMAL")
def test_a_request_low_when_abort_is_seen_halts_all_the_same(mover: Make) -> None:
    x = mover()
    x.send(SMALL + "N 280\r")
    x.begin()
    end = sum(UP) + 50 * TOP
    x.on(end - 200, "abort", 0)
    x.on(end - 100, "io_request", 0)
    x.on(end + 1, "io_request", 1)
    x.finish()
    assert x.periods() == UP + [TOP] * 50


@pytest.mark.fact("FLY-RATE-12", "UND-FLY-RAMPING")
@pytest.mark.parametrize("rate", [11, 12, 13])
def test_a_request_in_a_ramp_waits_for_the_start_of_slewing(mover: Make, rate: int) -> None:
    x = mover("instrobe")
    x.send(SMALL + "N 60000\r")
    x.begin("H\rG\r")
    x.request(60_000, rate, sum(UP) + 1000)
    x.till(sum(UP) + 300_000)
    served = sum(UP)  # taken where slewing would begin, at the rate 12 that has been reached
    ramp = {11: [MID] * 5, 12: [TOP], 13: [TOP] * 6}[rate]
    assert x.changes("instrobe")[0] == (served, 0)
    assert x.changes("slew") == [(served + sum(ramp), 0)]
    assert x.periods_from(served)[: len(ramp) + 3] == ramp + [x.period(rate)] * 3


@pytest.mark.fact("FLY-RATE-12", "UND-FLY-RAMPING")
def test_a_request_that_is_gone_before_slewing_begins_is_not_seen(mover: Make) -> None:
    x = mover("instrobe")
    x.send(SMALL + "N 60000\r")
    x.begin("H\rG\r")
    x.request(40_000, 30, sum(UP) - 100)
    x.till(sum(UP) + 300_000)
    assert x.changes("instrobe") == []
    assert x.changes("slew") == [(sum(UP), 0)]
    assert x.codes.count("request-withdrawn") == 1


@pytest.mark.fact("FLY-RATE-2")
@pytest.mark.parametrize("stepwise", [False, True], ids=["whole", "stepwise"])
@pytest.mark.parametrize(("low", "high", "missed"), [(100, 600, 1), (-100, 600, 0), (100, TOP + 100, 0)])
def test_a_request_that_comes_and_goes_between_two_samples_is_missed(
    mover: Make, low: int, high: int, missed: int, stepwise: bool
) -> None:
    x = mover("instrobe", stepwise=stepwise)
    look = x.endless(SMALL) + 10 * TOP
    x.request(look + low, 30, look + high)
    x.till(look + 50 * TOP)
    assert len(x.changes("instrobe")) == (0 if missed else 2)
    assert [found.text for found in x.x.findings if found.code == "request-withdrawn"] == [
        "a request was missed" if stepwise else "a rate request began and ended within one step: it was missed"
    ] * missed


@pytest.mark.parametrize("low", [-TOP + 100, -TOP + 4000, -20])
def test_an_observer_of_pulse_sees_every_edge_despite_brief_inputs(mover: Make, low: int) -> None:
    x = mover()
    look = x.endless(SMALL) + 10 * TOP
    edges: list[int] = []
    x.x.pins["pulse"].net.watch(lambda _net: edges.append(x.bench.now_ps))
    x.request(look + low, 30, look + low + 10)  # gone before the look
    x.till(look + 20 * TOP + TOP // 2)
    falls = x.x.steps(edges[0] - 1).times_ps.tolist()
    assert len(falls) >= 20 and [edge for edge in edges if edge in set(falls)] == falls


@pytest.mark.fact("UND-FLY-HELD")
def test_a_request_that_stays_low_counts_once(mover: Make) -> None:
    x = mover("instrobe")
    look = x.endless(SMALL) + 10 * TOP
    x.byte(look - 100, 13)
    x.on(look - 100, "io_request", 0)
    x.byte(look + 20_000, 20)
    x.on(look + 400_000, "io_request", 1)
    x.till(look + 399_000)
    assert x.changes("slew")[1:] == [(look, 1), (look + 6 * TOP, 0)]
    assert len(x.changes("instrobe")) == 2
    assert x.codes.count("request-held") == 1
    x.on(look + 500_000, "io_request", 0)  # after it has been high it counts again
    x.on(look + 520_000, "io_request", 1)
    x.till(look + 600_000)
    assert len(x.changes("instrobe")) == 4


@pytest.mark.fact("UND-FLY-SAME")
def test_the_present_rate_again_changes_neither_rate_for_the_abort(mover: Make) -> None:
    x = mover()
    assert aborted(x, 80) == x.way_up(3, 80, 200)[::-1]
