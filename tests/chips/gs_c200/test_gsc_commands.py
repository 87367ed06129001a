"""What each command of the GS-C modules does: outputs, delays, the counter, moves, and the ends of a program.

An instruction takes a millisecond before it acts; a motion begins 10 us later.
"""

from __future__ import annotations

import pytest
from gsc import C200, C200S, FAST, MS, NINE_SIX, SETUP, STR, US, base, both, gaps, shown, spacing, velocity, within

TENTH = 100 * MS
STILL = ("clock", "mov", "ramp", "dir", "reset", "uo1", "uo2", "uo3")
OUTPUTS = ("uo1", "uo2", "uo3")


# --------------------------------------------------------------------------------------------------- outputs and delays
@both
@pytest.mark.fact("GSC-CMD-A-1")
@pytest.mark.parametrize("number", [1, 2, 3])
def test_activate_sets_one_output_and_leaves_the_others(part: str, number: int) -> None:
    rig = base(part, *OUTPUTS)
    start = rig.run(f"A{number}")
    assert [rig.edges(pin) for pin in OUTPUTS] == [[(start + MS, 1)] if n == number else [] for n in (1, 2, 3)]
    assert rig.ask("V2") == f"V7{1 << number - 1}"


@both
@pytest.mark.fact("GSC-CMD-C-1")
@pytest.mark.parametrize("number", [1, 2, 3])
def test_clear_clears_one_output_and_leaves_the_others(part: str, number: int) -> None:
    rig = base(part, *OUTPUTS)
    start = rig.run("A1", "A2", "A3", f"C{number}")
    assert [rig.falls(pin) for pin in OUTPUTS] == [[start + 4 * MS] if n == number else [] for n in (1, 2, 3)]
    assert rig.ask("V2") == f"V7{7 - (1 << number - 1)}"


@both
@pytest.mark.fact("GSC-CMD-A-2", "GSC-CMD-C-1")
@pytest.mark.parametrize("letter", ["A", "C"])
def test_outputs_belong_to_programs_and_are_numbered_1_to_3(part: str, letter: str) -> None:
    rig = base(part, *OUTPUTS)
    assert rig.ask(f"{letter}3") == "E4"
    assert rig.prg(*(f"{letter}{number}" for number in "123")) == ["Y"] * 3
    assert rig.asks(*(letter + number for number in ("0", "4", "", "+1", "12"))) == ["E2"] * 5
    assert [rig.edges(pin) for pin in OUTPUTS] == [[], [], []]


@both
@pytest.mark.fact("GSC-CMD-D-1")
@pytest.mark.parametrize("tenths", [1, 15, 255])
def test_delay_waits_in_tenths_of_a_second(part: str, tenths: int) -> None:
    rig = base(part, "uo1")
    start = rig.run("A1", f"D{tenths}", "C1")
    assert rig.edges("uo1") == [(start + MS, 1), (start + 3 * MS + tenths * TENTH, 0)]
    assert rig.prg("D0", "D256", "D", "D255") == ["E2", "E2", "E2", "Y"]


@both
@pytest.mark.fact("GSC-CMD-D-2")
def test_a_delay_is_busy_and_does_not_move(part: str) -> None:
    rig = base(part, "rdy", *STILL)
    start = rig.start("D30")
    rig.bench.run("1 s")
    assert rig.levels("rdy", "mov", "ramp", "clock") == (0, 0, 0, 1)
    assert rig.ask("F") == "B"
    rig.bench.run_until_idle()
    assert rig.rises("rdy")[-1] == start + MS + 30 * TENTH
    assert rig.pulses() == rig.edges("mov") == []
    assert rig.ask("F") == "R"


# ------------------------------------------------------------------------------------------------------------- feedback
@both
@pytest.mark.fact("GSC-CMD-F-1")
def test_feedback_distinguishes_busy_from_ready_at_any_time(part: str) -> None:
    rig = base(part)
    assert rig.asks("F", "F1", "F+") == ["R", "E2", "E2"]
    assert rig.prg(*STR, "+200") == ["Y"] * 4
    assert rig.ask("F") == "R"
    assert rig.asks("E", "F") == ["Y", "B"]
    rig.bench.run_until_idle()
    assert rig.ask("F") == "R"


@pytest.mark.fact("GSC-CMD-F-2")
def test_feedback_reports_an_overflow_once() -> None:
    rig = base(C200)
    rig.run(*STR, "-1")
    assert rig.asks("V1", "F", "F") == ["V0", "E5", "R"]
    other = base(C200S)
    other.run(*STR, "-1")
    assert other.asks("F", "F", "V1") == ["R", "R", "V-1"]


# ----------------------------------------------------------------------------------------------------- position counter
@pytest.mark.fact("GSC-CMD-FORCE-1", "GSC-CMD-FORCE-3", "GSC-UND-F-SIGN")
def test_force_presets_the_counter_immediately() -> None:
    rig = base(C200S, *STILL)
    for position in (1000, -8388608, 8388607, 0):
        assert rig.asks(f"f{position:+d}", "V1") == ["Y", f"V{position:+d}"]
    assert rig.asks("f+12", "f-0", "V1") == ["Y", "Y", "V+0"]
    assert rig.asks("f+7", "f+8388608", "f-8388609", "f5", "f", "V1") == ["Y", "E2", "E2", "E2", "E2", "V+7"]
    assert [pin for pin in STILL if rig.edges(pin)] == ["reset"]  # that of power-up


@pytest.mark.fact("GSC-CMD-FORCE-2")
def test_force_in_a_program_acts_when_it_is_reached() -> None:
    rig = base(C200S)
    assert rig.prg(*STR, "+5", "f+100", "+7") == ["Y"] * 6
    assert rig.ask("V1") == "V+0"
    assert rig.ask("E") == "Y"
    rig.bench.run_until_idle()
    assert rig.moves() == [12]
    assert rig.x.steps().positions.tolist() == [*range(1, 6), *range(101, 108)]
    assert rig.ask("V1") == "V+107"


@both
@pytest.mark.fact("GSC-CMD-I-1")
def test_initialize_clears_the_counter_the_outputs_or_both(part: str) -> None:
    rig = base(part)
    zero, program = shown(part, 0), (*STR, "+5", "A1")
    rig.run(*program)
    assert rig.asks("V1", "V2") == [shown(part, 5), "V71"]
    assert rig.asks("I1", "V1", "V2") == ["Y", zero, "V71"]
    assert rig.asks("I2", "V2") == ["Y", "V70"]
    rig.run(*program)
    assert rig.asks("I2", "V1", "V2") == ["Y", shown(part, 5), "V70"]
    rig.run(*program)
    assert rig.asks("V1", "I3", "V1", "V2") == [shown(part, 10), "Y", zero, "V70"]
    assert rig.asks("I0", "I4", "I") == ["E2"] * 3


@pytest.mark.fact("GSC-CMD-I-2", "GSC-CON-I-BYTES")
def test_initialize_is_allowed_in_a_program_of_the_c200s() -> None:
    rig = base(C200S, "reset", "uo1")
    start = rig.run(*STR, "+5", "I1", "+7", "A1", "I2")
    fifth, sixth = rig.pulses()[4:6]
    assert len(rig.pulses()) == 12
    low = rig.falls("reset", start)
    assert low == [fifth + 10 * MS + MS] and sixth == low[0] + 400 * US + MS + SETUP
    assert [level for _, level in rig.edges("uo1")] == [1, 0]
    assert rig.asks("V1", "V2") == ["V+7", "V70"]
    assert rig.prg("I1") == ["Y"]
    assert len(rig.x.program) == 2


@pytest.mark.fact("GSC-CMD-I-3", "GSC-CON-I-BYTES")
def test_initialize_is_refused_in_a_program_of_the_c200() -> None:
    rig = base(C200)
    assert rig.prg(*STR, "I1", "D20") == ["Y", "Y", "Y", "E4", "Y"]
    assert rig.listed() == [*STR, "D20"]
    assert rig.asks("E", "I1", "F") == ["Y", "B", "B"]


# ----------------------------------------------------------------------------------------------------------- kill, zero
@both
@pytest.mark.fact("GSC-CMD-K-1", "GSC-CMD-K-3")
def test_kill_stops_dead_and_keeps_count_and_program(part: str) -> None:
    rig = base(part, "clock", "ramp", "mov", "rdy")
    program = [*FAST, "+100000", "A1"]
    start = rig.start(*program)
    rig.bench.run("5 s")
    obeyed = rig.obeyed("K")
    rig.bench.run("2 s")
    pulses = rig.pulses()
    assert rig.host.answers == ["Y"]
    assert obeyed - MS <= pulses[-1] <= obeyed
    assert rig.falls("clock") == pulses
    assert len(rig.rises("ramp", start)) == 1
    assert rig.levels("mov", "ramp", "rdy", "clock", "uo1") == (0, 0, 1, 1, 0)
    assert rig.ask("F") == "R"
    assert rig.pos() == len(pulses) > 4000
    assert rig.listed() == program


@both
@pytest.mark.fact("GSC-UND-K-SPEEDS")
@pytest.mark.parametrize("by", ["command", "kill"])
def test_after_k_the_speeds_are_as_before(part: str, by: str) -> None:
    rig = base(part)
    rig.start("S60", "T300", "R90", "+100000")
    rig.bench.run("3 s")
    speeds = ("start_stop", "top_speed", "ramp")
    assert [rig.x.registers[name] for name in speeds] == [60, 300, 90]
    if by == "kill":  # as a board does that has stopped the motor
        rig.x.kill()
        rig.bench.run("10 ms")
    else:
        rig.ask("K")
    assert rig.ask("F") == "R" and rig.x.powered
    assert [rig.x.registers[name] for name in speeds] == [60, 300, 90]
    assert rig.listed() == ["S60", "T300", "R90", "+100000"]


@both
@pytest.mark.fact("GSC-CMD-K-2", "GSC-CMD-Z-4")
@pytest.mark.parametrize("end", ["K", "Z"])
def test_after_an_end_from_outside_execute_starts_at_the_beginning(part: str, end: str) -> None:
    rig = base(part, "uo1")
    rig.start(*STR, "A1", "D10", "C1", "D50")
    rig.bench.run("2 s")
    assert rig.level("uo1") == 0
    assert rig.ask(end) == "Y"
    start = rig.obeyed("E")
    rig.bench.run("5 ms")
    assert rig.rises("uo1", start) == [start + 4 * MS]


@both
@pytest.mark.fact("GSC-CMD-K-4", "GSC-UND-KZ-IDLE")
def test_kill_and_zero_change_nothing_when_nothing_runs(part: str) -> None:
    rig = base(part, *STILL)
    program = [*STR, "+5", "A1"]
    rig.run(*program)
    start = rig.bench.now_ps + 1
    assert rig.asks("K", "Z", "F") == ["Y", "Y", "R"]
    assert [pin for pin in STILL if rig.edges(pin, start)] == []
    assert rig.pos() == 5 and rig.listed() == program


@both
@pytest.mark.fact("GSC-CMD-Z-1", "GSC-CMD-Z-3")
def test_zero_brings_the_motor_to_rest_through_its_ramp(part: str) -> None:
    rig = base(part, "ramp", "mov", "rdy")
    rig.start(*FAST, f"{velocity(part)}+", "A1")
    rig.bench.run("3 s")
    obeyed = rig.obeyed("Z")
    rig.bench.run_until_idle()
    pulses = rig.pulses()
    down, rest = rig.edges("ramp", obeyed)
    assert obeyed <= down[0] <= obeyed + MS
    assert within(pulses, down[0], rest[0]) == 51 and pulses[-1] < rest[0]
    assert gaps(pulses)[-51:] == [MS, *spacing(200, 10, 100, 50)[49::-1]]
    assert rig.falls("mov") == [rest[0]]
    assert rig.rises("rdy")[-1] == pulses[-1] + 10 * MS
    assert rig.levels("mov", "uo1") == (0, 0)
    assert rig.pos() == len(pulses)


@both
@pytest.mark.fact("GSC-CMD-Z-2")
def test_zero_without_motion_ends_the_program_immediately(part: str) -> None:
    rig = base(part, "rdy")
    rig.start(*STR, "D100", "A1")
    rig.bench.run("2 s")
    obeyed = rig.obeyed("Z")
    assert rig.rises("rdy", obeyed - MS) == [obeyed]
    rig.bench.run("20 s")
    assert rig.level("uo1") == 0 and rig.ask("F") == "R"


@both
@pytest.mark.fact("GSC-CMD-Z-5")
def test_the_ramp_after_zero_is_busy_and_can_be_killed(part: str) -> None:
    rig = base(part)
    program = ("S1", "T100", "R500", f"{velocity(part)}+")
    rig.start(*program)
    rig.bench.run("10 s")
    assert rig.asks("Z", "F", "V1") == ["Y", "B", "B"]
    assert rig.levels("mov", "ramp", "rdy") == (1, 1, 0)
    rig.bench.run_until(rig.x.pin("mov").is_(0))
    rig.bench.run_until_idle("1 s")
    assert rig.ask("F") == "R"
    assert rig.ask("E") == "Y"
    rig.bench.run("10 s")
    assert rig.asks("Z", "F") == ["Y", "B"]
    obeyed = rig.obeyed("K")
    rig.bench.run("5 s")
    assert rig.pulses()[-1] <= obeyed and rig.level("mov") == 0
    assert rig.ask("F") == "R"


# --------------------------------------------------------------------------------------------------------------- verify
@both
@pytest.mark.fact("GSC-CMD-V-1", "GSC-CMD-V-2")
def test_verify_answers_position_or_inputs_and_outputs_unless_a_program_runs(part: str) -> None:
    rig = base(part)
    rig.run(*STR, "+12", "A3")
    rig.drive("ui1", 0)
    assert rig.asks("V1", "V2") == [shown(part, 12), "V64"]
    assert rig.asks("V3", "V0", "V", "V+1") == ["E2"] * 4
    assert rig.prg(*STR) == ["Y"] * 3
    assert rig.asks("V1", "V2") == [shown(part, 12), "V64"]
    assert rig.listed() == [*STR]
    rig.start("D20")
    assert rig.asks("V1", "V2") == ["B", "B"]


# ---------------------------------------------------------------------------------------------- user inputs and outputs
@both
@pytest.mark.fact("GSC-USERIO-1")
def test_each_input_and_output_has_its_pin_and_its_weight(part: str) -> None:
    rig = base(part, ui1=0, ui2=0, ui3=0)
    pins = [(row.name, row.number) for row in rig.x.sheet.pins if row.name[:2] in ("ui", "uo")]
    assert pins == [("uo1", 31), ("uo2", 33), ("ui1", 34), ("uo3", 35), ("ui2", 36), ("ui3", 37)]
    for number in (1, 2, 3):
        rig.drive(f"ui{number}", 1)
        assert rig.ask("V2") == f"V{1 << number - 1}0"
        rig.drive(f"ui{number}", 0)
        rig.run(f"A{number}")
        assert rig.ask("V2") == f"V0{1 << number - 1}"
        assert rig.ask("I2") == "Y"


@both
@pytest.mark.fact("GSC-USERIO-2")
def test_waits_in_turn_are_a_condition_of_several_inputs(part: str) -> None:
    rig = base(part, ui1=0, ui2=0, ui3=0)
    rig.start(*STR, "W1", "W2", "W3", "+5")
    for pin in ("ui3", "ui1"):
        rig.bench.run("1 s")
        rig.drive(pin, 1)
    rig.bench.run("1 s")
    rig.drive("ui1", 0)  # its wait is over
    rig.drive("ui3", 0)
    rig.drive("ui2", 1)
    rig.bench.run("1 s")
    assert rig.pulses() == [] and rig.level("rdy") == 0
    last = rig.bench.now_ps
    rig.drive("ui3", 1)
    rig.bench.run_until_idle()
    assert len(rig.pulses()) == 5
    assert last + MS + SETUP < rig.pulses()[0] <= last + 2 * MS + SETUP  # a look, and the instruction


@both
@pytest.mark.fact("GSC-USERIO-3")
def test_an_output_of_one_module_times_a_move_of_another(part: str) -> None:
    rig = base(part, "uo1")
    y = rig.bench.add(part, name="y", straps={**NINE_SIX, "chs": 0})
    host = rig.bench.host(y)
    rig.bench.wire("x.uo1", "y.ui1")
    opener = "P" if part == C200 else "Po"
    assert [host.ask(line) for line in (opener, *STR, "W1", "+10", "E")] == ["Y"] * 7
    rig.run("D5", "A1")
    edge = rig.rises("uo1")[0]
    times = y.steps().times_ps.tolist()
    assert len(times) == 10
    assert edge + MS + SETUP < times[0] <= edge + 2 * MS + SETUP  # a look, and the instruction


# --------------------------------------------------------------------------------------------------------- whole system
@both
@pytest.mark.fact("GSC-SYS-ARCH-1")
def test_a_module_needs_nothing_but_straps_and_a_host(part: str) -> None:
    rig = base(part)
    assert rig.asks("F", "I3") == ["R", "Y"]
    rig.run(*FAST, "G500000" if part == C200 else "G+500000", timeout="600 s")
    assert rig.pos() == 500_000
    assert rig.x.findings == []


@both
@pytest.mark.fact("GSC-SYS-FAST-1")
def test_a_program_file_is_sent_verified_and_saved(part: str) -> None:
    file = b"S10\r\nT100\r\nR50\r\nL0\r\n+50\r\nL3\r\n"  # as a DOS program keeps it
    rig = base(part)
    lines = file.decode("ascii").split()
    assert rig.prg(*lines) == ["Y"] * len(lines)
    assert rig.listed() == lines
    assert rig.asks("M", "E") == ["Y", "Y"]
    rig.bench.run_until_idle()
    rig.cycle()
    assert rig.asks("Q", "X") == ["END", "Y"]
    assert "\r\n".join(rig.listed()).encode() + b"\r\n" == file
