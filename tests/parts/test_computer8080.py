"""The 8080 routines of the manual, on an 8255 and on a single output port."""

from __future__ import annotations

from itertools import pairwise

import pytest

import slewline
from slewline.parts.boards import computer8080

BINBUFFER = bytes.fromhex("43 00 42 00 52 01 64 53 01 FE 46 01 03 4E 02 05 00 47 00 FF")
ASCIIBUFFER = b"C\rB\rR 100\rS 254\rF 3\rN 5\rG\r\xff"
OSCILLOSCOPE = bytes.fromhex("43 00 52 01 64 53 01 FF 46 01 03 4E 02 05 00 2B 00 47 00")
STATE = 10**12 / 2_048_000
CONTROL = 0xEF


# ------------------------------------------------------------------------------------------------------------- 8255
@pytest.mark.fact("CIRCUIT-8255")
@pytest.mark.parametrize(("buffer", "mode"), [(BINBUFFER, 0), (ASCIIBUFFER, 1)])
def test_sendparallel_sends_a_buffer_without_its_stopper(circuit, buffer, mode):
    c = circuit("x.instrobe", "x.db", straps={"ascii_binary": mode}, divisor=1)
    sdk = c.part("ppi8255", "sdk", to="x")
    sdk.sendparallel(buffer)
    c.finish()
    strobes = c.rises("x.instrobe")
    levels = dict(c.edges("x.db"))
    taken = [next(level for t, level in sorted(levels.items(), reverse=True) if t <= strobe) for strobe in strobes]
    assert bytes(taken) == buffer[:-1]
    assert c.x.registers == {**c.x.registers, "rate": 100, "slope": 254, "firstrate": 3, "number": 5}
    assert len(c.x.steps()) == 5
    assert "conflict" not in c.codes("x")


@pytest.mark.fact("CIRCUIT-8255")
def test_rcvbyte_reads_a_verify_group_and_gives_the_bus_back(circuit):
    c = circuit("x.io_select", "x.ready")
    sdk = c.part("ppi8255", "sdk", to="x")
    sdk.sendparallel(b"N 513\rS 25\rR 127\rF 3\rZ 1\rV 3\r\xff")
    sdk.rcvbyte(6)
    sdk.sendparallel(b"C\r\xff")
    c.finish()
    assert sdk.received.hex(" ") == "02 01 19 7f 03 01"
    assert c.level("x.programmable_output") == 0
    assert c.level("x.io_select") == 0
    assert c.bench.findings == []


@pytest.mark.fact("CIRCUIT-8255")
def test_port_b_shows_eight_outputs_of_the_chip(circuit):
    c = circuit(rate=3, firstrate=3, slope=255, divisor=1)
    sdk = c.part("ppi8255", "sdk", to="x")
    c.settle()
    assert sdk.read(computer8080.STATUS) == 0xFF
    sdk.sendchar("C\r-\r")
    c.finish()
    assert sdk.read(computer8080.STATUS) == 0xFF & ~0x10 & ~0x40  # programmable output, DIRECTION
    sdk.sendchar("N 300\rG\r")
    c.bench.run_until(c.x.pin("slew").is_(0))
    assert sdk.read(computer8080.STATUS) & 0xA2 == 0  # SLEW, READY and PULSE low
    c.finish()
    assert sdk.read(computer8080.STATUS) & 0x01 == 0  # MOTION COMPLETE
    sdk.sendchar("E\r")
    c.finish()
    assert sdk.read(computer8080.STATUS) & 0x08 == 0  # PROG
    sdk.sendchar("U\rQX\r")
    c.bench.run_until(lambda: sdk.idle)
    c.bench.run("1 ms")
    assert sdk.read(computer8080.STATUS) & 0x0C == 0x08  # RUN
    with pytest.raises(slewline.UsageError, match="no input port 0xee"):
        sdk.read(0xEE)


CODES = {
    "io_request": (0x00, 0x01),
    "io_select": (0x02, 0x03),
    "dowhile": (0x04, 0x05),
    "abort": (0x08, 0x09),
    "step_inhibit": (0x0A, 0x0B),
    "wait": (0x0C, 0x0D),
    "reset": (0x0E, 0x0F),
}


@pytest.mark.fact("CIRCUIT-8255", "CON-HIWAIT")
@pytest.mark.parametrize("pin", CODES)
def test_the_codes_of_port_c_set_and_reset_one_pin_each(circuit, pin):
    c = circuit()
    sdk = c.part("ppi8255", "sdk", to="x")
    c.settle()
    rest = {name: c.level(f"x.{name}") for name in CODES}
    assert rest == dict.fromkeys(CODES, 1) | {"io_select": 0, "step_inhibit": 0}
    for level, code in enumerate(CODES[pin]):
        sdk.out(CONTROL, code)
        c.bench.run_until(lambda: sdk.idle)
        assert {name: c.level(f"x.{name}") for name in CODES} == rest | {pin: level}


@pytest.mark.fact("CIRCUIT-8255")
def test_the_codes_drive_a_program_through_wait_dowhile_inhibit_abort_and_reset(circuit):
    c = circuit("x.pulse", "x.run", position=0)
    sdk = c.part("ppi8255", "sdk", to="x")
    sdk.sendchar("A 0\rF 10\rR 10\rS 255\rZ 1\rN 4\rE\rU\rG\rT 0\r0\rQX\r")
    c.settle()
    c.bench.run("30 ms")
    assert c.x.position == 0
    sdk.out(CONTROL, computer8080.DOWHILE)
    sdk.out(CONTROL, computer8080.LOWAIT)
    c.bench.run_until(c.x.reaches(10))
    sdk.out(CONTROL, computer8080.STPINH)
    c.bench.run("100 ms")
    assert c.x.position in (10, 11)
    sdk.out(CONTROL, computer8080.TRIGGER)
    sdk.out(CONTROL, computer8080.NOLOOP)
    c.finish()
    assert c.x.position == 12
    sdk.sendchar("N 5000\rG\r")
    c.bench.run_until(c.x.reaches(100))
    sdk.out(CONTROL, computer8080.ABORT)
    c.finish()
    assert c.x.position < 110
    sdk.out(CONTROL, computer8080.NOABORT)
    sdk.out(CONTROL, computer8080.RESETLO)
    c.bench.run("1 ms")
    sdk.out(CONTROL, computer8080.NORESET)
    c.finish()
    assert c.x.program == b""
    assert "conflict" not in c.codes("x")


def test_the_program_looks_on_the_grid_of_its_polling_loop(circuit):
    c = circuit("x.io_request", "x.ready")
    sdk = c.part("ppi8255", "sdk", to="x")
    sdk.sendchar("C\r")
    c.finish()
    states = [round(t / STATE) for t in c.falls("x.io_request")]
    assert states[0] == 10 + 17 + 17 + 17  # IN, ANI and JZ, two times MVI and OUT
    busy = c.falls("x.ready")[0] / STATE
    looks = [states[0] + 10 + 27 * n for n in range(100)]
    seen = next(look for look in looks if look > busy)
    assert round(c.rises("x.io_request")[0] / STATE) == seen + 17 + 17


def test_a_port_or_a_buffer_that_cannot_be_is_refused(circuit):
    c = circuit()
    sdk = c.part("ppi8255", "sdk", to="x")
    for port, value in ((0xEE, 1), (CONTROL, 6), (CONTROL, 0x80)):
        with pytest.raises(slewline.UsageError, match=r"allowed 0xEC \(data\), 0xEF \(codes 0 to 5 and 8 to 15\)"):
            sdk.out(port, value)
    with pytest.raises(slewline.UsageError, match="no end mark FF"):
        sdk.sendparallel(b"C\r")
    assert sdk.idle


# ------------------------------------------------------------------------------------------- the examples of section 11
@pytest.mark.fact("CON-MC-CODE", "CIRCUIT-8255")
def test_the_motion_bit_reads_zero_when_the_five_steps_are_done(circuit):
    c = circuit("x.pulse", "x.ready", straps={"ascii_binary": 0}, divisor=1)
    sdk = c.part("ppi8255", "sdk", to="x")
    sdk.sendparallel(BINBUFFER)
    c.settle()
    c.bench.run_until(lambda: sdk.idle)
    looks = []
    while sdk.read(computer8080.STATUS) & 0x01:
        looks.append(sdk.read(computer8080.STATUS) & 0x20)
        c.bench.run("13 us")
    assert set(looks) == {0}  # READY is never found high before MOTION COMPLETE is low
    assert len(looks) > 800
    assert len(c.falls("x.pulse")) == 5


@pytest.mark.fact("EXAMPLE-11-3")
def test_the_oscilloscope_shows_the_same_trace_after_every_reset(circuit):
    pins = ("pulse", "direction", "programmable_output", "motion_complete", "phase1", "phase2", "phase3", "phase4")
    c = circuit(*(f"x.{pin}" for pin in pins), straps={"ascii_binary": 0}, divisor=1)
    sdk = c.part("ppi8255", "sdk", to="x")
    c.settle()
    traces = []
    for _ in range(3):
        sdk.out(CONTROL, computer8080.RESETLO)
        c.bench.run("1 ms")
        sdk.out(CONTROL, computer8080.NORESET)
        c.bench.run("1 ms")
        sdk.sendchar(OSCILLOSCOPE)
        begin = c.bench.now_ps
        c.bench.run_until(lambda: sdk.idle)
        c.bench.run_until(c.x.pin("motion_complete").is_(0))  # the host polls pin 37
        c.bench.run("10 ms")
        ticks = c.x.clock.ticks_until
        first = ticks(c.falls("x.pulse", begin)[0])
        edges = {pin: [(ticks(t) - first, level) for t, level in c.edges(f"x.{pin}", begin)] for pin in pins}
        traces.append({pin: [edge for edge in edges[pin] if edge[0] >= 0] for pin in pins})
        assert c.rises("x.programmable_output", begin) == []
        assert len(c.falls("x.programmable_output", begin)) == 1  # C triggers the sweep
    assert traces[0] == traces[1] == traces[2]
    falls = [t for t, level in traces[0]["pulse"] if level == 0]
    assert len(falls) == 5
    assert [t for t, level in traces[0]["motion_complete"] if level == 0] == [falls[-1] + 36667]  # the last step at F
    assert c.level("x.direction") == 1
    assert all(b > a for a, b in pairwise(falls))


# -------------------------------------------------------------------------------------------------------- one port
@pytest.mark.fact("CIRCUIT-8080")
def test_the_smallest_host_sends_a_string_including_its_end_mark(circuit):
    c = circuit("x.instrobe", "x.db", "x.io_request", "x.ready")
    host = c.part("host8080", to="x")
    host.send(b"C\r\xffB\r")
    c.finish()
    c.bench.run("5 ms")
    assert len(c.falls("x.instrobe")) == 2
    assert c.level("x.programmable_output") == 0
    assert host.sent == 2
    assert c.bench.findings == []
    with pytest.raises(slewline.UsageError, match="no end mark FF"):
        host.send("C\r")


@pytest.mark.fact("CIRCUIT-8080")
def test_bit_7_of_the_byte_is_the_request(circuit):
    c = circuit("x.db", "x.io_request", "x.ready")
    host = c.part("host8080", to="x")
    host.send(b"B\xff")
    c.finish()
    assert c.edges("x.db")[0] == (c.falls("x.io_request")[0], 0x42)  # data and request in the same instant
    assert c.edges("x.db")[1] == (c.rises("x.io_request")[0], 0x7F)
    assert c.rises("x.io_request")[0] > c.falls("x.ready")[0]
