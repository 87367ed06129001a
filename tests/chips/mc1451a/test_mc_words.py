"""Every command of the MC1451A family as words on the host port: code, what is written, what is read, the checksum.

What a command does besides is in test_mc_commands.py and its neighbours.
"""

from __future__ import annotations

import pytest
from mc import AXES, ENCODERS, TRAPEZOID, V1, base, each, with_axes, with_encoder
from mc_motion import mover

VERSIONS = {1: "4411", 2: "4c11", 4: "5c11"}
KINDS = {  # codes that are no commands: what is written and read besides the checksum, and what the chipset finds
    (0, 0, "illegal-command"): {0x00, 0x22, *range(0x80, 0x100)},
    (0, 0, ""): {0x49, 0x40, 0x41},
    (1, 0, ""): {0x06, 0x0F, 0x25, 0x26, 0x27, 0x28, 0x2B, 0x38, 0x62},
    (0, 1, ""): {0x07, 0x2D, 0x2E, 0x3A, 0x50, 0x51, 0x52, 0x53, 0x54, 0x61, 0x69, 0x6E},
    (0, 0, "undocumented-command"): {0x0D, 0x0E, 0x1F, 0x20, 0x21, 0x23, 0x24, 0x2A, 0x2C, 0x3D, 0x3F, 0x5A, 0x5F, 0x63}
    | set(range(0x72, 0x80)),
}


# ------------------------------------------------------------------------------------------------------- all together
@each
@pytest.mark.fact("PMD-RANGE-7", "PMD-CON-COMMAND-COUNT")
def test_every_command_of_the_table_is_answered_with_its_checksum_and_found_correct(part: str) -> None:
    rig = base(part)
    rows = [row for row in rig.x.sheet.commands if row.name != "RESET"]
    assert len(rows) == 69 + AXES[part]
    for row in rows:
        rig.host.command(row.name, *(1 for _ in row.args))
    rig.do("RESET")
    assert {found.code for found in rig.x.findings} <= {"no-encoder"}


@each
@pytest.mark.fact("PMD-UND-CODES", "PMD-UND-AXIS-ABSENT", "PMD-CON-ILLEGAL-34", "PMD-CON-RESERVED-4E")
def test_an_unknown_code_does_nothing(part: str) -> None:
    rig = base(part)
    illegal = KINDS[0, 0, "illegal-command"] | set(range(AXES[part] + 1, 5))
    before = [rig.x.registers_of(n + 1) for n in range(AXES[part])]
    tried = set()
    for (written, read, finding), codes in (KINDS | {(0, 0, "illegal-command"): illegal}).items():
        for code in sorted(codes):
            found = len(rig.codes)
            answer = rig.packet(code, *(0x1234,) * written, reads=read)
            checksum = 0 if code in illegal else code + 0x1234 * written
            assert answer == (0,) * read + (checksum,), f"{code:02x}"
            servo = ["servo-command"] * (code == 0x25)  # the first one of a servo chip
            assert rig.codes[found:] == [finding] * bool(finding) + servo, f"{code:02x}"
            tried.add(code)
    assert tried | set(rig.x.sheet.commands.by_code) == set(range(256))
    after = [rig.x.registers_of(n + 1) for n in range(AXES[part])]
    assert [{**registers, "time": 0} for registers in after] == [{**registers, "time": 0} for registers in before]
    assert rig.packet(0x31, reads=1)[0] == 0x0300  # axis 1 is still the current one


# -------------------------------------------------------------------------------------------------------- axis control
@each
@pytest.mark.fact("PMD-CMD-SET_1-1", "PMD-CMD-SET_2-1", "PMD-CMD-SET_3-1", "PMD-CMD-SET_4-1", "PMD-UND-AXIS-ABSENT")
def test_an_axis_becomes_the_current_one_if_it_is_there(part: str) -> None:
    rig = base(part)
    rig.says("01 > 0300 0301", "10 0000 0001 > 0011")
    for axis, (first, status, own) in enumerate(
        [("02 > 1300 1302", "1300 1331", 2), ("03 > 2300 2303", "2300 2331", 3), ("04 > 3300 3304", "3300 3334", 4)], 2
    ):
        rig.says("01 > 0300 0301")
        if axis <= AXES[part]:
            rig.says(first, f"31 > {status[:4]} {int(status[:4], 16) + 0x31:04x}", "4a > 0000 0000 004a")
            rig.says(f"10 0000 {own:04x} > {0x10 + own:04x}")
        else:
            rig.says(f"{axis:02x} > 0000", "31 > 0300 0331", "4a > 0000 0001 004b")
    for axis in range(1, AXES[part] + 1):
        rig.packet(axis, reads=1)
        rig.says(f"4a > 0000 {axis:04x} {0x4A + axis:04x}")


@with_axes
@pytest.mark.fact("PMD-CMD-SET_1-2")
def test_the_current_axis_stays_whatever_other_commands_come(part: str) -> None:
    rig = base(part)
    rig.says("02 > 1300 1302")
    others = [row for row in rig.x.sheet.commands if row.acts != "set" and row.name not in ("RESET", "SET_I")]
    assert len(others) > 50
    for row in others:
        rig.host.command(row.name, *(0 for _ in row.args))
    rig.do("MTR_ON")
    rig.next(3)
    rig.says("33 > 0033", "31 > 1300 1331", "39 > 0000", "31 > 0300 0331")


@with_axes
@pytest.mark.fact("PMD-CMD-SET_I-1", "PMD-CMD-GET_INTRPT-1")
def test_the_interrupting_axis_can_be_queried_and_can_become_the_current_one(part: str) -> None:
    rig = base(part)
    rig.says("30 > 0300 0330")  # nothing is pending
    rig.do("SET_2", "SET_INTRPT_MASK 1")
    rig.says("30 > 1300 1330")
    rig.do(*TRAPEZOID, "SET_POS 1", "UPDATE", "SET_1")
    rig.rest()
    rig.says("30 > 1301 1331", "31 > 0300 0331")  # axis 1 is current still
    rig.says("08 > 1301 1309", "31 > 1301 1332")


@each
@pytest.mark.fact("PMD-CMD-GET_STATUS-1", "PMD-CMD-GET_MODE-1", "PMD-UND-RESERVED-BITS")
def test_status_and_mode_after_reset(part: str) -> None:
    rig = base(part)
    rig.says("31 > 0300 0331", "31 > 0300 0331", "48 > 0000 0048", "31 > 0300 0331")


# --------------------------------------------------------------------------------------------------- profile generation
@each
@pytest.mark.fact("PMD-CMD-SET_PRFL_TRAP-1", "PMD-CMD-SET_PRFL_VEL-1", "PMD-CMD-SET_PRFL_S_CRV-1")
@pytest.mark.fact("PMD-CMD-SET_PRFL_GEAR-1")
def test_a_profile_mode_takes_effect_immediately_and_for_one_axis(part: str) -> None:
    rig = base(part)
    for axis in range(AXES[part], 0, -1):
        rig.packet(axis, reads=1)
        rig.says("48 > 0000 0048", "0a > 000a", "48 > 0800 0848", "0b > 000b", "48 > 1000 1048", "0c > 000c")
        rig.says("48 > 1800 1848", "09 > 0009", "48 > 0000 0048", "0a > 000a", "48 > 0800 0848")


@each
@pytest.mark.fact("PMD-CMD-SET_POS-1", "PMD-CMD-SET_POS-2", "PMD-CMD-GET_POS-1", "PMD-BUF-2")
def test_a_destination(part: str) -> None:
    rig = base(part)
    rig.says("10 0234 5678 > 58bc", "4a > 0234 5678 58f6", "10 0000 3039 > 3049", "4a > 0000 3039 3083")
    rig.says("10 c000 0000 > c010", "4a > c000 0000 c04a", "10 3fff ffff > 400e", "4a > 3fff ffff 4048")


@each
@pytest.mark.fact("PMD-CMD-SET_VEL-1", "PMD-CMD-SET_VEL-2", "PMD-CMD-GET_VEL-1", "PMD-BUF-2")
@pytest.mark.fact("PMD-CON-PARAM-UNIT", "PMD-CON-VELOCITY-SIGN")
def test_a_maximum_velocity(part: str) -> None:
    rig = base(part)
    rig.says("11 0002 c000 > c013", "4b > 0002 c000 c04d", "11 0000 5ba0 > 5bb1", "4b > 0000 5ba0 5beb")
    rig.says("11 3fff ffff > 400f", "4b > 3fff ffff 4049", "11 0000 0000 > 0011", "4b > 0000 0000 004b")


@each
@pytest.mark.fact("PMD-CMD-SET_ACC-1", "PMD-CMD-SET_ACC-2", "PMD-CMD-GET_ACC-1", "PMD-BUF-2")
def test_an_acceleration(part: str) -> None:
    rig = base(part)
    rig.says("12 0000 2ccd > 2cdf", "4c > 0000 2ccd 2d19", "12 0000 0159 > 016b", "4c > 0000 0159 01a5")
    rig.says("0a > 000a", "12 fffe 0ccd > 0cdd", "4c > fffe 0ccd 0d17", "12 c000 0000 > c012", "4c > c000 0000 c04c")


@each
@pytest.mark.fact("PMD-CMD-SET_JERK-1", "PMD-CMD-GET_JERK-1", "PMD-CMD-SET_MAX_ACC-1", "PMD-CMD-GET_MAX_ACC-1")
@pytest.mark.fact("PMD-RANGE-6", "PMD-BUF-2", "PMD-CON-MAXACC-RANGE", "PMD-CON-JERK-EXAMPLE")
def test_further_commands_of_an_s_curve(part: str) -> None:
    rig = base(part)
    rig.says("13 0020 0000 > 0033", "58 > 0020 0000 0078", "13 7fff ffff > 8011", "58 > 7fff ffff 8056")
    rig.says("13 01eb 851f > 871d", "58 > 01eb 851f 8762")
    rig.says("15 2ccd > 2ce2", "4f > 2ccd 2d1c", "15 7fff > 8014", "4f > 7fff 804e")


@each
@pytest.mark.fact(
    "PMD-CMD-SET_RATIO-1", "PMD-CMD-GET_RATIO-1", "PMD-BUF-2", "PMD-CON-GEAR-MINUS", "PMD-CON-RATIO-RANGE"
)
def test_a_gear_ratio(part: str) -> None:
    rig = base(part)
    rig.says("14 fff4 9c29 > 9c31", "59 > fff4 9c29 9c76", "14 0001 8000 > 8015", "59 > 0001 8000 805a")
    rig.says("14 fffe 0000 > 0012", "59 > fffe 0000 0057", "14 3fff ffff > 4012", "59 > 3fff ffff 4057")


@each
@pytest.mark.fact("PMD-CMD-SET_START_VEL-1", "PMD-CMD-GET_START_VEL-1", "PMD-CON-STARTVEL-RANGE")
def test_a_start_velocity(part: str) -> None:
    rig = base(part)
    rig.says("6b > 0000 0000 006b", "6a 0000 4000 > 406a", "6b > 0000 4000 406b")
    rig.says("6a 3fff ffff > 4068", "6b > 3fff ffff 4069")


# ---------------------------------------------------------------------------------------------------- parameter update
@each
@pytest.mark.fact("PMD-CMD-SET_BRK_PNT-1", "PMD-CMD-GET_BRK_PNT-1")
def test_a_comparison_value(part: str) -> None:
    rig = base(part)
    rig.says("16 0000 01f4 > 020a", "57 > 0000 01f4 024b", "16 ffff fffb > 0010", "57 > ffff fffb 0051")


@each
@pytest.mark.fact("PMD-CMD-SET_TIME_BRK-1", "PMD-CMD-SET_POS_BRK-1", "PMD-CMD-SET_NEG_BRK-1", "PMD-CMD-SET_EXT_BRK-1")
@pytest.mark.fact("PMD-CMD-SET_ACTL_POS_BRK-1", "PMD-CMD-SET_ACTL_NEG_BRK-1", "PMD-CMD-SET_MTN_CMPLT_BRK-1")
@pytest.mark.fact("PMD-CMD-SET_BRK_OFF-1", "PMD-CMD-UPDATE-1", "PMD-CMD-STOP-1", "PMD-CMD-SMOOTH_STOP-1")
@pytest.mark.fact("PMD-CMD-SYNCH_PRFL-1", "PMD-CMD-CLR_STATUS-1", "PMD-CMD-MTR_OFF-1", "PMD-CMD-MTR_ON-1")
@pytest.mark.fact("PMD-CMD-LMTS_ON-1", "PMD-CMD-LMTS_OFF-1", "PMD-CMD-SET_CAPT_INDEX-1", "PMD-CMD-SET_CAPT_HOME-1")
def test_commands_that_are_a_code_alone(part: str) -> None:
    rig = base(part)
    codes = "17 18 19 1b 1c 35 5e 6d 1a 46 4e 47 33 42 43 70 71 64 65"
    rig.says(*(f"{code} > 00{code}" for code in codes.split()))


@each
@pytest.mark.fact("PMD-CMD-SET_AUTO_UPDATE_ON-1", "PMD-CMD-SET_AUTO_UPDATE_OFF-1", "PMD-CMD-SET_OUTPUT_HIGH-1")
@pytest.mark.fact("PMD-CMD-SET_OUTPUT_STNDRD-1", "PMD-CMD-SET_AUTO_STOP_ON-1", "PMD-CMD-SET_AUTO_STOP_OFF-1")
def test_switches_of_an_axis_are_in_its_mode_word(part: str) -> None:
    rig = base(part)
    for axis in range(AXES[part], 0, -1):  # each finds its own word untouched by those before
        rig.packet(axis, reads=1)
        rig.says("48 > 0000 0048", "5d > 005d", "48 > 0400 0448", "5c > 005c", "48 > 0000 0048")
        rig.says("3b > 003b", "48 > 0200 0248", "3c > 003c", "48 > 0000 0048")
        rig.says("45 > 0045", "48 > 0080 00c8", "44 > 0044", "48 > 0000 0048")
        rig.says("5d > 005d", "3b > 003b", "45 > 0045", "48 > 0680 06c8")


# ------------------------------------------------------------------------------------------------------------- encoder
@each
@pytest.mark.fact("PMD-CMD-SET_POS_ERR-1", "PMD-CMD-GET_POS_ERR-1", "PMD-UND-POSERR-DEFAULT", "PMD-UND-ENC-ABSENT")
def test_a_limit_of_the_position_error(part: str) -> None:
    rig = base(part)
    rig.says("55 > 7fff 8054", "29 03e8 > 0411", "55 > 03e8 043d", "29 0064 > 008d", "55 > 0064 00b9")


@each
@pytest.mark.fact("PMD-CMD-SET_STEP_RATIO-1", "PMD-CMD-GET_STEP_RATIO-1", "PMD-CON-DATALINE", "PMD-CON-STEPRATIO-RANGE")
@pytest.mark.fact("PMD-UND-ENC-ABSENT")
def test_a_step_ratio(part: str) -> None:
    rig = base(part)
    rig.says("6f > 0000 006f", "68 0050 > 00b8", "6f > 0050 00bf", "68 0100 > 0168", "6f > 0100 016f")
    rig.says("68 7fff > 8067", "6f > 7fff 806e")


@each
@pytest.mark.fact("PMD-CMD-GET_CAPT-1", "PMD-CMD-SET_CAPT_INDEX-1", "PMD-CMD-SET_CAPT_HOME-1")
@pytest.mark.fact("PMD-CON-CAPTURE", "PMD-UND-CAPTURE", "PMD-CON-BIT3")
def test_nothing_is_captured_by_either_source(part: str) -> None:
    rig = mover(part, **{"quadrature": {}} if part in ENCODERS else {})
    for source in ("64 > 0064", "65 > 0065"):
        rig.says("36 > 0000 0000 0036", source)
        for shaft in rig.shafts.values():
            shaft.push(100)
        rig.next(2)
        for level in (0, 1, 0, 1):
            rig.drive("home1", level)
            rig.next(2)
        assert not rig.status() & 8
        rig.says("36 > 0000 0000 0036")


# ------------------------------------------------------------------------------------------------------- miscellaneous
@each
@pytest.mark.fact("PMD-CMD-SET_ACTL_POS-2", "PMD-RANGE-1")
def test_a_position_can_be_declared_up_to_both_ends(part: str) -> None:
    rig = base(part)
    rig.says("4d c000 0000 > c04d", "1d > c000 0000 c01d", "4d 3fff ffff > 404b", "1d > 3fff ffff 401b")


@each
@pytest.mark.fact("PMD-CMD-GET_HOME-1", "PMD-CON-PARTNAME")
def test_levels_of_the_home_inputs(part: str) -> None:
    rig = base(part)
    rig.says({1: "05 > 0001 0006", 2: "05 > 0003 0008", 4: "05 > 000f 0014"}[AXES[part]])
    for axis in range(1, AXES[part] + 1):
        rig.drive(f"home{axis}", 0)
        low = (1 << AXES[part]) - 1 & ~(1 << axis - 1)
        rig.says(f"05 > {low:04x} {low + 5:04x}")
        rig.drive(f"home{axis}", 1)
    if AXES[part] == 4:
        rig.drive("home2", 0)
        rig.says("05 > 000d 0012")


@each
@pytest.mark.fact("PMD-CMD-GET_LMT_SWTCH-1", "PMD-CON-PARTNAME")
def test_levels_of_the_limit_inputs(part: str) -> None:
    rig = base(part)
    rig.says("67 > 0000 0067", "71 > 0071", f"66 00ff > {0x66 + 0xFF:04x}")  # the levels, whatever is active
    for axis in range(1, AXES[part] + 1):
        for offset, name in enumerate(("poslimit", "neglimit")):
            rig.drive(f"{name}{axis}", 1)
            word = 1 << 2 * (axis - 1) + offset
            rig.says(f"67 > {word:04x} {word + 0x67:04x}")
            rig.drive(f"{name}{axis}", 0)
    if AXES[part] > 1:
        rig.drive("poslimit1", 1)
        rig.drive("neglimit2", 1)
        rig.says("67 > 0009 0070")


@each
@pytest.mark.fact("PMD-CMD-SET_LMT_SENSE-1", "PMD-CMD-SET_INTRPT_MASK-1", "PMD-CMD-GET_INTRPT_MASK-1")
def test_words_of_bits(part: str) -> None:
    rig = base(part)
    rig.says("71 > 0071", "66 000f > 0075", "66 00ff > 0165", "66 0000 > 0066")
    rig.says("56 > 0000 0056", "2f 0071 > 00a0", "56 > 0071 00c7", "2f 0031 > 0060", "56 > 0031 0087")


@each
@pytest.mark.fact("PMD-CMD-GET_VRSN-1", "PMD-VRSN-2", "PMD-VRSN-3", "PMD-VRSN-4", "PMD-VRSN-5", "PMD-VRSN-6")
@pytest.mark.fact("PMD-VRSN-1", "PMD-CON-VRSN-FAMILY")
def test_the_version_is_read_whichever_axis_is_current(part: str) -> None:
    rig = base(part)
    word = VERSIONS[AXES[part]]
    for axis in range(1, AXES[part] + 1):
        rig.packet(axis, reads=1)
        rig.says(f"6c > {word} {word[:2]}7d")
    version = int(word, 16)
    assert (version >> 11 & 7) + 1 == AXES[part]
    assert (version >> 8 & 7, version >> 3 & 3) == (4, 2)


@each
@pytest.mark.fact("PMD-CMD-GET_TIME-1")
def test_the_time_counts_cycles(part: str) -> None:
    rig = base(part)
    rig.to(1000)
    rig.says("3e > 0000 03e8 0426")
    reads = 3 + 2048  # clocks from the begin of the command to the instant at which the time is read: a strobe, a slice
    rig.to(2000, -reads - 1)
    assert rig.do("GET_TIME") == 1999
    rig.to(3000, -reads)
    assert rig.do("GET_TIME") == 3000


@with_encoder
@pytest.mark.fact("PMD-CMD-GET_ACTL_POS-1")
def test_the_actual_position_is_the_count_of_the_encoder(part: str) -> None:
    rig = mover(part, quadrature={})
    shaft = rig.shafts["quadrature"]
    shaft.push(1000)
    rig.bench.run("2 ms")
    rig.next()
    rig.says("37 > 0000 03e8 041f")
    rig.do("SET_ACTL_POS 0")
    shaft.push(-1000)
    rig.bench.run("2 ms")
    rig.next()
    rig.says("37 > ffff fc18 fc4e")
    rig.do(*V1, "UPDATE")
    shaft.push(7)
    rig.next()
    rig.says("37 > ffff fc1f fc55")  # in motion, too, and no older than a cycle
