"""Motions begin and end as events, in every family: when, where, after how many steps, and why."""

from __future__ import annotations

from typing import Any

import pytest

import slewline

SLOW = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
SPEEDS = "A 0\rF 30\rR 80\rS 250\rZ 1\r"
PACKETS = "SET_VEL 0x20000\nSET_ACC 800\n"


def events(chip: Any, axis: int = 1) -> list[Any]:
    """What the hooks of an axis are told from now on."""
    found: list[Any] = []
    chip.axis(axis).on_motion_begin.add(found.append)
    chip.axis(axis).on_motion_end.add(found.append)
    return found


def cy525(sent: str, *happenings: tuple[str, str, int | None], **options: Any) -> tuple[Any, list[Any]]:
    bench = slewline.Bench()
    x = bench.add("cy525", name="x", **options)
    found = events(x)
    for at, pin, level in happenings:
        x.pin(pin).drive(level, at) if level is not None else x.pin(pin).release(at)
    bench.host(x).send(SPEEDS + sent)
    bench.run("400 ms")
    return x, found


def gsc(*lines: str, part: str = "gs-c200", before: float = 0, **options: Any) -> tuple[Any, Any, list[Any]]:
    bench = slewline.Bench()
    x = bench.add(part, name="x", straps=SLOW, **options)
    host = bench.host(x)
    host.uart.follow_straps()
    found = events(x)
    for line in ("P" if part == "gs-c200" else "Po", *lines, "E"):
        assert host.ask(line) == "Y", line
    return x, host, found


def mc(text: str, **options: Any) -> tuple[Any, Any, list[Any]]:
    bench = slewline.Bench()
    x = bench.add("mc1151a-e", name="x", **options)
    host = bench.host(x)
    found = events(x)
    for line in (PACKETS + text).splitlines():
        name, *values = line.split()
        host.command(name, *(int(value, 0) for value in values))
    return x, host, found


def told(found: list[Any]) -> list[tuple[Any, ...]]:
    """Texts of what begins; position, steps and reason of what ends."""
    return [(each.text,) if hasattr(each, "text") else (each.position, each.steps, each.why) for each in found]


# --------------------------------------------------------------------------------------------------------- CY525
@pytest.mark.parametrize("stepwise", [False, True])
def test_a_motion_of_a_cy525_ends_where_motion_complete_falls(stepwise):
    x, found = cy525("N 40\rG\r-\rP 10\r", stepwise=stepwise)
    assert told(found) == [("G",), (40, 40, "done"), ("P 10",), (10, -30, "done")]
    steps = x.steps().times_ps
    assert found[0].time_ps < steps[0] and steps[39] < found[1].time_ps < steps[40]
    assert [motion.end for motion in x.motions()] == [found[1], found[3]]
    assert found[0].end is None and found[0].position == 0 and found[2].position == 40


@pytest.mark.parametrize("stepwise", [False, True])
@pytest.mark.parametrize(
    ("sent", "happens", "why"),
    [
        ("N 3000\rG\r", ("50 ms", "abort", 0), "stopped"),
        ("N 3000\rG\r", ("50 ms", "io_request", 0), "stopped"),  # in a normal motion: it halts without ramp
        ("N 900\rH\rG\r", ("60 ms", "abort", 0), "stopped"),
        ("N 3000\rG\r", ("50 ms", "reset", 0), "cut"),
    ],
)
def test_why_a_motion_of_a_cy525_ends_early(sent, happens, why, stepwise):
    x, found = cy525(sent, happens, stepwise=stepwise)
    _, ended = found
    assert ended.why == why
    assert ended.steps == len(x.steps()) == x.travel != 0


# ----------------------------------------------------------------------------------------------------------- GS-C
@pytest.mark.parametrize("stepwise", [False, True])
def test_a_motion_of_a_gs_c_ends_with_its_last_pulse(stepwise):
    x, _, found = gsc("S10", "T100", "R20", "+200", "-50", stepwise=stepwise)
    x.kernel.run(x.kernel.now + 10**12)
    assert told(found) == [("+200",), (200, 200, "done"), ("-50",), (150, -50, "done")]
    assert found[1].time_ps == int(x.steps().times_ps[199]) + x.sheet.times["clock"].ticks


@pytest.mark.parametrize("stepwise", [False, True])
@pytest.mark.parametrize(("letter", "why"), [("Z", "stopped"), ("K", "cut")])
def test_z_stops_a_run_and_k_cuts_it_off(letter, why, stepwise):
    x, host, found = gsc("S10", "T100", "R20", "g+", part="gs-c200s", stepwise=stepwise)
    x.kernel.run(x.kernel.now + 10**12)
    host.ask(letter)
    x.kernel.run(x.kernel.now + 10**12)
    assert [each[-1] for each in told(found)] == ["g+", why]
    assert found[1].steps == x.travel > 100


@pytest.mark.parametrize("stepwise", [False, True])
def test_the_end_of_the_counter_is_a_limit(stepwise):
    x, host, found = gsc("S10", "T100", "R20", "G30", "G-", stepwise=stepwise)
    x.kernel.run(x.kernel.now + 10**12)
    assert told(found) == [("G30",), (30, 30, "done"), ("G-",), (0, -30, "limit")]
    assert host.ask("F") == "E5"


def test_a_homing_is_one_motion_and_ends_at_position_0():
    bench = slewline.Bench()
    x = bench.add("gs-c200", name="x", straps=SLOW)
    host = bench.host(x)
    host.uart.follow_straps()
    for line in ("P", "S10", "E"):
        host.ask(line)
    found = events(x)
    x.pin("eot").drive(0, bench.now_ps + 10**12)
    x.pin("home").drive(0, bench.now_ps + 2 * 10**12)
    host.ask("H+")
    bench.run("3 s")
    begun, ended = found
    assert (begun.text, ended.position, ended.why) == ("H+", 0, "done")
    assert abs(ended.steps) < len(x.steps())


def test_without_its_supply_a_motion_is_cut_off():
    x, _, found = gsc("S10", "T100", "R20", "+9000")
    x.kernel.run(x.kernel.now + 10**12)
    x.power(False)
    assert [each[-1] for each in told(found)] == ["+9000", "cut"] and found[1].time_ps == x.kernel.now


# ---------------------------------------------------------------------------------------------------- MC1451A family
@pytest.mark.parametrize("stepwise", [False, True])
def test_an_update_in_motion_begins_another_motion(stepwise):
    _, host, found = mc("SET_POS 300\nUPDATE\nSET_POS 500\nUPDATE\n", stepwise=stepwise)
    host.wait("motion_complete")
    one, changed, two, done = found
    assert (one.text, two.text, changed.why, done.why) == ("UPDATE", "UPDATE", "changed", "done")
    assert changed.time_ps == two.time_ps and changed.position == two.position
    assert changed.steps + done.steps == done.position == 500


@pytest.mark.parametrize("stepwise", [False, True])
@pytest.mark.parametrize(
    ("end", "why"),
    [
        ("STOP\nUPDATE\n", "stopped"),
        ("SMOOTH_STOP\nUPDATE\n", "stopped"),
        ("MTR_OFF\n", "cut"),
        ("RESET\n", "cut"),
        ("SET_PRFL_S_CRV\n", "stopped"),
    ],
)
def test_causes_that_end_the_motion_of_a_chipset(end, why, stepwise):
    x, host, found = mc("SET_POS 30000\nUPDATE\n", stepwise=stepwise)
    x.kernel.run(x.kernel.now + 10**11)
    for line in end.splitlines():
        host.command(line)
    x.kernel.run(x.kernel.now + 10**11)
    assert [each[-1] for each in told(found)] == ["UPDATE", why]


@pytest.mark.parametrize("stepwise", [False, True])
def test_a_change_to_velocity_contouring_orders_no_end(stepwise):
    x, host, found = mc("SET_POS 30000\nUPDATE\n", stepwise=stepwise)
    x.kernel.run(x.kernel.now + 10**11)
    host.command("SET_VEL", 0)
    host.command("UPDATE")
    x.kernel.run(x.kernel.now + 10**10)
    host.command("SET_PRFL_VEL")
    host.wait("motion_complete")
    assert [each[-1] for each in told(found)] == ["UPDATE", "changed", "UPDATE", "done"]


@pytest.mark.parametrize("stepwise", [False, True])
def test_a_limit_switch_ends_a_motion(stepwise):
    x, host, found = mc("SET_POS 30000\nUPDATE\n", stepwise=stepwise)
    x.pin("poslimit1").drive(1, x.kernel.now + 10**11)
    host.wait("positive_limit")
    assert [each[-1] for each in told(found)] == ["UPDATE", "limit"]


@pytest.mark.parametrize("stepwise", [False, True])
def test_a_gear_has_no_end_but_another_mode(stepwise):
    x, host, found = mc("SET_PRFL_GEAR\nUPDATE\n", stepwise=stepwise)
    x.kernel.run(x.kernel.now + 10**11)
    assert told(found) == [("SET_PRFL_GEAR",), (0, 0, "changed"), ("UPDATE",)]
    host.command("SET_PRFL_TRAP")
    x.kernel.run(x.kernel.now + 10**10)
    assert told(found)[3:] == [(0, 0, "stopped")]


def test_a_gear_that_may_not_follow_ends_immediately():
    x, _, found = mc("MTR_OFF\nSET_PRFL_GEAR\n")
    x.kernel.run(x.kernel.now + 10**10)
    assert told(found) == [("SET_PRFL_GEAR",), (0, 0, "cut")]


# ----------------------------------------------------------------------------------------------- a step that is cut off
@pytest.mark.parametrize("stepwise", [False, True])
def test_where_reset_cuts_a_step_off_the_velocity_is_0(stepwise):
    x, (_, ended) = cy525("N 3000\rG\r", ("50 ms", "reset", 0), stepwise=stepwise)
    assert x.velocity_at(ended.time_ps - 1) > 0 and x.velocity_at(ended.time_ps) == 0
    times, speeds = x.motor.velocities(0, x.kernel.now)
    assert int(times[-1]) == ended.time_ps and speeds[-1] == 0
    assert (
        int(x.steps().times_ps[-1])
        < ended.time_ps
        < int(x.steps().times_ps[-1]) + 10**12 / x.velocity_at(ended.time_ps - 1)
    ), "within the last step"


def test_after_k_the_motor_is_stopped_and_the_next_motion_begins_from_rest():
    x, host, found = gsc("S1", "T2", "R2", "+50")
    x.kernel.run(x.kernel.now + 10**12)
    host.ask("K")
    cut = found[1].time_ps
    x.kernel.run(x.kernel.now + 10**12)
    host.ask("E")
    x.kernel.run(x.kernel.now + 10**12)
    host.ask("K")
    _, (again, _) = ((m.time_ps, m.end) for m in x.motions())
    assert x.velocity_at(cut - 1) > 0
    assert (x.velocity_at(list(range(cut, again, 10**10))) == 0).all()
    assert x.velocity_at(int(x.steps(again).times_ps[0])) > 0


def test_a_motion_cut_off_twice_before_its_first_step_leaves_the_earlier_cut_where_it_was():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    host = bench.host(x)
    host.send(SPEEDS + "N 3000\rG\r")
    bench.run_until(x.reaches(3))
    x.reset()
    bench.run("1 ms")
    (cut,) = (motion.end.time_ps for motion in x.motions())
    x.pin("step_inhibit").drive(1)
    host.send("N 5\rG\r")
    bench.run("3 ms")
    x.reset()
    bench.run("1 ms")
    assert [motion.end.why for motion in x.motions()] == ["cut", "cut"] and x.motions()[1].end.steps == 0
    assert x.velocity_at(cut - 1) > 0 and x.velocity_at(cut) == 0


# ---------------------------------------------------------------------------------------------------------- listeners
def test_two_listeners_receive_everything_and_one_may_leave_from_inside():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    heard: list[str] = []

    def once(motion: Any) -> None:
        heard.append(f"once {motion.text}")
        x.on_motion_begin.remove(once)

    x.on_motion_begin.add(lambda motion: heard.append(f"a {motion.text}"))
    x.on_motion_begin.add(once)
    x.on_motion_begin.add(lambda motion: heard.append(f"b {motion.text}"))
    bench.host(x).send(SPEEDS + "P 3\rP 5\r")
    bench.run_until_idle()
    assert heard == ["a P 3", "once P 3", "b P 3", "a P 5", "b P 5"]
