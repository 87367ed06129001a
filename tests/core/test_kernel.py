"""The kernel: what a task sees in which round of an instant, and that the order inside a round cannot matter."""

from __future__ import annotations

import gc
import warnings
from random import Random

import pytest

import slewline
from slewline.core.time import kernel as kernel_module
from slewline.core.time.kernel import Kernel
from slewline.core.wires.net import Driver, Net, Wave
from slewline.core.wires.waits import edge, first_of, level, until
from slewline.errors import Endless, SlewlineError
from tests.rows import rows

SEEDS = [None, *range(12)]


def shuffled(seed: int | None) -> Kernel:
    return Kernel(None if seed is None else Random(seed))


class Wires:
    """Nets by name on one kernel, each with one driver, and a log of what was noted."""

    def __init__(self, kernel: Kernel, **levels: int) -> None:
        self.kernel, self.log = kernel, []
        self.net = {name: Net(kernel, name) for name in levels}
        self.out = {name: Driver(net, "test") for name, net in self.net.items()}
        for name, value in levels.items():
            self.out[name].drive(value)
        kernel.settle()

    def note(self, what: str, *names: str) -> None:
        self.log.append((self.kernel.now, what, *(self.net[name].level for name in names)))


# ------------------------------------------------------------------------------------------------ round 1 and after


@rows("seed", SEEDS)
def test_a_timer_woken_task_sees_the_levels_from_before_the_instant(seed):
    kernel = shuffled(seed)
    wires = Wires(kernel, driven=0, promised=0)
    wires.out["promised"].play(Wave(0, (100,), (1,)))

    async def driver():
        await until(kernel, 100)
        wires.out["driven"].drive(1)

    async def looker():
        await until(kernel, 100)
        wires.note("look", "driven", "promised")
        await until(kernel, 101)
        wires.note("look", "driven", "promised")

    kernel.spawn(looker, name="looker")
    kernel.spawn(driver, name="driver")
    kernel.run(200)
    assert wires.log == [(100, "look", 0, 0), (101, "look", 1, 1)]


@rows("seed", SEEDS)
def test_promised_edges_and_changes_of_round_one_commit_together(seed):
    kernel = shuffled(seed)
    wires = Wires(kernel, a=1, b=0, c=0)
    wires.out["a"].play(Wave(1, (100,), (0,)))
    wires.out["b"].play(Wave(0, (100,), (1,)))
    for name in "abc":
        wires.net[name].watch(lambda net, name=name: wires.note(f"told {name}", "a", "b", "c"))

    async def driver():
        await until(kernel, 100)
        wires.out["c"].drive(1)

    async def woken_by(name):
        await edge(wires.net[name])
        wires.note(f"woken by {name}", "a", "b", "c")

    kernel.spawn(driver, name="driver")
    for name in "abc":
        kernel.spawn(woken_by, name, name=name)
    kernel.run(200)
    assert sorted(wires.log) == sorted(
        (100, f"{what} {name}", 0, 1, 1) for what in ("told", "woken by") for name in "abc"
    )


@rows("seed", SEEDS)
def test_an_edge_of_the_instant_survives_a_withdrawal_in_its_first_round(seed):
    kernel = shuffled(seed)
    wires = Wires(kernel, a=0)
    wave = Wave(0, (100, 200), (1, 0))
    wires.out["a"].play(wave)
    wires.net["a"].watch(lambda net: wires.note("edge", "a"))

    async def withdraws():
        await until(kernel, 100)
        wave.until = 150
        wires.out["a"].renew()

    kernel.spawn(withdraws, name="withdraws")
    kernel.run(300)
    assert wires.log == [(100, "edge", 1)]
    assert wires.net["a"].level == 1


@rows("seed", SEEDS)
def test_an_input_that_changes_exactly_at_a_sample_is_seen_at_the_next(seed):
    kernel = shuffled(seed)
    wires = Wires(kernel, x=0)
    seen = []

    async def looks():
        for ps in range(10, 60, 10):
            await until(kernel, ps)
            seen.append((ps, wires.net["x"].level))

    kernel.spawn(looks, name="looks")
    kernel.call_at(20, lambda: wires.out["x"].drive(1))
    kernel.call_at(39, lambda: wires.out["x"].drive(0))
    kernel.run(100)
    assert seen == [(10, 0), (20, 0), (30, 1), (40, 0), (50, 0)]


def test_reactions_run_in_later_rounds_of_the_same_instant():
    kernel = Kernel()
    wires = Wires(kernel, a=0, b=0, c=0)
    wires.net["c"].watch(lambda net: wires.note("told", "a", "b", "c"))

    async def follows(source, target):
        await level(wires.net[source], 1)
        wires.note(source, "a", "b", "c")
        wires.out[target].drive(1)

    kernel.spawn(follows, "a", "b", name="a to b")
    kernel.spawn(follows, "b", "c", name="b to c")
    kernel.call_at(50, lambda: wires.out["a"].drive(1))
    kernel.run(60)
    assert wires.log == [(50, "a", 1, 0, 0), (50, "b", 1, 1, 0), (50, "told", 1, 1, 1)]


def test_run_includes_its_last_instant_and_a_drive_afterwards_is_a_new_round_of_it():
    kernel = Kernel()
    wires = Wires(kernel, a=0)

    async def counts():
        while True:
            await edge(wires.net["a"])
            wires.note("edge", "a")

    kernel.spawn(counts, name="counts")
    kernel.call_at(100, lambda: wires.out["a"].drive(1))
    kernel.run(100)
    assert wires.log == [(100, "edge", 1)]
    wires.out["a"].drive(0)
    kernel.settle()
    assert wires.log == [(100, "edge", 1), (100, "edge", 0)]
    assert kernel.now == kernel.seen == 100
    kernel.run(100)
    kernel.run(250)
    assert kernel.now == 250


def test_a_call_for_the_present_or_the_past_is_served_immediately():
    kernel = Kernel()
    kernel.run(100)
    called = []
    kernel.call_at(100, lambda: called.append(kernel.now))
    kernel.call_at(7, lambda: called.append(kernel.now))
    kernel.call_at(101, lambda: called.append(kernel.now))
    kernel.settle()
    assert called == [100, 100]
    kernel.run(101)
    assert called == [100, 100, 101]


def test_settling_inside_a_run_waits_for_the_end_of_the_round():
    kernel = Kernel()
    wires = Wires(kernel, a=0)

    def drives():
        wires.out["a"].drive(1)
        kernel.settle()
        wires.note("in round 1", "a")

    kernel.call_at(10, drives)
    kernel.run(10)
    assert wires.log == [(10, "in round 1", 0)]
    assert wires.net["a"].level == 1


def test_run_while_stops_between_two_instants():
    kernel = Kernel()
    done = []
    for ps in (10, 10, 20, 30):
        kernel.call_at(ps, lambda: done.append(kernel.now))
    assert kernel.run_while(lambda: bool(done), 100) is False
    assert done == [10, 10]  # an instant is never cut in two
    assert kernel.now == 10
    assert kernel.run_while(lambda: len(done) > 9, 25) is True
    assert done == [10, 10, 20]
    assert kernel.next_time() == 30


# ------------------------------------------------------------------------------------------------------------- waits


def test_waits_for_a_level_that_is_there_already_return_in_the_same_round():
    kernel = Kernel()
    wires = Wires(kernel, a=1, b=0)
    log = []

    async def task():
        await until(kernel, 0)
        await until(kernel, kernel.now)
        await level(wires.net["a"], 1)
        log.append(await first_of(kernel, 50, (wires.net["b"], 1), (wires.net["a"], 1)))
        log.append(await first_of(kernel, kernel.now, (wires.net["b"], 1)))
        log.append(kernel.now)

    kernel.spawn(task, name="task")
    kernel.settle()
    assert log == [wires.net["a"], None, 0]


def test_of_several_levels_that_are_there_the_first_in_the_list_wins():
    kernel = Kernel()
    wires = Wires(kernel, a=1, b=1)
    log = []

    async def task():
        for names in ("ab", "ba"):
            found = await first_of(kernel, 100, *((wires.net[name], 1) for name in names))
            log.append((kernel.now, found.name))

    kernel.spawn(task, name="task")
    kernel.run(200)
    assert log == [(0, "a"), (0, "b")]


def test_the_first_of_several_levels_wins_and_the_others_are_forgotten():
    kernel = Kernel()
    wires = Wires(kernel, a=0, b=0)
    log = []

    async def task():
        found = await first_of(kernel, 100, (wires.net["a"], 1), (wires.net["b"], None))
        log.append((kernel.now, found.name))
        await until(kernel, 70)
        log.append(kernel.now)
        log.append(await first_of(kernel, 80, (wires.net["b"], 0)))
        log.append(kernel.now)

    kernel.spawn(task, name="task")
    kernel.call_at(30, lambda: wires.out["b"].drive(1))
    kernel.call_at(40, lambda: wires.out["a"].drive(1))
    kernel.call_at(100, lambda: wires.out["b"].drive(0))
    kernel.run(200)
    assert log == [(30, "b"), 70, None, 80]


@rows("seed", SEEDS)
def test_a_level_that_comes_at_the_very_end_of_a_wait_comes_too_late(seed):
    kernel = shuffled(seed)
    wires = Wires(kernel, driven=0, promised=0)
    wires.out["promised"].play(Wave(0, (100,), (1,)))
    log = []

    async def task():
        log.append(await first_of(kernel, 100, (wires.net["driven"], 1), (wires.net["promised"], 1)))
        log.append([wires.net["driven"].level, wires.net["promised"].level])

    kernel.spawn(task, name="task")
    kernel.call_at(100, lambda: wires.out["driven"].drive(1))
    kernel.run(100)
    assert log == [None, [0, 0]]


@rows("seed", SEEDS)
def test_a_wait_that_begins_in_round_one_sees_the_edge_of_that_instant(seed):
    kernel = shuffled(seed)
    wires = Wires(kernel, driven=0, promised=0)
    wires.out["promised"].play(Wave(0, (100,), (1,)))  # nobody watches it before
    log = []

    async def waits_for(name):
        await until(kernel, 100)
        await level(wires.net[name], 1)
        log.append((name, kernel.now))

    for name in ("driven", "promised"):
        kernel.spawn(waits_for, name, name=name)
    kernel.call_at(100, lambda: wires.out["driven"].drive(1))
    kernel.run(150)
    assert sorted(log) == [("driven", 100), ("promised", 100)]


def test_only_a_task_can_wait():
    with pytest.raises(SlewlineError, match="only a task"):
        Kernel().current()


# -------------------------------------------------------------------------------------------------------------- kill


@pytest.mark.parametrize("when", ["by time", "by level", "in the same round"])
def test_a_killed_task_runs_its_finally_and_nothing_else(when):
    kernel = Kernel()
    wires = Wires(kernel, a=0)
    log = []

    async def victim():
        try:
            await first_of(kernel, 50, (wires.net["a"], 1))
            log.append("woken")
        finally:
            log.append(kernel.now)

    task = kernel.spawn(victim, name="victim")
    kernel.settle()
    if when == "in the same round":
        wires.net["a"].watch(lambda net: task.kill())  # woken for round 2 already
    else:
        kernel.call_at(20, task.kill)
    if when != "by time":
        kernel.call_at(30, lambda: wires.out["a"].drive(1))
    kernel.run(100)
    assert log == [30 if when == "in the same round" else 20]
    assert not task.alive


def test_a_task_that_never_runs_leaves_no_complaint():
    async def waits(ps):
        await until(Kernel(), ps)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        gc.collect()  # what other tests have left complains of itself
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        kernel = Kernel()
        kernel.spawn(waits, 50, name="dropped")
        kernel.spawn(waits, 50, name="killed").kill()
        del kernel
        bench = slewline.Bench()
        bench.host(bench.add("cy525")).send("A 0\r")
        del bench
        gc.collect()
    assert not told, [str(warning.message) for warning in told]


@rows("seed", SEEDS)
def test_a_task_that_fails_is_over_and_keeps_nothing_from_the_others(seed):
    kernel = shuffled(seed)
    wires = Wires(kernel, promised=0)
    wires.out["promised"].play(Wave(0, (100,), (1,)))

    async def failing():
        await until(kernel, 100)
        raise ValueError("no")

    async def beside():
        await until(kernel, 100)
        wires.note("woken at 100")

    async def watching():
        await level(wires.net["promised"], 1)
        wires.note("sees the edge", "promised")

    tasks = [kernel.spawn(run, name=run.__name__) for run in (failing, beside, watching)]
    with pytest.raises(ValueError, match="no"):
        kernel.run(200)
    assert sorted(wires.log) == [(100, "sees the edge", 1), (100, "woken at 100")]
    assert not tasks[0].alive
    kernel.run(200)


def test_a_task_that_fails_alone_in_its_instant_is_over():
    kernel = Kernel()

    async def failing():
        await until(kernel, 100)
        raise ValueError("no")

    task = kernel.spawn(failing, name="failing")
    with pytest.raises(ValueError, match="no"):
        kernel.run(200)
    assert not task.alive and kernel.now == 100


def test_next_time_skips_abandoned_waits():
    kernel = Kernel()

    async def sleeper(ps):
        await until(kernel, ps)

    early, _ = kernel.spawn(sleeper, 10, name="early"), kernel.spawn(sleeper, 20, name="late")
    kernel.settle()
    assert kernel.next_time() == 10
    early.kill()
    assert kernel.next_time() == 20
    kernel.run(20)
    assert kernel.next_time() is None


# ----------------------------------------------------------------------------------------------------------- Endless


def test_tasks_that_answer_each_other_without_time_are_named(monkeypatch):
    monkeypatch.setattr(kernel_module, "ROUNDS_LIMIT", 1000)
    kernel = Kernel()
    wires = Wires(kernel, a=0, b=0)

    async def copies(source, target):
        while True:
            await edge(wires.net[source])
            wires.out[target].drive(1 - wires.net[target].level)

    kernel.spawn(copies, "a", "b", name="ping")
    kernel.spawn(copies, "b", "a", name="pong")
    kernel.call_at(3_000_000, lambda: wires.out["a"].drive(1))
    with pytest.raises(Endless, match=r"1000 rounds at 3 µs: .*<Task p[io]ng>"):
        kernel.run(4_000_000)
    assert not kernel.running


def test_a_ring_of_gates_without_delay_is_named(monkeypatch):
    monkeypatch.setattr(kernel_module, "ROUNDS_LIMIT", 1000)
    kernel = Kernel()
    wires = Wires(kernel, ring=0)
    out = wires.out["ring"]
    wires.net["ring"].watch(lambda net: out.drive(1 - net.level))
    kernel.call_at(10, lambda: out.drive(1))
    with pytest.raises(Endless, match=r"1000 rounds at 10 ps: .*ring"):
        kernel.run(20)


def test_the_limit_is_a_hundred_thousand_rounds():
    assert kernel_module.ROUNDS_LIMIT == 100_000


def test_many_rounds_are_allowed(monkeypatch):
    monkeypatch.setattr(kernel_module, "ROUNDS_LIMIT", 1000)
    kernel = Kernel()
    wires = Wires(kernel, a=0)
    left = 990

    def toggle(net):
        nonlocal left
        left -= 1
        if left:
            wires.out["a"].drive(1 - net.level)

    wires.net["a"].watch(toggle)
    kernel.call_at(5, lambda: wires.out["a"].drive(1))
    kernel.run(10)
    assert left == 0


# ------------------------------------------------------------------------------------------------------- one scenario


def scenario(seed: int | None) -> list[tuple[object, ...]]:
    """Timers, edges, kills and replies on a coarse grid of instants, so that nearly everything collides."""
    kernel, chance = shuffled(seed), Random(99)
    names = [f"n{i}" for i in range(6)]
    wires = Wires(kernel, **dict.fromkeys(names, 0))
    log: list[tuple[object, ...]] = []
    tasks = []

    async def walker(number, own, random):
        while True:
            pause = random.randrange(1, 4) * 10
            watched = wires.net[random.choice(names)]
            found = await first_of(kernel, kernel.now + pause, (watched, random.choice([0, 1, None])))
            log.append((kernel.now, number, found and found.name, *(wires.net[name].level for name in names)))
            if found is None:
                wires.out[own].drive(random.randrange(2))
            else:
                await until(kernel, kernel.now + 10)

    for number, own in enumerate(names):  # every net has one master: nothing but the order could decide
        tasks.append(kernel.spawn(walker, number, own, Random(chance.random()), name=own))
    stop = Driver(Net(kernel, "stop"), "test")
    stop.net.watch(lambda net: tasks[2].kill())  # through a net, hence after all timed work of the instant
    kernel.call_at(1000, lambda: stop.drive(1))
    kernel.run(2000)
    return sorted(log, key=lambda entry: entry[:2])


def test_the_order_inside_a_round_does_not_matter():
    expected = scenario(None)
    assert len(expected) > 300
    for seed in range(25):
        assert scenario(seed) == expected


@pytest.mark.parametrize("where", ["call", "commit", "until"])
def test_calls_from_a_run_cannot_let_time_pass(where):
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    if where == "call":
        bench.at("1 ms", lambda: bench.run("1 ms"))
    elif where == "commit":
        bench.on_commit.add(lambda ps: bench.run("1 ms"))
    else:
        bench.at("1 ms", lambda: bench.run_until(x.pin("abort").is_(1)))
    with pytest.raises(slewline.UsageError, match=r"the time is .*, and a run is in progress: .*run_until\(\)"):
        bench.run("2 ms")
    assert not bench.kernel.running
