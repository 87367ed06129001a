"""What happens exactly together, played whole and step by step: an instant's steps and instructions come before the
line and the supply."""

from __future__ import annotations

import pytest
from gsc import C200S, CHARACTER, MS, STR, TURNROUND, WIDTH, Rig, base, both

ways = pytest.mark.parametrize("stepwise", [False, True])


def rig(part: str, stepwise: bool, *record: str, **options: object) -> Rig:
    return base(part, *record, options={"stepwise": stepwise, **options})


def obeyed_at(rig: Rig, at: int, line: str) -> None:
    """Send a line so that it is obeyed at an instant: a millisecond behind its carriage return."""
    rig.bench.at(at - TURNROUND - CHARACTER * (len(line) + 1), lambda: rig.host.write(line + "\r"))


@ways
def test_a_line_that_is_obeyed_as_a_step_begins_comes_after_the_step(stepwise: bool) -> None:
    x = rig(C200S, stepwise, "mov")
    x.start("S100", "T100", "R1", "+200")
    x.bench.run("10 ms")
    step = x.pulses()[0] + 60 * MS
    obeyed_at(x, step, "K")
    x.bench.run_until_idle("1 s")
    assert x.pulses()[-1] == step
    assert x.edges("mov")[-1] == (step + WIDTH, 0)
    assert x.pos() == len(x.pulses()) == 61


@ways
def test_an_instruction_of_the_same_instant_comes_before_kill(stepwise: bool) -> None:
    x = rig(C200S, stepwise, "uo1")
    start = x.start("D1", "A1", "D1")
    obeyed_at(x, start + 102 * MS, "K")
    x.bench.run_until_idle("1 s")
    assert x.rises("uo1") == [start + 102 * MS]
    assert x.ask("F") == "R"


@ways
def test_a_killed_motion_with_an_inhibited_step_takes_none_of_the_missed_steps(stepwise: bool) -> None:
    x = rig(C200S, stepwise)
    x.start("S100", "T100", "R1", "+2000")
    x.bench.run("50 ms")
    x.drive("enable", 0)
    x.bench.run("100 ms")
    made = len(x.pulses())
    assert x.ask("K") == "Y"
    x.drive("enable", 1)
    x.bench.run("1 s")
    assert len(x.pulses()) == made == x.pos()


@ways
@both
def test_the_step_at_the_instant_of_a_supply_failure_is_made(part: str, stepwise: bool) -> None:
    x = rig(part, stepwise, "clock")
    x.start("S100", "T100", "R1", "+2000")
    x.bench.run("10 ms")
    at = x.pulses()[0] + 40 * MS
    x.bench.at(at, lambda: x.x.power(False))
    x.bench.run("100 ms")
    assert x.pulses()[-1] == at
    assert x.edges("clock")[-1] == (at, -1)  # the pin floats
    assert x.x.travel == len(x.pulses())


@ways
def test_a_supply_failure_within_a_homing_leaves_no_trace(stepwise: bool) -> None:
    x = rig(C200S, stepwise)
    x.run(*STR)
    assert x.ask("H") == "Y"
    x.bench.run("100 ms")
    x.cycle()
    x.bench.run("10 ms")
    x.start("S10", "T100", "R10", "g+")
    x.bench.run("1 s")
    made = len(x.pulses())
    assert x.ask("Z") == "Y"
    x.bench.run_until_idle("1 s")
    assert len(x.pulses()) > made + 9  # it ramps down: no homing, which would stop at once
    assert x.pos() == len(x.pulses(x.x.up_ps))


@ways
def test_a_low_input_is_sampled_an_instruction_time_apart(stepwise: bool) -> None:
    lasting = []
    for late in (0, 1):
        x = rig(C200S, stepwise, "mov")
        start = x.start("S1", "T1", "R1", "g+2")
        x.bench.run("10 ms")
        look = x.rises("mov", start)[0] + 20 * MS
        x.drive("ui2", 0, at=look + late)
        x.bench.at(look + MS - late, lambda x=x: x.x.pin("ui2").release())
        x.bench.run("1 s")
        lasting.append(len(x.pulses()))
    assert lasting == [1, 11]  # a look sees what was before it; a level that begins with one and is gone with the next


@ways
def test_an_input_that_falls_as_a_controlled_run_begins_is_seen_at_the_following_sample(stepwise: bool) -> None:
    lines = ("S1", "T1", "R1", "g+2")
    x = rig(C200S, stepwise, "mov")
    start = x.start(*lines)
    x.bench.run("10 ms")
    begins = x.rises("mov", start)[0]
    x = rig(C200S, stepwise, "mov")
    x.drive("ui2", 0, at=begins)
    assert x.start(*lines) == start
    x.bench.run("1 s")
    assert x.rises("mov", start) == [begins] and len(x.pulses()) == 1
