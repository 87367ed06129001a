"""Conditions of the control port, as they are asked: several times in an instant, and of parts that find on demand."""

import slewline
from slewline.links.time.moments import FindingCondition, PinCondition


def test_an_edge_is_there_however_often_it_is_queried():
    bench = slewline.Bench()
    bench.part("inverter", name="i")
    bench.pin("i.in1").drive(0)
    bench.run("1 us")
    condition = PinCondition(bench.pin("i.in1"), "rises")
    bench.pin("i.in1").net.watch(lambda _: None)
    condition.begin()
    assert not condition.met()
    bench.pin("i.in1").drive(1)
    bench.run("1 us")

    assert [condition.met(), condition.met()] == [True, True]
    condition.begin()
    assert not condition.met()


def test_a_finding_of_an_unobserved_motor_is_waited_for():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.part("stepper", name="m", to=x, step="100 us")
    bench.host(x).send("A 0\rF 100\rR 100\rS 200\rZ 1\rN 60\rG\r")
    bench.run_until(FindingCondition(bench, "m"))

    (found,) = [found for found in bench.findings if found.source == "m"]
    assert found.code == "out-of-step"
    assert 0 <= bench.now_ps - found.time_ps <= 3_000_000_000
