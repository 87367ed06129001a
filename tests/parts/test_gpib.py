"""A chip on the IEEE-488 bus: the simple listener, the full interface, the interrupt logic."""

from __future__ import annotations

import pytest

import slewline

US = 1_000_000


def listener_on(circuit, *recorded, line_feeds=False, **options):
    c = circuit(*recorded, **options)
    c.part("gpib_listener", "gpib", to="x", line_feeds=line_feeds)
    c.pet = c.part("gpib_talker", "pet", to="gpib")
    return c


# ----------------------------------------------------------------------------------------------------- simple listener
@pytest.mark.fact("CIRCUIT-GPIB-1")
def test_the_three_lines_of_the_listener_are_those_of_the_chip(circuit):
    c = listener_on(circuit, "gpib.dav", "gpib.nrfd", "gpib.ndac", "x.io_request", "x.ready")
    c.settle()
    assert (c.level("gpib.nrfd"), c.level("gpib.ndac"), c.level("gpib.dav")) == (1, 0, 1)
    c.pet.send("C\r")
    c.finish()
    assert c.level("x.programmable_output") == 0
    assert c.edges("x.io_request") == c.edges("gpib.dav")
    ready = c.edges("x.ready")
    assert c.edges("gpib.nrfd") == ready
    assert c.edges("gpib.ndac") == [(t, 1 - level) for t, level in ready]
    taken = [t + US for t in c.falls("x.ready")]  # the talker's own time
    assert c.rises("gpib.dav") == taken  # DAV goes when NDAC says that the byte is taken
    assert len(ready) == 4
    assert c.bench.findings == []


@pytest.mark.fact("CIRCUIT-GPIB-1")
def test_the_talker_does_not_lower_dav_while_the_chip_is_busy(circuit):
    c = listener_on(circuit, "gpib.dav", "x.ready")
    c.pet.send("D 20\rC\r")
    c.finish()
    delay = next(t for t in c.rises("x.ready") if t > 20_000 * US)
    assert not [t for t in c.falls("gpib.dav") if delay - 20_000 * US < t < delay]
    assert c.level("x.programmable_output") == 0


@pytest.mark.fact("CIRCUIT-GPIB-2")
def test_interface_clear_resets_the_chip(circuit):
    c = listener_on(circuit, "x.reset", position=0)
    c.pet.send("C\rE\rB\r")
    c.finish()
    assert c.x.program == b"B"
    c.pet.clear()
    c.finish()
    assert [c.rises("x.reset")[0] - c.falls("x.reset")[0]] == [100_000_000]
    assert c.x.program == b""
    assert c.level("x.programmable_output") == 1
    assert c.level("x.prog") == 1


@pytest.mark.fact("CIRCUIT-GPIB-2")
def test_the_end_of_a_motion_requests_service_until_the_next_byte(circuit):
    c = listener_on(circuit, "gpib.srq", "x.motion_complete", rate=30, firstrate=30, slope=255, divisor=1)
    c.pet.send("N 5\rG\r")
    c.finish()
    assert c.pet.requests == 1
    assert c.level("gpib.srq") == 0
    c.pet.send("C\r")
    c.finish()
    assert c.edges("gpib.srq") == c.edges("x.motion_complete")
    assert c.level("gpib.srq") == 1


@pytest.mark.fact("CIRCUIT-GPIB-2")
def test_bytes_under_attention_never_reach_the_chip(circuit):
    c = listener_on(circuit, "x.instrobe", "gpib.atn")
    c.settle()
    c.bench.run("1 us")
    c.pet.command([0x43, 0x0D])
    c.finish()
    assert c.falls("x.instrobe") == []
    assert len(c.edges("gpib.atn")) == 2
    c.pet.send("C\r")
    c.finish()
    assert len(c.falls("x.instrobe")) == 2
    assert c.level("x.programmable_output") == 0


@pytest.mark.fact("CIRCUIT-GPIB-3")
def test_line_feeds_are_kept_away_from_the_chip(circuit):
    c = listener_on(circuit, "x.instrobe", "x.programmable_output")
    c.pet.send("C\r\nB\r\n")
    c.finish()
    assert len(c.falls("x.instrobe")) == 4
    assert [level for _, level in c.edges("x.programmable_output")] == [0, 1]
    assert c.bench.findings == []


@pytest.mark.fact("CIRCUIT-GPIB-3")
def test_a_line_feed_that_comes_through_swallows_the_next_command(circuit):
    c = listener_on(circuit, "x.instrobe", "x.programmable_output", line_feeds=True)
    c.pet.send("C\r\nB\r\n")
    c.finish()
    assert len(c.falls("x.instrobe")) == 6
    assert [level for _, level in c.edges("x.programmable_output")] == [0]
    assert "line-feed" in c.codes("x")


def test_a_talker_without_a_listener_reports_it():
    bench = slewline.Bench()
    pet = bench.part("gpib_talker", "pet")
    pet.send("C")
    bench.run_until_idle()
    assert [found.code for found in pet.findings] == ["no-listener"]


# ---------------------------------------------------------------------------------------------------- full interface
def interface_on(circuit, *recorded, **options):
    c = circuit(*recorded, **options)
    c.part("gpib_device", "gpib", to="x", address=7)
    c.pc = c.part("gpib_controller", "pc", to="gpib")
    return c


@pytest.mark.fact("CIRCUIT-GPIB-4")
def test_commands_reach_the_addressed_chip_through_inverting_buffers(circuit):
    c = interface_on(circuit, "x.db", "gpib.dio", "gpib.atn", "x.instrobe")
    c.pc.write(7, "C\r")
    c.finish()
    assert [level for _, level in c.edges("x.db") if level >= 0] == [0x43, 0x0D]
    (begin,) = c.rises("gpib.atn")[:1]
    (end,) = [t for t in c.falls("gpib.atn") if t > begin]
    assert [level for t, level in c.edges("gpib.dio", begin + 1, end - 1) if level >= 0] == [0xFF ^ 0x43, 0xFF ^ 0x0D]
    c.pc.write(6, "B\r")
    c.finish()
    assert c.level("x.programmable_output") == 0
    assert len(c.falls("x.instrobe")) == 2
    assert c.codes("pc") == ["no-listener", "no-listener"]


@pytest.mark.fact("CIRCUIT-GPIB-4")
@pytest.mark.parametrize("number", [1, 3, 6])
def test_a_verify_read_out_is_a_read_of_the_bus(circuit, number):
    c = interface_on(circuit, "x.io_select", "gpib.dio", "gpib.dav", "x.outstrobe")
    c.pc.write(7, "N 513\rS 25\rR 127\rF 3\rZ 1\rV 3\r")
    c.pc.read(7, number)
    c.pc.write(7, "C\r")
    c.finish()
    assert c.pc.received == bytes.fromhex("02 01 19 7F 03 01")[:number]
    assert c.level("x.programmable_output") == 0
    assert [level for _, level in c.edges("x.io_select")] == [1, 0]
    assert len(c.falls("x.outstrobe")) == 2 * number
    select, release = (t for t, _ in c.edges("x.io_select"))
    given = [t for t in c.falls("gpib.dav", select) if t < release]
    assert bytes(c.edges("gpib.dio", select, t)[-1][1] ^ 0xFF for t in given) == c.pc.received
    assert c.bench.findings == []


@pytest.mark.fact("CIRCUIT-GPIB-4")
def test_a_poll_returns_the_wired_pins(circuit):
    c = interface_on(circuit)
    c.settle()
    c.pc.poll(7)
    c.pc.write(7, "C\r-\rE\r")
    c.finish()
    c.pc.poll(7)
    c.finish()
    # bits as in Table IX: MOTION COMPLETE, PULSE, RUN, PROG, output, READY, DIRECTION, SLEW
    assert c.pc.polled == [0xFF, 0xFF & ~(0x08 | 0x10 | 0x40)]
    assert [found.code for found in c.bench.findings] == ["unfinished"]  # no Q has come


def test_an_interface_clear_takes_all_addresses_back(circuit):
    c = interface_on(circuit, "x.instrobe")
    c.pc.command([0x3F, 0x27])
    c.pc.clear()
    c.pc.send("C\r")
    c.finish()
    assert c.falls("x.instrobe") == []
    assert c.codes("pc") == ["no-listener"] * 2
    c.pc.write(7, "C\r")
    c.finish()
    assert c.level("x.programmable_output") == 0


def test_two_chips_with_two_addresses_share_one_bus(circuit):
    c = interface_on(circuit)
    y = c.bench.add("cy525", name="y")
    c.part("gpib_device", "gpib2", to=y, address=8)
    for line in ("dio", "dav", "nrfd", "ndac", "atn", "ifc", "srq"):
        c.bench.wire(f"gpib.{line}", f"gpib2.{line}")
    c.pc.write(7, "A 111\rC\r")
    c.pc.write(8, "A 222\rV 0\r")
    c.pc.read(8, 5)
    c.finish()
    assert (c.x.position, y.position) == (111, 222)
    assert c.pc.received == b"00222"
    assert (c.level("x.programmable_output"), c.level("y.programmable_output")) == (0, 1)
    assert c.bench.findings == []


def test_an_address_beyond_30_is_refused(circuit):
    with pytest.raises(slewline.UsageError, match=r"address 31; allowed 0\.\.30"):
        circuit().part("gpib_device", address=31)


# ----------------------------------------------------------------------------------------------------- interrupt logic
def interrupts_on(circuit, *recorded, **options):
    c = interface_on(circuit, *recorded, **options)
    c.part("gpib_interrupts", "irq", to="x")
    c.bench.wire("gpib.clr", "irq.clear")
    c.bench.wire("gpib.trig", "irq.trigger")
    c.bench.wire("gpib.srq", "irq.srq")
    c.pc.write(7, "A 0\rF 10\rR 10\rS 255\rZ 1\rN 100\rG\r")
    c.settle()
    c.bench.run_until(c.x.reaches(20))
    return c


@pytest.mark.fact("CIRCUIT-GPIB-5")
def test_device_clear_freezes_the_motion_and_device_trigger_resumes_it(circuit):
    c = interrupts_on(circuit, "x.pulse", "x.step_inhibit")
    c.pc.device_clear()
    c.bench.run("200 ms")
    held = c.x.position
    assert 20 <= held <= 21
    assert (c.level("x.pulse"), c.level("x.step_inhibit")) == (0, 1)
    c.bench.run("1 s")
    assert c.x.position == held
    c.pc.trigger(8)  # somebody else
    c.bench.run("100 ms")
    assert c.x.position == held
    c.pc.trigger(7)
    c.finish()
    assert c.x.position == 100
    assert len(c.falls("x.pulse")) == 100
    assert c.level("x.step_inhibit") == 0


@pytest.mark.fact("CIRCUIT-GPIB-5")
def test_a_limit_switch_stops_the_motion_and_requests_service(circuit):
    c = interrupts_on(circuit, "x.pulse", "gpib.srq")
    c.bench.pin("irq.limit").drive(0)
    c.bench.run("200 ms")
    assert c.x.position == 20
    assert (c.level("x.pulse"), c.level("x.step_inhibit"), c.level("gpib.srq")) == (0, 1, 0)
    assert c.pc.requests == 1
    c.pc.trigger(7)  # the master drives away from the switch, which is still closed
    c.bench.run("10 ms")
    assert c.level("x.step_inhibit") == 0
    assert c.x.position > 20
    c.bench.pin("irq.limit").drive(1)
    assert c.level("gpib.srq") == 1
    c.finish()
    assert c.x.position == 100


@pytest.mark.fact("CIRCUIT-GPIB-5")
def test_the_end_of_a_motion_requests_service_too(circuit):
    c = interrupts_on(circuit, "gpib.srq", "x.motion_complete")
    assert c.pc.requests == 0
    c.finish()
    assert c.pc.requests == 1
    assert c.falls("gpib.srq") == c.falls("x.motion_complete")
    assert c.level("gpib.srq") == 0


@pytest.mark.fact("CIRCUIT-GPIB-5")
def test_a_chip_that_is_cleared_at_rest_begins_its_motion_with_the_trigger(circuit):
    c = interface_on(circuit, "x.pulse", rate=10, firstrate=10, slope=255, divisor=1)
    c.part("gpib_interrupts", "irq", to="x")
    c.bench.wire("gpib.clr", "irq.clear")
    c.bench.wire("gpib.trig", "irq.trigger")
    c.pc.device_clear()
    c.pc.write(7, "N 5\rG\r")
    c.settle()
    c.bench.run("100 ms")
    assert c.edges("x.pulse") == []
    c.pc.trigger(7)
    c.finish()
    assert len(c.falls("x.pulse")) == 5
