"""The passive circuits of section 9, and the socket."""

from __future__ import annotations

from itertools import pairwise
from math import isclose, pi

import pytest

from slewline.chips import sheet_of
from tests.parts.circuits import lc_frequency, reset_time

MS = 10**9


# ------------------------------------------------------------------------------------------------- RESET (fig. 9.1)
@pytest.mark.fact("RESET-6")
def test_one_microfarad_keeps_reset_low_for_much_longer_than_10_ms():
    assert reset_time() > 10 * MS
    assert reset_time() == 71_355_817_782
    assert isclose(reset_time(c=2e-6), 2 * reset_time())
    assert reset_time(c=0.1e-6) < 10 * MS  # a tenth of it would be too short
    assert isclose(reset_time(r=10e3, c=1e-6, supply=5, threshold=2.5), 0.01 * 0.693147 * 10**12, rel_tol=1e-6)


@pytest.mark.fact("RESET-6")
def test_the_capacitor_starts_a_chip_that_nobody_resets(circuit):
    c = circuit("x.instrobe", cold=True)
    host = c.bench.host(c.x)
    c.settle()
    c.x.power(True)
    host.send("C\r")
    c.bench.run_until_idle()
    assert c.falls("x.instrobe")[0] > reset_time()
    assert c.falls("x.instrobe")[0] - reset_time() < MS
    assert c.codes("x") == []


@pytest.mark.fact("RESET-6")
def test_an_external_gate_may_pull_reset_low_too(circuit):
    c = circuit("x.reset")
    c.part("nand", "gate")
    c.bench.wire("gate.out", "x.reset")
    host = c.bench.host(c.x)
    c.bench.pin("gate.in1").drive(0)
    host.send("C\rE\rB\r")
    c.finish()
    assert (c.level("x.programmable_output"), c.x.program) == (0, b"B")
    c.bench.pin("gate.in1").drive(1)
    c.bench.run("1 ms")
    assert (c.level("x.programmable_output"), c.x.program) == (1, b"")
    host.send("C\r")
    c.bench.run("5 ms")
    assert c.level("x.programmable_output") == 1  # still held
    c.bench.pin("gate.in1").drive(0)
    c.finish()
    assert c.level("x.programmable_output") == 0


# ------------------------------------------------------------------------------------------------- clock (fig. 9.2)
@pytest.mark.fact("CLOCK-3")
@pytest.mark.parametrize(
    ("l", "c", "cpp", "hertz"),
    [(45e-6, 20e-12, 7e-12, 5_240_068), (120e-6, 20e-12, 7e-12, 3_208_873), (1e-3, 2e-9, 0.0, 159_154.94)],
)
def test_the_lc_clock_has_the_frequency_of_its_coil_and_capacitors(l, c, cpp, hertz):  # noqa: E741
    assert isclose(lc_frequency(l, c, cpp), hertz, rel_tol=1e-6)
    capacitance = (c + 3 * cpp) / 2
    assert isclose((2 * pi * lc_frequency(l, c, cpp)) ** 2 * l * capacitance, 1)


@pytest.mark.fact("CLOCK-3")
def test_a_chip_runs_from_an_lc_clock(circuit):
    hertz = round(lc_frequency(45e-6, 20e-12, 7e-12))
    c = circuit("x.pulse", crystal=hertz, rate=40, firstrate=40, slope=255, divisor=1)
    c.bench.host(c.x).send("N 3\rG\r")
    c.finish()
    one, two, _ = c.falls("x.pulse")
    assert isclose((two - one) / 10**12, 11e6 / hertz / 4000, rel_tol=1e-9)


# ------------------------------------------------------------------------------------------------------------- family
CY512_SOCKET = [
    *("io_request", "xtal1", "xtal2", "reset", "nc", "abort", "vss", "instrobe", "nc", "outstrobe"),
    *("clk15", "db0", "db1", "db2", "db3", "db4", "db5", "db6", "db7", "vss"),
    *("phase1", "phase2", "phase3", "phase4", "nc", "vdd", "ready", "dowhile", "slew", "step_inhibit"),
    *("prog", "run", "direction", "programmable_output", "pulse"),
    *("ascii_binary", "motion_complete", "wait", "io_select", "vcc"),
]


@pytest.mark.fact("FAMILY-2")
def test_the_pins_fit_a_cy512_socket():
    pins = {row.number: row.name for row in sheet_of("cy525").pins}
    assert sorted(pins) == list(range(1, 41))
    for number, name in enumerate(CY512_SOCKET, 1):
        assert pins[number] == name or pins[number].rstrip("0123456789") == name  # nc5, vss7


@pytest.mark.fact("FAMILY-2")
def test_d_delays_and_x_executes_unlike_in_a_cy512(circuit):
    c = circuit("x.run", "x.ready")
    host = c.bench.host(c.x)
    host.send("E\rC\r0\rQ")
    c.finish()
    host.send("D 30\r")
    c.finish()
    assert c.edges("x.run") == []
    assert c.rises("x.ready")[-1] - c.falls("x.ready")[-1] > 30 * MS
    host.send("X\r")
    c.finish()
    assert [level for _, level in c.edges("x.run")] == [0, 1]


@pytest.mark.fact("FAMILY-2")
def test_h_is_unlimited_stepping_and_abort_ramps_down_unlike_in_a_cy512(circuit):
    c = circuit("x.slew", rate=40, firstrate=10, slope=240, divisor=1, position=0)
    host = c.bench.host(c.x)
    host.send("N 2000\rH\rG\r")
    c.settle()
    c.bench.run_until(c.x.pin("slew").is_(0))
    c.bench.run("60 s")
    assert c.x.travel > 200_000
    c.x.pin("abort").drive(0)
    aborted = c.bench.now_ps
    c.finish()
    clocks = [c.x.clock.ticks_until(t) for t in c.x.steps(aborted - MS).times_ps.tolist()]
    gaps = [after - before for before, after in pairwise(clocks)]
    assert gaps == sorted(gaps)
    assert gaps[-1] > 3 * gaps[0]
