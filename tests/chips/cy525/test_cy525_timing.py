"""How long the CY525 takes for what, and that all of it scales with its crystal.  Clocks: 11 to the us at 11 MHz."""

from __future__ import annotations

from itertools import pairwise

import pytest

import slewline
from slewline.chips.cy525.sheet import SHEET
from slewline.errors import TimeError, UsageError
from tests.ensembles import few

US, MS = 11, 11_000
BUSY, LETTER = 286, 2057
FIRST, NEXT = 60 * US, 40 * US
KNOWN = {"rate": 10, "firstrate": 10, "slope": 250, "divisor": 1, "position": 0}
ALONE = {letter: 375 for letter in "BCHI"} | {"E": 400} | {letter: 380 for letter in "TUWX+-"} | {"0": 600, "Q": 175}
LAST = {"R": 80, "S": 80, "O": 80, "J": 100, "D": 100, "V": 125, "L": 150, "N": 180, "Z": 180, "F": 240, "A": 375}


def busy(h, since):
    """Clocks of READY low, phase by phase."""
    edges = [(clock, level) for clock, level in h.edges("ready", since) if clock > 0]
    return [up - down for (down, _), (up, _) in pairwise(edges) if (down, 0) in edges]


def total(h, data):
    """Clocks from the first I/O REQUEST to READY behind the last byte."""
    h.until(ready=1)
    start = h.now
    h.send(data)
    return h.now - start


# ------------------------------------------------------------------------------------------------------ command mode


@pytest.mark.fact("TIME-CMD-1", "CON-TABLE5-XTAL", "CMD-Q-2", "CMD-B-1")
@pytest.mark.parametrize("letter", list(ALONE))
@pytest.mark.parametrize("crystal", ["11 MHz", "6 MHz"])
def test_a_command_without_argument_takes_the_time_of_table_v_from_letter_to_ready(hand, letter, crystal):
    h = hand("ready", crystal=crystal, straps={"wait": 0 if letter == "U" else 1})
    if letter == "Q":
        h.send("E\r")
    if letter == "0":
        h.send("A 5\r")
    if letter == "T":
        data = "T 0\r"
        assert total(h, data) - 2 * LETTER - 40 * US == ALONE[letter] * US  # without its argument and its conversion
    else:
        assert total(h, letter if letter == "Q" else f"{letter}\r") == ALONE[letter] * US


@pytest.mark.fact("TIME-CMD-1")
def test_g_takes_660_us_up_to_its_first_step(hand):
    h = hand("pulse", number=1, **KNOWN)
    h.send("G\r")
    assert h.falls("pulse") == [660 * US]


@pytest.mark.fact("TIME-CMD-2", "BIN-10", "CON-TABLE5-XTAL")
@pytest.mark.parametrize("letter", list(LAST))
def test_the_last_byte_of_a_binary_command_takes_the_time_of_table_v(hand, letter):
    h = hand("ready", straps={"ascii_binary": 0})
    size = SHEET.commands[letter].data_bytes
    h.send(bytes([ord(letter), size]) + b"\x01" * (size - 1))
    last = b"\x01" if size == 1 else b"\x00" if letter in "DL" else b"\x01"
    before = h.now
    h.send(last)
    extra = MS if letter == "D" else 0  # D 1
    assert busy(h, before) == [LAST[letter] * US + extra]


@pytest.mark.fact("TIME-CMD-2")
def test_p_takes_550_us_up_to_its_first_step(hand):
    h = hand("pulse", "ready", straps={"ascii_binary": 0}, **KNOWN)
    h.send(b"P\x02\x01")
    start = h.now
    h.send(b"\x00")
    assert h.falls("pulse", start) == [BUSY + 550 * US]


@pytest.mark.fact("TIME-CMD-2")
def test_the_order_of_table_v_is_kept():
    times = {row.form: row.time_us for row in SHEET.commands}
    assert times["R"] == times["S"] == times["O"] < times["J"] == times["D"] < times["V"] < times["L"]
    assert times["L"] < times["N"] == times["Z"] < times["F"] < times["A"] < times["P"]


@pytest.mark.fact("HS-10", "BIN-10", "UND-CONV-TIME")
@pytest.mark.parametrize(
    ("line", "us", "digits"),
    [
        ("N 5", 180, 1), ("N 65535", 180, 5), ("N 00005", 180, 5), ("R 100", 80, 3), ("R 7", 80, 1), ("L 1,0", 150, 2),
        ("L 255,59", 150, 5), ("A 36003", 375, 5), ("V 3", 125, 1), ("F 10", 240, 2), ("B", 162, 0),
    ],
)  # fmt: skip
def test_a_decimal_number_takes_40_us_a_digit_to_convert(hand, line, us, digits):
    h = hand("ready")
    h.send(line)
    start = h.now
    h.send("\r")
    assert busy(h, start)[0] == (us + 40 * digits) * US


@pytest.mark.fact("BIN-10", "UND-CONV-TIME", "HS-10")
def test_the_same_command_is_quicker_in_binary(hand):
    ascii_, binary = hand("ready"), hand("ready", straps={"ascii_binary": 0})
    ascii_.send("R 100")
    binary.send(b"R\x01")
    starts = ascii_.now, binary.now
    ascii_.send("\r")
    binary.send(b"\x64")
    assert busy(ascii_, starts[0]) == [(80 + 3 * 40) * US]
    assert busy(binary, starts[1]) == [80 * US]
    assert ascii_.x.registers["rate"] == binary.x.registers["rate"] == 100


@pytest.mark.fact("UND-CONV-TIME")
@pytest.mark.parametrize("number", [1, 65535])
def test_the_time_does_not_depend_on_the_value(hand, number):
    h = hand("ready", straps={"ascii_binary": 0})
    h.send(b"N\x02")
    start = h.now
    h.send(number.to_bytes(2, "little"))
    assert busy(h, start) == [LETTER - BUSY, 180 * US]


@pytest.mark.fact("HS-9", "TIME-CHAR-1")
@pytest.mark.parametrize("character", list("ENR127\x00"))
def test_a_character_takes_187_us_and_never_more_than_200(hand, character):
    h = hand("ready")
    if character not in "ENR":
        h.send("R ")
    assert total(h, character) == LETTER == 187 * US <= 200 * US


@pytest.mark.fact("HS-9", "EXAMPLE-7.2")
def test_eleven_characters_of_a_slow_host_take_3_3_ms(rig):
    r = rig(delay="100 us", record=("io_request",))
    r.host.send("E\rB\rC\r0\rQX\r")
    r.bench.run_until(lambda: r.host.idle)
    r.bench.run_until(r.x.pin("ready").is_(1))
    # five letters, E's end, three stored commands, Q, X's end, and ten times the host's 100 us
    exact = 5 * 187 + (400 - 187) + 3 * 188 + 175 + (380 - 187) + 10 * 100
    first = r.falls("io_request")[0]
    assert len(r.falls("io_request")) == 11
    assert r.bench.now_ps - first == exact * 1_000_000
    assert 0.8 * 3300 <= exact <= 1.2 * 3300


# ---------------------------------------------------------------------------------------------------------- programs


@pytest.mark.fact("TIME-RUN-1", "CMD-X-1")
def test_run_falls_150_us_after_the_acceptance_of_x(hand):
    h = hand("ready", "run")
    h.send("E\rB\r0\rQX")
    start = h.now
    h.send("\r")
    assert h.falls("run", start) == [BUSY + 150 * US]
    h.run(5000)
    assert h.rises("run", start) == [BUSY + 150 * US + FIRST + 36 * US]


@pytest.mark.fact("TIME-RUN-2", "PROG-8", "EXAMPLE-7.2", "UND-PROG-TIME")
@pytest.mark.parametrize("crystal", ["11 MHz", "3.579545 MHz"])
def test_b_c_and_0_follow_the_fall_of_run(hand, crystal):
    h = hand("run", "programmable_output", crystal=crystal)
    h.send("C\rE\rB\rC\r0\rQ")
    for _ in range(2):  # as often as one likes
        h.send("X\r")
        start = h.falls("run")[-1]
        h.run(5000)
        t1, t2 = (clock for clock, _ in h.edges("programmable_output", start))
        (t3,) = h.rises("run", start)
        assert (t1, t2 - t1, t3 - t2) == (60 * US, 40 * US, 36 * US)


@pytest.mark.fact("UND-PROG-TIME", "PROG-8")
@pytest.mark.parametrize(
    "line",
    ["A 5", "C", "F 9", "H", "J 2", "L 1,0", "N 5", "O 2", "R 9", "S 9", "T 0", "U", "V 0", "W", "Z 2", "+", "-"],
)
def test_every_instruction_that_does_not_wait_takes_40_us(hand, line):
    h = hand("run", "programmable_output", straps={"wait": 0 if line == "U" else 1})
    h.send(f"C\rE\r{line}\rB\r0\rQX\r")
    start = h.falls("run")[-1]
    h.run(20_000)
    assert h.edges("programmable_output", start) == [(FIRST + NEXT, 1)]


@pytest.mark.fact("UND-PROG-TIME", "CMD-D-1")
def test_a_delay_in_a_program_comes_on_top_of_its_40_us(hand):
    h = hand("run", "programmable_output")
    h.send("C\rE\rD 1\rD 3\rB\r0\rQX\r")
    start = h.falls("run")[-1]
    h.run(100_000)
    assert h.edges("programmable_output", start) == [(FIRST + MS + NEXT + 3 * MS + NEXT, 1)]


@pytest.mark.fact("UND-PROG-TIME", "CMD-U-1", "CMD-W-1")
@pytest.mark.parametrize(("letter", "level"), [("U", 0), ("W", 1)])
@pytest.mark.parametrize(
    ("change", "look"), [(FIRST - 1, 0), (FIRST, 88), (FIRST + 87, 88), (FIRST + 88, 176), (FIRST + 100_000, 100_056)]
)
def test_u_and_w_sample_every_8_us(hand, letter, level, change, look):
    h = hand("run", "programmable_output", straps={"wait": 1 - level})
    h.send(f"C\rE\r{letter}\rB\r0\rQX\r")
    start = h.falls("run")[-1]
    h.put(start + change, "wait", level)
    h.run(200_000)
    assert h.edges("programmable_output", start) == [(FIRST + look + NEXT, 1)]


@pytest.mark.fact("UND-PROG-TIME", "CMD-W-1")
def test_a_level_gone_by_the_following_sample_is_missed(hand):
    h = hand("run", "programmable_output", straps={"wait": 0})
    h.send("C\rE\rW\rB\r0\rQX\r")
    start = h.falls("run")[-1]
    for clock, level in (
        (FIRST + 1, 1),
        (FIRST + 87, 0),
        (FIRST + 89, 1),
        (FIRST + 176, 0),
    ):  # the second is there at a look
        h.put(start + clock, "wait", level)
    h.run(200_000)
    assert h.edges("programmable_output", start) == [(FIRST + 176 + NEXT, 1)]


@pytest.mark.fact("TIME-PROG-1", "CMD-E-1", "CMD-Q-1")
def test_prog_falls_within_the_busy_time_of_e_and_rises_within_that_of_q(hand):
    h = hand("prog", "ready")
    h.send("E")
    carriage_return = h.now
    h.send("\r")
    e_end = h.now
    h.send("B\r")
    q = h.now
    h.send("Q")
    q_end = h.now
    assert h.edges("prog") == [(e_end - 17 * US, 0), (q_end - 17 * US, 1)]
    assert carriage_return + BUSY < e_end - 17 * US
    assert q + BUSY < q_end - 17 * US


# ----------------------------------------------------------------------------------------------------------- crystals


def dialogue(h):
    """A bit of everything: commands, a delay, a verify byte, a program with motion; its trace, in clocks."""
    h.send("A 7\rN 40\rF 20\rR 30\rS 252\rZ 1\rD 2\rV 0\r")
    h.put(h.now, "io_select", 1)
    assert h.fetch(5) == b"00007"
    h.put(h.now, "io_select", 0)
    h.send("E\rC\rG\rD 3\rU\rB\r0\rQX\r")
    h.put(h.now + 400_000, "wait", 0)
    h.run(500_000)
    assert h.x.idle
    return h.trace


@pytest.mark.fact("CLOCK-1", "CLOCK-2", "CMD-D-2", "CON-SCALE-INVERSE")
def test_every_instant_is_the_same_clock_at_any_crystal(hand):
    pins = (
        "ready",
        "instrobe",
        "outstrobe",
        "pulse",
        "slew",
        "run",
        "prog",
        "programmable_output",
        "motion_complete",
        "phase1",
    )
    expected = dialogue(hand(*pins))
    assert len(expected) > 300
    for crystal in ("6 MHz", "5.5 MHz", "3.579545 MHz", "1 MHz", "10.999999 MHz"):
        assert dialogue(hand(*pins, crystal=crystal)) == expected


@pytest.mark.parametrize("shuffle", few(range(5), 2))
def test_the_order_inside_an_instant_does_not_matter(hand, shuffle):
    pins = (
        "ready",
        "instrobe",
        "outstrobe",
        "pulse",
        "slew",
        "run",
        "prog",
        "programmable_output",
        "motion_complete",
        "phase1",
    )
    plain, other = hand(*pins), hand(*pins, shuffle=shuffle)
    assert sorted(dialogue(other)) == sorted(dialogue(plain))
    assert [str(found) for found in other.x.findings] == [str(found) for found in plain.x.findings]


def rate(r):
    """Steps per second of a long slew, from its first begin to its last."""
    times = r.x.steps().times_ps
    return (len(times) - 1) * 10**12 / (times[-1] - times[0])


@pytest.mark.fact("CLOCK-1", "CLOCK-2")
@pytest.mark.parametrize(
    ("crystal", "parameter", "steps_per_second"),
    [
        ("3.579545 MHz", 30, 976),
        ("5.5 MHz", 29, 1450),
        ("11 MHz", 29, 2900),
        ("1 MHz", 29, 2900 / 11),
        ("6 MHz", 3, 300 * 6 / 11),
    ],
)
def test_step_rates_scale_with_the_crystal(rig, crystal, parameter, steps_per_second):
    r = rig(crystal=crystal, rate=parameter, firstrate=parameter, number=2000)
    r.send("G\r")
    assert rate(r) == pytest.approx(steps_per_second, rel=0.001)


@pytest.mark.fact("CLOCK-2")
@pytest.mark.parametrize(("crystal", "ms"), [("5.5 MHz", 1600), ("11 MHz", 800)])
def test_ramp_times_scale_with_the_inverse(rig, crystal, ms):
    r = rig(crystal=crystal, rate=127, firstrate=3, slope=100, divisor=1, number=60_000, record=("slew",))
    r.host.send("G\r")
    r.bench.run_until(r.x.pin("slew").is_(0))
    ramp = r.bench.now_ps - int(r.x.steps().times_ps[0])
    assert 0.88 * ms <= ramp / 1e9 <= 1.12 * ms


@pytest.mark.fact("CLOCK-2", "CMD-D-2", "CON-SCALE-INVERSE")
@pytest.mark.parametrize(("crystal", "ms"), [("11 MHz", 500), ("6 MHz", 500 * 11 / 6), ("1 MHz", 5500)])
def test_a_delay_scales_with_the_inverse(hand, crystal, ms):
    h = hand("ready", crystal=crystal)
    h.send("D 500")
    start = h.now
    h.send("\r")
    delay = h.x.clock.ps(h.rises("ready", start)[-1] - BUSY - (100 + 3 * 40) * US)
    assert delay == int(ms * 10**9)


@pytest.mark.fact("CON-DEFAULT-XTAL", "HS-15", "RESET-2")
def test_a_time_belongs_to_the_crystal_that_is_named_with_it():
    at_6 = {name for name, time in SHEET.times.items() if time.mhz == 6}
    assert at_6 == {"ready_after_motion", "reset_pulse"}
    assert {time.mhz for time in SHEET.times.values()} == {6, 11}


@pytest.mark.fact("CLOCK-1", "UND-CLOCK", "CON-TOP-RATE")
@pytest.mark.parametrize(
    ("crystal", "codes"),
    [
        ("1 MHz", []), ("11 MHz", []), ("3.58 MHz", []), ("11.37 MHz", ["crystal"]), ("12 MHz", ["crystal"]),
        ("0.5 MHz", ["crystal"]), ("11.000001 MHz", ["crystal"]), ("999999 Hz", ["crystal"]),
    ],
)  # fmt: skip
def test_crystals_from_1_to_11_mhz_fit_and_others_near_them_are_noted(rig, crystal, codes):
    r = rig(crystal=crystal)
    r.send("C\r")
    assert r.level("programmable_output") == 0
    assert r.codes == codes


@pytest.mark.fact("UND-CLOCK")
@pytest.mark.parametrize("crystal", ["12.000001 MHz", "499999 Hz", "0 Hz", 11])
def test_crystals_far_from_them_are_refused(crystal):
    with pytest.raises(UsageError, match="CY525 takes 1 to 11 MHz"):
        slewline.Bench().add("cy525", crystal=crystal)


def test_a_crystal_needs_a_unit():
    with pytest.raises(TimeError, match="number and a unit"):
        slewline.Bench().add("cy525", crystal="11")


@pytest.mark.fact("CON-TOP-RATE", "UND-CLOCK")
def test_ten_thousand_steps_a_second_take_11_37_mhz(rig):
    r = rig(crystal="11.37 MHz", rate=127, firstrate=127, number=3000)
    r.send("G\r")
    assert rate(r) == pytest.approx(10_000, rel=0.001)
