"""Integrated motors: speed relative to real time, in virtual seconds per CPU second.

    python benchmarks/run.py motors

The motor is a QSH4218-47-28-040 (2.8 A, 24 V) with its own inertia as load and 5 mN m of friction; RK4, 20 µs, unless
stated otherwise.  Numba compiles before the clock starts.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from statistics import median
from typing import Any

import numpy as np
from rows import REAL, Row, timed

import slewline
from slewline.parts.motors.drivers import read_driver
from slewline.parts.motors.law import MotorLaw
from slewline.parts.motors.motor_data import LoadData
from slewline.parts.motors.motors import motor_named

ROUNDS = 5
MOTOR, DRIVER = "QSH4218-47-28-040", "24 V, 2.8 A"
LOAD = {"inertia": 6.8e-6, "friction": 5e-3}
DATA = motor_named(MOTOR)
STEPS: dict[str, Any] = {"motor": MOTOR, "driver": DRIVER, "load": LOAD}


def law(step_us: int = 20) -> MotorLaw:
    """Return the motor of these figures, with a given grid."""
    return MotorLaw(DATA, read_driver(DRIVER, "driver", DATA), LoadData(**LOAD), step_ps=step_us * 10**6)


def ramp(count: int) -> tuple[Any, Any, int]:
    """Return the steps of a ramp from 300 steps/s: instants, commands, and its end."""
    n = np.arange(1, count + 1)
    times = ((np.sqrt(9e4 + 4e4 * n) - 300) / 2e4 * 1e12).astype(np.int64)
    return times, n, int(times[-1])


def alone(engine: str, step_us: int, count: int) -> Callable[[], float]:
    """Return a workload: a single motor without other parts."""

    def act() -> float:
        times, commands, stop = ramp(count)
        law(step_us).integrate(times, commands, stop, engine=engine)
        return stop * 1e-12

    return act


def until_rest(bench: slewline.Bench, motor: Any) -> float:
    """Run until a move has ended and the motor is at rest; return the virtual time that this takes, in seconds."""
    start = bench.now_ps
    bench.run_until_idle(timeout="1000 s")
    bench.run_until(motor.rests, timeout="10 s")
    assert not motor.lost
    return (bench.now_ps - start) * 1e-12


def cy525(*watched: str) -> Callable[[], float]:
    """Return a workload: a move of 20,000 steps, with some pins watched."""

    def act() -> float:
        bench = slewline.Bench()
        x: Any = bench.add("cy525", name="x", crystal="11 MHz")
        motor: Any = bench.part("stepper", to=x, **STEPS)
        bench.part("switch", name="one", on=motor, low=500, high=600)
        bench.part("switch", name="two", on=motor, low=19_000)
        for pin in watched:
            bench.pin(pin).net.watch(lambda _: None)
        bench.host(x).send("A 0\rF 10\rR 40\rS 150\rZ 1\rN 20000\rG\r")
        return until_rest(bench, motor)

    return act


def homing() -> float:
    """Run a module that homes on switches of the shaft; return the virtual seconds."""
    bench = slewline.Bench()
    x: Any = bench.add("gs-c200s", name="x", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0})
    motor: Any = bench.part("stepper", to=x, **STEPS)
    bench.part("switch", name="home", on=motor, to=x, role="home", low=-20, high=0, hysteresis=3)
    bench.part("switch", name="end", on=motor, to=x, role="end", low=500)
    host: Any = bench.host(x)
    for line in ("Po", "S30", "T150", "R40", "E", "H"):
        host.ask(line)
    return until_rest(bench, motor)


def encoder() -> float:
    """Run a chipset that reads an encoder of 200 counts per revolution; return the virtual seconds."""
    bench = slewline.Bench()
    x: Any = bench.add("mc1151a-e", name="x")
    motor: Any = bench.part("stepper", to=x, **STEPS)
    shaft: Any = bench.part("encoder", on=motor, to=x, counts=200)
    host: Any = bench.host(x)
    host.send("SET_STEP_RATIO 256\nSET_POS_ERR 10\nSET_AUTO_STOP_ON\nSET_VEL 0x8000\nSET_ACC 256\nSET_POS 2000\nUPDATE")
    start = bench.now_ps
    host.wait("motion_complete")
    assert shaft.counts == 2000
    return (bench.now_ps - start) * 1e-12


def closed_loop() -> float:
    """Run figure 19, where each step waits for the previous one; return the virtual seconds."""
    bench = slewline.Bench()
    x: Any = bench.add("gs-c200s", name="x", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0})
    motor: Any = bench.part("stepper", to=x, **STEPS)
    bench.part("encoder", name="detector", on=motor, counts=200)
    bench.part("step_check", name="check", to=x)
    bench.wire("detector.a", "check.x")
    bench.wire("detector.b", "check.y")
    host: Any = bench.host(x)
    for line in ("Po", "S30", "T300", "R20", "+1000"):
        host.ask(line)
    host.ask("E")
    start = bench.now_ps
    bench.run("600 ms")
    return (bench.now_ps - start) * 1e-12


def rows() -> Iterator[Row]:
    """Yield the rows of a single motor, and of motors driven by chips."""
    law().integrate(*ramp(10), engine="numba")
    for name, act, goal, bound in (
        ("one motor, 20 µs, Numba", alone("numba", 20, 6000), 100.0, "latency of four dependent evaluations"),
        ("one motor, 100 µs, plain Python", alone("python", 100, 600), 8.0, "about 240 operations per step"),
        ("CY525, queried once, at rest", cy525(), None, "the integrator"),
        ("CY525, two switches watched", cy525("one.out", "two.out"), 25.0, "the integrator"),
        (
            "GS-C200S homes on its switches",
            homing,
            30.0,
            "interrupted integration blocks: each switch stops or reverses the module",
        ),
        ("MC1151A-E with encoder", encoder, 5.0, "an event per count, and the chip computes each cycle"),
        ("closed loop of figure 19 (GS-C manual)", closed_loop, 2.0, "every step interrupts an integration block"),
    ):
        act()
        speeds = []
        for _ in range(ROUNDS):
            seconds, virtual = timed(act)
            speeds.append(virtual / seconds)
        yield Row(name, median(speeds), REAL, goal, True, bound)
    yield Row("events of a motor at rest in 24 h", float(at_rest()), "", 20.0, False, "none")


def at_rest() -> int:
    """Return the number of events of a motor at rest in a day, with a watched switch."""
    bench = slewline.Bench()
    x: Any = bench.add("cy525", name="x")
    motor: Any = bench.part("stepper", to=x, **STEPS)
    bench.part("switch", name="one", on=motor, low=500)
    bench.pin("one.out").net.watch(lambda _: None)
    bench.run("1 s")
    first = next(motor.kernel.order)
    bench.run("24 h")
    return int(next(motor.kernel.order) - first - 1)


if __name__ == "__main__":
    for row in rows():
        print(f"{row.name:50} {row.figure:10.1f} {row.unit:12} goal {row.goal}  {'met' if row.met else 'MISSED'}")
    print(os.getloadavg())
