"""The CY545: how commands and numbers are written, and what each of them does."""

from __future__ import annotations

import pytest
from cy545 import MS, US, Rig545

from slewline.chips.cy545 import sheet
from slewline.chips.cy545.sheet import CY545, CY545B, EIGHT
from slewline.errors import UsageError

LEGAL = {  # every command with a legal parameter; E, Q, X, 0 and branches: where programs are tested
    "A": "A 5", "B": "B 1", "C": "C", "D": "D 1", "F": "F 20", "G": "G", "H": "H 16", "I": "I", "N": "N 3",
    "O": "O 81H", "P": "P 9", "R": "R 9", "S": "S 9", "W": "W 1", "Y": "Y 9", "+": "+", "-": "-", "?": "? R",
    "[": "[1,1,2", '"': '"a"',
}  # fmt: skip


@pytest.fixture
def rig() -> Rig545:
    return Rig545("pulse", "busy", "ccw", "stopped", "txd")


# -------------------------------------------------------------------------------------------------------------- forms
@pytest.mark.fact("CY545-LANG-FORM-1", "CY545-CMD-PLUS-1")
def test_a_command_without_parameter_is_a_letter_and_a_return(rig: Rig545) -> None:
    rig.send("+")
    assert rig.level("ccw") == 1
    rig.send("\r")
    assert rig.level("ccw") == 0
    rig.send("-\r")
    assert rig.level("ccw") == 1
    assert not rig.falls("pulse")


@pytest.mark.fact("CY545-LANG-FORM-2")
@pytest.mark.parametrize("between", [",", " "])
def test_parameters_are_separated_by_a_comma_or_a_space(between: str) -> None:
    rig = Rig545()
    rig.enter("P 10", "P 0", f"L 3{between}0", "0")
    rig.run_program()
    assert len(rig.x.steps()) == 60
    assert not rig.codes


@pytest.mark.fact("CY545-LANG-NUM-1", "CY545-LANG-NUM-2", "CY545-QUERY-1")
@pytest.mark.parametrize(("written", "meant"), [("135", 135), ("87H", 135), ("0ABH", 171), ("00087H", 135)])
def test_a_number_is_decimal_or_hexadecimal_with_a_leading_digit_and_a_trailing_h(
    rig: Rig545, written: str, meant: int
) -> None:
    assert rig.say(f"R {written}", "? R") == f"R={meant:05}\r"
    assert not rig.codes


@pytest.mark.fact("CY545-LANG-NUM-2", "CY545-UND-ILLEGAL", "CY545-UND-LOWERCASE")
@pytest.mark.parametrize("written", ["ABH", "0AB", "87h", "0abH", "-1", "1.5", ""])
def test_a_command_with_an_invalid_number_is_ignored_and_reported(rig: Rig545, written: str) -> None:
    assert rig.say(f"R {written}", "? R") == "R=00100\r"
    assert rig.codes in (["bad-number"], ["missing-argument"])


@pytest.mark.fact("CY545-UND-ILLEGAL")
def test_surplus_parameters_are_ignored_and_the_command_is_performed(rig: Rig545) -> None:
    assert rig.say("R 5 6", "+ 1", "? R") == "R=00005\r"
    assert rig.codes == ["extra-argument", "extra-argument"]
    assert rig.level("ccw") == 0


@pytest.mark.fact("CY545-THUMB-7")
def test_only_the_first_parameter_may_come_from_switches(rig: Rig545) -> None:
    rig.say("Y 100", "L 3,#")
    assert rig.codes == ["bad-number"]
    assert rig.x.registers["pointer"] == 100


@pytest.mark.fact("CY545-LANG-NUM-3")
def test_a_number_has_any_number_of_digits(rig: Rig545) -> None:
    assert rig.say("N 0000000000200", "? N", "R 00087H", "? R") == "N=00000200\rR=00135\r"
    assert not rig.codes


@pytest.mark.fact("CY545-UND-RANGE", "CY545-LANG-NUM-3")
@pytest.mark.parametrize(
    ("command", "answer"), [("R 300", "R=00044\r"), ("N 16777217", "N=00000001\r"), ("Y 65546", "Y=00010\r")]
)
def test_of_a_number_that_is_too_large_the_low_bits_count(rig: Rig545, command: str, answer: str) -> None:
    assert rig.say(command, f"? {command[0]}") == answer
    assert rig.codes == ["range"]
    assert f"only its low bits are used: {int(answer[2:])}" in rig.x.findings[0].text


@pytest.mark.fact("CY545-UND-RANGE")
def test_of_too_large_a_number_of_lines_the_low_bits_count(rig: Rig545) -> None:
    rig.enter("G", "+", "-")
    assert rig.say("Y 0", "? M,258") == rig.say("? M,2")
    assert rig.codes == ["range"]


@pytest.mark.fact("CY545-LANG-WIDTH-1", "CY545-CON-MAX-STEPS", "CY545-CMD-N-1")
def test_positions_and_numbers_have_24_bits(rig: Rig545) -> None:
    assert rig.say("A 16777215", "? P", "N 16777215", "? N") == "P=16777215\rN=16777215\r"
    rig.say("A 16777214", "P 16777215")
    assert len(rig.x.steps()) == 1
    assert not rig.codes


@pytest.mark.fact("CY545-LANG-WIDTH-1")
def test_widths_are_in_the_sheet() -> None:
    sizes = {row.form: [arg.size for arg in row.args] for row in CY545.commands}
    assert all(sizes[letter] == [1] for letter in "BFHJORSW")
    assert sizes["T"] == sizes["L"] == [1, 1]
    assert sizes["D"] == sizes["Y"] == [2]
    assert sizes["Z"] == [2, 1]
    assert sizes["A"] == sizes["N"] == sizes["P"] == [3]


@pytest.mark.fact("CY545-LANG-SET-1", "CY545-CON-INSTR-COUNT")
def test_there_are_28_commands_and_a_prefix() -> None:
    assert [row.form for row in CY545B.commands] == [*'ABCDEFGHIJLNOPQRSTWXYZ+-?0["']
    assert CY545B.commands is CY545.commands


@pytest.mark.fact("CY545-LANG-SET-1")
@pytest.mark.parametrize("command", LEGAL.values(), ids=lambda text: text[:1])
def test_a_legal_command_is_taken_without_a_finding(command: str) -> None:
    rig = Rig545()
    rig.host.send(f"-\r{command}\r")
    rig.bench.run("2 s")
    assert not rig.codes


@pytest.mark.fact("CY545-LANG-SET-1", "CY545-UND-LETTER", "CY545-CON-L-SUMMARY")
@pytest.mark.parametrize("letter", ["K", "M", "U", "V", "r", "1", "~"])
def test_an_unknown_letter_takes_its_line_along(rig: Rig545, letter: str) -> None:
    before = rig.x.registers
    assert rig.say(f"{letter} 5R 9", "? R") == "R=00100\r"
    assert rig.x.registers == before
    assert rig.codes == ["unknown-command"]
    assert not rig.falls("pulse")


@pytest.mark.fact("CY545-UND-LF")
def test_a_line_feed_swallows_the_next_command(rig: Rig545) -> None:
    rig.send("R 5\r\nR 6\r")
    assert rig.say("? R") == "R=00005\r"
    assert rig.codes == ["line-feed"]


@pytest.mark.fact("CY545-UND-EMPTY-LINE")
def test_an_empty_line_has_no_effect(rig: Rig545) -> None:
    rig.send("\r\r\rR 5\r\r")
    assert rig.say("? R") == "R=00005\r"
    assert not rig.codes


@pytest.mark.fact("CY545-UND-SPACING")
@pytest.mark.parametrize("line", ["R5", "R  5", "R 5 "])
def test_spacing_is_tolerated_and_reported(rig: Rig545, line: str) -> None:
    assert rig.say(line, "? R") == "R=00005\r"
    assert rig.codes == ["spacing"]


# --------------------------------------------------------------------------------------------------------- parameters
@pytest.mark.fact("CY545-CMD-A-1", "CY545-QUERY-2")
def test_a_sets_the_position_without_a_motion(rig: Rig545) -> None:
    assert rig.say("A 1234", "? P") == "P=00001234\r"
    assert not rig.falls("pulse") and not rig.falls("stopped")


@pytest.mark.fact("CY545-CMD-F-1", "CY545-CMD-R-1", "CY545-CMD-S-1")
def test_f_r_and_s_are_kept(rig: Rig545) -> None:
    assert rig.say("F 255", "R 0", "S 1", "? F", "? R", "? S") == "F=00255\rR=00000\rS=00001\r"


@pytest.mark.fact("CY545-CMD-G-1", "CY545-CMD-G-2")
def test_g_takes_the_steps_of_n_in_the_direction_set_last_and_n_stays(rig: Rig545) -> None:
    assert rig.say("A 100", "N 7", "-", "G", "? P", "G", "+", "G", "? P") == "P=00000093\rP=00000093\r"
    assert len(rig.falls("pulse")) == 21


@pytest.mark.fact("CY545-CMD-P-1")
def test_p_goes_to_a_position_and_finds_the_direction_itself(rig: Rig545) -> None:
    assert rig.say("A 0", "P 40", "P 15", "? P") == "P=00000015\r"
    assert rig.x.steps().directions.tolist() == [1] * 40 + [-1] * 25
    assert len(rig.falls("pulse")) == 65


@pytest.mark.fact("CY545-UND-P-DIRECTION")
def test_p_keeps_the_direction_and_p_to_the_present_position_causes_no_motion(rig: Rig545) -> None:
    rig.say("A 10", "P 5", "N 1", "G")
    assert rig.x.position == 4
    rig.say("P 4")
    assert len(rig.falls("stopped")) == 2
    assert rig.level("ccw") == 0
    rig.say("G")
    assert rig.x.position == 5


@pytest.mark.fact("CY545-UND-WRAP", "CY545-RESET-3")
def test_the_position_wraps_within_24_bits(rig: Rig545) -> None:
    assert rig.say("N 5", "G", "? P") == "P=16777211\r"
    assert rig.say("+", "G", "G", "? P") == "P=00000005\r"


@pytest.mark.fact("CY545-UND-N-ZERO")
def test_g_with_n_0_takes_no_step(rig: Rig545) -> None:
    rig.say("N 0", "-", "G")
    assert not rig.falls("pulse") and not rig.falls("stopped")
    assert rig.codes == ["no-steps"]


@pytest.mark.fact("CY545-CMD-C-1")
def test_c_alone_starts_nothing(rig: Rig545) -> None:
    rig.say("C")
    rig.bench.run("1 s")
    assert not rig.falls("pulse")
    rig.host.send("N 10\rG\r")
    rig.bench.run("1 s")
    assert len(rig.falls("pulse")) > 100


@pytest.mark.fact("CY545-CMD-D-1", "CY545-HS-8")
@pytest.mark.parametrize(("crystal", "lasts"), [("12 MHz", 500), ("11 MHz", 500 * 12 / 11)])
def test_d_waits_milliseconds_at_12_mhz(crystal: str, lasts: float) -> None:
    rig = Rig545("busy", crystal=crystal)
    start = rig.bench.now_ps
    rig.say("D 500")
    falls = rig.falls("busy", start)
    rises = [rise for rise in rig.rises("busy", start) if rise > falls[0]]
    phases = [(up - down) / MS for down, up in zip(falls, rises, strict=True)]
    assert phases[-1] == pytest.approx(lasts, rel=0.02)
    assert max(phases[:-1]) < 1


@pytest.mark.fact("CY545-CMD-D-1")
def test_a_delay_may_last_for_65_seconds(rig: Rig545) -> None:
    start = rig.bench.now_ps
    rig.say("D 65535")
    assert (rig.bench.now_ps - start) / MS == pytest.approx(65535, rel=0.02)


# --------------------------------------------------------------------------------------------------------------- bits
@pytest.mark.fact("CY545-CMD-B-1", "CY545-BIT-1")
def test_b_sets_and_clears_each_user_bit(rig: Rig545) -> None:
    rig.say("O 80H")
    for bit in range(8):
        rig.say(f"B {16 + bit}")
        assert [rig.level(f"usrb{n}") for n in range(8)] == [int(n != bit) for n in range(8)]
        rig.say(f"B {bit}")
    assert rig.user == "111111"


@pytest.mark.fact("CY545-CMD-B-2", "CY545-UND-BIT-BUS")
def test_bits_of_the_data_bus_are_outputs_until_the_next_bus_cycle() -> None:
    rig = Rig545(replies=False, serial=True, memory=None, fixed_baud=9600)
    rig.serial.send("B 27\r")
    rig.bench.run_until_idle()
    assert [n for n in range(8) if rig.level(f"db{n}") == 0] == [3]
    rig.serial.send("B 11\r")
    rig.bench.run_until_idle()
    assert rig.level("db3") != 0
    rig.serial.send("B 24\r[1,1,65\r")
    rig.bench.run_until_idle()
    assert rig.level("db0") != 0
    assert rig.x._bits.bus_latch == 0xFF


@pytest.mark.fact("CY545-UND-BIT-BUS")
def test_a_bit_of_the_bus_in_a_program_is_reported() -> None:
    rig = Rig545()
    rig.enter("B 24", "0")
    rig.run_program()
    assert rig.codes == ["bus-bit"]


@pytest.mark.fact("CY545-CMD-B-3")
def test_bit_5_of_the_argument_has_no_effect_on_single_bits(rig: Rig545) -> None:
    rig.say("B 30H")
    assert rig.user == "111110"
    rig.say("B 20H")
    assert rig.user == "111111"


@pytest.mark.fact("CY545-CMD-B-4", "CY545-CMD-B-5")
def test_the_six_free_bits_are_written_anded_and_ored_together() -> None:
    rig = Rig545(*(f"usrb{n}" for n in range(8)))
    start = rig.bench.now_ps
    rig.say("B 6AH")
    assert rig.user == "101010"
    assert len({instant for n in (0, 2, 4) for instant in rig.falls(f"usrb{n}", start)}) == 1
    rig.say("B 7FH", "B 8FH")
    assert rig.user == "001111"
    rig.say("B 0F0H")
    assert rig.user == "111111"
    assert not rig.edges("usrb7", start)


@pytest.mark.fact("CY545-CMD-SLASH-1", "CY545-CMD-SLASH-2")
def test_a_slash_inverts_bit_4_of_the_argument(rig: Rig545) -> None:
    rig.say("/B 2")
    assert rig.user == "111011"
    rig.say("/B 12H")
    assert rig.user == "111111"
    rig.say("/B 40H")
    assert rig.user == "010000"
    assert not rig.codes


@pytest.mark.fact("CY545-UND-SLASH")
def test_a_slash_in_front_of_another_command_is_ignored(rig: Rig545) -> None:
    assert rig.say("/R 5", "? R") == "R=00005\r"
    assert rig.codes == ["slash"]


@pytest.mark.fact("CY545-UND-BIT-INPUT", "CY545-QUERY-4")
def test_a_bit_whose_latch_is_high_is_an_input(rig: Rig545) -> None:
    rig.say("O 80H")
    rig.drive("usrb3", 0)
    rig.bench.run("1 us")
    assert rig.level("usrb3") == 0
    assert not rig.codes
    rig.say("B 0C4H", "B 0BFH")  # OR and AND read the latch, not the pin: bit 3 is not cleared by them
    rig.x.pin("usrb3").release()
    rig.bench.run("1 us")
    assert rig.level("usrb3") == 1
    assert rig.x._bits.word & 0xFF == 0xFF


@pytest.mark.fact("CY545-QUERY-4")
def test_the_query_of_bits_has_the_user_bits_low_and_the_bus_high() -> None:
    rig = Rig545(replies=False, serial=True, memory=None, fixed_baud=9600)
    assert rig.serial.ask("? B") == "B=65535"
    rig.drive("usrb0", 0)
    assert rig.serial.ask("? B") == "B=65534"
    rig.drive("db7", 0)
    assert rig.serial.ask("? B") == f"B={0x7FFE:05}"


@pytest.mark.fact("CY545-BIT-1", "CY545-UND-BIT-SHARED")
@pytest.mark.parametrize(("mode", "sixth", "told"), [("0A0H", "CTS", True), ("0A1H", "FPL", True), ("80H", "", False)])
def test_usrb6_is_fpl_or_cts_or_a_user_bit(rig: Rig545, mode: str, sixth: str, told: bool) -> None:
    rig.say(f"O {mode}", "B 22", "B 7FH", "B 16")
    assert rig.x._bits.shared == sixth
    assert rig.level("usrb6") == int(sixth == "FPL")
    assert rig.user == "111110"
    assert rig.codes == ["shared-bit"] * told
    rig.say("O 80H")
    assert rig.level("usrb6") == 0


MATCHES = {  # argument -> levels of USRB5 ... USRB0 that match, and some that do not
    "3": (["001000", "111111"], ["110111"]),
    "13H": (["110111"], ["001000"]),
    "2AH": ([], []),
    "23H": (["001000"], ["000000"]),
    "4AH": (["001010"], ["001011", "101010"]),
    "8AH": (["001010", "111111"], ["001000", "110101"]),
    "0CAH": (["001000", "000010"], ["110101"]),
}


@pytest.mark.fact("CY545-UND-BIT-MATCH", "CY545-CMD-W-1")
@pytest.mark.parametrize("argument", [name for name in MATCHES if name != "2AH"])
def test_w_waits_until_the_bits_match(argument: str) -> None:
    rig = Rig545()
    good, bad = MATCHES[argument]
    for wrong in bad:
        for right in good:
            put(rig, wrong)
            rig.host.send(f"W {argument}\r")
            rig.bench.run("5 ms")
            assert rig.level("busy") == 0
            put(rig, right)
            rig.bench.run("1 ms")
            assert rig.level("busy") == 1


def put(rig: Rig545, levels: str) -> None:
    for bit, level in zip((5, 4, 3, 2, 1, 0), levels, strict=True):
        rig.drive(f"usrb{bit}", int(level))


@pytest.mark.fact("CY545-UND-BIT-MATCH")
def test_w_waits_for_a_bit_of_the_data_bus() -> None:
    rig = Rig545(replies=False, serial=True, memory=None, fixed_baud=9600)
    rig.serial.send("W 1AH\r")
    rig.bench.run("50 ms")
    assert not rig.x.idle
    rig.drive("db2", 0)
    rig.bench.run("1 ms")
    assert rig.x.idle


# ------------------------------------------------------------------------------------------------------------ strings
@pytest.mark.fact("CY545-CMD-STR-1", "CY545-UND-STRING-END")
def test_characters_between_quotes_are_sent_unchanged(rig: Rig545) -> None:
    assert rig.say('"Hello, 5"') == "Hello, 5"
    assert rig.say('"a;\\ b"x', '""') == "a;\\ b"
    assert rig.codes == ["extra-argument"]


@pytest.mark.fact("CY545-UND-QUERY-LETTERS")
def test_only_some_letters_may_be_queried(rig: Rig545) -> None:
    letters = {letter for letter in "ABCDEFGHIJKLNOPQRSTUVWXYZ" if rig.say(f"? {letter}")}
    assert letters == set("PNRFSOYB")
    assert set(rig.codes) == {"unknown-query"}


@pytest.mark.fact("CY545-SYS-2")
def test_no_command_reports_errors(rig: Rig545) -> None:
    rig.say("R ABH", "U")
    assert rig.say("?", "? E", "? X") == ""
    assert not any("error" in row.description for row in CY545.commands)
    assert not any("error" in row.name for row in CY545.registers)


# -------------------------------------------------------------------------------------------------------------- times
@pytest.mark.fact("CY545-UND-CMD-TIME", "CY545-UND-HS-TIMING")
@pytest.mark.parametrize(("line", "digits"), [("+", 0), ("R 5", 1), ("N 1234567", 7)])
def test_a_command_takes_100_us_and_20_for_each_digit(rig: Rig545, line: str, digits: int) -> None:
    start = rig.bench.now_ps
    rig.say(line)
    last = rig.rises("busy", start)[-1] - rig.falls("busy", start)[-1]
    assert last / US == pytest.approx(100 + 20 * digits, abs=0.2)


@pytest.mark.fact("CY545-UND-D-ZERO")
def test_d_0_takes_the_time_of_a_command(rig: Rig545) -> None:
    start = rig.bench.now_ps
    rig.say("D 0")
    last = rig.rises("busy", start)[-1] - rig.falls("busy", start)[-1]
    assert last / US == pytest.approx(120, abs=0.2) and rig.codes == ["range"]


@pytest.mark.fact("CY545-UND-HS-TIMING")
def test_the_time_of_a_command_is_an_option() -> None:
    rig = Rig545("busy", inferred={"command": 12_000})
    start = rig.bench.now_ps
    rig.say("+")
    assert rig.rises("busy", start)[-1] - rig.falls("busy", start)[-1] == pytest.approx(MS, abs=US)


@pytest.mark.fact("CY545-UND-CRYSTAL")
@pytest.mark.parametrize(("crystal", "told"), [("1 MHz", []), ("16 MHz", []), ("17 MHz", ["crystal"])])
def test_crystals_from_1_to_16_mhz_are_accepted_silently(crystal: str, told: list[str]) -> None:
    assert Rig545(crystal=crystal).codes == told
    with pytest.raises(UsageError, match="1 to 16 MHz"):
        Rig545(crystal="20 MHz")


# -------------------------------------------------------------------------------------------------------------- sheet
@pytest.mark.fact("CY545-SYS-3", "CY545-UND-PINS", "CY545-CON-CWW")
def test_eight_pins_belong_to_the_motor_and_no_pin_has_a_number() -> None:
    names = [pin.name for pin in CY545.pins]
    assert len(EIGHT) == 8 and set(EIGHT) <= set(names)
    assert "cww" not in names
    assert not any(pin.number for pin in CY545.pins)
    assert CY545.pins is CY545B.pins


@pytest.mark.fact("CY545-SYS-1")
def test_family_data_of_the_selection_guide() -> None:
    assert CY545.buffer_bytes == 65536
    assert CY545.commands["Z"].args[0].high == 65535
    lines = [pin for pin in CY545.pins if pin.name.startswith(("usrb", "db"))]
    assert len(lines) == 16
    assert not any(pin.role.startswith("phase") for pin in CY545.pins)
    assert {"step", "direction"} <= {pin.role for pin in CY545.pins}


@pytest.mark.fact("CY545-CON-LABELS")
def test_there_are_no_labels() -> None:
    assert not CY545.labels


@pytest.mark.fact("CY545-UND-VARIANT")
def test_the_two_parts_differ_in_three_things() -> None:
    same = ("pins", "commands", "registers", "options", "times", "limits", "rates", "dialect")
    for name in same[:-1]:
        assert getattr(CY545, name) == getattr(CY545B, name)
    assert set(sheet.DIFFERENCES) == {"FPL", "BUSY", "immediate commands"}
    assert CY545.channels[0] != CY545B.channels[0]


@pytest.mark.fact("CY545-UND-ILLEGAL", "CY545-UND-SPACING")
@pytest.mark.parametrize(
    ("asked", "code"),
    [("? R 5", "extra-argument"), ("? R,A", "extra-argument"), ("?R", "spacing"), ("?  R", "spacing")],
)
def test_a_query_with_too_much_or_oddly_spaced_is_answered_and_reported(rig: Rig545, asked: str, code: str) -> None:
    assert rig.say(asked) == "R=00100\r"
    assert rig.codes == [code]


def test_missing_parts_of_a_command_are_reported(rig: Rig545) -> None:
    rig.send('"open\r')
    assert rig.x.waiting.endswith("'\"open\\r' has arrived without its quotation mark")
    rig.send('"')
    assert rig.x.waiting.endswith("'\"open\\r' has arrived without its carriage return")
    rig.send("\rR 1")
    assert rig.x.waiting.endswith("'R 1' has arrived without its carriage return")
