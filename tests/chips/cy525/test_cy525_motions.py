"""What a CY525 tells of its motions: what began them, what happened on the way, and the ideal they follow."""

from __future__ import annotations

from random import Random
from typing import Any

import numpy as np
import pytest

import slewline
from slewline import UsageError
from slewline.chips.cy525.profile import unit_ticks
from slewline.chips.cy525.sheet import STEP_TICKS
from slewline.core.motion.one_axis import OneAxis

HZ = 11_000_000
BOTH = pytest.mark.parametrize("stepwise", (False, True))
RAMP = "A 0\rF 3\rR 80\rS 200\rZ 1\r"


def ran(text: str, stepwise: bool = False, happens: Any = ()) -> Any:
    """A CY525 that has done what a host has sent; `happens` are (instant, pin, level)."""
    bench = slewline.Bench()
    chip = bench.add("cy525", "x", "11 MHz", stepwise=stepwise)
    bench.host(chip).send(text)
    for at, pin, level in happens:
        bench.at(at, lambda pin=pin, level=level: chip.pin(pin).drive(level))  # type: ignore[misc]
    bench.run_until_idle("60 s")
    return chip


def texts(chip: OneAxis) -> list[str]:
    return [motion.text for motion in chip.motions()]


def speed(rate: int) -> float:
    return HZ / int(STEP_TICKS[rate])


@BOTH
def test_a_motion_names_its_command_and_the_rates_in_force(stepwise: bool) -> None:
    x = ran(RAMP + "N 900\rG\rR 60\rS 210\rP 5\r", stepwise)
    go, to = x.motions()
    assert texts(x) == ["G", "P 5"]
    assert go.rates == {"F = 3": speed(3), "R = 80": speed(80)} and go.notes == {"S": 200, "Z": 1, "N": 900}
    assert to.rates == {"F = 3": speed(3), "R = 60": speed(60)} and to.notes == {"S": 210, "Z": 1, "N": 895}
    assert x.parameters() == (to.rates, to.notes)
    assert x.motions(stop=go.time_ps) == x.motions()[:1] and not x.motions(start=to.time_ps + 1)


@BOTH
def test_a_motion_begins_before_its_first_step_and_its_ideal_with_it(stepwise: bool) -> None:
    x = ran(RAMP + "N 900\rG\r", stepwise)
    (go,) = x.motions()
    first = int(x.steps().times_ps[0])
    assert go.time_ps == first - x.clock.ps(110) and go.ideal.start == first  # READY falls 10 us before the first step


@BOTH
def test_a_program_reports_every_motion(stepwise: bool) -> None:
    x = ran(RAMP + "A 100\rN 3\rE\rG\rP 102\rL 2,0\r0\rQ\rX\r", stepwise)
    assert texts(x) == ["G", "P 102"] * 2


@BOTH
def test_events_during_a_motion_end_the_ideal(stepwise: bool) -> None:
    held = ran(RAMP + "N 3000\rG\r", stepwise, [("300 ms", "step_inhibit", 1), ("310 ms", "step_inhibit", 0)])
    (mark,) = held.marks(start="200 ms")
    assert (mark.kind, mark.text) == ("event", "STEP INHIBIT") and held.motions()[0].ideal.stop == mark.time_ps
    ended = ran(RAMP + "N 3000\rG\r", stepwise, [("300 ms", "abort", 0)])
    (load, abort) = ended.marks()
    assert (load.kind, load.text, abort.kind, abort.text) == ("command", "A 0", "command", "ABORT")
    ideal = ended.motions()[0].ideal
    assert ideal.stop == abort.time_ps >= 300 * 10**9 and ideal.interrupted
    assert ideal.velocities(np.array([ideal.stop, ideal.stop + 1])) == pytest.approx([speed(80), 0])
    halted = ran(RAMP + "N 3000\rG\r", stepwise, [("300 ms", "io_request", 0), ("310 ms", "io_request", 1)])
    assert [mark.text for mark in halted.marks()] == ["A 0", "I/O REQUEST"]


@BOTH
def test_a_rate_on_the_fly_is_marked(stepwise: bool) -> None:
    bench = slewline.Bench()
    x: Any = bench.add("cy525", "x", "11 MHz", stepwise=stepwise)
    host = bench.host(x)
    host.send(RAMP + "N 60000\rH\rG\r")
    bench.run("400 ms")
    host.change_rate(60)
    bench.run("100 ms")
    x.pin("abort").drive(0)
    bench.run_until_idle("10 s")
    assert [mark.text for mark in x.marks()] == ["A 0", "R 60", "ABORT"] and texts(x) == ["G"]
    assert x.motions()[0].ideal.stop == x.marks()[1].time_ps
    x.reset()
    bench.run("10 ms")
    assert texts(x) == ["G"]


@BOTH
@pytest.mark.fact("FLY-RATE-5", "FLY-RATE-6", "FLY-RATE-8")
def test_rates_on_the_fly_take_the_place_of_those_in_force(stepwise: bool) -> None:
    bench = slewline.Bench()
    x: Any = bench.add("cy525", "x", "11 MHz", stepwise=stepwise)
    host = bench.host(x)
    host.send(RAMP + "N 60000\rH\rG\r")
    bench.run("400 ms")
    for rate in (90, 60, 60, 0, 100):
        host.change_rate(rate)
        bench.run("200 ms")
    x.pin("abort").drive(0)
    bench.run_until_idle("10 s")
    (go,) = x.motions()
    assert go.rates == x.parameters().rates == {"F = 3": speed(3), "R = 80": speed(80)}
    instants, rates = zip(*go.changes, strict=True)
    low, high = {"F = 60": speed(60), "R = 60": speed(60)}, {"F = 60": speed(60), "R = 100": speed(100)}
    assert rates == ({"F = 3": speed(3), "R = 90": speed(90)}, low, low, {}, high)
    assert list(instants) == [mark.time_ps for mark in x.marks() if mark.text.startswith("R ")]
    host.send("N 9\rG\r")
    bench.run_until_idle()
    assert x.motions()[1].rates == go.rates and not x.motions()[1].changes  # for that motion only


@BOTH
def test_phases_are_the_legs_of_the_move(stepwise: bool) -> None:
    x = ran(RAMP + "N 3000\rG\r", stepwise)
    steps = x.steps().times_ps
    names = [(name, int(np.count_nonzero((begin <= steps) & (steps < end)))) for begin, end, name in x.phases()]
    up = names[0][1]
    assert names == [("up", up), ("slew", 3000 - 2 * up), ("down", up)]
    (begin, end, _), (after, *_) = x.phases()[:2]
    assert (begin, end) == (int(steps[0]), after)
    assert x.phases(start=begin + 1, stop=after - 1) == [(begin + 1, after - 1, "up")]


@pytest.mark.fact("RAMP-4")
def test_the_ideal_has_the_rates_of_the_table_one_every_unit() -> None:
    x = ran("A 0\rF 3\rR 127\rS 250\rZ 2\rN 60000\rG\r")
    ideal = x.motions()[0].ideal
    unit = x.clock.ps(unit_ticks(250, 2))
    at = ideal.start + unit * np.arange(125)
    assert ideal.velocities(at) == pytest.approx([speed(rate) for rate in range(3, 128)], rel=1e-7)
    assert ideal.velocities(at[:-1] + unit // 2) == pytest.approx(
        [(speed(rate) + speed(rate + 1)) / 2 for rate in range(3, 127)], rel=1e-6
    )
    assert ideal.positions(np.array([0, ideal.start, ideal.stop, 1 << 60])) == pytest.approx([0, 0, 60000, 60000])


def test_a_surplus_too_short_to_slew_is_made_at_the_first_rate() -> None:
    x = ran("A 0\rF 3\rR 20\rS 200\rZ 1\rN 300\rG\r")
    ideal = x.motions()[0].ideal
    assert [name for _, _, name in x.phases()] == ["up", "down", "crawl"]
    assert ideal.velocities(np.array([ideal.stop - 10**9])) == pytest.approx([speed(3)])
    assert ideal.positions(np.array([ideal.stop])) == pytest.approx([300])


def test_no_motion_leaves_its_ideal_by_more_than_its_units_and_first_step_allow() -> None:
    """A step ahead; behind by what the rate gains, times a unit and a step at F, if a unit is no shorter than that."""
    chance, nearest = Random(5), 9.0
    for _ in range(25):
        first = chance.randrange(3, 120)
        rate, slope, divisor = chance.randrange(first, 128), chance.randrange(1, 240), chance.randrange(1, 5)
        x = ran(f"A 0\rF {first}\rR {rate}\rS {slope}\rZ {divisor}\rN {chance.randrange(2, 8000)}\rG\r")
        low, unit = speed(first), unit_ticks(slope, divisor) / HZ
        assert unit * low >= 1 or slope > 200
        if unit * low >= 1:
            found = x.deviation(x.motions()[0])
            behind = (speed(rate) - low) * (unit + 1 / low) + 1
            assert -behind <= found.position <= 1 + 1e-6
            nearest = min(nearest, 1 + found.position / behind)
    assert nearest < 0.5  # of the bound is used


def test_a_motion_without_steps_has_no_ideal_to_be_compared_with() -> None:
    x = ran("N 0\rG\r")
    with pytest.raises(UsageError, match=r"x: the motion G at .* has no ideal"):
        x.deviation(x.motions()[0])


def test_the_past_is_forgotten_except_the_current_motion() -> None:
    x = ran(RAMP + "N 3\rG\rG\rG\r")
    second = x.motions()[1].time_ps
    x.motor.forget(second + 1)
    assert x.motions()[0].time_ps == second and len(x.motions()) == 2 and not x.marks()


def test_phases_and_steps_of_a_motion_are_cut_off_where_kept_data_begins() -> None:
    x = ran(RAMP + "N 3000\rG\r")
    _, (begin, end, _), down = x.phases()
    middle = (begin + end) // 2
    steps = x.steps(middle)
    x.motor.forget(middle)
    assert x.phases(middle) == [(middle, end, "slew"), down]
    assert x.steps(middle).times_ps.tolist() == steps.times_ps.tolist() and len(steps) == 1500
