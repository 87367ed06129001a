"""The two-line handshake, wire by wire.  Clocks are crystal clocks, 11 to the microsecond at 11 MHz.

clock        0         165 176      286                       2057
I/O REQUEST  \\______________________________/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾
INSTROBE     ‾‾‾‾‾‾‾‾‾‾\\___/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾
READY        ‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\\________________________/‾‾‾
"""

from __future__ import annotations

import pytest

from slewline.chips.cy525.sheet import SHEET

US = 11  # clocks
STROBE, SAMPLE, BUSY, LETTER = 165, 176, 286, 2057
LEAD = 10 * US  # a motion sets its lines so long before its first step
EFFECT = 17 * US  # an effect shows so long before READY returns
LINES = ("io_request", "instrobe", "ready")
OUTPUTS = tuple(pin.name for pin in SHEET.pins if pin.reset is not None and pin.in_out in ("out", "both"))
READY_BACK = 180  # from MOTION COMPLETE low to READY high: 30 us at 6 MHz
KNOWN = {"rate": 10, "firstrate": 10, "slope": 250, "divisor": 1, "position": 0}
STEP = 11_000  # clocks of a step at rate 10


def after(h, pin, since):
    """Edges behind a clock, without those of that very clock."""
    return [(clock, level) for clock, level in h.edges(pin, since) if clock > 0]


def mistakes(h):
    """Codes of the findings, without those about registers that only the options of the bench have set."""
    return [code for code in h.codes if code != "uninitialised"]


def lines(h, since=0):
    return [(clock - since, pin, level) for clock, pin, level in h.trace if clock >= since and pin in LINES]


# ---------------------------------------------------------------------------------------------------------- one byte


@pytest.mark.fact("HS-4", "UND-HS-WIDTH", "TIME-CHAR-1", "PIN-8", "PIN-27")
@pytest.mark.parametrize("crystal", ["11 MHz", "6 MHz", "3.579545 MHz", "1 MHz"])
def test_the_lines_of_one_byte_move_in_order(hand, crystal):
    h = hand(*LINES, crystal=crystal)
    h.strobe(1000, ord("E"), up=1300)
    h.run_to(6000)
    assert lines(h) == [
        (1000, "io_request", 0),
        (1000 + STROBE, "instrobe", 0),
        (1000 + SAMPLE, "instrobe", 1),
        (1000 + BUSY, "ready", 0),
        (1300, "io_request", 1),
        (1000 + LETTER, "ready", 1),
    ]
    assert h.codes == []


@pytest.mark.fact("HS-1", "CMD-C-1")
def test_a_command_goes_in_byte_by_byte(hand):
    h = hand("programmable_output", "ready")
    h.strobe(0, ord("C"), up=300)
    h.run_to(10_000)
    assert h.edges("programmable_output") == []
    h.strobe(10_000, 0x0D, up=10_300)
    h.run_to(20_000)
    # the carriage return of C takes what is left of 375 us
    assert h.rises("ready") == [LETTER, 10_000 + 375 * US - LETTER]
    assert h.edges("programmable_output") == [(10_000 + 375 * US - LETTER - EFFECT, 0)]


@pytest.mark.fact("HS-2", "HS-3", "HS-6", "CON-DATA-HOLD")
@pytest.mark.parametrize(
    ("comes", "goes", "taken"),
    [
        (0, 300, True),  # with the request: no set-up time
        (0, SAMPLE, True),  # gone exactly as INSTROBE rises
        (0, SAMPLE - 1, False),
        (STROBE, SAMPLE, True),  # only while INSTROBE is low
        (SAMPLE - 1, SAMPLE, True),
        (SAMPLE, 2000, False),  # comes exactly as INSTROBE rises: too late
        (SAMPLE + 1, 2000, False),
    ],
)
def test_the_bus_is_read_as_instrobe_rises(hand, comes, goes, taken):
    h = hand("programmable_output")
    h.put(1000, "io_request", 0)
    h.put(1300, "io_request", 1)
    h.data(1000 + comes, ord("C"))
    h.data(1000 + goes, None)
    h.run_to(4000)
    h.send("\r")
    assert h.x.pin("programmable_output").level == (0 if taken else 1)
    assert h.codes == ([] if taken else ["unknown-command"])  # an open bus reads FF


@pytest.mark.fact("HS-3")
def test_bus_changes_after_instrobe_have_no_effect(hand):
    h = hand()
    h.put(0, "io_request", 0)
    h.put(300, "io_request", 1)
    h.data(0, ord("B"))
    h.data(100, ord("C"))
    h.data(SAMPLE, ord("B"))
    h.run_to(4000)
    h.send("\r")
    assert h.x.pin("programmable_output").level == 0


@pytest.mark.fact("HS-6", "UND-HS-SHORT")
@pytest.mark.parametrize("up", [1, STROBE - 1, STROBE, SAMPLE - 1])
def test_a_byte_whose_request_ends_before_instrobe_is_lost(hand, up):
    h = hand(*LINES, "motion_complete")
    h.strobe(0, ord("C"), up=up)
    h.data(up, ord("C"))
    h.run_to(50_000)
    assert h.edges("ready") == []
    assert h.edges("instrobe") == [(STROBE, 0), (SAMPLE, 1)]
    assert h.codes == ["short-request"]
    h.send("C\r")
    assert h.x.pin("programmable_output").level == 0
    assert h.codes == ["short-request"]


@pytest.mark.fact("HS-6", "UND-HS-SHORT")
@pytest.mark.parametrize(
    ("up", "short"), [(SAMPLE, True), (SAMPLE + 1, True), (BUSY - 1, True), (BUSY, False), (BUSY + 1, False)]
)
def test_a_request_that_ends_between_instrobe_and_busy_counts_and_is_reported(hand, up, short):
    h = hand(*LINES)
    h.strobe(0, ord("C"), up=up)
    h.run_to(10_000)
    assert h.edges("ready") == [(BUSY, 0), (LETTER, 1)]
    h.send("\r")
    assert h.x.pin("programmable_output").level == 0
    assert h.codes == ["short-request"] * short


@pytest.mark.fact("HS-5", "PIN-27")
def test_ready_waits_for_the_request_to_end_however_long(hand):
    h = hand(*LINES)
    h.send("C")
    start = h.now
    h.strobe(start, 0x0D, up=start + 550_001)
    h.run_to(start + 549_000)
    assert h.x.waiting.startswith("x: waiting for io_request=1 (then READY rises) since ")
    assert h.x.pin("programmable_output").level == 0  # the effect does not wait
    h.run_to(start + 600_000)
    assert lines(h, start)[-2:] == [(550_001, "io_request", 1), (550_001, "ready", 1)]
    assert h.falls("instrobe", start) == [STROBE]  # one byte, taken once
    assert h.codes == []


@pytest.mark.fact("HS-5")
@pytest.mark.parametrize(("up", "ready"), [(LETTER - 1, LETTER), (LETTER, LETTER), (LETTER + 1, LETTER + 1)])
def test_ready_returns_with_the_later_of_processing_and_request(hand, up, ready):
    h = hand(*LINES)
    h.strobe(0, ord("C"), up=up)
    h.run_to(9000)
    assert h.rises("ready") == [ready]


@pytest.mark.fact("HS-7")
def test_the_bus_means_nothing_without_a_request(hand):
    h = hand(*OUTPUTS)
    for number, byte in enumerate(b"C\rB\rE\rX\r\x00\xff\x43"):
        h.data(100 * number, byte)
    h.run_to(100_000)
    assert h.trace == []
    assert h.x.idle
    assert h.codes == []


@pytest.mark.fact("HS-8")
def test_bit_seven_of_an_ascii_port_may_be_the_request(hand):
    h = hand("instrobe", "programmable_output")
    h.put(0, "db7", 0)  # grounded

    def port(byte):
        for bit in range(7):
            h.put(h.now, f"db{bit}", byte >> bit & 1)
        h.put(h.now, "io_request", byte >> 7)

    for character in b"C\r":
        h.until(ready=1)
        port(character & 0x7F)
        h.until(ready=0)
        port(0xFF)
    h.until(ready=1)
    assert h.x.pin("programmable_output").level == 0
    assert len(h.falls("instrobe")) == 2
    assert h.codes == []


@pytest.mark.fact("HS-16")
def test_one_routine_serves_ascii_and_binary(hand):
    ascii_, binary = hand("programmable_output"), hand("programmable_output", straps={"ascii_binary": 0})
    ascii_.send("C\rB\rR 100\rS 254\rF 3\rN 5\rG\r")
    binary.send(bytes.fromhex("43 00 42 00 52 01 64 53 01 FE 46 01 03 4E 02 05 00 47 00"))
    for h in (ascii_, binary):
        assert [level for _, level in h.edges("programmable_output")] == [0, 1]
        assert h.x.travel == 5
    assert ascii_.x.registers == binary.x.registers
    assert ascii_.x.registers | {"position": 0} == {
        "number": 5, "slope": 254, "rate": 100, "firstrate": 3, "divisor": 1, "position": 0,
    }  # fmt: skip


@pytest.mark.fact("HS-17", "PIN-DB", "PIN-33", "PIN-34")
def test_the_bring_up_by_hand(hand):
    h = hand(*OUTPUTS)

    def strobe(*ones):
        for bit in range(8):
            h.put(h.now, f"db{bit}", int(bit in ones))
        h.put(h.now, "io_request", 0)
        h.until(ready=0)
        h.put(h.now, "io_request", 1)
        h.until(ready=1)

    enter = (0, 2, 3)
    expected = dict.fromkeys(OUTPUTS, 1)
    for letter, pin, level in (
        ((0, 1, 6), "programmable_output", 0),  # C
        ((1, 6), "programmable_output", 1),  # B
        ((0, 2, 3, 5), "direction", 0),  # -
        ((0, 1, 3, 5), "direction", 1),  # +
    ):
        strobe(*letter)
        assert {name: h.x.pin(name).level for name in OUTPUTS} == expected
        strobe(*enter)
        expected[pin] = level
        assert {name: h.x.pin(name).level for name in OUTPUTS} == expected
    moved = {pin for _, pin, _ in h.trace}
    assert moved == {"ready", "instrobe", "programmable_output", "direction"}


# ------------------------------------------------------------------------------------------------------ host mistakes


@pytest.mark.fact("UND-HS-EARLY")
def test_a_request_while_ready_is_low_stays_pending(hand):
    h = hand(*LINES)
    h.strobe(0, ord("C"), up=300)
    h.strobe(1000, 0x0D, up=2057 + 1000)
    h.run_to(20_000)
    assert lines(h)[4:] == [
        (300, "io_request", 1),
        (1000, "io_request", 0),
        (LETTER, "ready", 1),
        (LETTER + STROBE, "instrobe", 0),
        (LETTER + SAMPLE, "instrobe", 1),
        (LETTER + BUSY, "ready", 0),
        (LETTER + 1000, "io_request", 1),
        (375 * US, "ready", 1),
    ]
    assert h.x.pin("programmable_output").level == 0
    assert h.codes == ["early-request"]


@pytest.mark.fact("UND-HS-EARLY")
@pytest.mark.parametrize("up", [1500, LETTER - 1])
def test_an_early_request_that_is_gone_when_ready_returns_is_not_seen(hand, up):
    h = hand(*LINES)
    h.strobe(0, ord("C"), up=300)
    h.strobe(1000, ord("B"), up=up)
    h.run_to(20_000)
    assert h.falls("instrobe") == [STROBE]
    h.send("\r")
    assert h.x.pin("programmable_output").level == 0


@pytest.mark.fact("HS-14", "UND-HS-IOSEL")
def test_io_select_changed_while_busy_counts_at_the_next_ready(hand):
    h = hand(*LINES, "outstrobe")
    h.strobe(0, ord("C"), up=300)
    h.put(1000, "io_select", 1)
    h.run_to(5000)
    assert h.edges("ready") == [(BUSY, 0), (LETTER, 1)]
    assert h.codes == ["select-while-busy"]
    h.put(6000, "io_request", 0)
    h.run_to(6400)
    assert h.falls("outstrobe") == [6000 + STROBE]  # the chip writes now
    assert h.falls("instrobe") == [STROBE]


@pytest.mark.fact("HS-14")
def test_io_select_may_change_while_ready_is_high_and_while_stepping(hand):
    h = hand(**KNOWN, number=3)
    h.put(100, "io_select", 1)
    h.put(200, "io_select", 0)
    h.run_to(1000)
    assert h.codes == []
    h.send("G")
    h.strobe(h.now, 0x0D, up=h.now + 400)
    h.run(10_000)
    assert h.x.travel == 1
    h.put(h.now, "io_select", 1)
    h.run(STEP)
    h.put(h.now, "io_select", 0)
    h.run(5 * STEP)
    assert h.x.travel == 3
    assert "select-while-busy" not in h.codes


@pytest.mark.fact("UND-HS-MODE")
def test_the_mode_is_read_with_the_command_letter(hand):
    h = hand()
    h.send("R")
    h.put(h.now, "ascii_binary", 0)
    h.send(" 33\r")
    assert h.x.registers["rate"] == 33
    h.send(b"R")
    h.put(h.now, "ascii_binary", 1)
    h.send(b"\x01\x40")
    assert h.x.registers["rate"] == 64
    assert h.codes == []


@pytest.mark.fact("UND-HS-MODE")
@pytest.mark.parametrize(("clock", "binary"), [(SAMPLE - 1, True), (SAMPLE, False)])
def test_the_mode_is_read_at_the_same_instant_as_the_bus(hand, clock, binary):
    h = hand()
    h.put(1000 + clock, "ascii_binary", 0)
    h.strobe(1000, ord("C"), up=1400)
    h.run_to(4000)
    h.put(h.now, "ascii_binary", 1)
    h.send(b"\x00" if binary else b"\r")
    assert h.x.pin("programmable_output").level == 0
    assert h.codes == []


# ----------------------------------------------------------------------------------------------------- READY and motion


@pytest.mark.fact("HS-11", "HS-15", "PIN-27", "MC-1", "CON-DEFAULT-XTAL")
@pytest.mark.parametrize("crystal", ["11 MHz", "6 MHz"])
def test_ready_stays_low_through_the_whole_motion(hand, crystal):
    h = hand("ready", "pulse", "motion_complete", crystal=crystal, number=4, **KNOWN)
    h.send("G")
    start = h.now
    h.strobe(start, 0x0D, up=start + 400)
    h.run(10 * STEP)
    begin = 660 * US - LETTER  # the time of G from its letter to the first step
    assert h.falls("pulse", start) == [begin + n * STEP for n in range(4)]
    end = begin + 4 * STEP
    assert h.edges("motion_complete", start) == [(end, 0)]
    assert after(h, "ready", start) == [(BUSY, 0), (end + READY_BACK, 1)]
    # 30 us at 6 MHz
    assert (h.x.clock.ps(start + end + READY_BACK) - h.x.clock.ps(start + end)) // 1_000_000 == (
        30 if crystal == "6 MHz" else 16
    )


@pytest.mark.fact("HS-12", "UND-HS-RUN-READY", "CON-READY-RUN", "PIN-27")
def test_in_a_program_ready_is_low_for_each_motion_and_high_between(hand):
    h = hand("ready", "pulse", "run", "motion_complete", number=2, **KNOWN)
    h.send("E\rG\rD 50\rG\r0\rQX\r")
    start = h.falls("run")[-1]
    h.run_to(start + 60 * 11_000 + 4 * STEP)
    first = 60 * US
    second = first + 2 * STEP + READY_BACK + 40 * US + 50 * 11_000 + 40 * US
    assert h.falls("pulse", start) == [first, first + STEP, second, second + STEP]
    assert h.edges("motion_complete", start) == [(first + 2 * STEP, 0), (second - LEAD, 1), (second + 2 * STEP, 0)]
    low = [edge for begin in (first, second) for edge in ((begin - LEAD, 0), (begin + 2 * STEP + READY_BACK, 1))]
    accepted = [(EFFECT, 1)]  # READY returns behind the terminator of X, after RUN has fallen
    assert h.edges("ready", start) == accepted + low
    assert h.rises("run", start) == [second + 2 * STEP + READY_BACK + 36 * US]


@pytest.mark.fact("HS-13")
@pytest.mark.parametrize("up", [1_100_000, 1_100_001])
def test_no_step_begins_before_the_request_is_over(hand, up):
    h = hand("pulse", "ready", "direction", "instrobe", number=3, **KNOWN)
    h.send("-\rG")
    start = h.now
    h.strobe(start, 0x0D, up=start + up)
    h.run_to(start + up - 10)
    assert h.x.waiting.startswith("x: waiting for io_request=1 before the first step (G) since ")
    h.run_to(start + up + 10 * STEP)
    assert h.falls("pulse", start) == [up + 1 + n * STEP for n in range(3)]  # looked at with every clock
    assert h.falls("instrobe", start) == [STROBE]  # nor is it a rate request
    assert h.x.travel == -3
    assert mistakes(h) == []


@pytest.mark.fact("HS-13", "UND-STEP-LEAD")
@pytest.mark.parametrize(("up", "late"), [(-1, 0), (0, 1), (1, 2)])
def test_a_request_that_ended_in_time_delays_nothing(hand, up, late):
    h = hand("pulse", number=1, **KNOWN)
    h.send("G")
    start, begin = h.now, 660 * US - LETTER
    h.strobe(start, 0x0D, up=start + begin + up)
    h.run(3 * STEP)
    assert h.falls("pulse", start) == [begin + late]


# --------------------------------------------------------------------------------------------------- running programs


@pytest.mark.fact("UND-HS-RUN", "LIVE-10")
def test_a_request_to_a_running_program_is_not_answered_and_holds_the_next_motion(hand):
    h = hand("instrobe", "ready", "pulse", "run", number=2, **KNOWN)
    h.send("E\rD 10\rG\rB\r0\rQC\rX\r")
    start = h.falls("run")[-1]
    h.put(start + 5000, "io_request", 0)
    h.data(start + 5000, ord("B"))
    h.put(start + 300_000, "io_request", 1)
    h.run_to(start + 299_000)
    due = 60 * US + 10 * 11_000 + 40 * US  # G would step here
    assert h.edges("ready", start + EFFECT + 1) == [(due - LEAD - EFFECT - 1, 0)]
    assert h.x.waiting.startswith("x: waiting for io_request=1 before the first step (G) since ")
    assert mistakes(h) == ["request-while-running"]
    h.run_to(start + 300_000 + 5 * STEP)
    assert h.falls("pulse", start) == [300_001, 300_001 + STEP]
    assert h.edges("instrobe", start) == []
    assert h.x.pin("run").level == 1


@pytest.mark.fact("UND-HS-RUN", "UND-UW-BYTE", "PIN-1")
@pytest.mark.parametrize(("letter", "level"), [("U", 1), ("W", 0)])
def test_a_request_ends_a_waiting_instruction_and_transfers_nothing(hand, letter, level):
    h = hand("instrobe", "ready", "programmable_output", "run", straps={"wait": level})
    h.send(f"E\r{letter}\rB\rD 1\r0\rQC\rX\r")
    start = h.falls("run")[-1]
    h.run_to(start + 100_000)
    assert h.x.waiting.startswith(f"x: waiting for wait={1 - level} ({letter}) since ")
    h.data(start + 100_000, ord("C"))
    h.put(start + 100_000, "io_request", 0)
    h.run_to(start + 200_000)
    look = -(-(100_001 - 60 * US) // (8 * US)) * 8 * US + 60 * US  # WAIT is looked at every 8 us
    assert h.edges("programmable_output", start) == [(look + 40 * US, 1)]
    assert h.edges("instrobe", start + EFFECT) == []
    assert h.x.pin("run").level == 1  # the program is over, but this request brings no byte
    assert h.edges("ready", start + EFFECT + 1) == []
    assert h.x.waiting.startswith("x: waiting for io_request=1 (its low ended a wait) since ")
    h.put(h.now, "io_request", 1)
    h.send("C\r")
    assert h.x.pin("programmable_output").level == 0
    assert h.codes == []
