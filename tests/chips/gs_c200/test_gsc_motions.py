"""What a GS-C module tells of its motions: what began them, what happened on the way, and the ideal they follow."""

from __future__ import annotations

from random import Random
from typing import Any

import numpy as np
import pytest

import slewline

BOTH = pytest.mark.parametrize("stepwise", (False, True))


def running(program: str, stepwise: bool = False, part: str = "gs-c200s", **options: Any) -> tuple[Any, Any, Any]:
    """A module that has begun to run a program; its host, and how time passes."""
    bench = slewline.Bench()
    chip = bench.add(part, "x", stepwise=stepwise, **options)
    host = bench.host(chip)
    host.ask("Po" if part == "gs-c200s" else "P")
    for line in program.split():
        assert host.ask(line) == "Y", line
    host.ask("E")
    return chip, host, bench.run


def ran(program: str, stepwise: bool = False, **options: Any) -> Any:
    chip, _, run = running(program, stepwise, **options)
    while not chip.idle:
        run("100 ms")
    return chip


@BOTH
def test_a_motion_names_its_command_and_the_rates_in_force(stepwise: bool) -> None:
    x = ran("S50 T400 R20 +300 T300 R10 G-5", stepwise)
    move, goto = x.motions()
    assert (move.text, goto.text) == ("+300", "G-5")
    assert (move.rates, move.notes) == ({"S = 50": 500.0, "T = 400": 4000.0}, {"R": 20})
    assert (goto.rates, goto.notes) == ({"S = 50": 500.0, "T = 300": 3000.0}, {"R": 10})
    first = int(x.steps().times_ps[0])
    assert move.time_ps == first - 10 * 10**6 and move.ideal.start == first  # MOV rises 10 us before the first step


@BOTH
def test_a_run_that_a_command_ends(stepwise: bool) -> None:
    x, host, run = running("S50 T400 R20 g-", stepwise)
    run("200 ms")
    assert host.ask("Z") == "Y"
    run("200 ms")
    (motion,), (mark,) = x.motions(), x.marks()
    assert (motion.text, mark.kind, mark.text) == ("g-", "command", "Z")
    assert mark.time_ps <= motion.ideal.stop <= mark.time_ps + 250 * 10**6  # the next step
    assert [name for _, _, name in x.phases()] == ["up", "slew", "down"]


@BOTH
@pytest.mark.parametrize("part, text", [("gs-c200", "G+2"), ("gs-c200s", "g+2")])
def test_a_run_that_an_input_ends(part: str, text: str, stepwise: bool) -> None:
    x, _, run = running(f"S50 T400 R20 {text}", stepwise, part=part)
    run("200 ms")
    x.pin("ui2").drive(0)
    run("200 ms")
    assert [motion.text for motion in x.motions()] == [text]
    assert [(mark.kind, mark.text) for mark in x.marks()] == [("event", "UI2")]


@BOTH
def test_a_homing_finds_the_end_of_travel_and_home(stepwise: bool) -> None:
    bench = slewline.Bench()
    x: Any = bench.add("gs-c200s", "x", stepwise=stepwise)
    host = bench.host(x)
    for line in ("Po", "S50", "T400", "R20", "+3", "E"):
        host.ask(line)
    bench.run("1 s")
    assert host.ask("H+") == "Y"
    bench.run("50 ms")
    x.pin("eot").drive(0)
    bench.run("50 ms")
    x.pin("home").drive(0)
    bench.run("50 ms")
    motion = x.motions()[-1]
    assert (motion.text, motion.rates, motion.ideal) == ("H+", {"S = 50": 500.0}, None)
    assert [(mark.kind, mark.text) for mark in x.marks()] == [("limit", "EOT"), ("home", "HOME")]


@BOTH
def test_an_inhibited_step_ends_the_ideal_and_so_does_a_kill(stepwise: bool) -> None:
    x, host, run = running("S50 T400 R20 +9000", stepwise)
    run("200 ms")
    x.pin("enable").drive(0)
    run("1 ms")
    x.pin("enable").drive(1)
    host.ask("K")
    assert [(mark.kind, mark.text) for mark in x.marks()] == [("event", "ENABLE"), ("command", "K")]
    assert x.motions()[0].ideal.stop == x.marks()[0].time_ps
    x, host, run = running("S50 T400 R20 +9000", stepwise)
    host.ask("K")
    assert x.motions()[0].ideal.stop == x.marks()[0].time_ps


def test_the_ideal_ramp_is_one_of_constant_acceleration() -> None:
    x = ran("S50 T400 R64 +300")
    ideal = x.motions()[0].ideal
    acceleration = (4000**2 - 500**2) / (2 * 64)
    up = (4000 - 500) / acceleration
    at = ideal.start + np.rint(np.linspace(0, up, 50) * 1e12).astype(np.int64)
    t = (at - ideal.start) / 1e12
    assert ideal.velocities(at) == pytest.approx(500 + acceleration * t)
    assert ideal.positions(at) == pytest.approx(500 * t + acceleration * t * t / 2)
    assert (ideal.stop - ideal.start) / 1e12 == pytest.approx(2 * up + (299 - 128) / 4000 + 1 / 500)
    assert ideal.positions(np.array([ideal.stop])) == pytest.approx([300])


def test_the_ideal_has_the_rate_of_the_law_at_every_step_of_a_ramp() -> None:
    x = ran("S50 T400 R64 +300", law="linear in steps")
    ideal = x.motions()[0].ideal
    at = np.arange(ideal.start, ideal.start + 40 * 10**9, 10**6)
    positions, rates = ideal.positions(at), ideal.velocities(at)
    whole = np.searchsorted(positions, np.arange(1, 40))
    assert rates[whole] == pytest.approx(500 + 3500 * np.arange(1, 40) / 64, rel=0.001)


def test_no_motion_leaves_its_ideal_by_more_than_the_ratio_of_its_speeds() -> None:
    """At most a step ahead, T/S + 1 steps behind; and every ideal comes to its destination."""
    chance, nearest = Random(3), 0.0
    for _ in range(12):
        start, top, ramp = chance.randrange(5, 200), chance.randrange(5, 1000), chance.randrange(1, 400)
        steps = chance.randrange(1, 1500)
        x = ran(f"S{start} T{top} R{ramp} +{steps}", law=chance.choice(["constant acceleration", "linear in steps"]))
        (motion,) = x.motions()
        found, behind = x.deviation(motion), max(top / start, 1) + 1
        assert -behind <= found.position <= 1 + 1e-6
        assert motion.ideal.positions(np.array([motion.ideal.stop])) == pytest.approx([steps])
        nearest = max(nearest, -found.position / behind)
    assert nearest > 0.25


@BOTH
def test_the_position_that_is_forced_is_marked(stepwise: bool) -> None:
    x = ran("f-70 S50 T400 R20 +3 I1", stepwise)
    assert [mark.text for mark in x.marks()] == ["f-70", "I1"]
    assert x.motions()[0].ideal.positions(np.array([0])) == [-70]
