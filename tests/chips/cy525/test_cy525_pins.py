"""The forty pins: what each one is, what it reads when it is left open, and what the outputs say."""

from __future__ import annotations

from itertools import pairwise

import pytest

import slewline
from slewline.chips.cy525.sheet import SHEET
from slewline.errors import UnknownName, UsageError, WiringError

US, MS = 11, 11_000
SAMPLE, BUSY, LETTER = 176, 286, 2057
STEP, HIGH = 11_000, 28  # a step at rate 10, and how long PULSE is high at its end
LEAD = 10 * US  # a motion sets its lines so long before its first step
KNOWN = {"rate": 10, "firstrate": 10, "slope": 250, "divisor": 1, "position": 0}
OUTPUTS = tuple(pin.name for pin in SHEET.pins if pin.reset is not None and pin.in_out in ("out", "both"))
SIGNALS = {
    1: "io_request", 4: "reset", 6: "abort", 8: "instrobe", 10: "outstrobe", 11: "clk15",
    **{12 + bit: f"db{bit}" for bit in range(8)}, **{20 + n: f"phase{n}" for n in (1, 2, 3, 4)},
    27: "ready", 28: "dowhile", 29: "slew", 30: "step_inhibit", 31: "prog", 32: "run", 33: "direction",
    34: "programmable_output", 35: "pulse", 36: "ascii_binary", 37: "motion_complete", 38: "wait", 39: "io_select",
}  # fmt: skip
MUTE = {2: "xtal1", 3: "xtal2", 5: "nc5", 7: "vss7", 9: "nc9", 20: "vss20", 25: "nc25", 26: "vdd", 40: "vcc"}
OPEN_LOW = {1: "io_request", 6: "abort", 39: "io_select"}
PULLED_UP = {4: "reset", 28: "dowhile", 30: "step_inhibit", 31: "prog", 36: "ascii_binary", 38: "wait"}


def mistakes(h):
    return [code for code in h.codes if code != "uninitialised"]


# ----------------------------------------------------------------------------------------------------------- wiring


@pytest.mark.fact("PIN-SUPPLY", "PIN-1", "PIN-4", "PIN-39")
def test_the_pins_have_the_numbers_of_the_package():
    assert {pin.number: pin.name for pin in SHEET.pins} == SIGNALS | MUTE
    assert sorted(pin.number for pin in SHEET.pins) == list(range(1, 41))


@pytest.mark.fact("PIN-SUPPLY")
@pytest.mark.parametrize("name", MUTE.values())
def test_supply_crystal_and_unconnected_pins_carry_no_signal(name):
    bench = slewline.Bench()
    x, y = bench.add("cy525", name="x"), bench.add("cy525", name="y")
    assert x.pin(name).level is None
    number = next(number for number, found in MUTE.items() if found == name)
    with pytest.raises(WiringError, match=rf"x\.{name} \(pin {number}: .*carries no signal"):
        x.pin(name).drive(0)
    for a, b in ((f"x.{name}", "y.wait"), ("y.wait", f"x.{name}")):
        with pytest.raises(WiringError, match="carries no signal; leave it unconnected"):
            bench.wire(a, b)
    with pytest.raises(WiringError):
        bench.record(f"x.{name}")
    assert y.pin("wait").level == 1


def test_an_unknown_pin_is_answered_with_the_existing_pins():
    bench = slewline.Bench()
    bench.add("cy525", name="x")
    with pytest.raises(
        UnknownName, match=r"x .cy525. has no pin 'strobe'; its pins: io_request, reset, abort, instrobe"
    ):
        bench.pin("x.strobe")


@pytest.mark.fact("PIN-PULLUP", "UND-PIN-OPEN", "PIN-6")
def test_a_bare_chip_reads_its_pull_ups_high_and_reports_the_three_pins_without():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x", bare=True)
    assert {name: x.pin(name).level for name in PULLED_UP.values()} == dict.fromkeys(PULLED_UP.values(), 1)
    assert {name: x.pin(name).level for name in OPEN_LOW.values()} == dict.fromkeys(OPEN_LOW.values(), 0)
    assert x.findings == []
    bench.run("1 us")
    assert [(found.code, found.time_ps) for found in x.findings] == [("open-pin", 0)] * 3
    for (number, name), found in zip(OPEN_LOW.items(), x.findings, strict=True):
        assert found.text == f"pin {number} ({name}) is open and has no pull-up: it reads low"


@pytest.mark.fact("PIN-PULLUP", "UND-PIN-OPEN")
@pytest.mark.parametrize("left_open", OPEN_LOW.values())
def test_only_what_is_left_open_is_reported(left_open):
    bench = slewline.Bench()
    x = bench.add("cy525", name="x", bare=True)
    for name, level in (("io_request", 1), ("abort", 1), ("io_select", 0)):
        if name != left_open:
            x.pin(name).drive(level)
    bench.run("1 ms")
    assert [found.text.split("(")[1].split(")")[0] for found in x.findings if found.code == "open-pin"] == [left_open]


def test_the_standard_wiring_needs_nothing(hand):
    h = hand()
    h.run(1000)
    assert {name: h.x.pin(name).level for name in ("io_request", "abort", "io_select", "step_inhibit")} == {
        "io_request": 1, "abort": 1, "io_select": 0, "step_inhibit": 0,
    }  # fmt: skip
    assert h.codes == []


def bare(hand, *watched, **options):
    """A bare chip with the three pins driven that have no pull-up."""
    h = hand(*watched, bare=True, **options)
    for name, level in (("io_request", 1), ("abort", 1), ("io_select", 0)):
        h.put(0, name, level)
    return h


@pytest.mark.fact("PIN-30", "PIN-PULLUP")
def test_an_open_step_inhibit_holds_every_motion(hand):
    h = bare(hand, "pulse", "ready", number=2, **KNOWN)
    h.send("G")
    start = h.now
    h.strobe(start, 0x0D, up=start + 400)
    h.run(11_000_000)
    assert h.edges("pulse") == []
    assert h.x.pin("ready").level == 0
    assert h.x.waiting.startswith("x: G held by step_inhibit=1 since ")
    low = h.now
    h.put(low, "step_inhibit", 0)
    h.run(5 * STEP)
    assert len(h.falls("pulse")) == 2
    assert h.falls("pulse")[0] - low <= 33  # looked at every 3 us
    assert mistakes(h) == []


@pytest.mark.fact("PIN-6", "UND-PIN-OPEN")
def test_an_open_abort_is_found_at_the_start(hand):
    h = hand("pulse", bare=True, number=2, **KNOWN)
    h.put(0, "io_request", 1)
    h.put(0, "io_select", 0)
    h.put(0, "step_inhibit", 0)
    h.send("G\r")
    assert h.x.travel == 2  # ABORT low from the start is disabled, as for a limit switch
    assert mistakes(h) == ["open-pin"]


@pytest.mark.fact("PIN-36", "PIN-PULLUP")
def test_an_open_mode_pin_means_ascii(hand):
    h = bare(hand)
    h.send("R 33\r")
    assert h.x.registers["rate"] == 33
    h.put(h.now, "ascii_binary", 0)
    h.send(b"R\x01\x0d")
    assert h.x.registers["rate"] == 13
    assert h.codes == []


@pytest.mark.fact("PIN-38", "PIN-28", "PIN-PULLUP")
def test_open_wait_and_dowhile_read_high(hand):
    h = bare(hand, "run", "programmable_output")
    h.send("E\rW\rC\rT 0\rU\r0\rQX\r")
    h.run(1_000_000)
    assert h.x.pin("programmable_output").level == 0  # W passed, T did not branch
    assert h.x.waiting.startswith("x: waiting for wait=0 (U) since ")
    h.put(h.now, "wait", 0)
    h.run(10_000)
    assert h.x.pin("run").level == 1


@pytest.mark.fact("PIN-28")
def test_dowhile_low_branches(hand):
    h = hand("programmable_output", straps={"dowhile": 0})
    h.send("E\rB\rC\rT 0\r0\rQX\r")
    h.run(10_000)
    assert len(h.edges("programmable_output")) > 10


@pytest.mark.fact("PIN-DC")
def test_levels_are_logic_and_volts_only_a_note(hand):
    assert set(SHEET.notes) == {"input levels", "output levels", "supply", "limits"}
    for text, numbers in (
        ("input levels", "2.0 3.8 0.8 0.6"),
        ("output levels", "2.4 40 0.45 1.6 10"),
        ("supply", "5 10 100 1.5"),
        ("limits", "-0.5 7 0 70"),
    ):
        assert all(number in SHEET.notes[text] for number in numbers.split())
    h = hand(number=3, **KNOWN)
    seen = set()
    for name in SIGNALS.values():
        h.x.pin(name).net.watch(lambda net, name=name: seen.add(h.x.pin(name).level))
    h.send("V 3\r")
    h.put(h.now, "io_select", 1)
    h.fetch(6)
    h.put(h.now, "io_select", 0)
    h.send("G\r")
    assert seen == {0, 1, None}
    with pytest.raises(UsageError, match=r"level 0\.8; allowed 0, 1"):
        h.x.pin("abort").drive(0.8)


@pytest.mark.fact("PIN-POS-LOGIC", "PIN-DB")
def test_a_high_wire_is_a_one(hand):
    h = hand(number=0x4180)
    h.send("V 3\r")
    h.put(h.now, "io_select", 1)
    for byte in (0x41, 0x80):
        h.put(h.now, "io_request", 0)
        h.until(ready=0)
        assert [h.x.pin(f"db{bit}").level for bit in range(8)] == [byte >> bit & 1 for bit in range(8)]
        h.put(h.now, "io_request", 1)
        h.until(ready=1)


@pytest.mark.fact("PIN-DB")
def test_the_chip_drives_the_bus_only_to_hand_bytes_out(hand):
    h = hand(number=2, **KNOWN)
    driven = []
    h.x.bus.watch(lambda bus: driven.append(bus.level))
    data = "C\rR 10\rN 2\rG\rE\rG\rD 2\rB\r0\rQX\rO 2\rI\rV 3\r"
    h.send(data)
    h.run(20 * STEP)
    h.x.reset()
    h.run(1000)
    whole = [level[1] for level in driven if level is not None and level[0] == 0xFF]
    assert bytes(whole) == data.encode()  # nothing but what the host put there
    assert driven[-1] is None


# ---------------------------------------------------------------------------------------------------------- outputs


@pytest.mark.fact("PIN-8")
def test_instrobe_pulses_once_for_every_byte_that_is_taken(hand):
    h = hand("instrobe", number=64_000, **KNOWN)
    data = "C\rK\r\r\nE\rB\rQ" + "N 64000\r"
    h.send(data)
    assert len(h.falls("instrobe")) == len(data)
    h.send("H\rG")
    h.strobe(h.now, 0x0D, up=h.now + 400)
    h.run(10 * STEP)
    assert len(h.falls("instrobe")) == len(data) + 4
    h.strobe(h.now, 20, up=h.now + 20_000)  # a rate on the fly is a byte as well
    h.run(5 * STEP)
    assert len(h.falls("instrobe")) == len(data) + 5
    assert [level for _, level in h.edges("instrobe")][-1] == 1


@pytest.mark.fact("PIN-10", "MC-2", "PIN-37", "PIN-39")
def test_outstrobe_pulses_twice_for_a_verify_byte_and_twice_for_a_position(hand):
    h = hand("outstrobe", "motion_complete", "ready", number=5, **KNOWN)
    h.send("V 3\r")
    h.put(h.now, "io_select", 1)
    h.fetch(3)
    assert len(h.falls("outstrobe")) == 6
    h.put(h.now, "io_select", 0)
    h.send("G")
    h.strobe(h.now, 0x0D, up=h.now + 400)
    h.run(STEP)
    start = h.now
    h.put(start, "io_select", 1)
    h.run(STEP)
    h.put(h.now, "io_select", 0)
    h.run(5 * STEP)
    first, second = h.falls("outstrobe", start)
    assert second - first == 10 * US
    (fall, rise) = h.edges("motion_complete", start)[:2]
    # low, with OUTSTROBE activity: the low byte is on the bus
    assert (fall[1], rise[1]) == (0, 1)
    assert first < fall[0] < second < rise[0] == fall[0] + 10 * US


@pytest.mark.fact("PIN-11", "CON-OUTPUTS-HIGH")
@pytest.mark.parametrize(("crystal", "hz"), [("6 MHz", 400_000), ("11 MHz", 733_333), ("3.579545 MHz", 238_636)])
def test_clk15_is_the_crystal_divided_by_fifteen(hand, crystal, hz):
    h = hand("clk15", crystal=crystal)
    h.send("C\r")
    h.run(1000)
    clocks = [clock for clock, _ in h.edges("clk15")]
    falls = h.falls("clk15")
    assert all(b - a == 15 for a, b in pairwise(falls))
    low = {b - a for a, b in pairwise(clocks)}
    assert low == {5, 10}
    assert h.x.clock.ps(5) >= 300_000
    assert (len(falls) - 1) * 10**12 // (h.x.clock.ps(falls[-1]) - h.x.clock.ps(falls[0])) == hz


@pytest.mark.fact("PIN-11", "CON-OUTPUTS-HIGH", "RESET-3")
def test_clk15_runs_on_through_a_reset(hand):
    h = hand("clk15")
    h.put(1003, "reset", 0)
    h.put(1303, "reset", None)
    h.run_to(3000)
    assert h.edges("clk15", 1) == [
        (clock - 1, level) for clock in range(1, 3001) for at, level in ((0, 0), (5, 1)) if clock % 15 == at
    ]


@pytest.mark.fact("PIN-PHASE")
def test_phases_are_off_after_reset_and_two_are_low_after_every_step(hand):
    phases = ("phase1", "phase2", "phase3", "phase4")
    h = hand("pulse", *phases, number=6, **KNOWN)
    assert [h.x.pin(name).level for name in phases] == [1, 1, 1, 1]
    h.send("G\r")
    start = h.falls("pulse")[0]
    levels = dict.fromkeys(phases, 1)
    seen = []
    for clock in h.falls("pulse"):
        levels |= {pin: level for when, pin, level in h.trace if when == clock and pin in phases}
        seen.append(tuple(levels.values()))
    assert all(sum(pattern) == 2 for pattern in seen)
    assert len(set(seen)) == 4
    assert {clock for clock, pin, _ in h.trace if pin in phases} == set(h.falls("pulse"))
    assert start > 0


@pytest.mark.fact("PIN-29")
def test_slew_is_low_while_the_rate_is_steady_and_high_at_rest(hand):
    h = hand("slew", "pulse", number=300, **KNOWN)
    assert h.x.pin("slew").level == 1
    h.send("G\r")
    begins = h.falls("pulse")
    assert h.edges("slew") == [(begins[0], 0), (begins[0] + 300 * STEP, 1)]


@pytest.mark.fact("PIN-32")
def test_run_is_low_for_the_whole_program(hand):
    h = hand("run", "programmable_output")
    h.send("E\rC\rD 3\rB\r0\rQ")
    assert h.edges("run") == []
    h.send("X\r")
    h.run(100_000)
    (fall, rise), (low, high) = (
        [clock for clock, _ in h.edges("run")],
        [clock for clock, _ in h.edges("programmable_output")],
    )
    assert fall < low < high < rise


@pytest.mark.fact("PIN-33", "EXAMPLE-7.9")
@pytest.mark.parametrize("crystal", ["6 MHz", "11 MHz"])
def test_direction_follows_p_plus_and_minus(hand, crystal):
    h = hand("direction", "pulse", crystal=crystal, number=2, **KNOWN)
    assert h.x.pin("direction").level == 1
    seen = []
    for line in ("P 2", "P 0", "+", "G", "-", "G"):
        h.send(line + "\r")
        if line[0] in "PG":
            seen.append(h.x.pin("direction").level)
    assert seen == [1, 0, 1, 0]
    assert h.x.travel == 0
    begins = h.falls("pulse")[::2]  # of the four motions
    shown = h.edges("direction")  # P 0, then + and - by themselves
    assert [level for _, level in shown] == [0, 1, 0]
    assert shown[0][0] == begins[1] - LEAD  # just before the first step
    assert begins[1] + 2 * STEP < shown[1][0] < begins[2] - LEAD < begins[2] + 2 * STEP < shown[2][0] < begins[3] - LEAD


@pytest.mark.fact("PIN-34")
@pytest.mark.parametrize("level", [0, 1])
def test_only_b_and_c_move_the_programmable_output(hand, level):
    h = hand("programmable_output", "run", number=1, **KNOWN)
    assert h.x.pin("programmable_output").level == 1
    h.send("CB"[level] + "\r")
    since = h.now
    for line in (
        "A 5", "D 1", "F 10", "G", "H", "I", "N 2", "O 2", "O 200", "P 7", "R 10", "S 9", "T 0", "V 0", "W", "Z 1",
        "+", "-", "0", "L 1,0", "E", "0",
    ):  # fmt: skip
        h.send(line + "\r")
    h.send("QX\r")
    h.run(10_000)
    h.put(h.now, "wait", 0)
    h.send("U\r")
    h.send("J 0\r")
    h.run(10_000)
    assert h.x.pin("programmable_output").level == level
    assert h.edges("programmable_output", since + 1) == []


@pytest.mark.fact("PIN-35", "CON-PULSE-HIGH", "STEP-1")
def test_pulse_is_low_for_each_step_and_high_for_2_5_us_between_two(hand):
    h = hand("pulse", number=5, **KNOWN)
    assert h.x.pin("pulse").level == 1
    h.send("G\r")
    begin = h.falls("pulse")[0]
    assert h.edges("pulse", begin) == [edge for n in range(5) for edge in ((n * STEP, 0), ((n + 1) * STEP - HIGH, 1))]
    assert 2_500_000 <= h.x.clock.ps(HIGH) < 2_600_000


# ----------------------------------------------------------------------------------------------------- motion complete


@pytest.mark.fact("MC-1", "PIN-37", "CON-MC-CODE")
@pytest.mark.parametrize("byte", [ord("C"), 0x0D, 0xFF])
def test_motion_complete_falls_after_the_last_step_and_rises_with_the_next_byte(hand, byte):
    h = hand("motion_complete", "pulse", number=5, **KNOWN)
    assert h.x.pin("motion_complete").level == 1
    h.send("G\r")
    assert h.falls("motion_complete") == [h.rises("pulse")[-1] + HIGH]
    h.run(11_000_000)
    assert h.x.pin("motion_complete").level == 0
    start = h.now
    h.strobe(start, byte, up=start + 400)
    h.run(5000)
    assert h.edges("motion_complete", start) == [(SAMPLE, 1)]


@pytest.mark.fact("UND-MC-PROGRAM")
def test_between_two_motions_of_a_program_motion_complete_rises_with_the_second(hand):
    h = hand("motion_complete", "pulse", number=2, **KNOWN)
    h.send("E\rG\rB\rD 5\rG\r0\rQX\r")
    h.run(20 * STEP)
    begins = h.falls("pulse")
    assert h.edges("motion_complete") == [(begins[1] + STEP, 0), (begins[2] - LEAD, 1), (begins[3] + STEP, 0)]


@pytest.mark.fact("UND-MC-PROGRAM", "MC-1")
def test_a_live_byte_between_two_motions_raises_motion_complete(hand):
    h = hand("motion_complete", "pulse", number=2, **KNOWN)
    h.send("E\rG\rD 50\rG\r0\rQX\r")
    h.run(4 * STEP)
    assert h.x.pin("motion_complete").level == 0
    h.put(h.now, "prog", 0)
    h.run(60 * MS)
    start = h.now
    h.strobe(start, ord("B"), up=start + 400)
    h.run(3000)
    assert h.edges("motion_complete", start) == [(SAMPLE, 1)]


@pytest.mark.fact("MC-2", "PIN-37")
def test_motion_complete_is_low_in_three_distinguishable_situations(hand):
    h = hand("motion_complete", "ready", "slew", "outstrobe", "pulse", number=64_000, **KNOWN)
    h.send("H\rG")
    h.strobe(h.now, 0x0D, up=h.now + 400)
    h.run(10 * STEP)
    # the low byte of a position: OUTSTROBE moves meanwhile
    since = h.now
    h.put(since, "io_select", 1)
    h.run(STEP)
    h.put(h.now, "io_select", 0)
    h.run(STEP)
    (fall, _), (rise, _) = h.edges("motion_complete", since)
    assert any(fall < clock < rise for clock in h.falls("outstrobe", since))
    assert h.edges("ready", since) == []
    # rate zero: SLEW low, READY low, no PULSE
    h.strobe(h.now, 0, up=h.now + 2 * STEP)
    h.run(20 * STEP)
    begins = len(h.falls("pulse"))
    h.run(100 * STEP)
    assert [h.x.pin(name).level for name in ("motion_complete", "slew", "ready", "pulse")] == [0, 0, 0, 1]
    assert len(h.falls("pulse")) == begins
    # over: READY goes high
    h.put(h.now, "abort", 0)
    h.run(5000)
    assert [h.x.pin(name).level for name in ("motion_complete", "slew", "ready")] == [0, 1, 1]
