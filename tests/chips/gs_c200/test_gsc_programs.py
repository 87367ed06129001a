"""Programming sessions of the GS-C modules: what is stored, what it costs, how it is listed, started and refused."""

from __future__ import annotations

import pytest
from gsc import C200, C200S, MS, STR, US, base, both, gaps

from slewline.language.lines import framed

STEP = ("+1",)
PINS = ("clock", "mov", "ramp", "dir", "uo1", "uo2", "uo3")
BAR = "S10 T100 R40 W1 +250 L0 A2 D1 C2 W2 +120 L4 A2 C2 W2 +250 A1 D5 C1"
HOLE = "W1 W2 A2 +150 D1 G0 C2 A1 D1 C1"
PROGRAMS = {  # with the locations that they take
    "bar": (BAR, 50),
    "drill": (f"S15 T200 R25 {HOLE}", 36),
    "bar until": (f"U3 {BAR}", 52),
    "drill five times": (f"S15 T200 R25 L0 {HOLE} L5", 40),
    "ramps": ("S10 T100 R25 +3000 R85 -800", 24),
}
OWN = {
    C200: "S10 T100 R50 G500000 G0 G9999999 G+ G- G+1 G-3 -999999",
    C200S: "S10 T100 R10 jc1,18 jc7,118 j0 G+0 G+500000 G-8388608 g+ g- g+1 g-3 f+0 f-8388608 f+8388607 I1 I3",
}
TWO = {C200: "A1 C1 D1 L0 L1 U1 W1", C200S: "A1 C1 D1 L0 L1 U1 W1 I1 j0 jc0,0"}
FOUR = {C200: "R1 S1 T1 +1 -1 G0 G+ G+1", C200S: "R1 S1 T1 +1 -1 G+0 g+ g+1 f+0"}


def lines_of(part: str, name: str) -> list[str]:
    """A program; the C200S lists the sign of a position."""
    text = OWN[part] if name == "own" else PROGRAMS[name][0]
    return [{"G0": "G+0"}.get(line, line) if part == C200S else line for line in text.split()]


# -------------------------------------------------------------------------------------------------------- begin and end
@both
@pytest.mark.fact("GSC-CMD-E-1", "GSC-CMD-E-2", "GSC-PROG-8", "GSC-SYS-INDEP-1")
def test_execute_ends_the_session_and_runs_the_program_from_its_start(part: str) -> None:
    rig = base(part, "rdy")
    assert rig.prg(*STR, "+5") == ["Y"] * 4
    assert rig.asks("E1", "E") == ["E2", "Y"]
    rig.bench.run_until_idle()
    assert rig.moves() == [5]
    assert rig.rises("rdy")[-1] == rig.pulses()[-1] + 10 * MS  # as soon as the last interval is over
    assert rig.asks("F", "A1", "E") == ["R", "E4", "Y"]
    rig.bench.run_until_idle()
    assert rig.moves() == [10]
    assert rig.listed() == [*STR, "+5"]


@both
@pytest.mark.fact("GSC-CMD-E-3", "GSC-UND-E-EMPTY")
def test_execute_without_a_program_is_refused_and_ends_the_session(part: str) -> None:
    rig = base(part)
    assert rig.ask("E") == "E4"
    assert rig.prg() == []
    assert rig.asks("A1", "E") == ["Y", "Y"]
    rig.bench.run_until_idle()
    assert rig.prg() == []
    assert rig.asks("E", "A1") == ["E4", "E4"]


@pytest.mark.fact("GSC-CMD-P-1")
def test_p_opens_a_session_of_the_c200_and_erases_the_program() -> None:
    rig = base(C200)
    rig.run(*STR, "+5")
    half = rig.bench.now_ps
    assert rig.asks("P1", "Q") == ["E2", "\r".join([*STR, "+5", "END"])]
    assert rig.asks("P", "Q", "A1", "E") == ["Y", "END", "Y", "Y"]
    rig.bench.run_until_idle()
    assert rig.level("uo1") == 1 and rig.pulses(half) == []
    assert rig.asks("Po", "Px") == ["E4", "E4"]


@pytest.mark.fact("GSC-CMD-PO-1", "GSC-SYS-INDEP-1")
def test_po_opens_a_session_of_the_c200s_and_erases_the_program() -> None:
    rig = base(C200S, chs=1)
    rig.run(*STR, "+5")
    assert rig.asks("P", "Q") == ["E4", "\r".join([*STR, "+5", "END"])]
    assert rig.wire(b"Po?\r") == b"YY\r"
    assert rig.asks("Q", "A1", "E") == ["END", "Y", "Y"]
    rig.bench.run_until_idle()
    assert rig.level("uo1") == 1
    assert rig.asks("Po", "Px", "A1") == ["Y", "Y", "E4"]


@pytest.mark.fact("GSC-CMD-PX-1", "GSC-SYS-INDEP-1")
def test_px_ends_a_session_without_a_run() -> None:
    rig = base(C200S, *PINS)
    assert rig.prg(*STR, "+5") == ["Y"] * 4
    assert rig.asks("Px1", "Px") == ["E2", "Y"]
    rig.bench.run("5 s")
    assert rig.pulses() == rig.edges("mov") == []
    assert rig.asks("F", "A1", "E") == ["R", "E4", "Y"]
    rig.bench.run_until_idle()
    assert rig.moves() == [5]


@pytest.mark.fact("GSC-CMD-PX-2", "GSC-UND-PX-IDLE")
def test_px_outside_a_session_changes_nothing() -> None:
    rig = base(C200S)
    rig.run(*STR, "+5")
    assert rig.asks("Px", "F") == ["Y", "R"]
    assert rig.listed() == [*STR, "+5"] and rig.moves() == [5]


# -------------------------------------------------------------------------------------------------------------- listing
@both
@pytest.mark.fact("GSC-CMD-Q-1", "GSC-UND-Q-FORMAT")
def test_query_lists_an_instruction_a_line_and_the_word_end(part: str) -> None:
    program = ("S10", "T100", "R50", "+500000")
    plain, checked = base(part), base(part, chs=1)
    assert plain.prg(*program) == checked.prg(*program) == ["Y"] * 4
    assert plain.wire(b"Q\r") == b"S10\rT100\rR50\r+500000\rEND\r"
    assert checked.wire(framed("Q")) == b"S104\rT100u\rR507\r+500000P\rENDW\r"
    assert plain.ask("Q1") == "E2"


@both
@pytest.mark.fact("GSC-UND-Q-FORMAT")
def test_no_address_precedes_the_lines_of_a_listing(part: str) -> None:
    rig = base(part, sel2=0, sel1=0, sel0=0)
    assert rig.prg(*STR) == ["Y"] * 3
    assert rig.wire(b"7Q\r") == b"S10\rT100\rR10\rEND\r"


@both
@pytest.mark.fact("GSC-CMD-Q-2")
def test_an_empty_program_is_listed_as_end(part: str) -> None:
    assert base(part).wire(b"Q\r") == b"END\r"
    assert base(part, chs=1).wire(b"QQ\r") == b"ENDW\r"


@both
@pytest.mark.fact("GSC-CMD-Q-3", "GSC-UND-Q-FORMAT")
@pytest.mark.parametrize("name", [*PROGRAMS, "own"])
def test_a_listing_sent_back_makes_the_same_program(part: str, name: str) -> None:
    rig = base(part)
    lines = lines_of(part, name)
    assert rig.prg(*lines) == ["Y"] * len(lines)
    stored, listed = rig.x.program, rig.listed()
    assert listed == lines
    assert name == "own" or len(stored) == PROGRAMS[name][1]
    assert rig.prg(*listed) == ["Y"] * len(lines)
    assert rig.listed() == listed and rig.x.program == stored


@both
@pytest.mark.fact("GSC-UND-Q-FORMAT")
def test_a_listing_has_one_spelling(part: str) -> None:
    rig = base(part)
    assert rig.prg("S010", "A01", "Lo", "+007", "G0050") == ["Y"] * 5
    assert rig.listed() == ["S10", "A1", "L0", "+7", "G50" if part == C200 else "G+50"]


# --------------------------------------------------------------------------------------------------------------- memory
@both
@pytest.mark.fact("GSC-PROG-1", "GSC-PROG-3", "GSC-PROG-11", "GSC-CON-CAPACITY", "GSC-SYS-INDEP-1")
def test_the_memory_has_119_locations(part: str) -> None:
    rig = base(part)
    assert rig.prg(*["A1"] * 59) == ["Y"] * 59
    assert rig.asks("A1", "+1", "C1") == ["E3"] * 3
    assert rig.listed() == ["A1"] * 59
    assert rig.prg(*["+1"] * 29) == ["Y"] * 29
    assert rig.asks("+1", "A1", "A1") == ["E3", "Y", "E3"]
    mixed = [*["A1", "C1"] * 15, *["+1"] * 14, "A1"]  # 45 instructions
    assert rig.prg(*mixed) == ["Y"] * 45
    assert len(rig.x.program) == 118


@both
@pytest.mark.fact("GSC-PROG-2", "GSC-SYS-INDEP-1", "GSC-CON-I-BYTES")
def test_instructions_take_two_or_four_locations(part: str) -> None:
    wide, narrow = base(part), base(part)
    assert wide.prg(*STEP * 29) == ["Y"] * 29  # 116 locations
    assert narrow.prg(*STEP * 28) == ["Y"] * 28  # 112
    assert wide.ask("M") == narrow.ask("M") == "Y"
    for cost, commands in ((2, TWO[part]), (4, FOUR[part])):
        for command in commands.split():
            assert wide.prg() == narrow.prg() == []
            assert wide.ask("X") == narrow.ask("X") == "Y"
            assert (command, wide.ask(command)) == (command, "Y" if cost == 2 else "E3")
            fill = ["Y"] * ((119 - 112 - cost) // 2)
            assert (command, narrow.asks(command, *["A1"] * 4)) == (command, ["Y", *fill, *["E3"] * (4 - len(fill))])


@both
@pytest.mark.fact("GSC-PROG-2")
def test_immediate_commands_take_no_location(part: str) -> None:
    rig = base(part)
    assert rig.prg(*STEP * 29) == ["Y"] * 29
    assert rig.asks("F", "V1", "V2", "M") == ["R", "V0" if part == C200 else "V+0", "V70", "Y"]
    assert rig.asks("A1", "A1") == ["Y", "E3"]


@both
@pytest.mark.fact("GSC-PROG-4")
def test_surplus_lines_are_left_out_and_the_session_continues(part: str) -> None:
    rig = base(part)
    rig.run(*STR, "C1")
    assert rig.prg(*STEP * 29) == ["Y"] * 29
    assert rig.asks("+1", "A1", "E") == ["E3", "Y", "Y"]
    rig.bench.run_until_idle()
    assert rig.moves() == [29] and rig.level("uo1") == 1


@both
@pytest.mark.fact("GSC-PROG-5")
def test_a_faulty_line_is_answered_immediately_and_not_stored(part: str) -> None:
    rig = base(part)
    assert rig.prg(*STR) == ["Y"] * 3
    assert rig.wire(b"A1\r", "parity") == b"E1\r"
    assert rig.wire(b"+1234567890123\r") == b"E1\r"
    assert rig.asks("A4", "+0", "S0", "Y", "A1") == ["E2", "E2", "E2", "E4", "Y"]
    assert rig.listed() == [*STR, "A1"]
    assert [found.code for found in rig.x.findings] == ["E1", "E1", "E2", "E2", "E2", "E4"]


@both
@pytest.mark.fact("GSC-PROG-10")
def test_the_modules_have_25_and_29_commands(part: str) -> None:
    rows = base(part).x.sheet.commands
    assert len(list(rows)) == len({row.form for row in rows}) == {C200: 25, C200S: 29}[part]
    letters = {
        C200: "A C D E F G H I K L M P Q R S T U V W X Z ±",
        C200S: "A C D E F f G g H I j jc K L M Po Px Q R S T U V W X Z ±",
    }
    assert {row.head for row in rows} == set(letters[part].split())


# --------------------------------------------------------------------------------------------------- which command when
@both
@pytest.mark.fact("GSC-PROG-6", "GSC-UND-DELAYED-OUTSIDE")
def test_delayed_commands_are_refused_outside_a_session(part: str) -> None:
    rig = base(part, *PINS)
    delayed = [line for line in f"{TWO[part]} {FOUR[part]}".split() if line[0] not in "If"]
    assert len(delayed) == {C200: 15, C200S: 17}[part]
    assert rig.asks(*delayed) == ["E4"] * len(delayed)
    rig.bench.run("1 s")
    assert [pin for pin in PINS if rig.edges(pin)] == []
    assert rig.asks("Q", "E") == ["END", "E4"]
    assert set(rig.x.registers[name] for name in ("start_stop", "top_speed", "ramp")) == {0}


@both
@pytest.mark.fact("GSC-UND-DELAYED-OUTSIDE")
def test_delayed_commands_may_act_immediately_by_option(part: str) -> None:
    rig = base(part, "uo3", options={"direct": True})
    for line in ("A3", *STR, "+5"):
        assert rig.ask(line) == "Y"
        rig.bench.run_until_idle()
    assert rig.level("uo3") == 1 and rig.moves() == [5]
    assert rig.ask("Q") == "END"
    assert rig.prg("C3", "-2") == ["Y", "Y"]  # in a session they are stored all the same
    assert rig.listed() == ["C3", "-2"] and rig.level("uo3") == 1


@both
@pytest.mark.fact("GSC-PROG-7", "GSC-UND-PROG-IMMEDIATE")
def test_which_immediate_commands_a_session_allows(part: str) -> None:
    rig = base(part, *PINS)
    assert rig.prg(*STR) == ["Y"] * 3
    assert rig.asks("F", "V1", "V2") == ["R", "V0" if part == C200 else "V+0", "V70"]
    assert rig.asks("H+", "H-", "H", "K", "Z") == ["E4"] * 5
    assert rig.asks("I1") == (["E4"] if part == C200 else ["Y"])
    assert rig.ask("M") == "Y"
    assert rig.listed() == [*STR] + (["I1"] if part == C200S else [])
    assert rig.prg() == [] and rig.ask("Q") == "END"  # a second opener erases again
    assert rig.asks("X", "A1") == ["Y", "Y"]
    assert rig.listed() == [*STR] + (["I1"] if part == C200S else []) + ["A1"]
    assert [pin for pin in PINS if rig.edges(pin)] == []


# ------------------------------------------------------------------------------------------------------- speeds missing
@both
@pytest.mark.fact("GSC-UND-DEFAULTS")
@pytest.mark.parametrize("missing", ["S10", "T100", "R10"])
def test_a_motion_before_its_speeds_are_known_is_refused(part: str, missing: str) -> None:
    rig = base(part)
    others = [line for line in STR if line != missing]
    assert rig.prg(*others, "+5", missing) == ["Y"] * 4
    assert rig.ask("E") == "E4"
    assert rig.pulses() == [] and rig.ask("F") == "R"
    rig.run(*others, "A1")  # without a motion nothing is missing
    rig.run(missing, "+5", *others)  # and what was executed earlier counts
    assert rig.moves() == [5]
    rig.cycle()
    assert rig.prg("+5") == ["Y"]
    assert rig.ask("E") == "E4"


@pytest.mark.fact("GSC-UND-DEFAULTS")
def test_a_jump_past_the_speeds_ends_the_program_at_the_motion() -> None:
    rig = base(C200S)
    rig.run("j14", *STR, "+5", "A1")
    assert rig.codes == ["no-speed"]
    assert rig.pulses() == [] and rig.levels("uo1", "rdy") == (0, 1)
    assert rig.ask("F") == "R"


@both
@pytest.mark.fact("GSC-UND-PERSIST")
def test_speeds_stay_until_power_off_of_the_module(part: str) -> None:
    rig = base(part, eot=0, home=0)
    rig.run(*STR, "+5")
    assert rig.asks("I3", "H") == ["Y", "Y"]
    rig.bench.run_until_idle()
    assert rig.prg("+7") == ["Y"]  # erases the program that set them
    assert [rig.x.registers[name] for name in ("start_stop", "top_speed", "ramp")] == [10, 100, 10]
    assert rig.ask("E") == "Y"
    rig.bench.run_until_idle()
    assert rig.moves() == [12]


# ----------------------------------------------------------------------------------------------------------- after K, H
@both
@pytest.mark.fact("GSC-CON-KILL-HOME")
def test_after_kill_and_home_only_the_c200_needs_its_program_again(part: str) -> None:
    rig = base(part, eot=0, home=0)
    assert rig.prg(*STR, "+500") == ["Y"] * 4
    assert rig.asks("M", "E", "K", "H") == ["Y"] * 4
    rig.bench.run_until_idle()
    assert rig.pos() == 0
    if part == C200:
        assert rig.asks("Q", "E", "X") == ["END", "E4", "Y"]
    half = rig.bench.now_ps
    assert rig.ask("E") == "Y"
    rig.bench.run_until_idle()
    assert rig.moves(half) == [500]


@both
@pytest.mark.fact("GSC-UND-H-NO-S")
def test_a_homing_goes_at_the_s_at_the_head_of_the_program_or_the_last_one_executed(part: str) -> None:
    rig = base(part)
    assert rig.ask("H") == "E4"
    assert rig.codes == ["E4"]
    rig.run("T100", "S20")
    for program, interval in ((("T50",), 5 * MS), (("S40", "S80"), 2500 * US)):
        rig.run(*program)
        start = rig.bench.now_ps
        assert rig.ask("H") == "Y"
        rig.bench.run("1 s")
        assert rig.ask("K") == "Y"
        assert set(gaps(rig.pulses(start))) == {interval}
