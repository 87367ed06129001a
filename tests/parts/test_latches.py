"""Latches for the position on the fly and for the phases."""

from __future__ import annotations

from itertools import product
from random import Random

import pytest

from slewline.core.time.events import NotYet
from slewline.core.wires.clocking import clock_edges
from slewline.core.wires.wave import Wave
from slewline.parts.base.counted import Sampled
from slewline.parts.boards.computer8080 import IOSELOUT

SLOW = "F 3\rR 3\rS 255\rZ 1\r"


@pytest.mark.fact("FLY-POS-5", "CIRCUIT-LATCH")
@pytest.mark.parametrize("position", [0x00FF, 0x0100, 0xFFFF])
def test_the_latches_catch_the_position_of_the_step_that_runs(circuit, position):
    c = circuit("x.pulse")
    latch = c.part("position_latch", to="x")
    host = c.bench.host(c.x)
    c.settle()
    host.send(f"A {position - 3}\r{SLOW}N 6\rG\r")
    c.bench.run_until(c.x.reaches(position - 1))
    assert host.read_position() == position
    assert latch.position == position
    c.bench.run_until_idle()
    assert latch.position == position
    assert c.x.position == (position + 3) % 65536
    for pin, byte in (("read_high", position >> 8), ("read_low", position & 0xFF)):
        assert c.x.bus.level is None  # high impedance
        c.bench.pin(f"position_latch.{pin}").drive(0)
        assert latch.byte("db") == byte
        c.bench.pin(f"position_latch.{pin}").drive(1)
    assert c.bench.findings == []


@pytest.mark.fact("FLY-POS-5")
def test_while_i_o_select_stays_high_the_latches_follow_every_step(circuit):
    c = circuit()
    latch = c.part("position_latch", to="x")
    ppi = c.part("ppi8255", to="x")
    ppi.sendchar(f"A 250\r{SLOW}N 12\rG\r")
    ppi.out(0xEF, IOSELOUT)
    seen = []
    c.settle()
    c.bench.run_until(c.x.pin("io_select").is_(1))
    assert c.x.position < 253
    first = c.x.position + 1
    for position in range(first, 262):
        c.bench.run_until(c.x.reaches(position))
        c.bench.run("40 us")
        seen.append(latch.position)
    assert seen == list(range(first, 262))


@pytest.mark.fact("CIRCUIT-LATCH", "FLY-POS-5")
@pytest.mark.parametrize("position", [0x00FF, 0x0100, 0x1234])
def test_two_373_and_nor_gates_on_pins_10_and_37_do_the_same(circuit, position):
    c = circuit()
    c.part("position_latch", "made", to="x")
    for name in ("high", "low"):
        c.part("latch8", name)
        c.part("nor", f"enable_{name}")
        c.bench.wire("x.db", f"{name}.d")
        c.bench.wire("x.db", f"{name}.q")
        c.bench.wire("x.outstrobe", f"enable_{name}.in1")
        c.bench.wire(f"enable_{name}.out", f"{name}.enable")
    c.bench.wire("x.motion_complete", "enable_high.in2", invert=True)
    c.bench.wire("x.motion_complete", "enable_low.in2")
    host = c.bench.host(c.x)
    c.settle()
    host.send(f"A {position - 2}\r{SLOW}N 4\rG\r")
    c.bench.run_until(c.x.reaches(position - 1))
    host.read_position()
    c.bench.run_until_idle()
    assert (c.bench["high"]._latched, c.bench["low"]._latched) == divmod(position, 256)
    assert c.bench["made"].position == position
    c.bench.pin("low.output_enable").drive(0)
    assert c.x.bus.byte == position & 0xFF


# ------------------------------------------------------------------------------------------------------ phase latch
def phase_circuit(circuit):
    c = circuit("phase_latch.coil1")
    c.part("phase_latch", to="x")
    c.host = c.bench.host(c.x)
    c.host.send(f"A 0\r{SLOW}N 3\rG\r")
    c.finish()
    return c


def coils(c):
    return tuple(c.level(f"phase_latch.coil{n}") for n in (1, 2, 3, 4))


def phases(c):
    return tuple(c.level(f"x.phase{n}") for n in (1, 2, 3, 4))


@pytest.mark.fact("PHASE-4")
def test_the_coils_stay_energised_when_i_or_reset_switches_the_phase_pins_off(circuit):
    c = phase_circuit(circuit)
    last = coils(c)
    assert last == phases(c)
    assert sum(last) == 2
    c.host.send("I\r")
    c.finish()
    assert (phases(c), coils(c)) == ((1, 1, 1, 1), last)
    c.host.send("N 2\rG\r")
    c.finish()
    after = coils(c)
    assert after == phases(c) != last
    c.x.reset()
    c.bench.run("1 ms")
    assert (phases(c), coils(c)) == ((1, 1, 1, 1), after)


@pytest.mark.fact("PHASE-4")
def test_the_latch_takes_the_off_pattern_only_with_a_pulse(circuit):
    c = phase_circuit(circuit)
    last = coils(c)
    c.host.send("O 4\r")
    c.finish()
    assert (phases(c), coils(c)) == ((1, 1, 1, 1), last)
    c.host.send("O 200\r")
    c.finish()
    assert coils(c) == (1, 1, 1, 1)
    assert c.x.position == 3


@pytest.mark.fact("PHASE-4")
def test_a_control_line_switches_the_coils_off_and_on_again(circuit):
    c = phase_circuit(circuit)
    last = coils(c)
    off = c.bench.pin("phase_latch.off")
    off.drive(1)
    assert coils(c) == (1, 1, 1, 1)
    assert phases(c) == last
    off.drive(0)
    assert coils(c) == last


@pytest.mark.fact("PHASE-4")
def test_in_motion_the_coils_show_each_pattern_at_the_end_of_its_step(circuit):
    c = circuit(*(f"phase_latch.coil{n}" for n in (1, 2, 3, 4)), "x.pulse")
    c.part("phase_latch", to="x")
    host = c.bench.host(c.x)
    host.send(f"A 0\rO 0\r{SLOW}N 8\rG\r")
    c.finish()
    changes = sorted({t for n in (1, 2, 3, 4) for t, _ in c.edges(f"phase_latch.coil{n}")})
    assert changes == c.rises("x.pulse")


def test_the_two_halves_of_a_position_are_enabled_apart(circuit):
    c = circuit()
    latch = c.part("position_latch")
    source = c.part("prom", "source", image=bytes(range(1, 9)))
    c.bench.wire("source.db", "position_latch.db")
    strobe, complete = c.bench.pin("position_latch.outstrobe"), c.bench.pin("position_latch.motion_complete")
    c.settle()
    for low, level in product((0, 1), (1, 0)):
        source.address += 1
        source._react()
        complete.drive(level)
        before = latch.position
        if low == 0:
            strobe.drive(0)
            strobe.drive(1)
            expected = before & 0xFF | latch.byte("db") << 8 if level else before & 0xFF00 | latch.byte("db")
            assert latch.position == expected
        else:
            assert latch.position == before


@pytest.mark.parametrize("seed", range(20))
def test_a_latch_names_an_instant_only_where_its_level_changes(seed):
    random = Random(seed)

    def wave(count):
        return Wave(
            0, tuple(sorted(random.sample(range(1, 99), count))), tuple(random.randrange(2) for _ in range(count))
        )

    latch = Sampled(clock_edges(wave(30), 1, 0), wave(9), random.randrange(2))
    changes = [ps for ps in range(1, 100) if latch.level(ps) != latch.level(ps - 1)]
    for start in range(99):
        answer, following = latch.after(start), next((ps for ps in changes if ps > start), None)
        if isinstance(answer, NotYet):
            assert start < answer.at and (following is None or answer.at < following)
        else:
            assert answer == following
