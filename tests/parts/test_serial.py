"""The receive-only serial interface: word formats, the baud rate generator, and what gets lost."""

from __future__ import annotations

import pytest

import slewline
from tests.rows import rows

BIT_9600 = 10**12 / 9600


def uart_on(circuit, *recorded, baud=9600, word=None, sender=None, **options):
    c = circuit(*recorded, **options)
    c.uart = c.part("uart", to="x", baud=baud, **(word or {}))
    c.pc = c.part("serial_sender", "pc", to="uart", baud=baud, **(sender if sender is not None else word or {}))
    return c


# ----------------------------------------------------------------------------------------------------- the circuit
@pytest.mark.fact("CIRCUIT-UART-1")
def test_the_uart_carries_commands_to_the_chip_by_its_three_lines(circuit):
    c = uart_on(circuit, "x.io_request", "x.ready", "x.instrobe", "x.db", "uart.rxd", "uart.dav")
    c.pc.send("C\r")
    c.finish()
    assert c.level("x.programmable_output") == 0
    assert c.bench.findings == []
    requests, busy = c.falls("x.io_request"), c.falls("x.ready")
    assert len(requests) == 2
    assert c.rises("x.io_request") == busy  # READY low clears DAV at once
    assert c.falls("uart.dav") == busy
    assert c.rises("uart.dav") == requests
    driven = [(t, level) for t, level in c.edges("x.db")]
    strobes = c.edges("x.instrobe")
    assert [t for t, _ in driven] == [t for t, _ in strobes]  # on the bus only while INSTROBE is low
    assert [level for _, level in driven] == [0x43, -1, 0x0D, -1]


@pytest.mark.fact("CIRCUIT-UART-1")
def test_a_character_is_requested_in_the_middle_of_its_stop_bit(circuit):
    c = uart_on(circuit, "uart.dav")
    c.settle()
    c.bench.run("10 us")
    c.pc.send("C")
    c.finish()
    tick = 10**12 / (16 * 9600)
    begin = 10_000_000 // tick * tick  # the clock before the fall
    (available,) = c.rises("uart.dav")
    assert available == int(begin + tick * (1 + 8 + 9 * 16))  # the clock behind it, half a bit, nine bits


@pytest.mark.fact("CIRCUIT-UART-2")
def test_nothing_travels_back_to_the_host(circuit):
    c = uart_on(circuit, "x.outstrobe", "x.io_select", "uart.rxd")
    c.pc.send("V 0\r")
    c.finish()
    quiet = c.bench.now_ps
    c.bench.run("20 ms")
    assert c.edges("x.outstrobe") == []
    assert c.level("x.io_select") == 0
    assert c.edges("uart.rxd", quiet) == []
    assert c.x.findings == []


# -------------------------------------------------------------------------------------------------- baud rates, words
RATES = ("76800", "38400", "19200", "9600", "4800", "2400", "1200", "600", "300", "150", "75", "37.5")


@pytest.mark.fact("CIRCUIT-UART-3")
@rows("stage", range(1, 13))
def test_each_stage_of_the_counter_is_sixteen_times_a_baud_rate(stage):
    baud = RATES[stage - 1]
    bench = slewline.Bench()
    uart = bench.part("uart", baud=baud)
    pc = bench.part("serial_sender", "pc", to="uart", baud=baud)
    assert uart._clock.hz == 2_457_600 / 2**stage == 16 * float(baud)
    bench.record("uart.rxd")
    bench.run("1 us")
    pc.send(b"\x55")
    bench.run_until_idle()
    times, _ = bench.edges("uart.rxd")
    bits = [b - a for a, b in zip(times.tolist(), times.tolist()[1:], strict=False)]
    bit = 2**stage * 16 / 2_457_600 * 1e12
    assert all(abs(found - bit) <= 1 for found in bits)  # rounded down to whole picoseconds
    assert len(bits) == 9
    assert uart.held == 0x55
    assert uart.findings == []


@pytest.mark.fact("CIRCUIT-UART-4")
@pytest.mark.parametrize(
    ("word", "changes"),
    [
        (dict(bits=8), [0, 1, 3, 7, 8, 9]),  # 43 hex: start, 1100 0010, stop
        (dict(bits=7, parity="even"), [0, 1, 3, 7]),  # 1100 001, parity 1, stop
        (dict(bits=7, parity="odd"), [0, 1, 3, 7, 8, 9]),
    ],
)
def test_a_character_is_sent_lowest_bit_first_with_its_parity_after_it(word, changes):
    bench = slewline.Bench()
    pc = bench.part("serial_sender", "pc", baud=9600, **word)
    bench.record("pc.txd")
    bench.run("625 us")  # six bits: a tick of the sender's clock
    pc.send("C")
    bench.run_until_idle()
    times, levels = bench.edges("pc.txd")
    assert [round((time - 625_000_000) / BIT_9600, 3) for time in times.tolist()] == changes
    assert levels.tolist() == [0, 1] * (len(changes) // 2)


@pytest.mark.fact("CIRCUIT-UART-3")
def test_a_rate_that_the_generator_does_not_have_is_refused():
    bench = slewline.Bench()
    with pytest.raises(slewline.UsageError, match=r"baud 110; allowed 76800, 38400, .*, 75, 37\.5"):
        bench.part("uart", baud=110)
    with pytest.raises(slewline.UsageError, match="sixteen times the rate must be a whole number of hertz"):
        bench.part("serial_sender", baud="110.03")


@pytest.mark.fact("CIRCUIT-UART-4")
@rows("bits", [5, 6, 7, 8])
@rows("parity", ["none", "odd", "even"])
@rows("stop", [1, "1.5", 2])
def test_every_word_format_arrives_when_both_ends_are_strapped_alike(bits, parity, stop):
    bench = slewline.Bench()
    word = dict(bits=bits, parity=parity, stop=stop)
    uart = bench.part("uart", **word)
    pc = bench.part("serial_sender", "pc", to="uart", **word)
    taken = []
    bench.pin("uart.dav").net.watch(lambda net: taken.append(uart.held) if net.level else None)
    mask = (1 << bits) - 1
    data = bytes([0x00, 0x55, 0xFF, 0x2C])
    for byte in data:
        pc.send([byte])
        bench.run_until_idle()
        bench.pin("uart.rdav").pulse(0, 0)
        bench.run(0)
    assert taken == [byte & mask for byte in data]
    assert uart.findings == []
    length = 1 + bits + (parity != "none") + float(stop)
    assert abs(bench.now_ps - 4 * length * BIT_9600) <= 4  # ps, rounding


@pytest.mark.fact("CIRCUIT-UART-4")
def test_a_parity_that_does_not_match_is_flagged_and_the_byte_reported(circuit):
    c = uart_on(circuit, word=dict(parity="odd"), sender=dict(parity="even"))
    c.pc.send("C\r")
    c.finish()
    assert c.codes("uart") == ["uart-parity", "uart-parity"]
    assert "0x43" in c.uart.findings[0].text
    assert c.level("uart.pe") == 1
    assert c.level("uart.fe") == 0


@pytest.mark.fact("CIRCUIT-UART-4")
def test_seven_bits_with_parity_read_as_eight_bits_give_another_byte(circuit):
    c = uart_on(circuit, word=dict(bits=8), sender=dict(bits=7, parity="odd"))
    c.pc.send("+")  # four ones: the parity bit, a one, lands in bit 7
    c.finish()
    assert c.uart.held == 0xAB
    assert c.level("x.direction") == 1
    assert c.x.findings[0].code == "unknown-command"


@pytest.mark.fact("CIRCUIT-UART-4")
def test_a_sender_that_is_too_slow_makes_framing_errors():
    bench = slewline.Bench()
    uart = bench.part("uart", baud=9600)
    pc = bench.part("serial_sender", "pc", to="uart", baud=8400)
    pc.send(b"\x00")
    bench.run_until_idle()
    assert [found.code for found in uart.findings] == ["uart-framing"]
    assert bench.pin("uart.fe").level == 1


def test_a_spike_on_the_line_is_not_a_start_bit():
    bench = slewline.Bench()
    uart = bench.part("uart", baud=9600)
    bench.record("uart.dav")
    bench.run("1 ms")
    bench.pin("uart.rxd").pulse(0, "40 us")  # less than half a bit
    bench.run("5 ms")
    assert uart.idle
    assert len(bench.edges("uart.dav")[0]) == 0
    bench.pin("uart.rxd").pulse(0, "60 us")  # more than half a bit: a start bit, and FF behind it
    bench.run("5 ms")
    assert uart.held == 0xFF
    assert len(bench.edges("uart.dav")[0]) == 1


def test_a_character_that_nobody_takes_is_overrun_by_the_next():
    bench = slewline.Bench()
    uart = bench.part("uart")
    pc = bench.part("serial_sender", "pc", to="uart")
    pc.send("AB")
    bench.run_until_idle()
    assert [found.code for found in uart.findings] == ["uart-overrun"]
    assert (uart.held, bench.pin("uart.oe").level, bench.pin("uart.dav").level) == (0x42, 1, 1)


def test_a_text_that_is_not_ascii_is_refused():
    bench = slewline.Bench()
    pc = bench.part("serial_sender", "pc")
    with pytest.raises(slewline.UsageError, match=r"pc: 'ü' at character 2 is not ASCII"):
        pc.send("Rü")
    with pytest.raises(slewline.UsageError, match="a list of numbers 0 to 255"):
        pc.send([256])


# ------------------------------------------------------------------------------------------------- what the link loses
MOVE = "A 0\rR 30\rF 30\rS 255\rZ 1\rN 30\rG\r"  # 30 steps, 10 ms


@pytest.mark.fact("UND-UART-MOTION", "DER-UART-LOSS")
def test_characters_that_are_complete_in_a_motion_are_lost_and_change_nothing(circuit):
    c = uart_on(circuit, "x.io_request", "x.ready")
    c.pc.send(MOVE)
    c.pc.pause("1 ms")
    c.pc.send("C\r")
    c.finish()
    assert c.codes("uart") == ["uart-lost", "uart-lost"]
    assert [found.text.split()[0] for found in c.uart.findings] == ["0x43", "0x0d"]
    assert c.level("x.programmable_output") == 1
    assert c.x.position == 30  # a request in a normal motion would have halted it
    assert c.codes("x") == []
    assert len(c.falls("x.io_request")) == len(MOVE)


@pytest.mark.fact("UND-UART-MOTION")
def test_a_character_in_a_continuous_motion_is_not_a_rate_request(circuit):
    c = uart_on(circuit, rate=10, firstrate=10, slope=255, divisor=1, position=0)
    c.pc.send("N 1000\rH\rG\r")
    c.settle()
    c.bench.run_until(c.x.pin("slew").is_(0))
    c.pc.send([80])
    c.bench.run("100 ms")
    assert c.codes("uart") == ["uart-lost"]
    times = c.x.steps("80 ms").times_ps
    assert set((times[1:] - times[:-1]).tolist()) == {10**9}  # rate 10: 1000 steps/s


@pytest.mark.fact("UND-UART-MOTION")
def test_a_host_that_waits_for_the_motion_loses_nothing(circuit):
    c = uart_on(circuit)
    c.pc.send(MOVE)
    c.pc.pause("20 ms")
    c.pc.send("C\r")
    c.finish()
    assert c.bench.findings == []
    assert c.level("x.programmable_output") == 0


@pytest.mark.fact("UND-UART-MOTION", "DER-UART-LOSS")
def test_a_character_that_is_complete_while_ready_is_low_leaves_no_request(circuit):
    c = uart_on(circuit)
    c.settle()
    c.bench.run("1 us")
    c.pc.send("D 5\r")
    c.bench.run_until(c.x.pin("ready").is_(0))
    c.bench.run_until(lambda: c.pc.idle)
    c.pc.send("C")
    c.bench.run("2 ms")
    assert c.codes("uart") == ["uart-lost"]
    c.bench.run_until_idle()
    c.bench.run("10 ms")
    assert c.level("uart.dav") == 0
    assert c.x.waiting.startswith("x: waiting for a command")  # not the C


@pytest.mark.fact("DER-UART-LOSS")
@pytest.mark.parametrize(("baud", "lost"), [(9600, []), (19200, ["uart-lost"])])
def test_at_6_mhz_the_terminator_of_a_command_outlasts_a_character_of_19200_baud(circuit, baud, lost):
    c = uart_on(circuit, baud=baud, crystal="6 MHz")
    c.pc.send("A 5\rC\r")
    c.finish()
    assert c.codes("uart")[:1] == lost
    assert c.x.position == 5
    assert c.level("x.programmable_output") == (1 if lost else 0)


def test_a_gap_after_each_character_makes_any_rate_safe(circuit):
    c = circuit(crystal="6 MHz")
    c.part("uart", to="x", baud=76800)
    pc = c.part("serial_sender", "pc", to="uart", baud=76800, gap="2 ms")
    pc.send("A 12345\rC\r")
    c.finish()
    assert c.bench.findings == []
    assert (c.x.position, c.level("x.programmable_output")) == (12345, 0)


@pytest.mark.parametrize("seed", range(5))
def test_the_order_of_tasks_in_an_instant_does_not_matter_to_the_uart(circuit, seed):
    runs = []
    for shuffle in (None, seed):
        c = uart_on(circuit, "x.io_request", "x.pulse", rate=30, firstrate=30, slope=255, divisor=1, shuffle=shuffle)
        c.pc.send("A 0\rN 5\rG\rC\rB\rP 0\rC\r")
        c.finish()
        runs.append((c.edges("x.io_request"), c.edges("x.pulse"), [str(found) for found in c.bench.findings]))
    assert runs[0] == runs[1]
    assert runs[0][2]
