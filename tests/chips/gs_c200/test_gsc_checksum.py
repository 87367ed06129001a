"""The checksum of a GS-C module: the sum of the codes before it, seven bits, the bit 0x10 always set.

2 A 3    0x32 + 0x41 + 0x33 = 0xA6    0x26    0x36, which is 6    on the line: 2A36 CR
"""

from __future__ import annotations

from random import Random

import pytest
from gsc import C200, C200S, NINE_SIX, STR, base, both

import slewline
from slewline.errors import UsageError
from slewline.language.lines import checksum

LINES = (  # commands and their checksums as they go over the line
    "A3t", "A1r", "C3v", "D15:", "EU", "FV", "f-8388608\x1c", "f+8388606\x18", "G0w", "G500000|", "G+500000\x17", "G+r",
    "G-26", "g+\x12", "g+1S", "HX", "H+s", "H-u", "I1z", "I2{", "I3|", "j12]", "jc0,40\x1d", "K[", "L0|", "L4\x10",
    "L5\x11", "L7\x13", "L10=", "M]", "PP", "Po?", "PxX", "QQ", "R1\x13", "R507", "S104", "T9\x1d", "T100u", "U2\x17",
    "V1\x17", "V2\x18", "W1\x18", "XX", "ZZ", "+5p", "+250R", "-800U",
)  # fmt: skip
ADDRESSED = ("2A36", "1Fw", "2Fx", "7K\x12", "5Z\x1f")
ANSWERS = (
    "YY", "BR", "RR", "E1v", "E2w", "E3x", "E4y", "E5z", "E6{", "V0\x16", "V1234567R", "V9999999u", "V+01", "V+1234[",
    "V-8388605y", "V+8388607y", "V-8388608|", "V006", "V25=", "V36?", "V70=", "V77T", "ENDW",
)  # fmt: skip


# ---------------------------------------------------------------------------------------------------------- the rule
@both
@pytest.mark.parametrize("line", LINES)
@pytest.mark.fact("GSC-CHK-1", "GSC-CON-CHK-OR")
def test_a_line_with_this_checksum_passes_and_with_another_one_does_not(part: str, line: str) -> None:
    assert base(part, chs=1).wire(line + "\r")[:2] != b"E1"
    assert base(part, chs=1).wire(line[:-1] + chr(ord(line[-1]) ^ 1) + "\r") == b"E1v\r"


@both
@pytest.mark.parametrize("line", ADDRESSED)
@pytest.mark.fact("GSC-CHK-1")
def test_the_address_is_summed_too(part: str, line: str) -> None:
    address = int(line[0])
    assert base(part, chs=1, options={"address": address}).wire(line + "\r")[:2] != b"E1"
    assert base(part, chs=1, options={"address": address}).wire(line[:-1] + "@\r") == b"E1v\r"


@both
@pytest.mark.fact("GSC-CHK-2", "GSC-CON-CHK-OR", "GSC-CON-HEX")
def test_the_checksum_of_2a3_is_6_and_not_the_ampersand(part: str) -> None:
    rig = base(part, chs=1, options={"address": 2})
    rig.prg()
    assert rig.wire("2A3&\r") == b"E1v\r"
    assert rig.wire(b"\x32\x41\x33\x36\x0d") == b"YY\r"
    assert rig.listed() == ["A3"]


@both
@pytest.mark.fact("GSC-CHK-3", "GSC-CON-HEX")
def test_the_checksum_of_a3_is_t(part: str) -> None:
    rig = base(part, chs=1)
    rig.prg()
    assert rig.wire(b"\x41\x33\x74\x0d") == b"YY\r"
    assert rig.listed() == ["A3"]


@both
@pytest.mark.fact("GSC-CHK-4")
def test_with_chs_low_there_is_none(part: str) -> None:
    rig = base(part)
    rig.prg()
    assert rig.wire("A3\r") == b"Y\r"


@pytest.mark.fact("GSC-CHK-9")
def test_a_checksum_is_one_of_64_codes_and_never_a_carriage_return() -> None:
    chance = Random(0)
    texts = [bytes(chance.choices(range(0x20, 0x7F), k=chance.randint(1, 10))) for _ in range(1000)]
    for line in (*LINES, *ADDRESSED, *ANSWERS):
        assert checksum(line[:-1].encode()) == ord(line[-1])
    codes = {code for code in range(0x80) if code & 0x10}
    assert {checksum(text) for text in texts} == codes and 0x0D not in codes
    assert {checksum(text, 0) for text in texts} == set(range(0x80))  # old firmware: it may be one


# ------------------------------------------------------------------------------------------------------------- answers
@both
@pytest.mark.fact("GSC-CHK-5", "GSC-CHK-15")
def test_answers_carry_a_checksum_by_the_same_rule(part: str) -> None:
    rig = base(part, chs=1, ui3=0)
    assert rig.wire("FV\r") == b"\x52\x52\x0d"  # ready and busy end alike
    assert rig.wire("V3\x19\r") == b"E2w\r"
    assert rig.wire("A3t\r") == b"E4y\r"
    assert rig.prg(*["A1"] * 59) == ["Y"] * 59
    assert rig.wire("A1r\r") == b"E3x\r"
    rig.x.eeprom_fault = True
    assert rig.wire("M]\r") == b"E6{\r"
    rig.start("A2", "A3", "D50")
    assert rig.wire("FV\r") == b"\x42\x52\x0d"
    rig.bench.run_until_idle()
    assert rig.wire("V2\x18\r") == b"V36?\r"
    assert rig.wire("QQ\r") == b"A2s\rA3t\rD509\rENDW\r"


@pytest.mark.fact("GSC-CHK-5")
def test_the_answers_of_one_part_carry_a_checksum_too() -> None:
    rig = base(C200, chs=1)
    assert rig.wire("V1\x17\r") == b"V0\x16\r"
    rig.run(*STR, "-1")
    assert rig.wire("FV\r") == b"E5z\r"
    rig = base(C200S, chs=1)
    assert rig.wire("V1\x17\r") == b"V+01\r"


# ------------------------------------------------------------------------------------------------------------- faults
@both
@pytest.mark.fact("GSC-CHK-6", "GSC-ERR-1", "GSC-CON-ERROR-WORD")
def test_a_wrong_checksum_is_e1_and_has_no_effect(part: str) -> None:
    rig = base(part, chs=1)
    rig.prg()
    assert rig.wire("A3s\r") == b"E1v\r"
    assert rig.wire("QQ\r") == b"ENDW\r"
    assert rig.codes == ["E1"]


@both
@pytest.mark.fact("GSC-CHK-7")
def test_a_missing_checksum_is_a_wrong_one(part: str) -> None:
    rig = base(part, chs=1)
    assert rig.wire("A3\r") == b"E1v\r"
    assert rig.wire("F\r") == b"E1v\r"


@both
@pytest.mark.fact("GSC-CHK-8")
def test_a_checksum_that_is_not_required_belongs_to_the_argument(part: str) -> None:
    rig = base(part)
    assert rig.wire("FV\r") == b"E2\r"
    rig.prg()
    assert rig.wire("A3t\r") == b"E2\r"
    assert rig.listed() == []


@both
@pytest.mark.fact("GSC-CHK-13")
def test_damage_that_changes_bit_4_of_the_sum_alone_passes_the_checksum(part: str) -> None:
    rig = base(part, chs=1)
    rig.prg()
    assert rig.wire("S104\r") == b"YY\r"
    assert rig.wire("C104\r") == b"E2w\r"


@both
@pytest.mark.fact("GSC-CHK-14")
def test_a_module_on_its_own_expects_checksums(part: str) -> None:
    bench = slewline.Bench()
    host = bench.host(bench.add(part, name="x", straps=NINE_SIX))
    host.write("F\rFV\r")
    bench.run("1 s")
    assert host.received == b"E1v\rRR\r"


# --------------------------------------------------------------------------------------------------------- old firmware
@pytest.mark.parametrize("firmware", ["1.0", "2.1"])
@pytest.mark.fact("GSC-CHK-11", "GSC-UND-FW-BEFORE-22")
def test_a_gs_c200_before_2_2_does_not_set_the_bit(firmware: str) -> None:
    rig = base(C200, chs=1, options={"firmware": firmware, "address": 2})
    rig.host.write("2P\x02\r")
    assert rig.wire("2A36\r") == b"YY\rE1v\r"
    assert rig.wire("2A3&\r") == b"YY\r"
    assert rig.ask("Q") == "A3\rEND"
    rig.start("D50")
    assert rig.wire("2Fx\r") == b"BB\r"
    rig.bench.run_until_idle()
    assert rig.wire("2N1\x31\r") == b"E4y\r"  # nothing else differs
    assert rig.wire("2V3\x3b\r") == b"E2w\r"


@pytest.mark.fact("GSC-CHK-11", "GSC-UND-FW-BEFORE-22")
def test_the_bit_is_set_from_2_2_on_and_by_every_gs_c200s() -> None:
    for part, firmware in ((C200, "2.2"), (C200, "2.10"), (C200, "3.0"), (C200S, "2.2")):
        rig = base(part, chs=1, options={"firmware": firmware})
        assert rig.wire("FV\r") == b"RR\r"
        assert rig.wire("F\x46\r") == b"E1v\r"


@pytest.mark.fact("GSC-UND-FW-BEFORE-22")
def test_no_gs_c200s_is_older_than_the_bit() -> None:
    with pytest.raises(UsageError, match=r"x: firmware '2\.1'; every GS-C200S sets bit 0x10 .* leave the option out"):
        base(C200S, options={"firmware": "2.1"})


@pytest.mark.parametrize("firmware", ["2", "new", "2.x", "", 2.1])
def test_a_firmware_that_is_not_a_version_is_refused(firmware: object) -> None:
    with pytest.raises(UsageError, match=r"firmware .*; (allowed text|a version is two numbers,) such as '2\.1'"):
        base(C200, options={"firmware": firmware})


@pytest.mark.fact("GSC-CHK-12", "GSC-UND-FW-BEFORE-22")
def test_without_the_bit_a_checksum_may_be_a_return_that_ends_its_line() -> None:
    rig = base(C200, chs=1, options={"firmware": "2.1"})
    rig.prg()
    assert rig.wire("T9\r\r", wait="1 s") == b"E1v\r"  # the 9 was taken for the checksum of T
    assert rig.ask("Q") == "END"
    rig = base(C200, chs=1)
    rig.prg()
    assert rig.wire("T9\x1d\r") == b"YY\r"
    assert rig.listed() == ["T9"]
