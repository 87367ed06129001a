"""CY525 commands as a host gives them: what each one does, and what becomes of what a host gets wrong."""

from __future__ import annotations

from itertools import pairwise

import pytest

from slewline.chips.cy525.instructions import Instructions
from slewline.chips.cy525.sheet import SHEET

US = 1_000_000  # picoseconds
MS, S = 1000 * US, 1_000_000 * US
KNOWN = "A 0\rN 3\rS 250\rR 10\rF 3\rZ 1\r"  # every register set, so that a motion has nothing to complain about
QUICK = "F 3\rR 10\rS 255\rZ 1\r"  # slews after a few steps
LEGAL = {
    "A": "A 1", "D": "D 1", "F": "F 3", "J": "J 0", "L": "L 1,0", "N": "N 3", "O": "O 2", "P": "P 5", "R": "R 10",
    "S": "S 9", "T": "T 0", "V": "V 0", "Z": "Z 2", "U": "U",
}  # fmt: skip
OUTPUTS = tuple(pin.name for pin in SHEET.pins if pin.reset is not None and pin.in_out in ("out", "both"))


# ------------------------------------------------------------------------------------------------ the language at large
@pytest.mark.fact("LANG-SET-1", "CON-INSTR-COUNT")
def test_rows_and_handlers_match_one_to_one():
    handlers = {name for name in dir(Instructions) if name.startswith("do_")}
    assert {row.handler for row in SHEET.commands} == handlers
    assert [row.form for row in SHEET.commands] == list("ABCDEFGHIJLNOPQRSTUVWXZ+-0")
    assert SHEET.labels == "ABCDE"


@pytest.mark.fact("LANG-SET-1")
@pytest.mark.parametrize("letter", "ABCDEFGHIJLNOPRSTUVWXZ+-0")
def test_every_command_is_taken_without_a_finding(rig, letter):
    r = rig()
    r.drive("wait", 0 if letter == "U" else 1)
    line = LEGAL.get(letter, letter)
    r.send(f"{KNOWN}E\r0\rQ{line}\r{'Q' if letter == 'E' else ''}")
    r.send(f"E\r{line}\rQ")
    assert r.codes == []
    assert len(r.x.program) == SHEET.commands[letter].size


@pytest.mark.fact("LANG-FORM-1")
def test_nothing_happens_before_the_carriage_return(rig):
    r = rig(record=("programmable_output", "ready"))
    r.send("C\r")
    r.host.send("B")
    r.bench.run("10 ms")
    assert r.level("programmable_output") == 0
    start = r.bench.now_ps
    r.send("\r")
    ((effect, level),) = r.edges("programmable_output", start)
    assert level == 1
    assert r.falls("ready", start)[0] < effect < r.rises("ready", start)[0]


@pytest.mark.fact("LANG-FORM-2", "LANG-PARAM-1", "CMD-N-1", "CON-N-RANGE")
@pytest.mark.parametrize(("number", "shown"), [(738, "02 E2"), (300, "01 2C"), (1, "00 01"), (65535, "FF FF")])
def test_numbers_are_decimal_and_read_back_high_byte_first(rig, number, shown):
    r = rig()
    r.send(f"N {number}\rE\rN {number}\rQ")
    stored = bytes.fromhex(shown)
    assert r.host.verify(3)[:2] == stored
    assert r.host.verify(1, 3) == b"N" + stored[::-1]
    assert r.codes == []


@pytest.mark.fact("LANG-PARAM-1")
def test_parameters_live_outside_the_program_and_outlast_it(rig):
    r = rig()
    r.send("S 255\rF 80\rR 80\rZ 1\rN 2\rE\rG\r0\rQX\r")
    r.send("X\r")
    assert r.x.program == bytes.fromhex("47 00")
    assert r.host.verify(3) == bytes([0, 2, 255, 80, 80, 1])
    r.bench.run("1 ms")
    gaps = [int(gap) for gap in r.x.steps().times_ps[1::2] - r.x.steps().times_ps[::2]]
    assert [round(gap * 11 / US) for gap in gaps] == [1840, 1840]  # 5978 steps/s in both runs


@pytest.mark.fact("LANG-MODE-1")
def test_a_command_acts_immediately_or_is_stored_or_runs(rig):
    r = rig(record=("programmable_output",))
    r.send("C\rE\rB\r0\rQ")
    assert r.edges("programmable_output")[0][1] == 0 and r.level("programmable_output") == 0
    r.send("X\r")
    assert r.level("programmable_output") == 1
    r.send("C\r")
    assert r.level("programmable_output") == 0
    r.send("B\r")
    assert [level for _, level in r.edges("programmable_output")] == [0, 1, 0, 1]


# ----------------------------------------------------------------------------------------- parameters, pins, directions
@pytest.mark.fact("CMD-A-1", "CON-ATHOME")
def test_absolute_sets_the_position_and_moves_nothing(rig):
    r = rig(record=("pulse", "phase1", "direction"))
    r.send("A 36003\r")
    assert r.host.verify(0) == b"36003"
    r.send("A 0\r")
    assert r.host.verify(0) == b"00000"
    assert r.x.travel == 0 and not r.edges("pulse") and not r.edges("phase1") and not r.edges("direction")


@pytest.mark.fact("CMD-A-2")
def test_positions_are_measured_against_the_last_absolute(rig):
    r = rig()
    r.send(KNOWN + "P 10\rA 100\rP 90\r")
    assert r.x.steps().directions.tolist() == [1] * 10 + [-1] * 10
    assert r.host.verify(0) == b"00090"
    r.send("E\rA 1000\rP 1003\r0\rQX\r")
    assert (r.x.position, r.x.travel) == (1003, 3)


@pytest.mark.fact("CMD-A-3", "UND-PARAM-POWERUP")
def test_the_position_is_arbitrary_until_absolute_is_given(rig):
    one, two = rig(position=17), rig(position=40000)
    assert (one.host.verify(0), two.host.verify(0)) == (b"00017", b"40000")
    for r in (one, two):
        r.send("A 0\r")
    assert one.host.verify(0) == two.host.verify(0) == b"00000"


@pytest.mark.fact("UND-PARAM-RESET")
def test_reset_keeps_the_parameters_and_clears_program_labels_and_the_continuous_flag(rig):
    r = rig()
    r.send(QUICK + "A 750\rN 1000\rE\rA$B\r0\rQH\r")
    r.x.reset()
    r.bench.run("1 ms")
    assert r.x.program == b"" and r.x.registers["position"] == 750
    assert r.host.verify(3) == bytes([0x03, 0xE8, 255, 10, 3, 1])
    r.send("G\r")
    assert r.x.position == 1750
    r.send("T A\r")  # DOWHILE is high: the label is looked up and nothing else happens
    assert r.codes == ["missing-label"]


@pytest.mark.fact("CMD-B-1", "CMD-C-1", "CON-TABLE5-XTAL")
@pytest.mark.parametrize(("line", "before", "after"), [("C\r", 1, 0), ("B\r", 0, 1)])
def test_bitset_and_clearbit_take_375_us_and_change_one_pin(rig, line, before, after):
    r = rig(record=(*OUTPUTS, "io_request"))
    r.send("B\r" if before else "C\r")
    r.bench.run("1 ms")
    start = r.bench.now_ps
    r.send(line)
    assert r.edges("programmable_output", start) == [(start + 358 * US, after)]
    assert r.rises("ready", start)[-1] == start + 375 * US
    changed = {pin for pin in OUTPUTS if r.edges(pin, start)}
    assert changed == {"programmable_output", "ready", "instrobe"}


@pytest.mark.fact("CMD-D-1", "CMD-D-2", "CON-DEFAULT-XTAL", "CON-SCALE-INVERSE")
@pytest.mark.parametrize(("crystal", "mhz"), [("11 MHz", 11), ("5 MHz", 5)])
@pytest.mark.parametrize("delay", [1, 500, 65535])
def test_delay_counts_milliseconds_at_11_mhz_and_stretches_with_the_crystal(rig, crystal, mhz, delay):
    r = rig(record=("ready",), crystal=crystal)
    r.send(f"D {delay}\r", timeout="200 s")
    last = r.falls("ready")[-1]
    work = 100 + 40 * len(str(delay))  # the command itself: Table V and the conversion of the digits
    assert r.rises("ready")[-1] - last == (work + 1000 * delay) * US * 11 // mhz


@pytest.mark.fact("CMD-F-1")
def test_every_move_begins_and_ends_at_the_first_rate(rig):
    r = rig(record=("motion_complete",))
    for rate, interval in ((3, 36667), (20, 5500)):  # 300 and 2000 steps/s
        start = r.bench.now_ps + 1
        r.send(f"Z 1\rS 200\rF {rate}\rR 80\rN 2000\rG\r")
        times = [*r.x.steps(start).times_ps.tolist(), r.falls("motion_complete", start)[-1]]
        ticks = [round((after - before) * 11 / US) for before, after in pairwise(times)]
        assert len(ticks) == 2000 and ticks[0] == ticks[-1] == max(ticks) == interval
        assert min(ticks) == 1840  # R, in the middle


@pytest.mark.fact("CMD-R-1")
@pytest.mark.parametrize(("rate", "ticks"), [(29, 3793), (3, 36667), (127, 1137)])
def test_rate_is_the_rate_of_slewing(rig, rate, ticks):
    r = rig()
    r.send(f"R {rate}\rF {rate}\rN 1000\rG\r")
    times = r.x.steps().times_ps
    assert len(times) == 1000
    assert {round(int(gap) * 11 / US) for gap in times[1:] - times[:-1]} == {ticks}


def ramp_ps(rig, lines: str) -> int:
    """From the first step to SLEW low."""
    r = rig()
    r.host.send(f"F 3\r{lines}N 60000\rG\r")
    r.bench.run_until(r.x.pin("slew").is_(0))
    return r.bench.now_ps - int(r.x.steps().times_ps[0])


@pytest.mark.fact("CMD-S-1", "CON-S1-PANEL")
def test_a_larger_slope_is_steeper(rig):
    ramps = [ramp_ps(rig, f"Z 1\rR 127\rS {slope}\r") for slope in (1, 10, 50, 100, 200, 240, 250)]
    assert ramps == sorted(ramps, reverse=True) and len(set(ramps)) == 7


@pytest.mark.fact("CMD-Z-1", "CON-Z-RANGE")
@pytest.mark.parametrize(("rate", "one", "other"), [(40, 1, 4), (6, 51, 255)])
def test_the_divisor_divides_the_slope(rig, rate, one, other):
    steep, flat = (ramp_ps(rig, f"R {rate}\rS 1\rZ {divisor}\r") for divisor in (one, other))
    assert flat * one == pytest.approx(steep * other, rel=0.05)


@pytest.mark.fact("CMD-PLUS-1", "CMD-MINUS-1", "CMD-G-1")
def test_the_signs_turn_the_direction_immediately(rig):
    r = rig(record=("direction", "pulse"))
    r.send(KNOWN + "-\r+\r-\r")
    assert [level for _, level in r.edges("direction")] == [0, 1, 0]
    assert not r.edges("pulse")
    r.send("A 100\rN 5\rG\r")
    assert [level for _, level in r.edges("pulse")] == [0, 1] * 5
    assert r.host.verify(0) == b"00095"
    r.send("N 100\rG\r")
    assert r.x.travel == -105 and r.level("direction") == 0


@pytest.mark.fact("CMD-G-2")
def test_go_does_not_use_up_the_number(rig):
    r = rig()
    r.send(QUICK + "A 0\rN 75\rG\rG\rG\r")
    assert r.x.position == 225
    assert r.host.verify(3)[:2] == bytes([0, 75])


@pytest.mark.fact("CMD-H-1")
def test_haltmode_alone_moves_nothing_and_the_next_go_does_not_end(rig):
    r = rig(record=("pulse",))
    r.send("F 10\rR 127\rS 255\rZ 1\rA 0\rN 65000\rH\r")
    r.bench.run("1 s")
    assert not r.edges("pulse")
    r.host.send("G\r")
    r.bench.run("7 s")
    assert r.x.travel > 65536 and r.x.position == r.x.travel - 65536
    assert r.level("slew") == 0 and not r.x.idle


# ------------------------------------------------------------------------------------------------------------- position
@pytest.mark.fact("CMD-P-1", "CMD-P-4", "CON-MODE-SELECT")
def test_position_moves_by_itself_and_leaves_the_number_alone(rig):
    r = rig(record=("motion_complete",))
    r.send(QUICK + "N 75\rA 0\rP 40\r")
    assert (r.x.position, r.level("direction"), r.level("motion_complete")) == (40, 1, 0)
    r.send("G\r")
    assert r.x.position == 115
    assert r.host.verify(3)[:2] == bytes([0, 75])


@pytest.mark.fact("CMD-P-2")
def test_position_compares_and_never_wraps_around(rig):
    r = rig()
    r.send("F 127\rR 127\rS 255\rZ 1\rA 65535\rP 0\r")
    assert (r.x.travel, r.x.position, r.level("direction")) == (-65535, 0, 0)


@pytest.mark.fact("CMD-P-2", "UND-P-SAME")
def test_position_to_the_present_position_turns_the_direction_and_completes(rig):
    r = rig(record=("pulse", "motion_complete"))
    r.send(KNOWN + "A 5\r-\rP 5\r")
    assert r.level("direction") == 1
    assert not r.edges("pulse") and [level for _, level in r.edges("motion_complete")] == [0]
    assert r.codes == []


@pytest.mark.fact("CMD-P-3")
def test_the_direction_of_a_position_command_stays_for_go(rig):
    r = rig(record=("direction", "pulse"))
    r.send(KNOWN + "A 10\rN 3\r")
    r.host.send("P 0\r")
    r.bench.run_until(r.x.pin("pulse").edges(2))
    ((turned, level),) = r.edges("direction")
    assert level == 0 and turned <= r.falls("pulse")[0]
    r.send("G\r")
    assert r.x.position == 65533 and len(r.edges("direction")) == 1


# ------------------------------------------------------------------------------------------------------------- phases
@pytest.mark.fact("CMD-O-1", "CON-O-WHEN")
@pytest.mark.parametrize(
    ("offset", "shown", "after"), [(0, 0b0101, 0b1001), (1, 0b1001, 0b1010), (2, 0b1010, 0b0110), (3, 0b0110, 0b0101)]
)
def test_offset_shows_a_pattern_from_which_the_next_step_continues(rig, offset, shown, after):
    r = rig(record=("pulse",))
    bits = lambda: int("".join(map(str, r.phases)), 2)  # noqa: E731
    r.send(KNOWN + f"N 1\rO {offset}\r")
    assert bits() == shown and not r.edges("pulse")
    r.send("+\rG\r")
    assert bits() == after
    r.send("-\rG\r")
    assert bits() == shown


@pytest.mark.fact("CMD-O-2", "CMD-O-4")
@pytest.mark.parametrize("offset", [4, 127])
def test_a_larger_offset_switches_the_phases_off_and_keeps_the_pointer(rig, offset):
    r = rig(record=("pulse",))
    r.send(KNOWN + f"O 1\rO {offset}\r")
    assert r.phases == (1, 1, 1, 1) and not r.edges("pulse")
    r.send("N 1\r+\rG\r")
    assert r.phases == (1, 0, 1, 0)


@pytest.mark.fact("CMD-O-3", "CMD-O-4")
@pytest.mark.parametrize("offset", [128, 255])
def test_an_offset_above_127_clocks_the_pattern_out_with_pulse(rig, offset):
    r = rig(record=("pulse", "phase1", "phase2", "phase3", "phase4", "motion_complete"))
    r.send(KNOWN + "A 9\rO 1\r")
    start = r.bench.now_ps
    r.send(f"O {offset}\r")
    (fell, low), (off, high) = r.edges("pulse", start)
    assert (low, high) == (0, 1) and off - fell == 20_000_000
    assert [r.edges(f"phase{n}", start) for n in (1, 2, 3, 4)] == [[], [(off, 1)], [(off, 1)], []]
    assert r.x.position == 9 and r.x.travel == 0 and not r.edges("motion_complete", start)
    r.send("N 1\r+\rG\r")
    assert r.phases == (1, 0, 1, 0)


# --------------------------------------------------------------------------------------------- verify, initialize, quit
@pytest.mark.fact("CMD-V-1")
def test_verify_only_points(rig):
    r = rig(record=("outstrobe",))
    r.send("N 513\rS 25\rR 127\rF 3\rZ 1\rV 3\r")
    assert not r.edges("outstrobe")
    r.host.do(lambda port: port.fetch(6))
    r.bench.run_until_idle()
    assert bytes(r.host.received) == bytes.fromhex("02 01 19 7F 03 01")


@pytest.mark.fact("CMD-V-2")
def test_verify_is_a_live_command_while_a_program_runs(rig):
    for live in (False, True):
        r = rig(record=("instrobe",))
        r.send("A 4711\rE\rD 300\rD 300\r0\rQ")
        r.start("X\r")
        if live:
            r.drive("prog", 0)
            r.bench.run("310 ms")  # the first delay is over, the chip waits
        taken = r.bench.now_ps
        r.host.send("V 0\r")
        r.host.do(lambda port: port.fetch(5))
        r.bench.run("200 ms")
        assert r.level("run") == 0
        assert len(r.falls("instrobe", taken)) == (4 if live else 0)
        assert r.host.received == (b"04711" if live else b"")


@pytest.mark.fact("CMD-I-1", "UND-I-PINS")
def test_initialize_forgets_the_program_and_switches_the_coils_off(rig):
    r = rig(record=("programmable_output", "run"))
    r.send(QUICK + "E\rA$B\r0\rQC\r-\rO 2\rH\rI\r")
    assert r.level("direction") == 1 and r.phases == (1, 1, 1, 1)
    assert r.host.verify(1, 3) == bytes(3) and r.x.program == b""
    assert r.level("programmable_output") == 0  # untouched
    r.send("A 0\rN 1000\rG\r")  # the continuous flag is gone: this ends
    assert r.x.position == 1000
    r.send("I\rN 1\rG\r")
    assert r.phases == (1, 0, 0, 1)  # the pointer began at 0
    r.start("X\r")
    r.bench.run("10 s")
    assert r.level("run") == 0 and r.level("programmable_output") == 0
    assert r.codes == ["end-of-program"]


@pytest.mark.fact("CMD-I-2")
def test_initialize_keeps_every_parameter(rig):
    r = rig()
    r.send("N 513\rS 25\rR 127\rF 4\rZ 2\rA 750\rI\r")
    assert r.host.verify(3) == bytes.fromhex("02 01 19 7F 04 02")
    assert r.host.verify(0) == b"00750"


@pytest.mark.fact("CMD-Q-1", "CMD-Q-2", "CON-QCR-LIST")
def test_quit_ends_program_entry_by_itself_in_175_us(rig):
    r = rig(record=("prog", "ready"))
    r.send("E\rB\r")
    r.bench.run("1 ms")
    start = r.bench.now_ps
    r.send("Q")
    ((up, level),) = r.edges("prog", start)
    assert level == 1 and up < start + 175 * US
    assert r.rises("ready", start) == [start + 175 * US]
    assert r.x.program == b"B"
    r.send("N 5\r")
    assert r.x.registers["number"] == 5 and r.codes == ["unfinished"]  # before the Q


@pytest.mark.fact("CMD-0-2")
def test_command_in_command_mode_takes_600_us_and_does_nothing(rig):
    r = rig(record=OUTPUTS)
    r.send("0\r")
    assert r.rises("ready")[-1] == 600 * US
    assert all(not r.edges(pin) for pin in set(OUTPUTS) - {"ready", "instrobe"}) and r.codes == []
