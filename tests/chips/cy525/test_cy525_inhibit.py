"""STEP INHIBIT: the steps it holds, when the chip looks at it, and what waits behind it.  Clocks of 11 MHz.

A step is looked at when PULSE would rise, 28 clocks (2.5 us) before its end; a held step looks again every 33 (3 us).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

HIGH, POLL = 28, 33
SMALL = "F 10\rR 12\rS 245\rZ 10\r"  # one unit every 49,720 clocks
LOW, TOP = 11_000, 9167
UP = [LOW] * 5 + [10_000] * 5
MOVE = UP + [TOP] * 256 + UP[::-1]  # N 276
CRAWLED = UP + UP[::-1] + [LOW] * 50  # N 70
Make = Callable[..., Any]


def longer(periods: list[int], step: int, clocks: int) -> list[int]:
    return [*periods[:step], periods[step] + clocks, *periods[step + 1 :]]


def held(rise: int, release: int) -> int:
    """Clocks by which a hold lengthens a step: from the rise of PULSE that did not come to the look that lets go."""
    return -((rise - release) // POLL) * POLL


@pytest.mark.fact("INHIBIT-1", "UND-INHIBIT-FIRST", "CON-INHIBIT-PULSE")
@pytest.mark.parametrize("command", ["P 1\r", "G\r"])
def test_a_motion_does_not_begin_while_inhibited(mover: Make, command: str) -> None:
    x = mover("phase1", "phase2", "phase3", "phase4", number=1, rate=10, firstrate=10, position=0)
    x.put(x.now, "step_inhibit", 1)
    x.give(command)
    x.bench.run("1 s")
    phases = [f"phase{n}" for n in (1, 2, 3, 4)]
    assert x.x.position == 0
    assert all(x.x.pin(pin).level == 1 for pin in (*phases, "pulse"))  # before the first step PULSE waits high
    assert x.x.pin("ready").level == 0
    assert not [edge for pin in (*phases, "pulse") for edge in x.bench.edges(f"x.{pin}")[0]]

    release = x.now
    x.put(release, "step_inhibit", 0)
    x.finish()
    assert x.x.position == 1
    (step,) = x.x.steps().times_ps.tolist()
    assert 0 < x.x.clock.ticks_until(step) - release <= POLL


@pytest.mark.fact("INHIBIT-2", "INHIBIT-3", "CON-INHIBIT-PULSE", "UND-RAMP-TIME")
@pytest.mark.parametrize(
    ("number", "step"),
    [*((276, step) for step in (0, 3, 9, 10, 100, 265, 266, 275)), *((70, step) for step in (19, 20, 69))],
)
def test_a_hold_lengthens_the_step_that_runs_and_nothing_else(mover: Make, number: int, step: int) -> None:
    plain = MOVE if number == 276 else CRAWLED
    x = mover("direction", number=number, position=65_500)
    x.send(SMALL)
    x.begin()
    rise = sum(plain[: step + 1]) - HIGH
    release = rise + 550_000  # 50 ms
    x.on(rise - 5000, "step_inhibit", 1)
    x.on(release, "step_inhibit", 0)
    x.till(rise + 275_000)
    assert x.x.pin("pulse").level == 0
    assert x.x.pin("slew").level == (0 if number == 276 and 10 <= step < 266 else 1)
    x.finish()
    # what follows is the plan as it was: a hold is no ramp time
    assert x.periods() == longer(plain, step, held(rise, release))
    assert x.x.position == (65_500 + number) % 65536


@pytest.mark.fact("INHIBIT-2", "UND-INHIBIT-FIRST")
@pytest.mark.parametrize("step", [4, 9, 50, 265, 270, 275])
@pytest.mark.parametrize(("rises", "falls", "holds"), [(-1, 0, 1), (-1, 1, 1), (0, 1, 0), (-40, -1, 0), (1, HIGH, 0)])
def test_only_the_level_at_the_end_of_a_step_counts(mover: Make, step: int, rises: int, falls: int, holds: int) -> None:
    # the look sees the level from before its instant, and so does the first look of a hold, one poll later
    x = mover(number=276)
    x.send(SMALL)
    x.begin()
    rise = sum(MOVE[: step + 1]) - HIGH
    x.on(rise + rises, "step_inhibit", 1)
    x.on(rise + falls, "step_inhibit", 0)
    x.finish()
    assert x.periods() == longer(MOVE, step, holds * POLL)


@pytest.mark.fact("INHIBIT-2")
def test_inhibit_that_comes_between_the_last_step_and_its_end_holds_nothing(mover: Make) -> None:
    x = mover(number=2, rate=10, firstrate=10)
    x.begin()
    x.on(2 * LOW - HIGH, "step_inhibit", 1)
    x.till(3 * LOW)
    assert x.periods() == [LOW, LOW]
    assert x.changes("ready")[-1] == (2 * LOW + 180, 1)


@pytest.mark.fact("INHIBIT-4")
def test_three_pulses_release_three_steps(mover: Make) -> None:
    x = mover(number=3, rate=10, firstrate=10)
    x.put(x.now, "step_inhibit", 1)
    x.give("G\r")
    x.run(100_000)
    begin = x.now
    for clock in (0, 40_000, 90_000):  # low for half a step, a whole period and more apart
        x.put(begin + clock, "step_inhibit", 0)
        x.put(begin + clock + LOW // 2, "step_inhibit", 1)
        x.run_to(begin + clock + 39_000)
        times = x.x.steps().times_ps.tolist()
        assert len(times) == {0: 1, 40_000: 2, 90_000: 3}[clock]  # one step begins at each pulse
        assert 0 <= x.x.clock.ticks_until(times[-1]) - begin - clock <= POLL + HIGH
    x.run(1_000_000)
    assert x.x.pin("pulse").level == 0 and x.x.pin("ready").level == 0  # the third is held until inhibit falls again
    x.put(x.now, "step_inhibit", 0)
    x.finish()
    assert len(x.x.steps()) == 3


@pytest.mark.fact("INHIBIT-4")
def test_with_inhibit_low_steps_run_freely(mover: Make) -> None:
    x = mover(number=3, rate=10, firstrate=10)
    x.put(x.now, "step_inhibit", 1)
    x.give("G\r")
    x.run(100_000)
    x.put(x.now, "step_inhibit", 0)
    x.finish()
    first, second, third = (x.x.clock.ticks_until(time) for time in x.x.steps().times_ps.tolist())
    assert (second - first, third - second) == (LOW, LOW)


@pytest.mark.fact("INHIBIT-5")
def test_an_inhibited_last_step_delays_motion_complete_and_ready(mover: Make) -> None:
    x = mover()
    x.send("R 80\rS 255\rF 10\rN 4\r")
    x.begin()
    x.on(32_000, "step_inhibit", 1)
    x.till(2_000_000)
    fast = x.period(11)  # one unit every 452 clocks: 24 of them are due after the first step, and one is taken
    assert x.begins() == [0, LOW, LOW + fast, LOW + 2 * fast]
    assert (x.x.pin("motion_complete").level, x.x.pin("ready").level, x.x.pin("pulse").level) == (1, 0, 0)
    release = 2_000_000
    x.on(release, "step_inhibit", 0)
    x.finish()
    end = x.changes("motion_complete")[-1][0]
    assert release + HIGH <= end <= release + POLL + HIGH
    assert x.changes("ready")[-1] == (end + 180, 1)


@pytest.mark.fact("UND-INHIBIT-ABORT")
def test_abort_during_a_hold_is_seen_when_the_inhibited_step_ends(mover: Make) -> None:
    x = mover(number=1000)
    x.send(SMALL)
    x.begin()
    rise = sum(UP) + 10 * TOP - HIGH
    release = rise + 400_000
    x.on(rise - 100, "step_inhibit", 1)
    x.on(rise + 100_000, "abort", 0)
    x.on(release, "step_inhibit", 0)
    x.finish()
    assert x.periods() == longer(UP + [TOP] * 10 + UP[::-1], 19, held(rise, release))


@pytest.mark.fact("UND-INHIBIT-ABORT", "UND-ABORT-SAMPLE")
def test_an_abort_released_before_the_inhibited_step_ends_is_missed(mover: Make) -> None:
    x = mover(number=276)
    x.send(SMALL)
    x.begin()
    rise = sum(MOVE[:101]) - HIGH
    x.on(rise - 100, "step_inhibit", 1)
    x.on(rise + 100_000, "abort", 0)
    x.on(rise + 200_000, "abort", 1)
    x.on(rise + 400_000, "step_inhibit", 0)
    x.finish()
    assert x.periods() == longer(MOVE, 100, held(rise, rise + 400_000))


@pytest.mark.fact("UND-INHIBIT-ABORT")
def test_a_rate_request_during_a_hold_is_seen_when_the_inhibited_step_ends(mover: Make) -> None:
    x = mover(number=60_000)
    x.send(SMALL)
    x.begin("H\rG\r")
    rise = sum(UP) + 10 * TOP - HIGH
    release = rise + 400_000
    x.on(rise - 100, "step_inhibit", 1)
    x.request(rise + 1000, 13, up=release + 2 * TOP)
    x.on(release, "step_inhibit", 0)
    x.till(release + 20 * LOW)
    end = rise + held(rise, release) + HIGH
    assert x.changes("slew")[1:3] == [(end, 1), (end + 6 * TOP, 0)]  # six steps, until the unit of 47,900 is over
    assert x.periods()[20:29] == [TOP] * 6 + [x.period(13)] * 3
    assert "request-withdrawn" not in x.codes  # it was served, and stayed for two more steps


@pytest.mark.fact("INHIBIT-2", "FLY-POS-3")
@pytest.mark.parametrize("at", [400, 550, 700])
def test_a_short_inhibit_does_not_hide_a_read_out_of_the_same_step(mover: Make, at: int) -> None:
    x = mover("outstrobe", number=276)
    x.send(SMALL)
    x.begin()
    begin = sum(MOVE[:20])
    x.on(begin + 500, "step_inhibit", 1)
    x.on(begin + 600, "step_inhibit", 0)
    x.on(begin + at, "io_select", 1)
    x.on(begin + TOP + 1000, "io_select", 0)
    x.finish()
    strobes = [clock for clock, level in x.changes("outstrobe") if level == 0]
    assert [clock - begin - TOP for clock in strobes] == [44, 154]  # with the next step


@pytest.mark.fact("INHIBIT-2", "UND-FLY-NORMAL")
@pytest.mark.parametrize("at", [400, 550, 700])
def test_a_short_inhibit_does_not_hide_a_request_of_the_same_step(mover: Make, at: int) -> None:
    x = mover(number=276)
    x.send(SMALL)
    x.begin()
    begin = sum(MOVE[:20])
    x.on(begin + 500, "step_inhibit", 1)
    x.on(begin + 600, "step_inhibit", 0)
    x.on(begin + at, "io_request", 0)
    x.on(begin + TOP + 1, "io_request", 1)
    x.till(begin + 2 * TOP)
    assert x.periods() == [*MOVE[:20], TOP]  # a normal motion halts
