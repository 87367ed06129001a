"""Committed time: who follows it hears of every instant that is over, and of where a run ends."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest

import slewline
from slewline.core.time import kernel as kernel_module
from slewline.core.time.kernel import Kernel
from slewline.core.wires.net import Driver, Net, Wave
from slewline.core.wires.waits import until
from slewline.errors import Endless


def followed(shuffle: int | None = None) -> tuple[Kernel, list[int]]:
    kernel, told = Kernel(None if shuffle is None else Random(shuffle)), []
    kernel.on_commit.add(told.append)
    return kernel, told


@pytest.mark.parametrize("shuffle", [None, 1, 2])
def test_every_instant_is_reported_once_and_the_end_of_the_run(shuffle):
    kernel, told = followed(shuffle)
    net = Net(kernel, "net")
    net.watch(lambda _: None)
    Driver(net, "promise").play(Wave(0, (20, 50), (1, 0)))
    for ps in (10, 30, 30, 50):
        kernel.call_at(ps, lambda: None)
    kernel.run(40)
    assert told == [0, 10, 20, 30, 40]
    kernel.run(40)  # no time passes
    kernel.run(60)
    assert told == [0, 10, 20, 30, 40, 50, 60]


def test_it_is_reported_when_the_instant_is_quiet():
    kernel, shown = Kernel(), []
    net = Net(kernel, "net")
    out = Driver(net, "out")
    kernel.on_commit.add(lambda ps: shown.append((ps, kernel.seen, net.level)))

    async def task():
        await until(kernel, 10)
        out.drive(1)

    kernel.spawn(task, name="task")
    kernel.run(10)
    assert shown == [(0, 0, None), (10, 10, 1)]


def test_inputs_between_two_runs_cause_another_report_of_the_instant():
    kernel, told = followed()
    out = Driver(Net(kernel, "net"), "out")
    kernel.run(10)
    kernel.settle()  # nothing to settle
    assert told == [10]
    out.drive(1)
    kernel.settle()
    assert told == [10, 10]


@pytest.mark.parametrize("event", [True, False])
def test_inputs_of_a_listener_belong_to_the_instant(event):
    kernel, told = followed()
    net = Net(kernel, "net")
    out, changes = Driver(net, "out"), []
    net.watch(lambda _: changes.append(kernel.now))
    kernel.on_commit.add(lambda ps: out.drive(1) if ps == 10 and net.level is None else None)
    if event:
        kernel.call_at(10, lambda: None)
    kernel.run(10)
    kernel.run(20)
    assert (changes, told) == ([10], [10, 10, 20])


def test_a_listener_that_always_adds_an_input_is_stopped(monkeypatch):
    monkeypatch.setattr(kernel_module, "ROUNDS_LIMIT", 20)
    kernel = Kernel()
    out = Driver(Net(kernel, "net"), "out")
    kernel.on_commit.add(lambda _: out.drive(0 if out.level else 1))
    with pytest.raises(Endless, match="a listener of on_commit changes an input at 10 ps each time it is called"):
        kernel.run(10)
    assert not kernel.running


@pytest.mark.parametrize("shuffle", [None, 1])
def test_a_listener_added_inside_a_run_receives_that_very_instant(shuffle):
    kernel, told, others = Kernel(None if shuffle is None else Random(shuffle)), [], []
    kernel.call_at(5, lambda: None)
    kernel.call_at(10, lambda: kernel.on_commit.add(told.append))
    kernel.call_at(15, lambda: kernel.on_commit.add(others.append))
    kernel.call_at(20, lambda: None)
    kernel.run(30)
    assert (told, others) == ([10, 15, 20, 30], [15, 20, 30])
    kernel.call_at(40, lambda: kernel.on_commit.remove(told.append))
    kernel.call_at(40, lambda: kernel.on_commit.remove(others.append))
    kernel.call_at(45, lambda: None)
    kernel.call_at(50, lambda: kernel.on_commit.add(told.append))
    kernel.run(60)
    assert (told[4:], others[3:]) == ([50, 60], [])


def test_an_error_of_a_listener_comes_out_of_the_run():
    kernel = Kernel()
    kernel.on_commit.add(lambda ps: 1 // (ps - 10))
    kernel.call_at(10, lambda: None)
    with pytest.raises(ZeroDivisionError):
        kernel.run(30)
    assert (kernel.now, kernel.running) == (10, False)


@pytest.mark.parametrize("stepwise", [False, True])
def test_steps_that_are_read_as_time_is_committed_are_never_taken_back(stepwise):
    """What a drive does: each time, it takes the steps since the last one; what is withdrawn must not be among them."""
    bench = slewline.Bench()
    x = bench.add("cy525", name="x", stepwise=stepwise)
    host, chance = bench.host(x), Random(7)
    taken, since = [], [0]

    def take(ps):
        taken.append(x.axes[0].times(since[0], ps - 1))
        since[0] = ps

    bench.kernel.on_commit.add(take)
    for _ in range(6):
        host.send("A 0\rF 30\rR 110\rS 240\rZ 1\rN 300\rG\r")
        x.pin("step_inhibit").pulse(1, "700 us", at=bench.now_ps + chance.randrange(5 * 10**9, 10**11))
        x.pin("abort").pulse(0, "5 ms", at=bench.now_ps + chance.randrange(5 * 10**9, 10**11))
        bench.run(f"{chance.randrange(10**9, 10**11)} ps")
        if chance.random() < 0.3:
            x.power(False)
            bench.run("1 ms")
            x.power(True)
    bench.run("1 s")
    made = x.steps().times_ps
    assert len(made) > 300
    assert np.array_equal(np.concatenate(taken), made)
