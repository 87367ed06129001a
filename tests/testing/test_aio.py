"""asyncio in virtual time: tasks that wait for a bench, for each other, for timers and threads."""

from __future__ import annotations

import asyncio
import threading
import time

import anyio
import pytest
import serialx

import slewline
import slewline.testing.for_serialx
from slewline.core.chip import step_nets
from slewline.errors import Timeout, UsageError
from slewline.testing import aio

pytest_plugins = ["pytester"]
SETUP = "A 0\rF 10\rR 100\rS 240\rZ 1\r"


def bench_of(*names):
    """A bench with some chips, each with a host."""
    bench = slewline.Bench()
    for name in names:
        bench.host(bench.add("cy525", name=name), name=f"{name}_host")
    return bench


async def drive(bench, name, steps, told):
    """A host program: a move, halfway, there, and back."""
    x, host = bench[name], bench[f"{name}_host"]
    host.send(f"{SETUP}N {steps}\rG\r")
    await bench.until(x.reaches(steps // 2))
    told.append((name, "halfway", bench.now_ps))
    await bench.until(lambda: x.position == steps)
    host.send("P 0\r")
    await bench.until(x.reaches(0))
    told.append((name, "back", bench.now_ps))


def alone(name, steps):
    """The same without asyncio."""
    bench, told = bench_of(name), []
    x, host = bench[name], bench[f"{name}_host"]
    host.send(f"{SETUP}N {steps}\rG\r")
    bench.run_until(x.reaches(steps // 2))
    told.append((name, "halfway", bench.now_ps))
    bench.run_until(lambda: x.position == steps)
    host.send("P 0\r")
    bench.run_until(x.reaches(0))
    told.append((name, "back", bench.now_ps))
    return told


RUNNERS = {
    "asyncio": lambda main: aio.run(main()),
    "anyio": lambda main: anyio.run(main, backend_options={"loop_factory": aio.VirtualLoop}),
}


@pytest.fixture(params=RUNNERS)
def run(request):
    return RUNNERS[request.param]


# -------------------------------------------------------------------------------------------------- two modules at once
def test_one_host_runs_two_modules_at_the_same_time(run):
    told = []

    async def main():
        bench = bench_of("x", "y")
        async with asyncio.TaskGroup() as group:
            group.create_task(drive(bench, "x", 700, told))
            group.create_task(drive(bench, "y", 300, told))
        await bench.until_idle()

    run(main)
    expected = alone("x", 700) + alone("y", 300)  # each as if the other were not there
    assert told == sorted(expected, key=lambda entry: entry[2])


def test_two_benches_keep_one_time(run):
    told = []

    async def main():
        left, right = bench_of("x"), bench_of("y")
        async with anyio.create_task_group() as group:
            group.start_soon(drive, left, "x", 700, told)
            group.start_soon(drive, right, "y", 300, told)
        assert asyncio.get_running_loop().time() == max(left.now, right.now)
        assert left.now_ps == max(entry[2] for entry in told)

    run(main)
    assert told == sorted(alone("x", 700) + alone("y", 300), key=lambda entry: entry[2])


def test_a_task_that_is_woken_speaks_at_that_very_instant():
    """Its byte goes out when the other bench has woken it, though nothing happens on its own bench."""

    async def main():
        left, right = bench_of("x"), bench_of("y")
        reached = asyncio.Event()

        async def follow():
            await right.wait("1 us")
            await reached.wait()
            assert right.now_ps == left.now_ps
            right["y_host"].send("N 5\r")

        async with asyncio.TaskGroup() as group:
            group.create_task(follow())
            left["x_host"].send(f"{SETUP}N 100\rG\r")
            await left.until(left["x"].reaches(7))
            reached.set()
        assert right.now_ps == left.now_ps
        await right.until_idle()

    aio.run(main())


# ----------------------------------------------------------------------------------------------------------------- time
def test_sleeps_and_timeouts_are_virtual(run):
    async def main():
        bench = bench_of("x")
        await bench.wait("1 ms")
        began = time.perf_counter()
        await asyncio.sleep(3600)
        assert bench.now_ps == 3600 * 10**12 + 10**9
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(7200):
                await asyncio.Event().wait()
        assert bench.now == 10800.001
        with anyio.move_on_after(1.5) as scope:
            await bench.wait("2 s")
        assert scope.cancelled_caught and bench.now == 10801.501
        await bench.wait(1000)
        assert bench.now_ps == 10801501 * 10**9 + 1000
        assert time.perf_counter() - began < 60

    run(main)


def test_time_does_not_advance_while_a_task_has_work_to_do():
    async def main():
        bench = bench_of("x")
        await bench.wait("1 ms")
        order = asyncio.Queue()

        async def hand_on(n):
            for _ in range(n):
                await asyncio.sleep(0)
            await order.put(n)

        timer = asyncio.create_task(bench.wait(1000))
        tasks = [asyncio.create_task(hand_on(n)) for n in (500, 20, 3)]
        assert [await order.get() for _ in tasks] == [3, 20, 500]
        assert bench.now_ps == 10**9 and not timer.done()
        await timer
        assert bench.now_ps == 10**9 + 1000

    aio.run(main())


def test_time_does_not_advance_while_a_thread_works():
    async def main():
        bench = bench_of("x")
        other = asyncio.create_task(bench.wait("1 s"))
        await asyncio.sleep(0)
        assert await asyncio.to_thread(lambda: time.sleep(0.02) or "done") == "done"
        assert bench.now_ps == 0 and not other.done()
        await other
        assert bench.now == 1

    aio.run(main())


def test_a_call_that_is_not_awaited_lets_time_pass_for_all():
    async def main():
        left, right = bench_of("x"), bench_of("y")
        await left.wait("1 ms")
        await right.wait("1 ms")
        left.run("5 ms")
        await asyncio.sleep(0.001)
        assert left.now == right.now + 0.001 == 0.007  # right has joined one millisecond later
        assert asyncio.get_running_loop().time() == 0.007

    aio.run(main())


def test_a_bench_that_was_run_before_continues():
    bench = bench_of("x")
    bench.run("250 ms")

    async def main():
        await bench.wait("1 ms")
        assert bench.now == 0.251 and asyncio.get_running_loop().time() == 0.001

    aio.run(main())
    bench.run("1 ms")
    assert bench.now == 0.252


def test_a_port_that_was_closed_is_forgotten_by_the_loop():
    async def main():
        for _ in range(5):
            async with serialx.async_serial_for_url("slewline://gs-c200s?chs=0", baudrate=9600) as port:
                await port.write(b"F")
        assert asyncio.get_running_loop().paces == {}

    aio.run(main())


@pytest.mark.system
def test_real_world_events_are_received():
    """A thread outside of the loop's own calls in; a socket answers."""

    async def main():
        called = asyncio.Event()
        loop = asyncio.get_running_loop()
        thread = threading.Timer(0.05, lambda: loop.call_soon_threadsafe(called.set))
        thread.start()
        await called.wait()
        thread.join()

        async def echo(reader, writer):
            writer.write(await reader.readline())
            await writer.drain()
            writer.close()

        server = await asyncio.start_server(echo, "127.0.0.1")
        reader, writer = await asyncio.open_connection(*server.sockets[0].getsockname())
        writer.write(b"heard\n")
        assert await reader.readline() == b"heard\n"
        writer.close()
        await writer.wait_closed()
        server.close()
        await server.wait_closed()

    aio.run(main())


# -------------------------------------------------------------------------------------------------- what does not come
def test_an_unmet_condition_is_reported_with_the_waiting_task(run):
    async def main():
        bench = bench_of("x")
        bench["x_host"].send("U\r")
        with pytest.raises(
            Timeout,
            match=r"waited 2 s for x at position 40; the time is 2 s\n(.*\n)*  x: waiting for wait=0 \(U\) since",
        ):
            await bench.until(bench["x"].reaches(40), timeout="2 s")
        assert bench.now == 2
        with pytest.raises(Timeout, match="waited 1 s for all queues to be empty and all chips idle"):
            await bench.until_idle("1 s")

    run(main)


def test_a_wait_that_is_cancelled_leaves_no_trace():
    async def main():
        bench = bench_of("x")
        x = bench["x"]
        waiting = asyncio.create_task(bench.until(lambda: x.position == 5))
        await bench.wait("1 ms")
        net = step_nets(x)[0]
        watched = len(net.observers)
        waiting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await waiting
        assert asyncio.get_running_loop().joined(bench).waits == []
        assert len(net.observers) == watched - 1

    aio.run(main())


def test_a_loop_in_a_deadlock_ends(monkeypatch):
    monkeypatch.setattr(aio, "GRACE_S", 0.05)

    async def main():
        bench = bench_of("x")
        await bench.wait("1 ms")
        await asyncio.Event().wait()

    with pytest.raises(Timeout, match=r"deadlock at 1 ms: every task waits, and no event is pending\n  x: "):
        aio.run(main())


def test_an_invalid_condition_is_refused():
    async def main():
        with pytest.raises(UsageError, match=r"until\(5\): expected a condition"):
            await bench_of("x").until(5)

    aio.run(main())


@pytest.mark.parametrize("runner", [asyncio.run, lambda main: anyio.run(lambda: main)], ids=["asyncio", "anyio"])
def test_a_loop_of_the_wall_clock_raises_with_a_remedy(runner):
    async def main():
        bench = bench_of("x")
        for wait in (bench.until(bench["x"].reaches(1)), bench.until_idle(), bench.wait("1 ms")):
            with pytest.raises(UsageError, match=r"wall clock; start the program with slewline\.testing\.aio\.run"):
                await wait

    runner(main())


# --------------------------------------------------------------------------------------------------------------- replay
def test_a_run_in_asyncio_replays_to_the_bit(tmp_path):
    told = []

    async def main():
        bench = slewline.Bench(journal=tmp_path / "run.jsonl")
        for name in ("x", "y"):
            bench.host(bench.add("cy525", name=name), name=f"{name}_host")
        async with asyncio.TaskGroup() as group:
            group.create_task(drive(bench, "x", 70, told))
            group.create_task(drive(bench, "y", 30, told))
        await bench.wait("10 ms")
        return bench

    bench = aio.run(main())
    again = slewline.replay(tmp_path / "run.jsonl")
    assert again.now_ps == bench.now_ps
    for name in ("x", "y"):
        assert again[name].steps().times_ps.tolist() == bench[name].steps().times_ps.tolist()


# ----------------------------------------------------------------------------------------------------------- in pytest
MARKED = """
import anyio, pytest
from slewline.testing import aio

@pytest.fixture
def anyio_backend():
    return "asyncio", {"loop_factory": aio.VirtualLoop}

@pytest.mark.anyio
async def test_a_move(cy525):
    cy525.host.send("A 0\\rF 10\\rR 100\\rS 240\\rZ 1\\rN 100\\rG\\r")
    await cy525.bench.until(cy525.chip.reaches(40))
    await anyio.sleep(1000)
    cy525.assert_steps(100)

@pytest.mark.anyio
async def test_that_fails(cy525):
    await cy525.bench.until(cy525.chip.reaches(cy525.position + 1), timeout="1 s")
"""


@pytest.mark.system
def test_tests_of_anyio_take_the_loop_and_the_fixtures(pytester, monkeypatch):
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    pytester.makepyfile(MARKED)
    result = pytester.runpytest_subprocess(
        "-p", "slewline.testing.plugin", "-p", "anyio", "-p", "no:cacheprovider", "-W", "error"
    )
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["*Timeout: waited 1 s for cy525 at position*", "*- slewline: cy525 on host -*"])
