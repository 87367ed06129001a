"""Commands from a PROM: the loader starts, stops, and stays stopped."""

from __future__ import annotations

from itertools import pairwise

import pytest

import slewline

SET_UP = "F 10\rR 10\rS 255\rZ 1\r"


@pytest.mark.fact("CIRCUIT-PROM-1", "CON-GUIDE-STANDALONE")
def test_a_prom_programs_and_starts_a_chip_without_a_host(circuit):
    c = circuit("x.instrobe", "x.io_request", "x.ready", "x.run")
    image = "E\rB\r0\rQX\r"
    prom = c.part("prom", to="x", image=image)
    c.finish()
    assert c.x.program == b"B\x00"
    assert len(c.edges("x.run")) == 2  # the program has run
    assert len(c.falls("x.instrobe")) == len(image) == prom.address
    requests = c.edges("x.io_request")
    assert [t for t, level in requests if level] == c.falls("x.ready")  # READY low takes the request back
    assert [t for t, level in requests if not level] == c.rises("x.ready")[: len(image) - 1]  # the first one falls at 0
    assert c.bench.findings == []


@pytest.mark.fact("CIRCUIT-PROM-2", "DER-PROM-CLOCK")
def test_the_stop_byte_is_never_read_and_motions_of_the_program_do_not_pass_it(circuit):
    c = circuit("x.instrobe", "x.io_request", "x.ready", position=0)
    image = f"A 0\r{SET_UP}N 3\rE\rG\rG\rG\r0\rQX\r".encode()
    prom = c.part("prom", to="x", image=image + b"\xff" + b"B\rC\r" * 5)
    c.finish()
    loaded = c.falls("x.instrobe")[-1]
    assert c.x.position == 9
    assert len(c.falls("x.ready", loaded)) == 4  # the last byte, and three motions
    assert len(c.falls("x.instrobe")) == len(image)
    assert c.falls("x.io_request", loaded) == []
    assert prom.address == len(image)
    assert c.level("x.io_request") == 1
    c.bench.run("1 s")
    assert prom.address == len(image)
    assert c.bench.findings == []


PRESETS = {0x00: ("+\rN 3\rA 0\r" + SET_UP + "G\r", 3), 0x40: ("-\rN 5\rA 100\r" + SET_UP + "G\r", 95)}
TWO = PRESETS[0x00][0].encode().ljust(0x40, b"\xff") + PRESETS[0x40][0].encode()


BUT_LOAD = {"db": "db", "request": "io_request", "ready": "ready"}


@pytest.mark.fact("CIRCUIT-PROM-3")
@pytest.mark.parametrize("start", PRESETS)
def test_the_preset_chooses_a_program(circuit, start):
    c = circuit()
    c.part("prom", to="x", image=TWO, start=start)
    c.finish()
    assert c.x.position == PRESETS[start][1]


@pytest.mark.fact("CIRCUIT-PROM-3")
def test_reset_loads_the_address_that_the_switches_show(circuit):
    c = circuit()
    prom = c.part("prom", to="x", image=TWO)
    c.finish()
    assert c.x.position == 3
    c.bench.pin("prom.p6").drive(1)
    assert prom.address == len(PRESETS[0][0])  # a switch by itself loads nothing
    c.x.reset()
    c.finish()
    assert c.x.position == 95
    assert prom.address == 0x40 + len(PRESETS[0x40][0])
    c.bench.pin("prom.p6").drive(0)
    c.x.reset()
    c.finish()
    assert c.x.position == 3


@pytest.mark.fact("CIRCUIT-PROM-3")
def test_a_load_switch_of_its_own_starts_the_program_again(circuit):
    c = circuit("x.instrobe")
    prom = c.part("prom", image="C\rB\r")
    for own, theirs in BUT_LOAD.items():
        c.bench.wire(f"prom.{own}", f"x.{theirs}")
    c.finish()
    c.bench.pin("prom.load").pulse(0, "10 us")
    c.finish()
    assert len(c.falls("x.instrobe")) == 8
    assert prom.address == 4
    assert c.bench.findings == []


def test_a_load_switch_kept_closed_sends_the_first_byte_again_and_reports_it(circuit):
    c = circuit("x.instrobe")
    c.part("prom", image="C\r")
    for own, theirs in BUT_LOAD.items():
        c.bench.wire(f"prom.{own}", f"x.{theirs}")
    c.finish()
    c.bench.pin("prom.load").pulse(0, "100 us")
    c.finish()
    assert c.codes("prom") == ["load-held"]
    assert len(c.falls("x.instrobe")) == 2 + 3


@pytest.mark.fact("CIRCUIT-PROM-4")
def test_a_binary_program_may_contain_ff_when_the_address_is_the_stop(circuit):
    program = bytes.fromhex("46 01 0A 52 01 64 53 01 FF 5A 01 01 41 02 00 00 4E 02 05 00 2B 00 47 00")
    start = 0xFF - len(program)
    c = circuit("x.instrobe", straps={"ascii_binary": 0})
    prom = c.part("prom", to="x", image=bytes(start) + program, start=start, stop="address")
    c.finish()
    assert len(c.falls("x.instrobe")) == len(program)
    assert prom.address == 0xFF
    assert c.x.registers["slope"] == 0xFF
    assert c.x.position == 5
    c.bench.run("1 s")
    assert len(c.falls("x.instrobe")) == len(program)
    assert c.bench.findings == []


@pytest.mark.fact("CIRCUIT-PROM-4")
def test_with_the_data_stop_a_binary_program_ends_before_its_ff(circuit):
    c = circuit("x.instrobe", straps={"ascii_binary": 0})
    prom = c.part("prom", to="x", image=bytes.fromhex("53 01 FF 43 00"))
    c.finish()
    assert prom.address == 2
    assert len(c.falls("x.instrobe")) == 2


@pytest.mark.fact("CIRCUIT-PROM-5")
def test_a_motion_command_delays_the_next_byte(circuit):
    c = circuit("x.io_request", "x.motion_complete", "x.programmable_output", "x.pulse", "x.ready")
    c.part("prom", to="x", image=f"C\rA 0\rN 20\r{SET_UP}G\rB\r")
    c.finish()
    pulses, (set_again,) = c.falls("x.pulse"), c.rises("x.programmable_output")
    (complete,) = (t for t in c.falls("x.motion_complete") if t > pulses[-1])
    assert complete < set_again
    assert [t for t, _ in c.edges("x.io_request") if pulses[0] <= t <= complete] == []
    requests = c.falls("x.io_request")
    next_request = next(t for t in requests if t > complete)
    assert next_request == next(t for t in c.rises("x.ready") if t > complete)
    assert len(pulses) == 20
    assert {b - a for a, b in pairwise(pulses)} == {10**9}


def test_an_image_that_is_too_long_or_a_bad_start_is_refused():
    bench = slewline.Bench()
    with pytest.raises(slewline.UsageError, match="257 bytes; eight address lines reach 256"):
        bench.part("prom", image=bytes(257))
    with pytest.raises(slewline.UsageError, match="start 256"):
        bench.part("prom", image="", start=256)
    with pytest.raises(slewline.UsageError, match="stop 'never'"):
        bench.part("prom", image="", stop="never")
