"""Several chips: on one bus, as co-routines of a host, in step with each other."""

from __future__ import annotations

import pytest

import slewline
from slewline.core.wires.waits import level
from tests.rows import rows

MOVE = "F 10\rR 10\rS 255\rZ 1\r"
US, MS = 10**6, 10**9


def chips(*names, shuffle=None, stepwise=False):
    bench = slewline.Bench(shuffle=shuffle)
    found = [bench.add("cy525", name=name, position=0, stepwise=stepwise) for name in names]
    return bench, *found


def falls(bench, pin, start=None):
    times, levels = bench.edges(pin, start)
    return times[levels == 0].tolist()


def rises(bench, pin, start=None):
    times, levels = bench.edges(pin, start)
    return times[levels == 1].tolist()


# -------------------------------------------------------------------------------------------------------- one data bus
@pytest.mark.fact("CIRCUIT-BUS-1")
def test_i_o_request_selects_one_of_several_chips_on_a_bus():
    bench, x, y, z = chips("x", "y", "z")
    host = bench.host(x, y, z)
    bench.record("x.instrobe", "y.instrobe", "z.instrobe", "y.io_request")
    host.to("y").send("C\r")
    bench.run_until_idle()
    assert [chip.pin("programmable_output").level for chip in (x, y, z)] == [1, 0, 1]
    assert len(falls(bench, "y.instrobe")) == 2
    assert falls(bench, "x.instrobe") == falls(bench, "z.instrobe") == []
    host.to("z").send("A 7\r")
    host.to("x").send("-\r")
    bench.run_until_idle()
    assert [chip.position for chip in (x, y, z)] == [0, 0, 7]
    assert [chip.pin("direction").level for chip in (x, y, z)] == [0, 1, 1]
    assert host.to("z").verify(0) == b"00007"
    assert bench.findings == []


@pytest.mark.fact("CIRCUIT-BUS-1")
def test_each_ready_is_watched_apart():
    bench, x, y = chips("x", "y")
    host = bench.host(x, y)
    bench.record("y.instrobe", "x.motion_complete")
    host.to("x").send(MOVE + "N 100\rG\r")
    host.to("y").send("C\r")
    bench.run_until_idle()
    (complete,) = falls(bench, "x.motion_complete")
    assert all(t < complete for t in falls(bench, "y.instrobe"))  # y is spoken to while x moves
    assert (x.position, y.pin("programmable_output").level) == (100, 0)
    assert [found for found in bench.findings if found.code == "conflict"] == []


@pytest.mark.fact("CIRCUIT-BUS-2")
def test_a_position_on_the_fly_collides_with_a_command_on_the_same_bus():
    bench, x, y = chips("x", "y")
    host = bench.host(x, y)
    bench.run(0)
    host.to("x").send("A 0\r" + MOVE + "N 60\rG\r")
    bench.run_until(x.reaches(5))

    async def select(port):
        port.select.drive(1)
        await level(x.pin("outstrobe").net, 0)

    host.do(select)
    host.to("y").send("A 12\r")
    bench.run_until(lambda: host.idle)
    assert "conflict" in {found.code for found in bench.findings}
    assert y.position != 12  # wired AND of the two bytes


# ---------------------------------------------------------------------------------------------------------- co-routines
@pytest.mark.fact("PROG-9", "CIRCUIT-COROUTINE")
def test_a_host_that_waits_for_run_runs_three_programs_in_turn():
    bench, x = chips("x")
    host = bench.host(x)
    bench.record("x.run")
    host.send("A 0\r" + MOVE)
    for number in (1, 2, 3):
        host.send(f"N {10 * number}\rE\r" + "G\r" * number + "0\rQX\r")
        bench.run_until(x.pin("run").is_(0))
        assert len(x.program) == number + 1
        bench.run_until(x.pin("run").is_(1))
    bench.run_until_idle()
    assert x.position == 10 + 2 * 20 + 3 * 30
    assert len(rises(bench, "x.run")) == 3
    assert bench.findings == []


@pytest.mark.fact("CIRCUIT-COROUTINE", "PROG-9")
def test_one_host_serves_two_chips_that_finish_independently():
    bench, x, y = chips("x", "y")
    host = bench.host(x, y)
    bench.record("x.run", "y.run")
    todo = {"x": [50, 40, 30], "y": [7, 80]}
    loads = []
    for name, program in todo.items():
        host.to(name).send("A 0\r" + MOVE)

        def load(name=name, program=program):
            if program:
                loads.append((name, bench.now_ps))
                host.to(name).send(f"N {program.pop(0)}\rE\rG\r0\rQX\r")

        bench[name].pin("run").net.watch(lambda net, load=load: load() if net.level == 1 else None)
        load()
    bench.run_until_idle()
    assert (x.position, y.position) == (120, 87)
    assert [name for name, _ in loads] == ["x", "y", "y", "x", "x"]
    assert (len(rises(bench, "x.run")), len(rises(bench, "y.run"))) == (3, 2)
    overlap = [t for t in falls(bench, "y.run") if falls(bench, "x.run")[0] < t < rises(bench, "x.run")[0]]
    assert len(overlap) == 2
    assert bench.findings == []


# ------------------------------------------------------------------------------------------------------ in step (s.10)
PROGRAM = "A 0\r" + MOVE + "N 20\rE\rC\rU\rG\r0\rQ"  # C: I am here; U: so is the other
INSTRUCTION, POLL = 40 * US, 8 * US


def in_step(start="0 us", masters=PROGRAM, slaves=PROGRAM, **options):
    """Pin 34 of the master drives pin 38 of the slave, which is started first."""
    bench, master, slave = chips("master", "slave", **options)
    bench.wire("master.programmable_output", "slave.wait")
    bench.record("master.pulse", "slave.pulse", "master.programmable_output")
    hosts = {chip.name: bench.host(chip) for chip in (master, slave)}
    master.pin("wait").drive(0)
    hosts["master"].send(masters)
    hosts["slave"].send(slaves + "X\r")
    bench.run("50 ms")
    bench.run(start)
    return bench, master, slave, hosts["master"]


@pytest.mark.fact("CIRCUIT-SYNC-1", "CON-SYNC-WAIT")
def test_the_slave_waits_until_the_master_clears_its_output():
    bench, master, slave, host = in_step()
    bench.run("1 s")
    assert slave.waiting.startswith("slave: waiting for wait=0 (U)")
    assert slave.position == 0
    host.send("X\r")
    bench.run_until_idle()
    assert (master.position, slave.position) == (20, 20)
    (cleared,) = falls(bench, "master.programmable_output")
    assert all(falls(bench, f"{name}.pulse")[0] > cleared for name in ("master", "slave"))
    assert bench.findings == []


@pytest.mark.fact("CIRCUIT-SYNC-1", "CON-SYNC-WAIT")
def test_a_slave_that_waits_for_high_would_not_wait_at_all():
    bench, _, slave = chips("master", "slave")
    bench.wire("master.programmable_output", "slave.wait")
    bench.host(slave).send(PROGRAM.replace("U", "W") + "X\r")
    bench.run_until_idle()
    assert slave.position == 20


def apart(bench, one, two):
    """By how much the second chip steps later than the first; all steps by the same time."""
    times = [falls(bench, f"{name}.pulse") for name in (one, two)]
    assert len(times[0]) == len(times[1]) == 20
    (difference,) = {b - a for a, b in zip(*times, strict=True)}
    return difference


@pytest.mark.fact("CIRCUIT-SYNC-2")
@rows("start", [f"{n} us" for n in range(0, 24, 3)])
def test_a_slave_that_waits_where_the_master_clears_steps_within_one_poll(start):
    bench, _, _, host = in_step(start, PROGRAM.replace("U\r", ""), PROGRAM.replace("C\r", ""))
    host.send("X\r")
    bench.run_until_idle()
    assert 0 <= apart(bench, "master", "slave") <= POLL


@pytest.mark.fact("CIRCUIT-SYNC-2")
@pytest.mark.parametrize("start", ["0 us", "5 us"])
def test_with_the_same_program_the_slave_leads_by_the_master_s_own_wait(start):
    bench, _, _, host = in_step(start)
    host.send("X\r")
    bench.run_until_idle()
    assert INSTRUCTION - POLL <= apart(bench, "slave", "master") <= INSTRUCTION


@pytest.mark.fact("CIRCUIT-SYNC-3")
@pytest.mark.parametrize(("x_steps", "y_steps"), [(50, 5), (5, 50)])
def test_two_programs_wait_for_each_other_whichever_comes_first(x_steps, y_steps):
    bench, x, y = chips("x", "y")
    bench.wire("x.programmable_output", "y.wait")
    bench.wire("y.programmable_output", "x.wait")
    bench.record("x.pulse", "y.pulse", "x.programmable_output", "y.programmable_output")
    for chip, steps in ((x, x_steps), (y, y_steps)):
        bench.host(chip).send(f"A 0\r{MOVE}E\rN {steps}\rG\rC\rU\rN 10\rG\rB\r0\rQX\r")
    bench.run_until_idle()
    assert (x.position, y.position) == (x_steps + 10, y_steps + 10)
    arrivals = [falls(bench, f"{name}.programmable_output")[0] for name in "xy"]
    together = [falls(bench, f"{name}.pulse")[-10] for name in "xy"]
    assert min(together) > max(arrivals)
    assert INSTRUCTION - POLL <= abs(together[0] - together[1]) <= INSTRUCTION
    assert abs(arrivals[0] - arrivals[1]) > 30 * MS
    assert bench.findings == []


# --------------------------------------------------------------------------------------------- PULSE on STEP INHIBIT
def follower(stepwise=False, shuffle=None, moves=(7, 3, 12)):
    """The follower has 500 steps to go, and goes only while PULSE of the leader is low."""
    bench, lead, follow = chips("lead", "follow", stepwise=stepwise, shuffle=shuffle)
    bench.wire("lead.pulse", "follow.step_inhibit")
    bench.record("lead.pulse", "follow.pulse")
    bench.host(follow).send("A 0\rF 30\rR 30\rS 255\rZ 1\rN 500\rG\r")
    host = bench.host(lead)
    host.send("A 0\r" + MOVE)
    for steps in moves:
        host.send(f"N {steps}\rG\rD 50\r")
    bench.run("400 ms")
    return bench, lead, follow


@pytest.mark.fact("INHIBIT-4")
def test_a_follower_steps_only_as_the_pulse_of_the_leader_lets_it():
    bench, lead, follow = follower()
    assert lead.position == 22
    recorder = bench._signals.recorder
    ticks, ps = follow.clock.ticks_until, follow.clock.ps
    steps = falls(bench, "follow.pulse")
    assert len(steps) == follow.position
    assert recorder.level(lead.pin("pulse").net, steps[0] - 1) == 0
    for begin in steps[1:]:
        look = ps(ticks(begin) - 28)  # 2.5 us before the next step: the end of PULSE
        assert recorder.level(lead.pin("pulse").net, look - 1) == 0
    leader = falls(bench, "lead.pulse")
    done = [0]
    for first, last in ((0, 6), (7, 9), (10, 21)):
        done.append(sum(t <= leader[last] + 1_000 * US for t in steps))
        moving = leader[last] - leader[first] + 1_000 * US
        count = done[-1] - done[-2]
        assert moving // 334_000_000 - 1 <= count <= moving // 333_000_000 + 2  # 3000 steps/s while the leader moves
    assert done[-1] == len(steps) < 500
    assert follow.pin("pulse").level == 0  # held inside a step
    assert "held by step_inhibit=1" in follow.waiting


@pytest.mark.fact("INHIBIT-4")
def test_the_follower_is_the_same_step_by_step_and_with_ties_shuffled():
    runs = []
    for stepwise, shuffle in ((False, None), (True, None), (False, 1), (False, 2), (True, 3)):
        bench, lead, follow = follower(stepwise, shuffle)
        runs.append((lead.steps().times_ps.tolist(), follow.steps().times_ps.tolist(), falls(bench, "follow.pulse")))
    assert all(run == runs[0] for run in runs)
    assert len(runs[0][1]) > 60


def test_a_conflict_on_a_wire_of_two_chips_is_one_finding_for_every_listener():
    bench = slewline.Bench()
    x, y = (bench.add("cy525", name=name) for name in "xy")
    bench.wire("x.slew", "y.slew")
    bench.run("20 ms")
    heard = []
    for chip in (x, y):
        chip.pin("slew").net.on_conflict.add(lambda net, chip=chip: heard.append((chip.name, bench.now_ps)))
    for ps in (30 * 10**9, 40 * 10**9):
        y.pin("slew").drive(0, at=ps)  # both show 1
        y.pin("slew").release(at=ps + 10**9)
    bench.run("50 ms")
    assert [(found.source, found.code) for found in bench.findings] == [("x", "conflict")] * 2
    assert heard == [(name, ps) for ps in (30 * 10**9, 40 * 10**9) for name in "xy"]
