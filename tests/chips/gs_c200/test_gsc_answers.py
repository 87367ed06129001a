"""What a GS-C module answers: Y, B, R, E and an error, V and data; one answer for each string.

The checks of a string, in this order: how it came (E1), its letter (E4), its argument (E2), a program that runs (B),
whether it is allowed now (E4), the program memory (E3).
"""

from __future__ import annotations

import re

import pytest
from gsc import C200, C200S, MS, STR, US, Rig, base, both

S = 10**12
IDLE = ("F", "V1", "V2", "I1", "I2", "I3", "K", "Z", "X", "A1", "+5", "V0", "V3", "V", "I0", "F1", "N", "O", "Y", "a1",
        "5", "?", "j", "jc0", "Lo", "S10", "$", "G", "G+", "+A", "H", " ", "END")  # fmt: skip
ENTERING = ("A1", "C2", "D1", "L0", "L2", "S10", "T100", "R10", "+1", "-1", "W1", "A4", "S0", "+0", "U", "K", "V1", "Z",
            "ZZ", "H", "F", "f", "j1", "g+", "G+", "I9", "+0000000000000", "E")  # fmt: skip
RUNNING = ("F", "V1", "V2", "+5", "N", "V9", "F1", "K", "F")
PROGRAM = {C200: "P", C200S: "Po"}  # what begins programming


def refused(rig: Rig, answer: str, *commands: str) -> None:
    """Each of these commands gets this answer."""
    assert {command: rig.ask(command) for command in commands} == dict.fromkeys(commands, answer)


def outputs(digit: int) -> list[str]:
    """Instructions that put an octal digit on the user outputs."""
    return [f"{'A' if digit >> n & 1 else 'C'}{n + 1}" for n in range(3)]


# ------------------------------------------------------------------------------------------------------------- forms
@both
@pytest.mark.fact("GSC-REPLY-1", "GSC-REPLY-2", "GSC-CON-ERROR-WORD", "GSC-CON-V-LETTER")
def test_every_string_gets_one_answer_of_this_form(part: str) -> None:
    form = re.compile(rb"(Y|B|R|E[1-6]|V[0-7]{2}|V[+-]?[0-9]{1,7})\r")
    rig = base(part)
    answers = [rig.wire(f"{line}\r", wait="50 ms") for line in (*IDLE, PROGRAM[part], *ENTERING, *RUNNING)]
    assert len(answers) > 60
    assert [answer for answer in answers if not form.fullmatch(answer)] == []


@both
@pytest.mark.fact("GSC-REPLY-3")
def test_y_confirms_a_command(part: str) -> None:
    assert base(part).wire("I3\r") == b"Y\r"


@both
@pytest.mark.fact("GSC-REPLY-4")
def test_b_refuses_everything_except_f_k_and_z_while_a_program_runs(part: str) -> None:
    rig = base(part, eot=0, home=0, ui1=0)
    program = ["A2", "D100"]
    rig.start(*program)
    refused(rig, "B", "V1", "V2", "Q", "M", "X", "E", "H", "I3", "I1", "A1", PROGRAM[part])
    assert rig.x._running and rig.level("uo2") == 1 and rig.level("uo1") == 0
    assert rig.ask("Z") == "Y"
    assert rig.ask("F") == "R" and rig.listed() == program and rig.ask("V2") == "V62"
    assert rig.ask("X") == "Y" and rig.listed() == []  # M has not written the program


@both
@pytest.mark.fact("GSC-REPLY-5")
def test_f_is_answered_ready_or_busy(part: str) -> None:
    rig = base(part)
    assert rig.wire("F\r") == b"R\r"
    rig.start("D100")
    assert rig.wire("F\r") == b"B\r"
    rig.bench.run_until_idle()
    assert rig.wire("F\r") == b"R\r"


@both
@pytest.mark.fact("GSC-REPLY-6", "GSC-CON-ERROR-WORD")
def test_an_error_is_e_and_a_digit(part: str) -> None:
    assert base(part).wire("V9\r", wait="1 s") == b"\x45\x32\x0d"


@both
@pytest.mark.fact("GSC-REPLY-13")
def test_each_line_of_a_program_is_answered_on_its_own(part: str) -> None:
    rig = base(part)
    lines = (PROGRAM[part], *STR, "+5")
    assert [rig.wire(f"{line}\r", wait="1 s") for line in lines] == [b"Y\r"] * 5


@both
@pytest.mark.fact("GSC-REPLY-14")
def test_e_is_answered_immediately_and_rdy_shows_the_end(part: str) -> None:
    rig = base(part, "rdy")
    rig.prg("D50")
    sent = rig.bench.now_ps + 2 * (11 * S // 9600)
    assert rig.obeyed("E") == sent + MS  # a millisecond behind its carriage return
    assert rig.host.answers == ["Y"] and rig.level("rdy") == 0
    rig.bench.run_until_idle()
    assert rig.rises("rdy")[-1] == sent + MS + MS + 5 * S  # D50 takes its time and five seconds


@both
@pytest.mark.fact("GSC-REPLY-14")
def test_h_is_answered_immediately_and_f_shows_the_end(part: str) -> None:
    rig = base(part, "rdy", home=0)
    rig.prg("S10")
    if part == C200S:
        rig.ask("Px")
    else:
        rig.ask("E")
        rig.bench.run_until_idle()
    closed = rig.bench.now_ps + 3 * S
    rig.drive("eot", 0, at=closed)
    start = rig.obeyed("H")
    assert rig.host.answers == ["Y"]
    rig.bench.run_to(start + 2 * S)
    assert rig.ask("F") == "B" and rig.level("rdy") == 0
    rig.bench.run_until_idle()
    first, step = start + 10 * US, 10 * MS  # it ends where the next step would have begun
    assert rig.rises("rdy")[-1] == first + -(-(closed - first) // step) * step
    assert rig.ask("F") == "R"


# ---------------------------------------------------------------------------------------------------------------- data
@pytest.mark.fact("GSC-REPLY-7", "GSC-CON-V-LETTER", "GSC-UND-V1-PAD")
def test_v1_of_a_gs_c200_is_plain_decimal() -> None:
    rig = base(C200)
    assert rig.wire("V1\r") == b"V0\r"
    rig.run("S10", "T1000", "R10", "+1234")
    assert rig.wire("V1\r") == b"V1234\r"
    rig.run("S10", "T1000", "R10", "G1234567")
    assert rig.wire("V1\r") == b"V1234567\r"


@pytest.mark.fact("GSC-REPLY-7", "GSC-UND-V1-PAD")
def test_v1_of_a_gs_c200_can_have_leading_zeros() -> None:
    rig = base(C200, options={"pad7": True})
    assert rig.wire("V1\r") == b"V0000000\r"
    rig.run("S10", "T1000", "R10", "+1234")
    assert rig.wire("V1\r") == b"V0001234\r"
    assert base(C200S, options={"pad7": True}).wire("V1\r") == b"V+0\r"


@pytest.mark.fact("GSC-REPLY-8", "GSC-CON-V-LETTER", "GSC-UND-V1-PAD")
def test_v1_of_a_gs_c200s_has_a_sign_and_no_leading_zeros() -> None:
    rig = base(C200S)
    for command, answer in (("f+1234", b"V+1234\r"), ("f-1", b"V-1\r"), ("I1", b"V+0\r"), ("f-0", b"V+0\r")):
        assert rig.ask(command) == "Y"
        assert rig.wire("V1\r") == answer


@pytest.mark.fact("GSC-REPLY-9", "GSC-CON-V-LENGTH")
def test_an_answer_may_have_eight_characters_after_the_v() -> None:
    rig = base(C200S, chs=1)
    assert rig.wire(b"f-8388608\x1c\r") == b"YY\r"
    assert rig.wire(b"V1\x17\r") == b"V-8388608|\r"


@both
@pytest.mark.fact("GSC-REPLY-10", "GSC-CON-V2-LEGEND")
def test_v2_is_an_octal_digit_for_the_inputs_and_one_for_the_outputs(part: str) -> None:
    rig = base(part)
    for shown in range(8):
        rig.run(*outputs(shown))
        for seen in range(8):
            for n in range(3):
                rig.drive(f"ui{n + 1}", seen >> n & 1)
            assert rig.wire("V2\r") == f"V{seen}{shown}\r".encode()


@both
@pytest.mark.fact("GSC-REPLY-11", "GSC-REPLY-12", "GSC-CON-V2-LEGEND", "GSC-CON-V-LETTER")
def test_v36_and_v25_mean_these_pins(part: str) -> None:
    for levels, program, answer in (
        ((1, 1, 0, 0, 1, 1), ["A2", "A3"], b"V36?\r"),
        ((0, 1, 0, 1, 0, 1), ["A1", "A3"], b"V25=\r"),
    ):
        rig = base(part, chs=1, ui1=levels[0], ui2=levels[1], ui3=levels[2])
        rig.run(*program)
        assert rig.wire("V2\x18\r") == answer
        assert rig.levels("ui1", "ui2", "ui3", "uo1", "uo2", "uo3") == levels
        rig.drive("chs", 0)
        assert rig.wire("V2\r") == answer[:3] + b"\r"


@both
@pytest.mark.fact("GSC-UND-OPEN-INPUTS")
def test_open_inputs_read_1(part: str) -> None:
    rig = base(part)
    pins = ("sel0", "sel1", "sel2", "rec", "enable", "eot", "home", "ui1", "ui2", "ui3")
    assert rig.levels(*pins) == (1,) * 10
    assert rig.ask("V2") == "V70"
    rig.run(*STR, "+5", "W1", "-2")  # ENABLE does not hold, UI1 is high
    assert rig.pos() == 3
    rig.ask("H")
    rig.bench.run("60 s")
    assert rig.x.moving  # no switch is closed


# -------------------------------------------------------------------------------------------------------------- errors
@both
@pytest.mark.fact("GSC-ERR-3")
def test_e2_an_argument_out_of_its_limits(part: str) -> None:
    rig = base(part)
    refused(rig, "E2", "I0", "I4", "V0", "V3")
    rig.prg()
    refused(rig, "E2", "A0", "A4", "C0", "C4", "D0", "D256", "L256", "R0", "R1000", "S0", "S1001", "T0", "T1001")
    refused(rig, "E2", "U0", "U4", "W0", "W4", "+0", "-0", "+1000000", "-1000000")
    refused(rig, "E2", *(("G10000000", "G+0", "G-4") if part == C200 else ("G+8388608", "G-8388609", "j119", "jc8,0")))
    refused(rig, "Y", "A3", "C1", "D255", "L255", "R999", "S1000", "T1000", "U3", "W3", "+999999", "-1")
    refused(rig, "Y", *(("G9999999", "G0") if part == C200 else ("G+8388607", "G-8388608", "j118", "jc7,118")))


@both
@pytest.mark.fact("GSC-ERR-4")
def test_e2_a_superfluous_argument(part: str) -> None:
    refused(base(part), "E2", "E1", "F1", "K1", "M1", "Q1", "X1", "Z1", "H+1", "H1", "E ")


@both
@pytest.mark.fact("GSC-ERR-5")
def test_e2_an_argument_that_is_missing_or_malformed(part: str) -> None:
    rig = base(part)
    bad = (
        "A",
        "D",
        "I",
        "R",
        "S",
        "T",
        "U",
        "V",
        "W",
        "+",
        "-",
        "++5",
        "A1.5",
        "S1 0",
        "A+1",
        "L",
        "L-1",
        "A1,",
        "+-5",
    )
    refused(rig, "E2", *bad)
    rig.prg()
    refused(rig, "E2", *bad)
    assert rig.listed() == []


@both
@pytest.mark.fact("GSC-ERR-6")
def test_e3_an_instruction_that_does_not_fit(part: str) -> None:
    rig = base(part)
    assert rig.prg(*["A1"] * 59) == ["Y"] * 59  # 118 of 119 locations
    refused(rig, "E3", "A1", "+5", "S10")
    assert rig.codes == ["E3"] * 3 and len(rig.listed()) == 59


@both
@pytest.mark.fact("GSC-ERR-7")
def test_e4_an_unknown_or_presently_impossible_command(part: str) -> None:
    rig = base(part)
    refused(rig, "E4", "N1", "O", "Y", "a1", "5", "?", "B", "O1", "+100", "A1", "S10", "E")
    rig.prg("S10")
    refused(rig, "E4", "N1", "Y", "H")
    assert rig.listed() == ["S10"]


@both
@pytest.mark.fact("GSC-ERR-8")
def test_e5_reports_once_that_the_counter_of_a_gs_c200_overflowed(part: str) -> None:
    rig = base(part, "rdy", "clock")
    start = rig.run(*STR, "-1")
    assert rig.level("rdy") == 1
    if part == C200:
        assert rig.rises("rdy", start) == [start + 4 * MS]  # S, T, R and the refused -1 take a millisecond each
        assert rig.falls("clock") == [] and rig.asks("F", "F") == ["E5", "R"]
    else:
        assert len(rig.falls("clock")) == 1 and rig.asks("F", "V1") == ["R", "V-1"]


@both
@pytest.mark.fact("GSC-ERR-9")
def test_e6_the_eeprom_was_not_programmed(part: str) -> None:
    rig = base(part)
    rig.prg("A1", "D5")
    rig.x.eeprom_fault = True
    assert rig.ask("M") == "E6"
    assert rig.listed() == ["A1", "D5"]
    rig.x.eeprom_fault = False
    assert rig.ask("M") == "Y"
    assert rig.ask("X") == "Y" and rig.listed() == ["A1", "D5"]


@both
@pytest.mark.fact("GSC-ERR-10", "GSC-UND-CHECK-ORDER")
def test_the_order_of_the_checks(part: str) -> None:
    rig = base(part, chs=1)
    assert rig.wire("N1@\r") == b"E1v\r"  # before the letter
    assert rig.wire("N1\x7f\r") == b"E4y\r"
    assert rig.wire("A4u\r") == b"E2w\r"  # the argument before what is allowed now
    assert rig.wire("A3t\r") == b"E4y\r"
    rig.prg("S10", *["A1"] * 57)
    assert rig.asks("A4", "N1", "H", "H2", "A3") == ["E2", "E4", "E4", "E2", "E3"]  # the memory last


@both
@pytest.mark.fact("GSC-ERR-12", "GSC-UND-BUSY-PRIORITY", "GSC-UND-CHECK-ORDER")
def test_a_running_program_answers_e1_to_damaged_lines_and_b_to_the_rest(part: str) -> None:
    rig = base(part, chs=1)
    rig.start("D50")
    assert rig.wire("V1@\r") == b"E1v\r"
    assert rig.wire(b"V1\x17\r") == b"BR\r"
    rig.host.write("V")
    rig.host.write("1", "parity")
    assert rig.wire(b"\x17\r") == b"E1v\r"
    refused(rig, "B", "N1", "A9", "F1", "K1", "?", "+", "A1", "E")
    assert rig.codes == ["E1", "E1", "busy"]
    assert rig.x._running and rig.ask("K") == "Y"


@both
@pytest.mark.fact("GSC-ERR-11")
def test_a_refused_command_has_no_effect_and_may_be_sent_again(part: str) -> None:
    rig = base(part)
    assert rig.prg(*STR, "+0", "+5") == ["Y", "Y", "Y", "E2", "Y"]
    assert rig.listed() == [*STR, "+5"]


@both
@pytest.mark.fact("GSC-ERR-13", "GSC-UND-P-ALIASES")
def test_a_command_of_the_other_part_is_unknown(part: str) -> None:
    rig = base(part)
    others = {C200: ("f+0", "g+", "g+1", "j0", "jc0,0", "Po", "P0", "Px"), C200S: ("P", "P0")}[part]
    refused(rig, "E4", *others)
    rig.prg()
    refused(rig, "E4", *others)
    assert rig.listed() == []


@both
@pytest.mark.fact("GSC-UND-P-ALIASES")
def test_a_lenient_gs_c200s_takes_p0_for_po(part: str) -> None:
    rig = base(part, options={"lenient": True})
    if part == C200S:
        assert rig.asks("P0", "A1", "P") == ["Y", "Y", "E4"]
        assert rig.listed() == ["A1"]
    else:
        assert rig.asks("P0", "Po", "P") == ["E4", "E4", "Y"]


@both
@pytest.mark.fact("GSC-ERR-14")
def test_letters_have_a_case_and_blanks_are_not_part_of_the_language(part: str) -> None:
    rig = base(part)
    unknown = ("a1", "s10", "k", "e", "J5", " S10", " F", "p", "l5")
    refused(rig, "E4", *unknown)
    rig.prg()
    refused(rig, "E4", *unknown)
    refused(rig, "E2", "S 10", "S10 ", "A1 ", "+ 5")
    assert rig.listed() == []


@both
@pytest.mark.fact("GSC-ERR-15")
def test_leading_zeros_are_accepted(part: str) -> None:
    rig = base(part)
    assert rig.prg("S010", "T0100", "R0010", "+000005", "D007") == ["Y"] * 5
    assert rig.listed() == ["S10", "T100", "R10", "+5", "D7"]
