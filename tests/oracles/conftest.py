"""A run of every family, recorded on all pins."""

from __future__ import annotations

import pytest

import slewline
from slewline.bench import load
from slewline.cli.demo import HERE, MACHINE


@pytest.fixture(scope="package")
def demo():
    """The welding machine of `slewline demo`."""
    bench = load(HERE / MACHINE)
    bench.record()
    bench.run_until_idle()
    return bench


SENT = "A 0\rF 10\rR 80\rS 240\rZ 1\rN 1000\rG\r-\rN 300\rG\r"  # a thousand steps and three hundred back


@pytest.fixture(scope="package")
def cy525():
    """Two moves, commanded over the bus."""
    bench = slewline.Bench()
    host = bench.host(bench.add("cy525", name="x"))
    bench.record()
    host.send(SENT)
    bench.run_until_idle()
    return bench


TOLD = ("Po", "S10", "T100", "R40", "+250", "-40", "E", "V1")  # what the host says to the module


@pytest.fixture(scope="package")
def gsc():
    """A program over a serial line of 9600 baud, 250 steps and 40 back."""
    bench = slewline.Bench()
    host = bench.host(bench.add("gs-c200s", name="x", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0}))
    bench.record()
    for line in TOLD:
        bench.run_until_idle()
        host.ask(line)
    bench.run("5 ms")
    return bench


@pytest.fixture(scope="package")
def mc1451a():
    """Two axes, 600 steps and 300 steps back, begun in the same cycle."""
    bench = slewline.Bench()
    host = bench.host(bench.add("mc1451a", name="x"))
    bench.record()
    host.send("SET_1\nSET_POS 600\nSET_VEL 0x40000\nSET_ACC 0x1000")
    host.send("SET_2\nSET_POS -300\nSET_VEL 0x20000\nSET_ACC 0x800\nMULTI_UPDATE 3")
    bench.run("100 ms")
    return bench


@pytest.fixture(scope="package")
def encoder():
    """An MC1151A-E whose shaft turns 300 counts forward and some back, as the axis does."""
    bench = slewline.Bench()
    x = bench.add("mc1151a-e", name="x")
    bench.part("encoder", to=x, counts=400, steps=400)  # per revolution
    host = bench.host(x)
    bench.record()
    host.send("SET_VEL 0x4000\nSET_ACC 256\nSET_POS 300\nUPDATE")
    bench.run_until(x.reaches(250))
    host.send("SET_POS 100\nUPDATE")
    bench.run("600 ms")
    return bench
