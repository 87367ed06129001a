"""The zero rate: rate 0 on the fly, and the two ways out of it.  Clocks of 11 MHz."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

Make = Callable[..., Any]
SMALL = "F 10\rR 12\rS 245\rZ 10\r"  # one unit every 49,720 clocks
MID, TOP = 10_000, 9167
US = 11


def zero(x: Any, setup: str = SMALL) -> int:
    """Ask for rate 0 after ten steps of slewing; the clock at which stepping ends."""
    look = x.endless(setup) + 10 * TOP
    x.request(look - 500, 0)
    x.till(look + 50_000)
    return look


@pytest.mark.fact("FLY-ZERO-1", "RATE-5", "SLEW-5", "CON-R-LOW")
def test_rate_0_stops_the_steps_immediately_and_keeps_slewing(mover: Make) -> None:
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
def test_a_higher_rate_continues_from_the_old_one(mover: Make) -> None:
    x = mover("instrobe")
    look = zero(x)
    asked = look + 500_000
    x.request(asked, 13, asked + 20_000)
    x.till(asked + 300_000)
    begin = x.begins()[20]
    assert 0 < begin - asked <= 8 * US  # polled
    assert x.periods_from(begin)[:10] == [TOP] * 6 + [x.period(13)] * 4
    assert x.changes("slew")[3:] == [(begin, 1), (begin + 6 * TOP, 0)]
    assert x.changes("motion_complete")[1:] == [(begin, 1)]  # with the first new step
    assert [clock for clock, level in x.changes("instrobe") if level == 0] == [look, begin]


@pytest.mark.fact("FLY-ZERO-2", "FLY-ZERO-3", "UND-FLY-ZERO-LOW")
@pytest.mark.parametrize(("setup", "low", "high"), [(SMALL, (12, 0, 3), 13), ("F 2\rR 2\rS 200\rZ 1\r", (2, 1), 3)])
def test_at_rate_0_only_a_rate_above_the_old_one_counts(
    mover: Make, setup: str, low: tuple[int, ...], high: int
) -> None:
    x = mover()
    x.endless(setup)
    x.run(100_000)
    x.ask(0)
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
    look = x.endless(SMALL) + 10 * TOP
    x.byte(look - 500, 0)
    x.on(look - 500, "io_request", 0)
    x.byte(look + 50_000, 20)  # still low: no new request
    x.till(look + 500_000)
    assert len(x.begins()) == 20
    x.on(look + 500_000, "io_request", 1)
    x.on(look + 600_000, "io_request", 0)
    x.till(look + 700_000)
    assert len(x.begins()) > 20


@pytest.mark.fact("FLY-ZERO-4")
def test_abort_ends_the_zero_rate_while_its_request_is_still_low(mover: Make) -> None:
    x = mover()
    look = x.endless(SMALL) + 10 * TOP
    x.byte(look - 500, 0)
    x.on(look - 500, "io_request", 0)
    x.on(look + 500_000, "abort", 0)
    x.till(look + 500_000)
    assert [x.x.pin(pin).level for pin in ("slew", "ready")] == [0, 0]
    x.run(88 + 180 + 1)  # a poll, and READY behind the motion
    assert [x.x.pin(pin).level for pin in ("slew", "ready")] == [1, 1]


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
    assert x.periods_from(low) == x.way_up(10, 13, 245, 10)[::-1]


@pytest.mark.fact("UND-FLY-ZERO-REGS", "FLY-RATE-8")
def test_a_zero_after_a_lower_rate_keeps_that_as_the_first_rate(mover: Make) -> None:
    x = mover()
    x.endless(SMALL)
    x.ask(11)
    x.until(slew=0)
    x.run(50_000)
    x.ask(0)
    x.run(50_000)
    clock = x.now - x.origin
    x.request(clock, 12, clock + 20_000)
    x.till(clock + 300_000)
    x.put(x.now, "abort", 0)
    low = x.now - x.origin
    x.finish()
    assert x.periods_from(low) == [MID] * 5


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


@pytest.mark.fact("FLY-ZERO-2")
@pytest.mark.parametrize(
    ("rate", "abort", "ways"),
    [(12, 1, "a rate above 12, or abort=0"), (12, 0, "a rate above 12"), (127, 1, "abort=0"), (127, 0, "RESET")],
)
def test_the_exits_from_the_zero_rate_are_reported(mover: Make, rate: int, abort: int, ways: str) -> None:
    x = mover(number=60_000)
    x.put(x.now, "abort", abort)
    look = zero(x, f"F 10\rR {rate}\rS 255\rZ 1\r") if rate == 12 else zero(x, "F 127\rR 127\rS 255\rZ 1\r")
    assert x.x.waiting.startswith(f"x: G at rate 0, waiting for {ways} since ")
    x.request(x.now - x.origin + 1000, 5)
    x.till(look + 200_000)
    told = [found.text for found in x.x.findings if found.code == "fly-zero-low"]
    assert told == [f"a request for rate 5 has no effect at rate 0; required: {ways}"]
