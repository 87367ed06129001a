"""While the motor turns: rates and read-outs on the fly, the zero rate.  Clocks count 1/11 us at 11 MHz."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from random import Random
from statistics import mean
from typing import Any

import pytest

Make = Callable[..., Any]
SMALL = "F 10\rR 12\rS 246\rZ 10\r"  # one unit every 47,900 clocks
LOW, MID, TOP = 11_000, 10_000, 9167
UP = [LOW] * 5 + [MID] * 5
DOWN = UP[::-1]
READY = 180  # clocks from MOTION COMPLETE to READY
US = 11


def endless(x: Any, setup: str = SMALL) -> int:
    """Begin a continuous motion; the clock at which it begins to slew."""
    x.send(f"{setup}N 60000\r")
    x.begin("H\rG\r")
    x.until(slew=0)
    return x.now - x.origin  # type: ignore[no-any-return]


def ask(x: Any, rate: int) -> int:
    """Ask for a rate as a host does, until SLEW is high; the clock of the motion at which it rose."""
    x.data(x.now, rate)
    x.put(x.now, "io_request", 0)
    x.until(slew=1)
    x.put(x.now, "io_request", 1)
    x.data(x.now, None)
    return x.now - x.origin  # type: ignore[no-any-return]


def steps_from(x: Any, clock: int) -> list[int]:
    """Clocks of the steps that began at a clock of the motion or later."""
    number = sum(begin < clock for begin in x.begins())
    return x.periods()[number:]  # type: ignore[no-any-return]


def longer(periods: list[int], step: int, clocks: int) -> list[int]:
    return [*periods[:step], periods[step] + clocks, *periods[step + 1 :]]


# ------------------------------------------------------------------------------------------------ rates on the fly, s.7
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
def test_a_request_at_any_phase_is_answered_within_the_present_step(mover: Make, rate: int, period: int) -> None:
    x = mover("instrobe", firstrate=rate, rate=rate)
    endless(x, "")
    chance, waited = Random(525), []
    for _ in range(1000):
        x.run(chance.randrange(period, 3 * period))
        asked = x.now
        waited.append(ask(x, rate) + x.origin - asked)
        x.until(slew=0)
    assert min(waited) > 0 and max(waited) <= period
    assert mean(waited) == pytest.approx(period / 2, rel=0.1)
    slew = x.changes("slew")[1:]
    rises, falls = slew[::2], slew[1::2]
    assert [fall - rise for (rise, _), (fall, _) in zip(rises, falls, strict=True)] == [period] * 1000
    strobes = [clock for clock, level in x.changes("instrobe") if level == 0]
    assert strobes == [rise for rise, _ in rises]  # each request is taken once, as SLEW rises
    assert set(x.periods()) == {period}


@pytest.mark.fact("UND-FLY-SAMPLE", "FLY-RATE-2")
@pytest.mark.parametrize(("clock", "late"), [(-1, 0), (0, TOP), (1, TOP)])
def test_the_request_is_looked_at_as_a_step_begins_and_the_byte_is_read_there(
    mover: Make, clock: int, late: int
) -> None:
    x = mover("instrobe")
    look = endless(x) + 20 * TOP
    x.byte(look - TOP + 1, 99)
    x.byte(look + late - 1, 11)  # what lies on the bus at the look counts
    x.byte(look + late, 127)
    x.on(look + clock, "io_request", 0)
    x.on(look + 2 * TOP, "io_request", 1)
    x.till(look + 200_000)
    rise = look + late
    assert x.changes("slew")[1:] == [(rise, 1), (rise + 5 * MID, 0)]
    assert x.changes("instrobe") == [(rise, 0), (rise + US, 1)]
    assert steps_from(x, rise)[:10] == [MID] * 10


@pytest.mark.fact("FLY-RATE-4", "RAMP-6")
def test_a_change_follows_the_segment_of_the_start_ramp_between_the_two_rates(mover: Make) -> None:
    x = mover()
    endless(x, "F 40\rR 40\rS 150\rZ 1\r")
    x.run(100_000)
    up, curve = ask(x, 80), x.way_up(40, 80, 150)
    x.until(slew=0)
    assert x.now - x.origin == up + sum(curve)
    x.run(50 * 1840)
    down = ask(x, 40)
    x.until(slew=0)
    assert x.now - x.origin == down + sum(curve)
    x.run(20 * 2750)
    after = steps_from(x, up)
    slewed = (down - up - sum(curve)) // 1840
    assert after[: 2 * len(curve) + slewed] == curve + [1840] * slewed + curve[::-1]
    assert set(after[2 * len(curve) + slewed :]) == {2750}
    y = mover()  # the same segment when a motion starts with it
    endless(y, "F 40\rR 80\rS 150\rZ 1\r")
    assert y.periods() == curve and y.now - y.origin == sum(curve)


def aborted(x: Any, *changes: int) -> list[int]:
    """F 3, R 80; rates on the fly one after the other, then ABORT held low: clocks of the steps from then on."""
    endless(x, "F 3\rR 80\rS 200\rZ 1\r")
    for rate in changes:
        x.run(100_000)
        ask(x, rate)
        x.until(slew=0)
    x.run(100_000)
    x.put(x.now, "abort", 0)
    low = x.now - x.origin
    x.finish()
    x.put(x.now, "abort", 1)
    return steps_from(x, low)


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
    endless(x, "F 3\rR 20\rS 255\rZ 1\r")
    for byte, period in ((1, 38_869), (127, 1137)):
        x.run(100_000)
        ask(x, byte)
        x.until(slew=0)
        start = x.now - x.origin
        x.run(10 * period)
        assert set(steps_from(x, start)) == {period}


@pytest.mark.fact("UND-FLY-BIT7")
@pytest.mark.parametrize("byte", [0x80, 0xFF])
def test_bytes_above_127_are_rate_127_and_never_the_zero_rate(mover: Make, byte: int) -> None:
    x = mover()
    endless(x, "F 100\rR 100\rS 200\rZ 1\r")
    x.run(10_000)
    ask(x, byte)
    x.until(slew=0)
    start = x.now - x.origin
    x.run(100_000)
    assert set(steps_from(x, start)) == {1137}
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
def test_a_request_in_a_ramp_waits_for_the_begin_of_slewing(mover: Make, rate: int) -> None:
    x = mover("instrobe")
    x.send(SMALL + "N 60000\r")
    x.begin("H\rG\r")
    x.request(60_000, rate, sum(UP) + 1000)
    x.till(sum(UP) + 300_000)
    served = sum(UP)  # taken where slewing would begin, at the rate 12 that has been reached
    ramp = {11: [MID] * 5, 12: [TOP], 13: [TOP] * 6}[rate]
    assert x.changes("instrobe")[0] == (served, 0)
    assert x.changes("slew") == [(served + sum(ramp), 0)]
    assert steps_from(x, served)[: len(ramp) + 3] == ramp + [x.period(rate)] * 3


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


@pytest.mark.fact("UND-FLY-HELD")
def test_a_request_that_stays_low_counts_once(mover: Make) -> None:
    x = mover("instrobe")
    look = endless(x) + 10 * TOP
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


# ----------------------------------------------------------------------------------------------------- the zero rate
def zero(x: Any, setup: str = SMALL) -> int:
    """Ask for rate 0 after ten steps of slewing; the clock at which stepping ends."""
    look = endless(x, setup) + 10 * TOP
    x.request(look - 500, 0)
    x.till(look + 50_000)
    return look


@pytest.mark.fact("FLY-ZERO-1", "RATE-5", "SLEW-5", "CON-R-LOW")
def test_rate_0_stops_the_steps_at_once_and_keeps_slewing(mover: Make) -> None:
    x = mover("instrobe", "phase1", "phase2")
    look = zero(x)
    x.till(look + 10_000_000)
    assert x.begins()[-1] == look - TOP and len(x.begins()) == 20
    assert x.changes("slew")[1:] == [(look, 1), (look + 10 * US, 0)]
    assert x.changes("motion_complete") == [(look, 0)]
    assert x.changes("instrobe") == [(look, 0), (look + US, 1)]
    assert x.changes("pulse")[-1] == (look - 28, 1)
    assert x.x.pin("ready").level == 0
    assert "rate 0" in x.x.waiting


@pytest.mark.fact("FLY-ZERO-2", "UND-FLY-ZERO-REGS", "SLEW-5")
def test_a_higher_rate_goes_on_from_the_old_one(mover: Make) -> None:
    x = mover("instrobe")
    look = zero(x)
    asked = look + 500_000
    x.request(asked, 13, asked + 20_000)
    x.till(asked + 300_000)
    begin = x.begins()[20]
    assert 0 < begin - asked <= 8 * US  # polled
    assert steps_from(x, begin)[:10] == [TOP] * 6 + [x.period(13)] * 4
    assert x.changes("slew")[3:] == [(begin, 1), (begin + 6 * TOP, 0)]
    assert x.changes("motion_complete")[1:] == [(begin, 1)]  # with the first new step
    assert [clock for clock, level in x.changes("instrobe") if level == 0] == [look, begin]


@pytest.mark.fact("FLY-ZERO-2", "FLY-ZERO-3", "UND-FLY-ZERO-LOW")
@pytest.mark.parametrize(("setup", "low", "high"), [(SMALL, (12, 0, 3), 13), ("F 2\rR 2\rS 200\rZ 1\r", (2, 1), 3)])
def test_at_rate_0_only_a_rate_above_the_old_one_counts(
    mover: Make, setup: str, low: tuple[int, ...], high: int
) -> None:
    x = mover()
    endless(x, setup)
    x.run(100_000)
    ask(x, 0)
    made = x.x.travel
    clock = x.now - x.origin + 50_000
    for rate in low:
        x.request(clock, rate, clock + 20_000)
        clock += 100_000
    x.till(clock)
    assert x.x.travel == made
    assert (x.x.pin("slew").level, x.x.pin("motion_complete").level, x.x.pin("ready").level) == (0, 0, 0)
    assert x.codes.count("fly-zero-low") == len(low)
    x.request(clock, high, clock + 20_000)
    x.till(clock + 200_000)
    assert x.x.travel > made


@pytest.mark.fact("FLY-ZERO-2", "UND-FLY-HELD")
def test_the_request_of_the_zero_must_be_high_before_the_next_one(mover: Make) -> None:
    x = mover()
    look = endless(x) + 10 * TOP
    x.byte(look - 500, 0)
    x.on(look - 500, "io_request", 0)
    x.byte(look + 50_000, 20)  # still low: no new request
    x.till(look + 500_000)
    assert len(x.begins()) == 20
    x.on(look + 500_000, "io_request", 1)
    x.on(look + 600_000, "io_request", 0)
    x.till(look + 700_000)
    assert len(x.begins()) > 20


@pytest.mark.fact("FLY-ZERO-4", "SLEW-5")
def test_abort_ends_the_zero_rate(rig: Make) -> None:
    x = rig(record=("motion_complete", "ready", "slew"), position=100)
    x.send("A 100\r" + SMALL + "N 60000\r")
    x.host.send("H\rG\r")
    x.bench.run_until(x.x.pin("slew").is_(0))
    x.bench.run("20 ms")
    x.host.change_rate(0)
    x.bench.run("20 ms")
    stopped = x.x.position
    start = x.bench.now_ps
    x.drive("abort", 0)
    x.bench.run_until_idle()
    assert (x.level("ready"), x.level("slew"), x.level("motion_complete")) == (1, 1, 0)
    rise = x.rises("slew", start)[0]
    assert 0 < rise - start <= 8_000_000  # the poll
    assert x.falls("motion_complete", start) == []  # low already
    x.drive("abort", 1)
    assert x.host.verify(0) == b"%05d" % stopped
    x.send("N 300\rG\r")
    assert x.x.position == stopped + 300  # and the continuous flag is gone


@pytest.mark.fact("UND-FLY-ZERO-REGS", "ABORT-10")
def test_after_the_zero_rate_an_abort_ramps_down_to_the_first_rate(mover: Make) -> None:
    x = mover()
    look = zero(x)
    x.request(look + 100_000, 13, look + 120_000)
    x.till(look + 300_000)
    x.put(x.now, "abort", 0)
    low = x.now - x.origin
    x.finish()
    assert steps_from(x, low) == x.way_up(10, 13, 246, 10)[::-1]


@pytest.mark.fact("UND-FLY-ZERO-REGS", "FLY-RATE-8")
def test_a_zero_after_a_lower_rate_keeps_that_as_the_first_rate(mover: Make) -> None:
    x = mover()
    endless(x)
    ask(x, 11)
    x.until(slew=0)
    x.run(50_000)
    ask(x, 0)
    x.run(50_000)
    clock = x.now - x.origin
    x.request(clock, 12, clock + 20_000)
    x.till(clock + 300_000)
    x.put(x.now, "abort", 0)
    low = x.now - x.origin
    x.finish()
    assert steps_from(x, low) == [MID] * 5


@pytest.mark.fact("FLY-ZERO-2", "UND-INHIBIT-ABORT")
def test_inhibit_holds_the_restart_after_the_zero_rate(mover: Make) -> None:
    x = mover()
    look = zero(x)
    x.on(look + 60_000, "step_inhibit", 1)
    x.request(look + 100_000, 13, look + 120_000)
    x.till(look + 500_000)
    assert len(x.begins()) == 20
    assert (x.x.pin("slew").level, x.x.pin("pulse").level, x.x.pin("motion_complete").level) == (1, 1, 0)
    x.on(look + 500_000, "step_inhibit", 0)
    x.till(look + 700_000)
    assert 0 < x.begins()[20] - look - 500_000 <= 3 * US
    assert x.periods()[20:26] == [TOP] * 6


@pytest.mark.fact("UND-ABORT-CONT-LOW")
def test_with_abort_low_from_the_start_the_zero_rate_has_no_exit_by_abort(mover: Make) -> None:
    x = mover()
    x.put(x.now, "abort", 0)
    look = zero(x)
    x.on(look + 100_000, "abort", 1)
    x.on(look + 200_000, "abort", 0)
    x.till(look + 2_000_000)
    assert len(x.begins()) == 20 and x.x.pin("ready").level == 0
    x.request(look + 2_000_000, 20, look + 2_100_000)
    x.till(look + 3_000_000)
    assert len(x.begins()) > 20


# ------------------------------------------------------------------------------------------------ read-outs on the fly
def read(x: Any, clock: int, until: int | None = None) -> None:
    """I/O SELECT high at a clock of the motion, for a good step or to another clock."""
    x.on(clock, "io_select", 1)
    x.on(clock + 11_500 if until is None else until, "io_select", 0)


@pytest.mark.fact("FLY-POS-2", "UND-FLY-POS-SAMPLE", "UND-MC-FLY", "CON-FLY-MC")
@pytest.mark.parametrize("position", [0x00FE, 0x00FF, 0xFFFE, 0xFFFF, 0x12FE])
def test_a_read_out_puts_both_bytes_of_one_position_on_the_bus(mover: Make, position: int) -> None:
    x = mover("outstrobe", "db", position=position, firstrate=10, rate=10, number=3)
    x.begin()
    read(x, 100)
    x.finish()
    b = LOW  # the second step: position + 2
    value = (position + 2) % 65536
    # high byte while MOTION COMPLETE is high, low byte while it is low, then high impedance
    assert x.changes("outstrobe") == [(b + 44, 0), (b + 55, 1), (b + 154, 0), (b + 165, 1)]
    assert x.changes("motion_complete") == [(b + 99, 0), (b + 209, 1), (3 * LOW, 0)]
    bus = [(b + 44, value >> 8), (b + 99, value & 0xFF), (b + 209, -1)]
    assert x.changes("db") == [
        edge for before, edge in zip([-1, *(level for _, level in bus)], bus, strict=False) if before != edge[1]
    ]
    assert 30 * US >= 209


@pytest.mark.fact("FLY-POS-1", "FLY-POS-6")
@pytest.mark.parametrize("straps", [{}, {"ascii_binary": 0}])
@pytest.mark.parametrize("continuous", [False, True])
def test_the_position_is_binary_in_both_modes_and_both_kinds_of_motion(
    rig: Make, straps: dict[str, int], continuous: bool
) -> None:
    x = rig(
        straps=straps, record=("outstrobe",), position=0xFFF0, number=2000, firstrate=20, rate=60, slope=250, divisor=1
    )
    x.host.send((b"H\x00G\x00" if continuous else b"G\x00") if straps else b"H\rG\r" if continuous else b"G\r")
    x.bench.run_until(x.x.pin("pulse").is_(0))
    read = [x.host.read_position() for _ in range(40)]
    strobes = x.falls("outstrobe")[::2]
    assert read == [x.x.position_at(strobe) for strobe in strobes]
    assert len(set(read)) == 40 and read[0] > 0xFFF0 and read[-1] < 0x100


@pytest.mark.fact("FLY-POS-3", "UND-FLY-POS-LATE")
def test_while_select_stays_high_every_step_is_read_out(mover: Make) -> None:
    x = mover("outstrobe", "db", number=30, firstrate=10, rate=10, position=0x1234)
    x.begin()
    read(x, 5 * LOW - 1, 15 * LOW - 1)
    x.finish()
    falls = [clock for clock, level in x.changes("outstrobe") if level == 0]
    assert falls == [k * LOW + late for k in range(5, 15) for late in (44, 154)]
    assert [level for _, level in x.changes("db") if level != -1] == [
        byte for k in range(5, 15) for byte in (0x12, 0x35 + k)
    ]


@pytest.mark.fact("FLY-POS-3")
def test_select_low_within_50_us_is_exactly_one_read_out(mover: Make) -> None:
    x = mover("outstrobe", number=30, firstrate=127, rate=127)  # steps of 103 us
    x.begin()
    read(x, 5 * 1137 - 1, 5 * 1137 + 209 + 50 * US)
    x.finish()
    assert len(x.changes("outstrobe")) == 4


@pytest.mark.fact("FLY-POS-4", "UND-FLY-POS-CRAWL", "UND-RAMP-TIME")
@pytest.mark.parametrize("crystal", ["11 MHz", "6 MHz"])
@pytest.mark.parametrize(
    ("number", "step", "clocks"),
    [
        (276, 1, 220),
        (276, 9, 220),
        (276, 10, 0),
        (276, 100, 0),
        (276, 265, 0),
        (276, 266, 220),
        (276, 275, 220),
        (70, 30, 0),
    ],
)
def test_a_read_out_lengthens_a_step_by_20_us_in_the_ramps_only(
    mover: Make, crystal: str, number: int, step: int, clocks: int
) -> None:
    # 220 clocks are 20 us at 11 MHz and 36.7 us at 6 MHz; neither slewing nor the steps at F after the ramp are ramps
    plain = UP + [TOP] * 256 + DOWN if number == 276 else UP + DOWN + [LOW] * 50
    x = mover(crystal=crystal)
    x.send(f"{SMALL}N {number}\r")
    x.begin()
    begin = sum(plain[:step])
    read(x, begin - 100, begin + 300)
    x.finish()
    assert x.periods() == longer(plain, step, clocks)  # and the 20 us are no ramp time: the rest is as it was
    if clocks:
        ps = x.x.clock.ps(x.origin + begin + clocks) - x.x.clock.ps(x.origin + begin)
        assert ps == pytest.approx(20_000_000 if crystal == "11 MHz" else 36_666_667, abs=1)


@pytest.mark.fact("FLY-POS-4", "UND-RAMP-TIME")
def test_read_outs_of_every_step_lengthen_both_ramps_and_nothing_else(mover: Make) -> None:
    x = mover(number=276)
    x.send(SMALL)
    x.begin()
    read(x, 100, 276 * LOW)
    x.finish()
    assert x.periods() == [LOW, *(period + 220 for period in UP[1:]), *[TOP] * 256, *(period + 220 for period in DOWN)]


@pytest.mark.fact("UND-FLY-POS-BOTH")
def test_a_rate_request_goes_before_a_read_out(mover: Make) -> None:
    x = mover("outstrobe", "instrobe")
    look = endless(x) + 10 * TOP
    x.request(look - 500, 13, look + 200)
    read(x, look - 500, look + 400)
    x.till(look + 100_000)
    assert x.changes("outstrobe") == []
    assert x.changes("instrobe") == [(look, 0), (look + US, 1)]
    assert x.changes("slew")[1][0] == look
    assert x.codes.count("request-and-select") == 1


@pytest.mark.fact("UND-FLY-POS-SAMPLE")
@pytest.mark.parametrize(
    ("rises", "falls", "step"), [(-1, 0, 5), (-1, 1, 5), (0, 1, None), (0, LOW + 1, 6), (1, LOW - 1, None)]
)
def test_select_is_looked_at_as_a_step_begins(mover: Make, rises: int, falls: int, step: int | None) -> None:
    x = mover("outstrobe", number=30, firstrate=10, rate=10)
    x.begin()
    x.on(5 * LOW + rises, "io_select", 1)
    x.on(5 * LOW + falls, "io_select", 0)
    x.finish()
    strobes = [clock for clock, level in x.changes("outstrobe") if level == 0]
    assert strobes == ([] if step is None else [step * LOW + 44, step * LOW + 154])


@pytest.mark.fact("UND-FLY-POS-LATE")
def test_select_still_high_when_the_motion_ends_leads_to_verify_bytes(mover: Make) -> None:
    x = mover("outstrobe", number=3, firstrate=10, rate=10)
    x.send("V 3\r")
    x.begin()
    x.on(LOW // 2, "io_select", 1)
    x.finish()
    assert len([level for _, level in x.changes("outstrobe") if level == 0]) == 4  # the second and third step
    assert x.fetch(6) == bytes([0, 3, 255, 10, 10, 1])


@pytest.mark.fact("UND-FLY-POS-IDLE")
def test_a_read_out_asked_during_a_hold_is_answered_by_the_next_step(mover: Make) -> None:
    x = mover("outstrobe", number=5, firstrate=10, rate=10)
    x.begin()
    rise = 2 * LOW - 28
    x.on(rise - 100, "step_inhibit", 1)
    x.on(rise + 50_000, "io_select", 1)
    x.till(rise + 200_000)
    assert x.changes("outstrobe") == []
    x.on(rise + 200_000, "step_inhibit", 0)
    x.on(rise + 200_000 + 2000, "io_select", 0)
    x.finish()
    third = x.begins()[2]
    assert [clock for clock, level in x.changes("outstrobe") if level == 0] == [third + 44, third + 154]


@pytest.mark.fact("UND-FLY-POS-IDLE")
def test_an_inhibited_step_is_read_out_once(mover: Make) -> None:
    x = mover("outstrobe", number=5, firstrate=10, rate=10)
    x.begin()
    x.on(LOW - 100, "io_select", 1)
    x.on(LOW + 500, "step_inhibit", 1)
    x.till(20 * LOW)
    assert [clock for clock, level in x.changes("outstrobe") if level == 0] == [LOW + 44, LOW + 154]


@pytest.mark.fact("UND-FLY-POS-IDLE")
def test_at_the_zero_rate_nothing_is_read_out(mover: Make) -> None:
    x = mover("outstrobe")
    look = zero(x)
    x.on(look + 60_000, "io_select", 1)
    x.till(look + 1_000_000)
    assert x.changes("outstrobe") == []
    x.request(look + 1_000_000, 13, look + 1_000_500)
    x.till(look + 1_005_000)
    begin = x.begins()[20]
    assert x.changes("outstrobe") == []  # the request was still low as this step began
    x.on(begin + TOP + 2000, "io_select", 0)
    x.till(look + 1_100_000)
    falls = [clock for clock, level in x.changes("outstrobe") if level == 0]
    assert falls == [begin + TOP + 44, begin + TOP + 154]
