"""Continuous motion: H, the motion that it begins, and how that ends.  Clocks of 11 MHz."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

Make = Callable[..., Any]
SMALL = "F 10\rR 12\rS 245\rZ 10\r"  # one unit every 49,720 clocks
UP = [11_000] * 5 + [10_000] * 5
TOP = 9167


@pytest.mark.fact("CONT-1", "CONT-5", "CONT-7")
def test_continuous_motion_runs_past_its_number_until_aborted(rig: Make) -> None:
    x = rig(record=("motion_complete",))
    x.send("A 0\rN 65000\rZ 1\rS 200\rF 3\rR 80\r")
    x.start("H\rG\r")
    x.bench.run_until(lambda: x.level("ready") == 0)
    x.bench.run("36 s")
    assert x.x.travel > 200_000 and x.level("motion_complete") == 1
    x.drive("abort", 0)
    x.bench.run_until_idle()
    x.drive("abort", 1)
    assert x.level("motion_complete") == 0
    stopped = x.x.travel
    x.send("N 10\rG\r")
    assert x.x.travel == stopped + 10  # the flag is gone


@pytest.mark.fact("CONT-1", "UND-CONT-P")
def test_p_starts_a_continuous_motion_in_its_direction_and_goes_past(mover: Make) -> None:
    x = mover(position=50_000)
    x.send(SMALL + "A 50000\r")
    x.begin("H\rP 49000\r")
    x.till(sum(UP) + 2000 * TOP)
    assert x.x.travel == -2011
    assert x.x.pin("slew").level == 0


@pytest.mark.fact("UND-CONT-P", "UND-CONT-SHORT")
def test_p_without_distance_clears_the_continuous_flag(mover: Make) -> None:
    x = mover(number=300)
    x.send(SMALL + "A 5\rH\rP 5\r")
    assert x.x.travel == 0
    x.begin()
    x.finish()
    assert len(x.begins()) == 300


@pytest.mark.fact("CONT-2")
@pytest.mark.parametrize("until", ["motion complete", "later"])
def test_abort_low_to_the_end_stops_a_continuous_motion_at_the_first_rate(mover: Make, until: str) -> None:
    x = mover(number=60_000)
    x.send(SMALL)
    x.begin("H\rG\r")
    look = sum(UP) + 50 * TOP
    end = look + sum(UP)
    x.on(look - 1, "abort", 0)
    x.on(end + (0 if until == "motion complete" else 500_000), "abort", 1)
    x.till(end + 1_000_000)
    assert x.periods() == UP + [TOP] * 50 + UP[::-1]
    assert x.changes("slew") == [(sum(UP), 0), (look, 1)]
    assert x.changes("motion_complete")[-1] == (end, 0)
    assert x.changes("ready")[-1] == (end + 180, 1)


@pytest.mark.fact("CONT-4", "UND-CONT-SHORT")
@pytest.mark.parametrize(
    ("setup", "number"),
    [
        ("F 3\rR 127\rS 10\rZ 1\r", 100),
        (SMALL, 275),  # 255 steps for slewing
        ("F 3\rR 127\rS 1\rZ 5\r", 65_535),  # a ramp of 34,950 steps
        ("F 10\rR 10\r", 255),
    ],
)
def test_h_has_no_effect_on_a_motion_that_does_not_slew(mover: Make, setup: str, number: int) -> None:
    x = mover(number=number, position=0)
    x.send(setup)
    x.begin("H\rG\r")
    x.finish()
    assert x.x.travel == number
    assert x.changes("slew") == []
    assert x.x.pin("motion_complete").level == 0
    assert x.codes.count("halt-without-effect") == 1
    x.send("N 300\rF 10\rR 10\rG\r")  # and the flag does not wait for the next one
    assert x.x.travel == number + 300


@pytest.mark.fact("CONT-4", "CONT-5")
@pytest.mark.parametrize(
    ("setup", "number"),
    [(SMALL, 276), ("F 3\rR 127\rS 1\rZ 4\r", 65_535), ("F 10\rR 10\r", 256), ("F 3\rR 127\rS 10\rZ 1\r", 64_000)],
)
def test_h_takes_effect_when_256_steps_would_slew(mover: Make, setup: str, number: int) -> None:
    x = mover(number=number)
    x.send(setup)
    x.begin("H\rG\r")
    x.bench.run("60 s")
    assert x.x.travel > number
    assert x.x.pin("slew").level == 0
    assert not [code for code in x.codes if code.startswith("halt")]


@pytest.mark.fact("CONT-6")
def test_on_the_fly_positions_follow_the_count_over_two_wraps(rig: Make) -> None:
    x = rig(record=("outstrobe", "pulse"))
    x.send("A 65000\rN 65000\rZ 1\rS 250\rF 3\rR 127\r")
    x.start("H\rG\r")
    x.bench.run_until(lambda: x.x.travel > 0)
    read = []
    for _ in range(16):
        x.bench.run("997 ms")
        read.append(x.host.read_position())
    falls = np.array(x.falls("pulse"))
    strobes = x.falls("outstrobe")[::2]  # high bytes
    counted = [int(np.searchsorted(falls, strobe, side="right")) for strobe in strobes]
    assert counted[-1] > 2 * 65536
    assert read == [(65_000 + count) % 65536 for count in counted]


@pytest.mark.fact("CONT-7")
def test_a_program_continues_after_its_continuous_motion_was_aborted(rig: Make) -> None:
    x = rig(record=("run", "motion_complete"))
    x.send(SMALL + "N 60000\rE\rH\rG\rN 10\rG\r0\rQ")
    x.start("X\r")
    x.bench.run_until(x.x.pin("slew").is_(0))
    x.bench.run("100 ms")
    x.drive("abort", 0)
    x.bench.run_until(x.x.pin("motion_complete").is_(0))
    stopped = x.x.travel
    x.drive("abort", 1)
    x.bench.run_until_idle()
    assert x.x.travel == stopped + 10
    assert x.level("run") == 1


@pytest.mark.fact("CONT-1", "CONT-7")
def test_h_holds_for_one_motion_only(mover: Make) -> None:
    x = mover(number=300)
    x.send(SMALL + "G\r")
    assert x.x.travel == 300
    x.begin("H\rG\r")
    x.on(5_000_000, "abort", 0)
    x.finish()
    x.put(x.now, "abort", 1)
    ran = x.x.travel
    assert ran > 600
    x.send("G\r")
    assert x.x.travel == ran + 300
