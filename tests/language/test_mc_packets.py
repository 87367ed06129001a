"""Packets of the MC1451A family: lines to words, words to numbers, checksums, names of bits, rates, bytes and back."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest

from slewline.chips import PARTS, sheet_of
from slewline.errors import ProgramError, UnknownName, UsageError
from slewline.language import packets, rates
from slewline.language.assemble import assemble, to_ascii, to_binary
from slewline.language.dialect import Command
from slewline.language.disassemble import disassemble, listing
from slewline.language.lines import Refusal
from tests.rows import rows

SHEET = sheet_of("mc1451a-e")
SHEETS = [sheet_of(part) for part, row in PARTS.items() if row.folder == "mc1451a"]
ROWS = [pytest.param(row, id=row.form) for row in SHEET.commands]
PER_S = rates.cycles_per_s(SHEET)
ROUND_PER_S = 3030  # what the worked figures of the manual reckon with; 25 MHz / 8192 are 3051.76


def arg(command):
    return SHEET.commands[command].args[0]


def words_of(line, sheet=SHEET):
    found = packets.command(sheet, line)
    return packets.words(found.row, found.values)


def refused(line, sheet=SHEET):
    found = packets.parse(sheet, line)
    assert isinstance(found, Refusal), line
    return found


# --------------------------------------------------------------------------------------------------------------- words
@rows(
    ("line", "words"),
    [
        ("SET_POS 12345", (0x0000, 0x3039)),
        ("SET_POS 1234567", (0x0012, 0xD687)),  # worked examples of the manual
        ("SET_POS -1073741824", (0xC000, 0x0000)),
        ("SET_POS $02345678", (0x0234, 0x5678)),
        ("SET_VEL 180224", (0x0002, 0xC000)),
        ("set_vel 0x2c000", (0x0002, 0xC000)),
        ("SET_ACC 11469", (0x0000, 0x2CCD)),
        ("SET_ACC -127795", (0xFFFE, 0x0CCD)),
        ("SET_ACC 0xFFFE0CCD", (0xFFFE, 0x0CCD)),
        ("SET_ACC -0x1F333", (0xFFFE, 0x0CCD)),
        ("SET_MAX_ACC 11469", (0x2CCD,)),
        ("SET_RATIO -746455", (0xFFF4, 0x9C29)),
        ("SET_RATIO 98304", (0x0001, 0x8000)),
        ("SET_RATIO $FFFE0000", (0xFFFE, 0x0000)),
        ("SET_BRK_PNT -5", (0xFFFF, 0xFFFB)),
        ("SET_BRK_PNT 4294967291", (0xFFFF, 0xFFFB)),
        ("SET_STEP_RATIO 80", (0x0050,)),
        ("RST_INTRPT $00EF", (0x00EF,)),
        ("  Update\t", ()),
        ("GET_TIME", ()),
    ],
)
@pytest.mark.fact("PMD-PKT-13", "PMD-CON-GEAR-MINUS")
def test_a_line_is_the_words_that_a_host_writes(line, words):
    assert words_of(line) == words


@rows("row", ROWS)
@pytest.mark.fact("PMD-PKT-1")
def test_numbers_come_back_from_their_words_with_their_sign(row):
    draw = random.Random(row.code)
    for each in (*row.args, *row.reads):
        for value in (each.low, each.high, 0, *(draw.randint(each.low, each.high) for _ in range(20))):
            data = each.pack(value, "big")
            sent = tuple(int.from_bytes(data[at : at + 2], "big") for at in range(0, len(data), 2))
            if row.args:
                assert packets.words(row, (value,)) == sent
            (back,) = packets.values((each,), sent)
            assert back == value or (back - value) % each.modulus == 0 < each.high - (1 << 31)
    assert packets.counted(row.args) == sum(each.size for each in row.args) / 2


def test_a_word_that_is_read_has_its_sign():
    assert packets.values(SHEET.commands["GET_TRGT_POS"].reads, (0xFFFF, 0xFC18)) == (-1000,)
    assert packets.values(SHEET.commands["GET_ACTL_POS_ERR"].reads, (0xFFF6,)) == (-10,)
    assert packets.values(SHEET.commands["GET_BRK_PNT"].reads, (0xFFFF, 0xFFFB)) == (-5,)
    assert packets.values(SHEET.commands["GET_TIME"].reads, (0xFFFF, 0xFFFF)) == (4294967295,)
    assert packets.values(SHEET.commands["GET_STATUS"].reads, (0xF300,)) == (0xF300,)


@pytest.mark.fact("PMD-PKT-2", "PMD-PKT-3", "PMD-PKT-4", "PMD-PKT-6", "PMD-PKT-8")
def test_checksums():
    assert packets.checksum(0x11, (0xFEDC, 0xBA98)) == 0xB985
    assert packets.checksum(0x6C, (0x5C11,)) == 0x5C7D
    assert packets.checksum(0x10, (0xFFFF, 0xFFFF)) == 0x000E
    assert packets.checksum(0x1A, ()) == 0x001A


@rows("values", [(), (1, 2), (1 << 30,), (-(1 << 30) - 1,), (1.0,), (True,), ("5",)])
def test_values_out_of_range_from_our_host_are_a_usage_error(values):
    with pytest.raises(UsageError, match="SET_POS"):
        packets.words(SHEET.commands["SET_POS"], values)


def test_the_mistake_lists_the_allowed_values():
    with pytest.raises(UsageError) as error:
        packets.words(SHEET.commands["SET_MAX_ACC"], (32768,))
    assert str(error.value) == "SET_MAX_ACC max_acceleration 32768: allowed 0..32767 (command reference)"


# ------------------------------------------------------------------------------------------------- lines that are none
@rows(
    ("line", "code", "at", "end", "allowed", "remedy"),
    [
        ("SET_POS", "missing-argument", 7, 8, "-1073741824..1073741823 (steps)", ""),
        ("SET_POS 1 2", "extra-argument", 10, 11, "", "leave out 2; write one command per line"),
        ("SET_POS 11 1", "extra-argument", 11, 12, "", "leave out 1; write one command per line"),
        ("STOP  now", "extra-argument", 6, 9, "", "leave out now; write one command per line"),
        ("SET_VEL -1", "range", 8, 10, "0..1073741823 (2^-16 steps/cycle)", "the nearest is 0"),
        ("SET_MAX_ACC 0x8000", "range", 12, 18, "0..32767 (2^-16 steps/cycle^2)", "the nearest is 32767"),
        ("SET_POS 0x40000000", "range", 8, 18, "-1073741824..1073741823 (steps)", "the nearest is 1073741823"),
        ("SET_VEL 2c000", "bad-number", 8, 13, "0..1073741823 (2^-16 steps/cycle)", "hexadecimal is written 0x2C000"),
        ("SET_VEL 2c000h", "bad-number", 8, 14, "0..1073741823 (2^-16 steps/cycle)", "hexadecimal is written 0x2C000"),
        ("SET_VEL 2.75", "bad-number", 8, 12, "0..1073741823 (2^-16 steps/cycle)", "2.75 steps/cycle is 180224"),
        (
            *("SET_STEP_RATIO 0.32", "bad-number", 15, 19, "0..32767 (2^-8 counts/step)"),
            "0.32 counts/step is 81.92, not a whole number; the nearest is 82",
        ),
        (
            *("SET_POS 12,345", "bad-number", 8, 14, "-1073741824..1073741823 (steps)"),
            "write the digits without separators",
        ),
        (
            *("SET_POS here", "bad-number", 8, 12, "-1073741824..1073741823 (steps)"),
            "write decimal digits, or hexadecimal ones after 0x or $",
        ),
        ("get_satus", "unknown-command", 0, 9, "", "write GET_STATUS"),
        ("SET_VELO 1", "unknown-command", 0, 8, "", "write SET_VEL"),
        ("POS 5", "unknown-command", 0, 3, "", "write SET_POS or GET_POS"),
        ("R 100", "unknown-command", 0, 1, "", "slewline describe mc1451a-e lists the commands"),
        ("", "unknown-command", 0, 0, "", "slewline describe mc1451a-e lists the commands"),
    ],
)
def test_a_wrong_line_is_reported_with_its_place_and_a_replacement(line, code, at, end, allowed, remedy):
    found = refused(line)
    assert (found.code, found.at, found.end, found.allowed, found.remedy) == (code, at, end, allowed, remedy)


@rows(
    ("name", "remedy"),
    [
        pytest.param("set_accel", "write SET_ACC", marks=pytest.mark.fact("PMD-CON-ACC-SPELLING")),
        ("set_pos_actl_brk", "write SET_ACTL_POS_BRK"),
        ("set_neg_actl_brk", "write SET_ACTL_NEG_BRK"),
        ("get_i", "write GET_INTRPT"),
        ("zero_pos", "write SET_ACTL_POS 0"),
        ("clr_prfl", "write STOP"),
        ("set_buf_mtr_cmd", "slewline describe mc1451a-e lists the commands"),
    ],
)
@pytest.mark.fact("PMD-CON-ACC-SPELLING", "PMD-CON-BRK-SPELLING", "PMD-CON-GET-I")
@pytest.mark.fact("PMD-CON-ZERO-POS", "PMD-CON-BUF-MTR-CMD")
def test_names_in_the_manual_that_are_not_commands(name, remedy):
    found = refused(f"{name} 0")
    assert found.found == f"{name} is not a command of the MC1451A-E" and found.remedy == remedy
    with pytest.raises(UnknownName, match=f"{name} is not a command .*; {remedy}"):
        packets.row(SHEET, name)


def test_a_missing_axis_is_distinguished_from_a_typing_error():
    assert refused("SET_3", sheet_of("mc1251a")).remedy == "a part with more axes has this command"
    assert words_of("SET_3", sheet_of("mc1451a")) == ()


def test_a_number_without_end_is_out_of_range_and_does_not_fill_the_message():
    found = refused("SET_POS " + "9" * 100_000)
    assert (found.code, len(found.found) < 80, found.remedy) == ("range", True, "the nearest is 1073741823")
    assert refused("SET_POS -" + "9" * 100_000).remedy == "the nearest is -1073741824"
    assert len(refused("X" * 100_000).found) < 80


def test_no_line_makes_the_reader_raise():
    draw = random.Random(1451)
    letters = "SETGOPVLUDAC_RK -+$0x19.,fF\té\0"
    for _ in range(3000):
        line = "".join(draw.choices(letters, k=draw.randint(0, 20)))
        found = packets.parse(SHEET, line)
        assert isinstance(found, Command | Refusal)
        if isinstance(found, Refusal):
            assert 0 <= found.at <= found.end <= len(line) + 1


def test_an_empty_line_raises_where_a_command_is_required():
    with pytest.raises(UsageError) as error:
        packets.command(SHEET, "SET_VEL 2c000")
    assert str(error.value) == (
        "SET_VEL velocity 2c000: allowed 0..1073741823 (2^-16 steps/cycle); hexadecimal is written 0x2C000"
    )


# ---------------------------------------------------------------------------------------------------- names of the bits
def test_words_about_an_axis_by_their_names():
    status, mode = SHEET.dialect.status, SHEET.dialect.mode
    assert packets.shown(0x1331, status) == "motion_complete motion_error positive_limit motor_on axis_on axis=2"
    assert packets.shown(0xBE80, mode) == "auto_stop high_speed auto_update_off profile=3 phase=5"
    assert packets.fields(0x7000, mode) == {
        **{"auto_stop": 0, "high_speed": 0, "auto_update_off": 0, "profile": 2, "phase": 3},
    }
    assert packets.fields(0x3000, status)["axis"] == 4


def test_a_status_bit_is_found_by_its_name():
    assert packets.status_bit(SHEET, "In_Motion").mask == 0x0400
    with pytest.raises(UnknownName, match=r"no status bit 'motion_compleet'; .*; did you mean motion_complete\?$"):
        packets.status_bit(SHEET, "motion_compleet")
    with pytest.raises(UnknownName, match="no status bit 'axis'; allowed motion_complete, "):
        packets.status_bit(SHEET, "axis")


# ---------------------------------------------------------------------------------------------------------------- rates
@pytest.mark.parametrize(
    ("command", "rate", "exact", "round_figure"),
    [
        pytest.param("SET_VEL", 12345, 265107, 267010, id="velocity"),
        pytest.param("SET_ACC", 67890, 478, 485, id="acceleration"),
        pytest.param("SET_MAX_ACC", 67890, 478, 485, id="S-curve acceleration"),
    ],
)
@pytest.mark.fact("PMD-TIME-5", "PMD-TIME-6", "PMD-TIME-7", "PMD-TIME-8", "PMD-CON-UNIT-EXAMPLES")
def test_a_rate_in_seconds_exactly_and_as_the_manual_reckons(command, rate, exact, round_figure):
    assert rates.register(arg(command), rate, PER_S) == exact
    assert rates.manual(arg(command), rate, ROUND_PER_S) == round_figure


@pytest.mark.fact("PMD-TIME-9", "PMD-CON-JERK-EXAMPLE")
def test_a_jerk():
    assert rates.register(arg("SET_JERK"), 1_000_000, PER_S) == 151116
    assert rates.register(arg("SET_JERK"), Fraction(75, 10_000) * PER_S**3, PER_S) == 0x1EB851F


@pytest.mark.fact("PMD-TIME-2", "PMD-TIME-3", "PMD-CON-CYCLE")
def test_a_second_has_3051_cycles_and_three_quarters_and_another_crystal_others():
    assert Fraction(30517578125, 10_000_000) == PER_S
    assert rates.cycles_per_s(SHEET, 20_000_000) == Fraction(1_000_000, Fraction(4096, 10))
    assert rates.register(arg("SET_VEL"), 12345, rates.cycles_per_s(SHEET, 12_500_000)) == 530214  # 2 * 265106.86


def test_register_values_in_seconds():
    assert rates.per_second(arg("SET_VEL"), 65536, PER_S) == PER_S
    assert round(float(rates.per_second(arg("SET_VEL"), 267010, PER_S)), 1) == 12433.6
    assert round(rates.per_second(arg("SET_ACC"), 485, PER_S)) == 68923
    for value in (1, 12345, (1 << 30) - 1):
        assert rates.register(arg("SET_VEL"), rates.per_second(arg("SET_VEL"), value, PER_S), PER_S) == value


@rows(
    ("line", "number"),
    [
        ("SET_VEL 12345 steps/s", 265107),
        ("set_vel 12345.steps/s", 265107),
        ("SET_START_VEL +.25 steps/cycle", 16384),
        ("SET_ACC 67890 steps/s2", 478),
        ("SET_ACC -67890 steps/s^2", -478),
        ("SET_MAX_ACC 0.25 steps/cycle2  ", 16384),
        ("SET_JERK 1e6 steps/s3", 151116),
        ("SET_JERK .0075 steps/cycle^3", 0x1EB851F),
        ("SET_VEL 1.52587890625e-5 steps/cycle", 1),
        ("SET_VEL 7.62939453125e-6 steps/cycle", 1),  # a half goes upwards
        ("SET_VEL 7.62939453124e-6 steps/cycle", 0),
    ],
)
def test_a_rate_may_be_followed_by_its_unit(line, number):
    found = packets.parse(SHEET, line)
    assert found.values == (number,)
    name, rate = line.split(maxsplit=1)
    assert packets.numbers(SHEET, SHEET.commands[name.upper()], [rate]) == (number,)


def test_a_rate_in_seconds_goes_by_the_crystal_and_one_in_cycles_does_not():
    for text, numbers in (("12345 steps/s", (265107, 530214)), ("4 steps/cycle", (262144, 262144))):
        found = [packets.command(SHEET, f"SET_VEL {text}", crystal).values[0] for crystal in (None, 12_500_000)]
        assert tuple(found) == numbers


@rows(
    ("line", "code", "found", "remedy"),
    [
        ("SET_VEL 5 steps/s2", "range", "SET_VEL velocity 5 steps/s2: allowed steps/s or steps/cycle", ""),
        ("SET_ACC 5 steps/s", "range", "SET_ACC acceleration 5 steps/s: allowed steps/s2 or steps/cycle2", ""),
        (
            "SET_VEL 1e9 steps/s",
            *("range", "SET_VEL velocity 1e9 steps/s: 327680 steps/cycle; allowed 0..16383.99998", ""),
        ),
        (
            *("SET_VEL 5 step/s", "bad-number", "SET_VEL velocity 5 step/s"),
            "write a decimal number with steps/s or steps/cycle after it",
        ),
        (
            "SET_POS 5 steps/s",
            "extra-argument",
            "steps/s after SET_POS, which takes position",
            "leave out steps/s; write one command per line",
        ),
    ],
)
def test_a_rate_with_the_wrong_unit_is_refused(line, code, found, remedy):
    refusal = packets.parse(SHEET, line)
    assert (refusal.code, refusal.found, refusal.remedy) == (code, found, remedy)


@rows(
    ("command", "value", "says"),
    [
        (
            "SET_VEL",
            1.5,
            "velocity 1.5: allowed a whole number, 0..1073741823 (command reference); 1.5 steps/cycle is 98304",
        ),
        ("SET_ACC", 0.3, "0.3 steps/cycle^2 is 19660.8, not a whole number; the nearest is 19661"),
        ("SET_VEL", float("nan"), "velocity nan: allowed a whole number, 0..1073741823 (command reference)"),
        ("SET_POS", 1.5, "position 1.5: allowed a whole number, -1073741824..1073741823 (command reference)"),
    ],
)
def test_a_fraction_is_refused_with_the_number_that_would_be_right(command, value, says):
    with pytest.raises(UsageError) as error:
        packets.words(SHEET.commands[command], (value,))
    assert str(error.value).endswith(says)


@rows(
    ("command", "text", "most"),
    [
        ("SET_VEL", "16384 steps/cycle", "16383.99998 steps/cycle"),
        ("SET_ACC", "16384 steps/cycle2", "16383.99998 steps/cycle2"),
        ("SET_MAX_ACC", "0.5 steps/cycle2", "0.4999847412 steps/cycle2"),
        ("SET_JERK", "0.5 steps/cycle3", "0.4999999998 steps/cycle3"),
    ],
)
def test_the_highest_rate_that_a_refusal_allows_is_taken(command, text, most):
    argument = arg(command)
    with pytest.raises(UsageError) as error:
        rates.spoken(argument, text, PER_S)
    assert str(error.value).endswith(f"..{most.split()[0]}")
    assert rates.spoken(argument, most, PER_S) == argument.high


def test_a_rate_that_no_register_holds():
    with pytest.raises(UsageError, match=r"velocity 60000000: 19660.8 steps/cycle; allowed 0\.\.16383\.99998$"):
        rates.register(arg("SET_VEL"), 60_000_000, PER_S)
    assert rates.register(arg("SET_ACC"), -67890, PER_S) == -478
    for rate in ("fast", float("nan"), float("inf"), True, None):
        with pytest.raises(UsageError, match="not a rate"):
            rates.register(arg("SET_VEL"), rate, PER_S)


@pytest.mark.fact("PMD-STALL-1", "PMD-STALL-2", "PMD-CON-ANGLE")
def test_the_step_ratio_is_a_whole_number_or_none():
    ratio = arg("SET_STEP_RATIO")
    assert [rates.step_ratio(ratio, *turn) for turn in ((4000, 12_800), (2000, 400), (400, 400))] == [80, 1280, 256]
    with pytest.raises(UsageError, match=r"12800 steps: 256 \* counts / steps is 81\.92; allowed whole"):
        rates.step_ratio(ratio, 4096, 12_800)
    with pytest.raises(UsageError, match=r"allowed 0\.\.127\.99609"):
        rates.step_ratio(ratio, 128, 1)
    with pytest.raises(UsageError, match="0 steps"):
        rates.step_ratio(ratio, 1, 0)


# ------------------------------------------------------------------------------------------------------- bytes and back
TEXT = """\
; two axes
SET_2
set_vel 0x10000
SET_ACC -1024        ; back
SET_MAX_ACC 11469
wait 20 ms
UPDATE
wait motion_complete
@until atrest2=1
GET_STATUS
"""
BYTES = "02 11 00 01 00 00 12 FF FF FC 00 15 2C CD 1A 31"


def test_a_script_as_bytes_of_packets():
    assembly = assemble(TEXT, SHEET)
    assert assembly.stored.hex(" ").upper() == BYTES
    assert assembly.listing().splitlines()[1] == "001  11 00 01 00 00  set_vel 0x10000"
    assert (assembly.findings, assembly.preset, assembly.labels) == ((), (), {})


def test_bytes_of_packets_as_a_script_again():
    text = disassemble(bytes.fromhex(BYTES), SHEET)
    assert text.splitlines()[1:3] == ["SET_VEL 65536   ; 01  11 00 01 00 00", "SET_ACC -1024   ; 06  12 FF FF FC 00"]
    assert text.splitlines()[3] == "SET_MAX_ACC 11469 ; 11  15 2C CD"
    assert assemble(text, SHEET).stored.hex(" ").upper() == BYTES
    odd = bytes.fromhex("80 1A 06 11 00")
    assert [line.split("  ")[-1].strip() for line in listing(odd, SHEET).splitlines()] == [
        "??? 80",
        "UPDATE",
        "??? 06 11 00",
    ]
    assert listing(odd[:-1], SHEET).splitlines()[2].split("  ")[-1].strip() == "??? 06 11"


@rows("sheet", SHEETS)
def test_every_command_goes_to_bytes_and_back(sheet):
    draw = random.Random(sheet.part)
    values = {row: [draw.randint(arg.low, arg.high) for arg in row.args] for row in sheet.commands}
    text = "\n".join(packets.spell(row, found) for row, found in values.items())
    stored = assemble(text, sheet).stored
    assert len(stored) == sum(1 + row.data_bytes for row in sheet.commands)
    assert assemble(disassemble(stored, sheet), sheet).stored == stored


def test_a_script_with_mistakes_is_refused_whole():
    with pytest.raises(ProgramError) as error:
        assemble("SET_POS 5\n  set_accel 7\nSET_VEL 1 ; fine\nUPDATE now", SHEET, "a.txt")
    assert str(error.value).split("\n\n") == [
        "a.txt, line 2, column 3: set_accel is not a command of the MC1451A-E (MC1451A-E manual, command reference)\n"
        "      set_accel 7\n      ^^^^^^^^^\n    write SET_ACC",
        "a.txt, line 4, column 8: now after UPDATE, which takes no argument (MC1451A-E manual, command reference)\n"
        "    UPDATE now\n           ^^^\n    leave out now; write one command per line",
    ]


def test_there_is_no_program_entry():
    assembly = assemble(TEXT, SHEET)
    for write in (to_ascii, to_binary):
        with pytest.raises(UsageError, match="the MC1451A-E has no program entry; use format hex or bin"):
            write(assembly)


def test_a_code_is_not_a_mnemonic():
    with pytest.raises(UsageError, match="command 26: expected a mnemonic such as 'GET_STATUS'"):
        packets.row(sheet_of("mc1451a"), 26)
