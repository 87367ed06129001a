"""The CY545 in binary: letter, count, data."""

from __future__ import annotations

import pytest
from cy545 import Rig545

from slewline.chips.cy545.sheet import CY545B
from slewline.language.text import Verbatim

SAMPLES = {  # as the manual codes them
    "R 87H": "52 01 87",
    "D 1A3BH": "44 02 3B 1A",
    "N 332211H": "4E 03 11 22 33",
    "Z 0421H,92H": "5A 03 21 04 92",
    "G": "47 00",
    "0": "00 00",
    "Q": "51",
}


@pytest.fixture
def rig() -> Rig545:
    found = Rig545("pulse", "usrb6", "busy")
    found.say("O 1")
    return found


def tell(rig: Rig545, data: str) -> bytes:
    rig.send(bytes.fromhex(data))
    return rig.answer.encode("latin-1")


@pytest.mark.fact("CY545-BIN-1", "CY545-BIN-2", "CY545-MODE-2", "CY545-QUERY-3", "CY545-UND-QUERY-BINARY")
def test_o_with_bit_7_clear_makes_all_that_follows_binary(rig: Rig545) -> None:
    assert tell(rig, "52 01 87 3F 01 52") == b"R=\x00\x87"
    tell(rig, "2B 00")
    assert rig.level("ccw") == 0
    tell(rig, "4E 03 03 00 00 47 00")
    assert len(rig.falls("pulse")) == 3
    assert not rig.codes


@pytest.mark.fact("CY545-BIN-3", "CY545-BIN-4", "CY545-QUERY-3")
def test_numbers_have_all_their_bytes_low_one_first_and_answers_high_one_first(rig: Rig545) -> None:
    assert tell(rig, "4E 03 05 00 00 3F 01 4E") == b"N=\x00\x00\x05"
    assert tell(rig, "4E 03 11 22 33 3F 01 4E") == b"N=\x33\x22\x11"
    before = rig.bench.now_ps
    tell(rig, "44 02 3B 1A")
    assert (rig.bench.now_ps - before) / 10**9 == pytest.approx(6715, rel=0.001)


@pytest.mark.fact("CY545-EXAMPLE-BIN", "CY545-BIN-5")
@pytest.mark.parametrize(("line", "sent"), SAMPLES.items())
def test_commands_are_coded_as_the_manual_codes_them(line: str, sent: str) -> None:
    spoken = CY545B.dialect
    assert isinstance(spoken, Verbatim)
    assert spoken.sent_binary(CY545B, line) == bytes.fromhex(sent)


def test_a_line_of_several_commands_has_them_all_in_binary() -> None:
    spoken = CY545B.dialect
    assert isinstance(spoken, Verbatim)
    assert spoken.sent(CY545B, "QX") == b"QX\r" and spoken.sent_binary(CY545B, "QX") == b"QX\0"


@pytest.mark.fact("CY545-BIN-5")
def test_a_binary_program_stops_at_two_zero_bytes(rig: Rig545) -> None:
    tell(rig, "59 02 00 00 45 00 4E 03 01 00 00 2B 00 47 00 00 00 47 00 51 59 02 00 00 58 00")
    assert rig.ram.content[:13].hex() == "4e030100002b00470000004700"
    assert rig.x.position == 1
    assert rig.x.registers["pointer"] == 11
    assert not rig.codes


@pytest.mark.fact("CY545-BIN-5")
def test_the_character_0_is_unknown_in_binary(rig: Rig545) -> None:
    tell(rig, "30 00")
    assert rig.codes == ["unknown-command"]


@pytest.mark.fact("CY545-BIN-6")
def test_a_wrong_count_takes_the_next_command_for_data_until_reset(rig: Rig545) -> None:
    tell(rig, "52 02 10 47 00")
    assert rig.codes == ["count"]
    assert not rig.falls("pulse")
    rig.x.reset()
    rig.bench.run("1 ms")
    assert rig.say("O 81H", "? R") == "R=00100\r"


@pytest.mark.fact("CY545-UND-ILLEGAL")
def test_bytes_that_are_missing_are_0_and_surplus_ones_are_ignored(rig: Rig545) -> None:
    tell(rig, "4E 02 05 01 52 02 10 20")
    assert (rig.x.registers["number"], rig.x.registers["rate"]) == (0x105, 0x10)
    assert rig.codes == ["count", "count"]


@pytest.mark.fact("CY545-BIN-7")
def test_slash_and_number_sign_belong_to_text(rig: Rig545) -> None:
    tell(rig, "2F 00")
    assert rig.codes == ["unknown-command"]
    assert tell(rig, "52 01 23 3F 01 52") == b"R=\x00\x23"


@pytest.mark.fact("CY545-UND-MODE-BINARY-RETURN")
def test_a_binary_o_with_bit_7_set_leads_back_to_text(rig: Rig545) -> None:
    tell(rig, "4F 01 81")
    assert rig.say("? R") == "R=00100\r"


@pytest.mark.fact("CY545-UND-LETTER")
def test_an_unknown_letter_takes_its_count_and_data_along(rig: Rig545) -> None:
    tell(rig, "4B 03 52 01 09")
    assert tell(rig, "3F 01 52") == b"R=\x00\x64"
    assert rig.codes == ["unknown-command"]


@pytest.mark.fact("CY545-UND-STRING-END", "CY545-UND-HP-COMMAND", "CY545-UND-QUERY-BINARY")
def test_strings_queries_of_memory_and_display_data_have_a_count_as_well(rig: Rig545) -> None:
    assert tell(rig, "22 03 22 0D 41") == b'"\rA'
    rig.ram.load(b"N 1\rG\r+\r")
    assert tell(rig, "3F 02 4D 02") == b"Y=\x00\x00N 1\rG\r"
    tell(rig, "5B 04 38 02 41 42")
    tell(rig, "5B 04 38 03 41 42")
    assert rig.codes == ["count"]


@pytest.mark.fact("CY545-UND-ENTRY-Q")
def test_in_binary_q_ends_the_entry_only_where_a_letter_belongs(rig: Rig545) -> None:
    tell(rig, "45 00 52 01 51 22 02 51 51 00 00 51 52 01 05")
    assert rig.ram.content[:9].hex() == "520151220251510000"
    assert rig.x.registers["rate"] == 5
    assert not rig.codes


@pytest.mark.fact("CY545-CMD-Q-1")
def test_q_has_no_count(rig: Rig545) -> None:
    tell(rig, "4E 03 02 00 00 45 00 47 00 51 47 00")
    assert len(rig.falls("pulse")) == 2
