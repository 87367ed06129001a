"""Motors behind chips: what a packet says of a stall, and what a motor costs that nobody looks at."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import slewline

from .table import Reading, at_most, check, same

MOTOR = {"motor": "QSH4218-47-28-040", "driver": "24 V, 2.8 A", "load": "inertia 68 g cm2, friction 2 mNm"}
MOTION_ERROR = 1 << 4  # of the status word


@check(44, "MC1451A-E with an encoder, to 4000")
def stall_in_the_packet() -> Iterator[Reading]:
    for acceleration in (478, 47_800):  # 1/65536 step/cycle^2
        bench = slewline.Bench()
        x: Any = bench.add("mc1451a-e", name="x")
        motor: Any = bench.part("stepper", to=x, **MOTOR)
        bench.part("encoder", on=motor, to=x, counts=200)
        host: Any = bench.host(x)
        host.send("SET_STEP_RATIO 256\nSET_POS_ERR 20\nSET_AUTO_STOP_ON")
        host.send(f"SET_VEL 42949\nSET_ACC {acceleration}\nSET_POS 4000\nUPDATE")
        bench.run("2.5 s")
        failed = bool(host.query("GET_STATUS") & MOTION_ERROR)
        name = f"acceleration {acceleration}"
        if acceleration == 478:
            yield same(f"{name}: position", x.axes[0].position, 4000)
            yield same(f"{name}: actual position", host.query("GET_ACTL_POS"), 4000)
        yield same(f"{name}: motion error", float(failed), float(acceleration > 478))
        yield same(f"{name}: steps lost", float(motor.lost > 0), float(acceleration > 478))


@check(48, "events of a motor that nobody looks at")
def no_events() -> Iterator[Reading]:
    bench = slewline.Bench()
    x: Any = bench.add("cy525", name="x", crystal="11 MHz")
    motor: Any = bench.part("stepper", to=x, **MOTOR)
    bench.part("switch", name="end", on=motor, low=500)
    bench.pin("end.out").net.watch(lambda _: None)
    bench.run("1 s")
    first = next(motor.kernel.order)
    bench.run("24 h")
    yield at_most("24 h at rest, a switch watched", next(motor.kernel.order) - first - 1, 20)

    bench = slewline.Bench()
    x = bench.add("cy525", name="x", crystal="11 MHz")
    motor = bench.part("stepper", to=x, **MOTOR)
    bench.host(x).send("A 0\rF 10\rR 40\rS 150\rZ 1\rN 65000\rH\rG\r")
    bench.run("5 s")
    reached, first = motor._run.reached, next(motor.kernel.order)
    bench.run("1 h")
    yield at_most("an hour of slew: events", next(motor.kernel.order) - first - 1, 20)
    yield at_most("an hour of slew: seconds integrated", (motor._run.reached - reached) * 1e-12, 0)
